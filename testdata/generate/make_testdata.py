"""The small meshes of testdata itself, by gmsh, VTK and azimesh; testdata/README.md says what each is.

Every file is what a real writer writes. Nothing here is random.
"""

import gmsh
import numpy as np
import vtk

import hart_ii
from gmsh_models import airfoil_hybrid, curved_plate, curved_solids, mixed_cells, shared_faces, sphere_in_box
from gmsh_moving import body_in_duct, rotor_sector, wing_on_plane
from place import FOLDER, azimesh, start_gmsh
from ugrid_file import Ugrid
from ugrid_file import write as write_ugrid
from vtk_fixtures import grid_of, named, strings, write_xml


def write_msh(name, version=4.1, binary=False):
    """Writes the current model as MSH."""
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", int(binary))
    gmsh.write(str(FOLDER / f"{name}.msh"))


def gmsh_files():
    """All MSH files."""
    start_gmsh()
    airfoil_hybrid()
    for version in (2.2, 4.1):
        for binary in (False, True):
            suffix = f"v{version:.1f}".replace(".", "") + ("_binary" if binary else "")
            write_msh(f"airfoil_hybrid_{suffix}", version, binary)
    yield "airfoil_hybrid", current_grid()
    sphere_in_box()
    write_msh("sphere_in_box_v22_binary", 2.2, True)
    write_msh("sphere_in_box_v41_binary", 4.1, True)
    yield "sphere_in_box", current_grid()
    mixed_cells()
    write_msh("mixed_cells_v22", 2.2)
    write_msh("mixed_cells_v41_binary", 4.1, True)
    yield "mixed_cells", current_grid()
    mixed_cells(2)
    yield "mixed_cells_coarse", current_grid()
    for incomplete, kind in ((False, "complete"), (True, "serendipity")):
        curved_plate(incomplete)
        write_msh(f"curved_plate_{kind}_v41", 4.1)
        curved_solids(incomplete)
        write_msh(f"curved_solids_{kind}_v22", 2.2)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 0)
    shared_faces()
    write_msh("shared_faces_v22", 2.2)
    write_msh("shared_faces_v41", 4.1)
    for make in (wing_on_plane, rotor_sector, body_in_duct):
        make()
        yield make.__name__, current_grid()
    gmsh.finalize()


VTK_TYPES = {1: 3, 2: 5, 3: 9, 4: 10, 5: 12, 6: 13, 7: 14}


def current_grid():
    """The current gmsh model of linear cells as (points, [(VTK type, nodes, tag, zone)], names)."""
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    used = np.unique(np.concatenate(gmsh.model.mesh.getElements(gmsh.model.getDimension())[2]))
    order = np.argsort(tags)
    order = order[np.isin(tags[order], used)]  # a circle's centre is in no cell
    points = xyz.reshape(-1, 3)[order]
    index = {tag: i for i, tag in enumerate(tags[order])}
    dimension = gmsh.model.getDimension()
    names = {dimension - 1: [], dimension: []}
    cells = []
    for dim, number in gmsh.model.getPhysicalGroups():
        names[dim].append(gmsh.model.getPhysicalName(dim, number))
        label = len(names[dim])
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dim, number):
            for kind, _, nodes in zip(*gmsh.model.mesh.getElements(dim, entity)):
                n_nodes = gmsh.model.mesh.getElementProperties(kind)[3]
                for row in nodes.reshape(-1, n_nodes):
                    tag, zone = (label, 0) if dim < dimension else (0, label)
                    cells.append((VTK_TYPES[kind], [index[n] for n in row], tag, zone))
    return points, cells, names[dimension - 1], names[dimension]


def unstructured(points, cells, tag_names, zone_names, arrays=True):
    """A VTK grid with tags, zones and their names as azimesh keeps them; with `arrays` a point array too."""
    grid = grid_of(points, [(kind, nodes) for kind, nodes, *_ in cells])
    grid.GetCellData().AddArray(named(np.array([tag for *_, tag, _ in cells], np.int32), "BoundaryTag"))
    grid.GetCellData().AddArray(named(np.array([zone for *_, zone in cells], np.int32), "Zone"))
    if arrays:
        grid.GetPointData().AddArray(named(np.linalg.norm(points, axis=1), "radius"))
    grid.GetFieldData().AddArray(strings(tag_names, "BoundaryTagNames"))
    grid.GetFieldData().AddArray(strings(zone_names, "ZoneNames"))
    return grid


def polyhedral(points, *rest):
    """The same grid with every solid cell as a polyhedron, faces as polygons."""
    grid = unstructured(points, *rest)
    listed = lambda cell: [cell.GetPointId(i) for i in range(cell.GetNumberOfPoints())]  # noqa: E731
    cells = []
    for i in range(grid.GetNumberOfCells()):
        cell = grid.GetCell(i)
        if cell.GetCellDimension() < 3:
            cells.append((vtk.VTK_POLYGON, listed(cell)))
        else:
            cells.append((vtk.VTK_POLYHEDRON, [listed(cell.GetFace(f)) for f in range(cell.GetNumberOfFaces())]))
    solid = grid_of(points, cells)
    solid.GetCellData().ShallowCopy(grid.GetCellData())
    solid.GetFieldData().ShallowCopy(grid.GetFieldData())
    return solid


def write_vtu(name, grid, **options):
    """Writes a grid as VTU in one of the modes of VTK."""
    write_xml(grid, FOLDER / f"{name}.vtu", block=4096, **options)


VTU = [
    ("airfoil_hybrid_ascii", "airfoil_hybrid", dict(mode="ascii")),
    ("airfoil_hybrid_inline_zlib", "airfoil_hybrid", dict(mode="inline", compressor="zlib")),
    ("airfoil_hybrid_raw_lz4", "airfoil_hybrid", dict(compressor="lz4", header=64)),
    ("airfoil_hybrid_inline_big_endian", "airfoil_hybrid", dict(mode="inline", order=0)), ("sphere_in_box_raw", "sphere_in_box", dict(header=64)),
    ("sphere_in_box_base64_lzma", "sphere_in_box", dict(mode="appended base64", compressor="lzma")),
    ("sphere_in_box_raw_zlib", "sphere_in_box", dict(compressor="zlib", header=64)), ("mixed_cells_inline", "mixed_cells", dict(mode="inline")),
    ("mixed_cells_raw_big_endian", "mixed_cells", dict(order=0)), ("mixed_cells_base64", "mixed_cells", dict(mode="appended base64", header=64)),
    ("mixed_cells_two_pieces", "mixed_cells", dict(pieces=2)),
]  # fmt: skip


def vtk_files(grids):
    """All VTU files made by VTK."""
    # VTK's writer keeps ranges of arrays in a grid and writes them the next time.
    made = {source: unstructured(*grids[source]) for source in ("airfoil_hybrid", "sphere_in_box", "mixed_cells")}
    for name, source, options in VTU:
        write_vtu(name, made[source], **options)
    poly = polyhedral(*grids["mixed_cells_coarse"])
    write_vtu("polyhedra_raw_zlib", poly, compressor="zlib")
    write_vtu("polyhedra_ascii", poly, mode="ascii")
    for make in (wing_on_plane, rotor_sector, body_in_duct):
        write_vtu(make.__name__, unstructured(*grids[make.__name__], arrays=False), compressor="zlib")


def own_files():
    """The mesh of the README with its schedule, the SU2 files, and the blade."""
    for name, *options in (("naca0012", "--nodes", 1200), ("block",)):
        azimesh("sample", name, *options, "-o", FOLDER / f"{name}.vtu", "--force")
    for name in ("airfoil_hybrid", "mixed_cells"):
        azimesh("convert", FOLDER / f"{name}_v41_binary.msh", FOLDER / f"{name}.su2", "--force")
    hart_ii.write(FOLDER)


def ugrid_files(points, cells, tags, _zones):
    """One mesh in several flavours, which share the names beside it; faces without a tag are left out."""
    mesh, numbers = Ugrid(points), []
    for vtk_type in (5, 9, 10, 14, 13, 12):
        chosen = [(nodes, tag) for kind, nodes, tag, _ in cells if kind == vtk_type and (tag or vtk_type not in (5, 9))]
        if chosen:
            mesh.cells.append((vtk_type, np.array([nodes for nodes, _ in chosen])))
        numbers += [tag for _, tag in chosen if vtk_type in (5, 9)]
    mesh.numbers = np.array(numbers)
    mesh.names = dict(enumerate(zip([4000, 5000, 6662, 6100, 3000, 7011, 5050], tags), 1))
    for flavour in ("", ".b8", ".lb4", ".lr8", ".lb8l"):
        write_ugrid(FOLDER / f"mixed_cells{flavour}.ugrid", mesh)
        mesh.names = {}


def main():
    """Makes everything."""
    FOLDER.mkdir(exist_ok=True)
    grids = dict(gmsh_files())
    vtk_files(grids)
    ugrid_files(*grids["mixed_cells_coarse"])
    own_files()
    for path in FOLDER.iterdir():
        assert path.is_dir() or path.stat().st_size <= 100_000 or path.suffix == ".csv", f"{path} has more than 100 kB"

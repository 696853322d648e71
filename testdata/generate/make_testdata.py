"""Makes testdata/: small meshes by gmsh, VTK and azimesh itself, and testdata/README.md.

Run from the repository root after `cargo build --release`:

    .venv/bin/python testdata/generate/make_testdata.py

Every file is what a real writer writes. Nothing here is random, so the same versions make the same
files but for time stamps.
"""

import os
import subprocess
from pathlib import Path

import gmsh
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

import hart_ii
from gmsh_models import airfoil_hybrid, curved_plate, curved_solids, mixed_cells, shared_faces, sphere_in_box
from gmsh_moving import body_in_duct, rotor_sector, wing_on_plane

FOLDER = Path("testdata")
AZIMESH = os.environ.get("AZIMESH", "target/release/azimesh")

made = []  # (file name, what it is, generator)


def note(path, what, generator):
    """Remembers a file for the README of the folder."""
    made.append((path.name, what, generator))


# ---------------------------------------------------------------- MSH, by gmsh


def write_msh(name, what, version=4.1, binary=False):
    """Writes the current model as MSH."""
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", int(binary))
    path = FOLDER / f"{name}.msh"
    gmsh.write(str(path))
    encoding = "binary" if binary else "ASCII"
    note(path, f"{what}; MSH {version} {encoding}", f"gmsh {gmsh.__version__}")


def gmsh_files():
    """All MSH files."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    airfoil_hybrid()
    for version in (2.2, 4.1):
        for binary in (False, True):
            suffix = f"v{version:.1f}".replace(".", "") + ("_binary" if binary else "")
            write_msh(f"airfoil_hybrid_{suffix}", airfoil_hybrid.__doc__, version, binary)
    yield "airfoil_hybrid", current_grid()
    sphere_in_box()
    write_msh("sphere_in_box_v22_binary", sphere_in_box.__doc__, 2.2, True)
    write_msh("sphere_in_box_v41_binary", sphere_in_box.__doc__, 4.1, True)
    yield "sphere_in_box", current_grid()
    mixed_cells()
    write_msh("mixed_cells_v22", mixed_cells.__doc__, 2.2)
    write_msh("mixed_cells_v41_binary", mixed_cells.__doc__, 4.1, True)
    yield "mixed_cells", current_grid()
    mixed_cells(2)
    yield "mixed_cells_coarse", current_grid()
    for incomplete, kind in ((False, "complete"), (True, "serendipity")):
        curved_plate(incomplete)
        write_msh(f"curved_plate_{kind}_v41", f"{curved_plate.__doc__} {kind}", 4.1)
        curved_solids(incomplete)
        write_msh(f"curved_solids_{kind}_v22", f"{curved_solids.__doc__} {kind}", 2.2)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 0)
    shared_faces()
    write_msh("shared_faces_v22", shared_faces.__doc__, 2.2)
    write_msh("shared_faces_v41", shared_faces.__doc__, 4.1)
    for make in (wing_on_plane, rotor_sector, body_in_duct):
        make()
        yield make.__name__, current_grid()
    gmsh.finalize()


# ---------------------------------------------------------------- VTU, by VTK

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


def add_array(data, name, values):
    """Adds a numeric array to point, cell or field data."""
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    data.AddArray(array)


def add_names(grid, name, names):
    """Adds names as a string array to the field data."""
    array = vtk.vtkStringArray()
    array.SetName(name)
    for text in names:
        array.InsertNextValue(text)
    grid.GetFieldData().AddArray(array)


def unstructured(points, cells, tag_names, zone_names, arrays=True):
    """A VTK grid with tags, zones and their names as azimesh keeps them; with `arrays` a point array too."""
    grid = vtk.vtkUnstructuredGrid()
    nodes = vtk.vtkPoints()
    nodes.SetData(numpy_to_vtk(points, deep=True))
    grid.SetPoints(nodes)
    array = vtk.vtkCellArray()
    for _, row, _, _ in cells:
        array.InsertNextCell(len(row), row)
    kinds = numpy_to_vtk(np.array([kind for kind, *_ in cells], np.uint8), deep=True)
    grid.SetCells(kinds, array)
    add_array(grid.GetCellData(), "BoundaryTag", np.array([tag for *_, tag, _ in cells], np.int32))
    add_array(grid.GetCellData(), "Zone", np.array([zone for *_, zone in cells], np.int32))
    if arrays:
        add_array(grid.GetPointData(), "radius", np.linalg.norm(points, axis=1))
    add_names(grid, "BoundaryTagNames", tag_names)
    add_names(grid, "ZoneNames", zone_names)
    return grid


def polyhedral(points, cells, tag_names, zone_names):
    """The same grid with every solid cell as a polyhedron, faces as polygons."""
    grid = unstructured(points, cells, tag_names, zone_names)
    solid = vtk.vtkUnstructuredGrid()
    solid.SetPoints(grid.GetPoints())
    for i in range(grid.GetNumberOfCells()):
        cell = grid.GetCell(i)
        if cell.GetCellDimension() < 3:
            solid.InsertNextCell(vtk.VTK_POLYGON, cell.GetPointIds())
            continue
        stream = vtk.vtkIdList()
        stream.InsertNextId(cell.GetNumberOfFaces())
        for f in range(cell.GetNumberOfFaces()):
            face = cell.GetFace(f).GetPointIds()
            stream.InsertNextId(face.GetNumberOfIds())
            for k in range(face.GetNumberOfIds()):
                stream.InsertNextId(face.GetId(k))
        solid.InsertNextCell(vtk.VTK_POLYHEDRON, stream)
    solid.GetCellData().ShallowCopy(grid.GetCellData())
    solid.GetFieldData().ShallowCopy(grid.GetFieldData())
    return solid


def write_vtu(name, grid, what, mode="raw", compressor="None", big_endian=False, header=32):
    """Writes a grid as VTU in one of VTK's modes: ascii, inline (base64), base64 or raw appended."""
    writer = vtk.vtkXMLUnstructuredGridWriter()
    path = FOLDER / f"{name}.vtu"
    writer.SetFileName(str(path))
    writer.SetInputData(grid)
    if mode == "ascii":
        writer.SetDataModeToAscii()
    elif mode == "inline":
        writer.SetDataModeToBinary()
    else:
        writer.SetDataModeToAppended()
        writer.SetEncodeAppendedData(mode == "base64")
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    writer.SetBlockSize(4096)
    if big_endian:
        writer.SetByteOrderToBigEndian()
    writer.SetHeaderTypeToUInt64() if header == 64 else writer.SetHeaderTypeToUInt32()
    assert writer.Write() == 1, path
    order = "big endian" if big_endian else "little endian"
    encoding = {"inline": "inline base64", "base64": "appended base64", "raw": "appended raw"}
    compression = "" if compressor == "None" else f", {compressor}"
    text = f"{encoding.get(mode, mode)}{compression}, {order}, UInt{header} headers"
    note(path, f"{what}; VTU, {text}", f"VTK {vtk.vtkVersion.GetVTKVersion()}")


def write_pieces(name, grid, what):
    """Writes a grid in two pieces in one VTU file, which VTK's writer does when it streams."""
    writer = vtk.vtkXMLUnstructuredGridWriter()
    path = FOLDER / f"{name}.vtu"
    pieces = vtk.vtkExtractUnstructuredGridPiece()
    pieces.SetInputData(grid)
    writer.SetFileName(str(path))
    writer.SetInputConnection(pieces.GetOutputPort())
    writer.SetNumberOfPieces(2)
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToNone()
    assert writer.Write() == 1, path
    note(path, f"{what}; VTU, appended raw, two pieces, Float32 nodes, some in no cell", f"VTK {vtk.vtkVersion.GetVTKVersion()}")


def vtk_files(grids):
    """All VTU files made by VTK."""
    what = {make.__name__: make.__doc__ for make in (airfoil_hybrid, sphere_in_box, mixed_cells)}
    airfoil = unstructured(*grids["airfoil_hybrid"])
    sphere = unstructured(*grids["sphere_in_box"])
    mixed = unstructured(*grids["mixed_cells"])
    hybrid = what["airfoil_hybrid"]
    write_vtu("airfoil_hybrid_ascii", airfoil, hybrid, "ascii")
    write_vtu("airfoil_hybrid_inline_zlib", airfoil, hybrid, "inline", "ZLib")
    write_vtu("airfoil_hybrid_raw_lz4", airfoil, hybrid, "raw", "LZ4", header=64)
    write_vtu("airfoil_hybrid_inline_big_endian", airfoil, hybrid, "inline", big_endian=True)
    solid = what["sphere_in_box"]
    write_vtu("sphere_in_box_raw", sphere, solid, "raw", header=64)
    write_vtu("sphere_in_box_base64_lzma", sphere, solid, "base64", "LZMA")
    write_vtu("sphere_in_box_raw_zlib", sphere, solid, "raw", "ZLib", header=64)
    write_vtu("mixed_cells_inline", mixed, what["mixed_cells"], "inline")
    write_vtu("mixed_cells_raw_big_endian", mixed, what["mixed_cells"], "raw", big_endian=True)
    write_vtu("mixed_cells_base64", mixed, what["mixed_cells"], "base64", header=64)
    write_pieces("mixed_cells_two_pieces", mixed, what["mixed_cells"])
    poly = polyhedral(*grids["mixed_cells_coarse"])
    write_vtu("polyhedra_raw_zlib", poly, "mixed_cells, coarser, as polyhedra", "raw", "ZLib")
    write_vtu("polyhedra_ascii", poly, "mixed_cells, coarser, as polyhedra", "ascii")
    for make in (wing_on_plane, rotor_sector, body_in_duct):
        grid = unstructured(*grids[make.__name__], arrays=False)
        write_vtu(make.__name__, grid, make.__doc__, "raw", "ZLib")


# ---------------------------------------------------------------- azimesh's own


def azimesh(*arguments):
    """Runs azimesh; its failure is ours."""
    subprocess.run([AZIMESH, *map(str, arguments)], check=True)


def own_files():
    """The mesh of the README with its schedule, and the SU2 files."""
    version = subprocess.run([AZIMESH, "--version"], check=True, capture_output=True, text=True)
    version = version.stdout.strip()
    for name, options, what in (
        ("naca0012", ["--nodes", 1200], "NACA 0012 O-grid, the README's first mesh"),
        ("block", [], "a square with a block of 5 by 1 cells taken out"),
    ):
        mesh = FOLDER / f"{name}.vtu"
        for old in (mesh, mesh.with_suffix(".toml")):
            old.unlink(missing_ok=True)
        azimesh("sample", name, *options, "-o", mesh)
        generator = " ".join(map(str, [f"{version}: sample", name, *options]))
        note(mesh, what, generator)
        note(mesh.with_suffix(".toml"), "its schedule", generator)
    for source, name in (
        ("airfoil_hybrid_v41_binary.msh", "airfoil_hybrid.su2"),
        ("mixed_cells_v41_binary.msh", "mixed_cells.su2"),
    ):
        target = FOLDER / name
        target.unlink(missing_ok=True)
        azimesh("convert", FOLDER / source, target)
        note(target, f"{source} as SU2", f"{version}: convert {source} {name}")
    hart_ii.write(FOLDER)
    generator = f"testdata/generate/hart_ii.py, {version}: sample blade"
    note(FOLDER / "hart_ii.vtu", "a blade of HART II's size, for the table beside it", generator)
    note(FOLDER / "hart_ii.toml", "its schedule", generator)
    note(FOLDER / "hart_ii_beam.csv", "elastic flap and twist of a blade like that of HART II, every 15 degrees", generator)


BY_HAND = {
    "wing_on_plane.toml": "the wing pitches; the symmetry plane slides",
    "rotor_sector.toml": "the blade pitches and flaps between periodic sides",
    "rotor_sector_sliding.toml": "the same with sliding planes below and above",
    "body_in_duct.toml": "the sphere moves along the duct; the curved wall slides",
    "block_sliding.toml": "the block turns by 60 degrees and moves; outer edges slide, twist, 10 substeps",
}


BY_OTHERS = {
    "lagrange_orders.txt": ("where VTK puts the nodes of its Lagrange cells, orders 1 to 6", "make_lagrange_orders.py, VTK 9.7.2"),
    "gmsh_orders.txt": ("where Gmsh puts the nodes of its elements, every order", "make_gmsh_orders.py, gmsh 4.15.2"),
}


def readme():
    """testdata/README.md: each file, what it is, and what made it."""
    lines = [
        "# Small meshes for tests and for trying things",
        "",
        "Meshes are made by `testdata/generate/make_testdata.py`; none holds anybody else's data.",
        "",
        "| file | bytes | what | made by |",
        "|---|---|---|---|",
    ]
    by_hand = [(name, f"schedule: {what}", "hand") for name, what in BY_HAND.items()]
    by_others = [(name, what, f"scripts/{script}") for name, (what, script) in BY_OTHERS.items()]
    for name, what, generator in sorted(made + by_hand + by_others):
        size = (FOLDER / name).stat().st_size
        assert size <= 100_000, f"{name} has {size} bytes; at most 100 kB"
        lines.append(f"| `{name}` | {size} | {what.replace('.;', ';')} | {generator} |")
    lines += ["", "`gmsh/` has one small model by gmsh 4.15.2 in every version of MSH, partitioned, with data, and cells of third"]
    lines += ["and fourth order (`testdata/generate/make_gmsh_versions.py`)."]
    lines += ["The folder `cgns/` holds small CGNS files in the layouts of real writers: two hexahedra as polyhedra with offsets, with"]
    lines += ["counts and by parents, with boundaries by nodes, behind links and families, structured with ghost layers, in steps, in two"]
    lines += ["bases. `testdata/generate/make_cgns.py` writes them with h5py 3.16.0."]
    lines += ["The folder `vtk/` holds legacy files of four versions, structured and rectilinear grids, polydata and a grid in two pieces,"]
    lines += ["written by VTK 9.7.2 (`testdata/generate/make_vtk_files.py`)."]
    lines += ["The folder `openfoam/` holds cases of two blocks, hexahedra and wedges, in two zones, with two times: as text, gzip, binary, with"]
    lines += ["labels of 64 bits, in two pieces, collated, and its dual of polyhedra, by OpenFOAM v1912 (`testdata/generate/make_openfoam.py`)."]
    (FOLDER / "README.md").write_text("\n".join(lines) + "\n")


def main():
    """Makes everything."""
    FOLDER.mkdir(exist_ok=True)
    grids = dict(gmsh_files())
    vtk_files(grids)
    own_files()
    readme()
    total = sum((FOLDER / name).stat().st_size for name, *_ in made)
    print(f"testdata: {len(made)} files, {total / 1e6:.2f} MB")


if __name__ == "__main__":
    main()

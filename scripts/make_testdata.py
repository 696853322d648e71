"""Makes testdata/: small meshes by gmsh, VTK and azimesh itself, and testdata/README.md.

Run from the repository root after `cargo build --release`:

    .venv/bin/python scripts/make_testdata.py

Every file is what a real writer writes. Nothing here is random, so the same versions make the same
files but for time stamps.
"""

import os
import subprocess
from pathlib import Path

import gmsh
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

FOLDER = Path("testdata")
AZIMESH = os.environ.get("AZIMESH", "target/release/azimesh")

made = []  # (file name, what it is, generator)


def note(path, what, generator):
    """Remembers a file for the README of the folder."""
    made.append((path.name, what, generator))


# ---------------------------------------------------------------- geometry, by gmsh


def model(name):
    """Starts an empty gmsh model."""
    gmsh.clear()
    gmsh.model.add(name)


def group(dimension, entities, name):
    """A physical group with a name."""
    number = gmsh.model.addPhysicalGroup(dimension, entities)
    gmsh.model.setPhysicalName(dimension, number, name)


def naca0012(x):
    """Half thickness of the NACA 0012 section with a closed trailing edge."""
    return 0.6 * (0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)


def airfoil_hybrid():
    """A NACA 0012 in a circle: quadrilaterals along the wall, triangles beyond; two zones."""
    model("airfoil_hybrid")
    geo = gmsh.model.geo
    n, layers = 40, 4
    angle = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    x = 0.5 * (1.0 + np.cos(angle))
    y = np.where(angle <= np.pi, 1.0, -1.0) * naca0012(x)
    wall = np.c_[x, y]
    normal = np.c_[np.cos(angle), 1.2 * np.sin(angle)]
    sheath = wall + 0.15 * normal
    inner = [geo.addPoint(a, b, 0.0) for a, b in wall]
    outer = [geo.addPoint(a, b, 0.0) for a, b in sheath]

    def around(points):
        return [geo.addLine(points[i], points[(i + 1) % n]) for i in range(n)]

    airfoil, interface = around(inner), around(outer)
    spokes = [geo.addLine(a, b) for a, b in zip(inner, outer)]
    for line in airfoil + interface:
        geo.mesh.setTransfiniteCurve(line, 2)
    for line in spokes:
        geo.mesh.setTransfiniteCurve(line, layers + 1, "Progression", 1.4)
    layer = []
    for i in range(n):
        loop = geo.addCurveLoop([spokes[i], interface[i], -spokes[(i + 1) % n], -airfoil[i]])
        layer.append(geo.addPlaneSurface([loop]))
        geo.mesh.setTransfiniteSurface(layer[-1])
        geo.mesh.setRecombine(2, layer[-1])
    centre = geo.addPoint(0.5, 0.0, 0.0)
    rim = [geo.addPoint(0.5 + 2.5 * c, 2.5 * s, 0.0, 0.5) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    circle = [geo.addCircleArc(rim[i], centre, rim[(i + 1) % 4]) for i in range(4)]
    field = geo.addPlaneSurface([geo.addCurveLoop(circle), geo.addCurveLoop(interface)])
    geo.synchronize()
    group(1, airfoil, "airfoil")
    group(1, circle, "farfield")
    group(2, layer, "boundary layer")
    group(2, [field], "field")
    gmsh.model.mesh.generate(2)


def sphere_in_box(size=1.0):
    """Tetrahedra between a sphere and a box; the box has four tags."""
    model("sphere_in_box")
    occ = gmsh.model.occ
    box = occ.addBox(-1.5, -1.5, -1.5, 3.0, 3.0, 3.0)
    sphere = occ.addSphere(0.0, 0.0, 0.0, 0.5)
    (_, volume), = occ.cut([(3, box)], [(3, sphere)])[0]
    occ.synchronize()
    named = {"sphere": [], "inlet": [], "outlet": [], "walls": []}
    for _, face in gmsh.model.getEntities(2):
        x, y, z = occ.getCenterOfMass(2, face)
        side = "inlet" if x < -1.4 else "outlet" if x > 1.4 else "walls"
        named["sphere" if max(abs(x), abs(y), abs(z)) < 1.0 else side].append(face)
    for name, faces in named.items():
        group(2, faces, name)
    group(3, [volume], "fluid")
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    poles = gmsh.model.getBoundary([(2, face) for face in named["sphere"]], recursive=True)
    gmsh.model.mesh.setSize(poles, 0.4 * size)
    gmsh.model.mesh.generate(3)


def mixed_cells(cells=3, pyramids=True):
    """All four linear solids: a block of hexahedra, wedges beside it, pyramids and tetrahedra above."""
    model("mixed_cells")
    geo = gmsh.model.geo
    corner = [geo.addPoint(x, y, 0.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1), (1.7, 0), (1.7, 1))]
    pairs = {"s": (0, 1), "e": (1, 2), "n": (2, 3), "w": (3, 0), "bs": (1, 4), "be": (4, 5), "bn": (5, 2)}
    line = {name: geo.addLine(corner[a], corner[b]) for name, (a, b) in pairs.items()}
    for tag in line.values():
        geo.mesh.setTransfiniteCurve(tag, cells + 1)
    floor = geo.addPlaneSurface([geo.addCurveLoop([line[k] for k in ("s", "e", "n", "w")])])
    loop = geo.addCurveLoop([line["bs"], line["be"], line["bn"], -line["e"]])
    beside = geo.addPlaneSurface([loop])
    geo.mesh.setTransfiniteSurface(floor)
    geo.mesh.setRecombine(2, floor)
    block = geo.extrude([(2, floor)], 0.0, 0.0, 0.6, [cells], recombine=True)
    wing = geo.extrude([(2, beside)], 0.0, 0.0, 0.6, [cells], recombine=True)
    solids = {"hexahedra": block[1][1], "wedges": wing[1][1]}
    if pyramids:
        solids["above"] = geo.extrude([block[0]], 0.0, 0.0, 0.8)[1][1]
    geo.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 1.0 / cells)
    named = {"floor": [], "roof": [], "sides": []}
    outside = gmsh.model.getBoundary(gmsh.model.getEntities(3), oriented=False)
    for face in sorted(face for _, face in outside):
        low, high = (gmsh.model.getBoundingBox(2, face)[i] for i in (2, 5))
        named["floor" if high < 0.1 else "roof" if low > 0.5 else "sides"].append(face)
    for name, faces in named.items():
        group(2, faces, name)
    for name, solid in solids.items():
        group(3, [solid], name)
    gmsh.model.mesh.generate(3)


def curved_plate(incomplete):
    """Second-order triangles and quadrilaterals around a hole in a plate."""
    model("curved_plate")
    occ = gmsh.model.occ
    plate = occ.addRectangle(-1.0, -1.0, 0.0, 2.0, 2.0)
    hole = occ.addDisk(0.0, 0.0, 0.0, 0.4, 0.4)
    occ.cut([(2, plate)], [(2, hole)])
    beside = occ.addRectangle(1.0, -1.0, 0.0, 1.0, 2.0)
    occ.fragment([(2, 1)], [(2, beside)])
    occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", int(incomplete))
    gmsh.model.mesh.setTransfiniteSurface(beside)
    gmsh.model.mesh.setRecombine(2, beside)
    lines = {"hole": [], "rim": []}
    for _, line in gmsh.model.getBoundary(gmsh.model.getEntities(2), oriented=False):
        x, y, _ = occ.getCenterOfMass(1, line)
        lines["hole" if np.hypot(x, y) < 0.5 else "rim"].append(line)
    for name, entities in lines.items():
        group(1, entities, name)
    group(2, [surface for _, surface in gmsh.model.getEntities(2)], "plate")
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(2)


def curved_solids(incomplete):
    """Second-order solids: `mixed_cells` of one layer; no pyramids where they would have 14 nodes."""
    mixed_cells(1, pyramids=incomplete)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", int(incomplete))
    gmsh.model.mesh.setOrder(2)


def shared_faces():
    """A box whose one side belongs to two boundary tags."""
    model("shared_faces")
    occ = gmsh.model.occ
    box = occ.addBox(0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
    faces = [face for _, face in gmsh.model.getEntities(2)]
    group(2, faces, "all sides")
    group(2, faces[:1], "monitored")
    group(3, [box], "fluid")
    gmsh.model.mesh.generate(3)


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


def unstructured(points, cells, tag_names, zone_names):
    """A VTK grid with tags, zones and their names as azimesh keeps them."""
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


# ---------------------------------------------------------------- azimesh's own


def azimesh(*arguments):
    """Runs azimesh; its failure is ours."""
    subprocess.run([AZIMESH, *map(str, arguments)], check=True)


def own_files():
    """The mesh of the README with its schedule, and the SU2 files."""
    version = subprocess.run([AZIMESH, "--version"], check=True, capture_output=True, text=True)
    version = version.stdout.strip()
    naca = FOLDER / "naca0012.vtu"
    for old in (naca, naca.with_suffix(".toml")):
        old.unlink(missing_ok=True)
    azimesh("sample", "naca0012", "--nodes", 1200, "-o", naca)
    note(naca, "NACA 0012 O-grid, the README's first mesh", f"{version}: sample naca0012 --nodes 1200")
    note(naca.with_suffix(".toml"), "its schedule", f"{version}: sample naca0012 --nodes 1200")
    for source, name in (
        ("airfoil_hybrid_v41_binary.msh", "airfoil_hybrid.su2"),
        ("mixed_cells_v41_binary.msh", "mixed_cells.su2"),
    ):
        target = FOLDER / name
        target.unlink(missing_ok=True)
        azimesh("convert", FOLDER / source, target)
        note(target, f"{source} as SU2", f"{version}: convert {source} {name}")


def readme():
    """testdata/README.md: each file, what it is, and what made it."""
    lines = [
        "# Small meshes for tests and for trying things",
        "",
        "All are made by `scripts/make_testdata.py`; none holds anybody else's data.",
        "",
        "| file | bytes | what | made by |",
        "|---|---|---|---|",
    ]
    for name, what, generator in sorted(made):
        size = (FOLDER / name).stat().st_size
        assert size <= 100_000, f"{name} has {size} bytes; at most 100 kB"
        lines.append(f"| `{name}` | {size} | {what.replace('.;', ';')} | {generator} |")
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

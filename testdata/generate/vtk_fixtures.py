"""Files in every mode that VTK can write, for scripts/verify/fixtures.py and make_vtk_files.py.

Four grids (tetrahedra with arrays of every type; linear cells of all kinds; quadratic ones; polyhedra) as legacy files of six versions, text and
binary, with and without field data before the points, and as .vtu in every mode: text, base64 inside or appended, appended raw; four compressors;
headers of 32 and 64 bits; both byte orders; node indices of 32 and 64 bits.
"""

import itertools
import re

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

OLD_VERSIONS = ["2.0", "3.0", "4.0", "4.1", "4.2"]
COMPRESSORS = {"none": "None", "zlib": "ZLib", "lz4": "LZ4", "lzma": "LZMA"}


def named(values, name, components=()):
    """A VTK array."""
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=1)
    array.SetName(name)
    for i, component in enumerate(components):
        array.SetComponentName(i, component)
    return array


def strings(values, name):
    """A VTK array of strings."""
    array = vtk.vtkStringArray()
    array.SetName(name)
    for value in values:
        array.InsertNextValue(value)
    return array


def grid_of(points, cells):
    """A grid of (VTK type, nodes) cells; a polyhedron has its faces in the place of nodes."""
    grid = vtk.vtkUnstructuredGrid()
    vtk_points = vtk.vtkPoints()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=1))
    grid.SetPoints(vtk_points)
    for kind, nodes in cells:
        ids = vtk.vtkIdList()
        if kind == vtk.VTK_POLYHEDRON:
            ids.InsertNextId(len(nodes))
            nodes = [entry for face in nodes for entry in (len(face), *face)]
        for node in nodes:
            ids.InsertNextId(int(node))
        grid.InsertNextCell(kind, ids)
    return grid


def block(n, dtype=np.float64):
    """Nodes of n x n x n cubes of which none is quite like another, and the corners of each."""
    axis = np.arange(n + 1)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3) / 3.0 + 0.01 * np.sin(x + 2 * y + 3 * z).reshape(-1, 1)
    corners = []
    for k, j, i in itertools.product(range(n), repeat=3):
        first = i + (n + 1) * (j + (n + 1) * k)
        quad = [first, first + 1, first + n + 2, first + n + 1]
        corners.append(quad + [node + (n + 1) ** 2 for node in quad])
    return points.astype(dtype), corners


def tetrahedra():
    """Tetrahedra and tagged triangles, with arrays of every type."""
    points, cubes = block(6)
    split = [(0, 1, 3, 4), (1, 2, 3, 6), (1, 3, 4, 6), (3, 4, 6, 7), (1, 4, 5, 6)]
    cells = [(vtk.VTK_TETRA, [cube[i] for i in corners]) for cube in cubes for corners in split]
    cells += [(vtk.VTK_TRIANGLE, [cube[0], cube[1], cube[3]]) for cube in cubes[:36]]
    grid = grid_of(points, cells)
    n_points, n_cells = len(points), len(cells)
    point_data, cell_data = grid.GetPointData(), grid.GetCellData()
    point_data.SetScalars(named(np.sqrt(np.arange(n_points)), "pressure"))
    point_data.SetVectors(named(points.astype(np.float32) ** 2, "velocity", ("u u", "v", "w")))
    point_data.SetNormals(named(np.tile([0.0, 0.6, 0.8], (n_points, 1)), "normals"))
    point_data.SetTCoords(named(points[:, :2].astype(np.float32), "texture"))
    point_data.SetTensors(named(np.outer(np.arange(n_points), np.arange(9.0)), "stress"))
    point_data.SetGlobalIds(named(np.arange(n_points, dtype=np.int64) * 3, "global"))
    bits = vtk.vtkBitArray()
    bits.SetName("bits")
    for node in range(n_points):
        bits.InsertNextValue(node % 3 == 0)
    point_data.AddArray(bits)
    types = [np.int8, np.uint8, np.int16, np.uint16, np.int32, np.uint32, np.int64, np.uint64]
    for dtype in types:
        low, high = np.iinfo(dtype).min, np.iinfo(dtype).max
        values = np.array([low, high, 0, 1, high // 3] * n_cells, dtype=dtype)[:n_cells]
        cell_data.AddArray(named(values, f"a {np.dtype(dtype).name} %"))
    # Not -inf, which VTK reads from XML text as inf.
    cell_data.AddArray(named(np.array([np.nan, np.inf, -0.0, 1e-310, 0.1] * n_cells)[:n_cells], "odd"))
    cell_data.AddArray(strings([f"cell {i}\n\"%" * (i % 4) for i in range(n_cells)], "words"))
    return grid


def mixed():
    """Every kind of linear cell, single precision."""
    points, cubes = block(4, np.float32)
    pixel = [0, 1, 3, 2]
    makers = [
        (vtk.VTK_HEXAHEDRON, range(8)), (vtk.VTK_VOXEL, pixel + [node + 4 for node in pixel]), (vtk.VTK_WEDGE, [0, 3, 1, 4, 7, 5]),
        (vtk.VTK_PYRAMID, [0, 1, 2, 3, 4]), (vtk.VTK_TETRA, [0, 1, 3, 4]), (vtk.VTK_QUAD, [0, 1, 2, 3]), (vtk.VTK_PIXEL, pixel),
        (vtk.VTK_TRIANGLE, [4, 5, 6]), (vtk.VTK_POLYGON, [0, 1, 2, 6, 7]), (vtk.VTK_LINE, [0, 6]), (vtk.VTK_VERTEX, [5]),
        (vtk.VTK_POLY_VERTEX, [1, 2, 3]), (vtk.VTK_POLY_LINE, [0, 1, 2, 3]), (vtk.VTK_TRIANGLE_STRIP, [0, 1, 3, 2, 7]), (vtk.VTK_EMPTY_CELL, []),
    ]  # fmt: skip
    cells = [
        (kind, [cube[i] for i in nodes])
        for cube, (kind, nodes) in zip(cubes, itertools.cycle(makers))
    ]
    grid = grid_of(points, cells)
    grid.GetCellData().SetScalars(named(np.arange(len(cells), dtype=np.int32), "material"))
    grid.GetCellData().AddArray(named(np.arange(2.0 * len(cells)).reshape(-1, 2), "pair"))
    return grid


def quadratic():
    """Every kind of quadratic cell, and cells of the third order, on nodes of their own."""
    kinds = [
        (vtk.VTK_QUADRATIC_EDGE, 3), (vtk.VTK_QUADRATIC_TRIANGLE, 6), (vtk.VTK_QUADRATIC_QUAD, 8), (vtk.VTK_QUADRATIC_POLYGON, 10),
        (vtk.VTK_QUADRATIC_TETRA, 10), (vtk.VTK_QUADRATIC_HEXAHEDRON, 20), (vtk.VTK_QUADRATIC_WEDGE, 15), (vtk.VTK_QUADRATIC_PYRAMID, 13),
        (vtk.VTK_BIQUADRATIC_QUAD, 9), (vtk.VTK_TRIQUADRATIC_HEXAHEDRON, 27), (vtk.VTK_TRIQUADRATIC_PYRAMID, 19),
        (vtk.VTK_QUADRATIC_LINEAR_QUAD, 6), (vtk.VTK_QUADRATIC_LINEAR_WEDGE, 12), (vtk.VTK_BIQUADRATIC_QUADRATIC_WEDGE, 18),
        (vtk.VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON, 24), (vtk.VTK_BIQUADRATIC_TRIANGLE, 7), (vtk.VTK_CUBIC_LINE, 4), (vtk.VTK_LAGRANGE_CURVE, 4),
        (vtk.VTK_LAGRANGE_TRIANGLE, 10), (vtk.VTK_LAGRANGE_QUADRILATERAL, 16), (vtk.VTK_LAGRANGE_TETRAHEDRON, 20),
        (vtk.VTK_LAGRANGE_HEXAHEDRON, 64), (vtk.VTK_LAGRANGE_WEDGE, 40), (vtk.VTK_BEZIER_CURVE, 4), (vtk.VTK_BEZIER_TRIANGLE, 10),
        (vtk.VTK_BEZIER_QUADRILATERAL, 16), (vtk.VTK_BEZIER_TETRAHEDRON, 20), (vtk.VTK_BEZIER_HEXAHEDRON, 64), (vtk.VTK_BEZIER_WEDGE, 40),
        (vtk.VTK_PENTAGONAL_PRISM, 10), (vtk.VTK_HEXAGONAL_PRISM, 12),
    ]  # fmt: skip
    cells, first = [], 0
    for kind, n in kinds * 2:
        cells.append((kind, range(first, first + n)))
        first += n
    grid = grid_of(np.cumsum(np.sin(np.arange(3 * first)).reshape(-1, 3), axis=0), cells)
    grid.GetPointData().AddArray(named(np.arange(first, dtype=np.float32), "height"))
    return grid


def polyhedra():
    """Cubes as polyhedra, tetrahedra and hexahedra between them."""
    points, cubes = block(3)
    faces = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    cells = []
    for i, cube in enumerate(cubes):
        if i % 3 == 0:
            cells.append((vtk.VTK_HEXAHEDRON, cube))
        elif i % 3 == 1:
            cells.append((vtk.VTK_POLYHEDRON, [[cube[node] for node in face] for face in faces]))
        else:
            sides = [(0, 1, 2), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
            corners = [cube[3], cube[1], cube[0], cube[4]]
            cells.append((vtk.VTK_POLYHEDRON, [[corners[node] for node in side] for side in sides]))
    grid = grid_of(points, cells)
    grid.GetCellData().AddArray(named(np.arange(float(len(cells))), "number"))
    return grid


GRIDS = {"tetrahedra": tetrahedra, "mixed": mixed, "quadratic": quadratic, "polyhedra": polyhedra}


def with_fields(grid):
    """The grid with field data: a time, names, and a table."""
    copy = vtk.vtkUnstructuredGrid()
    copy.ShallowCopy(grid)
    fields = vtk.vtkFieldData()
    fields.AddArray(named(np.array([0.125]), "TIME"))
    fields.AddArray(strings(["wall", "", "far field %"], "names"))
    fields.AddArray(named(np.arange(12, dtype=np.int32).reshape(4, 3), "a table"))
    copy.SetFieldData(fields)
    return copy


def write_legacy(grid, path, version, binary):
    """A legacy file; versions before 4.2 had the same layout under another number."""
    writer = vtk.vtkUnstructuredGridWriter()
    writer.SetFileVersion(51 if version == "5.1" else 42)
    (writer.SetFileTypeToBinary if binary else writer.SetFileTypeToASCII)()
    writer.SetInputData(grid)
    writer.SetFileName(str(path))
    assert writer.Write() == 1
    content = path.read_bytes()
    path.write_bytes(re.sub(rb"Version \d\.\d", b"Version " + version.encode(), content, count=1))


def write_xml(grid, path, mode="appended raw", compressor="none", header=32, order=1, ids=64, block=1024, pieces=1):
    """A .vtu file; in pieces as VTK's writer makes them when it streams."""
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    if pieces > 1:
        parts = vtk.vtkExtractUnstructuredGridPiece()
        parts.SetInputData(grid)
        writer.SetInputConnection(parts.GetOutputPort())
        writer.SetNumberOfPieces(pieces)
    if mode == "ascii":
        writer.SetDataModeToAscii()
    elif mode == "inline":
        writer.SetDataModeToBinary()
    else:
        writer.SetDataModeToAppended()
        writer.SetEncodeAppendedData(mode == "appended base64")
    getattr(writer, f"SetCompressorTypeTo{COMPRESSORS[compressor]}")()
    # Several blocks even in small arrays.
    writer.SetBlockSize(block)
    writer.SetHeaderType(header)
    writer.SetByteOrder(order)
    writer.SetIdType(ids)
    writer.SetFileName(str(path))
    assert writer.Write() == 1


def xml_modes():
    """Every combination that makes a different file."""
    for mode in ("ascii", "inline", "appended base64", "appended raw"):
        compressors = ["none"] if mode == "ascii" else COMPRESSORS
        for compressor, header, order, ids in itertools.product(compressors, (32, 64), (0, 1), (32, 64)):
            yield mode, compressor, header, order, ids


def fixtures(folder, every=1):
    """Writes every n-th file of each grid, another first one for each; yields the paths."""
    for first, (name, make) in enumerate(GRIDS.items()):
        grid = make()
        grids = {"": grid, "_fields": with_fields(grid)}
        jobs = []
        versions = [*OLD_VERSIONS, "5.1"]
        for version, binary, fields in itertools.product(versions, (False, True), grids):
            path = folder / f"{name}_{version}_{'binary' if binary else 'ascii'}{fields}.vtk"
            jobs.append((path, write_legacy, grids[fields], (version, binary)))
        for number, mode in enumerate(xml_modes()):
            fields = ("", "_fields")[number // 8 % 2]
            path = folder / f"{name}_{'_'.join(map(str, mode)).replace(' ', '_')}{fields}.vtu"
            jobs.append((path, write_xml, grids[fields], mode))
        for path, write, grid, options in jobs[first % every :: every]:
            write(grid, path, *options)
            yield path

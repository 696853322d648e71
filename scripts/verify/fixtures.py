"""Files in the modes of VTK's writers, read as VTK reads them: a ninth of testdata/generate/vtk_fixtures.py, or each EVERY-th.

What azimesh reads is written as .vtu and read by VTK: points, cells, faces and arrays must be exactly those that VTK reads from the file itself.
"""

import os
import sys
from pathlib import Path

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from program import azimesh, report, scratch

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "testdata" / "generate"))
import vtk_fixtures  # noqa: E402

# Prime to the number of choices of every option, so that each of them occurs.
EVERY = int(os.environ.get("EVERY", 9))


def read(path):
    """What VTK reads."""
    reader = vtk.vtkUnstructuredGridReader() if path.suffix == ".vtk" else vtk.vtkXMLUnstructuredGridReader()
    if path.suffix == ".vtk":
        for what in ("Scalars", "Vectors", "Normals", "Tensors", "ColorScalars", "TCoords", "Fields"):
            getattr(reader, f"ReadAll{what}On")()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def split(kind, nodes):
    """A VTK cell as cells of azimesh: collections are split, pixels and voxels turned."""
    if kind == vtk.VTK_EMPTY_CELL:
        return []
    if kind == vtk.VTK_POLY_VERTEX:
        return [(vtk.VTK_VERTEX, (node,)) for node in nodes]
    if kind == vtk.VTK_POLY_LINE:
        return [(vtk.VTK_LINE, pair) for pair in zip(nodes, nodes[1:])]
    if kind == vtk.VTK_TRIANGLE_STRIP:
        triples = zip(nodes, nodes[1:], nodes[2:])
        return [(vtk.VTK_TRIANGLE, (b, a, c) if i % 2 else (a, b, c)) for i, (a, b, c) in enumerate(triples)]
    if kind in (vtk.VTK_PIXEL, vtk.VTK_VOXEL):
        turned = [node for four in zip(*[iter(nodes)] * 4) for node in (four[0], four[1], four[3], four[2])]
        return [(vtk.VTK_QUAD if kind == vtk.VTK_PIXEL else vtk.VTK_HEXAHEDRON, tuple(turned))]
    return [(kind, nodes)]


def cells_of(grid):
    """(type, nodes, faces) of each cell as azimesh has it, and the cell it comes from."""
    cells, origin = [], []
    for index in range(grid.GetNumberOfCells()):
        ids = vtk.vtkIdList()
        grid.GetCellPoints(index, ids)
        nodes = tuple(ids.GetId(i) for i in range(ids.GetNumberOfIds()))
        faces = None
        if grid.GetCellType(index) == vtk.VTK_POLYHEDRON:
            grid.GetFaceStream(index, ids)
            faces = tuple(ids.GetId(i) for i in range(ids.GetNumberOfIds()))
        for kind, nodes in split(grid.GetCellType(index), nodes):
            cells.append((kind, nodes, faces))
            origin.append(index)
    return cells, np.array(origin, dtype=int)


def arrays_of(data, pick=slice(None)):
    """Name to (names of components, type, bytes of the picked values)."""
    arrays = {}
    for i in range(data.GetNumberOfArrays()):
        array = data.GetAbstractArray(i)
        n, listed = array.GetNumberOfComponents(), isinstance(array, (vtk.vtkStringArray, vtk.vtkBitArray))
        values = [array.GetValue(k) for k in range(array.GetNumberOfValues())] if listed else vtk_to_numpy(array)
        values = np.array(values, np.uint8) if isinstance(array, vtk.vtkBitArray) else np.array(values)
        names = [array.GetComponentName(k) or "" for k in range(n)] if array.HasAComponentName() else []
        picked = values.reshape(-1, n)[pick]
        arrays[array.GetName()] = n, names, str(picked.dtype), picked.shape, picked.tobytes()
    return arrays


def compare(path, folder):
    """Fails unless azimesh reads from a file what VTK does."""
    wanted = read(path)
    assert wanted.GetNumberOfCells() > 0, f"{path.name}: VTK does not read it"
    azimesh("convert", "--force", path, folder / "converted.vtu")
    found = read(folder / "converted.vtu")
    points = [vtk_to_numpy(grid.GetPoints().GetData()).astype(float) for grid in (found, wanted)]
    assert points[0].tobytes() == points[1].tobytes(), f"{path.name}: points"
    cells, origin = cells_of(wanted)
    assert cells_of(found)[0] == cells, f"{path.name}: cells"
    for kind, pick in (("PointData", slice(None)), ("CellData", origin), ("FieldData", slice(None))):
        own, other = (arrays_of(getattr(grid, f"Get{kind}")(), of) for grid, of in ((found, slice(None)), (wanted, pick)))
        assert own.keys() == other.keys(), f"{path.name}: {kind} {sorted(own)}, not {sorted(other)}"
        for name, array in other.items():
            assert own[name] == array, f"{path.name}: {kind} {name} is {own[name][:4]}, not {array[:4]}, or has other values"


def main():
    """Compares, and fails with the first file that differs."""
    n_files = 0
    with scratch() as folder:
        for path in vtk_fixtures.fixtures(folder, EVERY):
            compare(path, folder)
            path.unlink()
            n_files += 1
    report("fixtures", n_files, 0, "files by VTK")

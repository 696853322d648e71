"""Makes the .vtkhdf files of testdata/ from its VTU files: by VTK's own writer, and by h5py.

| file | what it is |
|---|---|
| mixed_cells_by_vtk.vtkhdf | mixed_cells_inline.vtu, by VTK's writer: small chunks, packed |
| polyhedra_by_vtk.vtkhdf | polyhedra_ascii.vtu, by VTK's writer |
| moving_by_vtk.vtkhdf | one cell of twenty of polyhedra_ascii.vtu, three steps by VTK's writer, everything again at each step |
| moving_parts_by_h5py.vtkhdf | mixed_cells_inline.vtu twice, as two parts, three steps with the topology once, packed, big endian; wedges in the order of VTK up to 9.6, marked |

At step k, of time k / 2, every y is larger by k / 2; the array "radius" is larger by k, "x" is x plus k.
"""

import h5py
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase

from place import FOLDER

TIMES = [0.0, 0.5, 1.0]


def grid_of(name):
    """A VTU file of the folder, by VTK."""
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(FOLDER / name))
    reader.Update()
    return reader.GetOutput()


def some_cells(grid):
    """One cell of twenty with their nodes and boundary tags, for a small file."""
    extract = vtk.vtkExtractCells()
    extract.SetInputData(grid)
    chosen = list(range(0, grid.GetNumberOfCells(), 20))
    extract.SetCellIds(chosen, len(chosen))
    extract.Update()
    out = extract.GetOutput()
    out.GetCellData().RemoveArray("vtkOriginalCellIds")
    out.GetPointData().RemoveArray("vtkOriginalPointIds")
    out.GetCellData().RemoveArray("Zone")
    out.GetFieldData().ShallowCopy(grid.GetFieldData())
    out.GetFieldData().RemoveArray("ZoneNames")
    return out


def writer_to(name):
    """VTK's writer, with chunks that make small files."""
    writer = vtk.vtkHDFWriter()
    writer.SetFileName(str(FOLDER / name))
    writer.SetChunkSize(100)
    writer.SetCompressionLevel(9)
    return writer


def moved(grid, step):
    """The grid as it is at a step."""
    out = vtk.vtkUnstructuredGrid()
    out.DeepCopy(grid)
    points = vtk_to_numpy(grid.GetPoints().GetData()) + [0.0, TIMES[step], 0.0]
    out.GetPoints().SetData(numpy_to_vtk(points, deep=True))
    x = numpy_to_vtk(points[:, 0] + step, deep=True)
    x.SetName("x")
    out.GetPointData().AddArray(x)
    return out


class Moving(VTKPythonAlgorithmBase):
    """A source of the steps."""

    def __init__(self, grid):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkUnstructuredGrid")
        self.grid = grid

    def FillOutputPortInformation(self, port, info):  # noqa: D102, N802, ARG002
        info.Set(vtk.vtkDataObject.DATA_TYPE_NAME(), "vtkUnstructuredGrid")
        return 1

    def RequestInformation(self, request, inputs, outputs):  # noqa: D102, N802, ARG002
        info = outputs.GetInformationObject(0)
        info.Set(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS(), TIMES, len(TIMES))
        info.Set(vtk.vtkStreamingDemandDrivenPipeline.TIME_RANGE(), [TIMES[0], TIMES[-1]], 2)
        return 1

    def RequestData(self, request, inputs, outputs):  # noqa: D102, N802, ARG002
        info = outputs.GetInformationObject(0)
        moment = info.Get(vtk.vtkStreamingDemandDrivenPipeline.UPDATE_TIME_STEP())
        out = vtk.vtkUnstructuredGrid.GetData(outputs)
        out.ShallowCopy(moved(self.grid, TIMES.index(moment)))
        out.GetInformation().Set(vtk.vtkDataObject.DATA_TIME_STEP(), moment)
        return 1


def by_vtk():
    """The files of VTK's writer."""
    for name in ("mixed_cells_inline", "polyhedra_ascii"):
        writer = writer_to(f"{name.rsplit('_', 1)[0]}_by_vtk.vtkhdf")
        writer.SetInputData(grid_of(f"{name}.vtu"))
        assert writer.Write() == 1, name
    source = Moving(some_cells(grid_of("polyhedra_ascii.vtu")))
    writer = writer_to("moving_by_vtk.vtkhdf")
    writer.SetInputConnection(source.GetOutputPort())
    writer.SetWriteAllTimeSteps(True)
    assert writer.Write() == 1, "moving"


def by_h5py():
    """Two parts, three steps, topology once."""
    grid = grid_of("mixed_cells_inline.vtu")
    points = vtk_to_numpy(grid.GetPoints().GetData()).astype(">f8")
    cells = grid.GetCells()
    n_points, n_cells = grid.GetNumberOfPoints(), grid.GetNumberOfCells()
    entries = vtk_to_numpy(cells.GetConnectivityArray()).astype(">i4")
    starts = vtk_to_numpy(cells.GetOffsetsArray())[:-1]
    for start in starts[vtk_to_numpy(grid.GetCellTypes()) == vtk.VTK_WEDGE]:
        entries[start : start + 6] = entries[start + np.array([0, 2, 1, 3, 5, 4])]
    twice = lambda array: np.concatenate([array, array])  # noqa: E731
    packed = dict(compression="gzip", shuffle=True)
    with h5py.File(FOLDER / "moving_parts_by_h5py.vtkhdf", "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = (2, 0)
        root.attrs.create("Type", np.bytes_("UnstructuredGrid"))
        root.attrs.create("wedges", np.bytes_("outward"))
        root["NumberOfPoints"] = [n_points, n_points]
        root["NumberOfCells"] = [n_cells, n_cells]
        root["NumberOfConnectivityIds"] = [len(entries), len(entries)]
        steps_of = [points + [0.0, moment, 0.0] for moment in TIMES]
        both = np.concatenate([twice(some) for some in steps_of]).astype(">f8")
        root.create_dataset("Points", data=both, chunks=(37, 3), **packed)
        root.create_dataset("Connectivity", data=twice(entries), chunks=(100,), **packed)
        root.create_dataset("Offsets", data=twice(vtk_to_numpy(cells.GetOffsetsArray()).astype(">i4")), **packed)
        root.create_dataset("Types", data=twice(vtk_to_numpy(grid.GetCellTypes())), **packed)
        radius = vtk_to_numpy(grid.GetPointData().GetArray("radius"))
        data = np.concatenate([twice(radius) + k for k in range(3)]).astype(">f4")
        root.create_dataset("PointData/radius", data=data, chunks=(64,), **packed)
        for name in ("BoundaryTag", "Zone"):
            root.create_dataset(f"CellData/{name}", data=twice(vtk_to_numpy(grid.GetCellData().GetArray(name))), **packed)
            names = grid.GetFieldData().GetAbstractArray(f"{name}Names")
            names = [names.GetValue(i) for i in range(names.GetNumberOfValues())]
            root.create_dataset(f"FieldData/{name}Names", data=names, dtype=h5py.string_dtype("ascii"))
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = len(TIMES)
        steps["Values"] = np.array(TIMES, "f4")
        steps["NumberOfParts"] = [2] * 3
        for name in ("PartOffsets", "CellOffsets", "ConnectivityIdOffsets"):
            steps[name] = [0] * 3
        steps["PointOffsets"] = [2 * n_points * k for k in range(3)]
        steps["PointDataOffsets/radius"] = [2 * n_points * k for k in range(3)]
        for name in ("BoundaryTag", "Zone"):
            steps[f"CellDataOffsets/{name}"] = [0] * 3


def main():
    by_vtk()
    by_h5py()

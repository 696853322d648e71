"""Meshes as VTK reads them."""

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.util.vtkConstants import VTK_FLOAT
from vtkmodules.vtkCommonCore import vtkIdList
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm

from model import DIMENSION, POLYHEDRON, Block, Model, by_kind

GROUPS = (("BoundaryTag", "BoundaryTagNames"), ("Zone", "ZoneNames"), ("Group", "GroupNames"))
FOREIGN = ("gmsh:physical", "CellEntityIds", "medit:ref")


class Failures:
    """VTK tells of a failed read through events only."""

    def __init__(self, reader):
        self.texts = []
        self.CallDataType = "string0"
        for event in ("ErrorEvent",):
            reader.AddObserver(event, self.hear)

    def hear(self, _object, _event, text=""):
        self.texts.append(str(text).strip().splitlines()[-1] if str(text).strip() else "error")


Failures.hear.CallDataType = "string0"


def read(path):
    """The file's data set as a model; raises with VTK's own words where it fails."""
    if path.endswith(".cgns"):
        return read_cgns(path)
    return of_grid(run(reader_of(path), path))


def reader_of(path):
    if path.endswith((".vtu", ".pvtu")):
        from vtkmodules.vtkIOXML import vtkXMLPUnstructuredGridReader, vtkXMLUnstructuredGridReader
        return vtkXMLUnstructuredGridReader() if path.endswith(".vtu") else vtkXMLPUnstructuredGridReader()
    if path.endswith((".vtkhdf", ".hdf")):
        from vtkmodules.vtkIOHDF import vtkHDFReader
        return vtkHDFReader()
    from vtkmodules.vtkIOLegacy import vtkDataSetReader
    return vtkDataSetReader()


def run(reader, path):
    failures = Failures(reader)
    reader.SetFileName(path)
    if hasattr(reader, "ReadAllScalarsOn"):
        for what in ("Scalars", "Vectors", "Tensors", "Normals", "TCoords", "Fields"):
            getattr(reader, f"ReadAll{what}On")()
    reader.Update()
    if failures.texts:
        raise ValueError(f"VTK: {failures.texts[0]}")
    output = reader.GetOutputDataObject(0)
    if output is None or not output.IsA("vtkDataSet"):
        raise ValueError(f"VTK: no data set ({output.GetClassName() if output else None})")
    return output


def read_cgns(path):
    from vtkmodules.vtkFiltersCore import vtkAppendFilter
    from vtkmodules.vtkIOCGNSReader import vtkCGNSReader
    reader = vtkCGNSReader()
    failures = Failures(reader)
    reader.SetFileName(path)
    reader.UpdateInformation()
    reader.EnableAllBases()
    reader.EnableAllFamilies()
    reader.Update()
    if failures.texts:
        raise ValueError(f"VTK: {failures.texts[0]}")
    append = vtkAppendFilter()
    iterator = reader.GetOutput().NewIterator()
    while not iterator.IsDoneWithTraversal():
        append.AddInputData(iterator.GetCurrentDataObject())
        iterator.GoToNextItem()
    append.Update()
    model = of_grid(append.GetOutput())
    model.faces_are_groups = True
    model.cell_arrays, model.point_arrays, model.groups = {}, {}, {}
    model.remarks.append("boundary tags not compared: VTK's CGNS reader gives volume cells")
    return model


def of_grid(data):
    points_of = data.GetPoints() if hasattr(data, "GetPoints") else None
    grid = data
    if not data.IsA("vtkUnstructuredGrid"):
        from vtkmodules.vtkFiltersCore import vtkAppendFilter
        append = vtkAppendFilter()
        append.SetOutputPointsPrecision(vtkAlgorithm.DOUBLE_PRECISION)
        append.AddInputData(data)
        append.Update()
        grid = append.GetOutput()
    n_points = grid.GetNumberOfPoints()
    points = vtk_to_numpy(grid.GetPoints().GetData()) if n_points else np.zeros((0, 3))
    model = Model(points)
    model.single = points.dtype == np.float32 or (
        points_of is not None and points_of.GetDataType() == VTK_FLOAT)
    add_cells(model, grid)
    model.point_arrays = arrays(data.GetPointData())
    model.cell_arrays = {} if model.split else arrays(data.GetCellData())
    take_groups(model, data, grid)
    return model.finish()


def arrays(data):
    found = {}
    for i in range(data.GetNumberOfArrays()):
        array = data.GetArray(i)
        name = data.GetArrayName(i)
        if array is not None and name is not None:
            found[name] = vtk_to_numpy(array)
    return found


def add_cells(model, grid):
    n = grid.GetNumberOfCells()
    if n == 0:
        return
    cells = grid.GetCells()
    offsets = vtk_to_numpy(cells.GetOffsetsArray()).astype(np.int64)
    connectivity = vtk_to_numpy(cells.GetConnectivityArray()).astype(np.int64)
    kinds = vtk_to_numpy(grid.GetCellTypesArray())
    for block in by_kind(kinds, np.diff(offsets), offsets[:-1], connectivity):
        if block.kind == POLYHEDRON:
            model.polyhedra += [faces_of(grid, int(cell)) for cell in block.index]
        elif block.nodes.shape[1]:
            model.blocks += simple(block, model)


def faces_of(grid, cell):
    ids = vtkIdList()
    grid.GetFaceStream(cell, ids)
    stream = [ids.GetId(i) for i in range(ids.GetNumberOfIds())]
    faces, at = [], 1
    for _ in range(stream[0]):
        faces.append(stream[at + 1:at + 1 + stream[at]])
        at += stream[at] + 1
    return faces


def simple(block, model):
    """Cells of VTK's own making as those that every program has."""
    nodes, size = block.nodes, block.nodes.shape[1]
    if block.kind == 8:
        return [Block(9, nodes[:, [0, 1, 3, 2]], block.index)]
    if block.kind == 11:
        return [Block(12, nodes[:, [0, 1, 3, 2, 4, 5, 7, 6]], block.index)]
    if block.kind not in (2, 4, 6):
        return [block]
    model.split = True
    if block.kind == 2:
        return [Block(1, nodes[:, [i]], block.index) for i in range(size)]
    if block.kind == 4:
        return [Block(3, nodes[:, [i, i + 1]], block.index) for i in range(size - 1)]
    turn = lambda i: [i, i + 1, i + 2] if i % 2 == 0 else [i + 1, i, i + 2]
    return [Block(5, nodes[:, turn(i)], block.index) for i in range(size - 2)]


def take_groups(model, data, grid):
    """Boundary tags and zones, by the names of arrays that programs agree on."""
    dimension = model.dimension()
    wanted = {"BoundaryTag": lambda d: d + 1 == dimension, "Zone": lambda d: d == dimension,
              "Group": lambda d: d + 1 < dimension}
    pairs = list(GROUPS)
    if "BoundaryTag" not in model.cell_arrays:
        pairs += [(name, None) for name in FOREIGN if name in model.cell_arrays][:1]
    for name, names in pairs:
        values = model.cell_arrays.get(name)
        if values is None or values.ndim > 1 or (values != np.rint(values)).any():
            continue
        texts = strings(data.GetFieldData(), names)
        if name == "Group" and texts is None:
            continue
        del model.cell_arrays[name]
        for block in model.blocks:
            of = DIMENSION.get(block.kind, 3)
            if name not in wanted or wanted[name](of):
                collect(model.groups, of, values[block.index], block.index, texts)


def collect(groups, dimension, numbers, index, texts):
    for number in np.unique(numbers[numbers != 0]).astype(int).tolist():
        named = texts is not None and 0 < number <= len(texts) and texts[number - 1]
        key = (dimension, texts[number - 1] if named else str(number))
        cells = index[numbers == number]
        groups[key] = np.concatenate([groups[key], cells]) if key in groups else cells


def strings(field, name):
    array = field.GetAbstractArray(name) if name else None
    if array is None or not array.IsA("vtkStringArray"):
        return None
    return [array.GetValue(i) for i in range(array.GetNumberOfValues())]

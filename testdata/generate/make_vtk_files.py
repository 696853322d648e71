"""Small legacy, structured and partitioned files for testdata/vtk, written by VTK."""

import numpy as np
import vtk

import place
from vtk_fixtures import block, grid_of, mixed, named, polyhedra, quadratic, with_fields, write_legacy

FOLDER = place.FOLDER / "vtk"


def tetrahedra():
    """Tetrahedra and tagged triangles, small enough to be text."""
    points, cubes = block(2)
    split = [(0, 1, 3, 4), (1, 2, 3, 6), (1, 3, 4, 6), (3, 4, 6, 7), (1, 4, 5, 6)]
    cells = [(vtk.VTK_TETRA, [cube[i] for i in corners]) for cube in cubes for corners in split]
    cells += [(vtk.VTK_TRIANGLE, [cube[0], cube[1], cube[3]]) for cube in cubes[:4]]
    grid = grid_of(points, cells)
    tags = np.array([0] * (len(cells) - 4) + [1, 1, 2, 2], dtype=np.int32)
    grid.GetCellData().AddArray(named(tags, "BoundaryTag"))
    grid.GetPointData().SetVectors(named(points**2, "velocity"))
    return grid


def lattice(kind, extent):
    """A structured or rectilinear grid with an array at its points."""
    grid = kind()
    grid.SetDimensions(*extent)
    axes = [np.linspace(0, 1, n) ** 2 for n in extent]
    if kind is vtk.vtkRectilinearGrid:
        for axis, values in zip("XYZ", axes):
            getattr(grid, f"Set{axis}Coordinates")(named(values, axis))
    else:
        z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
        points = vtk.vtkPoints()
        points.SetData(named(np.stack([x + 0.1 * y, y, z], axis=-1).reshape(-1, 3), "points"))
        grid.SetPoints(points)
    grid.GetPointData().AddArray(named(np.arange(float(np.prod(extent))), "height"))
    return grid


def surface():
    """Polydata of every kind of cell."""
    points, _ = block(2)
    data = vtk.vtkPolyData()
    vtk_points = vtk.vtkPoints()
    vtk_points.SetData(named(points, "points"))
    data.SetPoints(vtk_points)
    for what, cells in (
        ("Verts", [[0], [3, 4]]), ("Lines", [[0, 1, 2]]), ("Polys", [[0, 1, 4, 3], [9, 10, 13], [9, 10, 11, 14, 13]]),
        ("Strips", [[18, 19, 21, 22, 24]]),
    ):  # fmt: skip
        array = vtk.vtkCellArray()
        for nodes in cells:
            array.InsertNextCell(len(nodes), nodes)
        getattr(data, f"Set{what}")(array)
    return data


def write(writer, data, path, binary=True):
    """Writes one file."""
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    if path.suffix == ".vtk":
        (writer.SetFileTypeToBinary if binary else writer.SetFileTypeToASCII)()
    assert writer.Write() == 1


def write_pieces(grid, path, n):
    """A partitioned file whose pieces repeat the nodes between them."""
    numbers = named(np.arange(grid.GetNumberOfPoints(), dtype=np.int64), "GlobalNodeIds")
    grid.GetPointData().SetGlobalIds(numbers)
    names, n_cells = [], grid.GetNumberOfCells()
    for piece in range(n):
        ids = vtk.vtkIdTypeArray()
        for cell in range(piece * n_cells // n, (piece + 1) * n_cells // n):
            ids.InsertNextValue(cell)
        node = vtk.vtkSelectionNode()
        node.SetFieldType(vtk.vtkSelectionNode.CELL)
        node.SetContentType(vtk.vtkSelectionNode.INDICES)
        node.SetSelectionList(ids)
        selection = vtk.vtkSelection()
        selection.AddNode(node)
        extract = vtk.vtkExtractSelection()
        extract.SetInputData(0, grid)
        extract.SetInputData(1, selection)
        extract.Update()
        part = vtk.vtkUnstructuredGrid()
        part.ShallowCopy(extract.GetOutput())
        for data, name in ((part.GetPointData(), "vtkOriginalPointIds"), (part.GetCellData(), "vtkOriginalCellIds")):
            data.RemoveArray(name)
        names.append(f"{path.stem}_{piece}.vtu")
        write(vtk.vtkXMLUnstructuredGridWriter(), part, path.parent / names[-1])
    head = (
        '<VTKFile type="PUnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt32">\n'
        '  <PUnstructuredGrid GhostLevel="0">\n'
        '    <PPoints><PDataArray type="Float64" Name="Points" NumberOfComponents="3"/></PPoints>\n'
        '    <PPointData><PDataArray type="Float64" Name="velocity" NumberOfComponents="3"/>'
        '<PDataArray type="Int64" Name="GlobalNodeIds"/></PPointData>\n'
        '    <PCellData><PDataArray type="Int32" Name="BoundaryTag"/></PCellData>\n'
    )
    pieces = "".join(f'    <Piece Source="{name}"/>\n' for name in names)
    path.write_text(f"{head}{pieces}  </PUnstructuredGrid>\n</VTKFile>\n")


def main():
    """Writes all files anew."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for old in FOLDER.iterdir():
        old.unlink()
    grid = tetrahedra()
    for version in ("2.0", "3.0", "4.2", "5.1"):
        for binary in (False, True):
            name = f"tetrahedra_{version}_{'binary' if binary else 'ascii'}.vtk"
            write_legacy(with_fields(grid), FOLDER / name, version, binary)
    for name, make in (("mixed", mixed), ("quadratic", quadratic), ("polyhedra", polyhedra)):
        write_legacy(make(), FOLDER / f"{name}_5.1_binary.vtk", "5.1", True)
    write_legacy(mixed(), FOLDER / "mixed_4.2_ascii.vtk", "4.2", False)
    write_pieces(grid, FOLDER / "tetrahedra.pvtu", 2)
    for kind, stem, legacy, xml in (
        (vtk.vtkStructuredGrid, "structured", vtk.vtkStructuredGridWriter, vtk.vtkXMLStructuredGridWriter),
        (vtk.vtkRectilinearGrid, "rectilinear", vtk.vtkRectilinearGridWriter, vtk.vtkXMLRectilinearGridWriter),
    ):
        suffix = {"structured": ".vts", "rectilinear": ".vtr"}[stem]
        data = lattice(kind, (4, 3, 3))
        write(legacy(), data, FOLDER / f"{stem}_ascii.vtk", binary=False)
        write(legacy(), data, FOLDER / f"{stem}_binary.vtk")
        write(xml(), data, FOLDER / f"{stem}{suffix}")
    write(vtk.vtkPolyDataWriter(), surface(), FOLDER / "surface_ascii.vtk", binary=False)
    write(vtk.vtkXMLPolyDataWriter(), surface(), FOLDER / "surface.vtp")
    for path in sorted(FOLDER.iterdir()):
        assert path.stat().st_size < 100_000, path

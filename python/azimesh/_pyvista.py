"""Meshes to and from pyvista."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

import azimesh

if TYPE_CHECKING:
    import pyvista

    from azimesh import Mesh

# Cell array of the number of a boundary tag and of a zone, from 1; 0 is none. Their names are field arrays.
TAG, ZONE = "BoundaryTag", "Zone"
# Nodes of a wedge in the order of VTK up to 9.6, as the files that azimesh writes have them.
VTK_WEDGE = [0, 2, 1, 3, 5, 4]
ENDINGS = (".su2", ".cgns", ".msh", ".foam")


def to_pyvista(mesh: Mesh) -> pyvista.UnstructuredGrid:
    """The mesh as an unstructured grid; points and connectivity are copied.

    The boundary tag of a face is the cell array ``BoundaryTag``, the zone of a cell ``Zone``: numbers from 1, whose names
    are the field arrays ``BoundaryTagNames`` and ``ZoneNames``. Of a face in several tags the last counts. Wedges have their
    nodes in the order in which VTK up to 9.6 has a positive volume; VTK 9.7 has a negative one.
    """
    import pyvista

    cells, types = _cells(mesh)
    grid = pyvista.UnstructuredGrid(cells, types, np.array(mesh.points))
    for name, values in mesh.point_data.items():
        grid.point_data[name] = np.array(values)
    for name, values in mesh.cell_data.items():
        grid.cell_data[name] = np.array(values)
    for array, groups in ((TAG, mesh.tags), (ZONE, mesh.zones)):
        if not groups:
            continue
        numbers = np.zeros(mesh.n_cells, dtype=np.int32)
        for number, members in enumerate(groups.values(), start=1):
            numbers[members] = number
        grid.cell_data[array] = numbers
        grid.field_data[array + "Names"] = list(groups)
    return grid


def _cells(mesh: Mesh) -> tuple[Any, Any]:
    """Cells as VTK's list of (number of values, values...) and their types, in the order of the mesh."""
    from pyvista import CellType

    numbers = _vtk_numbers(CellType)
    types = np.empty(mesh.n_cells, dtype=np.uint8)
    sizes = np.empty(mesh.n_cells, dtype=np.int64)
    for name, block in mesh.cells.items():
        place = mesh.cell_index[name]
        types[place] = numbers[name.rstrip("0123456789") if name not in numbers else name]
        sizes[place] = np.diff(block[1]) if isinstance(block, tuple) else block.shape[1]
    starts = np.concatenate([[0], np.cumsum(sizes + 1)])
    cells = np.empty(starts[-1], dtype=np.int64)
    cells[starts[:-1]] = sizes
    for name, block in mesh.cells.items():
        begin = starts[mesh.cell_index[name]] + 1
        if isinstance(block, tuple):
            values, offsets = block
            for at, start, end in zip(begin, offsets[:-1], offsets[1:]):
                cells[at : at + end - start] = values[start:end]
        else:
            nodes = block[:, VTK_WEDGE] if name == "wedge" else block
            cells[begin[:, None] + np.arange(block.shape[1])] = nodes
    return cells, types


def _vtk_numbers(types: Any) -> dict[str, int]:
    """VTK's numbers by meshio's names."""
    return {
        "vertex": 1, "line": 3, "triangle": 5, "polygon": 7, "quad": 9, "tetra": 10, "hexahedron": 12, "wedge": 13,
        "pyramid": 14, "penta_prism": 15, "hexa_prism": 16, "line3": 21, "triangle6": 22, "quad8": 23, "tetra10": 24,
        "hexahedron20": 25, "wedge15": 26, "pyramid13": 27, "quad9": 28, "hexahedron27": 29, "quad6": 30, "wedge12": 31,
        "wedge18": 32, "hexahedron24": 33, "triangle7": 34, "line4": 35, "quadratic_polygon": 36, "pyramid19": 37,
        "polyhedron": 42,
        **{f"VTK_{name}": int(number) for name, number in types.__members__.items() if name[:6] in ("LAGRAN", "BEZIER")},
    }


def from_pyvista(grid: Any, tag_array: str | None = None) -> Mesh:
    """A mesh of a grid of pyvista, or of any data set of VTK with cells.

    Tags and zones are those of `to_pyvista`, and of any cell array that the readers of VTK files know;
    ``tag_array`` names another one.
    """
    import tempfile

    import pyvista

    wrapped = pyvista.wrap(grid)
    if not isinstance(wrapped, pyvista.UnstructuredGrid):
        wrapped = wrapped.cast_to_unstructured_grid()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "grid.vtu")
        wrapped.save(path)
        return azimesh.read(path, tag_array=tag_array)


def read(path: str | os.PathLike[str]) -> pyvista.UnstructuredGrid:
    """Reads a file of any format that azimesh reads, as pyvista's."""
    return to_pyvista(azimesh.read(path))


def use_in_pyvista() -> None:
    """Lets `pyvista.read` read .su2, .cgns, .msh and .foam by azimesh, in this process.

    pyvista reads some of these itself, as other types and with other arrays, so installing azimesh alone changes nothing
    but ``.ugrid``, which it does not read.
    """
    import pyvista

    for ending in ENDINGS:
        pyvista.register_reader(ending, read, override=True)

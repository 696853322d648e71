"""Meshes to and from meshio."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

import azimesh

if TYPE_CHECKING:
    import meshio

    from azimesh import Mesh


def to_meshio(mesh: Mesh) -> meshio.Mesh:
    """The mesh as meshio's: tags and zones are its ``cell_sets``, numbered within each block of cells."""
    import meshio

    blocks: list[tuple[str, Any]] = []
    places = []
    for name, block in mesh.cells.items():
        parts = _ragged(name, *block) if isinstance(block, tuple) else [(name, np.asarray(block), slice(None))]
        for kind, cells, at in parts:
            blocks.append((kind, cells))
            places.append(mesh.cell_index[name][at])
    block_of = np.empty(mesh.n_cells, dtype=np.int64)
    row_of = np.empty(mesh.n_cells, dtype=np.int64)
    for number, place in enumerate(places):
        block_of[place] = number
        row_of[place] = np.arange(len(place))
    sets = {}
    for name, cells in {**mesh.zones, **mesh.tags}.items():
        sets[name] = [row_of[cells[block_of[cells] == number]] for number in range(len(places))]
    cell_data = {
        name: [np.asarray(values)[place] for place in places]
        for name, values in mesh.cell_data.items()
        if isinstance(values, np.ndarray)
    }
    point_data = {name: values for name, values in mesh.point_data.items() if isinstance(values, np.ndarray)}
    return meshio.Mesh(np.array(mesh.points), blocks, point_data=point_data, cell_data=cell_data, cell_sets=sets)


def _ragged(name: str, values: Any, offsets: Any) -> list[tuple[str, Any, Any]]:
    """Polygons and polyhedra by their numbers of nodes, as meshio has them: (type, cells, which of the block they are)."""
    if name == "polygon":
        sizes = np.diff(offsets)
        groups = [(n, np.flatnonzero(sizes == n)) for n in np.unique(sizes)]
        return [(name, values[offsets[at][:, None] + np.arange(n)], at) for n, at in groups]
    cells = [_faces(values[start:end]) for start, end in zip(offsets[:-1], offsets[1:])]
    sizes = np.array([len(np.unique(np.concatenate(faces))) for faces in cells])
    groups = [(n, np.flatnonzero(sizes == n)) for n in np.unique(sizes)]
    return [(f"{name}{n}", [cells[i] for i in at], at) for n, at in groups]


def _faces(stream: Any) -> list[Any]:
    """The faces of a polyhedron from its stream: number of faces, then for each its nodes after their number."""
    faces, at = [], 1
    for _ in range(int(stream[0])):
        n = int(stream[at])
        faces.append(np.asarray(stream[at + 1 : at + 1 + n], dtype=np.int64))
        at += 1 + n
    return faces


def from_meshio(mesh: meshio.Mesh) -> Mesh:
    """A mesh of meshio's.

    ``cell_sets`` of faces become tags, those of volume cells zones. Without such sets the names in ``field_data`` do
    that, with the numbers of ``gmsh:physical``.
    """
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    cells = []
    for block in mesh.cells:
        if block.type.startswith("polyhedron"):
            cells.append(("polyhedron", _stream(block.data)))
        elif block.type == "polygon":
            nodes = np.asarray(block.data)
            cells.append(("polygon", (nodes.ravel(), np.arange(len(nodes) + 1) * nodes.shape[1])))
        else:
            cells.append((block.type, np.asarray(block.data)))
    ends = np.cumsum([0] + [len(block.data) for block in mesh.cells])
    sets: dict[str, list[Any]] = {}
    for name, rows in mesh.cell_sets.items():
        if not name.startswith("gmsh:"):
            sets[name] = [np.asarray(row, dtype=np.int64) + start for row, start in zip(rows, ends) if row is not None]
    if not sets and "gmsh:physical" in mesh.cell_data:
        numbers = np.concatenate(mesh.cell_data["gmsh:physical"])
        dimensions = np.repeat([block.dim for block in mesh.cells], np.diff(ends))
        for name, (number, dimension) in mesh.field_data.items():
            sets[name] = [np.flatnonzero((numbers == number) & (dimensions == dimension))]
    dimension_of = np.repeat([block.dim for block in mesh.cells], np.diff(ends))
    largest = max((block.dim for block in mesh.cells), default=0)
    tags, zones = {}, {}
    for name, parts in sets.items():
        numbers = np.concatenate(parts) if parts else np.empty(0, dtype=np.int64)
        tags[name] = numbers[dimension_of[numbers] == largest - 1]
        zones[name] = numbers[dimension_of[numbers] == largest]
    return azimesh.Mesh(
        points,
        cells,
        tags={name: cells for name, cells in tags.items() if len(cells)},
        zones={name: cells for name, cells in zones.items() if len(cells)},
        point_data={name: np.asarray(values) for name, values in mesh.point_data.items()},
        cell_data={name: np.concatenate(parts) for name, parts in mesh.cell_data.items()},
    )


def _stream(cells: Any) -> tuple[Any, Any]:
    values, offsets = [], [0]
    for faces in cells:
        values.append(len(faces))
        for face in faces:
            values += [len(face), *face]
        offsets.append(len(values))
    return np.asarray(values, dtype=np.int64), np.asarray(offsets)

"""A mesh as every reader here gives it, in VTK's node order, and the comparison of two of them."""

from dataclasses import dataclass, field

import numpy as np

DIMENSION = {1: 0, 3: 1, 5: 2, 7: 2, 9: 2, 21: 1, 22: 2, 23: 2, 28: 2, 30: 2, 34: 2, 35: 1, 36: 2,
             68: 1, 69: 2, 70: 2, 75: 1, 76: 2, 77: 2}
CORNERS = {1: 1, 3: 2, 5: 3, 9: 4, 10: 4, 12: 8, 13: 6, 14: 5, 15: 10, 16: 12, 21: 2, 22: 3, 23: 4,
           24: 4, 25: 8, 26: 6, 27: 5, 28: 4, 29: 8, 30: 4, 31: 6, 32: 6, 33: 8, 34: 3, 35: 2,
           37: 5, 68: 2, 69: 3, 70: 4, 71: 4, 72: 8, 73: 6, 74: 5}
POLYHEDRON = 42


@dataclass
class Block:
    """Cells of one kind and one number of nodes."""
    kind: int
    nodes: np.ndarray  # (cells, nodes of each)
    index: np.ndarray  # which cells of the mesh they are
    ordered: bool = True  # False: the reader's order of the nodes beyond the corners is not known


@dataclass
class Model:
    points: np.ndarray
    blocks: list = field(default_factory=list)
    polyhedra: list = field(default_factory=list)  # a list of faces each
    groups: dict = field(default_factory=dict)  # (dimension, name) -> cell indices
    point_arrays: dict = field(default_factory=dict)
    cell_arrays: dict = field(default_factory=dict)
    single: bool = False  # coordinates have 32 bits
    split: bool = False  # strips were split into triangles, whose first node is free
    faces_are_groups: bool = False  # faces below the mesh's dimension exist only in groups
    tags: np.ndarray = None  # the file's numbers of the nodes, where nodes come in another order
    remarks: list = field(default_factory=list)

    def n_cells(self):
        return sum(len(block.nodes) for block in self.blocks) + len(self.polyhedra)

    def dimension(self):
        kinds = [DIMENSION.get(block.kind, 3) for block in self.blocks if len(block.nodes)]
        return max(kinds + [3] * bool(self.polyhedra), default=0)

    def finish(self):
        """Gathers blocks of one kind; rounds coordinates to what the file holds."""
        points = np.asarray(self.points, dtype=np.float64).reshape(-1, 3)
        self.points = points + 0.0  # -0 is 0
        return self


def by_kind(kinds, sizes, offsets, connectivity):
    """Blocks of a mesh given as VTK gives it."""
    blocks = []
    for kind, size in sorted(set(zip(kinds.tolist(), sizes.tolist()))):
        index = np.flatnonzero((kinds == kind) & (sizes == size))
        at = offsets[index][:, None] + np.arange(size)[None, :]
        blocks.append(Block(kind, connectivity[at].reshape(len(index), size), index))
    return blocks


def places(*clouds):
    """Numbers of the positions of several clouds of points: equal where the bits are equal."""
    stacked = np.ascontiguousarray(np.concatenate(clouds))
    _, number = np.unique(stacked.view("V24").ravel(), return_inverse=True)
    return np.split(number.ravel(), np.cumsum([len(cloud) for cloud in clouds])[:-1])


def rows(model, place, wanted=None, below=None, corners_only=False):
    """Cells as sorted rows of position numbers, by kind and size."""
    found = {}
    for block in model.blocks:
        dimension = DIMENSION.get(block.kind, 3)
        if below is not None and dimension < below:
            continue
        nodes = block.nodes
        if wanted is not None:
            nodes = nodes[np.isin(block.index, wanted)]
        if not len(nodes):
            continue
        cells = place[nodes]
        corners = CORNERS.get(block.kind, cells.shape[1])
        if corners_only:
            cells = np.concatenate([cells[:, :corners], np.sort(cells[:, corners:], axis=1)], axis=1)
        if model.split and block.kind == 5:
            cells = first_smallest(cells)
        found.setdefault((block.kind, cells.shape[1]), []).append(cells)
    return {key: in_order(np.concatenate(parts)) for key, parts in found.items()}


def first_smallest(cells):
    shift = cells.argmin(axis=1)[:, None] + np.arange(cells.shape[1])[None, :]
    return np.take_along_axis(cells, shift % cells.shape[1], axis=1)


def in_order(cells):
    return cells[np.lexsort(cells.T[::-1])] if len(cells) else cells


def differences(ours, theirs):
    """Sentences on how two meshes differ, and remarks on how they may."""
    wrong, remarks = [], list(theirs.remarks)
    if ours.dimension() != theirs.dimension():
        wrong.append(f"dimension {ours.dimension()} against {theirs.dimension()}")
        return wrong, remarks
    if theirs.single:
        ours.points = ours.points.astype(np.float32).astype(np.float64)
        theirs.points = theirs.points.astype(np.float32).astype(np.float64)
    place, their_place = places(ours.points, theirs.points)
    compare_nodes(ours, theirs, place, their_place, wrong, remarks)
    if not wrong:
        compare_cells(ours, theirs, place, their_place, wrong, remarks)
        compare_groups(ours, theirs, place, their_place, wrong, remarks)
        compare_arrays(ours, theirs, wrong, remarks)
    return wrong, remarks


def compare_nodes(ours, theirs, place, their_place, wrong, remarks):
    used, their_use = in_use(ours), in_use(theirs)
    n, m = len(place), len(their_place)
    if n == m and (place == their_place).all():
        return
    counts = np.bincount(place[used], minlength=n + m)
    their_counts = np.bincount(their_place[their_use], minlength=n + m)
    different = np.flatnonzero(counts != their_counts)
    if len(different):
        wrong.append(f"nodes of cells: {len(used)} against {len(their_use)}, "
                     f"{len(different)} positions differ")
    elif n != m:
        remarks.append(f"{n} nodes against {m}: the peer leaves out nodes of no cell" if n > m else
                       f"{n} nodes against {m} with nodes of no cell")
    else:
        remarks.append("the peer has the nodes in another order")


def in_use(model):
    parts = [block.nodes.ravel() for block in model.blocks]
    parts += [np.array(face) for cell in model.polyhedra for face in cell]
    return np.unique(np.concatenate(parts)) if parts else np.array([], dtype=int)


def compare_cells(ours, theirs, place, their_place, wrong, remarks):
    below = ours.dimension() if theirs.faces_are_groups else None
    free = not all(block.ordered for block in theirs.blocks)
    corners_only = False
    if free:
        remarks.append("nodes beyond the corners compared as sets")
        corners_only = True
    ours.split = theirs.split
    mine = rows(ours, place, below=below, corners_only=corners_only)
    other = rows(theirs, their_place, below=below, corners_only=corners_only)
    for key in sorted(set(mine) | set(other)):
        a, b = mine.get(key), other.get(key)
        if a is not None and b is not None and a.shape == b.shape and (a == b).all():
            continue
        if a is not None and b is not None and same_sets(a, b) and twice(a, b):
            remarks.append("cells listed twice are one, with the first one's order of nodes")
        elif a is None or b is None or len(np.unique(a, axis=0)) != len(np.unique(b, axis=0)):
            wrong.append(f"cells of VTK type {key[0]} with {key[1]} nodes: "
                         f"{0 if a is None else len(a)} against {0 if b is None else len(b)}")
        elif (np.unique(a, axis=0) == np.unique(b, axis=0)).all():
            remarks.append("cells listed twice are counted once")
        else:
            what = "their nodes in another order" if same_sets(a, b) else "other nodes"
            wrong.append(f"cells of VTK type {key[0]} with {key[1]} nodes: {what}")
    solid = [as_solids(model.polyhedra, at) for model, at in ((ours, place), (theirs, their_place))]
    if solid[0] != solid[1]:
        wrong.append(f"polyhedra differ: {len(solid[0])} against {len(solid[1])}")


def same_sets(a, b):
    """Whether the cells are the same as sets of nodes, each counted once."""
    a, b = (np.unique(np.sort(cells, axis=1), axis=0) for cells in (a, b))
    return a.shape == b.shape and (a == b).all()


def twice(a, b):
    """Whether all rows that only one of them has belong to cells that are listed twice."""
    rows_a, rows_b = ({tuple(row) for row in cells.tolist()} for cells in (a, b))
    listed = [tuple(sorted(row)) for cells in (a, b) for row in np.unique(cells, axis=0).tolist()]
    return all(listed.count(tuple(sorted(row))) > 2 for row in rows_a ^ rows_b)


def as_solids(polyhedra, place):
    faces = lambda cell: tuple(sorted(tuple(sorted(place[list(face)].tolist())) for face in cell))
    return sorted(faces(cell) for cell in polyhedra)


def compare_groups(ours, theirs, place, their_place, wrong, remarks):
    for key, cells in sorted(theirs.groups.items()):
        dimension, name = key[0], key[1]
        their_rows = group_rows(theirs, their_place, cells)
        if not their_rows:
            continue
        alternatives = [(dimension, other) for other in key[1:]]
        found = next((ours.groups[k] for k in alternatives if k in ours.groups), None)
        what = "tag" if dimension + 1 == ours.dimension() else "group"
        if found is None:
            wrong.append(f"{what} \"{name}\" of dimension {dimension} is missing")
        elif group_rows(ours, place, found) != their_rows:
            mine = group_rows(ours, place, found)
            wrong.append(f"{what} \"{name}\": {len(mine)} cells against {len(their_rows)}")


def group_rows(model, place, cells):
    """The cells of a group as a set of sets of corner positions."""
    found = rows(model, place, wanted=cells)
    return {tuple(sorted(row[:CORNERS.get(kind, size)].tolist()))
            for (kind, size), part in found.items() for row in part}


def compare_arrays(ours, theirs, wrong, remarks):
    same_nodes = ours.points.shape == theirs.points.shape and (ours.points == theirs.points).all()
    for at, mine, other in (("point", ours.point_arrays, theirs.point_arrays),
                            ("cell", ours.cell_arrays, theirs.cell_arrays)):
        for name, values in other.items():
            found = mine.get(name)
            if found is None:
                wrong.append(f"{at} array \"{name}\" is missing")
            elif at == "cell" and len(found) != len(values) or at == "point" and not same_nodes:
                remarks.append(f"{at} arrays not compared: another number or order")
                break
            elif not np.array_equal(np.ravel(found), np.ravel(values), equal_nan=True):
                wrong.append(f"{at} array \"{name}\" has other values")

"""CGNS files by h5py: what the standard says of them, without any CGNS library."""

import h5py
import numpy as np

from model import Block, Model

# CGNS's number of an element type: VTK's kind, nodes, order of VTK's nodes among CGNS's
TWELVE = list(range(12))
TYPES = {
    2: (1, 1, None), 3: (3, 2, None), 4: (21, 3, None), 5: (5, 3, None), 6: (22, 6, None),
    7: (9, 4, None), 8: (23, 8, None), 9: (28, 9, None), 10: (10, 4, None), 11: (24, 10, None),
    12: (14, 5, None), 14: (13, 6, None),
    15: (26, 15, [*range(9), 12, 13, 14, 9, 10, 11]),
    16: (32, 18, [*range(9), 12, 13, 14, 9, 10, 11, 15, 16, 17]),
    17: (12, 8, None), 18: (25, 20, TWELVE + [16, 17, 18, 19, 12, 13, 14, 15]),
    19: (29, 27, TWELVE + [16, 17, 18, 19, 12, 13, 14, 15, 24, 22, 21, 23, 20, 25, 26]),
    21: (27, 13, None),
}
# elements whose nodes beyond the corners are compared as sets
HIGHER = {13: (74, 14), 24: (68, 4), 26: (69, 10), 28: (70, 16), 30: (71, 20), 33: (74, 30),
          36: (73, 40), 39: (72, 64), 40: (68, 5), 42: (69, 15), 44: (70, 25), 47: (71, 35),
          50: (74, 55), 53: (73, 75), 56: (72, 125)}
MIXED, NGON, NFACE = 20, 22, 23


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


class Node:
    """A node of the tree, links followed."""

    def __init__(self, group):
        if text(group.attrs.get("type", b"")) == "LK":
            group = group[" link"]
        self.group = group
        self.name = text(group.attrs.get("name", group.name.split("/")[-1]))
        self.label = text(group.attrs.get("label", b""))

    def children(self, label=None):
        nodes = [Node(self.group[key]) for key in self.group if not key.startswith(" ")]
        nodes = [(key, node) for key, node in zip((k for k in self.group if not k.startswith(" ")), nodes)]
        for key, node in nodes:
            node.name = key
        return [node for _, node in nodes if label is None or node.label == label]

    def child(self, name):
        return next((node for node in self.children() if node.name == name), None)

    def data(self):
        return np.array(self.group[" data"]) if " data" in self.group else None

    def words(self):
        data = self.data()
        return "" if data is None else bytes(data.astype(np.uint8).ravel()).decode().strip()


def read(path):
    with h5py.File(path, "r") as file:
        root = Node(file["/"])
        model = Model(np.zeros((0, 3)))
        clouds = []
        for base in root.children("CGNSBase_t"):
            dimension = int(base.data().ravel()[0])
            for zone in base.children("Zone_t"):
                read_zone(zone, dimension, model, clouds)
        model.points = np.concatenate(clouds) if clouds else np.zeros((0, 3))
        model.single = bool(clouds) and all(cloud.dtype == np.float32 for cloud in clouds)
        return model.finish()


def read_zone(zone, dimension, model, clouds):
    kind = zone.child("ZoneType")
    first_node = sum(len(cloud) for cloud in clouds)
    clouds.append(coordinates(zone))
    if kind is not None and kind.words() == "Structured":
        read_structured(zone, dimension, model, first_node)
        return
    elements, ngons, nfaces = {}, {}, {}
    for section in zone.children("Elements_t"):
        read_section(section, elements, ngons, nfaces)
    before = model.n_cells()
    index = {}
    if ngons:
        model.faces_are_groups = True
        add_polyhedra(model, ngons, nfaces, first_node)
    add_elements(model, elements, ngons, first_node, index, before)
    for bc_list in zone.children("ZoneBC_t"):
        for bc in bc_list.children("BC_t"):
            read_bc(bc, dimension, model, index, first_node)


def coordinates(zone):
    grid = zone.child("GridCoordinates") or zone.children("GridCoordinates_t")[0]
    columns = []
    for axis in "XYZ":
        node = grid.child(f"Coordinate{axis}")
        columns.append(node.data().ravel() if node is not None else None)
    n = max(len(column) for column in columns if column is not None)
    kind = next(column for column in columns if column is not None).dtype
    kind = np.dtype(kind).newbyteorder("=")
    return np.stack([np.zeros(n, kind) if column is None else column.astype(kind)
                     for column in columns], axis=1)


def read_section(section, elements, ngons, nfaces):
    kind = int(section.data().ravel()[0])
    start, end = (int(x) for x in section.child("ElementRange").data().ravel())
    connectivity = section.child("ElementConnectivity").data().ravel().astype(np.int64)
    offsets = section.child("ElementStartOffset")
    offsets = None if offsets is None else offsets.data().ravel().astype(np.int64)
    if kind in (NGON, NFACE):
        target = ngons if kind == NGON else nfaces
        at = 0
        for i, number in enumerate(range(start, end + 1)):
            if offsets is None:
                size = connectivity[at]
                target[number] = connectivity[at + 1:at + 1 + size]
                at += size + 1
            else:
                target[number] = connectivity[offsets[i]:offsets[i + 1]]
    elif kind == MIXED:
        at = 0
        for number in range(start, end + 1):
            of = int(connectivity[at])
            size = (TYPES.get(of) or HIGHER[of])[-2 if of in TYPES else -1]
            elements.setdefault(of, []).append((number, connectivity[at + 1:at + 1 + size]))
            at += size + 1
    else:
        size = TYPES[kind][1] if kind in TYPES else HIGHER[kind][1]
        nodes = connectivity.reshape(-1, size)
        elements.setdefault(kind, []).extend(zip(range(start, end + 1), nodes))


def add_elements(model, elements, ngons, first_node, index, first):
    for kind, cells in sorted(elements.items()):
        vtk_kind, size, order = TYPES.get(kind) or (*HIGHER[kind], None)
        nodes = np.array([nodes for _, nodes in cells]).reshape(-1, size) - 1 + first_node
        if order is not None:
            nodes = nodes[:, order]
        place = np.arange(first, first + len(nodes))
        index.update(zip((number for number, _ in cells), place.tolist()))
        model.blocks.append(Block(vtk_kind, nodes, place, kind not in HIGHER))
        first += len(nodes)
    for number, nodes in ngons.items():
        kind = {2: 3, 3: 5, 4: 9}.get(len(nodes), 7)
        index[number] = first
        model.blocks.append(Block(kind, nodes[None, :] - 1 + first_node, np.array([first])))
        first += 1


def add_polyhedra(model, ngons, nfaces, first_node):
    for faces in nfaces.values():
        model.polyhedra.append([(ngons[abs(int(face))] - 1 + first_node).tolist() for face in faces])


def read_bc(bc, dimension, model, index, first_node):
    places = next((bc.child(name) for name in
                   ("PointList", "PointRange", "ElementList", "ElementRange") if bc.child(name)), None)
    if places is None:
        return
    numbers = places.data().ravel().astype(np.int64)
    if places.name.endswith("Range"):
        numbers = np.arange(numbers.min(), numbers.max() + 1)
    location = bc.child("GridLocation")
    location = "Vertex" if location is None else location.words()
    if places.name.startswith("Element"):
        location = "FaceCenter"
    family = next((node.words() for node in bc.children("FamilyName_t")), bc.name)
    key = (dimension - 1, bc.name, family)
    if location == "Vertex":
        cells = faces_on(model, dimension, numbers - 1 + first_node)
    else:
        cells = np.array([index[number] for number in numbers.tolist() if number in index], int)
    if len(cells):
        model.groups[key] = cells


def faces_on(model, dimension, nodes):
    from model import DIMENSION
    found = [block.index[np.isin(block.nodes, nodes).all(axis=1)] for block in model.blocks
             if DIMENSION.get(block.kind, 3) == dimension - 1]
    return np.concatenate(found) if found else np.array([], int)


def read_structured(zone, dimension, model, first_node):
    sizes = zone.data().reshape(3, -1)[0].astype(int)
    grid = np.arange(int(np.prod(sizes))).reshape(sizes, order="F") + first_node
    model.faces_are_groups = True
    first = model.n_cells()
    if len(sizes) == 3:
        a, b = slice(None, -1), slice(1, None)
        corners = [(a, a, a), (b, a, a), (b, b, a), (a, b, a), (a, a, b), (b, a, b), (b, b, b), (a, b, b)]
        kind = 12
    else:
        a, b = slice(None, -1), slice(1, None)
        corners, kind = [(a, a), (b, a), (b, b), (a, b)], 9
    nodes = np.stack([grid[corner].ravel(order="F") for corner in corners], axis=1)
    model.blocks.append(Block(kind, nodes, np.arange(first, first + len(nodes))))
    first += len(nodes)
    for bc in [bc for bcs in zone.children("ZoneBC_t") for bc in bcs.children("BC_t")]:
        first = structured_bc(bc, dimension, grid, model, first)


def structured_bc(bc, dimension, grid, model, first):
    places = bc.child("PointRange")
    if places is None:
        return first
    low, high = np.sort(places.data().reshape(2, -1).astype(int), axis=0)
    location = bc.child("GridLocation")
    flat = [axis for axis in range(len(low)) if low[axis] == high[axis]]
    if len(flat) != 1 or location is not None and location.words() != "Vertex":
        model.remarks.append(f"BC {bc.name} on a structured zone not compared")
        return first
    patch = grid[tuple(slice(l - 1, h) for l, h in zip(low, high))].squeeze(axis=flat[0])
    a, b = slice(None, -1), slice(1, None)
    corners = [(a, a), (b, a), (b, b), (a, b)] if patch.ndim == 2 else [(a,), (b,)]
    nodes = np.stack([patch[corner].ravel(order="F") for corner in corners], axis=1)
    model.blocks.append(Block(9 if patch.ndim == 2 else 3, nodes, np.arange(first, first + len(nodes))))
    family = next((node.words() for node in bc.children("FamilyName_t")), bc.name)
    key = (dimension - 1, bc.name, family)
    before = model.groups.get(key, np.array([], int))
    model.groups[key] = np.concatenate([before, model.blocks[-1].index])
    return first + len(nodes)

"""Small CGNS files in the layouts that real writers leave behind.

All but the last hold the same two hexahedra side by side, 12 nodes, with the tags "low" (1 face, at x = 0), "high" (1 face,
at x = 2) and "sides" (the other 8 faces). Written by h5py, without any CGNS library.
"""

import h5py
import numpy as np

import place

FOLDER = place.FOLDER / "cgns"
KINDS = {"i4": "I4", "i8": "I8", "f4": "R4", "f8": "R8", "i1": "C1"}
X = np.array([i for k in range(2) for j in range(2) for i in range(3)], float)
Y = np.array([j for k in range(2) for j in range(2) for i in range(3)], float)
Z = np.array([k for k in range(2) for j in range(2) for i in range(3)], float)
HEXAHEDRA = [[1, 2, 5, 4, 7, 8, 11, 10], [2, 3, 6, 5, 8, 9, 12, 11]]
LOW, HIGH, MIDDLE = [1, 7, 10, 4], [3, 6, 12, 9], [2, 5, 11, 8]
SIDES = [
    [1, 2, 8, 7], [2, 3, 9, 8], [4, 10, 11, 5], [5, 11, 12, 6], [1, 4, 5, 2], [2, 5, 6, 3], [7, 8, 11, 10], [8, 9, 12, 11],
]  # fmt: skip


class Writer:
    """A CGNS file under work: one base, one zone unless told otherwise."""

    def __init__(self, name, version=3.4, order="<", packed=False, index="i4"):
        self.file = h5py.File(FOLDER / name, "w", track_order=True)
        self.order, self.packed, self.index = order, packed, index
        root = self.file
        mother = (("name", "HDF5 MotherNode", 33), ("label", "Root Node of HDF5 File", 33), ("type", "MT", 3))
        for key, text, n in mother:
            root.attrs[key] = np.array(text.encode(), dtype=f"S{n}")
        root[" format"] = np.frombuffer(b"IEEE_LITTLE_32\0", dtype="i1")
        root[" hdf5version"] = np.frombuffer(b"HDF5 Version 1.10.8".ljust(33, b"\0"), dtype="i1")
        self.add(root, "CGNSLibraryVersion", "CGNSLibraryVersion_t", np.array([version], "f4"))

    def add(self, parent, name, label, data=None):
        """A node; text becomes characters."""
        group = parent.create_group(name, track_order=True)
        if isinstance(data, str):
            data = np.frombuffer(data.encode(), dtype="i1")
        kind = "MT" if data is None else KINDS[data.dtype.str[1:]]
        for key, text, n in (("name", name, 33), ("label", label, 33), ("type", kind, 3)):
            group.attrs[key] = np.array(text.encode(), dtype=f"S{n}")
        group.attrs["flags"] = np.array([1], "i4")
        if data is not None:
            data = data.astype(data.dtype.newbyteorder(self.order))
            group.create_dataset(" data", data=data, **{"chunks": data.shape, "compression": "gzip"} if self.packed else {})
        return group

    def ints(self, parent, name, label, numbers, shape=None):
        data = np.array(numbers, self.index)
        return self.add(parent, name, label, data if shape is None else data.reshape(shape))

    def base(self, name="Base", cells=3, space=3):
        return self.add(self.file, name, "CGNSBase_t", np.array([cells, space], "i4"))

    def zone(self, base, name="Zone", n_nodes=12, n_cells=2):
        zone = self.ints(base, name, "Zone_t", [n_nodes, n_cells, 0], (3, 1))
        self.add(zone, "ZoneType", "ZoneType_t", "Unstructured")
        return zone

    def coordinates(self, zone, name="GridCoordinates", x=X, y=Y, z=Z, kind="f8"):
        grid = self.add(zone, name, "GridCoordinates_t")
        for axis, values in zip("XYZ", (x, y, z)):
            self.add(grid, f"Coordinate{axis}", "DataArray_t", np.array(values, kind))
        return grid

    def section(self, zone, name, kind, first, elements, offsets=None):
        section = self.add(zone, name, "Elements_t", np.array([kind, 0], "i4"))
        count = len(elements)
        self.ints(section, "ElementRange", "IndexRange_t", [first, first + count - 1])
        flat = [number for element in elements for number in element]
        if offsets is False:
            flat = [number for element in elements for number in [len(element), *element]]
        self.ints(section, "ElementConnectivity", "DataArray_t", flat)
        if offsets:
            self.ints(section, "ElementStartOffset", "DataArray_t", np.cumsum([0] + [len(element) for element in elements]))
        return section

    def condition(self, parent, name, points, kind="BCWall", location=None, family=None, how="PointList"):
        node = self.add(parent, name, "BC_t", kind)
        self.ints(node, how, "IndexRange_t" if how.endswith("Range") else "IndexArray_t", points, (-1, 1))
        if location:
            self.add(node, "GridLocation", "GridLocation_t", location)
        if family:
            self.add(node, "FamilyName", "FamilyName_t", family)

    def faces(self, zone, first, location="FaceCenter"):
        """The three boundary conditions on faces numbered from `first`: low, high, sides."""
        conditions = self.add(zone, "ZoneBC", "ZoneBC_t")
        self.condition(conditions, "low", [first], "BCInflow", location)
        self.condition(conditions, "high", [first + 1, first + 1], "BCOutflow", location, how="PointRange")
        self.condition(conditions, "sides", range(first + 2, first + 10), "BCWallViscous", location)


def polyhedra(name, version, offsets):
    """NGON_n and NFACE_n, the face between the two cells turned round for the second."""
    writer = Writer(name, version)
    zone = writer.zone(writer.base())
    writer.coordinates(zone)
    writer.section(zone, "Faces", 22, 1, [LOW, HIGH, *SIDES, MIDDLE], offsets)
    writer.section(zone, "Cells", 23, 12, [[1, 11, 3, 5, 7, 9], [2, -11, 4, 6, 8, 10]], offsets)
    writer.faces(zone, 1)


def parents():
    """Faces that name the cells on their two sides, and no NFACE_n."""
    writer = Writer("parents_only.cgns", index="i8")
    zone = writer.zone(writer.base())
    writer.coordinates(zone, kind="f4")
    section = writer.section(zone, "Faces", 22, 1, [LOW, HIGH, *SIDES, MIDDLE], True)
    left = [12, 13, 12, 13, 12, 13, 12, 13, 12, 13, 12]
    writer.ints(section, "ParentElements", "DataArray_t", [left, [0] * 10 + [13]], (2, 11))
    writer.faces(zone, 1)


def by_nodes():
    """No faces at all; conditions by nodes, location left out; big-endian, 8-byte, compressed."""
    writer = Writer("by_nodes_big_endian_packed.cgns", 3.2, ">", True, "i8")
    zone = writer.zone(writer.base())
    writer.coordinates(zone)
    writer.section(zone, "Elem", 17, 1, HEXAHEDRA)
    conditions = writer.add(zone, "ZoneBC", "ZoneBC_t")
    writer.condition(conditions, "low", LOW, "BCInflow")
    writer.condition(conditions, "high", HIGH, "BCOutflow", "Vertex")
    # nodes of the sides are all nodes: their faces at both ends are in "low" and "high" too
    writer.condition(conditions, "all", [1, 12], "BCWallViscous", how="PointRange")


def link_zone(zone, file):
    """Coordinates and section of another file."""
    for child in ("GridCoordinates", "Hexahedra"):
        link = zone.create_group(child, track_order=True)
        for key, text, n in (("name", child, 33), ("label", "", 33), ("type", "LK", 3)):
            link.attrs[key] = np.array(text.encode(), dtype=f"S{n}")
        target = f"/Base/Zone/{child}"
        link[" path"] = np.frombuffer(target.encode() + b"\0", dtype="i1")
        link[" file"] = np.frombuffer(file.encode() + b"\0", dtype="i1")
        link[" link"] = h5py.ExternalLink(file, target)


def linked_families():
    """Coordinates and section in another file, and in one that links to that; families within families."""
    grid = Writer("linked_grid.cgns")
    zone = grid.zone(grid.base())
    grid.coordinates(zone)
    grid.section(zone, "Hexahedra", 17, 1, HEXAHEDRA)
    twice = Writer("linked_twice.cgns", 3.4)
    link_zone(twice.zone(twice.base()), "linked_families.cgns")
    writer = Writer("linked_families.cgns", 3.4)
    base = writer.base()
    zone = writer.zone(base)
    link_zone(zone, "linked_grid.cgns")
    writer.section(zone, "Faces", 20, 3, [[7, *face] for face in (LOW, HIGH, *SIDES)])
    conditions = writer.add(zone, "ZoneBC", "ZoneBC_t")
    writer.condition(conditions, "BC1", [3, 3], "FamilySpecified", family="in", how="ElementRange")
    writer.condition(conditions, "BC2", [4], "FamilySpecified", family="/Base/out", how="ElementList")
    writer.condition(conditions, "BC3", [5, 6, 7, 8], "FamilySpecified", "FaceCenter", "wall_1")
    writer.condition(conditions, "BC4", [9, 10, 11, 12], "FamilySpecified", "CellCenter", "wall_2")
    for family, kind, within in (
        ("in", "BCInflow", "low"), ("out", "BCOutflow", "high"), ("wall_1", "BCWallViscous", "sides"), ("wall_2", "BCWallViscous", "sides"),
    ):  # fmt: skip
        node = writer.add(base, family, "Family_t")
        writer.add(node, "FamilyBC", "FamilyBC_t", kind)
        writer.add(node, within, "FamilyName_t", within)


def structured():
    """Structured, with a layer of ghost nodes at each end of the first index and ghost cells."""
    writer = Writer("structured_rind.cgns", 3.3)
    zone = writer.ints(writer.base(), "Block", "Zone_t", [[3, 2, 2], [2, 1, 1], [0, 0, 0]])
    writer.add(zone, "ZoneType", "ZoneType_t", "Structured")

    def ghosted(values):
        return np.pad(values.reshape(2, 2, 3), ((0, 0), (0, 0), (1, 1)), constant_values=-99.0)

    grid = writer.coordinates(zone, x=ghosted(X), y=ghosted(Y), z=ghosted(Z))
    writer.add(grid, "Rind", "Rind_t", np.array([1, 1, 0, 0, 0, 0], "i4"))
    solution = writer.add(zone, "Solution", "FlowSolution_t")
    writer.add(solution, "GridLocation", "GridLocation_t", "CellCenter")
    writer.add(solution, "Rind", "Rind_t", np.array([1, 0, 0, 0, 0, 0], "i4"))
    writer.add(solution, "Pressure", "DataArray_t", np.array([-99.0, 7.0, 8.0]).reshape(1, 1, 3))
    conditions = writer.add(zone, "ZoneBC", "ZoneBC_t")
    ranges = [
        ("low", [1, 1, 1, 1, 2, 2], "BCInflow", None), ("high", [3, 1, 1, 3, 1, 1], "BCOutflow", "IFaceCenter"),
        ("south", [1, 1, 1, 3, 1, 2], "BCWallViscous", "Vertex"), ("north", [1, 2, 1, 2, 2, 1], "BCWallViscous", "JFaceCenter"),
        ("bottom", [1, 1, 1, 3, 2, 1], "BCWallViscous", None), ("top", [1, 1, 2, 2, 1, 2], "BCWallViscous", "KFaceCenter"),
    ]  # fmt: skip
    for name, ends, kind, location in ranges:
        family = None if name in ("low", "high") else "sides"
        node = writer.add(conditions, name, "BC_t", kind)
        writer.ints(node, "PointRange", "IndexRange_t", ends, (2, 3))
        if location:
            writer.add(node, "GridLocation", "GridLocation_t", location)
        if family:
            writer.add(node, "FamilyName", "FamilyName_t", family)


def sequence():
    """Three steps: two grids, a pressure of each step."""
    writer = Writer("sequence.cgns", 3.4)
    base = writer.base()
    zone = writer.zone(base)
    writer.coordinates(zone)
    writer.coordinates(zone, "Moved", y=Y + 10)
    writer.section(zone, "Hexahedra", 17, 1, HEXAHEDRA)
    writer.section(zone, "low", 7, 3, [LOW])
    for step in range(3):
        writer.add(writer.add(zone, f"Solution{step}", "FlowSolution_t"), "Pressure", "DataArray_t", np.full(12, float(step)))
    data = writer.add(zone, "ZoneIterativeData", "ZoneIterativeData_t")
    for name, words in (
        ("GridCoordinatesPointers", ["GridCoordinates", "Moved", "GridCoordinates"]),
        ("FlowSolutionPointers", ["Solution0", "Solution1", "Solution2"]),
    ):
        text = "".join(word.ljust(32) for word in words)
        writer.add(data, name, "DataArray_t", np.frombuffer(text.encode(), "i1").reshape(3, 32))
    times = writer.add(base, "TimeIterValues", "BaseIterativeData_t", np.array([3], "i4"))
    writer.add(times, "TimeValues", "DataArray_t", np.array([0.0, 0.5, 1.0]))


def two_zones():
    """Two zones of one name in two bases, a condition of one name in both."""
    writer = Writer("two_bases.cgns", 3.1)
    for base_name, cell, shift in (("Left", HEXAHEDRA[0], 0.0), ("Right", HEXAHEDRA[0], 5.0)):
        zone = writer.zone(writer.base(base_name), "Zone", 12, 1)
        writer.coordinates(zone, x=X + shift)
        writer.section(zone, "Elem", 17, 1, [cell])
        writer.section(zone, "wall", 7, 2, [LOW])
        writer.condition(writer.add(zone, "ZoneBC", "ZoneBC_t"), "wall", [2, 2], "BCWall", "FaceCenter", how="PointRange")


def odd():
    """What real files have and the standard has not: a family without data, an abbreviated kind, a condition by nodes
    with the name of the section of cells, a polygon of two nodes, a link into a file that is not there."""
    writer = Writer("odd_parts.cgns", 3.4)
    base = writer.base()
    writer.add(writer.add(base, "ORPHAN", "Family_t"), "FamilyBC", "FamilyBC_t")
    base["Notes"] = h5py.ExternalLink("nowhere.cgns", "/Base/Notes")
    zone = writer.add(base, "Zone", "Zone_t", np.array([[12], [2], [0]], "i4"))
    writer.add(zone, "ZoneType", "ZoneType_t", "U")
    writer.add(zone, "FamilyName", "FamilyName_t")
    writer.coordinates(zone)
    writer.section(zone, "Air", 17, 1, HEXAHEDRA)
    writer.section(zone, "low", 7, 3, [LOW])
    writer.condition(writer.add(zone, "ZoneBC", "ZoneBC_t"), "Air", [1, 12], "Null", "Vertex", how="PointRange")
    flat = writer.add(base, "Flat", "Zone_t", np.array([[12], [0], [0]], "i4"))
    writer.add(flat, "ZoneType", "ZoneType_t", "Unstructured")
    writer.coordinates(flat)
    polygons = writer.add(flat, "Polygons", "Elements_t", np.array([22, 0], "i4"))
    writer.ints(polygons, "ElementRange", "IndexRange_t", [1, 2])
    writer.ints(polygons, "ElementStartOffset", "DataArray_t", [0, 4, 6])
    writer.ints(polygons, "ElementConnectivity", "DataArray_t", [*HIGH, 1, 2])


def main():
    FOLDER.mkdir(exist_ok=True)
    odd()
    polyhedra("polyhedra_offsets.cgns", 3.4, True)
    polyhedra("polyhedra_counts.cgns", 3.3, False)
    parents()
    by_nodes()
    linked_families()
    structured()
    sequence()
    two_zones()

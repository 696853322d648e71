"""Meshes as third parties read them, in one neutral form, and their comparison.

pyvista reads VTU, the gmsh API reads MSH, meshio reads MSH, SU2 and simple VTU.
"""

import contextlib
import io
import re
from dataclasses import dataclass, field
from pathlib import Path

import gmsh
import meshio
import numpy as np
import pyvista

# VTK cell type: (dimension, name in meshio).
KINDS = {
    1: (0, "vertex"), 3: (1, "line"), 5: (2, "triangle"), 7: (2, "polygon"), 9: (2, "quad"), 10: (3, "tetra"), 12: (3, "hexahedron"),
    13: (3, "wedge"), 14: (3, "pyramid"), 21: (1, "line3"), 22: (2, "triangle6"), 23: (2, "quad8"), 28: (2, "quad9"), 24: (3, "tetra10"),
    25: (3, "hexahedron20"), 29: (3, "hexahedron27"), 26: (3, "wedge15"), 32: (3, "wedge18"), 27: (3, "pyramid13"), 42: (3, "polyhedron"),
}  # fmt: skip
VTK_OF_MESHIO = {name: kind for kind, (_, name) in KINDS.items()}
# Gmsh element type: VTK cell type.
VTK_OF_GMSH = {
    15: 1, 1: 3, 2: 5, 3: 9, 4: 10, 5: 12, 6: 13, 7: 14, 8: 21, 9: 22, 16: 23, 10: 28, 11: 24, 17: 25, 12: 29, 18: 26, 13: 32, 19: 27,
}  # fmt: skip
# Gmsh's node order within second-order cells, as positions in VTK's; from Gmsh's manual
# ("Node ordering") and VTK's cell classes. Others are the same in both.
GMSH_IN_VTK_ORDER = {
    24: [0, 1, 2, 3, 4, 5, 6, 7, 9, 8], 25: [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
    29: [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26],
    26: [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11], 32: [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16],
    27: [0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12],
}  # fmt: skip
# Nodes of a wedge in the order of VTK up to 9.6, as positions in Gmsh's order, which is that of VTK 9.7.
OUTWARD_WEDGE = [0, 2, 1, 3, 5, 4]


@dataclass
class Mesh:
    """Nodes, cells as (VTK type, nodes) by dimension in file order, and groups by name.

    A group of cells below the mesh's dimension is a set of sorted node tuples; a zone is a set of positions among the cells of the mesh's dimension.
    """

    points: np.ndarray
    cells: dict = field(default_factory=lambda: {0: [], 1: [], 2: [], 3: []})
    tags: dict = field(default_factory=dict)
    zones: dict = field(default_factory=dict)

    @property
    def dimension(self):
        """Largest dimension of a cell."""
        return max(dimension for dimension, cells in self.cells.items() if cells)

    @property
    def volume_cells(self):
        """Cells of the mesh's own dimension."""
        return self.cells[self.dimension]


def face_key(nodes):
    """What makes two faces the same: their nodes, in any order."""
    return tuple(sorted(int(n) for n in nodes))


def by_pyvista(path):
    """A VTU as VTK reads it."""
    grid = pyvista.read(path)
    mesh = Mesh(np.array(grid.points, np.float64))
    kinds, offsets, nodes = grid.celltypes, grid.cell_offsets, grid.cell_connectivity
    rows = [nodes[offsets[i] : offsets[i + 1]] for i in range(grid.n_cells)]
    if has_outward_wedges(path):
        rows = [row[OUTWARD_WEDGE] if kind == 13 else row for kind, row in zip(kinds, rows)]
    position = []
    for i, (kind, row) in enumerate(zip(kinds, rows)):
        cells = mesh.cells[KINDS[int(kind)][0]]
        position.append(len(cells))
        stream = faces_of(grid, i) if kind == 42 else tuple(int(n) for n in row)
        cells.append((int(kind), stream))
    of_dimension = np.array([KINDS[int(kind)][0] for kind in kinds])
    for name, members in named_cells(grid, "BoundaryTag", of_dimension == mesh.dimension - 1):
        mesh.tags.setdefault(name, set()).update(face_key(rows[i]) for i in members)
    for name, members in named_cells(grid, "Zone", of_dimension == mesh.dimension):
        mesh.zones.setdefault(name, set()).update(position[i] for i in members)
    return mesh


def has_outward_wedges(path):
    """True for a VTU by azimesh that has wedges: it marks their order."""
    with open(path, "rb") as file:
        return b'wedges="outward"' in file.read(400)


def faces_of(grid, cell):
    """The faces of a polyhedron as sorted tuples, in any order."""
    return tuple(sorted(face_key(face.point_ids) for face in grid.get_cell(cell).faces))


def named_cells(grid, array, wanted):
    """(name, cells) of each positive value of a cell array, with names from the field data."""
    if array not in grid.cell_data:
        return
    values = np.asarray(grid.cell_data[array])
    names = list(map(str, grid.field_data.get(f"{array}Names", [])))
    for value in np.unique(values[wanted & (values > 0)]):
        name = names[value - 1] if value <= len(names) else str(value)
        yield name, np.flatnonzero(wanted & (values == value))


@contextlib.contextmanager
def quiet_gmsh():
    """An initialised gmsh that prints nothing and is gone afterwards."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        yield
    finally:
        gmsh.finalize()


def by_gmsh(path):
    """An MSH as gmsh reads it; nodes and elements in the order of their tags."""
    with quiet_gmsh():
        gmsh.open(str(path))
        tags, xyz, _ = gmsh.model.mesh.getNodes()
        # A node on two entities is given twice.
        tags, first = np.unique(tags, return_index=True)
        mesh = Mesh(xyz.reshape(-1, 3)[first])
        faces = {}
        for dimension, entity in gmsh.model.getEntities():
            for kind, elements, nodes in zip(*gmsh.model.mesh.getElements(dimension, entity)):
                rows = np.searchsorted(tags, nodes).reshape(len(elements), -1)
                for element, row in zip(elements, rows):
                    faces[int(element)] = (VTK_OF_GMSH[kind], entity, to_vtk_order(VTK_OF_GMSH[kind], row))
        collect(mesh, faces)
    return mesh


def to_vtk_order(kind, row):
    """Nodes of a gmsh cell in VTK's order."""
    order = GMSH_IN_VTK_ORDER.get(kind, range(len(row)))
    return tuple(int(row[i]) for i in order)


def collect(mesh, elements):
    """Fills cells, tags and zones from gmsh elements {tag: (VTK type, entity, nodes)}."""
    seen = set()
    placed = {}
    for _, (kind, entity, nodes) in sorted(elements.items()):
        dimension = KINDS[kind][0]
        placed.setdefault((dimension, entity), []).append((len(mesh.cells[dimension]), nodes))
        if (kind, face_key(nodes)) not in seen or dimension == 3:
            mesh.cells[dimension].append((kind, nodes))
        seen.add((kind, face_key(nodes)))
    for dimension, number in gmsh.model.getPhysicalGroups():
        name = gmsh.model.getPhysicalName(dimension, number) or str(number)
        members = [
            member
            for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, number)
            for member in placed.get((dimension, int(entity)), [])
        ]
        if dimension == mesh.dimension - 1:
            mesh.tags.setdefault(name, set()).update(face_key(nodes) for _, nodes in members)
        elif dimension == mesh.dimension:
            mesh.zones.setdefault(name, set()).update(position for position, _ in members)


def by_meshio(path):
    """A mesh as meshio reads it: cells of a type stay in order, those of different types need not."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        read = meshio.read(path, "gmsh" if Path(path).suffix == ".msh2" else None)
    points = np.zeros((len(read.points), 3))
    points[:, : read.points.shape[1]] = read.points
    mesh = Mesh(points)
    for block in read.cells:
        kind = VTK_OF_MESHIO[block.type]
        # meshio takes the wedges of every VTU to be in the order of VTK up to 9.6.
        turned = block.type == "wedge" and Path(path).suffix == ".vtu" and not has_outward_wedges(path)
        data = block.data[:, OUTWARD_WEDGE] if turned else block.data
        mesh.cells[KINDS[kind][0]].extend([(kind, tuple(int(n) for n in row)) for row in data])
    if Path(path).suffix == ".su2":
        su2_markers(path, read, mesh)
    elif "BoundaryTag" in read.cell_data:
        numbered_tags(read, mesh)
    return mesh


def su2_markers(path, read, mesh):
    """Markers: meshio numbers named ones 1, 2, ... in the order of the file."""
    names = re.findall(r"^MARKER_TAG=\s*(.+?)\s*$", Path(path).read_text(), re.M)
    for block, values in zip(read.cells, read.cell_data["su2:tag"]):
        if KINDS[VTK_OF_MESHIO[block.type]][0] != mesh.dimension - 1:
            continue
        for row, value in zip(block.data, values):
            mesh.tags.setdefault(names[value - 1], set()).add(face_key(row))


def numbered_tags(read, mesh):
    """Tags of a VTU without names: called by their number."""
    for block, values in zip(read.cells, read.cell_data["BoundaryTag"]):
        if KINDS[VTK_OF_MESHIO[block.type]][0] != mesh.dimension - 1:
            continue
        for row, value in zip(block.data, values):
            if value > 0:
                mesh.tags.setdefault(str(value), set()).add(face_key(row))


def third_party(path):
    """The mesh as the format's own reader has it."""
    suffix = Path(path).suffix
    readers = {".vtu": by_pyvista, ".msh": by_gmsh, ".msh2": by_gmsh, ".su2": by_meshio}
    return readers[suffix](path)


def write_su2(path, points, cells, tags, dimension=2):
    """Writes cells, and edges or faces by tag, as SU2: kinds by their number of nodes."""
    kinds = {2: 3, 3: 5, 4: 9 if dimension == 2 else 10, 5: 14, 6: 13, 8: 12}
    lines = [f"NDIME= {dimension}", f"NELEM= {len(cells)}"]
    lines += [" ".join(map(str, (kinds[len(cell)], *cell))) for cell in cells]
    lines += [f"NPOIN= {len(points)}", *(" ".join(map(repr, point[:dimension])) for point in np.asarray(points, float).tolist()), f"NMARK= {len(tags)}"]
    for name, faces in tags.items():
        lines += [f"MARKER_TAG= {name}", f"MARKER_ELEMS= {len(faces)}"]
        lines += [" ".join(map(str, ({2: 3, 3: 5, 4: 9}[len(face)], *face))) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def assert_same_points(found, wanted, what):
    """Bit for bit, so that -0 is not 0."""
    assert found.shape == wanted.shape, f"{what}: {found.shape} nodes, expected {wanted.shape}"
    differ = (found.view(np.uint64) != wanted.view(np.uint64)).any(axis=1)
    assert not differ.any(), (
        f"{what}: {differ.sum()} nodes differ, first {np.flatnonzero(differ)[0]}: "
        f"{found[differ][0]} instead of {wanted[differ][0]}"
    )


def by_kind(cells):
    """Cells as {VTK type: rows in order}."""
    rows = {}
    for kind, nodes in cells:
        rows.setdefault(kind, []).append(nodes)
    return rows


def assert_same_cells(found, wanted, what, across_kinds=True):
    """Same types and nodes in the same order; of each type on its own unless `across_kinds`."""
    if not across_kinds:
        found, wanted = by_kind(found), by_kind(wanted)
        assert found.keys() == wanted.keys(), f"{what}: types {found.keys()}, not {wanted.keys()}"
        for kind in wanted:
            assert_same_cells([(kind, r) for r in found[kind]], [(kind, r) for r in wanted[kind]], what)
        return
    assert len(found) == len(wanted), f"{what}: {len(found)} cells, expected {len(wanted)}"
    for i, (a, b) in enumerate(zip(found, wanted)):
        assert a == b, f"{what}: cell {i} is {a}, expected {b}"


def assert_same_groups(found, wanted, what):
    """Same names, and the same members under each."""
    assert found.keys() == wanted.keys(), f"{what}: {sorted(found)} instead of {sorted(wanted)}"
    for name in wanted:
        differ = found[name] ^ wanted[name]
        assert not differ, f"{what}: {len(differ)} members of {name} differ, one is {next(iter(differ))}"

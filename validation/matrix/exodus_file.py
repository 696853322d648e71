"""An Exodus file by its own numbers, as netCDF's library gives them, with the tables of sides of the Exodus manual."""

import numpy as np

# Corners of the sides of elements, from 1. The first two of a shell are the shell itself.
SIDES = {
    "LINE": [(1,), (2,)],
    "TRI": [(1, 2), (2, 3), (3, 1)],
    "QUAD": [(1, 2), (2, 3), (3, 4), (4, 1)],
    "SHELL3": [(1, 2, 3), (1, 3, 2), (1, 2), (2, 3), (3, 1)],
    "SHELL4": [(1, 2, 3, 4), (1, 4, 3, 2), (1, 2), (2, 3), (3, 4), (4, 1)],
    "TET": [(1, 2, 4), (2, 3, 4), (1, 4, 3), (1, 3, 2)],
    "PYRAMID": [(1, 2, 5), (2, 3, 5), (3, 4, 5), (1, 5, 4), (1, 4, 3, 2)],
    "WEDGE": [(1, 2, 5, 4), (2, 3, 6, 5), (1, 4, 6, 3), (1, 3, 2), (4, 5, 6)],
    "HEX": [(1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (1, 5, 8, 4), (1, 4, 3, 2), (5, 6, 7, 8)],
}
CORNERS = {"POINT": 1, "LINE": 2, "TRI": 3, "QUAD": 4, "SHELL3": 3, "SHELL4": 4, "TET": 4, "PYRAMID": 5, "WEDGE": 6, "HEX": 8}
DIMENSIONS = {"POINT": 0, "LINE": 1, "TRI": 2, "QUAD": 2, "SHELL3": 2, "SHELL4": 2, "NSIDED": 2, "TET": 3, "PYRAMID": 3, "WEDGE": 3, "HEX": 3}
STARTS = [("SPHERE", "POINT"), ("CIRCLE", "POINT"), ("BAR", "LINE"), ("BEAM", "LINE"), ("TRUSS", "LINE"), ("EDGE", "LINE"),
          ("TRISHELL", "SHELL3"), ("TRI", "TRI"), ("QUADSHELL", "SHELL4"), ("QUAD", "QUAD"), ("TET", "TET"), ("PYR", "PYRAMID"),
          ("WEDGE", "WEDGE"), ("PRISM", "WEDGE"), ("HEX", "HEX")]

TETRAHEDRON_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
HEXAHEDRON_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
WEDGE_EDGES = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
PYRAMID_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)]
# Of VTK's cells, after the corners: between which corners each node lies.
BETWEEN = {
    21: [(0, 1)],
    22: [(0, 1), (1, 2), (2, 0)],
    34: [(0, 1), (1, 2), (2, 0), (0, 1, 2)],
    23: [(0, 1), (1, 2), (2, 3), (3, 0)],
    28: [(0, 1), (1, 2), (2, 3), (3, 0), (0, 1, 2, 3)],
    24: TETRAHEDRON_EDGES,
    25: HEXAHEDRON_EDGES,
    29: HEXAHEDRON_EDGES + [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 1, 2, 3), (4, 5, 6, 7), tuple(range(8))],
    26: WEDGE_EDGES,
    32: WEDGE_EDGES + [(0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
    27: PYRAMID_EDGES,
    74: PYRAMID_EDGES + [(0, 1, 2, 3)],
}


def beside(mine, path):
    """Nodes bit for bit, elements by their corners, other nodes by their place, side sets by the corners of each face."""
    import netCDF4
    wrong, remarks = [], []
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        if wrong := nodes(mine, file):
            return {"wrong": wrong, "remarks": remarks}
        elements, not_read = blocks(file)
        if any(kind == "NFACED" for kind, _ in elements) and length(file, "num_side_sets"):
            not_read.append("side sets of nfaced")
        wrong += cells(mine, elements)
        wrong += polyhedra(mine, file, elements)
        wrong += not_in_the_middle(mine, remarks)
        if not_read:
            remarks.append(f"not compared by themselves: {', '.join(not_read)}")
        elif not wrong:
            wrong += side_sets(mine, file, elements, remarks)
    return {"wrong": wrong, "remarks": remarks}


def length(file, name):
    return len(file.dimensions[name]) if name in file.dimensions else 0


def nodes(mine, file):
    axes = length(file, "num_dim")
    if "coord" in file.variables:
        given = file["coord"][:].T.astype(float)
    else:
        given = np.stack([file[f"coord{axis}"][:].astype(float) for axis in "xyz"[:axes]], axis=1)
    points = np.zeros((len(given), 3))
    points[:, :axes] = given
    same = points.shape == mine.points.shape and (points + 0.0 == mine.points).all()
    return [] if same else [f"nodes: {len(mine.points)} against {len(points)}, or at other places"]


def shape(name, n_nodes, axes):
    name = name.strip().strip("\0").upper()
    if name.startswith("SHELL"):
        if axes < 3 and n_nodes < 4:
            return "LINE"
        return "SHELL3" if n_nodes in (3, 6, 7) else "SHELL4"
    found = next((shape for start, shape in STARTS if name.startswith(start)), None)
    return "SHELL3" if found == "TRI" and axes == 3 else found


def blocks(file):
    """For each element its shape and nodes from 1, and names of types that the tables do not have."""
    elements, not_read = [], []
    for place in range(1, length(file, "num_el_blk") + 1):
        n = length(file, f"num_el_in_blk{place}")
        variable = file.variables.get(f"connect{place}", file.variables.get(f"facconn{place}"))
        if not n or variable is None:
            continue
        of = variable.elem_type.lower()
        if of.startswith(("nsided", "nfaced")):
            elements += [(of[:6].upper(), row) for row in split(variable[:].tolist(), file[f"ebepecnt{place}"][:].tolist())]
            continue
        kind = shape(variable.elem_type, variable.shape[-1], length(file, "num_dim"))
        if kind and variable.ndim == 2:
            elements += [(kind, row) for row in variable[:].tolist()]
        else:
            not_read.append(variable.elem_type)
            elements += [(None, None)] * n
    return elements, not_read


def split(numbers, lengths):
    rows, first = [], 0
    for n in lengths:
        rows.append(numbers[first:first + n])
        first += n
    return rows


def polyhedra(mine, file, elements):
    """Polyhedra, each as the sets of nodes of its faces. VTK gives them by their number of nodes."""
    faces = []
    for place in range(1, length(file, "num_fa_blk") + 1):
        rows = file[f"fbconn{place}"][:].tolist()
        faces += rows if file[f"fbconn{place}"].ndim == 2 else split(rows, file[f"fbepecnt{place}"][:].tolist())
    theirs = [sorted(sorted(node - 1 for node in faces[face - 1]) for face in row) for kind, row in elements if kind == "NFACED"]
    ours = [sorted(sorted(int(node) for node in face) for face in cell) for cell in mine.polyhedra]
    return [] if sorted(ours) == sorted(theirs) else [f"polyhedra: {len(ours)} against {len(theirs)}, or with other faces"]


def cells(mine, elements):
    """Elements of the highest dimension one by one. Of others, which may lie at one place and are then one cell, the corners."""
    ours = {}
    for block in mine.blocks:
        ours.update(zip(block.index.tolist(), block.nodes.tolist()))
    n_wrong, dimension = 0, mine.dimension()
    faces, corners = set(), {tuple(sorted(row)) for row in corner_rows(mine, list(ours))}
    for i, (kind, row) in enumerate(elements):
        if kind in (None, "NFACED"):
            continue
        n = CORNERS.get(kind, len(row))
        if DIMENSIONS[kind] < dimension:
            faces.add(tuple(sorted(node - 1 for node in row[:n])))
            continue
        found = ours.get(i, [])
        # Nodes of an element that no kind of cell has come last.
        last = set(row[:len(found)]) if kind not in ("WEDGE", "HEX") else set(row)
        n_wrong += [node + 1 for node in found[:n]] != row[:n] or not {node + 1 for node in found} <= last
    n_wrong += len(faces - corners)
    return [f"cells: {n_wrong} of {len(elements)} have other nodes"] if n_wrong else []


def not_in_the_middle(mine, remarks):
    """Nodes that lie nearer to another place than to the middle of the corners between which they are."""
    n, wrong = 0, []
    for block in mine.blocks:
        between = BETWEEN.get(block.kind)
        if not between:
            continue
        points = mine.points[block.nodes]
        n_corners = points.shape[1] - len(between)
        for i, corners in enumerate(between):
            of = points[:, list(corners)]
            distance = np.linalg.norm(points[:, n_corners + i] - of.mean(axis=1), axis=1)
            n_far = int((distance > 0.25 * np.linalg.norm(of.max(axis=1) - of.min(axis=1), axis=1)).sum())
            n += len(points)
            if n_far:
                wrong.append(f"VTK type {block.kind}: {n_far} of {len(points)} nodes {n_corners + i} are not in the middle of {corners}")
    if n and not wrong:
        remarks.append(f"{n} nodes beyond the corners lie in the middle of their corners")
    return wrong


def side_sets(mine, file, elements, remarks):
    wrong, n_faces, n_sets, n_whole = [], 0, 0, 0
    dimension = mine.dimension()
    names = lines(file, "ss_names")
    ids = file["ss_prop1"][:].tolist() if "ss_prop1" in file.variables else []
    for i in range(length(file, "num_side_sets")):
        if f"elem_ss{i + 1}" not in file.variables:
            continue
        name = names[i] if i < len(names) and names[i] else str(ids[i] if i < len(ids) else i + 1)
        sides = list(zip(file[f"elem_ss{i + 1}"][:].tolist(), file[f"side_ss{i + 1}"][:].tolist()))
        # A VTU file has one zone for each cell, so that a set of the largest cells cannot be told from it.
        if dimension == 2 and any(is_whole(elements[element - 1][0], side) for element, side in sides):
            n_whole += len(sides)
            continue
        faces = {corners_of(*elements[element - 1], side, dimension) for element, side in sides}
        found = set()
        # A block has the name of its number too.
        renamed = any(key[1] == f"side set {name}" for key in mine.groups)
        for key in mine.groups:
            if key[1] == (f"side set {name}" if renamed else name) and key[0] < dimension:
                found |= corner_rows(mine, mine.groups[key])
        if missing := len(faces - found):
            wrong.append(f"side set \"{name}\": {missing} of {len(faces)} faces are not in the tag")
        elif found - faces:
            wrong.append(f"side set \"{name}\": {len(found - faces)} faces of the tag are not in it")
        n_faces, n_sets = n_faces + len(faces), n_sets + 1
    if n_whole:
        remarks.append(f"{n_whole} sides that are shells themselves not compared")
    if n_sets and not wrong:
        remarks.append(f"{n_faces} faces of {n_sets} side sets are those of the tags, and no others")
    return wrong


def is_whole(kind, side):
    return kind in ("SHELL3", "SHELL4") and side < 3


def corners_of(kind, row, side, dimension):
    if kind == "LINE" and dimension > 1:
        return tuple(sorted(node - 1 for node in row[:2]))
    if kind == "NSIDED":
        return tuple(sorted((row[side - 1] - 1, row[side % len(row)] - 1)))
    return tuple(sorted(row[corner - 1] - 1 for corner in SIDES[kind][side - 1]))


def corner_rows(mine, index):
    from model import CORNERS as OF_KIND
    found = set()
    for block in mine.blocks:
        rows = block.nodes[np.isin(block.index, index)]
        found |= {tuple(sorted(row[:OF_KIND.get(block.kind, len(row))])) for row in rows.tolist()}
    return found


def lines(file, name):
    if name not in file.variables:
        return []
    return [b"".join(row.tolist()).split(b"\0")[0].decode(errors="replace").strip() for row in file[name][:]]

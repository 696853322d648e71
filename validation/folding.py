"""Meshes and motions in which interpolation folds cells, and Jacobians in numpy.

Each case writes a mesh to a folder and gives its path with a schedule. `repair_cases.py`, `repair_peers.py` and
`verify/repair.py` use them.
"""

import itertools

import numpy as np

# Corners of the square and the cube in VTK's order.
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
CUBE = np.vstack([SQUARE, SQUARE + [0, 0, 1]])


def jacobians(points, cells, n):
    """The Jacobian of every cell at n points along each axis, corners included."""
    solid = cells.shape[1] == 8
    corners, axes = (CUBE, 3) if solid else (SQUARE, 2)
    found = []
    for at in itertools.product(np.linspace(0, 1, n), repeat=axes):
        factors = np.array([np.where(corners[:, k] == 1, at[k], 1 - at[k]) for k in range(axes)])
        columns = []
        for k in range(axes):
            slopes = np.where(corners[:, k] == 1, 1.0, -1.0) * np.delete(factors, k, axis=0).prod(axis=0)
            columns.append(np.einsum("c,mcx->mx", slopes, points[cells]))
        if not solid:
            columns.append(np.broadcast_to([0.0, 0.0, 1.0], columns[0].shape))
        found.append(np.einsum("mx,mx->m", columns[0], np.cross(columns[1], columns[2])))
    return np.array(found)


def schedule(body, motion, fixed, slide=(), more=""):
    """A schedule of two steps: as it is, and moved."""
    quoted = lambda names: ", ".join(f'"{name}"' for name in names)  # noqa: E731
    slides = f"slide = [{quoted(slide)}]\n" if slide else ""
    return f"""version = 1
[time]
values = [0.0, 1.0]
[[body]]
name = "{body}"
tags = ["{body}"]
[body.rigid]
{motion}
ramp = true
[boundaries]
fixed = [{quoted(fixed)}]
{slides}{more}"""


def rotation(angle, axis=(0.0, 0.0, 1.0), origin=(0.0, 0.0, 0.0)):
    """The motion that turns a body."""
    return f"rotate = {{ axis = {list(axis)}, origin = {list(origin)}, angle = {angle} }}"


def su2(path, points, cells, tags, dimension=2):
    """Writes quadrilaterals, triangles or hexahedra (by their number of nodes) with tags of edges or faces."""
    kinds = {3: 5, 4: 9, 8: 12} if dimension == 2 else {4: 10, 6: 13, 8: 12, 5: 14}
    lines = [f"NDIME= {dimension}", f"NELEM= {len(cells)}"]
    lines += [" ".join(map(str, (kinds[len(cell)], *cell, i))) for i, cell in enumerate(cells)]
    lines.append(f"NPOIN= {len(points)}")
    lines += [" ".join(map(repr, map(float, point[:dimension]))) + f" {i}" for i, point in enumerate(points)]
    lines.append(f"NMARK= {len(tags)}")
    faces = {2: 3, 3: 5, 4: 9}
    for name, members in tags.items():
        lines += [f"MARKER_TAG= {name}", f"MARKER_ELEMS= {len(members)}"]
        lines += [" ".join(map(str, (faces[len(face)], *face))) for face in members]
    path.write_text("\n".join(lines) + "\n")


# Along the diagonal of a hexahedron.
TETRAHEDRA = [(0, p, q, 6) for p, q in ((1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1))]


def in_triangles(cells):
    """Quadrilaterals cut in two."""
    return [triangle for a, b, c, d in cells for triangle in ((a, b, c), (a, c, d))]


def in_tetrahedra(cells, tags):
    """Hexahedra of a lattice cut in six, and the faces of their tags in two."""
    cells = [tuple(cell[i] for i in corners) for cell in cells for corners in TETRAHEDRA]
    faces = {}
    for cell in cells:
        for face in itertools.combinations(cell, 3):
            faces.setdefault(frozenset(face), []).append(face)
    outer = [face[0] for face in faces.values() if len(face) == 1]
    of_node = {}
    for face in outer:
        for node in face:
            of_node.setdefault(node, []).append(face)
    cut = lambda quad: {face for face in of_node[quad[0]] + of_node[quad[1]] if set(face) <= set(quad)}  # noqa: E731
    return cells, {name: sorted(set().union(*map(cut, quads))) for name, quads in tags.items()}


def two_blocks(folder, gap, move, n=60, split=False):
    """Two blocks with a narrow gap between them; the right one moves toward and along the left one's side."""
    left, right = ("left", 0.3, 0.5 - gap / 2, 0.35, 0.65), ("right", 0.5 + gap / 2, 0.7, 0.35, 0.65)
    inner = np.linspace(0.5 - gap / 2, 0.5 + gap / 2, 7)
    xs = np.unique(np.concatenate([np.linspace(0, 0.3, n // 3 + 1), np.linspace(0.3, 0.5 - gap / 2, n // 6 + 1), inner,
                                   np.linspace(0.5 + gap / 2, 0.7, n // 6 + 1), np.linspace(0.7, 1, n // 3 + 1)]).round(12))  # fmt: skip
    ys = np.unique(np.concatenate([np.linspace(0, 0.35, n // 3 + 1), np.linspace(0.35, 0.65, n // 3 + 1), np.linspace(0.65, 1, n // 3 + 1)]).round(12))
    motion = f"translate = [0.0, {move}, 0.0]"
    return blocks(folder, xs, ys, [left, right], split), schedule("right", motion, ["left", "outer"])


def blocks(folder, xs, ys, holes, split=False):
    """The mesh of a box between `xs` and `ys` without its holes."""
    points = np.array([[x, y] for y in ys for x in xs])
    node = lambda i, j: i + len(xs) * j  # noqa: E731
    tags = {hole[0]: [] for hole in holes} | {"outer": []}

    def hole_of(i, j):
        if not (0 <= i < len(xs) - 1 and 0 <= j < len(ys) - 1):
            return "outer"
        x, y = (xs[i] + xs[i + 1]) / 2, (ys[j] + ys[j + 1]) / 2
        return next((name for name, x0, x1, y0, y1 in holes if x0 < x < x1 and y0 < y < y1), None)

    cells = []
    for j in range(len(ys) - 1):
        for i in range(len(xs) - 1):
            if hole_of(i, j):
                continue
            ring = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]
            cells.append(ring)
            for k, beside in enumerate([(i, j - 1), (i + 1, j), (i, j + 1), (i - 1, j)]):
                if name := hole_of(*beside):
                    tags[name].append((ring[k], ring[(k + 1) % 4]))
    used = np.unique(np.array(cells))
    new = {old: i for i, old in enumerate(used)}
    cells = [[new[i] for i in cell] for cell in cells]
    tags = {name: [tuple(new[i] for i in edge) for edge in edges] for name, edges in tags.items()}
    su2(folder / "mesh.su2", points[used], in_triangles(cells) if split else cells, tags)
    return folder / "mesh.su2"


def flap(folder, angle, slot=0.02, split=False):
    """A flap behind a wing, with a slot between them; turns about the middle of its nose."""
    x0, x1 = 0.6, 0.6 + slot
    xs = np.unique(np.concatenate([np.linspace(0, 0.2, 11), np.linspace(0.2, x0, 31), np.linspace(x0, x1, 7), np.linspace(x1, 0.8, 15), np.linspace(0.8, 1.2, 21)]).round(12))
    ys = np.unique(np.concatenate([np.linspace(0, 0.45, 24), np.linspace(0.45, 0.48, 6), np.linspace(0.48, 0.52, 9), np.linspace(0.52, 0.55, 6), np.linspace(0.55, 1, 24)]).round(12))
    mesh = blocks(folder, xs, ys, [("wing", 0.2, x0, 0.45, 0.55), ("flap", x1, 0.8, 0.48, 0.52)], split)
    return mesh, schedule("flap", rotation(-angle, origin=(x1, 0.5, 0.0)), ["wing", "outer"])


def half_body(folder, by, slides, n=48):
    """Half a cylinder on a plane, moved along it. Where the plane is fixed the body overtakes its nodes: no valid mesh exists."""
    rings, around = 24, n
    radii = 0.1 * (10 ** np.linspace(0, 1, rings + 1))
    angles = np.linspace(0, np.pi, around + 1)
    points = np.array([[r * np.cos(a), r * np.sin(a)] for r in radii for a in angles])
    node = lambda i, j: i + (around + 1) * j  # noqa: E731
    cells = [[node(i + 1, j), node(i, j), node(i, j + 1), node(i + 1, j + 1)] for j in range(rings) for i in range(around)]
    tags = {
        "body": [(node(i, 0), node(i + 1, 0)) for i in range(around)],
        "outer": [(node(i, rings), node(i + 1, rings)) for i in range(around)],
        "plane": [(node(0, j), node(0, j + 1)) for j in range(rings)] + [(node(around, j), node(around, j + 1)) for j in range(rings)],
    }
    su2(folder / "mesh.su2", points, cells, tags)
    fixed, slide = (["outer"], ["plane"]) if slides else (["outer", "plane"], [])
    return folder / "mesh.su2", schedule("body", f"translate = [{by}, 0.0, 0.0]", fixed, slide)


def turned_block(folder, angle, slides, n=18, floats=False, split=False):
    """A block of hexahedra that stands on a plane and turns about the plane's normal; or it floats above that."""
    base = 0.3 if floats else 0.0
    xs = np.unique(np.concatenate([np.linspace(-1, -0.3, n // 3 + 1), np.linspace(-0.3, 0.3, n // 2 + 1), np.linspace(0.3, 1, n // 3 + 1)]).round(12))
    ys = np.unique(np.concatenate([np.linspace(-1, -0.1, n // 2 + 1), np.linspace(-0.1, 0.1, n // 4 + 1), np.linspace(0.1, 1, n // 2 + 1)]).round(12))
    zs = np.unique(np.concatenate([np.linspace(0, base, n // 3 if floats else 1), np.linspace(base, base + 0.4, n // 3 + 1), np.linspace(base + 0.4, 1 + base, n // 3 + 1)]).round(12))
    points = np.array([[x, y, z] for z in zs for y in ys for x in xs])
    node = lambda i, j, k: i + len(xs) * (j + len(ys) * k)  # noqa: E731
    middle = lambda values, i: (values[i] + values[i + 1]) / 2  # noqa: E731
    counts = [len(values) - 1 for values in (xs, ys, zs)]

    def beside(i, j, k):
        """The tag of what is at a place of the lattice; None for a cell."""
        if k < 0:
            return "plane"
        if not all(0 <= at < n for at, n in zip((i, j, k), counts)):
            return "outer"
        return "body" if abs(middle(xs, i)) < 0.3 and abs(middle(ys, j)) < 0.1 and base < middle(zs, k) < base + 0.4 else None

    cells, tags = [], {"body": [], "plane": [], "outer": []}
    for k, j, i in itertools.product(*(range(n) for n in counts[::-1])):
        if beside(i, j, k):
            continue
        ring = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
        low, high = [node(*at, k) for at in ring], [node(*at, k + 1) for at in ring]
        cells.append(low + high)
        for m, way in enumerate([(0, -1), (1, 0), (0, 1), (-1, 0)]):
            if name := beside(i + way[0], j + way[1], k):
                o = (m + 1) % 4
                tags[name].append((low[m], low[o], high[o], high[m]))
        if name := beside(i, j, k - 1):
            tags[name].append(tuple(low[::-1]))
        if name := beside(i, j, k + 1):
            tags[name].append(tuple(high))
    used = np.unique(np.array(cells))
    new = {old: i for i, old in enumerate(used)}
    cells = [[new[i] for i in cell] for cell in cells]
    tags = {name: [tuple(new[i] for i in face) for face in faces] for name, faces in tags.items()}
    if split:
        cells, tags = in_tetrahedra(cells, tags)
    su2(folder / "mesh.su2", points[used], cells, tags, dimension=3)
    fixed, slide = (["outer"], ["plane"]) if slides else (["outer", "plane"], [])
    return folder / "mesh.su2", schedule("body", rotation(angle), fixed, slide)


def o_grid(folder, angle, n=160, layers=60, first=1e-3, split=False):
    """An O-grid with thin first cells whose inner circle turns in the fixed outer one."""
    growth = np.geomspace(first, 0.12, layers)
    radii = 0.5 + np.concatenate([[0], np.cumsum(growth)])
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    points = np.array([[r * np.cos(a), r * np.sin(a)] for r in radii for a in angles])
    node = lambda i, j: i % n + n * j  # noqa: E731
    cells = [[node(i + 1, j), node(i, j), node(i, j + 1), node(i + 1, j + 1)] for j in range(layers) for i in range(n)]
    tags = {"body": [(node(i, 0), node(i + 1, 0)) for i in range(n)], "outer": [(node(i, layers), node(i + 1, layers)) for i in range(n)]}
    su2(folder / "mesh.su2", points, in_triangles(cells) if split else cells, tags)
    return folder / "mesh.su2", schedule("body", rotation(angle), ["outer"])

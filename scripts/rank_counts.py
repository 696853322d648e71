"""What a run of `azimesh deform` on ranks of MPI does, counted for `rank_model.py`: sizes of parts, messages, bytes of
memory, and the work that takes time. All that follows from the program's code is here: a change there is a change here.
"""

import math
from types import SimpleNamespace

# Nodes within 30 errors of the wall, where the correction reaches: 23 of the sample's 60 layers.
NEAR_WALL = 0.38
# Cells whose sides are compared among themselves first, and that a rank has all or none of.
CHUNK = 1 << 15


def counted(run, cores=math.inf):
    """The sizes of a run by the letters of the docs, with its parts. Work of ranks is that of the one with most, or
    the sum of all over the cores of the machine that they share."""
    _, ranks, threads, steps, quality, correction = run["case"]
    c = SimpleNamespace(N=run["nodes"], C=run["cells"], S=run["surface_points"], B=run["base_points"], R=run["modes"])
    c.judges, c.corrects, c.compact = quality != "none", correction, run.get("compact", False)
    # Written, looked at for folds (five more), and moved: a step that is looked at is moved again to be written.
    c.K, c.J = steps, min(steps + 5, run["steps"]) if c.judges else 0
    c.M, c.P, c.T = c.K + c.J, ranks, threads
    c.swept = c.S * sum(run["sweeps"])
    c.candidates = min(max(c.S // 16, 512), 2048)
    c.F = run["bytes_read"]
    c.written = c.F + 24 * c.N * (c.K - 1)  # one file: the mesh once, and positions
    c.L = c.S / 2  # of a layer
    c.parts = [part(c, rank) for rank in range(c.P)]
    for key in ("rows", "own", "hexes"):
        of_ranks = [getattr(of, key) for of in c.parts]
        setattr(c, key, max([*of_ranks, sum(of_ranks) / cores]))
    c.near_wall = min(c.rows, NEAR_WALL * c.N) * c.corrects
    c.placed = c.N + sum(of.nodes for of in c.parts[1:])
    return c


def part(c, rank):
    """What a rank has: its slab of nodes, nodes with fields, nodes and cells of its part, its own cells, faces."""
    whole = (c.N / c.P, c.N / c.P, 0, 0, 0, 0)
    if c.P == 1:
        whole = (c.N, c.N, c.N, c.C - c.S, c.C - c.S, c.S)
    elif c.judges:
        whole = cube(c) if c.compact else layers(c, rank)
    return SimpleNamespace(**dict(zip(("slab", "rows", "nodes", "hexes", "own", "faces"), whole)))


def cube(c):
    """Of a mesh whose numbering keeps neighbours together: a cube of cells with one layer around it."""
    side = (c.N / c.P) ** (1 / 3)
    return c.N / c.P, (side + 3) ** 3, (side + 3) ** 3, (side + 2) ** 3, c.N / c.P, c.S / c.P


def layers(c, rank):
    """Of the sample, whose nodes and cells lie layer by layer from the wall outwards, then the faces of the wall and of
    the outside: a part goes on for a layer at each seam, and who has the faces of the wall has its first cells."""
    n, L, slabs = c.N / c.L, c.L, math.ceil(c.C / CHUNK)
    first, last = (min(at * slabs // c.P * CHUNK, c.C) / L for at in (rank, rank + 1))
    has_faces = last > n - 1 and rank > 0
    start, end = min(first, n - 1), min(last, n - 1)
    low, high = max(start - 1, 0), min(end + 2, n)
    wall = min(low, 2) if has_faces else 0
    own_low, own_high = rank * n / c.P, (rank + 1) * n / c.P
    rows = high - low + wall + max(0, low - own_low) + max(0, own_high - high)
    hexes = min(end + 1, n - 1) - low + wall / 2
    faces = (low < 1 or has_faces) + (high >= n)
    return tuple(L * of for of in (n / c.P, rows, high - low + wall, hexes, end - start, faces))


# ---------------------------------------------------------------- messages


class Messages:
    """Counts messages as `src/ranks` sends them: {purpose: [messages, bytes]}."""

    def __init__(self, ranks):
        self.ranks, self.sent, self.what = ranks, {}, "start"

    def send(self, sizes, what=None):
        of = self.sent.setdefault(what or self.what, [0, 0])
        of[0] += len(sizes)
        of[1] += sum(sizes)

    def order(self, what, size):
        """Down a tree. Ranks learn from an order what it is for: who passes it on counts it with what was before."""
        before, self.what = self.what, what
        by_first = (self.ranks - 1).bit_length()
        self.send([size] * by_first)
        self.send([size] * (self.ranks - 1 - by_first), before)

    def fold(self, size):
        """Round all ranks, and down a tree."""
        self.send([size] * (2 * self.ranks - 1))

    def all(self, size):
        """Up a tree and down again."""
        self.send([size] * (2 * (self.ranks - 1)))


def varint(number):
    """Bytes of a whole number."""
    return max(1, math.ceil(int(number).bit_length() / 7))


def task_bytes(c):
    """What each rank gets to evaluate fields: the surface with its residuals, and the base points."""
    return c.S * (24 + 24 + 8 * c.R) + c.B * (24 + 8 * c.R)


def messages(c):
    """All that ranks send each other."""
    sent = Messages(c.P)
    others = c.parts[1:]
    if not others:
        return {}
    if c.judges:
        sent.order("parts", c.S / 2 * varint(c.C))
        sent.send([28 * of.nodes + 36 * of.hexes + 20 * of.faces for of in others])
        sent.send([of.faces * varint(of.nodes) for of in others])
        sent.fold(2)
    sent.order("fields", task_bytes(c))
    sent.send([24 * of.rows + 4 * of.nodes for of in others])
    for move in range(c.M):
        sent.order("positions", 4)
        sent.send([24 * of.slab for of in others])
        if c.judges:
            sent.order("places", 1)
            sent.send([24 * of.faces for of in others])
            sent.send([of.nodes / 16 for of in others])  # a hash of 16 bytes for 256 nodes
            sent.send([2] * len(others))
            judged(sent, is_look=move < c.J)
    sent.order("fields", 2)
    sent.order("fields", 1)
    return sent.sent


def judged(sent, is_look):
    """A step that is looked at: cells, with a histogram of 65,536 bins. One that is written: faces and walls."""
    sent.order("quality", 1)
    if is_look:
        sent.fold(4 * 65536 + 80)
        sent.fold(3)
    else:
        sent.fold(80)
        sent.order("quality", 1)
        sent.all(10)


# ---------------------------------------------------------------- memory


def memory(c):
    """MB at the peak of each rank: arrays that live at the same time (ARCHITECTURE.md, Memory)."""
    surface, program = (80 + 8 * c.R) * c.S, 20e6
    mesh = 24 * c.N + 32 * (c.C - c.S) + 16 * c.S
    found = []
    for rank, of in enumerate(c.parts):
        judge = (9 + 13.5) * of.hexes
        centres, tree, order = 32 * of.hexes, 220 * c.S * c.corrects, 12 * of.rows
        fields, places = 8 * c.R * of.rows, 24 * of.rows
        if c.P == 1:
            held, steps = mesh + surface, fields + 48 * c.N + (judge + centres) * c.judges
            evaluation = fields + order + tree + 8 * c.R * c.S
        else:
            own = 52 * of.nodes + 36 * of.hexes + 20 * of.faces + judge
            lists = 4 * sum(other.nodes for other in c.parts)
            held = own * c.judges + fields + places + 4 * of.nodes + (0 if rank else mesh + surface + lists)
            steps = places + centres + (0 if rank else 48 * c.N)
            evaluation = order + tree + task_bytes(c) * (1 if rank else 2)
        found.append((program + held + max(steps, evaluation)) / 1e6)
    return found


# ---------------------------------------------------------------- time


def passed_on(c):
    """Bytes of the fields' order that others than the first rank send, down the tree."""
    return (c.P - 1 - (c.P - 1).bit_length()) * task_bytes(c)


def shared_bytes(c):
    """Bytes that the first rank sends before the first step."""
    sent = messages(c)
    return sum(sent[what][1] for what in ("parts", "fields") if what in sent) - passed_on(c) if c.P > 1 else 0


def reference(c):
    """Cells of the part for which faces are paired and orientations found."""
    return c.hexes * c.judges


def apart(c):
    """Of these, those that have a neighbour in another chunk."""
    return reference(c) * min(1, c.L / CHUNK)


# What takes time: {what: [(stage, how much of it in a run)]}. Work of ranks is that of the one with most.
TERMS = {
    "byte of the mesh": [("reading", lambda c: c.F)],
    "surface node x base point of each sweep": [("selection", lambda c: c.swept)],
    "candidate x base point^2, base point^3 / 3": [("selection", lambda c: c.candidates * c.B**2 + c.B**3 / 3)],
    "node x base point": [("modes", lambda c: c.rows * c.B)],
    "node near the wall": [("modes", lambda c: c.near_wall)],
    "byte of parts and fields": [("modes", shared_bytes)],
    "cell of the reference": [
        ("modes", lambda c: reference(c) * (c.P > 1)),
        ("rest", lambda c: reference(c) * (c.P == 1)),
    ],
    "the same, with a neighbour in another chunk": [
        ("modes", lambda c: apart(c) * (c.P > 1)),
        ("rest", lambda c: apart(c) * (c.P == 1)),
    ],
    "node moved": [("steps", lambda c: c.M * c.rows)],
    "place compared": [("steps", lambda c: c.M * c.placed * c.judges * (c.P > 1))],
    "cell looked at": [("steps", lambda c: c.J * c.own)],
    "cell whose faces are judged": [("steps", lambda c: c.K * c.own * c.judges)],
    "byte written": [("writing", lambda c: c.written)],
    "node of the plan": [("rest", lambda c: c.N)],
    "start of the program": [("rest", lambda c: 1)],
    "start of ranks": [("rest", lambda c: c.P > 1)],
}
# What the first rank does alone, however many there are.
BY_FIRST = {"reading", "selection", "writing", "rest"}

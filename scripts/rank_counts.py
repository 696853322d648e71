"""What a run of `azimesh deform` on ranks of MPI does, counted for `rank_model.py`: sizes of parts, messages, bytes of
memory, and the work that takes time. All that follows from the program's code is here: a change there is a change here.
"""

import math
from types import SimpleNamespace

# Nodes within 30 errors of the wall, where the correction reaches: 23 of the sample's 60 layers.
NEAR_WALL = 0.38
# Cells whose sides are compared among themselves first, and that a rank has all or none of.
CHUNK = 1 << 15
# Bytes that are hashed as one where ranks write, and of the name of a file.
BLOCK, PATH = 1 << 16, 60
# Bytes of a file that a thread of a rank hashes.
SHARE = 64 << 20
# Patches of the surface at most, and points of one at least; nodes in their boxes for each that the correction reaches, and
# surface points near the patches of a rank for each of its own.
MOST_PATCHES, PATCH, BOXED, BESIDE = 1 << 16, 16, 1.25, 1.15
# Nodes that an outline knows, for each of the surface: the ends of first cells are as many as nodes of the wall, half of it here.
KNOWN = 1.5
# Bytes of the map of a body.
MAP = 98


def counted(run, cores=math.inf):
    """The sizes of a run by the letters of the docs, with its parts. Work of ranks is that of the one with most, or
    the sum of all over the cores of the machine that they share."""
    _, ranks, threads, steps, quality, correction = run["case"]
    c = SimpleNamespace(N=run["nodes"], C=run["cells"], S=run["surface_points"], B=run["base_points"], R=run["modes"])
    c.judges, c.corrects, c.compact = quality != "none", correction, run.get("compact", False)
    # Written, looked at for folds (five more), and moved: a step that is looked at is moved again to be written.
    c.K, c.J, c.scheduled = steps, min(steps + 5, run["steps"]) if c.judges else 0, run["steps"]
    # Threads: of each rank where all work, and of the first while the others wait.
    c.M, c.P, c.T, c.alone = c.K + c.J, ranks, threads, run["alone"]
    c.sweeps = run["sweeps"]
    c.swept = c.S * sum(c.sweeps) / min(c.P, cores)
    c.candidates = min(max(c.S // 16, 512), 2048)
    c.F = run["bytes_read"]
    # One file: the mesh once, and positions; where there are several ranks they write these and the nodes of cells.
    c.listed = 32 * (c.C - c.S) + 16 * c.S
    c.written = c.F + 24 * c.N * (c.K - 1) if c.P == 1 else c.F - 24 * c.N - c.listed
    c.written_apart = (c.P > 1) * (24 * c.N * c.K + c.listed) / min(c.P, cores)
    c.L = c.S / 2  # of a layer
    c.parts = [part(c, rank) for rank in range(c.P)]
    # The correction is shared evenly.
    c.patches = min(MOST_PATCHES, math.ceil(c.S / PATCH)) * c.corrects
    c.share = min(c.P, cores)
    c.near_wall = sum(of.near_wall for of in c.parts) / c.share
    for key in ("slab", "nodes", "own", "hexes"):
        of_ranks = [getattr(of, key) for of in c.parts]
        setattr(c, key, max([*of_ranks, sum(of_ranks) / cores]))
    return c


OF_RANK = ("slab", "nodes", "hexes", "own", "faces", "near_wall", "told", "placed", "elsewhere", "at_rest")


def part(c, rank):
    """What a rank has: its own nodes, which it evaluates fields at; all nodes and cells of its part, its own cells, faces, own nodes
    near the wall, own nodes that it tells the first rank of and that are on the surface, nodes of its part that are other
    ranks' own, and those of them on the surface."""
    if c.P == 1:
        has = (c.N, c.N, c.C - c.S, c.C - c.S, c.S, NEAR_WALL * c.N, c.N, c.N, 0, 0)
    else:
        has = cube(c) if c.compact else layers(c, rank)
    return SimpleNamespace(**dict(zip(OF_RANK, has)))


def cube(c):
    """Of a mesh whose numbering keeps neighbours together: a cube of cells with one layer around it."""
    slab, of_surface = c.N / c.P, c.S / c.P
    side = slab ** (1 / 3)
    nodes = (side + 3) ** 3
    near, at_rest = NEAR_WALL * slab, of_surface * (nodes / slab - 1)
    return slab, nodes, (side + 2) ** 3, slab, of_surface, near, of_surface, of_surface, nodes - slab, at_rest


def layers(c, rank):
    """Of the sample, whose nodes and cells lie layer by layer from the wall outwards, then the faces of the wall and of
    the outside: a part goes on for a layer at each seam, and who has the faces of the wall has its first cells. Every
    layer is around the wall, the last at the outside too."""
    n, L, slabs = c.N / c.L, c.L, math.ceil(c.C / CHUNK)
    first, last = (min(at * slabs // c.P * CHUNK, c.C) / L for at in (rank, rank + 1))
    start, end = min(first, n - 1), min(last, n - 1)
    low, high, has_faces = max(start - 1, 0), min(end + 2, n), last > n - 1 and rank > 0
    wall = min(low, 2) if has_faces else 0
    hexes, faces = min(end + 1, n - 1) - low + wall / 2, (low < 1 or has_faces) + (high >= n)
    row, end_row = rank * n / c.P, (rank + 1) * n / c.P
    # The wall and the outside; the other ends of first cells.
    placed = within(row, end_row, 0, 1) + within(row, end_row, n - 1, n)
    told = within(row, end_row, 1, 2)
    near_wall = max(0, min(end_row, NEAR_WALL * n) - row)
    nodes = max(end_row, high) - min(row, low) + wall
    of_rank = (n / c.P, nodes, hexes, end - start, faces, near_wall, told, placed, nodes - n / c.P)
    return tuple(L * of for of in (*of_rank, min(wall, 1)))


def within(start, end, low, high):
    """How much of one interval lies in another."""
    return max(0, min(end, high) - max(start, low))


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

    def exchange(self, size):
        """Between all ranks, so much together."""
        n = self.ranks * (self.ranks - 1)
        self.send([size / n] * n)

    def fold(self, size):
        """Round all ranks, and down a tree."""
        self.send([size] * (2 * self.ranks - 1))

    def gather(self, size):
        """Up a tree, in which a rank gives what those below it have."""
        depths = sum(rank.bit_count() for rank in range(self.ranks))
        self.send([size * depths / (self.ranks - 1)] * (self.ranks - 1))

    def all(self, size):
        """The same, and down again."""
        self.gather(size)
        self.send([size * self.ranks] * (self.ranks - 1))


def varint(number):
    """Bytes of a whole number."""
    return max(1, math.ceil(int(number).bit_length() / 7))


def index(n):
    """Bytes of a whole number below `n`, on average."""
    return 1 + sum(max(0, 1 - 128**digits / n) for digits in range(1, 5))


def interpolant(c, base_points):
    """Bytes of base points with their weights."""
    return base_points * (24 + 8 * c.R)


def task(c):
    """Bytes of what each rank gets to evaluate fields: the interpolant, coefficients of the modes at all steps, and boxes
    of patches."""
    return interpolant(c, c.B) + 24 * c.R * c.scheduled + 48 * c.patches


def near_surface(c):
    """Bytes of the surface near some patches: points, two triangles for each, residuals and fade radii."""
    return min(c.S, BESIDE * c.S / c.P) * (24 + 24 + 8 * c.R + 8) * c.corrects


def messages(c):
    """All that ranks send each other."""
    sent = Messages(c.P)
    others = c.parts[1:]
    if not others:
        return {}
    parts(sent, c)
    outlined(sent, c, others)
    selection(sent, c)
    hashed(sent, c, 0)
    sent.order("parts", (c.S / 2 * varint(c.C) + PATH) * c.judges + PATH)
    placed(sent, c, others)
    if c.judges:
        # Cells that are turned the wrong way.
        sent.what = "parts"
        sent.fold(2)
    sent.order("fields", task(c))
    sent.send([2 for _ in others])
    if c.corrects:
        corrected(sent, c)
    elsewhere = sum(of.elsewhere for of in c.parts)
    sent.what = "fields"
    sent.exchange(4 * elsewhere)
    sent.exchange(8 * c.R * elsewhere)
    sent.order("writing", 1)
    sent.send([4 * of.told + 5 for of in others])
    # The nodes of cells, in the first file.
    sent.order("writing", 16 + PATH)
    sent.all(5)
    sent.gather(BLOCK + 32 * c.listed / c.P / BLOCK)
    for move in range(c.M):
        sent.order("positions", 5)
        sent.send([24 * of.told for of in others])
        is_look = move < c.J
        sent.order("places", MAP)
        if c.judges:
            judged(sent, is_look)
        if not is_look:
            written(sent, c)
    sent.order("fields", 2)
    sent.order("fields", 1)
    return sent.sent


def placed(sent, c, others):
    """Which nodes ranks place themselves, and how: each of its own, then those that it has of others."""
    sent.send([8 * of.placed for of in others])
    sent.exchange(4 * sum(of.elsewhere for of in c.parts))
    sent.exchange(8 * sum(of.at_rest for of in c.parts))
    sent.gather(1)


def outlined(sent, c, others):
    """What the first rank learns of the parts: boundary faces with their nodes and where these are; faces on no cell; first cells,
    which lie with the rank that has the wall."""
    sent.exchange(sum(of.faces for of in others) * (16 + 28))
    sent.order("parts", 1)
    sent.send([8 * of.placed / 2 for of in others])
    sent.exchange(4 * sum(of.elsewhere for of in c.parts))
    sent.exchange(8 * sum(of.at_rest for of in c.parts) / 2)
    sent.exchange(36 * c.S / 2 * (1 - 1 / c.P) * c.compact)
    sent.order("parts", c.S / 2 * varint(c.C))
    sent.gather(1)
    # The file is hashed in shares of 64 MB: of each a block as it is, and the hashes of the others.
    sent.order("parts", 2 * PATH)
    sent.gather((math.ceil(c.F / SHARE) * BLOCK + 32 * c.F / BLOCK) / c.P)


def hashed(sent, c, path):
    """Coordinates that ranks write, or hash alone: bytes before the first whole block and behind the last, half a block each on
    average, and the hashes of those between."""
    sent.order("writing", 12 + path)
    sent.gather(BLOCK + 32 * 24 * c.N / c.P / BLOCK)


def parts(sent, c):
    """Parts that ranks read. Faces meet at the owners of their nodes; each rank asks who else has the nodes that others own,
    is told who has those, gets cells, and the coordinates of these nodes."""
    sent.order("parts", 2 * PATH)
    for size in (1, 1, 11, 1, 1):
        sent.all(size)
    elsewhere = sum(of.elsewhere for of in c.parts)
    sent.exchange(8 * sum(of.faces for of in c.parts[1:]) / 2)
    sent.all(1)
    # At each seam both have a layer of nodes, and one of them owns it.
    seams = elsewhere / 3
    sent.exchange(4 * seams)
    sent.exchange(8 * seams)
    sent.exchange(36 * sum(of.hexes - of.own for of in c.parts))
    sent.all(1)
    sent.all(11)
    sent.exchange(4 * elsewhere)
    sent.exchange(24 * elsewhere)


def corrected(sent, c):
    """How many nodes are around each patch; their places, and what is added to those that are in reach."""
    sent.what = "correction"
    near = sum(of.near_wall for of in c.parts)
    sent.gather(c.patches * 1.5)
    sent.send([4 * c.P] * (c.P - 1))
    abroad = near * (1 - 1 / c.P)
    sent.exchange(24 * BOXED * abroad)
    sent.send([near_surface(c)] * (c.P - 1))
    sent.exchange((4 + 8 * c.R) * abroad)


def selection(sent, c):
    """Sweeps over the surface, of which each rank has a slab of points and values. The largest error is looked for
    over a sample of the steps, and at the end over all of them."""
    slab = [c.S / c.P] * (c.P - 1)
    criterion = 8 * (3 * c.R + 1) * c.scheduled
    worst = math.ceil(c.S / math.ceil(c.S / c.candidates)) / c.P

    def look(size):
        sent.order("selection", criterion)
        sent.all(size)

    sent.order("selection", 2)
    sent.send([points * (24 + 8 * c.R) for points in slab])
    for base_points in c.sweeps:
        sent.order("selection", interpolant(c, base_points))
        look(9)
    look(9)
    for _ in c.sweeps[1:]:
        look(worst * (index(c.S) + 8 * c.R))
    look(9)
    look(9)
    sent.order("selection", 2)
    sent.send([points * 8 * c.R for points in slab])
    sent.order("selection", 2)


def written(sent, c):
    """A step that is kept: a hash of it for what the file has already, then numbers in the file, then the disk."""
    sent.order("writing", 1)
    for path in (0, PATH):
        hashed(sent, c, path)
    sent.order("writing", 1)
    sent.all(1)


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
    surface, program = (80 + 8 * c.R) * c.S, 20e6 if c.P == 1 else 30e6
    mesh = 24 * c.N + 32 * (c.C - c.S) + 16 * c.S
    found = []
    for rank, of in enumerate(c.parts):
        judge, centres = (9 + 13.5) * of.hexes, 32 * of.hexes
        fields = 8 * c.R * of.nodes
        if c.P == 1:
            evaluation = 12 * of.nodes + (220 + 8 * c.R) * c.S * c.corrects
            held, steps = mesh + surface, 48 * c.N + (judge + centres) * c.judges
        else:
            # As much as faces and sizes take stays with the allocator: short arrays that finding them has freed.
            own = 52 * of.nodes + 36 * of.hexes + 20 * of.faces + 2 * judge * c.judges
            # The first rank has the surface, and the places of its nodes and of the ends of first cells, with their numbers.
            held = own + (0 if rank else surface + 16 * c.S + (24 + 8) * KNOWN * c.S)
            # Positions that are kept, and those that the first rank knows.
            steps = centres * c.judges + 24 * of.slab + (0 if rank else 24 * KNOWN * c.S)
            # Places that others ask for, what is added there, and the same of the own nodes.
            near = sum(other.near_wall for other in c.parts) / c.P
            patches = min(c.S, BESIDE * c.S / c.P)
            corrects = (220 + 8 * c.R) * patches + near_surface(c) + (24 * BOXED + 2 * (4 + 8 * c.R)) * near
            evaluation = max(12 * of.slab, corrects * c.corrects + 8 * BOXED * of.near_wall)
        found.append((program + held + fields + max(steps, evaluation)) / 1e6)
    return found


# ---------------------------------------------------------------- time


def passed_on(c):
    """Bytes of orders that others than the first rank send, down the tree."""
    orders = sum(interpolant(c, n) for n in c.sweeps) + task(c)
    return (c.P - 1 - (c.P - 1).bit_length()) * orders


def exchanged(c, *purposes):
    """Bytes for some purposes, of which each rank sends as many."""
    sent = messages(c)
    return sum(sent[what][1] for what in purposes if what in sent)


def reference(c):
    """Cells of the part for which faces are paired and orientations found."""
    return c.hexes * c.judges


def apart(c):
    """Of these, those that have a neighbour in another chunk."""
    return reference(c) * min(1, c.L / CHUNK)


# Who works: each rank with its threads; the first with all of its machine while the others wait, or with one thread.
ALL, FIRST, ONE = "ranks", "first rank", "one thread"
# What takes time: {what: (who, [(stage, how much of it in a run)])}. Work of ranks is that of the one with most.
TERMS = {
    "byte of the mesh": (ALL, [("reading", lambda c: c.F / c.share)]),
    "cell of a part": (ALL, [("reading", lambda c: c.hexes * (c.P > 1))]),
    "surface node x base point of each sweep": (ALL, [("selection", lambda c: c.swept)]),
    "candidate x base point^2, base point^3 / 3": (
        FIRST,
        [("selection", lambda c: c.candidates * c.B**2 + c.B**3 / 3)],
    ),
    "node x base point": (ALL, [("modes", lambda c: c.slab * c.B)]),
    "node near the wall": (ALL, [("modes", lambda c: c.near_wall * c.corrects)]),
    "byte of parts and correction": (
        ONE,
        [("reading", lambda c: exchanged(c, "parts") / c.share), ("modes", lambda c: exchanged(c, "correction") / c.share)],
    ),
    "cell of the reference": (
        ALL,
        [("modes", lambda c: reference(c) * (c.P > 1)), ("rest", lambda c: reference(c) * (c.P == 1))],
    ),
    "the same, with a neighbour in another chunk": (
        ALL,
        [("modes", lambda c: apart(c) * (c.P > 1)), ("rest", lambda c: apart(c) * (c.P == 1))],
    ),
    "node moved": (ALL, [("steps", lambda c: c.M * c.nodes)]),
    "cell looked at": (ALL, [("steps", lambda c: c.J * c.own)]),
    "cell whose faces are judged": (ALL, [("steps", lambda c: c.K * c.own * c.judges)]),
    "byte written": (FIRST, [("writing", lambda c: c.written)]),
    "byte written by ranks": (ALL, [("writing", lambda c: c.written_apart)]),
    "byte of the file that is hashed": (ALL, [("rest", lambda c: c.F / c.share)]),
    "node of the plan": (ALL, [("rest", lambda c: c.slab)]),
    "start of the program": (ONE, [("rest", lambda c: 1)]),
    "start of ranks": (ONE, [("rest", lambda c: c.P > 1)]),
}

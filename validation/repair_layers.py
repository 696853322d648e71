"""Heights of first cells after `azimesh repair`, against the undeformed mesh.

    .venv/bin/python validation/repair_layers.py target/release/azimesh

A blade with first cells of 1e-6 chord is turned by one step of twist that folds cells, and, so that patches reach the wall, its wall
alone is pushed out through the cells on it. A row for hexahedra and wedges: cells that
are folded, left, and the least and largest ratio of a first cell's volume to its face on the blade, which is its height,
against the reference; of cells with a node that the repair has moved, and of the others.
"""

import json
import tempfile
from pathlib import Path

import numpy as np
import pyvista

from repair_cases import azimesh
from folding import rotation, schedule


def upright_edges(cells, wall):
    """Pairs (node of the wall, node above it) of the cells with a face on the wall, by cell."""
    n = cells.shape[1]
    beside = {8: [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)],
              6: [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]}[n]  # fmt: skip
    on_wall = wall[cells]
    first = np.flatnonzero(on_wall.sum(axis=1) == n // 2)
    pairs = []
    for a, b in beside:
        for a, b in ((a, b), (b, a)):
            held = first[on_wall[first, a] & ~on_wall[first, b]]
            pairs.append(np.stack([held, cells[held, a], cells[held, b]], axis=1))
    return np.concatenate(pairs)


def heights(points, pairs, n_cells):
    """The mean length of the upright edges of each first cell."""
    lengths = np.linalg.norm(points[pairs[:, 2]] - points[pairs[:, 1]], axis=1)
    sums, counts = np.zeros(n_cells), np.zeros(n_cells)
    np.add.at(sums, pairs[:, 0], lengths)
    np.add.at(counts, pairs[:, 0], 1)
    return sums[counts > 0] / counts[counts > 0], np.flatnonzero(counts > 0)


def sample(folder, kind):
    """A blade with first cells of 1e-6 chord, and its wall nodes."""
    mesh = folder / "mesh.vtu"
    azimesh("sample", "blade", "--nodes", 40_000, "--first-cell", 1e-6, "--cells", kind, "-o", mesh, "--force")
    grid = pyvista.read(mesh)
    number = list(grid.field_data["BoundaryTagNames"]).index("blade") + 1
    wall = np.zeros(grid.n_points, bool)
    for i in np.flatnonzero(np.asarray(grid.cell_data["BoundaryTag"]) == number):
        wall[grid.get_cell(int(i)).point_ids] = True
    return mesh, grid, wall


def row(folder, kind, angle):
    """Deforms, repairs and compares."""
    mesh, reference, wall = sample(folder, kind)
    more = '[rbf]\nsupport_radius = 5.625\nrotation_radius = 5.625\ninterpolate = "twist"\n[output]\non_inverted = "warn"\n'
    text = schedule("blade", rotation(angle, axis=(1.0, 0.0, 0.0)), ["outer"], more=more)
    (folder / "turned.toml").write_text(text)
    azimesh("deform", mesh, folder / "turned.toml", "-o", folder / "out", "--force", "-q")
    folded = sorted((folder / "out").glob("*_0001.vtu"))[-1]
    compare(folder, f"{kind}, {angle} degrees", kind, reference, wall, folded)


def dent(folder, kind, depth):
    """The wall alone is pushed out by so many heights of its first cells, over a bump a few cells wide; the mesh above is not."""
    mesh, reference, wall = sample(folder, kind)
    x = np.asarray(reference.points, float)
    pairs = upright_edges(reference.cells_dict[{"hex": 12, "wedge": 13}[kind]], wall)
    above = np.full(len(x), -1)
    above[pairs[:, 1]] = pairs[:, 2]
    nodes = np.flatnonzero(above >= 0)
    # In the middle of the upper side, away from edges.
    middle = nodes[np.argmin(np.linalg.norm(x[nodes] - np.quantile(x[nodes], [0.5, 0.5, 0.9], axis=0).diagonal(), axis=1))]
    distance = np.linalg.norm(x[nodes] - x[middle], axis=1)
    radius = np.sort(distance)[60]
    bump = depth * np.clip(1 - (distance / radius) ** 2, 0, None) ** 2
    moved = reference.copy()
    y = x.copy()
    y[nodes] += bump[:, None] * (x[above[nodes]] - x[nodes])
    moved.points = y
    moved.save(folder / "dented.vtu")
    compare(folder, f"{kind}, wall pushed out by {depth} first cells", kind, reference, wall, folder / "dented.vtu")


def compare(folder, name, kind, reference, wall, folded):
    """Repairs and prints the row."""
    out, seconds = azimesh("repair", folded, "-o", folder / "repaired.vtu", "--reference", folder / "mesh.vtu", "--force", "-q", "--json")
    found = json.loads(out)
    before, after = (pyvista.read(path) for path in (folded, folder / "repaired.vtu"))
    x, y, z = (np.asarray(grid.points, float) for grid in (reference, before, after))
    cells = reference.cells_dict[{"hex": 12, "wedge": 13}[kind]]
    pairs = upright_edges(cells, wall)
    old, own = heights(x, pairs, len(cells))
    ratio, ratio_before = heights(z, pairs, len(cells))[0] / old, heights(y, pairs, len(cells))[0] / old
    moved = (y != z).any(axis=1)[cells].any(axis=1)[own]
    of = lambda values: f"{values.min():.4f} to {values.max():.4f}" if len(values) else "-"  # noqa: E731
    rings = max((patch["rings"] for patch in found["patches"]), default=0)
    print(f"| {name} | {found['invalid_before']} | {found['invalid']} | {seconds:.1f} | {rings} | {moved.sum()} | "
          f"{of(ratio_before[moved])} | {of(ratio[moved])} | {len(own) - moved.sum()} | {of(ratio[~moved])} |", flush=True)  # fmt: skip


def main():
    """Both kinds of cells."""
    print("| case | folded | left | s | rings | first cells in patches | their heights before | after | other first cells | their heights |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("hex", "wedge"):
            for angle in (120, 180):
                row(Path(folder), kind, angle)
            for depth in (2, 20):
                dent(Path(folder), kind, depth)


if __name__ == "__main__":
    main()

"""What `azimesh repair` costs: CPU seconds against the same mesh with nothing folded.

    .venv/bin/python validation/repair_cost.py target/release/azimesh FOLDER [--nodes 500000] [--moved 63] [--rounds 3]

Makes a blade of hexahedra in FOLDER and moves single inner nodes of it, chosen with a fixed seed, through one of their neighbours:
all over the mesh, and side by side. Prints a row for each: folded cells, patches, nodes that could move, folded cells left, the
least determinant of a patch, and the CPU seconds of the fastest round without those of the mesh as it was.
"""

import argparse
import json
import resource
import subprocess
from pathlib import Path

import numpy as np
import pyvista


def run(program, *arguments):
    """Runs the program; gives its output and its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.returncode in (0, 1), f"{arguments}: {done.stderr}"
    return done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def folded(grid, n, together):
    """The points of a mesh of hexahedra of which n inner nodes have been moved past a neighbour."""
    points = np.array(grid.points, float)
    cells = grid.cells_dict[12]
    inner = np.ones(len(points), bool)
    inner[np.unique(grid.cells_dict[9])] = False
    counts = np.bincount(cells.ravel(), minlength=len(points))
    candidates = np.flatnonzero(inner & (counts == 8))
    random = np.random.default_rng(7)
    if together:
        middle = points[candidates[len(candidates) // 2]]
        near = np.argsort(np.linalg.norm(points[candidates] - middle, axis=1))[: 8 * n]
        candidates = candidates[near]
    chosen = random.choice(candidates, n, replace=False)
    across = np.full(len(points), -1)
    # The node beside it along the first edge of its last cell.
    for a, b in ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)):
        across[cells[:, a]] = cells[:, b]
    points[chosen] += 1.3 * (points[across[chosen]] - points[chosen])
    return points


def main():
    """Both cases, beside the mesh as it was."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("azimesh", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--nodes", type=int, default=500_000)
    parser.add_argument("--moved", type=int, default=63)
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    program, folder = args.azimesh.resolve(), args.folder
    folder.mkdir(parents=True, exist_ok=True)
    mesh = folder / "blade.vtu"
    if not mesh.exists():
        run(program, "sample", "blade", "--nodes", args.nodes, "--cells", "hex", "-o", mesh)
    grid = pyvista.read(mesh)

    def seconds(path):
        """The least CPU seconds of some rounds, and what was found."""
        command = ("repair", path, "--reference", mesh, "-o", folder / "out.vtu", "--force", "-q", "--json")
        rounds = [run(program, *command) for _ in range(args.rounds)]
        return min(own for _, own in rounds), json.loads(rounds[0][0])

    without, found = seconds(mesh)
    assert found["invalid_before"] == 0
    print(f"{grid.n_points} nodes, nothing folded: {without:.2f} s")
    print("| nodes | folded cells | patches | nodes that could move | left | least determinant | s |")
    print("|---|---|---|---|---|---|---|")
    for name, together in (("side by side", True), ("all over the mesh", False)):
        moved = grid.copy()
        moved.points = folded(grid, args.moved, together)
        path = folder / f"folded_{'together' if together else 'apart'}.vtu"
        moved.save(path)
        own, found = seconds(path)
        patches = found["patches"]
        least = min(patch["min_jacobian"] for patch in patches)
        print(f"| {grid.n_points:,} | {found['invalid_before']}, {name} | {len(patches)} | {sum(patch['nodes'] for patch in patches):,} "
              f"| {found['invalid']} | {least:.3f} | {own - without:.2f} |", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()

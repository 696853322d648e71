"""A regression test of a mesh generator: today's mesh against one that was found good."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import azimesh


def generate(n: int) -> azimesh.Mesh:
    """The generator under test: a square of n by n cells, walls tagged."""
    side = np.linspace(0.0, 1.0, n + 1)
    x, y = np.meshgrid(side, side)
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    quads = np.column_stack([corner, corner + 1, corner + n + 2, corner + n + 1])
    bottom = np.column_stack([np.arange(n), np.arange(1, n + 1)])
    return azimesh.Mesh(points, {"quad": quads, "line": bottom}, tags={"bottom": range(n * n, n * n + n)})


def main() -> azimesh.Difference:
    """Compares, and shows what a change of the generator looks like."""
    with tempfile.TemporaryDirectory() as folder:
        golden = Path(folder) / "golden.vtu"
        azimesh.write(generate(8), golden)
        same = azimesh.diff(generate(8), azimesh.read(golden), tolerance=1e-12)
        assert same.is_same, same
        changed = generate(8)
        points = changed.points.copy()
        points[40, 0] += 1e-6
        found = azimesh.diff(azimesh.read(golden), changed.with_points(points), tolerance=1e-9)
        print(found)
        return found


if __name__ == "__main__":
    main()

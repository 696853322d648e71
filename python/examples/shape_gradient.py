"""An adjoint shape step: derivatives by all nodes become derivatives by the surface, against finite differences.

A flow solver's adjoint gives dJ/dx of every node. `Morph.pull_back` takes it to the moving nodes, and a row of shape
functions to the design variables. Here J is the mean square of the cells' edge lengths, whose dJ/dx is exact.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

import azimesh

TESTDATA = Path(__file__).parents[2] / "testdata"
Floats = npt.NDArray[np.float64]


def objective(points: Floats, edges: npt.NDArray[np.int64]) -> tuple[float, Floats]:
    """J and its derivatives (n, 3) by the positions of all nodes."""
    along = points[edges[:, 1]] - points[edges[:, 0]]
    gradient = np.zeros_like(points)
    np.add.at(gradient, edges[:, 1], 2 * along / len(edges))
    np.add.at(gradient, edges[:, 0], -2 * along / len(edges))
    return float((along**2).sum() / len(edges)), gradient


def main() -> float:
    """Prints both gradients; gives their largest difference, relative."""
    mesh = azimesh.read(TESTDATA / "naca0012.vtu")
    quads = mesh.cells["quad"].astype(np.int64)
    edges = np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])
    morph = azimesh.Morph(mesh, "airfoil", "farfield")
    x = mesh.points[morph.moving, 0]
    # Design variables: bumps of Hicks and Henne in y.
    bumps = np.array([np.sin(np.pi * np.clip(x, 0, 1) ** p) ** 3 for p in (0.4, 0.7, 1.0, 1.5)])

    def moved(design: Floats) -> Floats:
        displacements = np.zeros((len(x), 3))
        displacements[:, 1] = design @ bumps
        return morph(displacements)

    design = np.array([0.01, -0.005, 0.004, 0.002])
    _, by_points = objective(moved(design), edges)
    adjoint = bumps @ morph.pull_back(by_points)[:, 1]
    step = 1e-4
    finite = np.array(
        [
            (objective(moved(design + step * e), edges)[0] - objective(moved(design - step * e), edges)[0]) / (2 * step)
            for e in np.eye(len(design))
        ]
    )
    for number, (a, b) in enumerate(zip(adjoint, finite)):
        print(f"variable {number}: {a: .12e} by pull_back, {b: .12e} by finite differences")
    return float(np.abs(adjoint - finite).max() / np.abs(finite).max())


if __name__ == "__main__":
    main()

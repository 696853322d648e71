"""A loop between a flow and a structure: `Morph` moves the mesh by what a beam gives, step after step.

The wing of the sample mesh is a cantilever of Euler and Bernoulli in numpy, clamped at the symmetry plane; in place of a
flow solver a pressure that grows with the local angle loads it. What a real coupling needs is all there: displacements of
the surface from the structure, positions of all nodes from azimesh, and forces taken back to the structure.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

import azimesh

TESTDATA = Path(__file__).parents[2] / "testdata"
N_ELEMENTS = 20


def beam(length: float, stiffness: float) -> npt.NDArray[np.float64]:
    """The stiffness matrix (2 N, 2 N) of a cantilever along z, deflections and slopes of its free nodes."""
    h = length / N_ELEMENTS
    element = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2]])
    element = np.vstack([element, [[-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]])
    whole = np.zeros((2 * N_ELEMENTS + 2, 2 * N_ELEMENTS + 2))
    for first in range(0, 2 * N_ELEMENTS, 2):
        whole[first : first + 4, first : first + 4] += stiffness / h**3 * element
    return whole[2:, 2:]


def main() -> float:
    """Couples until the tip rests; gives its deflection."""
    mesh = azimesh.read(TESTDATA / "wing_on_plane.vtu")
    morph = azimesh.Morph(mesh, "wing", ["farfield"], slide="symmetry")
    wing = mesh.points[morph.moving]
    span = wing[:, 2].max()
    stiffness = beam(span, 1.0)
    stations = np.linspace(0.0, span, N_ELEMENTS + 1)
    tip = 0.0
    for iteration in range(30):
        # A pressure that falls as the wing bends away, in place of a flow solver.
        load = np.zeros(2 * N_ELEMENTS)
        load[0::2] = 0.2 * (1.0 - tip) * span / N_ELEMENTS
        bent = np.concatenate([[0.0], np.linalg.solve(stiffness, load)[0::2]])
        displacements = np.zeros_like(wing)
        displacements[:, 1] = np.interp(wing[:, 2], stations, bent)
        points = morph(displacements)
        change, tip = abs(bent[-1] - tip), bent[-1]
        worst = azimesh.quality(mesh.with_points(points), reference=mesh).summary
        print(f"{iteration:2}: tip {tip:.6f}, {worst['inverted']} inverted, least {worst['min_scaled_jacobian']:.3f}")
        if change < 1e-8:
            break
    return float(tip)


if __name__ == "__main__":
    main()

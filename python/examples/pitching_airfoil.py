"""A pitching airfoil: a schedule made in Python, positions and quality at every step, a picture by pyvista."""

from __future__ import annotations

import sys
from pathlib import Path

import azimesh

TESTDATA = Path(__file__).parents[2] / "testdata"


def main(picture: str | None = None) -> None:
    """Prints a line a step; draws the step with the largest angle where a file is named."""
    mesh = azimesh.read(TESTDATA / "naca0012.vtu")
    schedule = azimesh.Schedule(
        {
            "azimuth": {"stop": 360.0, "step": 30.0},
            "body": [{"name": "airfoil", "tags": ["airfoil"], "cyclic": {"pitch": [{"sin": 10.0}]}}],
            "boundaries": {"fixed": ["farfield"]},
        }
    )
    deformation = azimesh.Deformation(mesh, schedule)
    for step in deformation:
        quality = step.quality
        print(f"{step.azimuth_deg:5.0f} degrees: least scaled Jacobian {quality['min_scaled_jacobian']:.3f}")
    if picture is not None:
        moved = mesh.with_points(deformation[3].points)
        moved.plot(off_screen=True, screenshot=picture, show_edges=True, color="white", cpos="xy", zoom=5.0)


if __name__ == "__main__":
    main(*sys.argv[1:])

"""The paper's greedy algorithms in plain numpy, beside what azimesh finds: one point a sweep over all surface nodes.

    .venv/bin/python validation/paper_greedy.py [--folder target/paper]

Needs the mesh and the results of `validation/paper.py table2 table3` in the folder. Writes greedy.json there,
of which paper.py makes a section of validation/paper.md. Takes about 3 minutes on two cores and 1 GB of memory.
"""

import argparse
import json
from pathlib import Path

import numpy as np
import pyvista

from paper_runs import COLLECTIVE, PITCH_COS, PITCH_SIN

SUPPORT_RADIUS = 6.0
ONE_STEP_TOLERANCE = 5e-4
ONE_STEP_ANGLES = (20.0, 40.0)
MOST_POINTS = 1500


def surface(mesh):
    """Positions of the surface points (N, 3), coincident nodes once, and which of them are on the blade (N)."""
    grid = pyvista.read(mesh)
    tag = grid.cell_data["BoundaryTag"]
    starts = grid.cell_offsets[:-1]
    blade, both = (np.unique(grid.cell_connectivity[starts[cells][:, None] + np.arange(4)]) for cells in (tag == 1, tag > 0))
    points, first = np.unique(grid.points[both], axis=0, return_index=True)
    return points, np.isin(both[first], blade)


def turned(points, degrees):
    """Displacements by a rotation about the x axis (N, 3)."""
    angle = np.radians(degrees)
    _, y, z = points.T
    return np.stack([0 * y, y * np.cos(angle) - z * np.sin(angle) - y, y * np.sin(angle) + z * np.cos(angle) - z], axis=1)


def kernel(points, base):
    """Wendland C2 between points (N, 3) and one base point (3)."""
    xi = np.minimum(np.linalg.norm(points - base, axis=1) / SUPPORT_RADIUS, 1.0)
    return (1 - xi) ** 4 * (4 * xi + 1)


def greedy(points, target, tolerance, fields=()):
    """Points chosen until the largest error of `target` (N, 3) is at most the tolerance.

    Every point is that with the largest error over all surface points. The Newton basis takes the place of
    solving anew for each point. Returns the number of base points and the largest error that they leave in
    each of the `fields` (N, 3).
    """
    basis = np.empty((MOST_POINTS, len(points)))
    power = np.ones(len(points))
    errors = [np.array(field) for field in (target, *fields)]
    for n in range(MOST_POINTS):
        size = np.linalg.norm(errors[0], axis=1)
        worst = int(size.argmax())
        if size[worst] <= tolerance:
            return n, [float(np.linalg.norm(error, axis=1).max()) for error in errors[1:]]
        column = kernel(points, points[worst]) - basis[:n, worst] @ basis[:n]
        column /= np.sqrt(power[worst])
        for error in errors:
            error -= column[:, None] * (error[worst] / column[worst])
        power -= column**2
        basis[n] = column
    raise AssertionError(f"{tolerance} is not met with {MOST_POINTS} points")


def constant(moving, fields):
    """The target of Algorithm 2: the largest displacement in each direction, at every moving point."""
    return moving[:, None] * np.abs(np.stack(fields)).max(axis=(0, 1))


def compared(points, moving, fields, tolerance):
    """What both algorithms take for motions `fields`, each (N, 3), and by how much Algorithm 2 misses them."""
    real = [greedy(points, field, tolerance)[0] for field in fields]
    n, left = greedy(points, constant(moving, fields), tolerance, fields)
    return {"real": [min(real), max(real)], "constant": n, "constant_error": max(left)}


def main():
    """Runs both algorithms on the motions of tables 2 and 3."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, default=Path("target/paper"))
    folder = parser.parse_args().folder
    points, moving = surface(folder / "chord_blade.vtu")
    found = {"surface_points": len(points), "one_step": {}}
    for degrees in ONE_STEP_ANGLES:
        fields = [moving[:, None] * turned(points, degrees)]
        found["one_step"][f"rotation, {degrees:g} degrees"] = compared(points, moving, fields, ONE_STEP_TOLERANCE)
    pitch = [COLLECTIVE + PITCH_SIN * np.sin(psi) + PITCH_COS * np.cos(psi) for psi in np.radians(range(0, 360, 10))]
    fields = [moving[:, None] * turned(points, degrees) for degrees in pitch]
    runs = json.loads((folder / "table3.json").read_text())["runs"]
    hardest = {name: int(np.argmax(run["real"]["base_points"])) for name, run in runs.items()}
    found["revolution"] = {}
    for name in runs:
        real, _ = greedy(points, fields[hardest[name]], float(name))
        n, left = greedy(points, constant(moving, fields), float(name), fields)
        found["revolution"][name] = {"real": real, "constant": n, "constant_error": max(left)}
    (folder / "greedy.json").write_text(json.dumps(found))
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()

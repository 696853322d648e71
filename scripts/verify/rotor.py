"""Four blades in one mesh, carried round with the azimuth.

Blade k is where blade 1 will be after k - 1 quarter turns, every blade is where numpy puts it, and the whole mesh repeats
itself after a quarter turn to a hundredth of the displacement. No cell is inverted, by azimesh's count and by VTK.
"""

import numpy as np

import bending
import outputs
import reference
from program import azimesh, report, scratch

BLADES = 4
SIZE = ["--nodes", 40_000, "--first-cell", 1e-3]


def make(folder, step):
    """The mesh, and its schedule with steps of `step` degrees."""
    path = folder / "rotor.vtu"
    azimesh("sample", "rotor", "--blades", BLADES, *SIZE, "-o", path, "--force")
    schedule = folder / "rotor.toml"
    schedule.write_text(schedule.read_text().replace("step = 10.0", f"step = {step}"))
    return path, schedule


def blades(mesh):
    """Nodes of each blade; node i of one is node i of the next, a quarter of a turn on."""
    nodes = [np.unique([n for face in mesh.tags[f"blade_{k + 1}"] for n in face]) for k in range(BLADES)]
    for k in range(BLADES):
        turned = mesh.points[nodes[k]] @ reference.rotation([0, 0, 1], np.pi / 2).T
        assert np.abs(turned - mesh.points[nodes[(k + 1) % BLADES]]).max() < 1e-12
    return nodes


def asymmetry(nodes, before, after):
    """Largest differences of blades and of all nodes; `after` is the mesh a quarter of a turn after `before`."""
    surface = max(np.abs(after[nodes[k]] - before[nodes[(k + 1) % BLADES]]).max() for k in range(BLADES))
    ahead = np.roll(before, -(len(before) // BLADES), axis=0)
    return surface, np.linalg.norm(after - ahead, axis=1).max()


def main():
    """One revolution in steps of 15 degrees."""
    with scratch() as folder:
        path, schedule = make(folder, 15.0)
        mesh, grid = bending.read(path)
        rows = outputs.deform(path, schedule, folder / "out")
        motion = reference.Motion(schedule, mesh)
        bending.check_steps(rows, motion.schedule["selection"]["tolerance"])
        nodes, found, worst, least = blades(mesh), [], 0.0, 1.0
        points = [outputs.points(folder / "out", row) for row in rows]
        quarter = (len(rows) - 1) // 4
        for k in range(len(rows)):
            wanted = motion.carried(motion.step(k), k)
            worst = max(worst, *(np.abs(points[k][n] - wanted[n]).max() for n in nodes))
            least = min(least, bending.least_quality(grid, points[k]))
            if k >= quarter:
                found.append(asymmetry(nodes, points[k - quarter], points[k]))
    surface, volume = np.max(found, axis=0)
    note = f"a quarter of a turn later blades agree to {surface:.1e}, all nodes to {volume:.1e}"
    report("rotor", len(rows), worst, "steps", f"{note}; smallest scaled Jacobian {least:.3f}")
    assert len(rows) == 25 and len(found) == 19
    assert worst <= 1e-12 and surface <= 1e-12, (worst, surface)
    # In the volume the interpolant depends on the base points, which are not symmetric.
    largest = max(float(row["max_displacement"]) for row in rows)
    assert volume <= 0.01 * largest and least > 0.0, (volume, largest, least)

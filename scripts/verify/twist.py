"""Large rotations: an airfoil in a fixed circle turned by 120, 180 and 270 degrees in one step.

The mesh is made here, and its quadrilaterals are judged here.
"""

import numpy as np
import pyvista

import meshes
import outputs
from program import report, scratch

AROUND, OUTER = 256, 2.5
FIRST, GROWTH, LARGEST = 1e-5, 1.2, 0.03  # heights of the cells, in chords
ANGLES = [20, 40, 60, 90, 120, 180, 270]

SCHEDULE = """
azimuth = {{ start = 0.0, stop = 270.0, step = 10.0 }}
boundaries.fixed = ["farfield"]
selection.tolerance = 1e-4
output.on_inverted = "warn"

[rbf]
support_radius = 10.0
{keys}

[[body]]
name = "airfoil"
tags = ["airfoil"]
rigid = {{ rotate = {{ axis = [0.0, 0.0, 1.0], origin = [0.25, 0.0, 0.0], angle = 270.0 }}, ramp = true }}
"""

# In the ring between airfoil and circle a rotation is not interpolated, unless it has a radius of its own.
WAYS = {
    "displacement": 'interpolate = "displacement"', "interpolated": 'interpolate = "twist"\nrotation_radius = 10.0',
    "twist": 'interpolate = "twist"',
}  # fmt: skip


def heights():
    """Distances from the wall: growing from the first cell to the largest, then even; scaled to end on the circle."""
    steps = [FIRST]
    while sum(steps) < OUTER:
        steps.append(min(steps[-1] * GROWTH, LARGEST))
    total = np.concatenate([[0.0], np.cumsum(steps)])
    return total * OUTER / total[-1]


def ogrid():
    """Nodes (layers, around, 2) of an O-grid: a NACA 0012 with its quarter chord in the middle of a circle."""
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    x = 0.5 * (1 + np.cos(angle))
    half = 0.6 * (0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    wall = np.c_[x - 0.25, np.where(angle <= np.pi, half, -half)]
    along = np.roll(wall, -1, axis=0) - np.roll(wall, 1, axis=0)
    normal = np.c_[along[:, 1], -along[:, 0]] / np.linalg.norm(along, axis=1)[:, None]
    circle = OUTER * np.c_[np.cos(angle), np.sin(angle)]
    layers = []
    for height in heights():
        # Along the normal through the boundary layer, then straight to the circle.
        away = 0.02 * -np.expm1(-height / 0.02)
        part = (height - away) / (OUTER - 0.02)
        layers.append((1 - part) * (wall + away * normal) + part * circle)
    layers[-1] = circle
    return np.array(layers)


def write_su2(nodes, path):
    """The O-grid as SU2, with the tags airfoil and farfield."""
    layers, around, _ = nodes.shape
    index = np.arange(layers * around).reshape(layers, around)
    after = np.roll(index, -1, axis=1)
    cells = np.stack([index[:-1], index[1:], after[1:], after[:-1]], axis=-1).reshape(-1, 4)
    tags = {tag: list(zip(index[layer], after[layer])) for tag, layer in (("airfoil", 0), ("farfield", -1))}
    meshes.write_su2(path, nodes.reshape(-1, 2), cells, tags)
    return cells


def scaled_jacobian(points, quads):
    """Least sine of a corner of each quadrilateral, counter-clockwise ones positive."""
    x = points[quads]
    ahead, back = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
    cross = ahead[..., 0] * back[..., 1] - ahead[..., 1] * back[..., 0]
    return (cross / (np.linalg.norm(ahead, axis=2) * np.linalg.norm(back, axis=2))).min(axis=1)


def turned(folder, way):
    """Rows of steps.csv by angle, each with the points, the least scaled Jacobian and the inverted cells found here."""
    mesh, schedule = folder / "ogrid.su2", folder / f"{way}.toml"
    quads = write_su2(ogrid(), mesh)
    schedule.write_text(SCHEDULE.format(keys=WAYS[way]))
    rows = outputs.deform(mesh, schedule, folder / way, expect=(0, 1))
    found = {}
    for row in rows:
        angle = round(float(row["azimuth_deg"]))
        if angle in [0, *ANGLES]:
            points = np.array(pyvista.read(folder / way / row["file"]).points)
            quality = scaled_jacobian(points, quads)
            found[angle] = row | {"points": points, "least": quality.min(), "folded": int((quality <= 0).sum())}
    return found


def by_logarithm(points, angle):
    """The nodes turned about the middle of the chord: as the airfoil within its radius, falling with log r to the circle."""
    middle = np.array([0.25, 0.0, 0.0])
    arms = points - middle
    radii = np.hypot(arms[:, 0], arms[:, 1])
    inner, outer = radii[:AROUND].max(), radii[-AROUND:].min()
    part = np.clip(np.log(np.clip(radii, 1e-300, None) / inner) / np.log(outer / inner), 0, 1)
    weight = np.where(part < 0.5, 1 - 4 / 3 * part**2, 4 / 3 * (1 - part))
    turns = np.exp(1j * np.radians(angle) * weight) * (arms[:, 0] + 1j * arms[:, 1])
    return middle + np.c_[turns.real, turns.imag, arms[:, 2]]


def main():
    """Twist leaves no cell inverted, displacement many, and azimesh counts them alike."""
    with scratch() as folder:
        twist, interpolated, displacement = (turned(folder, way) for way in ("twist", "interpolated", "displacement"))
    off = 0.0
    for row in [*twist.values(), *interpolated.values(), *displacement.values()]:
        assert row["folded"] == int(row["inverted"]), f"{row['inverted']} inverted cells, here {row['folded']}"
        if row["folded"] == 0:  # of folded cells VTK's definition, which azimesh follows, is another one
            off = max(off, abs(row["least"] - float(row["min_scaled_jacobian"])))
    for angle, row in twist.items():
        off = max(off, np.abs(row["points"] - by_logarithm(twist[0]["points"], angle)).max())
    least = ", ".join(f"{angle}: {twist[angle]['least']:.3f}" for angle in ANGLES)
    report("twist", len(twist) + len(interpolated) + len(displacement), off, "steps", f"least scaled Jacobian by degrees: {least}")
    assert off <= 1e-9
    for found in (twist, interpolated):
        assert all(row["folded"] == 0 for row in found.values()), "twist has folded cells"
    assert displacement[120]["folded"] > 0 and displacement[180]["folded"] > 0

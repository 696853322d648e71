"""A blade that bends, like that of HART II, through one revolution in both frames.

Nodes of the blade are where numpy puts them by equations 2, 3 and 11, about a lifting line that is found here; the outer
boundary stays; the tolerance holds; no cell is inverted by azimesh's count or by VTK's scaled Jacobian.
"""

import csv

import numpy as np
import pyvista
from scipy.spatial.distance import pdist, squareform

import meshes
import outputs
import reference
from program import TESTDATA, report, scratch

FRAMES = ("rotating", "inertial")
NEAR = 0.05  # part of the span inside its ends at which the chord is taken
CAP = 0.1  # part of that chord by which the outermost sections lie inside, as the ends are rounded


def read(path):
    """Nodes and boundary tags of a VTU, as `reference` wants them, and the grid itself."""
    grid = pyvista.read(path)
    names = list(grid.field_data["BoundaryTagNames"])
    tag, faces = np.array(grid.cell_data["BoundaryTag"]), {}
    for number, name in enumerate(names, start=1):
        cells = grid.extract_cells(np.flatnonzero(tag == number))
        original = np.array(cells.point_data["vtkOriginalPointIds"])
        faces[name] = [original[cell] for cell in cells.cells_dict[next(iter(cells.cells_dict))]]
    mesh = meshes.Mesh(np.array(grid.points, float), tags=faces)
    mesh.cells[3] = [None]
    return mesh, grid


def quarter_chord(points, faces, stations):
    """Rows station, x, y, z: a quarter of the longest extent of each section behind its leading edge; straight on at the ends."""
    faces = np.array(faces)
    edges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    low, high = points[np.unique(faces), 0].min(), points[np.unique(faces), 0].max()

    def chord(r):
        cut = (np.minimum(a[:, 0], b[:, 0]) <= r) & (r <= np.maximum(a[:, 0], b[:, 0])) & (a[:, 0] != b[:, 0])
        part = (r - a[cut, 0]) / (b[cut, 0] - a[cut, 0])
        section = a[cut] + part[:, None] * (b[cut] - a[cut])
        far = squareform(pdist(section))
        ends = section[list(np.unravel_index(far.argmax(), far.shape))]
        return ends[np.argsort(-ends[:, 1])]

    def row(r):
        nose, tail = chord(r)
        return np.array([r, *(nose + 0.25 * (tail - nose))])

    inward = []
    for end, sign in [(low, 1), (high, -1)]:
        length = np.linalg.norm(np.subtract(*chord(end + sign * NEAR * (high - low))))
        inward.append(sign * np.clip(CAP * length, 1e-3 * (high - low), 0.5 * NEAR * (high - low)))
    first, last = low + inward[0], high + inward[1]
    inside = [*stations, first + inward[0], last + inward[1]]
    rows = [row(r) for r in sorted({first, last, *[r for r in inside if first < r < last]})]
    return [2 * row(first) - row(first + inward[0]), *rows, 2 * row(last) - row(last + inward[1])]


def motion_of(schedule, mesh, folder):
    """The motion as `reference` has it, about the lifting line found here."""
    motion = reference.Motion(schedule, mesh)
    beam = motion.schedule["body"][0]["beam"]
    rows = quarter_chord(mesh.points, mesh.tags["blade"], np.unique(reference.read_table(motion.folder / beam["table"])["station"]))
    line = folder / "quarter_chord.csv"
    with open(line, "w", newline="") as file:
        csv.writer(file).writerows([["station", "x", "y", "z"], *[map(repr, map(float, row)) for row in rows]])
    beam["lifting_line"] = str(line.resolve())
    return motion


def off(motion, k, points):
    """Largest distances at step k of the blade's nodes from where they should be, and of the fixed ones."""
    wanted = motion.carried(motion.step(k), k)
    distance = np.linalg.norm(points - wanted, axis=1)
    return max(distance[nodes].max() for _, nodes in motion.moving), distance[motion.fixed].max()


def least_quality(grid, points):
    """The smallest scaled Jacobian of the volume cells, by VTK."""
    moved = grid.copy()
    moved.points = points
    volume = moved.extract_cells(np.flatnonzero(np.array(moved.cell_data["BoundaryTag"]) == 0))
    return float(np.min(volume.cell_quality("scaled_jacobian")["scaled_jacobian"]))


def check_steps(rows, tolerance):
    """The tolerance and the surfaces hold at every step, and no cell is inverted."""
    for row in rows:
        assert float(row["selection_error"]) <= tolerance, row
        assert float(row["max_surface_error"]) <= 0.01 * tolerance, row
        assert int(row["inverted"]) == 0, row


def revolution(folder, frame, mesh, grid):
    """(steps, largest distance of a node of the blade, smallest quality by VTK)."""
    schedule = folder / f"{frame}.toml"
    text = (TESTDATA / "hart_ii.toml").read_text()
    schedule.write_text(text.replace("[rotor]", f'[rotor]\nframe = "{frame}"'))
    (folder / "hart_ii_beam.csv").write_text((TESTDATA / "hart_ii_beam.csv").read_text())
    rows = outputs.deform(TESTDATA / "hart_ii.vtu", schedule, folder / frame)
    motion = motion_of(schedule, mesh, folder)
    check_steps(rows, motion.schedule["selection"]["tolerance"])
    worst, least = 0.0, 1.0
    for k, row in enumerate(rows):
        points = outputs.points(folder / frame, row)
        blade, fixed = off(motion, k, points)
        # What is carried round is turned here and there in another order.
        assert fixed <= (1e-14 if frame == "inertial" else 0.0), fixed
        worst = max(worst, blade)
        least = min(least, least_quality(grid, points))
    assert len(rows) == 25 and least > 0.0, (len(rows), least)
    return len(rows), worst, least


def main():
    """Every 15 degrees, rotating and inertial."""
    mesh, grid = read(TESTDATA / "hart_ii.vtu")
    with scratch() as folder:
        found = [revolution(folder, frame, mesh, grid) for frame in FRAMES]
    steps, worst = sum(n for n, _, _ in found), max(worst for _, worst, _ in found)
    least = min(least for _, _, least in found)
    report("bending", steps, worst, "steps", f"smallest scaled Jacobian {least:.3f}")
    assert worst <= 1e-12

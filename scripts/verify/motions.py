"""Every motion against an independent evaluation of its formulas, on random parameters.

Moving nodes of the written meshes are where numpy puts them, to 1e-12 of the largest displacement.
"""

import numpy as np

import meshes
import outputs
import reference
from program import TESTDATA, report, scratch

REST = """
[boundaries]
others = "{others}"
[rbf]
support_radius = {radius}
[selection]
tolerance = 1e-2
"""
AXES = ("dx", "dy", "dz", "rot_x_deg", "rot_y_deg", "rot_z_deg")


def numbers(random, size, n):
    """n random numbers up to `size`, as TOML and CSV have them."""
    return [float(value) for value in random.uniform(-size, size, n)]


def harmonic(random, size):
    """One harmonic of an angle up to `size` degrees."""
    sin, cos = numbers(random, size, 2)
    return f"[{{ sin = {sin}, cos = {cos} }}]"


def airfoil(random, folder, _mesh):
    """In the plane: a table over time with cubic interpolation, then pitch, without a rotor."""
    times = np.linspace(0.0, 2.0, 7)
    columns = {name: numbers(random, size, 7) for name, size in (("dx", 0.1), ("dy", 0.1), ("rot_z_deg", 5))}
    outputs.write_table(folder / "heave.csv", {"time_s": times} | columns)
    return f"""
time = {{ stop = 1.9, step = 0.38, frequency = 0.7 }}
[[body]]
name = "airfoil"
tags = ["airfoil"]
azimuth_offset = {numbers(random, 90, 1)[0]}
table = {{ file = "heave.csv", origin = {[*numbers(random, 0.5, 2), 0.0]}, interpolation = "cubic" }}
cyclic = {{ collective = 2.0, pitch = {harmonic(random, 4.0)}, pitch_axis = [-0.25, 0.0] }}
"""


def ball(random, folder, _mesh):
    """In space: rigid and a table over several revolutions, inertial frame."""
    azimuths = np.arange(0, 360, 45.0)
    columns = {name: numbers(random, 0.1 if "d" == name[0] else 8.0, 8) for name in AXES}
    outputs.write_table(folder / "free.csv", {"azimuth_deg": azimuths} | columns)
    return f"""
azimuth.values = [0.0, 33.0, 350.0, 725.5]
rotor = {{ frame = "inertial", hub = {numbers(random, 0.3, 3)} }}
[[body]]
name = "ball"
tags = ["sphere"]
azimuth_offset = {numbers(random, 90, 1)[0]}
rigid = {{ rotate = {{ axis = {numbers(random, 1, 3)}, angle = 7.0 }}, translate = {numbers(random, 0.1, 3)}, ramp = true }}
table = {{ file = "free.csv", origin = {numbers(random, 0.2, 3)}, interpolation = "{random.choice(["linear", "cubic"])}" }}
"""


def beam_table(random, folder, stations):
    """Unsorted rows over azimuth and station, and a lifting line."""
    rows = [(psi, r) for psi in np.arange(0, 360, 40.0) for r in stations]
    rows = [rows[i] for i in random.permutation(len(rows))]
    columns = {"azimuth_deg": [psi for psi, _ in rows], "station": [r for _, r in rows]}
    columns |= {name: numbers(random, 0.05 if "d" == name[0] else 6.0, len(rows)) for name in AXES}
    outputs.write_table(folder / "beam.csv", columns)
    line = {axis: numbers(random, 0.1, 3) for axis in "xyz"}
    at = np.linspace(stations[0], stations[-1], 3)
    line["x"] = [float(x + r) for x, r in zip(line["x"], at)]
    outputs.write_table(folder / "line.csv", {"station": at} | line)
    kind = random.choice(["linear", "cubic"])
    return f'beam = {{ table = "beam.csv", lifting_line = "line.csv", interpolation = "{kind}", hold_ends = true }}'


def blade(random, folder, _mesh):
    """A bending blade with pitch, flap and lag whose hub is another body, its parent."""
    offset = numbers(random, 15, 1)[0]
    return f"""
azimuth.values = [0.0, 95.0, 250.0, 400.0]
rotor.flap_sign = -1
[[body]]
name = "hub"
tags = ["hub_wall"]
rigid = {{ translate = {numbers(random, 0.02, 3)} }}
[[body]]
name = "blade"
tags = ["blade"]
parent = "hub"
azimuth_offset = {offset}
{beam_table(random, folder, [0.0, 0.7, 1.1, 1.6])}
[body.cyclic]
collective = 3.0
pitch = {harmonic(random, 4.0)}
coning = 1.0
flap = {harmonic(random, 2.0)}
lag = {harmonic(random, 1.0)}
flap_hinge = 0.1
"""


def wing(random, folder, _mesh):
    """A beam alone, spanwise along z from a plane of symmetry that stays."""
    return f"""
time = {{ stop = 1.0, step = 0.25, frequency = 1.5 }}
rotor = {{ span_axis = [0, 0, 1], shaft_axis = [0, 1, 0] }}
[[body]]
name = "wing"
tags = ["wing"]
{beam_table(random, folder, [0.0, 1.0, 2.0])}
"""


def nodal(random, folder, mesh):
    """Displacements of nodes for every step, modes over azimuth, then pitch."""
    nodes = sorted({node for face in mesh.tags["sphere"] for node in face})
    lines = ["azimuth_deg,node,dx,dy,dz"]
    for azimuth in (0.0, 40.0, 100.0):
        rows = [[azimuth, int(node), *numbers(random, 0.02, 3)] for node in nodes]
        lines += [",".join(map(repr, row)) for row in rows]
    (folder / "surface.csv").write_text("\n".join(lines) + "\n")
    lines = ["mode,node,dx,dy,dz"]
    lines += [",".join(map(repr, [j, int(node), *numbers(random, 0.1, 3)])) for j in (1, 2, 3) for node in nodes]
    (folder / "modes.csv").write_text("\n".join(lines) + "\n")
    columns = {f"q{j}": numbers(random, 1.0, 6) for j in (1, 2, 3)}
    outputs.write_table(folder / "q.csv", {"azimuth_deg": np.arange(0, 360, 60.0)} | columns)
    kind = random.choice(["linear", "cubic"])
    return f"""
azimuth.values = [0.0, 40.0, 100.0]
[[body]]
name = "ball"
tags = ["sphere"]
surface = {{ file = "surface.csv" }}
modes = {{ shapes = "modes.csv", coordinates = "q.csv", interpolation = "{kind}" }}
cyclic = {{ collective = 3.0, pitch = {harmonic(random, 4.0)}, coning = 2.0 }}
"""


CASES = [
    (nodal, "sphere_in_box_raw.vtu", "fixed", 3.0), (airfoil, "naca0012.vtu", "fixed", 6.0), (ball, "sphere_in_box_raw.vtu", "fixed", 3.0),
    (blade, "rotor_sector.vtu", "free", 3.0), (wing, "wing_on_plane.vtu", "fixed", 4.0),
]  # fmt: skip


def check(make, name, others, radius, seed):
    """(nodes compared, largest difference relative to the largest displacement)."""
    random = np.random.default_rng(seed)
    mesh = meshes.by_pyvista(TESTDATA / name)
    with scratch() as folder:
        schedule = folder / "motion.toml"
        schedule.write_text(make(random, folder, mesh) + REST.format(others=others, radius=radius))
        # Random motions may invert cells: exit code 1.
        rows = outputs.deform(TESTDATA / name, schedule, folder / "out", expect=(0, 1))
        motion = reference.Motion(schedule, mesh)
        nodes = np.concatenate([nodes for _, nodes in motion.moving])
        largest = moved = 0.0
        for k, row in enumerate(rows):
            target = motion.step(k)
            wanted = motion.carried(target, k)
            found = outputs.points(folder / "out", row)
            largest = max(largest, np.linalg.norm(found[nodes] - wanted[nodes], axis=1).max())
            moved = max(moved, np.linalg.norm(target - mesh.points, axis=1).max())
    return len(rows) * len(nodes), largest / moved


def main():
    """Three random motions of each kind."""
    for make, name, others, radius in CASES:
        checks = [check(make, name, others, radius, seed) for seed in (1, 2, 3)]
        n, largest = sum(n for n, _ in checks), max(largest for _, largest in checks)
        report(f"motions, {make.__name__}", n, largest, "positions", "of the largest displacement")
        assert largest <= 1e-12, f"{make.__name__}: off by {largest} of the largest displacement"

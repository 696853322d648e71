"""A displacement file by node id against a dense RBF solution in numpy, in 2D and 3D; node velocities.

With method "all" every node of the mesh is where numpy's solution puts it, to 1e-10 (or 100 eps times the
condition number). Velocities are the central differences of the meshes before and after.
"""

import numpy as np
import pyvista

import meshes
import outputs
import reference
from program import TESTDATA, report, scratch

CASES = [("naca0012.vtu", "airfoil", 6.0), ("sphere_in_box_raw.vtu", "sphere", 2.5)]
SURFACE = """
azimuth.values = [0]
boundaries.others = "fixed"
body = [ {{ name = "body", tags = ["{tag}"], surface = {{ file = "surface.csv" }} }} ]
rbf = {{ support_radius = {radius}, kernel = "wendland-c0" }}
selection.method = "all"
"""
H = 1e-4
VELOCITY = """
time = {{ values = [{before}, 0.4, {after}], frequency = 0.7 }}
rotor = {{ hub = [0.25, 0.0, 0.0]{frame} }}
boundaries.others = "fixed"
rbf.support_radius = {radius}
selection.tolerance = 1e-4
output.velocity = true
[[body]]
name = "body"
tags = ["{tag}"]
cyclic = {{ collective = 3.0, pitch = [ {{ sin = 6.0, cos = -2.0 }} ] }}
table = {{ file = "heave.csv", interpolation = "cubic" }}
"""


def dense(name, tag, radius):
    """(nodes compared, largest difference, its bound)."""
    mesh = meshes.by_pyvista(TESTDATA / name)
    with scratch() as folder:
        schedule = folder / "surface.toml"
        # Random displacements invert cells, which are to stay so.
        schedule.write_text('output.on_inverted = "warn"\n' + SURFACE.format(tag=tag, radius=radius))
        motion = reference.Motion(schedule, mesh)
        (_, nodes), = motion.moving
        random = np.random.default_rng(5)
        moved = 0.03 * random.standard_normal((len(nodes), 3))
        if mesh.dimension == 2:
            moved[:, 2] = 0.0
        order = random.permutation(len(nodes))
        rows = [",".join(map(repr, [int(nodes[i]), *map(float, moved[i])])) for i in order]
        (folder / "surface.csv").write_text("node,dx,dy,dz\n" + "\n".join(rows) + "\n")
        (row,) = outputs.deform(TESTDATA / name, schedule, folder / "out", expect=(0, 1))
        found = outputs.points(folder / "out", row)
    target = mesh.points.copy()
    target[nodes] += moved
    interpolant = reference.Interpolant(motion, motion.distinct_surface_nodes())
    wanted = mesh.points + interpolant.displacements(np.arange(len(mesh.points)), target)
    bound = max(1e-10, 100 * np.finfo(float).eps * interpolant.condition())
    return len(found), np.abs(found - wanted).max(), bound


def velocities(name, tag, radius):
    """(nodes compared, largest difference relative to the largest velocity)."""
    plane = meshes.by_pyvista(TESTDATA / name).dimension == 2
    with scratch() as folder:
        schedule = folder / "velocity.toml"
        text = VELOCITY.format(before=0.4 - H, after=0.4 + H, frame="" if plane else ', frame = "inertial"', radius=radius, tag=tag)
        schedule.write_text(text)
        (folder / "heave.csv").write_text("time_s,dy,rot_z_deg\n0,0,0\n0.3,0.1,5\n0.7,-0.1,2\n1,0.05,-4\n")
        rows = outputs.deform(TESTDATA / name, schedule, folder / "out", expect=(0, 1))
        before, _, after = (outputs.points(folder / "out", row) for row in rows)
        found = np.array(pyvista.read(folder / "out" / rows[1]["file"]).point_data["Velocity"])
    wanted = (after - before) / (2 * H)
    return len(found), np.abs(found - wanted).max() / np.abs(wanted).max()


def main():
    """One line a mesh and a property."""
    for name, tag, radius in CASES:
        n, largest, bound = dense(name, tag, radius)
        report(f"surface, {name}", n, largest, "positions", f"bound {bound:.1e}")
        assert largest <= bound, f"{name}: {largest} exceeds {bound}"
        n, largest = velocities(name, tag, radius)
        report(f"velocity, {name}", n, largest, "velocities", "of the largest, against differences")
        assert largest <= 1e-5, f"{name}: velocities are off by {largest}"

"""A flap turned down on a real mesh: the three-element airfoil of amovemesh, one step from the reference mesh.

Needs the folder that AZIMESH_TESTDATA names. The mesh has no boundary elements: `convert --tag-boundary connected` makes
tags. Every triangle is judged here, and the boundary's nodes are compared with those of amovemesh's own result.
"""

import sys

import numpy as np
import pyvista

import meshes
import outputs
import twist
from program import azimesh, real_meshes, report, scratch

MESH = "Slaedr__amovemesh/input/wing.msh"
OTHER = "Slaedr__amovemesh/src/RBF/wing-rbf--60-sr15-steps6.msh"
EQUILATERAL = 2 / np.sqrt(3)  # the scaled Jacobian is 1 there
HINGE = [19.20097919, 0.26911592, 0.0]  # of OTHER: found as the centre of its turned nodes

SCHEDULE = """
azimuth = {{ stop = {angle}, step = {step} }}
body = [ {{ name = "flap", tags = ["{flap}"], rigid = {{ rotate = {{ axis = [0, 0, 1], origin = {hinge}, angle = {down} }}, ramp = true }} }} ]
boundaries.others = "fixed"
output.on_inverted = "warn"
{rest}
"""

# What is said under [rbf], and an angle that it reaches.
WAYS = {
    "default": ("", 60),
    "substeps": ("rbf.substeps = 2", 90),
    "twist": ('rbf = { interpolate = "twist", kernel = "wendland-c0", support_radius = 40.0 }', 90),
}


def prepare(folder):
    """The mesh with tags: its path, nodes, triangles and the names of the flap's tag."""
    path = folder / "wing.vtu"
    azimesh("convert", real_meshes() / MESH, path, "--tag-boundary", "connected")
    grid = pyvista.read(path)
    points, triangles = np.array(grid.points)[:, :2], grid.cells_dict[5]
    assert (twist.scaled_jacobian(points, triangles) > 0).all()
    mesh = meshes.by_pyvista(path)
    nodes = {name: outputs.tagged(mesh, name) for name in mesh.tags}
    # The flap begins behind the main element.
    flap = [name for name in nodes if points[nodes[name], 0].min() > 19.0]
    assert len(nodes) == 4 and len(flap) == 1, nodes.keys()
    return path, points, triangles, nodes, flap[0]


def turn(folder, mesh, flap, rest, angle, step, name="run"):
    """The flap turned down by `step`, 2 `step`, ... up to `angle`: rows of steps.csv and the folder."""
    schedule = folder / f"{name}.toml"
    schedule.write_text(SCHEDULE.format(angle=angle, step=step, flap=flap, hinge=HINGE, down=-angle, rest=rest))
    return outputs.deform(mesh, schedule, folder / name, expect=(0, 1)), folder / name


def main():
    """Down by as much as each way of interpolating is known to reach, without an inverted triangle."""
    if real_meshes() is None:
        print("flap: SKIPPED, AZIMESH_TESTDATA is not set", file=sys.stderr, flush=True)
        return
    found = {}
    with scratch() as folder:
        mesh, points, triangles, nodes, flap = prepare(folder)
        other = meshes.by_meshio(real_meshes() / OTHER).points[:, :2]
        off = 0.0
        for way, (rest, angle) in WAYS.items():
            rows, out = turn(folder, mesh, flap, rest, angle, 15, way)
            for row in rows:
                moved = outputs.points(out, row)[:, :2]
                quality = EQUILATERAL * twist.scaled_jacobian(moved, triangles)
                assert int(row["inverted"]) == (quality <= 0).sum() == 0, (way, row)
                assert abs(quality.min() - float(row["min_scaled_jacobian"])) < 1e-9, (way, row)
                if float(row["azimuth_deg"]) == 60.0:
                    off = max(off, *(np.abs(moved[of] - other[of]).max() for of in nodes.values()))
                    found[way] = quality.min()
    note = ", ".join(f"{way} {least:.3f}" for way, least in found.items())
    note = f"least scaled Jacobian at 60 degrees: {note}, amovemesh {EQUILATERAL * twist.scaled_jacobian(other, triangles).min():.3f}"
    report("flap", len(WAYS) * sum(map(len, nodes.values())), off, "boundary nodes", note)
    assert off < 2e-4  # their files have six digits

"""Base points and what they do at every node, against dense numpy: 2D, 3D and mixed cells, surfaces in space and clouds of points.

`method = "all"`: every node of every step by a dense solve. `"sequence"`: the base points that azimesh has chosen, with the error that it reports, and
surfaces exactly where the motion puts them. The .pvd of a run has each step with its time. The surface (SU2 without volume cells, whose markers are
tags) and the cloud (vertex cells) have all nodes of a solid mesh in its order, so that numpy works on that.
"""

import tomllib
from dataclasses import dataclass, replace

import meshes
import numpy as np
import outputs
import pyvista
import reference
from program import TESTDATA, report, scratch

AIRFOIL = """
azimuth = { start = 0.0, stop = 360.0, step = 60.0 }
boundaries.fixed = ["farfield"]
rbf = { kernel = "wendland-c2", support_radius = 4.0 }

[[body]]
name = "airfoil"
tags = ["airfoil"]
cyclic = { collective = 4.0, pitch = [{ sin = -7.65, cos = -0.96 }, { sin = 1.5, cos = 0.5 }], pitch_axis = [-0.25, 0.01], phase = 12.0 }
"""

SPHERE = """
azimuth.values = [0.0, 45.0, 170.0, 290.5]
rotor = { hub = [-0.7, 0.1, 0.05], frame = "inertial", flap_sign = -1 }
boundaries = { fixed = ["inlet", "outlet"], others = "fixed" }
rbf = { kernel = "wendland-c4", support_radius = 2.5 }

[[body]]
name = "ball"
tags = ["sph*"]
azimuth_offset = 90.0
rigid = { ramp = true, rotate = { axis = [0.0, 1.0, 1.0], origin = [0.1, 0.0, 0.0], angle = 25.0 }, translate = [0.05, -0.02, 0.1] }

[body.cyclic]
collective = 6.0
pitch = [{ sin = -5.0, cos = 2.0 }]
coning = 2.0
flap = [{ sin = 3.0, cos = -0.4 }, { sin = 0.5, cos = 0.25 }]
lag = [{ sin = 1.0, cos = 0.3 }]
pitch_axis = [0.1, -0.05]
flap_hinge = 0.2
"""

MIXED = """
azimuth = { start = 0.0, stop = 270.0, step = 90.0 }
rotor.hub = [0.0, 0.5, 0.0]
boundaries = { fixed = ["roof"], others = "free" }
rbf = { kernel = "wendland-c0", support_radius = 3.0 }

[[body]]
name = "floor"
tags = ["floor"]
cyclic = { collective = 3.0, pitch = [{ sin = 4.0, cos = 1.0 }], coning = 1.0, flap = [{ sin = 1.5, cos = 0.5 }] }
"""

SELECTION = """
[selection]
method = "{method}"
{extra}
"""


@dataclass
class Case:
    """A mesh of testdata and a schedule for it, complete but for the selection."""

    name: str
    mesh: object
    schedule: str
    tolerance: float
    solid: object = None  # a mesh with the same nodes and tags that numpy reads in its place

    def write(self, folder, method):
        """Writes the schedule with a selection method into `folder`."""
        extra = f"tolerance = {self.tolerance}" if method == "sequence" else ""
        path = folder / f"{self.name}.toml"
        path.write_text(self.schedule + SELECTION.format(method=method, extra=extra))
        return path


CASES = [
    Case("airfoil", TESTDATA / "airfoil_hybrid_raw_lz4.vtu", AIRFOIL, 1e-3), Case("sphere", TESTDATA / "sphere_in_box_raw.vtu", SPHERE, 5e-3),
    Case("mixed", TESTDATA / "mixed_cells_inline.vtu", MIXED, 5e-3),
]  # fmt: skip


def base_nodes(folder, mesh):
    """The mesh nodes that base.vtp holds, matched by their exact position."""
    base = np.array(pyvista.read(folder / "base.vtp").points)
    at = {tuple(point): node for node, point in reversed(list(enumerate(mesh.points.tolist())))}
    nodes = np.array([at[tuple(point)] for point in base.tolist()])
    assert len(np.unique(nodes)) == len(nodes), "base.vtp holds a point twice"
    tomllib.loads((folder / "base.toml").read_text())
    return nodes


def check_all(case, folder):
    """Every node of every step, relative to the largest displacement."""
    mesh, schedule = meshes.by_pyvista(case.solid or case.mesh), case.write(folder, "all")
    rows = outputs.deform(case.mesh, schedule, folder / case.name)
    motion = reference.Motion(schedule, mesh)
    assert np.allclose([float(row["azimuth_deg"]) for row in rows], motion.azimuths(), rtol=0, atol=1e-9), "other steps"
    interpolant = reference.Interpolant(motion, motion.distinct_surface_nodes())
    everywhere = np.arange(len(mesh.points))
    difference, displacement = 0.0, 0.0
    for k, row in enumerate(rows):
        moved = interpolant.displacements(everywhere, motion.step(k))
        wanted = motion.carried(mesh.points + moved, k)
        difference = max(difference, np.linalg.norm(outputs.points(folder / case.name, row) - wanted, axis=1).max())
        displacement = max(displacement, np.linalg.norm(moved, axis=1).max())
    largest, condition = difference / displacement, interpolant.condition()
    report(f"{case.name}, all points", len(rows) * len(everywhere), largest, "nodes", f"cond(Phi) {condition:.2e}")
    assert largest <= max(1e-10, 100 * np.finfo(float).eps * condition), f"{case.name}: off by {largest}"


def check_sequence(case, folder):
    """Reported errors, relative to the tolerance: the truncation of modes may change a figure by 0.01 of it."""
    mesh, schedule = meshes.by_pyvista(case.solid or case.mesh), case.write(folder, "sequence")
    out = folder / case.name
    rows = outputs.deform(case.mesh, schedule, out)
    motion = reference.Motion(schedule, mesh)
    base = base_nodes(out, mesh)
    interpolant, surface, largest = reference.Interpolant(motion, base), motion.surface_nodes(), 0.0
    for k, row in enumerate(rows):
        target = motion.step(k)
        error = np.linalg.norm(interpolant.displacements(surface, target) - (target - mesh.points)[surface], axis=1).max()
        assert int(row["base_points"]) == len(base), f"{row['base_points']} in steps.csv, {len(base)} in base.vtp"
        assert error <= case.tolerance * (1 + 1e-9), f"step {k}: error {error} exceeds {case.tolerance}"
        largest = max(largest, abs(error - float(row["selection_error"])) / case.tolerance)
        check_surface(motion, target, outputs.points(out, row), k)
    report(f"{case.name}, sequence", len(rows), largest, "error figures", f"of the tolerance; {len(base)} base points")
    assert largest <= 0.01, f"{case.name}: selection_error is off by {largest} of the tolerance"
    check_pvd(out, rows)


def check_surface(motion, target, found, k):
    """Moving nodes to 1e-12 of the mesh's size; fixed ones bit for bit unless all is carried round."""
    points, wanted, surface = motion.mesh.points, motion.carried(target, k), motion.surface_nodes()
    off = np.linalg.norm(found[surface] - wanted[surface], axis=1).max()
    assert off <= 1e-12 * np.linalg.norm(np.ptp(points, axis=0)), f"step {k}: a surface node is off by {off}"
    if not motion.inertial:
        meshes.assert_same_points(found[motion.fixed], points[motion.fixed], f"fixed nodes at step {k}")


def check_pvd(out, rows):
    """VTK's PVD reader has every step with its time and its nodes."""
    reader = pyvista.PVDReader(str(next(out.glob("*.pvd"))))
    times = [float(row["time_s"] or row["azimuth_deg"]) for row in rows]
    assert np.allclose(reader.time_values, times, rtol=0, atol=1e-9), f"{reader.time_values}, not {times}"
    for time, row in zip(reader.time_values, rows, strict=True):
        reader.set_active_time_value(time)
        assert np.array_equal(reader.read()[0].points, outputs.points(out, row)), f"{row['file']} differs"


def write_cloud(mesh, path):
    """Vertex cells: one for each node, and one for each node of each tag."""
    nodes, tags = [np.arange(len(mesh.points))], [np.zeros(len(mesh.points), int)]
    for number, tag in enumerate(mesh.tags, 1):
        nodes.append(outputs.tagged(mesh, tag))
        tags.append(np.full(len(nodes[-1]), number))
    nodes = np.concatenate(nodes)
    cells = np.column_stack([np.ones_like(nodes), nodes]).ravel()
    grid = pyvista.UnstructuredGrid(cells, np.full(len(nodes), pyvista.CellType.VERTEX), mesh.points)
    grid.cell_data["BoundaryTag"] = np.concatenate(tags).astype(np.int32)
    grid.field_data["BoundaryTagNames"] = np.array(list(mesh.tags))
    grid.save(path)


def main():
    """Two lines a mesh."""
    solid = next(case for case in CASES if case.name == "sphere")
    mesh = meshes.by_pyvista(solid.mesh)
    solid = replace(solid, schedule=solid.schedule + '\n[output]\nformat = "vtu"\n', solid=solid.mesh)
    with scratch() as folder:
        meshes.write_su2(folder / "surface.su2", mesh.points, [], {name: sorted(faces) for name, faces in mesh.tags.items()}, 3)
        write_cloud(mesh, folder / "cloud.vtu")
        for case in [*CASES, *(replace(solid, name=name.split(".")[0], mesh=folder / name) for name in ("surface.su2", "cloud.vtu"))]:
            for check in (check_all, check_sequence):
                with scratch() as out:
                    check(case, out)

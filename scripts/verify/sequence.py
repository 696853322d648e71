"""selection "sequence": the reported error, and surfaces exactly where the motion puts them.

Reads the base points that azimesh has chosen and solves with numpy on those.
"""

import tomllib

import numpy as np
import pyvista

import meshes
import outputs
import reference
from cases import CASES
from program import report, scratch


def base_nodes(folder, mesh):
    """The mesh nodes that base.vtp holds, matched by their exact position."""
    base = np.array(pyvista.read(folder / "base.vtp").points)
    at = {tuple(point): node for node, point in reversed(list(enumerate(mesh.points.tolist())))}
    nodes = np.array([at[tuple(point)] for point in base.tolist()])
    assert len(np.unique(nodes)) == len(nodes), "base.vtp holds a point twice"
    tomllib.loads((folder / "base.toml").read_text())
    return nodes


def check(case, folder):
    """(figures compared, largest difference of an error figure relative to the tolerance, base points)."""
    mesh = meshes.by_pyvista(case.solid or case.mesh)
    schedule = case.write(folder, "sequence")
    rows = outputs.deform(case.mesh, schedule, folder / case.name)
    motion = reference.Motion(schedule, mesh)
    base = base_nodes(folder / case.name, mesh)
    interpolant = reference.Interpolant(motion, base)
    surface = motion.surface_nodes()
    largest = 0.0
    for k, row in enumerate(rows):
        target = motion.step(k)
        wanted = target[surface] - mesh.points[surface]
        error = np.linalg.norm(interpolant.displacements(surface, target) - wanted, axis=1).max()
        assert int(row["base_points"]) == len(base), f"{row['base_points']} in steps.csv, {len(base)} in base.vtp"
        assert error <= case.tolerance * (1 + 1e-9), f"step {k}: error {error} exceeds {case.tolerance}"
        largest = max(largest, abs(error - float(row["selection_error"])) / case.tolerance)
        check_surface(motion, target, outputs.points(folder / case.name, row), k)
    return len(rows), largest, len(base)


def check_surface(motion, target, found, k):
    """Moving nodes to 1e-12 of the mesh's size; fixed ones bit for bit unless all is carried round."""
    points = motion.mesh.points
    size = np.linalg.norm(points.max(axis=0) - points.min(axis=0))
    wanted = motion.carried(target, k)
    surface = motion.surface_nodes()
    off = np.linalg.norm(found[surface] - wanted[surface], axis=1).max()
    assert off <= 1e-12 * size, f"step {k}: a surface node is off by {off}"
    if not motion.inertial:
        meshes.assert_same_points(found[motion.fixed], points[motion.fixed], f"fixed nodes at step {k}")


def main():
    """One line a mesh. The truncation of modes may change a figure by 0.01 of the tolerance."""
    for case in CASES:
        with scratch() as folder:
            n, largest, n_base = check(case, folder)
        report(f"sequence, {case.name}", n, largest, "error figures", f"of the tolerance; {n_base} base points")
        assert largest <= 0.01, f"{case.name}: selection_error is off by {largest} of the tolerance"


if __name__ == "__main__":
    main()

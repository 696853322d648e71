"""selection "all" against a dense numpy solve: every node of every step."""

import numpy as np

import meshes
import outputs
import reference
from cases import CASES
from program import report, scratch


def deviation(case, folder):
    """(nodes compared, largest difference relative to the largest displacement, condition number)."""
    mesh = meshes.by_pyvista(case.solid or case.mesh)
    schedule = case.write(folder, "all")
    rows = outputs.deform(case.mesh, schedule, folder / case.name)
    motion = reference.Motion(schedule, mesh)
    assert len(rows) == len(motion.azimuths()), f"{len(rows)} steps, not {len(motion.azimuths())}"
    interpolant = reference.Interpolant(motion, motion.distinct_surface_nodes())
    everywhere = np.arange(len(mesh.points))
    difference, displacement = 0.0, 0.0
    for k, row in enumerate(rows):
        assert np.isclose(float(row["azimuth_deg"]), motion.azimuths()[k], rtol=0, atol=1e-9)
        moved = interpolant.displacements(everywhere, motion.step(k))
        wanted = motion.carried(mesh.points + moved, k)
        found = outputs.points(folder / case.name, row)
        difference = max(difference, np.linalg.norm(found - wanted, axis=1).max())
        displacement = max(displacement, np.linalg.norm(moved, axis=1).max())
    return len(rows) * len(everywhere), difference / displacement, interpolant.condition()


def main():
    """One line a mesh."""
    for case in CASES:
        with scratch() as folder:
            n_nodes, largest, condition = deviation(case, folder)
        limit = max(1e-10, 100 * np.finfo(float).eps * condition)
        report(f"all points, {case.name}", n_nodes, largest, "nodes", f"limit {limit:.1e}, cond(Phi) {condition:.2e}")
        assert largest <= limit, f"{case.name}: {largest} exceeds {limit}"


if __name__ == "__main__":
    main()

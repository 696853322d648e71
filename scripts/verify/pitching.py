"""The pitching NACA 0012 of SU2's test cases: published grids of five steps.

The airfoil turns about (0.248, 0) by -1.01 sin(106.69842 k dt) degrees, mathematically positive: nose
up by 1.01 sin. Mesh and grids are read from the folder that AZIMESH_TESTDATA names.
"""

import sys

import numpy as np

import outputs
import meshes
from program import real_meshes, report, scratch

CASE = "su2code__TestCases/disc_adj_euler/naca0012_pitching_def"
OMEGA, DT = 106.69842, 0.0023555025613149587

SCHEDULE = """
azimuth.values = [{values}]
boundaries.fixed = ["farfield"]

[[body]]
name = "airfoil"
tags = ["airfoil"]
cyclic = {{ pitch = [{{ sin = 1.01 }}], pitch_axis = [-0.248, 0.0] }}
"""


def main():
    """Compares the airfoil's nodes at all steps with the published grids, and the far field."""
    if real_meshes() is None:
        print("pitching airfoil: SKIPPED, AZIMESH_TESTDATA is not set", file=sys.stderr)
        return
    case = real_meshes() / CASE
    source = case / "mesh_NACA0012_inv_FFD.su2"
    mesh = meshes.by_meshio(source)
    airfoil = sorted({node for face in mesh.tags["airfoil"] for node in face})
    with scratch() as folder:
        schedule = folder / "pitching.toml"
        schedule.write_text(SCHEDULE.format(values=", ".join(repr(float(np.degrees(OMEGA * k * DT))) for k in range(5))))
        rows = outputs.deform(source, schedule, folder / "out")
        assert len(rows) == 5, rows
        largest = 0.0
        for k, row in enumerate(rows):
            assert int(row["inverted"]) == 0, f"step {k} has {row['inverted']} inverted cells"
            published = np.loadtxt(case / f"naca0012_pitching_def_solution_flow_{k:05}_xy.csv", delimiter=",", skiprows=1)
            found = outputs.points(folder / "out", row)
            largest = max(largest, np.linalg.norm(found[airfoil, :2] - published[airfoil], axis=1).max())
    report("pitching airfoil", 5 * len(airfoil), largest, "nodes")
    assert largest <= 1e-9, f"airfoil off by {largest}"

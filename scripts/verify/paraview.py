"""ParaView itself (`pvpython`, 5.11 of Debian or later) opens what `deform` writes, at three times: a .pvd, a .vtk.series,
a .cgns, a case of OpenFOAM; and one mesh as VTKHDF. Cells, times, and the range of every array are those that VTK's own reader finds in the
.vtu files. Skipped with a message if pvpython is not installed, or has no display (xvfb-run makes one).
"""

import json
import os
import shutil
import subprocess
import sys

import foam
import numpy as np
import pyvista
from program import TESTDATA, azimesh, report, scratch

STEPS = (0, 2, 7)
CASE_STEPS = (2, 5, 7)
# Run by ParaView's Python: all that it finds, as JSON.
INSIDE = """
import json, sys
from paraview.simple import *
found = {}
for path in sys.argv[2:]:
    reader = OpenDataFile(path)
    # Of a case ParaView leaves out the time 0, the mesh in constant, unless "Skip Zero Time" is off.
    first = 1 if path.endswith(".foam") else 0
    reader.UpdatePipelineInformation()
    for name in ("CellArrayStatus", "PointArrayStatus"):
        if hasattr(reader, name):
            reader.GetProperty(name).SelectAll()
    times = list(getattr(reader, "TimestepValues", None) or [])
    steps = []
    for time in [times[i - first] for i in ((2, 5, 7) if first else (0, 2, 7))] if len(times) > 1 else [0.0]:
        reader.UpdatePipeline(time)
        arrays = {}
        for kind, data in (("point", reader.PointData), ("cell", reader.CellData)):
            for i in range(data.GetNumberOfArrays()):
                array = data.GetArray(i)
                arrays[kind + " " + array.GetName()] = [array.GetRange(c) for c in range(array.GetNumberOfComponents())]
        info = reader.GetDataInformation()
        steps.append({"cells": info.GetNumberOfCells(), "points": info.GetNumberOfPoints(),
                      "bounds": list(info.GetBounds()), "arrays": arrays})
    found[path] = {"times": times, "steps": steps}
    if path.endswith(".foam"):
        found[path]["patches"] = patches = {}
        for region in reader.MeshRegions.Available:
            reader.MeshRegions = [region]
            reader.UpdatePipeline(times[6])
            patches[region] = reader.GetDataInformation().GetNumberOfCells()
json.dump(found, open(sys.argv[1], "w"))
"""


def pvpython(folder, *paths):
    """What ParaView finds in files."""
    (folder / "inside.py").write_text(INSIDE)
    command = ["pvpython", str(folder / "inside.py"), str(folder / "found.json"), *map(str, paths)]
    if "DISPLAY" not in os.environ and shutil.which("xvfb-run"):
        command = ["xvfb-run", "-a", *command]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    said = done.stdout + done.stderr
    assert done.returncode == 0 and "ERR|" not in said, f"{' '.join(command)}: {done.returncode}\n{said[-3000:]}"
    return json.loads((folder / "found.json").read_text())


def wanted(grid, volume_only):
    """What there is to find in a mesh."""
    own = np.array([cell.dimension for cell in grid.cell])
    chosen = own == own.max() if volume_only else np.ones(len(own), bool)
    arrays = {f"point {name}": ranges(values) for name, values in grid.point_data.items()}
    for name, values in grid.cell_data.items():
        if not (volume_only and name in ("BoundaryTag", "Zone")):
            arrays[f"cell {name}"] = ranges(values[chosen])
    return {"cells": int(chosen.sum()), "points": grid.n_points, "bounds": list(grid.bounds), "arrays": arrays}


def wanted_in_case(grid, first):
    """What there is to find inside a case of the same mesh: the cells, and the displacement from its first step."""
    return {**wanted(grid, True), "arrays": {"point wantedDisplacement": ranges(grid.points - first.points)}}


def faces_of(grid):
    """The number of cells in each region of a case: inside, and on each patch."""
    names = [str(name) for name in grid.field_data["BoundaryTagNames"]]
    tag = grid.cell_data["BoundaryTag"]
    return {"internalMesh": int((tag == 0).sum())} | {f"patch/{name}": int((tag == i + 1).sum()) for i, name in enumerate(names)}


def ranges(values):
    """Smallest and largest value of each component; None where all are NaN."""
    columns = np.asarray(values, float).reshape(len(values), -1).T
    return [None if np.isnan(column).all() else [np.nanmin(column), np.nanmax(column)] for column in columns]


def by_vtk(case, meshes):
    """Compares every node of a case at three times with VTK's own reader, which has 32 bits; the number of values."""
    for step, grid in zip(STEPS, meshes, strict=True):
        inside = foam.by_vtk(case, time=45.0 * step)["internalMesh"]
        assert np.array_equal(inside.points, grid.points.astype(np.float32)), f"{case}: step {step}"
    return 3 * sum(grid.n_points for grid in meshes)


def compare(what, found, expected):
    """The number of values compared."""
    assert (found["cells"], found["points"]) == (expected["cells"], expected["points"]), f"{what}: {found['cells']} cells"
    assert np.allclose(found["bounds"], expected["bounds"], rtol=1e-6), f"{what}: {found['bounds']}"
    missing = expected["arrays"].keys() - found["arrays"].keys()
    assert not missing, f"{what}: ParaView has no {sorted(missing)}"
    for name, columns in expected["arrays"].items():
        for theirs, ours in zip(found["arrays"][name], columns, strict=True):
            assert ours is None or np.allclose(theirs, ours, rtol=1e-6, atol=1e-12), f"{what}: {name} is {theirs}"
    return 2 + sum(len(columns) for columns in expected["arrays"].values())


def main():
    """One line in all."""
    if not shutil.which("pvpython") or not ("DISPLAY" in os.environ or shutil.which("xvfb-run")):
        print("paraview: pvpython or xvfb-run is not installed: SKIPPED", file=sys.stderr)
        return
    mesh = TESTDATA / "wing_on_plane.vtu"
    n = 0
    with scratch() as folder:
        schedule = folder / "wing.toml"
        text = (TESTDATA / "wing_on_plane.toml").read_text()
        schedule.write_text(text + '\n[output]\nquality = "cells"\ndisplacement = true\n')
        for name in ("vtu", "vtk", "cgns"):
            azimesh("deform", mesh, schedule, "-o", folder / name, "--format", name)
        meshes = [pyvista.read(folder / f"vtu/wing_on_plane_{step:04}.vtu") for step in STEPS]
        for step in meshes:
            assert not np.isnan(step.cell_data["ScaledJacobian"]).any(), "boundary faces have values"
        azimesh("convert", folder / "vtu/wing_on_plane_0007.vtu", folder / "one.hdf")
        azimesh("convert", folder / "vtu/wing_on_plane_0007.vtu", folder / "one.cgns")
        azimesh("convert", mesh, folder / "wing", "--format", "openfoam")
        azimesh("deform", folder / "wing", schedule, "-o", folder / "foam")
        sequences = [folder / name for name in ("vtu/wing_on_plane.pvd", "vtk/wing_on_plane.vtk.series", "cgns/wing_on_plane.cgns")]
        alone = [folder / "one.hdf", folder / "one.cgns"]
        cases = [folder / "foam/foam.foam"]
        found = pvpython(folder, *sequences, *cases, *alone)
        for path in sequences:
            assert found[str(path)]["times"] == [45.0 * step for step in range(9)], f"{path}: {found[str(path)]['times']}"
            for step, grid in zip(found[str(path)]["steps"], meshes, strict=True):
                n += compare(path.name, step, wanted(grid, path.suffix == ".cgns"))
        for path in cases:
            by_paraview = found[str(path)]
            in_case = [pyvista.read(folder / f"vtu/wing_on_plane_{step:04}.vtu") for step in CASE_STEPS]
            assert by_paraview["times"] == [45.0 * step for step in range(1, 9)], f"{path}: {by_paraview['times']}"
            for step, grid in zip(by_paraview["steps"], in_case, strict=True):
                n += compare(path.name, step, wanted_in_case(grid, meshes[0]))
            assert by_paraview["patches"] == faces_of(meshes[-1]), f"{path}: {by_paraview['patches']}"
            n += len(by_paraview["patches"]) + by_vtk(folder / "foam", meshes)
        for path in alone:
            n += compare(path.name, found[str(path)]["steps"][0], wanted(meshes[-1], path.suffix == ".cgns"))
    report("paraview", n, 0.0, note="of .pvd, .vtk.series, .cgns and a case at three times, and of one mesh as VTKHDF and CGNS")

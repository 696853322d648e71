"""What runs leave in every format of a sequence, for the checks that end runs at random moments.

A format that keeps the whole sequence in one file is added by a line in `SEQUENCES`. OpenFOAM has a folder for each time.
"""

import csv
import os
import signal

import h5py
import numpy as np
import pyvista
import vtk
from vtk.util.numpy_support import vtk_to_numpy

import foam
from program import AZIMESH, azimesh

SEED = 20261121
TIMES = int(os.environ.get("TIMES", 0))  # how often runs are ended in each format, where it is said
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL]
NAMES = ", ".join(how.name for how in SIGNALS)


def vtkhdf_steps(path):
    """Nodes at every step of a .vtkhdf file by VTK; h5py must agree on their number."""
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    with h5py.File(path) as file:
        times = file["VTKHDF/Steps/Values"][()]
        assert file["VTKHDF/Points"].shape == (int(file["VTKHDF/NumberOfPoints"][0]) * len(times), 3), path
    # VTK tells no times where there is one step.
    told = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert np.array_equal(told or times, times), f"{path}: VTK has the times {told}"
    for moment in times:
        reader.UpdateTimeStep(moment)
        yield vtk_to_numpy(reader.GetOutput().GetPoints().GetData()).copy()


def labelled(node, label):
    """Children with a CGNS label."""
    return [node[k] for k in node if not k.startswith(" ") and node[k].attrs["label"] == label.encode()]


def cgns_steps(path):
    """Nodes at every step of a .cgns file by libhdf5, by way of the zone's list of coordinates."""
    with h5py.File(path) as file:
        base = labelled(file, "CGNSBase_t")[0]
        zone = labelled(base, "Zone_t")[0]
        names = labelled(zone, "ZoneIterativeData_t")[0]["GridCoordinatesPointers/ data"][()]
        times = labelled(base, "BaseIterativeData_t")[0]["TimeValues/ data"][()]
        assert len(times) == len(names), f"{path}: {len(times)} times, {len(names)} coordinates"
        for name in names:
            node = zone[bytes(name.astype(np.uint8)).decode().strip()]
            axes = [node[f"Coordinate{axis}/ data"][()] for axis in "XYZ" if f"Coordinate{axis}" in node]
            yield np.stack([*axes, *[np.zeros_like(axes[0])] * (3 - len(axes))], axis=1)


# Formats of one file a sequence, and a reader that gives the nodes of its steps in order.
SEQUENCES = {"vtkhdf": vtkhdf_steps, "cgns": cgns_steps}
FORMATS = ["vtu", *SEQUENCES]
CASE = "openfoam"


def case(folder, nodes):
    """A mesh and its schedule of 36 steps, with another array at every step; the same as one layer of cells in a case."""
    mesh = folder / "mesh.vtu"
    azimesh("sample", "naca0012", "--nodes", nodes, "-o", mesh)
    schedule = mesh.with_suffix(".toml")
    schedule.write_text(schedule.read_text().replace("stop = 360.0", "stop = 350.0") + '\n[output]\nquality = "cells"\n')
    azimesh("convert", mesh, folder / "layer", "--format", CASE, "--extrude", 0.1)
    (folder / "layer.toml").write_text(schedule.read_text().replace("[output]", "[output]\ndisplacement = true"))
    return mesh


def inputs(mesh, name):
    """Mesh and schedule of a run."""
    return (mesh.with_name("layer"), mesh.with_name("layer.toml")) if name == CASE else (mesh, mesh.with_suffix(".toml"))


def command(mesh, folder, name):
    """The run that is ended, and the same that goes on with it."""
    return [AZIMESH, "--quiet", "deform", *inputs(mesh, name), "-o", folder, "--format", name, "--resume"]


def records(folder, name):
    """Where steps.csv and run.json are."""
    return folder / "azimesh" if name == CASE else folder


def case_steps(folder):
    """Nodes at every time of a case, ten degrees a step; each time is whole, with its displacement."""
    found, done = {}, finished(folder, CASE)
    for points in folder.glob("*/polyMesh/points"):
        time_name = points.parent.parent.name
        step = 0 if time_name == "constant" else round(float(time_name) / 10)
        if step == 0 and 0 not in done:
            # `constant` is a copy of the mesh that is given until step 0 is written.
            continue
        found[step] = foam.vectors(points)
        if step:
            assert len(foam.vectors(points.parent.parent / "wantedDisplacement")) == len(found[step]), points
    names = {path.name for path in folder.glob("constant/polyMesh/*")}
    assert not names or {"points", "faces", "owner", "neighbour", "boundary"} <= names, f"{folder}: {names}"
    return found


def steps_of(folder, name):
    """Step -> nodes, of every mesh under its own name."""
    if name == CASE:
        return case_steps(folder)
    if name == "vtu":
        return {int(path.stem.removeprefix("mesh_")): pyvista.read(path).points for path in folder.glob("mesh_[0-9]*.vtu")}
    path = folder / f"mesh.{name}"
    return dict(enumerate(SEQUENCES[name](path))) if path.exists() else {}


def finished(folder, name):
    """Steps that steps.csv calls finished; every row must be whole."""
    path = records(folder, name) / "steps.csv"
    if not path.exists() or not path.read_bytes():
        return []
    text = path.read_text()
    assert text.endswith("\n"), f"{path}: the last row is cut"
    rows = list(csv.reader(text.splitlines()))
    assert all(len(row) == len(rows[0]) for row in rows), f"{path}: a row is cut"
    assert all((path.parent / row[3]).is_file() for row in rows[1:]), f"{path}: a file is missing"
    return [int(row[0]) for row in rows[1:]]


def check_left(folder, name, wanted, what):
    """Whole files after a run was ended: those of steps.csv, and at most one more; the number of rows."""
    rows, found = finished(folder, name), steps_of(folder, name)
    assert set(rows) <= set(found), f"{what}: steps.csv has {rows}, the files {sorted(found)}"
    assert len(found) <= len(rows) + 1, f"{what}: steps.csv has {len(rows)} rows, there are {len(found)}"
    for step, points in found.items():
        assert np.array_equal(points, wanted[step]), f"{what}: step {step} is another"
    return len(rows)

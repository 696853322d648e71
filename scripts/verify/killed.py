"""`deform` killed with SIGKILL at random moments: what is left opens, and every finished step is right.

A format that keeps the whole sequence in one file is added by a line in `SEQUENCES`. OpenFOAM has a folder for each time.
"""

import csv
import random
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import h5py
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from program import AZIMESH, azimesh, report, scratch

NODES = 60_000
SEED = 20261121


def points_of(grid):
    """Nodes of a grid of VTK, copied."""
    return vtk_to_numpy(grid.GetPoints().GetData()).copy()


def vtu_points(path):
    """Nodes of one .vtu file by VTK."""
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0, f"{path}: VTK's error code {reader.GetErrorCode()}"
    return points_of(reader.GetOutput())


def vtkhdf_steps(path):
    """Nodes at every step of a .vtkhdf file by VTK; h5py must agree on their number."""
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    with h5py.File(path) as file:
        times = file["VTKHDF/Steps/Values"][()]
        n_points = int(file["VTKHDF/NumberOfPoints"][0])
        assert file["VTKHDF/Points"].shape == (n_points * len(times), 3), path
    # VTK tells no times where there is one step.
    told = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert np.array_equal(told or times, times), f"{path}: VTK has the times {told}"
    for moment in times:
        reader.UpdateTimeStep(moment)
        yield points_of(reader.GetOutput())


def labelled(node, label):
    """The first child with a CGNS label."""
    return next(child for child in node.values() if child.attrs.get("label") == label.encode())


def cgns_steps(path):
    """Nodes at every step of a .cgns file by libhdf5, by way of the zone's list of coordinates."""
    with h5py.File(path) as file:
        base = labelled(file, "CGNSBase_t")
        zone = labelled(base, "Zone_t")
        names = labelled(zone, "ZoneIterativeData_t")["GridCoordinatesPointers/ data"][()]
        times = labelled(base, "BaseIterativeData_t")["TimeValues/ data"][()]
        assert len(times) == len(names), f"{path}: {len(times)} times, {len(names)} coordinates"
        for name in names:
            node = zone[bytes(name.astype(np.uint8)).decode().strip()]
            axes = [node[f"Coordinate{axis}/ data"][()] for axis in "XYZ" if f"Coordinate{axis}" in node]
            axes += [np.zeros_like(axes[0])] * (3 - len(axes))
            yield np.stack(axes, axis=1)


# Formats of one file a sequence: the ending, and a reader that gives the nodes of its steps in order.
SEQUENCES = {"vtkhdf": vtkhdf_steps, "cgns": cgns_steps}
FORMATS = ["vtu", *SEQUENCES]
CASE = "openfoam"


def make_layer(mesh):
    """A case of one layer of cells over a plane mesh, and its schedule, which asks for displacements."""
    azimesh("convert", mesh, mesh.with_name("layer"), "--format", CASE, "--extrude", 0.1)
    text = mesh.with_suffix(".toml").read_text()
    text = text if "[output]" in text else text + "\n[output]\n"
    mesh.with_name("layer.toml").write_text(text.replace("[output]", "[output]\ndisplacement = true"))


def inputs(mesh, name):
    """Mesh and schedule of a run."""
    return (mesh.with_name("layer"), mesh.with_name("layer.toml")) if name == CASE else (mesh, mesh.with_suffix(".toml"))


def records(folder, name):
    """Where steps.csv and run.json are."""
    return folder / "azimesh" if name == CASE else folder


def foam_vectors(path):
    """The vectors of a binary file of OpenFOAM, which must be whole."""
    content = path.read_bytes()
    found = re.search(rb"\n(\d+)\n\(", content)
    assert found, f"{path}: it is cut"
    end = found.end() + 24 * int(found[1])
    assert content[end : end + 1] == b")" and content.endswith((b")\n", b"}\n")), f"{path}: it is cut"
    return np.frombuffer(content[found.end() : end], dtype="<f8").reshape(-1, 3)


def case_steps(folder):
    """Nodes at every time of a case, ten degrees a step; each time is whole, with its displacement."""
    found, done = {}, finished(folder, CASE)
    for points in folder.glob("*/polyMesh/points"):
        time_name = points.parent.parent.name
        step = 0 if time_name == "constant" else round(float(time_name) / 10)
        if step == 0 and 0 not in done:
            # `constant` is a copy of the mesh that is given until step 0 is written.
            continue
        found[step] = foam_vectors(points)
        if step:
            displacement = foam_vectors(points.parent.parent / "wantedDisplacement")
            assert len(displacement) == len(found[step]), points
    names = {path.name for path in folder.glob("constant/polyMesh/*")}
    assert not names or {"points", "faces", "owner", "neighbour", "boundary"} <= names, f"{folder}: {names}"
    return found


def steps_of(folder, name):
    """Step -> nodes, of every mesh under its own name."""
    if name == CASE:
        return case_steps(folder)
    if name == "vtu":
        files = sorted(folder.glob("mesh_[0-9]*.vtu"))
        return {int(path.stem.removeprefix("mesh_")): vtu_points(path) for path in files}
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


def command(mesh, folder, name):
    """The run that is killed."""
    mesh, schedule = inputs(mesh, name)
    return [AZIMESH, "--quiet", "deform", mesh, schedule, "-o", folder, "--format", name, "--force"]


def started(mesh, folder, name):
    """A run, and the moment at which its table stood in the folder."""
    run = subprocess.Popen(command(mesh, folder, name), stderr=subprocess.DEVNULL)
    table = records(folder, name) / "steps.csv"
    while not table.exists() and run.poll() is None:
        time.sleep(0.0005)
    return run, time.monotonic()


def uninterrupted(mesh, folder, name):
    """Nodes of every step, and how long the steps took."""
    run, start = started(mesh, folder, name)
    assert run.wait() == 0, f"{name}: the run failed"
    return steps_of(folder, name), time.monotonic() - start


def kill_once(mesh, folder, name, wanted, delay):
    """Kills a run after so many seconds; returns the number of steps that are left."""
    shutil.rmtree(folder, ignore_errors=True)
    run, _ = started(mesh, folder, name)
    time.sleep(delay)
    run.send_signal(signal.SIGKILL)
    run.wait()
    found = steps_of(folder, name)
    rows = finished(folder, name)
    what = f"{name} killed after {delay:.4f} s"
    assert set(rows) <= set(found), f"{what}: steps.csv has {rows}, the files {sorted(found)}"
    assert len(found) <= len(rows) + 1, f"{what}: steps.csv has {len(rows)} rows, there are {len(found)}"
    for step, points in found.items():
        assert np.array_equal(points, wanted[step]), f"{what}: step {step} is another"
    return len(found)


def check_again(mesh, folder, name, wanted):
    """A run with --force after a kill leaves no part of a file and the same meshes."""
    subprocess.run(command(mesh, folder, name), check=True)
    left = [path.name for path in folder.rglob(".*.part")]
    assert not left, f"{name}: {left} left after --force"
    found = steps_of(folder, name)
    assert found.keys() == wanted.keys(), f"{name}: a run after a kill has other steps"
    assert all(np.array_equal(found[step], wanted[step]) for step in wanted), name


def main(kills=5, nodes=NODES // 4):
    """One line in all."""
    chance = random.Random(SEED)
    n_steps, left = 0, []
    with scratch() as folder:
        mesh = Path(folder) / "mesh.vtu"
        azimesh("sample", "naca0012", "--nodes", nodes, "-o", mesh)
        make_layer(mesh)
        for name in [*FORMATS, CASE]:
            wanted, seconds = uninterrupted(mesh, folder / f"{name}_whole", name)
            for _ in range(kills):
                n = kill_once(mesh, folder / name, name, wanted, chance.uniform(0.0, seconds))
                left.append(n)
                n_steps += n
            check_again(mesh, folder / name, name, wanted)
    inside = sum(0 < n < len(wanted) for n in left)
    note = f"{kills} kills each of {', '.join([*FORMATS, CASE])}, {inside} with some of the steps finished"
    report("killed", n_steps, 0.0, "steps", note)


if __name__ == "__main__":
    main()

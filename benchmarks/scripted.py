"""Radial basis functions as a user would script them, on base points and displacements that are given.

    .venv/bin/python benchmarks/scripted.py motion MESH SCHEDULE BASE OUT.npz
    .venv/bin/python benchmarks/scripted.py whole|blocks|threads|scipy MESH MOTION.npz FOLDER
    .venv/bin/python benchmarks/scripted.py accuracy MOTION.npz FOLDER FOLDER

`compare_peers.py` runs each in a process of its own. The four ways read MESH with VTK, write a VTU file
a step to FOLDER with VTK, and print the seconds of fitting and evaluation together, as JSON.
"""

import json
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import vtk
from scipy.interpolate import RBFInterpolator
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.distance import cdist
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

# Nodes of a block: its kernel matrix stays in the cache (the fastest of 256, 1024, 4096 and 16384).
BLOCK = 1024


def read(path):
    """(grid, positions of its nodes)."""
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    return grid, vtk_to_numpy(grid.GetPoints().GetData())


def write(grid, positions, path):
    """The grid with other positions, in raw binary: VTK's fastest way."""
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(positions))
    grid.SetPoints(points)
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(grid)
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToNone()
    assert writer.Write() == 1, f"{path} cannot be written"


def wendland(at, base, radius):
    """Wendland's C2 function as the formula stands."""
    xi = np.minimum(cdist(at, base) / radius, 1)
    return (1 - xi) ** 4 * (4 * xi + 1)


def wendland_in_place(at, base, radius):
    """The same with two arrays, and products for the power."""
    xi = cdist(at, base)
    xi /= radius
    np.minimum(xi, 1, out=xi)
    kernel = 1 - xi
    kernel *= kernel
    kernel *= kernel
    xi *= 4
    xi += 1
    kernel *= xi
    return kernel


def side_by_side(moved):
    """Displacements (K, n, 3) of all steps as the columns of one matrix (n, 3K)."""
    return moved.transpose(1, 0, 2).reshape(moved.shape[1], -1)


def whole(points, base, moved, radius):
    """The kernel matrix of all nodes at once, multiplied for each step."""
    factor = cho_factor(wendland(base, base, radius))
    kernel = wendland(points, base, radius)
    for displacements in moved:
        yield points + kernel @ cho_solve(factor, displacements)


def blocks(points, base, moved, radius, workers=1):
    """One block of nodes after another, all steps at once."""
    weights = cho_solve(cho_factor(wendland_in_place(base, base, radius)), side_by_side(moved))
    steps = np.empty((len(moved), *points.shape))

    def fill(start):
        at = points[start : start + BLOCK]
        field = wendland_in_place(at, base, radius) @ weights
        steps[:, start : start + BLOCK] = at + field.reshape(len(at), -1, 3).transpose(1, 0, 2)

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(fill, range(0, len(points), BLOCK)))
    return steps


def threads(points, base, moved, radius):
    """`blocks`, with a thread for each core (numpy lets go of the interpreter in its loops)."""
    return blocks(points, base, moved, radius, len(os.sched_getaffinity(0)))


def scipy(points, base, moved, _radius):
    """RBFInterpolator with its linear kernel (it has no Wendland function), one fit for all steps."""
    field = RBFInterpolator(base, side_by_side(moved), kernel="linear")(points)
    return points + field.reshape(len(points), -1, 3).transpose(1, 0, 2)


def script(way, mesh, motion, folder):
    """Reads, interpolates and writes; only the interpolation is timed here."""
    grid, points = read(mesh)
    points = points.copy()
    given = np.load(motion)
    folder = Path(folder)
    folder.mkdir()
    seconds, started = 0.0, time.perf_counter()
    for k, positions in enumerate(way(points, points[given["base"]], given["moved"], given["radius"])):
        seconds += time.perf_counter() - started
        write(grid, np.ascontiguousarray(positions), folder / f"step_{k:04}.vtu")
        started = time.perf_counter()
    print(json.dumps(seconds))


def motion(mesh, schedule, base, out):
    """What the schedule prescribes at base points (displacements) and at all surface nodes (positions)."""
    import tomllib
    from types import SimpleNamespace

    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts" / "verify"))
    import pyvista
    import reference

    grid = pyvista.read(mesh)
    faces = grid.extract_cells(np.flatnonzero(grid.cell_data["BoundaryTag"]))
    original = faces.point_data["vtkOriginalPointIds"]
    rows = np.split(original[faces.cell_connectivity], faces.cell_offsets[1:-1])
    names = list(map(str, grid.field_data["BoundaryTagNames"]))
    tags = {name: [] for name in names}
    for tag, row in zip(faces.cell_data["BoundaryTag"], rows):
        tags[names[tag - 1]].append(row.tolist())
    prescribed = reference.Motion(schedule, SimpleNamespace(points=np.array(grid.points), dimension=3, tags=tags))
    nodes = np.array(tomllib.loads(Path(base).read_text())["nodes"])
    surface = prescribed.surface_nodes()
    steps = [prescribed.step(k) for k in range(len(prescribed.azimuths()))]
    np.savez(
        out, base=nodes, moved=np.array([step[nodes] - grid.points[nodes] for step in steps]), surface=surface,
        there=np.array([step[surface] for step in steps]), radius=prescribed.schedule["rbf"]["support_radius"],
        reference=grid.points,
    )  # fmt: skip


def accuracy(motion, folder, other):
    """Prints the largest error at a surface node of `folder`'s files, the largest difference of a node from
    `other`'s, and the largest displacement."""
    given = np.load(motion)
    error = difference = displacement = 0.0

    def largest(vectors):
        return float(np.linalg.norm(vectors, axis=1).max())

    files, others = (sorted(Path(name).glob("*.vtu")) for name in (folder, other))
    assert len(files) == len(others) == len(given["there"]), f"{len(files)} and {len(others)} files"
    for there, file, beside in zip(given["there"], files, others):
        points, expected = read(file)[1], read(beside)[1]
        error = max(error, largest(points[given["surface"]] - there))
        difference = max(difference, largest(points - expected))
        displacement = max(displacement, largest(expected - given["reference"]))
    print(json.dumps([error, difference, displacement]))


def main():
    """Does what the first argument says."""
    work, arguments = sys.argv[1], sys.argv[2:]
    ways = {"whole": whole, "blocks": blocks, "threads": threads, "scipy": scipy}
    if work in ways:
        script(ways[work], *arguments)
    else:
        {"motion": motion, "accuracy": accuracy}[work](*arguments)


if __name__ == "__main__":
    main()

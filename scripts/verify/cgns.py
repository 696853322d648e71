"""CGNS: what we write as h5py, VTK's reader and the CGNS library's own checker see it.

h5py reads nodes, cells and boundary conditions by the standard alone; VTK reads nodes, cells and each step of a
sequence; cgnscheck may find nothing but names of arrays that are not its own.
"""

import json
import re
import shutil
import subprocess

import h5py
import meshes
import numpy as np
import vtk
from program import TESTDATA, azimesh, report, scratch
from sequences import labelled
from vtk.util.numpy_support import vtk_to_numpy

# CGNS's number of an element type: VTK's, nodes, position in the file of each of VTK's nodes (SIDS 3.3)
QUADRATIC = [*range(12), 16, 17, 18, 19, 12, 13, 14, 15]
TYPES = {
    2: (1, 1, None), 3: (3, 2, None), 4: (21, 3, None), 5: (5, 3, None), 6: (22, 6, None), 7: (9, 4, None), 8: (23, 8, None), 9: (28, 9, None),
    10: (10, 4, None), 11: (24, 10, None), 12: (14, 5, None), 14: (13, 6, None), 15: (26, 15, [*range(9), 12, 13, 14, 9, 10, 11]),
    16: (32, 18, [*range(9), 12, 13, 14, 9, 10, 11, 15, 16, 17]), 17: (12, 8, None), 18: (25, 20, QUADRATIC),
    19: (29, 27, [*QUADRATIC, 24, 22, 21, 23, 20, 25, 26]), 21: (27, 13, None),
}  # fmt: skip
MIXED = 20
# What cgnscheck says of arrays whose names are the user's own, or have units of their own.
ALLOWED = ("not a CGNS data-name identifier", "exponents not given", "warnings (")


def data(node, name=None):
    """Data of a node, or of its child of this name, as one row of numbers."""
    return np.array((node[name] if name else node)[" data"]).ravel()


def by_h5py(path):
    """The mesh of a file with one zone, by the standard."""
    with h5py.File(path) as file:
        zone = labelled(labelled(file, "CGNSBase_t")[0], "Zone_t")[0]
        grid = zone["GridCoordinates"]
        axes = [data(grid, f"Coordinate{axis}") for axis in "XYZ" if f"Coordinate{axis}" in grid]
        points = np.zeros((len(axes[0]), 3))
        points[:, : len(axes)] = np.array(axes).T
        mesh = meshes.Mesh(points)
        elements = {}
        for section in sorted(labelled(zone, "Elements_t"), key=lambda s: data(s, "ElementRange")[0]):
            read_section(section, elements)
        for _, (kind, nodes) in sorted(elements.items()):
            mesh.cells[meshes.KINDS[kind][0]].append((kind, nodes))
        for condition in labelled(zone["ZoneBC"], "BC_t") if "ZoneBC" in zone else []:
            if "PointRange" in condition:
                first, last = data(condition, "PointRange")
                numbers = range(first, last + 1)
            else:
                numbers = data(condition, "PointList")
            name = bytes(data(condition, "FamilyName").astype(np.uint8)).decode()
            mesh.tags[name] = {meshes.face_key(elements[int(n)][1]) for n in numbers}
    return mesh


def read_section(section, elements):
    """Fills {number of an element: (VTK type, nodes)}."""
    number = int(data(section)[0])
    first, last = data(section, "ElementRange")
    nodes = data(section, "ElementConnectivity") - 1
    if number == MIXED:
        starts = data(section, "ElementStartOffset")
        for i, start in enumerate(starts[:-1]):
            kind, n, order = TYPES[int(nodes[start]) + 1]
            row = nodes[start + 1 : start + 1 + n]
            elements[int(first) + i] = (kind, tuple(int(node) for node in (row[order] if order else row)))
        return
    if number in TYPES:
        kind, n, order = TYPES[number]
        rows = nodes.reshape(-1, n)
        rows = rows[:, order] if order else rows
        for i, row in enumerate(rows):
            elements[int(first) + i] = (kind, tuple(int(node) for node in row))
    assert number in TYPES, f"element type {number} in {section.name}"


def by_vtk(path, time=None):
    """The grid of the only zone as VTK's reader has it."""
    reader = vtk.vtkCGNSReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    reader.EnableAllBases()
    reader.EnableAllPointArrays()
    reader.EnableAllCellArrays()
    if time is not None:
        reader.UpdateTimeStep(time)
    reader.Update()
    return reader.GetOutput().GetBlock(0).GetBlock(0)


def check_with_library(path):
    """Nothing but allowed warnings from cgnscheck, where it is installed."""
    if not shutil.which("cgnscheck"):
        return
    done = subprocess.run(["cgnscheck", str(path)], capture_output=True, text=True)
    said = [line for line in done.stdout.splitlines() if re.search("error|warning", line, re.I)]
    wrong = [line for line in said if not any(words in line for words in ALLOWED)]
    assert not wrong and done.returncode == 0, f"cgnscheck {path}: {wrong}"


def check_source(source, folder):
    """One mesh through CGNS; returns the number of its nodes."""
    target = folder / f"{source.stem}_{source.suffix[1:]}.cgns"
    azimesh("convert", source, target)
    wanted = meshes.third_party(source)
    if "two_pieces" not in source.name:  # its faces do not share the nodes of its cells
        check_with_library(target)
    grid = by_vtk(target)
    assert grid.GetNumberOfPoints() == len(wanted.points), f"{target}: nodes in VTK"
    found = vtk_to_numpy(grid.GetPoints().GetData())
    assert (found == wanted.points).all(), f"{target}: positions in VTK"
    assert grid.GetNumberOfCells() == len(wanted.volume_cells), f"{target}: cells in VTK"
    kinds = {kind for cells in wanted.cells.values() for kind, _ in cells}
    if not kinds & {7, 42}:
        read = by_h5py(target)
        meshes.assert_same_points(read.points, wanted.points, f"{target} by h5py")
        for dimension, cells in wanted.cells.items():
            meshes.assert_same_cells(read.cells[dimension], cells, f"{target} by h5py")
        tags = {name: faces for name, faces in wanted.tags.items() if faces}
        meshes.assert_same_groups(read.tags, tags, f"{target}: tags by h5py")
    azimesh("diff", source, target, expect=(0, 1))
    check_arrays(source, folder / f"judged_{target.name}", len(wanted.volume_cells))
    return len(wanted.points)


def check_arrays(source, target, n_cells):
    """VTK's reader has every cell array, with a value for each cell and for nothing else."""
    judged = json.loads(azimesh("quality", source, "-o", target, "--json"))
    arrays = by_vtk(target).GetCellData()
    assert arrays.HasArray("Volume"), f"{target}: VTK has no cell array"
    volumes = vtk_to_numpy(arrays.GetArray("Volume"))
    assert len(volumes) == n_cells, f"{target}: {len(volumes)} values of {n_cells} cells"
    total = volumes[~np.isnan(volumes)].sum()
    assert np.isclose(total, judged["total_volume"], rtol=1e-9), f"{target}: the volumes add up to {total}"


def check_sequence(folder):
    """A deformed sequence in one file: VTK has each step as the .vtu of that step."""
    schedule = (TESTDATA / "naca0012.toml").read_text()
    one = folder / "one.toml"
    one.write_text(schedule + '\n[output]\nformat = "cgns"\n')
    mesh = TESTDATA / "naca0012.vtu"
    azimesh("deform", mesh, TESTDATA / "naca0012.toml", "-o", folder / "many")
    azimesh("deform", mesh, one, "-o", folder / "one")
    (target,) = (folder / "one").glob("*.cgns")
    check_with_library(target)
    with h5py.File(target) as file:
        times = data(labelled(labelled(file, "CGNSBase_t")[0], "BaseIterativeData_t")[0], "TimeValues")
    steps = sorted((folder / "many").glob("*.vtu"))
    assert len(steps) == len(times), f"{len(steps)} files, {len(times)} times"
    for step, time in zip(steps, times):
        wanted = meshes.by_pyvista(step).points
        found = vtk_to_numpy(by_vtk(target, time).GetPoints().GetData())
        assert (found == wanted).all(), f"{target}: step at {time}"
    return len(steps)


def main():
    """Every mesh of testdata; then a sequence."""
    n_nodes = 0
    sources = sorted(p for p in TESTDATA.iterdir() if p.suffix in (".vtu", ".msh"))
    with scratch() as folder:
        for source in sources:
            n_nodes += check_source(source, folder)
        n_steps = check_sequence(folder)
    note = f"{len(sources)} meshes, a sequence of {n_steps} steps"
    if not shutil.which("cgnscheck"):
        note += "; cgnscheck is NOT INSTALLED"
    report("cgns", n_nodes, 0.0, "nodes", note)

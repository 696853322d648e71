"""`azimesh diff` on a mesh of 10 million nodes: that it finds what differs, and how long it takes.

    .venv/bin/python benchmarks/bench_diff.py [--nodes 10000000] [--folder target/bench] [--rounds 3]

A blade of hexahedra is compared with copies in which one node is moved by 1e-9, one face has the other tag,
two cells have changed places, and with one whose nodes and cells are all numbered anew. Files are in the
page cache. Seconds and peak memory are those of the whole command, reading both files included; `comparing`
is what `-v` says of the comparison alone.
"""

import argparse
import os
import re
import subprocess
import tempfile
import time
from pathlib import Path

from measure import machine, significant

AZIMESH = "target/release/azimesh"

# Writes the copies; in a process of its own, so that numpy counts in nobody's memory.
MAKE = """
import sys, numpy as np
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader as Reader, vtkXMLUnstructuredGridWriter as Writer
from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid as Grid, vtkCellArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.util.numpy_support import vtk_to_numpy as to_numpy, numpy_to_vtk as to_vtk
folder = sys.argv[1]
reader = Reader(); reader.SetFileName(f"{folder}/diff.vtu"); reader.Update()
mesh = reader.GetOutput()
points = to_numpy(mesh.GetPoints().GetData()).copy()
types = to_numpy(mesh.GetCellTypesArray()).copy()
offsets = to_numpy(mesh.GetCells().GetOffsetsArray()).copy()
nodes = to_numpy(mesh.GetCells().GetConnectivityArray()).copy()
tags = to_numpy(mesh.GetCellData().GetArray("BoundaryTag")).copy()
def write(name, points=points, nodes=nodes, types=types, offsets=offsets, tags=tags):
    grid, cells, places = Grid(), vtkCellArray(), vtkPoints()
    places.SetData(to_vtk(points)); grid.SetPoints(places)
    cells.SetData(to_vtk(offsets), to_vtk(nodes)); grid.SetCells(to_vtk(types), cells)
    grid.SetFieldData(mesh.GetFieldData())
    array = to_vtk(tags); array.SetName("BoundaryTag"); grid.GetCellData().AddArray(array)
    writer = Writer(); writer.SetFileName(f"{folder}/{name}.vtu"); writer.SetInputData(grid)
    writer.SetDataModeToAppended(); writer.EncodeAppendedDataOff(); writer.SetCompressorTypeToNone(); writer.Write()
write("diff_same")
moved = points.copy(); moved[len(points) // 2, 1] += 1e-9
write("diff_node", points=moved); del moved
swapped = tags.copy(); at = [np.flatnonzero(tags == tag)[0] for tag in (1, 2)]; swapped[at] = swapped[at[::-1]]
write("diff_tag", tags=swapped)
hexahedra = np.flatnonzero(types == 12); first = hexahedra[len(hexahedra) // 2]
reordered = nodes.copy(); a, b = offsets[first], offsets[first + 1]
reordered[a:b], reordered[b:b + 8] = nodes[b:b + 8], nodes[a:b]
write("diff_cell", nodes=reordered); del reordered
random = np.random.default_rng(1)
order = random.permutation(len(points)); number = np.empty_like(order); number[order] = np.arange(len(order))
new = []; kept = []
for kind in np.unique(types)[::-1]:
    cells = random.permutation(np.flatnonzero(types == kind)); n = offsets[cells[0] + 1] - offsets[cells[0]]
    kept.append(cells); new.append((number[nodes[offsets[cells][:, None] + np.arange(n)]], n, len(cells)))
sizes = np.concatenate([np.full(count, n) for _, n, count in new]); kept = np.concatenate(kept)
write("diff_position", points=points[order], nodes=np.concatenate([cells.ravel() for cells, _, _ in new]),
      types=types[kept], offsets=np.concatenate([[0], np.cumsum(sizes)]), tags=tags[kept])
"""


def run(command):
    """(exit code, seconds, peak MB, standard output, standard error) of a command."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as errors:
        started = time.monotonic()
        process = subprocess.Popen(list(map(str, command)), stdout=out, stderr=errors)
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.monotonic() - started
        process.returncode = os.waitstatus_to_exitcode(status)
        for file in (out, errors):
            file.seek(0)
        return process.returncode, seconds, usage.ru_maxrss / 1024, out.read(), errors.read()


def main():
    """Prints a row for each comparison; fails where one does not find what it should."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=10_000_000)
    parser.add_argument("--folder", type=Path, default=Path("target/bench"))
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run([AZIMESH, "-q", "sample", "blade", "--nodes", str(options.nodes), "-o", folder / "diff.vtu", "--force"],
                   check=True)
    subprocess.run([".venv/bin/python", "-c", MAKE, folder], check=True)
    print(f"{machine()}; diff.vtu: {(folder / 'diff.vtu').stat().st_size / 1e6:.0f} MB")
    print(f"{'copy':10}{'match':10}{'exit':>5}{'seconds':>9}{'comparing':>11}{'peak MB':>9}  said")
    cases = [("same", "order", 0, "same: "), ("node", "order", 1, "1 node differs"), ("tag", "order", 1, "groups differ"),
             ("cell", "order", 1, "2 cells differ"), ("position", "position", 0, "same: "),
             ("node", "position", 1, "1 node differs")]
    for copy, match, code, wanted in cases:
        command = [AZIMESH, "diff", "-v", "--match", match, folder / "diff.vtu", folder / f"diff_{copy}.vtu"]
        found = min((run(command) for _ in range(options.rounds)), key=lambda found: found[1])
        assert found[0] == code and wanted in found[3], f"{copy}: {found}"
        comparing = float(re.search(r"comparing: ([\d.]+) s", found[4])[1])
        said = found[3].splitlines()[0]
        print(f"{copy:10}{match:10}{found[0]:5}{significant(found[1]):>9}{significant(comparing):>11}{found[2]:9.0f}  {said}",
              flush=True)


if __name__ == "__main__":
    main()

"""Quality of a large mesh of tetrahedra beside VTK's filter, in one run.

    .venv/bin/python benchmarks/bench_quality.py [--nodes 8000000] [--threads 2] [--rounds 3] [--folder target/bench]

The mesh is that of `azimesh sample blade --cells tet`. Both programs time their own work and nothing else: reading is
left out. azimesh says its stages with `quality -v`; VTK is told to use as many threads and timed round each Update of
vtkMeshQuality. The rounds alternate; each figure is the best round. The floor is the time that this machine takes to
sum up as many bytes as the summary must read at least: 16 for the nodes of a cell, one for its orientation, 24 for
the coordinates of a node.
"""

import argparse
import json
import re
import subprocess
from pathlib import Path

from measure import PYTHON, machine, significant

AZIMESH = "target/release/azimesh"
# Stage of azimesh: what it counts, the least it must do a second, and the measures of VTK for the same metrics (VTK has
# none of faces).
STAGES = {
    "cells": ("cells", 40e6, ["Volume", "ScaledJacobian", "EdgeRatio", "EquiangleSkew"]),
    "faces": ("faces", 10e6, []),
}
BY_VTK = """
import json, sys, time
import vtk
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

path, threads, measures = sys.argv[1], int(sys.argv[2]), json.loads(sys.argv[3])
vtk.vtkSMPTools.SetBackend("STDThread")
vtk.vtkSMPTools.Initialize(threads)
reader = vtk.vtkXMLUnstructuredGridReader()
reader.SetFileName(path)
reader.Update()
grid = reader.GetOutput()
seconds = {}
for measure in measures:
    judge = vtkMeshQuality()
    judge.SetInputData(grid)
    for kind in ("Triangle", "Tet"):
        name = "Area" if (kind, measure) == ("Triangle", "Volume") else measure
        getattr(judge, f"Set{kind}QualityMeasureTo{name}")()
    started = time.monotonic()
    judge.Update()
    seconds[measure] = time.monotonic() - started
    del judge
print(json.dumps(seconds))
"""
BYTES_READ = """
import sys, time
from concurrent.futures import ThreadPoolExecutor
import numpy as np

n_bytes, threads = int(sys.argv[1]), int(sys.argv[2])
parts = np.array_split(np.ones(n_bytes // 8), threads)
with ThreadPoolExecutor(threads) as pool:
    best = 1e9
    for _ in range(5):
        started = time.monotonic()
        list(pool.map(np.sum, parts))
        best = min(best, time.monotonic() - started)
print(best)
"""


def sample(folder, nodes):
    """The mesh of about so many nodes, made where it is not there."""
    path = folder / f"quality_{nodes}.vtu"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        command = [AZIMESH, "sample", "blade", "--cells", "tet", "--nodes", nodes, "-o", path, "--force"]
        subprocess.run(list(map(str, command)), check=True, capture_output=True)
    return path


def by_azimesh(path, threads):
    """Seconds of each stage, and what the program found."""
    command = [AZIMESH, "quality", "--json", "-v", "--threads", str(threads), path]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    stages = {name: float(seconds) for name, seconds in re.findall(r"^([\w -]+): ([\d.]+) s$", done.stderr, re.M)}
    return stages, json.loads(done.stdout)


def by_vtk(path, threads):
    """Seconds of each measure."""
    measures = sorted({measure for _, _, measures in STAGES.values() for measure in measures})
    command = [PYTHON, "-c", BY_VTK, path, str(threads), json.dumps(measures)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def floor(n_bytes, threads):
    """Seconds to read so many bytes."""
    command = [PYTHON, "-c", BYTES_READ, str(n_bytes), str(threads)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def main():
    """Measures, prints a table, and fails where a stage is slower than it must be."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=8_000_000)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--folder", type=Path, default=Path("target/bench"))
    args = parser.parse_args()
    path = sample(args.folder, args.nodes)
    info = subprocess.run([AZIMESH, "info", "--json", path], check=True, capture_output=True, text=True)
    nodes = json.loads(info.stdout)["nodes"]
    ours, theirs = [], []
    for _ in range(args.rounds):
        stages, found = by_azimesh(path, args.threads)
        ours.append(stages)
        theirs.append(by_vtk(path, args.threads))
    best = {name: min(stages[name] for stages in ours) for name in ours[0]}
    counts = {"cells": found["cells"], "faces": found["inner_faces"] + found["outer_faces"]}
    print(f"{machine()}, {args.threads} threads: {nodes:,} nodes, {found['cells']:,} tetrahedra, best of {args.rounds}")
    print("azimesh, s: " + ", ".join(f"{name} {seconds:.3f}" for name, seconds in best.items()))
    failed = False
    for stage, (unit, least, measures) in STAGES.items():
        rate = counts[unit] / best[stage]
        if not measures:
            failed |= rate < least
            print(f"{stage}: {best[stage]:.3f} s, {rate / 1e6:.1f} million {unit} a second (at least {least / 1e6:.0f})")
            continue
        vtk = sum(min(seconds[measure] for seconds in theirs) for measure in measures)
        faster = vtk / best[stage]
        n_bytes = 17 * counts["cells"] + 24 * nodes
        reading = floor(n_bytes, args.threads)
        failed |= rate < least or faster < 10
        print(
            f"{stage}: {best[stage]:.3f} s, {rate / 1e6:.1f} million {unit} a second (at least {least / 1e6:.0f}); "
            f"VTK, {' + '.join(measures)}: {vtk:.1f} s, {significant(faster)} times as long (at least 10); "
            f"reading {n_bytes / 1e9:.2f} GB takes {reading:.3f} s, {reading / best[stage]:.0%} of that"
        )
    raise SystemExit(failed)


if __name__ == "__main__":
    main()

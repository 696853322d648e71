"""Compares `azimesh quality` with VTK cell by cell: volume, scaled Jacobian, equiangle skew.

    python scripts/check_quality.py [--azimesh PROGRAM] MESH...

Needs pyvista (checked with 0.49.1, VTK 9.7.2). The program writes its metrics as cell arrays of a
VTU file; VTK computes its own on the same file. Where a cell is the other way round than VTK has
it (a negative volume there), the cell's mirror image is what is compared: that is the same cell with
its nodes in VTK's order. VTK shows 0 for a pyramid with a negative scaled Jacobian and no sign in 2D.
Exits with 1 on a difference above 1e-12 (1e-7 for the skew, which ends in an arc cosine).
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import pyvista as pv
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

SIZES = {"Triangle": "Area", "Quad": "Area"}
PYRAMID = 14
CORNERS = {5: 3, 9: 4, 10: 4, 14: 5, 13: 6, 12: 8}


def vtk_metric(grid, measure):
    judge = vtkMeshQuality()
    judge.SetInputData(grid)
    for kind in ("Triangle", "Quad", "Tet", "Pyramid", "Wedge", "Hex"):
        name = SIZES.get(kind, "Volume") if measure == "Size" else measure
        getattr(judge, f"Set{kind}QualityMeasureTo{name}")()
    judge.Update()
    return pv.wrap(judge.GetOutput()).cell_data["Quality"].copy()


def extent(grid):
    """Longest side of each cell's box, the scale of its rounding errors."""
    points = grid.points[grid.cell_connectivity]
    starts = grid.cell_offsets[:-1]
    low = np.minimum.reduceat(points, starts)
    high = np.maximum.reduceat(points, starts)
    return (high - low).max(axis=1)


def check(program, mesh):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.vtu"
        subprocess.run([program, "quality", mesh, "-o", out, "-q"], check=True, capture_output=True)
        grid = pv.read(out)
    grid.points = grid.points.astype(float)
    mirrored = grid.copy()
    mirrored.points = grid.points * [-1, 1, 1]
    kinds = grid.celltypes
    solid = np.isin(kinds, [10, 12, 13, 14])
    ours = np.isfinite(grid.cell_data["ScaledJacobian"]) & np.isin(kinds, list(CORNERS))
    flipped = solid & (vtk_metric(grid, "Size") < 0)
    theirs = {
        name: np.where(flipped, vtk_metric(mirrored, name), vtk_metric(grid, name))
        for name in ("Size", "ScaledJacobian", "EquiangleSkew")
    }
    volume, scaled = grid.cell_data["Volume"].copy(), grid.cell_data["ScaledJacobian"].copy()
    scaled[(kinds == PYRAMID) & (scaled < 0)] = 0
    volume[~solid], scaled[~solid] = abs(volume[~solid]), abs(scaled[~solid])
    theirs["ScaledJacobian"][~solid] = abs(theirs["ScaledJacobian"][~solid])
    scale = extent(grid) ** np.where(solid, 3, 2)
    errors = {
        "volume": abs(volume - theirs["Size"]) / scale,
        "scaled Jacobian": abs(scaled - theirs["ScaledJacobian"]),
        "skew": abs(grid.cell_data["EquiangleSkew"] - theirs["EquiangleSkew"]),
    }
    worst = {name: error[ours].max() for name, error in errors.items()}
    relative = (abs(volume - theirs["Size"]) / abs(theirs["Size"]))[ours].max()
    good = worst["volume"] < 1e-12 and worst["scaled Jacobian"] < 1e-12 and worst["skew"] < 1e-7
    told = ", ".join(f"{name} {error:.1e}" for name, error in worst.items())
    verdict = "ok" if good else "DIFFERENT"
    print(f"{verdict}: {mesh}: {ours.sum()} cells, {flipped.sum()} the other way round; "
          f"largest difference: {told} (volume relative to itself {relative:.1e})")
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--azimesh", default="target/release/azimesh")
    parser.add_argument("mesh", nargs="+")
    args = parser.parse_args()
    results = [check(args.azimesh, mesh) for mesh in args.mesh]
    sys.exit(0 if all(results) else 1)


if __name__ == "__main__":
    main()

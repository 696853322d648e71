"""Writes testdata/cell_quality.csv: random cells of each kind and what VTK's vtkMeshQuality says.

Needs pyvista (written with pyvista 0.49.1 and VTK 9.7.2). Columns: VTK cell type, volume or area,
scaled Jacobian, equiangle skew, then the coordinates. Seeded: the same file every time.
"""

import pathlib
import sys

import numpy as np
import pyvista as pv
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

IDEAL = {
    5: [[0, 0, 0], [1, 0, 0], [0.5, 0.75**0.5, 0]],
    9: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
    10: [[0, 0, 0], [1, 0, 0], [0.5, 0.75**0.5, 0], [0.5, 0.75**0.5 / 3, (2 / 3) ** 0.5]],
    14: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0.5**0.5]],
    13: [[0, 0, 0], [1, 0, 0], [0.5, 0.75**0.5, 0], [0, 0, 1], [1, 0, 1], [0.5, 0.75**0.5, 1]],
    12: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
}


def quality(grid, measure):
    """One measure of the grid's only cell."""
    judge = vtkMeshQuality()
    judge.SetInputData(grid)
    for kind in ("Triangle", "Quad", "Tet", "Pyramid", "Wedge", "Hex"):
        choose = getattr(judge, f"Set{kind}QualityMeasureTo{measure}", None)
        if choose:
            choose()
    judge.Update()
    return judge.GetOutput().GetCellData().GetArray("Quality").GetValue(0)


def main():
    random = np.random.default_rng(7)
    rows = []
    for kind, corners in IDEAL.items():
        corners = np.array(corners, float)
        for sample in range(40):
            noise = random.normal(size=corners.shape) * (0, 0.1, 0.3, 0.6)[sample % 4]
            stretch = np.array([1, 1, 10.0 ** -random.uniform(0, 3)]) if sample % 3 == 1 else 1
            points = (corners + noise) * stretch
            if kind in (5, 9):
                points[:, 2] = 0
            grid = pv.UnstructuredGrid(np.array([len(points), *range(len(points))]), [kind], points)
            size = "Area" if kind in (5, 9) else "Volume"
            measures = (size, "ScaledJacobian", "EquiangleSkew")
            values = [quality(grid, measure) for measure in measures]
            rows.append([kind, *values, *points.ravel()])
    path = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "testdata/cell_quality.csv")
    with path.open("w") as file:
        file.write("vtk_type,size,scaled_jacobian,equiangle_skew,coordinates\n")
        for row in rows:
            file.write(",".join(repr(float(x)) if i else str(x) for i, x in enumerate(row)) + "\n")


if __name__ == "__main__":
    main()

"""Writes testdata/cell_quality.csv: random cells of each kind and what VTK's vtkMeshQuality says.

Needs pyvista (written with pyvista 0.49.1 and VTK 9.7.2). Columns: VTK cell type, the metrics, then the coordinates. Empty where VTK does not have
the metric, or has it wrong (see scripts/verify/quality.py). Seeded: the same file every time.
"""

import numpy as np
import pyvista as pv
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

from place import FOLDER

IDEAL = {
    5: [[0, 0, 0], [1, 0, 0], [0.5, 0.75**0.5, 0]], 9: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
    10: [[0, 0, 0], [1, 0, 0], [0.5, 0.75**0.5, 0], [0.5, 0.75**0.5 / 3, (2 / 3) ** 0.5]],
    14: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0.5**0.5]],
    13: [[0, 0, 0], [1, 0, 0], [0.5, 0.75**0.5, 0], [0, 0, 1], [1, 0, 1], [0.5, 0.75**0.5, 1]],
    12: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
}  # fmt: skip


NAMES = {5: "Triangle", 9: "Quad", 10: "Tet", 14: "Pyramid", 13: "Wedge", 12: "Hex"}
MEASURES = {
    "size": "Volume", "scaled_jacobian": "ScaledJacobian", "equiangle_skew": "EquiangleSkew", "edge_ratio": "EdgeRatio", "jacobian": "Jacobian",
    "aspect_ratio": "AspectRatio", "condition": "Condition", "shape": "Shape", "min_angle": "MinAngle", "max_angle": "MaxAngle", "skew": "Skew",
}  # fmt: skip
WRONG = {("EdgeRatio", 12), ("MinAngle", 10), ("Shape", 14)}


def quality(grid, kind, measure):
    """One measure of the grid's only cell; None where there is none."""
    name = "Area" if measure == "Volume" and kind in (5, 9) else measure
    judge = vtkMeshQuality()
    judge.SetInputData(grid)
    choose = getattr(judge, f"Set{NAMES[kind]}QualityMeasureTo{name}", None)
    if choose is None or (measure, kind) in WRONG:
        return None
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
            values = [quality(grid, kind, measure) for measure in MEASURES.values()]
            rows.append([kind, *values, *points.ravel()])
    with (FOLDER / "cell_quality.csv").open("w") as file:
        file.write(f"vtk_type,{','.join(MEASURES)},coordinates\n")
        for kind, *numbers in rows:
            texts = ("" if x is None else repr(float(x)) for x in numbers)
            file.write(f"{kind},{','.join(texts)}\n")

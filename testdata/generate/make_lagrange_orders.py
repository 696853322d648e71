"""testdata/lagrange_orders.txt: where VTK puts the nodes of its Lagrange cells.

A line is the cell type, the order, and i,j,k of each node in steps of 1/order. VTK's shape functions must be one at their own node there and zero at
all others. VTK has a number for Lagrange pyramids but no class, so there are none here.
"""

import vtk

from place import FOLDER

KINDS = {
    "Curve": lambda p: p + 1, "Triangle": lambda p: (p + 1) * (p + 2) // 2, "Quadrilateral": lambda p: (p + 1) ** 2,
    "Tetra": lambda p: (p + 1) * (p + 2) * (p + 3) // 6, "Hexahedron": lambda p: (p + 1) ** 3, "Wedge": lambda p: (p + 1) ** 2 * (p + 2) // 2,
}  # fmt: skip


def places(name, order, n):
    """Node positions of one cell in steps of 1/order, held against its shape functions."""
    cell = getattr(vtk, f"vtkLagrange{name}")()
    cell.GetPoints().SetNumberOfPoints(n)
    cell.GetPointIds().SetNumberOfIds(n)
    if hasattr(cell, "SetUniformOrderFromNumPoints"):
        cell.SetUniformOrderFromNumPoints(n)
    cell.Initialize()
    flat = cell.GetParametricCoords()
    weights = [0.0] * n
    for i in range(n):
        cell.InterpolateFunctions(list(flat[3 * i : 3 * i + 3]), weights)
        assert all(abs(w - (i == j)) < 1e-9 for j, w in enumerate(weights)), (name, order, i)
    steps = [order * flat[i] for i in range(3 * n)]
    assert all(abs(s - round(s)) < 1e-9 for s in steps), (name, order)
    return cell.GetCellType(), [[round(s) for s in steps[3 * i : 3 * i + 3]] for i in range(n)]


def main():
    lines = []
    for name, count in KINDS.items():
        for order in range(1, 7):
            number, nodes = places(name, order, count(order))
            lines.append(f"{number} {order} " + " ".join("{},{},{}".format(*node) for node in nodes))
    (FOLDER / "lagrange_orders.txt").write_text("\n".join(lines) + "\n")

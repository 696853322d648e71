"""testdata/gmsh_orders.txt: where Gmsh puts the nodes of its complete elements of every order.

A line is the element type, the family, the order, and i,j,k of each node in steps of 1/order along the axes of VTK's reference cell. Gmsh gives local
coordinates of all types but prisms above second order; of these a straight prism is meshed and raised to each order.
"""

import gmsh
import numpy as np

from place import FOLDER, start_gmsh

FAMILIES = {"Line": 10, "Triangle": 10, "Quadrangle": 10, "Tetrahedron": 10, "Hexahedron": 9, "Prism": 9, "Pyramid": 9}


def steps_of(family, order, local):
    """Gmsh's local coordinates as steps: its lines, quadrangles and hexahedra go from -1 to 1."""
    places = local.copy()
    if family in ("Line", "Quadrangle", "Hexahedron"):
        dimension = {"Line": 1, "Quadrangle": 2, "Hexahedron": 3}[family]
        places[:, :dimension] = (places[:, :dimension] + 1) / 2
    elif family == "Prism":
        places[:, 2] = (places[:, 2] + 1) / 2
    elif family == "Pyramid":
        places[:, :2] = (places[:, :2] + 1 - places[:, 2:]) / 2
    steps = places * order
    assert np.abs(steps - steps.round()).max() < 1e-6, (family, order)
    return steps.round().astype(int)


def properties(family, order):
    """Local coordinates by Gmsh's own table."""
    kind = gmsh.model.mesh.getElementType(family, order)
    _, dimension, of_order, n, local, _ = gmsh.model.mesh.getElementProperties(kind)
    assert of_order == order
    places = np.zeros((n, 3))
    places[:, :dimension] = np.reshape(local, (n, dimension))
    return kind, places


def prism(order):
    """Local coordinates of a prism of a mesh."""
    gmsh.clear()
    gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.extrude([(2, 1)], 0, 0, 1, numElements=[1], recombine=True)
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMin", 2)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order)
    kinds, _, nodes = gmsh.model.mesh.getElements(3)
    n = (order + 1) ** 2 * (order + 2) // 2
    points = np.array([gmsh.model.mesh.getNode(tag)[0] for tag in nodes[0][:n]])
    corner = points[0]
    places = np.linalg.solve(np.array([points[1] - corner, points[2] - corner, points[3] - corner]).T, (points - corner).T).T
    places[:, 2] = 2 * places[:, 2] - 1
    return kinds[0], places


def main():
    start_gmsh()
    lines = []
    for family, highest in FAMILIES.items():
        for order in range(1, highest + 1):
            kind, places = prism(order) if family == "Prism" else properties(family, order)
            steps = steps_of(family, order, places)
            lines.append(f"{kind} {family} {order} " + " ".join("{},{},{}".format(*node) for node in steps))
    (FOLDER / "gmsh_orders.txt").write_text("\n".join(lines) + "\n")
    gmsh.finalize()

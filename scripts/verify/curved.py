"""Random curved cells of each kind and of orders 2 to 4: validity and least Jacobian against gmsh's minDetJac, and against numpy at many points.

No valid cell is called inverted and no inverted cell valid. A tenth of the cells has straight edges: their figures are those of the corners. CELLS=10000
checks that many cells of each kind and order, and prints a table.
"""

import json
import os
import time

import gmsh
import numpy as np
import pyvista as pv

from program import azimesh, report, scratch

CELLS = int(os.environ.get("CELLS", 20))
# gmsh's name, corners, volume of its reference cell, simplices of the reference cell, points along an axis, factor of the scaled Jacobian.
KINDS = {
    "triangle": (3, 1 / 2, [[0, 1]], 40, 2 / 3**0.5), "quadrangle": (4, 4, [[0], [1]], 40, 1),
    "tetrahedron": (4, 1 / 6, [[0, 1, 2]], 14, 2**0.5), "hexahedron": (8, 8, [[0], [1], [2]], 9, 1),
    "prism": (6, 1, [[0, 1], [2]], 10, 2 / 3**0.5), "pyramid": (5, 4 / 3, [[0], [1], [2]], 25, 2**0.5),
}  # fmt: skip
# gmsh stops where its two bounds are that close.
TOLERANCE = 2e-2
ZERO = 1e-9


def lattice(kind, n):
    """Points of a reference cell, corners included."""
    line = np.linspace(0, 1, n)
    points = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    if kind in ("triangle", "quadrangle"):
        points = points[points[:, 2] == 0]
    if kind == "triangle" or kind == "prism":
        points = points[points[:, :2].sum(axis=1) < 1 + 1e-9]
    if kind == "tetrahedron":
        points = points[points.sum(axis=1) < 1 + 1e-9]
    if kind in ("quadrangle", "hexahedron"):
        return np.where(np.arange(3) < (2 if kind == "quadrangle" else 3), 2 * points - 1, 0)
    if kind == "prism":
        points[:, 2] = 2 * points[:, 2] - 1
    if kind == "pyramid":  # at the apex the determinant has a limit from each side
        points[points[:, 2] == 1, 2] -= 1e-7
        points[:, :2] = (2 * points[:, :2] - 1) * (1 - points[:, 2:])
    return points


def sampled(kind, element, cells):
    """The least determinant and the least scaled Jacobian of each cell (m, n, 3) at many points."""
    points = lattice(kind, KINDS[kind][3])
    _, slopes, _ = gmsh.model.mesh.getBasisFunctions(element, points.ravel(), "GradLagrange")
    slopes = np.reshape(slopes, (len(points), cells.shape[1], 3))
    simplices, factor = KINDS[kind][2], KINDS[kind][4]
    least = []
    for some in np.array_split(cells, max(1, len(cells) // 250)):
        axes = np.einsum("pna,mnx->ampx", slopes, some, optimize=True)
        if kind in ("triangle", "quadrangle"):
            axes[2] = [0, 0, 1]
        if kind == "pyramid":  # along the line to the apex
            across = points[:, :2] / (1 - points[:, 2:])
            axes[2] -= across[:, :1] * axes[0] + across[:, 1:] * axes[1]
        determinant = (np.cross(axes[0], axes[1]) * axes[2]).sum(axis=-1)
        product = np.ones_like(determinant)
        for simplex in simplices:
            corners = [np.zeros_like(axes[0]), *(axes[k] for k in simplex)]
            at = [np.prod([np.linalg.norm(a - b, axis=-1) for b in corners if b is not a], axis=0) for a in corners]
            product *= np.max(at, axis=0)
        least.append([determinant.min(axis=1), (factor * determinant / np.maximum(product, 1e-300)).min(axis=1)])
    return np.concatenate(least, axis=1)


def write(path, element, cells, dimension):
    """A mesh of cells that share no nodes; gmsh keeps it as its model."""
    gmsh.model.add("cells")
    gmsh.model.addDiscreteEntity(dimension, 1)
    n = np.arange(1, cells.shape[0] * cells.shape[1] + 1)
    gmsh.model.mesh.addNodes(dimension, 1, n, cells.ravel())
    gmsh.model.mesh.addElementsByType(1, element, np.arange(1, len(cells) + 1), n)
    gmsh.write(str(path))


def check(folder, kind, order, random):
    """A row of the table, and the largest difference of a least Jacobian."""
    started = time.monotonic()
    n_corners, size, *_ = KINDS[kind]
    element = gmsh.model.mesh.getElementType(kind, order)
    _, dimension, _, n, local, _ = gmsh.model.mesh.getElementProperties(element)
    straight = np.zeros((CELLS, n, 3))
    straight[:, :, :dimension] = np.reshape(local, (n, dimension))
    turned = np.eye(3) + random.uniform(-0.3, 0.3, (CELLS, 3, 3))
    if dimension == 2:
        turned[:, 2], turned[:, :, 2] = [0, 0, 1], [0, 0, 1]
    straight = straight @ turned + 10 * np.arange(CELLS)[:, None, None] % 1000 * [1, 0, 0]
    # Some are far from folding, some near, some folded.
    noise = random.normal(size=straight.shape) * 10.0 ** random.uniform(-2.5, -0.7, (CELLS, 1, 1))
    noise[::10] = 0
    if dimension == 2:
        noise[:, :, 2] = 0
    curved = straight + noise
    write(folder / "straight.msh", element, straight, dimension)
    write(folder / "curved.msh", element, curved, dimension)
    by_gmsh = np.array(gmsh.model.mesh.getElementQualities(np.arange(1, CELLS + 1), "minDetJac"))
    ours = ["quality", folder / "curved.msh", "--reference", folder / "straight.msh", "-o", folder / "out.vtu", "--force", "--json"]
    clock = time.monotonic()
    told = json.loads(azimesh(*ours))
    seconds = time.monotonic() - clock
    grid = pv.read(folder / "out.vtu")
    inverted = np.array(grid.cell_data["Inverted"]) > 0
    jacobian, scaled = (np.array(grid.cell_data[name]) for name in ("CurvedJacobian", "CurvedScaledJacobian"))
    dense, dense_scaled = sampled(kind, element, curved)
    unit = abs(np.array(grid.cell_data["Volume"])) / size
    dense, by_gmsh = dense / unit, by_gmsh / unit
    if kind == "pyramid":  # gmsh's bound is not below the values of its own map
        by_gmsh = dense
    proven = ~inverted & (jacobian > 0)
    unproven = ~inverted & ~proven
    least = np.minimum(dense, by_gmsh)
    is_folded, is_valid = least < -ZERO, least > (ZERO if kind != "pyramid" else TOLERANCE)  # between the points it is less
    wrong = (proven & is_folded) | (inverted & is_valid)
    place = f"{kind} of order {order}"
    assert not wrong.any(), f"{place}: cells {np.flatnonzero(wrong)[:5]}: {jacobian[wrong][:5]}, gmsh {by_gmsh[wrong][:5]}, numpy {dense[wrong][:5]}"
    assert told["inverted"] == inverted.sum() and told["unproven"] == unproven.sum(), f"{place}: {told['unproven']} unproven, {unproven.sum()} without sign"
    assert (jacobian <= dense + 1e-9 * (1 + abs(dense))).all(), f"{place}: above numpy"
    apart = np.where(inverted, 0, abs(jacobian - by_gmsh) / (1 + abs(by_gmsh)))  # gmsh need not go on where it has found a negative value
    assert np.quantile((scaled - dense_scaled)[~inverted], 0.8) < 0.1, f"{place}: scaled Jacobian above numpy"
    flat = np.arange(CELLS) % 10 == 0
    assert abs(jacobian - 1)[flat].max() < 1e-9, f"{place}: straight cells have {jacobian[flat].min()}"
    if kind != "pyramid":
        own = abs(scaled - np.array(grid.cell_data["ScaledJacobian"]))[flat].max()
        assert own < 1e-9, f"{place}: straight cells are off by {own} from their corners"
    over = (scaled - dense_scaled)[~inverted].max()
    row = [place, proven.sum(), inverted.sum(), unproven.sum(), wrong.sum(), apart.max(), over, seconds, time.monotonic() - started]
    assert apart.max() < TOLERANCE, f"{place}: {apart.max()} from gmsh in cell {apart.argmax()}: {jacobian[apart.argmax()]}, gmsh {by_gmsh[apart.argmax()]}, numpy {dense[apart.argmax()]}"
    return row


def main():
    """Fails with the first kind that differs."""
    random = np.random.default_rng(15)
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.Binary", 1)
    largest = 0.0
    with scratch() as folder:
        for kind in KINDS:
            for order in (2, 3, 4):
                if (kind, order) in (("prism", 3), ("prism", 4)):
                    continue  # "FaceClosureFull not implemented" (gmsh 4.15)
                place, *counts, apart, over, seconds, whole = check(folder, kind, order, random)
                if CELLS >= 1000:
                    print(f"{place:26}{'%6d valid%6d inverted%4d unproven%3d wrong' % tuple(counts)}  {apart:.1e} {over:+.1e} {seconds:.1f} s of {whole:.1f} s")
                largest = max(largest, apart)
                gmsh.clear()
    gmsh.finalize()
    report("curved", (len(KINDS) * 3 - 2) * CELLS, largest, "cells", "least Jacobians beside gmsh's minDetJac")

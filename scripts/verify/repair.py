"""Repaired meshes in numpy: every Jacobian is positive, at corners and between them, and the boundary has stayed.

A block in a square that is turned by 100 degrees (quadrilaterals), and a blade with cells of edge ratio 2e5 that is turned by
180 degrees (hexahedra); both fold in one step. Also: the same bytes on one thread and two.
"""

import itertools
import json

import numpy as np
import pyvista

from program import azimesh, report, scratch

# Corners of the square and the cube in VTK's order.
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
CUBE = np.vstack([SQUARE, SQUARE + [0, 0, 1]])


def jacobians(points, cells, n):
    """The Jacobian of every cell at n points along each axis, corners included."""
    solid = cells.shape[1] == 8
    corners, axes = (CUBE, 3) if solid else (SQUARE, 2)
    found = []
    for at in itertools.product(np.linspace(0, 1, n), repeat=axes):
        factors = np.array([np.where(corners[:, k] == 1, at[k], 1 - at[k]) for k in range(axes)])
        columns = []
        for k in range(axes):
            slopes = np.where(corners[:, k] == 1, 1.0, -1.0) * np.delete(factors, k, axis=0).prod(axis=0)
            columns.append(np.einsum("c,mcx->mx", slopes, points[cells]))
        if not solid:
            columns.append(np.broadcast_to([0.0, 0.0, 1.0], columns[0].shape))
        found.append(np.einsum("mx,mx->m", columns[0], np.cross(columns[1], columns[2])))
    return np.array(found)
TURNED = """
azimuth.values = [0.0, 1.0]
boundaries.fixed = ["outer"]
rbf = { support_radius = 5.625, rotation_radius = 5.625, interpolate = "twist", substeps = 8 }
[[body]]
name = "blade"
tags = ["blade"]
rigid = { rotate = { axis = [1.0, 0.0, 0.0], origin = [0.0, 0.0, 0.0], angle = 180.0 }, ramp = true }
"""

# Steps stay as they fold.
FOLDED = """
[output]
on_inverted = "warn"
"""


def check(folder, name, mesh, schedule, kind):
    """Deforms, repairs and judges; the number of cells that were folded."""
    azimesh("deform", mesh, schedule, "-o", folder / name, expect=(0, 1))
    folded = sorted((folder / name).glob("*.vtu"))[-1]
    outputs = [folder / f"{name}_{n}.vtu" for n in (1, 2)]
    for n, out in zip((1, 2), outputs):
        told = json.loads(azimesh("repair", folded, "-o", out, "--reference", mesh, "--threads", n, "--json"))
    assert outputs[0].read_bytes() == outputs[1].read_bytes(), f"{name}: two threads give other bytes than one"
    before, after, reference = (pyvista.read(path) for path in (folded, outputs[0], mesh))
    cells = after.cells_dict[kind]
    sign = np.sign(jacobians(reference.points, cells, 2)).min(axis=0)
    assert (sign != 0).all(), f"{name}: the reference has flat cells"
    bad = lambda grid, n: ((jacobians(np.asarray(grid.points, float), cells, n) * sign) <= 0).any(axis=0)  # noqa: E731
    n_before = int(bad(before, 2).sum())
    assert n_before > 10, f"{name}: only {n_before} cells are folded before"
    assert n_before <= told["invalid_before"], f"{name}: {n_before} folded corners, {told['invalid_before']} told"
    assert not bad(after, 5).any(), f"{name}: {bad(after, 5).sum()} cells are folded after the repair"
    moved = np.flatnonzero((before.points != after.points).any(axis=1))
    assert 0 < len(moved) <= sum(patch["nodes"] for patch in told["patches"]), f"{name}: {len(moved)} nodes have moved"
    boundary = np.unique(np.concatenate([grid_cells.ravel() for other, grid_cells in after.cells_dict.items() if other != kind]))
    assert len(boundary) and not np.isin(moved, boundary).any(), f"{name}: nodes of the boundary have moved"
    return n_before


def main():
    """Repairs both meshes."""
    with scratch() as folder:
        azimesh("sample", "block", "-o", folder / "block.vtu")
        text = (folder / "block.toml").read_text().replace("angle = 60.0", "angle = 100.0")
        (folder / "turned_block.toml").write_text(text + FOLDED)
        n = check(folder, "block", folder / "block.vtu", folder / "turned_block.toml", 9)
        azimesh("sample", "blade", "--nodes", "20000", "-o", folder / "blade.vtu")
        (folder / "turned_blade.toml").write_text(TURNED + FOLDED)
        n += check(folder, "blade", folder / "blade.vtu", folder / "turned_blade.toml", 12)
    report("repair", n, 0, "folded cells", "all valid after the repair")

"""sqrt(f_size) f_skew of cells, by Knupp's matrices, and the angle of first cells at moving walls, from the meshes alone.

docs/method.md has the equations, docs/boundaries.md the best published figures of the turned block.
At corner k of a cell the edges to its neighbours are the columns of A_k; W is the matrix of the ideal cell there.
"""

import numpy as np
import pyvista

import faces
import outputs
from program import TESTDATA, report, scratch

LEAST, MEAN = 0.19, 0.66
TOLERANCE = 1e-10
MESHES = ["mixed_cells_inline.vtu", "sphere_in_box_raw.vtu", "hart_ii.vtu", "airfoil_hybrid_ascii.vtu", "naca0012.vtu"]
RUNS = ["block_sliding", "body_in_duct", "hart_ii"]

HEIGHT = np.sqrt(0.75)
# VTK cell type: neighbours of each corner in a right-handed order, and the edges of the ideal cell there.
SQUARE, CUBE = np.eye(2), np.eye(3)
TRIANGLE = np.array([[1, 0.5], [0, HEIGHT]])
TETRAHEDRON = np.array([[1, 0.5, 0.5], [0, HEIGHT, HEIGHT / 3], [0, 0, np.sqrt(2 / 3)]])
PRISM = np.array([[1, 0.5, 0], [0, HEIGHT, 0], [0, 0, 1]])
PYRAMID = np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, np.sqrt(0.5)]])
RING = [[1, 3], [2, 0], [3, 1], [0, 2]]
CORNERS = {
    5: ([[1, 2]], TRIANGLE), 9: (RING, SQUARE), 10: ([[1, 2, 3]], TETRAHEDRON), 14: ([[a, b, 4] for a, b in RING], PYRAMID),
    13: ([[1, 2, 3], [2, 0, 4], [0, 1, 5], [5, 4, 0], [3, 5, 1], [4, 3, 2]], PRISM),
    12: ([[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]], CUBE),
}  # fmt: skip


def matrices(kind, points, cells):
    """A_k of each corner of each cell, (corners, cells, d, d), edges as columns."""
    neighbours, ideal = CORNERS[kind]
    d = len(ideal)
    x = points[cells][..., :d]
    return np.array([[x[:, n] - x[:, k] for n in around] for k, around in enumerate(neighbours)]).transpose(0, 2, 3, 1)


def skew(kind, at):
    """f_skew of cells from the matrices of their corners, whose determinants are positive."""
    ideal = CORNERS[kind][1]
    d = len(ideal)
    scaled = at @ np.linalg.inv(ideal)
    ratio = (scaled**2).sum(axis=(2, 3)) / (d * np.abs(np.linalg.det(scaled)) ** (2 / d))
    if kind in (5, 10):
        return 1 / ratio[0]
    if kind == 14:
        return 1 / ratio.mean(axis=0)
    unit = at / np.linalg.norm(at, axis=2, keepdims=True)
    ideal = np.linalg.det(ideal / np.linalg.norm(ideal, axis=0))
    power = 1 if d == 2 else 2 / 3
    return 1 / ((np.abs(np.linalg.det(unit)) / ideal) ** -power).mean(axis=0)


def size_skew(kind, cells, reference, points):
    """sqrt(f_size) f_skew of cells of one kind; NaN where corners are not all valid in the reference."""
    before = np.linalg.det(matrices(kind, reference, cells))
    at = matrices(kind, points, cells)
    sign = np.sign(before.sum(axis=0))
    now = np.linalg.det(at)
    valid = (now * sign > 0).all(axis=0)
    tau = np.where(valid, now.sum(axis=0) / before.sum(axis=0), 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        value = np.where(valid, np.sqrt(np.minimum(tau, 1 / tau)) * skew(kind, at), 0.0)
    return np.where((before * sign > 0).all(axis=0), value, np.nan)


def of_grid(grid, reference, points):
    """Of every cell of the mesh's own dimension; NaN for all others."""
    solid = bool(set(grid.celltypes.tolist()) & {10, 12, 13, 14})
    found = np.full(grid.n_cells, np.nan)
    for kind in CORNERS:
        if len(CORNERS[kind][1]) == 2 + solid and kind in grid.cells_dict:
            found[grid.celltypes == kind] = size_skew(kind, grid.cells_dict[kind], reference, points)
    return found


def compare_cells(name):
    """The cell array of `azimesh quality` on a shaken mesh; (values compared, largest difference)."""
    grid = pyvista.read(TESTDATA / name)
    points = faces.shaken(grid)
    before = np.asarray(grid.points, float)
    results, out = faces.judged(grid, points)
    own = np.array([cell.dimension for cell in grid.cell])
    own = own == own.max()
    wanted, found = of_grid(grid, before, points)[own], np.asarray(out.cell_data["SizeSkew"])[own]
    assert (np.isnan(wanted) == np.isnan(found)).all(), f"{name}: not defined for the same cells"
    known = ~np.isnan(wanted)
    differences = [
        np.abs(wanted - found)[known].max(), abs(results["min_size_skew"] - wanted[known].min()),
        abs(results["mean_size_skew"] - wanted[known].mean()),
    ]  # fmt: skip
    return known.sum() + 2, max(differences)


def wall_faces(grid, tag):
    """Nodes of each face of a tag and of the cell on it."""
    names = list(map(str, grid.field_data["BoundaryTagNames"]))
    tagged = np.flatnonzero(grid.cell_data["BoundaryTag"] == names.index(tag) + 1)
    tagged = {tuple(sorted(grid.get_cell(cell).point_ids)): grid.get_cell(cell).point_ids for cell in tagged}
    found = []
    for cell in grid.cell:
        parts = cell.faces if cell.dimension == 3 else cell.edges if cell.dimension == 2 else []
        for part in parts:
            key = tuple(sorted(part.point_ids))
            if key in tagged and tuple(sorted(cell.point_ids)) != key:
                found.append((tagged[key], cell.point_ids))
    assert len(found) == len(tagged), "every face of the wall has its cell"
    return found


def lean(points, wall, side=None):
    """Angle between the normal of each face and the line to its cell in degrees, and the normal's sign."""
    normals = np.array([faces.centre_and_area(points, face)[1] for face, _ in wall])
    lines = np.array([points[cell].mean(axis=0) - points[face].mean(axis=0) for face, cell in wall])
    along = (normals * lines).sum(axis=1)
    side = np.sign(along) if side is None else side
    return faces.angle(side * along / np.linalg.norm(normals, axis=1) / np.linalg.norm(lines, axis=1)), side


def compare_run(name):
    """Columns of steps.csv of a run; (values compared, largest difference, values of the last step)."""
    mesh = TESTDATA / f"{name.removesuffix('_sliding')}.vtu"
    tag = {"block_sliding": "block", "body_in_duct": "body", "hart_ii": "blade"}[name]
    grid = pyvista.read(mesh)
    before = np.array(grid.points, float)
    wall = wall_faces(grid, tag)
    angle, side = lean(before, wall)
    n, largest = 0, 0.0
    with scratch() as folder:
        rows = outputs.deform(mesh, TESTDATA / f"{name}.toml", folder / "out")
        for row in rows:
            points = outputs.points(folder / "out", row)
            values = of_grid(grid, before, points)
            wanted = {"min_size_skew": np.nanmin(values), "mean_size_skew": np.nanmean(values)}
            found = {column: abs(float(row[column]) - value) for column, value in wanted.items()}
            # An angle near zero is known to half the digits only from its cosine.
            turned = np.abs(lean(points, wall, side)[0] - angle).max()
            turn = abs(float(row["max_normal_change_deg"]) - turned)
            assert turn < 1e-5, f"{name}: walls turn by {row['max_normal_change_deg']}, not {turned}"
            n, largest = n + 3, max(largest, *found.values())
    return n, largest, wanted


def main():
    """Cells, then whole runs; the block as good as it was, one interpolation from the reference mesh."""
    for compare, names, what in ((compare_cells, MESHES, "cells"), (compare_run, RUNS, "steps")):
        n, largest = 0, 0.0
        for name in names:
            count, difference, *last = compare(name)
            assert difference < TOLERANCE, f"{name}: size-skew differs by {difference:.3g}"
            n, largest = n + count, max(largest, difference)
            if name == "block_sliding":
                least, mean = last[0].values()
        report(f"size-skew of {what} beside numpy", n, largest, note=", ".join(names))
    print(f"turned block: size-skew at least {least:.4f}, mean {mean:.4f}", flush=True)
    assert least >= LEAST and mean >= MEAN, f"least {LEAST} and mean {MEAN} are to be reached"

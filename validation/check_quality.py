"""Compares every metric of `azimesh quality` with VTK's vtkMeshQuality, cell by cell.

    python validation/check_quality.py [--azimesh PROGRAM] [--total] MESH...

Needs pyvista (checked with 0.49.1, VTK 9.7.2). The program writes its metrics as cell arrays of a VTU file; VTK
computes its own on the same file. Differences are relative where the value is above 1 (volume and Jacobian: relative to
the cell's size to the third power). What VTK has otherwise, and how it is compared:

- A solid cell with its nodes in reverse order has negative volume in VTK: its mirror image is compared, which is the
  same cell with its nodes in VTK's order.
- In 2D VTK's area and scaled Jacobian have no sign, and it shows 0 for a pyramid with a negative one.
- VTK takes 1e-30 for zero, whatever the unit: the mesh is scaled by a power of two, which is exact, before VTK sees it.
  Where VTK shows 1e30, azimesh has infinity.
- Three faults of VTK, each shown to be the whole difference by the same formula in numpy: the edge ratio of hexahedra
  leaves out half of the edges when it looks for the longest, the smallest angle of tetrahedra takes two of the six for
  180 degrees less them, the shape of pyramids leaves out the longer of the first two edges when it looks for the longest.
- The skew of hexahedra: VTK adds corners before it takes differences, which costs thin cells their digits. Where it is
  off by more than the tolerance, azimesh is compared with numpy in 80 bits.
- An angle close to 0 or 180 degrees ends in an arc cosine that has lost half of the digits, in VTK as here: angles
  and skew are compared by their cosines there.

Exits with 1 on a difference above 1e-10. --total prints one table over all meshes.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import pyvista as pv
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

TOLERANCE = 1e-10
TRIANGLE, QUAD, TET, HEX, WEDGE, PYRAMID = 5, 9, 10, 12, 13, 14
NAMES = {TRIANGLE: "Triangle", QUAD: "Quad", TET: "Tet", HEX: "Hex", WEDGE: "Wedge", PYRAMID: "Pyramid"}
CORNERS = {TRIANGLE: 3, QUAD: 4, TET: 4, HEX: 8, WEDGE: 6, PYRAMID: 5}
PLANE = (TRIANGLE, QUAD)
SOLID = (TET, HEX, WEDGE, PYRAMID)
# Cell array: kinds for which VTK has the metric; "Volume" is its "Area" in 2D.
METRICS = {
    "Volume": PLANE + SOLID,
    "ScaledJacobian": PLANE + SOLID,
    "EdgeRatio": (TRIANGLE, QUAD, TET, HEX, WEDGE),
    "EquiangleSkew": PLANE + SOLID,
    "Jacobian": (QUAD, *SOLID),
    "AspectRatio": (TRIANGLE, QUAD, TET),
    "Condition": (TRIANGLE, QUAD, TET, HEX, WEDGE),
    "Shape": PLANE + SOLID,
    "MinAngle": (TRIANGLE, QUAD, TET),
    "MaxAngle": (TRIANGLE, QUAD),
    "Skew": (QUAD, HEX),
}
WITH_SIZE = ("Volume", "Jacobian")
HEX_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
PYRAMID_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)]


def by_vtk(grid, metric):
    """VTK's value of a metric for every cell; what a kind does not have is left as it comes."""
    judge = vtkMeshQuality()
    judge.SetInputData(grid)
    for kind in METRICS[metric]:
        name = "Area" if metric == "Volume" and kind in PLANE else metric
        getattr(judge, f"Set{NAMES[kind]}QualityMeasureTo{name}")()
    judge.Update()
    return pv.wrap(judge.GetOutput()).cell_data["Quality"].copy()


def extent(grid):
    """Longest side of each cell's box."""
    points = grid.points[grid.cell_connectivity]
    starts = grid.cell_offsets[:-1]
    return (np.maximum.reduceat(points, starts) - np.minimum.reduceat(points, starts)).max(axis=1)


def corners(grid, chosen, kind, flipped):
    """Corners of the chosen cells of a kind, mirrored where they are the other way round."""
    starts = grid.cell_offsets[:-1][chosen]
    points = grid.points[grid.cell_connectivity[starts[:, None] + np.arange(CORNERS[kind])]].copy()
    points[flipped[chosen], :, 0] *= -1
    return points


def lengths(points, edges):
    return np.stack([np.linalg.norm(points[:, b] - points[:, a], axis=1) for a, b in edges], axis=1)


def hex_edge_ratio(points):
    """The edge ratio, and VTK's with the longest of the first six edges."""
    edges = lengths(points, HEX_EDGES)
    return edges.max(axis=1) / edges.min(axis=1), edges[:, :6].max(axis=1) / edges.min(axis=1)


def tet_min_angle(points):
    """The smallest dihedral angle, and VTK's with the supplements of those at edges 02 and 13."""
    a, b, c, d = points.transpose(1, 0, 2)
    abc, abd = np.cross(b - a, c - b), np.cross(b - a, d - a)
    acd, bcd = np.cross(d - a, d - c), np.cross(c - b, d - c)

    def cosine(u, v):
        return (u * v).sum(axis=1) / (np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1))

    right = [cosine(abc, abd), cosine(abc, bcd), cosine(abd, acd), cosine(acd, bcd)]
    turned = [cosine(abc, acd), cosine(abd, bcd)]
    largest = [np.max(right + [sign * cosine for cosine in turned], axis=0) for sign in (-1, 1)]
    return tuple(np.degrees(np.arccos(np.clip(cosine, -1, 1))) for cosine in largest)


def pyramid_shape(points):
    """The shape, and VTK's with the shorter of the first two edges and the normal at the first corner of the base."""
    base = pv.UnstructuredGrid({pv.CellType.QUAD: np.arange(4 * len(points)).reshape(-1, 4)}, points[:, :4].reshape(-1, 3))
    shape = by_vtk(base, "Shape")
    a, b, c, d, apex = points.transpose(1, 0, 2)
    up = apex - (a + b + c + d) / 4
    base_corners = ((a, b, d), (b, c, a), (c, d, b), (d, a, c))
    jacobians = [(np.cross(second - at, last - at) * (apex - at)).sum(axis=1) for at, second, last in base_corners]
    folded = np.min(jacobians, axis=0) <= 0
    edges = lengths(points, PYRAMID_EDGES)
    vtk_edge = np.maximum(edges[:, :2].min(axis=1), edges[:, 2:].max(axis=1))
    values = []
    ways = ((np.cross(c - a, d - b), edges.max(axis=1), folded), (np.cross(b - a, d - a), vtk_edge, False))
    for normal, edge, is_zero in ways:
        height = (up * normal).sum(axis=1) / np.linalg.norm(normal, axis=1)
        ideal = edge / np.sqrt(2)
        value = shape * height / np.linalg.norm(up, axis=1) * np.minimum(height / ideal, ideal / height)
        values.append(np.where((height > 0) & ~np.asarray(is_zero), value, 0))
    return tuple(values)


def hex_skew(points):
    """The skew in 80 bits: VTK adds corners before it takes differences, and how it rounds is its own."""
    corners = points.astype(np.longdouble).transpose(1, 0, 2)
    axes = []
    for ends, starts in (((1, 2, 5, 6), (0, 3, 4, 7)), ((2, 3, 6, 7), (1, 0, 5, 4)), ((4, 5, 6, 7), (0, 1, 2, 3))):
        axis = sum(corners[end] - corners[start] for end, start in zip(ends, starts))
        axes.append(axis / np.sqrt((axis * axis).sum(axis=1))[:, None])
    x, y, z = axes
    cosines = [abs((a * b).sum(axis=1)) for a, b in ((x, y), (x, z), (y, z))]
    return np.max(cosines, axis=0).astype(float), None


FAULTS = {
    ("EdgeRatio", HEX): hex_edge_ratio,
    ("MinAngle", TET): tet_min_angle,
    ("Shape", PYRAMID): pyramid_shape,
    ("Skew", HEX): hex_skew,
}


def judged(program, mesh):
    """The mesh with its metrics, as the program writes it."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.vtu"
        subprocess.run([program, "quality", mesh, "-o", out, "-q"], check=True, capture_output=True)
        grid = pv.read(out)
    grid.points = grid.points.astype(float)
    return grid


def difference(metric, ours, theirs, size):
    """Relative where the value is large; both infinite is equal, and so is both not a number."""
    theirs = np.where(abs(theirs) >= 1e30, np.copysign(np.inf, theirs), theirs)
    same = (ours == theirs) | (np.isnan(ours) & np.isnan(theirs))
    with np.errstate(invalid="ignore"):
        apart = abs(ours - theirs) / (size if metric in WITH_SIZE else np.maximum(1, abs(theirs)))
        if metric.endswith("Angle") or metric == "EquiangleSkew":
            # 1e-16 in the cosine is 1e-8 in an angle close to 0 or 180 degrees, where the skew is close to 1.
            turned = np.pi / 2 * (1 + ours), np.pi / 2 * (1 + theirs)
            if metric.endswith("Angle"):
                turned = np.radians(ours), np.radians(theirs)
            blunt = abs(np.cos(turned[0]) - np.cos(turned[1]))
            apart = np.minimum(apart, np.where(apart < 1e-5, blunt, apart))
    return np.where(same, 0, np.where(np.isnan(apart), np.inf, apart))


def compare(program, mesh):
    """{(metric, kind): (cells, largest difference, cells where VTK has a fault)} of a mesh."""
    grid = judged(program, mesh)
    found = {name: np.array(grid.cell_data[name]) for name in METRICS}
    kinds = grid.celltypes
    # Boundary faces have the values of the cells that they bound.
    dimensions = {kind: grid.get_cell(int(np.argmax(kinds == kind))).dimension for kind in np.unique(kinds)}
    own = [kind for kind, dimension in dimensions.items() if dimension == max(dimensions.values())]
    is_volume = np.isfinite(found["Volume"]) & np.isin(kinds, list(CORNERS)) & np.isin(kinds, own)
    if not is_volume.any():
        return {}
    scale = 2.0 ** -np.round(np.log2(np.median(extent(grid)[is_volume])))
    dimension = np.where(np.isin(kinds, SOLID), 3, 2)
    for name in WITH_SIZE:
        found[name] *= scale**dimension
    grid.points *= scale
    mirrored = grid.copy()
    mirrored.points = grid.points * [-1, 1, 1]
    flipped = np.isin(kinds, SOLID) & (by_vtk(grid, "Volume") < 0)
    size = extent(grid) ** dimension
    results = {}
    for metric, known in METRICS.items():
        theirs = np.where(flipped, by_vtk(mirrored, metric), by_vtk(grid, metric))
        for kind in known:
            chosen = np.flatnonzero(is_volume & (kinds == kind))
            if len(chosen) == 0:
                continue
            a, b = found[metric][chosen].copy(), theirs[chosen].copy()
            n_faults = 0
            if metric in ("Volume", "ScaledJacobian") and kind in PLANE:
                a, b = abs(a), abs(b)
            if (metric, kind) == ("ScaledJacobian", PYRAMID):
                a = np.maximum(a, 0)
            apart = np.zeros(len(a))
            if (metric, kind) in FAULTS:
                right, faulty = FAULTS[metric, kind](corners(grid, chosen, kind, flipped))
                faulty = b if faulty is None else faulty
                apart = difference(metric, faulty, b, size[chosen])
                wrong = difference(metric, faulty, right, size[chosen]) > TOLERANCE
                n_faults = int(wrong.sum())
                b = np.where(wrong, right, b)
            apart = np.maximum(apart, difference(metric, a, b, size[chosen]))
            results[metric, kind] = (len(chosen), float(apart.max()), n_faults, int(chosen[apart.argmax()]))
    return results


def check(program, mesh):
    """Compares one mesh and prints a line; gives whether it is good, and the differences."""
    results = compare(program, mesh)
    n_cells = {NAMES[kind]: n for (metric, kind), (n, *_) in results.items() if metric == "Volume"}
    bad = {key: result for key, result in results.items() if not result[1] <= TOLERANCE}
    largest = max((apart for _, apart, *_ in results.values()), default=0.0)
    cells = ", ".join(f"{n} {name}" for name, n in n_cells.items())
    print(f"{'DIFFERENT' if bad else 'ok'}: {mesh}: {cells}; largest difference {largest:.1e}", flush=True)
    for (metric, kind), (_, apart, _, cell) in bad.items():
        print(f"    {metric} of {NAMES[kind]}: {apart:.3e} at cell {cell}", flush=True)
    return not bad, results


def total(results):
    """One table over all meshes: cells compared and largest difference, by metric and kind."""
    sums = {}
    for key, (n, apart, n_faults, _) in (item for result in results for item in result.items()):
        cells, largest, faults = sums.get(key, (0, 0.0, 0))
        sums[key] = (cells + n, max(largest, apart), faults + n_faults)
    kinds = [kind for kind in NAMES if any(key[1] == kind for key in sums)]
    cells = [f"{sums['Volume', kind][0]:,}" for kind in kinds]
    print("| metric | " + " | ".join(NAMES[kind] for kind in kinds) + " |")
    print("|---|" + "---|" * len(kinds))
    print("| cells | " + " | ".join(cells) + " |")
    for metric in METRICS:
        row = []
        for kind in kinds:
            _, apart, faults = sums.get((metric, kind), (0, None, 0))
            note = f" ({faults:,} VTK's fault)" if faults else ""
            row.append("" if apart is None else f"{apart:.1e}{note}")
        print(f"| {metric} | " + " | ".join(row) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--azimesh", default="target/release/azimesh")
    parser.add_argument("--total", action="store_true", help="a table over all meshes")
    parser.add_argument("mesh", nargs="+")
    args = parser.parse_args()
    checked = [check(args.azimesh, mesh) for mesh in args.mesh]
    if args.total:
        total([results for _, results in checked])
    sys.exit(0 if all(good for good, _ in checked) else 1)


if __name__ == "__main__":
    main()

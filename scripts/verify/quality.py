"""Every metric of every cell of testdata and of meshes by others against VTK's vtkMeshQuality (checked with VTK 9.7.2).

The program writes its metrics as cell arrays of a VTU file; VTK computes its own on the same file. Differences are relative where the value is above 1
(volume and Jacobian: relative to the cell's size to the third power). What VTK has otherwise, and how it is compared:

- A solid cell with its nodes in reverse order has negative volume in VTK: its mirror image is compared, which is the
  same cell with its nodes in VTK's order.
- In 2D VTK's area and scaled Jacobian have no sign, and it shows 0 for a pyramid with a negative one.
- VTK takes 1e-30 for zero, whatever the unit: the mesh is scaled by a power of two, which is exact, before VTK sees it.
  Where VTK shows 1e30, azimesh has infinity.
- Numpy takes VTK's place where VTK has faults (EXACT): the edge ratio of hexahedra leaves out half of the edges when it looks for the longest, the
  smallest angle of tetrahedra takes two of the six for 180 degrees less them, the shape of pyramids leaves out the longer of the first two edges;
  the skew of hexahedra adds corners before it takes differences, which costs thin cells their digits (here in 80 bits).
- An angle close to 0 or 180 degrees ends in an arc cosine that has lost half of the digits, in VTK as here: angles
  and skew are compared by their cosines there.
"""

import sys

import numpy as np
import pyvista as pv
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

from formats import sources
from program import azimesh, real_meshes, report, scratch

TOLERANCE = 1e-10
TRIANGLE, QUAD, TET, HEX, WEDGE, PYRAMID = 5, 9, 10, 12, 13, 14
NAMES = {TRIANGLE: "Triangle", QUAD: "Quad", TET: "Tet", HEX: "Hex", WEDGE: "Wedge", PYRAMID: "Pyramid"}
CORNERS = {TRIANGLE: 3, QUAD: 4, TET: 4, HEX: 8, WEDGE: 6, PYRAMID: 5}
PLANE = (TRIANGLE, QUAD)
SOLID = (TET, HEX, WEDGE, PYRAMID)
# Cell array: kinds for which VTK has the metric; "Volume" is its "Area" in 2D.
METRICS = {
    "Volume": PLANE + SOLID, "ScaledJacobian": PLANE + SOLID, "EdgeRatio": (TRIANGLE, QUAD, TET, HEX, WEDGE), "EquiangleSkew": PLANE + SOLID,
    "Jacobian": (QUAD, *SOLID), "AspectRatio": (TRIANGLE, QUAD, TET), "Condition": (TRIANGLE, QUAD, TET, HEX, WEDGE), "Shape": PLANE + SOLID,
    "MinAngle": (TRIANGLE, QUAD, TET), "MaxAngle": (TRIANGLE, QUAD), "Skew": (QUAD, HEX),
}  # fmt: skip
WITH_SIZE = ("Volume", "Jacobian")
HEX_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
PYRAMID_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)]
# Meshes by others with cells of all kinds: boundary layers, surfaces in space, flat and tangled cells among them.
REAL = [
    "su2code__TestCases/hom_navierstokes/SphereViscous/nPoly1/SphereViscous_Linear.su2.gz",
    "su2code__TestCases/incomp_navierstokes/sphere/slice_2syms.su2", "su2code__TestCases/deformation/brick_hex/mesh_brick_hex_ffd.su2",
    "su2code__TestCases/actuator_disk/ActuatorDisk_I.su2", "su2code__TestCases/navierstokes/naca0012/mesh_NACA0012_lam_hybrid_v1.su2",
    "su2code__TestCases/aeroelastic/mesh_NACA64A010_hybrid_inv.su2", "su2code__TestCases/fea_fsi/Airfoil_RBF/mesh.su2",
    "gen_openfoam1912/wingMotion2D/wingMotion2D_tagged.vtu", "gen_openfoam1912/wingMotion2D/internal_with_polyhedra.vtu",
    "gen_openfoam1912/naca0012_adjoint/naca0012_tagged.vtu", "gen_gmsh4.15/wing_fuselage_12k.cgns", "gen_gmsh4.15/naca12BL_v41_bin.msh",
    "gen_adf2hdf_libcgns3.4/FVENS_n0012_113-33_hex.h5.cgns", "gen_adf2hdf_libcgns3.4/SU2_mesh_bend_coarse.h5.cgns",
    "gen_adf2hdf_libcgns3.4/mdolab_717_wl_L2_structured.h5.cgns", "pyvista__vtk-data/Data/AngularSector.vtk",
    "Slaedr__FVENS/testcases/visc-cylinder/grids/2dcylinderhybrid3.msh", "Slaedr__amovemesh/input/qin-mesh.msh",
    "dealii__dealii/examples/step-97/sphere_r6.msh", "dealii__dealii/examples/step-70/impeller.vtk",
    "dealii__dealii/tests/mesquite/mesh/3d/hex_5_tangled.vtk", "dealii__dealii/tests/mesquite/mesh/2d/hole_in_square_tanglap.vtk",
    "debian_gmsh-4.8.4/benchmarks/3d/discrete.msh", "mfem__mfem/data/sphere.msh",
]  # fmt: skip


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


def hex_edge_ratio(points):
    """The longest edge to the shortest."""
    edges = np.stack([np.linalg.norm(points[:, b] - points[:, a], axis=1) for a, b in HEX_EDGES], axis=1)
    return edges.max(axis=1) / edges.min(axis=1)


def tet_min_angle(points):
    """The smallest dihedral angle."""
    a, b, c, d = points.transpose(1, 0, 2)
    outward = [np.cross(b - a, d - a), np.cross(c - b, d - b), np.cross(a - c, d - c), np.cross(c - a, b - a)]
    unit = [normal / np.linalg.norm(normal, axis=1)[:, None] for normal in outward]
    cosines = [-(unit[i] * unit[j]).sum(axis=1) for i in range(4) for j in range(i)]
    return np.degrees(np.arccos(np.clip(np.max(cosines, axis=0), -1, 1)))


def pyramid_shape(points):
    """That of the base, less by how far the apex leans and how high it is."""
    base = pv.UnstructuredGrid({pv.CellType.QUAD: np.arange(4 * len(points)).reshape(-1, 4)}, points[:, :4].reshape(-1, 3))
    a, b, c, d, apex = points.transpose(1, 0, 2)
    up, normal = apex - (a + b + c + d) / 4, np.cross(c - a, d - b)
    base_corners = ((a, b, d), (b, c, a), (c, d, b), (d, a, c))
    folded = np.min([(np.cross(second - at, last - at) * (apex - at)).sum(axis=1) for at, second, last in base_corners], axis=0) <= 0
    edge = np.max([np.linalg.norm(points[:, j] - points[:, i], axis=1) for i, j in PYRAMID_EDGES], axis=0)
    height, ideal = (up * normal).sum(axis=1) / np.linalg.norm(normal, axis=1), edge / np.sqrt(2)
    value = by_vtk(base, "Shape") * height / np.linalg.norm(up, axis=1) * np.minimum(height / ideal, ideal / height)
    return np.where((height > 0) & ~folded, value, 0)


def hex_skew(points):
    """The largest cosine between two of the axes, in 80 bits."""
    corners = points.astype(np.longdouble).transpose(1, 0, 2)
    axes = []
    for ends, starts in (((1, 2, 5, 6), (0, 3, 4, 7)), ((2, 3, 6, 7), (1, 0, 5, 4)), ((4, 5, 6, 7), (0, 1, 2, 3))):
        axis = sum(corners[end] - corners[start] for end, start in zip(ends, starts))
        axes.append(axis / np.sqrt((axis * axis).sum(axis=1))[:, None])
    x, y, z = axes
    return np.max([abs((a * b).sum(axis=1)) for a, b in ((x, y), (x, z), (y, z))], axis=0).astype(float)


EXACT = {("EdgeRatio", HEX): hex_edge_ratio, ("MinAngle", TET): tet_min_angle, ("Shape", PYRAMID): pyramid_shape, ("Skew", HEX): hex_skew}


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
            apart = np.minimum(apart, np.where(apart < 1e-5, abs(np.cos(turned[0]) - np.cos(turned[1])), apart))
    return np.where(same, 0, np.where(np.isnan(apart), np.inf, apart))


def compare(path, folder):
    """{(metric, kind): (cells, largest difference, its cell)} of a mesh."""
    azimesh("quality", path, "-o", folder / "judged.vtu", "--force")
    grid = pv.read(folder / "judged.vtu")
    grid.points = grid.points.astype(float)
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
    # A plane cell that faces the other way than its neighbours is inverted; VTK gives it the values of its own side.
    backwards = np.isin(kinds, PLANE) & (found["Volume"] < 0)
    size, results = extent(grid) ** dimension, {}
    for metric, known in METRICS.items():
        theirs = np.where(flipped, by_vtk(mirrored, metric), by_vtk(grid, metric))
        for kind in known:
            skipped = backwards & (metric not in ("Volume", "ScaledJacobian"))
            chosen = np.flatnonzero(is_volume & (kinds == kind) & ~skipped)
            if len(chosen) == 0:
                continue
            a, b = found[metric][chosen], theirs[chosen]
            if metric in ("Volume", "ScaledJacobian") and kind in PLANE:
                a, b = abs(a), abs(b)
            if (metric, kind) == ("ScaledJacobian", PYRAMID):
                a = np.maximum(a, 0)
            if (metric, kind) in EXACT:
                b = EXACT[metric, kind](corners(grid, chosen, kind, flipped))
            apart = difference(metric, a, b, size[chosen])
            results[metric, kind] = (len(chosen), float(apart.max()), int(chosen[apart.argmax()]))
    return results


def main():
    """Fails with the first mesh that differs."""
    real, n, largest, seen = real_meshes(), 0, 0.0, set()
    if real is None:
        print("quality: AZIMESH_TESTDATA is not set: real meshes are SKIPPED", file=sys.stderr)
    paths = sources() + ([] if real is None else [real / name for name in REAL])
    with scratch() as folder:
        for path in paths:
            for (metric, kind), (n_cells, apart, cell) in compare(path, folder).items():
                assert apart <= TOLERANCE, f"{path}: {metric} of {NAMES[kind]} {cell} is off by {apart:.3e}"
                n, largest = n + n_cells, max(largest, apart)
                seen.add((metric, kind))
    missing = {(metric, kind) for metric, known in METRICS.items() for kind in known} - seen
    assert not missing, f"no mesh has {missing}"
    report("quality", n, largest, "values", f"{len(paths)} meshes beside VTK's mesh quality")

"""`convert --split-polyhedra` against VTK: volumes cell by cell, faces that fit, and files that gmsh and meshio open.

The meshes are Voronoi cells of random points (convex, plane faces of up to a dozen corners), polyhedra_ascii.vtu of
testdata, and a plane mesh of Voronoi polygons.
"""

import gmsh
import meshio
import numpy as np
import pyvista
from scipy.spatial import Voronoi

from meshes import quiet_gmsh
from program import TESTDATA, azimesh, report, scratch

N_POINTS = 60
POLYHEDRON, POLYGON, TETRAHEDRON, PYRAMID, TRIANGLE, QUADRILATERAL = 42, 7, 10, 14, 5, 9
# Corners of the faces of tetrahedra and pyramids.
FACES = {
    TETRAHEDRON: [(0, 1, 3), (1, 2, 3), (2, 0, 3), (0, 2, 1)], PYRAMID: [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
}  # fmt: skip


def voronoi(dimension, seed=3):
    """Nodes and faces of the Voronoi cells of random points in the unit box, which their mirror images bound; for
    each cell its faces, and the faces on the box."""
    inside = np.random.default_rng(seed).uniform(size=(N_POINTS, dimension))
    mirrored = [inside]
    for axis in range(dimension):
        for wall in (0.0, 1.0):
            image = inside.copy()
            image[:, axis] = 2 * wall - image[:, axis]
            mirrored.append(image)
    found = Voronoi(np.vstack(mirrored))
    cells, outer = [[] for _ in range(N_POINTS)], []
    for pair, corners in zip(found.ridge_points, found.ridge_vertices):
        for cell in pair[pair < N_POINTS]:
            cells[cell].append(corners)
        if (pair < N_POINTS).sum() == 1:
            outer.append(corners)
    used = np.unique(np.concatenate([np.concatenate(faces) for faces in cells]))
    number = {node: i for i, node in enumerate(used)}
    rename = lambda face: [number[node] for node in face]  # noqa: E731
    return found.vertices[used], [[rename(face) for face in faces] for faces in cells], [rename(face) for face in outer]


def solid():
    """Voronoi polyhedra, with all outer faces as tagged polygons."""
    points, cells, outer = voronoi(3)
    entries, types = [], []
    for faces in cells:
        stream = [len(faces), *(n for face in faces for n in (len(face), *face))]
        entries += [len(stream), *stream]
        types.append(POLYHEDRON)
    for face in outer:
        entries += [len(face), *face]
        types.append(POLYGON)
    grid = pyvista.UnstructuredGrid(np.array(entries), np.array(types, np.uint8), points)
    grid.cell_data["BoundaryTag"] = (np.array(types) == POLYGON).astype(np.int32)
    grid.field_data["BoundaryTagNames"] = ["box"]
    return grid


def plane():
    """Voronoi polygons of the unit square."""
    points, cells, _ = voronoi(2)
    points = np.column_stack([points, np.zeros(len(points))])
    entries = []
    for edges in cells:
        nodes = np.unique(edges)
        away = points[nodes] - points[nodes].mean(axis=0)
        nodes = nodes[np.argsort(np.arctan2(away[:, 1], away[:, 0]))]
        entries += [len(nodes), *nodes]
    return pyvista.UnstructuredGrid(np.array(entries), np.full(len(cells), POLYGON, np.uint8), points)


def sizes(grid):
    """Volume or area of each cell by VTK."""
    found = grid.compute_cell_sizes()
    dimensions = np.array([cell.dimension for cell in grid.cell])
    return np.where(dimensions == 3, found["Volume"], found["Area"]), dimensions


def split(grid, folder):
    """The mesh split, with `origin`: which cell each is a part of."""
    grid.cell_data["origin"] = np.arange(grid.n_cells)
    grid.point_data["place"] = np.asarray(grid.points, float)
    grid.save(folder / "whole.vtu")
    azimesh("convert", folder / "whole.vtu", folder / "parts.vtu", "--split-polyhedra", "--force")
    return pyvista.read(folder / "parts.vtu")


def compare(whole, parts, convex):
    """Volumes cell by cell; the number compared and the largest difference. VTK's volume of a polyhedron is that of its
    convex hull, so that of others is not compared."""
    (before, dimensions), (after, _) = sizes(whole), sizes(parts)
    assert (after > 0).all(), "each part has a positive volume"
    assert not np.isin(parts.celltypes, [POLYHEDRON, POLYGON]).any(), "nothing is left to split"
    summed = np.bincount(parts.cell_data["origin"], after, whole.n_cells)
    chosen = convex & (dimensions > 1)
    assert chosen.sum() > 10, "cells are compared"
    apart = np.abs(summed - before)[chosen] / before[chosen]
    assert apart.max() < 1e-10, f"volumes differ by {apart.max()}"
    new = np.asarray(parts.point_data["place"])[whole.n_points :]
    assert np.abs(new - parts.points[whole.n_points :]).max() < 1e-12, "new nodes have the mean of their nodes"
    return chosen.sum(), apart.max()


def check_faces(parts, n_boundary):
    """Each face belongs to two cells, or to one and a boundary face."""
    count = {}
    for kind, faces in FACES.items():
        for nodes in parts.cells_dict.get(kind, np.empty((0, 5), int)):
            for face in faces:
                key = tuple(sorted(nodes[list(face)]))
                count[key] = count.get(key, 0) + 1
    boundary = [tuple(sorted(face)) for kind in (TRIANGLE, QUADRILATERAL) for face in parts.cells_dict.get(kind, [])]
    assert set(count.values()) == {1, 2}, "no face is of three cells"
    assert sorted(boundary) == sorted(face for face, n in count.items() if n == 1), "faces fit"
    assert len(boundary) > n_boundary, "polygons of the boundary are split too"
    return len(count)


def check_other_programs(folder, parts):
    """SU2 as meshio reads it, MSH as gmsh does."""
    wanted = {kind: len(cells) for kind, cells in parts.cells_dict.items()}
    azimesh("convert", folder / "whole.vtu", folder / "parts.su2", "--split-polyhedra")
    blocks = meshio.read(folder / "parts.su2").cells
    found = {kind: sum(len(b.data) for b in blocks if b.type == kind) for kind in ("tetra", "pyramid")}
    assert found == {"tetra": wanted[TETRAHEDRON], "pyramid": wanted[PYRAMID]}, found
    azimesh("convert", folder / "whole.vtu", folder / "parts.b8.ugrid", "--split-polyhedra")
    azimesh("convert", folder / "whole.vtu", folder / "parts.msh", "--split-polyhedra")
    with quiet_gmsh():
        gmsh.open(str(folder / "parts.msh"))
        volume = 0.0
        for kind, elements, _ in zip(*gmsh.model.mesh.getElements(3)):
            volume += gmsh.model.mesh.getElementQualities(elements, "volume").sum()
        assert abs(volume - 1.0) < 1e-12, f"gmsh finds a volume of {volume}"


def main():
    """One line in all."""
    n, largest = 0, 0.0
    with scratch() as folder:
        whole = solid()
        parts = split(whole, folder)
        results = [compare(whole, parts, np.ones(whole.n_cells, bool))]
        n_faces = check_faces(parts, (whole.celltypes == POLYGON).sum())
        check_other_programs(folder, parts)
        for whole in (plane(), pyvista.read(TESTDATA / "polyhedra_ascii.vtu").cast_to_unstructured_grid()):
            parts = split(whole, folder)
            results.append(compare(whole, parts, np.ones(whole.n_cells, bool)))
    n = sum(int(result[0]) for result in results)
    largest = max(result[1] for result in results)
    report("split", n, largest, "volumes", f"{n_faces} faces fit; gmsh and meshio read the parts")

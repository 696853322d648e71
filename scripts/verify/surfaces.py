"""Surfaces in STL and VTP beside VTK's readers and meshio, by point and by cell, and their files read by azimesh.

What is written is held against the boundary in VTU: every cell by its corners, tags by name; the volume that the triangles enclose is
that of the solid cells, so that normals point out.
"""

from pathlib import Path

import meshio
import numpy as np
import pyvista
import vtk

from program import TESTDATA, azimesh, report, scratch

SOLIDS = ["mixed_cells_inline.vtu", "sphere_in_box_raw.vtu", "wing_on_plane.vtu", "polyhedra_ascii.vtu", "curved_solids_complete_v22.msh"]
PLANES = ["airfoil_hybrid.su2", "naca0012.vtu"]


def corners(points, triangles):
    """Corners of triangles in 32 bits, each from its least corner on, all sorted: the same however nodes are numbered."""
    all_corners = np.asarray(points)[np.asarray(triangles)].astype(np.float32) + 0
    rows = []
    for triangle in all_corners:
        triangle = [tuple(x) for x in triangle.tolist()]
        least = triangle.index(min(triangle))
        rows.append(triangle[least:] + triangle[:least])
    return np.array(sorted(rows))


def polygons(mesh):
    """Node lists of the cells of polygonal data, of dimension 2."""
    return [cell.point_ids for cell in mesh.cell if cell.dimension == 2]


def fans(mesh):
    """Triangles of polygons, each from its first corner."""
    return [[p[0], p[i - 1], p[i]] for p in polygons(mesh) for i in range(2, len(p))]


def enclosed(points, triangles):
    """Volume inside, by the divergence theorem."""
    a, b, c = np.moveaxis(np.asarray(points)[np.asarray(triangles)], 1, 0)
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def by_vtk(path):
    """Points and triangles of an STL file as VTK reads it."""
    reader = vtk.vtkSTLReader()
    reader.SetFileName(str(path))
    reader.MergingOn()
    reader.Update()
    mesh = pyvista.wrap(reader.GetOutput())
    return mesh.points, mesh.faces.reshape(-1, 4)[:, 1:]


def by_meshio(path):
    """Points and triangles of an STL file as meshio reads it."""
    mesh = meshio.read(path)
    return mesh.points, np.vstack([block.data for block in mesh.cells])


def read_back(path, folder):
    """Points and triangles of a file as azimesh reads it, and tags by name."""
    azimesh("convert", path, folder / "back.vtu", "--force")
    mesh = pyvista.read(folder / "back.vtu")
    tags = dict(zip(mesh.field_data.get("BoundaryTagNames", []), range(1, 1000)))
    numbers = mesh.cell_data.get("BoundaryTag", np.zeros(mesh.n_cells, int))
    return mesh.points, mesh.cells.reshape(-1, 4)[:, 1:], {name: int((numbers == n).sum()) for name, n in tags.items()}


def written(name, folder):
    """The surface of one mesh in every way, beside its boundary; cells and points compared, and triangles of the surface."""
    source, n = TESTDATA / name, 0
    if name in SOLIDS:
        azimesh("convert", source, folder / "b.vtu", "--tag-boundary", "connected", "--boundary-only", "--linearize", "--force")
        azimesh("convert", source, folder / "all.vtu", "--tag-boundary", "connected", "--linearize", "--force")
    else:
        azimesh("convert", source, folder / "all.vtu", "--force")
        azimesh("convert", source, folder / "b.vtu", "--force")
    expected = pyvista.read(folder / "b.vtu")
    faces = [cell.point_ids for cell in expected.cell if cell.dimension == 2]
    for options in [(), ("--encoding", "ascii"), ("--encoding", "base64", "--compression", "zlib")]:
        azimesh("convert", folder / "all.vtu", folder / "s.vtp", "--force", *options)
        found = pyvista.read(folder / "s.vtp")
        assert np.array_equal(found.points, expected.points), f"{name}: nodes of VTP"
        cells = polygons(found)
        assert [sorted(c) for c in cells] == [sorted(f) for f in faces], f"{name}: cells of VTP"
        for key in set(expected.cell_data) - {"vtkOriginalCellIds"}:
            own = expected.cell_data[key]
            own = np.concatenate([own[[c.dimension == d for c in expected.cell]] for d in (0, 1, 2)])
            assert np.array_equal(found.cell_data[key], own, equal_nan=True), f"{name}: {key}"
        names = [list(mesh.field_data.get("BoundaryTagNames", [])) for mesh in (expected, found)]
        assert names[0] == names[1], f"{name}: {names}"
        n += found.n_points + found.n_cells
    triangles = fans(found)
    wanted = corners(found.points, triangles)
    if name in SOLIDS:
        solid = pyvista.read(folder / "all.vtu").extract_cells_by_type([10, 12, 13, 14, 42])
        # VTK 9.7 has negative volumes for wedges in the order of VTK up to 9.6.
        volume = np.abs(solid.compute_cell_sizes(length=False, area=False)["Volume"]).sum()
        # Warped faces have no one volume behind them.
        assert abs(enclosed(found.points, triangles) - volume) < 1e-3 * volume, f"{name}: {enclosed(found.points, triangles)}, {volume}"
    for encoding in ("raw", "ascii"):
        path = folder / f"{encoding}.stl"
        azimesh("convert", folder / "all.vtu", path, "--force", "--encoding", encoding)
        for read in (by_vtk, by_meshio):
            assert np.array_equal(corners(*read(path)), wanted), f"{name}: {encoding} STL by {read.__name__}"
            n += len(wanted)
        points, own, tags = read_back(path, folder)
        assert np.array_equal(corners(points, own), wanted), f"{name}: {encoding} STL read back"
    if name in SOLIDS:
        numbers = np.repeat(found.cell_data["BoundaryTag"], [len(p) - 2 for p in polygons(found)])
        assert tags == {tag: int((numbers == i).sum()) for i, tag in enumerate(names[0], 1)}, f"{name}: {tags}"
    return n, (found.points, np.array(triangles))


def others(surface, folder):
    """STL files of VTK and meshio, read by azimesh."""
    points, triangles = surface
    wanted, n = corners(points, triangles), 0
    faces = np.hstack([np.full((len(triangles), 1), 3), triangles])
    mesh = pyvista.PolyData(points, faces.ravel())
    for binary in (False, True):
        mesh.save(folder / "vtk.stl", binary=binary)
        meshio.Mesh(points, [("triangle", triangles)]).write(folder / "meshio.stl", file_format="stl", binary=binary)
        for name in ("vtk.stl", "meshio.stl"):
            back = read_back(folder / name, folder)
            # VTK writes text with six digits.
            if (name, binary) == ("vtk.stl", False):
                assert np.abs(corners(*back[:2]) - wanted).max() < 1e-4 and len(back[1]) == len(wanted)
            else:
                assert np.array_equal(corners(*back[:2]), wanted), f"{name} {binary}"
            n += len(wanted)
    return n


def main():
    """One line."""
    n = 0
    with scratch() as folder:
        for name in SOLIDS + PLANES:
            compared, surface = written(name, Path(folder))
            n += compared
            n += others(surface, Path(folder))
    report("surfaces", n, 0.0, "points, cells and triangles", "STL and VTP beside VTK and meshio, their STL read")

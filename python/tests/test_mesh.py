"""Meshes: views of Rust's memory, made of arrays, and beside what other packages read."""

import gc
import subprocess
import sys
import weakref
from pathlib import Path

import numpy as np
import pytest

import azimesh


def test_points_are_a_view_without_a_copy(wing):
    points = wing.points
    assert points.shape == (wing.n_points, 3) and points.dtype == np.float64
    assert points.__array_interface__["data"][0] == wing.points.__array_interface__["data"][0]
    assert not points.flags.owndata


def test_views_cannot_be_written_to_nor_made_writeable(wing):
    for array in (wing.points, wing.cells["tetra"], wing.cell_index["tetra"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
        if not array.flags.owndata:
            with pytest.raises(ValueError, match="WRITEABLE"):
                array.flags.writeable = True


def test_a_view_outlives_its_mesh(testdata):
    mesh = azimesh.read(testdata / "wing_on_plane.vtu")
    dead = weakref.ref(mesh)
    points, cells = mesh.points, mesh.cells["tetra"]
    expected = points.copy()
    del mesh
    gc.collect()
    assert dead() is None
    assert (points == expected).all() and cells.max() < len(points)


def test_cells_tags_and_zones_are_those_that_vtk_reads(wing, testdata):
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.read(testdata / "wing_on_plane.vtu")
    assert (grid.points == wing.points).all()
    for kind, name in ((pyvista.CellType.TETRA, "tetra"), (pyvista.CellType.TRIANGLE, "triangle")):
        assert (grid.cells_dict[kind] == wing.cells[name]).all()
        assert (np.flatnonzero(grid.celltypes == kind) == wing.cell_index[name]).all()
    faces = np.concatenate(list(wing.tags.values()))
    assert sorted(faces) == sorted(wing.cell_index["triangle"])


def test_tag_nodes_are_those_of_its_faces(wing):
    faces = wing.tag_faces("wing")["triangle"]
    assert (wing.tag_nodes("wing") == np.unique(faces)).all()
    assert len(faces) == len(wing.tags["wing"])


def test_a_tag_that_is_not_there_is_told_with_those_that_are(wing):
    with pytest.raises(azimesh.Error, match="farfield"):
        wing.tag_nodes("wings")


def test_a_mesh_made_of_arrays_has_them(cube):
    assert cube.dimension == 3 and cube.n_cells == 3
    assert list(cube.cells) == ["hexahedron", "quad"]
    assert cube.tag_nodes("top").tolist() == [4, 5, 6, 7]
    assert cube.zones["fluid"].tolist() == [0]
    assert cube.point_data["height"].tolist() == [0, 0, 0, 0, 1, 1, 1, 1]


def test_with_points_moves_a_copy(cube):
    moved = cube.with_points(cube.points + 1.0)
    assert (moved.points == cube.points + 1.0).all()
    assert azimesh.diff(cube, moved).moved_nodes == 8
    assert cube.points[0].tolist() == [0, 0, 0]


def test_with_data_replaces_arrays_of_the_same_name(cube):
    other = cube.with_data(point_data={"height": np.arange(8, dtype=np.float32)}, cell_data={"number": [5, 6, 7]})
    assert other.point_data["height"].dtype == np.float32
    assert other.cell_data["number"].tolist() == [5, 6, 7]


def test_polygons_and_polyhedra_keep_their_faces(tmp_path):
    points = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    quads = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
    stream = [6] + [value for quad in quads for value in (4, *quad)]
    cells = [("polyhedron", (stream, [0, len(stream)])), ("polygon", (quads[0], [0, 4]))]
    mesh = azimesh.Mesh(points, cells, tags={"bottom": [1]})
    azimesh.write(mesh, tmp_path / "one.vtu")
    again = azimesh.read(tmp_path / "one.vtu")
    for name in ("polyhedron", "polygon"):
        for mine, other in zip(mesh.cells[name], again.cells[name]):
            assert (mine == other).all()
    assert not azimesh.diff(mesh, again)


@pytest.mark.parametrize(
    ("points", "cells", "wrong"),
    [
        ([[0, 0]], {}, "(1, 2)"),
        ([[0, 0, np.nan]], {}, "finite"),
        ([[0, 0, 0]] * 3, {"triangle": [[0, 1, 3]]}, "node 3"),
        ([[0, 0, 0]] * 3, {"triangle": [[0, 1, -1]]}, "-1"),
        ([[0, 0, 0]] * 3, {"triangle": [[0, 1]]}, "it must be 3"),
        ([[0, 0, 0]] * 3, {"tetras": [[0, 1, 2, 2]]}, "tetras"),
        ([[0, 0, 0]] * 3, {"polygon": ([0, 1, 2], [0, 4])}, "offsets"),
        ([[0, 0, 0]] * 3, {"polygon": ([0, 1, 2], [3, 0])}, "offsets"),
        ([[0, 0, 0]] * 3, {"polyhedron": ([4, 3, 0], [0, 3])}, "polyhedron"),
    ],
)
def test_what_is_no_mesh_is_told(points, cells, wrong):
    with pytest.raises(azimesh.Error) as told:
        azimesh.Mesh(points, cells)
    assert wrong in str(told.value) and told.value.kind == "input"


@pytest.mark.parametrize("cells", [{"line": [[0.5, 1.0]]}, {"line": [["a", "b"]]}, {"line": [[0, 1j]]}])
def test_cells_are_integers(cells):
    with pytest.raises(TypeError):
        azimesh.Mesh([[0, 0, 0], [1, 0, 0]], cells)


def test_tags_hold_faces_and_zones_cells(cube):
    with pytest.raises(azimesh.Error, match="dimension"):
        azimesh.Mesh(cube.points, dict(cube.cells), tags={"inside": [0]})
    with pytest.raises(azimesh.Error, match="9"):
        azimesh.Mesh(cube.points, dict(cube.cells), tags={"none": [9]})


def test_an_error_has_the_file_and_the_line(tmp_path):
    path = tmp_path / "bad.su2"
    path.write_text("NDIME= 2\nNELEM= 1\n5 0 1\n")
    with pytest.raises(azimesh.Error) as told:
        azimesh.read(path)
    assert told.value.path == path and told.value.line == 4 and told.value.kind == "input"


def test_a_note_tells_what_a_format_does_not_hold(cube, tmp_path):
    with pytest.warns(azimesh.Note) as notes:
        azimesh.write(cube, tmp_path / "cube.su2")
    assert any("height" in str(note.message) for note in notes)


@pytest.mark.parametrize("ending", ["vtu", "vtk", "msh", "cgns", "vtkhdf"])
def test_what_is_written_is_read(wing, tmp_path, ending):
    path = tmp_path / f"wing.{ending}"
    azimesh.write(wing, path)
    again = azimesh.read(path)
    assert not azimesh.diff(wing, again), azimesh.diff(wing, again)


def test_there_and_back_through_pyvista(wing, cube):
    pytest.importorskip("pyvista")
    for mesh in (wing, cube):
        again = azimesh.from_pyvista(mesh.to_pyvista())
        assert (again.points == mesh.points).all()
        assert {name: faces.tolist() for name, faces in again.tags.items()} == {
            name: faces.tolist() for name, faces in mesh.tags.items()
        }
        assert list(again.zones) == list(mesh.zones)


def test_there_and_back_through_meshio(wing, cube):
    pytest.importorskip("meshio")
    for mesh in (wing, cube):
        again = azimesh.from_meshio(mesh.to_meshio())
        assert (again.points == mesh.points).all()
        for name in mesh.tags:
            assert (again.tag_nodes(name) == mesh.tag_nodes(name)).all()
        assert list(again.zones) == list(mesh.zones)


def test_a_model_of_gmsh_comes_with_its_physical_groups():
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        box = gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [box], name="inside")
        gmsh.model.addPhysicalGroup(2, [tag for _, tag in gmsh.model.getEntities(2)], name="walls")
        gmsh.model.mesh.generate(3)
        n_nodes = len(gmsh.model.mesh.getNodes()[0])
        mesh = azimesh.from_gmsh()
    finally:
        gmsh.finalize()
    assert mesh.n_points == n_nodes
    assert list(mesh.tags) == ["walls"] and list(mesh.zones) == ["inside"]
    assert azimesh.quality(mesh).summary["inverted"] == 0


def test_quality_has_a_value_a_cell_as_vtk_has_it(wing):
    pyvista = pytest.importorskip("pyvista")
    found = azimesh.quality(wing)
    grid = wing.to_pyvista().cell_quality(["scaled_jacobian", "volume"])
    cells = wing.cell_index["tetra"]
    assert np.allclose(found["ScaledJacobian"][cells], grid["scaled_jacobian"][cells], atol=1e-12)
    assert np.allclose(found["Volume"][cells], grid["volume"][cells], rtol=1e-12)
    assert found.summary["min_scaled_jacobian"] == found["ScaledJacobian"].min()
    assert found["Inverted"].dtype == bool and not found["Inverted"].any()
    assert pyvista.__version__


def test_quality_has_the_arrays_that_the_command_writes(wing, tmp_path):
    azimesh.write(wing, tmp_path / "wing.vtu")
    written = tmp_path / "quality.vtu"
    subprocess.run([sys.executable, "-m", "azimesh", "--quiet", "quality", tmp_path / "wing.vtu", "-o", written], check=True)
    arrays = azimesh.read(written).cell_data
    found = azimesh.quality(wing)
    assert len(found) == 16
    for name, values in found.items():
        assert np.array_equal(arrays[name], values, equal_nan=values.dtype != bool), name


def test_quality_refuses_a_reference_with_other_cells(wing, cube):
    with pytest.raises(azimesh.Error, match="other cells"):
        azimesh.quality(wing, reference=cube)


def test_a_notebook_shows_a_table(cube):
    html = cube._repr_html_()
    assert "<td>8</td>" in html and "tag top" in html
    assert "8 points" in repr(cube)


def test_convert_keeps_everything(testdata, tmp_path):
    azimesh.convert(testdata / "naca0012.vtu", tmp_path / "a.cgns")
    assert not azimesh.diff(azimesh.read(testdata / "naca0012.vtu"), azimesh.read(tmp_path / "a.cgns"))


def test_pyvista_reads_by_azimesh_once_it_is_asked_to(tmp_path, airfoil):
    pyvista = pytest.importorskip("pyvista")
    azimesh.use_in_pyvista()
    azimesh.write(airfoil, tmp_path / "a.su2")
    grid = pyvista.read(tmp_path / "a.su2")
    assert "BoundaryTag" in grid.cell_data and grid.n_points == airfoil.n_points


def test_the_errors_survive_pickling(testdata):
    import pickle

    error = azimesh.Error("a message", "check", Path("a.vtu"), 7)
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.kind, again.path, again.line) == ("a message", "check", Path("a.vtu"), 7)

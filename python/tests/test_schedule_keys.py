"""Keys of the schedule given in a dict: oscillations, tables in other names and units, a rotor that speeds up, free tags."""

import numpy as np
import pytest

import azimesh
from conftest import TESTDATA


def turned(points, origin, degrees):
    """Points of a plane turned about a point."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    moved = points.copy()
    moved[:, :2] = np.asarray(origin) + (points[:, :2] - origin) @ np.array([[c, s], [-s, c]])
    return moved


def schedule(*bodies, **sections):
    """Times from 0 to 0.1 s, the airfoil or others moving."""
    return {
        "time": {"stop": 0.1, "step": 0.05},
        "body": [{"name": "airfoil", "tags": ["airfoil"], **body} for body in bodies],
        "boundaries": {"fixed": ["farfield"]},
        "rbf": {"support_radius": 10.0},
        "selection": {"tolerance": 1e-4},
        **sections,
    }


def surface(mesh, motion):
    """Times, and places of the nodes of the airfoil before and at each step."""
    deformation = azimesh.Deformation(mesh, azimesh.Schedule(motion))
    nodes = mesh.tag_nodes("airfoil")
    return [(step, mesh.points[nodes], step.points[nodes]) for step in deformation]


def test_a_rotation_swings_at_a_frequency_and_a_translation_on_top(airfoil):
    rigid = {
        "rotate": {"axis": [0, 0, 1], "origin": [0.5, 0, 0], "angle": 1.0, "harmonics": [{"sin": 4.0}, {"cos": np.float64(0.5)}], "frequency": 3},
        "translate": {"vector": (0, 0.02, 0), "harmonics": [{"cos": 1}], "frequency": 1.5},
    }
    for step, before, after in surface(airfoil, schedule({"rigid": rigid})):
        psi = 2 * np.pi * 3 * step.time_s
        wanted = turned(before, [0.5, 0], 1 + 4 * np.sin(psi) + 0.5 * np.cos(2 * psi))
        wanted[:, 1] += 0.02 * np.cos(2 * np.pi * 1.5 * step.time_s)
        assert np.abs(after - wanted).max() < 1e-12


def test_a_rotation_has_a_table(airfoil, tmp_path):
    (tmp_path / "angle.csv").write_text("time_s,angle_rad\n0,0\n0.05,0.03\n0.1,-0.01\n")
    rotate = {"axis": [0, 0, 1], "table": str(tmp_path / "angle.csv")}
    for (_, before, after), angle in zip(surface(airfoil, schedule({"rigid": {"rotate": rotate}})), [0, 0.03, -0.01]):
        assert np.abs(after - turned(before, [0, 0], np.degrees(angle))).max() < 1e-12


def test_a_table_has_names_and_units_of_its_own(airfoil, tmp_path):
    (tmp_path / "heave.csv").write_text("t,plunge,load\n0,0,9\n50,20,9\n100,-10,9\n")
    table = {"file": str(tmp_path / "heave.csv"), "columns": {"time_s": "t", "dy": "plunge"}, "units": {"time_s": "ms", "dy": "mm"}}
    motion = schedule({"table": table}, output={"length_unit": "m", "title": "Heave"})
    for (_, before, after), dy in zip(surface(airfoil, motion), [0, 0.02, -0.01]):
        assert np.abs(after - before - [0, dy, 0]).max() < 1e-15


def test_pitch_has_a_table_over_the_azimuth_of_a_rotor_that_speeds_up(airfoil, tmp_path):
    (tmp_path / "azimuth.csv").write_text("time_s,azimuth_deg\n0,0\n0.05,45\n0.1,180\n")
    (tmp_path / "trim.csv").write_text("azimuth_deg,pitch_deg\n0,1\n90,3\n180,-2\n270,0\n")
    motion = schedule({"cyclic": {"table": str(tmp_path / "trim.csv")}}, rotor={"azimuth_table": str(tmp_path / "azimuth.csv")})
    found = surface(airfoil, motion)
    assert [step.azimuth_deg for step, *_ in found] == pytest.approx([0, 45, 180], abs=1e-12)
    for (_, before, after), pitch in zip(found, [1, 2, -2]):
        # Nose up, and the nose points to -x.
        assert np.abs(after - turned(before, [0, 0], -pitch)).max() < 1e-12


def test_a_beam_has_names_units_and_held_ends(tmp_path):
    mesh = azimesh.read(TESTDATA / "wing_on_plane.vtu")
    (tmp_path / "beam.csv").write_text("r,u,tw\n0,0,0\n0.5,30,0.02\n")
    beam = {
        "table": str(tmp_path / "beam.csv"),
        "columns": {"station": "r", "dz": "u", "rot_x_deg": "tw"},
        "units": {"station": "radius", "dz": "mm", "rot_x_deg": "rad"},
        "hold_ends": True,
    }
    motion = {
        "azimuth": {"values": [0]},
        "rotor": {"span_axis": [0, 0, 1], "shaft_axis": [0, 1, 0]},
        "body": [{"name": "wing", "tags": ["wing"], "beam": beam}],
        "boundaries": {"fixed": ["farfield"], "slide": ["symmetry"]},
        "output": {"length_unit": "m"},
    }
    [step] = azimesh.Deformation(mesh, azimesh.Schedule(motion))
    nodes = mesh.tag_nodes("wing")
    before, after = mesh.points[nodes], step.points[nodes]
    outer = before[:, 2] > 0.55 * before[:, 2].max()
    # Past the last station the section moves as a whole: 30 mm along the shaft, turned by 0.02.
    spread = (after - before)[outer]
    assert np.ptp(spread[:, 1]) < 0.03 and abs(spread[:, 1].mean() - 0.03) < 0.02
    beam.pop("hold_ends")
    with pytest.raises(azimesh.Error, match="hold_ends"):
        azimesh.Deformation(mesh, azimesh.Schedule(motion))


def test_free_tags_go_along_and_an_unknown_key_is_told(airfoil):
    rigid = {"translate": [0.0, 0.05, 0.0]}
    motion = schedule({"rigid": rigid}, boundaries={"free": ["farfield"]})
    [*_, last] = azimesh.Deformation(airfoil, azimesh.Schedule(motion))
    far = airfoil.tag_nodes("farfield")
    assert 0 < np.abs(last.points[far] - airfoil.points[far]).max() <= 0.05
    wrong = {"rotate": {"axis": [0, 0, 1], "harmonic": [{"sin": 1.0}]}}
    with pytest.raises(azimesh.Error, match="harmonics"):
        azimesh.Schedule(schedule({"rigid": wrong}))


def test_an_error_in_a_dict_names_the_key_and_no_line(airfoil):
    harmonics = {"cyclic": {"pitch": [{"sin": 1}, {"sinn": 1}]}}
    for bodies, place in [
        ([{"rigid": {"translate": [0, 0, "1"]}}], 'schedule["body"][0]["rigid"]["translate"]: '),
        ([{"rigid": {"translate": [0, 0.1, 0]}}, harmonics], 'schedule["body"][1]["cyclic"]["pitch"][1]["sinn"]: '),
        ([{"rigid": {"translate": [0, 0.1, 0]}, "tags": ["wing"]}], 'schedule["body"][0]["tags"]: tag "wing"'),
    ]:
        with pytest.raises(azimesh.Error) as error:
            azimesh.Deformation(airfoil, azimesh.Schedule(schedule(*bodies)))
        assert str(error.value).startswith(place)
        assert error.value.line is None and error.value.path is None


def test_a_dict_or_list_that_contains_itself_is_refused():
    inner = {}
    inner["body"] = inner
    nested = []
    for _ in range(100_000):
        nested = [nested]
    for keys in [inner, {"body": nested}]:
        with pytest.raises(azimesh.Error, match="contain itself"):
            azimesh.Schedule(keys)

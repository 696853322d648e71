"""Morph: exact at the surface, linear, with an exact transpose; beside scipy."""

import numpy as np
import pytest

import azimesh


@pytest.fixture(scope="module")
def morph(wing):
    return azimesh.Morph(wing, "wing", ["farfield", "symmetry"], support_radius=2.0)


def displacements(morph, seed=1):
    random = np.random.default_rng(seed)
    x = morph.mesh.points[morph.moving]
    return 0.01 * np.sin(3 * x + random.uniform(0, 6, 3)) * [1, 1, 0]


def test_moving_and_fixed_nodes_are_where_they_should_be(morph, wing):
    given = displacements(morph)
    points = morph(given)
    assert np.abs(points[morph.moving] - (wing.points[morph.moving] + given)).max() < 1e-16
    fixed = np.setdiff1d(wing.tag_nodes("farfield"), morph.moving)
    assert (points[fixed] == wing.points[fixed]).all()


def test_it_is_linear(morph):
    a, b = displacements(morph, 1), displacements(morph, 2)
    both = morph.displacements_of(a + 2 * b)
    assert np.abs(both - morph.displacements_of(a) - 2 * morph.displacements_of(b)).max() < 1e-14


def test_pull_back_is_the_transpose(morph, wing):
    random = np.random.default_rng(5)
    given, gradient = displacements(morph), random.standard_normal(wing.points.shape)
    there = (gradient * morph.displacements_of(given)).sum()
    back = (morph.pull_back(gradient) * given).sum()
    assert there == pytest.approx(back, rel=1e-11)


def test_base_points_are_surface_nodes(morph, wing):
    surface = np.unique(np.concatenate([wing.tag_nodes(name) for name in wing.tags]))
    assert np.isin(morph.base_points, surface).all() and len(morph.base_points) > 10


def test_nodes_are_given_by_number_too(wing, morph):
    other = azimesh.Morph(wing, wing.tag_nodes("wing"), fixed=morph_fixed(wing, morph), support_radius=2.0)
    assert (np.sort(other.moving) == np.sort(morph.moving)).all()


def morph_fixed(wing, morph):
    return np.setdiff1d(np.concatenate([wing.tag_nodes("farfield"), wing.tag_nodes("symmetry")]), morph.moving)


def test_the_report_tells_where_base_points_are_off(morph):
    report = morph.report(displacements(morph))
    assert 0 <= report["largest_residual"] < 0.01 and report["steep_nodes"].dtype == np.int64


@pytest.mark.parametrize(
    ("change", "wrong"),
    [
        ({"moving": "wings"}, "wings"),
        ({"moving": [10**9]}, "1000000000"),
        ({"moving": [-1]}, "-1"),
        ({"moving": []}, "empty"),
        ({"kernel": "gauss"}, "gauss"),
        ({"support_radius": -1.0}, "support_radius"),
        ({"max_points": 0}, "max_points"),
        ({"samples": [np.zeros((2, 3))]}, "2"),
    ],
)
def test_wrong_options_are_told(wing, change, wrong):
    options = {"moving": "wing", "fixed": ["farfield", "symmetry"], **change}
    with pytest.raises(azimesh.Error, match=wrong):
        azimesh.Morph(wing, **options)


@pytest.mark.parametrize("given", [np.zeros((3, 3)), np.zeros((3, 2)), np.zeros(3), [[np.nan] * 3] * 494])
def test_wrong_displacements_are_told(morph, given):
    with pytest.raises(azimesh.Error):
        morph(given)


def test_it_warns_where_its_points_do_not_meet_the_tolerance(wing, morph):
    assert morph.selection_error <= 1e-4
    with pytest.warns(azimesh.Note, match="20 base points leave an error of .* above the tolerance"):
        coarse = azimesh.Morph(wing, "wing", ["farfield", "symmetry"], max_points=20)
    assert coarse.selection_error > 1e-4

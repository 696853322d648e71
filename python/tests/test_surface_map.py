"""SurfaceMap: rigid motions, bending, forces; beside scipy."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator
from scipy.spatial.transform import Rotation

import azimesh


def skin(n_chord, n_span, shift=0.0):
    """Points on both sides of a wing of chord 1 and span 8."""
    angle, y = np.meshgrid((np.arange(n_chord) + shift) * 2 * np.pi / n_chord, np.linspace(0, 8, n_span))
    x = (0.5 + 0.5 * np.cos(angle)).clip(0, 1)
    z = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4) * np.sign(np.sin(angle))
    return np.stack([x, y, z], -1).reshape(-1, 3)


def bent(x):
    """The wing along a circle of radius 6."""
    angle, radius = x[:, 1] / 6, 6 - x[:, 2]
    return np.stack([x[:, 0], radius * np.sin(angle), 6 - radius * np.cos(angle)], -1)


def test_rigid_motions_are_exact():
    given, wall = skin(24, 20), skin(80, 60, 0.3)
    turn = Rotation.from_rotvec([0.7, -1.1, 0.4])
    found = azimesh.SurfaceMap(given, wall)(turn.apply(given) + [3, -2, 1] - given)
    assert np.abs(wall + found - turn.apply(wall) - [3, -2, 1]).max() < 1e-12


def test_bending_is_as_near_as_with_global_functions():
    given, wall = skin(40, 40), skin(80, 60, 0.3)
    moved = bent(given) - given
    ours = azimesh.SurfaceMap(given, wall)(moved)
    theirs = RBFInterpolator(given, moved, kernel="thin_plate_spline", degree=1)(wall)
    ours, theirs = (np.linalg.norm(wall + d - bent(wall), axis=1).max() for d in (ours, theirs))
    assert ours < 2 * theirs < 1e-2


def test_a_plate_turns_the_wall_around_it():
    x, y = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 8, 40))
    plate = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], -1)
    at = np.arange(plate.shape[0]).reshape(x.shape)
    facets = np.concatenate([
        np.stack([at[:-1, :-1], at[:-1, 1:], at[1:, :-1]], -1).reshape(-1, 3),
        np.stack([at[:-1, 1:], at[1:, 1:], at[1:, :-1]], -1).reshape(-1, 3),
    ])
    wall = skin(80, 60, 0.3)
    for map_ in (azimesh.SurfaceMap(plate, wall), azimesh.SurfaceMap(plate, wall, "plane", facets=facets)):
        error = np.linalg.norm(wall + map_(bent(plate) - plate) - bent(wall), axis=1).max()
        assert error < 3e-3, error


def test_forces_and_moments_are_kept():
    given, wall = skin(24, 20), skin(80, 60, 0.3)
    forces = np.random.default_rng(1).standard_normal(wall.shape)
    found = azimesh.SurfaceMap(given, wall).pull_back(forces)
    size = np.abs(forces).sum()
    assert np.abs(found.sum(0) - forces.sum(0)).max() < 1e-13 * size
    assert np.abs(np.cross(given, found).sum(0) - np.cross(wall, forces).sum(0)).max() < 1e-12 * size


def test_wrong_arguments_are_told():
    given = skin(24, 20)
    with pytest.raises(azimesh.Error, match="needs `facets`"):
        azimesh.SurfaceMap(given, given, "plane")
    with pytest.raises(azimesh.Error, match="unknown method"):
        azimesh.SurfaceMap(given, given, "spline")
    with pytest.raises(azimesh.Error, match="479 displacements for 480 points"):
        azimesh.SurfaceMap(given, given)(given[1:])

"""What the tests share: small meshes of the project, and a schedule."""

from pathlib import Path

import numpy as np
import pytest

import azimesh

TESTDATA = Path(__file__).parents[2] / "testdata"


@pytest.fixture
def testdata() -> Path:
    return TESTDATA


@pytest.fixture(scope="session")
def airfoil() -> azimesh.Mesh:
    return azimesh.read(TESTDATA / "naca0012.vtu")


@pytest.fixture(scope="session")
def wing() -> azimesh.Mesh:
    return azimesh.read(TESTDATA / "wing_on_plane.vtu")


@pytest.fixture
def pitch() -> azimesh.Schedule:
    return azimesh.Schedule(TESTDATA / "naca0012.toml")


def keys(**body: object) -> dict[str, object]:
    """A schedule of five steps that moves the airfoil."""
    moves = {"name": "airfoil", "tags": ["airfoil"], **body}
    return {
        "azimuth": {"stop": 360.0, "step": 90.0},
        "body": [moves],
        "boundaries": {"fixed": ["farfield"]},
        "selection": {"tolerance": 1e-4},
    }


@pytest.fixture
def cube() -> azimesh.Mesh:
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    return azimesh.Mesh(
        corners,
        {"hexahedron": [[0, 1, 3, 2, 4, 5, 7, 6]], "quad": [[0, 1, 3, 2], [4, 5, 7, 6]]},
        tags={"bottom": [1], "top": [2]},
        zones={"fluid": [0]},
        point_data={"height": corners[:, 2]},
    )

"""The examples run and give what they promise; the stubs fit them."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "examples"


def example(name):
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_pitching_airfoil_prints_its_steps_and_draws(tmp_path, capsys):
    pytest.importorskip("pyvista")
    picture = tmp_path / "airfoil.png"
    example("pitching_airfoil").main(str(picture))
    assert len(capsys.readouterr().out.splitlines()) == 13
    assert picture.stat().st_size > 10_000


def test_the_coupled_wing_comes_to_rest():
    assert 0.01 < example("fluid_structure").main() < 1.0


def test_pull_back_gives_the_gradient_of_finite_differences():
    assert example("shape_gradient").main() < 1e-8


def test_the_regression_test_sees_one_node():
    found = example("regression").main()
    assert found.moved_nodes == 1 and found.max_distance == pytest.approx(1e-6)


def test_stubs_and_examples_are_strictly_typed():
    pytest.importorskip("mypy")
    checked = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", *map(str, sorted(FOLDER.glob("*.py")))],
        capture_output=True,
        text=True,
    )
    assert checked.returncode == 0, checked.stdout

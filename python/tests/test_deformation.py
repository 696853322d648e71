"""Deformations: the same as the program, motion by a function, progress and Ctrl-C."""

import filecmp
import gc
import os
import signal
import subprocess
import sys
import threading
import time
import weakref

import numpy as np
import pytest

import azimesh
from conftest import TESTDATA, keys


def test_points_are_those_of_the_files_bit_for_bit(airfoil, pitch, tmp_path):
    deformation = azimesh.Deformation(airfoil, pitch)
    told = deformation.write(tmp_path / "out")
    assert told["outcome"] == "complete" and told["steps_written"] == len(deformation) == 37
    for step in deformation:
        written = azimesh.read(tmp_path / "out" / f"naca0012_{step.index:04}.vtu")
        assert (step.points == written.points).all()
        assert step.quality["inverted"] == 0


def test_write_gives_the_bytes_of_the_command(airfoil, pitch, tmp_path):
    azimesh.Deformation(airfoil, pitch).write(tmp_path / "library")
    files = [str(TESTDATA / "naca0012.vtu"), str(TESTDATA / "naca0012.toml")]
    command = [sys.executable, "-m", "azimesh", "-q", "deform", *files, "-o", str(tmp_path / "command")]
    subprocess.run(command, check=True)
    names = sorted(os.listdir(tmp_path / "library"))
    assert names == sorted(os.listdir(tmp_path / "command"))
    # run.json and steps.csv hold seconds.
    same = [name for name in names if not name.endswith((".json", ".csv"))]
    equal, different, _ = filecmp.cmpfiles(tmp_path / "library", tmp_path / "command", same, shallow=False)
    assert not different and len(equal) == len(same) > 37


def test_the_command_has_exit_codes(tmp_path):
    run = lambda *arguments: subprocess.run([sys.executable, "-m", "azimesh", *arguments], capture_output=True, text=True)
    assert run("--version").stdout.startswith("azimesh ")
    missing = run("info", str(tmp_path / "none.vtu"))
    assert missing.returncode == 2 and "there is no such file" in missing.stderr


def test_a_schedule_of_keys_is_that_of_the_file(airfoil, tmp_path):
    text = (
        'azimuth = { stop = 360.0, step = 90.0 }\nbody = [{ name = "airfoil", tags = ["airfoil"], '
        'cyclic = { pitch = [{ sin = 5.0 }] } }]\nboundaries.fixed = ["farfield"]\nselection.tolerance = 1e-4\n'
    )
    (tmp_path / "pitch.toml").write_text(text)
    by_file = azimesh.Deformation(airfoil, azimesh.Schedule(tmp_path / "pitch.toml"))
    by_keys = azimesh.Deformation(airfoil, azimesh.Schedule(keys(cyclic={"pitch": [{"sin": np.float64(5.0)}]})))
    assert (by_file[1].points == by_keys[1].points).all()
    assert [step.azimuth_deg for step in by_keys] == [0, 90, 180, 270, 360]


def test_a_wrong_schedule_is_told_with_its_line(tmp_path):
    (tmp_path / "wrong.toml").write_text("azimuth = { stop = 360.0, step = 90.0 }\n[rbf]\nsupport_radius = -1.0\n")
    with pytest.raises(azimesh.Error) as told:
        azimesh.Schedule(tmp_path / "wrong.toml")
    assert told.value.line == 3 and told.value.path == tmp_path / "wrong.toml"
    with pytest.raises(azimesh.Error, match="support_radius"):
        azimesh.Schedule({**keys(cyclic={}), "rbf": {"support_radius": -1.0}})
    with pytest.raises(TypeError, match="body"):
        azimesh.Schedule({**keys(), "body": object()})


def test_a_function_of_python_moves_a_body(airfoil):
    def heave(moment, points):
        assert points.shape[1] == 3
        return np.array([0.0, 0.01 * moment.index, 0.0]) + 0.0 * points

    deformation = azimesh.Deformation(airfoil, azimesh.Schedule(keys(displacements=heave)))
    nodes = airfoil.tag_nodes("airfoil")
    for step in deformation:
        expected = airfoil.points[nodes] + [0.0, 0.01 * step.index, 0.0]
        assert np.allclose(step.points[nodes], expected, atol=1e-15)


def test_what_a_function_raises_comes_out(airfoil):
    def wrong(moment, points):
        raise LookupError(f"step {moment.index}")

    with pytest.raises(LookupError, match="step"):
        azimesh.Deformation(airfoil, azimesh.Schedule(keys(displacements=wrong)))
    with pytest.raises(azimesh.Error, match="displacements for"):
        azimesh.Deformation(airfoil, azimesh.Schedule(keys(displacements=lambda moment, points: points[1:])))


def test_base_points_can_be_given_again(airfoil, pitch):
    first = azimesh.Deformation(airfoil, pitch)
    again = azimesh.Deformation(airfoil, pitch, base_points=first.base_points)
    assert (again.base_points == first.base_points).all()
    assert (again[7].points == first[7].points).all()


def test_steps_are_indexed_like_a_list(airfoil, pitch):
    deformation = azimesh.Deformation(airfoil, pitch)
    assert deformation[-1].index == 36 and deformation[0].azimuth_deg == 0
    with pytest.raises(IndexError):
        deformation[37]
    with pytest.raises(azimesh.Error, match="velocity"):
        deformation[0].velocities


def test_velocities_are_differences_of_positions(airfoil):
    schedule = {**keys(cyclic={"pitch": [{"sin": 5.0}]}), "output": {"velocity": True}}
    del schedule["azimuth"]
    h = 1e-5
    schedule["time"] = {"values": [0.1 - h, 0.1, 0.1 + h], "frequency": 2.0}
    before, now, after = azimesh.Deformation(airfoil, azimesh.Schedule(schedule))
    difference = (after.points - before.points) / (2 * h)
    assert np.abs(now.velocities - difference).max() < 1e-7 * np.abs(difference).max()


def test_progress_is_told_and_may_end_the_work(airfoil, pitch):
    stages = []
    azimesh.Deformation(airfoil, pitch, progress=lambda stage, done, total: stages.append((stage, done, total)))
    assert stages and all(isinstance(stage, str) for stage, _, _ in stages)

    def enough(stage, done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        azimesh.Deformation(airfoil, pitch, progress=enough)[1].points
    with pytest.raises(TypeError, match="progress"):
        azimesh.Deformation(airfoil, pitch, progress=3)


def test_a_bar_is_drawn(airfoil, pitch, capsys):
    azimesh.Deformation(airfoil, pitch, progress=True)
    assert capsys.readouterr().err


def test_a_folder_is_not_overwritten_without_force(airfoil, pitch, tmp_path):
    deformation = azimesh.Deformation(airfoil, pitch)
    deformation.write(tmp_path, steps=(0, 2))
    with pytest.raises(azimesh.Error, match="force"):
        deformation.write(tmp_path, steps=(0, 2))
    deformation.write(tmp_path, steps=(0, 2), force=True)
    assert deformation.write(tmp_path, steps=(0, 2), resume=True)["steps_kept"] == 2


def test_what_was_made_in_memory_is_written_but_not_resumed(airfoil, tmp_path):
    deformation = azimesh.Deformation(airfoil, azimesh.Schedule(keys(cyclic={"pitch": [{"sin": 5.0}]})))
    assert deformation.write(tmp_path, format="vtkhdf")["steps_written"] == 5
    with pytest.raises(azimesh.Error, match="memory"):
        deformation.write(tmp_path, resume=True)


def test_a_check_that_fails_is_an_error_after_the_files(airfoil, pitch, tmp_path):
    with pytest.raises(azimesh.Error) as told:
        azimesh.Deformation(airfoil, pitch).write(tmp_path, fail_on=["min_scaled_jacobian<0.9"])
    assert told.value.kind == "check"
    assert (tmp_path / "naca0012_0036.vtu").exists()


def test_ctrl_c_ends_the_work_and_leaves_whole_steps(airfoil, tmp_path):
    schedule = keys(cyclic={"pitch": [{"sin": 5.0}]})
    schedule["azimuth"] = {"stop": 3600.0, "step": 1.0}
    deformation = azimesh.Deformation(airfoil, azimesh.Schedule(schedule))

    def interrupt():
        while not list(tmp_path.glob("*.vtu")):
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    # A shell starts what it puts into the background with SIGINT ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Thread(target=interrupt, daemon=True).start()
        with pytest.raises(KeyboardInterrupt):
            deformation.write(tmp_path)
    finally:
        signal.signal(signal.SIGINT, before)
    written = list(tmp_path.glob("*.vtu"))
    assert 0 < len(written) < len(deformation)
    for path in written:
        assert azimesh.read(path).n_points == airfoil.n_points
    # The next call begins afresh.
    assert deformation[1].points.shape == airfoil.points.shape


def test_iteration_keeps_no_step(airfoil, pitch):
    points = [weakref.ref(step.points) for step in azimesh.Deformation(airfoil, pitch)]
    gc.collect()
    assert len(points) == 37
    assert all(view() is None for view in points)


def test_threads_of_python_share_a_deformation(airfoil, pitch):
    deformation = azimesh.Deformation(airfoil, pitch)
    expected = [step.points.copy() for step in deformation]
    found = [None] * len(deformation)

    def work(first):
        for index in range(first, len(deformation), 4):
            found[index] = deformation[index].points

    threads = [threading.Thread(target=work, args=(first,)) for first in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all((a == b).all() for a, b in zip(found, expected))


def test_a_page_of_a_run_is_written(airfoil, pitch, tmp_path):
    azimesh.Deformation(airfoil, pitch).write(tmp_path, steps=(0, 3))
    azimesh.Deformation(airfoil, pitch).write(tmp_path / "whole")
    page = azimesh.report(tmp_path / "whole")
    assert page.read_text().startswith("<!doctype html>")
    with pytest.raises(azimesh.Error, match="no folder"):
        azimesh.report(tmp_path / "none")


def test_ctrl_c_does_not_wait_for_functions_of_python(airfoil):
    calls = []

    def slow(moment, points):
        calls.append(moment.index)
        time.sleep(0.1)
        return 0.0 * points

    schedule = azimesh.Schedule({
        "azimuth": {"stop": 40.0, "step": 1.0},
        "body": [{"name": "a", "tags": ["airfoil"], "displacements": slow}],
        "boundaries": {"fixed": ["farfield"]},
    })
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Timer(0.4, os.kill, (os.getpid(), signal.SIGINT)).start()
        started = time.monotonic()
        with pytest.raises(KeyboardInterrupt):
            azimesh.Deformation(airfoil, schedule)
    finally:
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - started < 1.5
    assert len(calls) < 20
    n = len(calls)
    time.sleep(0.5)
    assert len(calls) <= n + 1


def test_progress_may_print_the_deformation(airfoil):
    printed = []
    schedule = azimesh.Schedule({
        "azimuth": {"values": [0.0, 90.0]},
        "body": [{"name": "a", "tags": ["airfoil"], "cyclic": {"pitch": [{"sin": 5.0}]}}],
        "boundaries": {"fixed": ["farfield"]},
        "selection": {"method": "real"},
    })
    made = None
    made = azimesh.Deformation(airfoil, schedule, progress=lambda *stage: printed.append(repr(made)) if made else None)
    made[1].points
    assert any("Deformation" in text for text in printed)

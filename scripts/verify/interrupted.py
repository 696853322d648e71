"""A run of 36 steps ended by SIGINT, SIGTERM, SIGHUP and SIGKILL at random moments and resumed until it is done:
the same bytes as without, and whole files all along.

Formats: files of one step each, whole sequences in one file, and a case of OpenFOAM.
"""

import random
import signal
import subprocess
import time
from pathlib import Path

import numpy as np

from killed import CASE, FORMATS, SEED, finished, inputs, make_layer, records, steps_of
from program import AZIMESH, azimesh, report, scratch

NODES = 8_000
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL]
# The longest that a run may take to end when it is asked to, with the step it is writing.
PATIENCE = 20.0


def case(folder, nodes):
    """A mesh and its schedule of 36 steps, with another array at every step."""
    mesh = folder / "mesh.vtu"
    azimesh("sample", "naca0012", "--nodes", nodes, "-o", mesh)
    schedule = mesh.with_suffix(".toml")
    text = schedule.read_text().replace("stop = 360.0", "stop = 350.0")
    schedule.write_text(text + '\n[output]\nquality = "cells"\n')
    return mesh


def command(mesh, folder, name):
    """The run that is ended, and the same that goes on with it."""
    mesh, schedule = inputs(mesh, name)
    return [AZIMESH, "--quiet", "deform", mesh, schedule, "-o", folder, "--format", name, "--resume"]


def left_by(folder):
    """Files by name, without what tells of the single runs: seconds, and run.json."""
    files = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    # A case has an empty file of its name.
    files = {name: content for name, content in files.items() if not name.endswith(("run.json", ".foam"))}
    (own,) = [name for name in files if name.endswith("steps.csv")]
    table = files[own].decode().splitlines()
    at = table[0].split(",").index("seconds")
    files[own] = [row.split(",")[:at] + row.split(",")[at + 1 :] for row in table]
    return files


def check_left(folder, name, wanted, what):
    """Whole files after a run was ended; the number of steps in steps.csv."""
    rows = finished(folder, name)
    found = steps_of(folder, name)
    assert set(rows) <= set(found), f"{what}: steps.csv has {rows}, the files {sorted(found)}"
    for step, points in found.items():
        assert np.array_equal(points, wanted[step]), f"{what}: step {step} is another"
    return len(rows)


def n_rows(folder, name):
    """Whole rows of steps.csv."""
    table = records(folder, name) / "steps.csv"
    return max(table.read_bytes().count(b"\n") - 1, 0) if table.exists() else 0


def wait_for_moment(run, folder, name, chance):
    """Waits for a random moment of a run: mostly a few steps on, at times before the first."""
    if chance.random() < 0.2:
        time.sleep(chance.uniform(0.0, 0.3))
        return
    wanted = n_rows(folder, name) + chance.randrange(9)
    while run.poll() is None and n_rows(folder, name) < wanted:
        time.sleep(0.0005)
    time.sleep(chance.uniform(0.0, 0.05))


def end_once(run, how):
    """Sends a signal, unless the run is over; whether it ended the run."""
    if run.poll() is not None:
        assert run.returncode == 0, f"a run that was left alone ended with {run.returncode}"
        return False
    run.send_signal(how)
    asked = time.monotonic()
    code = run.wait()
    seconds = time.monotonic() - asked
    assert seconds < PATIENCE, f"{how.name}: it took {seconds:.1f} s to end"
    # 0: it was done; negative: before the program listened to signals.
    expected = {-how} if how == signal.SIGKILL else {128 + how, -how}
    assert code in expected | {0}, f"{how.name}: exit code {code}"
    return code != 0


def until_done(mesh, folder, name, wanted, chance):
    """Ends and resumes a run until it is done; the numbers of steps that were there after each end."""
    left = []
    while True:
        run = subprocess.Popen(command(mesh, folder, name), stderr=subprocess.DEVNULL)
        wait_for_moment(run, folder, name, chance)
        how = chance.choice(SIGNALS)
        if not end_once(run, how):
            return left
        if (records(folder, name) / "run.json").exists():
            what = f"{name}, {how.name}, end {len(left) + 1}"
            left.append(check_left(folder, name, wanted, what))


def main(ends=8, nodes=NODES):
    """One line in all; `ends` for each format."""
    chance = random.Random(SEED)
    n_files, left = 0, []
    with scratch() as folder:
        mesh = case(Path(folder), nodes)
        make_layer(mesh)
        for name in [*FORMATS, CASE]:
            whole = folder / f"{name}_whole"
            subprocess.run(command(mesh, whole, name), check=True)
            wanted = steps_of(whole, name)
            assert len(wanted) == 36, f"{name}: {len(wanted)} steps"
            ended = []
            while len(ended) < ends:
                out = folder / f"{name}_{len(ended)}"
                ended += until_done(mesh, out, name, wanted, chance)
                found, expected = left_by(out), left_by(whole)
                assert found.keys() == expected.keys(), f"{name}: {sorted(found.keys() ^ expected.keys())}"
                for file, content in expected.items():
                    assert found[file] == content, f"{name}: {file} is another after ends at {ended}"
                n_files += len(expected)
            left += ended
    inside = sum(0 < n < 36 for n in left)
    note = f"{len(left)} ends by {', '.join(how.name for how in SIGNALS)} of {', '.join([*FORMATS, CASE])}, {inside} amid the steps"
    report("interrupted", n_files, 0.0, "files", note)


if __name__ == "__main__":
    main()

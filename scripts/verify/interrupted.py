"""A run of 36 steps ended by SIGINT, SIGTERM, SIGHUP and SIGKILL at random moments and resumed until it is done:
the same bytes as without, and whole files all along. TIMES says how often in each format.

Formats: files of one step each, whole sequences in one file, and a case of OpenFOAM.
"""

import random
import signal
import subprocess
import time

import outputs
from program import report, scratch
from sequences import CASE, FORMATS, NAMES, SEED, SIGNALS, TIMES, case, check_left, command, records, steps_of

NODES = 8_000
# The longest that a run may take to end when it is asked to, with the step it is writing.
PATIENCE = 20.0


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
            left.append(check_left(folder, name, wanted, f"{name}, {how.name}, end {len(left) + 1}"))


def main(ends=TIMES or 8, nodes=NODES):
    """One line in all; `ends` for each format."""
    chance = random.Random(SEED)
    n_files, left = 0, []
    with scratch() as folder:
        mesh = case(folder, nodes)
        for name in [*FORMATS, CASE]:
            whole = folder / f"{name}_whole"
            subprocess.run(command(mesh, whole, name), check=True)
            wanted, expected = steps_of(whole, name), outputs.content(whole)
            assert len(wanted) == 36, f"{name}: {len(wanted)} steps"
            ended = []
            while len(ended) < ends:
                out = folder / f"{name}_{len(ended)}"
                ended += until_done(mesh, out, name, wanted, chance)
                n_files += outputs.same(outputs.content(out), expected, f"{name}, after ends at {ended}")
            left += ended
    inside = sum(0 < n < 36 for n in left)
    assert inside, "no run was ended amid its steps"
    report("interrupted", n_files, 0.0, "files", f"{len(left)} ends by {NAMES} of {', '.join([*FORMATS, CASE])}, {inside} amid the steps")

"""A disk that is too small, and one that fills up half way: `deform` refuses the first with both figures and ends with exit code 3 on the second,
whole files left, which --resume completes when there is room. However small the mesh, run.json says how a run on a full disk ended.

Needs a file system of its own, a small tmpfs, which only root can mount; says so where it cannot.
"""

import json
import subprocess
import sys
from contextlib import contextmanager

import outputs
from program import AZIMESH, report, scratch
from sequences import CASE, FORMATS, case, check_left, inputs, records, steps_of

NODES = 4_000
SMALL = 300


@contextmanager
def disk(folder, n_bytes):
    """A folder with room for so many bytes; None where it cannot be made."""
    folder.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={n_bytes}", "tmpfs", folder], capture_output=True, text=True)
    if done.returncode != 0:
        yield None
        return
    try:
        yield folder
    finally:
        subprocess.run(["umount", folder], check=True)


def deform(mesh, out, name, *options):
    """A run and what it said."""
    mesh, schedule = inputs(mesh, name)
    command = [AZIMESH, "deform", mesh, schedule, "-o", out, "--format", name, *options]
    return subprocess.run(command, capture_output=True, text=True)


def check(mesh, folder, name):
    """One format; the number of steps that fit."""
    whole = folder / f"{name}_whole"
    assert deform(mesh, whole, name).returncode == 0, name
    wanted = steps_of(whole, name)
    total = sum(path.stat().st_size for path in whole.rglob("*") if path.is_file())
    with disk(folder / f"{name}_disk", total * 6 // 10) as small:
        if small is None:
            return None
        out = small / "out"
        refused = deform(mesh, out, name)
        assert refused.returncode == 3, f"{name}: exit code {refused.returncode}\n{refused.stderr}"
        assert "36 steps take" in refused.stderr and "are free" in refused.stderr, refused.stderr
        assert not out.exists(), f"{name}: a refused run has written {list(out.iterdir())}"
        full = deform(mesh, out, name, "--no-space-check")
        assert full.returncode == 3, f"{name}: exit code {full.returncode}\n{full.stderr}"
        assert "No space left on device" in full.stderr, full.stderr
        outcome = json.loads((records(out, name) / "run.json").read_text())["outcome"]
        assert "No space left on device" in outcome, f"{name}: run.json says {outcome}"
        n_rows = check_left(out, name, wanted, name)
        assert 0 < n_rows < 36, f"{name}: {n_rows} steps fit"
        left = [path.name for path in out.rglob(".*.part")]
        assert not left, f"{name}: {left} left"
        subprocess.run(["mount", "-o", f"remount,size={total * 3}", small], check=True)
        resumed = deform(mesh, out, name, "--resume")
        assert resumed.returncode == 0, f"{name}: exit code {resumed.returncode}\n{resumed.stderr}"
        outputs.same(outputs.content(out), outputs.content(whole), name)
        return n_rows


def check_ends(mesh, folder, name):
    """A small mesh on disks of many sizes: run.json says how each run ended."""
    whole = folder / f"{name}_small"
    assert deform(mesh, whole, name).returncode == 0, name
    total = sum(path.stat().st_size for path in whole.rglob("*") if path.is_file())
    for part in range(6, 18):
        with disk(folder / f"{name}_{part}", 100_000 + total * part // 10) as small:
            if small is None:
                return
            done = deform(mesh, small / "out", name, "--no-space-check")
            outcome = json.loads((records(small / "out", name) / "run.json").read_text())["outcome"]
            expected = {0: "complete", 3: "No space left on device"}[done.returncode]
            assert expected in outcome, f"{name}: exit code {done.returncode}, but run.json says {outcome}"


def main(nodes=NODES):
    """One line in all."""
    with scratch() as folder:
        mesh = case(folder, nodes)
        names = [*FORMATS, CASE]
        fitted = [check(mesh, folder, name) for name in names]
        (folder / "small").mkdir()
        small = case(folder / "small", SMALL)
        for name in names:
            check_ends(small, folder, name)
    if None in fitted:
        print("full_disk: SKIPPED: no tmpfs can be mounted here (that takes root)", file=sys.stderr, flush=True)
        return
    note = ", ".join(f"{name} full after {n} of 36" for name, n in zip(names, fitted))
    report("full_disk", 36 * len(names), 0.0, "steps", note)

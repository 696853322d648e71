"""Job arrays from one base.toml: the scripts of docs/examples, with Slurm's variables set by hand, give the
files of one run, also where a step has inverted cells, and say so by their exit code. GNU parallel is run where it
is installed.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import outputs
from program import AZIMESH, azimesh, report, scratch

NODES = 3_000
EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples"


def shell(script, *arguments, folder, expect=0, **variables):
    """Runs a script with azimesh in its path; what it said on standard error."""
    path = f"{Path(AZIMESH).resolve().parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, **{name: str(value) for name, value in variables.items()}}
    command = ["bash", EXAMPLES / script, *map(str, arguments)]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == expect, f"{script}: exit code {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stderr


def check_joined(out, whole, name):
    """A joined sequence holds the files of one run, besides those of its parts; their number."""
    return outputs.same(outputs.content(out), outputs.content(whole), f"{name}, beside one run", extra=True)


def array(inputs, out, folder):
    """The tasks of an array in no order; how many of them failed a check."""
    failed = 0
    for task in [3, 1, 4, 2]:
        variables = dict(SLURM_ARRAY_TASK_ID=task, SLURM_ARRAY_TASK_MIN=1, SLURM_ARRAY_TASK_COUNT=4)
        failed += "a check failed" in shell("slurm_array.sh", *inputs, out, folder=folder, **variables)
    return failed


def check(inputs, folder, name, expect):
    """Both scripts with inputs for which one run ends with `expect`; how many files were compared."""
    mesh, schedule, base = inputs
    azimesh("select", folder / mesh, folder / schedule, "-o", folder / base)
    whole = folder / f"{name}_whole"
    azimesh("deform", folder / mesh, folder / schedule, "-o", whole, "--base", folder / base, expect=expect)
    n_files = 0
    for _ in range(2):
        failed = array(inputs, f"{name}_array", folder)
        assert failed == expect, f"{name}: {failed} tasks say that a check failed"
        azimesh("finish", folder / f"{name}_array", expect=expect)
    n_files += check_joined(folder / f"{name}_array", whole, f"{name}, slurm_array.sh")
    if shutil.which("parallel"):
        for _ in range(2):
            shell("gnu_parallel.sh", *inputs, f"{name} side by side", 3, folder=folder, expect=expect)
        n_files += check_joined(folder / f"{name} side by side", whole, f"{name}, gnu_parallel.sh")
    return n_files


def main():
    """One line in all."""
    with scratch() as folder:
        azimesh("sample", "naca0012", "--nodes", NODES, "-o", folder / "n.vtu")
        n_files = check(["n.vtu", "n.toml", "base.toml"], folder, "sound", 0)
        # At one of the steps the airfoil is turned by 170 degrees, at the others by 12 at the most.
        text = (folder / "n.toml").read_text()
        for old, new in [
            ("start = 0.0\nstop = 360.0\nstep = 10.0", "values = [0, 1, 2, 3, 4, 90, 176, 177, 178, 179, 180]"),
            ("sin = 10.0", "sin = 170.0"),
        ]:
            assert old in text, f"n.toml has no {old}"
            text = text.replace(old, new)
        (folder / "far.toml").write_text(text + '\n[output]\non_inverted = "warn"\n')
        n_files += check(["n.vtu", "far.toml", "far_base.toml"], folder, "inverted", 1)
    tried = "slurm_array.sh"
    if shutil.which("parallel"):
        tried += " and gnu_parallel.sh"
    else:
        print("batches: GNU parallel is not installed: its script is NOT run", file=sys.stderr, flush=True)
    report("batches", n_files, 0.0, "files", f"{tried}, with and without inverted cells at a step")

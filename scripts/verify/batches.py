"""Job arrays from one base.toml: the scripts of docs/examples, with Slurm's variables set by hand, give the
files of one run. GNU parallel is run where it is installed.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from interrupted import left_by
from program import AZIMESH, azimesh, report, scratch

NODES = 3_000
EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples"


def shell(script, *arguments, folder, **variables):
    """Runs a script with azimesh in its path."""
    path = f"{Path(AZIMESH).resolve().parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, **{name: str(value) for name, value in variables.items()}}
    command = ["bash", EXAMPLES / script, *map(str, arguments)]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, f"{script}: exit code {done.returncode}\n{done.stdout}{done.stderr}"


def check_joined(out, whole, name):
    """A joined sequence holds the files of one run, besides those of its parts; their number."""
    found, expected = left_by(out), left_by(whole)
    for file, content in expected.items():
        assert found.get(file) == content, f"{name}: {file} is another than in one run"
    return len(expected)


def main():
    """One line in all."""
    n_files = 0
    with scratch() as folder:
        mesh, schedule, base = folder / "n.vtu", folder / "n.toml", folder / "base.toml"
        azimesh("sample", "naca0012", "--nodes", NODES, "-o", mesh)
        azimesh("select", mesh, schedule, "-o", base)
        azimesh("deform", mesh, schedule, "-o", folder / "whole", "--base", base)
        inputs = [mesh.name, schedule.name, base.name]
        for task in [3, 1, 4, 2]:
            array = dict(SLURM_ARRAY_TASK_ID=task, SLURM_ARRAY_TASK_MIN=1, SLURM_ARRAY_TASK_COUNT=4)
            shell("slurm_array.sh", *inputs, "array", folder=folder, **array)
        azimesh("finish", folder / "array")
        n_files += check_joined(folder / "array", folder / "whole", "slurm_array.sh")
        tried = "slurm_array.sh"
        if shutil.which("parallel"):
            for _ in range(2):
                shell("gnu_parallel.sh", *inputs, "side_by_side", 3, folder=folder)
            n_files += check_joined(folder / "side_by_side", folder / "whole", "gnu_parallel.sh")
            tried += " and gnu_parallel.sh"
        else:
            print("batches: GNU parallel is not installed: its script is NOT run", file=sys.stderr, flush=True)
    report("batches", n_files, 0.0, "files", tried)


if __name__ == "__main__":
    main()

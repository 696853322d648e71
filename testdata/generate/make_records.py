"""Records of runs of every sort, for the tests of src/record.

Writes run.json of each into testdata/records, and steps.csv and base.toml of some. The records that are there were written by
azimesh 0.1.0; write them again only with a version whose records differ on purpose.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import place

FOLDER = place.FOLDER / "records"
OVER = ("sin = 10.0", "sin = 170.0")
SUBSTEPS = ("[rbf]", '[output]\non_inverted = "substeps"\n[rbf]')
STOP = ("[rbf]", '[output]\non_inverted = "stop"\n[rbf]')
IN_ONE = ["--format", "vtkhdf"]


def main():
    """Every sort of run, on an airfoil of 300 nodes in four steps."""
    program = place.AZIMESH
    FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        call(program, "sample", "naca0012", "--nodes", "300", "-o", "n.vtu")
        template = Path("n.toml").read_text().replace("step = 10.0", "step = 120.0").replace("tolerance = 1e-4", "tolerance = 1e-2")

        def run(name, changes, *options, out=None, mesh="n.vtu", **more):
            schedule = template
            for old, new in changes:
                schedule = schedule.replace(old, new)
            Path(f"{name}.toml").write_text(schedule)
            call(program, "deform", mesh, f"{name}.toml", "-o", out or name, *options, **more)

        run("plain", [], "--tag-array", "BoundaryTag")
        run("repairs", [OVER, SUBSTEPS], "--fail-on", "max_skew>0.1")
        run("passed_over", [OVER, STOP], "--keep-going")
        run("stopped", [OVER, STOP])
        run("twist", [("[rbf]", '[rbf]\ninterpolate = "twist"')])
        run("real", [("[selection]", '[selection]\nmethod = "real"\nrefresh = 240.0')])
        run("not_judged", [("[rbf]", '[output]\nquality = "none"\n[rbf]')])
        run("pipe", [], mesh="-", input=Path("n.vtu").read_bytes())
        run("resumed", [OVER, SUBSTEPS], *IN_ONE)
        table = Path("resumed/steps.csv")
        table.write_text("".join(table.read_text().splitlines(keepends=True)[:2]))
        run("resumed", [OVER, SUBSTEPS], *IN_ONE, "--resume")
        for steps in ["0..1", "1..4"]:
            run("joined", [OVER, SUBSTEPS], *IN_ONE, "--steps", steps)
        call(program, "finish", "joined")
        for steps in ["0..1", "1..4"]:
            run("joined_and_resumed", [], "--steps", steps)
        call(program, "finish", "joined_and_resumed")
        Path("joined_and_resumed/n_0001.vtu").unlink()
        run("joined_and_resumed", [], "--resume")
        for record in Path().glob("*/run.json"):
            shutil.copy(record, FOLDER / f"{record.parent}.json")
        shutil.copy("joined/run_1-4.json", FOLDER / "part.json")
        (FOLDER / "running.json").write_text(running(program))
        for name in ["plain", "repairs", "not_judged"]:
            shutil.copy(f"{name}/steps.csv", FOLDER / f"{name}.csv")
        for name in ["plain", "twist"]:
            shutil.copy(f"{name}/base.toml", FOLDER / f"{name}.toml")


def running(program):
    """The record of a run that is killed while it chooses base points."""
    call(program, "sample", "naca0012", "--nodes", "40000", "-o", "large.vtu")
    schedule = Path("large.toml").read_text().replace("step = 10.0", "step = 120.0")
    Path("large.toml").write_text(schedule.replace("tolerance = 1e-4", "tolerance = 1e-9"))
    started = subprocess.Popen([program, "-q", "deform", "large.vtu", "large.toml", "-o", "running"])
    record = Path("running/run.json")
    while not record.exists():
        time.sleep(0.001)
    started.kill()
    started.wait()
    return record.read_text()


def call(program, *arguments, **more):
    """Runs a command; checks that fail are part of it."""
    done = subprocess.run([program, "-q", *arguments], capture_output=True, check=False, **more)
    if done.returncode > 1:
        sys.exit(done.stderr.decode())

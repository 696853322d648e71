"""The program with the feature `mpi` under mpirun: what ranks of threads cannot show. Ranks write the bytes of one process, report an
error once, and a run whose rank was killed is resumed by another number of ranks. The suite compares all motions and formats on threads.

    AZIMESH_MPI    the program built with --features mpi (target/azimesh-mpi)
    KILLS          how often a rank is killed (4)
"""

import os
import random
import signal
import subprocess
import time
from pathlib import Path

from outputs import content, same
from program import AZIMESH, TESTDATA, azimesh, report, scratch

PROGRAM = os.environ.get("AZIMESH_MPI", "target/azimesh-mpi")
KILLS = int(os.environ.get("KILLS", "4"))
SEED = 20261123
# Open MPI refuses root and more ranks than processors unless it is told otherwise.
ALLOWED = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}
# Mesh, schedule and changes of the schedule.
CASES = [
    ("naca0012", "naca0012", {"[rbf]": "[output]\nquality = \"cells\"\ndisplacement = true\n[rbf]"}),
    ("hart_ii", "hart_ii", {"step = 15": "step = 60", "[rbf]": "[output]\nvelocity = true\nformat = \"cgns\"\n[rbf]"}),
    ("rotor_sector", "rotor_sector_sliding", {"[rbf]": "[output]\nformat = \"vtkhdf\"\n[rbf]"}),
]


def command(n, *arguments):
    """The command of so many ranks."""
    return ["mpirun", "-n", str(n), PROGRAM, *map(str, arguments)]


def ranks(n, *arguments, expect=0):
    """Runs so many ranks to their end."""
    done = subprocess.run(command(n, *arguments), capture_output=True, text=True, env=os.environ | ALLOWED)
    said = f"{n} ranks, {arguments}: exit code {done.returncode}, expected {expect}\n{done.stderr}"
    assert done.returncode == expect, said
    return done


def schedule_of(folder, name, changes):
    """A schedule of the test data, changed."""
    text = (TESTDATA / f"{name}.toml").read_text()
    for old, new in changes.items():
        assert old in text, f"{old} is not in {name}.toml"
        text = text.replace(old, new)
    path = folder / f"{name}.toml"
    path.write_text(text)
    (folder / "hart_ii_beam.csv").write_bytes((TESTDATA / "hart_ii_beam.csv").read_bytes())
    return path


def check_cases(folder):
    """Motions and boundaries of testdata."""
    n_files = 0
    for number, (mesh, schedule, changes) in enumerate(CASES):
        schedule = schedule_of(folder, schedule, changes)
        arguments = ["-q", "deform", TESTDATA / f"{mesh}.vtu", schedule, "-o"]
        azimesh(*arguments[1:], folder / f"{number}_alone")
        ranks(3, *arguments, folder / f"{number}_ranks")
        n_files += same(content(folder / f"{number}_ranks"), content(folder / f"{number}_alone"), schedule.name)
    report("mpi: cases", n_files, 0, "files")


def check_large(folder):
    """Quality and deformation of a mesh that ranks read and write together; where steps are repaired the first reads all of it."""
    mesh, schedule = folder / "b.vtu", folder / "b.toml"
    azimesh("sample", "blade", "--nodes", 40_000, "--cells", "tet", "-o", mesh)
    schedule.write_text(schedule.read_text().replace("step = 10.0", "step = 130.0"))
    alone = subprocess.run([AZIMESH, "quality", mesh, "--worst", "7"], capture_output=True, text=True, check=True)
    assert ranks(4, "quality", mesh, "--worst", 7).stdout == alone.stdout, "quality"
    narrow = ("support_radius = 5.625", "support_radius = 0.35")
    for name, output, change, n in [
        ("vtu", "", None, 4), ("vtkhdf", 'format = "vtkhdf"', None, 7), ("repaired", 'format = "vtkhdf"', narrow, 3),
    ]:  # fmt: skip
        text = schedule.read_text().replace("[rbf]", f"[output]\n{output}\n[rbf]").replace(*change or ("", ""))
        of_case, out = folder / f"large_{name}.toml", folder / f"large_{name}"
        of_case.write_text(text)
        azimesh("deform", mesh, of_case, "-o", out)
        printed = ranks(n, "-v", "deform", mesh, of_case, "-o", folder / f"large_{name}_{n}").stderr
        assert ("read whole" in printed) == (name == "repaired"), f"{name}: whether the first rank has read the mesh\n{printed}"
        same(content(folder / f"large_{name}_{n}"), content(out), f"a blade, {name}, with {n} ranks")
    report("mpi: a blade", 4, 0, "runs")


def check_together(folder):
    """Files that ranks read and write together: one process gives the same quality and the same bytes."""
    for ending in ("vtkhdf", "vtu", "cgns", "msh", "lb8.ugrid"):
        mesh = folder / f"together.{ending}"
        azimesh("convert", folder / "b.vtu", mesh)
        alone = subprocess.run([AZIMESH, "quality", mesh, "--json"], capture_output=True, text=True, check=True)
        done = ranks(3, "-v", "quality", mesh, "--json")
        assert done.stdout == alone.stdout, f"quality of {mesh.name}"
        assert "read whole" not in done.stderr, done.stderr
        if ending == "msh":
            continue
        one, several = folder / f"one.{ending}", folder / f"several.{ending}"
        azimesh("convert", folder / "together.vtkhdf", one)
        printed = ranks(3, "-v", "convert", folder / "together.vtkhdf", several).stderr
        assert "read whole" not in printed and one.read_bytes() == several.read_bytes(), printed
    one, several = folder / "one.su2", folder / "several.su2"
    azimesh("convert", folder / "b.vtu", one)
    assert "read whole" in ranks(3, "-v", "convert", folder / "b.vtu", several).stderr
    assert one.read_bytes() == several.read_bytes(), "a format that ranks do not write"
    report("mpi: read and written together", 10, 0, "commands")


def check_no_room(folder):
    """A rank that cannot write: one error, nothing short, and the run goes on where there is room."""
    mesh, schedule = folder / "b.vtu", folder / "b.toml"
    limited = folder / "limited.sh"
    limited.write_text(
        '#!/bin/bash\ntrap "" XFSZ\n[ "$OMPI_COMM_WORLD_RANK" = 2 ] && ulimit -f 300\n' f'exec {Path(PROGRAM).resolve()} "$@"\n'
    )
    limited.chmod(0o755)
    for name in ("vtu", "vtkhdf"):
        out, of_case = folder / f"room_{name}", folder / f"large_{name}.toml"
        command = ["mpirun", "-n", "3", limited, "-q", "deform", mesh, of_case, "-o", out]
        done = subprocess.run(command, capture_output=True, text=True, env=os.environ | ALLOWED)
        assert done.returncode == 3 and done.stderr.count("rank 2: File too large") == 1, (done.returncode, done.stderr)
        left = [path.name for path in out.iterdir() if path.suffix in (".vtu", ".vtkhdf", ".part")]
        assert not left, left
        ranks(2, "-q", "deform", mesh, of_case, "-o", out, "--resume")
        same(content(out), content(folder / f"large_{name}"), f"{name}, once there is room")
    report("mpi: a rank without room", 2, 0, "runs")


def check_errors(folder):
    """One message of the program, and an exit code that is not zero."""
    for arguments, code, words in [
        (["quality", folder / "none.vtu"], 2, "there is no such file"),
        (["deform", TESTDATA / "naca0012.vtu", folder / "none.toml", "-o", folder / "e"], 2, "there is no such file"),
        (["quality"], 2, "the following required arguments"),
        (["quality", TESTDATA / "naca0012.vtu", "--fail-on", "min_volume<1"], 1, "min_volume<1 holds"),
    ]:
        done = ranks(3, *arguments, expect=code)
        assert done.stderr.count(words) == 1, done.stderr
    assert ranks(3, "--version").stdout.count("azimesh") == 1
    out = [folder / "alone.vtu", folder / "ranks.vtu"]
    azimesh("quality", TESTDATA / "naca0012.vtu", "-o", out[0])
    ranks(3, "-q", "quality", TESTDATA / "naca0012.vtu", "-o", out[1])
    assert out[0].read_bytes() == out[1].read_bytes(), "a command of one rank"
    report("mpi: errors", 6, 0, "commands")


def check_script(folder):
    """docs/examples/slurm_mpi.sh, with Slurm's launcher imitated."""
    programs = folder / "programs"
    programs.mkdir()
    (programs / "azimesh").symlink_to(Path(PROGRAM).resolve())
    (programs / "srun").write_text('#!/bin/bash\nwhile [[ $1 == --* ]]; do shift; done\nexec mpirun -n 4 "$@"\n')
    (programs / "srun").chmod(0o755)
    mesh, schedule = TESTDATA / "naca0012.vtu", TESTDATA / "naca0012.toml"
    script = ["bash", "docs/examples/slurm_mpi.sh", mesh, schedule, folder / "script"]
    variables = {"PATH": f"{programs}:{os.environ['PATH']}", "SLURM_CPUS_PER_TASK": "1"}
    for _ in range(2):
        subprocess.run(script, check=True, capture_output=True, env=os.environ | ALLOWED | variables)
    azimesh("deform", mesh, schedule, "-o", folder / "no_script")
    report("mpi: script", same(content(folder / "script"), content(folder / "no_script"), "slurm_mpi.sh"), 0, "files")


def kill_one(process, delay, chance):
    """Kills one of the ranks after a while; gives the seconds until the launcher has ended."""
    time.sleep(delay)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    if not children:
        process.wait()
        return None
    try:
        os.kill(int(chance.choice(children)), signal.SIGKILL)
    except ProcessLookupError:
        process.wait()
        return None
    started = time.monotonic()
    process.wait(timeout=60)
    return time.monotonic() - started


def check_kills(folder):
    """A rank killed at any moment ends all; the run is resumed by another number of ranks."""
    chance = random.Random(SEED)
    mesh, schedule = folder / "b.vtu", folder / "b.toml"
    schedule.write_text(schedule.read_text().replace("step = 130.0", "step = 30.0"))
    cells = folder / "cells.toml"
    cells.write_text(schedule.read_text().replace("[rbf]", "[output]\nquality = \"cells\"\n[rbf]"))
    # A file for each step; one file for all steps; one file with arrays at cells.
    runs = [(schedule, "vtu"), (schedule, "vtkhdf"), (cells, "vtkhdf")]
    wanted, longest, n_killed = [], 0.0, 0
    for number, (steps, form) in enumerate(runs):
        started = time.monotonic()
        alone = folder / f"kills_{number}"
        azimesh("deform", mesh, steps, "-o", alone, "--format", form)
        length = 2 * (time.monotonic() - started)
        wanted.append(content(alone))
    for kill in range(KILLS):
        out, (steps, form) = folder / f"killed_{kill}", runs[kill % 3]
        arguments = ["deform", mesh, steps, "-o", out, "--format", form]
        process = subprocess.Popen(command(3, "-q", *arguments), stderr=subprocess.PIPE, env=os.environ | ALLOWED)
        # Every second rank is killed in the first steps, so that some die before their run has ended.
        if kill % 2 == 1:
            while process.poll() is None and not (out / "run.json").exists():
                time.sleep(0.01)
        seconds = kill_one(process, chance.uniform(0.1, length) if kill % 2 == 0 else 0.05, chance)
        printed = process.stderr.read().decode()
        if seconds is not None:
            n_killed += 1
            longest = max(longest, seconds)
            assert process.returncode != 0, "a launcher whose rank was killed exits with an error"
            assert printed.count("error: ") <= 1 and seconds < 10, printed
        again = ["--resume"] if (out / "run.json").exists() else []
        ranks(chance.choice([1, 2, 4]), *arguments, *again)
        same(content(out), wanted[kill % 3], f"resumed after kill {kill}")
    assert n_killed > 0, "no rank was killed in time"
    report("mpi: kills", n_killed, 0, "ranks killed", f"all ended within {longest:.1f} s, every run resumed to the same bytes")


def main():
    with scratch() as folder:
        check_cases(folder)
        check_large(folder)
        check_together(folder)
        check_no_room(folder)
        check_errors(folder)
        check_script(folder)
        check_kills(folder)

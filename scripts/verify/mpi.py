"""The program with the feature `mpi` under mpirun: any number of ranks gives what one process gives, to the byte; errors are
told once; what is left of a run whose rank was killed is resumed by another number of ranks.

    AZIMESH_MPI    the program built with --features mpi (target/azimesh-mpi)
    KILLS          how often a rank is killed (4)
"""

import csv
import os
import random
import re
import signal
import subprocess
import time
from pathlib import Path

from program import AZIMESH, TESTDATA, azimesh, report, scratch

PROGRAM = os.environ.get("AZIMESH_MPI", "target/azimesh-mpi")
KILLS = int(os.environ.get("KILLS", "4"))
SEED = 20261123
# Open MPI refuses root and more ranks than processors unless it is told otherwise.
ALLOWED = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}
# Mesh, schedule and changes of the schedule: every sort of motion and boundary.
CASES = [
    ("naca0012", "naca0012", {"[rbf]": "[output]\nquality = \"cells\"\ndisplacement = true\n[rbf]"}),
    ("naca0012", "naca0012", {"support_radius = 10.0": "support_radius = 1.5", "[rbf]": "[output]\nformat = \"vtkhdf\"\n[rbf]"}),
    ("naca0012", "naca0012", {"[rbf]": "[output]\nformat = \"cgns\"\n[rbf]\nsubsteps = 2"}),
    ("block", "block", {"angle = 60.0": "angle = 170.0"}),
    ("block", "block_sliding", {}),
    ("body_in_duct", "body_in_duct", {}),
    ("hart_ii", "hart_ii", {"step = 15": "step = 60", "[rbf]": "[output]\nvelocity = true\n[rbf]"}),
    ("hart_ii", "hart_ii", {"step = 15": "step = 60", "[rbf]": "[rbf]\ninterpolate = \"twist\""}),
    ("rotor_sector", "rotor_sector", {}),
    ("rotor_sector", "rotor_sector_sliding", {}),
    ("wing_on_plane", "wing_on_plane", {}),
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


def content(folder):
    """What the files of a run hold, but for times and the record of the run."""
    found = {}
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        name = str(path.relative_to(folder))
        if name == "run.json":
            continue
        if name == "steps.csv":
            rows = csv.DictReader(path.open())
            found[name] = [{key: value for key, value in row.items() if key != "seconds"} for row in rows]
        else:
            found[name] = path.read_bytes()
    return found


def same(found, wanted, what):
    """Names the first file that differs."""
    assert found.keys() == wanted.keys(), f"{what}: {found.keys() ^ wanted.keys()}"
    for name, bytes_of in wanted.items():
        assert found[name] == bytes_of, f"{what}: {name} differs"
    return len(wanted)


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
    """Every sort of motion with 1, 3 and 7 ranks."""
    n_files = 0
    for number, (mesh, schedule, changes) in enumerate(CASES):
        schedule = schedule_of(folder, schedule, changes)
        arguments = ["-q", "deform", TESTDATA / f"{mesh}.vtu", schedule, "-o"]
        alone = folder / f"{number}_alone"
        azimesh(*arguments[1:], alone)
        for n in (1, 3, 7):
            out = folder / f"{number}_{n}"
            ranks(n, *arguments, out)
            n_files += same(content(out), content(alone), f"{schedule.name} with {n} ranks")
    report("mpi: cases", n_files, 0, "files")


def check_rotors(folder):
    """A zone that deforms or turns against the rest, and several bodies around a hub, carried round; coordinates of 32 bits. The first
    rank reads none of them whole."""
    n_files = 0
    small = ["--layers", 4, "--first-cell", 0.01, "--surface-nodes", 1500]
    inertial, rotating = ('frame = "rotating"', 'frame = "inertial"'), ("", "")
    for name, options, change, output in [
        ("zone", small, inertial, 'format = "cgns"\nvelocity = true'),
        ("still", ["--layers", 6, *small[2:]], rotating, 'format = "vtu"'),
        ("bodies", ["--blades", 3, "--nodes", 20_000, "--first-cell", 0.01], inertial, 'format = "vtkhdf"\nprecision = "f32"\nvelocity = true'),
        ("ugrid", ["--blades", 3, "--nodes", 20_000, "--first-cell", 0.01], inertial, 'format = "ugrid-b8"'),
    ]:
        mesh = folder / f"{name}.{'lb8.ugrid' if name == 'ugrid' else 'vtu'}"
        schedule = mesh.with_suffix(".toml")
        azimesh("sample", "rotor", *options, "-o", mesh)
        text = schedule.read_text().replace("step = 10.0", "step = 130.0").replace(*change)
        text = text.replace("tolerance = 3e-5", "tolerance = 5e-3").replace("collective = 10.04", "collective = 4.0")
        text = text.replace("[rotor]", "[rotor]\nrpm = 300.0")
        assert change[1] in text
        schedule.write_text(text.replace("[rbf]", f"[output]\n{output}\n[rbf]"))
        azimesh("deform", mesh, schedule, "-o", folder / f"{name}_alone")
        for n in (2, 3, 7):
            told = ranks(n, "-v", "deform", mesh, schedule, "-o", folder / f"{name}_{n}").stderr
            assert "read whole" not in told, f"{name}: the first rank has read the mesh\n{told}"
            n_files += same(content(folder / f"{name}_{n}"), content(folder / f"{name}_alone"), f"{name} with {n} ranks")
    report("mpi: rotors", n_files, 0, "files")


def check_large(folder):
    """A mesh of several slabs: quality and deformation with 2 to 5 ranks, which write the positions of their slabs."""
    mesh, schedule = folder / "b.vtu", folder / "b.toml"
    azimesh("sample", "blade", "--nodes", 40_000, "--cells", "tet", "-o", mesh)
    schedule.write_text(schedule.read_text().replace("step = 10.0", "step = 130.0"))
    judged = subprocess.run([AZIMESH, "quality", mesh, "--worst", "7"], capture_output=True, text=True, check=True)
    for n in (2, 4, 5):
        assert ranks(n, "quality", mesh, "--worst", 7).stdout == judged.stdout, f"quality with {n} ranks"
    narrow = ("support_radius = 5.625", "support_radius = 0.35")
    for name, output, change, numbers in [
        ("vtu", "", None, (2, 4, 5)),
        ("vtkhdf", 'format = "vtkhdf"', None, (3,)),
        ("cgns", 'format = "cgns"', None, (7,)),
        ("unjudged", 'format = "cgns"\nquality = "none"', None, (2,)),
        ("repaired", 'format = "vtkhdf"', narrow, (2, 3)),
    ]:
        text = schedule.read_text().replace("[rbf]", f"[output]\n{output}\n[rbf]").replace(*change or ("", ""))
        of_case = folder / f"large_{name}.toml"
        of_case.write_text(text)
        azimesh("deform", mesh, of_case, "-o", folder / f"large_{name}")
        for n in numbers:
            out = folder / f"large_{name}_{n}"
            told = ranks(n, "-v", "deform", mesh, of_case, "-o", out).stderr
            # Of a run whose steps are all repaired the ranks write the nodes of their cells.
            n_sent = int(re.search(r"^writing: ([\d,]+) messages", told, re.MULTILINE)[1].replace(",", ""))
            assert n_sent > 2 * (n - 1), f"{name}: the ranks have written nothing\n{told}"
            assert ("read whole" in told) == (name == "repaired"), f"{name}: whether the first rank has read the mesh\n{told}"
            same(content(out), content(folder / f"large_{name}"), f"a blade, {name}, with {n} ranks")
    report("mpi: several slabs", 8, 0, "runs")


# What names of the files end with that ranks read by slabs.
BY_SLABS = ["vtkhdf", "vtu", "cgns", "msh", "lb8.ugrid"]


def check_slabs(folder):
    """Files of which each rank reads its slab: meshes, sequences and references are judged as by one process, and no rank reads the whole."""
    n_judged = 0
    meshes = [(folder / "b.vtu", "blade"), (TESTDATA / "naca0012.vtu", "naca"), (TESTDATA / "mixed_cells.su2", "mixed")]
    for ending in BY_SLABS:
        cases = []
        for mesh, name in meshes:
            path = folder / f"slabs_{name}.{ending}"
            if name == "naca" and ending == "lb8.ugrid":
                continue
            azimesh("convert", mesh, path)
            cases += [[path], [path, "--reference", path]]
        if ending in ("vtkhdf", "cgns"):
            schedule = schedule_of(folder, "naca0012", {"[rbf]": f"[output]\nformat = \"{ending}\"\n[rbf]"})
            azimesh("deform", TESTDATA / "naca0012.vtu", schedule, "-o", folder / f"slabs_{ending}")
            cases += [[folder / f"slabs_{ending}"]]
        for case in cases:
            for form in ([], ["--json"]):
                alone = subprocess.run([AZIMESH, "quality", *case, *form], capture_output=True, text=True, check=True)
                for n in (2, 3, 4):
                    done = ranks(n, "-v", "quality", *case, *form)
                    assert done.stdout == alone.stdout, f"{case} with {n} ranks"
                    assert "read whole by one rank" not in done.stderr, done.stderr
                    n_judged += 1
        whole = ranks(2, "-v", "quality", folder / f"slabs_mixed.{ending}", "--worst", 3)
        assert whole.stderr.count("read whole by one rank: --worst") == 1, whole.stderr
    report("mpi: read by slabs", n_judged, 0, "judged")


def check_convert(folder):
    """Meshes that ranks read and write together have the bytes that one process writes; what they do not is done by the first."""
    n_written = 0
    for start in ("vtkhdf", "vtu", "cgns", "lb8.ugrid"):
        mesh = folder / f"slabs_blade.{start}"
        for ending in ("vtkhdf", "vtu", "cgns", "b8.ugrid", "su2"):
            alone = folder / f"converted.{ending}"
            azimesh("convert", mesh, alone, "--force")
            for n in (2, 5):
                together = folder / f"together.{ending}"
                told = ranks(n, "-v", "convert", mesh, together, "--force").stderr
                assert ("read whole" in told) == (ending == "su2"), told
                assert alone.read_bytes() == together.read_bytes(), f"{start} to {ending} with {n} ranks"
                n_written += 1
    # Cells of several kinds in turn.
    mesh, alone, together = folder / "slabs_mixed.vtkhdf", folder / "mixed.b8.ugrid", folder / "mixed_of_ranks.b8.ugrid"
    azimesh("convert", mesh, alone)
    told = ranks(3, "-v", "convert", mesh, together).stderr
    assert "read whole" not in told and alone.read_bytes() == together.read_bytes(), told
    pvd = folder / "large_vtu" / "b.pvd"
    last, of_ranks = folder / "last.vtu", folder / "last_of_ranks.vtu"
    azimesh("convert", pvd, last)
    told = ranks(2, "-v", "convert", pvd, of_ranks).stderr
    assert "read whole" not in told and last.read_bytes() == of_ranks.read_bytes(), told
    mesh, scaled = folder / "slabs_blade.cgns", [folder / "scaled_alone.vtu", folder / "scaled.vtu"]
    azimesh("convert", mesh, scaled[0], "--scale", 0.001)
    assert "one rank changes it" in ranks(2, "-v", "convert", mesh, scaled[1], "--scale", 0.001).stderr
    assert scaled[0].read_bytes() == scaled[1].read_bytes(), "scaled"
    report("mpi: convert", n_written + 3, 0, "files")


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
    n_files = same(content(folder / "script"), content(folder / "no_script"), "slurm_mpi.sh")
    report("mpi: script", n_files, 0, "files")


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
    # A file for each step, and one for all.
    formats = [["--format", "vtu"], ["--format", "vtkhdf"]]
    wanted, longest, n_killed = [], 0.0, 0
    for form in formats:
        started = time.monotonic()
        azimesh("deform", mesh, schedule, "-o", folder / form[1], *form)
        length = 2 * (time.monotonic() - started)
        wanted.append(content(folder / form[1]))
    for kill in range(KILLS):
        out, form = folder / f"killed_{kill}", formats[kill % 2]
        run = command(3, "-q", "deform", mesh, schedule, "-o", out, *form)
        process = subprocess.Popen(run, stderr=subprocess.PIPE, env=os.environ | ALLOWED)
        seconds = kill_one(process, chance.uniform(0.1, length), chance)
        told = process.stderr.read().decode()
        if seconds is not None:
            n_killed += 1
            longest = max(longest, seconds)
            assert process.returncode != 0, "a launcher whose rank was killed tells that it failed"
            assert told.count("error: ") <= 1 and seconds < 10, told
        again = ["--resume"] if (out / "run.json").exists() else []
        told = ranks(chance.choice([1, 2, 4]), "-v", "deform", mesh, schedule, "-o", out, *form, *again).stderr
        assert "read whole" not in told, told
        same(content(out), wanted[kill % 2], f"resumed after kill {kill}")
    assert n_killed > 0, "no rank was killed in time"
    report("mpi: kills", n_killed, 0, "ranks killed", f"all ended within {longest:.1f} s, every run resumed to the same bytes")


def main():
    with scratch() as folder:
        check_cases(folder)
        check_rotors(folder)
        check_large(folder)
        check_slabs(folder)
        check_convert(folder)
        check_no_room(folder)
        check_errors(folder)
        check_script(folder)
        check_kills(folder)

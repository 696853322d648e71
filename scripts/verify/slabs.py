"""Slabs of a mesh, each moved by a run of its own: 1 to 9 of them joined give what one run gives, to the byte, for every format
and motion; what a run leaves that is killed is resumed.

    KILLS          how often a run is killed (4)
"""

import os
import random
import signal
import subprocess
import time
from pathlib import Path

from batches import shell
from mpi import content, same, schedule_of
from program import AZIMESH, TESTDATA, azimesh, report, scratch

KILLS = int(os.environ.get("KILLS", "4"))
SEED = 20261125
# What slabs do without the whole mesh: a solid mesh, its schedule and changes of that.
CASES = [
    ("hart_ii", "hart_ii", {"step = 15": "step = 60"}),
    ("hart_ii", "hart_ii", {"step = 15": "step = 60", "[rbf]": "[rbf]\ninterpolate = \"twist\""}),
    ("hart_ii", "hart_ii", {"step = 15": "step = 60", "[rbf]": "[output]\nvelocity = true\n[rbf]"}),
    ("rotor_sector", "rotor_sector", {}),
    ("rotor_sector", "rotor_sector_sliding", {}),
    ("body_in_duct", "body_in_duct", {}),
    ("wing_on_plane", "wing_on_plane", {"[selection]": "[selection]\ncorrection = false"}),
    ("wing_on_plane", "wing_on_plane", {"[selection]": "[selection]\nmethod = \"real\""}),
    ("wing_on_plane", "wing_on_plane", {}),
    ("wing_on_plane", "wing_on_plane", {"[rbf]": "[rbf]\nsubsteps = 2"}),
    ("rotor_sector", "rotor_sector", {"[rbf]": "[rbf]\nsubsteps = 3", "[selection]": "[selection]\ncorrection = false"}),
]
# What they need the whole mesh for, and what is told of that.
WHOLE = [
    ("naca0012", "naca0012", {"[rbf]": "[output]\nquality = \"cells\"\ndisplacement = true\n[rbf]"}, "arrays of all cells"),
    ("naca0012", "naca0012", {"support_radius = 10.0": "support_radius = 1.5"}, "no solid cells"),
    ("block", "block", {"angle = 60.0": "angle = 170.0"}, "no solid cells"),
    ("block", "block_sliding", {}, "no solid cells"),
]


# A blade in a zone: of tetrahedra cells outside the zone lie in several slabs.
SMALL_ZONE = ["--layers", 6, "--first-cell", 0.003, "--surface-nodes", 12_000]


def in_slabs(mesh, schedule, out, n, *options, expect=0):
    """Runs the slabs in any order, and joins them."""
    numbers = list(range(1, n + 1))
    random.Random(SEED + n).shuffle(numbers)
    for number in numbers:
        azimesh("deform", mesh, schedule, "-o", out, "--slab", f"{number}/{n}", *options)
    azimesh("finish", out, expect=expect)


def joined(folder):
    """What joined slabs leave, but for their own files."""
    return {name: held for name, held in content(folder).items() if not name.startswith("slabs_")}


def told(mesh, schedule, *options):
    """What a slab that is all of a mesh tells."""
    out = mesh.parent / "told"
    command = [AZIMESH, "deform", mesh, schedule, "-o", out, "--slab", "1/1", *options]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    subprocess.run(["rm", "-r", out], check=True)
    return done.stderr


def check_cases(folder):
    """Every sort of motion, from each format and to each, in 1 to 9 slabs."""
    n_files = 0
    formats = {"vtkhdf": "vtkhdf", "cgns": "cgns", "vtu": "vtu", "b8.ugrid": "ugrid-lb8l"}
    for number, (name, schedule, changes) in enumerate(CASES):
        schedule = schedule_of(folder, schedule, changes)
        for i, ending in enumerate(formats):
            mesh = folder / f"{name}.{ending}"
            azimesh("convert", TESTDATA / f"{name}.vtu", mesh, "--force")
            # Symmetry planes, whose numbers in UGRID tell their direction.
            conditions = folder / f"{name}.mapbc"
            if conditions.exists():
                conditions.write_text(conditions.read_text().replace(" 0 ", " 6662 "))
            written = [*formats.values()][(number + i) % 4]
            alone = folder / f"{number}_{ending}"
            azimesh("deform", mesh, schedule, "-o", alone, "--format", written)
            said = told(mesh, schedule, "--format", written)
            assert "read whole" not in said, f"{schedule.name} from {ending} to {written}: {said}"
            for n in (1 + (number + i) % 3, 4 + (number + 2 * i) % 6):
                out = folder / f"{number}_{ending}_{n}"
                in_slabs(mesh, schedule, out, n, "--format", written)
                n_files += same(joined(out), content(alone), f"{schedule.name} from {ending} to {written} in {n} slabs")
    report("slabs: cases", n_files, 0, "files")


def check_large(folder):
    """Meshes of which every slab has cells: tetrahedra, wedges and hexahedra; repaired steps; 1 to 9 slabs."""
    n_files = 0
    narrow = ("support_radius = 5.625", "support_radius = 0.35")
    for name, cells, nodes, output, change, numbers in [
        ("tet", "tet", 50_000, 'format = "vtu"', None, range(1, 10)),
        ("wedge", "wedge", 80_000, 'format = "vtkhdf"', None, (2, 4)),
        ("hex", "hex", 110_000, 'format = "cgns"', None, (3,)),
        ("repaired", "tet", 50_000, 'format = "vtkhdf"', narrow, (1, 4)),
        ("warned", "tet", 50_000, 'format = "cgns"\non_inverted = "warn"', narrow, (3,)),
        ("substeps", "tet", 50_000, 'format = "vtu"\non_inverted = "substeps"', narrow, (2,)),
        ("stopped", "tet", 50_000, 'format = "vtkhdf"\non_inverted = "stop"', narrow, (2,)),
        ("unjudged", "tet", 50_000, 'format = "cgns"\nquality = "none"', None, (5,)),
        ("single", "tet", 50_000, 'format = "vtu"\nprecision = "f32"', None, (6,)),
    ]:
        mesh, schedule = folder / f"{name}.vtkhdf", folder / f"{name}.toml"
        first_cell = 0.01 if name == "single" else 1e-4
        azimesh("sample", "blade", "--nodes", nodes, "--cells", cells, "--first-cell", first_cell, "-o", mesh)
        text = schedule.read_text().replace("step = 10.0", "step = 130.0").replace("[rbf]", f"[output]\n{output}\n[rbf]")
        schedule.write_text(text.replace(*change or ("", "")))
        alone, expect = folder / f"large_{name}", 1 if name in ("warned", "substeps", "stopped") else 0
        azimesh("deform", mesh, schedule, "-o", alone, expect=expect)
        for n in numbers:
            out = folder / f"large_{name}_{n}"
            in_slabs(mesh, schedule, out, n, expect=expect)
            n_files += same(joined(out), content(alone), f"a blade, {name}, in {n} slabs")
    report("slabs: large meshes", n_files, 0, "files")


def check_whole(folder):
    """What slabs need the whole mesh for."""
    n_files = 0
    for number, (name, schedule, changes, reason) in enumerate(WHOLE):
        schedule = schedule_of(folder, schedule, changes)
        for ending in ("vtu", "vtkhdf", "cgns"):
            mesh, alone = folder / f"{name}.{ending}", folder / f"whole_{number}_{ending}"
            azimesh("convert", TESTDATA / f"{name}.vtu", mesh, "--force")
            said = told(mesh, schedule, "--format", ending)
            assert "read whole" in said and reason in said, said
            azimesh("deform", mesh, schedule, "-o", alone, "--format", ending)
            for n in (1, 3 + number % 4):
                out = folder / f"{alone.name}_{n}"
                in_slabs(mesh, schedule, out, n, "--format", ending)
                n_files += same(joined(out), content(alone), f"{schedule.name} as {ending} in {n} slabs")
    report("slabs: whole meshes", n_files, 0, "files")


def check_rotors(folder):
    """A zone that turns against the rest, a zone that deforms alone, bodies around a hub that are carried round; a plane mesh."""
    n_files = 0
    inertial, few = ('frame = "rotating"', 'frame = "inertial"'), ("step = 10.0", "step = 130.0")
    coarse = [few, ("tolerance = 3e-5", "tolerance = 5e-3"), ("collective = 10.04", "collective = 4.0")]
    zone = ["--layers", 4, "--first-cell", 0.01, "--surface-nodes", 3000]
    bodies = ["--blades", 3, "--nodes", 60_000, "--first-cell", 0.01]
    for name, sample, options, changes, output, numbers in [
        ("zone", "rotor", zone, [*coarse, inertial], 'format = "cgns"', (2, 5)),
        ("still", "rotor", zone, coarse, 'format = "vtu"', (3,)),
        ("zone32", "rotor", [*SMALL_ZONE, "--cells", "tet"], coarse, 'format = "vtkhdf"\nprecision = "f32"', (3,)),
        ("bodies", "rotor", bodies, [*coarse, inertial], 'format = "vtkhdf"\nprecision = "f32"', (1, 4)),
        ("gmsh", "rotor", [*SMALL_ZONE, "--cells", "tet"], [*coarse, inertial], 'format = "vtkhdf"', (2,)),
        ("plane", "naca0012", ["--nodes", 70_000], [few], 'format = "vtkhdf"\ndisplacement = true', (2, 7)),
        ("text", "blade", ["--nodes", 40_000], [few], 'format = "msh"', (3,)),
    ]:
        mesh, schedule = folder / f"{name}.{'msh' if name in ('gmsh', 'text') else 'vtu'}", folder / f"{name}.toml"
        azimesh("sample", sample, *options, "-o", mesh)
        text = schedule.read_text()
        for old, new in changes:
            text = text.replace(old, new)
            assert new in text, f"{new} is not in {name}.toml"
        schedule.write_text(text.replace("[rbf]", f"[output]\n{output}\n[rbf]"))
        alone = folder / f"rotor_{name}"
        azimesh("deform", mesh, schedule, "-o", alone)
        is_whole = name in ("plane", "text")
        assert ("read whole" in told(mesh, schedule)) == is_whole, f"{name}: whether the mesh is read whole"
        for n in numbers:
            in_slabs(mesh, schedule, folder / f"{alone.name}_{n}", n)
            n_files += same(joined(folder / f"{alone.name}_{n}"), content(alone), f"{name} in {n} slabs")
    report("slabs: rotors and plane meshes", n_files, 0, "files")


def check_kills(folder):
    """Slabs and their joining killed at any moment, and resumed."""
    chance = random.Random(SEED)
    mesh, schedule = folder / "tet.vtkhdf", folder / "tet.toml"
    schedule.write_text(schedule.read_text().replace("step = 130.0", "step = 15.0"))
    azimesh("deform", mesh, schedule, "-o", folder / "whole")
    wanted, out, n_killed = content(folder / "whole"), folder / "killed", 0

    def killed(*arguments):
        """Kills the command after a while; how long it took where it was not."""
        nonlocal n_killed
        process = subprocess.Popen([AZIMESH, "-q", *map(str, arguments)])
        try:
            process.wait(timeout=chance.uniform(0.05, 1.0))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
            n_killed += 1

    for _ in range(KILLS):
        for slab in ("1/3", "2/3", "3/3"):
            arguments = ["deform", mesh, schedule, "-o", out, "--slab", slab, "--resume"]
            killed(*arguments)
            azimesh(*arguments)
        killed("finish", out)
        azimesh("finish", out)
        same(joined(out), wanted, "resumed")
        subprocess.run(["rm", "-r", out], check=True)
    assert n_killed > 0, "nothing was killed in time"
    report("slabs: kills", n_killed, 0, "runs killed", "every one resumed to the same bytes")


def check_script(folder):
    """docs/examples/slurm_slabs.sh, with Slurm's variables set by hand."""
    for task in (3, 1, 2, 2):
        shell("slurm_slabs.sh", "tet.vtkhdf", "tet.toml", "array", 3, folder=folder, SLURM_ARRAY_TASK_ID=task)
    subprocess.run([Path(AZIMESH).resolve(), "-q", "finish", "array"], cwd=folder, check=True)
    n_files = same(joined(folder / "array"), content(folder / "whole"), "slurm_slabs.sh")
    report("slabs: script", n_files, 0, "files")


def main():
    started = time.monotonic()
    with scratch() as folder:
        check_cases(folder)
        check_large(folder)
        check_whole(folder)
        check_rotors(folder)
        check_kills(folder)
        check_script(folder)
    print(f"slabs: {time.monotonic() - started:.0f} s", flush=True)

"""Two builds of azimesh on the same input: what they leave must be the same bytes.

    .venv/bin/python scripts/compare_builds.py BEFORE AFTER [--meshes FOLDER]

Runs `deform` with every schedule of testdata (those of testdata/real on the meshes of FOLDER) and of the samples, in every
format that can be written, as a whole, in parts that `finish` joins, stopped and resumed, and with base points of `select`; and
`convert` of every mesh of testdata into every format. Meshes, base points and lists must be the same bytes, steps.csv the same
but for `seconds`, run.json have the same keys; exit codes and what is printed must be the same but for paths of the program and seconds.
Ends with 1 and names each file where something differs.
"""

import argparse
import csv
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

TESTDATA = Path(__file__).resolve().parents[1] / "testdata"
FORMATS = ["vtu", "vtk", "vtk42", "vtkhdf", "msh", "msh22", "su2", "cgns", "ugrid", "ugrid-b8", "ugrid-lb4"]
SAMPLES = {
    "naca0012": ["naca0012", "--nodes", "1000"],
    "blade": ["blade", "--nodes", "4000"],
    "rotor": ["rotor", "--nodes", "8000"],
    "rotors": ["rotor", "--blades", "4", "--nodes", "16000"],
    "block": ["block", "--nodes", "900"],
}
# Schedules of testdata/real and the meshes that they are for.
REAL = {
    "naca0012_openfoam.toml": "gen_openfoam1912/naca0012_adjoint/naca0012_tagged.vtu",
    "wing_motion_2d.toml": "gen_openfoam1912/wingMotion2D/wingMotion2D_tagged.vtu",
    "sphere_su2.toml": "su2code__TestCases/hom_navierstokes/SphereViscous/nPoly1/SphereViscous_Linear.su2.gz",
    "wing_fuselage_gmsh.toml": "gen_gmsh4.15/wing_fuselage_12k_v41_bin.msh",
    "naca0012_su2_hybrid.toml": "su2code__TestCases/navierstokes/naca0012/mesh_NACA0012_lam_hybrid_v1.su2",
    "naca0012_pitching.toml": "su2code__TestCases/disc_adj_euler/naca0012_pitching_def/mesh_NACA0012_inv_FFD.su2",
}
SECONDS = re.compile(r"\d+\.\d+ s\b|(selection|modes|steps|other|writing) \d+\.\d+")


class Differences:
    """What differs, a line each; how much was compared."""

    def __init__(self):
        self.lines, self.n_files, self.n_commands = [], 0, 0

    def folders(self, what, before, after):
        """Files of two folders, those of folders in them too."""
        names = [{path.relative_to(folder) for path in folder.rglob("*") if path.is_file()} for folder in (before, after)]
        for name in sorted(names[0] ^ names[1]):
            self.lines.append(f"{what}: {name} is left by one build only")
        for name in sorted(names[0] & names[1]):
            self.n_files += 1
            if content(before / name) != content(after / name):
                self.lines.append(f"{what}: {name} is another")


def content(path):
    """What of a file must be the same."""
    if re.fullmatch(r"steps.*\.csv", path.name):
        rows = list(csv.reader(path.open(newline="")))
        seconds = rows[0].index("seconds") if rows else 0
        return [row[:seconds] for row in rows]
    if re.fullmatch(r"run.*\.json", path.name):
        return sorted(keys(json.loads(path.read_text())))
    return path.read_bytes()


def keys(value, prefix=""):
    """Paths of all keys of a JSON object; those of a list's first element."""
    if isinstance(value, list):
        value = value[0] if value else None
    for key, inner in value.items() if isinstance(value, dict) else []:
        yield f"{prefix}{key}"
        yield from keys(inner, f"{prefix}{key}.")


class Build:
    """One of the programs, in a folder of its own."""

    def __init__(self, program, folder):
        self.program, self.folder = str(Path(program).resolve()), folder
        folder.mkdir()

    def run(self, arguments):
        """Exit code and what was printed, seconds left out."""
        environment = {key: value for key, value in os.environ.items() if not key.startswith("SLURM")}
        done = subprocess.run(
            [self.program, *map(str, arguments)], cwd=self.folder, env=environment, capture_output=True, text=True, errors="replace"
        )
        return done.returncode, SECONDS.sub("", done.stdout), SECONDS.sub("", done.stderr)


def both(builds, found, what, *arguments):
    """Runs a command in both; notes another exit code or text. The exit code of the first."""
    before, after = (build.run(arguments) for build in builds)
    found.n_commands += 1
    for name, one, other in zip(["exit code", "output", "messages"], before, after):
        if one != other:
            found.lines.append(f"{what}: {' '.join(map(str, arguments))}: {name}:\n    before {one!r}\n    after  {other!r}")
    return before[0]


def compare_folders(builds, found, what, name):
    """Compares a folder of both and removes it."""
    folders = [build.folder / name for build in builds]
    if all(folder.is_dir() for folder in folders):
        found.folders(what, *folders)
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)


def n_steps_of(build, mesh, schedule):
    """Steps of a schedule; 0 where it is refused."""
    code, text, _ = build.run(["check", mesh, schedule, "--json"])
    return len(json.loads(text)["steps"]) if code == 0 else 0


def deform(builds, found, mesh, schedule):
    """One schedule in every format and way."""
    what = f"{Path(mesh).name} {Path(schedule).name}"
    for name in FORMATS:
        both(builds, found, what, "deform", mesh, schedule, "-o", "out", "--format", name)
        compare_folders(builds, found, f"{what} {name}", "out")
    n = n_steps_of(builds[0], mesh, schedule)
    if n < 3:
        return
    code = both(builds, found, what, "select", mesh, schedule, "-o", "base.toml", "--force")
    base = ["--base", "base.toml"] if code == 0 else []
    for name in ["vtu", "vtkhdf", "cgns"]:
        for steps in [f"0..{n // 3}", f"{n // 3}..{n - 1}", f"{n - 1}..{n}"]:
            both(builds, found, what, "deform", mesh, schedule, "-o", "out", "--format", name, "--steps", steps, *base)
        both(builds, found, what, "finish", "out")
        compare_folders(builds, found, f"{what} {name} in parts", "out")
        both(builds, found, what, "deform", mesh, schedule, "-o", "out", "--format", name)
        for build in builds:
            cut_table(build.folder / "out" / "steps.csv", 1 + n // 2)
        both(builds, found, what, "deform", mesh, schedule, "-o", "out", "--format", name, "--resume")
        compare_folders(builds, found, f"{what} {name} resumed", "out")


def cut_table(path, n_lines):
    """Leaves the first lines, as a run that was stopped would."""
    if path.exists():
        path.write_text("".join(path.read_text().splitlines(keepends=True)[:n_lines]))


def convert(builds, found, mesh):
    """One mesh into every format."""
    both(builds, found, mesh.name, "info", mesh, "--json")
    both(builds, found, mesh.name, "quality", mesh, "--json")
    for name in FORMATS:
        both(builds, found, mesh.name, "convert", mesh, "-o", "out", "--format", name)
        compare_folders(builds, found, f"{mesh.name} into {name}", "out")


def cases(builds, meshes):
    """Pairs of a mesh and a schedule."""
    for schedule in sorted(TESTDATA.glob("*.toml")):
        stem = next(stem for stem in [schedule.stem, schedule.stem.removesuffix("_sliding")] if (TESTDATA / f"{stem}.vtu").exists())
        yield TESTDATA / f"{stem}.vtu", schedule
    for name, arguments in SAMPLES.items():
        for build in builds:
            build.run(["sample", *arguments, "-o", f"{name}.vtu"])
        if (builds[0].folder / f"{name}.vtu").exists():
            yield f"{name}.vtu", f"{name}.toml"
    for name, mesh in REAL.items() if meshes else []:
        if (meshes / mesh).exists():
            yield meshes / mesh, TESTDATA / "real" / name


def main():
    """A count, or what differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--meshes", type=Path, help="folder of real meshes")
    options = parser.parse_args()
    found = Differences()
    with tempfile.TemporaryDirectory(prefix="azimesh-builds-") as folder:
        builds = [Build(program, Path(folder) / name) for name, program in [("before", options.before), ("after", options.after)]]
        for mesh, schedule in cases(builds, options.meshes):
            deform(builds, found, mesh, schedule)
            print(f"{Path(mesh).name} {Path(schedule).name}: {found.n_files} files, {len(found.lines)} differences so far", flush=True)
        patterns = ["*.vtu", "*.vtkhdf", "*.msh", "*.su2", "*.ugrid", "vtk/*", "cgns/*.cgns", "gmsh/*.msh"]
        for mesh in sorted(path for pattern in patterns for path in TESTDATA.glob(pattern)):
            convert(builds, found, mesh)
    print("\n".join(found.lines))
    print(f"{found.n_commands} commands, {found.n_files} files compared, {len(found.lines)} differences")
    return 1 if found.lines else 0


if __name__ == "__main__":
    sys.exit(main())

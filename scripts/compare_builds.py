"""Two builds of azimesh on the same input: what they leave must be the same bytes.

    .venv/bin/python scripts/compare_builds.py BEFORE AFTER

Runs `deform` with every schedule of testdata and of the samples, in every format that can be written, as a whole, in parts that `finish` joins, and
resumed, and `convert` of every mesh of testdata into every format. Files must be the same bytes, steps.csv the same but for `seconds`, run.json have
the same keys; exit codes and what is printed must be the same but for seconds. Ends with 1 and names each file where something differs.
"""

import csv
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

TESTDATA = Path(__file__).resolve().parents[1] / "testdata"
FORMATS = ["vtu", "vtk", "vtk42", "vtkhdf", "msh", "msh22", "su2", "cgns", "ugrid", "ugrid-b8", "ugrid-lb4"]
SAMPLES = ["naca0012 --nodes 1000", "blade --nodes 4000", "rotor --nodes 8000", "rotor --blades 4 --nodes 16000", "block --nodes 900"]
SECONDS = re.compile(r"\d+\.\d+ s\b|(selection|modes|steps|other|writing) \d+\.\d+")
PATTERNS = ["*.vtu", "*.vtkhdf", "*.msh", "*.su2", "*.ugrid", "*.exo", "*.mesh", "*.inp", "vtk/*", "cgns/*.cgns", "gmsh/*.msh", "fluent/*", "openfoam/*"]


def keys(value, prefix=""):
    """Paths of all keys of a JSON object; those of a list's first element."""
    value = value[0] if isinstance(value, list) and value else value
    for key, inside in value.items() if isinstance(value, dict) else []:
        yield f"{prefix}{key}"
        yield from keys(inside, f"{prefix}{key}.")


def content(path):
    """What of a file must be the same."""
    if re.fullmatch(r"steps.*\.csv", path.name):
        rows = list(csv.reader(path.open(newline="")))
        return [row[: rows[0].index("seconds")] for row in rows]
    return sorted(keys(json.loads(path.read_text()))) if re.fullmatch(r"run.*\.json", path.name) else path.read_bytes()


class Builds:
    """Both programs, each in a folder of its own, and what differed."""

    def __init__(self, programs, folder):
        self.programs = [Path(program).resolve() for program in programs]
        self.folders = [folder / name for name in ("before", "after")]
        for place in self.folders:
            place.mkdir()
        self.wrong, self.n_files, self.n_commands = [], 0, 0

    def run(self, *arguments):
        """Runs a command in both; the exit code and the output of the first."""
        said = []
        for program, folder in zip(self.programs, self.folders):
            done = subprocess.run([program, *map(str, arguments)], cwd=folder, capture_output=True, text=True, errors="replace")
            said.append((done.returncode, SECONDS.sub("", done.stdout), SECONDS.sub("", done.stderr)))
        self.n_commands += 1
        self.wrong += [f"{' '.join(map(str, arguments))}:\n    before {said[0]}\n    after  {said[1]}"] * (said[0] != said[1])
        return said[0][:2]

    def compare(self, what):
        """Compares the folders `out` and removes them."""
        outs = [folder / "out" for folder in self.folders]
        names = [{path.relative_to(out) for path in out.rglob("*") if path.is_file()} if out.is_dir() else {Path(".")} if out.exists() else set() for out in outs]
        self.wrong += [f"{what}: {name} is left by one build only" for name in sorted(names[0] ^ names[1])]
        for name in sorted(names[0] & names[1]):
            self.n_files += 1
            self.wrong += [f"{what}: {name} is another"] * (content(outs[0] / name) != content(outs[1] / name))
        for out in outs:
            shutil.rmtree(out) if out.is_dir() else out.unlink(missing_ok=True)

    def deform(self, mesh, schedule):
        """One schedule in every format, in parts, and resumed."""
        what, command = f"{Path(mesh).name} {Path(schedule).name}", ["deform", mesh, schedule, "-o", "out", "--format"]
        for name in FORMATS:
            self.run(*command, name)
            self.compare(f"{what} {name}")
        code, said = self.run("check", mesh, schedule, "--json")
        n = len(json.loads(said)["steps"]) if code == 0 else 0
        for name in ["vtu", "vtkhdf", "cgns"] if n > 2 else []:
            for steps in (f"0..{n // 3}", f"{n // 3}..{n - 1}", f"{n - 1}..{n}"):
                self.run(*command, name, "--steps", steps)
            self.run("finish", "out")
            self.compare(f"{what} {name} in parts")
            self.run(*command, name)
            for table in [folder / "out" / "steps.csv" for folder in self.folders]:
                table.write_text("".join(table.read_text().splitlines(keepends=True)[: 1 + n // 2])) if table.exists() else None
            self.run(*command, name, "--resume")
            self.compare(f"{what} {name} resumed")

    def convert(self, mesh):
        """One mesh into every format."""
        for command in ("info", "quality"):
            self.run(command, mesh, "--json")
        for name in FORMATS:
            self.run("convert", mesh, "-o", "out", "--format", name)
            self.compare(f"{mesh.name} into {name}")


def main():
    """A count, or what differs."""
    with tempfile.TemporaryDirectory(prefix="azimesh-builds-") as folder:
        builds = Builds(sys.argv[1:3], Path(folder))
        for schedule in sorted(TESTDATA.glob("*.toml")):
            builds.deform(TESTDATA / f"{schedule.stem.removesuffix('_sliding')}.vtu", schedule)
        for i, options in enumerate(SAMPLES):
            builds.run("sample", *options.split(), "-o", f"{i}.vtu")
            builds.deform(f"{i}.vtu", f"{i}.toml")
        for mesh in sorted(path for pattern in PATTERNS for path in TESTDATA.glob(pattern)):
            builds.convert(mesh)
    print("\n".join(builds.wrong))
    print(f"{builds.n_commands} commands, {builds.n_files} files compared, {len(builds.wrong)} differences")
    return 1 if builds.wrong else 0


if __name__ == "__main__":
    sys.exit(main())

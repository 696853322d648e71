"""azimesh beside other programs on large meshes: whole commands in turn, medians of seconds and peak memory.

    .venv/bin/python benchmarks/bench.py [convert run quality diff openfoam scipy growth threads] [--nodes 1000000] [--rounds 3] [--folder target/bench]

Meshes are samples; a peer that is not installed, or fails, has its complaint in the table. Files that are written are synced. `hyperfine` measures
single commands as well; here commands alternate, and the peak memory of each is taken.
"""

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

AZIMESH = os.environ.get("AZIMESH", "target/release/azimesh")
ETC = Path("/usr/share/openfoam/etc/bashrc")
GMSH = "import gmsh, sys; gmsh.initialize(); gmsh.option.setNumber('General.Terminal', 0); gmsh.open(sys.argv[1]); gmsh.write(sys.argv[2])"
PYTHON = {
    "gmsh": GMSH, "meshio": "import meshio, sys; meshio.read(sys.argv[1]).write(sys.argv[2])",
    "pyvista": "import pyvista, sys; pyvista.save_meshio(sys.argv[2], pyvista.read(sys.argv[1]))",
}  # fmt: skip
VTK_QUALITY = """
import sys, vtk
reader = vtk.vtkXMLUnstructuredGridReader(); reader.SetFileName(sys.argv[1])
for measure in ("Volume", "ScaledJacobian", "EdgeRatio", "EquiangleSkew"):
    judge = vtk.vtkMeshQuality(); judge.SetInputConnection(reader.GetOutputPort())
    getattr(judge, f"SetTetQualityMeasureTo{measure}")(); judge.Update()
"""
# Displacements of every step at given base points carried to all nodes, as a user would script it.
SCIPY = """
import sys, numpy as np, pyvista
from pathlib import Path
from scipy.interpolate import RBFInterpolator
mesh = pyvista.read(sys.argv[1])
base = np.array(pyvista.read(Path(sys.argv[2]) / "base.vtp").points)
at = {tuple(point): node for node, point in enumerate(mesh.points.tolist())}
nodes = [at[tuple(point)] for point in base.tolist()]
moved = [np.array(pyvista.read(path).points)[nodes] - base for path in sorted(Path(sys.argv[2]).glob("*.vtu"))]
found = RBFInterpolator(base, np.hstack(moved), kernel="linear")(mesh.points)
for i in range(len(moved)):
    copy = mesh.copy(); copy.points = mesh.points + found[:, 3 * i : 3 * i + 3]; copy.save(f"{sys.argv[3]}_{i}.vtu")
"""


def used(command):
    """(seconds, processor seconds, MB) of a command, what it wrote synced; what it said where it fails."""
    os.sync()
    with tempfile.TemporaryFile() as said:
        started = time.monotonic()
        process = subprocess.Popen(list(map(str, command)), stdout=said, stderr=said)
        _, status, usage = os.wait4(process.pid, 0)
        os.sync()
        seconds = time.monotonic() - started
        process.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        lines = said.read().decode(errors="replace").strip().splitlines()
        return (seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024) if process.returncode == 0 else (lines or ["fails"])[-1][:60]


def azimesh(*arguments):
    """A command of azimesh."""
    return [AZIMESH, *map(str, arguments), "-q"]


def made(*command):
    """Runs a command that prepares a benchmark."""
    subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL)


def sample(folder, nodes, *options, name="blade"):
    """A sample mesh, made once."""
    path = folder / f"{name}_{nodes}{''.join(map(str, options)).replace('-', '_')}.vtu"
    if not path.exists():
        made(*azimesh("sample", name, "--nodes", nodes, *options, "-o", path, "--force"))
    return path


def convert(folder, nodes):
    """Converting a rotor of tetrahedra, from and to what each program knows."""
    vtu = sample(folder, nodes, "--cells", "tet", name="rotor")
    for ending in ("msh", "cgns"):
        made(*azimesh("convert", vtu, folder / f"from.{ending}", "--force"))
    ways = [(folder / "from.msh", "vtu"), (folder / "from.msh", "cgns"), (folder / "from.msh", "su2"), (folder / "from.cgns", "msh"), (vtu, "msh")]
    for source, target in ways:
        out = folder / f"to.{target}"
        what = f"{source.suffix[1:]} to {target}"
        yield f"{what}: azimesh", azimesh("convert", source, out, "--force")
        for peer, script in PYTHON.items():
            yield f"{what}: {peer}", [sys.executable, "-c", script, source, folder / f"{peer}.{'vtk' if (peer, target) == ('gmsh', 'vtu') else target}"]


def run(folder, nodes):
    """A revolution with quality beside dd of the same bytes."""
    mesh, out = sample(folder, nodes), folder / "run"
    deform = azimesh("deform", mesh, mesh.with_suffix(".toml"), "-o", out, "--force")
    made(*deform)
    n_bytes = sum(path.stat().st_size for path in out.glob("*.vtu"))
    yield "azimesh", deform
    yield f"dd of {n_bytes / 1e9:.2f} GB", ["dd", "if=/dev/zero", f"of={folder / 'dd.bin'}", "bs=16M", "iflag=count_bytes", f"count={n_bytes}"]


def quality(folder, nodes):
    """Quality of tetrahedra, reading included: all metrics of azimesh, four of VTK."""
    mesh = sample(folder, nodes, "--cells", "tet")
    yield "azimesh", azimesh("quality", mesh)
    yield "VTK", [sys.executable, "-c", VTK_QUALITY, mesh]


def diff(folder, nodes):
    """Differences of a mesh and its copy, in order and by position."""
    mesh, copy = sample(folder, nodes), folder / "copy.vtkhdf"
    made(*azimesh("convert", mesh, copy, "--force"))
    yield "in order", azimesh("diff", mesh, copy)
    yield "by position", azimesh("diff", mesh, copy, "--match", "position")


def openfoam(folder, nodes):
    """Reading a binary polyMesh, and the same mesh as CGNS."""
    mesh, case = sample(folder, nodes, "--cells", "tet"), folder / "case"
    shutil.rmtree(case, ignore_errors=True)
    made(*azimesh("convert", mesh, case, "--format", "openfoam", "--encoding", "raw"))
    made(*azimesh("convert", mesh, folder / "case.cgns", "--force"))
    yield "polyMesh", azimesh("info", case)
    yield "CGNS", azimesh("info", folder / "case.cgns")
    (case / "system").mkdir()
    header = "FoamFile { version 2.0; format ascii; class dictionary; object dictionary; }\n"
    control = "application none; startTime 0; endTime 1; deltaT 1; writeControl timeStep; writeInterval 1; writeFormat binary;\n"
    for name, text in {"controlDict": control, "fvSchemes": "divSchemes {} gradSchemes {} laplacianSchemes {}\n", "fvSolution": "\n"}.items():
        (case / "system" / name).write_text(header + text)
    yield "foamToVTK", ["bash", "-c", f". {ETC} && foamToVTK -constant -case {case}"]


def scipy(folder, nodes):
    """A revolution from given base points beside SciPy's RBFInterpolator on the same points."""
    mesh, out = sample(folder, nodes), folder / "scipy_run"
    schedule, base = mesh.with_suffix(".toml"), folder / "base.toml"
    made(*azimesh("select", mesh, schedule, "-o", base, "--force"))
    deform = azimesh("deform", mesh, schedule, "--base", base, "-o", out, "--force", "--format", "vtu")
    made(*deform)
    yield "azimesh, exact surface and quality", deform
    yield "SciPy RBFInterpolator, linear", [sys.executable, "-c", SCIPY, mesh, out, folder / "scipy"]


def growth(folder, nodes):
    """The same run on ever more nodes."""
    for n in (nodes // 4, nodes // 2, nodes, 2 * nodes):
        mesh = sample(folder, n, "--surface-nodes", nodes // 20)
        yield f"{n:,} nodes", azimesh("deform", mesh, mesh.with_suffix(".toml"), "-o", folder / "growth", "--force", "--steps", "0..4")


def threads(folder, nodes):
    """A run on one thread and on two."""
    mesh = sample(folder, nodes)
    for n in (1, 2):
        yield f"threads: {n}", azimesh("deform", mesh, mesh.with_suffix(".toml"), "-o", folder / "threads", "--force", "--threads", n)


CASES = {case.__name__: case for case in (convert, run, quality, diff, openfoam, scipy, growth, threads)}


def main():
    """A table for each benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", help=", ".join(CASES))
    parser.add_argument("--nodes", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--folder", type=Path, default=Path("target/bench"))
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for name in options.cases or CASES:
        commands = dict(CASES[name](options.folder, options.nodes))
        rounds = [{row: used(command) for row, command in commands.items()} for _ in range(options.rounds)]
        print(f"\n{name}: {CASES[name].__doc__}\n\n| | s | processor, s | peak memory, MB |\n|---|---|---|---|")
        for row in commands:
            found = [one[row] for one in rounds]
            failed = next((one for one in found if isinstance(one, str)), None)
            cells = [failed, "", ""] if failed else ["{:.3g}".format(statistics.median(values)) for values in list(zip(*found))[:2]]
            cells = cells if failed else [*cells, f"{statistics.median(one[2] for one in found):,.0f}"]
            print(f"| {row} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()

"""azimesh beside what a user would script with numpy and SciPy; writes benchmarks/peers.md.

    .venv/bin/python benchmarks/compare_peers.py [--nodes 380000] [--tolerance 1e-4] [--rounds 3]

The sample blade, one set of base points, one step and 36 steps of cyclic pitch and flap. Every program
is a process of its own (`scripted.py` has those that are not azimesh), in turn, over several rounds.
"""

import argparse
import datetime
import json
import os
import shutil
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from measure import PYTHON, alternating, machine, significant, used

SCRIPTED = Path(__file__).with_name("scripted.py")
PAGE = Path(__file__).with_name("peers.md")
STEPS = {1: "values = [270.0]", 36: "start = 0.0\nstop = 350.0\nstep = 10.0"}
ROWS = {
    "azimesh": "azimesh",
    "exact": "azimesh, exact surface and quality",
    "threads": "numpy, in blocks, a thread a core",
    "blocks": "numpy, in blocks",
    "whole": "numpy, whole matrix",
    "scipy": "SciPy `RBFInterpolator`, linear",
}
MOTION = """
[[body]]
name = "blade"
tags = ["blade"]

[body.cyclic]
collective = 10.04
pitch = [ { sin = -7.65, cos = -0.96 } ]
coning = 2.619
flap = [ { sin = 3.211, cos = -0.421 } ]

[boundaries]
fixed = ["outer"]

[rbf]
support_radius = 5.625
"""


def schedule(folder, steps, exact, tolerance):
    """The file of a schedule. `exact` has the correction and the quality of cells, as by default."""
    path = folder / f"steps_{steps}{'_exact' if exact else ''}.toml"
    plain = "" if exact else 'correction = false\n\n[output]\nquality = "none"\n'
    path.write_text(f"[azimuth]\n{STEPS[steps]}\n{MOTION}\n[selection]\ntolerance = {tolerance}\n{plain}")
    return path


def clear(out):
    """A folder out of the way, and the disk at rest."""
    shutil.rmtree(out, ignore_errors=True)
    os.sync()


def azimesh_job(program, folder, steps, exact, tolerance):
    """(computing s, whole s, CPU s, MB) of deform from base points chosen before."""
    out = folder / f"{'exact' if exact else 'azimesh'}_{steps}"
    toml = schedule(folder, steps, exact, tolerance)
    command = [program, "deform", folder / "blade.vtu", toml, "--base", folder / "base.toml", "-o", out, "-q"]

    def job():
        clear(out)
        took = used(command)
        seconds = json.loads((out / "run.json").read_text())["seconds"]
        computing = seconds["selection"] + seconds["modes"] + seconds["steps"]
        return computing, took.seconds, took.cpu_seconds, took.megabytes

    return job


def scripted_job(way, folder, steps):
    """The same of a script."""
    out = folder / f"{way}_{steps}"

    def job():
        clear(out)
        took = used([PYTHON, SCRIPTED, way, folder / "blade.vtu", folder / f"motion_{steps}.npz", out])
        return float(took.said), took.seconds, took.cpu_seconds, took.megabytes

    return job


def prepare(program, folder, nodes, tolerance):
    """Mesh, base points, and what the schedules prescribe there; what azimesh says of the first two."""
    mesh, base = folder / "blade.vtu", folder / "base.toml"
    surface = round(nodes * 25_000 / 380_000)
    used([program, "sample", "blade", "--nodes", nodes, "--surface-nodes", surface, "-o", mesh, "--force", "-q"])
    chosen = used([program, "select", mesh, schedule(folder, 36, False, tolerance), "-o", base, "--force", "--json"])
    for steps in STEPS:
        toml = schedule(folder, steps, False, tolerance)
        used([PYTHON, SCRIPTED, "motion", mesh, toml, base, folder / f"motion_{steps}.npz"])
    about = used([program, "info", mesh, "--json"])
    return json.loads(chosen.said), json.loads(about.said)


def free_bytes():
    """Memory that a process may take now."""
    line = next(line for line in Path("/proc/meminfo").read_text().splitlines() if "MemAvailable" in line)
    return int(line.split()[1]) * 1024


def ways(n_nodes, n_base):
    """The scripts to run. The whole matrix needs four arrays of its size; without room it is left out."""
    needed, free = 4 * 8 * n_nodes * n_base, free_bytes()
    if needed < 0.8 * free:
        return ["threads", "blocks", "whole", "scipy"]
    print(f"whole matrix left out: {needed / 1e9:.0f} GB, {free / 1e9:.0f} GB are free", file=sys.stderr)
    return ["threads", "blocks", "scipy"]


def compare(program, folder, steps, scripts, options):
    """{row: figures} for a number of steps, and {row: accuracy}; the files are removed."""
    jobs = {
        "azimesh": azimesh_job(program, folder, steps, False, options.tolerance),
        "exact": azimesh_job(program, folder, steps, True, options.tolerance),
        **{way: scripted_job(way, folder, steps) for way in scripts},
    }
    figures = alternating(jobs, options.rounds)
    found = {}
    for row in jobs:
        check = ["accuracy", folder / f"motion_{steps}.npz", folder / f"{row}_{steps}", folder / f"azimesh_{steps}"]
        found[row] = json.loads(used([PYTHON, SCRIPTED, *check]).said)
    for row in jobs:
        shutil.rmtree(folder / f"{row}_{steps}")
    return figures, found


def table(figures, found):
    """Rows in markdown; in brackets how many times azimesh's figure."""
    lines = [
        "| | computing, s | whole command, s | CPU, s | peak memory, MB | largest error at the surface |",
        "|---|---|---|---|---|---|",
    ]
    for row, name in ROWS.items():
        if row not in figures:
            continue
        cells = [
            significant(value) + ("" if row == "azimesh" else f" ({significant(value / of, 2)})")
            for value, of in zip(figures[row], figures["azimesh"])
        ]
        lines.append(f"| {name} | {' | '.join(cells)} | {found[row][0]:.1e} |")
    return "\n".join(lines)


def agreement(results):
    """The largest difference between azimesh and numpy, relative to the largest displacement."""
    rows = [found[way] for _, found in results.values() for way in ("threads", "blocks", "whole") if way in found]
    return max(difference / displacement for _, difference, displacement in rows)


def page(options, about, chosen, results):
    """The text of benchmarks/peers.md."""
    steps_36, found_36 = results[36]
    libraries = ", ".join(f"{name} {version(name.lower())}" for name in ("numpy", "SciPy", "VTK"))
    size = f"{about['nodes']:,} nodes, {chosen['surface_points']:,} of them on the surface"
    return f"""# Beside scripts in numpy and SciPy

What users write in scripts, measured by `benchmarks/compare_peers.py`, which writes this page. {datetime.date.today():%B %Y}, {machine()};
Python {sys.version.split()[0]}, {libraries}. Medians of {options.rounds} rounds in which every program runs once, in turn, in a process
of its own.

`azimesh sample blade`: {size}, hexahedra. The paper's cyclic
pitch and flap, Wendland C2, and the same {chosen['layers'][0]['base_points']:,} base points for all, chosen by `azimesh select` for a tolerance of
{options.tolerance:g} ({options.tolerance / 0.3:.1g} chord). In brackets: multiples of azimesh's figure.

## One step

{table(*results[1])}

## 36 steps

{table(steps_36, found_36)}

Every node of every step that numpy computes is where azimesh puts it, to {agreement(results):.0e} of the largest displacement.

## What is counted

- **Computing**: from displacements of base points to node positions of all steps. azimesh: `selection` (with `--base`: solving for
  given base points, and their error on the surface), `modes` and `steps` of `run.json`. Scripts: fitting and evaluation.
- **Whole command**: also starting the program, importing libraries, reading the mesh, and writing a VTU file a step (raw
  binary; the scripts with VTK's own reader and writer). azimesh also computes the motion and measures the error of each step at
  the surface, and hashes each file; the scripts get the displacements of the base points from a file. None of them waits for the disk.
- **CPU**: user and system seconds of the whole command. **Peak memory**: resident, of the whole command.
- **azimesh, exact surface and quality**: azimesh's defaults. It corrects the surface and computes the quality of every cell at every step; the other
  rows do neither.
- **numpy, in blocks**: one Cholesky factorisation, weights of all steps together, one kernel matrix for each 1,024 nodes, worked
  on in place, times the weights; a thread for each core, or one loop (whose matrix product uses threads as well).
- **numpy, whole matrix**: the formula for all nodes at once, then a product a step.
- **`RBFInterpolator`**: one fit with three columns a step. It has no Wendland function; its linear kernel does not decay with
  distance, and the base points were chosen for Wendland's; hence its error.
"""


def main():
    """Measures and writes the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--azimesh", default="target/release/azimesh")
    parser.add_argument("--nodes", type=int, default=380_000)
    parser.add_argument("--tolerance", type=float, default=1e-4)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--page", type=Path, default=PAGE)
    options = parser.parse_args()
    program = Path(options.azimesh).resolve()
    with tempfile.TemporaryDirectory(prefix="azimesh-compare-") as folder:
        folder = Path(folder)
        chosen, about = prepare(program, folder, options.nodes, options.tolerance)
        scripts = ways(about["nodes"], chosen["layers"][0]["base_points"])
        results = {steps: compare(program, folder, steps, scripts, options) for steps in STEPS}
    text = page(options, about, chosen, results)
    options.page.write_text(text)
    print(text)


if __name__ == "__main__":
    main()

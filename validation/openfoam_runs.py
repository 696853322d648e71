"""A pitching airfoil in OpenFOAM, moved in four ways: forces beside those of a mesh that turns as a whole.

    . /usr/share/openfoam/etc/bashrc                  (Debian's package openfoam, v1912)
    docs/openfoam/azimeshMotion/build.sh SOURCES      (makes libazimeshMotion.so)
    python validation/openfoam_runs.py FOLDER [--azimesh target/release/azimesh] [--draw docs/pictures/openfoam_forces.png]

Follows the page docs/tasks/openfoam.md with the case docs/openfoam/pitching_airfoil: two periods of laminar flow at a Reynolds number of 1000,
a pitch of 10 sin(wt) degrees. Compared over the second period: the points of azimesh at each time step of the solver, at every second and at
every tenth, the last ones straight in time too, and OpenFOAM's Laplacian with azimesh's wall at every tenth. Prints a table; runs take about a minute each.
"""

import argparse
import os
import pathlib
import re
import shutil
import subprocess

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[1]
CASE = ROOT / "docs" / "openfoam" / "pitching_airfoil"
LIBRARY = ROOT / "docs" / "openfoam" / "azimeshMotion"
PERIOD = 4.0
SCHEDULE = """
time = {{ stop = {stop}, step = {step}, frequency = 0.25 }}
boundaries.fixed = ["farfield"]
selection.tolerance = 1e-4
output = {{ quality = "none", displacement = true }}
rotor = {{ span_axis = [0.0, 0.0, -1.0], shaft_axis = [0.0, 1.0, 0.0] }}
[[body]]
name = "airfoil"
tags = ["airfoil"]
cyclic = {{ pitch = [ {{ sin = 10.0 }} ] }}
"""
# name: (what it is, step of the sequence in s, entries of dynamicMeshDict)
RUNS = {
    "rigid": ("the whole mesh turns", None, ""),
    "each": ("azimesh's points at each time step", 0.005, ""),
    "second": ("at every second one", 0.01, ""),
    "tenth": ("at every tenth one", 0.05, ""),
    "straight": ("at every tenth one, `interpolation linear`", 0.05, "interpolation linear;"),
    "laplacian": ("OpenFOAM's Laplacian, the wall at every tenth one", 0.05, ""),
}


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--azimesh", default=str(ROOT / "target" / "release" / "azimesh"))
    arguments.add_argument("--only", nargs="*", default=list(RUNS))
    arguments.add_argument("--draw", type=pathlib.Path)
    asked = arguments.parse_args()
    asked.folder.mkdir(exist_ok=True)
    prepare(asked.folder, asked.azimesh)
    for name in asked.only:
        if seconds(asked.folder / name) is None:
            run(asked.folder, name, asked.azimesh)
    table(asked.folder)
    if asked.draw:
        draw(asked.folder, asked.draw)


def shell(command, folder, **more):
    """Runs a command, whose output goes to the file `log` beside it."""
    with open(folder / "log", "a") as log:
        environment = os.environ | {"LD_LIBRARY_PATH": f"{LIBRARY}:{os.environ.get('LD_LIBRARY_PATH', '')}"}
        subprocess.run([str(word) for word in command], cwd=folder, check=True, stdout=log, stderr=log, env=environment, **more)


def prepare(folder, azimesh):
    """The case `wing`: the mesh of a sample, one layer thick."""
    if (folder / "wing").exists():
        return
    shell([azimesh, "-q", "sample", "naca0012", "--nodes", "5000", "--first-cell", "0.002", "-o", "airfoil.vtu"], folder)
    shell([azimesh, "convert", "airfoil.vtu", "mesh", "--format", "openfoam", "--extrude", "0.1",
           "--patch-type", "airfoil=wall"], folder)
    shutil.copytree(CASE, folder / "wing")
    shutil.copytree(folder / "mesh" / "constant" / "polyMesh", folder / "wing" / "constant" / "polyMesh")
    shell(["checkMesh"], folder / "wing")


def sequence(folder, name, step, azimesh):
    """The sequence of a run; where its wall is all that counts, for both periods."""
    moved = folder / f"moved_{name}"
    text = SCHEDULE.format(step=step, stop=2 * PERIOD if name == "laplacian" else PERIOD)
    (folder / f"{name}.toml").write_text(text)
    if not moved.exists():
        shell([azimesh, "deform", "wing", f"{name}.toml", "-o", moved.name], folder)
    return moved


def run(folder, name, azimesh):
    _, step, entries = RUNS[name]
    case = folder / name
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(folder / "wing", case)
    dictionary = case / "constant" / "dynamicMeshDict"
    if name in ("rigid", "laplacian"):
        shutil.copy(f"{dictionary}.{name}", dictionary)
    else:
        moved = sequence(folder, name, step, azimesh)
        dictionary.write_text(dictionary.read_text().replace("../moved", f"../{moved.name}") + entries + "\n")
    if name == "laplacian":
        for field in sequence(folder, name, step, azimesh).glob("*/wantedDisplacement"):
            (case / field.parent.name).mkdir(exist_ok=True)
            shutil.copy(field, case / field.parent.name)
    shell(["pimpleFoam"], case)


def seconds(case):
    """Seconds of computing that OpenFOAM tells at the end of a run; None for one that has not ended."""
    log = case / "log"
    text = log.read_text() if log.exists() else ""
    told = re.findall(r"ExecutionTime = ([\d.]+) s", text)
    return float(told[-1]) if text.rstrip().endswith("End") else None


def forces(case):
    """{name: values} of the coefficients of a run, Time among them."""
    path = max((case / "postProcessing" / "forces").glob("*/coefficient.dat"))
    header = [line for line in path.read_text().splitlines() if line.startswith("#")][-1]
    return dict(zip(header.lstrip("# ").split(), numpy.loadtxt(path).T))


def table(folder):
    print("| run | largest difference of c_l | of c_d | of c_m | seconds |\n|---|---|---|---|---|")
    rigid = forces(folder / "rigid")
    second = rigid["Time"] > PERIOD + 1e-9
    for name, (title, *_) in RUNS.items():
        if seconds(folder / name) is None:
            continue
        found = forces(folder / name)
        assert numpy.allclose(found["Time"], rigid["Time"])
        cells = []
        for key in ("Cl", "Cd", "CmPitch"):
            a, b = rigid[key][second], found[key][second]
            if name == "rigid":
                cells.append(f"({a.min():.3f} to {a.max():.3f})")
            else:
                cells.append(f"{abs(a - b).max():.2g} ({100 * abs(a - b).max() / numpy.ptp(a):.2g}%)")
        print(f"| {title} | {' | '.join(cells)} | {seconds(folder / name):.0f} |")


def draw(folder, path):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (above, below) = pyplot.subplots(2, 1, figsize=(8, 6.5), sharex=True, layout="constrained")
    rigid = forces(folder / "rigid")
    shown = rigid["Time"] > 0.1
    above.plot(rigid["Time"][shown], rigid["Cl"][shown], "k", lw=2.5, alpha=0.35, label=RUNS["rigid"][0])
    for name in ("each", "tenth", "laplacian"):
        if seconds(folder / name) is not None:
            found = forces(folder / name)
            above.plot(found["Time"][shown], found["Cl"][shown], lw=0.8, label=RUNS[name][0])
            below.plot(found["Time"][shown], (found["Cl"] - rigid["Cl"])[shown], lw=0.8, label=RUNS[name][0])
    above.set_ylabel("lift coefficient")
    below.set_ylabel("difference from the rigid mesh")
    below.set_xlabel("time in s")
    above.legend(fontsize=8)
    below.legend(fontsize=8)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main()

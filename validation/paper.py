"""The cases of Sheng and Allen (AIAA Journal 51(3), 2013) on meshes like theirs: the tables and pictures of validation/paper.md.

    .venv/bin/python validation/paper.py [table2 greedy table3 table4 cost] [--nodes 1000000] [--folder target/paper]

Runs the cases that are named, all unless any is, and prints their tables; results are kept as JSON in the folder, from which the pictures are
drawn. `greedy` is the paper's greedy in plain numpy, beside the results of tables 2 and 3. All take about 15 minutes on two cores and 4 GB of disk.
`--nodes 8000000` is the paper's size.
"""

import argparse
import csv
import json
import os
import shutil
import subprocess
from pathlib import Path

import matplotlib
import numpy as np
import pyvista

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

AZIMESH = os.environ.get("AZIMESH", "target/release/azimesh")
PICTURES = Path(__file__).resolve().parent / "pictures"
NAMES = {"real": "Algorithm 1 (real)", "constant": "Algorithm 2 (constant)", "sequence": "sequence"}
COLOURS = {"real": "#0b6e99", "constant": "#d1711f", "sequence": "#2f8f4e"}
COLLECTIVE, SIN, COS = 10.04, -7.65, -0.96  # degrees of pitch
PITCH = f"cyclic = {{ collective = {COLLECTIVE}, pitch = [ {{ sin = {SIN}, cos = {COS} }} ] }}"
PITCH_AND_FLAP = PITCH[:-2] + ", coning = 2.619, flap = [ { sin = 3.211, cos = -0.421 } ] }"
MOTIONS = {f"translation, {by} chord": f"rigid = {{ translate = [0.0, 0.0, {by}] }}" for by in (0.1, 0.2, 0.25, 0.5)}
MOTIONS |= {f"rotation, {by} degrees": f"rigid = {{ rotate = {{ axis = [1.0, 0.0, 0.0], angle = {by}.0 }} }}" for by in (20, 40)}
ONE_STEP_TOLERANCE = 5e-4
TIP, M427_TIP = 6.0, 5.625
SCHEDULE = """
boundaries.fixed = ["outer"]
rbf.support_radius = {radius!r}
selection = {{ method = "{method}", tolerance = {tolerance!r}, max_points = 10000, correction = {correction} }}
output = {{ quality = "{quality}", on_inverted = "warn" }}
[azimuth]
{azimuth}
[[body]]
name = "blade"
tags = ["blade"]
{motion}
"""
COLUMNS = {
    "azimuth": "azimuth_deg", "base_points": "base_points", "error": "selection_error", "inverted": "inverted", "min_jacobian": "min_scaled_jacobian",
    "mean_jacobian": "mean_scaled_jacobian", "first_cell": "min_first_cell_ratio",
}  # fmt: skip


def azimesh(*arguments):
    """Standard output of a command; inverted cells (exit code 1) are told by the tables."""
    done = subprocess.run([AZIMESH, *map(str, arguments), "--quiet"], capture_output=True, text=True)
    assert done.returncode in (0, 1), f"{arguments}: {done.stderr}"
    return done.stdout


def sample(path, *options):
    """The sample blade; what it says of its size."""
    made = json.loads(azimesh("sample", "blade", *options, "-o", path, "--force", "--json"))
    print(f"{path.name}: {made['nodes']:,} nodes, {made['surface_nodes']:,} of them on boundaries\n")
    return path


def chord_blade(folder):
    """The mesh of tables 2 and 3: an untwisted blade of chord one in a cylinder of five chords."""
    return sample(folder / "chord_blade.vtu", "--untwisted", "--surface-nodes", 25121, "--nodes", 379170, "--cylinder-radius", 2.5)


def m427_blade(folder, nodes):
    """A blade of the M427's measures; a twelfth of the nodes are on boundaries, as in the paper."""
    return sample(folder / "m427_blade.vtu", "--nodes", nodes, "--surface-nodes", nodes // 12)


def schedule(folder, motion, radius, tolerance, method, azimuth="values = [0]", correction=True, quality="summary"):
    """A schedule for the blade."""
    path = folder / "schedule.toml"
    text = SCHEDULE.format(motion=motion, radius=radius, tolerance=tolerance, method=method, azimuth=azimuth, correction=str(correction).lower(), quality=quality)
    path.write_text(text)
    return path


def deform(folder, mesh, *given, steps=None, **options):
    """Columns of steps.csv, and of run.json seconds and selections, of a run whose meshes are deleted."""
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    azimesh("deform", mesh, schedule(folder, *given, **options), "-o", out, *(["--steps", f"0..{steps}"] if steps else []))
    (record,), (table,) = out.glob("run*.json"), out.glob("steps*.csv")
    record = json.loads(record.read_text())
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    shutil.rmtree(out)
    found = {name: [float(row[column] or "nan") for row in rows] for name, column in COLUMNS.items()}
    return found | {key: record[key] for key in ("nodes", "surface_points", "modes", "seconds", "selections")}


def table(header, *rows):
    """Prints a Markdown table."""
    for line in (header, ["---"] * len(header), *rows):
        print("| " + " | ".join(map(str, line)) + " |")
    print(flush=True)


def span(values):
    """The one value, or the least and the most."""
    return f"{min(values):,.0f}" if min(values) == max(values) else f"{min(values):,.0f}-{max(values):,.0f}"


def table2(folder, _):
    """One step of rigid motion: base points by each method, and what becomes of the mesh."""
    mesh = chord_blade(folder)
    runs = {name: {method: deform(folder, mesh, motion, TIP, ONE_STEP_TOLERANCE, method) for method in NAMES} for name, motion in MOTIONS.items()}

    def count(motion, radius, tolerance=ONE_STEP_TOLERANCE):
        chosen = azimesh("select", mesh, schedule(folder, motion, radius, tolerance, "real"), "-o", folder / "base.toml", "--force", "--json")
        return json.loads(chosen)["layers"][0]["base_points"]

    rows = []
    for name, motion in MOTIONS.items():
        supports = span([count(motion, radius) for radius in (2.0, 4.0, 6.0, 10.0, 20.0, 60.0)])
        rows.append([name, *(span(runs[name][method]["base_points"]) for method in NAMES), supports, count(motion, TIP, TIP * ONE_STEP_TOLERANCE)])
    table(["base points", *NAMES.values(), "Algorithm 1, support 2 to 60 chords", "Algorithm 1, 5e-4 blade radii"], *rows)
    pair = lambda one, column, digits: ", ".join(f"{one[method][column][0]:.{digits}f}" for method in ("real", "constant"))  # noqa: E731
    table(
        ["", "error, Algorithm 2", "inverted, all three", "min scaled Jacobian", "mean scaled Jacobian", "first cell"],
        *([name, f"{one['constant']['error'][0]:.1e}", sum(run["inverted"][0] for run in one.values()),
           pair(one, "min_jacobian", 3), pair(one, "mean_jacobian", 3), pair(one, "first_cell", 4)] for name, one in runs.items()),
    )  # fmt: skip
    return runs


def revolution(folder, mesh, motion, radius, tolerances):
    """A revolution in steps of 10 degrees, by each method at each tolerance."""
    azimuth = "stop = 350\nstep = 10"
    runs = {repr(t): {method: deform(folder, mesh, motion, radius, t, method, azimuth=azimuth) for method in NAMES} for t in tolerances}
    rows = []
    for tolerance, methods in runs.items():
        assert max(methods["sequence"]["error"]) <= float(tolerance), "sequence exceeds its tolerance"
        for method, run in methods.items():
            t, n = run["seconds"], len(run["azimuth"])
            seconds = [t["selection"], t["modes"], t["steps"] / n, t["writing"] / n, t["total"]]
            over = sum(error > float(tolerance) for error in run["error"])
            rows.append([NAMES[method], tolerance, span(run["base_points"]), f"{max(run['error']):.2e}", f"{over} of {n}", sum(run["inverted"]),
                         f"{min(run['min_jacobian']):.3f}", *(f"{value:.3g}" for value in seconds)])  # fmt: skip
    table(["method", "tolerance", "base points", "largest error", "steps over", "inverted", "min SJ", "selection, s", "modes, s", "step, s", "write, s", "total, s"], *rows)
    return runs


def table3(folder, _):
    """Cyclic pitch."""
    return revolution(folder, chord_blade(folder), PITCH, TIP, (5e-4, 2.5e-4, 1e-4))


def table4(folder, nodes):
    """Pitch and flap of the M427 blade."""
    return revolution(folder, m427_blade(folder, nodes), PITCH_AND_FLAP, M427_TIP, (2e-4, 1e-4, 7.5e-5, 5e-5))


def cost(folder, nodes):
    """Seconds of choosing ever more base points, of evaluating them at all nodes, and of a step."""
    mesh, runs = m427_blade(folder, nodes), {}
    for tolerance in (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5):
        options = dict(azimuth="stop = 350\nstep = 10", correction=False, quality="none", steps=6)
        runs[repr(tolerance)] = deform(folder, mesh, PITCH_AND_FLAP, M427_TIP, tolerance, "sequence", **options)
    rows = [[t, span(run["base_points"]), *(f"{run['seconds'][part] / n:.3g}" for part, n in (("selection", 1), ("modes", 1), ("steps", 6)))] for t, run in runs.items()]
    table(["tolerance, m", "base points", "selection, s", "evaluation, s", "step, s"], *rows)
    return runs


def surface(mesh):
    """Positions of the surface points (N, 3), coincident nodes once, and which of them are on the blade (N)."""
    grid = pyvista.read(mesh)
    tag, starts = grid.cell_data["BoundaryTag"], grid.cell_offsets[:-1]
    blade, both = (np.unique(grid.cell_connectivity[starts[cells][:, None] + np.arange(4)]) for cells in (tag == 1, tag > 0))
    points, first = np.unique(grid.points[both], axis=0, return_index=True)
    return points, np.isin(both[first], blade)


def turned(points, degrees):
    """Displacements by a rotation about the x axis (N, 3)."""
    angle = np.radians(degrees)
    _, y, z = points.T
    return np.stack([0 * y, y * np.cos(angle) - z * np.sin(angle) - y, y * np.sin(angle) + z * np.cos(angle) - z], axis=1)


def chosen(points, target, tolerance, fields=()):
    """One point a sweep, that with the largest error of `target` (N, 3), until the tolerance holds.

    The Newton basis takes the place of solving anew for each point. Returns the number of points, and the largest error that they leave in the `fields`.
    """
    basis, power, errors = [], np.ones(len(points)), [np.array(one) for one in (target, *fields)]
    while True:
        size = np.linalg.norm(errors[0], axis=1)
        worst = int(size.argmax())
        if size[worst] <= tolerance:
            return len(basis), max((float(np.linalg.norm(error, axis=1).max()) for error in errors[1:]), default=0.0)
        xi = np.minimum(np.linalg.norm(points - points[worst], axis=1) / TIP, 1.0)
        column = (1 - xi) ** 4 * (4 * xi + 1)
        if basis:
            known = np.array(basis)
            column -= known[:, worst] @ known
        column /= np.sqrt(power[worst])
        for error in errors:
            error -= column[:, None] * (error[worst] / column[worst])
        power -= column**2
        basis.append(column)


def greedy(folder, _):
    """Both algorithms on the rotations of table 2, and on the cyclic pitch of table 3 at its hardest azimuth."""
    points, moving = surface(folder / "chord_blade.vtu")
    one_step, cyclic = (json.loads((folder / f"table{n}.json").read_text()) for n in (2, 3))
    rows = []

    def compare(name, tolerance, fields, hardest, ours):
        real, _ = chosen(points, fields[hardest], tolerance)
        n, left = chosen(points, moving[:, None] * np.abs(np.stack(fields)).max(axis=(0, 1)), tolerance, fields)
        rows.append([name, tolerance, span([max(ours["real"]["base_points"])]), real, span(ours["constant"]["base_points"]), n,
                     f"{max(ours['constant']['error']) / tolerance:.0f}", f"{left / tolerance:.0f}"])  # fmt: skip

    for degrees in (20, 40):
        name = f"rotation, {degrees} degrees"
        compare(name, ONE_STEP_TOLERANCE, [moving[:, None] * turned(points, degrees)], 0, one_step[name])
    fields = [moving[:, None] * turned(points, COLLECTIVE + SIN * np.sin(psi) + COS * np.cos(psi)) for psi in np.radians(range(0, 360, 10))]
    for tolerance, ours in cyclic.items():
        compare("cyclic pitch", float(tolerance), fields, int(np.argmax(ours["real"]["base_points"])), ours)
    table(["motion", "tolerance", "Algorithm 1", "in numpy", "Algorithm 2", "in numpy", "error of Algorithm 2 / tolerance", "in numpy"], *rows)
    return rows


def draw_residuals(runs):
    """Error of each base point when it was chosen, and of every sweep over all nodes."""
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.9), sharey=True, layout="constrained")
    for axis, kind, methods in zip(axes, ("translation", "rotation"), (["real"], ["real", "constant"])):
        for method in methods:
            for name, line in zip([name for name in runs if name.startswith(kind)], ("-", "--", ":", "-.")):
                layer = runs[name][method]["selections"][0]["layers"][0]
                axis.semilogy(layer["residuals"], line, color=COLOURS[method], lw=1.1, label=f"{name}, {NAMES[method]}")
                axis.plot(*np.array(layer["history"]).T, "o", ms=3, color=COLOURS[method])
        axis.axhline(ONE_STEP_TOLERANCE, color="#333333", lw=0.8)
        axis.set(xlabel="base points", ylabel="largest error, chords")
        axis.legend(fontsize=7.5)
    return figure


def draw_azimuth(runs):
    """Base points, and the largest surface error before the correction, against azimuth."""
    figure, axes = plt.subplots(2, 1, figsize=(8, 6.4), sharex=True, layout="constrained")
    for (tolerance, methods), line in zip(runs.items(), ("-", "--", ":", "-.")):
        axes[1].axhline(float(tolerance), color="#333333", lw=0.7, ls=line)
        for method, run in methods.items():
            style = dict(color=COLOURS[method], ls=line, label=f"{NAMES[method]}, {tolerance}")
            axes[0].plot(run["azimuth"], run["base_points"], **style)
            axes[1].semilogy(run["azimuth"], run["error"], **style)
    axes[0].set(ylabel="base points", ylim=(0, None))
    axes[1].set(xlabel="azimuth, degrees", ylabel="largest error before the correction", xticks=range(0, 361, 45))
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside right upper", fontsize=8)
    return figure


def draw_cost(runs):
    """Seconds against base points."""
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.9), layout="constrained")
    n = [run["base_points"][0] for run in runs.values()]
    for axis, part, label in ((axes[0], "selection", "selection"), (axes[1], "modes", "evaluation at all nodes"), (axes[1], "steps", "six steps")):
        axis.loglog(n, [run["seconds"][part] for run in runs.values()], "o-", label=label)
        axis.set(xlabel="base points", ylabel="s")
        axis.legend(fontsize=8)
    return figure


DRAWN = {"table2": (draw_residuals, "residuals"), "table3": (draw_azimuth, "pitch"), "table4": (draw_azimuth, "m427"), "cost": (draw_cost, "cost")}
CASES = {case.__name__: case for case in (table2, table3, greedy, table4, cost)}


def main():
    """Runs cases, prints and draws."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", help=", ".join(CASES))
    parser.add_argument("--nodes", type=int, default=1_000_000, help="of the M427 blade")
    parser.add_argument("--folder", type=Path, default=Path("target/paper"))
    parser.add_argument("--pictures", type=Path, default=PICTURES)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for name in options.cases or CASES:
        print(f"{name}: {CASES[name].__doc__}\n", flush=True)
        result = CASES[name](options.folder, options.nodes)
        (options.folder / f"{name}.json").write_text(json.dumps(result))
        if name in DRAWN:
            draw, picture = DRAWN[name]
            draw(result).savefig(options.pictures / f"paper_{picture}.png", dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()

"""Pictures of validation/paper.md."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

COLOURS = {"real": "#0b6e99", "constant": "#d1711f", "sequence": "#2f8f4e"}
NAMES = {"real": "Algorithm 1 (real)", "constant": "Algorithm 2 (constant)", "sequence": "sequence"}
LINES = ("-", "--", ":", "-.")
INK = "#333333"

plt.rcParams.update(
    {
        "figure.dpi": 110, "font.size": 9, "axes.spines.top": False, "axes.spines.right": False,
        "axes.edgecolor": INK, "axes.grid": True, "grid.color": "#dddddd", "grid.linewidth": 0.6,
        "legend.frameon": False, "lines.linewidth": 1.4,
    }
)  # fmt: skip


def draw(results, folder):
    """Every picture whose runs are there."""
    folder.mkdir(exist_ok=True)
    if "table2" in results:
        save(residuals(results["table2"]["runs"]), folder / "paper_residuals.png")
    if "table3" in results:
        save(by_azimuth(results["table3"]["runs"], "chord"), folder / "paper_pitch.png")
    if "table4" in results:
        save(by_azimuth(results["table4"]["runs"], "m"), folder / "paper_m427.png")
    if "cost" in results:
        save(costs(results["cost"]), folder / "paper_cost.png")


def save(figure, path):
    """Writes and closes a figure."""
    figure.savefig(path, metadata={"Software": None})
    plt.close(figure)


def residuals(runs):
    """Error of each base point when it was chosen, and of every sweep over all nodes."""
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.9), sharey=True, layout="constrained")
    for axis, kind in zip(axes, ("translation", "rotation")):
        motions = [name for name in runs if name.startswith(kind)]
        # With a translation both algorithms have the same target.
        methods = {"translation": ("real",), "rotation": ("real", "constant")}[kind]
        for method in methods:
            whose = NAMES[method] if len(methods) > 1 else "Algorithms 1 and 2"
            for name, line in zip(motions, LINES):
                layer = runs[name][method]["selections"][0]["layers"][0]
                label = f"{name.split(', ', 1)[1]}, {whose}"
                axis.semilogy(layer["residuals"], line, color=COLOURS[method], lw=1.1, label=label)
                swept = np.array(layer["history"])
                axis.plot(swept[:, 0], swept[:, 1], "o", ms=3, color=COLOURS[method])
        axis.axhline(runs[motions[0]]["real"]["tolerance"], color=INK, lw=0.8)
        axis.set_xlabel("base points")
        axis.set_title(kind, loc="left", fontsize=10)
        axis.legend(fontsize=7.5)
    axes[0].set_ylabel("largest error, chords")
    return figure


def by_azimuth(runs, unit):
    """Base points, and the largest surface error before the correction, against azimuth."""
    figure, axes = plt.subplots(2, 1, figsize=(8, 6.4), sharex=True, layout="constrained")
    for (tolerance, methods), line in zip(runs.items(), LINES):
        axes[1].axhline(float(tolerance), color=INK, lw=0.7, ls=line)
        for method, run in methods.items():
            style = dict(color=COLOURS[method], ls=line, label=f"{NAMES[method]}, {float(tolerance):.3g}")
            axes[0].plot(run["azimuth"], run["base_points"], **style)
            axes[1].semilogy(run["azimuth"], run["error"], **style)
    axes[0].set_ylabel("base points")
    axes[0].set_ylim(bottom=0)
    axes[1].set_ylabel(f"largest error before the correction, {unit}")
    axes[1].set_xlabel("azimuth, degrees")
    axes[1].set_xticks(range(0, 361, 45))
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", fontsize=8, title="method, tolerance")
    return figure


def costs(result):
    """Seconds against base points beside the formulas."""
    points = formulas(result)
    n = points["n"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.9), layout="constrained")
    left.loglog(n, points["selection"], "o", color=COLOURS["sequence"], label="selection, measured")
    left.loglog(
        n, points["selection_formula"], "-", color=COLOURS["sequence"], lw=1,
        label=r"$a\,N_s \sum n_k + b\,(m n^2 + n^3/3)$",
    )  # fmt: skip
    left.loglog(
        n, points["one_by_one"], "--", color=INK, lw=1, label=r"a sweep for every point: $a\,N_s n^2/2$, not run"
    )
    right.plot(n, points["evaluation"], "o", color=COLOURS["real"], label="evaluation at all nodes, measured")
    right.plot(n, points["evaluation_formula"], "-", color=COLOURS["real"], lw=1, label=r"$a\,N_v n + c$")
    right.plot(n, points["step"], "s", ms=4, color=COLOURS["sequence"], label="positions at a step, measured")
    right.set_ylim(bottom=0)
    for axis in (left, right):
        axis.set_xlabel("base points")
        axis.set_ylabel("s")
        axis.legend(fontsize=8)
    return figure


def formulas(result):
    """Measured seconds and what the counts of operations give, with three fitted numbers.

    `a`: seconds of a kernel evaluation, from evaluating the modes at all nodes; `c`: what that
    takes beside; `b`: seconds of a multiply-add of the selection.
    """
    runs = result["runs"]
    surface, nodes = runs[0]["surface_points"], runs[0]["nodes"]
    candidates = min(max(surface // 16, 512), 4096)
    layers = [run["selections"][0]["layers"][0] for run in runs]
    n = np.array([layer["base_points"] for layer in layers], dtype=float)
    swept = np.array([sum(points for points, _ in layer["history"]) for layer in layers], dtype=float)
    selection = np.array([run["seconds"]["selection"] for run in runs])
    evaluation = np.array([run["seconds"]["modes"] for run in runs])
    step = np.array([run["seconds"]["steps"] / len(run["azimuth"]) for run in runs])
    a, c = np.polyfit(nodes * n, evaluation, 1, w=1 / evaluation)
    # The chosen base points are evaluated once more at the surface when their weights are final.
    kernels = a * surface * (swept + n)
    products = candidates * n**2 + n**3 / 3
    b = max(0.0, np.median((selection - kernels)[-4:] / products[-4:]))
    return {
        "n": n, "sweeps": [len(layer["history"]) for layer in layers], "a": a, "b": b, "c": c,
        "selection": selection, "selection_formula": kernels + b * products,
        "one_by_one": a * surface * n**2 / 2,
        "evaluation": evaluation, "evaluation_formula": a * nodes * n + c, "step": step,
    }  # fmt: skip

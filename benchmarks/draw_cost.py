"""Draws the picture of benchmarks/growth.md; `cost_growth.py` measures."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

COLOURS = {
    "selection": "#1f77b4",
    "modes": "#d62728",
    "correction": "#9467bd",
    "steps": "#2ca02c",
    "writing": "#8c6d31",
    "megabytes": "#333333",
}
MARKERS = dict(zip(COLOURS, "osvD^o"))


def short(value, _position=None):
    """12500 as 12.5k."""
    for limit, letter in ((1e6, "M"), (1e3, "k")):
        if value >= limit:
            return f"{value / limit:g}{letter}"
    return f"{value:g}"


def curve(axes, values, points, part, expected):
    """Measurements, and the formula where there is one."""
    found = [(value, f[part]) for value, f in zip(values, points) if f[part] > 0]
    style = dict(color=COLOURS[part], marker=MARKERS[part], markersize=5)
    formula = expected(part, points)
    if formula:
        axes.plot(values, formula, "--", color=COLOURS[part], linewidth=1.2)
        axes.plot(*zip(*found), linestyle="none", label=part, **style)
    elif found:
        axes.plot(*zip(*found), linestyle=":", linewidth=0.8, label=part, **style)


def scales(axes, values):
    """Logarithms on both axes, with the values themselves below."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xticks(values, [short(value) for value in values], fontsize=9)
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(short))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(alpha=0.25)


def limits(series, parts):
    """Room around all figures of some parts."""
    found = [f[part] for points in series for f in points for part in parts if f[part] > 0]
    return min(found) / 1.5, max(found) * 1.5


def draw(description, series, expected, path):
    """A column for each series: seconds of the parts above, memory below."""
    parts = [part for part in COLOURS if part != "megabytes"]
    figure, panels = plt.subplots(
        2, len(series), figsize=(13, 7), sharey="row", sharex="col", height_ratios=[2.2, 1], layout="constrained"
    )
    for column, ((title, symbol, values, held), points) in enumerate(zip(description, series)):
        above, below = panels[0][column], panels[1][column]
        for part in parts:
            curve(above, values, points, part, expected)
        curve(below, values, points, "megabytes", expected)
        for axes in (above, below):
            scales(axes, values)
        below.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        above.set_ylim(limits(series, parts))
        below.set_ylim(limits(series, ["megabytes"]))
        symbols = ", ".join(f"${key}$ = {short(value)}" for key, value in held.items())
        above.set_title(f"{title}\n{symbols}", fontsize=10)
        below.set_xlabel(f"{title}, ${symbol}$")
    panels[0][0].set_ylabel("seconds")
    panels[1][0].set_ylabel("peak memory, MB")
    handles, labels = panels[0][0].get_legend_handles_labels()
    handles.append(plt.Line2D([], [], linestyle="--", color="#555555"))
    figure.legend(handles, [*labels, "formula"], loc="outside upper center", ncols=len(handles), frameon=False)
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=100)

"""Time and memory of `azimesh deform` as nodes, surface nodes, base points and steps are doubled four
times; writes benchmarks/growth.md and benchmarks/pictures/growth.png.

    .venv/bin/python benchmarks/cost_growth.py [--rounds 2] [--again]

Measurements are kept in target/cost_growth.json; --again writes the page from there. Needs 4 GB of
disk, and gives them back.
"""

import argparse
import datetime
import json
import math
import os
import shutil
import tempfile
from pathlib import Path

from measure import machine, significant, used

ROOT = Path(__file__).resolve().parent.parent
KEPT = ROOT / "target" / "cost_growth.json"
PAGE = ROOT / "benchmarks" / "growth.md"
PICTURE = ROOT / "benchmarks" / "pictures" / "growth.png"

# (title, what grows, its values, what is held)
SERIES = [
    ("nodes", "N_v", [250_000, 500_000, 1_000_000, 2_000_000, 4_000_000], {"N_s": 50_000, "n": 500, "K": 4}),
    ("surface nodes", "N_s", [12_500, 25_000, 50_000, 100_000, 200_000], {"N_v": 1_000_000, "n": 500, "K": 4}),
    ("base points", "n", [125, 250, 500, 1000, 2000], {"N_v": 1_000_000, "N_s": 50_000, "K": 4}),
    ("steps", "K", [9, 18, 36, 72, 144], {"N_v": 250_000, "N_s": 50_000, "n": 500}),
]
# What is measured, as the table names it.
PARTS = {
    "selection": "selection, s",
    "modes": "modes, s",
    "correction": "correction, s",
    "steps": "steps, s",
    "writing": "writing, s",
    "whole": "whole command, s",
    "megabytes": "peak memory, MB",
    "error": "error before the correction",
}
MODES = 3
SCHEDULE = """
[azimuth]
values = {azimuths}

[[body]]
name = "blade"
tags = ["blade"]

[body.cyclic]
collective = 10.04
pitch = [ {{ sin = -7.65, cos = -0.96 }} ]
coning = 2.619
flap = [ {{ sin = 3.211, cos = -0.421 }} ]

[boundaries]
fixed = ["outer"]

[rbf]
support_radius = 5.625

[selection]
method = "constant"  # ends at max_points: exactly n base points
tolerance = 1e-12
max_points = {n}
correction = {correction}

[output]
quality = "none"
"""


def schedule(path, size, correction):
    """A revolution in K steps with n base points."""
    azimuths = [360 * k / size["K"] for k in range(size["K"])]
    path.write_text(SCHEDULE.format(azimuths=azimuths, n=size["n"], correction=str(correction).lower()))


def deform(program, folder, size, correction):
    """Seconds of each part, of the whole command, MB, and what run.json says of the mesh and selection."""
    toml, out = folder / "steps.toml", folder / "out"
    schedule(toml, size, correction)
    os.sync()
    took = used([program, "deform", folder / "mesh.vtu", toml, "-o", out, "-q"])
    record = json.loads((out / "run.json").read_text())
    shutil.rmtree(out)
    layer = record["selections"][0]["layers"][0]
    assert layer["base_points"] == size["n"] and record["modes"] == MODES, f"not what was asked for: {record}"
    return {
        **record["seconds"],
        "whole": took.seconds,
        "megabytes": took.megabytes,
        "nodes": record["nodes"],
        "cells": record["cells"],
        "surface": record["surface_points"],
        "sweeps": len(layer["history"]),
        "error": layer["error"],
    }


def point(program, folder, size, rounds):
    """One row of figures: the least of several rounds, with and without the correction."""
    nodes = ["--nodes", size["N_v"], "--surface-nodes", size["N_s"]]
    used([program, "sample", "blade", *nodes, "-o", folder / "mesh.vtu", "--force", "-q"])
    runs = {
        correction: [deform(program, folder, size, correction) for _ in range(rounds)] for correction in (False, True)
    }
    plain, corrected = ({key: min(run[key] for run in runs[way]) for key in runs[way][0]} for way in (False, True))
    figures = {**plain, "whole": corrected["whole"], "megabytes": corrected["megabytes"]}
    figures["correction"] = corrected["modes"] - plain["modes"]
    return {**figures, "K": size["K"], "n": size["n"]}


def measure(program, rounds):
    """[[figures of each value] of each series]."""
    with tempfile.TemporaryDirectory(prefix="azimesh-cost-") as folder:
        folder = Path(folder)
        series = []
        for title, symbol, values, held in SERIES:
            series.append([])
            for value in values:
                series[-1].append(point(program, folder, {**held, symbol: value}, rounds))
                print(f"{title} {value}: {series[-1][-1]['whole']:.2f} s", flush=True)
        return series


# ---------------------------------------------------------------- the formulas of docs/method.md


def selection(f):
    """sweeps x N_s n kernel evaluations, candidates x n^2 and n^3 / 3 multiply-adds, all counted alike."""
    candidates = min(max(f["surface"] // 16, 512), 4096)
    return f["sweeps"] * f["surface"] * f["n"] + candidates * f["n"] ** 2 + f["n"] ** 3 / 3


def megabytes(f):
    """The larger of what stands during the selection and during the steps (ARCHITECTURE.md, Memory)."""
    candidates = min(max(f["surface"] // 16, 512), 4096)
    mesh = 48 * f["nodes"] + 32 * f["cells"] + 16 * MODES * f["surface"]
    return max(mesh + 8 * candidates * f["n"] + 24 * f["n"] ** 2, mesh + (24 + 8 * MODES) * f["nodes"]) / 1e6


FORMULAS = {
    "selection": selection,
    "modes": lambda f: f["nodes"] * f["n"],
    "steps": lambda f: f["nodes"] * f["K"],
    "writing": lambda f: f["nodes"] * f["K"],
    "megabytes": megabytes,
}


def slope(values, of):
    """d log(of) / d log(values), by least squares."""
    x, y = [math.log(value) for value in values], [math.log(value) for value in of]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    exponent = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / sum((a - mean_x) ** 2 for a in x)
    return round(exponent, 2) + 0.0  # no -0.00


def expected(part, points):
    """The formula at the points of a series, scaled to go through the middle of the measurements; or None."""
    if part not in FORMULAS:
        return None
    ratios = [math.log(f[part] / FORMULAS[part](f)) for f in points]
    scale = math.exp(sum(ratios) / len(ratios))
    return [scale * FORMULAS[part](f) for f in points]


# ---------------------------------------------------------------- the page


def table(symbol, values, points):
    """A series in markdown, with the slope measured and the slope of the formula."""
    lines = [
        f"| {symbol} | {' | '.join(f'{value:,}' for value in values)} | slope | formula |",
        "|---" * (len(values) + 3) + "|",
    ]
    for part, name in PARTS.items():
        found = [f[part] for f in points]
        formula = expected(part, points)
        digits = 2 if part == "error" else 3
        slopes = [f"{slope(values, row):.2f}" if row and min(row) > 0 else "" for row in (found, formula)]
        lines.append(f"| {' | '.join([name, *(significant(value, digits) for value in found), *slopes])} |")
    return "\n".join(lines)


def page(kept):
    """The text of benchmarks/growth.md."""
    parts = []
    for (title, symbol, values, held), points in zip(SERIES, kept["series"]):
        holding = ", ".join(f"{key} = {value:,}" for key, value in held.items())
        parts.append(f"## {symbol}, the number of {title}\n\n{holding}.\n\n{table(symbol, values, points)}\n")
    return f"""# How the cost grows

Time and memory of `azimesh deform` while one size is doubled four times and the others are kept constant, by `benchmarks/cost_growth.py`,
which writes this page. {kept["when"]}, {kept["machine"]}. The sample blade of hexahedra, the paper's cyclic pitch and flap
(three modes); each figure is the least of {kept["rounds"]} runs.

![Time and peak memory against nodes, surface nodes, base points and steps](pictures/growth.png)

Markers are measurements, dashed lines the formulas of [the method](../docs/method.md), scaled to the measurements of their panel:

| part of a run | formula | what the slopes say |
|---|---|---|
| selection | sweeps x N_s n + candidates x n^2 + n^3 / 3 | candidates: one for every 16 surface nodes, 512 to 2,048 |
| modes | N_v n | once for all steps |
| correction | | its reach is proportional to the error that it removes: falls with n |
| steps | K N_v | positions, and their error at the surface |
| writing | K N_v | one VTU file a step; overlaps with the next step's positions, and shares the cores with them |
| peak memory | that of the mesh, or of the selection if it is larger | no array has the size N_v n or N_s K |

A slope is the exponent of the power law through the five figures (least squares of logarithms). Exactly n base points are obtained with
`method = "constant"`, which ends at `max_points`; the other parts do not depend on how the points were chosen. Quality is off,
so `steps` is positions alone; times are those of `run.json`, the whole command and its memory those of the process with correction.
`modes` is measured without correction, the correction as the difference of two runs.

{chr(10).join(parts)}"""


def main():
    """Measures, unless told to use what is kept, and writes page and picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--azimesh", default="target/release/azimesh")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--again", action="store_true")
    options = parser.parse_args()
    if not options.again:
        series = measure(Path(options.azimesh).resolve(), options.rounds)
        when = f"{datetime.date.today():%B %Y}"
        kept = {"series": series, "when": when, "machine": machine(), "rounds": options.rounds}
        KEPT.parent.mkdir(exist_ok=True)
        KEPT.write_text(json.dumps(kept, indent=1))
    kept = json.loads(KEPT.read_text())
    PAGE.write_text(page(kept))
    # Imported after the measurements, which count the memory of this process.
    from draw_cost import draw

    draw(SERIES, kept["series"], expected, PICTURE)
    print(PAGE.read_text())


if __name__ == "__main__":
    main()

"""The tables and figures of Sheng and Allen (AIAA Journal 51(3), 2013) on meshes like theirs.

    .venv/bin/python validation/paper.py [table2 table3 table4 cost] [--nodes 1000000] [--folder target/paper]

Runs the cases that are named (all unless any is), keeps what they came to as JSON in the folder, and
writes validation/paper.md and its pictures from what the folder holds, results of validation/m427.py and
validation/paper_greedy.py included; a part of the page without results stays as it is.
`--draw` runs nothing. All cases take about 12 minutes on two cores and 4 GB of disk.
"""

import argparse
import json
from pathlib import Path

import paper_plots
import paper_text
from paper_runs import (
    PITCH, PITCH_AND_FLAP, base_points, deform, quality, revolution, sample, schedule, without_residuals,
)  # fmt: skip

METHODS = ("real", "constant", "sequence")
DOCS = Path(__file__).resolve().parent

CHORD_BLADE = ("--untwisted", "--surface-nodes", "25121", "--nodes", "379170", "--cylinder-radius", "2.5")
BLADE_RADIUS = {"chord": 6.0, "m427": 5.625}

# The cylinder around the blade is five chords in diameter.
MOTIONS = {
    "translation, 0.1 chord": "rigid = { translate = [0.0, 0.0, 0.1] }",
    "translation, 0.2 chord": "rigid = { translate = [0.0, 0.0, 0.2] }",
    "translation, 0.25 chord = 0.1 cylinder radius": "rigid = { translate = [0.0, 0.0, 0.25] }",
    "translation, 0.5 chord = 0.2 cylinder radius": "rigid = { translate = [0.0, 0.0, 0.5] }",
    "rotation, 20 degrees": "rigid = { rotate = { axis = [1.0, 0.0, 0.0], angle = 20.0 } }",
    "rotation, 40 degrees": "rigid = { rotate = { axis = [1.0, 0.0, 0.0], angle = 40.0 } }",
}
ONE_STEP_TOLERANCE = 5e-4
SUPPORT_RADII = (2.0, 4.0, 6.0, 10.0, 20.0, 60.0)
PITCH_TOLERANCES = (5e-4, 2.5e-4, 1e-4)
M427_TOLERANCES = (2e-4, 1e-4, 7.5e-5, 5e-5)
COST_TOLERANCES = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5)


def chord_blade(folder):
    """The mesh of the paper's tables 2 and 3: an untwisted blade of chord one."""
    mesh = folder / "chord_blade.vtu"
    return mesh, sample(mesh, *CHORD_BLADE)


def m427_blade(folder, nodes):
    """A blade of the M427's measures; a twelfth of the nodes are on boundaries, as in the paper."""
    mesh = folder / "m427_blade.vtu"
    return mesh, sample(mesh, "--nodes", str(nodes), "--surface-nodes", str(nodes // 12))


def table2(folder, _):
    """One step of rigid motion, by each method."""
    mesh, made = chord_blade(folder)
    runs = {
        name: {
            method: deform(mesh, schedule(motion, BLADE_RADIUS["chord"], ONE_STEP_TOLERANCE, method), folder)
            for method in METHODS
        }
        for name, motion in MOTIONS.items()
    }

    def count(name, radius, tolerance):
        return base_points(mesh, schedule(MOTIONS[name], radius, tolerance, "real"), folder)

    # What the paper leaves open: the length that tolerances are parts of, and the support radius.
    tip = BLADE_RADIUS["chord"]
    return {
        "mesh": made,
        "before": quality(mesh),
        "runs": runs,
        "in_blade_radii": {name: count(name, tip, tip * ONE_STEP_TOLERANCE) for name in MOTIONS},
        "by_support_radius": {
            name: {radius: count(name, radius, ONE_STEP_TOLERANCE) for radius in SUPPORT_RADII} for name in MOTIONS
        },
    }


def table3(folder, _):
    """Cyclic pitch over a revolution, by each method at each tolerance."""
    mesh, made = chord_blade(folder)
    runs = over_revolution(mesh, PITCH, BLADE_RADIUS["chord"], PITCH_TOLERANCES, folder)
    return {"mesh": made, **runs}


def table4(folder, nodes):
    """Cyclic pitch and flap of the M427 blade, by each method at each tolerance."""
    mesh, made = m427_blade(folder, nodes)
    runs = over_revolution(mesh, PITCH_AND_FLAP, BLADE_RADIUS["m427"], M427_TOLERANCES, folder)
    return {"mesh": made, **runs}


def over_revolution(mesh, motion, radius, tolerances, folder):
    """The runs {tolerance: {method: run}}, and seconds of a step that is not judged by its quality."""

    def run(method, tolerance, steps=None, **options):
        text = schedule(motion, radius, tolerance, method, revolution(10), **options)
        return without_residuals(deform(mesh, text, folder, steps))

    runs = {repr(tolerance): {method: run(method, tolerance) for method in METHODS} for tolerance in tolerances}
    for tolerance, methods in runs.items():
        worst = max(methods["sequence"]["error"])
        assert worst <= float(tolerance), f"sequence: {worst} exceeds {tolerance}"
    unjudged = run("sequence", tolerances[0], steps=10, quality="none")
    return {"runs": runs, "before": quality(mesh), "unjudged_step": unjudged["seconds"]["steps"] / 10}


def cost(folder, nodes):
    """Seconds of choosing ever more base points, of evaluating them at all nodes, and of a step."""
    mesh, made = m427_blade(folder, nodes)
    runs = []
    for tolerance in COST_TOLERANCES:
        text = schedule(
            PITCH_AND_FLAP, BLADE_RADIUS["m427"], tolerance, "sequence", revolution(10), False, quality="none"
        )
        runs.append(without_residuals(deform(mesh, text, folder, steps=6)))
    return {"mesh": made, "runs": runs}


CASES = {"table2": table2, "table3": table3, "table4": table4, "cost": cost}


def main():
    """Runs cases, then writes the page and its pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=", ".join(CASES))
    parser.add_argument("--nodes", type=int, default=1_000_000, help="of the M427 blade in table 4 and its figures")
    parser.add_argument("--folder", type=Path, default=Path("target/paper"))
    parser.add_argument("--draw", action="store_true", help="only write the page from earlier results")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    unknown = set(options.cases) - set(CASES)
    assert not unknown, f"no such case: {', '.join(unknown)}; there are {', '.join(CASES)}"
    for name in [] if options.draw else options.cases or CASES:
        print(name, flush=True)
        result = CASES[name](options.folder, options.nodes)
        (options.folder / f"{name}.json").write_text(json.dumps(result))
    results = {path.stem: json.loads(path.read_text()) for path in options.folder.glob("*.json")}
    paper_plots.draw(results, DOCS / "pictures")
    path = DOCS / "paper.md"
    path.write_text(paper_text.page(results, path.read_text() if path.exists() else ""))


if __name__ == "__main__":
    main()

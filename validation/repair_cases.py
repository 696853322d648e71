"""Cases in which interpolation folds cells, and what `azimesh repair` and `on_inverted = "repair"` make of them.

    .venv/bin/python validation/repair_cases.py target/release/azimesh [CASE ...]

Prints a row of a table for each case: cells that are inverted and unproven after one step, what `on_inverted = "repair"` leaves
of them, what `azimesh repair` leaves of them (each with the least scaled Jacobian and CPU seconds), the largest extra
displacement, and the reason where cells are left. A case whose name begins with one of the given words is run; without any,
all of them.
"""

import json
import resource
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np
import pyvista

from folding import flap, half_body, jacobians, o_grid, rotation, schedule, turned_block, two_blocks

AZIMESH = Path(sys.argv[1]).resolve()


def azimesh(*arguments):
    """Runs the program; gives its output and its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([AZIMESH, *map(str, arguments)], capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.returncode in (0, 1), f"{arguments}: {done.stderr}"
    return done.stdout, after.ru_utime - before.ru_utime


def blade(folder, angle, cells, keys="", nodes=20_000):
    """A blade with first cells of 1e-5 chord in a fixed cylinder, turned about its span."""
    azimesh("sample", "blade", "--nodes", nodes, "--cells", cells, "-o", folder / "mesh.vtu", "--force")
    more = f'[rbf]\nsupport_radius = 5.625\ninterpolate = "twist"\n{keys}\n'
    return folder / "mesh.vtu", schedule("blade", rotation(angle, axis=(1.0, 0.0, 0.0)), ["outer"], more=more)


def twisted(case, keys):
    """A case with rotations interpolated."""
    mesh, text = case
    return mesh, text + f'[rbf]\ninterpolate = "twist"\n{keys}\n'


def last_row(folder):
    """The last row of steps.csv as a dictionary."""
    lines = [line.split(",") for line in (folder / "steps.csv").read_text().splitlines()]
    return dict(zip(lines[0], lines[-1]))


def count(row, *columns):
    """The sum of columns."""
    return sum(int(row[column] or 0) for column in columns)


def check(mesh, repaired):
    """Quadrilaterals and hexahedra of a mesh that was said to be valid are so at 5 points along each axis."""
    reference, after = pyvista.read(mesh), pyvista.read(repaired)
    for kind in (9, 12):
        cells = after.cells_dict.get(kind)
        if cells is None or (kind == 9 and 12 in after.cells_dict):
            continue
        sign = np.sign(jacobians(np.asarray(reference.points, float), cells, 2)).min(axis=0)
        bad = (jacobians(np.asarray(after.points, float), cells, 5) * sign <= 0).any(axis=0)
        assert not bad.any(), f"{mesh}: {bad.sum()} cells are folded after the repair"


def run(name, folder, mesh, text):
    """One row: the motion as it is, then with repair, and the repair command on the folded mesh."""
    azimesh("convert", mesh, folder / "reference.vtu", "--force")
    seconds, rows = {}, {}
    for how in ("warn", "repair"):
        (folder / f"{how}.toml").write_text(text + f'\n[output]\nformat = "vtu"\non_inverted = "{how}"\n')
        _, seconds[how] = azimesh("deform", mesh, folder / f"{how}.toml", "-o", folder / how, "--force", "-q")
        rows[how] = last_row(folder / how)
    folded = sorted((folder / "warn").glob("*_0001.*"))[-1]
    slide = ["--slide", "plane"] if "slide = " in text else []
    arguments = ["--reference", folder / "reference.vtu", "--json", "--force", "--quiet", *slide]
    out, own = azimesh("repair", folded, "-o", folder / "repaired.vtu", *arguments)
    found = json.loads(out)
    if found["invalid"] == 0:
        check(folder / "reference.vtu", folder / "repaired.vtu")
    extra = max((patch["largest_move"] for patch in found["patches"]), default=0.0)
    reasons = Counter(left["reason"] for left in found["unrepaired"])
    reason = ", ".join(f"{n} {reason}" for reason, n in reasons.items())
    if found["overtaken"]:
        face = found["overtaken"][0]
        reason += f": {len(found['overtaken'])} faces, the first of cell {face['cell']} on nodes {face['nodes']}"
    before = f"{count(rows['warn'], 'inverted')} + {count(rows['warn'], 'unproven')}"
    print(
        f"| {name} | {before} | {count(rows['repair'], 'inverted', 'unproven')} | {float(rows['repair']['min_scaled_jacobian']):.4f} "
        f"| {seconds['repair']:.2f} | {found['invalid']} | {found['min_scaled_jacobian']:.4f} | {own:.2f} | {extra:.3g} | {reason} |",
        flush=True,
    )


CASES = {}
for gap in (0.05, 0.005, 0.0005):
    for times in (2, 4, 20, 60):
        # Farther than 0.3 the blocks are no longer side by side.
        if gap * times <= 0.31:
            CASES[f"gap {gap}, moved by {times} gaps"] = lambda folder, gap=gap, times=times: two_blocks(folder, gap, gap * times)
CASES["gap 0.0005, moved by 600 gaps"] = lambda folder: two_blocks(folder, 0.0005, 0.3)
for by in (0.2, 0.5, 0.7):
    CASES[f"half a cylinder on a sliding plane, moved by {by / 0.2:g} diameters"] = lambda folder, by=by: half_body(folder, by, True)
    CASES[f"half a cylinder on a fixed plane, moved by {by / 0.2:g} diameters"] = lambda folder, by=by: half_body(folder, by, False)
for angle in (30, 90, 180):
    CASES[f"a block on a sliding plane, {angle} degrees"] = lambda folder, angle=angle: turned_block(folder, angle, True)
    CASES[f"a block on a fixed plane, {angle} degrees"] = lambda folder, angle=angle: turned_block(folder, angle, False)
for angle in (20, 40, 60):
    CASES[f"flap behind a slot, {angle} degrees"] = lambda folder, angle=angle: flap(folder, angle)
for angle in (90, 120, 180, 270):
    CASES[f"O-grid, {angle} degrees"] = lambda folder, angle=angle: o_grid(folder, angle)
    for keys, name in (("", "twist"), ("rotation_radius = 7.0", "interpolated twist")):
        CASES[f"O-grid, {name}, {angle} degrees"] = lambda folder, angle=angle, keys=keys: twisted(o_grid(folder, angle), keys)
CASES["triangles, gap 0.005, moved by 20 gaps"] = lambda folder: two_blocks(folder, 0.005, 0.1, split=True)
CASES["triangles, gap 0.005, moved by 60 gaps"] = lambda folder: two_blocks(folder, 0.005, 0.3, split=True)
CASES["triangles, flap behind a slot, 60 degrees"] = lambda folder: flap(folder, 60, split=True)
CASES["triangles, O-grid, 120 degrees"] = lambda folder: o_grid(folder, 120, split=True)
CASES["triangles, O-grid, 180 degrees"] = lambda folder: o_grid(folder, 180, split=True)
for angle in (90, 120, 150):
    for cells in ("hexahedra", "tetrahedra"):
        CASES[f"{cells}, a block in a box, {angle} degrees"] = lambda folder, angle=angle, cells=cells: turned_block(
            folder, angle, False, n=12, floats=True, split=cells == "tetrahedra"
        )
for angle in (90, 120, 180, 270):
    for cells in ("hex", "wedge", "tet"):
        CASES[f"blade of {cells}, {angle} degrees"] = lambda folder, angle=angle, cells=cells: blade(folder, angle, cells)
        CASES[f"blade of {cells}, interpolated rotation, {angle} degrees"] = lambda folder, angle=angle, cells=cells: blade(
            folder, angle, cells, "rotation_radius = 5.625"
        )


def main():
    """Runs the cases that are asked for."""
    words = sys.argv[2:]
    print("| case | inverted + unproven in one step | left at the step | least SJ | s | left by `azimesh repair` | least SJ | s | largest move | reason |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name, make in CASES.items():
        if words and not any(name.startswith(word) for word in words):
            continue
        with tempfile.TemporaryDirectory() as folder:
            run(name, Path(folder), *make(Path(folder)))


if __name__ == "__main__":
    main()

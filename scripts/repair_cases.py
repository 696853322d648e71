"""Cases in which interpolation folds cells, and what `azimesh repair` and `on_inverted = "repair"` make of them.

    .venv/bin/python scripts/repair_cases.py target/release/azimesh [CASE ...] [--keep FOLDER]

Prints a row a case: cells that are not valid before and after, the least scaled Jacobian, seconds, and the largest extra
displacement. A case whose name begins with one of the given words is run; without any, all of them.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

AZIMESH = Path(sys.argv[1]).resolve()


def azimesh(*arguments):
    """Runs the program; gives its exit code, output and errors."""
    done = subprocess.run([AZIMESH, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode in (0, 1), f"{arguments}: {done.stderr}"
    return done.returncode, done.stdout, done.stderr


def su2(path, points, cells, tags, dimension=2):
    """Writes quadrilaterals, triangles or hexahedra (by their number of nodes) with tags of edges or faces."""
    kinds = {3: 5, 4: 9, 8: 12} if dimension == 2 else {4: 10, 6: 13, 8: 12, 5: 14}
    lines = [f"NDIME= {dimension}", f"NELEM= {len(cells)}"]
    lines += [" ".join(map(str, (kinds[len(cell)], *cell, i))) for i, cell in enumerate(cells)]
    lines.append(f"NPOIN= {len(points)}")
    lines += [" ".join(map(repr, map(float, point[:dimension]))) + f" {i}" for i, point in enumerate(points)]
    lines.append(f"NMARK= {len(tags)}")
    faces = {2: 3, 3: 5, 4: 9}
    for name, members in tags.items():
        lines += [f"MARKER_TAG= {name}", f"MARKER_ELEMS= {len(members)}"]
        lines += [" ".join(map(str, (faces[len(face)], *face))) for face in members]
    path.write_text("\n".join(lines) + "\n")


def two_blocks(folder, gap, move, n=60):
    """Two blocks with a narrow gap between them; the right one moves toward and along the left one's side."""
    left, right = ("left", 0.3, 0.5 - gap / 2, 0.35, 0.65), ("right", 0.5 + gap / 2, 0.7, 0.35, 0.65)
    inner = np.linspace(0.5 - gap / 2, 0.5 + gap / 2, 7)
    xs = np.unique(np.concatenate([np.linspace(0, 0.3, n // 3 + 1), np.linspace(0.3, 0.5 - gap / 2, n // 6 + 1), inner,
                                   np.linspace(0.5 + gap / 2, 0.7, n // 6 + 1), np.linspace(0.7, 1, n // 3 + 1)]).round(12))  # fmt: skip
    ys = np.unique(np.concatenate([np.linspace(0, 0.35, n // 3 + 1), np.linspace(0.35, 0.65, n // 3 + 1), np.linspace(0.65, 1, n // 3 + 1)]).round(12))
    return blocks(folder, xs, ys, [left, right]), f"""version = 1
[time]
values = [0.0, 1.0]
[[body]]
name = "right"
tags = ["right"]
[body.rigid]
translate = [0.0, {move}, 0.0]
ramp = true
[boundaries]
fixed = ["left", "outer"]
"""


def blocks(folder, xs, ys, holes):
    """The mesh of a box between `xs` and `ys` without its holes."""
    points = np.array([[x, y] for y in ys for x in xs])
    node = lambda i, j: i + len(xs) * j  # noqa: E731
    tags = {hole[0]: [] for hole in holes} | {"outer": []}

    def hole_of(i, j):
        if not (0 <= i < len(xs) - 1 and 0 <= j < len(ys) - 1):
            return "outer"
        x, y = (xs[i] + xs[i + 1]) / 2, (ys[j] + ys[j + 1]) / 2
        return next((name for name, x0, x1, y0, y1 in holes if x0 < x < x1 and y0 < y < y1), None)

    cells = []
    for j in range(len(ys) - 1):
        for i in range(len(xs) - 1):
            if hole_of(i, j):
                continue
            ring = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]
            cells.append(ring)
            for k, beside in enumerate([(i, j - 1), (i + 1, j), (i, j + 1), (i - 1, j)]):
                if name := hole_of(*beside):
                    tags[name].append((ring[k], ring[(k + 1) % 4]))
    used = np.unique(np.array(cells))
    new = {old: i for i, old in enumerate(used)}
    cells = [[new[i] for i in cell] for cell in cells]
    tags = {name: [tuple(new[i] for i in edge) for edge in edges] for name, edges in tags.items()}
    su2(folder / "mesh.su2", points[used], cells, tags)
    return folder / "mesh.su2"


def half_body(folder, by, slides, n=48):
    """Half a cylinder on a plane, moved along it. Where the plane is fixed the body overtakes its nodes: no valid mesh exists."""
    rings, around = 24, n
    radii = 0.1 * (10 ** np.linspace(0, 1, rings + 1))
    angles = np.linspace(0, np.pi, around + 1)
    points = np.array([[r * np.cos(a), r * np.sin(a)] for r in radii for a in angles])
    node = lambda i, j: i + (around + 1) * j  # noqa: E731
    cells = [[node(i + 1, j), node(i, j), node(i, j + 1), node(i + 1, j + 1)] for j in range(rings) for i in range(around)]
    tags = {
        "body": [(node(i, 0), node(i + 1, 0)) for i in range(around)],
        "outer": [(node(i, rings), node(i + 1, rings)) for i in range(around)],
        "plane": [(node(0, j), node(0, j + 1)) for j in range(rings)] + [(node(around, j), node(around, j + 1)) for j in range(rings)],
    }
    su2(folder / "mesh.su2", points, cells, tags)
    return folder / "mesh.su2", f"""version = 1
[time]
values = [0.0, 1.0]
[[body]]
name = "body"
tags = ["body"]
[body.rigid]
translate = [{by}, 0.0, 0.0]
ramp = true
[boundaries]
fixed = ["outer"{'' if slides else ', "plane"'}]
{'slide = ["plane"]' if slides else ''}
"""


def o_grid(folder, angle, n=160, layers=60, first=1e-3):
    """An O-grid with thin first cells whose inner circle turns in the fixed outer one."""
    growth = np.geomspace(first, 0.12, layers)
    radii = 0.5 + np.concatenate([[0], np.cumsum(growth)])
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    points = np.array([[r * np.cos(a), r * np.sin(a)] for r in radii for a in angles])
    node = lambda i, j: i % n + n * j  # noqa: E731
    cells = [[node(i + 1, j), node(i, j), node(i, j + 1), node(i + 1, j + 1)] for j in range(layers) for i in range(n)]
    tags = {"body": [(node(i, 0), node(i + 1, 0)) for i in range(n)], "outer": [(node(i, layers), node(i + 1, layers)) for i in range(n)]}
    su2(folder / "mesh.su2", points, cells, tags)
    return folder / "mesh.su2", turned(angle, "body", "outer")


def turned(angle, body, fixed):
    """A schedule that turns a body in the plane."""
    return f"""version = 1
[time]
values = [0.0, 1.0]
[[body]]
name = "{body}"
tags = ["{body}"]
[body.rigid]
rotate = {{ axis = [0.0, 0.0, 1.0], origin = [0.0, 0.0, 0.0], angle = {angle} }}
ramp = true
[boundaries]
fixed = ["{fixed}"]
"""


def blade(folder, angle, cells, nodes=20_000):
    """A blade with first cells of 1e-5 chord, turned about its span."""
    azimesh("sample", "blade", "--nodes", nodes, "--cells", cells, "-o", folder / "mesh.vtu", "--force")
    return folder / "mesh.vtu", f"""version = 1
[time]
values = [0.0, 1.0]
[[body]]
name = "blade"
tags = ["blade"]
[body.rigid]
rotate = {{ axis = [1.0, 0.0, 0.0], origin = [0.0, 0.0, 0.0], angle = {angle} }}
ramp = true
[boundaries]
fixed = ["outer"]
[rbf]
support_radius = 5.625
interpolate = "twist"
"""


def run(name, folder, mesh, schedule):
    """One row: the motion as it is, then with repair, and the repair command on the folded mesh."""
    for how in ("warn", "substeps", "repair"):
        (folder / f"{how}.toml").write_text(schedule + f'\n[output]\non_inverted = "{how}"\n')
    told = {}
    for how in ("warn", "substeps", "repair"):
        start = time.monotonic()
        azimesh("deform", mesh, folder / f"{how}.toml", "-o", folder / how, "--force", "-q")
        told[how] = (read_rows(folder / how / "steps.csv"), time.monotonic() - start)
    folded = sorted((folder / "warn").glob("*_0001.*"))[-1]
    start = time.monotonic()
    code, out, _ = azimesh("repair", folded, "-o", folder / "repaired.vtu", "--reference", mesh, "--json", "--force")
    seconds, found = time.monotonic() - start, json.loads(out)
    worst = lambda how, column: max(float(row[column] or 0) for row in told[how][0])  # noqa: E731
    least = lambda how: min(float(row["min_scaled_jacobian"]) for row in told[how][0])  # noqa: E731
    extra = max((patch["largest_move"] for patch in found["patches"]), default=0.0)
    print(
        f"{name:34} {worst('warn', 'inverted'):7.0f} {worst('substeps', 'inverted'):7.0f} {worst('repair', 'inverted'):7.0f} {least('repair'):8.4f} "
        f"{told['repair'][1]:7.2f} | {found['invalid_before']:7} {found['invalid']:6} {found['min_scaled_jacobian'] or 0:8.4f} {seconds:7.2f} {extra:9.3g}",
        flush=True,
    )


def read_rows(path):
    """The rows of a table as dictionaries."""
    lines = [line.split(",") for line in path.read_text().splitlines()]
    return [dict(zip(lines[0], line)) for line in lines[1:]]


CASES = {}
for gap in (0.05, 0.005, 0.0005):
    for times in (2, 4, 20, 60):
        CASES[f"gap {gap} moved by {times} gaps"] = lambda folder, gap=gap, times=times: two_blocks(folder, gap, min(gap * times, 0.3))
for by in (0.2, 0.5, 0.7):
    CASES[f"half body on a sliding plane, {by}"] = lambda folder, by=by: half_body(folder, by, True)
    CASES[f"half body on a fixed plane, {by} (none)"] = lambda folder, by=by: half_body(folder, by, False)
for angle in (90, 120, 180, 270):
    CASES[f"o-grid {angle}"] = lambda folder, angle=angle: o_grid(folder, angle)
for angle in (120, 180):
    for cells in ("hex", "wedge", "tet"):
        CASES[f"blade of {cells}, {angle}"] = lambda folder, angle=angle, cells=cells: blade(folder, angle, cells)


def main():
    words = [word for word in sys.argv[2:] if not word.startswith("--")]
    print(f"{'case':34} {'warn':>7} {'substep':>7} {'repair':>7} {'least':>8} {'s':>7} | {'before':>7} {'after':>6} {'least':>8} {'s':>7} {'moved':>9}")
    for name, make in CASES.items():
        if words and not any(name.startswith(word) for word in words):
            continue
        with tempfile.TemporaryDirectory() as folder:
            run(name, Path(folder), *make(Path(folder)))


if __name__ == "__main__":
    main()

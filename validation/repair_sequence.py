"""A body that turns there and back in a mesh that folds: how much the velocities of nodes jump at repaired steps.

    .venv/bin/python validation/repair_sequence.py target/release/azimesh FOLDER [--case blade] [--angle 180] [--step 5] [--frames]

Writes an O-grid, or a blade of 20,000 nodes of hexahedra, and its sequence to FOLDER; `--rbf` are further lines of the schedule. Prints a row a step: the weight of the repair, folded cells left, the least scaled
Jacobian, and the largest second difference of a node's positions in units of the largest first difference of the moving
surface: what the velocity of a node changes by from step to step. `--frames` draws every step to FOLDER/frames.
"""

import argparse
import json
import subprocess
from pathlib import Path

import numpy as np
import pyvista


def o_grid(path, n=96, layers=36, first=2e-3):
    """An O-grid with thin first cells between an ellipse and a circle, as SU2 has it."""
    growth = np.geomspace(first, 0.16, layers)
    part = np.concatenate([[0], np.cumsum(growth)]) / growth.sum()
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    inner = np.stack([0.5 * np.cos(angles), 0.2 * np.sin(angles)], axis=1)
    outer = 2.5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points = np.concatenate([inner + t * (outer - inner) for t in part])
    around = np.arange(n)
    after = (around + 1) % n
    cells = np.concatenate([np.stack([around, around + n, after + n, after], axis=1) + n * j for j in range(layers)])
    lines = [f"NDIME= 2\nNELEM= {len(cells)}"] + [f"9 {a} {b} {c} {d} {i}" for i, (a, b, c, d) in enumerate(cells)]
    lines += [f"NPOIN= {len(points)}"] + [f"{x!r} {y!r} {i}" for i, (x, y) in enumerate(points.tolist())] + ["NMARK= 2"]
    for name, first_node in (("body", 0), ("outer", n * layers)):
        lines += [f"MARKER_TAG= {name}\nMARKER_ELEMS= {n}"] + [f"3 {first_node + a} {first_node + b}" for a, b in zip(around, after)]
    path.write_text("\n".join(lines) + "\n")


def schedule(case, angle, step, rbf, how):
    """Turns the body by `angle` and back."""
    n = round(angle / step)
    angles = [step * i for i in range(n + 1)] + [step * i for i in range(n - 1, -1, -1)]
    rows = "\n".join(f"{i},0,0,0,{f'{a},0,0' if case == 'blade' else f'0,0,{a}'}" for i, a in enumerate(angles))
    body = "blade" if case == "blade" else "body"
    text = f"""version = 1
[time]
start = 0.0
stop = {len(angles) - 1}.0
step = 1.0
[[body]]
name = "{body}"
tags = ["{body}"]
[body.table]
file = "turn.csv"
[boundaries]
fixed = ["outer"]
[rbf]
{rbf}
[output]
{how}
"""
    return text, "time_s,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n" + rows + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("azimesh", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--case", choices=["o_grid", "blade"], default="o_grid")
    parser.add_argument("--rbf", default="")
    parser.add_argument("--angle", type=float, default=180.0)
    parser.add_argument("--step", type=float, default=5.0)
    parser.add_argument("--output", default='on_inverted = "repair"')
    parser.add_argument("--frames", action="store_true")
    args = parser.parse_args()
    folder = args.folder
    folder.mkdir(parents=True, exist_ok=True)
    mesh = folder / ("mesh.vtu" if args.case == "blade" else "mesh.su2")
    if args.case == "blade":
        sample = [args.azimesh.resolve(), "sample", "blade", "--nodes", "20000", "--cells", "hex", "-o", mesh, "--force", "-q"]
        subprocess.run(sample, check=True)
    else:
        o_grid(mesh)
    text, table = schedule(args.case, args.angle, args.step, args.rbf, args.output)
    (folder / "turn.toml").write_text(text)
    (folder / "turn.csv").write_text(table)
    command = [args.azimesh.resolve(), "deform", mesh, folder / "turn.toml", "-o", folder / "out", "--force", "-q"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    files = sorted((folder / "out").glob("mesh_*.vtu"))
    meshes = [pyvista.read(path) for path in files]
    points = np.array([mesh.points for mesh in meshes], dtype=float)
    rows = [line.split(",") for line in (folder / "out" / "steps.csv").read_text().splitlines()]
    column = rows[0].index
    repairs = json.loads((folder / "out" / "run.json").read_text()).get("repairs", [])
    weights = {repair["step"]: repair.get("weight", 1.0) for repair in repairs}
    first = np.linalg.norm(np.diff(points, axis=0), axis=2)
    second = np.linalg.norm(np.diff(points, 2, axis=0), axis=2)
    unit = first[:, wall_nodes(meshes[0], "blade" if args.case == "blade" else "body")].max()
    print(f"{'step':>4} {'weight':>7} {'left':>5} {'least SJ':>9} {'speed':>7} {'jump':>7}")
    for i, row in enumerate(rows[1:]):
        speed = first[i].max() / unit if i < len(first) else np.nan
        jump = second[i - 1].max() / unit if 0 < i < len(points) - 1 else np.nan
        left = int(row[column("inverted")]) + int(row[column("unproven")] or 0)
        print(f"{i:4} {weights.get(i, 0.0):7.3f} {left:5} {float(row[column('min_scaled_jacobian')]):9.4f} {speed:7.3f} {jump:7.3f}")
    if args.frames:
        draw(folder, meshes)


def wall_nodes(mesh, tag):
    """The nodes of a tag."""
    number = list(mesh.field_data["BoundaryTagNames"]).index(tag) + 1
    faces = np.flatnonzero(np.asarray(mesh.cell_data["BoundaryTag"]) == number)
    return np.unique(np.concatenate([mesh.get_cell(int(face)).point_ids for face in faces]))


def draw(folder, meshes):
    """A picture of every step."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import PolyCollection

    (folder / "frames").mkdir(exist_ok=True)
    for i, mesh in enumerate(meshes):
        quads = mesh.cells_dict[pyvista.CellType.QUAD]
        figure, axes = plt.subplots(figsize=(6, 6))
        axes.add_collection(PolyCollection(mesh.points[quads][:, :, :2], facecolor="none", edgecolor="k", linewidth=0.25))
        axes.set(xlim=(-1.6, 1.6), ylim=(-1.6, 1.6), aspect="equal", title=f"step {i}")
        figure.savefig(folder / "frames" / f"{i:04}.png", dpi=90)
        plt.close(figure)


if __name__ == "__main__":
    main()

"""The runs and figures of validation/hart_ii.md: a bending blade through one revolution at 1 degree.

    .venv/bin/python validation/hart_ii_page.py [--nodes 300000] [-o target/hart_ii]

Runs the rotating and the inertial frame over 361 steps, each into one file, checks every row of steps.csv, the positions of
some steps against numpy and the cells of these by VTK, prints the figures of the page, and draws hart_ii_steps.png into the folder.
"""

import argparse
import json
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / folder) for folder in ("scripts/verify", "testdata/generate")]
matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402

import bending  # noqa: E402
import hart_ii  # noqa: E402
import outputs  # noqa: E402

LOOKED_AT = (0, 37, 90, 135, 180, 251, 270, 315, 360)


def points_at(path, k):
    """Nodes of step k in a .vtkhdf."""
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        start = int(root["Steps/PointOffsets"][k])
        return root["Points"][start : start + int(root["NumberOfPoints"][0])].astype(float)


def run(folder, frame):
    """Rows of steps.csv, run.json, the file of a revolution, and its schedule."""
    schedule, out = folder / f"{frame}.toml", folder / frame
    text = (folder / "hart_ii.toml").read_text().replace("[rotor]", f'[rotor]\nframe = "{frame}"')
    schedule.write_text(text + '\n[output]\nformat = "vtkhdf"\n')
    outputs.azimesh("deform", folder / "hart_ii.vtu", schedule, "-o", out, "--force")
    return outputs.steps(out), json.loads((out / "run.json").read_text()), out / "hart_ii.vtkhdf", schedule


def tips(motion, mesh):
    """Displacement of the outermost node of the blade at every step, and the same without the table."""
    nodes = outputs.tagged(mesh, "blade")
    tip = nodes[[mesh.points[nodes, 0].argmax()]]
    body = motion.schedule["body"][0]
    rigid = {key: value for key, value in body.items() if key != "beam"}
    return [np.array([motion.moved(one, tip, k)[0] - mesh.points[tip[0]] for k in range(len(motion.azimuths()))]) for one in (body, rigid)]


def draw_steps(path, column, tip, rigid, tolerance):
    """Tip, error and quality against azimuth."""
    panels = {
        "height of the tip over the reference mesh, mm": {"with the table": 1e3 * tip[:, 2], "precone and pitch alone": 1e3 * rigid[:, 2]},
        "error before the correction, and the tolerance, 1e-6 m": {"error": 1e6 * column("selection_error"), "tolerance": [1e6 * tolerance] * len(tip)},
        "scaled Jacobian": {"smallest": column("min_scaled_jacobian"), "first percentile": column("p01_scaled_jacobian")},
    }
    figure, axes = plt.subplots(1, 3, figsize=(11.5, 3.3), dpi=100, layout="constrained")
    for ax, (title, lines) in zip(axes, panels.items()):
        for name, values in lines.items():
            ax.plot(column("azimuth_deg"), values, label=name)
        ax.set_title(title, loc="left", fontsize=9)
        ax.set(xlim=(0, 360), xticks=range(0, 361, 60), xlabel="azimuth, degrees")
        ax.legend(fontsize=8)
    figure.savefig(path, metadata={"Software": None})


def main():
    """Mesh, runs, checks, figures, a picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=300_000)
    parser.add_argument("-o", "--output", type=Path, default=Path("target/hart_ii"))
    options = parser.parse_args()
    folder = options.output
    hart_ii.write(folder, 1.0, options.nodes)
    mesh, grid = bending.read(folder / "hart_ii.vtu")
    for frame in bending.FRAMES:
        rows, record, file, schedule = run(folder, frame)
        motion = bending.motion_of(schedule, mesh, folder)
        tolerance = motion.schedule["selection"]["tolerance"]
        assert len(rows) == 361
        bending.check_steps(rows, tolerance)
        column = lambda name, rows=rows: np.array([float(row[name]) for row in rows])  # noqa: E731
        places = {k: points_at(file, k) for k in LOOKED_AT}
        worst, fixed = np.max([bending.off(motion, k, points) for k, points in places.items()], axis=0)
        least = min(bending.least_quality(grid, points) for points in places.values())
        tip, rigid = tips(motion, mesh)
        elastic = tip[:, 2] - rigid[:, 2]
        assert worst < 1e-12 and fixed < 1e-13 and least > 0, (worst, fixed, least)
        print(f"{frame}: {record['nodes']} nodes, {record['cells']} cells, {record['surface_points']} surface points")
        print(f"  modes {record['modes']}, off by {record['mode_truncation']:.2e}; base points {rows[0]['base_points']}")
        print(f"  tolerance {tolerance}, selection error {max(column('selection_error')):.3e}, surface error {max(column('max_surface_error')):.2e}")
        print(f"  inverted {max(column('inverted'))}, scaled Jacobian from {min(column('min_scaled_jacobian')):.3f}, first cells from {min(column('min_first_cell_ratio')):.4f}")
        print(f"  numpy at {len(LOOKED_AT)} azimuths: blade off by {worst:.1e}, fixed by {fixed:.1e}; VTK's least {least:.3f}")
        print(f"  tip up {tip[:, 2].min():.4f} to {tip[:, 2].max():.4f}, of that elastic {elastic.min():.4f} to {elastic.max():.4f}")
        print(f"  largest displacement {max(column('max_displacement')):.4f}; seconds {record['seconds']}")
        draw_steps(folder / "hart_ii_steps.png", column, tip, rigid, tolerance)
        file.unlink()


if __name__ == "__main__":
    main()

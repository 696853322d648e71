"""The runs, figures and pictures of validation/hart_ii.md: a bending blade through one revolution at 1 degree.

    .venv/bin/python validation/hart_ii_page.py [--nodes 300000] [-o target/hart_ii] [--pictures validation/pictures]

Runs the rotating and the inertial frame over 361 steps, each into one file, checks every row of steps.csv, the positions of
some steps against numpy and the cells of these by VTK, prints the figures of the page, and draws.
"""

import argparse
import json
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np
import pyvista as pv

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / folder) for folder in ("scripts", "scripts/verify", "testdata/generate")]
matplotlib.use("Agg")

import matplotlib.pyplot as plt

import bending
import hart_ii
import outputs
from make_pictures import EDGES, Image, save

LOOKED_AT = (0, 37, 90, 135, 180, 251, 270, 315, 360)
STATIONS = (0.62, 1.25, 1.88)
INK, BLUE, ORANGE = "#333333", "#0b6e99", "#d1711f"


def points_at(path, k):
    """Nodes of step k in a .vtkhdf."""
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        start = int(root["Steps/PointOffsets"][k])
        return root["Points"][start : start + int(root["NumberOfPoints"][0])].astype(float)


def run(folder, frame):
    """Rows of steps.csv, run.json and the file of a revolution."""
    text = (folder / "hart_ii.toml").read_text()
    schedule = folder / f"{frame}.toml"
    text = text.replace("[rotor]", f'[rotor]\nframe = "{frame}"')
    schedule.write_text(text + '\n[output]\nformat = "vtkhdf"\n')
    out = folder / frame
    outputs.azimesh("deform", folder / "hart_ii.vtu", schedule, "-o", out, "--force")
    return outputs.steps(out), json.loads((out / "run.json").read_text()), out / "hart_ii.vtkhdf", schedule


def looked_at(motion, grid, path, steps):
    """Largest distance of a node of the blade from numpy's place, of a fixed one, and the least quality by VTK."""
    worst, fixed, least = 0.0, 0.0, 1.0
    for k in steps:
        points = points_at(path, k)
        blade, held = bending.off(motion, k, points)
        worst, fixed = max(worst, blade), max(fixed, held)
        least = min(least, bending.least_quality(grid, points))
    return worst, fixed, least


def tips(motion, mesh):
    """Displacement of the outermost node of the blade at every step, and the same without the table."""
    nodes = np.array(sorted({n for face in mesh.tags["blade"] for n in face}))
    tip = nodes[[mesh.points[nodes, 0].argmax()]]
    body = motion.schedule["body"][0]
    rigid = {key: value for key, value in body.items() if key != "beam"}
    place = lambda body, k: motion.moved(body, tip, k)[0] - mesh.points[tip[0]]
    steps = range(len(motion.azimuths()))
    return np.array([place(body, k) for k in steps]), np.array([place(rigid, k) for k in steps])


def draw_steps(path, rows, tip, rigid, tolerance):
    """Tip, error and quality against azimuth."""
    psi = [float(row["azimuth_deg"]) for row in rows]
    plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
                         "grid.color": "#dddddd", "axes.edgecolor": INK, "legend.frameon": False})  # fmt: skip
    figure, axes = plt.subplots(1, 3, figsize=(11.5, 3.3), dpi=100, layout="constrained")
    axes[0].plot(psi, 1e3 * tip[:, 2], color=BLUE, label="with the table")
    axes[0].plot(psi, 1e3 * rigid[:, 2], color=INK, lw=0.9, ls="--", label="precone and pitch alone")
    axes[0].set_title("height of the tip over the reference mesh, mm", loc="left", fontsize=9)
    axes[0].legend(fontsize=8)
    errors = [1e6 * float(row["selection_error"]) for row in rows]
    axes[1].plot(psi, errors, color=ORANGE)
    axes[1].axhline(1e6 * tolerance, color=INK, lw=0.9)
    axes[1].set_ylim(0, 1.15e6 * tolerance)
    axes[1].set_title("error before the correction, and the tolerance, 1e-6 m", loc="left", fontsize=9)
    axes[2].plot(psi, [float(row["min_scaled_jacobian"]) for row in rows], color=BLUE, label="smallest")
    axes[2].plot(psi, [float(row["p01_scaled_jacobian"]) for row in rows], color=ORANGE, label="first percentile")
    axes[2].set_ylim(0, 1)
    axes[2].set_title("scaled Jacobian", loc="left", fontsize=9)
    axes[2].legend(fontsize=8)
    for ax in axes:
        ax.set_xlim(0, 360)
        ax.set_xticks(range(0, 361, 60))
        ax.set_xlabel("azimuth, degrees")
    figure.savefig(path, metadata={"Software": None})
    plt.close(figure)


def blade_of(grid, points):
    """The blade's faces with the nodes at some places."""
    moved = grid.copy()
    moved.points = points
    return moved.extract_cells(np.flatnonzero(moved.cell_data["BoundaryTag"] == 1)).extract_surface(algorithm="dataset_surface")


def cuts_of(grid, points):
    """Rectangles across the span, with the quality of the cells they cut."""
    moved = grid.copy()
    moved.points = points
    volume = moved.extract_cells(np.flatnonzero(moved.cell_data["BoundaryTag"] == 0))
    judged = volume.cell_quality("scaled_jacobian")
    for x in STATIONS:
        cut = judged.slice(normal=(1, 0, 0), origin=(x, 0, 0))
        middle = 0.06 * x
        for axis, centre, half in ((1, -0.03, 0.17), (2, middle, 0.15)):
            for side in (-1, 1):
                normal, origin = np.zeros(3), np.zeros(3)
                normal[axis], origin[axis] = side, centre + side * half
                cut = cut.clip(normal=normal, origin=origin)
        yield cut


def screenshot(plotter):
    """The picture as an image."""
    return Image.fromarray(plotter.screenshot(return_img=True)).convert("RGB")


def draw_blade(path, grid, points):
    """The blade where it is, where it was, and three cuts."""
    plotter = pv.Plotter(window_size=(3000, 1800), off_screen=True)
    plotter.set_background("white")
    for at, cut in enumerate(cuts_of(grid, points)):
        plotter.add_mesh(
            cut, scalars="scaled_jacobian", cmap="viridis", clim=(0.5, 1), show_edges=True, edge_color=EDGES,
            line_width=1.0, lighting=False, show_scalar_bar=at == 0,
            scalar_bar_args=dict(
                title="scaled Jacobian", position_x=0.58, position_y=0.1, width=0.3, height=0.07,
                title_font_size=44, label_font_size=38, n_labels=3, fmt="%.2f", color="black",
            ),
        )  # fmt: skip
    shading = dict(smooth_shading=True, split_sharp_edges=True)
    plotter.add_mesh(blade_of(grid, points), color="#e3e6ea", specular=0.4, specular_power=20, **shading)
    plotter.add_mesh(blade_of(grid, np.array(grid.points)), color="#d8432b", opacity=0.22, **shading)
    plotter.camera_position = [(0.1, -1.35, 0.62), (1.2, 0, 0.0), (0, 0, 1)]
    plotter.camera.zoom(1.15)
    save(screenshot(plotter), path)


def draw_round(path, grid, file):
    """The blade at every 30 degrees of the inertial frame, coloured by its elastic height."""
    plotter = pv.Plotter(window_size=(3000, 1700), off_screen=True)
    plotter.set_background("white")
    for psi in range(0, 360, 30):
        colour = "#d8432b" if psi == 0 else "#c9d1da"
        blade = blade_of(grid, points_at(file, psi))
        plotter.add_mesh(blade, color=colour, smooth_shading=True, split_sharp_edges=True, specular=0.3)
    plotter.camera_position = [(-4.2, -4.2, 2.6), (0, 0, 0.0), (0, 0, 1)]
    plotter.camera.zoom(1.45)
    save(screenshot(plotter), path)


def main():
    """Mesh, runs, checks, figures, pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=300_000)
    parser.add_argument("-o", "--output", type=Path, default=Path("target/hart_ii"))
    parser.add_argument("--pictures", type=Path, default=Path("validation/pictures"))
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
        worst, fixed, least = looked_at(motion, grid, file, LOOKED_AT)
        tip, rigid = tips(motion, mesh)
        column = lambda name: [float(row[name]) for row in rows]
        print(f"{frame}: {record['nodes']} nodes, {record['cells']} cells, {record['surface_points']} surface points")
        print(f"  modes {record['modes']}, off by {record['mode_truncation']:.2e}; base points {rows[0]['base_points']}")
        print(f"  tolerance {tolerance}, selection error {max(column('selection_error')):.3e}, "
              f"surface error {max(column('max_surface_error')):.2e}")  # fmt: skip
        print(f"  inverted {max(column('inverted'))}, scaled Jacobian from {min(column('min_scaled_jacobian')):.3f}, "
              f"first cells from {min(column('min_first_cell_ratio')):.4f}")  # fmt: skip
        print(f"  numpy at {len(LOOKED_AT)} azimuths: blade off by {worst:.1e}, fixed by {fixed:.1e}; VTK's least {least:.3f}")
        elastic = tip[:, 2] - rigid[:, 2]
        print(f"  tip up {tip[:, 2].min():.4f} to {tip[:, 2].max():.4f}, of that elastic {elastic.min():.4f} to {elastic.max():.4f}")
        print(f"  largest displacement {max(column('max_displacement')):.4f}; seconds {record['seconds']}")
        if frame == "rotating":
            draw_steps(options.pictures / "hart_ii_steps.png", rows, tip, rigid, tolerance)
            draw_blade(options.pictures / "hart_ii.png", grid, points_at(file, int(tip[:, 2].argmax())))
        else:
            draw_round(options.pictures / "hart_ii_round.png", grid, file)
        file.unlink()


if __name__ == "__main__":
    main()

"""The run, figures and picture of docs/tasks/rotor.md: four blades in one mesh through one revolution.

    .venv/bin/python scripts/rotor_page.py [--nodes 40000] [--first-cell 1e-3] [--step 5] [-o target/rotor] [--pictures docs/pictures]

Checks every row of steps.csv, the blades of every step against numpy, the symmetry of the whole mesh, and some steps by VTK.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np
import pyvista as pv

sys.path.insert(0, str(Path(__file__).parent / "verify"))

import bending
import outputs
import reference
import rotor
sys.path.append(str(Path(__file__).resolve().parents[1] / "validation"))
from hart_ii_page import points_at, screenshot
from make_pictures import EDGES, save

AZIMUTH = 30


def boundary(grid, points, first, last):
    """The faces of some tags with the nodes at some places."""
    moved = grid.copy()
    moved.points = points
    tag = np.array(moved.cell_data["BoundaryTag"])
    return moved.extract_cells(np.flatnonzero((tag >= first) & (tag <= last))).extract_surface(algorithm="dataset_surface")


def draw(path, grid, points):
    """The blades and the hub, and the cells that the plane of the hub cuts, coloured by quality."""
    moved = grid.copy()
    moved.points = points
    volume = moved.extract_cells(np.flatnonzero(moved.cell_data["BoundaryTag"] == 0))
    cut = volume.cell_quality("scaled_jacobian").slice(normal=(0, 0, 1), origin=(0, 0, -0.25))
    plotter = pv.Plotter(window_size=(3000, 2000), off_screen=True)
    plotter.set_background("white")
    plotter.add_mesh(
        cut, scalars="scaled_jacobian", cmap="viridis", clim=(0, 1), show_edges=True, edge_color=EDGES, line_width=0.7,
        lighting=False, scalar_bar_args=dict(
            title="scaled Jacobian", position_x=0.66, position_y=0.03, width=0.3, height=0.06, title_font_size=44,
            label_font_size=38, n_labels=3, fmt="%.1f", color="black",
        ),
    )  # fmt: skip
    shading = dict(smooth_shading=True, split_sharp_edges=True, specular=0.4, specular_power=20)
    plotter.add_mesh(boundary(grid, points, 1, 1), color="#d8432b", **shading)
    plotter.add_mesh(boundary(grid, points, 2, rotor.BLADES), color="#e3e6ea", **shading)
    plotter.add_mesh(boundary(grid, points, rotor.BLADES + 1, rotor.BLADES + 1), color="#8f9bad", **shading)
    plotter.camera_position = [(-7.0, -13.5, 10.5), (0, 0, -0.2), (0, 0, 1)]
    plotter.camera.zoom(1.4)
    save(screenshot(plotter), path)


def main():
    """Mesh, run, checks, figures, picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=40_000)
    parser.add_argument("--first-cell", type=float, default=1e-3)
    parser.add_argument("--step", type=float, default=5.0)
    parser.add_argument("-o", "--output", type=Path, default=Path("target/rotor"))
    parser.add_argument("--pictures", type=Path, default=Path("docs/pictures"))
    options = parser.parse_args()
    folder = options.output
    folder.mkdir(parents=True, exist_ok=True)
    path, schedule = rotor.make(folder, options.step, ["--nodes", options.nodes, "--first-cell", options.first_cell])
    schedule.write_text(schedule.read_text() + '\n[output]\nformat = "vtkhdf"\n')
    outputs.azimesh("deform", path, schedule, "-o", folder / "out", "--force")
    rows, record = outputs.steps(folder / "out"), json.loads((folder / "out" / "run.json").read_text())
    file = folder / "out" / "rotor.vtkhdf"
    mesh, grid = bending.read(path)
    motion = reference.Motion(schedule, mesh)
    tolerance = motion.schedule["selection"]["tolerance"]
    bending.check_steps(rows, tolerance)
    symmetry, worst, least = rotor.Symmetry(mesh), 0.0, 1.0
    quarter = (len(rows) - 1) // 4
    for k in range(len(rows)):
        points = points_at(file, k)
        if k % 6 == 0:
            wanted = motion.carried(motion.step(k), k)
            worst = max(worst, *(np.abs(points[n] - wanted[n]).max() for n in symmetry.nodes))
            least = min(least, bending.least_quality(grid, points))
        if k >= quarter:
            symmetry.compare(points_at(file, k - quarter), points)
    assert worst <= 1e-12 and symmetry.surface <= 1e-12 and least > 0.0, (worst, symmetry.surface, least)
    column = lambda name: [float(row[name]) for row in rows]
    print(f"{record['nodes']} nodes, {record['cells']} cells, {record['surface_points']} surface points, {len(rows)} steps")
    print(f"modes {record['modes']}; base points {rows[0]['base_points']}; tolerance {tolerance}, "
          f"error {max(column('selection_error')):.3e}, surface {max(column('max_surface_error')):.1e}")  # fmt: skip
    print(f"inverted {max(column('inverted'))}; scaled Jacobian {min(column('min_scaled_jacobian')):.3f}, VTK {least:.3f}; "
          f"first cells {min(column('min_first_cell_ratio')):.4f}")  # fmt: skip
    print(f"blades against numpy {worst:.1e}; {symmetry.n_steps} steps a quarter of a turn later: "
          f"blades {symmetry.surface:.1e}, all nodes {symmetry.volume:.2e}")  # fmt: skip
    print(f"seconds {record['seconds']}")
    draw(options.pictures / "rotor.png", grid, points_at(file, round(AZIMUTH / options.step)))
    file.unlink()


if __name__ == "__main__":
    main()

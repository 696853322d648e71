"""Measures and draws large rotations for docs/rotations.md.

    .venv/bin/python scripts/large_rotations.py

Prints the tables: an airfoil in a circle and a blade in its cylinder, turned in one step from the reference mesh, with
displacements interpolated, with rotations interpolated, and with rotations that fall with the logarithm of the radius; and the airfoil with
cells of other heights, about another point and with other support radii. Draws docs/pictures/large_rotations.png: the airfoil at 180 degrees.
"""

import sys
import tempfile
from pathlib import Path

import matplotlib

sys.path.insert(0, str(Path(__file__).parent / "verify"))
matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pyvista
from matplotlib.collections import LineCollection, PolyCollection
from PIL import Image

import outputs
import twist
from program import azimesh

WAYS = tuple(twist.WAYS)
BLADE = ["--untwisted", "--root", 11, "--radius", 14, "--cylinder-radius", 8, "--first-cell", 1e-2]
BLADE += ["--nodes", 500_000, "--layers", 110]


def row_of(row):
    """A line of the table for one way."""
    least, ratio = float(row["min_scaled_jacobian"]), float(row["min_first_cell_ratio"])
    return f"{least:.3f} ({row['inverted']}) | {ratio:.3f}"


def table(found):
    """All ways side by side."""
    print("| degrees | " + " | first cell | ".join(WAYS) + " | first cell |")
    print("|---" * (1 + 2 * len(WAYS)) + "|")
    for angle in twist.ANGLES:
        print(f"| {angle} | " + " | ".join(row_of(found[way][angle]) for way in WAYS) + " |")


def blade(folder):
    """Rows of steps.csv by way and angle."""
    mesh = folder / "blade.vtu"
    azimesh("sample", "blade", *BLADE, "-o", mesh)
    found = {}
    for way in WAYS:
        text = twist.SCHEDULE.format(keys=twist.WAYS[way].replace("10.0", "20.0")).replace("airfoil", "blade").replace("farfield", "outer")
        text = text.replace("[0.0, 0.0, 1.0], origin = [0.25, 0.0, 0.0]", "[1.0, 0.0, 0.0], origin = [12.5, -0.25, 0.0]")
        text = text.replace("support_radius = 10.0", "support_radius = 20.0").replace("1e-4", "3e-3")
        schedule = folder / f"blade_{way}.toml"
        schedule.write_text(text)
        rows = outputs.deform(mesh, schedule, folder / f"blade_{way}", expect=(0, 1))
        found[way] = {round(float(row["azimuth_deg"])): row for row in rows}
    return found


def variants(folder):
    """The airfoil at 120, 180 and 270 degrees with other cells, another centre, other radii."""
    def told(name, ways=("interpolated", "twist"), change=lambda text: text):
        cells = [row_of(found[angle]).split(" |")[0] for way in ways for found in [twist.turned(folder, way, change)] for angle in (120, 180, 270)]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)

    print("| | interpolated: 120 | 180 | 270 | twist: 120 | 180 | 270 |\n|---|---|---|---|---|---|---|")
    usual = twist.LARGEST
    for twist.LARGEST in (0.02, 0.03, 0.05, 0.1, float("inf")):
        told(f"{twist.LARGEST}, {len(twist.heights()) - 1} layers, largest {max(twist.np.diff(twist.heights())):.3f}")
    twist.LARGEST = usual
    told("about the quarter chord", change=lambda text: text.replace("origin = [0.25", "origin = [0.0"))
    for radius in (2.5, 40.0):
        told(f"support radius {radius}", change=lambda text, radius=radius: text.replace("radius = 10.0", f"radius = {radius}"))


def draw(axes, points, shape, title):
    """Every fourth line of the O-grid, and the folded cells in red."""
    nodes = points[:, :2].reshape(*shape, 2)
    closed = np.concatenate([nodes, nodes[:, :1]], axis=1)
    lines = [*closed[::4], closed[-1], *np.swapaxes(nodes, 0, 1)[::4]]
    axes.add_collection(LineCollection(lines, colors="#1c2b45", linewidths=0.35))
    quads = np.stack([closed[:-1, :-1], closed[1:, :-1], closed[1:, 1:], closed[:-1, 1:]], axis=2).reshape(-1, 4, 2)
    folded = twist.scaled_jacobian(quads.reshape(-1, 2), np.arange(4 * len(quads)).reshape(-1, 4)) <= 0
    axes.add_collection(PolyCollection(quads[folded], facecolors="#d8432b", edgecolors="none", zorder=3))
    axes.fill(*nodes[0].T, color="#8f9bad", zorder=4)
    axes.set_title(title, fontsize=10)
    axes.set_aspect("equal")
    axes.set_xlim(-2.55, 2.55)
    axes.set_ylim(-2.55, 2.55)
    axes.axis("off")


def picture(folder, found, path):
    """The reference mesh and both ways at 180 degrees."""
    shape = twist.ogrid().shape[:2]
    figure, axes = plt.subplots(1, 3, figsize=(12, 4.2), dpi=100, layout="constrained")
    shown = [("reference mesh", "twist", 0), ("180 degrees, displacement", "displacement", 180), ("180 degrees, twist", "twist", 180)]
    for ax, (title, way, angle) in zip(axes, shown):
        points = np.array(pyvista.read(folder / way / found[way][angle]["file"]).points)
        draw(ax, points, shape, title)
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")
    image.quantize(16, method=Image.FASTOCTREE, dither=Image.Dither.NONE).save(path, optimize=True)


def main():
    """Both cases, and the picture."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        found = {way: twist.turned(folder, way) for way in WAYS}
        print("airfoil:")
        table(found)
        picture(folder, found, Path("docs/pictures/large_rotations.png"))
        variants(folder)
        print("blade:")
        table(blade(folder))


if __name__ == "__main__":
    main()

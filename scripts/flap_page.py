"""The table and the picture of validation/flap.md: the flap of a three-element airfoil.

    AZIMESH_TESTDATA=... .venv/bin/python scripts/flap_page.py [--pictures docs/pictures]
"""

import argparse
import sys
from pathlib import Path

import matplotlib
import numpy as np

sys.path.insert(0, str(Path(__file__).parent / "verify"))
matplotlib.use("Agg")

import matplotlib.pyplot as plt
from PIL import Image

import flap
import outputs
from program import scratch

WAYS = [
    ("nothing", ""),
    ("`support_radius = 8`", "rbf.support_radius = 8.0"),
    ("`support_radius = 15`", "rbf.support_radius = 15.0"),
    ("`support_radius = 40`", "rbf.support_radius = 40.0"),
    ("`support_radius = 120`", "rbf.support_radius = 120.0"),
    ('`kernel = "wendland-c0"`, 40', 'rbf = { kernel = "wendland-c0", support_radius = 40.0 }'),
    ('`kernel = "wendland-c4"`, 40', 'rbf = { kernel = "wendland-c4", support_radius = 40.0 }'),
    ("`substeps = 2`", "rbf.substeps = 2"),
    ("`substeps = 6`", "rbf.substeps = 6"),
    ('`"twist"`, 15', 'rbf = { interpolate = "twist", support_radius = 15.0 }'),
    ('`"twist"`, `"wendland-c0"`, 15', 'rbf = { interpolate = "twist", kernel = "wendland-c0", support_radius = 15.0 }'),
    ('`"twist"`, `"wendland-c0"`, 40', 'rbf = { interpolate = "twist", kernel = "wendland-c0", support_radius = 40.0 }'),
    ('`"twist"`, `"wendland-c0"`, 40, `substeps = 2`',
     'rbf = { interpolate = "twist", kernel = "wendland-c0", support_radius = 40.0, substeps = 2 }'),
]  # fmt: skip
SHOWN = (30, 45, 60, 90, 120)
DRAWN = (0, 30, 60, 90)
WINDOW = (14.0, 26.2, -6.8, 1.8)


def reached(rows):
    """The largest angle up to which no triangle is inverted."""
    largest = 0.0
    for row in rows:
        if int(row["inverted"]):
            break
        largest = float(row["azimuth_deg"])
    return largest


def draw(axes, points, triangles, title):
    """Triangles behind the wing by their quality."""
    middle = points[triangles].mean(axis=1)
    near = (middle[:, 0] > WINDOW[0] - 1) & (middle[:, 0] < WINDOW[1] + 1) & (np.abs(middle[:, 1]) < 9)
    quality = flap.scaled_jacobian(points, triangles)
    drawn = axes.tripcolor(points[:, 0], points[:, 1], triangles[near], facecolors=quality[near], vmin=0, vmax=1,
                           edgecolors="#1c2b45", linewidth=0.15)  # fmt: skip
    axes.set_xlim(*WINDOW[:2])
    axes.set_ylim(*WINDOW[2:])
    axes.set_aspect("equal")
    axes.axis("off")
    axes.set_title(f"{title}, smallest {quality.min():.2f}", fontsize=9)
    return drawn


def picture(path, meshes, triangles):
    """Four angles side by side."""
    figure, axes = plt.subplots(2, 2, figsize=(10, 7.2), dpi=110, layout="constrained")
    for ax, (angle, points) in zip(axes.flat, meshes.items()):
        drawn = draw(ax, points, triangles, f"{angle} degrees" if angle else "reference mesh")
    figure.colorbar(drawn, ax=axes, shrink=0.5, label="scaled Jacobian")
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")
    image.quantize(128, method=Image.FASTOCTREE, dither=Image.Dither.NONE).save(path, optimize=True)


def main():
    """Every way to 150 degrees, in steps of 5."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pictures", type=Path, default=Path("docs/pictures"))
    pictures = parser.parse_args().pictures
    if flap.real_meshes() is None:
        sys.exit("flap_page: AZIMESH_TESTDATA is not set")
    print("| what is said under `[rbf]` | " + " | ".join(f"{angle} degrees" for angle in SHOWN) + " | largest angle |")
    print("|---|" + "---|" * (len(SHOWN) + 1))
    with scratch() as folder:
        mesh, points, triangles, _, tag = flap.prepare(folder)
        for n, (name, rest) in enumerate(WAYS):
            rows, out = flap.turn(folder, mesh, tag, rest, 150, 5, f"way{n}")
            found = {round(float(row["azimuth_deg"])): row for row in rows}
            cells = [f"{float(found[a]['min_scaled_jacobian']):.3f} ({found[a]['inverted']})" for a in SHOWN]
            print(f"| {name} | " + " | ".join(cells) + f" | {reached(rows):g} |", flush=True)
            if name == "`substeps = 2`":
                meshes = {a: outputs.points(out, found[a])[:, :2] for a in DRAWN}
                picture(pictures / "flap.png", meshes, triangles)


if __name__ == "__main__":
    main()

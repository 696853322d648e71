"""The pictures of docs/: `.venv/bin/python scripts/pictures.py [blade rotor large_rotations flap report] [-o docs/pictures]`.

blade.webp: a rotor blade through one revolution. rotor.png: four blades at 30 degrees. large_rotations.png: an airfoil in a circle at 180 degrees, as
displacements and as `twist`. flap.png: the flap of a three-element airfoil (of AZIMESH_TESTDATA). report.png: the top of a report in Chromium.
"""

import argparse
import base64
import io
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pyvista as pv
from PIL import Image, ImageChops

sys.path.insert(0, str(Path(__file__).parent / "verify"))
matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.collections import LineCollection, PolyCollection  # noqa: E402

import flap as flap_check  # noqa: E402
import outputs  # noqa: E402
import twist  # noqa: E402
from program import azimesh, scratch  # noqa: E402

DARK, RED, GREY = "#1c2b45", "#d8432b", "#e3e6ea"
BAR = dict(title="scaled Jacobian", width=0.3, height=0.07, n_labels=3, fmt="%.2f", color="black", position_x=0.62, position_y=0.08)


def save(image, path, colours=256):
    """With few colours, so that it is small."""
    image.quantize(colours, method=Image.FASTOCTREE, dither=Image.Dither.NONE).save(path, optimize=True)


def of_figure(figure):
    """A figure of matplotlib as an image."""
    figure.canvas.draw()
    return Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")


def boundary(mesh, first, last):
    """The faces of some tags."""
    tag = mesh.cell_data["BoundaryTag"]
    return mesh.extract_cells(np.flatnonzero((tag >= first) & (tag <= last))).extract_surface(algorithm="dataset_surface")


def judged(mesh):
    """The cells of a mesh with their quality."""
    return mesh.extract_cells(np.flatnonzero(mesh.cell_data["BoundaryTag"] == 0)).cell_quality("scaled_jacobian")


def rendered(cuts, surfaces, camera, zoom, size, least):
    """Cuts coloured by quality, and surfaces as (mesh, colour, opacity)."""
    plotter = pv.Plotter(window_size=size, off_screen=True)
    plotter.set_background("white")
    for i, cut in enumerate(cuts):
        plotter.add_mesh(cut, scalars="scaled_jacobian", cmap="viridis", clim=(least, 1), show_edges=True, edge_color=DARK, lighting=False,
                         show_scalar_bar=i == 0, scalar_bar_args=BAR)  # fmt: skip
    for mesh, colour, opacity in surfaces:
        plotter.add_mesh(mesh, color=colour, opacity=opacity, smooth_shading=True, split_sharp_edges=True, specular=0.4, specular_power=20)
    plotter.camera_position = camera
    plotter.camera.zoom(zoom)
    image = Image.fromarray(plotter.screenshot(return_img=True)).convert("RGB")
    plotter.close()
    return image


def blade(folder, pictures):
    """Every step of a revolution: the blade in grey, in red where it was, cells of three cuts by their quality."""
    azimesh("sample", "blade", "--nodes", 60000, "--first-cell", "2e-3", "-o", folder / "blade.vtu")
    outputs.deform(folder / "blade.vtu", folder / "blade.toml", folder / "out")
    before, frames = pv.read(folder / "blade.vtu"), []
    for step in sorted((folder / "out").glob("blade_????.vtu"))[:-1]:
        mesh = pv.read(step)
        surface, cells, cuts = boundary(mesh, 1, 1), judged(mesh), []
        for x in (1.75, 3.1, 4.45):
            near = surface.points[np.abs(surface.points[:, 0] - x) < 0.1]
            middle = (near.min(axis=0) + near.max(axis=0)) / 2
            box = (x - 1, x + 1, middle[1] - 0.42, middle[1] + 0.42, middle[2] - 0.3, middle[2] + 0.3)
            cuts.append(cells.slice(normal=(1, 0, 0), origin=(x, 0, 0)).clip_box(box, invert=False))
        camera = [(0.0, -2.9, 1.35), (3.2, 0, -0.05), (0, 0, 1)]
        image = rendered(cuts, [(surface, GREY, 1.0), (boundary(before, 1, 1), RED, 0.22)], camera, 1.28, (1600, 880), 0.5)
        frames.append(image.resize((800, 440), Image.LANCZOS))
    frames[0].save(pictures / "blade.webp", save_all=True, append_images=frames[1:], duration=100, loop=0, quality=60, method=6, minimize_size=True)


def rotor(folder, pictures):
    """Four blades and the hub, and the cells that the plane of the hub cuts."""
    azimesh("sample", "rotor", "--blades", 4, "--nodes", 40000, "--first-cell", "1e-3", "-o", folder / "rotor.vtu")
    rows = outputs.deform(folder / "rotor.vtu", folder / "rotor.toml", folder / "out")
    mesh = pv.read(folder / "out" / next(row["file"] for row in rows if float(row["azimuth_deg"]) == 30))
    surfaces = [(boundary(mesh, 1, 1), RED, 1.0), (boundary(mesh, 2, 4), GREY, 1.0), (boundary(mesh, 5, 5), "#8f9bad", 1.0)]
    cut = judged(mesh).slice(normal=(0, 0, 1), origin=(0, 0, -0.25))
    image = rendered([cut], surfaces, [(-7.0, -13.5, 10.5), (0, 0, -0.2), (0, 0, 1)], 1.4, (3000, 2000), 0.0)
    left, top, right, bottom = ImageChops.difference(image, Image.new("RGB", image.size, "white")).getbbox()
    image = image.crop((left, max(top - 30, 0), right, min(bottom + 30, image.height)))
    save(image.resize((1200, round(image.height * 1200 / image.width)), Image.LANCZOS), pictures / "rotor.png")


def large_rotations(folder, pictures):
    """Every fourth line of an O-grid, and folded cells in red."""
    shape = twist.ogrid().shape[:2]
    found = {way: twist.turned(folder, way) for way in ("twist", "displacement")}
    figure, axes = plt.subplots(1, 3, figsize=(12, 4.2), dpi=100, layout="constrained")
    for ax, (way, angle) in zip(axes, (("twist", 0), ("displacement", 180), ("twist", 180))):
        nodes = found[way][angle]["points"][:, :2].reshape(*shape, 2)
        closed = np.concatenate([nodes, nodes[:, :1]], axis=1)
        ax.add_collection(LineCollection([*closed[::4], closed[-1], *np.swapaxes(nodes, 0, 1)[::4]], colors=DARK, linewidths=0.35))
        quads = np.stack([closed[:-1, :-1], closed[1:, :-1], closed[1:, 1:], closed[:-1, 1:]], axis=2).reshape(-1, 4, 2)
        folded = twist.scaled_jacobian(quads.reshape(-1, 2), np.arange(4 * len(quads)).reshape(-1, 4)) <= 0
        ax.add_collection(PolyCollection(quads[folded], facecolors=RED, edgecolors="none", zorder=3))
        ax.fill(*nodes[0].T, color="#8f9bad", zorder=4)
        ax.set_title(f"{angle} degrees, {way}" if angle else "reference mesh", fontsize=10)
        ax.set(aspect="equal", xlim=(-2.55, 2.55), ylim=(-2.55, 2.55))
        ax.axis("off")
    save(of_figure(figure), pictures / "large_rotations.png", 16)


def flap(folder, pictures):
    """Triangles behind the wing by their quality, at four angles with two substeps."""
    mesh, _, triangles, _, tag = flap_check.prepare(folder)
    rows, out = flap_check.turn(folder, mesh, tag, "rbf.substeps = 2", 90, 30)
    figure, axes = plt.subplots(2, 2, figsize=(10, 7.2), dpi=110, layout="constrained")
    for ax, row in zip(axes.flat, rows):
        points = outputs.points(out, row)[:, :2]
        x, y = points[triangles].mean(axis=1).T
        near, quality = (x > 13) & (x < 27.2) & (np.abs(y) < 9), twist.scaled_jacobian(points, triangles) * 2 / np.sqrt(3)
        drawn = ax.tripcolor(*points.T, triangles[near], facecolors=quality[near], vmin=0, vmax=1, edgecolors=DARK, linewidth=0.15)
        ax.set(xlim=(14.0, 26.2), ylim=(-6.8, 1.8), aspect="equal")
        ax.axis("off")
        ax.set_title(f"{float(row['azimuth_deg']):g} degrees, smallest {quality.min():.2f}", fontsize=9)
    figure.colorbar(drawn, ax=axes, shrink=0.5, label="scaled Jacobian")
    save(of_figure(figure), pictures / "flap.png", 128)


def report(folder, pictures):
    """The page of a rotor with four blades."""
    from browser import chromium
    from report import drawn, wait_for

    azimesh("sample", "rotor", "--blades", 4, "--nodes", 120000, "--first-cell", "1e-3", "-o", folder / "rotor.vtu")
    schedule = folder / "rotor.toml"
    schedule.write_text(schedule.read_text() + '\n[output]\ntitle = "Four blades in forward flight"\nlength_unit = "m"\n')
    outputs.deform(folder / "rotor.vtu", schedule, folder / "out")
    azimesh("report", folder / "out")
    with chromium(1280) as driver:
        driver.get((folder / "out" / "report.html").as_uri())
        wait_for(driver, "space", "return document.getElementById('scene').dataset.ready")
        driver.execute_script("showStep(5)")
        drawn(driver)
        driver.execute_script("const c = document.getElementById('command'); c.textContent = c.textContent.replaceAll(arguments[0], '')", f"{folder}/")
        clip = {"x": 0, "y": 0, "width": 1280, "height": 1500, "scale": 1}
        taken = driver.execute_cdp_cmd("Page.captureScreenshot", {"clip": clip, "captureBeyondViewport": True})
    Image.open(io.BytesIO(base64.b64decode(taken["data"]))).convert("RGB").quantize(128, dither=Image.Dither.NONE).save(pictures / "report.png", optimize=True)


DRAWN = {draw.__name__: draw for draw in (blade, rotor, large_rotations, flap, report)}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help=", ".join(DRAWN))
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/pictures"))
    options = parser.parse_args()
    for name in options.names or DRAWN:
        with scratch() as place:
            DRAWN[name](place, options.output)

"""Renders docs/pictures/blade.webp: a rotor blade through one revolution, cut at three stations.

    .venv/bin/python scripts/make_pictures.py [--azimesh PROGRAM]

Needs pyvista and Pillow. Makes the sample `blade`, deforms it through one revolution and draws every step: the blade in grey, in red
where it is in the reference mesh; the cells of three cuts coloured by their scaled Jacobian.
"""

import argparse
import pathlib
import subprocess
import tempfile

import numpy as np
import pyvista as pv
from PIL import Image, ImageChops

STATIONS = (1.75, 3.1, 4.45)
EDGES = "#1c2b45"


def blade_of(mesh):
    """The faces of the first boundary tag."""
    return mesh.extract_cells(np.flatnonzero(mesh.cell_data["BoundaryTag"] == 1)).extract_surface(algorithm="dataset_surface")


def cuts_of(mesh):
    """Rectangles of the planes across the span, around the blade, with the quality of the cells in them."""
    blade = blade_of(mesh).points
    volume = mesh.extract_cells(np.flatnonzero(mesh.cell_data["BoundaryTag"] == 0))
    measured = volume.cell_quality("scaled_jacobian")
    for x in STATIONS:
        cut = measured.slice(normal=(1, 0, 0), origin=(x, 0, 0))
        section = blade[np.abs(blade[:, 0] - x) < 0.1]
        middle = (section.min(axis=0) + section.max(axis=0)) / 2
        for axis, centre, half in ((1, middle[1], 0.42), (2, middle[2], 0.3)):
            for side in (-1, 1):
                normal, origin = np.zeros(3), np.zeros(3)
                normal[axis], origin[axis] = side, centre + side * half
                cut = cut.clip(normal=normal, origin=origin)
        yield cut


def draw(reference, deformed):
    """One frame, at twice its size."""
    plotter = pv.Plotter(window_size=(1600, 880), off_screen=True)
    plotter.set_background("white")
    for at, cut in enumerate(cuts_of(deformed)):
        plotter.add_mesh(
            cut, scalars="scaled_jacobian", cmap="viridis", clim=(0.5, 1), show_edges=True,
            edge_color=EDGES, line_width=1, lighting=False, show_scalar_bar=at == 0,
            scalar_bar_args=dict(
                title="scaled Jacobian", position_x=0.6, position_y=0.12, width=0.3, height=0.08,
                title_font_size=26, label_font_size=22, n_labels=3, fmt="%.2f", color="black",
            ),
        )
    shading = dict(smooth_shading=True, split_sharp_edges=True)
    plotter.add_mesh(blade_of(deformed), color="#e3e6ea", specular=0.4, specular_power=20, **shading)
    plotter.add_mesh(blade_of(reference), color="#d8432b", opacity=0.22, **shading)
    plotter.camera_position = [(0.0, -2.9, 1.35), (3.2, 0, -0.05), (0, 0, 1)]
    plotter.camera.zoom(1.28)
    image = Image.fromarray(plotter.screenshot(return_img=True)).convert("RGB")
    plotter.close()
    return image.resize((800, 440), Image.LANCZOS)


def save(image, path):
    """Cuts the white margin off and keeps the file small."""
    white = Image.new("RGB", image.size, (255, 255, 255))
    left, top, right, bottom = ImageChops.difference(image, white).getbbox()
    image = image.crop((left, max(top - 30, 0), right, min(bottom + 30, image.height)))
    image = image.resize((1200, round(image.height * 1200 / image.width)), Image.LANCZOS)
    image.quantize(256, method=Image.FASTOCTREE, dither=Image.Dither.NONE).save(path, optimize=True)


def main():
    """Makes the mesh, moves it and draws its steps."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--azimesh", default="target/release/azimesh")
    program = str(pathlib.Path(parser.parse_args().azimesh).resolve())
    pictures = pathlib.Path(__file__).resolve().parent.parent / "docs" / "pictures"
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        mesh = folder / "blade.vtu"
        size = ["--nodes", "60000", "--first-cell", "2e-3"]
        subprocess.run([program, "sample", "blade", *size, "-o", mesh], check=True)
        subprocess.run([program, "deform", mesh, folder / "blade.toml", "-o", folder / "out"], check=True)
        reference = pv.read(mesh)
        steps = sorted((folder / "out").glob("blade_????.vtu"))[:-1]
        frames = [draw(reference, pv.read(step)) for step in steps]
    frames[0].save(
        pictures / "blade.webp", save_all=True, append_images=frames[1:], duration=100, loop=0, quality=60, method=6, minimize_size=True
    )


if __name__ == "__main__":
    main()

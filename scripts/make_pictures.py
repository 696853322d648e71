"""Renders docs/pictures/blade.png: a rotor blade at 270 degrees of azimuth, cut at three stations.

    .venv/bin/python scripts/make_pictures.py [--azimesh PROGRAM]

Needs pyvista and Pillow (written with pyvista 0.49.1). Makes the sample `blade`, deforms it through
one revolution and draws step 27: the blade in grey where it is, in red where it was in the reference
mesh; the cells of three cuts coloured by their scaled Jacobian.
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
    return mesh.extract_cells(np.flatnonzero(mesh.cell_data["BoundaryTag"] == 1)).extract_surface()


def cuts_of(mesh):
    """Rectangles of the planes across the span, with the quality of the cells they cut."""
    volume = mesh.extract_cells(np.flatnonzero(mesh.cell_data["BoundaryTag"] == 0))
    judged = volume.cell_quality("scaled_jacobian")
    for x in STATIONS:
        cut = judged.slice(normal=(1, 0, 0), origin=(x, 0, 0))
        for axis, centre, half in ((1, -0.08, 0.42), (2, -0.02, 0.3)):
            for side in (-1, 1):
                normal, origin = np.zeros(3), np.zeros(3)
                normal[axis], origin[axis] = side, centre + side * half
                cut = cut.clip(normal=normal, origin=origin)
        yield cut


def draw(reference, deformed):
    """The picture, large."""
    plotter = pv.Plotter(window_size=(3000, 1800), off_screen=True)
    plotter.set_background("white")
    for at, cut in enumerate(cuts_of(deformed)):
        plotter.add_mesh(
            cut, scalars="scaled_jacobian", cmap="viridis", clim=(0.5, 1), show_edges=True,
            edge_color=EDGES, line_width=1.2, lighting=False, show_scalar_bar=at == 0,
            scalar_bar_args=dict(
                title="scaled Jacobian", position_x=0.58, position_y=0.16, width=0.3, height=0.07,
                title_font_size=44, label_font_size=38, n_labels=3, fmt="%.2f", color="black",
            ),
        )
    shading = dict(smooth_shading=True, split_sharp_edges=True)
    plotter.add_mesh(blade_of(deformed), color="#e3e6ea", specular=0.4, specular_power=20, **shading)
    plotter.add_mesh(blade_of(reference), color="#d8432b", opacity=0.22, **shading)
    plotter.camera_position = [(0.0, -2.9, 1.35), (3.2, 0, -0.05), (0, 0, 1)]
    plotter.camera.zoom(1.28)
    return Image.fromarray(plotter.screenshot(return_img=True)).convert("RGB")


def save(image, path):
    """Cuts the white margin off and keeps the file small."""
    white = Image.new("RGB", image.size, (255, 255, 255))
    left, top, right, bottom = ImageChops.difference(image, white).getbbox()
    image = image.crop((left, max(top - 30, 0), right, min(bottom + 30, image.height)))
    image = image.resize((1200, round(image.height * 1200 / image.width)), Image.LANCZOS)
    image.quantize(256, method=Image.FASTOCTREE, dither=Image.Dither.NONE).save(path, optimize=True)


def main():
    """Makes the mesh, moves it and draws it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--azimesh", default="target/release/azimesh")
    program = str(pathlib.Path(parser.parse_args().azimesh).resolve())
    pictures = pathlib.Path(__file__).resolve().parent.parent / "docs" / "pictures"
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        mesh = folder / "blade.vtu"
        size = ["--nodes", "200000", "--first-cell", "1e-3"]
        subprocess.run([program, "sample", "blade", *size, "-o", mesh], check=True)
        schedule = folder / "blade.toml"
        subprocess.run([program, "deform", mesh, schedule, "-o", folder / "out"], check=True)
        image = draw(pv.read(mesh), pv.read(folder / "out" / "blade_0027.vtu"))
        pictures.mkdir(exist_ok=True)
        save(image, pictures / "blade.png")


if __name__ == "__main__":
    main()

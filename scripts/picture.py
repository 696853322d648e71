"""Draws meshes side by side into a PNG, off screen.

    .venv/bin/python scripts/picture.py MESH... -o OUT.png [--colour quality|tag|zone]
        [--zoom XMIN XMAX YMIN YMAX] [--cut x|y|z[=POSITION]]

2D meshes are seen from +z; 3D ones are cut by a plane and seen along its normal, or, without a
cut, shown by their boundary from a corner.
"""

import argparse

import numpy as np
import pyvista

SOLIDS = {10, 12, 13, 14, 24, 25, 26, 27, 29, 32, 42}
PLANES = {5, 7, 9, 22, 23, 28}
VIEWS = {"x": "yz", "y": "xz", "z": "xy"}


def split(grid):
    """(cells of the mesh's own dimension, boundary cells)."""
    solid = np.isin(grid.celltypes, list(SOLIDS))
    plane = np.isin(grid.celltypes, list(PLANES))
    volume, boundary = (solid, plane) if solid.any() else (plane, ~plane)
    return grid.extract_cells(volume), grid.extract_cells(boundary), bool(solid.any())


def coloured(volume, boundary, colour):
    """The scalar array to colour by, put on the parts as "colour"."""
    if colour == "quality":
        quality = volume.cell_quality("scaled_jacobian")["scaled_jacobian"]
        volume.cell_data["colour"] = quality
    elif colour == "zone":
        volume.cell_data["colour"] = volume.cell_data["Zone"]
    if "BoundaryTag" in boundary.cell_data:
        boundary.cell_data["colour"] = boundary.cell_data["BoundaryTag"]


def cut(volume, plane):
    """The cells that a plane normal to an axis meets, whole."""
    axis, _, position = plane.partition("=")
    number = "xyz".index(axis)
    at = float(position) if position else volume.center[number]
    low, high = (np.array([c.bounds[2 * number + i] for c in volume.cell]) for i in (0, 1))
    return volume.extract_cells((low <= at) & (high > at)), VIEWS[axis]


def draw(plotter, path, options):
    """One mesh into the current subplot."""
    volume, boundary, solid = split(pyvista.read(path))
    coloured(volume, boundary, options.colour)
    shown, view = (volume, "xy")
    if solid and options.cut:
        shown, view = cut(volume, options.cut)
    elif solid:
        shown, view = boundary, "iso"
    scalars = "colour" if "colour" in shown.cell_data else None
    limits = [0.0, 1.0] if options.colour == "quality" and shown is not boundary else None
    title = "scaled Jacobian" if limits else options.colour
    plotter.add_mesh(
        shown, scalars=scalars, lighting=view == "iso", clim=limits, cmap="viridis", show_edges=True, line_width=0.5,
        scalar_bar_args={"title": title}, color=None if scalars else "lightgrey",
    )  # fmt: skip
    plotter.camera_position = view
    plotter.enable_parallel_projection()
    if options.zoom:
        xmin, xmax, ymin, ymax = options.zoom
        across = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}.get(view, (0, 1))
        focus = np.array(shown.center)
        focus[list(across)] = (xmin + xmax) / 2, (ymin + ymax) / 2
        away = np.array(plotter.camera.position) - plotter.camera.focal_point
        plotter.camera.focal_point, plotter.camera.position = focus, focus + away
        plotter.camera.parallel_scale = (ymax - ymin) / 2
    else:
        plotter.reset_camera()


def main():
    """Reads the arguments and writes the picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+", metavar="MESH")
    parser.add_argument("-o", "--output", required=True, metavar="PNG")
    parser.add_argument("--colour", choices=["quality", "tag", "zone"], default="quality")
    parser.add_argument("--zoom", nargs=4, type=float, metavar=("XMIN", "XMAX", "YMIN", "YMAX"))
    parser.add_argument("--cut", metavar="AXIS[=POSITION]")
    parser.add_argument("--size", nargs=2, type=int, default=[900, 800], help="pixels of one mesh")
    options = parser.parse_args()
    n_meshes = len(options.meshes)
    width, height = options.size
    plotter = pyvista.Plotter(off_screen=True, shape=(1, n_meshes), window_size=[width * n_meshes, height])
    for i, path in enumerate(options.meshes):
        plotter.subplot(0, i)
        draw(plotter, path, options)
    plotter.screenshot(options.output)


if __name__ == "__main__":
    main()

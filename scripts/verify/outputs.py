"""What `azimesh deform` leaves: steps.csv and the deformed meshes."""

import csv

import numpy as np
import pyvista

from program import azimesh


def deform(mesh, schedule, folder, expect=0):
    """Runs deform and returns the rows of steps.csv."""
    azimesh("deform", mesh, schedule, "-o", folder, expect=expect)
    return steps(folder)


def steps(folder):
    """Rows of steps.csv as dictionaries of text."""
    with open(folder / "steps.csv", newline="") as file:
        return list(csv.DictReader(file))


def points(folder, row):
    """Nodes of the mesh of one step."""
    return np.array(pyvista.read(folder / row["file"]).points)

"""What `azimesh deform` leaves: steps.csv, the deformed meshes, and all files by name."""

import csv

import numpy as np
import pyvista

from program import azimesh


def deform(mesh, schedule, folder, *more, expect=0):
    """Runs deform with more arguments and returns the rows of steps.csv."""
    azimesh("deform", mesh, schedule, "-o", folder, *more, expect=expect)
    return steps(folder)


def steps(folder):
    """Rows of steps.csv as dictionaries of text."""
    with open(folder / "steps.csv", newline="") as file:
        return list(csv.DictReader(file))


def points(folder, row):
    """Nodes of the mesh of one step."""
    return np.array(pyvista.read(folder / row["file"]).points)


def write_table(path, columns):
    """Writes columns of numbers by name as CSV."""
    rows = [",".join(repr(float(x)) for x in row) for row in zip(*columns.values(), strict=True)]
    path.write_text("\n".join([",".join(columns), *rows]) + "\n")


def tagged(mesh, *tags):
    """Nodes on some tags of a mesh, ascending."""
    return np.array(sorted({node for tag in tags for face in mesh.tags[tag] for node in face}), int)


def content(folder):
    """Files by name, without what tells of the single runs: seconds, and run.json. A case has an empty file of its name."""
    found = {}
    for path in sorted(path for path in folder.rglob("*") if path.is_file() and path.name != "run.json" and path.suffix != ".foam"):
        found[str(path.relative_to(folder))] = without_seconds(path) if path.name == "steps.csv" else path.read_bytes()
    return found


def without_seconds(path):
    """Rows of a table that is whole."""
    text = path.read_text()
    assert text.endswith("\n"), f"{path} is cut"
    rows = [line.split(",") for line in text.splitlines()]
    at = rows[0].index("seconds")
    return [row[:at] + row[at + 1 :] for row in rows]


def same(found, wanted, what, extra=False):
    """Names the first file that differs; with `extra` there may be more than is wanted. The number compared."""
    assert extra or found.keys() == wanted.keys(), f"{what}: {sorted(found.keys() ^ wanted.keys())}"
    for name, expected in wanted.items():
        assert found.get(name) == expected, f"{what}: {name} differs"
    return len(wanted)

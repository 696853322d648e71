"""UGRID files in plain numpy, after the description of UG_IO: an independent reader and writer.

<https://www.simcenter.msstate.edu/software/documentation/ug_io/3d_grid_file_type_ugrid.html>
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

# Cells in the order of the file: VTK cell type, nodes.
FACES = [(5, 3), (9, 4)]
SOLIDS = [(10, 4), (14, 5), (13, 6), (12, 8)]
# Position of UGRID's nodes of a pyramid in VTK's: its base is the quadrilateral 1 4 5 2, its apex 3.
PYRAMID = [1, 0, 4, 2, 3]
ORDERS = {"b": ">", "lb": "<", "r": ">", "lr": "<"}


@dataclass
class Ugrid:
    """Nodes, (VTK type, rows of nodes from 0 in VTK's order) and the number of each boundary face."""

    points: np.ndarray
    cells: list = field(default_factory=list)
    numbers: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    names: dict = field(default_factory=dict)


def flavour(path):
    """(letters, real bytes, integer bytes) of a name such as wing.lb8l.ugrid; None for text."""
    suffixes = Path(path).suffixes
    name = suffixes[-2][1:] if len(suffixes) > 1 else ""
    letters = name.rstrip("l").rstrip("48") if name != "l" else ""
    if letters not in ORDERS:
        return None
    return letters, int(name.rstrip("l")[-1]), 8 if name.endswith("l") else 4


def types(kind):
    """numpy types of reals and integers."""
    letters, real, integer = kind
    return f"{ORDERS[letters]}f{real}", f"{ORDERS[letters]}i{integer}"


def read(path):
    """A UGRID file of any flavour, with the .mapbc beside it."""
    kind = flavour(path)
    if kind is None:
        numbers = np.array(Path(path).read_text().split())
        take_at = 0

        def take(n, real=False):
            nonlocal take_at
            take_at += n
            return numbers[take_at - n : take_at].astype(float if real else int)
    else:
        data = Path(path).read_bytes()
        if kind[0] in ("r", "lr"):
            data = without_marks(data, ORDERS[kind[0]])
        real_type, integer_type = types(kind)

        def take(n, real=False):
            nonlocal data
            dtype = np.dtype(real_type if real else integer_type)
            values, data = np.frombuffer(data[: n * dtype.itemsize], dtype), data[n * dtype.itemsize :]
            return values.astype(float if real else int)

    counts = take(7)
    mesh = Ugrid(take(3 * counts[0], real=True).reshape(-1, 3))
    for (vtk, n), count in zip(FACES, counts[1:3]):
        mesh.cells.append((vtk, take(n * count).reshape(-1, n) - 1))
    mesh.numbers = take(counts[1] + counts[2])
    for (vtk, n), count in zip(SOLIDS, counts[3:]):
        rows = take(n * count).reshape(-1, n) - 1
        if vtk == 14:
            turned = np.empty_like(rows)
            turned[:, PYRAMID] = rows
            rows = turned
        mesh.cells.append((vtk, rows))
    mesh.names = read_names(path)
    return mesh


def without_marks(data, order):
    """Fortran records without the marks around them."""
    parts, at = [], 0
    while at < len(data):
        (length,) = np.frombuffer(data[at : at + 4], f"{order}i4")
        parts.append(data[at + 4 : at + 4 + length])
        (behind,) = np.frombuffer(data[at + 4 + length : at + 8 + length], f"{order}i4")
        assert behind == length, f"record mark {behind} behind {length} bytes"
        at += 8 + length
    return b"".join(parts)


def mapbc(path):
    """The .mapbc beside a mesh."""
    name = Path(path).name.removesuffix(".ugrid")
    if flavour(path):
        name = name.rpartition(".")[0]
    return Path(path).with_name(f"{name}.mapbc")


def read_names(path):
    """Face number: (condition, name) from the .mapbc, where there is one."""
    if not mapbc(path).exists():
        return {}
    first, *lines = mapbc(path).read_text().splitlines()
    rows = [line.split(maxsplit=2) for line in lines]
    assert int(first) == len(rows), f"{mapbc(path)}: {first} patches promised, {len(rows)} there"
    return {int(row[0]): (int(row[1]), row[2]) for row in rows}


def write(path, mesh):
    """Writes a mesh in the flavour that the name says, and its .mapbc."""
    kind = flavour(path)
    real_type, integer_type = types(kind) if kind else ("f8", "i8")
    rows_of = dict(mesh.cells)
    rows = [rows_of.get(vtk, np.zeros((0, n), int)) for vtk, n in FACES + SOLIDS]
    rows[3] = rows[3][:, PYRAMID]
    counts = np.array([len(mesh.points), *map(len, rows)], integer_type)
    integers = [np.asarray(part + 1, integer_type) for part in rows]
    integers.insert(2, np.asarray(mesh.numbers, integer_type).reshape(-1, 1))
    points = np.asarray(mesh.points, real_type)
    if kind is None:
        lines = [" ".join(map(str, counts))]
        lines += [" ".join(map(repr, map(float, point))) for point in points]
        lines += [" ".join(map(str, row)) for part in integers for row in part]
        Path(path).write_text("\n".join(lines) + "\n")
    else:
        records = [counts.tobytes(), b"".join(part.tobytes() for part in [points, *integers])]
        marks = [b"", b""]
        if kind[0] in ("r", "lr"):
            marks = [np.array(len(record), f"{ORDERS[kind[0]]}i4").tobytes() for record in records]
        Path(path).write_bytes(b"".join(mark + data + mark for mark, data in zip(marks, records)))
    if mesh.names:
        lines = [f"{number} {condition} {name}" for number, (condition, name) in mesh.names.items()]
        mapbc(path).write_text("\n".join([str(len(lines)), *lines]) + "\n")

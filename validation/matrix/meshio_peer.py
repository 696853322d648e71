"""Meshes as meshio reads them; the markers of SU2, which meshio only numbers, by their lines."""

import re

import meshio
import numpy as np
from meshio._vtk_common import meshio_to_vtk_order
from meshio.vtk._vtk_51 import meshio_to_vtk_type

from model import POLYHEDRON, DIMENSION, Block, Model


def read(path):
    mesh = meshio.read(path)
    points = np.asarray(mesh.points)
    if points.shape[1] < 3:
        points = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    model = Model(points, single=points.dtype == np.float32)
    physical = mesh.cell_data.get("gmsh:physical", [None] * len(mesh.cells))
    names = {(int(at[1]), int(at[0])): name for name, at in mesh.field_data.items()}
    first = 0
    for cells, numbers in zip(mesh.cells, physical):
        kind = meshio_to_vtk_type.get(cells.type)
        if kind is None or kind == POLYHEDRON:
            raise ValueError(f"meshio: cells of type {cells.type}")
        nodes = np.asarray(cells.data, dtype=np.int64)
        permutation = meshio_to_vtk_order(cells.type)
        if permutation is not None and not (kind == 13 and path.endswith((".msh", ".su2", ".e", ".exo", ".ex2"))):
            nodes = nodes[:, permutation]
        index = np.arange(first, first + len(nodes))
        model.blocks += pixels(kind, nodes, index)
        if numbers is not None:
            gather(model, DIMENSION.get(kind, 3), np.asarray(numbers).ravel(), index, names)
        first += len(nodes)
    return model.finish()


def gather(model, dimension, numbers, index, names):
    for number in np.unique(numbers[numbers != 0]).tolist():
        key = (dimension, names.get((dimension, number), str(number)), str(number))
        before = model.groups.get(key, np.array([], int))
        model.groups[key] = np.concatenate([before, index[numbers == number]])


def pixels(kind, nodes, index):
    if kind == 8:
        return [Block(9, nodes[:, [0, 1, 3, 2]], index)]
    if kind == 11:
        return [Block(12, nodes[:, [0, 1, 3, 2, 4, 5, 7, 6]], index)]
    return [Block(kind, nodes, index)]


def read_su2(path):
    """meshio's nodes and cells, or those of the text where meshio fails; markers from the text."""
    with open(path, errors="replace") as file:
        lines = [line.split("%")[0].strip() for line in file]
    starts = [i for i, line in enumerate(lines) if re.match(r"IZONE\s*=", line)]
    if len(starts) > 1:
        return of_zones([lines[i:j] for i, j in zip(starts, starts[1:] + [None])])
    try:
        model = read(path)
        model.groups = {}
    except (Exception, SystemExit) as error:
        model = of_lines(lines)
        model.remarks.append(f"meshio fails ({error}); compared with the lines themselves")
    return with_markers(model, lines)


def of_zones(zones):
    """All zones of a file by their lines, one after another; names of tags are not compared."""
    whole = Model(np.zeros((0, 3)))
    for lines in zones:
        zone = with_markers(of_lines(lines), lines)
        for block in zone.blocks:
            add(whole, block.kind, block.nodes + len(whole.points))
        whole.points = np.concatenate([whole.points, zone.points])
    whole.remarks.append("compared with the lines of its zones, names of tags apart")
    return whole.finish()


def with_markers(model, lines):
    whole = model.dimension()
    volume = [block for block in model.blocks if DIMENSION.get(block.kind, 3) == whole]
    model.blocks = []
    for block in volume:
        add(model, block.kind, block.nodes)
    for name, faces in markers(lines):
        parts = [add(model, kind, [face for face in faces if len(face) == size])
                 for size, kind in ((1, 1), (2, 3), (3, 5), (4, 9))]
        if any(map(len, parts)):
            model.groups[(whole - 1, name)] = np.concatenate(parts)
    return model.finish()


def add(model, kind, nodes):
    first = model.n_cells()
    index = np.arange(first, first + len(nodes))
    if len(nodes):
        model.blocks.append(Block(kind, np.array(nodes, dtype=np.int64), index))
    return index


SIZES = {1: 1, 3: 2, 5: 3, 9: 4, 10: 4, 12: 8, 13: 6, 14: 5}


def of_lines(lines):
    """Nodes and cells of a mesh of one zone."""
    at = {line.split("=")[0].strip(): i for i, line in enumerate(lines) if "=" in line}
    count = lambda key: int(lines[at[key]].split("=")[1].split()[0])
    rows = lambda key: [line.split() for line in lines[at[key] + 1:at[key] + 1 + count(key)]]
    dimension = count("NDIME")
    points = np.array([[float(x) for x in row[:dimension]] for row in rows("NPOIN")])
    model = Model(np.pad(points, ((0, 0), (0, 3 - dimension))))
    by_kind = {}
    for row in rows("NELEM"):
        kind = int(row[0])
        by_kind.setdefault(kind, []).append([int(word) for word in row[1:1 + SIZES[kind]]])
    for kind, nodes in sorted(by_kind.items()):
        add(model, kind, nodes)
    return model


def markers(lines):
    lines, name = iter(lines), None
    for line in lines:
        tag = re.match(r"MARKER_TAG\s*=\s*(\S+)", line)
        count = re.match(r"MARKER_ELEMS\s*=\s*(\d+)", line)
        if tag:
            name = tag.group(1)
        elif count and name and name != "SEND_RECEIVE":
            faces = []
            while len(faces) < int(count.group(1)):
                words = next(lines).split()
                if words and "=" not in words[0]:
                    faces.append([int(word) for word in words[1:1 + SIZES[int(words[0])]]])
            yield name, faces

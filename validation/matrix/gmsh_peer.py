"""Meshes as gmsh's own API reads them."""

import functools

import gmsh
import numpy as np
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid

from model import Block, Model

# VTK's kind of gmsh's families of elements: first and second order, then Lagrange cells
KINDS = {15: 1, 1: 3, 2: 5, 3: 9, 4: 10, 5: 12, 6: 13, 7: 14, 8: 21, 9: 22, 10: 28, 11: 24, 12: 29,
         13: 32, 16: 23, 17: 25, 18: 26, 19: 27}
LAGRANGE = {"Line": 68, "Triangle": 69, "Quadrilateral": 70, "Tetrahedron": 71, "Hexahedron": 72,
            "Prism": 73, "Pyramid": 74}


def read(path):
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.logger.start()
        before = len(gmsh.logger.get())
        gmsh.open(path)
        errors = [line for line in gmsh.logger.get()[before:] if line.startswith("Error")]
        if errors:
            raise ValueError(f"gmsh: {errors[0].split(':', 1)[1].strip()}")
        return model_of()
    finally:
        gmsh.finalize()


def model_of():
    tags, xyz, _ = gmsh.model.mesh.getNodes(includeBoundary=False)
    order = np.argsort(tags, kind="stable")
    tags = np.asarray(tags)[order].astype(np.int64)
    model = Model(np.asarray(xyz).reshape(-1, 3)[order])
    tags, first = np.unique(tags, return_index=True)
    model.points = model.points[first]
    at = np.zeros(int(tags.max()) + 1 if len(tags) else 1, dtype=np.int64)
    at[tags] = np.arange(len(tags))
    n_cells, of_entity = 0, {}
    for entity in gmsh.model.getEntities():
        start = n_cells
        types, _, nodes = gmsh.model.mesh.getElements(*entity)
        for kind, numbers in zip(types, nodes):
            block = block_of(int(kind), at[np.asarray(numbers, dtype=np.int64)], n_cells)
            model.blocks.append(block)
            n_cells += len(block.nodes)
        of_entity[entity] = np.arange(start, n_cells)
    for dimension, tag in gmsh.model.getPhysicalGroups():
        name = gmsh.model.getPhysicalName(dimension, tag) or str(tag)
        entities = gmsh.model.getEntitiesForPhysicalGroup(dimension, tag)
        cells = [of_entity.get((dimension, int(entity)), np.array([], int)) for entity in entities]
        model.groups[(dimension, name, str(tag))] = np.concatenate(cells)
    return model.finish()


def block_of(kind, nodes, first):
    name, _, _, n_nodes, _, _ = gmsh.model.mesh.getElementProperties(kind)
    vtk_kind = KINDS.get(kind) or LAGRANGE.get(name.split()[0])
    if vtk_kind is None:
        raise ValueError(f"gmsh: element type {kind} ({name}) has no VTK cell")
    nodes = nodes.reshape(-1, n_nodes)
    permutation = order_of(kind, vtk_kind, n_nodes)
    ordered = permutation is not None
    if ordered:
        nodes = nodes[:, permutation]
    return Block(vtk_kind, nodes, np.arange(first, first + len(nodes)), ordered)


@functools.cache
def order_of(kind, vtk_kind, n_nodes):
    """Node i of VTK is node order[i] of gmsh, found by the nodes' places in the reference cell."""
    _, dimension, order, _, local, _ = gmsh.model.mesh.getElementProperties(kind)
    if order == 1 or dimension == 0:
        return list(range(n_nodes))
    own = np.zeros((n_nodes, 3))
    own[:, :dimension] = np.asarray(local).reshape(n_nodes, dimension)
    if vtk_kind in (21, 28, 29, 23, 25, 68, 70, 72):
        own[:, :dimension] = (own[:, :dimension] + 1) / 2
    elif vtk_kind in (26, 32, 73):
        own[:, 2] = (own[:, 2] + 1) / 2
    elif vtk_kind == 27:
        own[:, :2] = own[:, :2] / (2 * np.maximum(1 - own[:, 2:], 1e-9)) + 0.5
        own[own[:, 2] > 1 - 1e-9, :2] = 0.5
    places = vtk_places(vtk_kind, n_nodes)
    if places is None:
        return None
    if vtk_kind == 27:  # VTK's middles of the rising edges, in a pyramid that does not taper
        places = places.copy()
        rising = (places[:, 2] > 0.1) & (places[:, 2] < 0.9)
        places[rising, :2] = np.rint(places[rising, :2])
        own[(own[:, 2] > 0.1) & (own[:, 2] < 0.9), :2] = np.rint(
            own[(own[:, 2] > 0.1) & (own[:, 2] < 0.9), :2])
    distance = np.abs(places[:, None, :] - own[None, :, :]).max(axis=2)
    found = distance.argmin(axis=1)
    if distance.min(axis=1).max() > 1e-6 or len(set(found.tolist())) != n_nodes:
        return None
    return found.tolist()


def vtk_places(kind, n_nodes):
    if kind == 74:  # VTK has the number but no cell for it
        return None
    grid, points = vtkUnstructuredGrid(), vtkPoints()
    points.SetNumberOfPoints(n_nodes)
    for node in range(n_nodes):
        points.SetPoint(node, 0, 0, 0)
    grid.SetPoints(points)
    grid.InsertNextCell(kind, n_nodes, list(range(n_nodes)))
    places = grid.GetCell(0).GetParametricCoords()
    return None if places is None else np.array(places).reshape(n_nodes, 3)

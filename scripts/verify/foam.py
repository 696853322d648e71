"""OpenFOAM cases as VTK's reader has them, and their comparison with what azimesh reads.

VTK's reader has points in 32 bits; those in 64 bits are read here from the file.
"""

import gzip
import re

import numpy as np
import pyvista
from vtkmodules.vtkCommonCore import vtkIdList
from vtkmodules.vtkIOParallel import vtkPOpenFOAMReader

from program import azimesh

# Faces of VTK's cells by their corners.
FACES = {
    10: [(0, 1, 3), (1, 2, 3), (2, 0, 3), (0, 2, 1)],
    12: [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)],
    13: [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)],
    14: [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
}


def by_vtk(case, time=None, region=None, long_labels=False, float_scalars=False):
    """The blocks of VTK's reader: the mesh, patches and cell zones. It is told the widths of binary numbers."""
    marker = case / "mesh.foam"
    there = marker.exists()
    if not there:
        marker.touch()
    try:
        reader = vtkPOpenFOAMReader()
        reader.SetFileName(str(marker))
        reader.SetCaseType(vtkPOpenFOAMReader.RECONSTRUCTED_CASE)
        reader.SetUse64BitLabels(long_labels)
        reader.SetUse64BitFloats(not float_scalars)
        reader.SkipZeroTimeOff()
        reader.ListTimeStepsByControlDictOff()
        reader.ReadZonesOn()
        reader.CacheMeshOff()
        reader.UpdateInformation()
        for chosen in ("Cell", "Point", "Lagrangian"):
            getattr(reader, f"DisableAll{chosen}Arrays")()
        for i in range(reader.GetNumberOfPatchArrays()):
            chosen = reader.GetPatchArrayName(i)
            reader.SetPatchArrayStatus(chosen, int("Zone" not in chosen or "cellZone" in chosen))
        if time is not None:
            reader.SetTimeValue(time)
        reader.Update()
        found = dict(blocks(pyvista.wrap(reader.GetOutput())))
        # A case with regions has their names before all others.
        own = f"{region or 'defaultRegion'}/"
        of_region = {name[len(own) :]: block for name, block in found.items() if name.startswith(own)}
        return of_region or found
    finally:
        if not there:
            marker.unlink()


def points_in(path, float_scalars=False):
    """The points in a file, in 64 bits."""
    packed = path.with_name(path.name + ".gz")
    data = path.read_bytes() if path.exists() else gzip.decompress(packed.read_bytes())
    start = re.search(rb"\n\s*(\d+)\s*\(", data)
    n, body = int(start[1]), data[start.end() :]
    if re.search(rb"format\s+binary", data[: start.start()]):
        return np.frombuffer(body, "<f4" if float_scalars else "<f8", 3 * n).reshape(n, 3).astype(float)
    numbers = body[: body.rindex(b")")].replace(b"(", b" ").replace(b")", b" ").split()
    return np.array(numbers[: 3 * n], float).reshape(n, 3)


def blocks(found, prefix=""):
    """Every block that is no list of blocks, by its names."""
    for i in range(found.n_blocks):
        block, name = found[i], f"{prefix}{found.get_block_name(i)}"
        if isinstance(block, pyvista.MultiBlock):
            yield from blocks(block, f"{name}/")
        elif block is not None:
            yield name, block


def cell_faces(grid):
    """For each cell the set of its faces, each the set of its nodes."""
    ids, cells = vtkIdList(), []
    for i in range(grid.n_cells):
        kind = grid.GetCellType(i)
        if kind == 42:
            grid.GetFaceStream(i, ids)
            stream = [ids.GetId(k) for k in range(ids.GetNumberOfIds())]
            faces, at = [], 1
            for _ in range(stream[0]):
                faces.append(frozenset(stream[at + 1 : at + 1 + stream[at]]))
                at += 1 + stream[at]
        else:
            grid.GetCellPoints(i, ids)
            nodes = [ids.GetId(k) for k in range(ids.GetNumberOfIds())]
            faces = [frozenset(nodes[k] for k in face) for face in FACES[kind]]
        cells.append(frozenset(faces))
    return cells


def face_places(grid, chosen=None):
    """The faces of a surface by the places of their nodes, sorted."""
    points, faces = grid.points.astype(np.float32).tolist(), []
    ids = vtkIdList()
    for i in range(grid.n_cells) if chosen is None else chosen:
        grid.GetCellPoints(int(i), ids)
        faces.append(tuple(sorted(tuple(points[ids.GetId(k)]) for k in range(ids.GetNumberOfIds()))))
    return sorted(faces)


def by_azimesh(path, out, step=None):
    """The mesh as azimesh reads it: the grid, its cells that are volumes, faces by tag, cells by zone."""
    chosen = [] if step is None else ["--step", step]
    azimesh("convert", path, out, "--force", *chosen)
    grid = pyvista.read(out)
    names = [str(name) for name in grid.field_data.get("BoundaryTagNames", [])]
    tags = {name: np.flatnonzero(grid.cell_data["BoundaryTag"] == i + 1) for i, name in enumerate(names)}
    zones = [str(name) for name in grid.field_data.get("ZoneNames", [])]
    zones = {name: np.flatnonzero(grid.cell_data["Zone"] == i + 1) for i, name in enumerate(zones)}
    volume = np.flatnonzero(np.isin(grid.celltypes, [10, 12, 13, 14, 42]))
    return grid, volume, tags, zones


def compare(case, path, out, step=None, points=None, **told):
    """Compares a mesh node by node to the bit, cell by cell, face by face of each patch; gives what was compared.

    `points` is the file of the points, where it is not that of the case.
    """
    found = by_vtk(case, **told)
    internal = found["internalMesh"]
    grid, volume, tags, zones = by_azimesh(path, out, step)
    expected = points_in(points or case / "constant/polyMesh/points", told.get("float_scalars", False))
    assert np.array_equal(grid.points, expected), f"{path}: points differ"
    assert np.array_equal(expected.astype(np.float32), internal.points), f"{path}: points differ from VTK's"
    ours = grid.extract_cells(volume) if len(volume) < grid.n_cells else grid
    assert np.array_equal(volume, np.arange(len(volume))), f"{path}: cells come first"
    assert internal.n_cells == len(volume), f"{path}: {len(volume)} cells, not {internal.n_cells}"
    by_node = np.asarray(ours.point_data.get("vtkOriginalPointIds", np.arange(ours.n_points)))
    theirs = cell_faces(internal)
    for i, faces in enumerate(cell_faces(ours)):
        faces = frozenset(frozenset(int(by_node[n]) for n in face) for face in faces)
        assert faces == theirs[i], f"{path}: cell {i} differs"
    kinds = {int(kind): int(n) for kind, n in zip(*np.unique(internal.celltypes, return_counts=True))}
    own = {int(kind): int(n) for kind, n in zip(*np.unique(ours.celltypes, return_counts=True))}
    n_faces = 0
    for name, block in found.items():
        parts = name.split("/")
        if "boundary" in parts[:-1] and block.n_cells > 0:
            assert face_places(block) == face_places(grid, tags[parts[-1]]), f"{path}: patch {parts[-1]} differs"
            n_faces += block.n_cells
        if "cellZones" in parts[:-1]:
            zone = grid.extract_cells(zones[parts[-1]])
            assert zone.n_cells == block.n_cells, f"{path}: zone {parts[-1]} differs"
            # VTK takes each label of 64 bits in a zone for two of 32.
            is_same = told.get("long_labels") or face_places(zone) == face_places(block)
            assert is_same, f"{path}: zone {parts[-1]} differs"
    assert n_faces == grid.n_cells - len(volume), f"{path}: {n_faces} faces on patches"
    return {"points": grid.n_points, "cells": len(volume), "faces": n_faces, "vtk": kinds, "azimesh": own, "tags": len(tags), "zones": len(zones)}

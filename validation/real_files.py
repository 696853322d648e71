"""Meshes of other projects as azimesh reads them, beside Gmsh, VTK and meshio.

    .venv/bin/python validation/real_files.py [FOLDER] [PART OF A PATH]

FOLDER is AZIMESH_TESTDATA where it is left out. Every mesh is converted to VTU, which VTK reads; each peer reads the file itself,
in a process of its own, since some crash. Compared are the positions of the nodes of cells to the bit, every cell by its corners in order and its other
nodes, groups by their names, and arrays. A line a file: what azimesh and every peer make of it. It ends with 1 where all peers that read a file
differ, or where one reads what azimesh refuses, unless KNOWN has the reason.
"""

import gzip
import multiprocessing
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.append(str(ROOT / "scripts" / "verify"))
AZIMESH = os.environ.get("AZIMESH", str(ROOT / "target/release/azimesh"))
LIMIT_S = 120
PEERS = {
    ".msh": ["gmsh", "meshio"], ".cgns": ["gmsh", "vtk"], ".su2": ["meshio"], ".ugrid": ["meshio"], ".mesh": ["gmsh", "meshio"], ".inp": ["meshio"],
    ".vtk": ["vtk", "meshio"], ".vtu": ["vtk", "meshio"], ".pvtu": ["vtk"], ".vtkhdf": ["vtk"], ".foam": ["vtk"], ".cas": ["vtk"],
    **dict.fromkeys([".e", ".exo", ".ex2", ".g"], ["vtk", "meshio"]), **dict.fromkeys([".xyz", ".p3d"], ["vtk"]),
}  # fmt: skip
CORNERS = {
    1: 1, 3: 2, 5: 3, 9: 4, 10: 4, 12: 8, 13: 6, 14: 5, 15: 10, 16: 12, 21: 2, 22: 3, 23: 4, 24: 4, 25: 8, 26: 6, 27: 5, 28: 4, 29: 8, 30: 4, 31: 6, 32: 6,
    33: 8, 34: 3, 35: 2, 37: 5, 68: 2, 69: 3, 70: 4, 71: 4, 72: 8, 73: 6, 74: 5, 75: 2, 76: 3, 77: 4, 78: 4, 79: 8, 80: 6,
}  # fmt: skip
PLANE = {5, 7, 9, 22, 23, 28, 30, 34, 36, 69, 70, 76, 77}
LINES = {3, 21, 35, 68, 75}
WEDGES = {13, 26, 32, 73}
# Part of the path: why azimesh is right where every peer gives something else, or refuses what one reads.
KNOWN = {
    "io_msh/MSub": "MSH 3 is not read; gmsh writes it as MSH 4.1",
    "testhybrid2.msh": "its triangles are numbered as quadrilaterals; meshio makes cells of what follows",
    "bike_original.obj_curved.msh": "it mixes triangles of first and third order, of which gmsh keeps the corners only",
    "misc/partitions.msh": "its nodes are numbered from 0, which meshio takes for the last one",
    "meshes/cow.msh": "its nodes are numbered from 0; gmsh keeps three of them and meshio takes 0 for the last one",
}


@dataclass
class Reading:
    """A mesh: nodes, (VTK type, rows of nodes, numbers of the cells), polyhedra as sets of faces, groups as (dimension, name) to cells, arrays."""

    points: np.ndarray
    blocks: list = field(default_factory=list)
    polyhedra: list = field(default_factory=list)
    groups: dict = field(default_factory=dict)
    arrays: dict = field(default_factory=dict)
    is_ordered: bool = True  # whether the corners of a cell are in the order of VTK

    def dimension(self):
        return 3 if self.polyhedra else max((dimension_of(kind) for kind, rows, _ in self.blocks if len(rows)), default=0)

    def used(self):
        parts = [rows.ravel() for _, rows, _ in self.blocks] + [np.array(list(face)) for cell in self.polyhedra for face in cell]
        return np.unique(np.concatenate(parts)) if parts else np.array([], int)


def dimension_of(kind):
    """Of a VTK cell type."""
    return 0 if kind == 1 else 1 if kind in LINES else 2 if kind in PLANE else 3


def by_vtk(path, ours=False):
    """Through the reader that pyvista has for the ending; blocks of a file follow one another, and name groups."""
    import pyvista
    from foam import blocks

    is_fluent = path.endswith(".msh") or ".cas" in path
    found = pyvista.FluentReader(path).read() if is_fluent else pyvista.read(path)
    # VTK's reader puts cells of Fluent together in an order of its own.
    whole, first = Reading(np.zeros((0, 3)), is_ordered=not is_fluent), 0
    parts = [(name.split("/")[-1], part) for name, part in blocks(found) if part.n_cells] if isinstance(found, pyvista.MultiBlock) else [(None, found)]
    for name, part in parts:
        grid = part.cast_to_unstructured_grid()
        cells, nodes = np.arange(first, first + grid.n_cells), len(whole.points)
        add(whole, grid, nodes, first)
        whole.points = np.concatenate([whole.points, np.asarray(grid.points, grid.points.dtype)]) if nodes else np.asarray(grid.points)
        if name is not None and grid.n_cells:
            whole.groups[max(dimension_of(int(kind)) for kind in np.unique(grid.celltypes)), name] = cells
        first += grid.n_cells
    if isinstance(found, pyvista.UnstructuredGrid):
        whole.arrays = {f"{at} {name}": np.asarray(values) for at in ("point", "cell") for name, values in getattr(found, f"{at}_data").items()}
        if ours:
            for array in ("BoundaryTag", "Zone"):
                named(whole, found, array)
    return whole


def add(whole, grid, shift, first):
    """Cells of a grid of VTK; strips and the like in parts, pixels and voxels turned."""
    sizes = np.diff(grid.cell_offsets)
    for kind, size in set(zip(grid.celltypes.tolist(), sizes.tolist())):
        index = np.flatnonzero((grid.celltypes == kind) & (sizes == size))
        rows = grid.cell_connectivity[grid.cell_offsets[index][:, None] + np.arange(size)] + shift
        if kind == 42:
            whole.polyhedra += [frozenset(frozenset(n + shift for n in face.point_ids) for face in grid.get_cell(int(i)).faces) for i in index]
        elif kind in (8, 11):
            rows = rows[:, [0, 1, 3, 2, 4, 5, 7, 6][:size]]
            whole.blocks.append((9 if kind == 8 else 12, rows, index + first))
        elif kind in (2, 4, 6):
            part = {2: 1, 4: 2, 6: 3}[kind]
            for i in range(size - part + 1):
                turned = [i + 1, i, i + 2] if part == 3 and i % 2 else list(range(i, i + part))
                whole.blocks.append(({1: 1, 2: 3, 3: 5}[part], rows[:, turned], index + first))
        elif kind:
            whole.blocks.append((kind, rows, index + first))


def named(whole, grid, array):
    """Groups of a VTU of azimesh, of the dimension that the array is for."""
    dimension = whole.dimension() - (array == "BoundaryTag")
    own = np.isin(grid.celltypes, [kind for kind in np.unique(grid.celltypes) if dimension_of(int(kind)) == dimension])
    names = list(map(str, grid.field_data.get(f"{array}Names", [])))
    values = np.asarray(grid.cell_data[array]) if array in grid.cell_data else np.zeros(grid.n_cells, int)
    for value in np.unique(values[own & (values > 0)]):
        whole.groups[dimension, names[value - 1] if value <= len(names) else str(value)] = np.flatnonzero(own & (values == value))


def by_meshio(path):
    """meshio's cells in the order of VTK; the names of SU2's markers from the lines, since meshio numbers them."""
    import meshio
    from meshio._vtk_common import meshio_to_vtk_order, meshio_to_vtk_type

    mesh = meshio.read(path)
    whole, first = Reading(np.pad(mesh.points, ((0, 0), (0, 3 - mesh.points.shape[1])))), 0
    is_su2 = path.endswith(".su2")
    names = {(int(at[1]), int(at[0])): name for name, at in mesh.field_data.items()}
    if is_su2:
        names, number = {}, 0
        for name in re.findall(r"^\s*MARKER_TAG\s*=\s*(\S+)", Path(path).read_text(errors="replace"), re.M):
            number = int(name) if name.isdigit() else number + 1
            names[number] = name
    numbers = mesh.cell_data.get("su2:tag" if is_su2 else "gmsh:physical", [None] * len(mesh.cells))
    top = max(block.dim for block in mesh.cells)
    for block, tags in zip(mesh.cells, numbers):
        kind, rows = meshio_to_vtk_type[block.type], np.asarray(block.data, int)
        order = meshio_to_vtk_order(block.type)
        index = np.arange(first, first + len(rows))
        whole.blocks.append((kind, rows if order is None else rows[:, order], index))
        first += len(rows)
        for tag in [] if tags is None or is_su2 and block.dim == top else np.unique(tags[tags > 0]).tolist():
            key = block.dim, names.get(tag if is_su2 else (block.dim, tag), str(tag))
            whole.groups[key] = np.concatenate([whole.groups.get(key, np.array([], int)), index[tags == tag]])
    return whole


def by_gmsh(path):
    """Gmsh's own model; groups are its physical groups."""
    import gmsh
    from meshes import VTK_OF_GMSH, quiet_gmsh

    lagrange = {"Line": 68, "Triangle": 69, "Quadrilateral": 70, "Tetrahedron": 71, "Hexahedron": 72, "Prism": 73, "Pyramid": 74}
    with quiet_gmsh():
        gmsh.open(path)
        tags, xyz, _ = gmsh.model.mesh.getNodes()
        tags, at = np.unique(tags, return_index=True)
        whole, of_entity, first = Reading(xyz.reshape(-1, 3)[at]), {}, 0
        for entity in gmsh.model.getEntities():
            start = first
            for kind, elements, nodes in zip(*gmsh.model.mesh.getElements(*entity)):
                name = gmsh.model.mesh.getElementProperties(kind)[0].split()[0]
                rows = np.searchsorted(tags, nodes).reshape(len(elements), -1)
                whole.blocks.append((VTK_OF_GMSH.get(int(kind)) or lagrange[name], rows, np.arange(first, first + len(rows))))
                first += len(rows)
            of_entity[entity] = np.arange(start, first)
        for dimension, tag in gmsh.model.getPhysicalGroups():
            members = [of_entity[dimension, int(entity)] for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag)]
            whole.groups[dimension, gmsh.model.getPhysicalName(dimension, tag) or str(tag)] = np.concatenate(members)
    return whole


READERS = {"vtk": by_vtk, "meshio": by_meshio, "gmsh": by_gmsh}


def cells_of(mesh, place, least, is_ordered):
    """Cells as a set: type, corners in order, the other nodes; wedges, whose order has two ways round, by their nodes."""
    found = set()
    for kind, rows, _ in mesh.blocks:
        if dimension_of(kind) < least:
            continue
        rows = place[rows]
        n = 0 if kind in WEDGES or not is_ordered else CORNERS.get(kind, rows.shape[1])
        found.update((kind, *corners, *sorted(others)) for corners, others in zip(rows[:, :n].tolist(), rows[:, n:].tolist()))
    return found


def faces_of(mesh, place, chosen):
    """The cells of a group by their corners, in any order."""
    found = set()
    for kind, rows, index in mesh.blocks:
        corners = place[rows[np.isin(index, chosen), : CORNERS.get(kind, rows.shape[1])]]
        found.update(frozenset(row) for row in corners.tolist())
    return found


def differences(ours, theirs):
    """Sentences on what differs."""
    if ours.dimension() != theirs.dimension():
        return [f"dimension {ours.dimension()}, not {theirs.dimension()}"]
    clouds = [np.asarray(mesh.points, float).reshape(-1, 3) + 0.0 for mesh in (ours, theirs)]
    if theirs.points.dtype == np.float32:
        clouds = [cloud.astype(np.float32).astype(float) for cloud in clouds]
    _, number = np.unique(np.concatenate(clouds).view("V24").ravel(), return_inverse=True)
    places = np.split(number.ravel(), [len(clouds[0])])
    used = [set(place[mesh.used()].tolist()) for place, mesh in zip(places, (ours, theirs))]
    wrong = [f"{len(used[0] ^ used[1])} of {len(used[1])} positions"] if used[0] != used[1] else []
    # Programs keep faces that bound no more than a cell, or leave them out: those in groups are compared with these.
    cells = [cells_of(mesh, place, ours.dimension(), theirs.is_ordered) for mesh, place in zip((ours, theirs), places)]
    wrong += [f"{len(cells[0] ^ cells[1])} of {len(cells[1])} cells"] if cells[0] != cells[1] else []
    solids = [{frozenset(frozenset(place[list(face)].tolist()) for face in cell) for cell in mesh.polyhedra} for mesh, place in zip((ours, theirs), places)]
    wrong += [f"{len(solids[0] ^ solids[1])} of {len(solids[1])} polyhedra"] if solids[0] != solids[1] else []
    for key in theirs.groups.keys() & ours.groups.keys():
        members = [faces_of(mesh, place, mesh.groups[key]) for mesh, place in zip((ours, theirs), places)]
        wrong += [f"{len(members[0] ^ members[1])} of {len(members[1])} cells of {key[1]!r}"] if members[0] != members[1] else []
    for name, values in theirs.arrays.items():
        own = ours.arrays.get(name)
        if own is not None and own.shape == values.shape and own.dtype.kind == "f" and not np.array_equal(own, values, equal_nan=True):
            wrong.append(f"the values of {name}")
    return wrong


def compared(peer, path, ours, out):
    """What a peer makes of a file; runs in a process of its own."""
    sys.stdout = open(os.devnull, "w")
    try:
        theirs = READERS[peer](path)
        if not len(theirs.used()):
            out.put(("fails", "no cells"))
        else:
            wrong = differences(by_vtk(ours, ours=True), theirs) if ours else []
            out.put(("differs", "; ".join(wrong)) if wrong else ("same" if ours else "reads it", ""))
    except (Exception, SystemExit) as error:
        out.put(("fails", " ".join(str(error).split())[:100] or type(error).__name__))


def asked(*arguments):
    """The same, whatever becomes of the process."""
    out = multiprocessing.get_context("spawn").Queue()
    process = multiprocessing.get_context("spawn").Process(target=compared, args=(*arguments, out), daemon=True)
    process.start()
    try:
        while process.is_alive() and out.empty():
            process.join(0.05)
        return out.get(timeout=1)
    except Exception:
        return "fails", f"ends with {process.exitcode}"
    finally:
        process.kill()


def judge(path, name):
    """(whether it is right, what was said) of one file."""
    with tempfile.TemporaryDirectory() as scratch:
        plain = Path(scratch) / path.name.removesuffix(".gz")
        if path.suffix == ".gz":
            plain.write_bytes(gzip.decompress(path.read_bytes()))
        plain = plain if path.suffix == ".gz" else path
        ours = f"{scratch}/ours.vtu"
        done = subprocess.run([AZIMESH, "-q", "convert", path, ours, "--force"], capture_output=True, text=True, errors="replace", timeout=LIMIT_S)
        refused = done.returncode == 2
        if done.returncode not in (0, 2):
            return False, f"azimesh ends with {done.returncode}: {done.stderr[-200:]}"
        # Fluent's meshes have the ending of Gmsh's.
        peers = ["vtk"] if plain.read_bytes()[:1] == b"(" else PEERS[plain.suffix]
        found = {peer: asked(peer, str(plain), None if refused else ours) for peer in peers}
    verdicts = [verdict for verdict, _ in found.values()]
    why = next((why for part, why in KNOWN.items() if part in name), None)
    right = "reads it" not in verdicts if refused else "same" in verdicts or "differs" not in verdicts
    said = [done.stderr.strip().splitlines()[-1].replace(str(path), "")] if refused else []
    said += [f"{peer} {verdict}{': ' * bool(words)}{words}" for peer, (verdict, words) in found.items()] + [why] * bool(why)
    return right or bool(why), ("refused: " if refused else "read: ") + "; ".join(said)


def main():
    """A line a file, and the sums."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ["AZIMESH_TESTDATA"])
    part = sys.argv[2] if len(sys.argv) > 2 else ""
    files = [path for path in sorted(folder.rglob("*")) if path.name.removesuffix(".gz").endswith(tuple(PEERS)) and path.is_file()]
    files = [path for path in files if part in str(path.relative_to(folder))]
    names = [str(path.relative_to(folder)) for path in files]
    sums = Counter()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, (right, said) in zip(names, pool.map(judge, files, names)):
            sums[said.split(":")[0] if right else "WRONG"] += 1
            print(f"{name}\t{'' if right else 'WRONG: '}{said}", flush=True)
    print(f"{len(files)} files: {dict(sums)}", file=sys.stderr)
    return bool(sums["WRONG"])


if __name__ == "__main__":
    sys.exit(main())

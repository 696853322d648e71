"""Files of Fluent by others: read by azimesh, and compared with VTK's readers, with the sections of the file itself, and with OpenFOAM's converter.

    python validation/matrix_fluent.py FOLDER --azimesh target/release/azimesh -o docs/matrix_fluent.md

FOLDER holds the files, below a folder for each repository (owner__name). The mesh that azimesh writes as VTU is compared
- with VTK (`vtkFLUENTReader`, `vtkFLUENTCFFReader`): nodes to the bit, cells as sets of nodes, zone by zone, polyhedra by their faces;
- with the file, whose sections (or HDF5 datasets) are read here again: nodes to the bit, each boundary zone by its name, face by face as sets of nodes, and the
  number of cells of each zone;
- with OpenFOAM's `fluent3DMeshToFoam`, for solid meshes in text, where it is installed: `azimesh diff --match position`.
"""

import argparse
import gzip
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter

import h5py
import numpy as np
import pyvista
import vtk

HEAD = """# Every Fluent file

Files of {n} public repositories, each read by azimesh and compared with VTK's readers (nodes to the bit, cells of each zone as sets of nodes,
polyhedra face by face; VTK has nodes in 32 bits), with the sections of the file as the script reads them (nodes to the bit, each boundary zone by its name and face by face, cells
by zone), and with the mesh that OpenFOAM's `fluent3DMeshToFoam` (v1912) makes of solid meshes in text (by `azimesh diff --match position`: nodes, cells, tags).
`python validation/matrix_fluent.py` makes this page from a folder of the files, which are not part of the project.

| file | stored as | nodes | cells | zones, tags | VTK | the file | OpenFOAM | notes |
|---|---|---|---|---|---|---|---|---|
"""
INTERIOR, PARENT, OVERLAP = 2, 31, 1000
ETC = pathlib.Path("/usr/share/openfoam/etc/bashrc")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--azimesh", default="target/release/azimesh")
    arguments.add_argument("--only", default="")
    arguments.add_argument("-o", "--output", type=pathlib.Path)
    asked = arguments.parse_args()
    files = sorted(path for path in asked.folder.rglob("*") if path.is_file() and asked.only in str(path))
    rows = []
    for path in files:
        rows.append(row(path, asked.folder, pathlib.Path(asked.azimesh).resolve()))
        print(rows[-1], flush=True)
    if asked.output:
        n = len({path.relative_to(asked.folder).parts[0] for path in files})
        asked.output.write_text(HEAD.format(n=n) + "".join(f"{line}\n" for line in rows))
    sys.exit(any("**wrong**" in line for line in rows))


def row(path, folder, azimesh):
    name = str(path.relative_to(folder))
    with tempfile.TemporaryDirectory() as scratch:
        ours = pathlib.Path(scratch) / "ours.vtu"
        run = subprocess.run([azimesh, "convert", path, ours], capture_output=True, text=True)
        told = [line.replace(f"{path}: ", "").removeprefix("note: ") for line in run.stderr.splitlines() if str(ours) not in line]
        stated = Stated(path)
        if run.returncode:
            return f"| {name} | {stated.how} | | | | | | | refused: {' '.join(told)} |".replace(str(path), path.name)
        mesh = Ours(ours)
        tags = f"{len(mesh.zones)}, {len(mesh.tags)}"
        kinds = ", ".join(f"{n:,} {kind}" for kind, n in sorted(mesh.kinds.items()))
        answers = [answer(by_vtk, mesh, path, scratch), answer(by_file, mesh, stated), answer(by_openfoam, stated, path, azimesh, scratch)]
        told = "; ".join(note for note in told if "types of boundary conditions" not in note)
        return f"| {name} | {stated.how} | {len(mesh.points):,} | {kinds} | {tags} | {' | '.join(answers)} | {told} |"


def answer(compare, *arguments):
    try:
        return compare(*arguments)
    except AssertionError as error:
        return f"**wrong**: {error}"


class Ours:
    """What azimesh has read."""

    def __init__(self, path):
        grid = pyvista.read(path)
        self.points = np.asarray(grid.points)
        dimension = max(vtk.vtkCellTypeUtilities.GetDimension(int(kind)) for kind in set(grid.celltypes))
        names = lambda key: [str(name) for name in grid.field_data[key]] if key in grid.field_data else []
        numbers = lambda key: np.asarray(grid.cell_data[key]) if key in grid.cell_data else np.zeros(grid.n_cells, int)
        tag, zone = numbers("BoundaryTag"), numbers("Zone")
        tags, zones = names("BoundaryTagNames"), names("ZoneNames")
        self.tags = {name: [] for name in tags}
        self.zones = {name: Counter() for name in zones}
        self.kinds = Counter()
        for cell, kind in enumerate(grid.celltypes):
            if vtk.vtkCellTypeUtilities.GetDimension(int(kind)) == dimension:
                self.kinds[vtk.vtkCellTypeUtilities.GetClassNameFromTypeId(int(kind)).removeprefix("vtk").lower()] += 1
                self.zones[zones[zone[cell] - 1]][nodes_of(grid, cell)] += 1
            elif tag[cell]:
                self.tags[tags[tag[cell] - 1]].append(nodes_of(grid, cell))


def nodes_of(grid, cell):
    """A cell as a set of nodes; a polyhedron as a set of faces."""
    if grid.GetCellType(cell) == vtk.VTK_POLYHEDRON:
        ids = vtk.vtkIdList()
        grid.GetFaceStream(cell, ids)
        stream = [ids.GetId(i) for i in range(ids.GetNumberOfIds())]
        faces, at = [], 1
        for _ in range(stream[0]):
            faces.append(tuple(sorted(stream[at + 1 : at + 1 + stream[at]])))
            at += stream[at] + 1
        return tuple(sorted(faces))
    ids = vtk.vtkIdList()
    grid.GetCellPoints(cell, ids)
    return tuple(sorted(ids.GetId(i) for i in range(ids.GetNumberOfIds())))


def by_vtk(mesh, path, scratch):
    """Nodes, and the cells of each zone, as VTK reads them."""
    if path.name.endswith(".gz"):
        path = pathlib.Path(shutil.copy(path, scratch)).with_suffix("")
        path.write_bytes(gzip.decompress(pathlib.Path(f"{path}.gz").read_bytes()))
    is_hdf5 = path.suffix == ".h5"
    # The reader crashes on some files; then the others go on.
    code = "import sys; sys.path.insert(0, sys.argv[3]); import matrix_fluent as m; m.save_vtk(sys.argv[1], sys.argv[2])"
    out = pathlib.Path(scratch) / "vtk.npz"
    command = [sys.executable, "-c", code, path, out, pathlib.Path(__file__).parent]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=200)
    except subprocess.TimeoutExpired:
        return "VTK has not ended after 200 s"
    if run.returncode or not out.exists():
        return f"VTK fails ({run.returncode})"
    with np.load(out, allow_pickle=True) as saved:
        points, blocks, failure = saved["points"], saved["blocks"].tolist(), str(saved["failure"])
    if len(points) == 0 or not any(cells for _, cells in blocks):
        return f"VTK reads no cells: {' '.join(failure.split(': ')[-1].split()[-12:])}"
    used = np.array(sorted({node for _, cells in blocks for cell in cells for node in flat(cell)}), dtype=int)
    is_same = len(points) == len(mesh.points) and (points[used] == mesh.points[used].astype(points.dtype)).all()
    # VTK 9.7 takes nodes of three coordinates in binary sections for nodes of two, and says so.
    misread = not is_same and not is_hdf5 and "converted dim" in run.stderr + run.stdout
    if not is_same and not misread:
        raise AssertionError(f"nodes of VTK: {len(points)} against {len(mesh.points)}")
    whole = sum((Counter(cells) for _, cells in blocks), Counter())
    mine = sum(mesh.zones.values(), Counter())
    if whole != mine:
        # VTK gives polyhedra without nodes some of their faces.
        missing, further = sum((mine - whole).values()), sum((whole - mine).values())
        if is_hdf5 or any(isinstance(cell[0], tuple) for cell in further_of(whole, mine)):
            sets = Counter(tuple(sorted(set(flat(cell)))) for cell in whole.elements())
            if sets == Counter(tuple(sorted(set(flat(cell)))) for cell in mine.elements()):
                return f"same, polyhedra as sets of nodes{'; VTK misreads its nodes' if misread else ''}"
        raise AssertionError(f"cells: {missing} of {sum(mine.values())} are not in VTK's, {further} of {sum(whole.values())} only there")
    if not is_hdf5:
        for name, cells in blocks:
            known = mesh.zones.get(name.split(":")[0] if name.split(":")[0] in mesh.zones else name.rsplit(":", 1)[0])
            if known is None or known != Counter(cells):
                raise AssertionError(f"zone {name} has other cells")
    return "cells the same; VTK misreads its nodes" if misread else "same"


def further_of(whole, mine):
    return list((whole - mine).elements())[:1]


def flat(cell):
    return [node for face in cell for node in face] if isinstance(cell[0], tuple) else cell


def save_vtk(path, out):
    """In a process of its own: VTK's nodes and its cells by zone."""
    reader = vtk.vtkFLUENTCFFReader() if path.endswith(".h5") else vtk.vtkFLUENTReader()
    failures = []

    def hear(_object, _event, text=""):
        failures.append(text)

    hear.CallDataType = vtk.VTK_STRING
    reader.AddObserver("ErrorEvent", hear)
    reader.SetFileName(path)
    reader.Update()
    output = reader.GetOutput()
    grids = [output.GetBlock(i) for i in range(output.GetNumberOfBlocks())]
    named = lambda i: output.GetMetaData(i).Get(vtk.vtkCompositeDataSet.NAME()) if output.HasMetaData(i) else None
    names = [named(i) or "" for i in range(len(grids))]
    points = next((pyvista.wrap(grid).points for grid in grids if grid is not None), np.zeros((0, 3)))
    blocks = []
    for name, grid in zip(names, grids):
        # Blocks of zones of faces have the cells beside them.
        if grid is None or (not path.endswith(".h5") and name.rsplit(":", 1)[-1] not in ("fluid", "solid")):
            continue
        blocks.append((name, [nodes_of(grid, cell) for cell in range(grid.GetNumberOfCells())]))
    saved = np.empty(len(blocks), dtype=object)
    saved[:] = blocks
    np.savez(out, points=points, blocks=saved, failure=" ".join(failures)[-400:])


class Stated:
    """What the file says: faces of its zones as sets of nodes from 0, cells of its zones, types and names."""

    def __init__(self, path):
        self.faces, self.cells, self.names, self.how, self.dimension = {}, {}, {}, "", 3
        self.refined, self.nodes = set(), []
        self.is_text = True
        if path.suffix == ".h5":
            self.of_hdf5(path)
        else:
            data = path.read_bytes()
            packed = data[:2] == b"\x1f\x8b"
            self.of_sections(gzip.decompress(data) if packed else data)
            self.how = f"{'text' if self.is_text else 'binary'}{', gzip' if packed else ''}"
            self.data = gzip.decompress(data) if packed else data

    def of_hdf5(self, path):
        self.how, self.is_text = "HDF5", False
        with h5py.File(path) as file:
            mesh = file["meshes/1"]
            self.dimension = int(mesh.attrs["dimension"][0])
            nodes, cells = {}, [{}, {}]
            for section in mesh["nodes/coords"].values():
                self.nodes.append((int(section.attrs["minId"][0]), section[()]))
            for section in mesh["faces/nodes"].values():
                list_of, at = section["nodes"][()].astype(int) - 1, 0
                for face, n in enumerate(section["nnodes"][()].tolist(), int(section.attrs["minId"][0])):
                    nodes[face] = tuple(list_of[at : at + n].tolist())
                    at += n
            for side, name in enumerate(("c0", "c1")):
                for section in mesh[f"faces/{name}"].values():
                    cells[side].update(enumerate(section[()].tolist(), int(section.attrs["minId"][0])))
            zones = mesh["faces/zoneTopology"]
            for zone, first, last, kind in zip(*(zones[key][()].tolist() for key in ("id", "minId", "maxId", "zoneType"))):
                own = [(nodes[face], cells[0].get(face, 0), cells[1].get(face, 0)) for face in range(first, last + 1)]
                self.faces.setdefault((zone, kind), []).extend(own)
            zones = mesh["cells/zoneTopology"]
            for zone, first, last in zip(*(zones[key][()].tolist() for key in ("id", "minId", "maxId"))):
                self.cells[zone] = self.cells.get(zone, 0) + last - first + 1
            for kind, of in (("cells", {}), ("faces", {})):
                zones = mesh[f"{kind}/zoneTopology"]
                listed = b";".join(zones["name"][()]).decode().split(";")
                for zone, name in zip(zones["id"][()].tolist(), listed):
                    self.names[zone] = (None, name)

    def of_sections(self, data):
        found = re.search(rb"\(2 +([23])\s*\)", data)
        self.dimension = int(found.group(1)) if found else 3
        order = ">" if re.search(rb"\(4 +\((?!60)", data[:5000]) else "<"
        at = 0
        header = re.compile(rb"\(\s*(\d\d?|[23]0\d\d)\s*\(([0-9a-fA-F\s]+)\)\s*(\()?|\(\s*(?:39|45)\s*\((\d+) +(\S+) +([^\s)]+)|End of Binary Section")
        while match := header.search(data, at):
            at = match.end()
            if match.group(4):
                zone, kind, name = (match.group(i).decode() for i in (4, 5, 6))
                self.names.setdefault(int(zone), (kind, name))
                continue
            if not match.group(1):
                continue
            index, numbers = int(match.group(1)), [int(n, 16) for n in match.group(2).split()]
            if index % 1000 == 12 and numbers[0] and len(numbers) > 3:
                if numbers[3] != 32:
                    self.cells[numbers[0]] = self.cells.get(numbers[0], 0) + numbers[2] - numbers[1] + 1
            if index in (59, 58, 3059, 2059):
                self.refined.update(range(numbers[0], numbers[1] + 1) if index != 58 else ())
            if not match.group(3):
                continue
            if index % 1000 == 10 and numbers[0]:
                at = self.some_nodes(data, at, index, numbers, order)
            elif index % 1000 == 13 and numbers[0]:
                at = self.zone_of_faces(data, at, index, numbers, order)
            elif index >= 2000:
                self.is_text = False
                at = data.index(b"End of Binary Section", at)
            elif index in (10, 18, 58, 59, 61, 62, 41, 40):
                at = data.index(b")", at)

    def some_nodes(self, data, at, index, numbers, order):
        n = numbers[2] - numbers[1] + 1
        width = numbers[4] if len(numbers) > 4 else self.dimension
        if index < 2000:
            end = data.index(b")", at)
            values = np.array(data[at:end].split(), dtype=float)
        else:
            self.is_text = False
            size = 8 if index > 3000 else 4
            end = at + n * width * size
            values = np.frombuffer(data[at:end], f"{order}f{size}").astype(float)
        self.nodes.append((numbers[1], values.reshape(n, width)))
        return end

    def points(self):
        parts = [part for _, part in sorted(self.nodes, key=lambda part: part[0])]
        points = np.concatenate(parts)
        return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))

    def zone_of_faces(self, data, at, index, numbers, order):
        zone, first, last, kind = numbers[:4]
        size = numbers[4] if len(numbers) > 4 and numbers[4] not in (0, 5) else 0
        n = last - first + 1
        if index < 2000:
            end = data.index(b")", at)
            words = [int(word, 16) for word in data[at:end].split()]
        else:
            self.is_text = False
            end = data.index(b"End of Binary Section", at)
            words = np.frombuffer(data[at : at + (end - at) // 4 * 4], f"{order}i4")
        faces, place = self.faces.setdefault((zone, kind), []), 0
        for face in range(first, last + 1):
            count = size or int(words[place])
            place += not size
            faces.append((tuple(int(node) - 1 for node in words[place : place + count]), int(words[place + count]), int(words[place + count + 1])))
            place += count + 2
        assert len(faces) >= n
        return end


def by_file(mesh, stated):
    """Nodes to the bit, and each boundary zone by its name, face by face."""
    points = stated.points()
    assert points.shape == mesh.points.shape and (points == mesh.points).all(), "nodes are not those of the file"
    tags = {}
    for (zone, kind), faces in stated.faces.items():
        word, name = stated.names.get(zone, (None, f"zone-{zone}"))
        if kind == PARENT or kind >= OVERLAP:
            continue
        is_interior = word == "interior" if word else kind == INTERIOR
        kept = [tuple(sorted(nodes)) for nodes, one, other in faces if (one > 0) + (other > 0) == (1 if is_interior else 1) or
                (not is_interior and one and other)]  # fmt: skip
        if kept:
            tags.setdefault(name, []).extend(kept)
    if not stated.refined:
        mine = {name: Counter(faces) for name, faces in mesh.tags.items()}
        wanted = {name: Counter(faces) for name, faces in tags.items()}
        for name in sorted(set(mine) | set(wanted)):
            one, other = mine.get(name, Counter()), wanted.get(name, Counter())
            assert one == other, f'tag "{name}": {sum(one.values())} faces against {sum(other.values())}'
    cells = {stated.names.get(zone, (None, ""))[1]: n for zone, n in stated.cells.items()}
    assert cells == {name: sum(zone.values()) for name, zone in mesh.zones.items()}, f"zones have {cells} cells"
    return f"same, {sum(map(len, tags.values())):,} faces"


def by_openfoam(stated, path, azimesh, scratch):
    """The mesh that fluent3DMeshToFoam makes."""
    if not (stated.is_text and stated.dimension == 3 and ETC.exists()):
        return ""
    case = pathlib.Path(scratch) / "case"
    (case / "system").mkdir(parents=True)
    header = "FoamFile {{ version 2.0; format ascii; class dictionary; object {}; }}\n"
    (case / "system/controlDict").write_text(
        header.format("controlDict") + "application x; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;\n"
        "writeControl timeStep; writeInterval 1; writeFormat ascii; writePrecision 17;\n")  # fmt: skip
    for name, text in ("fvSchemes", "divSchemes {} gradSchemes {} laplacianSchemes {}"), ("fvSolution", ""):
        (case / "system" / name).write_text(header.format(name) + text)
    (case / "in.msh").write_bytes(stated.data)
    shell = f". {ETC} >/dev/null 2>&1; fluent3DMeshToFoam -case {case} {case}/in.msh > {case}/log 2>&1"
    run = subprocess.run(["bash", "-c", shell], capture_output=True, text=True)
    if run.returncode or not (case / "constant/polyMesh/faces").exists():
        return f"OpenFOAM fails ({run.returncode})"
    run = subprocess.run([azimesh, "diff", path, case, "--match", "position", "--tolerance", "1e-12"], capture_output=True, text=True)
    if run.returncode == 0:
        return "same"
    lines = [line.strip() for line in (run.stdout + run.stderr).splitlines() if line.strip() and not line.startswith("note")]
    return f"differs: {'; '.join(lines)[:300]}".replace(str(path), path.name).replace(str(case), "case")


if __name__ == "__main__":
    main()

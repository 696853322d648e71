"""The matrix of real Exodus and Plot3D files: each beside VTK, and Exodus files beside meshio.

    python validation/matrix_exodus.py FOLDER --azimesh target/release/azimesh -o docs/matrix_exodus.md

Needs vtk, meshio and numpy. Every file is converted to VTU, which VTK reads; VTK's own reader of the format reads the
file itself. Compared are nodes bit for bit, cells with their nodes in order, zones, the faces of every side set, and
arrays at nodes and elements. meshio compares nodes and cells again, and
`exodus_file.py` the file's own numbers with the tables of the manual, without which no difference is excused. Of Plot3D, the
faces of every tag are made again from the neutral map or the sides. Each reader works in a process of its own: some crash.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE / "matrix"))
EXODUS = (".e", ".exo", ".ex2", ".exii", ".g", ".gen", ".e-s002")
PLOT3D = (".xyz", ".p3d", ".p3dfmt", ".p2dfmt", ".bin")
LIMIT_S = 300


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("folder", nargs="?", type=pathlib.Path)
    arguments.add_argument("--azimesh", default="target/release/azimesh")
    arguments.add_argument("-o", "--output", type=pathlib.Path)
    arguments.add_argument("--one", nargs=3, help=argparse.SUPPRESS)  # peer, file, ours
    asked = arguments.parse_args()
    if asked.one:
        print("\n" + json.dumps(answer(*asked.one)))
        return
    files = sorted(path for path in asked.folder.rglob("*") if path.suffix in EXODUS + PLOT3D)
    results = [judge(path, asked) for path in files if path.stat().st_size]
    text = page(results)
    if asked.output:
        asked.output.write_text(text)
    print(text.split("| file")[0])
    sys.exit(any(result["verdict"] == "wrong" for result in results))


def judge(path, asked):
    name = path.relative_to(asked.folder).as_posix()
    family = "Exodus" if path.suffix in EXODUS else "Plot3D"
    with tempfile.TemporaryDirectory() as scratch:
        ours = f"{scratch}/ours.vtu"
        run = subprocess.run([asked.azimesh, "convert", str(path), ours], capture_output=True, text=True,
                             errors="replace", timeout=LIMIT_S)
        notes = [line for line in run.stderr.splitlines() if ours not in line]
        notes = [line.replace(f"{path}: ", "").removeprefix("note: ") for line in notes]
        result = {"name": name, "family": family, "stored": stored(path), "notes": notes}
        if run.returncode == 2:
            sentence = notes[-1].removeprefix("error: ").replace(f"{path}:", "line ")
            result |= {"verdict": "refused", "said": [sentence]}
        elif run.returncode != 0:
            result |= {"verdict": "wrong", "said": [f"ends with {run.returncode}: {run.stderr[-300:]}"]}
        else:
            result |= compared(path, ours, peers(path, family))
    print(result["verdict"], name, "; ".join(result["said"]), flush=True)
    return result


def peers(path, family):
    if family == "Exodus":
        return "file", "vtk", "meshio"
    return ("file_plot3d", "vtk_plot3d") if is_text(path) else ("vtk_plot3d",)


def compared(path, ours, peers):
    """What each peer says. Wrong is any difference that is not excused, and an excuse needs the file's own numbers."""
    said, same, n_wrong = [], set(), 0
    for peer in peers:
        found = asked_in_a_process(peer, path, ours)
        label = peer.split("_")[0].replace("file", "the file itself")
        if "failed" in found:
            said.append(f"{label} fails: {found['failed']}")
        elif found["wrong"]:
            said.append(f"{label} differs: {'; '.join(found['wrong'])}")
            why = excused(path, peer, found["wrong"]) if "file" in same else None
            said += [why] if why else []
            n_wrong += not why
        else:
            said.append(f"same as {label}{found.get('more', '')}")
            same.add(peer)
        said += [f"{label}: {remark}" for remark in found.get("remarks", [])]
    return {"verdict": "wrong" if n_wrong else "same" if same else "unchecked", "said": said}


def asked_in_a_process(peer, path, ours):
    run = subprocess.run([sys.executable, __file__, "--one", peer, str(path), ours], capture_output=True, text=True, timeout=LIMIT_S)
    try:
        return json.loads(run.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        return {"failed": f"crashes ({run.returncode})"}


# part of a name, why azimesh is right where VTK gives something else
VTK_WRONG = [
    ("EDGE3", "VTK leaves the second coordinate of nodes on a line as memory had it"),
    ("EDGE4", "VTK keeps the two ends"),
    ("PRISM20", "VTK keeps the corners, and its sides of seven nodes are empty cells"),
    ("PRISM21", "VTK makes Lagrange wedges of 21 nodes, with a node inside, and its sides of seven nodes are empty cells"),
    ("PYRAMID14", "VTK keeps the corners"),
    ("PYRAMID18", "VTK keeps the corners"),
    ("QUADSHELL9", "VTK keeps eight of nine nodes"),
    ("TET14", "VTK keeps the corners, and its sides of seven nodes are empty cells"),
    ("TRI7", "VTK keeps the corners"),
    ("TRISHELL3", "side 3 of a triangle in space is its edge 1 2 by the manual, here the one at the smallest y; VTK takes 3 1"),
    ("cylinder.exo", "sides of shells are cells of a zone and of side sets, of which a VTU file keeps one"),
]


def excused(path, peer, differences):
    """Why a difference is not ours. meshio keeps the node order of Exodus and has no polyhedra."""
    if peer == "meshio" and all("nodes in another order" in difference for difference in differences):
        return "meshio keeps the order of nodes of the file"
    if peer == "meshio":
        import netCDF4
        with netCDF4.Dataset(path) as file:
            return "meshio leaves polyhedra out" if "num_fa_blk" in file.dimensions else None
    return next((why for part, why in VTK_WRONG if part in path.name), None)


def stored(path):
    start = path.read_bytes()[:8]
    if start.startswith(b"CDF"):
        return f"CDF-{start[3]}"
    if start.startswith(b"\x89HDF"):
        return "HDF5"
    return "text" if start.strip()[:1].isdigit() else "binary"


def answer(peer, path, ours):
    import model
    import vtk_peer
    try:
        mine = vtk_peer.read(ours)
        if peer == "file":
            import exodus_file
            return exodus_file.beside(mine, path)
        if peer == "vtk":
            return beside_vtk(mine, path)
        if peer == "file_plot3d":
            return beside_plot3d(mine, path, plot3d_by_words)
        if peer == "vtk_plot3d":
            return beside_plot3d(mine, path, plot3d_by_vtk)
        import meshio_peer
        theirs = meshio_peer.read(path)
        theirs.faces_are_groups = True
        theirs.point_arrays, theirs.cell_arrays = {}, {}
        wrong, remarks = model.differences(mine, theirs)
        return {"wrong": wrong, "remarks": remarks}
    except (Exception, SystemExit) as error:
        return {"failed": " ".join(str(error).split())[:200] or type(error).__name__}


def beside_vtk(mine, path):
    import model
    theirs, sets = read_exodus(path, mine)
    n_faces = sum(len(faces) for faces in sets.values())
    theirs.faces_are_groups = True
    wrong, remarks = model.differences(mine, theirs)
    n_compared = 0
    for name, faces in sets.items():
        found = [key for key in mine.groups if key[1] in (name, name.removeprefix("Unnamed set ID: "))]
        found += [key for key in mine.groups if key[1] == f"side set {name}"]
        rows = set()
        place = np.arange(len(mine.points))
        for key in found:
            rows |= model.group_rows(mine, place, mine.groups[key])
        missing = [face for face in faces if face not in rows]
        n_compared += len(faces) - len(missing)
        if missing:
            wrong.append(f"side set \"{name}\": {len(missing)} of {len(faces)} faces are not in the tag")
    if not wrong and sets:
        remarks.append(f"{n_compared} faces of {len(sets)} side sets of {n_faces} are in their tags")
    return {"wrong": wrong, "remarks": remarks}


def read_exodus(path, mine):
    """Nodes, cells, zones and arrays as VTK reads them, and the faces of side sets as sets of corners."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOExodus import vtkExodusIIReader
    import vtk_peer
    from model import CORNERS, Model
    reader = vtkExodusIIReader()
    failures = vtk_peer.Failures(reader)
    reader.SetFileName(path)
    reader.UpdateInformation()
    reader.ApplyDisplacementsOff()
    reader.SetSqueezePoints(False)
    n_times = reader.GetNumberOfTimeSteps()
    if n_times:
        times = reader.GetOutputInformation(0).Get(reader.GetExecutive().TIME_STEPS())
        reader.UpdateTimeStep(times[-1])
    kinds = {"blocks": reader.ELEM_BLOCK, "sides": reader.SIDE_SET, "nodal": reader.NODAL}
    for kind in (reader.ELEM_BLOCK, reader.SIDE_SET):
        for i in range(reader.GetNumberOfObjects(kind)):
            reader.SetObjectStatus(kind, i, 1)
    for kind in (reader.NODAL, reader.ELEM_BLOCK):
        for i in range(reader.GetNumberOfObjectArrays(kind)):
            reader.SetObjectArrayStatus(kind, reader.GetObjectArrayName(kind, i), 1)
    reader.Update()
    if n_times:
        reader.UpdateTimeStep(times[-1])
    if failures.texts:
        raise ValueError(f"VTK: {failures.texts[0]}")
    output = reader.GetOutput()
    whole, first, sets = None, 0, {}
    names = [reader.GetObjectName(kinds["blocks"], i) for i in range(reader.GetNumberOfObjects(kinds["blocks"]))]
    ids = [reader.GetObjectId(kinds["blocks"], i) for i in range(len(names))]
    blocks = output.GetBlock(0)
    cell_parts = []
    for i in range(blocks.GetNumberOfBlocks() if blocks else 0):
        grid = blocks.GetBlock(i)
        if grid is None or grid.GetNumberOfCells() == 0:
            continue
        part = vtk_peer.of_grid(grid)
        if whole is None:
            whole = Model(part.points, single=part.single)
            whole.point_arrays = {name.rstrip("_"): values for name, values in part.point_arrays.items()
                                  if name not in ("GlobalNodeId", "PedigreeNodeId") and values.dtype.kind == "f"}
        index = np.arange(first, first + grid.GetNumberOfCells())
        for block in part.blocks:
            block.index = block.index + first
            whole.blocks.append(block)
        whole.polyhedra += part.polyhedra
        name = names[i] if not names[i].startswith("Unnamed block") else str(ids[i])
        dimension = part.dimension()
        if len(part.blocks):
            key = (dimension, name)
            old = whole.groups.get(key, np.array([], int))
            whole.groups[key] = np.concatenate([old, index])
        cell_parts.append(((dimension, name), {n: v for n, v in part.cell_arrays.items()
                                   if n not in ("GlobalElementId", "PedigreeElementId", "ObjectId") and v.dtype.kind == "f"}))
        first += grid.GetNumberOfCells()
    if whole is None or not len(whole.points):
        raise ValueError("VTK gives no cells with nodes")
    sides = output.GetBlock(4)
    sides_names = [reader.GetObjectName(kinds["sides"], i) for i in range(reader.GetNumberOfObjects(kinds["sides"]))]
    for i in range(sides.GetNumberOfBlocks() if sides else 0):
        grid = sides.GetBlock(i)
        faces = []
        for block in vtk_peer.of_grid(grid).blocks if grid is not None else []:
            n = CORNERS.get(block.kind, block.nodes.shape[1])
            # VTK takes an edge of three nodes for a triangle.
            n = 2 if mine.dimension() == 2 and n == 3 and block.kind == 5 else n
            faces += [tuple(sorted(row)) for row in block.nodes[:, :n].tolist()]
        if faces:
            name = sides_names[i].removeprefix("Unnamed set ID: ").split(" ")[0] if sides_names[i].startswith("Unnamed") else sides_names[i]
            sets.setdefault(name, []).extend(faces)
    compare_elements(mine, cell_parts, whole)
    whole.finish()
    mine.cell_arrays = {}
    mine.point_arrays = {name.rstrip("_"): values for name, values in mine.point_arrays.items()}
    return whole, sets


def compare_elements(mine, parts, whole):
    """Arrays of elements, block by block. Shells may be faces that lie elsewhere among the cells: left out."""
    names, n_values = set(), 0
    for key, arrays in parts:
        index = np.sort(mine.groups.get(key, np.array([], int)))
        if key[0] < mine.dimension():
            continue
        for name, values in arrays.items():
            found = mine.cell_arrays.get(name.rstrip("_"), mine.cell_arrays.get(name))
            if found is None or len(index) != len(values):
                whole.remarks.append(f"element array \"{name}\" not compared")
            elif not np.array_equal(np.ravel(found[index]), np.ravel(values), equal_nan=True):
                raise ValueError(f"element array \"{name}\" has other values")
            else:
                names.add(name)
                n_values += len(values)
    if names:
        whole.remarks.append(f"{len(names)} element arrays the same ({n_values} values)")


def beside_plot3d(mine, path, read):
    """Every node of every block, its cells, and the faces of each tag by the neutral map or by the sides."""
    points, sizes, how = read(path)
    wrong = []
    if len(points) != len(mine.points) or (points + 0.0 != mine.points).any():
        wrong.append(f"nodes: {len(mine.points)} against {len(points)}, or at other places")
    n_cells = sum(int(np.prod([max(n - 1, 1) for n in size])) for size in sizes)
    dimension = max(sum(n > 1 for n in size) for size in sizes)
    solid = [block for block in mine.blocks if block.kind == {3: 12, 2: 9, 1: 3}[dimension]]
    first = 0
    expected = []
    for size in sizes:
        expected.append(cells_of(size, first))
        first += int(np.prod(size))
    theirs = np.concatenate(expected)
    ours = solid[0].nodes[:n_cells] if solid else np.zeros((0, 8))
    if ours.shape != theirs.shape or (ours != theirs).any():
        wrong.append(f"cells: {ours.shape} against {theirs.shape}, or with other nodes")
    tags = {key[1]: faces_of(mine, cells) for key, cells in mine.groups.items() if key[0] == dimension - 1}
    expected, whence = sides_or_map(path, points, sizes, dimension)
    if tags != expected:
        names = sorted(name for name in set(tags) | set(expected) if tags.get(name) != expected.get(name))
        wrong.append(f"tags by {whence}: {', '.join(names)}")
    n_faces = sum(len(faces) for faces in tags.values())
    remarks = [f"{len(sizes)} blocks, {len(points)} nodes, {n_cells} cells by {how}; {n_faces} faces in {len(tags)} tags by {whence}"]
    return {"wrong": wrong, "remarks": remarks}


def faces_of(mine, index):
    found = set()
    for block in mine.blocks:
        found |= {tuple(sorted(row)) for row in block.nodes[np.isin(block.index, index)].tolist()}
    return found


def sides_or_map(path, points, sizes, dimension):
    """The faces of each tag by the neutral map beside the file where it is for these sizes, else by the sides of blocks."""
    first = np.cumsum([0] + [int(np.prod(size)) for size in sizes])
    numbers = [np.arange(np.prod(size)).reshape(size, order="F") + first[i] for i, size in enumerate(sizes)]
    path = pathlib.Path(path)
    entries = neutral_map(path.with_suffix(".nmf"), sizes)
    if entries:
        tags = {}
        for name, block, side, ranges in entries:
            cut = np.moveaxis(numbers[block], {1: 2, 2: 2, 3: 0, 4: 0, 5: 1, 6: 1}[side], 0)[0 if side % 2 else -1]
            # The ranges of j sides are those of k, then of i.
            spans = ranges[::-1] if side in (5, 6) else ranges
            rows, columns = (slice(min(span) - 1, max(span)) for span in spans)
            tags.setdefault(name, set()).update(quads(cut[rows, columns]))
        tags.pop("one-to-one", None)
        return tags, "the neutral map"
    sides, count = {}, {}
    for i, (size, number) in enumerate(zip(sizes, numbers)):
        for axis in range(3):
            for name, at in (("min", 0), ("max", -1)):
                if size[axis] > 1 and sum(n > 1 for n in size) == dimension:
                    faces = quads(np.take(number, at, axis))
                    key = f"{'ijk'[axis]}{name}" if len(sizes) == 1 else f"block{i + 1}_{'ijk'[axis]}{name}"
                    sides[key] = {face: tuple(sorted(tuple((points[node] + 0.0).tolist()) for node in face)) for face in faces}
                    for at_place in sides[key].values():
                        count[at_place] = count.get(at_place, 0) + 1
    return {key: set(faces) for key, faces in sides.items() if all(count[place] == 1 for place in faces.values())}, "the sides of blocks"


def quads(cut):
    """Faces of a side as sorted nodes; of a plane block, its edges."""
    if 1 in cut.shape:
        line = cut.ravel()
        return [tuple(sorted(pair)) for pair in zip(line[:-1].tolist(), line[1:].tolist())]
    corners = np.stack([cut[:-1, :-1], cut[1:, :-1], cut[1:, 1:], cut[:-1, 1:]], axis=-1).reshape(-1, 4)
    return [tuple(sorted(row)) for row in corners.tolist()]


def neutral_map(path, sizes):
    """Name, block, side and ranges of each line; nothing where there is no map, or it is for other sizes."""
    if not path.exists():
        return []
    lines = [line.split("\\")[0].split("#")[0].split() for line in path.read_text().splitlines()]
    lines = [line for line in lines if line]
    n = int(lines[0][0])
    given = [[int(word) for word in line[1:4]] for line in lines[1:n + 1]]
    # A plane may be two planes of nodes in the map, whose second and third index are the first two of the grid.
    shift = given == [[2, *size[:2]] for size in sizes] and all(size[2] == 1 for size in sizes)
    if given != [list(size) for size in sizes] and not shift:
        return []
    entries = []
    for name, *words in lines[n + 1:]:
        words = [int(word) for word in words if word.isdigit()]
        for part in (words[:6], words[6:12]):
            if len(part) == 6:
                entries.append((name.strip("'"), part[0] - 1, part[1], ((part[2], part[3]), (part[4], part[5]))))
                if shift:
                    entries[-1] = plane(*entries[-1])
    return [entry for entry in entries if entry]


def plane(name, block, side, ranges):
    """A line of a map of two planes as one of a plane: sides across j and k become sides across i and j."""
    if side in (3, 4):
        return None
    # Across k the ranges are those of i and j, across j of k and i.
    span = ranges[1] if side in (1, 2) else ranges[0]
    return (name, block, side + 4, ((1, 1), span)) if side in (1, 2) else (name, block, side - 2, (span, (1, 1)))


def cells_of(size, first):
    axes = [i for i in range(3) if size[i] > 1]
    stride = [1, size[0], size[0] * size[1]]
    start = first + sum(np.meshgrid(*[np.arange(max(n - 1, 1)) * s for n, s in zip(size, stride)], indexing="ij")).T.ravel()
    if len(axes) == 2:
        a, b = (stride[i] for i in axes)
        return start[:, None] + np.array([0, a, a + b, b])
    a, b, c = stride
    return start[:, None] + np.array([0, a, a + b, b, c, a + c, a + b + c, b + c])


def is_text(path):
    return all(byte < 128 and byte for byte in pathlib.Path(path).read_bytes()[:2000])


def plot3d_by_words(path):
    points, sizes, *_ = by_words(pathlib.Path(path).read_bytes().split(), path)
    return points, sizes, "the words of the file"


def plot3d_by_vtk(path):
    """Nodes and sizes of blocks by VTK; of text, the number of words says VTK what the layout is."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOParallel import vtkMultiBlockPLOT3DReader
    import vtk_peer
    reader = vtkMultiBlockPLOT3DReader()
    failures = vtk_peer.Failures(reader)
    reader.SetXYZFileName(path)
    if is_text(path):
        *_, is_multi, n_axes, has_flags = by_words(pathlib.Path(path).read_bytes().split(), path)
        reader.BinaryFileOff()
        reader.SetMultiGrid(is_multi)
        reader.SetTwoDimensionalGeometry(n_axes == 2)
        reader.SetIBlanking(has_flags)
        reader.DoublePrecisionOn()
    else:
        reader.AutoDetectFormatOn()
    reader.Update()
    if failures.texts:
        raise ValueError(f"VTK: {failures.texts[0]}")
    output = reader.GetOutput()
    points, sizes = [], []
    for i in range(output.GetNumberOfBlocks()):
        grid, size = output.GetBlock(i), [0, 0, 0]
        grid.GetDimensions(size)
        sizes.append(size)
        points.append(vtk_to_numpy(grid.GetPoints().GetData()).astype(float))
    if not points:
        raise ValueError("VTK gives no blocks")
    return np.concatenate(points), sizes, "VTK"


def by_words(words, path):
    """The layout whose numbers of nodes fit, as the ending of the name says how many axes there are."""
    for multi in (True, False):
        for axes in ((2, 3) if "2d" in path.lower() else (3, 2)):
            at = 1 if multi else 0
            n = int(words[0]) if multi else 1
            if n > 1000 or len(words) < at + n * axes:
                continue
            try:
                sizes = [[int(w) for w in words[at + i * axes:at + (i + 1) * axes]] + [1] * (3 - axes) for i in range(n)]
            except ValueError:
                continue
            at += n * axes
            total = sum(int(np.prod(size)) for size in sizes)
            for flags in (0, 1):
                if at + total * (axes + flags) != len(words):
                    continue
                numbers = np.array([float(word) for word in words[at:]])
                points, first = [], 0
                for size in sizes:
                    k = int(np.prod(size))
                    block = np.zeros((k, 3))
                    block[:, :axes] = numbers[first:first + axes * k].reshape(axes, k).T
                    points.append(block)
                    first += (axes + flags) * k
                return np.concatenate(points), sizes, multi, axes, bool(flags)
    raise ValueError("its numbers fit no layout")


def page(results):
    count = lambda family, verdict: sum(r["family"] == family and r["verdict"] == verdict for r in results)
    text = __doc__.split("\n\n")[0].replace("The matrix of real", "# Real", 1) + "\n\n"
    text = "# Real Exodus and Plot3D files\n\n" + (
        "Files of public repositories, each read by azimesh and by VTK, Exodus files by meshio too. \"The file itself\" is what netCDF's\n"
        "library gives of an Exodus file, with the tables of sides of the manual, or the words of a Plot3D file of text; VTK is said to\n"
        "be wrong only where azimesh agrees with it. Files in `recoded` are others that netCDF's library has written in another of its\n"
        "formats; those called `testwt` are made of the text (ncdump) that SEACAS has of them, `-sides` without sides 4 and 5 of element 7,\nwhich is a polygon of three nodes.\n"
        "`validation/matrix_exodus.py` makes this page of a folder with them.\n\n"
        "| format | files | the same as a peer | refused | wrong | no peer reads it |\n|---|---|---|---|---|---|\n")
    for family in ("Exodus", "Plot3D"):
        n = sum(r["family"] == family for r in results)
        text += f"| {family} | {n} | {count(family, 'same')} | {count(family, 'refused')} | {count(family, 'wrong')} | {count(family, 'unchecked')} |\n"
    for family in ("Exodus", "Plot3D"):
        text += f"\n## {family}\n\n| file | stored as | result | notes |\n|---|---|---|---|\n"
        for r in (r for r in results if r["family"] == family):
            said = "; ".join(r["said"]).replace("|", "\\|")
            verdict = {"same": "", "refused": "refused: ", "wrong": "WRONG: ", "unchecked": "not compared: "}[r["verdict"]]
            notes = "" if r["verdict"] == "refused" else "; ".join(r["notes"]).replace("|", "\\|")
            text += f"| {r['name']} | {r['stored']} | {verdict}{said} | {notes} |\n"
    return text


if __name__ == "__main__":
    main()

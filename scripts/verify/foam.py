"""OpenFOAM cases as VTK's reader and OpenFOAM's tools have them, and their comparison with what azimesh reads.

VTK's reader has points in 32 bits; those in 64 bits are read here from the file.
"""

import gzip
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pyvista
from vtkmodules.vtkCommonCore import vtkIdList
from vtkmodules.vtkIOParallel import vtkPOpenFOAMReader

from program import azimesh

ETC = Path("/usr/share/openfoam/etc/bashrc")
HEADER = "FoamFile {{ version 2.0; format ascii; class {}; object {}; }}\n"
SYSTEM = {
    "controlDict": "application none; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;\n"
    "writeControl timeStep; writeInterval 1; writeFormat binary; writePrecision 17; timePrecision 8;\n",
    "fvSchemes": "ddtSchemes {} gradSchemes {} divSchemes {} laplacianSchemes {} interpolationSchemes {} snGradSchemes {}\n",
    "fvSolution": "\n",
}
# Faces of VTK's cells by their corners.
FACES = {
    10: [(0, 1, 3), (1, 2, 3), (2, 0, 3), (0, 2, 1)], 12: [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)],
    13: [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)], 14: [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
}  # fmt: skip


def is_there(program):
    """Whether OpenFOAM and one of its programs are installed."""
    return ETC.exists() and shutil.which(program) is not None


def make_system(case):
    """What OpenFOAM's programs want of a case beside its mesh."""
    (case / "system").mkdir(parents=True, exist_ok=True)
    for name, text in SYSTEM.items():
        (case / "system" / name).write_text(HEADER.format("dictionary", name) + text)
    return case


def run(case, *command):
    """What a program of OpenFOAM says of a case; some write files into the folder where they were started."""
    line = f". {ETC} >/dev/null 2>&1; exec {' '.join(command)} -case {case}"
    done = subprocess.run(["bash", "-c", line], cwd=case, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "FATAL" not in done.stdout + done.stderr, f"{command} in {case}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
    return done.stdout


def vectors(path):
    """The vectors of a list of points or of a field at points, which must be whole: text or binary, packed or not."""
    packed = path.with_name(path.name + ".gz")
    data = path.read_bytes() if path.exists() else gzip.decompress(packed.read_bytes())
    start = re.search(rb"\n\s*(?:internalField\s+nonuniform\s+List<vector>\s*)?(\d+)\s*\(", data)
    assert start, f"{path}: it is cut"
    n, at = int(start[1]), start.end()
    is_binary = re.search(rb"format\s+binary", data[:at])
    end = at + 24 * n if is_binary else data.index(b"\n)", at) + 1
    assert data[end : end + 1] == b")" and data.endswith((b")\n", b"}\n", b"//\n")), f"{path}: it is cut"
    numbers = data[at:end].replace(b"(", b" ").replace(b")", b" ").split() if not is_binary else None
    return (np.frombuffer(data[at:end], "<f8") if is_binary else np.array(numbers, float)).reshape(n, 3)


def by_vtk(case, time=None, long_labels=False):
    """The blocks of VTK's reader: the mesh, patches and cell zones. It is told the width of labels."""
    marker = case / "mesh.foam"
    marker.touch()
    reader = vtkPOpenFOAMReader()
    reader.SetFileName(str(marker))
    reader.SetCaseType(vtkPOpenFOAMReader.RECONSTRUCTED_CASE)
    reader.SetUse64BitLabels(long_labels)
    reader.SetUse64BitFloats(True)
    for switch in ("SkipZeroTimeOff", "ListTimeStepsByControlDictOff", "ReadZonesOn", "CacheMeshOff", "UpdateInformation"):
        getattr(reader, switch)()
    for chosen in ("Cell", "Point", "Lagrangian"):
        getattr(reader, f"DisableAll{chosen}Arrays")()
    for i in range(reader.GetNumberOfPatchArrays()):
        chosen = reader.GetPatchArrayName(i)
        reader.SetPatchArrayStatus(chosen, int("Zone" not in chosen or "cellZone" in chosen))
    if time is not None:
        reader.SetTimeValue(time)
    reader.Update()
    marker.unlink()
    return dict(blocks(pyvista.wrap(reader.GetOutput())))


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
        if (kind := grid.GetCellType(i)) == 42:
            faces = [frozenset(map(int, face.point_ids)) for face in grid.get_cell(i).faces]
        else:
            grid.GetCellPoints(i, ids)
            faces = [frozenset(ids.GetId(k) for k in face) for face in FACES[kind]]
        cells.append(frozenset(faces))
    return cells


def face_places(grid, chosen=None):
    """The faces of a surface by the places of their nodes, sorted."""
    points, faces, ids = grid.points.astype(np.float32).tolist(), [], vtkIdList()
    for i in range(grid.n_cells) if chosen is None else chosen:
        grid.GetCellPoints(int(i), ids)
        faces.append(tuple(sorted(tuple(points[ids.GetId(k)]) for k in range(ids.GetNumberOfIds()))))
    return sorted(faces)


def by_azimesh(path, out, step=None):
    """The mesh as azimesh reads it: the grid, its cells that are volumes, faces by tag, cells by zone."""
    azimesh("convert", path, out, "--force", *([] if step is None else ["--step", step]))
    grid = pyvista.read(out)
    named = lambda array: {  # noqa: E731
        str(name): np.flatnonzero(grid.cell_data[array] == i) for i, name in enumerate(grid.field_data.get(f"{array}Names", []), 1)
    }
    volume = np.flatnonzero(np.isin(grid.celltypes, [10, 12, 13, 14, 42]))
    return grid, volume, named("BoundaryTag"), named("Zone")


def compare(what, mesh, internal, patches, zones=(), same_kinds=False):
    """Compares points in 32 bits, cells by their faces, faces of each patch and cells of each zone; the number of all of them."""
    grid, volume, tags, own_zones = mesh
    assert np.array_equal(grid.points.astype(np.float32), internal.points[: grid.n_points].astype(np.float32)), f"{what}: points"
    assert internal.n_cells == len(volume), f"{what}: {len(volume)} cells, not {internal.n_cells}"
    ours = grid.extract_cells(volume) if len(volume) < grid.n_cells else grid
    by_node = np.asarray(ours.point_data.get("vtkOriginalPointIds", np.arange(grid.n_points)))
    for i, (own, other) in enumerate(zip(cell_faces(ours), cell_faces(internal), strict=True)):
        assert frozenset(frozenset(int(by_node[n]) for n in face) for face in own) == other, f"{what}: cell {i} differs"
    assert not same_kinds or np.array_equal(ours.celltypes, internal.celltypes), f"{what}: types of cells"
    n_faces = 0
    for name, patch in patches.items():
        assert face_places(patch) == face_places(grid, tags[name]), f"{what}: patch {name} differs"
        n_faces += patch.n_cells
    for name, zone in dict(zones).items():
        assert face_places(zone) == face_places(grid.extract_cells(own_zones[name])), f"{what}: zone {name} differs"
    assert n_faces == grid.n_cells - len(volume), f"{what}: {n_faces} faces on patches"
    return grid.n_points + len(volume) + n_faces


def beside_vtk(case, path, out, step=None, points=None, **told):
    """Compares what azimesh reads from `path` with what VTK's reader has of a case, and with the points in its file to the bit."""
    mesh, found = by_azimesh(path, out, step), by_vtk(case, **told)
    expected = vectors(points or case / "constant/polyMesh/points")
    assert np.array_equal(np.asarray(mesh[0].points, float).view(np.uint64), expected.view(np.uint64)), f"{path}: points differ"
    of = lambda folder: {name.split("/")[-1]: block for name, block in found.items() if folder in name.split("/")[:-1]}  # noqa: E731
    patches = {name: block for name, block in of("boundary").items() if block.n_cells}
    # VTK takes each label of 64 bits in a zone for two of 32.
    return compare(path, mesh, found["internalMesh"], patches, {} if told.get("long_labels") else of("cellZones"))

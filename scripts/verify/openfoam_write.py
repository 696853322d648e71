"""OpenFOAM: cases that we write as VTK's reader sees them, and as checkMesh and foamToVTK do where OpenFOAM is installed.

VTK reads nodes, cells and the faces of each patch of single meshes, in binary and in text, and the nodes at every time
of a sequence. checkMesh (Debian: `apt-get install openfoam`; checked with v1912) has to find faces in order, closed cells
and our volumes at every time; foamToVTK our nodes, cells and `wantedDisplacement`. Without OpenFOAM that part is skipped.
"""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pyvista
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from killed import foam_vectors
from program import TESTDATA, azimesh, report, scratch

ETC = Path("/usr/share/openfoam/etc/bashrc")
HEADER = "FoamFile {{ version 2.0; format ascii; class dictionary; object {}; }}\n"
SYSTEM = {
    "controlDict": "application checkMesh; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;\n"
    "writeControl timeStep; writeInterval 1; writePrecision 17; timePrecision 8;\n",
    "fvSchemes": "ddtSchemes {} gradSchemes {} divSchemes {} laplacianSchemes {} interpolationSchemes {} snGradSchemes {}\n",
    "fvSolution": "",
}
MESHES = {
    "polyhedra_raw_zlib.vtu": [], "mixed_cells.su2": [], "sphere_in_box_raw.vtu": [], "rotor_sector.vtu": [],
    "naca0012.vtu": ["--extrude", "0.1"], "curved_solids_serendipity_v22.msh": ["--linearize"],
}  # fmt: skip
SCHEDULE = """azimuth.values = [0, 22.5, 45]
output = {{ format = "{format}", displacement = {displacement} }}
boundaries.fixed = ["inlet", "outlet", "walls"]
rbf.support_radius = 3.0
[[body]]
name = "sphere"
tags = ["sphere"]
rigid = {{ translate = [0.1, 0.05, 0.0], ramp = true }}
"""


def make_system(case):
    """What OpenFOAM's programs want of a case beside its mesh."""
    (case / "system").mkdir(parents=True)
    for name, text in SYSTEM.items():
        (case / "system" / name).write_text(HEADER.format(name) + text)


def by_vtk(case, moment=None):
    """(grid of the cells, {patch: grid of its faces}) by VTK's own reader."""
    reader = vtk.vtkOpenFOAMReader()
    reader.SetFileName(str(next(case.glob("*.foam"))))
    reader.SkipZeroTimeOff()
    reader.UpdateInformation()
    reader.EnableAllPatchArrays()
    times = vtk_to_numpy(reader.GetTimeValues()).tolist() if reader.GetTimeValues() else []
    if moment is not None:
        reader.UpdateTimeStep(moment)
    reader.Update()
    blocks = pyvista.wrap(reader.GetOutput())
    grid, patches = None, {}
    for name in blocks.keys():
        block = blocks[name]
        if name == "internalMesh":
            grid = block
        elif block is not None:
            patches.update({key: block[key] for key in block.keys()})
    return grid, patches, times


def node_sets(grid):
    """The nodes of each cell, ascending."""
    return [sorted(grid.get_cell(i).point_ids) for i in range(grid.n_cells)]


def faces_at(points, faces):
    """Faces as sorted lists of the places of their nodes."""
    return sorted(sorted(map(tuple, points[face].tolist())) for face in faces)


def same_points(case, time_name, grid, wanted):
    """Coordinates: in the file bit for bit, and as VTK reads them, which keeps 32 bits."""
    own = points_of(wanted)
    path = case / time_name / "polyMesh" / "points"
    stored = foam_vectors(path) if b"binary" in path.read_bytes()[:100] else foam_text(path)
    assert own.dtype == np.float64 and np.array_equal(stored.view(np.uint64), own.view(np.uint64)), path
    assert np.array_equal(points_of(grid), own.astype(np.float32)), f"{path}: as VTK reads it"


def foam_text(path):
    """The vectors of a text file of OpenFOAM."""
    rows = path.read_text().split("\n(\n", 1)[1].rsplit("\n)", 1)[0].splitlines()
    return np.array([[float(word) for word in row.strip("()").split()] for row in rows])


def points_of(grid):
    """Nodes of a grid in the bits that it has."""
    return vtk_to_numpy(grid.GetPoints().GetData())


def check_mesh(folder, name, options):
    """A mesh in a case, in binary and in text, against the same in a .vtu."""
    azimesh("convert", TESTDATA / name, folder / "as.vtu", "--force", *options)
    wanted = pyvista.read(folder / "as.vtu")
    solid = [i for i in range(wanted.n_cells) if wanted.get_cell(i).dimension == 3]
    cells = [sorted(wanted.get_cell(i).point_ids) for i in solid]
    tags = wanted.cell_data["BoundaryTag"]
    names = [str(tag) for tag in wanted.field_data["BoundaryTagNames"]]
    for encoding in ["raw", "ascii"]:
        case = folder / f"{Path(name).stem}_{encoding}"
        azimesh("convert", TESTDATA / name, case, "--format", "openfoam", "--encoding", encoding, *options)
        grid, patches, _ = by_vtk(case)
        same_points(case, "constant", grid, wanted)
        assert node_sets(grid) == cells, f"{case}: cells"
        for number, tag in enumerate(names, 1):
            own = [wanted.get_cell(i).point_ids for i in np.flatnonzero(tags == number)]
            patch = patches[tag]
            found = [patch.get_cell(i).point_ids for i in range(patch.n_cells)]
            rounded = points_of(wanted).astype(np.float32)
            assert faces_at(points_of(patch), found) == faces_at(rounded, own), f"{case}: {tag}"
    return len(cells), folder / f"{Path(name).stem}_raw"


def openfoam(case, *command):
    """What a program of OpenFOAM says of a case."""
    line = f". {ETC} >/dev/null 2>&1; exec {' '.join(command)} -case {case}"
    done = subprocess.run(["bash", "-c", line], cwd=case, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "FATAL" not in done.stdout + done.stderr, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


def volume(path):
    """Sum of the volumes of the cells, by azimesh."""
    with scratch() as folder:
        azimesh("quality", path, "-o", folder / "q.vtu")
        found = pyvista.read(folder / "q.vtu")
        solid = np.isin(found.celltypes, [10, 12, 13, 14, 15, 16, 42])
        return float(found.cell_data["Volume"][solid].sum())


def check_by_checkmesh(case, expected, n_times=1):
    """checkMesh finds a good topology and these volumes at every time."""
    said = openfoam(case, "checkMesh", "-allTopology", "-allGeometry")
    for line in ["Boundary definition OK", "Upper triangular ordering OK", "Cell to face addressing OK", "zip-up check OK"]:
        assert line in said, f"{case}: no \"{line}\" in\n{said}"
    assert said.count("Face pyramids OK") == n_times and said.count("Boundary openness") == n_times, said
    found = [float(v) for v in re.findall(r"Total volume = ([^ ]+)\.", said)]
    assert len(found) == n_times, f"{case}: {found}"
    largest = max(abs(a / b - 1) for a, b in zip(found, expected, strict=True))
    assert largest < 1e-5, f"{case}: volumes {found}, expected {expected}"
    return largest


def check_sequence(folder, has_openfoam):
    """The times of a sequence against the same in .vtu files."""
    case = folder / "moving"
    make_system(case)
    mesh = TESTDATA / "sphere_in_box_raw.vtu"
    for name, format_, displacement in [("case.toml", "openfoam", "true"), ("vtu.toml", "vtu", "true")]:
        (folder / name).write_text(SCHEDULE.format(format=format_, displacement=displacement))
    azimesh("deform", mesh, folder / "case.toml", "-o", case)
    azimesh("deform", mesh, folder / "vtu.toml", "-o", folder / "vtu")
    paths = [folder / "vtu" / f"sphere_in_box_raw_{step:04}.vtu" for step in range(3)]
    steps = [pyvista.read(path) for path in paths]
    for step, moment in zip(steps, [0.0, 22.5, 45.0], strict=True):
        grid, _, times = by_vtk(case, moment)
        assert times == [0.0, 22.5, 45.0], times
        same_points(case, f"{moment:g}" if moment else "constant", grid, step)
    if not has_openfoam:
        return
    check_by_checkmesh(case, [volume(path) for path in paths], 3)
    # It writes 32 bits.
    openfoam(case, "foamToVTK", "-no-boundary")
    written = sorted((case / "VTK").glob("moving_*/internal.vtu"), key=lambda path: int(path.parent.name.split("_")[1]))
    for step, path in zip(steps, written, strict=True):
        found = pyvista.read(path)
        assert np.array_equal(points_of(found), points_of(step).astype(np.float32)), f"{path}: nodes"
        own, wanted = found.point_data["wantedDisplacement"], step.point_data["Displacement"]
        assert np.array_equal(own, wanted.astype(np.float32)), f"{path}: displacement"


def main():
    """One line in all."""
    has_openfoam = ETC.exists() and shutil.which("checkMesh") is not None
    n_cells = 0
    with scratch() as folder:
        for name, options in MESHES.items():
            n, case = check_mesh(folder, name, options)
            n_cells += n
            if has_openfoam:
                make_system(case)
                check_by_checkmesh(case, [volume(case)])
        check_sequence(folder, has_openfoam)
    note = "VTK's reader, checkMesh and foamToVTK" if has_openfoam else "VTK's reader; SKIPPED: checkMesh, as OpenFOAM is not installed"
    report("openfoam_write", n_cells, 0.0, "cells", note)


if __name__ == "__main__":
    main()

"""OpenFOAM's own `foamToVTK` beside azimesh: cells with their kinds, faces of each patch, points; of the cases in
testdata, and of others that blockMesh, snappyHexMesh and polyDualMesh make here. Skipped, and said so, where OpenFOAM is not
installed.

Shapes with a collapsed edge (`wedge`, `tetWedge`) are polyhedra of both; with `-poly-decomp` foamToVTK would squeeze them into
hexahedra and wedges with a node twice.
"""

import gzip
import re
import shutil
import subprocess
import sys
from pathlib import Path

import foam
import numpy as np
import pyvista
from openfoam_write import ETC
from program import TESTDATA, report, scratch

MESH = "constant/polyMesh"
HEADER = "FoamFile {{ version 2.0; format ascii; class dictionary; object {}; }}\n"
CONTROL = """application none; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1; writeControl timeStep;
writeInterval 1; writeFormat binary; writePrecision 12;
"""
SCHEMES = "divSchemes {} gradSchemes {} laplacianSchemes {}\n"
# A box with a graded side, and the same drawn to an edge: hexahedra, and wedges at the edge.
BOX = """scale 1;
vertices ((-1 -1 -1) (1 -1 -1) (1 1 -1) (-1 1 -1) (-1 -1 1) (1 -1 1) (1 1 1) (-1 1 1));
blocks (hex (0 1 2 3 4 5 6 7) box (6 6 6) simpleGrading (2 1 1));
boundary (low {{ type patch; faces ((0 4 7 3)); }} high {{ type wall; faces ((1 2 6 5)); }});
defaultPatch {{ name sides; type patch; }}
"""
DRAWN = """scale 1;
vertices ((0 0 0) (2 -0.1 0) (2 0.1 0) (0 0 3) (2 -0.1 3) (2 0.1 3));
blocks (hex (0 1 2 0 3 4 5 3) box (5 1 4) simpleGrading (1 1 1));
boundary (back {{ type wedge; faces ((0 1 4 3)); }} front {{ type wedge; faces ((0 3 5 2)); }});
defaultPatch {{ name sides; type patch; }}
"""
SNAPPY = """castellatedMesh true; snap true; addLayers false; mergeTolerance 1e-6;
geometry { ball { type searchableSphere; centre (0 0 0); radius 0.5; } }
castellatedMeshControls
{
    maxLocalCells 100000; maxGlobalCells 200000; minRefinementCells 0; nCellsBetweenLevels 1; resolveFeatureAngle 30;
    features (); refinementSurfaces { ball { level (1 2); } } refinementRegions {} locationInMesh (-0.93 -0.91 -0.92);
    allowFreeStandingZoneFaces true;
}
snapControls { nSmoothPatch 2; tolerance 2; nSolveIter 10; nRelaxIter 3; }
addLayersControls
{
    relativeSizes true; layers {} expansionRatio 1; finalLayerThickness 0.3; minThickness 0.1; nGrow 0; featureAngle 60;
    nRelaxIter 3; nSmoothSurfaceNormals 1; nSmoothNormals 3; nSmoothThickness 10; maxFaceThicknessRatio 0.5;
    maxThicknessToMedialRatio 0.3; minMedianAxisAngle 90; nBufferCellsNoExtrude 0; nLayerIter 10;
}
meshQualityControls
{
    maxNonOrtho 65; maxBoundarySkewness 20; maxInternalSkewness 4; maxConcave 80; minVol 1e-13; minTetQuality 1e-15; minArea -1;
    minTwist 0.02; minDeterminant 0.001; minFaceWeight 0.05; minVolRatio 0.01; minTriangleTwist -1; nSmoothScale 4;
    errorReduction 0.75;
}
"""


def run(case, *command):
    """Runs a tool of OpenFOAM in a case."""
    line = f". {ETC} >/dev/null 2>&1; exec {' '.join(command)} -case {case}"
    # Some write files into the folder where they were started.
    done = subprocess.run(["bash", "-c", line], cwd=case, capture_output=True, text=True)
    assert done.returncode == 0, f"{command[0]} in {case}:\n{done.stdout[-1500:]}{done.stderr[-1500:]}"


def dictionaries(case, **further):
    """The files that every tool asks for, and further ones."""
    (case / "system").mkdir(parents=True, exist_ok=True)
    for name, text in {"controlDict": CONTROL, "fvSchemes": SCHEMES, "fvSolution": "\n", **further}.items():
        (case / "system" / name).write_text(HEADER.format(name) + text)
    return case


def cases(folder):
    """Cases with what OpenFOAM's tools need."""
    for name in ("ascii", "packed", "binary", "polyhedra"):
        shutil.copytree(TESTDATA / "openfoam" / name / MESH, folder / name / MESH)
        yield dictionaries(folder / name)
    for name, text in (("box", BOX), ("drawn", DRAWN)):
        case = dictionaries(folder / name, blockMeshDict=text.format())
        run(case, "blockMesh")
        yield case
    ball = dictionaries(folder / "ball", blockMeshDict=BOX.format(), snappyHexMeshDict=SNAPPY)
    run(ball, "blockMesh")
    run(ball, "snappyHexMesh", "-overwrite")
    yield ball
    dual = folder / "dual"
    shutil.copytree(folder / "drawn", dual, ignore=shutil.ignore_patterns("VTK"))
    run(dual, "polyDualMesh", "60", "-overwrite")
    yield dual
    yield one_cell(folder / "wedge", *WEDGE)
    yield one_cell(folder / "tet_wedge", *TET_WEDGE)


# Single cells with a collapsed edge: their points and faces.
WEDGE = (
    [(0, 0, 0), (1, 0, 0), (0.5, 1, 0), (0, 0, 1), (1, 0, 1), (0.8, 1, 1), (0.2, 1, 1)],
    [(0, 2, 1), (3, 4, 5, 6), (0, 1, 4, 3), (1, 2, 5, 4), (2, 6, 5), (0, 3, 6, 2)],
)
TET_WEDGE = (
    [(0, 0, 0), (1, 0, 0), (0.5, 1, 0), (0.2, 0.2, 1), (0.6, 0.3, 1)],
    [(0, 2, 1), (0, 1, 4, 3), (1, 2, 4), (2, 0, 3, 4)],
)


def one_cell(case, points, faces):
    """A case of one cell."""
    dictionaries(case)
    mesh = case / MESH
    mesh.mkdir(parents=True)
    listed = lambda rows: f"{len(rows)}\n(\n" + "".join(f"{row}\n" for row in rows) + ")\n"
    row = lambda values: "(" + " ".join(map(str, values)) + ")"
    patch = f"1\n(\nsides {{ type patch; nFaces {len(faces)}; startFace 0; }}\n)\n"
    for name, kind, text in [
        ("points", "vectorField", listed([row(point) for point in points])),
        ("faces", "faceList", listed([f"{len(face)}{row(face)}" for face in faces])),
        ("owner", "labelList", listed([0] * len(faces))),
        ("neighbour", "labelList", listed([])),
        ("boundary", "polyBoundaryMesh", patch),
    ]:
        (mesh / name).write_text(HEADER.format(name).replace("class dictionary", f"class {kind}") + text)
    return case


def by_foam_to_vtk(case, chosen):
    """The grid inside, and the patches by their names; `chosen` are options that choose the time and the region."""
    run(case, "foamToVTK", *chosen, "-no-point-data")
    # Of the mesh in constant and of that at the time 0, which is the same.
    inside = sorted(case.glob("VTK/**/internal.vtu"))[0]
    patches = {path.stem: pyvista.read(path) for path in inside.parent.glob("boundary/*.vtp")}
    return pyvista.read(inside), patches


def empty_patches(case):
    """Names of the patches of type `empty`."""
    path = next(path for path in case.rglob("polyMesh/boundary*") if path.name in ("boundary", "boundary.gz"))
    data = path.read_bytes()
    text = (gzip.decompress(data) if path.suffix == ".gz" else data).decode("latin1")
    return re.findall(r"(\S+)\s*\{[^{}]*\btype\s+empty\s*;", text)


def compare(case, out, path=None, step=None, chosen=("-constant", "-time", "0")):
    """What was compared: points, cells and faces. `path` is the case for azimesh, where it is another one."""
    theirs, patches = by_foam_to_vtk(case, chosen)
    grid, volume, tags, _ = foam.by_azimesh(path or case, out, step)
    assert np.array_equal(grid.points.astype(np.float32), theirs.points[: grid.n_points].astype(np.float32)), f"{case.name}: points"
    assert theirs.n_cells == len(volume), f"{case.name}: {len(volume)} cells, not {theirs.n_cells}"
    ours = grid.extract_cells(volume)
    by_node = np.asarray(ours.point_data["vtkOriginalPointIds"])
    for i, (own, other) in enumerate(zip(foam.cell_faces(ours), foam.cell_faces(theirs), strict=True)):
        own = frozenset(frozenset(int(by_node[n]) for n in face) for face in own)
        assert own == other, f"{case.name}: cell {i}"
        kinds = int(ours.celltypes[i]), int(theirs.celltypes[i])
        assert kinds[0] == kinds[1], f"{case.name}: cell {i} is a {kinds[0]}, not a {kinds[1]}"
    faces = 0
    for name in empty_patches(case):
        # OpenFOAM itself has no faces there.
        if name not in patches or patches[name].n_cells == 0:
            patches.pop(name, None)
            faces += len(tags[name])
    for name, patch in patches.items():
        assert foam.face_places(patch) == foam.face_places(grid, tags[name]), f"{case.name}: patch {name}"
        faces += patch.n_cells
    assert faces == grid.n_cells - len(volume), f"{case.name}: {faces} faces on patches"
    return grid.n_points, len(volume), faces


def main():
    """One line in all."""
    if not (ETC.exists() and shutil.which("foamToVTK")):
        print("foam_to_vtk: OpenFOAM is not installed: SKIPPED", file=sys.stderr)
        return
    found = {}
    with scratch() as folder:
        for case in cases(Path(folder)):
            found[case.name] = compare(case, folder / "out.vtu")
    cells = ", ".join(f"{name} {n}" for name, (_, n, _) in found.items())
    n = sum(sum(row) for row in found.values())
    report("foam_to_vtk", n, 0.0, "points, cells and faces", f"cells of {cells}")


if __name__ == "__main__":
    main()

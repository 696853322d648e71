"""OpenFOAM cases of OpenFOAM's own tools, in every encoding, read as VTK's reader has them, and as `foamToVTK` has where OpenFOAM is installed."""

import gzip
import re
import shutil

import numpy as np
import pyvista

import foam
from program import TESTDATA, azimesh, report, scratch

CASES = TESTDATA / "openfoam"
MESH = "constant/polyMesh"
READ = [
    ("ascii", {"step": 1, "time": 0.5, "points": CASES / "ascii/0.5/polyMesh/points"}),
    ("ascii", {"step": 2, "time": 1.0, "points": CASES / "ascii/1/polyMesh/points"}),
    ("packed", {}), ("binary", {}), ("wide_labels", {"long_labels": True}), ("polyhedra", {}),
]  # fmt: skip
# Single cells with a collapsed edge, `wedge` and `tetWedge`, which are polyhedra of both: their points and faces.
CELLS = {
    "wedge": (
        [(0, 0, 0), (1, 0, 0), (0.5, 1, 0), (0, 0, 1), (1, 0, 1), (0.8, 1, 1), (0.2, 1, 1)],
        [(0, 2, 1), (3, 4, 5, 6), (0, 1, 4, 3), (1, 2, 5, 4), (2, 6, 5), (0, 3, 6, 2)],
    ),
    "tet_wedge": ([(0, 0, 0), (1, 0, 0), (0.5, 1, 0), (0.2, 0.2, 1), (0.6, 0.3, 1)], [(0, 2, 1), (0, 1, 4, 3), (1, 2, 4), (2, 0, 3, 4)]),
}


def one_cell(case, points, faces):
    """A case of one cell."""
    (case / MESH).mkdir(parents=True)
    listed = lambda rows: f"{len(rows)}\n(\n" + "".join(f"{row}\n" for row in rows) + ")\n"  # noqa: E731
    row = lambda values: "(" + " ".join(map(str, values)) + ")"  # noqa: E731
    for name, kind, text in [
        ("points", "vectorField", listed([row(point) for point in points])),
        ("faces", "faceList", listed([f"{len(face)}{row(face)}" for face in faces])),
        ("owner", "labelList", listed([0] * len(faces))),
        ("neighbour", "labelList", listed([])),
        ("boundary", "polyBoundaryMesh", f"1\n(\nsides {{ type patch; nFaces {len(faces)}; startFace 0; }}\n)\n"),
    ]:
        (case / MESH / name).write_text(foam.HEADER.format(kind, name) + text)


def beside_foam_to_vtk(case, out):
    """Compares a case; the number of points, cells and faces."""
    foam.run(foam.make_system(case), "foamToVTK", "-constant", "-time", "0", "-no-point-data")
    inside = sorted(case.glob("VTK/**/internal.vtu"))[0]
    patches = {path.stem: pyvista.read(path) for path in inside.parent.glob("boundary/*.vtp")}
    mesh = foam.by_azimesh(case, out)
    path = next(path for path in case.rglob("polyMesh/boundary*") if path.name in ("boundary", "boundary.gz"))
    data = path.read_bytes()
    text = (gzip.decompress(data) if path.suffix == ".gz" else data).decode("latin1")
    # OpenFOAM itself has no faces on patches of the type `empty`.
    for name in re.findall(r"(\S+)\s*\{[^{}]*\btype\s+empty\s*;", text):
        patches[name] = mesh[0].extract_cells(mesh[2][name])
    return foam.compare(case.name, mesh, pyvista.read(inside), patches, same_kinds=True)


def main():
    """Single meshes and times, and pieces beside the mesh that was decomposed."""
    n, note = 0, "SKIPPED: foamToVTK, as OpenFOAM is not installed"
    with scratch() as folder:
        out = folder / "out.vtu"
        for name, told in READ:
            n += foam.beside_vtk(CASES / name, CASES / name, out, **{"time": 0.0, **told})
            grid, volume, tags, zones = foam.by_azimesh(CASES / name, out)
            assert np.array_equal(volume, np.arange(len(volume))), f"{name}: cells come first"
            assert len(zones) == 2 and len(tags) >= 4, (tags, zones)
        assert 42 in grid.celltypes, "polyhedra"
        for pieces, whole in [("decomposed", "ascii/constant/polyMesh"), ("collated", "binary")]:
            azimesh("diff", CASES / pieces, CASES / whole, "--tolerance", 1e-11)
        if foam.is_there("foamToVTK"):
            note = "VTK's reader and foamToVTK"
            for name in ("ascii", "packed", "binary", "polyhedra"):
                shutil.copytree(CASES / name / MESH, folder / name / MESH)
            for name, cell in CELLS.items():
                one_cell(folder / name, *cell)
            n += sum(beside_foam_to_vtk(folder / name, out) for name in ("ascii", "packed", "binary", "polyhedra", *CELLS))
    report("openfoam", n, 0, "nodes, cells and boundary faces", note)

"""OpenFOAM: cases that we write as VTK's reader sees them, and as checkMesh and foamToVTK do where OpenFOAM is installed.

VTK reads nodes, cells and the faces of each patch of single meshes, in binary and in text, and the nodes at every time
of a sequence. checkMesh (Debian: `apt-get install openfoam`; checked with v1912) has to find faces in order, closed cells, our volumes at every
time, and the metrics of faces that `azimesh quality` has; foamToVTK our nodes and `wantedDisplacement`. Without OpenFOAM that part is skipped.
"""

import json
import re
from pathlib import Path

import numpy as np
import pyvista

import foam
from program import TESTDATA, azimesh, report, scratch

MESHES = {
    "polyhedra_raw_zlib.vtu": [], "mixed_cells.su2": [], "sphere_in_box_raw.vtu": [], "rotor_sector.vtu": [],
    "naca0012.vtu": ["--extrude", "0.1"], "curved_solids_serendipity_v22.msh": ["--linearize"],
}  # fmt: skip
SCHEDULE = """azimuth.values = [0, 22.5, 45]
output = {{ format = "{format}", displacement = true }}
boundaries.fixed = ["inlet", "outlet", "walls"]
rbf.support_radius = 3.0
[[body]]
name = "sphere"
tags = ["sphere"]
rigid = {{ translate = [0.1, 0.05, 0.0], ramp = true }}
"""
PITCH = """
time = { stop = 0.4, step = 0.1, frequency = 1.0 }
boundaries = { fixed = ["farfield"], others = "free" }
rbf.support_radius = 6.0
output = { displacement = true, quality = "none" }
rotor = { span_axis = [0.0, 0.0, -1.0], shaft_axis = [0.0, 1.0, 0.0] }
[[body]]
name = "body"
tags = ["airfoil"]
cyclic = { collective = 2.0, pitch = [ { sin = 5.0 } ] }
"""
NUMBER = r"\s*[=:]?\s*([-+.\de]+)"
METRICS = {
    "max_non_orthogonality": "non-orthogonality Max" + NUMBER, "mean_non_orthogonality": r"non-orthogonality Max.*average" + NUMBER,
    "max_face_skewness": "Max skewness" + NUMBER, "min_volume_ratio": "Face volume ratio.*[mM]inimum" + NUMBER,
    "min_face_weight": "Face interpolation weight.*[mM]inimum" + NUMBER,
}  # fmt: skip


def check_mesh(folder, name, options):
    """A mesh in a case, in binary and in text, against the same in a .vtu; the number compared, and the case."""
    source, n = folder / "as.vtu", 0
    azimesh("convert", TESTDATA / name, source, "--force", *options)
    for encoding in ["ascii", "raw"]:
        case = folder / f"{Path(name).stem}_{encoding}"
        azimesh("convert", TESTDATA / name, case, "--format", "openfoam", "--encoding", encoding, *options)
        n += foam.beside_vtk(case, source, folder / "out.vtu")
    return n, case


def check_by_checkmesh(case, paths):
    """checkMesh finds a good topology, and of each of the paths the volume and the metrics of faces."""
    said = foam.run(foam.make_system(case), "checkMesh", "-allTopology", "-allGeometry")
    for line in ["Boundary definition OK", "Upper triangular ordering OK", "Cell to face addressing OK", "zip-up check OK"]:
        assert line in said, f"{case}: no \"{line}\" in\n{said}"
    assert said.count("Face pyramids OK") == said.count("Boundary openness") == len(paths), said
    found = [float(v) for v in re.findall(r"Total volume = ([^ ]+)\.", said)]
    judged = [json.loads(azimesh("quality", path, "--json")) for path in paths]
    assert np.allclose(found, [own["total_volume"] for own in judged], rtol=1e-5), f"{case}: volumes {found}"
    for name, pattern in METRICS.items():
        for own, printed in zip(judged, re.findall(pattern, said)):
            # It prints six digits.
            assert np.isclose(own[name], float(printed.rstrip(",.")), rtol=1e-4), f"{case}: {name} is {own[name]}, not {printed}"


def check_sequence(folder, has_openfoam):
    """The times of a sequence against the same in .vtu files."""
    mesh, case = TESTDATA / "sphere_in_box_raw.vtu", folder / "moving"
    foam.make_system(case)
    for name, out in [("openfoam", case), ("vtu", folder / "vtu")]:
        (folder / f"{name}.toml").write_text(SCHEDULE.format(format=name))
        azimesh("deform", mesh, folder / f"{name}.toml", "-o", out)
    paths = [folder / "vtu" / f"sphere_in_box_raw_{step:04}.vtu" for step in range(3)]
    steps = [pyvista.read(path) for path in paths]
    for step, time in zip(steps, ["constant", "22.5", "45"], strict=True):
        stored = foam.vectors(case / time / "polyMesh" / "points")
        assert np.array_equal(stored, step.points), f"{case}: points at {time}"
        inside = foam.by_vtk(case, time=0.0 if time == "constant" else float(time))["internalMesh"]
        assert np.array_equal(inside.points, step.points.astype(np.float32)), f"{case}: points at {time} as VTK reads them"
    if not has_openfoam:
        return
    check_by_checkmesh(case, paths)
    foam.run(case, "foamToVTK", "-no-boundary")
    written = sorted((case / "VTK").glob("moving_*/internal.vtu"), key=lambda path: int(path.parent.name.split("_")[1]))
    for step, path in zip(steps, written, strict=True):
        found = pyvista.read(path)
        assert np.array_equal(found.points, step.points.astype(np.float32)), f"{path}: nodes"
        assert np.array_equal(found.point_data["wantedDisplacement"], step.point_data["Displacement"].astype(np.float32)), f"{path}: displacement"


def patches(text):
    """{name: type} of the dictionaries within the outer brackets of a text."""
    return dict(re.findall(r'"?([\w.*]+)"?\s*\{[^{}]*?\btype\s+(\w+);', text))


def check_displacements(folder):
    """What a solver interpolates, as `fvMeshMovers::interpolator` looks for it: a pointVectorField in each folder that is named by a time, also 0, with
    an entry for each patch, constraint types under their own names; with it constant/polyMesh/points are the points of that time."""
    azimesh("convert", TESTDATA / "naca0012.vtu", folder / "airfoil", "--format", "openfoam", "--extrude", "0.1")
    (folder / "pitch.toml").write_text(PITCH)
    case = folder / "moved"
    azimesh("deform", folder / "airfoil", folder / "pitch.toml", "-o", case, "--format", "openfoam")
    base, n, most = foam.vectors(case / "constant/polyMesh/points"), 0, 0.0
    boundary = patches((case / "constant/polyMesh/boundary").read_text().partition("(")[2])
    assert set(boundary) == {"airfoil", "farfield", "back", "front"} and boundary["back"] == "empty", boundary
    fields = {float(path.parent.name): path for path in case.glob("*/wantedDisplacement")}
    assert np.allclose(sorted(fields), [0, 0.1, 0.2, 0.3, 0.4]), fields
    for path in fields.values():
        text, displacement = path.read_bytes().decode("latin1"), foam.vectors(path)
        for wanted in (r"class\s+pointVectorField;", r'object\s+"?wantedDisplacement"?;', r"\ndimensions\s+\[0 1 0 0 0 0 0\];"):
            assert re.search(wanted, text), f"{path}: no {wanted}"
        found = patches(text.partition("boundaryField")[2])
        assert all(found.get(name) == ("empty" if kind == "empty" else "calculated") for name, kind in boundary.items()), found
        points = path.parent / "polyMesh" / "points"
        places = foam.vectors(points if points.exists() else case / "constant/polyMesh/points")
        assert abs(base + displacement - places).max() < 1e-15, path
        n, most = n + len(places), max(most, abs(displacement).max())
    assert most > 0.01, "nothing moves"
    return n


def main():
    """One line in all."""
    has_openfoam, n = foam.is_there("checkMesh"), 0
    with scratch() as folder:
        for name, options in MESHES.items():
            compared, case = check_mesh(folder, name, options)
            n += compared
            if has_openfoam:
                check_by_checkmesh(case, [folder / "as.vtu"])
        check_sequence(folder, has_openfoam)
        n += check_displacements(folder)
    note = "VTK's reader, checkMesh and foamToVTK" if has_openfoam else "VTK's reader; SKIPPED: checkMesh, as OpenFOAM is not installed"
    report("openfoam_write", n, 0.0, "nodes, cells and faces", note)

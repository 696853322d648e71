"""Compares face metrics of `azimesh quality` with OpenFOAM's checkMesh, on the same mesh.

    python validation/check_faces_openfoam.py [--azimesh PROGRAM] MESH.vtu...

Needs checkMesh (Debian: `apt-get install openfoam`; checked with v1912) and pyvista. Solid meshes only. The
nodes inside are shaken first; the mesh is then given to OpenFOAM as a polyMesh of our own writing, faces
and all, and checkMesh writes its fields with 17 digits. What is compared: of each cell the largest
non-orthogonality (its cosine), skewness and the smallest volume ratio, and checkMesh's own summary.
Exits with 1 on a difference above 1e-8. Not part of scripts/test, which needs no OpenFOAM.
"""

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyvista

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts" / "verify"))
import faces as numpy_faces  # noqa: E402
import program  # noqa: E402

ETC = "/usr/share/openfoam/etc"
TOLERANCE = 1e-8
HEADER = "FoamFile {{ version 2.0; format ascii; class {}; object {}; }}\n"
CONTROL = """application checkMesh; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;
writeControl timeStep; writeInterval 1; writeFormat ascii; writePrecision 17; writeCompression off;
"""
SCHEMES = "ddtSchemes {} gradSchemes {} divSchemes {} laplacianSchemes {} interpolationSchemes {} snGradSchemes {}\n"


def write(path, kind, text):
    """A dictionary or a list of OpenFOAM."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(HEADER.format(kind, path.name) + text)


def write_case(folder, points, faces):
    """A case of nothing but a mesh."""
    rows = lambda values: f"{len(values)}\n(\n" + "\n".join(values) + "\n)\n"  # noqa: E731
    vector = lambda v: "(" + " ".join(map(str, v)) + ")"  # noqa: E731
    mesh = folder / "constant" / "polyMesh"
    write(mesh / "points", "vectorField", rows([vector(p) for p in points.tolist()]))
    write(mesh / "faces", "faceList", rows([f"{len(f)}{vector(f)}" for f in faces.nodes]))
    write(mesh / "owner", "labelList", rows(list(map(str, faces.owner))))
    write(mesh / "neighbour", "labelList", rows(list(map(str, faces.neighbour))))
    n = len(faces.neighbour)
    patch = f"outside {{ type patch; nFaces {len(faces.owner) - n}; startFace {n}; }}"
    write(mesh / "boundary", "polyBoundaryMesh", rows([patch]))
    write(folder / "system" / "controlDict", "dictionary", CONTROL)
    write(folder / "system" / "fvSchemes", "dictionary", SCHEMES)
    write(folder / "system" / "fvSolution", "dictionary", "")


def check_mesh(folder):
    """What checkMesh prints."""
    environment = {**os.environ, "WM_PROJECT_DIR": str(Path(ETC).parent), "FOAM_ETC": ETC}
    command = ["checkMesh", "-case", str(folder), "-allGeometry", "-writeAllFields"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def field(folder, name):
    """Internal values of a field that checkMesh wrote."""
    text = (folder / "constant" / name).read_text()
    found = re.search(r"internalField\s+nonuniform List<scalar>\s+\d+\s*\(([^)]*)\)", text)
    if found:
        return np.array(found.group(1).split(), float)
    return float(re.search(r"internalField\s+uniform (\S+);", text).group(1))


def printed(text, pattern):
    """A number of checkMesh's summary."""
    return float(re.search(pattern, text).group(1).rstrip(",."))


NUMBER = r"\s*[=:]?\s*([-+.\de]+)"
SUMMARY = {
    "max_non_orthogonality": "non-orthogonality Max" + NUMBER,
    "mean_non_orthogonality": r"non-orthogonality Max.*average" + NUMBER,
    "max_face_skewness": "Max skewness" + NUMBER,
    "min_volume_ratio": "Face volume ratio" + r".*[mM]inimum" + NUMBER,
    "min_face_weight": "Face interpolation weight" + r".*[mM]inimum" + NUMBER,
}


def check(path):
    """One mesh; whether all agrees."""
    grid = pyvista.read(path)
    faces = numpy_faces.Faces(grid)
    points = numpy_faces.shaken(grid)
    with program.scratch() as folder:
        for name, nodes in (("moved", points), ("plain", np.asarray(grid.points, float))):
            copy = grid.copy()
            copy.clear_data()
            copy.points = nodes
            copy.save(folder / f"{name}.vtu")
        results, out = numpy_faces.judged(folder / "moved.vtu", folder / "plain.vtu")
        write_case(folder / "case", points, faces)
        text = check_mesh(folder / "case")
        angle, skewness, ratio = (
            field(folder / "case", name) for name in ("nonOrthoAngle", "skewness", "cellVolumeRatio")
        )
    cosine = lambda degrees: np.cos(np.radians(degrees))  # noqa: E731
    # checkMesh counts boundary faces as orthogonal with a ratio of 1.
    ours = {name: np.asarray(out.cell_data[name])[faces.cells] for name in numpy_faces.ARRAYS}
    pairs = {
        "non-orthogonality (cosine)": (cosine(np.nan_to_num(ours["NonOrthogonality"], nan=0.0)), cosine(angle)),
        "skewness": (ours["FaceSkewness"], skewness),
        "volume ratio": (np.nan_to_num(ours["VolumeRatio"], nan=1.0), ratio),
    }
    worst = {name: np.abs(a - b).max() for name, (a, b) in pairs.items()}
    for name, pattern in SUMMARY.items():
        worst[name] = abs(results[name] - printed(text, pattern))
    good = max(worst.values()) < TOLERANCE
    told = ", ".join(f"{name} {error:.1e}" for name, error in worst.items())
    values = ", ".join(f"{name} {results[name]:.6g}" for name in SUMMARY)
    print(f"{'ok' if good else 'DIFFERENT'}: {path}: {len(faces.cells)} cells, {len(faces.owner)} faces; {values}")
    print(f"    largest difference: {told}", flush=True)
    return good


def main():
    """One mesh after another."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--azimesh", default=program.AZIMESH)
    parser.add_argument("mesh", nargs="+")
    arguments = parser.parse_args()
    program.AZIMESH = arguments.azimesh
    sys.exit(0 if all([check(path) for path in arguments.mesh]) else 1)


if __name__ == "__main__":
    main()

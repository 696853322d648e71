"""Makes testdata/openfoam with OpenFOAM's own tools (Debian's 1912): small cases in every encoding.

    . /usr/share/openfoam/etc/bashrc
    .venv/bin/python testdata/generate make_openfoam
"""

import re
import shutil
import struct
import subprocess
import tempfile
from pathlib import Path

import place

HERE = place.FOLDER / "openfoam"
HEADER = """FoamFile
{{
    version     2.0;
    format      ascii;
    class       dictionary;
    object      {};
}}
"""
CONTROL = """application potentialFoam;
startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1; writeControl timeStep; writeInterval 1;
writeFormat {}; writePrecision 12; writeCompression {}; timePrecision 6; runTimeModifiable no;
"""
BLOCKS = """scale 1;
vertices ((0 0 0) (2 0 0) (2 1 0) (0 1 0) (0 0 1) (2 0 1) (2 1 1) (0 1 1) (3 0 0) (3 1 0.5));
blocks
(
    hex (0 1 2 3 4 5 6 7) rotor (3 2 2) simpleGrading (1 2 1)
    hex (1 8 9 2 5 8 9 6) stator (2 2 2) simpleGrading (1 2 1)
);
edges ();
boundary
(
    inlet { type patch; faces ((0 4 7 3)); }
    floor { type wall; faces ((0 3 2 1) (1 2 9 8)); }
    nothing { type symmetryPlane; faces (); }
);
defaultPatch { name rest; type patch; }
"""
DECOMPOSE = "numberOfSubdomains 2; method simple; simpleCoeffs { n (2 1 1); delta 0.001; }\n"


def run(case, *command, **options):
    """Runs a tool of OpenFOAM in a case."""
    # Some write files into the folder where they were started.
    subprocess.run([*command, "-case", str(case)], cwd=case, check=True, stdout=subprocess.DEVNULL, **options)


def new_case(folder, form="ascii", compression="off"):
    """A case with a mesh of hexahedra and wedges in two zones."""
    (folder / "system").mkdir(parents=True)
    for name, text in [
        ("controlDict", CONTROL.format(form, compression)), ("blockMeshDict", BLOCKS), ("decomposeParDict", DECOMPOSE),
        ("fvSchemes", "divSchemes {} gradSchemes {} laplacianSchemes {}\n"), ("fvSolution", "\n"),
    ]:  # fmt: skip
        (folder / "system" / name).write_text(HEADER.format(name) + text)
    run(folder, "blockMesh")
    return folder


def moved(case, time, scale):
    """Points at a time: the mesh sheared, in the encoding of the case."""
    shutil.copytree(case, case.parent / "moving")
    run(case.parent / "moving", "transformPoints", "-scale", scale)
    (case / time / "polyMesh").mkdir(parents=True)
    for path in (case.parent / "moving/constant/polyMesh").glob("points*"):
        shutil.copy(path, case / time / "polyMesh")
    shutil.rmtree(case.parent / "moving")


def wide_labels(mesh):
    """Labels of 64 bits, and no `arch` to say so, as a real file of OpenFOAM 3.0.1 has them."""
    for name in ["faces", "owner", "neighbour", "cellZones"]:
        path = mesh / name
        data = re.sub(rb"    arch [^\n]*\n", b"", path.read_bytes())
        out, at = b"", data.index(b"// * *")
        out, data = data[:at], data[at:]
        while found := re.search(rb"\n(\d+)\s*\(", data):
            n, start = int(found[1]), found.end()
            if data[start + 4 * n : start + 4 * n + 1] != b")":
                out, data = out + data[:start], data[start:]
                continue
            labels = struct.unpack(f"<{n}i", data[start : start + 4 * n])
            out += data[:start] + struct.pack(f"<{n}q", *labels)
            data = data[start + 4 * n :]
        path.write_bytes(out + data)


def keep(case, name, *folders):
    """Copies what is read of a case."""
    target = HERE / name
    shutil.rmtree(target, ignore_errors=True)
    for folder in folders:
        shutil.copytree(case / folder, target / folder)
    for path in target.rglob("*"):
        if path.is_file() and path.name in ("cellLevel", "pointLevel", "level0Edge", "surfaceIndex"):
            path.unlink()
    (target / "case.foam").touch()


def main():
    """Makes all cases."""
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        mesh = "constant/polyMesh"
        case = new_case(scratch / "ascii")
        moved(case, "0.5", "(1 1 2)")
        moved(case, "1", "(1 2 1)")
        keep(case, "ascii", mesh, "0.5", "1")
        keep(new_case(scratch / "packed", "ascii", "on"), "packed", mesh)
        binary = new_case(scratch / "binary", "binary")
        keep(binary, "binary", mesh)
        wide_labels(binary / mesh)
        keep(binary, "wide_labels", mesh)
        parts = new_case(scratch / "parts")
        run(parts, "decomposePar")
        keep(parts, "decomposed", f"processor0/{mesh}", f"processor1/{mesh}")
        collated = new_case(scratch / "collated", "binary")
        run(collated, "decomposePar", "-fileHandler", "collated")
        keep(collated, "collated", f"processors2/{mesh}")
        dual = new_case(scratch / "dual", "binary")
        run(dual, "polyDualMesh", "60", "-overwrite")
        keep(dual, "polyhedra", mesh)

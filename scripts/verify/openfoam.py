"""OpenFOAM cases of OpenFOAM's own tools, in every encoding, read as VTK's reader has them."""

import foam
from program import TESTDATA, azimesh, report, scratch

CASES = TESTDATA / "openfoam"
MESH = "constant/polyMesh"


def main():
    """Compares single meshes and times with VTK's reader, and pieces with the mesh that was decomposed."""
    n = 0
    with scratch() as folder:
        out = folder / "out.vtu"
        for name, told in [
            ("ascii", {"step": 1, "time": 0.5, "points": CASES / "ascii/0.5/polyMesh/points"}),
            ("ascii", {"step": 2, "time": 1.0, "points": CASES / "ascii/1/polyMesh/points"}),
            ("packed", {}),
            ("binary", {}),
            ("wide_labels", {"long_labels": True}),
            ("polyhedra", {}),
        ]:
            told = {"time": 0.0, **told}
            found = foam.compare(CASES / name, CASES / name, out, **told)
            assert found["zones"] == 2 and found["tags"] >= 4, found
            n += found["points"] + found["cells"] + found["faces"]
        assert found["azimesh"].get(42), "polyhedra"
        for pieces, whole in [("decomposed", "ascii/constant/polyMesh"), ("collated", "binary")]:
            azimesh("diff", CASES / pieces, CASES / whole, "--tolerance", 1e-11)
    report("openfoam", n, 0, "nodes, cells and boundary faces")


if __name__ == "__main__":
    main()

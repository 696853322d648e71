"""What a solver of OpenFOAM interpolates: the fields `<time>/wantedDisplacement` of a sequence.

Read here as OpenFOAM's `fvMeshMovers::interpolator` and `uniformInterpolatedDisplacement` look for them, in a few lines: a pointVectorField in each
folder that is named by a time, with a vector for each point in the order of constant/polyMesh/points, an entry for each patch, and the
constraint types under their own names. `constant/polyMesh/points` plus the displacement are the points of that time, and at time 0 it is there too.
"""

import re

import numpy as np

from program import TESTDATA, azimesh, report, scratch

SCHEDULE = """
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
LIST = re.compile(rb"^\s*(?:internalField\s+nonuniform\s+List<vector>\s+)?(\d+)\s*\(", re.M)


def entries(text, names):
    """The values of some entries of a dictionary."""
    return {name: re.search(rf"^\s*{name}\s+(.*?);", text, re.M)[1].strip('"') for name in names}


def vectors(path):
    """(header, vectors, the text behind them) of a binary list of points or a field of vectors at points."""
    data = path.read_bytes()
    end = data.index(b"}") + 1
    header = entries(data[:end].decode(), ("format", "class", "object"))
    assert header["format"] == "binary", header
    found = LIST.search(data, end)
    count, start = int(found[1]), found.end()
    stop = start + 24 * count
    assert data[stop : stop + 1] == b")", f"{path}: a list of {count} vectors does not end there"
    before = data[end : found.start(1)].decode()
    return header, np.frombuffer(data[start:stop], "<f8").reshape(-1, 3), before, data[stop + 1 :].decode()


def patches(text):
    """{name: type} of the dictionaries within the outer brackets of a text."""
    return dict(re.findall(r'"?([\w.*]+)"?\s*\{[^{}]*?\btype\s+(\w+);', text))


def compare(case):
    """(number of points compared, largest distance) over all times."""
    _, base, *_ = vectors(case / "constant" / "polyMesh" / "points")
    boundary = patches((case / "constant" / "polyMesh" / "boundary").read_text().partition("(")[2])
    assert set(boundary) == {"airfoil", "farfield", "back", "front"} and boundary["back"] == "empty", boundary
    times = sorted(float(path.parent.name) for path in case.glob("*/wantedDisplacement"))
    assert np.allclose(times, [0, 0.1, 0.2, 0.3, 0.4]), times
    n, largest, most = 0, 0.0, 0.0
    for path in sorted(case.glob("*/wantedDisplacement")):
        header, displacement, before, after = vectors(path)
        assert (header["class"], header["object"]) == ("pointVectorField", "wantedDisplacement"), header
        assert re.search(r"^dimensions\s+\[0 1 0 0 0 0 0\];", before, re.M), before
        fields = patches(after.partition("boundaryField")[2])
        wanted = {name: "empty" if kind == "empty" else "calculated" for name, kind in boundary.items()}
        assert {name: fields.get(name) for name in wanted} == wanted, fields
        points = path.parent / "polyMesh" / "points"
        _, places, *_ = vectors(points if points.exists() else case / "constant" / "polyMesh" / "points")
        n += len(places)
        largest = max(largest, abs(base + displacement - places).max())
        most = max(most, abs(displacement).max())
    assert most > 0.01, "nothing moves"
    return n, largest


def main():
    """Displacements lead from the mesh of the case to the points of each time."""
    with scratch() as folder:
        azimesh("convert", TESTDATA / "naca0012.vtu", folder / "airfoil", "--format", "openfoam", "--extrude", "0.1")
        (folder / "pitch.toml").write_text(SCHEDULE)
        azimesh("deform", folder / "airfoil", folder / "pitch.toml", "-o", folder / "moved", "--format", "openfoam")
        n, largest = compare(folder / "moved")
    assert largest < 1e-15, largest
    report("openfoam_motion", n, largest, "points")


if __name__ == "__main__":
    main()

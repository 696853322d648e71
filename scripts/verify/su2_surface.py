"""The surface files of `output.surface = "su2"` as SU2 reads them.

SU2 is not among the programs that the tests install; what it does with these files is done here in a few lines
(CSurfaceMovement::SetExternal_Deformation): lines of an index and coordinates, no header, the index that of the
node in the mesh file, every node of MARKER_MOVING in it, file names that end in _00000.dat for iteration 0.
"""

import math

import meshes
import outputs
from program import TESTDATA, azimesh, report, scratch

SCHEDULE = """
time = {{ stop = 0.04, step = 0.01, frequency = 5.0 }}
boundaries.others = "fixed"
rbf.support_radius = 3.0
output = {{ format = "{format}", surface = "su2" }}
[[body]]
name = "body"
tags = ["airfoil"]
cyclic = {{ pitch = [ {{ sin = 3.0 }} ] }}
"""


def moved(path, dimension, nodes):
    """Where SU2 moves the nodes of its moving markers to, by the file of an iteration."""
    places = dict.fromkeys(nodes, (0.0,) * dimension)
    for line in path.read_text().splitlines():
        index, *coordinates = line.split()
        assert len(coordinates) >= dimension, f"{path}: {line}"
        if int(index) in places:
            places[int(index)] = tuple(map(float, coordinates[:dimension]))
    return places


def compare(format_name, folder):
    """(number of nodes compared, largest distance) over all iterations."""
    (folder / "pitch.toml").write_text(SCHEDULE.format(format=format_name))
    azimesh("deform", TESTDATA / "airfoil_hybrid.su2", folder / "pitch.toml", "-o", folder / format_name)
    mesh = meshes.by_meshio(TESTDATA / "airfoil_hybrid.su2")
    points, airfoil = mesh.points[:, :2].tolist(), outputs.tagged(mesh, "airfoil").tolist()
    n, largest, most = 0, 0.0, 0.0
    for step in range(5):
        mesh = folder / format_name / f"airfoil_hybrid_{step:04}.{format_name}"
        volume = folder / f"{format_name}_{step}.su2"
        azimesh("convert", mesh, volume)
        wanted = meshes.by_meshio(volume).points[:, :2].tolist()
        found = moved(folder / format_name / f"airfoil_hybrid_surface_{step:05}.dat", 2, airfoil)
        n += len(found)
        largest = max(largest, *(math.dist(place, wanted[node]) for node, place in found.items()))
        most = max(most, *(math.dist(place, points[node]) for node, place in found.items()))
    assert len(airfoil) > 10 and most > 0.01, "nothing moves"
    return n, largest


def main():
    """The surfaces of every iteration are those of the meshes, node by node."""
    with scratch() as folder:
        found = [compare(name, folder) for name in ("su2", "vtu")]
    n, largest = sum(n for n, _ in found), max(largest for _, largest in found)
    assert largest == 0.0, largest
    report("su2_surface", n, largest, "nodes of an airfoil")

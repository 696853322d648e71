"""Face metrics by plain numpy, face by face from OpenFOAM's formulas, beside the cell arrays and the
results of `azimesh quality`: on meshes of every kind of cell with their inner nodes shaken.
"""

import json

import numpy as np
import pyvista

from program import TESTDATA, azimesh, report, scratch

MESHES = [
    "mixed_cells_inline.vtu", "sphere_in_box_raw.vtu", "polyhedra_ascii.vtu", "hart_ii.vtu", "airfoil_hybrid_ascii.vtu", "naca0012.vtu",
]  # fmt: skip
ARRAYS = ["NonOrthogonality", "FaceSkewness", "VolumeRatio"]
SHAKEN = 0.15
TOLERANCE = 1e-10


class Faces:
    """The faces of a mesh's own cells, those between two cells first, in OpenFOAM's order.

    `nodes`: a tuple of nodes each, turning so that the normal points out of the owner; `owner`;
    `neighbour` of the first ones; `cells`: the places of the mesh's own cells in the file.
    """

    def __init__(self, grid):
        dimensions = np.array([cell.dimension for cell in grid.cell])
        self.dimension = dimensions.max()
        self.cells = np.flatnonzero(dimensions == self.dimension)
        points = np.asarray(grid.points, float)
        sides = {}
        for cell, place in enumerate(self.cells):
            whole = grid.get_cell(place)
            parts = whole.faces if self.dimension == 3 else whole.edges
            middle = points[whole.point_ids].mean(axis=0)
            for part in parts:
                nodes = tuple(part.point_ids)
                face, area = centre_and_area(points, nodes)
                if area @ (face - middle) < 0:
                    nodes = nodes[::-1]
                sides.setdefault(tuple(sorted(nodes)), []).append((cell, nodes))
        inner = sorted(s for s in ((pair[0][0], pair[1][0], pair[0][1]) for pair in sides.values() if len(pair) == 2))
        outer = sorted((pair[0][0], pair[0][1]) for pair in sides.values() if len(pair) == 1)
        assert len(inner) + len(outer) == len(sides), "no face has three cells"
        self.owner = np.array([s[0] for s in inner] + [s[0] for s in outer])
        self.neighbour = np.array([s[1] for s in inner], int)
        self.nodes = [s[2] for s in inner] + [s[1] for s in outer]


def centre_and_area(points, nodes):
    """Centre and normal of the length of the area; of an edge in the plane z = 0, to its right."""
    x = points[list(nodes)]
    if len(x) == 2:
        along = x[1] - x[0]
        return x.mean(axis=0), np.array([along[1], -along[0], 0.0])
    if len(x) == 3:
        return x.mean(axis=0), np.cross(x[1] - x[0], x[2] - x[0]) / 2
    middle, following = x.mean(axis=0), np.roll(x, -1, axis=0)
    normals = np.cross(following - x, middle - x)
    sizes = np.linalg.norm(normals, axis=1)
    centre = (sizes[:, None] * (x + following + middle)).sum(axis=0) / sizes.sum() / 3
    return centre, normals.sum(axis=0) / 2


def centres_and_volumes(faces, centre, area):
    """Of the cells, by pyramids (in the plane triangles) over their faces."""
    n, d = len(faces.cells), int(faces.dimension)
    sides = [(faces.owner, slice(None), 1.0), (faces.neighbour, slice(len(faces.neighbour)), -1.0)]
    sums, counts = np.zeros((n, 3)), np.zeros(n)
    for cell, which, _ in sides:
        np.add.at(sums, cell, centre[which])
        np.add.at(counts, cell, 1)
    middle = sums / counts[:, None]
    volume, moment = np.zeros(n), np.zeros((n, 3))
    for cell, which, sign in sides:
        part = sign * ((centre[which] - middle[cell]) * area[which]).sum(axis=1)
        np.add.at(volume, cell, part)
        np.add.at(moment, cell, part[:, None] * (d * centre[which] + middle[cell]) / (d + 1))
    return moment / volume[:, None], volume / d


def extents(points, faces, centre, direction, least):
    """How far each face reaches from its centre along a direction."""
    length = np.linalg.norm(direction, axis=1)
    unit = direction / np.where(length > 0, length, 1)[:, None]
    return np.maximum([np.abs((points[list(nodes)] - c) @ u).max() for nodes, c, u in zip(faces.nodes, centre, unit)], least)


def metrics(points, faces):
    """Cosine, volume ratio and weight of the faces between two cells; skewness of all."""
    shapes = [centre_and_area(points, nodes) for nodes in faces.nodes]
    centre, area = np.array([s[0] for s in shapes]), np.array([s[1] for s in shapes])
    cells, volume = centres_and_volumes(faces, centre, area)
    n = len(faces.neighbour)
    own, other = faces.owner[:n], faces.neighbour
    between, to_face = cells[other] - cells[own], centre - cells[faces.owner]
    dot = lambda a, b: (a * b).sum(axis=1)  # noqa: E731
    length, size = np.linalg.norm(between, axis=1), np.linalg.norm(area, axis=1)
    cosine = dot(between, area[:n]) / (length * size[:n])
    off = to_face.copy()
    off[:n] -= (dot(area[:n], to_face[:n]) / dot(area[:n], between))[:, None] * between
    unit = area[n:] / size[n:, None]
    height = dot(unit, to_face[n:])
    off[n:] -= height[:, None] * unit
    least = np.concatenate([0.2 * length, 0.4 * np.abs(height)])
    before, after = np.abs(dot(area[:n], to_face[:n])), np.abs(dot(area[:n], cells[other] - centre[:n]))
    return {
        "cosine": cosine, "skewness": np.linalg.norm(off, axis=1) / extents(points, faces, centre, off, least),
        "ratio": np.minimum(volume[own], volume[other]) / np.maximum(volume[own], volume[other]),
        "weight": np.minimum(before, after) / (before + after),
    }  # fmt: skip


def worst_of_cells(faces, values, worst, start):
    """Of each cell over its faces; `worst` is np.maximum or np.minimum."""
    found = np.full(len(faces.cells), start)
    worst.at(found, faces.owner[: len(values)], values)
    worst.at(found, faces.neighbour, values[: len(faces.neighbour)])
    return found


def shaken(grid, seed=1):
    """Nodes that lie on no outer face, moved at random by a part of the shortest edge at each."""
    faces = Faces(grid)
    points = np.array(grid.points, float)
    reach = np.full(len(points), np.inf)
    for nodes in faces.nodes:
        for a, b in zip(nodes, nodes[1:] + nodes[:1]):
            reach[[a, b]] = np.minimum(reach[[a, b]], np.linalg.norm(points[a] - points[b]))
    for nodes in faces.nodes[len(faces.neighbour) :]:
        reach[list(nodes)] = 0.0
    step = np.random.default_rng(seed).uniform(-1, 1, points.shape)
    step[:, faces.dimension :] = 0.0
    return points + SHAKEN * np.where(np.isfinite(reach), reach, 0)[:, None] * step


def judged(grid, points):
    """Results of `azimesh quality` for a grid with moved nodes against itself, and the mesh with the cell arrays it writes."""
    with scratch() as folder:
        for name, nodes in (("moved", points), ("plain", np.asarray(grid.points, float))):
            copy = grid.copy()
            copy.clear_data()
            copy.points = nodes
            copy.save(folder / f"{name}.vtu")
        out = folder / "judged.vtu"
        text = azimesh("quality", folder / "moved.vtu", "--reference", folder / "plain.vtu", "-o", out, "--json")
        return json.loads(text), pyvista.read(out)


def angle(cosine):
    """In degrees."""
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def same_as_their_cells(found, grid, faces):
    """Whether boundary faces have the value of the cell that they bound, the first of two, and all other cells
    below the mesh's own dimension none."""
    owner = {tuple(sorted(nodes)): faces.cells[cell] for nodes, cell in zip(faces.nodes, faces.owner)}
    wanted = found.copy()
    for place in np.setdiff1d(np.arange(grid.n_cells), faces.cells):
        cell = owner.get(tuple(sorted(grid.get_cell(place).point_ids)))
        wanted[place] = np.nan if cell is None else found[cell]
    return np.array_equal(wanted, found, equal_nan=True)


def compare(path):
    """One mesh; returns how many values were compared and the largest difference."""
    grid = pyvista.read(path)
    faces = Faces(grid)
    points = shaken(grid)
    results, out = judged(grid, points)
    ours = metrics(points, faces)
    wanted = {
        "max_non_orthogonality": angle(ours["cosine"].min()), "mean_non_orthogonality": angle(ours["cosine"].mean()),
        "max_face_skewness": ours["skewness"].max(), "min_volume_ratio": ours["ratio"].min(), "min_face_weight": ours["weight"].min(),
    }  # fmt: skip
    differences = [abs(results[name] - value) for name, value in wanted.items()]
    assert results["inner_faces"] == len(faces.neighbour) and results["outer_faces"] == len(faces.owner) - len(
        faces.neighbour
    ), f"{path}: another number of faces"
    of_cells = {
        "NonOrthogonality": worst_of_cells(faces, ours["cosine"], np.minimum, np.inf),
        "FaceSkewness": worst_of_cells(faces, ours["skewness"], np.maximum, -np.inf),
        "VolumeRatio": worst_of_cells(faces, ours["ratio"], np.minimum, np.inf),
    }
    n = len(differences)
    for name, value in of_cells.items():
        found = np.asarray(out.cell_data[name])
        assert same_as_their_cells(found, grid, faces), f"{path}: {name} of a boundary face"
        found = found[faces.cells]
        assert (np.isnan(found) == np.isinf(value)).all(), f"{path}: {name} is missing"
        known = ~np.isnan(found)
        found = np.cos(np.radians(found)) if name == "NonOrthogonality" else found
        differences.append(np.abs(found[known] - value[known]).max())
        n += known.sum()
    return n, max(differences)


def main():
    """One line for all meshes."""
    n, largest = 0, 0.0
    for name in MESHES:
        count, difference = compare(TESTDATA / name)
        assert difference < TOLERANCE, f"{name}: face metrics differ by {difference:.3g}"
        n, largest = n + count, max(largest, difference)
    report("face metrics beside numpy", n, largest, note=f"{len(MESHES)} meshes")

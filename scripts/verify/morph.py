"""Morph against dense numpy: A d, its transpose and the exact surface, on 2D, 3D, sliding and periodic meshes.

The example `morph_by_files` runs it, on displacements and derivatives that are random numbers. Here the whole
matrix A is made from its definition in docs/method.md: dense solves, closest points by trying every facet.
"""

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

import meshes
from outputs import tagged
from program import AZIMESH, TESTDATA, report, scratch
from reference import kernel_matrix, rotation

EXAMPLE = Path(os.environ.get("MORPH_BY_FILES", Path(AZIMESH).parent / "examples" / "morph_by_files"))


@dataclass
class Case:
    """A mesh, its tags by role, and the normal of the plane that slides."""

    mesh: str
    moving: str
    fixed: tuple
    slide: str = ""
    normal: tuple = (0.0, 0.0, 0.0)
    radius: float = 4.0
    max_points: int = 60
    periodic: tuple = ()
    angles: tuple = (0.0,)  # degrees about z: the identity and the images

    def run(self, folder):
        """Runs the example on what lies in the folder."""
        settings = [f"moving={self.moving}", f"fixed={','.join(self.fixed)}", f"max_points={self.max_points}"]
        settings += [f"support_radius={self.radius}", "tolerance=1e-9"]
        settings += [f"slide={self.slide}"] if self.slide else []
        settings += [f"periodic={':'.join(self.periodic)}"] if self.periodic else []
        subprocess.run([EXAMPLE, TESTDATA / self.mesh, folder, *settings], check=True, capture_output=True)


CASES = [
    Case("naca0012.vtu", "airfoil", ("farfield",), max_points=40),
    Case("sphere_in_box_raw.vtu", "sphere", ("inlet", "outlet")),
    Case("wing_on_plane.vtu", "wing", ("farfield",), "symmetry", (0.0, 0.0, 1.0)),
    Case("rotor_sector.vtu", "blade", ("hub_wall", "outer", "bottom", "top"), radius=3.0,
         periodic=("side_a", "side_b"), angles=(0.0, 90.0, 180.0, 270.0)),
]  # fmt: skip


class Dense:
    """The matrix A of one case, (3 nodes, 3 moving nodes)."""

    def __init__(self, case, mesh, base):
        self.case, self.mesh, self.x = case, mesh, mesh.points
        self.n = len(self.x)
        self.moving = tagged(mesh, case.moving)
        self.fixed = np.setdiff1d(tagged(mesh, *case.fixed), self.moving)
        sliding = tagged(mesh, case.slide) if case.slide else np.array([], int)
        self.sliding = np.setdiff1d(sliding, np.union1d(self.moving, self.fixed))
        self.surface = np.concatenate([self.moving, self.fixed, self.sliding])
        self.base = base
        self.turns = [rotation([0, 0, 1], np.radians(angle)) for angle in case.angles]
        self.images = [self.x[base] @ turn.T for turn in self.turns]
        self.followers()
        self.build()

    def followers(self):
        """Nodes of the second side, the node that each follows, and the rotation between them."""
        self.pairs = []
        if self.case.periodic:
            a, b = (tagged(self.mesh, side) for side in self.case.periodic)
            for turn in (self.turns[1], self.turns[-1]):
                away = np.linalg.norm((self.x[a] @ turn.T)[:, None] - self.x[b][None], axis=2)
                if away.min(axis=1).max() < 1e-6:
                    for i, j in zip(a, b[away.argmin(axis=1)]):
                        lead, follow, map = (i, j, turn) if i < j else (j, i, turn.T)
                        if i != j:
                            self.pairs.append((lead, follow, map))
                    return
            raise AssertionError("the sides are not images of each other")

    def held(self):
        """N N^T at each surface node: everything, or the normal of the plane."""
        everything = np.broadcast_to(np.eye(3), (len(self.surface), 3, 3)).copy()
        slides = np.isin(self.surface, self.sliding)
        everything[slides] = np.outer(self.case.normal, self.case.normal)
        return everything

    def phi(self, at):
        """sum_g phi R_g between places and base points, (3 at, 3 base)."""
        blocks = sum(
            np.kron(kernel_matrix("wendland-c2", self.case.radius, at, image), turn)
            for image, turn in zip(self.images, self.turns)
        )
        return blocks

    def build(self):
        """A as the method has it, one step after the other."""
        n, m = 3 * self.n, 3 * len(self.moving)
        values = np.zeros((n, m))  # what is prescribed, at all nodes
        values[rows(self.moving)] = np.eye(m)
        held = self.held()
        place = {node: i for i, node in enumerate(self.surface)}
        columns = []  # N of the base points
        for i, node in enumerate(self.base):
            at = held[place[node]]
            directions = np.eye(3) if np.allclose(at, np.eye(3)) else np.array([self.case.normal]).T
            block = np.zeros((3 * len(self.base), directions.shape[1]))
            block[3 * i : 3 * i + 3] = directions
            columns.append(block)
        normals = np.hstack(columns)
        system = normals.T @ self.phi(self.x[self.base]) @ normals
        self.condition = np.linalg.cond(system)
        weights = normals @ np.linalg.solve(system, normals.T @ values[rows(self.base)])
        moved = np.vstack([self.phi(part) @ weights for part in np.array_split(self.x, 8)])
        residual = np.zeros((n, m))
        for at, node in zip(held, self.surface):
            three = slice(3 * node, 3 * node + 3)
            residual[three] = at @ (values[three] - moved[three])
        moved += self.correction(residual)
        moved[rows(self.moving)] = np.eye(m)
        moved[rows(self.fixed)] = 0.0
        free = np.eye(3) - np.outer(self.case.normal, self.case.normal)
        for node in self.sliding:
            moved[3 * node : 3 * node + 3] = free @ moved[3 * node : 3 * node + 3]
        for lead, follow, turn in self.pairs:
            if follow not in self.fixed:
                moved[3 * follow : 3 * follow + 3] = turn @ moved[3 * lead : 3 * lead + 3]
        self.a = moved
        if self.mesh.dimension == 2:
            self.a = moved * np.tile([1.0, 1.0, 0.0], len(self.moving))

    def facets(self):
        """Triangles, or edges with the second node repeated, between the surface nodes."""
        known = set(self.surface)
        found = []
        for _, nodes in self.mesh.cells[self.mesh.dimension - 1]:
            if set(nodes) <= known:
                last = nodes[-1]
                found += [(nodes[0], nodes[1], last)] if len(nodes) < 4 else [nodes[:3], (nodes[0], *nodes[2:])]
        return np.array(found)

    def continued(self):
        """Points, facets, and the node and turn of each point: the surface, then what its images add to it."""
        facets, known = self.facets(), list(self.surface)
        points, of = list(self.x), [(node, self.turns[0]) for node in range(self.n)]
        everywhere = [facets]
        for turn in self.turns[1:]:
            place = {}
            for node in np.unique(facets):
                x = turn @ self.x[node]
                away = np.linalg.norm(np.array(points)[known] - x, axis=1)
                place[node] = known[away.argmin()] if away.min() < 1e-6 else len(points)
                if place[node] == len(points):
                    points.append(x)
                    of.append((node, turn))
                    known.append(place[node])
            everywhere.append(np.vectorize(place.get)(facets))
        return np.array(points), np.vstack(everywhere), of

    def correction(self, residual):
        """What the residuals of the surface and its images add at every node."""
        points, facets, of = self.continued()
        reach = self.reach(points, facets)
        rho_at = np.array([reach[node] for node, _ in of])
        added = np.zeros_like(residual)
        for node in range(self.n):
            corners, weights, away = closest(self.x[node], points, facets)
            rho = weights @ rho_at[corners]
            if rho > 0.0 and away < rho:
                xi = away / rho
                fade = (1 - xi) ** 4 * (4 * xi + 1)
                for corner, weight in zip(corners, weights):
                    source, turn = of[corner]
                    added[3 * node : 3 * node + 3] += fade * weight * turn @ residual[3 * source : 3 * source + 3]
        return added

    def reach(self, points, facets):
        """The distance of the base point that is third or fourth nearest, at most half the gap; by node."""
        base = np.vstack(self.images)
        nearest = np.sort(np.linalg.norm(self.x[self.surface][:, None] - base[None], axis=2), axis=1)
        reach = np.zeros(self.n)
        reach[self.surface] = nearest[:, self.mesh.dimension]
        beyond = (nearest[:, 0] >= self.case.radius) & ~np.isin(self.surface, self.moving)
        reach[self.surface[beyond]] = 0.0
        part = components(facets)
        for node in np.unique(facets[facets < self.n]):
            others = facets[part[facets[:, 0]] != part[node]]
            if len(others):
                reach[node] = min(reach[node], 0.5 * closest(self.x[node], points, others)[2])
        return reach


def rows(nodes):
    """The three rows of each node."""
    return (3 * np.asarray(nodes)[:, None] + np.arange(3)).ravel()


def components(facets):
    """A number for the connected surface of each node."""
    n = facets.max() + 1
    edges = facets[:, [0, 1, 0, 2]].reshape(-1, 2)
    return connected_components(coo_array((np.ones(len(edges)), edges.T), shape=(n, n)), directed=False)[1]


def closest(x, points, facets):
    """Corners, weights and distance of the point of the facets that is closest to x: corners, edges, insides."""
    a, b, c = (points[facets[:, corner]] for corner in range(3))
    best = [(np.linalg.norm(x - a, axis=1), np.tile([1.0, 0.0, 0.0], (len(facets), 1)))]
    identity = np.eye(3)
    for (p, q), (i, j) in zip([(a, b), (b, c), (c, a)], [(0, 1), (1, 2), (2, 0)]):
        along = q - p
        length = np.maximum((along**2).sum(axis=1), 1e-300)
        t = np.clip(((x - p) * along).sum(axis=1) / length, 0.0, 1.0)
        weights = (1 - t)[:, None] * identity[i] + t[:, None] * identity[j]
        best.append((np.linalg.norm(x - p - t[:, None] * along, axis=1), weights))
    u, v, w = b - a, c - a, x - a
    uu, uv, vv = (u * u).sum(1), (u * v).sum(1), (v * v).sum(1)
    area = uu * vv - uv * uv
    solid = area > 1e-14 * uu * vv
    area = np.where(solid, area, 1.0)
    s = (vv * (w * u).sum(1) - uv * (w * v).sum(1)) / area
    t = (uu * (w * v).sum(1) - uv * (w * u).sum(1)) / area
    away = np.where(solid & (s >= 0) & (t >= 0) & (s + t <= 1), np.linalg.norm(w - s[:, None] * u - t[:, None] * v, axis=1), np.inf)
    best.append((away, np.stack([1 - s - t, s, t], axis=1)))
    distances = np.stack([away for away, _ in best])
    how, facet = np.unravel_index(distances.argmin(), distances.shape)
    return facets[facet], best[how][1][facet], distances[how, facet]


def check(case, folder):
    """(values compared, largest difference of A d and of A^T g relative to the largest value, condition number)."""
    mesh = meshes.by_pyvista(TESTDATA / case.mesh)
    random = np.random.default_rng(7)
    moving = tagged(mesh, case.moving)
    d = random.standard_normal((len(moving), 3))
    g = random.standard_normal((len(mesh.points), 3))
    if mesh.dimension == 2:
        d[:, 2] = 0.0
    (folder / "displacements.f64").write_bytes(d.astype("<f8").tobytes())
    (folder / "gradient.f64").write_bytes(g.astype("<f8").tobytes())
    case.run(folder)
    found = {name: np.fromfile(folder / f"{name}.f64", "<f8") for name in ("moved", "points", "pulled_back")}
    dense = Dense(case, mesh, np.fromfile(folder / "base_points.u32", "<u4").astype(int))
    wanted, back = dense.a @ d.ravel(), dense.a.T @ g.ravel()
    difference = max(
        np.abs(found["moved"] - wanted).max() / np.abs(wanted).max(), np.abs(found["pulled_back"] - back).max() / np.abs(back).max(),
        np.abs(found["points"] - mesh.points.ravel() - wanted).max() / np.abs(wanted).max(),
    )  # fmt: skip
    exact = found["points"].reshape(-1, 3)
    assert (exact[moving] == mesh.points[moving] + d).all(), f"{case.mesh}: moving nodes are not exact"
    assert (exact[dense.fixed] == mesh.points[dense.fixed]).all(), f"{case.mesh}: fixed nodes have moved"
    inner = abs(g.ravel() @ found["moved"] - found["pulled_back"] @ d.ravel())
    inner /= np.linalg.norm(g) * np.linalg.norm(found["moved"])
    return len(wanted) + len(back), difference, inner, dense.condition


def main():
    """One line a mesh."""
    for case in CASES:
        with scratch() as folder:
            n_values, largest, inner, condition = check(case, folder)
        limit = max(1e-10, 100 * np.finfo(float).eps * condition)
        kind = "periodic" if case.periodic else "sliding" if case.slide else "fixed"
        note = f"limit {limit:.1e}, <g, A d> off by {inner:.1e}, cond(Phi) {condition:.1e}"
        report(f"morph, {case.mesh}, {kind}", n_values, largest, "values", note)
        assert largest <= limit, f"{case.mesh}: {largest} exceeds {limit}"
        assert inner <= 1e-20 * max(condition, 1e8), f"{case.mesh}: the transpose is off by {inner}"

"""The method in plain numpy: rotor motion, Wendland kernels, dense solve and evaluation.

Written from the equations alone (Sheng & Allen 2013, eqs. 2, 3, 11 and table 1), to compare
azimesh with. Angles in degrees where a schedule has them. No beam tables.
"""

import tomllib
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

# Table 1 of the paper, normalised to phi(0) = 1; 0 <= xi <= 1.
KERNELS = {
    "wendland-c0": lambda xi: (1 - xi) ** 2,
    "wendland-c2": lambda xi: (1 - xi) ** 4 * (4 * xi + 1),
    "wendland-c4": lambda xi: (1 - xi) ** 6 * (35 * xi**2 + 18 * xi + 3) / 3,
    "wendland-c6": lambda xi: (1 - xi) ** 8 * (32 * xi**3 + 25 * xi**2 + 8 * xi + 1),
}


def rotation(axis, angle):
    """The matrix that turns by `angle` (rad) about `axis`, right-handed (Rodrigues)."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def kernel_matrix(name, radius, at, base):
    """phi(|x - x_i| / R) of every point in `at` and every base point, (len(at), len(base))."""
    distance = np.sqrt(((at[:, None, :] - base[None, :, :]) ** 2).sum(axis=2))
    return KERNELS[name](np.minimum(distance / radius, 1.0))


class Motion:
    """What a schedule prescribes on a mesh (as `meshes.Mesh` has it)."""

    def __init__(self, path, mesh):
        self.schedule = tomllib.loads(Path(path).read_text())
        self.mesh = mesh
        self.axes(self.schedule.get("rotor", {}))
        self.roles(self.schedule.get("boundaries", {}))

    def axes(self, rotor):
        """Hub and frame; the columns of `frame` are e_x (span), e_y, e_z (shaft)."""
        plane = self.mesh.dimension == 2
        span = np.array(rotor.get("span_axis", [0, 0, -1] if plane else [1, 0, 0]), float)
        shaft = np.array(rotor.get("shaft_axis", [0, 1, 0] if plane else [0, 0, 1]), float)
        span, shaft = span / np.linalg.norm(span), shaft / np.linalg.norm(shaft)
        self.hub = np.array(rotor.get("hub", [0, 0, 0]), float)
        self.frame = np.column_stack([span, np.cross(shaft, span), shaft])
        self.inertial = rotor.get("frame", "rotating") == "inertial"
        self.signs = {name: rotor.get(f"{name}_sign", 1) for name in ("pitch", "flap", "lag")}

    def tagged(self, patterns):
        """Nodes on the boundary tags that match."""
        nodes = set()
        for name, faces in self.mesh.tags.items():
            if any(fnmatchcase(name, pattern) for pattern in patterns):
                nodes.update(node for face in faces for node in face)
        return nodes

    def roles(self, boundaries):
        """Which nodes move with which body, and which stay: moving is stronger than fixed."""
        taken = set()
        self.moving = []
        for body in self.schedule["body"]:
            nodes = self.tagged(body["tags"]) - taken
            taken |= nodes
            self.moving.append((body, np.array(sorted(nodes))))
        fixed = boundaries.get("fixed", [])
        if boundaries.get("others") == "fixed":
            named = [tag for body in self.schedule["body"] for tag in body["tags"]]
            named += boundaries.get("slide", [])
            others = [t for t in self.mesh.tags if not any(fnmatchcase(t, p) for p in named)]
            fixed = [*fixed, *others]
        self.fixed = np.array(sorted(self.tagged(fixed) - taken), int)

    def azimuths(self):
        """The azimuth of each step, degrees."""
        azimuth = self.schedule["azimuth"]
        if "values" in azimuth:
            return [float(value) for value in azimuth["values"]]
        start, stop, step = (float(azimuth[key]) for key in ("start", "stop", "step"))
        count = int(np.floor((stop - start) / step * (1 + 1e-12))) + 1
        return [start + i * step for i in range(count)]

    def moved(self, body, nodes, azimuth, progress):
        """Positions of a body's nodes in the rotating frame: rigid, then cyclic."""
        x = self.mesh.points[nodes]
        if "rigid" in body:
            x = rigid(body["rigid"], x, progress)
        if "cyclic" in body:
            x = self.cyclic(body, x, azimuth)
        return x

    def cyclic(self, body, x, azimuth):
        """Eqs. 2, 3 and 11 without a beam, in the blade's frame at its azimuth."""
        motion = body["cyclic"]
        offset = body.get("azimuth_offset", 0.0)
        psi = np.radians(azimuth + offset)
        angle = {
            name: self.signs[name] * harmonics(motion, name, mean, psi)
            for name, mean in (("pitch", "collective"), ("flap", "coning"), ("lag", None))
        }
        e_x, e_y, e_z = np.eye(3)
        hinge = motion.get("flap_hinge", 0.0) * e_x
        blade = rotation(self.frame[:, 2], np.radians(offset)) @ self.frame
        local = (x - self.hub) @ blade
        reference = np.outer(local[:, 0], e_x) + [0.0, *motion.get("pitch_axis", [0.0, 0.0])]
        x_r = (local - reference) @ rotation(e_x, angle["pitch"]).T
        hinged = rotation(e_z, angle["lag"]) @ rotation(e_y, -angle["flap"])
        turned = hinge + (x_r + reference - hinge) @ hinged.T
        return self.hub + turned @ blade.T

    def step(self, k):
        """Base points, their positions in the rotating frame, and how many of them move."""
        azimuths = self.azimuths()
        progress = k / (len(azimuths) - 1) if len(azimuths) > 1 else 1.0
        target = self.mesh.points.copy()
        for body, nodes in self.moving:
            target[nodes] = self.moved(body, nodes, azimuths[k], progress)
        return target

    def carried(self, points, k):
        """In the inertial frame, everything turned by the azimuth about the shaft."""
        if not self.inertial:
            return points
        turn = rotation(self.frame[:, 2], np.radians(self.azimuths()[k]))
        return self.hub + (points - self.hub) @ turn.T

    def surface_nodes(self):
        """All nodes with a prescribed position."""
        return np.unique(np.concatenate([nodes for _, nodes in self.moving] + [self.fixed]))

    def distinct_surface_nodes(self):
        """The same with coincident nodes taken once."""
        nodes = self.surface_nodes()
        _, first = np.unique(self.mesh.points[nodes], axis=0, return_index=True)
        return nodes[np.sort(first)]


def rigid(motion, x, progress):
    """Rotation about an origin, then translation; a ramp does a part of both."""
    part = progress if motion.get("ramp", False) else 1.0
    if "rotate" in motion:
        turn = motion["rotate"]
        matrix = rotation(turn["axis"], np.radians(turn["angle"]) * part)
        origin = np.array(turn.get("origin", [0, 0, 0]), float)
        x = origin + (x - origin) @ matrix.T
    return x + part * np.array(motion.get("translate", [0, 0, 0]), float)


def harmonics(motion, name, mean, psi):
    """Eq. 11: mean + sum over m of A_m sin(m psi + delta) + B_m cos(m psi + delta), in radians."""
    delta = np.radians(motion.get("phase", 0.0))
    angle = motion.get(mean, 0.0) if mean else 0.0
    for m, term in enumerate(motion.get(name, []), start=1):
        angle += term.get("sin", 0.0) * np.sin(m * psi + delta)
        angle += term.get("cos", 0.0) * np.cos(m * psi + delta)
    return np.radians(angle)


class Interpolant:
    """Displacements at base points carried to all nodes by a dense solve."""

    def __init__(self, motion, base_nodes):
        rbf = motion.schedule["rbf"]
        self.kernel = rbf.get("kernel", "wendland-c2")
        self.radius = rbf["support_radius"]
        self.points = motion.mesh.points
        self.base = base_nodes
        self.phi = kernel_matrix(self.kernel, self.radius, self.points[base_nodes], self.points[base_nodes])

    def condition(self):
        """Condition number of Phi_bb in the 2-norm."""
        return np.linalg.cond(self.phi)

    def displacements(self, at, target):
        """Interpolated displacement at the nodes `at`; `target` holds positions of all nodes."""
        weights = np.linalg.solve(self.phi, target[self.base] - self.points[self.base])
        return kernel_matrix(self.kernel, self.radius, self.points[at], self.points[self.base]) @ weights

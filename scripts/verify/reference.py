"""The method in plain numpy: rotor motion, Wendland kernels, dense solve and evaluation.

Written from the equations alone (Sheng & Allen 2013, eqs. 2, 3, 11 and table 1), to compare
azimesh with. Angles in degrees where a schedule has them.
"""

import csv
import tomllib
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

# Table 1 of the paper, normalised to phi(0) = 1; 0 <= xi <= 1.
KERNELS = {
    "wendland-c0": lambda xi: (1 - xi) ** 2, "wendland-c2": lambda xi: (1 - xi) ** 4 * (4 * xi + 1),
    "wendland-c4": lambda xi: (1 - xi) ** 6 * (35 * xi**2 + 18 * xi + 3) / 3,
    "wendland-c6": lambda xi: (1 - xi) ** 8 * (32 * xi**3 + 25 * xi**2 + 8 * xi + 1),
}  # fmt: skip


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
        self.folder = Path(path).parent
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
        if "time" in self.schedule:
            return [360.0 * self.schedule["time"].get("frequency", 0.0) * t for t in self.times()]
        return self.values("azimuth")

    def times(self):
        """The time of each step in s; none without rpm or [time]."""
        if "time" in self.schedule:
            return self.values("time")
        rpm = self.schedule.get("rotor", {}).get("rpm", np.nan)
        return [azimuth / (6.0 * rpm) for azimuth in self.azimuths()]

    def values(self, section):
        """The listed values, or those from start to stop."""
        azimuth = self.schedule[section]
        if "values" in azimuth:
            return [float(value) for value in azimuth["values"]]
        start, stop, step = (float(azimuth.get(key, 0.0)) for key in ("start", "stop", "step"))
        count = int(np.floor((stop - start) / step * (1 + 1e-12))) + 1
        return [start + i * step for i in range(count)]

    def moved(self, body, nodes, k):
        """Positions of some nodes in the rotating frame, as a body moves.

        Surface, modes, rigid, table, beam and cyclic; then its parent.
        """
        steps = len(self.azimuths())
        x = reference = self.mesh.points[nodes]
        while body is not None:
            if "surface" in body:
                x = x + self.surface(body, nodes, k)
            if "modes" in body:
                x = x + self.modes(body, nodes, k)
            if "rigid" in body:
                x = rigid(body["rigid"], x, k / (steps - 1) if steps > 1 else 1.0)
            if "table" in body:
                x = self.table(body, x, k)
            if "beam" in body or "cyclic" in body:
                x = self.blade(body, x, reference, k)
            named = {other["name"]: other for other in self.schedule["body"]}
            body = named.get(body.get("parent"))
        return x

    def key(self, name, k, offset):
        """Where step k is in a table whose first column has this name."""
        return {"azimuth_deg": self.azimuths()[k] + offset, "time_s": self.times()[k], "step": k}[name]

    def surface(self, body, nodes, k):
        """Displacements of the rows of this step, by node."""
        columns = read_table(self.folder / body["surface"]["file"])
        key = next(iter(columns))
        return by_node(columns, np.isclose(columns[key], self.key(key, k, offset_of(self.schedule, body))), nodes)

    def modes(self, body, nodes, k):
        """The sum of coordinates times shapes."""
        motion = body["modes"]
        shapes = read_table(self.folder / motion["shapes"])
        columns = read_table(self.folder / motion["coordinates"])
        key = next(iter(columns))
        at = self.key(key, k, offset_of(self.schedule, body))
        moved = np.zeros((len(nodes), 3))
        for j in range(1, len(columns)):
            q = over(columns[key], columns[f"q{j}"], at, motion.get("interpolation", "linear"), key == "azimuth_deg")
            moved += q * by_node(shapes, shapes["mode"] == j, nodes)
        return moved

    def table(self, body, x, k):
        """Rz Ry Rx about the origin, then the translation; columns that are not there are 0."""
        motion = body["table"]
        columns = read_table(self.folder / motion["file"])
        key = next(iter(columns))
        at = self.key(key, k, offset_of(self.schedule, body))
        of = {
            name: over(columns[key], values, at, motion.get("interpolation", "linear"), key == "azimuth_deg")
            for name, values in columns.items()
        }
        turn = np.eye(3)
        for axis, name in zip(np.eye(3), ("rot_x_deg", "rot_y_deg", "rot_z_deg")):
            turn = rotation(axis, np.radians(of.get(name, 0.0))) @ turn
        origin = np.array(motion.get("origin", [0, 0, 0]), float)
        return origin + (x - origin) @ turn.T + [of.get(name, 0.0) for name in ("dx", "dy", "dz")]

    def blade(self, body, x, reference, k):
        """Eqs. 2, 3 and 11, in the blade's frame at its azimuth; `reference` says which section a node is in."""
        motion = body.get("cyclic", {})
        offset = offset_of(self.schedule, body)
        psi = np.radians(self.azimuths()[k] + offset)
        angle = {
            name: self.signs[name] * harmonics(motion, name, mean, psi)
            for name, mean in (("pitch", "collective"), ("flap", "coning"), ("lag", None))
        }
        e_x, e_y, e_z = np.eye(3)
        hinge = motion.get("flap_hinge", 0.0) * e_x
        # In 2D an offset shifts the azimuth alone.
        turned = np.radians(offset) if self.mesh.dimension == 3 else 0.0
        blade = rotation(self.frame[:, 2], turned) @ self.frame
        local = (x - self.hub) @ blade
        station = (reference - self.hub) @ blade[:, 0]
        if "beam" in body:
            six, axis = self.beam(body["beam"], station, k, offset)
        else:
            six = np.zeros((len(x), 6))
            axis = np.outer(station, e_x) + [0.0, *motion.get("pitch_axis", [0.0, 0.0])]
        x_r = local - axis
        for e, angles in zip((e_x, e_y, e_z), np.radians(six[:, 3:]).T):
            turns = angles + (angle["pitch"] if e is e_x else 0.0)
            x_r = np.array([rotation(e, turn) @ row for turn, row in zip(turns, x_r)])
        hinged = rotation(e_z, angle["lag"]) @ rotation(e_y, -angle["flap"])
        turned = hinge + (x_r + axis - hinge + six[:, :3]) @ hinged.T
        return self.hub + turned @ blade.T

    def beam(self, motion, station, k, offset):
        """The six values of each node's section, and the point of the lifting line it turns about."""
        columns = read_table(self.folder / motion["table"])
        key = next(iter(columns))
        stations = np.unique(columns["station"])
        six = []
        for name in ("dx", "dy", "dz", "rot_x_deg", "rot_y_deg", "rot_z_deg"):
            at_stations = []
            for r in stations:
                here = columns["station"] == r
                order = np.argsort(columns[key][here])
                keys, values = columns[key][here][order], columns[name][here][order]
                at = self.key(key, k, offset)
                at_stations.append(over(keys, values, at, motion.get("interpolation", "linear"), key == "azimuth_deg"))
            six.append(np.interp(station, stations, at_stations))
        line = read_table(self.folder / motion["lifting_line"])
        axis = np.stack([np.interp(station, line["station"], line[name]) for name in "xyz"], axis=1)
        axis[:, 0] += station - np.clip(station, line["station"][0], line["station"][-1])
        return np.stack(six, axis=1), axis

    def step(self, k):
        """Base points, their positions in the rotating frame, and how many of them move."""
        target = self.mesh.points.copy()
        for body, nodes in self.moving:
            target[nodes] = self.moved(body, nodes, k)
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


def offset_of(schedule, body):
    """The azimuth offset of a body: its own, or that of its parent."""
    if "azimuth_offset" in body or "parent" not in body:
        return body.get("azimuth_offset", 0.0)
    named = {other["name"]: other for other in schedule["body"]}
    return offset_of(schedule, named[body["parent"]])


def read_table(path):
    """Columns of a CSV file by name, in its order."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def by_node(columns, rows, nodes):
    """The vectors of some rows in the order of `nodes`."""
    vectors = {
        int(node): vector
        for node, *vector in zip(*(columns[name][rows] for name in ("node", "dx", "dy", "dz")))
    }
    return np.array([vectors[int(node)] for node in nodes])


def over(keys, values, at, kind, periodic):
    """Values between keys; over azimuth from 0 to 360 degrees, which repeats itself."""
    if periodic:
        at = at % 360.0
        if keys[-1] < 360.0:
            keys, values = np.append(keys, keys[0] + 360.0), np.append(values, values[0])
    if kind == "cubic":
        return CubicSpline(keys, values, bc_type="periodic" if periodic else "not-a-knot")(at)
    return np.interp(at, keys, values)


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

"""Keys of the schedule against formulas written anew here: positions to 1e-12, velocities by differences in time.

Nothing of reference.py is used: each case says where a node is at a time t by matrices of its own, and numpy differentiates that. Oscillations about
any axis, tables of angles, pitch and azimuth, names and units of columns, transient tables, plane zones that turn.
"""

import numpy as np
import pyvista
from scipy.interpolate import CubicSpline, interp1d
from scipy.spatial.transform import Rotation

import meshes
import outputs
from program import TESTDATA, report, scratch

REST = """
[boundaries]
others = "fixed"
[rbf]
support_radius = 3.0
[selection]
tolerance = 1e-2
[output]
velocity = true
on_inverted = "warn"
"""
TIMES = [0.0, 0.013, 0.05, 0.0999]
H = 1e-4  # s: the differences are of fourth order


def turn(axis, degrees):
    """The rotation matrix about a direction: exp of the cross product's matrix, by its eigenvectors."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    values, vectors = np.linalg.eigh(1j * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]))
    return (vectors * np.exp(-1j * values * np.radians(degrees)) @ vectors.conj().T).real


def about(x, axis, origin, degrees):
    """Points turned about an axis through a point."""
    return np.asarray(origin) + (x - np.asarray(origin)) @ turn(axis, degrees).T


def waves(t, hertz, terms):
    """Sum over m of a sin + b cos at m times a frequency."""
    psi = 2 * np.pi * hertz * t
    return sum(a * np.sin(m * psi) + b * np.cos(m * psi) for m, (a, b) in enumerate(terms, start=1))


def csv(folder, name, header, *columns):
    """A table of columns."""
    outputs.write_table(folder / name, dict(zip(header.split(","), columns, strict=True)))


def swinging(_folder):
    """About any axis and along any vector, each at a frequency of its own."""
    text = """
[body.rigid]
rotate = { axis = [1, 2, -1], origin = [0.1, 0, 0.2], angle = 2.0, harmonics = [ { sin = 10, cos = 1 }, {}, { cos = 0.5 } ], frequency = 5 }
translate = { vector = [0, 0.03, 0.1], harmonics = [ { cos = 1 }, { sin = -0.3 } ], frequency = 7.5 }
"""

    def at(x, t):
        moved = about(x, [1, 2, -1], [0.1, 0, 0.2], 2.0 + waves(t, 5, [(10, 1), (0, 0), (0, 0.5)]))
        return moved + waves(t, 7.5, [(0, 1), (-0.3, 0)]) * np.array([0, 0.03, 0.1])

    return text, at


def with_azimuth(_folder):
    """With the azimuth of a body that is ahead of the rotor, in radians."""
    text = """
azimuth_offset = 0.5
rigid.rotate = { axis = [0, 1, 0], origin = [0.7, 0, 0], harmonics = [ { sin = 0.1 }, { cos = 0.05 } ] }
"""

    def at(x, t):
        psi = 2 * np.pi * 3.0 * t + 0.5
        return about(x, [0, 1, 0], [0.7, 0, 0], np.degrees(0.1 * np.sin(psi) + 0.05 * np.cos(2 * psi)))

    return text, at, 'angle_unit = "rad"\ntime = { values = TIMES, frequency = 3.0 }'


def angle_tables(folder, kind="cubic"):
    """An angle from a table over time, on top of a mean."""
    t = np.linspace(-0.01, 0.12, 8)
    angle = np.array([0, 3, -2, 8, 5, -4, 1, 0])
    csv(folder, "flap.csv", "time_s,angle_deg", t, angle)
    text = f"""
rigid.rotate = {{ axis = [0, 0, 2], origin = [0.3, 0, 0], angle = 1.5, table = "flap.csv", interpolation = "{kind}" }}
"""
    over = CubicSpline(t, angle, bc_type="not-a-knot") if kind == "cubic" else interp1d(t, angle)
    return text, lambda x, time: about(x, [0, 0, 1], [0.3, 0, 0], 1.5 + float(over(time)))


def linear_angle_tables(folder):
    """The same, straight between rows."""
    return angle_tables(folder, "linear")


def trim(folder):
    """Pitch, flap and lag from a table over azimuth of a file with other names and units, on top of series."""
    psi = np.arange(0, 360, 60.0)
    pitch, lag = np.array([0.02, 0.1, -0.05, 0.03, 0.0, -0.1]), np.array([1, 0, -1, 2, 0, 1.0])
    csv(folder, "trim.csv", "psi,theta,zeta,other", np.radians(psi), pitch, lag, psi)
    text = """
azimuth_offset = 40
[body.cyclic]
collective = 1.0
flap = [ { sin = 2.0 } ]
flap_hinge = 0.2
pitch_axis = [0.05, -0.02]
table = "trim.csv"
interpolation = "cubic"
columns = { azimuth_deg = "psi", pitch_deg = "theta", lag_deg = "zeta" }
units = { azimuth_deg = "rad", pitch_deg = "rad" }
"""
    closed = np.append(psi, 360.0)
    of = [CubicSpline(closed, np.append(v, v[0]), bc_type="periodic") for v in (np.degrees(pitch), lag)]

    def at(x, t):
        own = 360 * 3.0 * t + 40
        blade = turn([0, 0, 1], 40)
        local = x @ blade
        # Pitch about the axis along the span, flap and lag about the hinge.
        local = about(local, [1, 0, 0], [0, 0.05, -0.02], 1.0 + float(of[0](own % 360)))
        local = about(local, [0, 1, 0], [0.2, 0, 0], -2.0 * np.sin(np.radians(own)))
        local = about(local, [0, 0, 1], [0.2, 0, 0], float(of[1](own % 360)))
        return local @ blade.T

    return text, at, "time = { values = TIMES, frequency = 3.0 }"


def transient(folder):
    """A table over azimuth that does not repeat itself: of the rotor's azimuth, though the body is ahead."""
    psi, lift = np.array([0, 50.0, 120]), np.array([0, 0.1, 0.15])
    csv(folder, "start.csv", "azimuth_deg,dz", psi, lift)
    text = 'azimuth_offset = 90\ntable = { file = "start.csv", interpolation = "cubic" }'
    over = CubicSpline(psi, lift, bc_type="not-a-knot")
    return text, lambda x, t: x + [0, 0, float(over(360 * 3.0 * t))], "time = { values = TIMES, frequency = 3.0 }"


def spin_up(folder):
    """A rotor that speeds up, carried round, with pitch by its azimuth."""
    t = np.linspace(0, 0.1, 6)
    azimuth = 9000 * t**2
    csv(folder, "azimuth.csv", "time_s,azimuth_deg", t, azimuth)
    over = CubicSpline(t, azimuth, bc_type="not-a-knot")
    text = "cyclic.pitch = [ { sin = 6.0 } ]"

    def at(x, time):
        psi = float(over(time))
        x = about(x, [1, 0, 0], [0, 0, 0], 6 * np.sin(np.radians(psi)))
        return about(x, [0, 0, 1], [0, 0, 0], psi)

    head = """time.values = TIMES
rotor = { azimuth_table = "azimuth.csv", azimuth_interpolation = "cubic", frame = "inertial" }"""
    return text, at, head


def linear_spin_up(folder):
    """The same, straight between rows: the speed of an interval."""
    t, azimuth = np.array([0, 0.03, 0.1]), np.array([0, 0.2, 1.4])
    csv(folder, "azimuth.csv", "time_s,azimuth_rad", t, azimuth)
    head = 'time.values = TIMES\nrotor = { azimuth_table = "azimuth.csv", frame = "inertial" }'
    psi = interp1d(t, np.degrees(azimuth), fill_value="extrapolate")
    return "rigid.translate = [0.1, 0, 0]", lambda x, t: about(x + [0.1, 0, 0], [0, 0, 1], [0, 0, 0], float(psi(t))), head


def rounded(folder):
    """A table that ends at 0.0998999999 for a step at 0.0999, and is cubic."""
    t, rise = np.array([0, 0.04, 0.07, 0.0998999999]), np.array([0, 0.1, 0.05, 0.2])
    csv(folder, "rounded.csv", "time_s,dx", t, rise)
    over = CubicSpline(t, rise, bc_type="not-a-knot")
    text = 'table = { file = "rounded.csv", interpolation = "cubic" }'
    # The last step has the value and the rate of the last row.
    return text, lambda x, time: x + [float(over(time - 1e-10 * (time > 0.09))), 0, 0]


def turned_by_table(folder, form, columns, numbers, angles):
    """A table of rotations in a form; `angles` are what is interpolated, `numbers` what is written."""
    t = np.array([0, 0.03, 0.1])
    csv(folder, "turns.csv", f"time_s,{columns}", t, *np.transpose(numbers))
    text = f'table = {{ file = "turns.csv", origin = [0.1, 0, 0.2], rotation = "{form}" }}'
    over = interp1d(t, angles, axis=0, fill_value="extrapolate")
    # scipy's capital letters are intrinsic.
    order = form[6:].upper()

    def at(x, time):
        values = over(time)
        rotation = Rotation.from_rotvec(values)
        if order in ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"):
            rotation = Rotation.from_euler(order, [values["XYZ".index(axis)] for axis in order])
        return np.array([0.1, 0, 0.2]) + rotation.apply(x - [0.1, 0, 0.2])

    return text, at


def angles_in_order(folder):
    """Three angles about y, then z of the body, then its x."""
    angles = np.array([[0.1, 0.2, -0.3], [0.4, -0.2, 0.1], [-0.2, 0.5, 0.3]])
    return turned_by_table(folder, "euler_yzx", "rot_x_rad,rot_y_rad,rot_z_rad", angles, angles)


VECTORS = np.array([[0.1, 0.2, -0.3], [0.5, 1.4, 0.3], [0.2, 3.5, 0.9]])  # the last is more than half a turn


def vectors(folder):
    """Rotation vectors, straight between rows."""
    return turned_by_table(folder, "vector", "rot_x_rad,rot_y_rad,rot_z_rad", VECTORS, VECTORS)


def quaternions(folder):
    """Quaternions, of which one has the other sign."""
    numbers = Rotation.from_rotvec(VECTORS).as_quat()[:, [3, 0, 1, 2]] * [[1], [-1], [1]]
    return turned_by_table(folder, "quaternion", "quat_w,quat_x,quat_y,quat_z", numbers, VECTORS)


def parameters(folder):
    """Wiener-Milenkovic parameters of at most half a turn."""
    short = Rotation.from_rotvec(VECTORS).as_rotvec()
    angle = np.linalg.norm(short, axis=1, keepdims=True)
    return turned_by_table(folder, "wiener_milenkovic", "wm_x,wm_y,wm_z", 4 * np.tan(angle / 4) * short / angle, VECTORS)


TURNS = [angles_in_order, vectors, quaternions, parameters]
SPHERE = [*TURNS, swinging, with_azimuth, angle_tables, linear_angle_tables, trim, transient, spin_up, linear_spin_up, rounded]


def bending(folder):
    """Names, units and zeros of a beam table, of a blade whose stations are fractions of the radius."""
    r, psi = np.array([0, 0.5, 1.0]), np.arange(0, 360, 90.0)
    lift, twist = np.outer([0, 20, -30, 10.0], r**2), np.outer([0, 0.05, 0.02, -0.08], r)
    grid = [(p, s) for p in range(4) for s in range(3)]
    csv(folder, "beam.csv", "psi,r_R,w,theta_x,M", *zip(*[(psi[p], r[s], lift[p, s], twist[p, s], 7) for p, s in grid]))
    csv(folder, "line.csv", "station,x,y,z", [0, 5], [0, 5], [0.01, 0.01], [0, 0])
    text = """
[body.beam]
table = "beam.csv"
lifting_line = "line.csv"
columns = { azimuth_deg = "psi", station = "r_R", dz = "w", rot_x_deg = "theta_x" }
units = { station = "radius", dz = "mm", rot_x_deg = "rad" }
"""

    def at(x, t, radius):
        place = (360 * 3.0 * t) % 360 / 90
        row, part = int(place), place % 1
        def over(table):
            return np.interp(x[:, 0] / radius, r, (1 - part) * table[row] + part * table[(row + 1) % 4])
        moved = np.array([about(p, [1, 0, 0], [p[0], 0.01, 0], np.degrees(a)) for p, a in zip(x, over(twist))])
        moved[:, 2] += 1e-3 * over(lift)
        return moved

    return text, at, "time = { values = TIMES, frequency = 3.0 }"


def compare(name, mesh, tag, case, folder, rest=REST):
    """(nodes compared, largest error of positions by the displacement, of velocities by the largest speed)."""
    text, at, *head = case(folder)
    head = head[0] if head else "time.values = TIMES"
    schedule = folder / f"{name}.toml"
    body = f'{head}\n[[body]]\nname = "b"\ntags = ["{tag}"]\n{text}\n'.replace("TIMES", repr(TIMES))
    schedule.write_text(body + rest)
    # The zone is not round.
    more = ["--allow-outside"] if name == "zone" else []
    rows = outputs.deform(mesh, schedule, folder / name, *more, expect=(0, 1))
    reference = meshes.by_pyvista(mesh)
    nodes = outputs.tagged(reference, tag)
    x = reference.points[nodes]
    if case is bending:
        radius, of_beam = x[:, 0].max(), at
        at = lambda x, t: of_beam(x, t, radius)  # noqa: E731
    off = moved = slow = speed = 0.0
    for t, row in zip(TIMES, rows):
        grid = pyvista.read(folder / name / row["file"])
        points, velocity = np.array(grid.points)[nodes], np.array(grid.point_data["Velocity"])[nodes]
        wanted = at(x, t)
        off = max(off, np.linalg.norm(points - wanted, axis=1).max())
        moved = max(moved, np.linalg.norm(wanted - x, axis=1).max())
        # To the right of a time, where a linear table has its rate.
        ahead = [at(x, t + k * H) for k in range(5)]
        rate = sum(w * f for w, f in zip((-25, 48, -36, 16, -3), ahead)) / (12 * H)
        slow = max(slow, np.linalg.norm(velocity - rate, axis=1).max())
        speed = max(speed, np.linalg.norm(rate, axis=1).max())
    return len(rows) * len(nodes), off / moved, slow / speed


def turning_zone(folder):
    """A zone of a plane mesh turns while the airfoil in it swings about its own axis."""
    text = 'rigid.rotate = { axis = [0, 0, 1], origin = [0.5, 0, 0], harmonics = [ { sin = 8.0 } ] }'
    head = """time = { values = TIMES, frequency = 3.0 }
rotor = { frame = "inertial", hub = [0.5, 0, 0] }"""

    def at(x, t):
        psi = 360 * 3.0 * t
        x = about(x, [0, 0, 1], [0.5, 0, 0], 8 * np.sin(np.radians(psi)))
        return about(x, [0, 0, 1], [0.5, 0, 0], psi)

    rest = REST.replace('others = "fixed"', 'zones = ["boundary layer"]')
    return compare("zone", TESTDATA / "airfoil_hybrid_raw_lz4.vtu", "airfoil", lambda _: (text, at, head), folder, rest)


def main():
    """Every key; positions by the largest displacement, velocities by the largest speed."""
    total, positions, velocities = 0, 0.0, 0.0
    with scratch() as folder:
        results = {case.__name__: compare(case.__name__, TESTDATA / "sphere_in_box_raw.vtu", "sphere", case, folder) for case in SPHERE}
        results["bending"] = compare("bending", TESTDATA / "rotor_sector.vtu", "blade", bending, folder)
        results["turning_zone"] = turning_zone(folder)
    for name, (n, off, slow) in results.items():
        print(f"  {name}: {n} nodes, positions {off:.1e}, velocities {slow:.1e}")
        assert off <= 1e-12, f"{name}: positions are off by {off} of the largest displacement"
        assert slow <= 1e-6, f"{name}: velocities are off by {slow} of the largest speed"
        total, positions, velocities = total + n, max(positions, off), max(velocities, slow)
    report("keys", total, positions, "positions", f"velocities {velocities:.1e} of the largest speed")

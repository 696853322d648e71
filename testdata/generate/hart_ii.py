"""A blade that bends like that of HART II: its beam table, a mesh and a schedule.

`write` makes hart_ii_beam.csv (every `step` degrees, 11 stations), hart_ii.vtu and hart_ii.toml, for make_testdata.py and, with a table of every degree
and a finer mesh, for validation/hart_ii_page.py.

Source of all numbers that are not called assumed: the HART II baseline (case BL) among the examples of OpenCOPTER,
https://github.com/PsuAeroacoustics/OpenCOPTER, oc_fly/example/hart_ii.json5 and hart_ii_params.json5. Its series
are h = sum_m cos[m] cos(m psi) + sin[m - 1] sin(m psi) in radians, cos[0] being the mean (fourier_motion in
oc_fly/source/compute_aero.py). The file has a rigid blade on an equivalent hinge; here it bends.

Assumed:
- Signs: rotations are right-handed about the axes in the file, so flap up and nose up are both -h. The test's report
  was not at hand to tell whether that is how the blade moved.
- Shape of the flap along the span: a cantilever from the pitch hinge under an even load, with the file's
  displacement at the tip. Slopes follow from it.
- Shape of the elastic twist: the first of a rod clamped at the pitch hinge, a quarter of a sine.
- No lag, no shortening.
- Trim: 3.8 degrees collective, cyclic 1.9 cos psi - 1.3 sin psi; the file leaves it to be found.
- Sections: NACA 0012, where the blade has NACA 23012.
"""

import numpy as np

from place import azimesh

RADIUS = 2.0  # m
CHORD = RADIUS / 16.5
ROOT = 0.22 * RADIUS
TWIST = -6.2 / (1.0 - 0.22)  # degrees from hub to tip: the file counts from root to tip
OMEGA = 109.12  # rad/s
PRECONE = 2.5  # degrees
PITCH_HINGE = 0.075  # m
FLAP_HINGE = PITCH_HINGE + 0.35
FLAP_COS = (-0.007672, 0.002095, -0.0008852, -0.001253, -0.0001377)
FLAP_SIN = (-0.009844, -0.0004784, 0.001229, -1.665e-6)
TWIST_COS = (-0.009037, 0.002961, -0.009796, 0.0005252, 0.001129, -0.0006439, -0.0001786, -0.0004622)
TWIST_SIN = (-0.003797, 5.21e-6, -0.000541, 0.001793, 0.0003353, -2.835e-5, -0.00036)
STATIONS = 11

SCHEDULE = """# A blade like that of HART II, baseline, through one revolution: elastic flap and twist from a table on top of
# precone and cyclic pitch. By testdata/generate/hart_ii.py, which names the source and what is assumed, such as the trim below.
version = 1

[azimuth]
start = 0.0
stop = 360.0
step = {step:g}

[rotor]
rpm = {rpm:.2f}

[[body]]
name = "blade"
tags = ["blade"]

[body.beam]
table = "hart_ii_beam.csv"
interpolation = "cubic"

[body.cyclic]
collective = 3.8
pitch = [ {{ sin = -1.3, cos = 1.9 }} ]
coning = {precone}

[boundaries]
fixed = ["outer"]

[rbf]
support_radius = {radius}

[selection]
tolerance = {tolerance:.1e}
"""


def series(cos, sin, psi):
    """Mean and harmonics at azimuths in radians."""
    even = sum(a * np.cos(m * psi) for m, a in enumerate(cos))
    return even + sum(b * np.sin(m * psi) for m, b in enumerate(sin, 1))


def shapes(stations):
    """Flap, its slope and twist along the span, with 1 at the tip (the slope is that of flap, by metres)."""
    length = RADIUS - PITCH_HINGE
    s = (stations - PITCH_HINGE) / length
    flap = s**2 * (6.0 - 4.0 * s + s**2) / 3.0
    slope = 4.0 * s * (3.0 - 3.0 * s + s**2) / 3.0 / length
    return flap, slope, np.sin(0.5 * np.pi * s)


def rows(step):
    """The table, azimuth by azimuth, without the last, which would repeat the first."""
    stations = np.linspace(ROOT, RADIUS, STATIONS)
    flap, slope, twist = shapes(stations)
    for azimuth in np.arange(0.0, 360.0, step):
        psi = np.radians(azimuth)
        tip = -series(FLAP_COS, FLAP_SIN, psi) * (RADIUS - FLAP_HINGE)
        turn = -series(TWIST_COS, TWIST_SIN, psi)
        for i, station in enumerate(stations):
            # Positive rot_y lowers what is outboard.
            yield azimuth, station, tip * flap[i], np.degrees(turn * twist[i]), np.degrees(-tip * slope[i])


def write_table(path, step):
    """hart_ii_beam.csv: lengths in m, from the hub."""
    lines = [
        "# A blade like that of HART II, baseline; by testdata/generate/hart_ii.py, which names the source and what is assumed.",
        "azimuth_deg,station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg",
    ]
    lines += [f"{psi:g},{r:.4f},0,0,{dz:.9f},{rx:.7f},{ry:.7f},0" for psi, r, dz, rx, ry in rows(step)]
    path.write_text("\n".join(lines) + "\n")


def write_mesh(path, size):
    """The blade in its cylinder; a small one is packed."""
    raw = path.with_suffix(".raw.vtu")
    shape = ["--radius", RADIUS, "--root", ROOT, "--chord", repr(CHORD), "--twist", repr(TWIST)]
    azimesh("sample", "blade", "-o", raw, "--force", *shape, *size)
    azimesh("convert", raw, path, "--force", "--compression", "zlib")
    raw.unlink()
    raw.with_suffix(".toml").unlink()


def write(folder, step=15.0, nodes=None):
    """All three files; `nodes` is None for the smallest mesh."""
    folder.mkdir(parents=True, exist_ok=True)
    small = ["--nodes", 3120, "--layers", 5, "--first-cell", 0.01]
    write_mesh(folder / "hart_ii.vtu", small if nodes is None else ["--nodes", nodes])
    write_table(folder / "hart_ii_beam.csv", step)
    values = {
        "step": step, "rpm": OMEGA * 30.0 / np.pi, "precone": PRECONE, "radius": RADIUS,
        "tolerance": 1e-3 * CHORD if nodes is None else 1e-4 * CHORD,
    }  # fmt: skip
    (folder / "hart_ii.toml").write_text(SCHEDULE.format(**values))

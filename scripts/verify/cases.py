"""The meshes and schedules that the deformation checks run on: 2D, 3D and mixed cells."""

from dataclasses import dataclass

from program import TESTDATA

AIRFOIL = """
[azimuth]
start = 0.0
stop = 360.0
step = 60.0

[[body]]
name = "airfoil"
tags = ["airfoil"]
cyclic = {{ collective = 4.0, pitch = [{{ sin = -7.65, cos = -0.96 }}, {{ sin = 1.5, cos = 0.5 }}], pitch_axis = [-0.25, 0.01], phase = 12.0 }}

[boundaries]
fixed = ["farfield"]

[rbf]
kernel = "wendland-c2"
support_radius = 4.0
"""

SPHERE = """
[azimuth]
values = [0.0, 45.0, 170.0, 290.5]

[rotor]
hub = [-0.7, 0.1, 0.05]
frame = "inertial"
flap_sign = -1

[[body]]
name = "ball"
tags = ["sph*"]
azimuth_offset = 90.0

[body.rigid]
ramp = true
rotate = {{ axis = [0.0, 1.0, 1.0], origin = [0.1, 0.0, 0.0], angle = 25.0 }}
translate = [0.05, -0.02, 0.1]

[body.cyclic]
collective = 6.0
pitch = [{{ sin = -5.0, cos = 2.0 }}]
coning = 2.0
flap = [{{ sin = 3.0, cos = -0.4 }}, {{ sin = 0.5, cos = 0.25 }}]
lag = [{{ sin = 1.0, cos = 0.3 }}]
pitch_axis = [0.1, -0.05]
flap_hinge = 0.2

[boundaries]
fixed = ["inlet", "outlet"]
others = "fixed"

[rbf]
kernel = "wendland-c4"
support_radius = 2.5
"""

MIXED = """
[azimuth]
start = 0.0
stop = 270.0
step = 90.0

[rotor]
hub = [0.0, 0.5, 0.0]

[[body]]
name = "floor"
tags = ["floor"]
cyclic = {{ collective = 3.0, pitch = [{{ sin = 4.0, cos = 1.0 }}], coning = 1.0, flap = [{{ sin = 1.5, cos = 0.5 }}] }}

[boundaries]
fixed = ["roof"]
others = "free"

[rbf]
kernel = "wendland-c0"
support_radius = 3.0
"""

SELECTION = """
[selection]
method = "{method}"
{extra}
"""


@dataclass
class Case:
    """A mesh of testdata and a schedule for it, complete but for the selection."""

    name: str
    mesh: object
    schedule: str
    tolerance: float
    solid: object = None  # a mesh with the same nodes and tags that numpy reads in its place

    def write(self, folder, method):
        """Writes the schedule with a selection method into `folder`."""
        extra = f"tolerance = {self.tolerance}" if method == "sequence" else ""
        path = folder / f"{self.name}.toml"
        path.write_text(self.schedule.format() + SELECTION.format(method=method, extra=extra))
        return path


CASES = [
    Case("airfoil", TESTDATA / "airfoil_hybrid_raw_lz4.vtu", AIRFOIL, 1e-3),
    Case("sphere", TESTDATA / "sphere_in_box_raw.vtu", SPHERE, 5e-3),
    Case("mixed", TESTDATA / "mixed_cells_inline.vtu", MIXED, 5e-3),
]

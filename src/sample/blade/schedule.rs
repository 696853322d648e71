//! Motion schedules of the blade samples.

use super::geometry::Geometry;

/// A blade in its rotating frame through one revolution of forward flight.
pub(super) fn blade(geometry: &Geometry) -> String {
    text(geometry, "rotating", "[boundaries]\nfixed = [\"outer\"]\n")
}

/// The zone `rotor` carried round with the azimuth.
pub(super) fn rotor(geometry: &Geometry) -> String {
    let boundaries = "[boundaries]\n\
        zones = [\"rotor\"]  # only this zone deforms and turns\n\
        fixed = [\"farfield\"]\n";
    text(geometry, "inertial", boundaries)
}

fn text(geometry: &Geometry, frame: &str, boundaries: &str) -> String {
    let note = match frame {
        "inertial" => "the mesh is carried round with the azimuth",
        _ => "the mesh pitches and flaps, but is not carried round",
    };
    format!(
        r#"# Cyclic pitch and flap of the M427 rotor in forward flight
# (Sheng and Allen, AIAA Journal 51(3), 2013), one revolution in steps of 10 degrees.
version = 1
angle_unit = "deg"

[azimuth]
start = 0.0
stop = 360.0
step = 10.0

[rotor]
hub = [0.0, 0.0, 0.0]
span_axis = [1.0, 0.0, 0.0]
shaft_axis = [0.0, 0.0, 1.0]
frame = "{frame}"  # {note}

[[body]]
name = "blade"
tags = ["blade"]

[body.cyclic]
collective = 10.04
pitch = [ {{ sin = -7.65, cos = -0.96 }} ]
coning = 2.619
flap = [ {{ sin = 3.211, cos = -0.421 }} ]

{boundaries}
[rbf]
kernel = "wendland-c2"
support_radius = {radius:?}  # the blade's radius

[selection]
tolerance = {tolerance:?}  # 1e-4 chord
"#,
        radius = geometry.radius,
        tolerance = round(1e-4 * geometry.chord),
    )
}

/// The number without the last digits that rounding left.
fn round(x: f64) -> f64 {
    format!("{x:.12e}").parse().unwrap_or(x)
}

//! Motion schedules of the blade samples.

use super::geometry::Geometry;
use std::fmt::Write;

/// Pitch and flap of the M427 rotor in forward flight, as keys of `cyclic`.
const CYCLIC: [&str; 4] = [
    "collective = 10.04",
    "pitch = [ { sin = -7.65, cos = -0.96 } ]",
    "coning = 2.619",
    "flap = [ { sin = 3.211, cos = -0.421 } ]",
];

/// A blade in its rotating frame through one revolution of forward flight.
pub(super) fn blade(geometry: &Geometry) -> String {
    text(
        geometry,
        "rotating",
        &one_blade(),
        "[boundaries]\nfixed = [\"outer\"]\n",
    )
}

/// The zone `rotor` in its rotating frame: a cylinder along the blade is not a surface of revolution about the shaft, so
/// it cannot turn inside the background.
pub(super) fn rotor(geometry: &Geometry) -> String {
    let boundaries = "[boundaries]\n\
        zones = [\"rotor\"]  # only this zone deforms\n\
        fixed = [\"farfield\"]\n";
    text(geometry, "rotating", &one_blade(), boundaries)
}

/// Several blades, each with its own azimuth, carried round with the mesh.
pub(super) fn rotor_of(geometry: &Geometry, n_blades: usize) -> String {
    let mut bodies = String::new();
    for blade in 0..n_blades {
        // Writing to a string cannot fail.
        let _ = write!(
            bodies,
            "[[body]]\nname = \"blade_{0}\"\ntags = [\"blade_{0}\"]\nazimuth_offset = {1:?}\ncyclic = {{ {2} }}\n\n",
            blade + 1,
            round(360.0 * blade as f64 / n_blades as f64),
            CYCLIC.join(", ")
        );
    }
    text(
        geometry,
        "inertial",
        &bodies,
        "[boundaries]\nfixed = [\"hub\", \"outer\"]\n",
    )
}

/// The body of a mesh with one blade.
fn one_blade() -> String {
    let cyclic = CYCLIC.join("\n");
    format!("[[body]]\nname = \"blade\"\ntags = [\"blade\"]\n\n[body.cyclic]\n{cyclic}\n\n")
}

fn text(geometry: &Geometry, frame: &str, bodies: &str, boundaries: &str) -> String {
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

{bodies}{boundaries}
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

//! Several rotors: which one a body has, its azimuth, and what is refused.

use super::{parse, two_cubes};
use crate::motion::{Rotor, Schedule, Steps};

/// Two rotors without errors, and a body of the second.
const TWO: &str = "azimuth = { stop = 30, step = 15 }
boundaries.others = 'fixed'
[[rotor]]
name = 'front'
rpm = 60
[[rotor]]
name = 'rear'
hub = [1, 0, 0]
rpm = 90
azimuth_sign = -1
[[body]]
name = 'b'
tags = ['blade_1']
rotor = 'rear'
cyclic.collective = 2
";

/// Returns the error of a changed schedule on a mesh.
pub(super) fn told(old: &str, new: &str) -> String {
    assert!(TWO.contains(old), "{old}");
    let found = parse(&TWO.replace(old, new));
    match found.and_then(|schedule| schedule.resolve_on(&two_cubes())) {
        Ok(_) => "no error".into(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn rotors_that_contradict_each_other_are_refused() {
    assert_eq!(told("'rear'\ncyclic", "'rear'\ncyclic"), "no error");
    let child = "rotor = 'rear'\ncyclic.collective = 1\n[[body]]\nname = 'c'\ntags = ['hub']\nparent = 'b'\nrotor = 'front'";
    assert_eq!(
        told("rotor = 'rear'", child),
        "hover.toml:20: `rotor` = \"front\", and body \"c\" moves with \"b\" of the rotor \"rear\"; a body has the rotor of its parent"
    );
    let overlap = TWO.replace("rpm = 60", "rpm = 60\nframe = 'inertial'\nzones = ['*']");
    let overlap = overlap.replace("rpm = 90", "frame = 'inertial'\nzones = ['rotor']");
    let error = parse(&overlap).and_then(|schedule| schedule.resolve_on(&two_cubes()));
    assert_eq!(
        error.expect_err("a cell twice").to_string(),
        "hover.toml:12: `zones` has cells that turn with rotor \"front\" already; a cell turns with one rotor"
    );
    let empty = TWO.split("[[rotor]]").next().expect("a start");
    let error = parse(&format!("{empty}rotor = []"));
    assert_eq!(
        error.expect_err("no rotor").to_string(),
        "hover.toml:3: `rotor` is empty; write [[rotor]] for each rotor, or leave the key out"
    );
    let unnamed = Schedule::new(Steps::azimuths_deg([0.0]))
        .rotor(Rotor::new().name("a").shaft_axis([1.0, 0.0, 0.0]))
        .rotor(Rotor::new());
    let error = unnamed.resolve_on(&two_cubes()).expect_err("no name");
    assert_eq!(
        error.to_string(),
        "rotor 2 of 2 has no `name`; of several rotors each needs one, which bodies name"
    );
}

#[test]
fn a_body_has_the_azimuth_the_rate_and_the_axes_of_its_rotor() {
    let harmonics = "cyclic.pitch = [ { sin = 2 } ]";
    let text = TWO.replace("cyclic.collective = 2", harmonics);
    let child = "[[body]]\nname = 'c'\ntags = ['hub']\nparent = 'b'\n";
    let schedule = parse(&format!("{text}{child}")).expect("it is good");
    let motion = schedule.resolve_on(&two_cubes()).expect("it fits");
    for (step, azimuth) in motion.steps.iter().zip([0.0, 15.0, 30.0]) {
        assert_eq!(step.azimuth_deg(), Some(azimuth), "that of the first rotor");
        let own = (1.5 * azimuth).to_radians();
        let [pitch, ..] = motion.cyclic_angles(0, step).expect("it pitches");
        assert!((pitch - 2_f64.to_radians() * own.sin()).abs() < 1e-15);
        let seen = motion.rotors[1].step(step);
        assert!((seen.azimuth - own).abs() < 1e-15 && seen.time_s() == step.time_s());
        assert!((seen.azimuth_rate.expect("a rate") - 540_f64.to_radians()).abs() < 1e-12);
    }
    assert_eq!(motion.bodies[1].rotor, 1, "that of the parent");
    assert_eq!(motion.axes(0).hub, [1.0, 0.0, 0.0]);
}

#[test]
fn with_times_every_rotor_has_its_rpm() {
    let text = TWO.replace(
        "azimuth = { stop = 30, step = 15 }",
        "time.values = [0, 0.25]",
    );
    let motion = parse(&text).and_then(|schedule| schedule.resolve_on(&two_cubes()));
    let motion = motion.expect("it is good");
    let step = &motion.steps[1];
    let azimuths = [0, 1].map(|rotor| motion.rotors[rotor].step(step).azimuth_deg());
    assert_eq!(azimuths, [Some(90.0), Some(135.0)]);
    // One of them alone.
    let motion = parse(&text.replace("rpm = 60\n", ""));
    let motion = motion.and_then(|schedule| schedule.resolve_on(&two_cubes()));
    let motion = motion.expect("it is good");
    let azimuths = [0, 1].map(|rotor| motion.rotors[rotor].step(&motion.steps[1]).azimuth_deg());
    assert_eq!(azimuths, [None, Some(135.0)]);
}

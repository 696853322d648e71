//! Contents of a good schedule.

use super::{one_body, parse};
use crate::motion::motions::{Harmonic, Rigid};
use crate::motion::options::RbfOptions;
use crate::motion::output::OutputOptions;
use crate::motion::steps::MAX_STEPS;
use crate::motion::{
    Beam, Cyclic, Frame, KernelName, OnInverted, Others, QualityOutput, Schedule, SelectionMethod,
    SelectionOptions, SurfaceOutput, TableMotion,
};
use azimesh_io::formats::{Compression, Encoding, Precision};
use proptest::prelude::*;
use std::path::Path;

const FULL: &str = r#"
version = 1
angle_unit = "deg"
[azimuth]
start = 0.0
stop = 360
step = 10.0
[rotor]
hub = [1, 2.0, 3e0]
span_axis = [2.0, 0.0, 0.0]
shaft_axis = [0.0, 0.0, 0.5]
frame = "inertial"
rpm = 395.0
azimuth_sign = -1
pitch_sign = 1
[[body]]
name = "blade"
tags = ["blade", "tip_*"]
azimuth_offset = 90.0
[body.cyclic]
collective = 10.04
pitch = [ { sin = -7.65, cos = -0.96 }, { cos = 1 } ]
coning = 2.619
flap = [ { sin = 3.211, cos = -0.421 } ]
lag = []
phase = 0.0
pitch_axis = [0.1, 0.2]
flap_hinge = 0.3
[[body]]
name = "store"
tags = ["store"]
rigid.translate = [0.0, 0.1, 0.0]
[boundaries]
zones = ["rotor"]
fixed = ["farfield"]
others = "free"
[rbf]
kernel = "wendland-c4"
support_radius = 5.6_25
polynomial = "none"
interpolate = "displacement"
substeps = 1
[selection]
method = "all"
tolerance = 1e-4
criterion = "max"
max_points = 5_00
correction = false
[output]
format = "vtu"
precision = "f32"
quality = "cells"
displacement = true
velocity = true
encoding = "ascii"
compression = "zlib"
on_inverted = "stop"
surface = "su2"
title = "M427, \u03bc = 0.15"
length_unit = "m"
"#;

#[test]
fn every_key_of_this_version_is_read() {
    let schedule = parse(FULL).expect("a good schedule");
    assert_eq!(schedule.path, Path::new("hover.toml"));
    assert_eq!(schedule.steps().expect("steps").len(), 37);
    let rotor = &schedule.rotors[0];
    assert_eq!(rotor.hub, [1.0, 2.0, 3.0]);
    assert_eq!(rotor.span_axis, Some([1.0, 0.0, 0.0]));
    assert_eq!(rotor.shaft_axis, Some([0.0, 0.0, 1.0]));
    assert_eq!((rotor.frame, rotor.rpm), (Frame::Inertial, Some(395.0)));
    assert_eq!((rotor.azimuth_sign, rotor.pitch_sign), (-1.0, 1.0));
    let [blade, store] = &schedule.bodies[..] else {
        panic!("two bodies");
    };
    assert_eq!(blade.name, "blade");
    assert_eq!(
        blade
            .tags
            .iter()
            .map(|tag| tag.text.as_str())
            .collect::<Vec<_>>(),
        ["blade", "tip_*"]
    );
    assert_eq!(blade.azimuth_offset, Some(90f64.to_radians()));
    let cyclic = blade.motion::<Cyclic>().expect("it is cyclic");
    assert_eq!(cyclic.pitch.mean, 10.04f64.to_radians());
    let second = Harmonic {
        sin: 0.0,
        cos: 1f64.to_radians(),
    };
    assert_eq!(cyclic.pitch.harmonics[1], second);
    assert_eq!(cyclic.flap.harmonics[0].sin, 3.211f64.to_radians());
    assert_eq!((cyclic.pitch_axis, cyclic.flap_hinge), ([0.1, 0.2], 0.3));
    assert!(cyclic.lag.harmonics.is_empty());
    let rigid = store.motion::<Rigid>().expect("it is rigid");
    let by = rigid.translate.as_ref().map(|translation| translation.by);
    assert_eq!(by, Some([0.0, 0.1, 0.0]));
    assert_eq!(schedule.boundaries.others, Some(Others::Free));
    assert_eq!(schedule.boundaries.zones[0].text, "rotor");
    assert_eq!(
        schedule.rbf,
        RbfOptions {
            kernel: KernelName::WendlandC4,
            support_radius: Some(5.625),
            ..RbfOptions::default()
        }
    );
    assert_eq!(
        schedule.selection,
        SelectionOptions {
            method: SelectionMethod::All,
            tolerance: Some(1e-4),
            max_points: 500,
            correction: false,
            ..SelectionOptions::default()
        }
    );
    assert_eq!(
        schedule.output,
        OutputOptions {
            format: Some("vtu".into()),
            precision: Precision::F32,
            quality: QualityOutput::Cells,
            displacement: true,
            velocity: true,
            encoding: Encoding::Ascii,
            compression: Compression::Zlib,
            on_inverted: OnInverted::Stop,
            improve: None,
            surface: SurfaceOutput::Su2,
            title: Some("M427, \u{3bc} = 0.15".into()),
            boundary_faces: true,
            length_unit: Some("m".into()),
        }
    );
}

#[test]
fn a_title_and_a_unit_fill_a_line_at_most() {
    for (key, wrong) in [
        ("title", "''".to_owned()),
        ("title", format!("'{}'", "x".repeat(201))),
        ("title", "\"two\\nlines\"".to_owned()),
        ("length_unit", "' '".to_owned()),
        ("length_unit", "'millimetres of the model'".to_owned()),
    ] {
        let text = FULL.replace(&format!("\n{key} = "), &format!("\n{key} = {wrong} #"));
        let told = parse(&text)
            .and_then(|s| s.check())
            .expect_err("it is no label")
            .to_string();
        assert!(
            told.contains(key) || told.contains("should be one line"),
            "{told}"
        );
        assert!(told.starts_with("hover.toml:"), "{told}");
    }
}

#[test]
fn what_is_left_out_has_its_default() {
    let schedule = one_body("", "rigid = { translate = [1, 0, 0] }");
    assert_eq!(schedule.rbf.kernel.name(), "wendland-c2");
    assert_eq!(schedule.rbf.support_radius, None);
    assert_eq!(schedule.selection, SelectionOptions::default());
    assert_eq!(schedule.selection.max_points, 5000);
    assert!(schedule.selection.correction);
    assert_eq!(schedule.output.format(), "vtu");
    assert_eq!(schedule.rotors[0].frame, Frame::Rotating);
    assert!(
        schedule
            .steps()
            .expect("steps")
            .iter()
            .all(|step| step.time_s.is_none())
    );
}

fn azimuths(section: &str) -> Vec<f64> {
    let schedule = one_body(section, "rigid = { translate = [1, 0, 0] }");
    schedule
        .steps()
        .expect("steps")
        .iter()
        .map(|step| step.azimuth_deg)
        .collect()
}

#[test]
fn stop_is_a_step_when_the_step_lands_on_it() {
    assert_eq!(
        azimuths("[azimuth]\nstop = 30\nstep = 10"),
        [0.0, 10.0, 20.0, 30.0]
    );
    assert_eq!(
        azimuths("[azimuth]\nstop = 25\nstep = 10"),
        [0.0, 10.0, 20.0]
    );
    assert_eq!(
        azimuths("[azimuth]\nstart = 10\nstop = -10\nstep = -10"),
        [10.0, 0.0, -10.0]
    );
    assert_eq!(azimuths("[azimuth]\nstart = 5\nstop = 5\nstep = 10"), [5.0]);
    let tenths = azimuths("[azimuth]\nstop = 0.3\nstep = 0.1");
    assert_eq!((tenths.len(), tenths[3]), (4, 0.3));
    let thirds = azimuths("[azimuth]\nstop = 360\nstep = 0.3333333333333333");
    assert_eq!((thirds.len(), thirds[1080]), (1081, 360.0));
    let radians = azimuths(
        "angle_unit = \"rad\"\n[azimuth]\nstop = 6.283185307179586\nstep = 0.17453292519943295",
    );
    assert_eq!((radians.len(), radians[36]), (37, 360.0));
    assert_eq!(
        azimuths("[azimuth]\nvalues = [0, 90.0, 30]"),
        [0.0, 90.0, 30.0]
    );
}

#[test]
fn revolutions_a_minute_or_a_frequency_give_each_step_its_time() {
    let rigid = "rigid = { translate = [1, 0, 0] }";
    let schedule = one_body("rotor.rpm = 600\n[azimuth]\nstop = 360\nstep = 180", rigid);
    let times: Vec<_> = schedule
        .steps()
        .expect("steps")
        .iter()
        .map(|step| step.time_s)
        .collect();
    assert_eq!(times, [Some(0.0), Some(0.05), Some(0.1)]);
    let schedule = one_body("[time]\nstop = 0.5\nstep = 0.25\nfrequency = 2", rigid);
    let steps = schedule.steps().expect("steps");
    let steps: Vec<_> = steps.iter().map(|s| (s.azimuth_deg, s.time_s)).collect();
    assert_eq!(
        steps,
        [(0.0, Some(0.0)), (180.0, Some(0.25)), (360.0, Some(0.5))]
    );
}

#[test]
fn angles_may_be_in_radians() {
    let schedule = one_body(
        "angle_unit = \"rad\"",
        "azimuth_offset = 0.5\ncyclic = { collective = 0.25, phase = 0.125 }",
    );
    let body = &schedule.bodies[0];
    let cyclic = body.motion::<Cyclic>().expect("it is cyclic");
    assert_eq!(
        (body.azimuth_offset, cyclic.pitch.mean, cyclic.phase),
        (Some(0.5), 0.25, 0.125)
    );
    assert_eq!(schedule.steps().expect("steps")[1].azimuth, 30.0);
}

#[test]
fn the_examples_of_the_schedule_page_are_good() {
    let page = include_str!("../../../../../docs/schedule.md");
    let examples: Vec<Schedule> = page
        .split("```toml\n")
        .skip(1)
        .map(|rest| rest.split("```").next().expect("split gives one at least"))
        .map(|text| parse(text).expect("a good schedule"))
        .collect();
    let steps: Vec<usize> = examples
        .iter()
        .map(|schedule| schedule.steps().expect("steps").len())
        .collect();
    assert_eq!(steps[..4], [21, 21, 1, 37]);
    let first = |example: usize| &examples[example].bodies[0];
    assert!(first(0).motion::<Cyclic>().is_some() && first(1).motion::<TableMotion>().is_some());
    assert!(first(2).motion::<Beam>().is_some());
}

#[test]
fn a_million_steps_are_read_and_deep_nesting_is_refused() {
    let values = "0.5,\n".repeat(MAX_STEPS);
    let body = "[[body]]\nname = \"a\"\ntags = [\"a\"]\ncyclic = {}\n";
    let schedule = parse(&format!("azimuth.values = [{values}]\n{body}")).expect("it is good");
    assert_eq!(schedule.steps().expect("steps").len(), MAX_STEPS);
    assert!(parse(&format!("azimuth.values = [{values}1]\n{body}")).is_err());
    assert!(parse(&format!("version = {}", "[".repeat(100_000))).is_err());
}

#[test]
fn windows_line_ends_are_fine() {
    let text = FULL.replace("\n", "\r\n");
    let shown = |text: &str| {
        let mut schedule = parse(text).expect("a good schedule");
        schedule.text.clear();
        format!("{schedule:?}")
    };
    assert_eq!(shown(&text), shown(FULL));
}

#[test]
fn a_missing_file_is_an_error_with_its_name() {
    let error = Schedule::read(Path::new("no/such.toml")).expect_err("it is not there");
    assert!(error.to_string().starts_with("no/such.toml: "), "{error}");
}

proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(text in "\\PC{0,200}") {
        let _ = parse(&text);
    }

    #[test]
    fn no_damage_to_a_schedule_makes_the_reader_panic(
        at in 0..FULL.len(),
        with in prop::sample::select(vec!["", "\"", "[", "]", "{", "9e999", "-", "=", "\n", ".", "é", "inf", "0"]),
        cut in 0usize..4,
    ) {
        let end = (at + cut).min(FULL.len());
        let _ = parse(&format!("{}{with}{}", &FULL[..at], &FULL[end..]));
    }
}

//! Rotations and translations that swing, and angles from tables.

use super::tables::{assert_near, place, resolve};
use crate::motion::{
    AxisRotation, Body, Cyclic, Motion, Others, Schedule, Steps, Table, Translation,
};
use azimesh_core::error::Result;
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{Vector, add, scale, unit};
use std::f64::consts::TAU;

const X: Vector = [0.3, 0.4, 0.2];

fn space(head: &str, body: &str, files: &[(&str, &str)]) -> Result<Motion> {
    resolve(false, head, body, files)
}

fn turned(axis: Vector, origin: Vector, degrees: f64) -> Vector {
    let axis = unit(axis).expect("a direction");
    Transform::rotation(axis, origin, degrees.to_radians()).apply(X)
}

#[test]
fn a_rotation_swings_with_the_azimuth_of_its_body() {
    let body = "azimuth_offset = 20\nrigid.rotate = { axis = [0, 1, 0], origin = [0.7, 0, 0], angle = 2, harmonics = [ { sin = 10, cos = 1 }, { cos = 3 } ] }";
    let motion = space("azimuth.values = [0, 50, 400]", body, &[]).expect("it is good");
    for (step, azimuth) in [0.0, 50.0, 400.0].into_iter().enumerate() {
        let psi = (azimuth + 20f64).to_radians();
        let angle = 2.0 + 10.0 * psi.sin() + psi.cos() + 3.0 * (2.0 * psi).cos();
        let expected = turned([0.0, 1.0, 0.0], [0.7, 0.0, 0.0], angle);
        assert_near(place(&motion, step, X), expected);
    }
}

#[test]
fn a_frequency_of_its_own_needs_times_and_no_azimuth() {
    let body = "azimuth_offset = 20\nrigid = { rotate = { axis = [1, 1, 0], harmonics = [ { sin = 10 } ], frequency = 5 }, translate = { vector = [0, 0, 0.1], harmonics = [ { cos = 1 }, { sin = 0.5 } ], frequency = 2 } }";
    let motion = space("time.values = [0, 0.03, 0.71]", body, &[]).expect("it is good");
    for (step, time) in [0.0, 0.03, 0.71].into_iter().enumerate() {
        let angle = 10.0 * (TAU * 5.0 * time).sin();
        let factor = (TAU * 2.0 * time).cos() + 0.5 * (2.0 * TAU * 2.0 * time).sin();
        let expected = add(
            turned([1.0, 1.0, 0.0], [0.0; 3], angle),
            scale([0.0, 0.0, 0.1], factor),
        );
        assert_near(place(&motion, step, X), expected);
    }
    let untimed = space("azimuth.values = [0]", body, &[])
        .expect_err("no time")
        .to_string();
    assert!(
        untimed.contains("`frequency` needs the time of every step"),
        "{untimed}"
    );
    let no_azimuth = body.replace(", frequency = 2", "");
    let told = space("time.values = [0]", &no_azimuth, &[])
        .expect_err("no azimuth")
        .to_string();
    assert!(
        told.contains("the harmonics of body \"blade\" need the azimuth"),
        "{told}"
    );
}

#[test]
fn a_ramp_takes_a_part_of_what_swings() {
    let body = "rigid = { rotate = { axis = [0, 0, 1], harmonics = [ { sin = 8 } ] }, translate = [1, 0, 0], ramp = true }";
    let motion = space("azimuth.values = [0, 30, 90]", body, &[]).expect("it is good");
    let expected = add(
        turned([0.0, 0.0, 1.0], [0.0; 3], 0.5 * 8.0 * 0.5),
        [0.5, 0.0, 0.0],
    );
    assert_near(place(&motion, 1, X), expected);
}

#[test]
fn the_angle_of_a_rotation_comes_from_a_table() {
    let body = "azimuth_offset = 90\nrigid.rotate = { axis = [0, 1, 0], origin = [0.7, 0, 0], angle = 2, table = \"flap.csv\" }";
    let times = space(
        "time.values = [0.5, 1]",
        body,
        &[("flap.csv", "time_s,angle_deg\n0,0\n1,8\n")],
    );
    let times = times.expect("it is good");
    assert_near(
        place(&times, 0, X),
        turned([0.0, 1.0, 0.0], [0.7, 0.0, 0.0], 6.0),
    );
    // Over azimuth the table is ahead by the offset, and repeats itself.
    let turns = space(
        "azimuth.values = [0, 300]",
        body,
        &[(
            "flap.csv",
            "azimuth_deg,angle_rad\n0,0.1\n90,0.2\n180,0.3\n270,0.0\n",
        )],
    );
    let turns = turns.expect("it is good");
    let two = |rad: f64| turned([0.0, 1.0, 0.0], [0.7, 0.0, 0.0], 2.0 + rad.to_degrees());
    assert_near(place(&turns, 0, X), two(0.2));
    assert_near(place(&turns, 1, X), two(0.1 + 0.1 / 3.0));
}

#[test]
fn pitch_flap_and_lag_come_from_a_table_or_on_top_of_series() {
    let trim = (
        "trim.csv",
        "azimuth_deg,flap_deg,pitch_deg\n0,1,4\n180,3,-4\n360,1,4\n",
    );
    let head = "azimuth.values = [0, 90]\nrotor.flap_sign = -1";
    let with = |cyclic: &str| {
        let body = format!("azimuth_offset = 45\ncyclic = {{ flap_hinge = 0.1, {cyclic} }}");
        space(head, &body, &[trim]).expect("it is good")
    };
    // At the blade's azimuth of 45 degrees, by hand.
    let both = with("collective = 1, pitch = [ { sin = 2 } ], coning = 0.5, table = \"trim.csv\"");
    let pitch = 1.0 + 2.0 * 45f64.to_radians().sin() + 2.0;
    let by_hand = with(&format!("collective = {pitch:?}, coning = {:?}", 0.5 + 1.5));
    assert_near(place(&both, 0, X), place(&by_hand, 0, X));
    let alone = with("table = \"trim.csv\"");
    assert_near(
        place(&alone, 1, X),
        place(&with("collective = -2, coning = 2.5"), 1, X),
    );
    let angles = alone
        .cyclic_angles(0, &alone.steps[1])
        .expect("it is cyclic");
    assert!(
        (angles[0].to_degrees() + 2.0).abs() < 1e-14 && angles[2] == 0.0,
        "{angles:?}"
    );
}

#[test]
fn a_bending_blade_pitches_by_the_table() {
    let beam = "azimuth_deg,station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n0,0,0,0,0,0,0,0\n0,1,0,0,0.1,3,0,0\n180,0,0,0,0,0,0,0\n180,1,0,0,0,0,0,0\n";
    let line = "station,x,y,z\n0,0,0,0\n1,1,0,0\n";
    let files = [
        ("beam.csv", beam),
        ("line.csv", line),
        ("trim.csv", "azimuth_deg,pitch_deg\n0,4\n180,4\n"),
    ];
    let with = |cyclic: &str| {
        let beam = "beam = { table = \"beam.csv\", lifting_line = \"line.csv\" }";
        space("azimuth.values = [0]", &format!("{beam}\n{cyclic}"), &files).expect("it is good")
    };
    let (table, series) = (
        with("cyclic.table = \"trim.csv\""),
        with("cyclic.collective = 4"),
    );
    assert_near(place(&table, 0, X), place(&series, 0, X));
}

#[test]
fn a_table_that_does_not_repeat_is_taken_at_the_azimuth_of_the_rotor() {
    let table = "azimuth_deg,dx\n0,0\n720,7.2\n";
    let body = "azimuth_offset = 90\ntable.file = \"m.csv\"";
    let motion = space("azimuth.values = [0, 100, 720]", body, &[("m.csv", table)]);
    let motion = motion.expect("it is good");
    assert_near(place(&motion, 1, [0.0; 3]), [1.0, 0.0, 0.0]);
    let notes: Vec<String> = motion.notes().iter().map(ToString::to_string).collect();
    assert!(
        notes[0].ends_with(
            "body \"blade\": the table does not repeat itself (its values at azimuth 720 deg differ from those at azimuth 0 deg, so it is not periodic), so it is taken at the azimuth of the rotor; azimuth_offset = 90 turns the axes of the blade, and shifts harmonics and tables that repeat themselves"
        ),
        "{notes:?}"
    );
    // One that repeats itself is ahead by the offset.
    let table = "azimuth_deg,dx\n0,0\n90,1\n180,2\n270,1\n360,0\n";
    let motion = space("azimuth.values = [0]", body, &[("m.csv", table)]).expect("it is good");
    assert_near(place(&motion, 0, [0.0; 3]), [1.0, 0.0, 0.0]);
    assert!(motion.notes().is_empty());
}

#[test]
fn a_step_that_rounding_puts_beside_the_end_of_a_table_is_its_end() {
    let table = "time_s,dx\n0,0\n0.05,1\n0.0999999,2\n";
    let body = "table.file = \"m.csv\"";
    let motion = space("time.values = [0, 0.1]", body, &[("m.csv", table)]);
    assert_near(
        place(&motion.expect("it is good"), 1, [0.0; 3]),
        [2.0, 0.0, 0.0],
    );
    let one = space(
        "time.values = [0.1]",
        body,
        &[("m.csv", "time_s,dx\n0.0999999,2\n")],
    );
    assert_near(
        place(&one.expect("it is good"), 0, [0.0; 3]),
        [2.0, 0.0, 0.0],
    );
    let far = space("time.values = [0, 0.1001]", body, &[("m.csv", table)]);
    let told = far.expect_err("it is past the end").to_string();
    assert!(
        told.ends_with(
            "the motion needs time 0.1001 s, but the table goes from time 0 s to time 0.0999999 s; add the missing rows"
        ),
        "{told}"
    );
}

#[test]
fn a_schedule_made_in_memory_swings_alike() {
    let swing = AxisRotation::new([0.0, 1.0, 0.0])
        .origin([0.7, 0.0, 0.0])
        .angle_deg(2.0);
    let table = || Table::from_rows(["azimuth_deg", "angle_deg"], [[0.0, 1.0], [180.0, 2.0]]);
    let trim = Table::from_rows(["azimuth_deg", "pitch_deg"], [[0.0, 1.0], [180.0, 2.0]]);
    let body = Body::new("blade", ["blade_1"])
        .rotate(swing.harmonic_deg(2, 1.0, 3.0).table(table()))
        .translate(Translation::new([0.0, 0.0, 0.1]).harmonic(1, 0.0, 1.0))
        .cyclic(Cyclic::new().table(trim));
    let steps = Steps::azimuths_deg([0.0, 70.0]);
    let schedule = Schedule::new(steps).body(body).others(Others::Fixed);
    let found = schedule
        .resolve_on(&super::two_cubes())
        .expect("it is good");
    let files = [
        ("a.csv", "azimuth_deg,angle_deg\n0,1\n180,2\n"),
        ("t.csv", "azimuth_deg,pitch_deg\n0,1\n180,2\n"),
    ];
    let read = space(
        "azimuth.values = [0, 70]",
        "rigid = { rotate = { axis = [0, 1, 0], origin = [0.7, 0, 0], angle = 2, harmonics = [ {}, { sin = 1, cos = 3 } ], table = \"a.csv\" }, translate = { vector = [0, 0, 0.1], harmonics = [ { cos = 1 } ] } }\ncyclic.table = \"t.csv\"",
        &files,
    );
    let read = read.expect("it is good");
    for step in [0, 1] {
        assert_eq!(place(&found, step, X), place(&read, step, X));
    }
}

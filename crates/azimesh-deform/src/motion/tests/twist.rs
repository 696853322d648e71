//! Parts of a motion, and its rotation vector.

use super::{one_body, two_cubes, two_squares};
use crate::motion::options::RbfOptions;
use crate::motion::{Interpolate, Motion, Step};
use azimesh_core::Note;
use azimesh_core::geometry::vector::{Vector, add, distance, norm, scale, sub};
use azimesh_core::geometry::{Bounds, Transform};
use proptest::prelude::*;

fn cubes(head: &str, body: &str) -> Motion {
    one_body(head, body)
        .resolve_on(&two_cubes())
        .expect("it fits the mesh")
}

fn squares(body: &str) -> Motion {
    one_body("", body)
        .resolve_on(&two_squares())
        .expect("it fits the mesh")
}

const MIXED: &str = "azimuth_offset = 40.0\nrigid = { rotate = { axis = [1, 2, 2], origin = [1, 0, 0.5], angle = 70.0 }, translate = [0.1, -0.2, 0.3] }\n[body.cyclic]\ncollective = 80.0\npitch = [{ sin = -7.0 }]\nconing = 12.0\nflap = [{ cos = 4.0 }]\nlag = [{ cos = 3.0 }]\npitch_axis = [0.1, 0.2]\nflap_hinge = 0.3";

#[test]
fn the_whole_part_is_the_pose_and_the_empty_part_moves_nothing() {
    let motion = cubes("rotor.hub = [0.3, -0.7, 0.2]", MIXED);
    for step in &motion.steps {
        let (part, whole) = (motion.pose_part(0, step, 1.0), motion.pose(0, step));
        assert_eq!(part.rigid(), whole.rigid());
        let rest = motion.pose_part(0, step, 0.0);
        let rest = rest.rigid().expect("it is rigid");
        assert_eq!(rest.rotation, Transform::IDENTITY.rotation);
        assert!(norm(rest.translation) < 1e-15);
    }
}

#[test]
fn a_part_has_that_part_of_every_angle_and_translation() {
    let whole = "rigid = { rotate = { axis = [0, 0, 1], angle = 80.0 }, translate = [1, 2, 0] }\ncyclic = { collective = 20.0, coning = 4.0, lag = [{ cos = 6.0 }] }";
    let quarter = "rigid = { rotate = { axis = [0, 0, 1], angle = 20.0 }, translate = [0.25, 0.5, 0] }\ncyclic = { collective = 5.0, coning = 1.0, lag = [{ cos = 1.5 }] }";
    let (whole, quarter) = (cubes("", whole), cubes("", quarter));
    let step = &whole.steps[0];
    let x = [0.3, 0.4, 0.5];
    let found = whole.pose_part(0, step, 0.25).apply(x);
    assert!(distance(found, quarter.pose(0, step).apply(x)) < 1e-15);
}

#[test]
fn a_rotation_about_one_axis_has_its_whole_angle() {
    for angle in [1e-9_f64, 20.0, 180.0, 270.0, -340.0, 360.0, 1000.0] {
        let rigid = format!("rigid = {{ rotate = {{ axis = [3, 0, 4], angle = {angle:?} }} }}");
        let motion = cubes("", &rigid);
        let theta = motion.rotation(0, &motion.steps[0], 0.0, 1.0);
        let error = norm(theta) / angle.abs().to_radians() - 1.0;
        assert!(error.abs() < 1e-15, "{angle}: {error:e}");
        let expected = scale([0.6, 0.0, 0.8], angle.to_radians());
        assert!(distance(theta, expected) <= 1e-15 * norm(expected));
        let half = motion.rotation(0, &motion.steps[0], 0.25, 0.75);
        assert_eq!(half, scale(theta, 0.5));
    }
}

#[test]
fn rotations_about_opposite_axes_add_up() {
    let motion = squares(
        "rigid = { rotate = { axis = [0, 0, 1], origin = [9, 8, 0], angle = 300.0 } }\ncyclic = { collective = -200.0 }",
    );
    let theta = motion.rotation(0, &motion.steps[0], 0.0, 1.0);
    assert_eq!([theta[0], theta[1]], [0.0; 2]);
    assert!((theta[2].to_degrees() - 500.0).abs() < 1e-12, "{theta:?}");
}

#[test]
fn a_second_small_rotation_does_not_unwind_a_large_one() {
    for angle in [170.0, 190.0, 270.0, 350.0, 450.0, 700.0] {
        let body = format!(
            "rigid = {{ rotate = {{ axis = [0, 0, 1], angle = {angle:?} }} }}\ncyclic = {{ collective = 0.001 }}"
        );
        let motion = cubes("", &body);
        let theta = motion.rotation(0, &motion.steps[0], 0.0, 1.0);
        assert!(
            (norm(theta).to_degrees() - angle).abs() < 0.01,
            "{angle} {theta:?}"
        );
        assert!(theta[2] > 0.99 * norm(theta), "{angle} {theta:?}");
    }
}

#[test]
fn nothing_turns_where_nothing_is_asked_to() {
    let motion = cubes("", "rigid = { translate = [1, 2, 3] }");
    let centre = [0.5, 0.5, 0.0];
    let twist = motion.twist(0, &motion.steps[0], centre, 0.0, 1.0);
    assert_eq!((twist.theta, twist.tau), ([0.0; 3], [1.0, 2.0, 3.0]));
    let motion = cubes("", "cyclic = { pitch = [{ sin = 5.0 }] }");
    let twist = motion.twist(0, &motion.steps[0], centre, 0.0, 1.0);
    assert_eq!((twist.theta, twist.tau), ([0.0; 3], [0.0; 3]));
}

#[test]
fn the_centre_is_the_rotation_centre_where_that_is_on_the_body() {
    let bounds = Bounds {
        low: [1.0, -0.25, -0.1],
        high: [5.0, 0.75, 0.1],
    };
    for (body, expected) in [
        (
            "rigid = { rotate = { axis = [0, 0, 1], origin = [2, 0.5, 0], angle = 20 } }",
            [2.0, 0.5, 0.0],
        ),
        (
            "rigid = { rotate = { axis = [0, 0, 1], origin = [9, 0.5, 3], angle = 20 } }",
            [5.0, 0.5, 0.1],
        ),
        (
            "cyclic = { collective = 3.0, pitch_axis = [0.125, 0.05] }",
            [1.0, 0.125, 0.05],
        ),
        (
            "cyclic = { collective = 3.0 }\nrigid = { rotate = { axis = [0, 0, 1], origin = [2, 0.5, 0], angle = 20 } }",
            [2.0, 0.5, 0.0],
        ),
        ("rigid = { translate = [1, 0, 0] }", [3.0, 0.25, 0.0]),
    ] {
        assert_eq!(cubes("", body).twist_centre(0, &bounds), expected, "{body}");
    }
}

#[test]
fn a_rotation_past_three_hundred_degrees_in_one_go_is_warned_of() {
    let rbf = |interpolate, substeps| RbfOptions {
        interpolate,
        substeps,
        ..RbfOptions::default()
    };
    let turn = |angle: f64| {
        squares(&format!(
            "rigid = {{ rotate = {{ axis = [0, 0, 1], angle = {angle:?} }}, ramp = true }}"
        ))
    };
    let far = |told: &[Note]| {
        assert_eq!(told[0].code, "turns_far");
        told[0].text.clone()
    };
    let twist = rbf(Interpolate::Twist, 1);
    assert!(turn(299.0).warnings(&twist).is_empty());
    assert!(turn(340.0).warnings(&rbf(Interpolate::Twist, 2)).is_empty());
    assert!(
        turn(340.0)
            .warnings(&rbf(Interpolate::Displacement, 1))
            .is_empty()
    );
    let one = far(&turn(-340.0).warnings(&twist));
    assert!(one.contains(" turns by 340 degrees at step 2 ("), "{one}");
    assert!(one.ends_with("set rbf.substeps = 2"), "{one}");
    let more = turn(1000.0).warnings(&rbf(Interpolate::Twist, 3));
    let more = far(&more);
    assert!(
        more.contains(" turns by 1000 degrees in 3 substeps at step 2 ("),
        "{more}"
    );
    assert!(more.ends_with("set rbf.substeps = 6"), "{more}");
}

#[test]
fn a_step_without_an_azimuth_is_named_by_its_time() {
    let body = "rigid.rotate = { axis = [0, 0, 1], angle = 340 }";
    let motion = cubes("[time]\nvalues = [0.25]", body);
    let twist = RbfOptions {
        interpolate: Interpolate::Twist,
        ..RbfOptions::default()
    };
    let [warning] = &motion.warnings(&twist)[..] else {
        panic!("it turns too far");
    };
    let told = warning.to_string();
    assert!(told.contains("at step 0 (0.25 s); above"), "{told}");
}

fn motions() -> impl Strategy<Value = (Motion, Step)> {
    let angle = || -300.0..300.0f64;
    let vector = || prop::array::uniform3(-1.0..1.0f64);
    let small = || -30.0..30.0f64;
    let cyclic = (angle(), small(), small(), small(), -0.5..0.5f64);
    (vector(), vector(), angle(), vector(), cyclic, 0.0..360.0f64, any::<bool>())
        .prop_filter("an axis", |case| norm(case.0) > 1e-2)
        .prop_map(|(axis, origin, turn, shift, cyclic, psi, both)| {
            let (collective, sin, flap, lag, hinge) = cyclic;
            let mut body = format!(
                "rigid = {{ rotate = {{ axis = {axis:?}, origin = {origin:?}, angle = {turn:?} }}, translate = {shift:?} }}\n"
            );
            if both {
                body += &format!(
                    "cyclic = {{ collective = {collective:?}, pitch = [{{ sin = {sin:?} }}], flap = [{{ cos = {flap:?} }}], lag = [{{ cos = {lag:?} }}], flap_hinge = {hinge:?} }}"
                );
            }
            let motion = cubes(&format!("[azimuth]\nvalues = [{psi:?}]"), &body);
            let step = motion.steps[0];
            (motion, step)
        })
}

proptest! {
    #[test]
    fn a_twist_puts_every_point_where_the_pose_does(
        (motion, step) in motions(),
        centre in prop::array::uniform3(-1.0..1.0),
        x in prop::array::uniform3(-2.0..2.0),
        ends in prop::array::uniform2(0.0..=1.0),
    ) {
        for [from, to] in [[0.0, 1.0], ends] {
            let twist = motion.twist(0, &step, centre, from, to);
            let [before, after] = [from, to].map(|part| motion.pose_part(0, &step, part));
            let expected = after.apply(x);
            let found = twist.apply(before.apply(centre), 1.0, before.apply(x));
            let size = norm(expected).max(norm(sub(x, centre)));
            prop_assert!(distance(found, expected) < 1e-13 * size.max(1.0), "{twist:?}");
        }
    }

    #[test]
    fn rotation_vectors_are_continuous_along_the_path((motion, step) in motions()) {
        let mut before: Vector = [0.0; 3];
        for i in 1..=200 {
            let part = f64::from(i) / 200.0;
            let theta = motion.rotation(0, &step, 0.0, part);
            // Near a whole turn the vector may change fast; the rotation itself does not.
            if (norm(theta) - 2.0 * std::f64::consts::PI).abs() > 0.6 {
                prop_assert!(distance(theta, before) < 1.0, "{part}: {before:?} {theta:?}");
            }
            before = theta;
        }
    }

    #[test]
    fn consecutive_parts_make_the_whole((motion, step) in motions(), x in prop::array::uniform3(-2.0..2.0)) {
        let centre = [0.1, 0.2, 0.3];
        let mut place: Vector = x;
        for i in 0..4 {
            let [from, to] = [i, i + 1].map(|j| f64::from(j) / 4.0);
            let twist = motion.twist(0, &step, centre, from, to);
            let about = motion.pose_part(0, &step, from).apply(centre);
            place = twist.apply(about, 1.0, place);
        }
        let expected = motion.pose(0, &step).apply(x);
        prop_assert!(distance(place, expected) < 1e-13 * norm(add(expected, [1.0; 3])).max(1.0));
    }
}

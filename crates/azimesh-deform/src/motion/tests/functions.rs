//! Bodies that a function of the caller moves.

use super::{two_cubes, two_squares};
use crate::motion::{Body, Cyclic, Motion, Others, Schedule, Step, Steps};
use azimesh_core::geometry::vector::{Vector, add, distance, norm};

fn schedule(steps: Steps, body: Body) -> Schedule {
    Schedule::new(steps).body(body).others(Others::Fixed)
}

/// Bends up with the square of x, growing with the square of time or azimuth.
fn bend(step: &Step, places: &[Vector], out: &mut [Vector]) {
    let t = step.time_s().or(step.azimuth_deg()).expect("one of them");
    for (x, d) in places.iter().zip(out) {
        *d = [0.0, 0.0, 0.1 * t * t * x[0] * x[0]];
    }
}

fn bent(steps: Steps) -> Motion {
    let body = Body::new("blade", ["blade_1"]).displacements(bend);
    schedule(steps, body)
        .resolve_on(&two_cubes())
        .expect("it fits the mesh")
}

#[test]
fn a_function_places_every_node_and_parts_of_it_are_parts() {
    let motion = bent(Steps::azimuths_deg([0.0, 2.0]));
    let nodes = two_cubes().points;
    for (node, x) in (0..4).zip(nodes) {
        let expected = add(x, [0.0, 0.0, 0.4 * x[0]]);
        assert_eq!(motion.pose(0, &motion.steps[1]).place(node, x), expected);
        let half = motion.pose_part(0, &motion.steps[1], 0.5).place(node, x);
        assert!(distance(half, add(x, [0.0, 0.0, 0.2 * x[0]])) < 1e-15);
    }
    assert!(!motion.is_rigid(0) && !motion.has_rotations(0));
}

#[test]
fn its_velocity_is_the_difference_of_the_steps_beside() {
    let motion = bent(Steps::times_s([0.0, 1.0, 3.0]));
    for (step, expected) in [(0, 0.1), (1, 0.3), (2, 0.4)] {
        let found = motion.velocities(&motion.steps[step])[0].velocity(1, [1.0, 0.0, 0.0]);
        assert!((norm(found) - expected).abs() < 1e-15, "{step} {found:?}");
    }
}

#[test]
fn it_acts_before_the_other_motions_of_its_body() {
    let turning = Cyclic::new().collective_deg(90.0);
    let body = Body::new("blade", ["blade_1"])
        .displacements(bend)
        .cyclic(turning);
    let motion = schedule(Steps::azimuths_deg([1.0]), body).resolve_on(&two_cubes());
    let motion = motion.expect("it fits the mesh");
    // Nose up about x: what is up goes back.
    let place = motion.pose(0, &motion.steps[0]).place(1, [1.0, 0.0, 0.0]);
    assert!(distance(place, [1.0, -0.1, 0.0]) < 1e-15, "{place:?}");
}

#[test]
fn displacements_that_are_no_numbers_name_body_step_and_node() {
    let broken = |step: &Step, _: &[Vector], out: &mut [Vector]| {
        out[2][1] = if step.index() == 1 { f64::NAN } else { 0.0 };
    };
    let body = Body::new("blade", ["blade_1"]).displacements(broken);
    let found = schedule(Steps::azimuths_deg([0.0, 30.0]), body).resolve_on(&two_cubes());
    assert_eq!(
        found.expect_err("NaN is refused").to_string(),
        "body \"blade\": the displacement of node 2 at step 1 (azimuth 30 degrees) is [0.0, NaN, 0.0]; displacements must be finite numbers"
    );
    let up = |_: &Step, _: &[Vector], out: &mut [Vector]| out[0] = [0.0, 0.0, 1.0];
    let body = Body::new("blade", ["blade_1"]).displacements(up);
    let found = schedule(Steps::azimuths_deg([0.0]), body).resolve_on(&two_squares());
    let told = found.expect_err("it leaves the plane").to_string();
    assert!(
        told.ends_with("displacements along z must be 0 in a 2D mesh"),
        "{told}"
    );
}

#[test]
fn it_has_no_children() {
    let parent = Body::new("blade", ["blade_1"]).displacements(bend);
    let schedule = schedule(Steps::azimuths_deg([0.0]), parent)
        .body(Body::new("hub", ["hub"]).parent("blade"));
    assert_eq!(
        schedule
            .resolve_on(&two_cubes())
            .expect_err("it is known at its nodes")
            .to_string(),
        "body \"hub\" cannot move with \"blade\", whose displacements are known only at its own nodes; give the child a motion of its own"
    );
}

#[test]
fn only_functions_with_a_name_can_be_told_apart() {
    let named = Body::new("b", ["b"]).displacements_named("bend 1", bend);
    let schedule = schedule(
        Steps::azimuths_deg([0.0]),
        Body::new("a", ["a"]).displacements(bend),
    );
    let found = schedule
        .body(named)
        .body(Body::new("c", ["c"]).cyclic(Cyclic::new()));
    assert_eq!(found.functions(), [("a", None), ("b", Some("bend 1"))]);
}

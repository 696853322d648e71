//! A motion that is one file and one line, `motions/heave.rs`, in the chain with others.

use super::tables::{assert_near, resolve};
use crate::motion::Motion;
use azimesh_core::geometry::vector::{Vector, distance, scale, sub};

const HEAVE: &str = "heave = { amplitude = 0.5, axis = [0, 0, 1] }";

fn heaving(times: &str, body: &str) -> Motion {
    let head = format!("time = {{ values = {times}, frequency = 0.25 }}");
    resolve(false, &head, body, &[]).expect("it is good")
}

#[test]
fn a_new_motion_moves_parts_and_turns_with_the_others() {
    let turn = "rigid.rotate = { axis = [1, 0, 0], angle = 90 }";
    let motion = heaving("[0, 1]", &format!("{turn}\n{HEAVE}"));
    let step = &motion.steps[1];
    assert!(motion.is_rigid(0) && motion.has_rotations(0));
    assert_near(motion.pose(0, step).apply([0.0, 1.0, 0.0]), [0.0, 0.0, 1.5]);
    let half = motion.pose_part(0, step, 0.5).apply([0.0, 0.0, 0.0]);
    assert_near(half, [0.0, 0.0, 0.25]);
    let theta: Vector = motion.rotation(0, step, 0.0, 1.0);
    assert_near(theta, [90f64.to_radians(), 0.0, 0.0]);
}

#[test]
fn a_new_motion_has_a_velocity() {
    let h = 1e-5;
    let motion = heaving(&format!("[{:?}, 0.4, {:?}]", 0.4 - h, 0.4 + h), HEAVE);
    let place = |step: usize| motion.pose(0, &motion.steps[step]).apply([0.0; 3]);
    let difference = scale(sub(place(2), place(0)), 0.5 / h);
    let found = motion.velocities(&motion.steps[1])[0].velocity(0, [0.0; 3]);
    assert!(
        distance(found, difference) < 1e-8,
        "{found:?} {difference:?}"
    );
}

#[test]
fn a_new_motion_is_checked_like_the_others() {
    let told = |head: &str, body: &str| {
        let error = resolve(false, head, body, &[]).expect_err("it is wrong");
        let error = error.to_string();
        error[error.rfind("hover.toml").expect("its file is named")..].to_owned()
    };
    assert_eq!(
        told(
            "azimuth.values = [0]",
            "heave = { amplitude = -1, axis = [0, 0, 1] }"
        ),
        "hover.toml:6: `amplitude` is -1; it must be a number greater than 0"
    );
    assert_eq!(
        told("azimuth.values = [0]", "heave = { amplitud = 1 }"),
        "hover.toml:6: unknown key `amplitud` in [body.heave]; did you mean `amplitude`? known: amplitude, axis"
    );
    let time = told("time.values = [0]", HEAVE);
    assert!(
        time.contains("the harmonics of body \"blade\" need the azimuth"),
        "{time}"
    );
}

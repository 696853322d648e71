//! Velocities against differences of places.

use super::tables::resolve;
use crate::motion::Motion;
use azimesh_core::geometry::vector::{Vector, distance, norm, scale, sub};

const H: f64 = 1e-5;
const TABLE: &str = "time_s,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n0,0,0,0,0,0,0\n1,0.1,-0.2,0.3,10,20,-30\n2,0,0.5,0,-10,5,3\n3,0.2,0,0.1,0,1,2\n";
const BEAM: &str = "azimuth_deg,station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n0,0,0,0,0,0,0,0\n0,1.1,0.1,0.2,0.3,10,20,30\n120,0,0.1,0,0,5,0,0\n120,1.1,-0.2,0.1,0.1,-5,4,3\n240,0,0,0.2,0,0,1,-2\n240,1.1,0,0,-0.3,4,-5,-6\n";
const CYCLIC: &str = "cyclic = { collective = 5, pitch = [ { sin = 7, cos = 2 }, { cos = 1 } ], coning = 3, flap = [ { sin = 4 } ], lag = [ { cos = 2 } ], phase = 11, flap_hinge = 0.2 }";

/// A motion at three times with spacing `H`, after the times of `before`.
fn motion_after(before: &str, interpolation: &str, body: &str) -> Motion {
    let head = format!(
        "time.values = [{before}{:?}, 1.3, {:?}]\ntime.frequency = 0.6\nrotor = {{ frame = \"inertial\", hub = [0.1, 0.2, 0.3], flap_sign = -1, azimuth_sign = -1 }}",
        1.3 - H,
        1.3 + H
    );
    let body = body.replace(
        "INTERPOLATION",
        &format!("interpolation = \"{interpolation}\""),
    );
    let files = [
        ("m.csv", TABLE),
        ("beam.csv", BEAM),
        (
            "s.csv",
            "time_s,node,dx,dy,dz\n0,0,0,0,0\n0,1,0,0,0\n0,2,0,0,0\n0,3,0,0,0\n3,0,3,0,0\n3,1,3,0,0\n3,2,3,0,0\n3,3,3,0,0\n",
        ),
        ("angle.csv", "time_s,angle_deg\n0,0\n1,9\n2,-4\n3,1\n"),
        (
            "trim.csv",
            "azimuth_deg,pitch_deg,lag_deg\n0,1,0\n100,5,2\n200,-3,1\n300,0,0\n",
        ),
    ];
    resolve(false, &head, &body, &files).expect("it is good")
}

fn motion(interpolation: &str, body: &str) -> Motion {
    motion_after("", interpolation, body)
}

#[track_caller]
fn assert_differentiated(motion: &Motion) {
    let first = motion.steps.len() - 3;
    for x in [[0.3, 0.4, 0.0], [0.9, -0.2, 0.1]] {
        let place =
            |step: usize| -> Vector { motion.pose(0, &motion.steps[first + step]).apply(x) };
        let difference = scale(sub(place(2), place(0)), 0.5 / H);
        let found = motion.velocities(&motion.steps[first + 1])[0].velocity(0, x);
        let off = distance(found, difference) / norm(difference);
        assert!(off < 1e-7, "{found:?} {difference:?}");
        let to_inertial = |step: usize| {
            motion
                .to_inertial(&motion.steps[first + step])
                .expect("inertial")
        };
        let difference = scale(
            sub(
                to_inertial(2).of_body(0).expect("it turns").apply(place(2)),
                to_inertial(0).of_body(0).expect("it turns").apply(place(0)),
            ),
            0.5 / H,
        );
        let to_inertial = motion
            .to_inertial_moving(&motion.steps[first + 1])
            .expect("inertial");
        let found = to_inertial
            .of_body(0)
            .expect("it turns")
            .velocity(place(1), found);
        let off = distance(found, difference) / norm(difference);
        assert!(off < 1e-7, "{found:?} {difference:?}");
    }
}

#[test]
fn oscillations_and_tables_of_angles_are_differentiated() {
    let rotate = "axis = [1, 2, 3], origin = [0.1, 0.2, 0], angle = 3";
    let harmonics = "harmonics = [ { sin = 5, cos = 2 }, { sin = 1 } ]";
    for body in [
        format!("rigid.rotate = {{ {rotate}, {harmonics} }}"),
        format!("rigid.rotate = {{ {rotate}, {harmonics}, frequency = 2.3 }}"),
        // Small: it grows within the three steps.
        "rigid = { rotate = { axis = [1, 2, 3], angle = 1e-5, harmonics = [ { sin = 3e-5 } ] }, translate = { vector = [1, 0, 0], harmonics = [ { cos = 2 } ] }, ramp = true }".to_owned(),
        format!("rigid.rotate = {{ {rotate}, table = \"angle.csv\", INTERPOLATION }}"),
        format!("rigid.translate = {{ vector = [1, 2, 3], {harmonics} }}"),
        format!("rigid.translate = {{ vector = [1, 2, 3], {harmonics}, frequency = 2.3 }}"),
        "cyclic = { pitch = [ { sin = 3 } ], table = \"trim.csv\", INTERPOLATION }".to_owned(),
    ] {
        for interpolation in ["linear", "cubic"] {
            assert_differentiated(&motion(interpolation, &body));
        }
    }
}

#[test]
fn harmonics_and_tables_are_differentiated() {
    for interpolation in ["linear", "cubic"] {
        assert_differentiated(&motion(interpolation, CYCLIC));
        for rotation in ["euler_zyx", "euler_yzx", "vector"] {
            let table = format!(
                "table = {{ file = \"m.csv\", origin = [0.3, 0.1, 0], INTERPOLATION, rotation = \"{rotation}\" }}"
            );
            assert_differentiated(&motion(interpolation, &table));
            assert_differentiated(&motion(interpolation, &format!("{table}\n{CYCLIC}")));
        }
    }
}

#[test]
fn bending_blades_are_differentiated() {
    let beam =
        "azimuth_offset = 25\nbeam = { table = \"beam.csv\", INTERPOLATION, hold_ends = true }";
    for interpolation in ["linear", "cubic"] {
        assert_differentiated(&motion(interpolation, beam));
        let all = format!("{beam}\n{CYCLIC}\nrigid.translate = [0.1, 0, 0]");
        assert_differentiated(&motion(interpolation, &all));
        for rotation in ["euler_yzx", "vector"] {
            let turned = format!("INTERPOLATION, rotation = \"{rotation}\"");
            let all = all.replace("INTERPOLATION", &turned);
            assert_differentiated(&motion(interpolation, &all));
        }
    }
}

#[test]
fn a_linear_table_over_steps_has_the_rate_of_the_interval_after_each_step() {
    let head = "time.values = [0, 0.1, 0.3, 0.6, 1]";
    let rows = "0,0\n1,0.1\n2,0.1\n3,0.3\n4,0.2\n";
    let table = format!("step,dx\n{rows}");
    let beam = format!("step,station,dx\n{}", rows.replace(',', ",0,"));
    for (body, file) in [
        ("table.file = \"m.csv\"", &table),
        ("beam = { table = \"m.csv\", hold_ends = true }", &beam),
    ] {
        let motion = resolve(false, head, body, &[("m.csv", file)]).expect("it is good");
        for (step, rate) in motion.steps.iter().zip([1.0, 0.0, 0.2 / 0.3, -0.25, -0.25]) {
            let found = motion.velocities(step)[0].velocity(0, [0.2, 0.0, 0.0]);
            assert!((found[0] - rate).abs() < 1e-12, "{body}: {step}: {found:?}");
        }
    }
}

#[test]
fn a_ramp_grows_over_the_steps() {
    let ramp = "rigid = { ramp = true, translate = [0.1, 0.2, 0.3], rotate = { axis = [1, 2, 2], origin = [1, 0, 0], angle = 0.01 } }";
    assert_differentiated(&motion("linear", ramp));
    let still = motion("linear", "rigid.translate = [1, 0, 0]");
    let pace = &still.velocities(&still.steps[0])[0];
    assert_eq!(pace.velocity(0, [1.0, 2.0, 3.0]), [0.0; 3]);
}

/// A smooth start multiplies every motion of a body by a factor.
#[test]
fn motions_begin_smoothly() {
    let surface = "surface = { file = \"s.csv\", INTERPOLATION }".to_owned();
    for body in [
        CYCLIC.to_owned(),
        format!("table.file = \"m.csv\"\n{CYCLIC}"),
        "table = { file = \"m.csv\", rotation = \"vector\" }".to_owned(),
        "beam = { table = \"beam.csv\", hold_ends = true, rotation = \"vector\" }".to_owned(),
        "rigid.rotate = { axis = [1, 2, 3], angle = 20, harmonics = [ { sin = 5 } ] }".to_owned(),
        format!(
            "beam = {{ table = \"beam.csv\", hold_ends = true }}\n{CYCLIC}\nrigid.translate = [0.1, 0, 0]"
        ),
        surface,
    ] {
        for ramp in ["seconds = 2", "seconds = 1.1", "steps = 1"] {
            let body = format!("ramp = {{ {ramp} }}\n{body}");
            let motion = motion_after("0, ", "cubic", &body);
            if body.contains("surface") {
                let node = motion.pose(0, &motion.steps[2]).place(1, [1.0, 0.0, 0.0]);
                let s: f64 = if ramp == "seconds = 2" { 0.65 } else { 1.0 };
                let expected = [1.0 + 1.3 * s * s * (3.0 - 2.0 * s), 0.0, 0.0];
                assert!(
                    distance(node, expected) < 1e-14,
                    "{ramp}: {node:?} {expected:?}"
                );
                continue;
            }
            assert_differentiated(&motion);
            let x = [0.3, 0.4, 0.0];
            assert_eq!(motion.pose(0, &motion.steps[0]).apply(x), x, "{ramp}");
        }
    }
    for (body, expected) in [
        (
            "ramp = {}\nrigid.translate = [1, 0, 0]",
            "needs either `seconds` or `steps`",
        ),
        (
            "ramp = { seconds = 1, steps = 2 }\nrigid.translate = [1, 0, 0]",
            "needs either `seconds` or `steps`",
        ),
        (
            "ramp = { seconds = -1 }\nrigid.translate = [1, 0, 0]",
            "seconds",
        ),
        (
            "ramp = { seconds = 1 }\nrigid.translate = [1, 0, 0]",
            "the steps have no times",
        ),
    ] {
        let found = resolve(false, "azimuth.values = [0, 30]", body, &[]);
        let error = found.expect_err("it is wrong").to_string();
        assert!(
            error.contains("hover.toml:6: ") && error.contains(expected),
            "{error}"
        );
    }
}

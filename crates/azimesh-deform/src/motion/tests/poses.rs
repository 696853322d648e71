//! Positions of the points of a body: closed forms, and the equations evaluated term by term.

use super::{one_body, two_cubes, two_squares};
use crate::motion::motions::Series;
use crate::motion::options::RbfOptions;
use crate::motion::{Motion, Step};
use azimesh_core::geometry::vector::{Vector, add, cross, distance, dot, scale, sub, unit};
use azimesh_core::geometry::{Transform, transform::Matrix};
use proptest::prelude::*;

fn cubes(head: &str, body: &str) -> Motion {
    one_body(head, body)
        .resolve_on(&two_cubes())
        .expect("it fits the mesh")
}

fn squares(head: &str, body: &str) -> Motion {
    one_body(head, body)
        .resolve_on(&two_squares())
        .expect("it fits the mesh")
}

fn at(azimuth_deg: f64) -> Step {
    Step {
        index: 0,
        azimuth_deg,
        azimuth: azimuth_deg.to_radians(),
        time_s: None,
        has_azimuth: true,
        azimuth_rate: None,
    }
}

/// The map of the first body, which is rigid.
fn rigid(motion: &Motion, step: &Step) -> Transform {
    let pose = motion.pose(0, step);
    *pose.rigid().expect("it is rigid")
}

#[track_caller]
fn assert_near(found: Vector, expected: Vector) {
    assert!(
        distance(found, expected) < 1e-14,
        "{found:?} is not {expected:?}"
    );
}

#[test]
fn a_tip_flaps_up_by_five_degrees_at_ninety_degrees_of_azimuth() {
    let motion = cubes("", "cyclic = { flap = [{ sin = 5.0 }] }");
    let (sin, cos) = 5f64.to_radians().sin_cos();
    let tip = motion.pose(0, &at(90.0)).apply([2.0, 0.0, 0.0]);
    assert_near(tip, [2.0 * cos, 0.0, 2.0 * sin]);
    assert_eq!(rigid(&motion, &at(0.0)), Transform::IDENTITY);
}

#[test]
fn conventions_say_where_the_leading_edge_and_the_tip_go() {
    for bits in 0..16 {
        let sign = |bit: u32| if bits >> bit & 1 == 1 { -1 } else { 1 };
        let head = format!(
            "[rotor]\nazimuth_sign = {}\npitch_sign = {}\nflap_sign = {}\nlag_sign = {}",
            sign(0),
            sign(1),
            sign(2),
            sign(3)
        );
        let moved = |keys: &str, x: Vector| {
            let motion = cubes(&head, &format!("cyclic = {{ {keys} }}"));
            sub(motion.pose(0, &at(0.0)).apply(x), x)
        };
        let motion = cubes(&head, "cyclic = {}");
        // A blade goes round towards its leading edge.
        let tip = [1.0, 0.0, 0.0];
        let ahead = sub(motion.rotors[0].axes.turn(0.1).apply(tip), tip);
        let nose = motion.rotors[0].axes.leading_edge();
        assert!(dot(ahead, nose) > 0.0);
        let way =
            |up: f64, plus: &'static str, minus: &'static str| if up > 0.0 { plus } else { minus };
        let told = motion.rotors[0].axes.conventions();
        assert!(
            told[1].contains(&format!("chord (leading edge) {nose:?}")),
            "{told:?}"
        );
        assert_eq!(
            told[2],
            format!(
                "azimuth {} seen from the thrust side, pitch positive nose {}, flap positive {}, lag {} positive",
                way(ahead[1], "counter-clockwise", "clockwise"),
                way(moved("collective = 5", nose)[2], "up", "down"),
                way(moved("coning = 5", tip)[2], "up", "down"),
                way(
                    dot(moved("lag = [{ cos = 5 }]", tip), nose),
                    "lead",
                    "trail"
                ),
            )
        );
    }
}

#[test]
fn more_than_a_turn_of_pitch_is_told_of() {
    for (keys, told) in [
        ("collective = 300, pitch = [{ sin = 59 }]", false),
        ("collective = 4000", true),
    ] {
        let motion = cubes("", &format!("cyclic = {{ {keys} }}"));
        assert_eq!(
            motion.warnings(&RbfOptions::default()).len(),
            usize::from(told),
            "{keys}"
        );
    }
}

#[test]
fn a_hinge_is_where_flap_and_lag_begin() {
    let motion = cubes("", "cyclic = { flap = [{ cos = 90.0 }], flap_hinge = 0.5 }");
    assert_near(
        motion.pose(0, &at(0.0)).apply([2.0, 0.0, 0.0]),
        [0.5, 0.0, 1.5],
    );
    let motion = cubes("", "cyclic = { lag = [{ cos = 90.0 }], flap_hinge = 0.5 }");
    assert_near(
        motion.pose(0, &at(0.0)).apply([2.0, 0.0, 0.0]),
        [0.5, 1.5, 0.0],
    );
}

#[test]
fn positive_lag_leads_counter_clockwise_rotation() {
    let motion = cubes("", "cyclic = { lag = [{ cos = 3.0 }] }");
    let (sin, cos) = 3f64.to_radians().sin_cos();
    assert_near(
        motion.pose(0, &at(0.0)).apply([1.0, 0.0, 0.0]),
        [cos, sin, 0.0],
    );
}

#[test]
fn positive_pitch_raises_the_leading_edge_on_a_rotor() {
    let motion = cubes("", "cyclic = { collective = 10.0 }");
    let nose = motion.pose(0, &at(0.0)).apply([1.0, 0.25, 0.0]);
    let (sin, cos) = 10f64.to_radians().sin_cos();
    assert_near(nose, [1.0, 0.25 * cos, 0.25 * sin]);
}

#[test]
fn positive_pitch_raises_a_nose_at_minus_x_in_two_dimensions() {
    let motion = squares(
        "rotor = { hub = [0.25, 0.0, 0.0] }",
        "cyclic = { collective = 10.0 }",
    );
    let pose = motion.pose(0, &at(0.0));
    let (sin, cos) = 10f64.to_radians().sin_cos();
    assert_near(
        pose.apply([0.0, 0.0, 0.0]),
        [0.25 - 0.25 * cos, 0.25 * sin, 0.0],
    );
    assert_eq!(pose.apply([0.7, 0.1, 0.0])[2], 0.0);
}

#[test]
fn the_pitch_axis_stays_where_its_offset_puts_it() {
    let motion = squares(
        "",
        "cyclic = { collective = 10.0, pitch_axis = [-0.25, 0.1] }",
    );
    let axis = [0.25, 0.1, 0.0];
    assert_near(motion.pose(0, &at(0.0)).apply(axis), axis);
    let motion = cubes(
        "",
        "cyclic = { collective = 10.0, pitch_axis = [0.2, 0.3] }",
    );
    let axis = [7.0, 0.2, 0.3];
    assert_near(motion.pose(0, &at(0.0)).apply(axis), axis);
}

#[test]
fn harmonics_add_up_with_their_phase() {
    let motion = cubes(
        "",
        "cyclic = { collective = 10.0, pitch = [{ sin = -7.0, cos = 2.0 }, { cos = 1.0 }, {}, { sin = 0.5 }], phase = 20.0 }",
    );
    let psi = 33f64.to_radians();
    let delta = 20f64.to_radians();
    let expected = 10.0 - 7.0 * (psi + delta).sin()
        + 2.0 * (psi + delta).cos()
        + (2.0 * psi + delta).cos()
        + 0.5 * (4.0 * psi + delta).sin();
    let (sin, cos) = expected.to_radians().sin_cos();
    assert_near(
        motion.pose(0, &at(33.0)).apply([0.0, 1.0, 0.0]),
        [0.0, cos, sin],
    );
    assert_eq!(Series::default().at(psi, delta), 0.0);
}

#[test]
fn the_second_of_four_blades_does_at_psi_what_the_first_does_a_quarter_turn_later() {
    let cyclic = "cyclic = { collective = 8.0, pitch = [{ sin = -7.0, cos = 2.0 }], coning = 3.0, flap = [{ sin = 4.0 }], lag = [{ cos = 1.5 }], flap_hinge = 0.3, pitch_axis = [0.1, 0.0] }";
    let head =
        "rotor = { hub = [0.2, -0.1, 0.4], span_axis = [1, 0, 0.0], shaft_axis = [0, 0.0, 1] }";
    let first = cubes(head, cyclic);
    let second = cubes(head, &format!("azimuth_offset = 90.0\n{cyclic}"));
    let quarter = Transform::rotation([0.0, 0.0, 1.0], [0.2, -0.1, 0.4], 90f64.to_radians());
    for psi in [0.0, 17.0, 200.0] {
        for x in [[1.0, 0.1, 0.2], [3.0, -0.2, 0.0]] {
            let expected = quarter.apply(first.pose(0, &at(psi + 90.0)).apply(x));
            let found = second.pose(0, &at(psi)).apply(quarter.apply(x));
            assert!(distance(found, expected) < 1e-13);
        }
    }
}

#[test]
fn in_two_dimensions_an_offset_shifts_the_azimuth_alone() {
    let cyclic = "cyclic = { pitch = [{ sin = 5.0 }] }";
    let first = squares("", cyclic);
    let second = squares("", &format!("azimuth_offset = 90.0\n{cyclic}"));
    let x = [0.3, 0.2, 0.0];
    assert_near(
        second.pose(0, &at(10.0)).apply(x),
        first.pose(0, &at(100.0)).apply(x),
    );
}

#[test]
fn each_sign_turns_its_own_angle_round() {
    for (sign, cyclic, x, expected) in [
        (
            "pitch_sign",
            "collective = 90.0",
            [0.0, 1.0, 0.0],
            [0.0, 0.0, -1.0],
        ),
        (
            "flap_sign",
            "coning = 90.0",
            [1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0],
        ),
        (
            "lag_sign",
            "lag = [{ cos = 90.0 }]",
            [1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
        ),
    ] {
        let motion = cubes(
            &format!("rotor = {{ {sign} = -1 }}"),
            &format!("cyclic = {{ {cyclic} }}"),
        );
        assert_near(motion.pose(0, &at(0.0)).apply(x), expected);
    }
}

#[test]
fn a_clockwise_rotor_is_carried_the_other_way() {
    let cyclic = "cyclic = { collective = 1.0 }";
    let ccw = cubes("rotor = { frame = \"inertial\" }", cyclic);
    let cw = cubes(
        "rotor = { frame = \"inertial\", azimuth_sign = -1 }",
        cyclic,
    );
    let in_inertial = |motion: &Motion| {
        motion
            .to_inertial(&at(90.0))
            .expect("inertial")
            .of_body(0)
            .expect("it turns")
            .apply([1.0, 0.0, 0.0])
    };
    assert_near(in_inertial(&ccw), [0.0, 1.0, 0.0]);
    assert_near(in_inertial(&cw), [0.0, -1.0, 0.0]);
    assert!(cubes("", cyclic).to_inertial(&at(90.0)).is_none());
}

#[test]
fn a_rigid_motion_turns_then_translates_and_comes_before_the_cyclic_one() {
    let schedule = "rigid = { rotate = { axis = [0, 0, 2], origin = [1, 0, 0], angle = 90.0 }, translate = [0, 0, 0.5] }";
    let motion = cubes("", schedule);
    assert_near(
        motion.pose(0, &at(0.0)).apply([2.0, 0.0, 0.0]),
        [1.0, 1.0, 0.5],
    );
    let motion = cubes("", &format!("cyclic = {{ collective = 90.0 }}\n{schedule}"));
    assert_near(
        motion.pose(0, &at(0.0)).apply([2.0, 0.0, 0.0]),
        [1.0, -0.5, 1.0],
    );
}

#[test]
fn a_ramp_goes_from_nothing_to_the_whole_motion() {
    let schedule = "rigid = { rotate = { axis = [0, 0, 1], angle = 40.0 }, translate = [1, 2, 0], ramp = true }";
    let motion = squares("", schedule);
    assert_eq!(rigid(&motion, &motion.steps[0]), Transform::IDENTITY);
    for (step, angle) in [(1, 20.0), (2, 40.0)] {
        let (sin, cos) = f64::to_radians(angle).sin_cos();
        let part = angle / 40.0;
        let found = motion.pose(0, &motion.steps[step]).apply([1.0, 0.0, 0.0]);
        assert_near(found, [cos + part, sin + 2.0 * part, 0.0]);
    }
    let single = squares("[azimuth]\nvalues = [7.0]", schedule);
    let end = rigid(&motion, &motion.steps[2]);
    assert_eq!(rigid(&single, &single.steps[0]), end);
}

/// Everything eq. 2 and 3 depend on, angles in radians.
#[derive(Debug, Clone)]
struct Case {
    hub: Vector,
    span: Vector,
    shaft: Vector,
    offset: f64,
    psi: f64,
    pitch: [f64; 3],
    flap: [f64; 3],
    lag: [f64; 2],
    phase: f64,
    pitch_axis: [f64; 2],
    hinge: f64,
}

impl Case {
    fn motion(&self) -> Motion {
        let Self {
            hub, span, shaft, ..
        } = self;
        let rotor = format!(
            "angle_unit = \"rad\"\n[rotor]\nhub = {hub:?}\nspan_axis = {span:?}\nshaft_axis = {shaft:?}\nframe = \"inertial\""
        );
        let [collective, ps, pc] = self.pitch;
        let [coning, fs, fc] = self.flap;
        let [ls, lc] = self.lag;
        let cyclic = format!(
            "azimuth_offset = {:?}\n[body.cyclic]\ncollective = {collective:?}\nconing = {coning:?}\npitch = [{{ sin = {ps:?}, cos = {pc:?} }}]\nflap = [{{ sin = {fs:?}, cos = {fc:?} }}]\nlag = [{{ sin = {ls:?}, cos = {lc:?} }}]\nphase = {:?}\npitch_axis = {:?}\nflap_hinge = {:?}",
            self.offset, self.phase, self.pitch_axis, self.hinge
        );
        cubes(&rotor, &cyclic)
    }

    fn step(&self) -> Step {
        at(self.psi.to_degrees())
    }

    /// The equations term by term, with matrices in the blade's frame; `a` turns the result.
    fn expected(&self, x: Vector, a: f64) -> Vector {
        let psi = self.step().azimuth + self.offset;
        let (s, c) = (psi + self.phase).sin_cos();
        let pitch = self.pitch[0] + self.pitch[1] * s + self.pitch[2] * c;
        let flap = self.flap[0] + self.flap[1] * s + self.flap[2] * c;
        let lag = self.lag[0] * s + self.lag[1] * c;
        let e_z = unit(self.shaft).expect("a direction");
        let along = scale(e_z, dot(self.span, e_z));
        let e_x = unit(sub(self.span, along)).expect("not parallel");
        let basis = [e_x, cross(e_z, e_x), e_z];
        let from_hub = sub(x, self.hub);
        let in_rotor = basis.map(|e| dot(e, from_hub));
        let in_blade = times(rz(-self.offset), in_rotor);
        let x_ref = [in_blade[0], self.pitch_axis[0], self.pitch_axis[1]];
        let x_r = times(rx(pitch), sub(in_blade, x_ref));
        let hinge = [self.hinge, 0.0, 0.0];
        let flapped = times(ry(-flap), sub(add(x_r, x_ref), hinge));
        let moved = times(rz(a), add(hinge, times(rz(lag), flapped)));
        let back = (0..3).map(|i| scale(basis[i], moved[i]));
        back.fold(self.hub, add)
    }
}

fn times(m: Matrix, x: Vector) -> Vector {
    m.map(|row| dot(row, x))
}

fn rx(t: f64) -> Matrix {
    let (s, c) = t.sin_cos();
    [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]
}

fn ry(t: f64) -> Matrix {
    let (s, c) = t.sin_cos();
    [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]
}

fn rz(t: f64) -> Matrix {
    let (s, c) = t.sin_cos();
    [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
}

prop_compose! {
    fn cases()(
        hub in prop::array::uniform3(-1.0..1.0),
        span in prop::array::uniform3(-1.0..1.0),
        shaft in prop::array::uniform3(-1.0..1.0),
        offset in -4.0..4.0,
        psi in -20.0..20.0,
        pitch in prop::array::uniform3(-1.0..1.0),
        flap in prop::array::uniform3(-1.0..1.0),
        lag in prop::array::uniform2(-1.0..1.0),
        phase in -3.0..3.0,
        pitch_axis in prop::array::uniform2(-0.3..0.3),
        hinge in -0.5..0.5,
    ) -> Case {
        Case { hub, span, shaft, offset, psi, pitch, flap, lag, phase, pitch_axis, hinge }
    }
}

fn well_separated(case: &Case) -> bool {
    let normal = cross(case.span, case.shaft);
    dot(normal, normal) > 1e-3
}

proptest! {
    #[test]
    fn poses_are_the_equations_evaluated_term_by_term(
        case in cases().prop_filter("axes apart", well_separated),
        x in prop::array::uniform3(-2.0..2.0),
    ) {
        let motion = case.motion();
        let step = case.step();
        let pose = rigid(&motion, &step);
        prop_assert!(distance(pose.apply(x), case.expected(x, case.offset)) < 1e-12);
        let to_inertial = motion.to_inertial(&step).expect("inertial");
        let to_inertial = to_inertial.of_body(0).expect("it turns");
        let in_inertial = pose.then(to_inertial).apply(x);
        let expected = case.expected(x, step.azimuth + case.offset);
        prop_assert!(distance(in_inertial, expected) < 1e-12);
    }

    #[test]
    fn poses_are_proper_rotations(case in cases().prop_filter("axes apart", well_separated)) {
        let motion = case.motion();
        let step = case.step();
        let pose = rigid(&motion, &step);
        for rotation in [pose.rotation, pose.then(motion.to_inertial(&step).expect("inertial").of_body(0).expect("it turns")).rotation] {
            for i in 0..3 {
                for j in 0..3 {
                    let expected = if i == j { 1.0 } else { 0.0 };
                    prop_assert!((dot(rotation[i], rotation[j]) - expected).abs() < 1e-14);
                }
            }
            let det = dot(rotation[0], cross(rotation[1], rotation[2]));
            prop_assert!((det - 1.0).abs() < 1e-14);
        }
    }
}

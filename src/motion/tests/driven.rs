//! Motions from tables: six degrees of freedom and bending blades.

use super::{parse, two_cubes, two_squares};
use crate::error::Result;
use crate::geometry::transform::Matrix;
use crate::geometry::vector::{Vector, add, distance, dot, sub};
use crate::motion::{Motion, RbfOptions, Step};
use proptest::prelude::*;
use std::fmt::Write as _;

/// A schedule of one body beside the files that it names, on a mesh.
pub(super) fn resolve(
    plane: bool,
    head: &str,
    body: &str,
    files: &[(&str, &str)],
) -> Result<Motion> {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("it can be written");
    }
    let text = format!(
        "boundaries.others = \"fixed\"\n{head}\n[[body]]\nname = \"blade\"\ntags = [\"blade_1\"]\n{body}\n"
    );
    let path = folder.path().join("hover.toml");
    std::fs::write(&path, text).expect("it can be written");
    let schedule = crate::motion::Schedule::read(&path)?;
    let mesh = if plane { two_squares() } else { two_cubes() };
    schedule.resolve(&mesh)
}

/// What a wrong table is told, without its folder.
fn told(plane: bool, body: &str, table: &str) -> String {
    let azimuths = "azimuth.values = [0, 30]";
    let found = resolve(plane, azimuths, body, &[("m.csv", table)]);
    let error = found.expect_err("it is wrong").to_string();
    match error.rfind("m.csv").or_else(|| error.rfind("hover.toml")) {
        Some(at) => error[at..].to_owned(),
        None => error,
    }
}

fn place(motion: &Motion, step: usize, x: Vector) -> Vector {
    motion.pose(0, &motion.steps[step]).apply(x)
}

#[track_caller]
fn assert_near(found: Vector, expected: Vector) {
    assert!(
        distance(found, expected) < 2e-15,
        "{found:?} is not {expected:?}"
    );
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

const TABLE: &str = "table = { file = \"m.csv\" }";

#[test]
fn a_heaving_body_follows_its_table_between_rows() {
    let table = "time_s,dy\n0,0\n1,0.5\n2,-0.5\n";
    let head = "time.values = [0, 0.5, 1.75, 2]";
    let motion = resolve(true, head, TABLE, &[("m.csv", table)]).expect("it is good");
    for (step, dy) in [(0, 0.0), (1, 0.25), (2, -0.25), (3, -0.5)] {
        assert_near(place(&motion, step, [3.0, 1.0, 0.0]), [3.0, 1.0 + dy, 0.0]);
    }
}

#[test]
fn a_table_turns_about_its_origin_x_first_and_then_translates() {
    let table = "step,rot_x_deg,rot_y_deg,rot_z_deg,dx,dy,dz\n0,90,0,0,0,0,0\n1,90,90,0,0,0,0\n2,90,90,90,1,2,3\n";
    let body = "table = { file = \"m.csv\", origin = [1, 0, 0] }";
    let head = "azimuth.values = [0, 1, 2]";
    let motion = resolve(false, head, body, &[("m.csv", table)]).expect("it is good");
    let x = [1.0, 1.0, 0.0];
    assert_near(place(&motion, 0, x), [1.0, 0.0, 1.0]);
    assert_near(place(&motion, 1, x), [2.0, 0.0, 0.0]);
    assert_near(place(&motion, 2, x), [2.0, 3.0, 3.0]);
    // Its rotations are those of twist, and parts of it have parts of its angles.
    let theta = motion.rotation(0, &motion.steps[0], 0.0, 1.0);
    assert!((theta[0].to_degrees() - 90.0).abs() < 1e-12);
    let half = motion.pose_part(0, &motion.steps[0], 0.5).apply(x);
    let half_way = 0.5 * 2f64.sqrt();
    assert!(distance(half, [1.0, half_way, half_way]) < 1e-15);
}

#[test]
fn a_table_over_azimuth_repeats_itself_and_is_shifted_by_the_offset() {
    let table = "azimuth_deg,rot_z_deg\n0,0\n90,10\n180,0\n270,-10\n360,0\n";
    let head = "azimuth.values = [0, 45, 450, 810]";
    let motion = |offset: &str| {
        let body = format!("azimuth_offset = {offset}\n{TABLE}");
        resolve(true, head, &body, &[("m.csv", table)]).expect("it is good")
    };
    let angle = |motion: &Motion, step: usize| {
        let x = place(motion, step, [1.0, 0.0, 0.0]);
        x[1].atan2(x[0]).to_degrees()
    };
    for (offset, angles) in [("0", [0.0, 5.0, 10.0, 10.0]), ("90", [10.0, 5.0, 0.0, 0.0])] {
        let motion = motion(offset);
        for (step, expected) in angles.into_iter().enumerate() {
            assert!(
                (angle(&motion, step) - expected).abs() < 1e-12,
                "{offset} {step}"
            );
        }
    }
}

#[test]
fn a_wrong_table_is_told_its_line() {
    for (plane, body, table, expected) in [
        (
            false,
            TABLE,
            "dx,dy\n0,1\n",
            "m.csv:1: the table has no column `azimuth_deg`, `azimuth_rad`, `time_s` or `step`; found: dx, dy",
        ),
        (
            false,
            TABLE,
            "azimuth_deg\n0\n",
            "m.csv:1: the table has none of the columns dx, dy, dz, rot_x_deg, rot_y_deg, rot_z_deg",
        ),
        (
            false,
            TABLE,
            "azimuth_deg,dx\n0,a\n",
            "m.csv:2: column `dx` holds \"a\"; it must be a finite number",
        ),
        (
            false,
            TABLE,
            "azimuth_deg,dx\n0,1\n30,NaN\n",
            "m.csv:3: column `dx` holds \"NaN\"; it must be a finite number",
        ),
        (
            false,
            TABLE,
            "azimuth_deg,dx\n0,1\n30\n",
            "m.csv:3: the row has 1 field; it must have 2, one for each column",
        ),
        (
            false,
            TABLE,
            "azimuth_deg,dx\n30,1\n0,1\n",
            "m.csv:3: azimuth 0 deg comes after azimuth 30 deg of line 2; rows must go from one `azimuth_deg` to a larger one",
        ),
        (
            false,
            TABLE,
            "azimuth_deg,dx\n0,1\n0,1\n",
            "m.csv:3: azimuth 0 deg repeats azimuth 0 deg of line 2; rows must go from one `azimuth_deg` to a larger one",
        ),
        (
            false,
            TABLE,
            "time_s,dx\n0,1\n1,2\n",
            "hover.toml:6: the table is over `time_s`, but the steps have no time; give the schedule [time], or `rpm` in [rotor]",
        ),
        (
            true,
            TABLE,
            "azimuth_deg,dx,dz\n0,1,0\n90,2,0.5\n",
            "m.csv:3: `dz` is not 0, and body \"blade\" would leave the plane of the 2D mesh; dx, dy and rot_z_deg stay in it",
        ),
        (
            true,
            "beam = { table = \"m.csv\" }",
            "x\n1\n",
            "hover.toml:6: body \"blade\" is a beam, which needs a 3D mesh; in 2D a table or modes bend it",
        ),
    ] {
        assert_eq!(told(plane, body, table), expected);
    }
    let short = told(false, TABLE, "azimuth_deg,dx\n0,1\n10,2\n");
    assert!(short.starts_with("m.csv:3: the motion is asked for at azimuth 30 deg; the table goes from azimuth 0 deg to azimuth 10 deg"), "{short}");
    let typo = told(false, TABLE, "azimuth_deg,rot_z\n0,1\n");
    assert!(
        typo.starts_with("m.csv:1: column `rot_z` is not known here; did you mean `rot_z_"),
        "{typo}"
    );
}

const BEAM: &str = "station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n";

#[test]
fn a_beam_bends_up_between_its_stations() {
    let table = format!("{BEAM}0,0,0,0,0,0,0\n0.5,0,0,0.1,0,0,0\n1,0,0,0.4,0,0,0\n");
    let motion = resolve(
        false,
        "azimuth.values = [0]",
        "beam = { table = \"m.csv\" }",
        &[("m.csv", &table)],
    );
    let motion = motion.expect("it is good");
    assert!(!motion.is_rigid(0));
    for (r, dz) in [
        (0.0, 0.0),
        (0.25, 0.05),
        (0.5, 0.1),
        (0.75, 0.25),
        (1.0, 0.4),
        (7.0, 0.4),
    ] {
        let x = [r, 0.3, 0.0];
        assert_near(place(&motion, 0, x), [r, 0.3, dz]);
    }
}

#[test]
fn sections_twist_about_a_quarter_of_the_chord_nose_up() {
    // The face goes from y = 0 to y = 1, its leading edge: a quarter of the chord is at 0.75.
    let table = format!("{BEAM}0,0,0,0,0,0,0\n1,0,0,0,20,0,0\n");
    let motion = resolve(
        false,
        "azimuth.values = [0]",
        "beam = { table = \"m.csv\" }",
        &[("m.csv", &table)],
    );
    let motion = motion.expect("it is good");
    let (sin, cos) = 10f64.to_radians().sin_cos();
    let nose = place(&motion, 0, [0.5, 1.0, 0.0]);
    assert!(
        distance(nose, [0.5, 0.75 + 0.25 * cos, 0.25 * sin]) < 1e-15,
        "{nose:?}"
    );
    assert_near(place(&motion, 0, [0.5, 0.75, 0.0]), [0.5, 0.75, 0.0]);
}

#[test]
fn the_quarter_chord_of_a_clockwise_rotor_is_at_its_own_leading_edge() {
    let table = format!("{BEAM}0,0,0,0,0,0,0\n1,0,0,0,20,0,0\n");
    let motion = resolve(
        false,
        "azimuth.values = [0]\nrotor.azimuth_sign = -1",
        "beam = { table = \"m.csv\" }",
        &[("m.csv", &table)],
    );
    let motion = motion.expect("it is good");
    assert_near(place(&motion, 0, [0.5, 0.25, 0.0]), [0.5, 0.25, 0.0]);
    assert_eq!(
        motion.notes(),
        [
            "body \"blade\": its quarter chord goes from [0.0000, 0.2500, 0.0000] to [1.0000, 0.2500, 0.0000], \
          with the leading edge towards [0.000, -1.000, 0.000]"
        ]
    );
}

#[test]
fn a_lifting_line_of_its_own_is_shown_and_told_of_where_it_is_beside_the_blade() {
    let table = format!("{BEAM}0,0,0,0,0,0,0\n1,0,0,0,20,0,0\n");
    for (line, ends, is_beside) in [
        (
            "0,0,0.5,0\n1,1,0.5,0",
            "[0.0000, 0.5000, 0.0000] to [1.0000, 0.5000, 0.0000]",
            false,
        ),
        (
            "0,0,-0.4,0\n1,1,1.4,0",
            "[0.0000, -0.4000, 0.0000] to [1.0000, 1.4000, 0.0000]",
            false,
        ),
        (
            "0,5,0.5,0\n1,9,0.5,0",
            "[5.0000, 0.5000, 0.0000] to [9.0000, 0.5000, 0.0000]",
            true,
        ),
    ] {
        let motion = resolve(
            false,
            "azimuth.values = [0]",
            "beam = { table = \"m.csv\", lifting_line = \"l.csv\" }",
            &[
                ("m.csv", &table),
                ("l.csv", &format!("station,x,y,z\n{line}\n")),
            ],
        );
        let motion = motion.expect("it is good");
        assert!(
            motion.notes()[0].starts_with(&format!(
                "body \"blade\": its lifting line goes from {ends}"
            )),
            "{:?}",
            motion.notes()
        );
        let warnings = motion.warnings(&RbfOptions::default());
        assert_eq!(!warnings.is_empty(), is_beside, "{warnings:?}");
    }
}

#[test]
fn a_flap_of_five_degrees_adds_to_a_beam() {
    let table = format!("{BEAM}0,0,0,0.1,0,0,0\n1,0,0,0.1,0,0,0\n");
    let body = "cyclic = { flap = [ { sin = 5.0 } ] }\nbeam = { table = \"m.csv\" }";
    let motion =
        resolve(false, "azimuth.values = [90]", body, &[("m.csv", &table)]).expect("it is good");
    let (sin, cos) = 5f64.to_radians().sin_cos();
    let tip = place(&motion, 0, [1.0, 0.75, 0.0]);
    assert_near(tip, [cos - 0.1 * sin, 0.75, sin + 0.1 * cos]);
}

#[test]
fn a_wrong_beam_table_is_told_its_line() {
    let beam = "beam = { table = \"m.csv\" }";
    let told = |table: String| told(false, beam, &table);
    let missing = told("azimuth_deg,station,dx,dy,dz,rot_x_deg,rot_y_deg\n".into());
    assert!(
        missing.starts_with("m.csv:1: the table has no"),
        "{missing}"
    );
    assert_eq!(
        told(format!(
            "azimuth_deg,{BEAM}0,0,0,0,0,0,0,0\n0,0,0,0,0,0,0,0\n"
        )),
        "m.csv:3: azimuth 0 deg, station 0 is given twice, first in line 2; keep one of the rows"
    );
    assert_eq!(
        told(format!("{BEAM}5,0,0,0,0,0,0\n6,0,0,0,0,0,0\n")),
        "m.csv:2: the stations go from 5 to 6, but body \"blade\" lies between 0 and 1 along its span; stations are lengths in mesh units from the hub"
    );
    let axis = "cyclic = { collective = 1, pitch_axis = [0.1, 0] }\nbeam = { table = \"m.csv\" }";
    assert_eq!(
        super::driven::told(false, axis, "x\n1\n"),
        "hover.toml:7: body \"blade\" has both `pitch_axis` and a beam, whose sections pitch about its lifting line; leave `pitch_axis` out"
    );
}

#[test]
fn a_blade_that_goes_on_far_past_its_table_is_told_of() {
    let table = format!("{BEAM}0,0,0,0,0,0,0\n0.5,0,0,0.1,0,0,0\n");
    let motion = resolve(
        false,
        "azimuth.values = [0]",
        "beam = { table = \"m.csv\" }",
        &[("m.csv", &table)],
    );
    let notes = motion.expect("it is good").notes();
    assert_eq!(notes.len(), 2);
    assert!(
        notes[0].ends_with(
            "has no stations between 0.5 and 1; the values of its last one are held there"
        ),
        "{notes:?}"
    );
}

#[test]
fn a_schedule_is_parsed_without_its_tables() {
    let text = "azimuth.values = [0]\n[[body]]\nname = \"a\"\ntags = [\"a\"]\nbeam = { table = \"nowhere.csv\", interpolation = \"cubic\", lifting_line = \"line.csv\" }\n";
    let schedule = parse(text).expect("a good schedule");
    let beam = schedule.bodies[0].beam.as_ref().expect("it is there");
    assert_eq!(beam.lifting_line.as_deref(), Some("line.csv"));
}

/// Everything that eq. 2 and 3 depend on, with two azimuths and two stations.
#[derive(Debug, Clone)]
struct Case {
    hub: Vector,
    offset: f64,
    psi: f64,
    pitch: [f64; 3],
    flap: [f64; 2],
    lag: f64,
    hinge: f64,
    line: [Vector; 2],
    /// Rows at azimuths 0 and 180 degrees, stations 0 and 2: lengths, then degrees.
    rows: [[f64; 6]; 4],
}

impl Case {
    fn motion(&self) -> Motion {
        let mut table = format!("azimuth_deg,{BEAM}");
        for ((psi, r), row) in [(0, 0), (0, 2), (180, 0), (180, 2)].iter().zip(&self.rows) {
            let row = row.map(|value| format!("{value:?}")).join(",");
            writeln!(table, "{psi},{r},{row}").expect("a string grows");
        }
        let [a, b] = self.line.map(|x| x.map(|x| format!("{x:?}")).join(","));
        let line = format!("station,x,y,z\n-0.5,{a}\n1.5,{b}\n");
        let [collective, sin, cos] = self.pitch;
        let [coning, flap] = self.flap;
        let body = format!(
            "azimuth_offset = {:?}\ncyclic = {{ collective = {collective:?}, pitch = [ {{ sin = {sin:?}, cos = {cos:?} }} ], coning = {coning:?}, flap = [ {{ cos = {flap:?} }} ], lag = [ {{ sin = {:?} }} ], flap_hinge = {:?} }}\nbeam = {{ table = \"m.csv\", lifting_line = \"line.csv\" }}",
            self.offset, self.lag, self.hinge
        );
        let head = format!(
            "azimuth.values = [{:?}]\nrotor.hub = {:?}",
            self.psi, self.hub
        );
        resolve(
            false,
            &head,
            &body,
            &[("m.csv", &table), ("line.csv", &line)],
        )
        .expect("it is good")
    }

    /// The equations term by term, with matrices in the blade's frame.
    fn expected(&self, x: Vector) -> Vector {
        let to_blade = rz(-self.offset.to_radians());
        let [r, y, z] = times(to_blade, sub(x, self.hub));
        let along = (r / 2.0).clamp(0.0, 1.0);
        let turned = (self.psi + self.offset).rem_euclid(360.0) / 180.0;
        let (first, part) = if turned < 1.0 {
            (0, turned)
        } else {
            (1, turned - 1.0)
        };
        let six = |azimuth: usize, station: usize| self.rows[2 * (azimuth % 2) + station];
        let at: [f64; 6] = std::array::from_fn(|i| {
            let span = |azimuth| (1.0 - along) * six(azimuth, 0)[i] + along * six(azimuth, 1)[i];
            (1.0 - part) * span(first) + part * span(first + 1)
        });
        let on_line = ((r + 0.5) / 2.0).clamp(0.0, 1.0);
        let beyond = r - (-0.5 + 2.0 * on_line);
        let mut x_ref: Vector =
            std::array::from_fn(|i| (1.0 - on_line) * self.line[0][i] + on_line * self.line[1][i]);
        x_ref[0] += beyond;
        let psi = (self.psi + self.offset).to_radians();
        let pitch = self.pitch[0] + self.pitch[1] * psi.sin() + self.pitch[2] * psi.cos();
        let flap = self.flap[0] + self.flap[1] * psi.cos();
        let angles =
            [at[3] + pitch, at[4], at[5], -flap, self.lag * psi.sin()].map(f64::to_radians);
        let x_r = times(rx(angles[0]), sub([r, y, z], x_ref));
        let x_r = times(rz(angles[2]), times(ry(angles[1]), x_r));
        let hinge = [self.hinge, 0.0, 0.0];
        let bent = add(add(x_r, sub(x_ref, hinge)), [at[0], at[1], at[2]]);
        let moved = add(hinge, times(rz(angles[4]), times(ry(angles[3]), bent)));
        add(self.hub, times(rz(self.offset.to_radians()), moved))
    }
}

prop_compose! {
    fn cases()(
        hub in prop::array::uniform3(-0.2..0.2),
        offset in -20.0..20.0,
        psi in -720.0..720.0,
        pitch in prop::array::uniform3(-20.0..20.0),
        flap in prop::array::uniform2(-9.0..9.0),
        lag in -9.0..9.0,
        hinge in -0.5..0.5,
        line in prop::array::uniform2(prop::array::uniform3(-0.3..0.3)),
        rows in prop::array::uniform4(prop::array::uniform6(-0.9..0.9)),
    ) -> Case {
        let rows = rows.map(|row: [f64; 6]| std::array::from_fn(|i| if i < 3 { row[i] } else { 30.0 * row[i] }));
        Case { hub, offset, psi, pitch, flap, lag, hinge, line, rows }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn beams_are_the_equations_evaluated_term_by_term(
        case in cases(),
        points in prop::array::uniform4(prop::array::uniform3(-1.0..3.0)),
    ) {
        let motion = case.motion();
        let step: &Step = &motion.steps[0];
        for x in points {
            let pose = motion.pose(0, step);
            let expected = case.expected(x);
            for found in [pose.apply(x), pose.map(x).apply(x)] {
                prop_assert!(distance(found, expected) < 2e-14, "{found:?} {expected:?}");
            }
        }
    }
}

#[test]
fn a_file_that_is_not_there_is_told_with_the_line_that_names_it() {
    let missing = resolve(
        false,
        "azimuth.values = [0]",
        "table = { file = \"nope.csv\" }",
        &[],
    );
    let told = missing.expect_err("there is no such file").to_string();
    assert!(
        told.contains("hover.toml:") && told.contains("there is no file "),
        "{told}"
    );
}

#[test]
fn a_table_of_one_row_is_not_held_at_other_times() {
    let table = ("m.csv", "time_s,dx\n0,0.1\n");
    let body = "table = { file = \"m.csv\" }";
    let at = |head: &str| resolve(false, head, body, &[table]);
    let motion = at("time.values = [0]").expect("it has a row");
    assert_near(place(&motion, 0, [0.0; 3]), [0.1, 0.0, 0.0]);
    let told = at("time.values = [0, 1]")
        .expect_err("it has no row")
        .to_string();
    assert!(
        told.ends_with(
            "the motion is asked for at time 1 s; the table goes from time 0 s to time 0 s"
        ),
        "{told}"
    );
}

//! Bending blades: tables over azimuth and span.

use super::parse;
use super::tables::*;
use crate::motion::options::RbfOptions;
use crate::motion::{Beam, Motion, Step};
use azimesh_core::geometry::vector::{Vector, add, distance, sub};
use proptest::prelude::*;
use std::fmt::Write as _;
use std::path::PathBuf;

const BEAM: &str = "station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n";

/// The blade that a good table bends.
fn bent(head: &str, table: &str) -> Motion {
    let body = "beam = { table = \"m.csv\" }";
    resolve(false, head, body, &[("m.csv", table)]).expect("it is good")
}

#[test]
fn a_beam_bends_up_between_its_stations() {
    let table = format!("{BEAM}0,0,0,0,0,0,0\n0.5,0,0,0.1,0,0,0\n1,0,0,0.4,0,0,0\n");
    let motion = bent("azimuth.values = [0]", &table);
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
    let motion = bent("azimuth.values = [0]", &table);
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
    let motion = bent("azimuth.values = [0]\nrotor.azimuth_sign = -1", &table);
    assert_near(place(&motion, 0, [0.5, 0.25, 0.0]), [0.5, 0.25, 0.0]);
    let notes = motion.notes();
    assert_eq!((notes.len(), &*notes[0].code), (1, "beam_line"));
    assert_eq!(
        notes[0].text,
        "body \"blade\": its quarter chord goes from [0.0000, 0.2500, 0.0000] to [1.0000, 0.2500, 0.0000], with the \
         leading edge towards [0.000, -1.000, 0.000]"
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
            motion.notes()[0].to_string().starts_with(&format!(
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
        "m.csv:2: the stations go from 5 to 6, but body \"blade\" goes from 0 to 1 along its span; stations are lengths from the hub in mesh units"
    );
    let axis = "cyclic = { collective = 1, pitch_axis = [0.1, 0] }\nbeam = { table = \"m.csv\" }";
    assert_eq!(
        super::tables::told(false, axis, "x\n1\n"),
        "hover.toml:7: body \"blade\" has both `pitch_axis` and a beam, whose sections pitch about its lifting line; leave `pitch_axis` out"
    );
}

#[test]
fn a_table_of_part_of_a_blade_is_refused_unless_its_ends_are_held() {
    let half = format!("{BEAM}0,0,0,0,0,0,0\n0.5,0,0,0.1,0,0,0\n");
    assert_eq!(
        told(false, "beam = { table = \"m.csv\" }", &half),
        "m.csv:3: the stations go from 0 to 0.5, which is 50% of the blade: body \"blade\" goes from 0 to 1 along its span; \
         stations are lengths from the hub in mesh units; with `hold_ends = true` the values of the first and the last \
         station hold for the rest of the blade"
    );
    let held = "beam = { table = \"m.csv\", hold_ends = true }";
    let held = |table: &str| {
        let motion = resolve(false, "azimuth.values = [0]", held, &[("m.csv", table)]);
        motion.expect("its ends are held")
    };
    assert_near(place(&held(&half), 0, [0.9, 0.3, 0.0]), [0.9, 0.3, 0.1]);
    let notes = held(&half).notes();
    assert_eq!(notes.len(), 2);
    assert_eq!(notes[0].code, "no_stations");
    let text = "has no stations between 0.5 and 1; the values of its last station are used there";
    assert!(notes[0].text.ends_with(text), "{notes:?}");
    let nearly = format!("{BEAM}0.05,0,0,0,0,0,0\n0.96,0,0,0.1,0,0,0\n");
    assert_eq!(bent("azimuth.values = [0]", &nearly).notes().len(), 1);
}

/// A blade of one face from `root` to `tip`, with a table of these stations.
fn blade_with(root: f64, tip: f64, stations: &[f64], body: &str) -> Result<Motion, String> {
    let rows = stations.iter().map(|r| format!("{r},0,0,0,0,0,0\n"));
    let table = format!("{BEAM}{}", rows.collect::<String>());
    let body = format!("beam = {{ table = \"m.csv\"{body} }}");
    let line = "station,x,y,z\n0,0,0,0\n1,1,0.5,0\n";
    let files = [("m.csv", table.as_str()), ("l.csv", line)];
    let head = "azimuth.values = [0]";
    let told = |text: String| text.rsplit('/').next().unwrap_or_default().to_owned();
    resolve_between([root, tip], head, &body, &files).map_err(|error| told(error.to_string()))
}

#[test]
fn stations_that_are_fractions_of_the_radius_are_refused_with_the_key_that_says_so() {
    let key = "fractions of the radius need `units = { station = \"radius\" }`";
    for (root, tip, what) in [
        (
            0.9,
            5.6,
            "m.csv:4: the stations go from 0.2 to 1, which is 2% of the blade",
        ),
        (1.3, 5.6, "m.csv:4: the stations go from 0.2 to 1, but body"),
        (
            0.1,
            0.6,
            "m.csv:4: station 1 is far past the end of the blade",
        ),
    ] {
        let error = blade_with(root, tip, &[0.2, 0.6, 1.0], "").expect_err("they are fractions");
        assert!(error.starts_with(what) && error.contains(key), "{error}");
    }
    for (root, tip) in [(0.2, 1.0), (0.2, 0.95), (0.2, 1.08)] {
        assert!(blade_with(root, tip, &[0.2, 0.6, 1.0], "").is_ok(), "{tip}");
    }
    assert!(blade_with(0.9, 5.6, &[0.2, 1.0], ", hold_ends = true").is_ok());
}

#[test]
fn a_bent_lifting_line_over_fractions_of_the_radius_is_refused() {
    let with_line = |tip: f64| blade_with(0.0, tip, &[0.0, tip], ", lifting_line = \"l.csv\"");
    let error = with_line(5.6).expect_err("they are fractions");
    let wanted =
        "l.csv:3: the stations of the lifting line go from 0 to 1, but body \"blade\" ends at 5.6";
    assert!(error.starts_with(wanted), "{error}");
    assert!(with_line(1.05).is_ok());
}

#[test]
fn a_schedule_is_parsed_without_its_tables() {
    let text = "azimuth.values = [0]\n[[body]]\nname = \"a\"\ntags = [\"a\"]\nbeam = { table = \"nowhere.csv\", interpolation = \"cubic\", lifting_line = \"line.csv\" }\n";
    let schedule = parse(text).expect("a good schedule");
    assert!(schedule.bodies[0].motion::<Beam>().is_some());
    let names: Vec<_> = schedule.files();
    assert_eq!(names, ["nowhere.csv", "line.csv"].map(PathBuf::from));
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
        let places = [(0, 0), (0, 2), (180, 0), (180, 2), (360, 0), (360, 2)];
        for ((psi, r), row) in places.iter().zip(self.rows.iter().cycle()) {
            let row = row.map(|value| format!("{value:?}")).join(",");
            writeln!(table, "{psi},{r},{row}").expect("a string grows");
        }
        let [a, b] = self.line.map(|x| x.map(|x| format!("{x:?}")).join(","));
        let line = format!("station,x,y,z\n-0.5,{a}\n1.5,{b}\n");
        let [collective, sin, cos] = self.pitch;
        let [coning, flap] = self.flap;
        let body = format!(
            "azimuth_offset = {:?}\ncyclic = {{ collective = {collective:?}, pitch = [ {{ sin = {sin:?}, cos = {cos:?} }} ], coning = {coning:?}, flap = [ {{ cos = {flap:?} }} ], lag = [ {{ sin = {:?} }} ], flap_hinge = {:?} }}\nbeam = {{ table = \"m.csv\", lifting_line = \"line.csv\", hold_ends = true }}",
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

//! Tables of other programs: other names of columns, other units, columns left out.

use super::tables::{assert_near, place, resolve};
use crate::motion::Motion;

const HEAD: &str = "azimuth.values = [0, 30]\nrotor.hub = [-1, 0, 0]";
const LINE: &str = "station,x,y,z\n0,0,0,0\n2,2,0,0\n";
pub(super) const PLAIN: &str =
    "station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n0,0,0,0,0,0,0\n2,0.03,0,0,10,0,0\n";
const X: [f64; 3] = [0.5, 0.2, 0.1];

fn beam(keys: &str, table: &str) -> azimesh_core::error::Result<Motion> {
    let body = format!("beam = {{ table = \"m.csv\", lifting_line = \"line.csv\"{keys} }}");
    resolve(false, HEAD, &body, &[("m.csv", table), ("line.csv", LINE)])
}

pub(super) fn told(keys: &str, table: &str) -> String {
    let error = beam(keys, table).expect_err("it is wrong").to_string();
    let at = error.rfind("hover.toml").or_else(|| error.rfind("m.csv"));
    error[at.expect("it names a file")..].to_owned()
}

fn notes(motion: &Motion) -> Vec<String> {
    motion
        .notes()
        .iter()
        .map(|note| note.text.clone())
        .collect()
}

#[test]
fn a_beam_table_has_names_and_units_of_its_own() {
    let table = "theta_x,r_R,u1,mass\n0,0,0,5\n0.17453292519943295,1,30,7\n";
    let keys = ", columns = { station = \"r_R\", dx = \"u1\", rot_x_deg = \"theta_x\" }, units = { station = \"radius\", dx = \"mm\", rot_x_deg = \"rad\" }";
    let (plain, named) = (beam("", PLAIN), beam(keys, table));
    let (plain, named) = (plain.expect("it is good"), named.expect("it is good"));
    assert_near(place(&named, 0, X), place(&plain, 0, X));
    // At three quarters of the radius: 22.5 mm and 7.5 degrees.
    let (sin, cos) = 7.5f64.to_radians().sin_cos();
    let expected = [0.5 + 0.0225, 0.2 * cos - 0.1 * sin, 0.2 * sin + 0.1 * cos];
    assert_near(place(&named, 0, X), expected);
    let notes = notes(&named);
    assert!(
        notes.contains(
            &"body \"blade\": passed over 1 column that `columns` does not name: mass".to_owned()
        ),
        "{notes:?}"
    );
    assert!(
        notes.contains(&"body \"blade\": dx in mm is converted for a mesh in m; for another write for example  length_unit = \"mm\"  in [output]".to_owned()),
        "{notes:?}"
    );
}

#[test]
fn what_a_beam_table_leaves_out_is_zero() {
    let plain = beam("", PLAIN).expect("it is good");
    let short = beam("", "station,dx,rot_x_deg\n0,0,0\n2,0.03,10\n").expect("it is good");
    assert_eq!(place(&short, 0, X), place(&plain, 0, X));
    assert_eq!(
        told("", "station\n0\n2\n"),
        "m.csv:1: the table has none of the columns dx, dy, dz, rot_x_deg, rot_y_deg, rot_z_deg"
    );
}

#[test]
fn lengths_are_converted_to_the_unit_of_the_mesh() {
    let with = |unit: &str| {
        let head = format!("{HEAD}\noutput.length_unit = \"{unit}\"");
        let body = "table = { file = \"m.csv\", columns = { time_s = \"t\", dx = \"X\" }, units = { dx = \"ft\", time_s = \"ms\" } }";
        let head = head.replace("azimuth.values = [0, 30]", "time.values = [0, 0.5]");
        resolve(false, &head, body, &[("m.csv", "t,X\n0,0\n1000,2\n")])
    };
    let found = with("mm").expect("it is good");
    let moved = place(&found, 1, [0.0; 3])[0];
    assert!((moved - 304.8).abs() < 1e-12, "{moved}");
    assert!(notes(&found).is_empty());
    let error = with("chord")
        .expect_err("it is no unit of length")
        .to_string();
    assert!(error.ends_with("`dx` is in ft, which cannot be converted to `length_unit` = \"chord\" in [output]; known: m, mm, cm, km, um, in, ft"), "{error}");
}

#[test]
fn tables_of_angles_and_azimuths_have_names_and_units() {
    let trim = "cyclic = { table = \"m.csv\", columns = { azimuth_deg = \"psi\", pitch_deg = \"theta\" }, units = { azimuth_deg = \"rad\", pitch_deg = \"rad\" } }";
    let tau = std::f64::consts::TAU;
    let table = format!("psi,theta,x\n0,0,0\n{:?},0.1,1\n{tau:?},0,2\n", tau / 2.0);
    let named = resolve(false, HEAD, trim, &[("m.csv", &table)]).expect("it is good");
    let plain = resolve(
        false,
        HEAD,
        "cyclic.table = \"m.csv\"",
        &[("m.csv", "azimuth_deg,pitch_rad\n0,0\n180,0.1\n360,0\n")],
    );
    assert_near(
        place(&named, 1, X),
        place(&plain.expect("it is good"), 1, X),
    );
}

#[test]
fn a_name_that_another_column_has_taken_is_not_read_twice() {
    let taken =
        beam(", columns = { dx = \"dz\" }", "station,dz\n0,0\n2,0.1\n").expect("it is good");
    assert_near(place(&taken, 0, [1.0, 0.0, 0.0]), [1.1, 0.0, 0.0]);
}

#[test]
fn a_minus_before_a_name_changes_the_sign_and_a_number_is_a_factor() {
    let table = "r_R,u1,-u2,theta_x\n0,0,0,0\n1,-30,0.5,-10\n";
    let keys = ", columns = { station = \"r_R\", dx = \"-u1\", dy = \"-u2\", rot_x_deg = \"- theta_x\" }, units = { station = 2, dx = 0.001 }";
    let (plain, named) = (beam("", PLAIN), beam(keys, table));
    let (plain, named) = (plain.expect("it is good"), named.expect("it is good"));
    let expected = place(&plain, 0, X);
    // A name that is in the file is used unchanged.
    assert_near(
        place(&named, 0, X),
        [expected[0], expected[1] + 0.375, expected[2]],
    );
    // A factor converts to the mesh unit; no unit is assumed.
    assert_eq!(notes(&named), notes(&plain));
}

fn warned(motion: &Motion) -> Vec<String> {
    let warnings = motion.warnings(&crate::motion::options::RbfOptions::default());
    warnings.into_iter().map(|note| note.text).collect()
}

#[test]
fn a_rotation_against_the_slope_of_its_displacement_is_warned_of() {
    let of = |row: &str| {
        let table = format!("station,dy,dz,rot_y_deg,rot_z_deg\n0,0,0,0,0\n{row}\n");
        warned(&beam("", &table).expect("it is good"))
    };
    // 0.2 in 2 are 5.71 degrees.
    for right in [
        "2,0,0.2,-11,0",
        "2,0,-0.2,9,0",
        "2,0.2,0,0,10",
        "2,0,0.2,0,0",
    ] {
        assert!(of(right).is_empty(), "{right}");
    }
    assert_eq!(
        of("2,0,0.2,11,0"),
        [
            "body \"blade\": rot_y contradicts the slope of dz: between the stations 0 and 2 the slope of dz is 5.71 deg, so that rot_y should be near -5.71 deg; the table has 5.5 deg. If its sign follows another convention, write  columns = { rot_y_deg = \"-rot_y_deg\" }"
        ]
    );
    assert!(of("2,0.2,0,0,-10")[0].contains("rot_z contradicts the slope of dy"));
    let small = of("2,0,0.2,-0.2,0");
    assert!(
        small[0].starts_with("body \"blade\": rot_y is 0.018 times the slope of dz:"),
        "{small:?}"
    );
}

#[test]
fn a_table_and_steps_of_different_extent_are_warned_of() {
    let of = |table: &str, keys: &str| {
        let body = format!("table = {{ file = \"m.csv\"{keys} }}");
        let head = "time = { stop = 0.5, step = 0.1 }";
        resolve(false, head, &body, &[("m.csv", table)])
    };
    let milliseconds = "time_s,dz\n0,0\n250,0.1\n500,0\n";
    let found = of(milliseconds, "").expect("it is good");
    assert_eq!(
        warned(&found),
        [
            "body \"blade\": the steps go from time 0 s to time 0.5 s, which is 0.1% of the table, which goes from time 0 s to time 500 s; if its times are not in s, write for example  units = { time_s = \"ms\" }"
        ]
    );
    let found = of(milliseconds, ", units = { time_s = \"ms\" }").expect("it is good");
    assert!(warned(&found).is_empty());
    let error = of("time_s,dz\n0,0\n0.004,0.1\n0.00833333,0\n", "").expect_err("it is short");
    let error = error.to_string();
    let told = "the motion needs time 0.1 s, but the table goes from time 0 s to time 0.00833333 s; add the missing rows; it covers 1.7% of the steps, which go from time 0 s to time 0.5 s; if its times are not in s, write for example  units = { time_s = \"min\" }";
    assert!(error.ends_with(told), "{error}");
}

#[test]
fn a_line_of_units_below_the_names_counts_unless_units_are_given() {
    let of = |table: &str, keys: &str| {
        let names =
            "columns = { time_s = \"Time\", dx = \"PtfmSurge\", rot_x_deg = \"-PtfmRoll\" }";
        let body = format!("table = {{ file = \"m.csv\", {names}{keys} }}");
        let head = "time.values = [0.5]\noutput.length_unit = \"mm\"";
        resolve(false, head, &body, &[("m.csv", table)])
    };
    let table = "Time PtfmSurge PtfmRoll Wind\n(s) (m) (rad) (m/s)\n0 0 0 7\n1 0.002 0.4 8\n";
    let (sin, cos) = (-0.2_f64).sin_cos();
    let turned = [0.2 * cos - 0.1 * sin, 0.2 * sin + 0.1 * cos];
    let found = of(table, "").expect("it is good");
    assert_near(place(&found, 0, X), [1.5, turned[0], turned[1]]);
    let found = of(table, ", units = { dx = 1 }").expect("it is good");
    assert_near(place(&found, 0, X), [0.501, turned[0], turned[1]]);
    let error = of(&table.replace("(rad)", "(kN)"), "")
        .expect_err("no angle")
        .to_string();
    let told = "m.csv:2: unit \"kN\" of `rot_x_deg` is not known; known: deg, rad; `units` can give a factor";
    assert!(error.ends_with(told), "{error}");
}

#[test]
fn a_table_of_openfoam_turns_about_z_first() {
    let table = "1((0 ((0 0 0) (90 0 90))))";
    let body = "table = { file = \"m.dat\" }";
    let found = resolve(false, "time.values = [0]", body, &[("m.dat", table)]);
    // x goes to y about z, and from there to z about x.
    assert_near(
        place(&found.expect("it is good"), 0, [1.0, 0.0, 0.0]),
        [0.0, 0.0, 1.0],
    );
}

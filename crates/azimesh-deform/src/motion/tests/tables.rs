//! Motions from tables of six degrees of freedom, and what tests of tables share.

use super::{two_cubes, two_squares};
use crate::motion::Motion;
use azimesh_core::error::Result;
use azimesh_core::geometry::transform::Matrix;
use azimesh_core::geometry::vector::{Vector, distance, dot};
use azimesh_io::mesh::Mesh;

/// A schedule of one body, with the files that it names, on a mesh.
pub(super) fn resolve(
    plane: bool,
    head: &str,
    body: &str,
    files: &[(&str, &str)],
) -> Result<Motion> {
    let mesh = if plane { two_squares() } else { two_cubes() };
    resolve_on(&mesh, head, body, files)
}

/// The same in space, with a body that goes from `root` to `tip` along its span.
pub(super) fn resolve_between(
    [root, tip]: [f64; 2],
    head: &str,
    body: &str,
    files: &[(&str, &str)],
) -> Result<Motion> {
    let mut mesh = two_cubes();
    for point in &mut mesh.points {
        point[0] = root + (tip - root) * point[0];
    }
    resolve_on(&mesh, head, body, files)
}

fn resolve_on(mesh: &Mesh, head: &str, body: &str, files: &[(&str, &str)]) -> Result<Motion> {
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
    schedule.resolve_on(mesh)
}

/// Returns the error of a wrong table, without its folder.
pub(super) fn told(plane: bool, body: &str, table: &str) -> String {
    told_at(plane, "azimuth.values = [0, 30]", body, ("m.csv", table))
}

/// Returns the error of a wrong schedule or file, without its folder.
pub(super) fn told_at(plane: bool, head: &str, body: &str, file: (&str, &str)) -> String {
    let found = resolve(plane, head, body, &[file]);
    let error = found.expect_err("it is wrong").to_string();
    match error.rfind(file.0).or_else(|| error.rfind("hover.toml")) {
        Some(at) => error[at..].to_owned(),
        None => error,
    }
}

pub(super) fn place(motion: &Motion, step: usize, x: Vector) -> Vector {
    motion.pose(0, &motion.steps[step]).apply(x)
}

#[track_caller]
pub(super) fn assert_near(found: Vector, expected: Vector) {
    assert!(
        distance(found, expected) < 2e-15,
        "{found:?} is not {expected:?}"
    );
}

pub(super) fn times(m: Matrix, x: Vector) -> Vector {
    m.map(|row| dot(row, x))
}

pub(super) fn rx(t: f64) -> Matrix {
    let (s, c) = t.sin_cos();
    [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]
}

pub(super) fn ry(t: f64) -> Matrix {
    let (s, c) = t.sin_cos();
    [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]
}

pub(super) fn rz(t: f64) -> Matrix {
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
    // Its rotations are those of twist; a part of it has that part of its angles.
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
fn a_step_between_the_last_row_and_the_next_revolution_is_told_of() {
    let rows = (0..6).map(|i| format!("{},{}\n", 60 * i, i));
    let table = format!("azimuth_deg,dx\n{}", rows.collect::<String>());
    let notes = |azimuths: &str| {
        let head = format!("azimuth.values = [{azimuths}]");
        let body = "table.file = \"m.csv\"";
        let motion = resolve(false, &head, body, &[("m.csv", &table)]).expect("it is good");
        let notes = motion.notes();
        notes
            .iter()
            .map(|note| note.text.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(
        notes("0, 300, 690"),
        [
            "body \"blade\": the table goes from azimuth 0 deg to azimuth 300 deg, one step before azimuth 360 deg, and so repeats itself; the values of step 2 are between its last and its first row"
        ]
    );
    assert!(notes("0, 30, 300, 360, 410").is_empty());
    for (rows, missing) in [
        ("0,0\n170,1\n190,2\n", "azimuth 275 deg"),
        ("0,0\n180,1\n", "azimuth 275 deg"),
    ] {
        let table = format!("azimuth_deg,dx\n{rows}");
        let found = resolve(
            false,
            "azimuth.values = [0, 275]",
            "table.file = \"m.csv\"",
            &[("m.csv", &table)],
        );
        let error = found.expect_err("it is half a revolution").to_string();
        assert!(
            error.contains(&format!(
                "the motion needs {missing}, but the table goes from azimuth 0 deg to"
            )),
            "{error}"
        );
        assert!(error.ends_with("add the missing rows"), "{error}");
    }
}

#[test]
fn a_wrong_table_is_told_its_line() {
    let short = told(false, TABLE, "azimuth_deg,dx\n0,1\n10,2\n");
    assert!(short.starts_with("m.csv:3: the motion needs azimuth 30 deg, but the table goes from azimuth 0 deg to azimuth 10 deg"), "{short}");
    let typo = told(false, TABLE, "azimuth_deg,rot_z\n0,1\n");
    assert!(
        typo.starts_with("m.csv:1: unknown column `rot_z`; did you mean `rot_z_"),
        "{typo}"
    );
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
        told.ends_with("the motion needs time 1 s, but the table goes from time 0 s to time 0 s; add the missing rows"),
        "{told}"
    );
}

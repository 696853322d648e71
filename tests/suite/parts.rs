//! A sequence in parts from one base, or from none: the same bytes as in one run.

use crate::support::{airfoil, files, rewrite, succeed};
use std::collections::BTreeMap;
use std::path::Path;

const PARTS: [&str; 3] = ["0..3", "3..4", "4..7"];

/// steps.csv as rows without their seconds.
fn rows(table: &[u8]) -> Vec<String> {
    let text = std::str::from_utf8(table).unwrap();
    text.lines().map(crate::support::without_seconds).collect()
}

/// Meshes and rows that a run left; a part calls its table steps_A-B.csv.
fn left(folder: &Path, out: &str) -> (BTreeMap<String, Vec<u8>>, Vec<String>) {
    let mut files = files(&folder.join(out));
    let mut tables = files.iter().filter(|(name, _)| name.ends_with(".csv"));
    let rows = rows(tables.next().expect("a table of the steps").1);
    assert!(tables.next().is_none());
    files.retain(|name, _| name.ends_with(".vtu"));
    (files, rows)
}

/// Runs a schedule of seven steps whole and in three parts; with `base` from base points chosen
/// before.
fn in_parts_as_in_one(folder: &Path, schedule: &str, base: bool) {
    let deform = |out: &str, options: &[&str]| {
        let args = ["-q", "deform", "n.vtu", schedule, "-o", out];
        succeed(folder, [&args[..], options].concat());
        left(folder, out)
    };
    let (whole, table) = deform("whole", &[]);
    assert_eq!(whole.len(), 7);
    let mut options = Vec::new();
    if base {
        let args = [
            "-q",
            "select",
            "n.vtu",
            schedule,
            "-o",
            "base.toml",
            "--force",
        ];
        succeed(folder, args);
        options = vec!["--base", "base.toml"];
    }
    let mut meshes = BTreeMap::new();
    let mut joined = vec![table[0].clone()];
    for (at, part) in PARTS.into_iter().enumerate() {
        let part = [&options[..], &["--steps", part]].concat();
        let (files, rows) = deform(&format!("part_{at}"), &part);
        assert_eq!(rows[0], table[0]);
        joined.extend_from_slice(&rows[1..]);
        meshes.extend(files);
    }
    assert_eq!(joined, table);
    assert_eq!(meshes.len(), whole.len());
    for (name, content) in whole {
        // Not assert_eq: nobody wants to read the bytes.
        assert!(meshes[&name] == content, "{name} by {schedule}");
    }
    for out in ["whole", "part_0", "part_1", "part_2"] {
        std::fs::remove_dir_all(folder.join(out)).unwrap();
    }
}

/// A pitching airfoil in seven steps, with more lines in two sections.
fn case(folder: &Path, rbf: &str, selection: &str) {
    let changes = [
        ("step = 10.0", "step = 60.0"),
        ("[rbf]", &format!("[rbf]\n{rbf}")[..]),
        ("[selection]", &format!("[selection]\n{selection}")[..]),
    ];
    rewrite(folder, "n.toml", "case.toml", &changes);
}

#[test]
fn a_sequence_comes_in_parts_as_in_one() {
    let folder = airfoil();
    case(folder.path(), "", "");
    in_parts_as_in_one(folder.path(), "case.toml", true);
    in_parts_as_in_one(folder.path(), "case.toml", false);
}

#[test]
fn a_constant_selection_comes_in_parts_as_in_one() {
    let folder = airfoil();
    case(folder.path(), "", "method = \"constant\"\nmax_points = 60");
    in_parts_as_in_one(folder.path(), "case.toml", true);
    case(
        folder.path(),
        "",
        "method = \"constant\"\nconstant = [0.0, 0.1, 0.0]",
    );
    in_parts_as_in_one(folder.path(), "case.toml", true);
}

#[test]
fn selections_along_the_way_come_in_parts_as_in_one() {
    let folder = airfoil();
    // Base points for a step at which nothing moves would be none.
    rewrite(
        folder.path(),
        "n.toml",
        "n.toml",
        &[("sin = 10.0", "cos = 10.0")],
    );
    for refresh in ["", "refresh = 120.0", "refresh = 100.0"] {
        case(folder.path(), "", &format!("method = \"real\"\n{refresh}"));
        in_parts_as_in_one(folder.path(), "case.toml", false);
    }
}

#[test]
fn a_twist_comes_in_parts_as_in_one() {
    let folder = airfoil();
    case(
        folder.path(),
        "interpolate = \"twist\"\nrotation_radius = 4.0",
        "",
    );
    in_parts_as_in_one(folder.path(), "case.toml", true);
}

#[test]
fn substeps_come_in_parts_as_in_one() {
    let folder = airfoil();
    for rbf in ["substeps = 3", "substeps = 2\ninterpolate = \"twist\""] {
        case(folder.path(), rbf, "");
        in_parts_as_in_one(folder.path(), "case.toml", true);
    }
}

#[test]
fn every_surface_node_comes_in_parts_as_in_one() {
    let folder = airfoil();
    case(folder.path(), "", "method = \"all\"");
    in_parts_as_in_one(folder.path(), "case.toml", true);
}

#[test]
fn a_sliding_boundary_comes_in_parts_as_in_one() {
    let folder = airfoil();
    let slide = ("fixed = [\"farfield\"]", "slide = [\"farfield\"]");
    rewrite(folder.path(), "n.toml", "n.toml", &[slide]);
    for rbf in ["", "substeps = 2"] {
        case(folder.path(), rbf, "");
        in_parts_as_in_one(folder.path(), "case.toml", true);
    }
}

//! The same input gives the same bytes, whatever the number of threads.

use crate::support::sequence::testdata;
use crate::support::{airfoil, files, rewrite, succeed};
use std::path::Path;

/// steps.csv without its seconds.
fn without_seconds(table: &[u8]) -> Vec<String> {
    let text = std::str::from_utf8(table).unwrap();
    text.lines().map(crate::support::without_seconds).collect()
}

/// Deforms with one, two and three threads; all files but run.json must hold the same bytes.
fn same_on_any_number_of_threads(folder: &Path, mesh: &str, schedule: &str) {
    let deform = |threads: &str| {
        let out = format!("{schedule}_{threads}");
        // A turning zone here is not round.
        let options = ["-q", "--allow-outside", "--threads", threads, "-o", &out];
        succeed(folder, [&["deform", mesh, schedule][..], &options].concat());
        let mut files = files(&folder.join(out));
        files.remove("run.json").expect("a record of the run");
        let table = files.remove("steps.csv").expect("a table of the steps");
        (files, table)
    };
    let (one, table) = deform("1");
    assert!(one.len() > 4, "{:?}", one.keys());
    for threads in ["2", "3"] {
        let (other, other_table) = deform(threads);
        let names = |files: &std::collections::BTreeMap<String, Vec<u8>>| -> Vec<String> {
            files.keys().cloned().collect()
        };
        assert_eq!(names(&one), names(&other));
        for (name, content) in &one {
            // Not assert_eq: nobody wants to read the bytes.
            assert!(*content == other[name], "{name} with {threads} threads");
        }
        assert_eq!(without_seconds(&table), without_seconds(&other_table));
    }
}

/// A blade in its cylinder or in zones, and three steps of its schedule.
fn blade(folder: &Path, sample: &str) {
    let size = [
        "--layers",
        "4",
        "--first-cell",
        "0.01",
        "--surface-nodes",
        "4000",
    ];
    let args = [&["-q", "sample", sample, "-o", "b.vtu"][..], &size].concat();
    succeed(folder, &args);
    let tolerance = std::fs::read_to_string(folder.join("b.toml")).unwrap();
    let tolerance = tolerance
        .lines()
        .find(|line| line.starts_with("tolerance"))
        .unwrap();
    let changes = [
        ("step = 10.0", "step = 130.0"),
        (tolerance, "tolerance = 1e-4"),
    ];
    rewrite(folder, "b.toml", "b.toml", &changes);
}

#[test]
fn an_airfoil_deforms_to_the_same_bytes_on_any_number_of_threads() {
    let folder = airfoil();
    let folder = folder.path();
    succeed(folder, "-q sample naca0012 --nodes 30000 --force -o n.vtu");
    rewrite(
        folder,
        "n.toml",
        "n.toml",
        &[("step = 10.0", "step = 50.0")],
    );
    same_on_any_number_of_threads(folder, "n.vtu", "n.toml");
    let cells = (
        "[rbf]",
        "[output]\nquality = \"cells\"\ndisplacement = true\nencoding = \"base64\"\n\
        compression = \"zlib\"\n[rbf]",
    );
    rewrite(folder, "n.toml", "arrays.toml", &[cells]);
    same_on_any_number_of_threads(folder, "n.vtu", "arrays.toml");
}

#[test]
fn a_blade_deforms_to_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    blade(folder, "blade");
    same_on_any_number_of_threads(folder, "b.vtu", "b.toml");
    let radius = "support_radius = 5.625 ";
    let msh = "[output]\nformat = \"msh\"\n[rbf]";
    let changes = [
        (radius, "support_radius = 1.5 "),
        ("[rbf]", msh),
        ("tolerance = 1e-4", "tolerance = 1e-3"),
    ];
    rewrite(folder, "b.toml", "small.toml", &changes);
    same_on_any_number_of_threads(folder, "b.vtu", "small.toml");
}

#[test]
fn a_turning_zone_deforms_to_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    blade(folder, "rotor");
    let turning = ("frame = \"rotating\"", "frame = \"inertial\"");
    rewrite(folder, "b.toml", "turning.toml", &[turning]);
    same_on_any_number_of_threads(folder, "b.vtu", "turning.toml");
}

#[test]
fn sliding_and_periodic_boundaries_give_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    for (mesh, schedule) in [
        ("wing_on_plane.vtu", "wing_on_plane.toml"),
        ("body_in_duct.vtu", "body_in_duct.toml"),
        ("rotor_sector.vtu", "rotor_sector_sliding.toml"),
        ("block.vtu", "block_sliding.toml"),
    ] {
        for name in [mesh, schedule] {
            std::fs::copy(testdata(name), folder.path().join(name)).unwrap();
        }
        same_on_any_number_of_threads(folder.path(), mesh, schedule);
    }
}

#[test]
fn a_twist_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    blade(folder, "blade");
    let twist = (
        "[rbf]",
        "[rbf]\ninterpolate = \"twist\"\nrotation_radius = 4.0",
    );
    rewrite(folder, "b.toml", "twist.toml", &[twist]);
    same_on_any_number_of_threads(folder, "b.vtu", "twist.toml");
    let more = ("[rbf]", "[rbf]\nsubsteps = 2\npolynomial = \"linear\"");
    let coarse = ("tolerance = 1e-4", "tolerance = 1e-3");
    rewrite(folder, "twist.toml", "more.toml", &[more, coarse]);
    same_on_any_number_of_threads(folder, "b.vtu", "more.toml");
}

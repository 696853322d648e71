//! How much `check` says that the meshes will take, and how much they take.

use crate::support::{airfoil, files, json, rewrite, succeed};
use std::path::Path;

/// A schedule, and the bytes that `check` foresees for it and those that its meshes take.
fn foreseen_and_taken(folder: &Path, mesh: &str, schedule: &str) -> (f64, f64) {
    let foreseen = json(folder, ["check", mesh, schedule])["output_bytes"].clone();
    succeed(folder, ["-q", "deform", mesh, schedule, "-o", "out"]);
    let left = files(&folder.join("out"));
    let stem = mesh.strip_suffix(".vtu").unwrap();
    let is_mesh = |name: &&String| name.starts_with(stem) && !name.ends_with(".pvd");
    let meshes = left.keys().filter(is_mesh);
    let taken: usize = meshes.map(|name| left[name].len()).sum();
    std::fs::remove_dir_all(folder.join("out")).unwrap();
    (foreseen.as_f64().unwrap(), taken as f64)
}

#[test]
fn bytes_of_the_output_are_foreseen() {
    let folder = airfoil();
    let folder = folder.path();
    let args = "-q sample blade --nodes 5000 -o blade.vtu";
    succeed(folder, args);
    for (mesh, step, output) in [
        ("n.vtu", "10.0", ""),
        ("n.vtu", "1.0", ""),
        (
            "n.vtu",
            "30.0",
            "\nquality = \"cells\"\ndisplacement = true",
        ),
        ("blade.vtu", "60.0", ""),
        (
            "blade.vtu",
            "60.0",
            "\nquality = \"cells\"\ndisplacement = true",
        ),
    ] {
        let of_mesh = mesh.replace(".vtu", ".toml");
        for format in ["vtu", "vtkhdf", "cgns", "su2"] {
            let changes = [
                ("step = 10.0", format!("step = {step}")),
                (
                    "[rbf]",
                    format!("[output]\nformat = \"{format}\"{output}\n[rbf]"),
                ),
            ];
            let changes = changes.each_ref().map(|(from, to)| (*from, to.as_str()));
            rewrite(folder, &of_mesh, "case.toml", &changes);
            let (foreseen, taken) = foreseen_and_taken(folder, mesh, "case.toml");
            // A sequence in one file is bounded with up to 100 kB of metadata per step.
            let n_steps = 360.0 / step.parse::<f64>().unwrap() + 1.0;
            assert!(
                foreseen >= taken && foreseen <= 1.1 * taken + n_steps * 100e3,
                "{mesh}, {format}, every {step} degrees{output}: {foreseen} bytes foreseen, {taken} taken"
            );
        }
    }
}

//! The commands of docs/tasks/regression_test.md do what the page says.

use crate::support::{assert_says, succeed};
use std::path::Path;
use std::process::{Command, Output};

/// The commands of the page, block by block.
fn blocks() -> Vec<String> {
    let page = include_str!("../../docs/tasks/regression_test.md");
    let blocks = page.split("```sh\n").skip(1);
    blocks
        .map(|rest| rest.split("```").next().unwrap().to_owned())
        .collect()
}

fn shell(folder: &Path, commands: &str) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_azimesh"));
    let path = format!(
        "{}:{}",
        program.parent().unwrap().display(),
        std::env::var("PATH").unwrap()
    );
    let mut shell = Command::new("sh");
    shell
        .current_dir(folder)
        .env("PATH", path)
        .args(["-e", "-c", commands]);
    shell.output().unwrap()
}

#[test]
fn the_pipeline_of_the_docs_passes_and_finds_what_changed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let blocks = blocks();
    let [sample, golden, check] = &blocks[..] else {
        panic!("the page has {} blocks", blocks.len());
    };
    for commands in [sample, golden] {
        let output = shell(path, commands);
        assert!(
            output.status.success() && output.stdout.is_empty(),
            "{commands}: {output:?}"
        );
    }
    for _ in 0..2 {
        let output = shell(path, check);
        let said = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success(), "{said}: {:?}", output.stderr);
        assert_says(&said, &["same: ", "37 steps", "792 nodes", "836 cells"]);
    }
    // A schedule that turns the airfoil further gives other meshes.
    let schedule = std::fs::read_to_string(path.join("airfoil.toml")).unwrap();
    assert!(schedule.contains("sin = 10.0"), "{schedule}");
    std::fs::write(
        path.join("airfoil.toml"),
        schedule.replace("sin = 10.0", "sin = 10.001"),
    )
    .unwrap();
    let output = shell(path, check);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let said = String::from_utf8(output.stdout).unwrap();
    assert_says(&said, &["different: "]);
    // And a strict bound on quality ends it before.
    succeed(
        path,
        "-q sample naca0012 --nodes 800 -o airfoil.su2 --force",
    );
    let strict = check.replace("min_scaled_jacobian<0.5", "min_scaled_jacobian<0.9");
    let output = shell(path, &strict);
    assert_eq!(
        (output.status.code(), output.stdout.len()),
        (Some(1), 0),
        "{output:?}"
    );
}

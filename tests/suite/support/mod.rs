//! What the tests from outside share: running the program in a folder of its own, and sample meshes.

pub mod exodus;
pub mod netcdf;
pub mod plot3d;
pub mod sequence;

use assert_cmd::Command;
use azimesh::sample::{BladeOptions, CellShape, SizeOptions, blade};
use azimesh_io::mesh::Mesh;
use std::collections::BTreeMap;
use std::path::Path;
use tempfile::TempDir;

/// What a run of the program gave.
#[derive(Debug)]
pub struct Run {
    pub code: i32,
    pub out: String,
    pub err: String,
}

/// A blade with so many nodes, of cells of one shape.
pub fn blade_of(nodes: usize, surface_nodes: usize, cells: CellShape) -> Mesh {
    let size = SizeOptions {
        nodes: Some(nodes),
        surface_nodes: Some(surface_nodes),
        ..SizeOptions::default()
    };
    let options = BladeOptions {
        size,
        cells,
        ..BladeOptions::default()
    };
    blade(&options).unwrap().mesh
}

/// Arguments of the program: a line of words between blanks, or a text for each.
pub trait Args: std::fmt::Debug {
    fn words(&self) -> Vec<&str>;
}

impl Args for str {
    fn words(&self) -> Vec<&str> {
        self.split_whitespace().collect()
    }
}

impl Args for String {
    fn words(&self) -> Vec<&str> {
        self.as_str().words()
    }
}

impl Args for [&str] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl<const N: usize> Args for [&str; N] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl Args for Vec<&str> {
    fn words(&self) -> Vec<&str> {
        self.clone()
    }
}

impl<T: Args + ?Sized> Args for &T {
    fn words(&self) -> Vec<&str> {
        (**self).words()
    }
}

/// Runs the program in a folder.
pub fn azimesh(folder: &Path, args: impl Args) -> Run {
    let output = Command::cargo_bin("azimesh")
        .unwrap()
        .current_dir(folder)
        .args(args.words())
        .output()
        .unwrap();
    Run {
        code: output.status.code().expect("no signal ended it"),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// Runs the program; it must end well.
pub fn succeed(folder: &Path, args: impl Args) -> Run {
    let run = azimesh(folder, &args);
    assert_eq!(run.code, 0, "{args:?}: {run:?}");
    run
}

/// The JSON a command prints.
pub fn json(folder: &Path, args: impl Args) -> serde_json::Value {
    let args = [&args.words()[..], &["--json"]].concat();
    let run = azimesh(folder, &args);
    serde_json::from_str(&run.out).unwrap_or_else(|error| panic!("{args:?}: {error}: {run:?}"))
}

/// A folder with a small NACA 0012, `n.vtu` and `n.toml`.
pub fn airfoil() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "-q sample naca0012 --nodes 800 -o n.vtu");
    folder
}

/// The same with `few.toml`, its schedule in five steps.
pub fn short() -> TempDir {
    let folder = airfoil();
    let few = [("step = 10.0", "step = 90.0")];
    rewrite(folder.path(), "n.toml", "few.toml", &few);
    folder
}

/// Writes `to` as `from` with each pair's first text replaced by its second; each must be there.
pub fn rewrite(folder: &Path, from: &str, to: &str, changes: &[(&str, &str)]) {
    let mut text = std::fs::read_to_string(folder.join(from)).unwrap();
    for (old, new) in changes {
        assert!(text.contains(old), "{from} has no {old:?}");
        text = text.replace(old, new);
    }
    std::fs::write(folder.join(to), text).unwrap();
}

/// Names of the files in a folder, hidden ones too.
pub fn names(folder: &Path) -> Vec<String> {
    files(folder).into_keys().collect()
}

/// Files of a folder by name.
pub fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            let content = if path.is_file() {
                std::fs::read(&path).unwrap()
            } else {
                Vec::new()
            };
            (name, content)
        })
        .collect()
}

/// All files below a folder by their paths.
pub fn all_files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path)
            } else {
                let name = path
                    .strip_prefix(folder)
                    .unwrap()
                    .to_str()
                    .unwrap()
                    .to_owned();
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// A sentence has these names, nouns and numbers. A number may not be a part of another.
pub fn assert_says(sentence: &str, parts: &[&str]) {
    let is_digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    for part in parts {
        let is_apart = |at: usize| {
            let (before, after) = (&sentence[..at], &sentence[at + part.len()..]);
            let longer_before =
                is_digit(part.chars().next()) && is_digit(before.chars().next_back());
            let longer_after = is_digit(part.chars().next_back()) && is_digit(after.chars().next());
            !(longer_before || longer_after)
        };
        let is_said = sentence.match_indices(part).any(|(at, _)| is_apart(at));
        assert!(is_said, "{part:?} is not in: {sentence}");
    }
}

/// A row of steps.csv without its seconds, the tenth column from the end.
pub fn without_seconds(row: &str) -> String {
    let mut values: Vec<&str> = row.split(',').collect();
    values.remove(values.len() - 10);
    values.join(",")
}

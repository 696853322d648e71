//! A format that is a folder, for tests: it is this file and a line in [`FORMATS`](super::FORMATS), and all commands
//! and runs support it.
//!
//! `points` has x, y and z of a node a line, `cells` the nodes of a tetrahedron; `0.5/points` the nodes at a
//! time of a sequence.

use super::{
    Begin, Commit, Folder, Format, Location, Notes, ReadOptions, SequenceFile, Staged,
    WriteOptions, save, stage_bytes,
};
use crate::mesh::{CellKind, Mesh, MeshView};
use azimesh_core::error::{Error, Result};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// A folder of two files of text.
pub static TOY: Format = Format {
    name: "toy",
    title: "toy (a folder)",
    extensions: &["toy"],
    folder: Some(Folder {
        detect: |location| matches!(location, Location::Folder(folder) if folder.join("cells").is_file()),
        read,
        steps: |location| {
            let times = times(location.path())?;
            Ok(times.into_iter().map(|(time, _)| time).collect())
        },
        shared: |_| None,
    }),
    write_files: Some(|mesh, out, _| {
        let folder = out.path().to_path_buf();
        for (name, text) in [("points", points_of(mesh)), ("cells", cells_of(mesh)?)] {
            out.in_folder(&folder, name, |out| {
                let written = out.write_all(text.as_bytes());
                written.map_err(|error| Error::io(&folder, &error))
            })?;
        }
        Ok(Notes::default())
    }),
    sequence: Some(|path, _, begin, sync| {
        Ok(Box::new(Sequence {
            folder: path.to_path_buf(),
            is_resuming: begin == Begin::Resume,
            commit: Commit {
                replace: true,
                sync,
            },
            names: Vec::new(),
            n_bytes: 0,
            staged: Vec::new(),
            notes: Notes::default(),
        }))
    }),
    ..Format::NEW
};

fn read(location: &Location, options: &ReadOptions, _: &mut Notes) -> Result<Mesh> {
    let folder = location.path();
    let times = times(folder)?;
    let step = options.step.or(times.len().checked_sub(1));
    let points = match step.and_then(|step| times.get(step)) {
        Some((_, name)) => folder.join(name).join("points"),
        None => folder.join("points"),
    };
    let points = numbers::<f64>(&points)?;
    let mut mesh = Mesh {
        points: points.as_chunks().0.to_vec(),
        ..Mesh::default()
    };
    for nodes in numbers::<u32>(&folder.join("cells"))?.as_chunks::<4>().0 {
        mesh.cells.push(CellKind::Tetrahedron, nodes);
    }
    Ok(mesh)
}

fn points_of(mesh: &MeshView) -> String {
    let lines = mesh.points.iter();
    lines
        .map(|[x, y, z]| format!("{x:?} {y:?} {z:?}\n"))
        .collect()
}

fn cells_of(mesh: &MeshView) -> Result<String> {
    let mut text = String::new();
    for run in mesh.volume_runs() {
        if run.kind != CellKind::Tetrahedron {
            return Err(Error::input("a toy has tetrahedra"));
        }
        for [a, b, c, d] in run.connectivity.as_chunks().0 {
            writeln!(text, "{a} {b} {c} {d}").expect("a string takes all");
        }
    }
    Ok(text)
}

fn numbers<T: std::str::FromStr>(path: &Path) -> Result<Vec<T>> {
    let text = fs::read_to_string(path).map_err(|error| Error::io(path, &error))?;
    let wrong = || Error::input("expected a number").file(path);
    let words = text.split_whitespace();
    words
        .map(|word| word.parse().map_err(|_| wrong()))
        .collect()
}

/// Times of the steps and the names of their folders, in the order of the times.
fn times(folder: &Path) -> Result<Vec<(f64, String)>> {
    let entries = fs::read_dir(folder).map_err(|error| Error::io(folder, &error))?;
    let names = entries.flatten().map(|entry| entry.file_name());
    let time = |name: std::ffi::OsString| {
        let name = name.into_string().ok()?;
        Some((name.parse().ok()?, name))
    };
    let mut times: Vec<(f64, String)> = names.filter_map(time).collect();
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(times)
}

/// A folder that takes one mesh after another.
struct Sequence {
    folder: PathBuf,
    commit: Commit,
    is_resuming: bool,
    /// Names of the steps.
    names: Vec<String>,
    n_bytes: u64,
    /// Files of the mesh appended last.
    staged: Vec<Staged>,
    notes: Notes,
}

impl SequenceFile for Sequence {
    fn append(&mut self, time: f64, mesh: &MeshView) -> Result<blake3::Hash> {
        if self.names.is_empty() && !self.is_resuming {
            fs::create_dir_all(&self.folder).map_err(|error| Error::io(&self.folder, &error))?;
            for (name, text) in [("points", points_of(mesh)), ("cells", cells_of(mesh)?)] {
                let path = self.folder.join(name);
                self.staged
                    .push(stage_bytes(text.as_bytes(), &path, self.commit)?);
            }
        }
        let (name, text) = (time.to_string(), points_of(mesh));
        let path = self.folder.join(&name).join("points");
        self.is_resuming &= fs::read_to_string(&path).is_ok_and(|found| found == text);
        if !self.is_resuming {
            let folder = self.folder.join(&name);
            fs::create_dir_all(&folder).map_err(|error| Error::io(&folder, &error))?;
            self.staged
                .push(stage_bytes(text.as_bytes(), &path, self.commit)?);
        }
        self.names.push(name);
        self.n_bytes += text.len() as u64;
        Ok(blake3::hash(text.as_bytes()))
    }
    fn commit(&mut self) -> Result<()> {
        Staged::keep_all(self.staged.drain(..))
    }
    fn notes(&self) -> &Notes {
        &self.notes
    }
    fn n_bytes(&self) -> u64 {
        self.n_bytes
    }
    fn end(&mut self) -> Result<bool> {
        let mut later = times(&self.folder)?;
        later.retain(|(_, name)| !self.names.contains(name));
        for (_, name) in &later {
            let path = self.folder.join(name);
            fs::remove_dir_all(&path).map_err(|error| Error::io(&path, &error))?;
        }
        Ok(!later.is_empty())
    }
    fn is_resuming(&self) -> bool {
        self.is_resuming
    }
}

fn tetrahedron() -> Mesh {
    let mut mesh = Mesh {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        ..Mesh::default()
    };
    mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
    mesh
}

#[test]
fn a_folder_is_written_whole_or_not_at_all_and_found_by_its_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.toy");
    let mesh = tetrahedron();
    mesh.write(&path).expect("it can be written");
    let loaded = Mesh::read_with(&path, &ReadOptions::default()).expect("it can be read");
    assert_eq!((loaded.mesh, loaded.format.name), (mesh.clone(), "toy"));
    let (options, keep) = (WriteOptions::default(), Commit::with_force(false));
    assert!(
        save(&mesh.view(), &path, &TOY, &options, keep).is_err(),
        "it is there"
    );
    let mut other = mesh.clone();
    other.points[0][0] = -1.0;
    other.cells.push(CellKind::Pyramid, &[0, 1, 2, 3, 0]);
    assert!(other.write(&path).is_err(), "no tetrahedron");
    assert_eq!(Mesh::read(&path).expect("it is as it was"), mesh);
    assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 1);
    other.cells = mesh.cells.clone();
    other
        .write(&path)
        .expect("it takes the place of the old one");
    assert_eq!(Mesh::read(&path).expect("it can be read"), other);
}

#[test]
fn a_sequence_has_a_folder_a_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("moving.toy");
    let create = TOY.sequence.expect("it has sequences");
    let write = |begin, n: u32| {
        let mut file = create(&path, &WriteOptions::default(), begin, false).expect("it starts");
        let mesh = tetrahedron();
        for step in 0..n {
            let points: Vec<_> = mesh
                .points
                .iter()
                .map(|p| p.map(|x| x + f64::from(step)))
                .collect();
            let time = f64::from(step) / 2.0;
            file.push(time, &mesh.view().with_points(&points))
                .expect("a step");
        }
        (file.is_resuming(), file.end().expect("it ends"))
    };
    assert_eq!(write(Begin::Create, 3), (false, false));
    assert_eq!(write(Begin::Resume, 2), (true, true));
    assert_eq!(write(Begin::Resume, 4), (false, false));
    let location = Location::open(&path).expect("it is there");
    assert_eq!(TOY.steps(&location).expect("times"), [0.0, 0.5, 1.0, 1.5]);
    let options = ReadOptions {
        step: Some(2),
        ..ReadOptions::default()
    };
    let mesh = Mesh::read_with(&path, &options)
        .expect("it can be read")
        .mesh;
    assert_eq!(mesh.points[0], [2.0; 3]);
}

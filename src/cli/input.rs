//! What a command reads: a mesh, or the meshes of a sequence one after another.

use super::Context;
use crate::error::{Error, Result};
use crate::formats::{self, Format, Loaded, Source};
use crate::mesh::Mesh;
use std::path::{Path, PathBuf};

/// One input, opened.
pub struct Input {
    path: PathBuf,
    meshes: Meshes,
}

enum Meshes {
    /// A file with one mesh, or with a sequence.
    File {
        source: Source,
        format: &'static dyn Format,
        times: Vec<f64>,
    },
    /// A list of files with a time each.
    Listed(Vec<(f64, PathBuf)>),
}

impl Input {
    /// Opens a mesh file, of a format that is known or that its content tells, a list of them, or
    /// the sequence of a folder.
    pub fn open(path: &Path, format: Option<&'static dyn Format>) -> Result<Self> {
        if path.is_dir() {
            return Self::open(&sequence_in(path)?, format);
        }
        let meshes = match formats::is_series(path) {
            true => Meshes::Listed(formats::read_series(path)?),
            false => {
                let source = Source::open(path)?;
                let format = format.map_or_else(|| formats::of(&source), Ok)?;
                let times = format.steps(&source).map_err(|error| error.file(path))?;
                Meshes::File {
                    source,
                    format,
                    times,
                }
            }
        };
        Ok(Self {
            path: path.to_path_buf(),
            meshes,
        })
    }

    /// Files that are the meshes of one sequence, in order; their times are 0, 1, 2, ...
    pub fn of_parts(paths: &[PathBuf]) -> Result<Self> {
        if let Some(list) = paths.iter().find(|path| formats::is_series(path)) {
            return Err(Error::input("a list of meshes cannot be a part of a sequence").file(list));
        }
        let times = (0..paths.len()).map(|i| i as f64);
        Ok(Self {
            path: paths[0].clone(),
            meshes: Meshes::Listed(times.zip(paths.iter().cloned()).collect()),
        })
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file with the mesh of a step.
    pub fn path_of(&self, step: usize) -> &Path {
        match &self.meshes {
            Meshes::File { .. } => &self.path,
            Meshes::Listed(list) => list.get(step).map_or(&self.path, |(_, path)| path),
        }
    }

    /// What the file is.
    pub fn title(&self) -> Option<String> {
        match &self.meshes {
            Meshes::File { source, format, .. } => Some(format.title_of(source.bytes())),
            Meshes::Listed(_) => None,
        }
    }

    /// Version of the format that the file says it has.
    pub fn version(&self) -> Option<String> {
        match &self.meshes {
            Meshes::File { source, format, .. } => format.version(source.bytes()),
            Meshes::Listed(_) => None,
        }
    }

    /// Times of a sequence; `None` where it is one mesh.
    pub fn times(&self) -> Option<Vec<f64>> {
        match &self.meshes {
            Meshes::File { times, .. } => (times.len() > 1).then(|| times.clone()),
            Meshes::Listed(list) => Some(list.iter().map(|(time, _)| *time).collect()),
        }
    }

    /// Name without folder and endings.
    pub fn stem(&self) -> String {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let name = formats::without_packing(&name);
        let name = name.strip_suffix(".series").unwrap_or(name);
        let known = formats::FORMATS
            .iter()
            .flat_map(|format| format.extensions());
        let stem = known
            .chain(&["pvd"])
            .filter_map(|ending| name.strip_suffix(ending)?.strip_suffix('.'))
            .min_by_key(|stem| stem.len());
        match stem.unwrap_or(name) {
            "" | "-" => "mesh".to_owned(),
            stem => stem.to_owned(),
        }
    }

    /// The mesh of a step, or the one there is; tells what its reader remarks.
    pub fn mesh(&self, step: Option<usize>, context: &Context) -> Result<Mesh> {
        let loaded = self.read(step, context)?;
        for note in loaded.notes.iter() {
            context.note(&format!("{}: {note}", self.path.display()));
        }
        Ok(loaded.mesh)
    }

    /// Reads a mesh: that of a step of a sequence, or the one there is.
    pub fn read(&self, step: Option<usize>, context: &Context) -> Result<Loaded> {
        context.stage("reading", || {
            let mut options = context.read_options();
            match &self.meshes {
                Meshes::File { source, format, .. } => {
                    options.step = step;
                    formats::read_as(*format, source, &options)
                }
                Meshes::Listed(list) => {
                    let (_, path) = &list[step.unwrap_or(list.len() - 1)];
                    formats::read(&Source::open(path)?, &options)
                }
            }
        })
    }
}

/// The file that is or lists the sequence of a folder, as `deform` leaves it: a .pvd, or a .vtkhdf
/// or .cgns with all steps.
fn sequence_in(folder: &Path) -> Result<PathBuf> {
    let entries = std::fs::read_dir(folder).map_err(|error| Error::io(folder, &error))?;
    let mut files = Vec::new();
    for entry in entries {
        files.push(entry.map_err(|error| Error::io(folder, &error))?.path());
    }
    files.sort();
    let visible = |path: &&PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        !name.starts_with('.') && path.is_file()
    };
    let ending = |path: &PathBuf| path.extension().map(|e| e.to_ascii_lowercase());
    for wanted in [&["pvd"][..], &["vtkhdf", "cgns"]] {
        let is_wanted =
            |path: &&PathBuf| wanted.iter().any(|w| ending(path).is_some_and(|e| e == *w));
        let found: Vec<&PathBuf> = files.iter().filter(visible).filter(is_wanted).collect();
        match found[..] {
            [] => continue,
            [one] => return Ok(one.clone()),
            [first, second, ..] => {
                return Err(Error::input(format!(
                    "the folder holds several sequences, {} and {}; name one of them",
                    first.display(),
                    second.display()
                ))
                .file(folder));
            }
        }
    }
    Err(Error::input(
        "this is a folder, not a mesh, and it holds no sequence: no .pvd, .vtkhdf or .cgns",
    )
    .file(folder))
}

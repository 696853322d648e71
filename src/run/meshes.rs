//! The meshes of a run: a file for each step, or one file for all.

use super::names::Names;
use crate::error::Result;
use crate::formats::{
    Begin, Format, Notes, SequenceFile, Waiting, WriteOptions, stage_companions, stage_whole,
};
use crate::mesh::MeshView;
use crate::motion::Step;
use std::io::Write;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The file that takes all meshes, also in the hands of the thread that commits them.
type Shared = Arc<Mutex<Box<dyn SequenceFile>>>;

/// Where the meshes go.
pub(super) struct Meshes<'a> {
    names: &'a Names,
    format: &'static dyn Format,
    options: WriteOptions,
    /// The file that takes all of them, where the format has that.
    sequence: Option<Shared>,
    /// Whether all meshes so far were in that file before.
    pub is_retracing: bool,
    /// Where each mesh written or retraced ends in that file.
    pub ends: Vec<u64>,
    /// What the format could not hold.
    pub notes: Notes,
}

/// A mesh that is written and not one of the sequence yet.
pub(super) enum Written {
    /// Files under hidden names.
    Files(Vec<Waiting>),
    /// The mesh appended last to the file of all.
    Appended(Shared, PathBuf),
}

impl Written {
    /// Makes it one of the sequence.
    pub fn keep(self) -> Result<()> {
        match self {
            Self::Files(files) => Waiting::keep_all(files),
            Self::Appended(sequence, path) => {
                lock(&sequence).commit().map_err(|error| error.file(&path))
            }
        }
    }
}

impl<'a> Meshes<'a> {
    /// Nothing is under its name before the first mesh is kept.
    pub fn new(
        names: &'a Names,
        format: &'static dyn Format,
        options: WriteOptions,
        begin: Begin,
    ) -> Result<Self> {
        let first = names.path(&names.mesh(names.steps().start));
        let create = |create: crate::formats::CreateSequence| {
            create(&first, &options, begin, names.commit.sync)
        };
        let sequence = format.sequence().map(create).transpose()?;
        Ok(Self {
            names,
            format,
            options,
            is_retracing: sequence.as_ref().is_some_and(|file| file.is_retracing()),
            sequence: sequence.map(|file| Arc::new(Mutex::new(file))),
            ends: Vec::new(),
            notes: Notes::default(),
        })
    }

    /// Writes the mesh of a step; gives the hash of its file, or of what it added to that of all
    /// steps. A mesh is kept before the next is appended.
    pub fn write(&mut self, mesh: &MeshView, step: &Step) -> Result<(blake3::Hash, Written)> {
        let path = self.names.path(&self.names.mesh(step.index));
        if let Some(sequence) = &self.sequence {
            let mut file = lock(sequence);
            let appended = file.append(step.time(), mesh);
            let hash = appended.map_err(|error| error.file(&path))?;
            self.ends.push(file.n_bytes());
            self.is_retracing = file.is_retracing();
            return Ok((hash, Written::Appended(Arc::clone(sequence), path)));
        }
        let commit = self.names.commit;
        let ((hash, notes), file) = stage_whole(&path, commit, |out| {
            let mut hashing = Hashing {
                out,
                hasher: blake3::Hasher::new(),
            };
            let notes = self.format.write(mesh, &mut hashing, &self.options)?;
            Ok((hashing.hasher.finalize(), notes))
        })?;
        self.notes.extend(notes);
        let mut files = vec![file];
        files.extend(stage_companions(mesh, &path, self.format, commit)?);
        Ok((hash, Written::Files(files)))
    }

    /// Makes the file of all steps end with the mesh written or retraced last; tells whether it did
    /// not.
    pub fn end(&mut self) -> Result<bool> {
        let path = self.names.path(&self.names.mesh(self.names.steps().start));
        let ended = self.sequence.as_ref().map(|sequence| lock(sequence).end());
        let ended = ended.unwrap_or(Ok(false));
        ended.map_err(|error| error.file(&path))
    }
}

fn lock(sequence: &Shared) -> MutexGuard<'_, Box<dyn SequenceFile>> {
    sequence.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The hash of the file that a mesh would have alone; it is written to nowhere.
pub(super) fn hash_of(
    mesh: &MeshView,
    format: &dyn Format,
    options: &WriteOptions,
) -> Result<blake3::Hash> {
    let mut hashing = Hashing {
        out: &mut std::io::sink(),
        hasher: blake3::Hasher::new(),
    };
    format.write(mesh, &mut hashing, options)?;
    Ok(hashing.hasher.finalize())
}

struct Hashing<'a> {
    out: &'a mut dyn Write,
    hasher: blake3::Hasher,
}

impl Write for Hashing<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let n = self.out.write(bytes)?;
        self.hasher.update(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

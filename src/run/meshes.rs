//! The meshes of a run: a file for each step, or one file for all; beside them the files of surfaces.

use super::names::Names;
use super::surface::SurfaceFiles;
use azimesh_core::error::Result;
use azimesh_deform::motion::Step;
use azimesh_io::formats::{
    Begin, Format, Notes, Output, OutputSet, SequenceFile, Staged, WriteOptions,
};
use azimesh_io::mesh::MeshView;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The file that takes all meshes, also in the hands of the thread that commits them.
type Shared = Arc<Mutex<Box<dyn SequenceFile>>>;

/// Where the meshes go.
pub(super) struct Meshes<'a> {
    names: &'a Names,
    format: &'static Format,
    options: WriteOptions,
    /// The files of the moving surfaces, where they are asked for.
    surface: Option<SurfaceFiles>,
    /// The file that takes all of them, where the format has that.
    sequence: Option<Shared>,
    /// Whether all meshes so far were in that file before.
    pub is_resuming: bool,
    /// Where each mesh written or verified ends in that file.
    pub ends: Vec<u64>,
    /// What the format could not hold.
    pub notes: Notes,
}

impl<'a> Meshes<'a> {
    /// Nothing is under its name before the first mesh is kept.
    pub fn new(
        names: &'a Names,
        format: &'static Format,
        options: WriteOptions,
        surface: Option<SurfaceFiles>,
        begin: Begin,
    ) -> Result<Self> {
        let first = names.path(&names.mesh(names.steps().start));
        let create = |create: azimesh_io::formats::CreateSequence| {
            create(&first, &options, begin, names.commit.sync)
        };
        let sequence = format.sequence.filter(|_| names.is_in_one());
        let sequence = sequence.map(create).transpose()?;
        Ok(Self {
            names,
            format,
            options,
            surface,
            is_resuming: sequence.as_ref().is_some_and(|file| file.is_resuming()),
            sequence: sequence.map(|file| Arc::new(Mutex::new(file))),
            ends: Vec::new(),
            notes: Notes::default(),
        })
    }

    /// Writes the mesh of a step and its surfaces; gives the hash of its file, or of what it added to that of all
    /// steps, and what makes it one of the sequence. A mesh is kept before the next is appended.
    pub fn write(&mut self, mesh: &MeshView, step: &Step) -> Result<(blake3::Hash, Staged)> {
        let surface = match &self.surface {
            Some(surface) => Some(surface.stage(mesh, self.names, step.index())?),
            None => None,
        };
        let (hash, written) = self.write_mesh(mesh, step)?;
        let written = match surface {
            Some(surface) => Staged::all(vec![surface, written]),
            None => written,
        };
        Ok((hash, written))
    }

    fn write_mesh(&mut self, mesh: &MeshView, step: &Step) -> Result<(blake3::Hash, Staged)> {
        if let Some(case) = self.names.in_case(step.index()) {
            let mut out = OutputSet::new(case.folder, self.names.commit).hashed();
            (case.format).write_step(mesh, case.file, &mut out, &self.options)?;
            let written = out.finish();
            return Ok((hash_in_case(&written), written.files));
        }
        let path = self.names.path(&self.names.mesh(step.index()));
        if let Some(sequence) = &self.sequence {
            let mut file = lock(sequence);
            let appended = file.append(step.time(), mesh);
            let hash = appended.map_err(|error| error.file(&path))?;
            self.ends.push(file.n_bytes());
            self.is_resuming = file.is_resuming();
            let sequence = Arc::clone(sequence);
            let commit = move || lock(&sequence).commit().map_err(|error| error.file(&path));
            return Ok((hash, Staged::new(move || commit().map(|()| None))));
        }
        let mut out = OutputSet::new(&path, self.names.commit).hashed();
        let notes = self.format.write(mesh, &mut out, &self.options)?;
        self.notes.extend(notes);
        let written = out.finish();
        Ok((written.hash.expect("it was asked for"), written.files))
    }

    /// Makes the file of all steps end with the mesh written or verified last; tells whether it did
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

/// The hash that the row of a step would have; the mesh is written to nowhere.
pub(super) fn hash_of(
    mesh: &MeshView,
    names: &Names,
    step: usize,
    format: &Format,
    options: &WriteOptions,
) -> Result<blake3::Hash> {
    if let Some(case) = names.in_case(step) {
        let mut out = OutputSet::nowhere(case.folder).hashed();
        (case.format).write_step(mesh, case.file, &mut out, options)?;
        return Ok(hash_in_case(&out.finish()));
    }
    let mut out = OutputSet::nowhere(Path::new("mesh")).hashed();
    format.write(mesh, &mut out, options)?;
    Ok(out.finish().hash.expect("it was asked for"))
}

/// The hash of a step in a case: of its points or, where it has several files, of all of them.
fn hash_in_case(written: &Output) -> blake3::Hash {
    let mut hashes = written.of_folder.values();
    match (hashes.next(), hashes.next()) {
        (Some(one), None) => *one,
        _ => written.hash.expect("it was asked for"),
    }
}

//! The meshes of a run: a file for each step, or one file for all.

use super::output::Names;
use crate::error::Result;
use crate::formats::{Begin, Format, SequenceFile, WriteOptions, write_companions, write_whole};
use crate::mesh::Mesh;
use crate::motion::Step;
use std::io::Write;

/// Where the meshes go.
pub(super) struct Meshes<'a> {
    names: &'a Names,
    format: &'static dyn Format,
    options: WriteOptions,
    /// The file that takes all of them, where the format has that.
    sequence: Option<Box<dyn SequenceFile>>,
    /// Where each mesh written or retraced ends in that file.
    pub ends: Vec<u64>,
    /// What the format could not hold, a sentence each.
    pub notes: Vec<String>,
}

impl<'a> Meshes<'a> {
    /// Nothing is under its name before the first mesh is written.
    pub fn new(
        names: &'a Names,
        format: &'static dyn Format,
        options: WriteOptions,
        begin: Begin,
    ) -> Result<Self> {
        let first = names.mesh(names.steps().start);
        let sequence = format
            .sequence()
            .map(|create| create(&names.path(&first), &options, begin))
            .transpose()?;
        Ok(Self {
            names,
            format,
            options,
            sequence,
            ends: Vec::new(),
            notes: Vec::new(),
        })
    }

    /// Writes the mesh of a step; gives the hash of its file, or of what it added to that of all
    /// steps.
    pub fn write(&mut self, mesh: &Mesh, step: &Step) -> Result<blake3::Hash> {
        let path = self.names.path(&self.names.mesh(step.index));
        if let Some(sequence) = &mut self.sequence {
            let appended = sequence.append(step.time(), mesh);
            let hash = appended.map_err(|error| error.file(&path))?;
            self.ends.push(sequence.n_bytes());
            return Ok(hash);
        }
        let (hash, notes) = write_whole(&path, |out| {
            let mut hashing = Hashing {
                out,
                hasher: blake3::Hasher::new(),
            };
            let notes = self.format.write(mesh, &mut hashing, &self.options)?;
            Ok((hashing.hasher.finalize(), notes))
        })?;
        for note in notes {
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
        write_companions(mesh, &path, self.format)?;
        Ok(hash)
    }

    /// Makes the file of all steps end with the mesh written or retraced last; tells whether it did
    /// not.
    pub fn end(&mut self) -> Result<bool> {
        let path = self.names.path(&self.names.mesh(self.names.steps().start));
        let ended = self.sequence.as_mut().map(|sequence| sequence.end());
        let ended = ended.unwrap_or(Ok(false));
        ended.map_err(|error| error.file(&path))
    }

    /// Whether all meshes so far were in the file of all steps before.
    pub fn is_retracing(&self) -> bool {
        let sequence = self.sequence.as_ref();
        sequence.is_some_and(|sequence| sequence.is_retracing())
    }
}

/// The hash of the file that a mesh would have alone; it is written to nowhere.
pub(super) fn hash_of(
    mesh: &Mesh,
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

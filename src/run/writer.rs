//! Steps on their way to the disk: a mesh, with its surfaces, then its row; no signal ends the program between the two.
//! Waiting for the disk is done on a separate thread, during the work on the next step.

use super::names::Names;
use super::outputs::foreign_file;
use super::surface::SurfaceFiles;
use super::table::Table;
use crate::record::{Row, Rows};
use azimesh_core::error::{Error, Result};
use azimesh_core::progress::Stop;
use azimesh_deform::motion::Step;
use azimesh_io::formats::{
    Begin, CaseFormat, Format, Notes, OutputSet, SequenceFile, Staged, WriteOptions,
};
use azimesh_io::mesh::MeshView;
use std::collections::BTreeSet;
use std::panic::resume_unwind;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::Instant;

/// Writes the steps of a run, in their order.
pub(super) struct Writer<'a> {
    names: &'a Names,
    format: &'static Format,
    options: WriteOptions,
    /// The files of the moving surfaces, if the schedule asks for them.
    surface: Option<SurfaceFiles>,
    /// The file that holds all meshes, if the format has one; shared with the thread that commits them.
    sequence: Option<Arc<Mutex<Box<dyn SequenceFile>>>>,
    /// True if all meshes so far were already in that file.
    pub is_resuming: bool,
    /// The end of each mesh written or verified in that file.
    pub ends: Vec<u64>,
    /// Notes on data of the meshes so far that the format could not hold.
    pub notes: Notes,
    table: Arc<Mutex<Table>>,
    /// Steps that the table of the earlier run has.
    listed: BTreeSet<usize>,
    stop: &'a Arc<Stop>,
    /// The written step that waits for the disk.
    under_way: Option<JoinHandle<Result<()>>>,
    /// Seconds of writing.
    pub seconds: f64,
}

impl<'a> Writer<'a> {
    /// Starts with the rows of an earlier run. No file has the name of a mesh before the first mesh is kept.
    pub fn start(
        names: &'a Names,
        format: &'static Format,
        options: WriteOptions,
        surface: Option<SurfaceFiles>,
        (kept, listed): (Rows, BTreeSet<usize>),
        stop: &'a Arc<Stop>,
        begin: Begin,
    ) -> Result<Self> {
        let table = Table::start(names.table(), kept, names.commit)?;
        let first = names.path(&names.mesh(names.steps().start));
        let create = format.sequence.filter(|_| names.is_in_one);
        let sequence = create.map(|create| create(&first, &options, begin, names.commit.sync));
        let sequence = sequence.transpose()?;
        Ok(Self {
            names,
            format,
            options,
            surface,
            is_resuming: sequence.as_ref().is_some_and(|file| file.is_resuming()),
            sequence: sequence.map(|file| Arc::new(Mutex::new(file))),
            ends: Vec::new(),
            notes: Notes::default(),
            table: Arc::new(Mutex::new(table)),
            listed,
            stop,
            under_way: None,
            seconds: 0.0,
        })
    }

    /// Writes a mesh, then its row, which lacks the file and its hash; `seconds` is the time spent before. Both are on the
    /// disk when the next step is written, or after [`Writer::settle`].
    pub fn write(
        &mut self,
        mesh: &MeshView,
        step: &Step,
        mut row: Row,
        seconds: f64,
    ) -> Result<()> {
        let held = self.stop.hold();
        let clock = Instant::now();
        if self.names.is_in_one {
            self.settle()?;
        }
        let (hash, written) = self.write_mesh(mesh, step)?;
        self.check_own(mesh, step.index(), hash)?;
        self.settle()?;
        self.seconds += clock.elapsed().as_secs_f64();
        row.file = self.names.mesh(step.index());
        row.blake3 = hash.to_string();
        row.seconds = ((seconds + clock.elapsed().as_secs_f64()) * 1e3).round() / 1e3;
        let table = Arc::clone(&self.table);
        let finish = move || {
            let _held = held;
            written.keep()?;
            lock(&table).add(row)
        };
        if !self.names.commit.sync {
            return finish();
        }
        let thread = Builder::new().name("disk".to_owned()).spawn(finish);
        let refused = |error| Error::system(format!("cannot start a thread: {error}"));
        self.under_way = Some(thread.map_err(refused)?);
        Ok(())
    }

    /// Refuses to replace a file of a step without a row, unless it has this hash: a killed run has left it.
    fn check_own(&self, mesh: &MeshView, step: usize, hash: blake3::Hash) -> Result<()> {
        let names = self.names;
        if self.listed.contains(&step) {
            return Ok(());
        }
        let path = names.path(&names.mesh(step));
        let has_own_file = self.sequence.is_none() && !names.is_shared(step);
        let is_own = || names.has_hash(&path, &hash.to_string()).unwrap_or(false);
        if has_own_file && path.exists() && !is_own() {
            return Err(foreign_file(&path));
        }
        let mut surface = self.surface.iter();
        surface.try_for_each(|surface| surface.check_own(mesh, names, step))
    }

    /// Waits until every written step is on the disk and has its row.
    pub fn settle(&mut self) -> Result<()> {
        let Some(thread) = self.under_way.take() else {
            return Ok(());
        };
        let clock = Instant::now();
        let done = thread.join().unwrap_or_else(|panic| resume_unwind(panic));
        self.seconds += clock.elapsed().as_secs_f64();
        done
    }

    /// Verifies a mesh in the file of all steps from an earlier run: returns whether it has the hash of its row.
    pub fn verify(&mut self, mesh: &MeshView, step: &Step) -> Result<bool> {
        let _held = self.stop.hold();
        self.settle()?;
        let clock = Instant::now();
        let (hash, written) = self.write_mesh(mesh, step)?;
        written.keep()?;
        self.seconds += clock.elapsed().as_secs_f64();
        let table = lock(&self.table);
        let row = table.rows().get(&step.index());
        Ok(row.is_some_and(|row| row.blake3 == hash.to_string()))
    }

    /// Writes the mesh of a step and its surfaces. Returns the hash of its file, or of the data appended to the file of all
    /// steps, and the pending commit. A mesh is kept before the next is appended.
    fn write_mesh(&mut self, mesh: &MeshView, step: &Step) -> Result<(blake3::Hash, Staged)> {
        let (names, at) = (self.names, step.index());
        let surface = self.surface.as_ref();
        let surface = surface.map(|surface| surface.stage(mesh, names, at));
        let surface = surface.transpose()?;
        let (hash, written) = if let Some(sequence) = &self.sequence {
            let path = names.path(&names.mesh(at));
            let mut file = lock(sequence);
            let appended = file.append(step.time(), mesh);
            let hash = appended.map_err(|error| error.file(&path))?;
            self.ends.push(file.n_bytes());
            self.is_resuming = file.is_resuming();
            let sequence = Arc::clone(sequence);
            let commit = move || lock(&sequence).commit().map_err(|error| error.file(&path));
            (hash, Staged::act(commit))
        } else {
            let (hash, notes, written) =
                write_alone(mesh, names, at, self.format, &self.options, |path| {
                    OutputSet::new(path, names.commit)
                })?;
            self.notes.extend(notes);
            (hash, written)
        };
        Ok(match surface {
            Some(surface) => (hash, Staged::all(vec![surface, written])),
            None => (hash, written),
        })
    }

    /// Makes the file of all steps end with the last step; returns whether it did not.
    pub fn end(&mut self) -> Result<bool> {
        let _held = self.stop.hold();
        self.settle()?;
        let path = self.names.path(&self.names.mesh(self.names.steps().start));
        let ended = self.sequence.as_ref().map(|sequence| lock(sequence).end());
        ended
            .unwrap_or(Ok(false))
            .map_err(|error| error.file(&path))
    }

    /// Returns the rows of all finished steps.
    pub fn rows(&self) -> Rows {
        lock(&self.table).rows().clone()
    }
}

impl Drop for Writer<'_> {
    /// Waits for the last step. A run that ends with an error has reported it.
    fn drop(&mut self) {
        let _ = self.settle();
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes the mesh of a step that has its own files, to the set of files that `set` creates for their path.
fn write_alone(
    mesh: &MeshView,
    names: &Names,
    step: usize,
    format: &Format,
    options: &WriteOptions,
    set: impl Fn(&Path) -> OutputSet<'_>,
) -> Result<(blake3::Hash, Notes, Staged)> {
    let Some((case, file)) = names.in_case(step) else {
        let path = names.path(&names.mesh(step));
        let mut out = set(&path).hashed();
        let notes = format.write(mesh, &mut out, options)?;
        let written = out.finish();
        let hash = written.hash.expect("it was asked for");
        return Ok((hash, notes, written.files));
    };
    let mut out = set(case).hashed();
    CaseFormat.write_step(mesh, file, &mut out, options)?;
    let written = out.finish();
    // The hash of its points or, if it has several files, of all of them.
    let mut hashes = written.of_folder.values();
    let hash = match (hashes.next(), hashes.next()) {
        (Some(one), None) => *one,
        _ => written.hash.expect("it was asked for"),
    };
    Ok((hash, Notes::default(), written.files))
}

/// Returns the hash that the row of a step would have, by writing the mesh to a null sink.
pub(super) fn hash_of(
    mesh: &MeshView,
    names: &Names,
    step: usize,
    format: &Format,
    options: &WriteOptions,
) -> Result<blake3::Hash> {
    let (hash, ..) = write_alone(mesh, names, step, format, options, |path| {
        OutputSet::nowhere(path)
    })?;
    Ok(hash)
}

//! Steps on their way to the disk: a mesh, then its row; no signal ends the program between the
//! two. What waits for the disk does so on a thread of its own, beside the work on the next step.

use super::meshes::Meshes;
use super::names::Names;
use super::record::Clock;
use super::surface::SurfaceFiles;
use super::table::Table;
use crate::record::{Row, Rows};
use azimesh_core::error::{Error, Result};
use azimesh_core::progress::Stop;
use azimesh_deform::motion::Step;
use azimesh_io::formats::{Begin, Format, Notes, WriteOptions};
use azimesh_io::mesh::MeshView;
use std::panic::resume_unwind;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};

/// Writes the steps of a run, in their order.
pub(super) struct Writer<'a> {
    names: &'a Names,
    meshes: Meshes<'a>,
    table: Arc<Mutex<Table>>,
    stop: &'a Arc<Stop>,
    /// The step that is written and waits for the disk.
    under_way: Option<JoinHandle<Result<()>>>,
    /// Seconds of writing.
    pub seconds: f64,
}

impl<'a> Writer<'a> {
    /// Starts with the rows of an earlier run.
    pub fn start(
        names: &'a Names,
        format: &'static Format,
        options: WriteOptions,
        surface: Option<SurfaceFiles>,
        kept: Rows,
        stop: &'a Arc<Stop>,
        begin: Begin,
    ) -> Result<Self> {
        let table = Table::start(names.table(), kept, names.commit)?;
        Ok(Self {
            names,
            meshes: Meshes::new(names, format, options, surface, begin)?,
            table: Arc::new(Mutex::new(table)),
            stop,
            under_way: None,
            seconds: 0.0,
        })
    }

    /// Writes a mesh, then its row, which lacks the file and its hash; `seconds` is what it took before. Both
    /// are on the disk when the next step is written, or after [`Writer::settle`].
    pub fn write(
        &mut self,
        mesh: &MeshView,
        step: &Step,
        mut row: Row,
        seconds: f64,
    ) -> Result<()> {
        let held = self.stop.hold();
        let clock = Clock::start();
        if self.names.is_in_one() {
            self.settle()?;
        }
        let (hash, written) = self.meshes.write(mesh, step)?;
        self.settle()?;
        self.seconds += clock.seconds();
        row.file = self.names.mesh(step.index());
        row.blake3 = hash.to_string();
        row.seconds = ((seconds + clock.seconds()) * 1e3).round() / 1e3;
        let table = Arc::clone(&self.table);
        self.finish(move || {
            let _held = held;
            written.keep()?;
            lock(&table).add(row)
        })
    }

    /// Does what waits for the disk on a thread of its own, where anything is waited for.
    fn finish(&mut self, work: impl FnOnce() -> Result<()> + Send + 'static) -> Result<()> {
        if !self.names.commit.sync {
            return work();
        }
        let thread = Builder::new().name("disk".to_owned()).spawn(work);
        let refused = |error| Error::system(format!("cannot start a thread: {error}"));
        self.under_way = Some(thread.map_err(refused)?);
        Ok(())
    }

    /// Waits until every step that was written is on the disk and has its row.
    pub fn settle(&mut self) -> Result<()> {
        let Some(thread) = self.under_way.take() else {
            return Ok(());
        };
        let clock = Clock::start();
        let done = thread.join().unwrap_or_else(|panic| resume_unwind(panic));
        self.seconds += clock.seconds();
        done
    }

    /// Verifies a mesh that an earlier run put into the file of all steps: tells whether it has the hash of its
    /// row.
    pub fn verify(&mut self, mesh: &MeshView, step: &Step) -> Result<bool> {
        let _held = self.stop.hold();
        self.settle()?;
        let clock = Clock::start();
        let (hash, written) = self.meshes.write(mesh, step)?;
        written.keep()?;
        self.seconds += clock.seconds();
        let table = lock(&self.table);
        let row = table.rows().get(&step.index());
        Ok(row.is_some_and(|row| row.blake3 == hash.to_string()))
    }

    /// After the last step: makes the file of all steps end with it; tells whether it did not.
    pub fn end(&mut self) -> Result<bool> {
        let _held = self.stop.hold();
        self.settle()?;
        self.meshes.end()
    }

    /// Where each mesh so far ends in the file of all steps.
    pub fn ends(&self) -> &[u64] {
        &self.meshes.ends
    }

    /// What the format could not hold of the meshes so far.
    pub fn notes(&self) -> &Notes {
        &self.meshes.notes
    }

    /// Whether all meshes so far were in the file of all steps before.
    pub fn is_resuming(&self) -> bool {
        self.meshes.is_resuming
    }

    /// The rows of all steps that are finished.
    pub fn rows(&self) -> Rows {
        lock(&self.table).rows().clone()
    }
}

impl Drop for Writer<'_> {
    /// A run that ends with an error has told it; the step before is waited for all the same.
    fn drop(&mut self) {
        let _ = self.settle();
    }
}

fn lock(table: &Mutex<Table>) -> MutexGuard<'_, Table> {
    table.lock().unwrap_or_else(PoisonError::into_inner)
}

//! Steps on their way to the disk: a mesh, then its row; nothing asks the program to end between the
//! two.

use super::meshes::Meshes;
use super::output::Names;
use super::record::Clock;
use super::stop::Stop;
use super::table::{Row, Rows, Table};
use crate::error::Result;
use crate::formats::{Begin, Format, WriteOptions};
use crate::mesh::Mesh;
use crate::motion::Step;

/// Writes the steps of a run, in their order.
pub(super) struct Writer<'a> {
    names: &'a Names,
    meshes: Meshes<'a>,
    table: Table,
    stop: &'a Stop,
    /// Seconds of writing.
    pub seconds: f64,
}

impl<'a> Writer<'a> {
    /// Starts with the rows of an earlier run.
    pub fn start(
        names: &'a Names,
        format: &'static dyn Format,
        options: WriteOptions,
        kept: Rows,
        stop: &'a Stop,
        begin: Begin,
    ) -> Result<Self> {
        Ok(Self {
            names,
            meshes: Meshes::new(names, format, options, begin)?,
            table: Table::start(names.table(), kept)?,
            stop,
            seconds: 0.0,
        })
    }

    /// Writes a mesh, then its row, which lacks what writing tells; `seconds` is what it took before.
    pub fn write(&mut self, mesh: &Mesh, step: &Step, mut row: Row, seconds: f64) -> Result<()> {
        let _held = self.stop.hold();
        let clock = Clock::start();
        let hash = self.meshes.write(mesh, step)?;
        self.seconds += clock.seconds();
        row.set("file", self.names.mesh(step.index));
        row.set("blake3", hash.to_string());
        row.set("seconds", format!("{:.3}", seconds + clock.seconds()));
        self.table.add(step.index, row)
    }

    /// Goes over a mesh that an earlier run put into the file of all steps; tells whether it is the one
    /// that the row speaks of.
    pub fn retrace(&mut self, mesh: &Mesh, step: &Step) -> Result<bool> {
        let _held = self.stop.hold();
        let clock = Clock::start();
        let hash = self.meshes.write(mesh, step)?;
        self.seconds += clock.seconds();
        let row = self.table.rows().get(&step.index);
        Ok(row.is_some_and(|row| row.text("blake3") == hash.to_string()))
    }

    /// After the last step: makes the file of all steps end with it; tells whether it did not.
    pub fn end(&mut self) -> Result<bool> {
        let _held = self.stop.hold();
        self.meshes.end()
    }

    /// Where each mesh so far ends in the file of all steps.
    pub fn ends(&self) -> &[u64] {
        &self.meshes.ends
    }

    /// What the format could not hold of the meshes so far.
    pub fn notes(&self) -> &[String] {
        &self.meshes.notes
    }

    /// Whether all meshes so far were in the file of all steps before.
    pub fn is_retracing(&self) -> bool {
        self.meshes.is_retracing()
    }

    /// The rows of all steps that are finished.
    pub fn into_rows(self) -> Rows {
        self.table.into_rows()
    }
}

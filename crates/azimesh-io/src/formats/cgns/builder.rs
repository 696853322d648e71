//! The mesh as far as it has been read, and a record of what is left out.

use super::super::Notes;
use super::arrays::Arrays;
use super::tags::Tags;
use crate::mesh::too_many;
use crate::mesh::{Cells, DataArray};
use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::diagnostic::formats::{NotKept, Read};
use azimesh_core::error::{Error, Result};
use std::collections::BTreeMap;

/// The mesh as far as it has been read.
#[derive(Default)]
pub(super) struct MeshBuilder {
    pub points: Vec<[f64; 3]>,
    pub cells: Cells,
    pub tags: Tags,
    pub point_arrays: Arrays,
    pub cell_arrays: Arrays,
    pub field_arrays: Vec<DataArray>,
    /// Elements of which only the corners are kept, by type.
    pub incomplete: BTreeMap<&'static str, usize>,
    /// Notes on damage in the file.
    pub remarks: Vec<Diagnostic>,
    /// Kinds of data that are left out, with their numbers.
    left: BTreeMap<String, usize>,
    /// Kinds of data that are left out, with their names.
    left_by_name: BTreeMap<String, Vec<String>>,
}

impl MeshBuilder {
    /// Counts data that a mesh cannot hold.
    pub fn leave(&mut self, what: &str, n: usize) {
        *self.left.entry(what.to_owned()).or_default() += n;
    }

    /// Notes the name of data that a mesh cannot hold.
    pub fn leave_named(&mut self, what: &str, name: &str) {
        let names = self.left_by_name.entry(what.to_owned()).or_default();
        names.push(name.to_owned());
    }

    /// Refuses more cells than can be indexed.
    pub fn check_room(&self, n: usize) -> Result<()> {
        match self.cells.len().checked_add(n) {
            Some(total) if total < u32::MAX as usize => Ok(()),
            _ => Err(Error::input(too_many("cells"))),
        }
    }

    /// Adds the notes on what is left out.
    pub fn say(&self, notes: &mut Notes) {
        notes.extend(self.remarks.iter().cloned());
        for (what, n) in &self.left {
            let (what, n) = (what.clone(), *n);
            notes.push(NotKept::Nodes { what, n });
        }
        for (what, names) in &self.left_by_name {
            let (what, names) = (what.clone(), names.clone());
            notes.push(NotKept::NamedNodes { what, names });
        }
        for (&element, &n) in &self.incomplete {
            notes.push(Read::OnlyCorners { element, n });
        }
    }
}

//! The notes that readers and writers collect: each once, in order.

use super::names::repeated;
use super::tokens::{first_fortran_real, n_comments};
use super::{Precision, WriteOptions};
use crate::mesh::{Group, MeshView};
use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::diagnostic::formats::{ArrayWritten, Condition, GroupWritten, Read, Written};
use std::collections::BTreeSet;

/// Notes of readers and writers, without duplicates: an iterator of [`Diagnostic`]s. See
/// [`Mesh::read_with`](crate::Mesh::read_with) and [`Mesh::write`](crate::Mesh::write).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Notes {
    list: Vec<Diagnostic>,
    /// Text of each note of the list.
    known: BTreeSet<String>,
    /// Texts that were read as Latin-1.
    latin1: BTreeSet<String>,
}

impl Notes {
    /// Adds notes of exponents of Fortran and of comments in a text that was read.
    pub(super) fn dialect(&mut self, bytes: &[u8]) {
        self.fortran(bytes);
        let (n, n_trailing) = n_comments(bytes);
        self.count(n, |n| Read::CommentLines { n });
        self.count(n_trailing, |n| Read::TrailingComments { n });
    }

    /// Adds a note of exponents of Fortran in a text that was read.
    pub(super) fn fortran(&mut self, bytes: &[u8]) {
        if let Some(line) = first_fortran_real(bytes) {
            self.push(Read::FortranExponents { line });
        }
    }

    /// Adds a note, once.
    pub fn push(&mut self, note: impl Into<Diagnostic>) {
        let note = note.into();
        if self.known.insert(format!("{note:?}")) {
            self.list.push(note);
        }
    }

    /// Adds a note of a number, unless that is zero.
    pub(super) fn count<T: Into<Diagnostic>>(&mut self, n: usize, note: impl FnOnce(usize) -> T) {
        self.extend((n > 0).then(|| note(n)));
    }

    /// Adds a note of a list, unless that is empty.
    pub(super) fn list<L, T: Into<Diagnostic>>(
        &mut self,
        list: Vec<L>,
        note: impl FnOnce(Vec<L>) -> T,
    ) {
        self.extend((!list.is_empty()).then(|| note(list)));
    }

    /// Notes the arrays that a format without arrays leaves out. It writes the field arrays in `kept` in another way.
    pub(super) fn arrays_left_out(&mut self, format: &'static str, mesh: &MeshView, kept: &[&str]) {
        let is_kept = |name: &String| kept.contains(&name.as_str());
        for (what, arrays) in [
            ("point", &mesh.point_arrays),
            ("cell", &mesh.cell_arrays),
            ("field", &mesh.field_arrays),
        ] {
            let mut names: Vec<String> = arrays.iter().map(|array| array.name.clone()).collect();
            names.retain(|name| what != "field" || !is_kept(name));
            self.list(names, |names| ArrayWritten::LeftOut {
                format,
                what,
                names,
            });
        }
    }

    /// Notes a format whose coordinates have 64 bits, if 32 are asked for.
    pub(super) fn in_64_bits(&mut self, format: &'static str, options: &WriteOptions) {
        if options.precision == Precision::F32 {
            self.push(Written::CoordinatesIn64 { format });
        }
    }

    /// Notes the types of boundary conditions, for a format that has none.
    pub(super) fn conditions_left_out(&mut self, format: &'static str, mesh: &MeshView) {
        let groups = mesh.groups.iter();
        let n = groups.filter(|group| group.condition.is_some()).count();
        self.count(n, |n| Condition::NotWritten { format, n });
    }

    /// Notes groups of one dimension and name, for a format that knows them by their names alone.
    pub(super) fn joined<'a>(&mut self, groups: impl IntoIterator<Item = &'a Group>) {
        for ((_, name), n) in repeated(groups) {
            let name = name.to_owned();
            self.push(GroupWritten::Joined { name, n });
        }
    }

    /// Notes a text that was read as Latin-1.
    pub(super) fn latin1(&mut self, text: &str) {
        self.latin1.insert(text.to_owned());
    }

    /// Adds the notes on the file as a whole.
    pub(super) fn close(&mut self) {
        let texts = std::mem::take(&mut self.latin1).into_iter().collect();
        self.list(texts, |texts| Read::Latin1 { texts });
    }

    /// The notes, in order.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// Number of notes.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Checks if there are no notes.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

#[cfg(test)]
impl Notes {
    pub(super) fn has(&self, note: impl Into<Diagnostic>) -> bool {
        self.list.contains(&note.into())
    }
}

#[cfg(test)]
impl<const N: usize> PartialEq<[Diagnostic; N]> for Notes {
    fn eq(&self, notes: &[Diagnostic; N]) -> bool {
        self.list == notes
    }
}

impl<T: Into<Diagnostic>> Extend<T> for Notes {
    fn extend<I: IntoIterator<Item = T>>(&mut self, notes: I) {
        notes.into_iter().for_each(|note| self.push(note));
    }
}

impl IntoIterator for Notes {
    type Item = Diagnostic;
    type IntoIter = std::vec::IntoIter<Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.into_iter()
    }
}

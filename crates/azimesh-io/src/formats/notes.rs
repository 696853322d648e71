//! The notes that readers and writers collect: each once, in order.

use super::dialect::{first_fortran_real, n_comments};
use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::diagnostic::formats::Read;
use std::collections::BTreeSet;

/// Notes of readers and writers, without duplicates: an iterator of [`Diagnostic`]s. See
/// [`Mesh::read_with`](crate::Mesh::read_with) and [`Mesh::write`](crate::Mesh::write).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Notes {
    list: Vec<Diagnostic>,
    /// Those of the list, as text that tells them apart.
    known: BTreeSet<String>,
    /// Texts that were read as Latin-1.
    latin1: BTreeSet<String>,
}

impl Notes {
    /// Adds notes of exponents of Fortran and of comments in a text that was read.
    pub(super) fn dialect(&mut self, bytes: &[u8]) {
        self.fortran(bytes);
        let (n, n_trailing) = n_comments(bytes);
        if n > 0 {
            self.push(Read::CommentLines { n });
        }
        if n_trailing > 0 {
            self.push(Read::TrailingComments { n: n_trailing });
        }
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

    /// Notes a text that was read as Latin-1.
    pub(super) fn latin1(&mut self, text: &str) {
        self.latin1.insert(text.to_owned());
    }

    /// Adds the notes on the file as a whole.
    pub(super) fn close(&mut self) {
        let texts: Vec<String> = std::mem::take(&mut self.latin1).into_iter().collect();
        if !texts.is_empty() {
            self.push(Read::Latin1 { texts });
        }
    }

    /// The notes, in order.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// Number of notes.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are no notes.
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

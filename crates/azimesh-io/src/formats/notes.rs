//! The notes that readers and writers collect: each once, in order.

use super::names::repeated;
use super::tokens::{first_fortran_real, n_comments};
use super::{Precision, WriteOptions};
use crate::mesh::{Group, MeshView};
use azimesh_core::error::counted;
use azimesh_core::{Note, note};
use std::collections::BTreeSet;

/// Notes of readers and writers, without duplicates: an iterator of [`Note`]s. See
/// [`Mesh::read_with`](crate::Mesh::read_with) and [`Mesh::write`](crate::Mesh::write).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Notes {
    list: Vec<Note>,
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
        self.count(n, |n| {
            note!(
                "comment_lines",
                "{} with # or !, which the format does not know as comments, {} passed over",
                if n == 1 {
                    "1 line that begins".into()
                } else {
                    format!("{n} lines that begin")
                },
                if n == 1 { "is" } else { "are" }
            )
        });
        self.count(n_trailing, |n| {
            note!(
                "trailing_comments",
                "what follows # or !, which the format does not know as comments, is passed over in {}",
                counted(n, "line")
            )
        });
    }

    /// Adds a note of exponents of Fortran in a text that was read.
    pub(super) fn fortran(&mut self, bytes: &[u8]) {
        if let Some(line) = first_fortran_real(bytes) {
            self.push(note!(
                "fortran_exponents",
                "numbers with exponents of Fortran, such as that in line {line}, are read: D stands for E"
            ));
        }
    }

    /// Adds a note, once.
    pub fn push(&mut self, note: Note) {
        if self.known.insert(note.to_string()) {
            self.list.push(note);
        }
    }

    /// Adds a note of a number, unless that is zero.
    pub(super) fn count(&mut self, n: usize, note: impl FnOnce(usize) -> Note) {
        self.extend((n > 0).then(|| note(n)));
    }

    /// Adds a note of a list, unless that is empty.
    pub(super) fn list<L>(&mut self, list: Vec<L>, note: impl FnOnce(Vec<L>) -> Note) {
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
            self.of_arrays(format, what, names);
        }
    }

    /// Notes arrays that a format has no place for.
    pub(super) fn of_arrays(&mut self, format: &str, what: &str, names: Vec<String>) {
        self.list(names, |names| {
            let quoted = quoted(&names).join(", ");
            note!(
                "arrays_left_out",
                "{format} holds no {what} arrays; left out: {quoted}"
            )
            .with("names", names)
        });
    }

    /// Notes things of a file that a mesh does not hold, if there are any.
    pub(super) fn not_kept(&mut self, what: &str, n: usize) {
        self.count(n, |n| note!("not_kept", "{what} are not kept ({n})"));
    }

    /// Notes named things of a file that a mesh does not hold, if there are any.
    pub(super) fn names_not_kept(&mut self, what: &str, names: Vec<String>) {
        self.list(names, |names| {
            note!("names_not_kept", "{what} are not kept: {}", listed(&names)).with("names", names)
        });
    }

    /// Notes cells of lower dimension that a format does not hold.
    pub(super) fn lower_cells(&mut self, n: usize) {
        self.count(n, |n| {
            note!(
                "lower_cells_left_out",
                "cells of lower dimension are left out ({n})"
            )
        });
    }

    /// Notes groups of lower dimension than boundary tags, for a format that does not hold them.
    pub(super) fn lower_groups(&mut self, format: &str, names: Vec<String>) {
        self.list(names, |names| {
            let quoted = quoted(&names).join(", ");
            note!(
                "lower_groups_left_out",
                "{format} holds boundary tags only; groups left out: {quoted}"
            )
            .with("names", names)
        });
    }

    /// Notes a format whose coordinates have 64 bits, if 32 are asked for.
    pub(super) fn in_64_bits(&mut self, format: &'static str, options: &WriteOptions) {
        if options.precision == Precision::F32 {
            self.push(match format {
                "UGRID" => note!(
                    "coordinates_in_64",
                    "coordinates are written in 64 bits; ugrid-b4 has 32"
                ),
                format => note!(
                    "coordinates_in_64",
                    "{format} holds coordinates in 64 bits only"
                ),
            });
        }
    }

    /// Notes the types of boundary conditions, for a format that has none.
    pub(super) fn conditions_left_out(&mut self, format: &'static str, mesh: &MeshView) {
        let groups = mesh.groups.iter();
        let n = groups.filter(|group| group.condition.is_some()).count();
        self.count(n, |n| {
            let text = match format {
                "SU2" => "types of boundary conditions are not written: SU2 has them in its configuration".into(),
                "MSH" => {
                    let tags = counted(n, "tag");
                    format!("MSH holds no types of boundary conditions; the types of {tags} are left out")
                }
                _ => "types of boundary conditions are not written".into(),
            };
            Note::new("conditions_left_out", text)
        });
    }

    /// Notes groups of one dimension and name, for a format that knows them by their names alone.
    pub(super) fn joined<'a>(&mut self, groups: impl IntoIterator<Item = &'a Group>) {
        for ((_, name), n) in repeated(groups) {
            self.push(note!(
                "tags_joined",
                "{n} tags are called \"{name}\" and become one"
            ));
        }
    }

    /// Notes a text that was read as Latin-1.
    pub(super) fn latin1(&mut self, text: &str) {
        self.latin1.insert(text.to_owned());
    }

    /// Adds the notes on the file as a whole.
    pub(super) fn close(&mut self) {
        let texts: Vec<String> = std::mem::take(&mut self.latin1).into_iter().collect();
        self.list(texts, |texts| {
            note!(
                "latin1",
                "texts that are not UTF-8 are read as Latin-1: {}",
                listed(&quoted(&texts))
            )
        });
    }

    /// The notes, in order.
    pub fn iter(&self) -> std::slice::Iter<'_, Note> {
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
    pub(super) fn has(&self, code: &str) -> bool {
        self.list.iter().any(|note| note.code == code)
    }

    /// Checks if there is a note of this sentence.
    pub(super) fn says(&self, text: &str) -> bool {
        self.list.iter().any(|note| note.text == text)
    }
}

/// Compares the codes of notes.
#[cfg(test)]
impl<const N: usize> PartialEq<[&str; N]> for Notes {
    fn eq(&self, codes: &[&str; N]) -> bool {
        self.list
            .iter()
            .map(|note| &*note.code)
            .eq(codes.iter().copied())
    }
}

/// Names that a sentence lists before it counts the others.
pub(super) const LISTED: usize = 5;

/// Names in quotes.
pub(super) fn quoted(names: &[String]) -> Vec<String> {
    names.iter().map(|name| format!("\"{name}\"")).collect()
}

/// The first names of a list, and the number of the others.
pub(super) fn listed(names: &[String]) -> String {
    let first = names[..names.len().min(LISTED)].join(", ");
    match names.len().saturating_sub(LISTED) {
        0 => first,
        n => format!("{first} and {n} more"),
    }
}

/// Notes an array that is left out, since it has more tuples than its items.
pub(super) fn too_long(what: &str, name: &str) -> Note {
    note!(
        "array_too_long",
        "the {what} array \"{name}\" is left out: it has more tuples than there are {what}s"
    )
    .with("name", name)
}

/// Notes an array that is left out, since it is another in some pieces.
pub(super) fn not_alike(what: &str, name: &str) -> Note {
    note!(
        "array_not_alike",
        "the {what} array \"{name}\" is left out: its type or number of components differs between pieces"
    )
    .with("name", name)
}

/// Notes blanking of nodes.
pub(super) fn blanking() -> Note {
    note!(
        "blanking",
        "blanking is not kept: cells at blanked nodes are read like others"
    )
}

/// Notes a companion file that cannot be used.
pub(super) fn conditions_unused(error: &str) -> Note {
    note!(
        "conditions_unused",
        "names and conditions of tags are not used: {error}"
    )
}

/// Notes data after the last cell of a UGRID file, bytes or numbers.
pub(super) fn rest(what: &str, n: usize) -> Note {
    note!(
        "rest_not_kept",
        "{what} after the last cell ({n}), such as volume numbers, are not kept"
    )
}

/// Notes coordinates that lose digits.
pub(super) fn coordinates_rounded() -> Note {
    note!("coordinates_rounded", "coordinates are rounded to 32 bits")
}

impl Extend<Note> for Notes {
    fn extend<I: IntoIterator<Item = Note>>(&mut self, notes: I) {
        notes.into_iter().for_each(|note| self.push(note));
    }
}

impl IntoIterator for Notes {
    type Item = Note;
    type IntoIter = std::vec::IntoIter<Note>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.into_iter()
    }
}

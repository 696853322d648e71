//! Scalars and records of an MSH file, as text or little-endian binary.

use super::super::names::{Rule, cut};
use super::super::records::{push_integer, push_real, write_all, write_records};
use super::super::{Encoding, WriteOptions};
use super::content::MshContent;
use crate::mesh::MeshView;
use azimesh_core::diagnostic::formats::GroupWritten;
use azimesh_core::error::Result;
use std::io::Write;

/// Most values in one record: the tags of an element and its nodes.
const MOST_VALUES: usize = 1024;

/// Writes scalars as text or little-endian binary.
pub(super) struct Sink<'a> {
    pub out: &'a mut dyn Write,
    pub text: bool,
}

impl<'a> Sink<'a> {
    pub fn new(out: &'a mut dyn Write, options: &WriteOptions) -> Self {
        Self {
            out,
            text: options.encoding == Encoding::Ascii,
        }
    }

    /// Writes a line or several, in text and binary files alike.
    pub fn line(&mut self, line: &str) -> Result<()> {
        write_all(self.out, line.as_bytes())?;
        write_all(self.out, b"\n")
    }

    /// Ends binary data; text ends its lines itself.
    pub fn end_binary(&mut self) -> Result<()> {
        if self.text {
            return Ok(());
        }
        write_all(self.out, b"\n")
    }

    /// Writes `$MeshFormat`.
    pub fn header(&mut self, version: &str) -> Result<()> {
        let is_binary = u8::from(!self.text);
        self.line(&format!("$MeshFormat\n{version} {is_binary} 8"))?;
        if !self.text {
            write_all(self.out, &1i32.to_le_bytes())?;
            self.end_binary()?;
        }
        self.line("$EndMeshFormat")
    }

    /// Writes `$PhysicalNames`. A nameless group goes without, unless it is empty: then the line is
    /// all that remains of it. Returns notes on names that had to change.
    pub fn physical_names(
        &mut self,
        mesh: &MeshView,
        plan: &MshContent,
    ) -> Result<Vec<GroupWritten>> {
        let mut notes = Vec::new();
        let mut lines = Vec::new();
        let names: [_; 4] = std::array::from_fn(|dimension| {
            let groups = mesh.groups.iter();
            let here = groups.filter(|group| usize::from(group.dimension) == dimension);
            NAME.by_name(here.map(|group| group.name.as_str()))
        });
        for (group, number) in mesh.groups.iter().zip(&plan.numbers) {
            if group.name == number.to_string() && !group.cells.is_empty() {
                continue;
            }
            if let Some(own) = group.number.filter(|own| own != number) {
                notes.push(GroupWritten::Renumbered {
                    name: group.name.clone(),
                    number: *number,
                    own,
                });
            }
            let name = &names[usize::from(group.dimension)][group.name.as_str()];
            notes.extend(NAME.note("group", &group.name, name));
            lines.push(format!("{} {number} \"{name}\"", group.dimension));
        }
        if !lines.is_empty() {
            let n = lines.len();
            let lines = lines.join("\n");
            self.line(&format!("$PhysicalNames\n{n}\n{lines}\n$EndPhysicalNames"))?;
        }
        Ok(notes)
    }

    /// Writes many records of integers as lines or in binary of `width` bytes each, 4 or 8: `record` puts
    /// record `i` into the slice of `n_values`.
    pub fn integers(
        &mut self,
        n: usize,
        n_values: usize,
        width: usize,
        record: impl Fn(usize, &mut [u64]) + Sync,
    ) -> Result<()> {
        let text = self.text;
        let record_bytes = n_values * width;
        write_records(self.out, n, &|range, buffer| {
            let mut values = [0; MOST_VALUES];
            let values = &mut values[..n_values];
            if text {
                for i in range {
                    record(i, values);
                    push_line(buffer, values);
                }
                return;
            }
            buffer.resize(range.len() * record_bytes, 0);
            for (i, bytes) in range.zip(buffer.chunks_exact_mut(record_bytes)) {
                record(i, values);
                match width {
                    8 => put(bytes, values, |x| x.to_le_bytes()),
                    _ => put(bytes, values, |x| (x as u32).to_le_bytes()),
                }
            }
        })
    }
}

fn put<const WIDTH: usize>(bytes: &mut [u8], values: &[u64], encode: impl Fn(u64) -> [u8; WIDTH]) {
    for (bytes, value) in bytes.chunks_exact_mut(WIDTH).zip(values) {
        bytes.copy_from_slice(&encode(*value));
    }
}

fn push_line(buffer: &mut Vec<u8>, values: &[u64]) {
    for (at, value) in values.iter().enumerate() {
        push_integer(buffer, *value);
        buffer.push(if at + 1 < values.len() { b' ' } else { b'\n' });
    }
}

/// Appends three coordinates as the end of a line.
pub(super) fn push_point(buffer: &mut Vec<u8>, point: &[f64; 3]) {
    for (i, x) in point.iter().enumerate() {
        push_real(buffer, *x);
        buffer.push(if i < 2 { b' ' } else { b'\n' });
    }
}

/// Appends three coordinates in binary.
pub(super) fn push_point_binary(buffer: &mut Vec<u8>, point: &[f64; 3]) {
    for x in point {
        buffer.extend_from_slice(&x.to_le_bytes());
    }
}

/// Names of groups, without what would end them too early, and no longer than Gmsh reads.
pub(super) const NAME: Rule = Rule {
    longest: 127,
    fit: |name, longest| cut(&plain(name), longest),
    why: "names in MSH have at most 127 bytes, no quotes and no line ends",
};

/// Names of arrays.
pub(super) const ARRAY: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| plain(name),
    why: "names in MSH have no quotes and no line ends",
};

fn plain(name: &str) -> String {
    name.replace(char::is_control, " ").replace('"', "'")
}

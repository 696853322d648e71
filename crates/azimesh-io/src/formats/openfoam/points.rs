//! Lists of numbers as OpenFOAM's files have them: binary in the machine's own order of bytes, or text. Owns the header
//! of a file.

use crate::formats::records::{push_integer, push_real, write_all, write_records};
use crate::formats::{Encoding, WriteOptions};
use azimesh_core::error::Result;
use std::io::Write;

/// What the header of a file says.
pub(super) struct Header<'a> {
    /// Class of what is in it, such as `vectorField`.
    pub class: &'a str,
    /// Folder in the case.
    pub location: &'a str,
    /// Name of the file.
    pub object: &'a str,
    /// A remark on its content.
    pub note: Option<String>,
}

impl Header<'_> {
    /// The header of a file with its numbers in this form.
    pub fn text(&self, is_binary: bool) -> String {
        let Self {
            class,
            location,
            object,
            ..
        } = self;
        let (format, arch) = match is_binary {
            true => ("binary", format!("    arch        \"{}\";\n", arch())),
            false => ("ascii", String::new()),
        };
        let note = self.note.as_ref().map_or(String::new(), |note| {
            format!("    note        \"{note}\";\n")
        });
        format!(
            "FoamFile\n{{\n    version     2.0;\n    format      {format};\n{arch}    class       {class};\n{note}    \
             location    \"{location}\";\n    object      {object};\n}}\n\n"
        )
    }
}

/// Order of bytes and sizes of numbers.
fn arch() -> &'static str {
    match cfg!(target_endian = "little") {
        true => "LSB;label=32;scalar=64",
        false => "MSB;label=32;scalar=64",
    }
}

/// Whether numbers are written in binary.
pub(super) fn is_binary(options: &WriteOptions) -> bool {
    options.encoding != Encoding::Ascii
}

/// Writes a list of vectors: its length, and the numbers in parentheses.
pub(super) fn vectors(out: &mut dyn Write, vectors: &[[f64; 3]], is_binary: bool) -> Result<()> {
    list(out, vectors.len(), is_binary, &mut |out| match is_binary {
        true => write_all(out, bytemuck::cast_slice(vectors)),
        false => write_records(out, vectors.len(), &|range, buffer| {
            for vector in &vectors[range] {
                buffer.push(b'(');
                for (i, x) in vector.iter().enumerate() {
                    if i > 0 {
                        buffer.push(b' ');
                    }
                    push_number(buffer, *x);
                }
                buffer.extend_from_slice(b")\n");
            }
        }),
    })
}

/// Writes a list of labels.
pub(super) fn labels(out: &mut dyn Write, labels: &[u32], is_binary: bool) -> Result<()> {
    list(out, labels.len(), is_binary, &mut |out| match is_binary {
        true => write_all(out, bytemuck::cast_slice(labels)),
        false => write_records(out, labels.len(), &|range, buffer| {
            for label in &labels[range] {
                push_integer(buffer, u64::from(*label));
                buffer.push(b'\n');
            }
        }),
    })
}

/// Writes a list of `bool`.
pub(super) fn flags(out: &mut dyn Write, flags: &[bool], is_binary: bool) -> Result<()> {
    list(out, flags.len(), is_binary, &mut |out| {
        let byte = |flag: &bool| [b'0' * u8::from(!is_binary) + u8::from(*flag), b'\n'];
        let n = if is_binary { 1 } else { 2 };
        let bytes: Vec<u8> = flags
            .iter()
            .flat_map(|flag| byte(flag).into_iter().take(n))
            .collect();
        write_all(out, &bytes)
    })
}

/// Writes a list as text of which `push` appends the entry of an index.
pub(super) fn entries(
    out: &mut dyn Write,
    n: usize,
    push: &(dyn Fn(usize, &mut Vec<u8>) + Sync),
) -> Result<()> {
    list(out, n, false, &mut |out| {
        write_records(out, n, &|range, buffer| range.for_each(|i| push(i, buffer)))
    })
}

/// A list of length `n`, of which `inside` writes what stands in its parentheses.
fn list(
    out: &mut dyn Write,
    n: usize,
    is_binary: bool,
    inside: &mut dyn FnMut(&mut dyn Write) -> Result<()>,
) -> Result<()> {
    // An empty binary list has no parentheses.
    if is_binary && n == 0 {
        return write_all(out, b"0\n");
    }
    write_all(
        out,
        format!("{n}\n({}", if is_binary { "" } else { "\n" }).as_bytes(),
    )?;
    inside(out)?;
    write_all(out, b")\n")
}

/// A number as the shortest text that reads back to the same bits; whole ones without a point.
fn push_number(buffer: &mut Vec<u8>, value: f64) {
    let from = buffer.len();
    push_real(buffer, value);
    if buffer[from..].ends_with(b".0") {
        buffer.truncate(buffer.len() - 2);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(write: impl Fn(&mut dyn Write) -> Result<()>) -> Vec<u8> {
        let mut out = Vec::new();
        write(&mut out).expect("a vector takes all");
        out
    }

    #[test]
    fn lists_are_text_or_binary() {
        let points = [[0.0, -1.5, 1e-300], [0.1, 2.0, 3.0]];
        assert_eq!(
            text(|out| vectors(out, &points, false)),
            b"2\n(\n(0 -1.5 1e-300)\n(0.1 2 3)\n)\n"
        );
        let mut expected = b"2\n(".to_vec();
        expected.extend(points.as_flattened().iter().flat_map(|x| x.to_ne_bytes()));
        expected.extend(b")\n");
        assert_eq!(text(|out| vectors(out, &points, true)), expected);
        assert_eq!(text(|out| labels(out, &[], true)), b"0\n");
        assert_eq!(text(|out| labels(out, &[], false)), b"0\n(\n)\n");
        assert_eq!(
            text(|out| labels(out, &[7, 12], false)),
            b"2\n(\n7\n12\n)\n"
        );
    }
}

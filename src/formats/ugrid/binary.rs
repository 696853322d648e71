//! Reading UGRID from bytes: bulk conversions on all threads.

use super::Ugrid;
use super::fortran;
use super::layout::{Binary, Content, Counts, KINDS, N_FACE_KINDS, n_nodes};
use crate::diagnostic::formats::{NotKept, Read};
use crate::error::{Error, Result, option};
use crate::formats::Notes;
use crate::mesh::first_where;
use crate::parallel::for_blocks;
use std::borrow::Cow;

/// Numbers that one task converts at a time.
const CHUNK: usize = 1 << 16;

/// Reads the numbers of a binary file.
pub(super) fn read(bytes: &[u8], binary: &Binary, flavour: &Ugrid) -> Result<Content> {
    let wrong = |what: String| Error::input(what + &hint(bytes, flavour)).byte(0);
    let mut notes = Notes::default();
    let (header, body, start) = match binary.has_records {
        false => {
            let body = bytes.get(binary.header()..).unwrap_or(&[]);
            (bytes, Cow::Borrowed(body), binary.header())
        }
        true => match (records(bytes, binary), fortran::unmarked(bytes, binary)) {
            (Ok(records), _) => records,
            (Err(_), Some((header, body))) => {
                notes.push(Read::WrongRecordMarks);
                let start = bytes.len() - fortran::MARK - body.len();
                (header, Cow::Borrowed(body), start)
            }
            (Err(error), None) => return Err(with_hint(error, bytes, flavour)),
        },
    };
    let counts = binary.counts(header).ok_or_else(|| {
        let n = binary.header();
        wrong(format!(
            "the file has {} bytes; the seven counts at its start alone need {n}",
            bytes.len()
        ))
    })?;
    let counts = counts.map_err(wrong)?;
    let needed = binary.body(&counts);
    if (body.len() as u128) < needed {
        return Err(wrong(format!(
            "the counts at the start need {needed} bytes of coordinates and cells, the file has {}",
            body.len()
        )));
    }
    let mut rest = Section { body: &body, start };
    let points = points(rest.take(3 * counts.n_nodes * binary.real), binary);
    let [n_face_entries, n_entries] = counts.n_entries();
    let mut connectivity = vec![0u32; n_entries];
    let (faces, solid) = connectivity.split_at_mut(n_face_entries);
    read_nodes(&mut rest, 0..N_FACE_KINDS, &counts, binary, faces)?;
    let face_numbers = face_numbers(&mut rest, &counts, binary)?;
    read_nodes(&mut rest, N_FACE_KINDS..KINDS.len(), &counts, binary, solid)?;
    if !rest.body.is_empty() {
        notes.push(NotKept::Rest {
            n: rest.body.len(),
            what: "bytes",
        });
    }
    Ok(Content {
        counts,
        points,
        connectivity,
        face_numbers,
        notes,
    })
}

/// Counts and data between the marks of records, and where the data start.
type Records<'a> = (&'a [u8], Cow<'a, [u8]>, usize);

fn records<'a>(bytes: &'a [u8], binary: &Binary) -> Result<Records<'a>> {
    let header = fortran::header(bytes, binary).ok_or_else(|| {
        Error::input("the file does not start with a Fortran record of seven counts").byte(0)
    })?;
    let (body, start) = fortran::data(bytes, fortran::header_bytes(binary) as usize, binary)?;
    Ok((header, body, start))
}

/// The bytes that are still to be read, and their offset in the file.
struct Section<'a> {
    body: &'a [u8],
    start: usize,
}

impl<'a> Section<'a> {
    /// The next `n` bytes; the whole length has been checked.
    fn take(&mut self, n: usize) -> &'a [u8] {
        let (taken, rest) = self.body.split_at(n);
        self.body = rest;
        self.start += n;
        taken
    }
}

/// A hint at what the file may be instead.
fn hint(bytes: &[u8], flavour: &Ugrid) -> String {
    match Ugrid::that_fits(bytes) {
        Some(name) if name != flavour.name => {
            let format = option("format");
            format!(" (read as {}; it would fit {format} {name})", flavour.name)
        }
        _ => format!(" (read as {})", flavour.name),
    }
}

fn with_hint(mut error: Error, bytes: &[u8], flavour: &Ugrid) -> Error {
    error.message += &hint(bytes, flavour);
    error
}

/// Converts `N` bytes at a time.
fn convert<T: Send, const N: usize>(bytes: &[u8], out: &mut [T], f: impl Fn([u8; N]) -> T + Sync) {
    for_blocks(out, CHUNK, &|first, out| {
        let bytes = bytes[first * N..].chunks_exact(N);
        for (out, bytes) in out.iter_mut().zip(bytes) {
            *out = f(bytes.try_into().expect("chunks of N bytes"));
        }
    });
}

fn points(bytes: &[u8], binary: &Binary) -> Vec<[f64; 3]> {
    let mut points = vec![[0.0; 3]; bytes.len() / binary.real / 3];
    let out = points.as_flattened_mut();
    match (binary.is_big_endian, binary.real) {
        (true, 8) => convert(bytes, out, f64::from_be_bytes),
        (false, 8) => convert(bytes, out, f64::from_le_bytes),
        (true, _) => convert(bytes, out, |x| f64::from(f32::from_be_bytes(x))),
        (false, _) => convert(bytes, out, |x| f64::from(f32::from_le_bytes(x))),
    }
    points
}

/// Node indices of some kinds, counted from 0; each is one of the mesh.
fn read_nodes(
    section: &mut Section,
    kinds: std::ops::Range<usize>,
    counts: &Counts,
    binary: &Binary,
    mut out: &mut [u32],
) -> Result<()> {
    // An index that is too large for 32 bits is too large for the mesh.
    let narrow = |node: u64| u32::try_from(node.wrapping_sub(1)).unwrap_or(u32::MAX);
    for i in kinds {
        let per_cell = n_nodes(KINDS[i]);
        let n = per_cell * counts.n_cells[i];
        let (own, rest) = std::mem::take(&mut out).split_at_mut(n);
        out = rest;
        let start = section.start;
        let bytes = section.take(n * binary.integer);
        match (binary.is_big_endian, binary.integer) {
            (true, 4) => convert(bytes, own, |x| u32::from_be_bytes(x).wrapping_sub(1)),
            (false, 4) => convert(bytes, own, |x| u32::from_le_bytes(x).wrapping_sub(1)),
            (true, _) => convert(bytes, own, |x| narrow(u64::from_be_bytes(x))),
            (false, _) => convert(bytes, own, |x| narrow(u64::from_le_bytes(x))),
        }
        let wrong = |&node: &u32| node as usize >= counts.n_nodes;
        if let Some(at) = first_where(own, wrong) {
            let at = at * binary.integer;
            let node = binary.integer(&bytes[at..at + binary.integer]);
            return Err(Error::input(format!(
                "a {} has node {node}, but the mesh has {} nodes, counted from 1",
                KINDS[i].name(),
                counts.n_nodes
            ))
            .byte((start + at) as u64));
        }
    }
    Ok(())
}

fn face_numbers(section: &mut Section, counts: &Counts, binary: &Binary) -> Result<Vec<i32>> {
    let start = section.start;
    let bytes = section.take(counts.n_faces() * binary.integer);
    let mut numbers = vec![0i32; counts.n_faces()];
    match (binary.is_big_endian, binary.integer) {
        (true, 4) => convert(bytes, &mut numbers, i32::from_be_bytes),
        (false, 4) => convert(bytes, &mut numbers, i32::from_le_bytes),
        _ => {
            let wide = bytes.chunks_exact(binary.integer);
            for (i, (number, bytes)) in numbers.iter_mut().zip(wide).enumerate() {
                let wide = binary.integer(bytes);
                *number = i32::try_from(wide).map_err(|_| {
                    Error::input(format!("face number {wide} is out of range"))
                        .byte((start + i * binary.integer) as u64)
                })?;
            }
        }
    }
    Ok(numbers)
}

//! Reading UGRID from bytes: bulk conversions on all threads.

use super::Ugrid;
use super::fortran;
use super::layout::{Binary, Content, Counts, KINDS, N_FACE_KINDS, n_nodes};
use crate::formats::Notes;
use crate::mesh::first_where;
use azimesh_core::diagnostic::formats::{NotKept, Read};
use azimesh_core::error::{Error, Result, option};
use azimesh_core::parallel::for_blocks;
use std::borrow::Cow;
use std::ops::Range;

/// Numbers that one task converts at a time.
const CHUNK: usize = 1 << 16;

/// Reads the numbers of a binary file.
pub(super) fn read(bytes: &[u8], binary: &Binary, flavour: &Ugrid) -> Result<Content> {
    let mut notes = Notes::default();
    let (counts, parts, start) = body(bytes, binary, flavour, &mut notes)?;
    let body = match parts[..] {
        [part] => Cow::Borrowed(part),
        _ => Cow::Owned(parts.concat()),
    };
    let stored = Stored::new(&counts, &body, start, *binary);
    let mut connectivity = vec![0u32; counts.n_entries()[1]];
    let mut rest = &mut connectivity[..];
    let (faces, solid) = (0..N_FACE_KINDS, N_FACE_KINDS..KINDS.len());
    let mut read_kinds = |kinds: Range<usize>| {
        kinds.into_iter().try_for_each(|kind| {
            let n = counts.n_cells[kind];
            let (own, others) = std::mem::take(&mut rest).split_at_mut(n_nodes(KINDS[kind]) * n);
            rest = others;
            stored.nodes(kind, 0..n, own)
        })
    };
    read_kinds(faces)?;
    let face_numbers = stored.face_numbers()?;
    read_kinds(solid)?;
    notes.count(stored.n_rest, |n| NotKept::Rest { n, what: "bytes" });
    Ok(Content {
        counts,
        points: stored.points(0..counts.n_nodes),
        connectivity,
        face_numbers,
        notes,
    })
}

/// The counts at the start of a file, its data in parts, as long as the counts need, and where these start.
pub(super) fn body<'a>(
    bytes: &'a [u8],
    binary: &Binary,
    flavour: &Ugrid,
    notes: &mut Notes,
) -> Result<(Counts, Vec<&'a [u8]>, usize)> {
    let wrong = |what: String| Error::input(what + &hint(bytes, flavour)).byte(0);
    let (header, body, start) = match binary.has_records {
        false => {
            let body = bytes.get(binary.header()..).unwrap_or(&[]);
            (bytes, vec![body], binary.header())
        }
        true => match (records(bytes, binary), fortran::unmarked(bytes, binary)) {
            (Ok(records), _) => records,
            (Err(_), Some((header, body))) => {
                notes.push(Read::WrongRecordMarks);
                let start = bytes.len() - fortran::MARK - body.len();
                (header, vec![body], start)
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
    let n_bytes: usize = body.iter().map(|part| part.len()).sum();
    if (n_bytes as u128) < needed {
        return Err(wrong(format!(
            "the counts at the start need {needed} bytes of coordinates and cells, the file has {n_bytes}"
        )));
    }
    Ok((counts, body, start))
}

/// Counts and data between the marks of records, and where the data start.
type Records<'a> = (&'a [u8], Vec<&'a [u8]>, usize);

fn records<'a>(bytes: &'a [u8], binary: &Binary) -> Result<Records<'a>> {
    let header = fortran::header(bytes, binary).ok_or_else(|| {
        Error::input("the file does not start with a Fortran record of seven counts").byte(0)
    })?;
    let (body, start) = fortran::data(bytes, fortran::header_bytes(binary) as usize, binary)?;
    Ok((header, body, start))
}

/// Numbers that follow each other in a file.
#[derive(Debug, Clone, Copy, Default)]
struct Section<'a> {
    bytes: &'a [u8],
    /// Their offset in the file.
    start: usize,
}

impl Section<'_> {
    /// Some of the numbers, of so many bytes each.
    fn part(&self, numbers: Range<usize>, width: usize) -> Self {
        let start = numbers.start * width;
        Self {
            bytes: &self.bytes[start..numbers.end * width],
            start: self.start + start,
        }
    }
}

/// Where the numbers of a file lie.
pub(super) struct Stored<'a> {
    binary: Binary,
    n_nodes: usize,
    points: Section<'a>,
    /// The nodes of the cells of each of [`KINDS`].
    nodes: [Section<'a>; KINDS.len()],
    face_numbers: Section<'a>,
    /// Bytes after all of these.
    pub n_rest: usize,
}

impl<'a> Stored<'a> {
    /// In data that are as long as the counts need; they start at this byte of the file.
    pub fn new(counts: &Counts, body: &'a [u8], start: usize, binary: Binary) -> Self {
        let mut rest = Section { bytes: body, start };
        let mut take = |n: usize| {
            let (bytes, after) = rest.bytes.split_at(n);
            let start = rest.start;
            rest = Section {
                bytes: after,
                start: start + n,
            };
            Section { bytes, start }
        };
        let points = take(3 * counts.n_nodes * binary.real);
        let of_kind = |i: usize| n_nodes(KINDS[i]) * counts.n_cells[i] * binary.integer;
        let mut nodes = [Section::default(); KINDS.len()];
        for (i, nodes) in nodes[..N_FACE_KINDS].iter_mut().enumerate() {
            *nodes = take(of_kind(i));
        }
        let face_numbers = take(counts.n_faces() * binary.integer);
        for (i, nodes) in nodes.iter_mut().enumerate().skip(N_FACE_KINDS) {
            *nodes = take(of_kind(i));
        }
        Self {
            binary,
            n_nodes: counts.n_nodes,
            points,
            nodes,
            face_numbers,
            n_rest: rest.bytes.len(),
        }
    }

    /// The coordinates of some nodes.
    pub fn points(&self, nodes: Range<usize>) -> Vec<[f64; 3]> {
        let mut points = vec![[0.0; 3]; nodes.len()];
        let out = points.as_flattened_mut();
        let bytes = self.points.part(nodes, 3 * self.binary.real).bytes;
        match (self.binary.is_big_endian, self.binary.real) {
            (true, 8) => convert(bytes, out, f64::from_be_bytes),
            (false, 8) => convert(bytes, out, f64::from_le_bytes),
            (true, _) => convert(bytes, out, |x| f64::from(f32::from_be_bytes(x))),
            (false, _) => convert(bytes, out, |x| f64::from(f32::from_le_bytes(x))),
        }
        points
    }

    /// Node indices of some cells of a kind, counted from 0; each is one of the mesh.
    pub fn nodes(&self, kind: usize, cells: Range<usize>, out: &mut [u32]) -> Result<()> {
        // An index that is too large for 32 bits is too large for the mesh.
        let narrow = |node: u64| u32::try_from(node.wrapping_sub(1)).unwrap_or(u32::MAX);
        let width = self.binary.integer;
        let Section { bytes, start } = self.nodes[kind].part(cells, n_nodes(KINDS[kind]) * width);
        match (self.binary.is_big_endian, width) {
            (true, 4) => convert(bytes, out, |x| u32::from_be_bytes(x).wrapping_sub(1)),
            (false, 4) => convert(bytes, out, |x| u32::from_le_bytes(x).wrapping_sub(1)),
            (true, _) => convert(bytes, out, |x| narrow(u64::from_be_bytes(x))),
            (false, _) => convert(bytes, out, |x| narrow(u64::from_le_bytes(x))),
        }
        let Some(at) = first_where(out, |&node| node as usize >= self.n_nodes) else {
            return Ok(());
        };
        let node = self.binary.integer(&bytes[at * width..(at + 1) * width]);
        Err(Error::input(format!(
            "a {} has node {node}, but the mesh has {} nodes, counted from 1",
            KINDS[kind].name(),
            self.n_nodes
        ))
        .byte((start + at * width) as u64))
    }

    /// The number of each boundary face.
    pub fn face_numbers(&self) -> Result<Vec<i32>> {
        let Section { bytes, start } = self.face_numbers;
        let width = self.binary.integer;
        let mut numbers = vec![0i32; bytes.len() / width];
        match (self.binary.is_big_endian, width) {
            (true, 4) => convert(bytes, &mut numbers, i32::from_be_bytes),
            (false, 4) => convert(bytes, &mut numbers, i32::from_le_bytes),
            _ => {
                let wide = bytes.chunks_exact(width);
                for (i, (number, bytes)) in numbers.iter_mut().zip(wide).enumerate() {
                    let wide = self.binary.integer(bytes);
                    *number = i32::try_from(wide).map_err(|_| {
                        Error::input(format!("face number {wide} is out of range"))
                            .byte((start + i * width) as u64)
                    })?;
                }
            }
        }
        Ok(numbers)
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

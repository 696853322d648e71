//! Makes a mesh of the numbers of a file. A binary file is read by ranges; the whole mesh is the range of all. In text the
//! numbers are between white space, wherever lines end.

use super::super::number::{Chunk, DType};
use super::super::slabs::{Refusal, Slabs, overlapping, whole};
use super::super::tokens::{Tokens, shown, without_comments};
use super::super::{Notes, Source};
use super::layout::{Binary, Counts, KINDS, N_FACE_KINDS, N_NODES};
use super::{Ugrid, faces, fortran, mapbc};
use crate::formats::notes::rest;
use crate::mesh::{Cells, Mesh};
use azimesh_core::error::{Error, Result, option};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::{note, sparse};
use std::borrow::Cow;
use std::ops::Range;

type Found<T> = std::result::Result<T, Refusal>;

/// The whole mesh, with the names and conditions of the companion file.
pub(super) fn read(source: &Source, flavour: &Ugrid, notes: &mut Notes) -> Result<Mesh> {
    let patches = mapbc::companion(source.path(), notes)?;
    let (mut mesh, face_numbers) = if flavour.layout.is_some() {
        let stored = Stored::new(source, flavour, notes)?;
        let n_rest = stored.n_rest;
        let mut mesh = Mesh {
            cells: stored.cells(0..stored.n_cells())?,
            ..Mesh::default()
        };
        let face_numbers = stored.face_numbers()?;
        notes.count(n_rest, |n| rest("bytes", n));
        mesh.points = stored.points(0..stored.n_nodes())?;
        (mesh, face_numbers)
    } else {
        read_text(source.bytes(), flavour, notes)?
    };
    faces::add_groups(&mut mesh, &face_numbers, &patches);
    Ok(mesh)
}

/// Opens a file to read ranges of it; an odd or damaged file is read whole.
pub(super) fn open<'a>(source: &'a Source, flavour: &Ugrid) -> Found<impl Slabs + use<'a>> {
    if flavour.layout.is_none() {
        return Err(whole("it is text"));
    }
    let mut notes = Notes::default();
    let stored = Stored::new(source, flavour, &mut notes)?;
    if matches!(stored.body, Cow::Owned(_)) {
        return Err(whole("its Fortran records are in several parts"));
    }
    if !notes.is_empty() {
        return Err(whole("its Fortran records have wrong marks"));
    }
    if stored.n_rest > 0 {
        return Err(whole("there are bytes after its cells"));
    }
    Ok(stored)
}

/// The numbers of a file, which can be read by ranges.
struct Stored<'a> {
    source: &'a Source,
    binary: Binary,
    counts: Counts,
    /// The numbers after the counts, as long as the counts need at least.
    body: Cow<'a, [u8]>,
    /// Offset of the numbers in the file.
    start: usize,
    /// Bytes after the numbers.
    n_rest: usize,
}

impl<'a> Stored<'a> {
    fn new(source: &'a Source, flavour: &Ugrid, notes: &mut Notes) -> Result<Self> {
        let bytes = source.bytes();
        let binary = flavour.layout.expect("a text is read by itself");
        let (header, parts, start) = if binary.has_records {
            records(bytes, &binary, notes).map_err(|error| Error {
                message: error.message + &hint(bytes, flavour),
                ..error
            })?
        } else {
            let body = bytes.get(binary.header()..).unwrap_or(&[]);
            (bytes, vec![body], binary.header())
        };
        let wrong = |what: String| Error::input(what + &hint(bytes, flavour)).byte(0);
        let counts = binary.counts(header).ok_or_else(|| {
            let n = binary.header();
            wrong(format!(
                "the file has {} bytes; the seven counts at its start alone need {n}",
                bytes.len()
            ))
        })?;
        let counts = counts.map_err(wrong)?;
        let needed = binary.body(&counts);
        let n_bytes: usize = parts.iter().map(|part| part.len()).sum();
        if (n_bytes as u128) < needed {
            return Err(wrong(format!(
                "the counts at the start need {needed} bytes of coordinates and cells, the file has {n_bytes}"
            )));
        }
        let body = match parts[..] {
            [part] => Cow::Borrowed(part),
            _ => Cow::Owned(parts.concat()),
        };
        Ok(Self {
            source,
            binary,
            counts,
            body,
            start,
            n_rest: n_bytes - needed as usize,
        })
    }

    fn coordinates(&self, nodes: Range<usize>) -> Chunk<'_> {
        let real = self.binary.real;
        let bytes = &self.body[3 * real * nodes.start..3 * real * nodes.end];
        DType::real(real, self.binary.is_big_endian).of(bytes)
    }

    /// Some of the integers after the coordinates, and their offset in the file.
    fn integers(&self, numbers: Range<usize>) -> (Chunk<'_>, usize) {
        let binary = self.binary;
        let first = 3 * self.counts.n_nodes * binary.real;
        let [start, end] = [numbers.start, numbers.end].map(|at| first + at * binary.integer);
        let dtype = DType::integer(binary.integer, binary.is_big_endian);
        (dtype.of(&self.body[start..end]), self.start + start)
    }

    /// Node indices of some cells of a kind, counted from 0; each is one of the mesh.
    fn nodes(&self, kind: usize, cells: Range<usize>, out: &mut [u32]) -> Result<()> {
        let first = self.counts.n_before(kind);
        let [from, to] = [cells.start, cells.end].map(|cell| first + cell * N_NODES[kind]);
        let (nodes, start) = self.integers(from..to);
        let n_nodes = self.counts.n_nodes;
        let found = nodes.indices(out, (1, n_nodes as u64), 0);
        found.map_err(|(at, node)| {
            let message = no_such_node(kind, node, n_nodes);
            Error::input(message).byte((start + at * self.binary.integer) as u64)
        })
    }

    fn face_numbers(&self) -> Result<Vec<i32>> {
        let first = self.counts.n_entries(N_FACE_KINDS);
        let (stored, start) = self.integers(first..first + self.counts.n_faces());
        let mut numbers = vec![0i32; stored.n_values()];
        if self.binary.integer == 4 {
            stored.copy_to(&mut numbers);
            return Ok(numbers);
        }
        for (i, number) in numbers.iter_mut().enumerate() {
            let wide = stored.integer(i);
            *number = i32::try_from(wide).map_err(|_| {
                Error::input(format!("face number {wide} is out of range"))
                    .byte((start + i * self.binary.integer) as u64)
            })?;
        }
        Ok(numbers)
    }
}

impl Slabs for Stored<'_> {
    fn n_nodes(&self) -> usize {
        self.counts.n_nodes
    }

    fn n_cells(&self) -> usize {
        self.counts.n_cells.iter().sum()
    }

    fn points(&self, nodes: Range<usize>) -> Result<Vec<Vector>> {
        Ok(self.coordinates(nodes).points(3))
    }

    fn cells(&self, cells: Range<usize>) -> Result<Cells> {
        let mut end = 0;
        let kinds = self.counts.n_cells.map(|n| {
            end += n;
            end - n..end
        });
        let kinds: Vec<_> = kinds.into_iter().enumerate().collect();
        let wanted: Vec<_> = overlapping(&kinds, |(_, all)| all.clone(), cells)
            .map(|((kind, _), own)| (*kind, own))
            .collect();
        let mut counts = Counts {
            n_cells: [0; KINDS.len()],
            ..self.counts
        };
        for (kind, own) in &wanted {
            counts.n_cells[*kind] = own.len();
        }
        let mut connectivity = vec![0; counts.n_entries(KINDS.len())];
        let mut rest = &mut connectivity[..];
        for (kind, own) in wanted {
            let (nodes, others) = rest.split_at_mut(N_NODES[kind] * own.len());
            self.nodes(kind, own, nodes)?;
            rest = others;
        }
        Ok(counts.cells(connectivity))
    }

    fn complete(&self, mesh: &mut Mesh, notes: &mut Notes) -> Found<()> {
        let patches = mapbc::companion(self.source.path(), notes)?;
        // Numbers of symmetry planes depend on the positions of their nodes.
        let mut boundary = Mesh {
            points: sparse::zeros(self.n_nodes(), [0.0; 3]),
            cells: self.cells(0..self.counts.n_faces())?,
            ..Mesh::default()
        };
        for node in boundary.cells.connectivity() {
            let node = *node as usize;
            self.coordinates(node..node + 1)
                .few_reals(&mut boundary.points[node]);
        }
        faces::add_groups(&mut boundary, &self.face_numbers()?, &patches);
        mesh.groups.append(&mut boundary.groups);
        mesh.field_arrays.append(&mut boundary.field_arrays);
        Ok(())
    }
}

/// Counts, data in their parts, and offset of the data.
type Records<'a> = (&'a [u8], Vec<&'a [u8]>, usize);

/// Finds the records of a file. Marks may be wrong where the length is right: meshio writes such files.
fn records<'a>(bytes: &'a [u8], binary: &Binary, notes: &mut Notes) -> Result<Records<'a>> {
    let marked = fortran::header(bytes, binary).ok_or_else(|| {
        Error::input("the file does not start with a Fortran record of seven counts").byte(0)
    });
    let start = binary.header() + 2 * fortran::MARK;
    let marked = marked.and_then(|header| {
        let (parts, start) = fortran::data(bytes, start, binary)?;
        Ok((header, parts, start))
    });
    let unmarked = || {
        let (header, start) = (bytes.get(fortran::MARK..)?, start + fortran::MARK);
        let body = bytes.get(start..bytes.len().checked_sub(fortran::MARK)?)?;
        let counts = binary.counts(header)?.ok()?;
        (body.len() as u128 == binary.body(&counts)).then_some((header, vec![body], start))
    };
    marked.or_else(|error| {
        let found = unmarked().ok_or(error)?;
        notes.push(note!(
            "wrong_record_marks",
            "the Fortran record marks are wrong; the file is read by its counts, which fit its length"
        ));
        Ok(found)
    })
}

/// A hint at the flavour that the file may be instead.
fn hint(bytes: &[u8], flavour: &Ugrid) -> String {
    let other = flavour.other(bytes);
    let other = other.map(|name| format!("; it would fit {} {name}", option("input-format")));
    format!(" (read as {}{})", flavour.name, other.unwrap_or_default())
}

/// The refusal of a node index.
pub(super) fn no_such_node(kind: usize, node: impl std::fmt::Display, n_nodes: usize) -> String {
    let kind = KINDS[kind].name();
    format!("a {kind} has node {node}, but the mesh has {n_nodes} nodes, counted from 1")
}

/// Checks if seven counts are at the start, with about as much text behind them as they need.
pub(super) fn fits_text(bytes: &[u8]) -> bool {
    let Ok((counts, rest)) = text_counts(bytes) else {
        return false;
    };
    let n_numbers = 3 * counts.n_nodes as u128 + counts.n_integers() as u128;
    let is_number = Tokens::new(&bytes[rest..]).real("a coordinate").is_ok();
    counts.is_mesh() && is_number && n_numbers * 2 <= (bytes.len() - rest) as u128 + 1
}

/// The counts, and the byte behind them.
fn text_counts(bytes: &[u8]) -> Result<(Counts, usize)> {
    let mut lexer = Tokens::new(bytes);
    let mut numbers = [0; 7];
    for number in &mut numbers {
        let word = lexer.next_word();
        let mut word =
            word.ok_or_else(|| lexer.error("the file ends within the seven counts at its start"))?;
        *number = word.integer("one of the seven counts")?;
    }
    let counts = Counts::of(numbers).map_err(|refusal| lexer.error(refusal))?;
    Ok((counts, lexer.position()))
}

/// The mesh in a text, which may have comments, and the number of each boundary face.
fn read_text(bytes: &[u8], flavour: &Ugrid, notes: &mut Notes) -> Result<(Mesh, Vec<i32>)> {
    let plain = without_comments(bytes);
    let found = read_plain(plain.as_deref().unwrap_or(bytes), flavour, notes)?;
    if plain.is_some() {
        notes.dialect(bytes);
    }
    Ok(found)
}

fn read_plain(bytes: &[u8], flavour: &Ugrid, notes: &mut Notes) -> Result<(Mesh, Vec<i32>)> {
    let (counts, start) =
        text_counts(bytes).map_err(|error| binary_instead(error, bytes, flavour))?;
    let tokens = Tokens::between(bytes, start..bytes.len());
    let words = tokens.words();
    let n_found = words.len();
    let n_needed = 3 * counts.n_nodes + counts.n_integers();
    if n_found < n_needed {
        return Err(tokens.error_at_end(format!(
            "the counts at the start need {n_needed} numbers, the file ends after {n_found}"
        )));
    }
    let mut points = vec![[0.0; 3]; counts.n_nodes];
    let mut integers = vec![0u32; counts.n_integers()];
    let reals = points.as_flattened_mut();
    words.parse_into(reals, "a coordinate", &mut integers, |words, first, out| {
        parse_integers(words, &counts, first, out)
    })?;
    let first = counts.n_entries(N_FACE_KINDS);
    let face_numbers = integers.drain(first..first + counts.n_faces());
    let face_numbers = face_numbers.map(|bits| bits as i32).collect();
    notes.dialect(bytes);
    notes.count(n_found - n_needed, |n| rest("numbers", n));
    let mesh = Mesh {
        points,
        cells: counts.cells(integers),
        ..Mesh::default()
    };
    Ok((mesh, face_numbers))
}

/// Adds to an error what the file may be instead.
fn binary_instead(mut error: Error, bytes: &[u8], flavour: &Ugrid) -> Error {
    if let Some(name) = flavour.other(bytes) {
        error.message += &format!(
            " (read as text; it would fit {} {name})",
            option("input-format")
        );
    } else if bytes.iter().take(64).any(|byte| *byte == 0) {
        let start = shown(&bytes[..bytes.len().min(16)]);
        error.message = format!("expected text, found binary data: {start}");
    }
    error
}

/// Parses integers from number `first` on: nodes counted from 0, bits of the face numbers.
fn parse_integers(
    words: &mut Tokens,
    counts: &Counts,
    first: usize,
    out: &mut [u32],
) -> Result<()> {
    let (mut at, end) = (first, first + out.len());
    let mut out = out.iter_mut();
    for kind in 0..KINDS.len() {
        if kind == N_FACE_KINDS {
            let n = counts.n_before(kind).min(end).saturating_sub(at);
            for out in out.by_ref().take(n) {
                *out = words.narrow::<i32>("a face number")? as u32;
            }
            at += n;
        }
        let last = counts.n_before(kind) + counts.n_entries(kind + 1) - counts.n_entries(kind);
        let n = last.min(end).saturating_sub(at);
        for out in out.by_ref().take(n) {
            let node = words.integer("a node index")?;
            *out = match usize::try_from(node) {
                Ok(index) if index >= 1 && index <= counts.n_nodes => (index - 1) as u32,
                _ => return Err(words.error(no_such_node(kind, node, counts.n_nodes))),
            };
        }
        at += n;
    }
    Ok(())
}

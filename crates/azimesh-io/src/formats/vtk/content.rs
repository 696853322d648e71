//! Arrays to be written: what they are and their bytes, which are mostly those in memory.

use super::number::Element;
use super::order;
use crate::mesh::{CellKind, Cells, NumbersApart, Values, arrays::with_numbers};
use azimesh_core::error::Result;
use std::borrow::Cow;

/// Values made at a time where an array is not in memory.
const CHUNK: usize = 1 << 19;

/// One array of the file.
pub struct Content<'a> {
    /// Its name.
    pub name: &'a str,
    /// Type of the values.
    pub element: Element,
    /// Values of a tuple.
    pub n_components: usize,
    /// Their names; empty where they have none.
    pub component_names: &'a [String],
    /// Number of tuples.
    pub n_tuples: usize,
    /// Bytes of all values.
    pub n_bytes: usize,
    /// The values, in order.
    pub parts: Vec<ContentPart<'a>>,
}

/// Some of an array's values, in the byte order of this machine.
pub enum ContentPart<'a> {
    /// Values in memory.
    Bytes(Cow<'a, [u8]>),
    /// Coordinates in 32 bits.
    Singles(&'a [f64]),
    /// Numbers that other ranks write: all that there is of an array.
    Apart(NumbersApart<'a>),
    /// Nodes of each cell.
    Nodes(&'a Cells),
    /// VTK type of each cell.
    Types(&'a Cells),
    /// End of each cell's nodes, as 32 bits or as 64.
    Offsets(&'a Cells, Element),
    /// Face streams of the polyhedra.
    Faces(&'a Cells),
    /// End of each polyhedron's face stream, -1 for other cells.
    FaceOffsets(&'a Cells, Element),
}

impl<'a> Content<'a> {
    /// A scalar array of `n_tuples` values.
    pub fn scalar(
        name: &'a str,
        element: Element,
        n_tuples: usize,
        parts: Vec<ContentPart<'a>>,
    ) -> Self {
        Self {
            name,
            element,
            n_components: 1,
            component_names: &[],
            n_tuples,
            n_bytes: n_tuples * element.size(),
            parts,
        }
    }

    /// Adds values at the end; the caller counts the tuples.
    pub fn append(&mut self, part: ContentPart<'a>) {
        if let ContentPart::Bytes(bytes) = &part {
            self.n_bytes += bytes.len();
        }
        self.parts.push(part);
    }

    /// An array of strings.
    pub fn strings(name: &'a str, strings: &[String]) -> Self {
        let bytes = string_bytes(strings);
        Self {
            n_bytes: bytes.len(),
            ..Self::scalar(name, Element::String, strings.len(), vec![bytes.into()])
        }
    }

    /// The numbers that other ranks write; none where the bytes are here.
    pub fn apart(&self) -> Option<&NumbersApart<'a>> {
        match &self.parts[..] {
            [ContentPart::Apart(numbers)] => Some(numbers),
            _ => None,
        }
    }

    /// Passes all bytes to `sink`, in as few parts as possible, each of whole values.
    ///
    /// # Panics
    /// When other ranks write them.
    pub fn for_each(&self, sink: Sink) -> Result<()> {
        for part in &self.parts {
            match part {
                ContentPart::Bytes(bytes) => sink(bytes)?,
                ContentPart::Singles(coordinates) => {
                    for some in coordinates.chunks(CHUNK) {
                        let singles: Vec<f32> = some.iter().map(|x| *x as f32).collect();
                        sink(bytemuck::cast_slice(&singles))?;
                    }
                }
                ContentPart::Apart(_) => panic!("what other ranks write is not here"),
                ContentPart::Nodes(cells) => nodes(cells, sink)?,
                ContentPart::Types(cells) => types(cells, sink)?,
                ContentPart::Offsets(cells, Element::Int32) => offsets(cells, |x| x as i32, sink)?,
                ContentPart::Offsets(cells, _) => offsets(cells, |x| x as i64, sink)?,
                ContentPart::Faces(cells) => faces(cells, sink)?,
                ContentPart::FaceOffsets(cells, Element::Int32) => {
                    face_offsets(cells, |x| x as i32, sink)?;
                }
                ContentPart::FaceOffsets(cells, _) => face_offsets(cells, |x| x, sink)?,
            }
        }
        Ok(())
    }
}

impl From<Vec<u8>> for ContentPart<'_> {
    fn from(bytes: Vec<u8>) -> Self {
        ContentPart::Bytes(Cow::Owned(bytes))
    }
}

/// Numbers in memory as they are.
pub fn slice<T: bytemuck::NoUninit>(values: &[T]) -> ContentPart<'_> {
    ContentPart::Bytes(Cow::Borrowed(bytemuck::cast_slice(values)))
}

/// Numbers that live no longer than this call.
pub fn owned<T: bytemuck::NoUninit>(values: &[T]) -> ContentPart<'static> {
    bytemuck::cast_slice(values).to_vec().into()
}

/// VTK's type of the values and their bytes.
pub fn of_values(values: &Values) -> (Element, ContentPart<'_>) {
    let part = with_numbers!(values, v => slice(v), strings => string_bytes(strings).into());
    (Element::of(values), part)
}

/// A zero within a string would end it.
fn not_zero(byte: u8) -> u8 {
    match byte {
        0 => b'_',
        byte => byte,
    }
}

/// Bytes of strings, a zero after each.
fn string_bytes(strings: &[String]) -> Vec<u8> {
    strings
        .iter()
        .flat_map(|string| string.bytes().map(not_zero).chain([0]))
        .collect()
}

type Sink<'s> = &'s mut dyn FnMut(&[u8]) -> Result<()>;

fn nodes(cells: &Cells, sink: Sink) -> Result<()> {
    if !order::has_wedges(cells) {
        return sink(bytemuck::cast_slice(cells.connectivity()));
    }
    let mut values: Vec<u32> = Vec::new();
    for run in cells.runs() {
        for some in run
            .connectivity
            .chunks(CHUNK / run.n_nodes.max(1) * run.n_nodes.max(1))
        {
            values.extend_from_slice(&order::listed(run.kind, some));
            flush_full(&mut values, sink)?;
        }
    }
    sink(bytemuck::cast_slice(&values))
}

fn types(cells: &Cells, sink: Sink) -> Result<()> {
    let mut bytes = Vec::new();
    for run in cells.runs() {
        let mut left = run.n_cells();
        while left > 0 {
            let n = left.min(CHUNK - bytes.len());
            bytes.resize(bytes.len() + n, run.kind.vtk());
            left -= n;
            flush_full(&mut bytes, sink)?;
        }
    }
    sink(&bytes)
}

fn offsets<T: bytemuck::NoUninit>(
    cells: &Cells,
    convert: impl Fn(u64) -> T,
    sink: Sink,
) -> Result<()> {
    let mut values: Vec<T> = Vec::new();
    let mut end = 0;
    for run in cells.runs() {
        let mut left = run.n_cells();
        while left > 0 {
            let n = left.min(CHUNK - values.len());
            let step = run.n_nodes as u64;
            values.extend((1..=n as u64).map(|i| convert(end + i * step)));
            end += n as u64 * step;
            left -= n;
            flush_full(&mut values, sink)?;
        }
    }
    sink(bytemuck::cast_slice(&values))
}

fn faces(cells: &Cells, sink: Sink) -> Result<()> {
    for run in cells.runs().filter(|run| run.kind == CellKind::Polyhedron) {
        for cell in run.first_cell..run.first_cell + run.n_cells() {
            sink(bytemuck::cast_slice(cells.face_stream(cell).unwrap_or(&[])))?;
        }
    }
    Ok(())
}

fn face_offsets<T: bytemuck::NoUninit>(
    cells: &Cells,
    convert: impl Fn(i64) -> T,
    sink: Sink,
) -> Result<()> {
    let mut values: Vec<T> = Vec::new();
    let mut end = 0;
    for run in cells.runs() {
        for cell in run.first_cell..run.first_cell + run.n_cells() {
            let stream = match run.kind {
                CellKind::Polyhedron => cells.face_stream(cell),
                _ => None,
            };
            end += stream.map_or(0, |stream| stream.len() as i64);
            values.push(convert(if stream.is_some() { end } else { -1 }));
            flush_full(&mut values, sink)?;
        }
    }
    sink(bytemuck::cast_slice(&values))
}

fn flush_full<T: bytemuck::NoUninit>(values: &mut Vec<T>, sink: Sink) -> Result<()> {
    if values.len() >= CHUNK {
        sink(bytemuck::cast_slice(values))?;
        values.clear();
    }
    Ok(())
}

//! Writes a mesh as VTK XML: `vtk::arrays` chooses the arrays, whose values follow the XML or are inside it, as text,
//! base64, raw, or compressed blocks.

use super::super::column::{Column, Sink};
use super::super::names::Rule;
use super::super::vtk::arrays::{Sections, VtkArrays};
use super::super::vtk::number::{Element, ascii, failed};
use super::super::vtk::order::{self, OUTWARD, WEDGES};
use super::super::{Compression, Encoding, Notes, Out, WriteOptions};
use crate::mesh::MeshView;
use azimesh_core::error::Result;
use azimesh_core::parallel::{block, try_map};
use std::io::{BufWriter, Write};

/// Smaller pieces are gathered before they are written; larger ones are written as they are.
const BUFFER: usize = 1 << 20;
/// Bytes of a block that is compressed on its own.
const BLOCK: usize = 256 << 10;

/// Arrays that are declared to VTK as global numbers of nodes and cells in a mesh of several files.
const GLOBAL_IDS: [&str; 2] = ["GlobalNodeIds", "GlobalCellIds"];
/// The lists of cells of polygonal data.
const LISTS: [&str; 4] = ["Verts", "Lines", "Strips", "Polys"];

/// Writes the mesh; returns a note for each thing that is not in the file.
pub(super) fn write(mesh: &MeshView, out: &mut dyn Out, options: &WriteOptions) -> Result<Notes> {
    let flattened = options.check_coordinates(mesh)?;
    let mut plan = VtkArrays::new(mesh, options, &NAMES);
    let mut notes = std::mem::take(&mut plan.notes);
    notes.extend(flattened);
    // Files of version 2.1 have the nodes of Lagrange and Bezier hexahedra in VTK's present order; every reader takes
    // 1.0.
    let is_new = mesh.cells.runs().any(|run| order::concerns(run.kind));
    let file = File {
        sections: plan.sections(),
        n_points: mesh.points.len(),
        n_cells: plan.n_cells(),
        lists: None,
        version: if is_new { "2.1" } else { "1.0" },
        has_wedges: order::has_wedges(mesh.cells),
        options,
    };
    file.write(out)?;
    Ok(notes)
}

pub(super) struct File<'a> {
    pub sections: Sections<'a>,
    pub n_points: usize,
    pub n_cells: usize,
    /// Of polygonal data, how many cells are vertices, lines, strips and polygons: `cells` has two arrays for each.
    pub lists: Option<[usize; 4]>,
    pub version: &'static str,
    /// True if there are wedges, whose order is marked.
    pub has_wedges: bool,
    pub options: &'a WriteOptions,
}

impl File<'_> {
    pub fn write(&self, out: &mut dyn Out) -> Result<()> {
        let mut out = BufWriter::with_capacity(BUFFER, out);
        match self.options.encoding {
            Encoding::Raw => self.appended(&mut out)?,
            Encoding::Base64 | Encoding::Ascii => self.inline(&mut out)?,
        }
        out.flush().map_err(failed)
    }

    /// XML first, all values after it.
    fn appended(&self, out: &mut dyn Out) -> Result<()> {
        let all = self.sections.all();
        let all = all.map(|array| Encoded::new(array, self.options.compression));
        let all = all.collect::<Result<Vec<_>>>()?;
        let mut sizes = all.iter().map(Encoded::n_bytes);
        let mut offset = 0;
        self.xml(out, &mut |array, out| {
            let (start, _) = tag(array, "appended");
            put(out, format!("{start} offset=\"{offset}\"/>\n"))?;
            offset += sizes.next().expect("every array has a size");
            Ok(())
        })?;
        put(out, "  <AppendedData encoding=\"raw\">\n   _".into())?;
        all.iter().try_for_each(|array| array.write_raw(out))?;
        put(out, "\n  </AppendedData>\n</VTKFile>\n".into())
    }

    /// Values inside the XML.
    fn inline(&self, out: &mut dyn Write) -> Result<()> {
        let is_text = self.options.encoding == Encoding::Ascii;
        let format = if is_text { "ascii" } else { "binary" };
        self.xml(out, &mut |array, out| {
            let (start, end) = tag(array, format);
            put(out, format!("{start}>\n"))?;
            if is_text {
                ascii(array, out)?;
            } else {
                Encoded::new(array, self.options.compression)?.write_base64(out)?;
            }
            put(out, format!("{end}\n"))
        })?;
        put(out, "</VTKFile>\n".into())
    }

    /// The XML up to the end of the grid; each array is written by `array`.
    fn xml(&self, out: &mut dyn Write, array: WriteArray) -> Result<()> {
        let version = self.version;
        let grid = self.lists.map_or("UnstructuredGrid", |_| "PolyData");
        let is_big = cfg!(target_endian = "big");
        let order = if is_big { "BigEndian" } else { "LittleEndian" };
        let compressor = match self.options.compression {
            _ if self.options.encoding == Encoding::Ascii => "",
            Compression::None => "",
            Compression::Zlib => " compressor=\"vtkZLibDataCompressor\"",
            Compression::Lz4 => " compressor=\"vtkLZ4DataCompressor\"",
            Compression::Lzma => " compressor=\"vtkLZMADataCompressor\"",
        };
        let mut mark = String::new();
        if self.has_wedges {
            mark = format!(" {WEDGES}=\"{OUTWARD}\"");
        }
        let head = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{grid}\" version=\"{version}\" \
             byte_order=\"{order}\" header_type=\"UInt64\"{compressor}{mark}>\n  <{grid}>\n"
        );
        put(out, head)?;
        let sections = &self.sections;
        if !sections.fields.is_empty() {
            section("FieldData", &sections.fields, out, array)?;
        }
        let (n_points, n_cells) = (self.n_points, self.n_cells);
        let mut counts = format!("NumberOfPoints=\"{n_points}\"");
        match self.lists {
            None => counts += &format!(" NumberOfCells=\"{n_cells}\""),
            Some(lists) => LISTS
                .iter()
                .zip(lists)
                .for_each(|(list, n)| counts += &format!(" NumberOf{list}=\"{n}\"")),
        }
        put(out, format!("<Piece {counts}>\n"))?;
        section("PointData", &sections.point_data, out, array)?;
        section("CellData", &sections.cell_data, out, array)?;
        section("Points", &sections.points, out, array)?;
        if self.lists.is_none() {
            section("Cells", &sections.cells, out, array)?;
        } else {
            for (list, arrays) in LISTS.iter().zip(sections.cells.chunks(2)) {
                section(list, arrays, out, array)?;
            }
        }
        put(out, format!("</Piece>\n  </{grid}>\n"))
    }
}

type WriteArray<'w> = &'w mut dyn FnMut(&Column, &mut dyn Write) -> Result<()>;

fn section(name: &str, arrays: &[Column], out: &mut dyn Write, array: WriteArray) -> Result<()> {
    let ids = arrays.iter().find(|array| GLOBAL_IDS.contains(&array.name));
    let ids = ids.map(|array| format!(" GlobalIds=\"{}\"", array.name));
    put(out, format!("<{name}{}>\n", ids.unwrap_or_default()))?;
    arrays.iter().try_for_each(|column| array(column, out))?;
    put(out, format!("</{name}>\n"))
}

fn put(out: &mut dyn Write, text: String) -> Result<()> {
    out.write_all(text.as_bytes()).map_err(failed)
}

/// Start tag of an array without its end, and end tag.
fn tag(array: &Column, format: &str) -> (String, &'static str) {
    // VTK calls arrays that hold no numbers by another name.
    let (element, end) = match array.element {
        Element::String => ("Array", "</Array>"),
        _ => ("DataArray", "</DataArray>"),
    };
    let mut tag = format!(
        "<{element} type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"",
        array.element.name(),
        escaped(array.name),
        array.n_components
    );
    for (i, name) in array.component_names.iter().enumerate() {
        tag += &format!(" ComponentName{i}=\"{}\"", escaped(name));
    }
    tag += &format!(" NumberOfTuples=\"{}\" format=\"{format}\"", array.n_tuples);
    (tag, end)
}

/// Names as attributes of XML 1.0 hold them.
pub const NAMES: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| name.replace(|c| !is_xml(c), "_"),
    why: "names in XML have no control characters",
};

/// Returns whether XML 1.0 has a character, be it by its number.
pub(in crate::formats) fn is_xml(c: char) -> bool {
    matches!(c, '\t' | '\n' | '\r' | ' '..) && !matches!(c, '\u{fffe}' | '\u{ffff}')
}

/// Text for the value of an attribute. Characters that XML does not have become `_`.
pub(in crate::formats) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            c if !is_xml(c) => escaped.push('_'),
            c if c.is_control() => escaped += &format!("&#{};", u32::from(c)),
            other => escaped.push(other),
        }
    }
    escaped
}

struct Encoded<'c> {
    array: &'c Column<'c>,
    /// The number of bytes; of compressed values the number of blocks, their size, the size of the last if it is smaller,
    /// and the compressed size of each.
    header: Vec<u8>,
    blocks: Option<Vec<Vec<u8>>>,
}

impl<'c> Encoded<'c> {
    fn new(array: &'c Column, compression: Compression) -> Result<Self> {
        let mut numbers = vec![array.n_bytes()];
        let mut blocks = None;
        if compression != Compression::None {
            let mut packed = Vec::new();
            in_groups(BLOCK, &[], &|sink| array.for_each(sink), &mut |bytes| {
                packed.extend(try_map(bytes.len().div_ceil(BLOCK), &|i| {
                    pack(compression, &bytes[block(bytes.len(), BLOCK, i)])
                })?);
                Ok(())
            })?;
            numbers = vec![packed.len(), BLOCK, array.n_bytes() % BLOCK];
            numbers.extend(packed.iter().map(Vec::len));
            blocks = Some(packed);
        }
        let header = numbers.iter().flat_map(|n| (*n as u64).to_ne_bytes());
        Ok(Self {
            array,
            header: header.collect(),
            blocks,
        })
    }

    /// Bytes that [`Encoded::write_raw`] writes.
    fn n_bytes(&self) -> usize {
        let values = match &self.blocks {
            Some(blocks) => blocks.iter().map(Vec::len).sum(),
            None => self.array.n_bytes(),
        };
        self.header.len() + values
    }

    /// Passes on the bytes after the header.
    fn for_each(&self, sink: Sink) -> Result<()> {
        match &self.blocks {
            Some(blocks) => blocks.iter().try_for_each(|block| sink(block)),
            None => self.array.for_each(sink),
        }
    }

    /// Writes header and values as they are.
    fn write_raw(&self, out: &mut dyn Out) -> Result<()> {
        out.write_all(&self.header).map_err(failed)?;
        match self.array.remote() {
            Some(numbers) => out.apart(numbers, 0).map(drop),
            None => self.for_each(&mut |bytes| out.write_all(bytes).map_err(failed)),
        }
    }

    /// Writes header and values as one base64 text, blocks as another than their header.
    fn write_base64(&self, out: &mut dyn Write) -> Result<()> {
        /// Bytes encoded at a time, a multiple of 3.
        const STEP: usize = 3 << 18;
        let mut encode = |bytes: &[u8]| {
            let mut steps = bytes
                .chunks(STEP)
                .map(|s| base64_simd::STANDARD.encode_to_string(s));
            steps.try_for_each(|text| put(out, text))
        };
        let mut start = &self.header[..];
        if self.blocks.is_some() {
            encode(start)?;
            start = &[];
        }
        in_groups(3, start, &|sink| self.for_each(sink), &mut encode)
    }
}

/// Passes `start` and the bytes of `each` to `sink` in parts of whole groups of `size` bytes, except for the last.
fn in_groups(
    size: usize,
    start: &[u8],
    each: &dyn Fn(Sink) -> Result<()>,
    sink: Sink,
) -> Result<()> {
    let mut pending = start.to_vec();
    each(&mut |bytes| {
        // Fill the group that was begun.
        let missing = (size - pending.len() % size) % size;
        let (head, rest) = bytes.split_at(missing.min(bytes.len()));
        pending.extend_from_slice(head);
        if !pending.len().is_multiple_of(size) {
            return Ok(());
        }
        let (whole, tail) = rest.split_at(rest.len() / size * size);
        sink(&pending)?;
        sink(whole)?;
        pending.clear();
        pending.extend_from_slice(tail);
        Ok(())
    })?;
    sink(&pending)
}

fn pack(compression: Compression, block: &[u8]) -> Result<Vec<u8>> {
    // Between fast and small; topology shrinks well at any level.
    const ZLIB_LEVEL: u32 = 4;
    const LZMA_PRESET: u32 = 4;
    match compression {
        Compression::None => Ok(block.to_vec()),
        Compression::Lz4 => Ok(lz4_flex::block::compress(block)),
        Compression::Zlib => {
            let level = flate2::Compression::new(ZLIB_LEVEL);
            let mut writer = flate2::write::ZlibEncoder::new(Vec::new(), level);
            let written = writer.write_all(block);
            written.and_then(|()| writer.finish()).map_err(failed)
        }
        Compression::Lzma => {
            let mut options = lzma_rust2::XzOptions::with_preset(LZMA_PRESET);
            options.lzma_options.dict_size = BLOCK as u32;
            options.set_check_sum_type(lzma_rust2::CheckType::Crc32);
            let mut writer = lzma_rust2::XzWriter::new(Vec::new(), options).map_err(failed)?;
            let written = writer.write_all(block);
            written.and_then(|()| writer.finish()).map_err(failed)
        }
    }
}

//! The XML of a .vtu file that is written, with values behind it or inside it.

use super::super::column::Column;
use super::super::names::Rule;
use super::super::vtk::arrays::Sections;
use super::super::vtk::number::Element;
use super::super::vtk::order::{OUTWARD, WEDGES};
use super::super::{Compression, Encoding, WriteOptions};
use super::encode::{self, CompressedBlocks, failed};
use crate::formats::Out;
use azimesh_core::error::Result;
use std::io::Write;

/// Arrays that are declared to VTK as global numbers of nodes and cells in a mesh of several files.
const GLOBAL_IDS: [&str; 2] = ["GlobalNodeIds", "GlobalCellIds"];

/// The lists of cells of polygonal data.
const LISTS: [&str; 4] = ["Verts", "Lines", "Strips", "Polys"];

/// A file about to be written.
pub(super) struct File<'a> {
    pub sections: Sections<'a>,
    pub n_points: usize,
    pub n_cells: usize,
    /// Of polygonal data, how many cells are vertices, lines, strips and polygons: `cells` has two arrays for each.
    pub lists: Option<[usize; 4]>,
    /// Version of the XML.
    pub version: &'static str,
    /// Whether there are wedges, whose order is marked.
    pub has_wedges: bool,
    pub options: &'a WriteOptions,
}

impl File<'_> {
    /// XML first, all values behind it.
    pub fn appended(&self, out: &mut dyn Out) -> Result<()> {
        let compression = self.options.compression;
        let compressed: Option<Vec<CompressedBlocks>> = match compression {
            Compression::None => None,
            _ => {
                let all = self
                    .sections
                    .all()
                    .map(|array| CompressedBlocks::new(array, compression));
                Some(all.collect::<Result<_>>()?)
            }
        };
        let sizes: Vec<usize> = match &compressed {
            Some(compressed) => compressed.iter().map(CompressedBlocks::n_bytes).collect(),
            None => self
                .sections
                .all()
                .map(|array| 8 + array.n_bytes())
                .collect(),
        };
        let mut sizes = sizes.into_iter();
        let mut offset = 0;
        self.xml(out, &mut |array, out| {
            let tag = tag(array, "appended", Some(offset));
            offset += sizes.next().expect("every array has a size");
            writeln!(out, "{}/>", tag.0).map_err(failed)
        })?;
        write!(out, "  <AppendedData encoding=\"raw\">\n   _").map_err(failed)?;
        match &compressed {
            Some(compressed) => compressed
                .iter()
                .try_for_each(|array| array.write_raw(out))?,
            None => self
                .sections
                .all()
                .try_for_each(|array| encode::raw(array, out))?,
        }
        write!(out, "\n  </AppendedData>\n</VTKFile>\n").map_err(failed)
    }

    /// Values inside the XML.
    pub fn inline(&self, out: &mut dyn Write) -> Result<()> {
        let options = self.options;
        let format = if options.encoding == Encoding::Ascii {
            "ascii"
        } else {
            "binary"
        };
        self.xml(out, &mut |array, out| {
            let (start, end) = tag(array, format, None);
            writeln!(out, "{start}>").map_err(failed)?;
            match (options.encoding, options.compression) {
                (Encoding::Ascii, _) => encode::ascii(array, out)?,
                (_, Compression::None) => encode::base64(array, out)?,
                (_, compression) => CompressedBlocks::new(array, compression)?.write_base64(out)?,
            }
            writeln!(out, "{end}").map_err(failed)
        })?;
        writeln!(out, "</VTKFile>").map_err(failed)
    }

    /// The XML up to the end of the grid; each array is written by `array`.
    fn xml(
        &self,
        out: &mut dyn Write,
        array: &mut dyn FnMut(&Column, &mut dyn Write) -> Result<()>,
    ) -> Result<()> {
        let version = self.version;
        let grid = match self.lists {
            None => "UnstructuredGrid",
            Some(_) => "PolyData",
        };
        let order = if cfg!(target_endian = "big") {
            "BigEndian"
        } else {
            "LittleEndian"
        };
        let compressor = match self.options.compression {
            _ if self.options.encoding == Encoding::Ascii => "",
            Compression::None => "",
            Compression::Zlib => " compressor=\"vtkZLibDataCompressor\"",
            Compression::Lz4 => " compressor=\"vtkLZ4DataCompressor\"",
            Compression::Lzma => " compressor=\"vtkLZMADataCompressor\"",
        };
        let mark = match self.has_wedges {
            true => format!(" {WEDGES}=\"{OUTWARD}\""),
            false => String::new(),
        };
        write!(
            out,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{grid}\" version=\"{version}\" \
             byte_order=\"{order}\" header_type=\"UInt64\"{compressor}{mark}>\n  <{grid}>\n"
        )
        .map_err(failed)?;
        let sections = &self.sections;
        if !sections.fields.is_empty() {
            section("FieldData", &sections.fields, out, array)?;
        }
        let (n_points, n_cells) = (self.n_points, self.n_cells);
        let counts = match self.lists {
            None => format!(" NumberOfCells=\"{n_cells}\""),
            Some(lists) => {
                let counts = LISTS.iter().zip(lists);
                let counts = counts.map(|(list, n)| format!(" NumberOf{list}=\"{n}\""));
                counts.collect()
            }
        };
        writeln!(out, "<Piece NumberOfPoints=\"{n_points}\"{counts}>").map_err(failed)?;
        section("PointData", &sections.point_data, out, array)?;
        section("CellData", &sections.cell_data, out, array)?;
        section("Points", &sections.points, out, array)?;
        match self.lists {
            None => section("Cells", &sections.cells, out, array)?,
            Some(_) => {
                for (list, arrays) in LISTS.iter().zip(sections.cells.chunks(2)) {
                    section(list, arrays, out, array)?;
                }
            }
        }
        write!(out, "</Piece>\n  </{grid}>\n").map_err(failed)
    }
}

fn section(
    name: &str,
    arrays: &[Column],
    out: &mut dyn Write,
    write_array: &mut dyn FnMut(&Column, &mut dyn Write) -> Result<()>,
) -> Result<()> {
    let ids = arrays.iter().find(|array| GLOBAL_IDS.contains(&array.name));
    let ids = ids.map_or(String::new(), |array| {
        format!(" GlobalIds=\"{}\"", array.name)
    });
    writeln!(out, "<{name}{ids}>").map_err(failed)?;
    for array in arrays {
        write_array(array, out)?;
    }
    writeln!(out, "</{name}>").map_err(failed)
}

/// Start tag of an array without its last character, and end tag.
fn tag(array: &Column, format: &str, offset: Option<usize>) -> (String, &'static str) {
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
    if let Some(offset) = offset {
        tag += &format!(" offset=\"{offset}\"");
    }
    (tag, end)
}

/// Names as attributes of XML 1.0 hold them.
pub const NAMES: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| name.replace(|c| !is_xml(c), "_"),
    why: "names in XML have no control characters",
};

/// Whether XML 1.0 has a character, be it by its number.
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

//! A mesh as a .vtu file: which arrays there are, and the XML around them.

use super::super::{Compression, Encoding, Precision, WriteOptions};
use super::content::{Content, Part, of_values, owned, slice};
use super::encode::{self, Packed, failed};
use super::number::Element;
use super::tags::{self, BOUNDARY, LOWER, Labels, Numbers, ZONE};
use crate::error::{Error, Result};
use crate::mesh::{DataArray, Group, Mesh, Values};
use std::io::{BufWriter, Write};

/// Smaller pieces are gathered before they are written; larger ones are written as they are.
const BUFFER: usize = 1 << 20;

/// Writes the mesh; returns a sentence for each thing that is not in the file.
pub(super) fn write(
    mesh: &Mesh,
    out: &mut dyn Write,
    options: &WriteOptions,
) -> Result<Vec<String>> {
    check_precision(mesh, options)?;
    let plan = Plan::new(mesh, options);
    let file = File {
        sections: plan.sections(),
        n_points: mesh.points.len(),
        n_cells: mesh.cells.len() + plan.repeated.len(),
        options,
    };
    let mut out = BufWriter::with_capacity(BUFFER, out);
    match options.encoding {
        Encoding::Raw => file.appended(&mut out)?,
        Encoding::Base64 | Encoding::Ascii => file.inline(&mut out)?,
    }
    out.flush().map_err(failed)?;
    Ok(plan.notes)
}

fn check_precision(mesh: &Mesh, options: &WriteOptions) -> Result<()> {
    let too_large = |point: &[f64; 3]| point.iter().any(|x| x.abs() > f64::from(f32::MAX));
    match mesh.points.iter().position(too_large) {
        Some(node) if options.precision == Precision::F32 => Err(Error::input(format!(
            "node {node} has coordinates {:?}, too large for 32 bits; write 64",
            mesh.points[node]
        ))),
        _ => Ok(()),
    }
}

/// What is written of a mesh.
struct Plan<'a> {
    mesh: &'a Mesh,
    options: &'a WriteOptions,
    /// Groups as numbers, for those pairs of arrays that the mesh needs.
    labels: Vec<(Labels, Numbers)>,
    /// Cells written again because they are in several tags.
    repeated: Vec<usize>,
    /// Node indices of those cells.
    repeated_nodes: Vec<u32>,
    /// Arrays of the repeated cells.
    repeated_arrays: Vec<Values>,
    notes: Vec<String>,
}

impl<'a> Plan<'a> {
    fn new(mesh: &'a Mesh, options: &'a WriteOptions) -> Self {
        let dimension = mesh.dimension();
        let n_cells = mesh.cells.len();
        let mut labels = Vec::new();
        let mut notes = Vec::new();
        for pair in [BOUNDARY, ZONE, LOWER] {
            let of_pair = |group: &&Group| match pair.array {
                "BoundaryTag" => group.dimension + 1 == dimension,
                "Zone" => group.dimension == dimension,
                _ => group.dimension + 1 < dimension,
            };
            let groups: Vec<&Group> = mesh.groups.iter().filter(of_pair).collect();
            if !groups.is_empty() {
                labels.push((pair, tags::number(&groups, n_cells, !options.tag_names)));
            }
        }
        let mut repeated = Vec::new();
        for (pair, numbers) in &labels {
            if pair.array == BOUNDARY.array {
                repeated.extend(numbers.further.iter().map(|(cell, _)| *cell));
            } else if let Some((cell, _)) = numbers.further.first() {
                notes.push(format!(
                    "{} cells are in more than one group; the array {} holds the first (cell {cell})",
                    numbers.further.len(),
                    pair.array
                ));
            }
        }
        let arrays = mesh.cell_arrays.iter();
        let mut plan = Self {
            mesh,
            options,
            repeated_nodes: repeated
                .iter()
                .flat_map(|&c| mesh.cells.get(c).nodes)
                .copied()
                .collect(),
            repeated_arrays: arrays
                .map(|a| a.values.select(a.n_components, &repeated))
                .collect(),
            labels,
            repeated,
            notes,
        };
        plan.note_dropped();
        plan
    }

    fn note_dropped(&mut self) {
        let mesh = self.mesh;
        if !self.options.tag_names && !self.labels.is_empty() {
            self.notes
                .push("names of tags are not written, as was asked".into());
        }
        let arrays = mesh
            .point_arrays
            .iter()
            .chain(&mesh.cell_arrays)
            .chain(&mesh.field_arrays);
        let dropped = arrays.filter(|array| !self.is_kept(array));
        let dropped: Vec<_> = dropped.map(|array| &array.name).collect();
        let note = |name| format!("the array \"{name}\" is not written");
        self.notes.extend(dropped.into_iter().map(note));
    }

    /// Whether an array of the mesh is written: not when its name is taken by tags, nor strings
    /// where none are wanted.
    fn is_kept(&self, array: &DataArray) -> bool {
        let taken = self.labels.iter().any(|(pair, _)| {
            pair.array == array.name || (pair.names == array.name && self.options.tag_names)
        });
        let is_text = matches!(array.values, Values::Text(_));
        !taken && (self.options.tag_names || !is_text)
    }

    fn sections(&self) -> Sections<'_> {
        Sections {
            fields: self.fields(),
            point_data: self
                .kept(&self.mesh.point_arrays)
                .map(|(_, array)| content(array))
                .collect(),
            cell_data: self.cell_data(),
            points: vec![self.points()],
            cells: self.cells(),
        }
    }

    fn kept<'s>(&'s self, arrays: &'s [DataArray]) -> impl Iterator<Item = (usize, &'s DataArray)> {
        arrays
            .iter()
            .enumerate()
            .filter(|(_, array)| self.is_kept(array))
    }

    fn fields(&self) -> Vec<Content<'_>> {
        let arrays = self
            .kept(&self.mesh.field_arrays)
            .map(|(_, array)| content(array));
        let with_names = self.labels.iter().filter(|_| self.options.tag_names);
        let names = with_names.map(|(pair, n)| Content::strings(pair.names, &n.names));
        arrays.chain(names).collect()
    }

    fn cell_data(&self) -> Vec<Content<'_>> {
        let n_cells = self.mesh.cells.len() + self.repeated.len();
        let labels = self.labels.iter().map(|(pair, numbers)| {
            let repeated: Vec<i32> = if pair.array == BOUNDARY.array {
                numbers.further.iter().map(|(_, number)| *number).collect()
            } else {
                self.repeated
                    .iter()
                    .map(|&cell| numbers.of_cells[cell])
                    .collect()
            };
            let parts = vec![slice(&numbers.of_cells), owned(&repeated)];
            Content::scalar(pair.array, Element::Int32, n_cells, parts)
        });
        let arrays = self.kept(&self.mesh.cell_arrays).map(|(at, array)| {
            let mut content = content(array);
            content.append(of_values(&self.repeated_arrays[at]).1);
            content.n_tuples = n_cells;
            content
        });
        labels.chain(arrays).collect()
    }

    fn points(&self) -> Content<'_> {
        let coordinates = self.mesh.points.as_flattened();
        let (element, part) = match self.options.precision {
            Precision::F64 => (Element::Float64, slice(coordinates)),
            Precision::F32 => (Element::Float32, Part::Singles(coordinates)),
        };
        Content {
            n_components: 3,
            n_tuples: self.mesh.points.len(),
            ..Content::scalar("Points", element, coordinates.len(), vec![part])
        }
    }

    fn cells(&self) -> Vec<Content<'_>> {
        let cells = &self.mesh.cells;
        let n_cells = cells.len() + self.repeated.len();
        let n_entries = cells.connectivity().len() + self.repeated_nodes.len();
        let index = match i32::try_from(self.mesh.points.len()) {
            Ok(_) => Element::Int32,
            Err(_) => Element::UInt32,
        };
        let nodes = vec![slice(cells.connectivity()), slice(&self.repeated_nodes)];
        let offset = narrowest(n_entries);
        let mut ends = Vec::with_capacity(self.repeated.len());
        let mut types = Vec::with_capacity(self.repeated.len());
        let mut end = cells.connectivity().len();
        for &cell in &self.repeated {
            let cell = cells.get(cell);
            end += cell.nodes.len();
            ends.push(end as i64);
            types.push(cell.kind.vtk());
        }
        let ends = vec![Part::Offsets(cells, offset), integers(&ends, offset)];
        let types = vec![Part::Types(cells), types.into()];
        let mut arrays = vec![
            Content::scalar("connectivity", index, n_entries, nodes),
            Content::scalar("offsets", offset, n_cells, ends),
            Content::scalar("types", Element::UInt8, n_cells, types),
        ];
        if cells.has_polyhedra() {
            let streams = cells
                .iter()
                .filter_map(|cell| cells.face_stream(cell.index));
            let n_entries = streams.map(<[u32]>::len).sum();
            let offset = narrowest(n_entries);
            let repeated = vec![-1; self.repeated.len()];
            let ends = vec![
                Part::FaceOffsets(cells, offset),
                integers(&repeated, offset),
            ];
            let faces = vec![Part::Faces(cells)];
            arrays.push(Content::scalar("faces", index, n_entries, faces));
            arrays.push(Content::scalar("faceoffsets", offset, n_cells, ends));
        }
        arrays
    }
}

/// Type of offsets up to `n`.
fn narrowest(n: usize) -> Element {
    match i32::try_from(n) {
        Ok(_) => Element::Int32,
        Err(_) => Element::Int64,
    }
}

fn integers(values: &[i64], element: Element) -> Part<'static> {
    match element {
        Element::Int32 => owned(&values.iter().map(|x| *x as i32).collect::<Vec<_>>()),
        _ => owned(values),
    }
}

fn content(array: &DataArray) -> Content<'_> {
    let (element, part) = of_values(&array.values);
    let mut content = Content {
        n_components: array.n_components,
        component_names: &array.component_names,
        ..Content::scalar(&array.name, element, array.n_tuples(), Vec::new())
    };
    content.n_bytes = 0;
    content.append(part);
    content
}

/// The arrays of each part of the file.
struct Sections<'a> {
    fields: Vec<Content<'a>>,
    point_data: Vec<Content<'a>>,
    cell_data: Vec<Content<'a>>,
    points: Vec<Content<'a>>,
    cells: Vec<Content<'a>>,
}

impl<'a> Sections<'a> {
    /// Every array, in the order of the file.
    fn all(&self) -> impl Iterator<Item = &Content<'a>> {
        let of_piece = [&self.point_data, &self.cell_data, &self.points, &self.cells];
        self.fields.iter().chain(of_piece.into_iter().flatten())
    }
}

/// A file about to be written.
struct File<'a> {
    sections: Sections<'a>,
    n_points: usize,
    n_cells: usize,
    options: &'a WriteOptions,
}

impl File<'_> {
    /// XML first, all values behind it.
    fn appended(&self, out: &mut dyn Write) -> Result<()> {
        let compression = self.options.compression;
        let packed: Option<Vec<Packed>> = match compression {
            Compression::None => None,
            _ => {
                let all = self
                    .sections
                    .all()
                    .map(|array| Packed::new(array, compression));
                Some(all.collect::<Result<_>>()?)
            }
        };
        let sizes: Vec<usize> = match &packed {
            Some(packed) => packed.iter().map(Packed::n_bytes).collect(),
            None => self.sections.all().map(|array| 8 + array.n_bytes).collect(),
        };
        let mut sizes = sizes.into_iter();
        let mut offset = 0;
        self.xml(out, &mut |array, out| {
            let tag = tag(array, "appended", Some(offset));
            offset += sizes.next().expect("every array has a size");
            writeln!(out, "{}/>", tag.0).map_err(failed)
        })?;
        write!(out, "  <AppendedData encoding=\"raw\">\n   _").map_err(failed)?;
        match &packed {
            Some(packed) => packed.iter().try_for_each(|array| array.write_raw(out))?,
            None => self
                .sections
                .all()
                .try_for_each(|array| encode::raw(array, out))?,
        }
        write!(out, "\n  </AppendedData>\n</VTKFile>\n").map_err(failed)
    }

    /// Values inside the XML.
    fn inline(&self, out: &mut dyn Write) -> Result<()> {
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
                (_, compression) => Packed::new(array, compression)?.write_base64(out)?,
            }
            writeln!(out, "{end}").map_err(failed)
        })?;
        write!(out, "</VTKFile>\n").map_err(failed)
    }

    /// The XML up to the end of the grid; each array is written by `array`.
    fn xml(
        &self,
        out: &mut dyn Write,
        array: &mut dyn FnMut(&Content, &mut dyn Write) -> Result<()>,
    ) -> Result<()> {
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
        write!(
            out,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
             byte_order=\"{order}\" header_type=\"UInt64\"{compressor}>\n  <UnstructuredGrid>\n"
        )
        .map_err(failed)?;
        let sections = &self.sections;
        if !sections.fields.is_empty() {
            section("FieldData", &sections.fields, out, array)?;
        }
        let (n_points, n_cells) = (self.n_points, self.n_cells);
        writeln!(
            out,
            "<Piece NumberOfPoints=\"{n_points}\" NumberOfCells=\"{n_cells}\">"
        )
        .map_err(failed)?;
        section("PointData", &sections.point_data, out, array)?;
        section("CellData", &sections.cell_data, out, array)?;
        section("Points", &sections.points, out, array)?;
        section("Cells", &sections.cells, out, array)?;
        write!(out, "</Piece>\n  </UnstructuredGrid>\n").map_err(failed)
    }
}

fn section(
    name: &str,
    arrays: &[Content],
    out: &mut dyn Write,
    write_array: &mut dyn FnMut(&Content, &mut dyn Write) -> Result<()>,
) -> Result<()> {
    writeln!(out, "<{name}>").map_err(failed)?;
    for array in arrays {
        write_array(array, out)?;
    }
    writeln!(out, "</{name}>").map_err(failed)
}

/// Start tag of an array without its last character, and end tag.
fn tag(array: &Content, format: &str, offset: Option<usize>) -> (String, &'static str) {
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

/// Text for the value of an attribute.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\n' | '\r' | '\t' => escaped += &format!("&#{};", u32::from(c)),
            other => escaped.push(other),
        }
    }
    escaped
}

//! The XML of a .vtu file: which arrays there are and where their values lie.
//!
//! Knows elements and attributes; nothing of how values are stored or of what they mean.

use super::super::Compression;
use super::super::vtk::number::Element;
use crate::error::{Error, Result};
use quick_xml::XmlVersion;
use quick_xml::events::attributes::Attribute;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

/// What a file holds.
pub(super) struct Document<'a> {
    /// Version of the file, major and minor.
    pub version: (u32, u32),
    /// How binary values are laid out.
    pub layout: Layout,
    /// Arrays of the mesh as a whole.
    pub field_data: Vec<Array<'a>>,
    /// The parts of the mesh.
    pub pieces: Vec<Piece<'a>>,
}

/// How binary values are laid out, the same for all arrays of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// Byte order.
    pub big_endian: bool,
    /// Bytes of one number of a header: 4 or 8.
    pub header_bytes: usize,
    /// Compression of blocks.
    pub compression: Compression,
}

/// One part of the mesh, with nodes of its own.
pub(super) struct Piece<'a> {
    pub n_points: u64,
    pub n_cells: u64,
    pub points: Vec<Array<'a>>,
    pub cells: Vec<Array<'a>>,
    pub point_data: Vec<Array<'a>>,
    pub cell_data: Vec<Array<'a>>,
}

/// One array and where its values lie.
#[derive(Clone)]
pub(super) struct Array<'a> {
    pub name: String,
    pub element: Element,
    pub n_components: usize,
    pub component_names: Vec<String>,
    /// Number of tuples, which only arrays of field data give.
    pub n_tuples: Option<u64>,
    pub place: Place,
    /// The values as stored; of an appended array, all from its offset to the end of the section.
    pub stored: &'a [u8],
    /// The file up to the values, for line numbers.
    pub before: &'a [u8],
}

/// In which form values are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Ascii,
    Base64,
    Raw,
}

/// One-based line after `before`.
pub(super) fn line_after(before: &[u8]) -> u64 {
    1 + memchr::memchr_iter(b'\n', before).count() as u64
}

/// Finds every array of the file.
pub(super) fn parse(bytes: &[u8]) -> Result<Document<'_>> {
    let start = memchr::memmem::find(bytes, b"<AppendedData");
    let xml = &bytes[..start.unwrap_or(bytes.len())];
    let text = std::str::from_utf8(xml).map_err(|error| {
        let at = error.valid_up_to();
        Error::input("the XML is not UTF-8 text").byte(at as u64)
    })?;
    let appended = start
        .map(|start| appended_section(bytes, start))
        .transpose()?;
    let mut reader = Reader::from_str(text);
    reader.config_mut().expand_empty_elements = true;
    let parser = Parser {
        reader,
        bytes,
        appended,
    };
    parser.document()
}

/// The data after the underscore of `<AppendedData encoding="...">_`, and where it starts.
fn appended_section(bytes: &[u8], start: usize) -> Result<Appended> {
    let fail = |message: &str| Error::input(message).line(line_after(&bytes[..start]));
    let length = memchr::memchr(b'>', &bytes[start..])
        .ok_or_else(|| fail("the file ends inside the element AppendedData"))?;
    let tag = &bytes[start..=start + length];
    let place = if memchr::memmem::find(tag, b"raw").is_some() {
        Place::Raw
    } else if memchr::memmem::find(tag, b"base64").is_some() {
        Place::Base64
    } else {
        return Err(fail("AppendedData needs encoding=\"raw\" or \"base64\""));
    };
    let mut at = start + length + 1;
    while bytes.get(at).is_some_and(u8::is_ascii_whitespace) {
        at += 1;
    }
    if bytes.get(at) != Some(&b'_') {
        return Err(fail(
            "the data of AppendedData must start with an underscore",
        ));
    }
    Ok(Appended {
        place,
        start: at + 1,
    })
}

#[derive(Clone, Copy)]
struct Appended {
    place: Place,
    start: usize,
}

struct Parser<'a> {
    reader: Reader<&'a [u8]>,
    bytes: &'a [u8],
    appended: Option<Appended>,
}

/// The value of an attribute. VTK does not escape the `&` of a name; then it is taken as it is.
fn value(attribute: &Attribute) -> String {
    match attribute.normalized_value(XmlVersion::Implicit1_0) {
        Ok(value) => value.into_owned(),
        Err(_) => attribute.value.to_string(),
    }
}

/// What may come inside an element.
enum Child<'a> {
    Element(BytesStart<'a>),
    /// Text that is not blank, as a range of the file.
    Text(std::ops::Range<usize>),
}

impl<'a> Parser<'a> {
    fn document(mut self) -> Result<Document<'a>> {
        let root = loop {
            match self.next_event()? {
                Event::Start(root) => break root,
                Event::Eof => return Err(self.error("there is no element VTKFile")),
                _ => {}
            }
        };
        if root.name().as_ref() != "VTKFile" {
            return Err(self.error("the outermost element is not VTKFile"));
        }
        let kind = self.attribute(&root, "type")?.unwrap_or_default();
        if kind != "UnstructuredGrid" {
            return Err(self.error(format!(
                "the file holds a VTK {kind}; what can be read is an UnstructuredGrid"
            )));
        }
        let mut document = Document {
            version: self.version(&root)?,
            layout: self.layout(&root)?,
            field_data: Vec::new(),
            pieces: Vec::new(),
        };
        let mut found = false;
        while let Some(child) = self.child("VTKFile")? {
            match child {
                Child::Element(e) if e.name().as_ref() == "UnstructuredGrid" => {
                    found = true;
                    self.grid(&mut document)?;
                }
                other => self.skip(other)?,
            }
        }
        if !found {
            return Err(self.error("there is no element UnstructuredGrid"));
        }
        Ok(document)
    }

    fn version(&self, root: &BytesStart) -> Result<(u32, u32)> {
        let version = self.attribute(root, "version")?.unwrap_or_default();
        let mut numbers = version.trim().split('.').map(|n| n.parse().unwrap_or(0));
        Ok((numbers.next().unwrap_or(0), numbers.next().unwrap_or(0)))
    }

    fn layout(&self, root: &BytesStart) -> Result<Layout> {
        let order = self.attribute(root, "byte_order")?;
        let big_endian = match order.as_deref() {
            Some("BigEndian") => true,
            Some("LittleEndian") | None => false,
            Some(other) => return Err(self.error(format!("byte_order \"{other}\" is not known"))),
        };
        let header = self.attribute(root, "header_type")?;
        let header_bytes = match header.as_deref() {
            Some("UInt32") | None => 4,
            Some("UInt64") => 8,
            Some(other) => return Err(self.error(format!("header_type \"{other}\" is not known"))),
        };
        let compressor = self.attribute(root, "compressor")?;
        let compression = match compressor.as_deref() {
            None | Some("") => Compression::None,
            Some("vtkZLibDataCompressor") => Compression::Zlib,
            Some("vtkLZ4DataCompressor") => Compression::Lz4,
            Some("vtkLZMADataCompressor") => Compression::Lzma,
            Some(other) => return Err(self.error(format!("compressor \"{other}\" is not known"))),
        };
        Ok(Layout {
            big_endian,
            header_bytes,
            compression,
        })
    }

    fn grid(&mut self, document: &mut Document<'a>) -> Result<()> {
        while let Some(child) = self.child("UnstructuredGrid")? {
            match child {
                Child::Element(e) if e.name().as_ref() == "FieldData" => {
                    document.field_data.extend(self.arrays("FieldData")?);
                }
                Child::Element(e) if e.name().as_ref() == "Piece" => {
                    let piece = self.piece(&e)?;
                    document.pieces.push(piece);
                }
                other => self.skip(other)?,
            }
        }
        Ok(())
    }

    fn piece(&mut self, element: &BytesStart) -> Result<Piece<'a>> {
        let mut piece = Piece {
            n_points: self.count(element, "NumberOfPoints")?.unwrap_or(0),
            n_cells: self.count(element, "NumberOfCells")?.unwrap_or(0),
            points: Vec::new(),
            cells: Vec::new(),
            point_data: Vec::new(),
            cell_data: Vec::new(),
        };
        while let Some(child) = self.child("Piece")? {
            let Child::Element(element) = child else {
                continue;
            };
            match element.name().as_ref() {
                "Points" => {
                    piece.points.extend(self.arrays("Points")?);
                    // Errors name the array, whatever the file calls it.
                    let arrays = piece.points.iter_mut();
                    arrays.for_each(|array| array.name = "Points".into());
                }
                "Cells" => piece.cells.extend(self.arrays("Cells")?),
                "PointData" => piece.point_data.extend(self.arrays("PointData")?),
                "CellData" => piece.cell_data.extend(self.arrays("CellData")?),
                _ => self.skip(Child::Element(element))?,
            }
        }
        Ok(piece)
    }

    fn arrays(&mut self, parent: &str) -> Result<Vec<Array<'a>>> {
        let mut arrays = Vec::new();
        while let Some(child) = self.child(parent)? {
            match child {
                Child::Element(e) if matches!(e.name().as_ref(), "DataArray" | "Array") => {
                    arrays.push(self.array(&e)?);
                }
                other => self.skip(other)?,
            }
        }
        Ok(arrays)
    }

    fn array(&mut self, element: &BytesStart) -> Result<Array<'a>> {
        let name = self.attribute(element, "Name")?.unwrap_or_default();
        let kind = self.attribute(element, "type")?.unwrap_or_default();
        let kind = Element::from_name(&kind).ok_or_else(|| {
            self.error(format!(
                "array \"{name}\" has values of type \"{kind}\", which is not known"
            ))
        })?;
        let n_components = match self.count(element, "NumberOfComponents")?.unwrap_or(1) {
            0 => return Err(self.error(format!("array \"{name}\" has tuples of 0 components"))),
            n => usize::try_from(n).map_err(|_| self.error("too many components"))?,
        };
        let component_names = self.component_names(element, n_components)?;
        let n_tuples = self.count(element, "NumberOfTuples")?;
        let format = self.attribute(element, "format")?;
        let (place, start, end) = match format.as_deref() {
            Some("appended") => self.appended_array(element, &name)?,
            Some("binary") => self.inline(Place::Base64)?,
            Some("ascii") | None => self.inline(Place::Ascii)?,
            Some(other) => {
                let message = format!("array \"{name}\" has the format \"{other}\"");
                return Err(self.error(format!("{message}; known: ascii, binary, appended")));
            }
        };
        Ok(Array {
            name,
            element: kind,
            n_components,
            component_names,
            n_tuples,
            place,
            stored: &self.bytes[start..end],
            before: &self.bytes[..start],
        })
    }

    fn component_names(&self, element: &BytesStart, n_components: usize) -> Result<Vec<String>> {
        const MOST: usize = 4096;
        let mut names = Vec::new();
        for attribute in element.attributes() {
            let attribute = attribute.map_err(|error| self.error(error.to_string()))?;
            let Some(index) = attribute.key.as_ref().strip_prefix("ComponentName") else {
                continue;
            };
            let Ok(index) = index.parse::<usize>() else {
                continue;
            };
            if index < n_components.min(MOST) {
                names.resize(names.len().max(index + 1), String::new());
                names[index] = value(&attribute);
            }
        }
        Ok(names)
    }

    /// Values that stand inside the element: its first text. Whatever else is in it is skipped.
    fn inline(&mut self, place: Place) -> Result<(Place, usize, usize)> {
        let mut values = None;
        while let Some(child) = self.child("DataArray")? {
            match child {
                Child::Text(range) if values.is_none() => values = Some(range),
                Child::Text(_) => {
                    return Err(self.error("the values are interrupted by an element"));
                }
                element => self.skip(element)?,
            }
        }
        let at = self.reader.buffer_position() as usize;
        let range = values.unwrap_or(at..at);
        Ok((place, range.start, range.end))
    }

    fn appended_array(
        &mut self,
        element: &BytesStart,
        name: &str,
    ) -> Result<(Place, usize, usize)> {
        let offset = self.count(element, "offset")?.ok_or_else(|| {
            self.error(format!("array \"{name}\" is appended, but has no offset"))
        })?;
        self.inline(Place::Raw)?;
        let section = self.appended.ok_or_else(|| {
            self.error(format!(
                "array \"{name}\" is appended, but the file has no AppendedData"
            ))
        })?;
        let start = usize::try_from(offset)
            .ok()
            .and_then(|offset| section.start.checked_add(offset))
            .filter(|start| *start <= self.bytes.len())
            .ok_or_else(|| {
                Error::input(format!(
                    "its offset is {offset}, but the file has {} bytes of appended data",
                    self.bytes.len() - section.start
                ))
                .dataset(name)
            })?;
        Ok((section.place, start, self.bytes.len()))
    }

    /// The next element or text inside `parent`; `None` at its end.
    fn child(&mut self, parent: &str) -> Result<Option<Child<'a>>> {
        loop {
            let start = self.reader.buffer_position() as usize;
            match self.next_event()? {
                Event::Start(element) => return Ok(Some(Child::Element(element))),
                Event::End(_) => return Ok(None),
                // The XML is cut off where the appended data starts.
                Event::Eof if parent == "VTKFile" && self.appended.is_some() => return Ok(None),
                Event::Eof => {
                    return Err(self.error(format!("the file ends inside the element {parent}")));
                }
                Event::Text(_) | Event::CData(_) => {
                    let end = self.reader.buffer_position() as usize;
                    if !self.bytes[start..end].trim_ascii().is_empty() {
                        return Ok(Some(Child::Text(start..end)));
                    }
                }
                _ => {}
            }
        }
    }

    fn skip(&mut self, child: Child) -> Result<()> {
        if let Child::Element(element) = child {
            let skipped = self.reader.read_to_end(element.name()).map(drop);
            skipped.map_err(|error| self.error(error.to_string()))?;
        }
        Ok(())
    }

    fn next_event(&mut self) -> Result<Event<'a>> {
        let event = self.reader.read_event();
        event.map_err(|error| {
            let at = (self.reader.error_position() as usize).min(self.bytes.len());
            Error::input(error.to_string()).line(line_after(&self.bytes[..at]))
        })
    }

    fn attribute(&self, element: &BytesStart, name: &str) -> Result<Option<String>> {
        let attribute = element.try_get_attribute(name);
        let attribute = attribute.map_err(|error| self.error(error.to_string()))?;
        Ok(attribute.map(|attribute| value(&attribute)))
    }

    fn count(&self, element: &BytesStart, name: &str) -> Result<Option<u64>> {
        let value = self.attribute(element, name)?;
        let value = value
            .as_deref()
            .map(str::trim)
            .filter(|value| !value.is_empty());
        let count = value.map(|value| {
            value.parse().map_err(|_| {
                self.error(format!(
                    "{name}=\"{value}\" is not a whole number, zero or more"
                ))
            })
        });
        count.transpose()
    }

    fn error(&self, message: impl Into<String>) -> Error {
        let at = (self.reader.buffer_position() as usize).min(self.bytes.len());
        Error::input(message).line(line_after(&self.bytes[..at]))
    }
}

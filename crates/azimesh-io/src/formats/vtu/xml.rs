//! XML of VTK: elements, attributes, and the stored values of arrays, which are not decoded here.

use super::super::tokens::line_of;
use super::super::vtk::number::Element;
use super::super::{Compression, Notes};
use azimesh_core::error::{Error, Result};
use azimesh_core::note;
use quick_xml::XmlVersion;
use quick_xml::events::attributes::Attribute;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use std::borrow::Cow;
use std::ops::Range;

/// Layout of binary values, the same for all arrays of a file.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub big_endian: bool,
    /// Bytes of one number of a header: 4 or 8.
    pub header_bytes: usize,
    pub compression: Compression,
}

/// One array and its stored values.
#[derive(Clone)]
pub(super) struct Array<'a> {
    pub name: String,
    pub element: Element,
    /// True if its values are bits, eight to a byte; `element` is then the type of the bytes.
    pub is_bits: bool,
    pub n_components: usize,
    pub component_names: Vec<String>,
    /// Number of tuples, which only arrays of field data give.
    pub n_tuples: Option<u64>,
    /// Steps that it belongs to, from 0; none for all steps.
    pub steps: Vec<usize>,
    pub encoding: DataEncoding,
    pub layout: Layout,
    /// The values as stored; of an appended array, all from its offset to the end of the section.
    pub stored: &'a [u8],
    /// The file up to the values, for line numbers.
    pub before: &'a [u8],
}

impl Array<'_> {
    /// The line of the file that a stored byte is on.
    pub fn line(&self, at: usize) -> u64 {
        line_of(self.before, self.before.len()) - 1 + line_of(self.stored, at)
    }
}

/// The element after which the XML ends: bytes of any value follow.
const APPENDED: &[u8] = b"<AppendedData";

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum DataEncoding {
    Ascii,
    Base64,
    Raw,
}

/// The encoding of the data after `<AppendedData encoding="...">_`, and the byte that it starts at.
fn appended_section(bytes: &[u8], start: usize) -> Result<(DataEncoding, usize)> {
    let fail = |message: &str| Error::input(message).line(line_of(bytes, start));
    let length = memchr::memchr(b'>', &bytes[start..])
        .ok_or_else(|| fail("the file ends inside the element AppendedData"))?;
    let tag = &bytes[start..=start + length];
    let encoding = if memchr::memmem::find(tag, b"raw").is_some() {
        DataEncoding::Raw
    } else if memchr::memmem::find(tag, b"base64").is_some() {
        DataEncoding::Base64
    } else {
        return Err(fail("AppendedData needs encoding=\"raw\" or \"base64\""));
    };
    let mut at = start + length + 1;
    while bytes.get(at).is_some_and(u8::is_ascii_whitespace) {
        at += 1;
    }
    match bytes.get(at) {
        Some(b'_') => Ok((encoding, at + 1)),
        _ => Err(fail(
            "the data of AppendedData must start with an underscore",
        )),
    }
}

/// A file with its XML in UTF-8: unchanged, or converted from Latin-1 where the XML is declared as that or is not
/// valid UTF-8. Text of two bytes per character is not changed.
pub(in crate::formats) fn as_utf8<'a>(bytes: &'a [u8], notes: &mut Notes) -> Cow<'a, [u8]> {
    let end = memchr::memmem::find(bytes, APPENDED).unwrap_or(bytes.len());
    let (xml, data) = bytes.split_at(end);
    let is_wide = xml.starts_with(b"\xff\xfe") || xml.starts_with(b"\xfe\xff");
    if xml.is_ascii() || is_wide {
        return bytes.into();
    }
    if !says_latin1(xml) {
        if std::str::from_utf8(xml).is_ok() {
            return bytes.into();
        }
        notes.push(note!(
            "xml_latin1",
            "the XML is not UTF-8; it is read as Latin-1"
        ));
    }
    let text: String = xml.iter().copied().map(char::from).collect();
    let mut bytes = text.into_bytes();
    bytes.extend_from_slice(data);
    bytes.into()
}

/// Returns whether the declaration at the start names Latin-1.
fn says_latin1(xml: &[u8]) -> bool {
    let head = xml.trim_ascii_start();
    let end = memchr::memmem::find(head, b"?>").filter(|_| head.starts_with(b"<?xml"));
    let head = head[..end.unwrap_or(0)].to_ascii_lowercase();
    let mut names = ["iso-8859-1", "latin1"].into_iter();
    names.any(|name| memchr::memmem::find(&head, name.as_bytes()).is_some())
}

/// A position in the XML.
pub(in crate::formats) struct Parser<'a> {
    reader: Reader<&'a [u8]>,
    bytes: &'a [u8],
    appended: Option<(DataEncoding, usize)>,
    /// Layout of the arrays that follow.
    pub(super) layout: Layout,
}

/// The value of an attribute. VTK does not escape the `&` of a name; then it is read unchanged.
fn value(attribute: &Attribute) -> String {
    match attribute.normalized_value(XmlVersion::Implicit1_0) {
        Ok(value) => value.into_owned(),
        Err(_) => attribute.value.to_string(),
    }
}

/// The content of an element.
enum Child<'a> {
    Element(BytesStart<'a>),
    /// Text that is not blank, as a range of the file.
    Text(Range<usize>),
}

impl<'a> Parser<'a> {
    /// At the start of a file.
    pub fn open(bytes: &'a [u8]) -> Result<Self> {
        let start = memchr::memmem::find(bytes, APPENDED);
        let xml = &bytes[..start.unwrap_or(bytes.len())];
        let text = std::str::from_utf8(xml).map_err(|error| {
            let at = error.valid_up_to();
            Error::input("the XML is neither UTF-8 nor Latin-1 text").byte(at as u64)
        })?;
        let appended = start.map(|start| appended_section(bytes, start));
        let mut reader = Reader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        Ok(Self {
            reader,
            bytes,
            appended: appended.transpose()?,
            layout: Layout {
                big_endian: false,
                header_bytes: 4,
                compression: Compression::None,
            },
        })
    }

    /// The outermost element, which must be VTKFile.
    pub fn root(&mut self) -> Result<BytesStart<'a>> {
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
        Ok(root)
    }

    pub(super) fn arrays(&mut self, parent: &str) -> Result<Vec<Array<'a>>> {
        let mut arrays = Vec::new();
        self.each(parent, |parser, name, element| {
            let is_array = matches!(name, "DataArray" | "Array");
            if is_array {
                arrays.push(parser.array(element)?);
            }
            Ok(is_array)
        })?;
        Ok(arrays)
    }

    /// Passes the elements inside `parent` and their names to `take`, and skips those that it does not take.
    pub fn each(
        &mut self,
        parent: &str,
        mut take: impl FnMut(&mut Self, &str, &BytesStart) -> Result<bool>,
    ) -> Result<()> {
        while let Some(child) = self.child(parent)? {
            if let Child::Element(element) = child
                && !take(self, element.name().as_ref(), &element)?
            {
                self.skip(&element)?;
            }
        }
        Ok(())
    }

    fn array(&mut self, element: &BytesStart) -> Result<Array<'a>> {
        let name = self.attribute(element, "Name")?.unwrap_or_default();
        let kind = self.attribute(element, "type")?.unwrap_or_default();
        let is_bits = kind == "Bit";
        let known = Element::from_name(if is_bits { "UInt8" } else { &kind });
        let element_type = known.ok_or_else(|| {
            self.error(format!(
                "array \"{name}\" has values of type \"{kind}\", which is not known"
            ))
        })?;
        let n_components = match self.count(element, "NumberOfComponents")?.unwrap_or(1) {
            0 => return Err(self.error(format!("array \"{name}\" has 0 components"))),
            n => usize::try_from(n).map_err(|_| self.error("too many components"))?,
        };
        let component_names = self.component_names(element, n_components)?;
        let n_tuples = self.count(element, "NumberOfTuples")?;
        let format = self.attribute(element, "format")?;
        let (encoding, stored) = match format.as_deref() {
            Some("appended") => self.appended_array(element, &name)?,
            Some("binary") => (DataEncoding::Base64, self.inline()?),
            Some("ascii") | None => (DataEncoding::Ascii, self.inline()?),
            Some(other) => {
                let message = format!("array \"{name}\" has the format \"{other}\"");
                return Err(self.error(format!("{message}; known: ascii, binary, appended")));
            }
        };
        Ok(Array {
            name,
            element: element_type,
            is_bits,
            n_components,
            component_names,
            n_tuples,
            steps: self.list(element, "TimeStep")?,
            encoding,
            layout: self.layout,
            before: &self.bytes[..stored.start],
            stored: &self.bytes[stored],
        })
    }

    fn component_names(&self, element: &BytesStart, n_components: usize) -> Result<Vec<String>> {
        const MOST: usize = 4096;
        let mut names = Vec::new();
        for attribute in element.attributes() {
            let attribute = attribute.map_err(|error| self.error(error.to_string()))?;
            let index = attribute.key.as_ref().strip_prefix("ComponentName");
            let index = index.and_then(|index| index.parse::<usize>().ok());
            if let Some(index) = index.filter(|index| *index < n_components.min(MOST)) {
                names.resize(names.len().max(index + 1), String::new());
                names[index] = value(&attribute);
            }
        }
        Ok(names)
    }

    /// The values inside the element: its first text. Any element in it is skipped.
    fn inline(&mut self) -> Result<Range<usize>> {
        let mut values = None;
        while let Some(child) = self.child("DataArray")? {
            match child {
                Child::Text(range) if values.is_none() => values = Some(range),
                Child::Text(_) => {
                    return Err(self.error("the values are interrupted by an element"));
                }
                Child::Element(element) => self.skip(&element)?,
            }
        }
        let at = self.reader.buffer_position() as usize;
        Ok(values.unwrap_or(at..at))
    }

    fn appended_array(
        &mut self,
        element: &BytesStart,
        name: &str,
    ) -> Result<(DataEncoding, Range<usize>)> {
        let missing =
            |parser: &Self, what| parser.error(format!("array \"{name}\" is appended, but {what}"));
        let offset = self.count(element, "offset")?;
        let offset = offset.ok_or_else(|| missing(self, "has no offset"))?;
        self.inline()?;
        let section = self.appended;
        let (encoding, first) =
            section.ok_or_else(|| missing(self, "the file has no AppendedData"))?;
        let end = self.bytes.len();
        let start = usize::try_from(offset).ok();
        let start = start.and_then(|offset| first.checked_add(offset));
        let start = start.filter(|start| *start <= end).ok_or_else(|| {
            let n = end - first;
            let message =
                format!("its offset is {offset}, but the file has {n} bytes of appended data");
            Error::input(message).dataset(name)
        })?;
        Ok((encoding, start..end))
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

    fn skip(&mut self, element: &BytesStart) -> Result<()> {
        let skipped = self.reader.read_to_end(element.name()).map(drop);
        skipped.map_err(|error| self.error(error.to_string()))
    }

    fn next_event(&mut self) -> Result<Event<'a>> {
        let event = self.reader.read_event();
        event.map_err(|error| {
            let at = self.reader.error_position() as usize;
            Error::input(error.to_string()).line(line_of(self.bytes, at))
        })
    }

    pub fn attribute(&self, element: &BytesStart, name: &str) -> Result<Option<String>> {
        let attribute = element.try_get_attribute(name);
        let attribute = attribute.map_err(|error| self.error(error.to_string()))?;
        Ok(attribute.map(|attribute| value(&attribute)))
    }

    /// An attribute that is a whole number.
    pub(super) fn count(&self, element: &BytesStart, name: &str) -> Result<Option<u64>> {
        let value = self.attribute(element, name)?.unwrap_or_default();
        let value = value.trim();
        if value.is_empty() {
            return Ok(None);
        }
        value.parse().map(Some).map_err(|_| {
            self.error(format!(
                "{name}=\"{value}\" is not a whole number, zero or more"
            ))
        })
    }

    /// An attribute that is a list of numbers; empty where there is none.
    pub(super) fn list<T: std::str::FromStr>(
        &self,
        element: &BytesStart,
        name: &str,
    ) -> Result<Vec<T>> {
        let text = self.attribute(element, name)?.unwrap_or_default();
        let number = |word: &str| {
            let wrong =
                |_| self.error(format!("{name} has \"{word}\", which is not such a number"));
            word.parse().map_err(wrong)
        };
        text.split_whitespace().map(number).collect()
    }

    pub fn error(&self, message: impl Into<String>) -> Error {
        let at = self.reader.buffer_position() as usize;
        Error::input(message).line(line_of(self.bytes, at))
    }
}

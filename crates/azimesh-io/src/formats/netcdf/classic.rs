//! netCDF's classic formats: a header of dimensions, attributes and variables, then the values of each variable,
//! everything with the most significant byte first.
//!
//! CDF-1 has offsets of 32 bits, CDF-2 of 64, CDF-5 counts of 64 bits too. Variables along the dimension without a
//! fixed length are stored record by record: one row of each of them after the other.
//! Format: <https://docs.unidata.ucar.edu/netcdf-c/current/file_format_specifications.html>

use super::super::names::decoded;
use super::super::vtk::number::Element;
use super::Data;
use azimesh_core::error::{Error, Result};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

/// Tags of the lists of the header.
const DIMENSIONS: u64 = 10;
const VARIABLES: u64 = 11;
const ATTRIBUTES: u64 = 12;

/// A file with its header.
pub(in super::super) struct Classic<'a> {
    bytes: &'a [u8],
    version: u8,
    dimensions: Vec<(String, usize)>,
    /// Index of the dimension of the records.
    record: Option<usize>,
    n_records: usize,
    variables: BTreeMap<String, Stored<'a>>,
}

/// Position of the values of a variable.
#[derive(Clone)]
pub(in super::super) struct Stored<'a> {
    bytes: &'a [u8],
    /// Indices of its dimensions, and their lengths.
    dimensions: Vec<usize>,
    pub(super) shape: Vec<usize>,
    element: Element,
    start: u64,
    /// Bytes from one row to the next.
    stride: u64,
    attributes: BTreeMap<String, &'a [u8]>,
}

impl<'a> Classic<'a> {
    /// Reads the header.
    pub fn read(bytes: &'a [u8]) -> Result<Self> {
        let version = bytes[3];
        let mut cursor = Cursor {
            bytes,
            at: 4,
            is_wide: version == 5,
        };
        let n_records = cursor.count("the number of records")?;
        let mut classic = Self {
            bytes,
            version,
            dimensions: Vec::new(),
            record: None,
            n_records: 0,
            variables: BTreeMap::new(),
        };
        for i in 0..cursor.list(DIMENSIONS, "dimensions")? {
            let name = cursor.name()?;
            let n = cursor.size("the length of a dimension")?;
            // A file can have one; netCDF's library takes the first.
            if n == 0 && classic.record.is_none() {
                classic.record = Some(i);
            }
            classic.dimensions.push((name, n));
        }
        cursor.attributes()?;
        for _ in 0..cursor.list(VARIABLES, "variables")? {
            let name = cursor.name()?;
            let variable = classic.header(&mut cursor)?;
            classic.variables.insert(name, variable);
        }
        classic.lay_out(n_records);
        Ok(classic)
    }

    fn header(&self, cursor: &mut Cursor<'a>) -> Result<Stored<'a>> {
        let n = cursor.size("the number of dimensions of a variable")?;
        let mut dimensions = Vec::new();
        for _ in 0..n {
            let at = cursor.at;
            let dimension = cursor.size("a dimension of a variable")?;
            if dimension >= self.dimensions.len() {
                return Err(Error::input(format!(
                    "a variable has dimension {dimension}; the file has {}",
                    self.dimensions.len()
                ))
                .byte(at as u64));
            }
            dimensions.push(dimension);
        }
        let attributes = cursor.attributes()?;
        let element = cursor.element()?;
        // The size, which follows from the dimensions, and which is wrong for variables that are too large for it.
        cursor.count("the size of a variable")?;
        let start = match self.version {
            1 => u64::from(cursor.word("the place of a variable")?),
            _ => cursor.long("the place of a variable")?,
        };
        Ok(Stored {
            bytes: self.bytes,
            dimensions,
            shape: Vec::new(),
            element,
            start,
            stride: 0,
            attributes,
        })
    }

    /// Finds the shape of each variable, and the size of a record: its variables are each filled up to a multiple of four
    /// bytes, but for one alone.
    fn lay_out(&mut self, n_records: u64) {
        let record = self.record;
        let is_of_records =
            |variable: &Stored| record.is_some() && variable.dimensions.first().copied() == record;
        self.set_shapes(1);
        let of_records = self.variables.values().filter(|of| is_of_records(of));
        let rows: Vec<u64> = of_records.clone().map(Stored::row).collect();
        let record_size = match rows[..] {
            [row] => row,
            _ => rows.iter().fold(0_u64, |sum, row| {
                sum.saturating_add(row.saturating_add(3) / 4 * 4)
            }),
        };
        // A file whose writer did not finish has no number of records: those that are there count.
        let streaming = if self.version == 5 {
            u64::MAX
        } else {
            u32::MAX.into()
        };
        let there = of_records.map(|of| of.start).min().map_or(0, |start| {
            let left = (self.bytes.len() as u64).saturating_sub(start);
            left.checked_div(record_size).unwrap_or(0)
        });
        let n = if n_records == streaming {
            there
        } else {
            n_records
        };
        self.n_records = usize::try_from(n).unwrap_or(usize::MAX);
        self.set_shapes(self.n_records);
        for variable in self.variables.values_mut() {
            variable.stride = if is_of_records(variable) {
                record_size
            } else {
                variable.row()
            };
        }
    }

    fn set_shapes(&mut self, n_records: usize) {
        let length = |i: &usize| {
            if Some(*i) == self.record {
                n_records
            } else {
                self.dimensions[*i].1
            }
        };
        for variable in self.variables.values_mut() {
            variable.shape = variable.dimensions.iter().map(length).collect();
        }
    }

    /// The format's name.
    pub fn title(&self) -> &'static str {
        match self.version {
            1 => "CDF-1",
            2 => "CDF-2",
            _ => "CDF-5",
        }
    }

    /// The length of a dimension.
    pub fn length(&self, dimension: &str) -> Option<usize> {
        let mut dimensions = self.dimensions.iter();
        let found = dimensions.position(|(name, _)| name == dimension)?;
        Some(if Some(found) == self.record {
            self.n_records
        } else {
            self.dimensions[found].1
        })
    }

    /// Names of the variables.
    pub fn names(&self) -> Vec<String> {
        self.variables.keys().cloned().collect()
    }

    /// The variable of this name.
    pub fn variable(&self, name: &str) -> Option<Stored<'a>> {
        self.variables.get(name).cloned()
    }
}

impl<'a> Stored<'a> {
    /// Bytes of a row.
    fn row(&self) -> u64 {
        let row = self.shape.iter().skip(1).map(|n| *n as u64);
        row.fold(self.element.size() as u64, u64::saturating_mul)
    }

    fn n_rows(&self) -> usize {
        self.shape.first().copied().unwrap_or(1)
    }

    /// Values of some rows.
    pub fn rows(&self, rows: Range<usize>) -> Result<Data<'a>> {
        let n_rows = self.n_rows();
        if rows.start > rows.end || rows.end > n_rows {
            let (start, end) = (rows.start, rows.end);
            return Err(Error::input(format!(
                "rows {start} to {end} are needed; it has {n_rows}"
            )));
        }
        Ok(Data::Bytes(self.bytes_of(rows)?, self.element))
    }

    /// All bytes of text.
    pub fn text(&self) -> Result<Vec<u8>> {
        if self.element != Element::String {
            return Err(Error::input("it must be text"));
        }
        Ok(self.bytes_of(0..self.n_rows())?.into_owned())
    }

    /// The bytes of an attribute that is text.
    pub fn attribute(&self, name: &str) -> Option<&'a [u8]> {
        self.attributes.get(name).copied()
    }

    fn bytes_of(&self, rows: Range<usize>) -> Result<Cow<'a, [u8]>> {
        let row = self.row();
        let start = |row: usize| {
            (row as u64)
                .saturating_mul(self.stride)
                .saturating_add(self.start)
        };
        let slice = |start: u64, length: u64| {
            let end = start.saturating_add(length);
            let there = usize::try_from(start).ok().zip(usize::try_from(end).ok());
            there.and_then(|(start, end)| self.bytes.get(start..end)).ok_or_else(|| {
                Error::input(format!(
                    "its values end at byte {end}, but the file ends at byte {}: it is cut short",
                    self.bytes.len()
                ))
            })
        };
        if self.stride == row || rows.len() <= 1 {
            let n = row.saturating_mul(rows.len() as u64);
            return slice(start(rows.start), n).map(Cow::Borrowed);
        }
        // The last row first, so that nothing is copied of a file that is cut short.
        slice(start(rows.end - 1), row)?;
        let mut bytes = Vec::new();
        for i in rows {
            bytes.extend_from_slice(slice(start(i), row)?);
        }
        Ok(Cow::Owned(bytes))
    }
}

/// A place in the header.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// True if counts have 64 bits.
    is_wide: bool,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, n: usize, what: &str) -> Result<&'a [u8]> {
        let end = self.at.checked_add(n);
        let taken = end
            .and_then(|end| self.bytes.get(self.at..end))
            .ok_or_else(|| {
                Error::input(format!(
                    "the file ends at byte {} in its header, where {what} should be",
                    self.bytes.len()
                ))
                .byte(self.at as u64)
            })?;
        self.at += n;
        Ok(taken)
    }

    fn word(&mut self, what: &str) -> Result<u32> {
        let bytes = self.take(4, what)?;
        Ok(u32::from_be_bytes(
            bytes.try_into().expect("four bytes were taken"),
        ))
    }

    fn long(&mut self, what: &str) -> Result<u64> {
        let bytes = self.take(8, what)?;
        Ok(u64::from_be_bytes(
            bytes.try_into().expect("eight bytes were taken"),
        ))
    }

    fn count(&mut self, what: &str) -> Result<u64> {
        if self.is_wide {
            self.long(what)
        } else {
            self.word(what).map(u64::from)
        }
    }

    /// A count of things that a machine can hold.
    fn size(&mut self, what: &str) -> Result<usize> {
        let at = self.at as u64;
        let n = self.count(what)?;
        let fits = usize::try_from(n).ok().filter(|n| *n < usize::MAX / 2);
        fits.ok_or_else(|| Error::input(format!("{what} is {n}, which cannot be")).byte(at))
    }

    /// The length of a list with this tag; an empty one may have none.
    fn list(&mut self, tag: u64, what: &str) -> Result<usize> {
        let at = self.at as u64;
        let found = u64::from(self.word("the tag of a list")?);
        let n = self.size("the length of a list")?;
        if found == tag || (found == 0 && n == 0) {
            return Ok(n);
        }
        Err(Error::input(format!(
            "the list of {what} has the tag {found}; it must be {tag}"
        ))
        .byte(at))
    }

    fn name(&mut self) -> Result<String> {
        let n = self.size("the length of a name")?;
        Ok(decoded(self.padded(n, "a name")?).into_owned())
    }

    /// Bytes that are filled up to a multiple of four.
    fn padded(&mut self, n: usize, what: &str) -> Result<&'a [u8]> {
        let bytes = self.take(n, what)?;
        let rest = n.wrapping_neg() % 4;
        self.take(rest, what)?;
        Ok(bytes)
    }

    fn element(&mut self) -> Result<Element> {
        let at = self.at as u64;
        Ok(match self.word("a type")? {
            1 => Element::Int8,
            2 => Element::String,
            3 => Element::Int16,
            4 => Element::Int32,
            5 => Element::Float32,
            6 => Element::Float64,
            7 => Element::UInt8,
            8 => Element::UInt16,
            9 => Element::UInt32,
            10 => Element::Int64,
            11 => Element::UInt64,
            other => {
                let message = format!("the type of values is {other}; it must be 1 to 11");
                return Err(Error::input(message).byte(at));
            }
        })
    }

    /// Attributes; the bytes of those that are text.
    fn attributes(&mut self) -> Result<BTreeMap<String, &'a [u8]>> {
        let mut attributes = BTreeMap::new();
        for _ in 0..self.list(ATTRIBUTES, "attributes")? {
            let name = self.name()?;
            let element = self.element()?;
            let n = self.size("the length of an attribute")?;
            let bytes = self.padded(n.saturating_mul(element.size()), "an attribute")?;
            if element == Element::String {
                attributes.insert(name, bytes);
            }
        }
        Ok(attributes)
    }
}

//! netCDF's classic formats: a header of dimensions, attributes and variables, then the values of each variable,
//! everything with the most significant byte first.
//!
//! CDF-1 has offsets of 32 bits, CDF-2 of 64, CDF-5 counts of 64 bits too. Variables along the dimension without a
//! fixed length lie record by record: one row of each of them after the other.
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
    /// Bytes from one record to the next.
    record_size: u64,
    variables: BTreeMap<String, Header<'a>>,
}

/// A variable in the header.
struct Header<'a> {
    dimensions: Vec<usize>,
    element: Element,
    start: u64,
    attributes: BTreeMap<String, &'a [u8]>,
}

/// Where the values of a variable are.
pub(in super::super) struct Stored<'a> {
    bytes: &'a [u8],
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
            record_size: 0,
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
            let header = classic.header(&mut cursor)?;
            classic.variables.insert(name, header);
        }
        classic.lay_out_records(n_records);
        Ok(classic)
    }

    fn header(&self, cursor: &mut Cursor<'a>) -> Result<Header<'a>> {
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
        Ok(Header {
            dimensions,
            element,
            start,
            attributes,
        })
    }

    /// Bytes of a row of a variable of records, of all of another; `None` where they are too many.
    fn row(&self, header: &Header) -> Option<u64> {
        let fixed = header
            .dimensions
            .iter()
            .filter(|i| Some(**i) != self.record);
        let size = header.element.size() as u64;
        fixed
            .map(|i| self.dimensions[*i].1 as u64)
            .try_fold(size, u64::checked_mul)
    }

    fn is_of_records(&self, header: &Header) -> bool {
        header
            .dimensions
            .first()
            .is_some_and(|first| Some(*first) == self.record)
    }

    /// Finds the size of a record: its variables are each filled up to a multiple of four bytes, but for one alone.
    fn lay_out_records(&mut self, n_records: u64) {
        let of_records: Vec<&Header> = self
            .variables
            .values()
            .filter(|header| self.is_of_records(header))
            .collect();
        let rows: Vec<u64> = of_records
            .iter()
            .map(|header| self.row(header).unwrap_or(u64::MAX / 4))
            .collect();
        self.record_size = match rows[..] {
            [row] => row,
            _ => rows.iter().fold(0, |sum, row| {
                sum.saturating_add(row.saturating_add(3) / 4 * 4)
            }),
        };
        let start = of_records.iter().map(|header| header.start).min();
        // A file whose writer did not finish has no number of records: those that are there count.
        let streaming = if self.version == 5 {
            u64::MAX
        } else {
            u32::MAX.into()
        };
        let there = start.map_or(0, |start| {
            let left = (self.bytes.len() as u64).saturating_sub(start);
            left.checked_div(self.record_size).unwrap_or(0)
        });
        let n = if n_records == streaming {
            there
        } else {
            n_records
        };
        self.n_records = usize::try_from(n).unwrap_or(usize::MAX);
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
        let found = self
            .dimensions
            .iter()
            .position(|(name, _)| name == dimension)?;
        Some(self.length_of(found))
    }

    fn length_of(&self, dimension: usize) -> usize {
        match Some(dimension) == self.record {
            true => self.n_records,
            false => self.dimensions[dimension].1,
        }
    }

    /// Names of the variables.
    pub fn names(&self) -> Vec<String> {
        self.variables.keys().cloned().collect()
    }

    /// The variable of this name.
    pub fn variable(&self, name: &str) -> Option<Stored<'a>> {
        let header = self.variables.get(name)?;
        let shape: Vec<usize> = header
            .dimensions
            .iter()
            .map(|i| self.length_of(*i))
            .collect();
        let row = shape.iter().skip(1).map(|n| *n as u64);
        let row = row.fold(header.element.size() as u64, u64::saturating_mul);
        Some(Stored {
            bytes: self.bytes,
            shape,
            element: header.element,
            start: header.start,
            stride: if self.is_of_records(header) {
                self.record_size
            } else {
                row
            },
            attributes: header.attributes.clone(),
        })
    }
}

impl<'a> Stored<'a> {
    /// Values of some rows.
    pub fn rows(&self, rows: Range<usize>) -> Result<Data<'a>> {
        let n_rows = self.shape.first().copied().unwrap_or(1);
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
        let n_rows = self.shape.first().copied().unwrap_or(1);
        Ok(self.bytes_of(0..n_rows)?.into_owned())
    }

    /// The bytes of an attribute that is text.
    pub fn attribute(&self, name: &str) -> Option<&'a [u8]> {
        self.attributes.get(name).copied()
    }

    fn bytes_of(&self, rows: Range<usize>) -> Result<Cow<'a, [u8]>> {
        let row = self.shape.iter().skip(1).map(|n| *n as u64);
        let row = row.fold(self.element.size() as u64, u64::saturating_mul);
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
    /// Whether counts have 64 bits.
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
        match self.is_wide {
            true => self.long(what),
            false => self.word(what).map(u64::from),
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

//! netCDF files: dimensions, variables and attributes by name, whichever way they are stored. Their meaning is left to
//! Exodus.
//!
//! ```text
//! classic   CDF-1, CDF-2 and CDF-5: the header, and the places of the values of each variable
//! ```
//!
//! The crate `netcdf-reader` (0.12) reads these formats too, but its errors about damaged headers (`InvalidData`) have no
//! byte offset, names must be UTF-8, each dimension of length 0 is one of records, and it returns copies of values, while values
//! are read here in the mapped file.
//!
//! netCDF-4 files are HDF5 and are read as such: a dimension is a dataset of its length, a variable a dataset.

mod classic;

use super::Source;
use super::hdf5::{self, Dataset, Group};
use super::names::decoded;
use super::number::{Chunk, DType};
use super::vtk::number::Element;
use crate::mesh::Values;
use azimesh_core::error::{Error, Result};
use classic::{Classic, Stored};
use std::borrow::Cow;
use std::ops::Range;

/// An open file.
pub(super) enum File<'a> {
    /// CDF-1, CDF-2 or CDF-5.
    Classic(Classic<'a>),
    /// netCDF-4.
    Hdf5(Group),
}

/// A variable.
pub(super) struct Variable<'a> {
    name: String,
    shape: Vec<usize>,
    stored: At<'a>,
}

enum At<'a> {
    Classic(Stored<'a>),
    Hdf5(Box<Dataset>),
}

/// Tests if these are the first bytes of a file of netCDF's own formats.
pub(super) fn is_classic(bytes: &[u8]) -> bool {
    matches!(bytes, [b'C', b'D', b'F', 1 | 2 | 5, ..])
}

impl<'a> File<'a> {
    /// Reads the header, or opens the HDF5 file.
    pub fn open(source: &'a Source) -> Result<Self> {
        match source.bytes() {
            bytes if is_classic(bytes) => Ok(Self::Classic(Classic::read(bytes)?)),
            bytes if hdf5::is_hdf5(bytes) => {
                Ok(Self::Hdf5(hdf5::File::open(source)?.root()?))
            }
            [b'C', b'D', b'F', version, ..] => Err(Error::input(format!(
                "this is a netCDF file of version {version}; versions 1, 2 and 5 and those in HDF5 are read"
            ))
            .byte(3)),
            _ => Err(Error::input(
                "this is no netCDF file, which begins with \"CDF\" or is HDF5",
            )
            .byte(0)),
        }
    }

    /// Name of the format of the file.
    pub fn title(&self) -> &'static str {
        match self {
            Self::Classic(classic) => classic.title(),
            Self::Hdf5(_) => "netCDF-4 (HDF5)",
        }
    }

    /// The length of a dimension; `None` where there is none of this name.
    pub fn length(&self, dimension: &str) -> Result<Option<usize>> {
        match self {
            Self::Classic(classic) => Ok(classic.length(dimension)),
            Self::Hdf5(root) => {
                let found = root.dataset(dimension)?;
                found
                    .map(|found| length(dimension, found.n_rows()))
                    .transpose()
            }
        }
    }

    /// Names of the variables, and in HDF5 of the dimensions too.
    pub fn names(&self) -> Result<Vec<String>> {
        match self {
            Self::Classic(classic) => Ok(classic.names()),
            Self::Hdf5(root) => Ok(root.names()?.1),
        }
    }

    /// The variable of this name; `None` where there is none.
    pub fn variable(&self, name: &str) -> Result<Option<Variable<'a>>> {
        let (shape, stored) = match self {
            Self::Classic(classic) => match classic.variable(name) {
                Some(stored) => (stored.shape.clone(), At::Classic(stored)),
                None => return Ok(None),
            },
            Self::Hdf5(root) => match root.dataset(name)? {
                Some(dataset) => {
                    let shape = dataset.shape().iter().map(|n| length(name, *n));
                    (shape.collect::<Result<_>>()?, At::Hdf5(Box::new(dataset)))
                }
                None => return Ok(None),
            },
        };
        let name = name.to_owned();
        Ok(Some(Variable {
            name,
            shape,
            stored,
        }))
    }

    /// The variable of this name, which must be there.
    pub fn need(&self, name: &str) -> Result<Variable<'a>> {
        let found = self.variable(name)?;
        found.ok_or_else(|| Error::input("the file has no such variable").dataset(name))
    }
}

fn length(name: &str, n: u64) -> Result<usize> {
    let n = usize::try_from(n).ok();
    n.ok_or_else(|| Error::input("it is too long").dataset(name))
}

impl Variable<'_> {
    /// An error about it.
    pub fn refuse(&self, message: impl Into<String>) -> Error {
        Error::input(message).dataset(&self.name)
    }

    /// Number of values along each of its dimensions.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Length of its first dimension; 1 for a single value.
    pub fn n_rows(&self) -> usize {
        self.shape.first().copied().unwrap_or(1)
    }

    /// All values.
    pub fn data(&self) -> Result<Data<'_>> {
        self.rows(0..self.n_rows())
    }

    /// The values of some of its rows: of the first dimension.
    pub fn rows(&self, rows: Range<usize>) -> Result<Data<'_>> {
        let found = match &self.stored {
            At::Classic(stored) => stored.rows(rows),
            At::Hdf5(dataset) => dataset
                .rows(rows.start as u64..rows.end as u64)
                .map(Data::Values),
        };
        found.map_err(|error| error.dataset(&self.name))
    }

    /// All values as integers.
    pub fn integers(&self) -> Result<Vec<i64>> {
        let data = self.data()?;
        let chunk = data.chunk().filter(|chunk| chunk.element.is_integer());
        let chunk = chunk.ok_or_else(|| self.refuse("it must have integers"))?;
        let mut integers = vec![0; chunk.n_values()];
        chunk.integers(&mut integers);
        Ok(integers)
    }

    /// All values as floating-point numbers.
    pub fn reals(&self) -> Result<Vec<f64>> {
        let data = self.data()?;
        let chunk = data
            .chunk()
            .ok_or_else(|| self.refuse("it must have numbers"))?;
        let mut reals = vec![0.0; chunk.n_values()];
        chunk.reals(&mut reals);
        Ok(reals)
    }

    /// Lines of text, each up to its first NUL and without spaces behind it.
    pub fn lines(&self) -> Result<Vec<Vec<u8>>> {
        let bytes = match &self.stored {
            At::Classic(stored) => stored.text(),
            At::Hdf5(dataset) => dataset.bytes(),
        };
        let bytes = bytes.map_err(|error| error.dataset(&self.name))?;
        let length = self.shape.last().copied().unwrap_or(0);
        let lines = bytes.chunks_exact(length.max(1));
        Ok(lines
            .map(|line| {
                let end = line.iter().position(|byte| *byte == 0);
                line[..end.unwrap_or(line.len())].trim_ascii_end().to_vec()
            })
            .collect())
    }

    /// An attribute that is text.
    pub fn text(&self, attribute: &str) -> Result<Option<String>> {
        match &self.stored {
            At::Classic(stored) => Ok(stored.attribute(attribute).map(|bytes| {
                let end = bytes.iter().position(|byte| *byte == 0);
                decoded(&bytes[..end.unwrap_or(bytes.len())]).into_owned()
            })),
            At::Hdf5(dataset) => dataset.text(attribute),
        }
    }
}

/// Values as they are in the file, or as they were read of HDF5.
pub(super) enum Data<'a> {
    /// Bytes, the most significant first.
    Bytes(Cow<'a, [u8]>, Element),
    /// Of HDF5.
    Values(Values),
}

impl Data<'_> {
    /// The numbers; `None` for text.
    pub fn chunk(&self) -> Option<Chunk<'_>> {
        match self {
            Self::Bytes(_, Element::String) => None,
            Self::Bytes(bytes, element) => Some(DType::new(*element, true).of(bytes)),
            Self::Values(values) => Chunk::of(values),
        }
    }

    /// The numbers in their own type; `None` for text.
    pub fn into_values(self) -> Option<Values> {
        let chunk = match self {
            Self::Values(Values::Text(_)) => return None,
            Self::Values(values) => return Some(values),
            Self::Bytes(..) => self.chunk()?,
        };
        macro_rules! copied {
            ($($element:ident $variant:ident),*) => {
                match chunk.element {
                    $(Element::$element => {
                        let mut values = vec![Default::default(); chunk.n_values()];
                        chunk.copy_to(&mut values);
                        Values::$variant(values)
                    })*
                    Element::String => return None,
                }
            };
        }
        Some(copied!(
            Int8 I8, UInt8 U8, Int16 I16, UInt16 U16, Int32 I32, UInt32 U32, Int64 I64, UInt64 U64, Float32 F32,
            Float64 F64
        ))
    }
}

//! Reads groups, attributes, and datasets as [`Values`] with the crate `hdf5-reader`.

use super::super::names::decoded;
use super::super::{Notes, Source};
use super::decode::{Bits, ShortChunks};
use super::whole::check;
use crate::mesh::Values;
use azimesh_core::error::{Error, Result};
use bytemuck::allocation::cast_vec;
use hdf5_reader::error::Error as Refused;
use hdf5_reader::{
    Attribute, Datatype, ExternalLinkResolver, H5Type, Hdf5File, OpenOptions, SliceInfo,
    SliceInfoElem, StringSize,
};
use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Decompressed data can be this many times larger than the file.
const MOST_RATIO: usize = 1100;
/// Most files that links lead to from one to the next.
const MOST_FILES: usize = 16;
/// Decompressed bytes that a small file may have.
const SMALLEST_LIMIT: usize = 64 << 20;

/// An open file.
pub(in crate::formats) struct File {
    inner: Hdf5File,
    missing: MissingFiles,
    short: ShortChunks,
}

/// Files that links of a file lead to and that are not there, as far as the links were followed.
#[derive(Clone, Default)]
pub(in crate::formats) struct MissingFiles(Arc<Mutex<BTreeSet<String>>>);

impl MissingFiles {
    fn lock(&self) -> MutexGuard<'_, BTreeSet<String>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Their names, ascending.
    pub fn names(&self) -> Vec<String> {
        self.lock().iter().cloned().collect()
    }
}

/// A group; links are followed, also into other files.
#[derive(Clone)]
pub(in crate::formats) struct Group(hdf5_reader::group::Group, ShortChunks);

/// A dataset.
pub(in crate::formats) struct Dataset {
    inner: hdf5_reader::Dataset,
    /// Bytes that it may have, by the size of the file.
    limit: u64,
    short: ShortChunks,
    /// Strings that were read as Latin-1.
    latin1: RefCell<Vec<String>>,
}

impl File {
    /// Opens the file. Its links into other files are relative to its folder.
    pub fn open(source: &Source) -> Result<Self> {
        let missing = MissingFiles::default();
        let links = SameFolder::of(source.path(), &missing, MOST_FILES);
        let options = options(source.bytes().len(), links);
        Self::with(source, options, missing, ShortChunks::default())
    }

    /// Opens a file whose last chunks may hold no more than the rows that there are, as Fluent writes them. It has no
    /// links into other files.
    pub fn open_with_short_chunks(source: &Source) -> Result<Self> {
        let short = ShortChunks::default();
        let options = OpenOptions {
            filter_registry: Some(short.filters()),
            ..options(source.bytes().len(), None)
        };
        Self::with(source, options, MissingFiles::default(), short)
    }

    fn with(
        source: &Source,
        options: OpenOptions,
        missing: MissingFiles,
        short: ShortChunks,
    ) -> Result<Self> {
        check(source)?;
        let inner = Hdf5File::from_owner(source.shared(), options).map_err(at_root)?;
        Ok(Self {
            inner,
            missing,
            short,
        })
    }

    /// Files that links lead to and that are not there.
    pub fn missing_files(&self) -> MissingFiles {
        self.missing.clone()
    }

    /// The group that holds everything.
    pub fn root(&self) -> Result<Group> {
        let root = self.inner.root_group().map_err(at_root)?;
        Ok(Group(root, self.short.clone()))
    }
}

/// Options for a file of `n_bytes`.
fn options(n_bytes: usize, resolver: Option<Arc<dyn ExternalLinkResolver>>) -> OpenOptions {
    OpenOptions {
        external_link_resolver: resolver,
        max_read_bytes: limit(n_bytes),
        max_chunk_bytes: limit(n_bytes).min(hdf5_reader::HDF5_MAX_CHUNK_BYTES),
        ..OpenOptions::default()
    }
}

/// Bytes that a dataset of a file of `n_bytes` may have when it is decompressed.
fn limit(n_bytes: usize) -> usize {
    n_bytes.saturating_mul(MOST_RATIO).max(SMALLEST_LIMIT)
}

/// Finds linked files in the folder of the file that links to them.
struct SameFolder {
    folder: PathBuf,
    missing: MissingFiles,
    /// Files that may follow one another.
    left: usize,
}

impl SameFolder {
    fn of(
        file: &Path,
        missing: &MissingFiles,
        left: usize,
    ) -> Option<Arc<dyn ExternalLinkResolver>> {
        Some(Arc::new(Self {
            folder: file.parent()?.to_path_buf(),
            missing: missing.clone(),
            left,
        }))
    }
}

impl ExternalLinkResolver for SameFolder {
    fn resolve_external_link(&self, name: &str) -> hdf5_reader::error::Result<Option<Hdf5File>> {
        let path = self.folder.join(name);
        if !path.is_file() {
            self.missing.lock().insert(name.to_owned());
            return Ok(None);
        }
        let source = Source::stored(&path).map_err(std::io::Error::other)?;
        let left = self.left.checked_sub(1);
        let next = left.and_then(|left| Self::of(&path, &self.missing, left));
        let options = options(source.bytes().len(), next);
        Hdf5File::from_owner(source.shared(), options).map(Some)
    }
}

impl Group {
    /// The name in the group that contains it.
    pub fn name(&self) -> &str {
        self.0.name()
    }

    /// The groups in it, in the order of creation where the file has that, else by name.
    pub fn groups(&self) -> Result<Vec<Group>> {
        let groups = self.at_self(self.0.groups())?.into_iter();
        Ok(groups.map(|inner| self.subgroup(inner)).collect())
    }

    /// The datasets in it, in the order of [`Group::groups`].
    pub fn datasets(&self) -> Result<Vec<Dataset>> {
        let datasets = self.at_self(self.0.datasets())?.into_iter();
        Ok(datasets.map(|inner| self.bounded(inner)).collect())
    }

    /// Names of its groups and of its datasets.
    pub fn names(&self) -> Result<(Vec<String>, Vec<String>)> {
        self.at_self(self.0.member_names())
    }

    /// The group of this name; `None` where there is none, also where a link leads nowhere.
    pub fn group(&self, name: &str) -> Result<Option<Group>> {
        let group = self.at_self(found(self.0.group(name)))?;
        Ok(group.map(|inner| self.subgroup(inner)))
    }

    /// The dataset of this name; `None` where there is none.
    pub fn dataset(&self, name: &str) -> Result<Option<Dataset>> {
        let dataset = self.at_self(found(self.0.dataset(name)))?;
        Ok(dataset.map(|inner| self.bounded(inner)))
    }

    /// The dataset of this name, which must be there.
    pub fn need(&self, name: &str) -> Result<Dataset> {
        let found = self.dataset(name)?;
        found.ok_or_else(|| Error::input("the dataset is missing").dataset(name))
    }

    /// An attribute that is text.
    pub fn text(&self, name: &str) -> Result<Option<String>> {
        let attribute = self.at_self(found(self.0.attribute(name)))?;
        let text = attribute.map(|attribute| attribute.read_string());
        at(name, text.transpose())
    }

    /// An attribute that is numbers or text.
    pub fn attribute(&self, name: &str) -> Result<Option<Values>> {
        attribute_values(name, self.at_self(found(self.0.attribute(name)))?)
    }

    fn subgroup(&self, inner: hdf5_reader::group::Group) -> Group {
        Group(inner, self.1.clone())
    }

    fn bounded(&self, inner: hdf5_reader::Dataset) -> Dataset {
        let limit = limit(usize::try_from(self.0.storage().len()).unwrap_or(usize::MAX));
        Dataset {
            inner,
            limit: limit as u64,
            short: self.1.clone(),
            latin1: RefCell::default(),
        }
    }

    fn at_self<T>(&self, read: std::result::Result<T, Refused>) -> Result<T> {
        at(self.name(), read)
    }
}

/// `None` for a group, a dataset or an attribute that is not there.
fn found<T>(found: std::result::Result<T, Refused>) -> std::result::Result<Option<T>, Refused> {
    match found {
        Err(
            Refused::GroupNotFound(_) | Refused::DatasetNotFound(_) | Refused::AttributeNotFound(_),
        ) => Ok(None),
        found => found.map(Some),
    }
}

/// An error of the crate as one of this name.
fn at<T>(name: &str, read: std::result::Result<T, Refused>) -> Result<T> {
    read.map_err(|error| refused(error).dataset(name))
}

/// Runs `$body` with `$T` standing for the bits of numbers of this datatype and `$variant` for the variant of [`Values`];
/// `$other` for anything that is no such number.
macro_rules! with_number {
    ($datatype:expr, $T:ident, $variant:ident => $body:expr, $other:expr) => {
        with_number!(@match $datatype, $T, $variant, $body, $other;
            (FixedPoint 1 true u8 I8) (FixedPoint 1 false u8 U8)
            (FixedPoint 2 true u16 I16) (FixedPoint 2 false u16 U16)
            (FixedPoint 4 true u32 I32) (FixedPoint 4 false u32 U32)
            (FixedPoint 8 true u64 I64) (FixedPoint 8 false u64 U64))
    };
    (@match $datatype:expr, $T:ident, $variant:ident, $body:expr, $other:expr;
        $((FixedPoint $size:literal $signed:literal $type:ident $name:ident))*) => {
        match $datatype {
            $(Datatype::FixedPoint { size: $size, signed: $signed, .. } => {
                type $T = Bits<$type>;
                use Values::$name as $variant;
                $body
            })*
            Datatype::FloatingPoint { size: 4, .. } => {
                type $T = Bits<u32>;
                use Values::F32 as $variant;
                $body
            }
            Datatype::FloatingPoint { size: 8, .. } => {
                type $T = Bits<u64>;
                use Values::F64 as $variant;
                $body
            }
            other => $other(other),
        }
    };
}

impl Dataset {
    /// The name in the group that contains it.
    pub fn name(&self) -> &str {
        self.inner.name()
    }

    /// An attribute that is numbers or text.
    pub fn attribute(&self, name: &str) -> Result<Option<Values>> {
        attribute_values(name, at(self.name(), found(self.inner.attribute(name)))?)
    }

    /// Numbers of values along each index; empty for a single value.
    pub fn shape(&self) -> &[u64] {
        self.inner.shape()
    }

    /// Number of rows: values of the first index.
    pub fn n_rows(&self) -> u64 {
        self.shape().first().copied().unwrap_or(1)
    }

    /// At least `n` rows, so many that chunks are read whole where the data is stored in chunks.
    pub fn whole_chunks(&self, n: u64) -> u64 {
        let chunk = self.inner.chunks().and_then(|chunk| chunk.first().copied());
        chunk.map_or(n, |rows| n.next_multiple_of(u64::from(rows).max(1)))
    }

    /// Values in one row.
    pub fn row(&self) -> Result<usize> {
        let others = self.shape().iter().skip(1);
        others
            .map(|n| usize::try_from(*n).ok())
            .try_fold(1_usize, |product, n| product.checked_mul(n?))
            .ok_or_else(|| Error::input("its rows are too long").dataset(self.name()))
    }

    /// Bytes of one value; 0 for what is neither a number nor text.
    pub fn value_size(&self) -> usize {
        hdf5_reader::dtype_element_size(self.inner.dtype()).unwrap_or(0)
    }

    /// Checks if its values are integers.
    pub fn is_of_integers(&self) -> bool {
        let is_read = matches!(self.value_size(), 1 | 2 | 4 | 8);
        is_read && matches!(self.inner.dtype(), Datatype::FixedPoint { .. })
    }

    /// Checks if its values are numbers.
    pub fn is_of_numbers(&self) -> bool {
        let is_real = matches!(self.inner.dtype(), Datatype::FloatingPoint { .. });
        self.is_of_integers() || is_real && matches!(self.value_size(), 4 | 8)
    }

    /// An attribute that is text.
    pub fn text(&self, name: &str) -> Result<Option<String>> {
        let attribute = at(self.name(), found(self.inner.attribute(name)))?;
        let text = attribute.map(|attribute| attribute.read_string());
        at(self.name(), text.transpose())
    }

    /// The bytes of single characters.
    pub fn bytes(&self) -> Result<Vec<u8>> {
        self.check_rows(&(0..self.n_rows()))?;
        if self.value_size() != 1 {
            return Err(Error::input("it must be text of single characters").dataset(self.name()));
        }
        at(self.name(), self.inner.read_raw_bytes())
    }

    /// All values, in their own type and the byte order of this machine.
    pub fn values(&self) -> Result<Values> {
        let read = || self.read(None);
        self.short.while_reading(&self.inner, read)
    }

    /// Refuses rows that are not there, and more than a file of this size can hold. Callers that read
    /// rows part by part asks for all of them first.
    pub fn check_rows(&self, rows: &Range<u64>) -> Result<()> {
        let wrong = |message: String| Err(Error::input(message).dataset(self.name()));
        let n = self.n_rows();
        if rows.start > rows.end || rows.end > n {
            let (start, end) = (rows.start, rows.end);
            return wrong(format!("rows {start} to {end} are needed; it has {n}"));
        }
        let row = self.row()?.saturating_mul(self.value_size().max(1)) as u64;
        let n_bytes = (rows.end - rows.start).saturating_mul(row);
        if n_bytes > self.limit {
            return wrong(format!(
                "its rows have {n_bytes} bytes, more than a file of this size can hold"
            ));
        }
        Ok(())
    }

    /// The values of some rows. Text is not read in parts.
    pub fn rows(&self, rows: Range<u64>) -> Result<Values> {
        self.check_rows(&rows)?;
        if self.shape().is_empty() || rows == (0..self.n_rows()) {
            return self.values();
        }
        self.read(Some(rows))
    }

    /// The values of some rows, or of all.
    fn read(&self, rows: Option<Range<u64>>) -> Result<Values> {
        let values = with_number!(
            self.inner.dtype(),
            T, Variant => self.numbers::<T>(rows).map(|bits| Variant(cast_vec(bits))),
            |other: &Datatype| match (self.others(other)?, rows) {
                (Values::Text(text), Some(rows)) => {
                    let row = self.row()?;
                    let part = rows.start as usize * row..rows.end as usize * row;
                    Ok(Values::Text(text[part].to_vec()))
                }
                (_, Some(_)) => Err(unknown(other)),
                (values, None) => Ok(values),
            }
        );
        values.map_err(|error| error.dataset(self.name()))
    }

    fn numbers<T: H5Type>(&self, rows: Option<Range<u64>>) -> Result<Vec<T>> {
        let array = match rows {
            None => self.inner.read_array_parallel::<T>(),
            Some(rows) if rows.is_empty() => return Ok(Vec::new()),
            Some(Range { start, end }) => {
                let step = 1;
                let mut selection = SliceInfo::all(self.shape().len());
                selection.selections[0] = SliceInfoElem::Slice { start, end, step };
                self.inner.read_slice_parallel::<T>(&selection)
            }
        };
        Ok(array.map_err(refused)?.into_raw_vec_and_offset().0)
    }

    /// Strings that are not all UTF-8.
    fn bytes_of_strings(&self) -> std::result::Result<Vec<String>, Refused> {
        let size = match self.inner.dtype() {
            Datatype::String { size, .. } => Some(size),
            _ => None,
        };
        let is_fixed = matches!(size, Some(StringSize::Fixed(_)));
        let raw = self.inner.read_raw_bytes()?;
        let elements = raw.chunks_exact(self.inner.raw_element_size()?.max(1));
        let string = |element: &[u8]| {
            let bytes = if is_fixed {
                element.to_vec()
            } else {
                self.inner.resolve_vlen_reference_bytes(element, 1)?
            };
            let end = bytes.iter().position(|byte| *byte == 0);
            let text = decoded(&bytes[..end.unwrap_or(bytes.len())]);
            if let Cow::Owned(text) = &text {
                self.latin1.borrow_mut().push(text.clone());
            }
            Ok(text.into_owned())
        };
        elements.map(string).collect()
    }

    /// Notes the strings that were read as Latin-1.
    pub fn note_latin1(&self, notes: &mut Notes) {
        let texts = self.latin1.borrow();
        texts.iter().for_each(|text| notes.latin1(text));
    }

    fn others(&self, datatype: &Datatype) -> Result<Values> {
        match datatype {
            Datatype::String { .. } | Datatype::VarLen { .. } => {
                let strings = match self.inner.read_strings() {
                    Err(Refused::InvalidData(_)) => self.bytes_of_strings(),
                    read => read,
                };
                strings.map(Values::Text).map_err(refused)
            }
            // A truth value.
            Datatype::Enum { base, .. }
                if matches!(**base, Datatype::FixedPoint { size: 1, .. }) =>
            {
                self.inner.read_raw_bytes().map(Values::U8).map_err(refused)
            }
            other => Err(unknown(other)),
        }
    }
}

fn attribute_values(name: &str, attribute: Option<Attribute>) -> Result<Option<Values>> {
    let Some(attribute) = attribute else {
        return Ok(None);
    };
    let values = with_number!(
        &attribute.datatype,
        T, Variant => attribute
            .read_1d::<T>()
            .map(|bits| Variant(cast_vec(bits)))
            .map_err(refused),
        |other: &Datatype| match other {
            Datatype::String { .. } | Datatype::VarLen { .. } => {
                attribute.read_strings().map(Values::Text).map_err(refused)
            }
            other => Err(unknown(other)),
        }
    );
    values.map(Some).map_err(|error| error.dataset(name))
}

fn unknown(datatype: &Datatype) -> Error {
    let found = match datatype {
        Datatype::FixedPoint { size, .. } => format!("integers of {size} bytes"),
        Datatype::FloatingPoint { size, .. } => format!("floating-point numbers of {size} bytes"),
        Datatype::Compound { .. } => "compound types".to_owned(),
        Datatype::Array { .. } => "arrays".to_owned(),
        Datatype::Enum { .. } => "enumerations".to_owned(),
        Datatype::Opaque { .. } => "opaque bytes".to_owned(),
        Datatype::Reference { .. } => "references".to_owned(),
        Datatype::Bitfield { .. } => "bit fields".to_owned(),
        Datatype::String { .. } | Datatype::VarLen { .. } => "text".to_owned(),
    };
    Error::input(format!("its values are {found}, which cannot be read"))
}

/// An error of the file as a whole.
fn at_root(error: Refused) -> Error {
    refused(error).dataset("/")
}

fn refused(error: Refused) -> Error {
    match error {
        Refused::Io(error) => Error::system(error.to_string()),
        other if other.to_string().contains("invalid UTF-8 string") => Error::input(
            "the name of a group, a dataset or an attribute is not UTF-8, which HDF5 requires",
        ),
        other => Error::input(format!("HDF5: {other}")),
    }
}

//! An array to be written: its type, and its values in memory, made in blocks, or on other ranks.

use super::vtk::number::Element;
use crate::mesh::{NumbersApart, Values, arrays::with_numbers};
use azimesh_core::error::Result;
use std::borrow::Cow;

/// Values made at a time where an array is not in memory.
pub const BLOCK: usize = 1 << 19;

/// Takes bytes as they are made.
pub type Sink<'s> = &'s mut dyn FnMut(&[u8]) -> Result<()>;
/// Makes bytes as they are written.
pub type Make<'a> = Box<dyn Fn(Sink) -> Result<()> + Send + Sync + 'a>;

/// One array of a file.
pub struct Column<'a> {
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
    /// The values, in order.
    pub data: Data<'a>,
}

/// Values of an array, in the byte order of this machine.
pub enum Data<'a> {
    /// Numbers in memory.
    Bytes(Cow<'a, [u8]>),
    /// Strings without zeros.
    Text(Cow<'a, [String]>),
    /// Numbers that are made as they are written.
    Made(Make<'a>),
    /// Numbers that other ranks write: all values of an array.
    Remote(NumbersApart<'a>),
    /// Values one after another.
    Parts(Vec<Data<'a>>),
}

impl<'a> Column<'a> {
    /// An array of `n_tuples` values.
    pub fn scalar(name: &'a str, element: Element, n_tuples: usize, data: Data<'a>) -> Self {
        Self {
            name,
            element,
            n_components: 1,
            component_names: &[],
            n_tuples,
            data,
        }
    }

    /// Bytes of all values; a string has a zero after it.
    pub fn n_bytes(&self) -> usize {
        match self.element {
            Element::String => self.data.strings().map(|text| text.len() + 1).sum(),
            element => self.n_tuples * self.n_components * element.size(),
        }
    }

    /// The numbers that other ranks write; none where the values are here.
    pub fn remote(&self) -> Option<&NumbersApart<'a>> {
        match &self.data {
            Data::Remote(numbers) => Some(numbers),
            _ => None,
        }
    }

    /// Passes all bytes to `sink`, in as few parts as possible, each of whole values.
    ///
    /// # Panics
    /// When other ranks write them.
    pub fn for_each(&self, sink: Sink) -> Result<()> {
        self.data.for_each(sink)
    }
}

impl<'a> Data<'a> {
    /// Numbers in memory as they are.
    pub fn slice<T: bytemuck::NoUninit>(values: &'a [T]) -> Self {
        Data::Bytes(Cow::Borrowed(bytemuck::cast_slice(values)))
    }

    /// A copy of a few numbers.
    pub fn owned<T: bytemuck::NoUninit>(values: &[T]) -> Self {
        Data::Bytes(Cow::Owned(bytemuck::cast_slice(values).to_vec()))
    }

    /// A copy of a few integers as 64 bits or as 32.
    pub fn integers(values: &[i64], is_wide: bool) -> Self {
        if is_wide {
            return Self::owned(values);
        }
        Self::owned(&values.iter().map(|x| *x as i32).collect::<Vec<_>>())
    }

    /// Strings; a zero within a string would end it.
    pub fn text(strings: &'a [String]) -> Self {
        if strings.iter().any(|text| text.contains('\0')) {
            return Data::Text(strings.iter().map(|text| text.replace('\0', "_")).collect());
        }
        Data::Text(strings.into())
    }

    /// Numbers that are made as they are written.
    pub fn made(make: impl Fn(Sink) -> Result<()> + Send + Sync + 'a) -> Self {
        Data::Made(Box::new(make))
    }

    /// The values of an array of a mesh.
    pub fn of(values: &'a Values) -> Self {
        with_numbers!(values, v => Self::slice(v), strings => Self::text(strings))
    }

    /// The strings; none of numbers.
    pub fn strings(&self) -> Box<dyn Iterator<Item = &String> + '_> {
        match self {
            Data::Text(strings) => Box::new(strings.iter()),
            Data::Parts(parts) => Box::new(parts.iter().flat_map(Data::strings)),
            _ => Box::new(std::iter::empty()),
        }
    }

    /// Passes all bytes to `sink`, in as few parts as possible, each of whole values; strings with a zero after each.
    ///
    /// # Panics
    /// When other ranks write them.
    pub fn for_each(&self, sink: Sink) -> Result<()> {
        match self {
            Data::Bytes(bytes) => sink(bytes),
            Data::Text(strings) => {
                let bytes = strings.iter().flat_map(|text| text.bytes().chain([0]));
                sink(&bytes.collect::<Vec<u8>>())
            }
            Data::Made(make) => make(sink),
            Data::Remote(_) => panic!("the values are on other ranks"),
            Data::Parts(parts) => parts.iter().try_for_each(|part| part.for_each(sink)),
        }
    }

    /// The hash of all bytes.
    pub fn hash(&self) -> Result<blake3::Hash> {
        if let Data::Remote(numbers) = self {
            return numbers.hash();
        }
        let mut hasher = blake3::Hasher::new();
        self.for_each(&mut |bytes| {
            hasher.update_rayon(bytes);
            Ok(())
        })?;
        Ok(hasher.finalize())
    }
}

/// Passes values to `sink`, a block at a time.
pub fn stream<T: bytemuck::NoUninit>(
    mut values: impl Iterator<Item = T>,
    sink: Sink,
) -> Result<()> {
    let mut block: Vec<T> = Vec::new();
    loop {
        block.clear();
        block.extend(values.by_ref().take(BLOCK));
        if block.is_empty() {
            return Ok(());
        }
        sink(bytemuck::cast_slice(&block))?;
    }
}

/// Passes integers to `sink` as 64 bits or as 32, a block at a time.
pub fn stream_integers(values: impl Iterator<Item = i64>, is_wide: bool, sink: Sink) -> Result<()> {
    if is_wide {
        return stream(values, sink);
    }
    stream(values.map(|x| x as i32), sink)
}

/// Start of each item of a list, and the end of the last.
pub fn starts(lengths: impl Iterator<Item = usize>) -> impl Iterator<Item = i64> {
    let mut end = 0;
    let ends = lengths.map(move |n| {
        end += n as i64;
        end
    });
    std::iter::once(0).chain(ends)
}

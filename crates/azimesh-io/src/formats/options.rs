//! Options of readers and writers.

use super::Format;
use super::rounding::flattened;
use crate::mesh::{MeshView, check_in_32_bits};
use azimesh_core::Note;
use azimesh_core::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;

/// Options of readers.
///
/// ```
/// use azimesh_io::{Mesh, ReadOptions};
/// # fn main() -> azimesh_io::Result<()> {
/// let options = ReadOptions { tag_array: Some("Marker".to_owned()), step: None };
/// let error = Mesh::read_with("testdata/naca0012.vtu", &options).err().expect("it has no such array");
/// assert!(error.message.contains("Marker"));
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ReadOptions {
    /// Name of the VTK cell array that holds boundary tags, when it is not one of the known names.
    pub tag_array: Option<String>,
    /// Index of the step to read from a file with a sequence; the last by default.
    pub step: Option<usize>,
}

impl ReadOptions {
    /// The step that is read of a file with `n`: the one asked for, else the last; `None` where it has none.
    pub(super) fn step_of(&self, n: usize) -> Result<Option<usize>> {
        match self.step {
            Some(step) if step < n.max(1) => Ok(self.step.filter(|_| n > 0)),
            None => Ok(n.checked_sub(1)),
            Some(step) => Err(Error::input(if n <= 1 {
                format!("there is no step {step}: the file holds one mesh")
            } else {
                format!("there is no step {step}: the file has steps 0 to {}", n - 1)
            })),
        }
    }
}

/// Options of writers: [`Encoding`], [`Compression`], [`Precision`] and what only the formats of VTK have.
///
/// ```
/// use azimesh_io::{Compression, Mesh, Precision, WriteOptions};
/// # fn main() -> azimesh_io::Result<()> {
/// # let folder = tempfile::tempdir().expect("a folder");
/// # let path = folder.path().join("small.vtu");
/// let options = WriteOptions {
///     compression: Compression::Zlib,
///     precision: Precision::F32,
///     ..WriteOptions::default()
/// };
/// let mesh = Mesh::read("testdata/naca0012.vtu")?;
/// mesh.view().write_with(&path, &options)?;
/// let x = Mesh::read(&path)?.points[7][0];
/// assert_eq!(x, f64::from(mesh.points[7][0] as f32));
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct WriteOptions {
    /// Encoding of numbers.
    pub encoding: Encoding,
    /// Compression of binary data, in formats that have it.
    pub compression: Compression,
    /// Precision of coordinates.
    pub precision: Precision,
    /// True if names of tags are written as string arrays (VTU); some readers refuse them.
    pub tag_names: bool,
    /// Number of pieces that the mesh is cut into, in formats of pieces.
    pub pieces: Option<NonZeroUsize>,
}

impl WriteOptions {
    /// Names of the options that are set but have no effect on files of this format.
    pub fn without_effect(&self, format: &Format) -> Vec<&'static str> {
        let is_set = self.compression != Compression::None;
        let compresses = format.compresses && self.encoding != Encoding::Ascii;
        let dropped = [
            ("encoding", !format.encodings.contains(&self.encoding)),
            ("compression", is_set && !compresses),
            ("tag-names", !self.tag_names && !format.holds.tag_names),
        ];
        let dropped = dropped.into_iter().filter(|(_, is_dropped)| *is_dropped);
        dropped.map(|(option, _)| option).collect()
    }

    /// Refuses coordinates that the wanted precision cannot hold; a note on cells that become flat in it.
    pub(super) fn check_coordinates(&self, mesh: &MeshView) -> Result<Option<Note>> {
        // Other ranks look at what they write.
        if self.precision == Precision::F64 || mesh.by_ranks.is_some() {
            return Ok(None);
        }
        check_in_32_bits(mesh.points, 0)?;
        Ok(flattened(mesh))
    }
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self {
            encoding: Encoding::Raw,
            compression: Compression::None,
            precision: Precision::F64,
            tag_names: true,
            pieces: None,
        }
    }
}

macro_rules! choices {
    ($(#[doc = $doc:literal] $name:ident [$n:literal] { $($value:ident $text:literal $meaning:literal,)* })*) => {$(
        #[doc = $doc]
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name {
            $(#[doc = $meaning] $value,)*
        }

        impl $name {
            /// Each with its name and its meaning.
            pub const ALL: [(&'static str, Self, &'static str); $n] = [$(($text, Self::$value, $meaning)),*];
        }
    )*};
}

choices! {
    /// Encoding of numbers in a file.
    Encoding [3] {
        Raw "raw" "Binary, as in memory",
        Base64 "base64" "Binary in base64 (VTU)",
        Ascii "ascii" "Text",
    }
    /// Compression of binary data.
    Compression [4] {
        None "none" "None",
        Zlib "zlib" "zlib",
        Lz4 "lz4" "LZ4 blocks",
        Lzma "lzma" "LZMA in xz containers",
    }
    /// Precision of coordinates.
    Precision [2] {
        F64 "f64" "64 bits",
        F32 "f32" "32 bits",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::by_name;

    #[test]
    fn options_that_a_format_has_no_use_for_are_known() {
        let all = WriteOptions {
            pieces: None,
            encoding: Encoding::Base64,
            compression: Compression::Zlib,
            precision: Precision::F64,
            tag_names: false,
        };
        let ascii = WriteOptions {
            encoding: Encoding::Ascii,
            ..all.clone()
        };
        for (name, of_all, of_ascii) in [
            ("vtu", vec![], vec!["compression"]),
            ("pvtu", vec![], vec!["compression"]),
            ("vtk", vec!["encoding", "compression"], vec!["compression"]),
            (
                "vtkhdf",
                vec!["encoding", "compression"],
                vec!["encoding", "compression"],
            ),
            (
                "msh",
                vec!["encoding", "compression", "tag-names"],
                vec!["compression", "tag-names"],
            ),
            (
                "ugrid-b8",
                vec!["encoding", "compression", "tag-names"],
                vec!["encoding", "compression", "tag-names"],
            ),
        ] {
            let format = by_name(name).expect("it is a format");
            assert_eq!(all.without_effect(format), of_all, "{name}");
            assert_eq!(ascii.without_effect(format), of_ascii, "{name}");
            let usual = WriteOptions::default().without_effect(format);
            assert!(usual.is_empty(), "{name}: {usual:?}");
        }
    }
}

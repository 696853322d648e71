//! UGRID, the format of AFLR3, FUN3D and others: solid cells, and boundary faces with numbers.
//!
//! A flavour for each way of storing the same numbers: text, C binary and Fortran records, in
//! either byte order and several widths. Names and boundary conditions of the face numbers are in
//! a companion file `.mapbc`, as FUN3D has it.
//!
//! ```
//! use azimesh_io::Mesh;
//! # fn main() -> azimesh_io::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let path = folder.path().join("mixed.b8.ugrid");
//!
//! // `mixed_cells.mapbc` is read too: `1 4000 floor`, `2 5000 roof`, `3 6662 sides`.
//! let mesh = Mesh::read("testdata/mixed_cells.lb4.ugrid")?;
//! let floor = mesh.tags().next().expect("a tag");
//! assert_eq!((floor.number, floor.name.as_str()), (Some(1), "floor"));
//! assert_eq!(floor.condition.as_deref(), Some("BCWallViscous"));
//!
//! // The ending gives the variant: big-endian, 64-bit coordinates.
//! mesh.write(&path)?;
//! assert!(path.with_file_name("mixed.mapbc").exists());
//! # Ok(())
//! # }
//! ```

mod binary;
mod conditions;
mod faces;
mod fits;
mod fortran;
mod layout;
mod mapbc;
mod read;
mod slabs;
mod text;
mod write;

use super::slabs::opened;
use super::{Encoding, Format, Precision};
use crate::mesh::MeshView;
use layout::Layout;
pub(super) use layout::in_order;
use std::path::{Path, PathBuf};

/// One way of storing a UGRID file.
struct Ugrid {
    name: &'static str,
    layout: Layout,
}

macro_rules! flavours {
    ($($id:ident $name:literal $title:literal [$($extension:literal),*] $layout:expr;)*) => {
        $(
            #[doc = $title]
            pub static $id: Format = {
                const FLAVOUR: &Ugrid = &Ugrid { name: $name, layout: $layout };
                Format {
                    name: $name,
                    title: $title,
                    extensions: &[$($extension),*],
                    // There is no magic number: the counts at the start must fit the whole length.
                    detect: |source| FLAVOUR.layout.fits(source.bytes()),
                    read: |source, _, notes| {
                        let patches = mapbc::companion(&case(source.path()), notes)?;
                        read::read(source.bytes(), FLAVOUR, &patches, notes)
                    },
                    slabs: Some(|source, _| opened(slabs::open(source, FLAVOUR))),
                    write: Some(|mesh, out, options| {
                        write::write(mesh, out, &FLAVOUR.layout, options)
                    }),
                    takes_cells_apart: |mesh| write::takes_cells_apart(mesh, &FLAVOUR.layout),
                    ..FLAVOUR.layout.format()
                }
            };
        )*
        /// Every way of storing a UGRID file.
        static ALL: &[Ugrid] = &[$(Ugrid { name: $name, layout: $layout }),*];
    };
}

flavours! {
    TEXT "ugrid" "UGRID (.ugrid, text)" ["ugrid"] Layout::Text;
    B8 "ugrid-b8" "UGRID (.b8.ugrid)" ["b8.ugrid"] Layout::c_binary(true, 8, 4);
    LB8 "ugrid-lb8" "UGRID (.lb8.ugrid)" ["lb8.ugrid"] Layout::c_binary(false, 8, 4);
    B4 "ugrid-b4" "UGRID (.b4.ugrid)" ["b4.ugrid"] Layout::c_binary(true, 4, 4);
    LB4 "ugrid-lb4" "UGRID (.lb4.ugrid)" ["lb4.ugrid"] Layout::c_binary(false, 4, 4);
    R8 "ugrid-r8" "UGRID (.r8.ugrid)" ["r8.ugrid"] Layout::fortran(true, 8);
    LR8 "ugrid-lr8" "UGRID (.lr8.ugrid)" ["lr8.ugrid"] Layout::fortran(false, 8);
    R4 "ugrid-r4" "UGRID (.r4.ugrid)" ["r4.ugrid"] Layout::fortran(true, 4);
    LR4 "ugrid-lr4" "UGRID (.lr4.ugrid)" ["lr4.ugrid"] Layout::fortran(false, 4);
    B8L "ugrid-b8l" "UGRID (.b8l.ugrid)" ["b8l.ugrid", "b8.ugrid64"] Layout::c_binary(true, 8, 8);
    LB8L "ugrid-lb8l" "UGRID (.lb8l.ugrid)" ["lb8l.ugrid", "lb8.ugrid64"]
        Layout::c_binary(false, 8, 8);
}

impl Layout {
    /// What depends on the widths of numbers.
    const fn format(&self) -> Format {
        let (encodings, is_single, is_plain): (&[Encoding], _, _) = match self {
            Self::Text => (Format::NEW.encodings, false, false),
            Self::Binary(binary) => (
                &[Encoding::Raw],
                binary.real == 4,
                !binary.has_records && binary.real == 8,
            ),
        };
        Format {
            encodings,
            precisions: if is_single {
                &[Precision::F32]
            } else {
                &[Precision::F64]
            },
            takes_numbers_apart: if is_plain { |_| true } else { |_| false },
            companions,
            ..Format::NEW
        }
    }
}

fn companions(mesh: &MeshView, path: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let file = mapbc::path(&case(path));
    // One that is there already would name the tags of this mesh.
    if mesh.dimension() != 3 || !(mapbc::is_needed(mesh) || file.exists()) {
        return Vec::new();
    }
    vec![(file, mapbc::content(mesh).into_bytes())]
}

impl Ugrid {
    /// The flavour whose counts fit these bytes, for a sentence about a file under a wrong name.
    fn that_fits(bytes: &[u8]) -> Option<&'static str> {
        let fitting = ALL.iter().find(|flavour| flavour.layout.fits(bytes));
        fitting.map(|flavour| flavour.name)
    }
}

/// The path without its endings: what the files of a case share.
fn case(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(super::case_name(&name))
}

#[cfg(test)]
mod tests;

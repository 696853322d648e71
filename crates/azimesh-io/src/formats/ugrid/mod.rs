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

mod faces;
mod fortran;
mod layout;
mod mapbc;
mod read;
mod write;

use super::slabs::opened;
use super::{Encoding, Format, Precision};
pub(super) use layout::in_order;
use layout::{Layout, binary, fits};
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
                    detect: |source| fits(&FLAVOUR.layout, source.bytes()),
                    read: |source, _, notes| read::read(source, FLAVOUR, notes),
                    slabs: Some(|source, _| opened(read::open(source, FLAVOUR))),
                    write: Some(|mesh, out, options| {
                        write::write(mesh, out, &FLAVOUR.layout, options)
                    }),
                    takes_cells_apart: |mesh| write::takes_cells_apart(mesh, &FLAVOUR.layout),
                    ..of_layout(&FLAVOUR.layout)
                }
            };
        )*
        /// Every way of storing a UGRID file.
        static ALL: &[Ugrid] = &[$(Ugrid { name: $name, layout: $layout }),*];
    };
}

flavours! {
    TEXT "ugrid" "UGRID (.ugrid, text)" ["ugrid"] None;
    B8 "ugrid-b8" "UGRID (.b8.ugrid)" ["b8.ugrid"] binary(true, 8, 4, false);
    LB8 "ugrid-lb8" "UGRID (.lb8.ugrid)" ["lb8.ugrid"] binary(false, 8, 4, false);
    B4 "ugrid-b4" "UGRID (.b4.ugrid)" ["b4.ugrid"] binary(true, 4, 4, false);
    LB4 "ugrid-lb4" "UGRID (.lb4.ugrid)" ["lb4.ugrid"] binary(false, 4, 4, false);
    R8 "ugrid-r8" "UGRID (.r8.ugrid)" ["r8.ugrid"] binary(true, 8, 4, true);
    LR8 "ugrid-lr8" "UGRID (.lr8.ugrid)" ["lr8.ugrid"] binary(false, 8, 4, true);
    R4 "ugrid-r4" "UGRID (.r4.ugrid)" ["r4.ugrid"] binary(true, 4, 4, true);
    LR4 "ugrid-lr4" "UGRID (.lr4.ugrid)" ["lr4.ugrid"] binary(false, 4, 4, true);
    B8L "ugrid-b8l" "UGRID (.b8l.ugrid)" ["b8l.ugrid", "b8.ugrid64"] binary(true, 8, 8, false);
    LB8L "ugrid-lb8l" "UGRID (.lb8l.ugrid)" ["lb8l.ugrid", "lb8.ugrid64"]
        binary(false, 8, 8, false);
}

/// Constants and functions that depend on the widths of numbers.
const fn of_layout(layout: &Layout) -> Format {
    let text = Format {
        companions: mapbc::companions,
        ..Format::NEW
    };
    let Some(binary) = layout else {
        return text;
    };
    let is_plain = !binary.has_records && binary.real == 8;
    let precisions = [&[Precision::F32], &[Precision::F64]];
    Format {
        encodings: &[Encoding::Raw],
        precisions: precisions[(binary.real == 8) as usize],
        takes_numbers_apart: if is_plain { |_| true } else { |_| false },
        ..text
    }
}

impl Ugrid {
    /// Another flavour, whose counts fit these bytes, for a sentence about a file under a wrong name.
    fn other(&self, bytes: &[u8]) -> Option<&'static str> {
        let fitting = ALL.iter().find(|flavour| fits(&flavour.layout, bytes))?;
        (fitting.name != self.name).then_some(fitting.name)
    }
}

/// The path without its endings: what the files of a case share.
fn case(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(super::case_name(&name))
}

#[cfg(test)]
mod tests;

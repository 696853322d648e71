//! Plot3D grids (.xyz, .p3d, .p3dfmt, .x, .fmt): blocks of structured nodes, as text or binary. Read only.
//!
//! Nothing in a Plot3D file says how it is stored. The counts at its start have to fit its whole length in one way only;
//! where several do, the flavours of the format say which. A neutral map file of the same name names the boundaries.
//!
//! ```
//! use azimesh_io::{CellKind, Mesh};
//! # fn main() -> azimesh_io::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let path = folder.path().join("block.xyz");
//!
//! // One block of 2 by 2 by 2 nodes: all x, all y, all z.
//! let text = "2 2 2
//!     0 1 0 1 0 1 0 1
//!     0 0 1 1 0 0 1 1
//!     0 0 0 0 1 1 1 1";
//! std::fs::write(&path, text).expect("a file");
//!
//! let mesh = Mesh::read(&path)?;
//! assert_eq!(mesh.points[1], [1.0, 0.0, 0.0]);
//! assert_eq!(mesh.cells.get(0).kind, CellKind::Hexahedron);
//! // Each side of the block is a tag.
//! let tags: Vec<_> = mesh.tags().map(|tag| tag.name.as_str()).collect();
//! assert_eq!(tags, ["imin", "imax", "jmin", "jmax", "kmin", "kmax"]);
//! # Ok(())
//! # }
//! ```
//!
//! Parts of the module:
//!
//! ```text
//! layout     what the files do not say: text or binary, byte order, widths, blanking; which of these fit a file
//! records    binary files, with and without the record marks of Fortran
//! text       files of text
//! blocks     blocks -> cells, faces of their sides
//! neutral    neutral map files (.nmf): boundary faces and their types
//! read       order of the work
//! ```

mod blocks;
mod layout;
mod neutral;
mod read;
mod records;
mod text;

use super::{Format, Source, without_compression};
use layout::Layout;

/// Endings of names.
const EXTENSIONS: &[&str] = &["p3d", "xyz", "p3dfmt", "p2dfmt", "x", "fmt", "xfmt", "grd"];

/// Plot3D, with what is stated of the file.
struct Plot3d {
    name: &'static str,
    /// Returns whether a layout is what is stated.
    allows: fn(&Layout) -> bool,
}

macro_rules! flavours {
    ($($id:ident $name:literal $title:literal $allows:expr;)*) => {
        $(
            #[doc = $title]
            pub static $id: Format = {
                const STATED: &Plot3d = &Plot3d { name: $name, allows: $allows };
                Format {
                    name: $name,
                    title: $title,
                    read: |source, _, notes| read::read(source, STATED, notes),
                    ..if matches!($name.as_bytes(), b"plot3d") { DETECTED } else { Format::NEW }
                }
            };
        )*
        static ALL: &[Plot3d] = &[$(Plot3d { name: $name, allows: $allows }),*];
    };
}

flavours! {
    ANY "plot3d" "Plot3D grid (.p3d)" |_| true;
    SINGLE "plot3d-single" "Plot3D grid of one block, without its number" |layout| !layout.is_multi;
    MULTI "plot3d-multi" "Plot3D grid of several blocks" |layout| layout.is_multi;
    PLANE "plot3d-2d" "Plot3D grid in a plane" |layout| layout.n_axes == 2;
    SOLID "plot3d-3d" "Plot3D grid in space" |layout| layout.n_axes == 3;
    BLANKED "plot3d-iblank" "Plot3D grid with blanking" |layout| layout.has_blanking;
    PLAIN "plot3d-no-iblank" "Plot3D grid without blanking" |layout| !layout.has_blanking;
    F32 "plot3d-f32" "Plot3D grid of 32 bits" |layout| layout.real() == Some(4);
    F64 "plot3d-f64" "Plot3D grid of 64 bits" |layout| layout.real() == Some(8);
}

/// The flavour without any statement.
const DETECTED: Format = Format {
    extensions: EXTENSIONS,
    detect: is_grid,
    ..Format::NEW
};

/// Returns whether the counts at the start fit the whole file. Text is read only if its file name is usual for a grid.
fn is_grid(source: &Source) -> bool {
    let name = source.path().to_string_lossy().to_ascii_lowercase();
    let is_named = || {
        let name = without_compression(&name);
        let ending = name.rsplit_once('.').map(|(_, ending)| ending);
        ending.is_some_and(|ending| EXTENSIONS.contains(&ending))
    };
    let bytes = source.bytes();
    if read::is_text(bytes) {
        return is_named() && !text::fits(bytes).0.is_empty();
    }
    records::recognizes(bytes)
}

impl Plot3d {
    /// The flavours that one of two layouts is of and the other is not.
    fn that_tell(one: &Layout, other: &Layout) -> Option<[&'static str; 2]> {
        let only = |this: &Layout, that: &Layout| {
            let is_only = |of: &&Plot3d| (of.allows)(this) && !(of.allows)(that);
            ALL.iter().find(is_only).map(|flavour| flavour.name)
        };
        Some([only(one, other)?, only(other, one)?])
    }
}

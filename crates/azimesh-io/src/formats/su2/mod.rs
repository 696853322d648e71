//! SU2 meshes: plane or solid, one zone or several, boundary tags as markers.
//!
//! Linear cells have VTK's node order; curved cells, of the discontinuous Galerkin solver, are put into it. Text that
//! only SU2 understands is kept unchanged in field arrays, one text for each zone.
//!
//! ```
//! use azimesh_io::Mesh;
//! # fn main() -> azimesh_io::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let path = folder.path().join("airfoil.su2");
//!
//! let mesh = Mesh::read("testdata/naca0012.vtu")?;
//! mesh.write(&path)?;
//!
//! let text = std::fs::read_to_string(&path).expect("the file that was written");
//! let markers: Vec<_> = text.lines().filter(|line| line.starts_with("MARKER_TAG")).collect();
//! assert_eq!(markers, ["MARKER_TAG= airfoil", "MARKER_TAG= farfield"]);
//! assert_eq!(Mesh::read(&path)?.cells, mesh.cells);
//! # Ok(())
//! # }
//! ```

mod degree;
mod parts;
mod read;
mod write;
mod zone;

pub use write::{n_zones, write_surface};

use super::Format;
use crate::mesh::{CellKind, MeshView, Values};

/// SU2 mesh (.su2).
pub static SU2: Format = Format {
    name: "su2",
    title: "SU2 mesh (.su2)",
    extensions: &["su2"],
    detect: |source| read::recognizes(source.bytes()),
    read: |source, _, notes| read::read(source.bytes(), notes),
    write: Some(|mesh, out, options| write::write(mesh, out, options)),
    ..Format::NEW
};

/// The boundary of partitioned and periodic meshes that exchanges nodes.
const EXCHANGE: &str = "SEND_RECEIVE";
/// Field array with the centres and angles of periodic markers.
pub const PERIODIC: &str = "su2:PERIODIC";
/// Field array with the boxes for free-form deformation.
pub const BOXES: &str = "su2:FFD";
/// Field array with the numbers of exchanged nodes.
pub const EXCHANGED: &str = "su2:SEND_RECEIVE";
/// Field array of the second number of `NPOIN=`: the nodes that are no copies of others.
pub const OWN_NODES: &str = "su2:NPOIN";

/// A kind of text that is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Extra {
    /// Offsets of the angles of attack and sideslip.
    Offset,
    /// Markers `SEND_RECEIVE`: nodes that are exchanged, and how.
    Exchange,
    /// Transformations between periodic boundaries.
    Periodic,
    /// Boxes for free-form deformation.
    Boxes,
}

impl Extra {
    /// Every kind, in the order in which they are written.
    const ALL: [Self; 4] = [Self::Offset, Self::Exchange, Self::Periodic, Self::Boxes];

    fn array(self) -> &'static str {
        ["su2:OFFSET", EXCHANGED, PERIODIC, BOXES][self as usize]
    }

    /// The kind of text that a keyword with this name belongs to.
    fn of(keyword: &[u8]) -> Option<Self> {
        match keyword {
            b"AOA_OFFSET" | b"AOS_OFFSET" => Some(Self::Offset),
            b"NPERIODIC" => Some(Self::Periodic),
            _ if keyword.starts_with(b"SEND_") => Some(Self::Exchange),
            _ if keyword.starts_with(b"PERIODIC_") => Some(Self::Periodic),
            _ if keyword.starts_with(b"FFD_") => Some(Self::Boxes),
            _ => None,
        }
    }

    /// The text of each zone, where there is one for each of `n_zones`.
    fn texts<'a>(self, mesh: &MeshView<'a>, n_zones: usize) -> Option<&'a [String]> {
        match &mesh.field_array(self.array())?.values {
            Values::Text(texts) if texts.len() == n_zones => Some(texts),
            _ => None,
        }
    }
}

/// Returns true for kinds of cells of SU2, which numbers them as VTK does.
fn holds(kind: CellKind) -> bool {
    use CellKind::*;
    matches!(
        kind,
        Vertex | Line | Triangle | Quadrilateral | Tetrahedron | Hexahedron | Wedge | Pyramid
    )
}

#[cfg(test)]
mod tests;

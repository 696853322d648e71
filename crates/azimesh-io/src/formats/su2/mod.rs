//! SU2 meshes: plane or solid, one zone or several, boundary tags as markers.
//!
//! Linear cells have VTK's node order; curved ones, of the discontinuous Galerkin solver, are put
//! into it. Text that only SU2 understands is kept unchanged.
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
mod extra;
mod keyword;
mod parts;
mod read;
mod surface;
mod write;
mod zone;

pub use extra::{BOXES, PERIODIC};
pub use surface::{n_zones, write_surface};

use super::Format;
use crate::mesh::CellKind;

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

/// Whether SU2 has cells of this kind; it numbers them as VTK does.
fn holds(kind: CellKind) -> bool {
    use CellKind::*;
    matches!(
        kind,
        Vertex | Line | Triangle | Quadrilateral | Tetrahedron | Hexahedron | Wedge | Pyramid
    )
}

#[cfg(test)]
mod tests;

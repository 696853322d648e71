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

use super::{Format, Notes, ReadOptions, Source, WriteOptions};
use crate::formats::Out;
use crate::mesh::{CellKind, Mesh, MeshView};
use azimesh_core::error::Result;

/// SU2 mesh (.su2).
pub struct Su2;

impl Format for Su2 {
    fn name(&self) -> &'static str {
        "su2"
    }
    fn title(&self) -> &'static str {
        "SU2 mesh (.su2)"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["su2"]
    }
    fn recognizes_start(&self, head: &[u8]) -> bool {
        read::recognizes(head)
    }
    fn read_file(
        &self,
        source: &Source,
        _options: &ReadOptions,
        notes: &mut Notes,
    ) -> Result<Mesh> {
        read::read(source.bytes(), notes)
    }
    fn write_file(
        &self,
        mesh: &MeshView,
        out: &mut dyn Out,
        options: &WriteOptions,
    ) -> Result<Notes> {
        write::write(mesh, out, options)
    }
}

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

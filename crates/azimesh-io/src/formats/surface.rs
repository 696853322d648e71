//! What formats that hold surfaces alone are given of a mesh, and what is told of the rest.

use super::Notes;
use crate::mesh::{Mesh, MeshView};
use azimesh_core::diagnostic::formats::Written;

/// Which outer faces of a solid mesh are its surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OuterFaces {
    /// All of them.
    All,
    /// Those that are boundary cells of the mesh.
    Listed,
}

/// The surface of a mesh, and notes on what of the mesh is not in it.
pub(super) fn surface_of(
    mesh: &MeshView,
    format: &'static str,
    outer: OuterFaces,
) -> (Mesh, Notes) {
    let skin = mesh.skin();
    let mut notes = Notes::default();
    if skin.n_solid > 0 {
        notes.push(Written::BoundaryAlone {
            format,
            n: skin.n_solid,
        });
    }
    if skin.n_lower > 0 {
        notes.push(Written::LowerCellsLeftOut { n: skin.n_lower });
    }
    if skin.n_bare > 0 {
        let n = skin.n_bare;
        notes.push(match outer {
            OuterFaces::All => Written::BareFaces { n },
            OuterFaces::Listed => Written::BareFacesLeftOut { n },
        });
    }
    if skin.n_curved > 0 {
        notes.push(Written::CornersAlone { n: skin.n_curved });
    }
    let surface = match outer {
        OuterFaces::All => skin.mesh,
        OuterFaces::Listed => skin.without_bare(),
    };
    (surface, notes)
}

//! The positive side of plane cells.

use azimesh_core::geometry::vector::Vector;

/// Positive side of a two-dimensional cell.
#[derive(Debug, Clone)]
pub(super) enum Facing {
    /// Toward +z, for all cells.
    Z,
    /// Toward a normal of each cell.
    Normals(Vec<[f32; 3]>),
}

impl Facing {
    #[inline]
    pub(super) fn of(&self, cell: usize) -> Vector {
        match self {
            Facing::Z => [0.0, 0.0, 1.0],
            Facing::Normals(normals) => normals[cell].map(f64::from),
        }
    }
}

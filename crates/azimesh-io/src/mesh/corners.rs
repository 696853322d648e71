//! The corners of straight cells, with the ends of the edges that leave them.

use super::CellKind;

/// Each corner of a wedge with the ends of its edges in the order of a positive Jacobian.
pub const WEDGE: [[u8; 4]; 6] = [
    [0, 1, 2, 3],
    [1, 2, 0, 4],
    [2, 0, 1, 5],
    [3, 5, 4, 0],
    [4, 3, 5, 1],
    [5, 4, 3, 2],
];

/// Each corner of a hexahedron with the ends of its edges in the order of a positive Jacobian.
pub const HEXAHEDRON: [[u8; 4]; 8] = [
    [0, 1, 3, 4],
    [1, 2, 0, 5],
    [2, 3, 1, 6],
    [3, 0, 2, 7],
    [4, 7, 5, 0],
    [5, 4, 6, 1],
    [6, 5, 7, 2],
    [7, 6, 4, 3],
];

/// The same for the corners that decide whether a cell of this kind is valid: the first corner of a triangle or
/// tetrahedron, the base corners of a pyramid. In a plane the last entry repeats the corner. Empty for kinds whose number of
/// corners varies.
pub fn of(kind: CellKind) -> &'static [[u8; 4]] {
    match kind {
        CellKind::Triangle => &[[0, 1, 2, 0]],
        CellKind::Quadrilateral => &[[0, 1, 3, 0], [1, 2, 0, 1], [2, 3, 1, 2], [3, 0, 2, 3]],
        CellKind::Tetrahedron => &[[0, 1, 2, 3]],
        CellKind::Pyramid => &[[0, 1, 3, 4], [1, 2, 0, 4], [2, 3, 1, 4], [3, 0, 2, 4]],
        CellKind::Wedge => &WEDGE,
        CellKind::Hexahedron => &HEXAHEDRON,
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_of_a_corner_share_an_edge_with_it() {
        for kind in [
            CellKind::Triangle,
            CellKind::Quadrilateral,
            CellKind::Tetrahedron,
            CellKind::Pyramid,
            CellKind::Wedge,
            CellKind::Hexahedron,
        ] {
            assert!(!of(kind).is_empty());
            for [corner, ends @ ..] in of(kind) {
                for end in ends.iter().filter(|end| *end != corner) {
                    let are = |edge: &&[u8; 2]| edge.contains(corner) && edge.contains(end);
                    assert!(kind.edges().iter().any(|edge| are(&edge)), "{kind:?}");
                }
            }
        }
    }
}

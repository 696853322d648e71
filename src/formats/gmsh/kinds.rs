//! Gmsh's element types and their node order against VTK's.

use crate::mesh::CellKind::{self, *};

/// Gmsh's number and VTK's kind of every element that is read and written.
const TYPES: [(i32, CellKind); 18] = [
    (1, Line),
    (2, Triangle),
    (3, Quadrilateral),
    (4, Tetrahedron),
    (5, Hexahedron),
    (6, Wedge),
    (7, Pyramid),
    (8, Line3),
    (9, Triangle6),
    (10, Quadrilateral9),
    (11, Tetrahedron10),
    (12, Hexahedron27),
    (13, Wedge18),
    (15, Vertex),
    (16, Quadrilateral8),
    (17, Hexahedron20),
    (18, Wedge15),
    (19, Pyramid13),
];

/// The kind of Gmsh's element type, or a sentence that refuses it.
pub(super) fn kind(number: i64) -> Result<CellKind, String> {
    let known = TYPES.iter().find(|(of, _)| i64::from(*of) == number);
    known.map(|(_, kind)| *kind).ok_or_else(|| {
        let what = match number {
            14 => "a pyramid with 14 nodes",
            20..=33 | 36..=65 | 71..=132 => "an element of third or higher order",
            _ => "none that azimesh reads",
        };
        format!(
            "element type {number} is {what}; points, first-order and second-order elements are read"
        )
    })
}

/// Gmsh's number for a kind; `None` for polygons and polyhedra.
pub(super) fn number(kind: CellKind) -> Option<i32> {
    let known = TYPES.iter().find(|(_, of)| *of == kind);
    known.map(|(number, _)| *number)
}

/// Where VTK's nodes are among Gmsh's: node `i` of VTK is node `order[i]` of Gmsh. `None` where
/// both count alike.
pub(super) fn order(kind: CellKind) -> Option<&'static [usize]> {
    Some(match kind {
        Tetrahedron10 => &[0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
        Hexahedron20 => &[
            0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15,
        ],
        Hexahedron27 => &[
            0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24,
            20, 25, 26,
        ],
        Wedge15 => &[0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11],
        Wedge18 => &[0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16],
        Pyramid13 => &[0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12],
        _ => return None,
    })
}

/// Puts the nodes of one cell from Gmsh's order into VTK's.
pub(super) fn to_vtk(order: &[usize], nodes: &mut [u32]) {
    let mut gmsh = [0; 27];
    gmsh[..nodes.len()].copy_from_slice(nodes);
    for (node, &from) in nodes.iter_mut().zip(order) {
        *node = gmsh[from];
    }
}

/// Node tags, from 1, of one cell in Gmsh's order.
pub(super) fn to_gmsh(order: Option<&[usize]>, cell: &[u32], tags: &mut [u64]) {
    for (i, node) in cell.iter().enumerate() {
        tags[order.map_or(i, |order| order[i])] = u64::from(*node) + 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edges in the order of their middle nodes, as Gmsh's manual draws them.
    fn gmsh_edges(kind: CellKind) -> &'static [[u8; 2]] {
        match kind.linear() {
            Tetrahedron => &[[0, 1], [1, 2], [2, 0], [3, 0], [2, 3], [1, 3]],
            Hexahedron => &[
                [0, 1],
                [0, 3],
                [0, 4],
                [1, 2],
                [1, 5],
                [2, 3],
                [2, 6],
                [3, 7],
                [4, 5],
                [4, 7],
                [5, 6],
                [6, 7],
            ],
            Wedge => &[
                [0, 1],
                [0, 2],
                [0, 3],
                [1, 2],
                [1, 4],
                [2, 5],
                [3, 4],
                [3, 5],
                [4, 5],
            ],
            Pyramid => &[
                [0, 1],
                [0, 3],
                [0, 4],
                [1, 2],
                [1, 4],
                [2, 3],
                [2, 4],
                [3, 4],
            ],
            _ => &[],
        }
    }

    #[test]
    fn middle_nodes_go_to_the_same_edge() {
        for kind in CellKind::ALL {
            let Some(order) = order(kind) else { continue };
            let n_corners = kind.linear().n_nodes().expect("no polygon is ordered");
            for (i, edge) in kind.edges().iter().enumerate() {
                let from = gmsh_edges(kind)[order[n_corners + i] - n_corners];
                let same = from == *edge || from == [edge[1], edge[0]];
                assert!(same, "{kind:?} edge {i}");
            }
        }
    }

    #[test]
    fn there_and_back_is_the_same_order() {
        for kind in CellKind::ALL {
            let Some(order) = order(kind) else { continue };
            let nodes: Vec<u32> = (100..).take(order.len()).collect();
            let mut tags = vec![0; order.len()];
            to_gmsh(Some(order), &nodes, &mut tags);
            let mut back: Vec<u32> = tags.iter().map(|tag| *tag as u32 - 1).collect();
            to_vtk(order, &mut back);
            assert_eq!(back, nodes, "{kind:?}");
        }
    }

    #[test]
    fn what_is_not_read_is_named() {
        let sentence = kind(29).expect_err("third order");
        assert!(sentence.contains("third or higher order"), "{sentence}");
        assert!(kind(14).is_err() && kind(-1).is_err() && kind(0).is_err());
    }
}

//! Gmsh's element types and their node order against VTK's.

use super::lattice::lattice;
use crate::mesh::CellKind::{self, *};
use crate::mesh::lagrange;
use std::sync::OnceLock;

/// Gmsh's number and the kind of elements with a fixed number of nodes.
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

/// Gmsh's numbers of complete elements, from first order on.
const ORDERS: [(CellKind, &[i32]); 7] = [
    (LagrangeCurve, &[1, 8, 26, 27, 28, 62, 63, 64, 65, 66]),
    (LagrangeTriangle, &[2, 9, 21, 23, 25, 42, 43, 44, 45, 46]),
    (
        LagrangeQuadrilateral,
        &[3, 10, 36, 37, 38, 47, 48, 49, 50, 51],
    ),
    (
        LagrangeTetrahedron,
        &[4, 11, 29, 30, 31, 71, 72, 73, 74, 75],
    ),
    (LagrangeHexahedron, &[5, 12, 92, 93, 94, 95, 96, 97, 98]),
    (LagrangeWedge, &[6, 13, 90, 91, 106, 107, 108, 109, 110]),
    (LagrangePyramid, &[7, 14, 118, 119, 120, 121, 122, 123, 124]),
];

/// An element type.
#[derive(Debug)]
pub(super) struct Type {
    /// The kind of cell.
    pub kind: CellKind,
    /// Nodes of an element.
    pub n_nodes: usize,
    /// For each of Gmsh's nodes its place among VTK's; empty where both count alike.
    to_vtk: Vec<u16>,
}

impl Type {
    fn new(kind: CellKind, n_nodes: usize) -> Self {
        let from: Vec<usize> = match (order(kind), lagrange::order(kind, n_nodes)) {
            (Some(order), _) => order.to_vec(),
            (None, Some(order)) => {
                let gmsh = lattice(kind, order as u16);
                lagrange::permutation(&lagrange::lattice(kind, order), &gmsh)
                    .expect("both have the same places")
            }
            (None, None) => Vec::new(),
        };
        let mut to_vtk = vec![0; from.len()];
        for (vtk, &gmsh) in from.iter().enumerate() {
            to_vtk[gmsh] = vtk as u16;
        }
        if to_vtk.iter().zip(0..).all(|(to, i)| *to == i) {
            to_vtk.clear();
        }
        Self {
            kind,
            n_nodes,
            to_vtk,
        }
    }

    /// The place among VTK's nodes of Gmsh's node `i`.
    #[inline]
    pub fn vtk(&self, i: usize) -> usize {
        match &self.to_vtk[..] {
            [] => i,
            to => to[i].into(),
        }
    }
}

/// The element type with this number, or a sentence that refuses it.
pub(super) fn element_type(number: i64) -> Result<&'static Type, String> {
    static KNOWN: [OnceLock<Option<Type>>; 128] = [const { OnceLock::new() }; 128];
    let known = usize::try_from(number).ok().and_then(|i| KNOWN.get(i));
    let found = known.and_then(|cell| cell.get_or_init(|| make(number)).as_ref());
    found.ok_or_else(|| refused(number))
}

fn make(number: i64) -> Option<Type> {
    let is = |of: &i32| i64::from(*of) == number;
    if let Some((_, kind)) = TYPES.iter().find(|(of, _)| is(of)) {
        return Some(Type::new(*kind, kind.n_nodes()?));
    }
    ORDERS.iter().find_map(|(kind, numbers)| {
        let order = numbers.iter().position(is)? + 1;
        Some(Type::new(*kind, lagrange::n_nodes(*kind, order)?))
    })
}

fn refused(number: i64) -> String {
    let incomplete = "an incomplete (serendipity) element of third or higher order, which lacks nodes \
                      inside; mesh with Mesh.SecondOrderIncomplete = 0 for complete ones";
    let what = match number {
        20 | 22 | 24 | 32 | 33 | 39..=41 | 52..=61 | 79..=83 | 99..=105 | 111..=117 | 125..=131 => {
            incomplete
        }
        34 | 35 => "a polygon or polyhedron that Gmsh makes by cutting elements with a level set",
        67..=70 => "the border between cut elements",
        84..=89 | 132 => "an element of order zero, which has no corners",
        133..=136 => "a part of another element, cut by a level set",
        137..=140 => "an element with bubble or enriched nodes",
        _ => "unknown",
    };
    format!(
        "element type {number} is {what}; points, complete elements of any order, and incomplete ones \
         of second order are read"
    )
}

/// Gmsh's number for elements of this kind with `n_nodes`; `None` where it has none.
pub(super) fn number(kind: CellKind, n_nodes: usize) -> Option<i32> {
    if kind == CubicLine {
        return number(LagrangeCurve, n_nodes);
    }
    if let Some((number, _)) = TYPES.iter().find(|(_, of)| *of == kind) {
        return Some(*number);
    }
    let (_, numbers) = ORDERS.iter().find(|(of, _)| *of == kind)?;
    let order = lagrange::order(kind, n_nodes)?;
    numbers.get(order - 1).copied()
}

/// The type that cells of this kind with `n_nodes` are written as.
pub(super) fn written_type(kind: CellKind, n_nodes: usize) -> Option<(i32, Type)> {
    Some((number(kind, n_nodes)?, Type::new(kind, n_nodes)))
}

/// Where VTK's nodes are among Gmsh's, for kinds of second order: node `i` of VTK is node `order[i]`
/// of Gmsh. `None` where both count alike.
fn order(kind: CellKind) -> Option<&'static [usize]> {
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
    fn every_element_goes_to_its_kind_and_back() {
        for number in 0..200 {
            let Ok(of) = element_type(number) else {
                continue;
            };
            let back = super::number(of.kind, of.n_nodes);
            assert_eq!(back.map(i64::from), Some(number));
            let mut places: Vec<usize> = (0..of.n_nodes).map(|i| of.vtk(i)).collect();
            places.sort_unstable();
            assert!(places.into_iter().eq(0..of.n_nodes), "{number}");
        }
        assert_eq!(number(CubicLine, 4), Some(26));
        assert_eq!(number(LagrangePyramid, 14), Some(14));
        assert_eq!(number(LagrangeHexahedron, 27), Some(12));
        assert_eq!(number(LagrangeTriangle, 7), None);
        assert_eq!(number(LagrangeCurve, 12), None);
    }

    #[test]
    fn what_is_not_read_is_named() {
        let sentence = element_type(20).expect_err("a triangle with 9 nodes");
        assert!(sentence.contains("serendipity"), "{sentence}");
        for number in [-1, 0, 34, 69, 85, 134, 137, 1000, i64::MAX] {
            assert!(element_type(number).is_err(), "{number}");
        }
    }
}

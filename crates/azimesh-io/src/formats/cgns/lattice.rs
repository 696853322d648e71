//! Node order of complete elements of third and fourth order in CGNS.
//!
//! Nodes are listed as in VTK's Lagrange cells: corners, edges, faces, inside. But where VTK goes along
//! the axes, CGNS goes round: edges and faces are cyclic, the nodes inside a quadrilateral are its
//! rim and then its middle, and the inside of a solid is a pile of layers.

use crate::mesh::CellKind::{self, *};
use crate::mesh::lagrange::{self, LatticePoint, inside_triangle, permutation, shell, shifted};

/// For each node of a Lagrange cell in VTK's order, its position in CGNS's order.
pub(super) fn vtk_from_cgns(kind: CellKind, order: u16) -> Vec<usize> {
    let vtk = lagrange::lattice(kind, order.into());
    permutation(&vtk, &places(kind, order)).expect("both orders list the same places")
}

/// Places in the order of the standard (SIDS, conventions for unstructured elements).
fn places(kind: CellKind, order: u16) -> Vec<LatticePoint> {
    let faces: &[&[usize]] = match kind {
        LagrangeQuadrilateral => &[&[0, 1, 2, 3]],
        LagrangeTetrahedron => &[&[0, 1, 2], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
        LagrangePyramid => &[
            &[0, 1, 2, 3],
            &[0, 1, 4],
            &[1, 2, 4],
            &[2, 3, 4],
            &[3, 0, 4],
        ],
        LagrangeWedge => &[
            &[0, 1, 2],
            &[0, 1, 4, 3],
            &[1, 2, 5, 4],
            &[2, 0, 3, 5],
            &[3, 4, 5],
        ],
        LagrangeHexahedron => &[
            &[0, 1, 2, 3],
            &[0, 1, 5, 4],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[3, 0, 4, 7],
            &[4, 5, 6, 7],
        ],
        _ => return Vec::new(),
    };
    let mut edges = kind.edges().to_vec();
    if matches!(kind, LagrangeWedge | LagrangeHexahedron) {
        // Edges between base and top come before those of the top.
        let n = edges.len() / 3;
        edges[n..].rotate_left(n);
    }
    let (triangle, square) = (&inside_triangle(order)[..], &rounds(order)[..]);
    let mut corners = lagrange::lattice(kind, 1);
    corners.iter_mut().flatten().for_each(|i| *i *= order);
    let inside = |face: &&[usize]| match **face {
        [a, b, c] => ([a, b, c], triangle),
        [a, b, .., d] => ([a, b, d], square),
        _ => unreachable!("a face has three or four corners"),
    };
    let faces: Vec<_> = faces.iter().map(inside).collect();
    let mut places = shell(order, &corners, &edges, &faces);
    let mut layers = |of_layer: &[[u16; 2]]| {
        for k in 1..order {
            places.extend(of_layer.iter().map(|&[i, j]| [i, j, k]));
        }
    };
    match (kind, order) {
        (LagrangeWedge, _) => layers(triangle),
        (LagrangeHexahedron, _) => layers(square),
        (LagrangeTetrahedron, 4) | (LagrangePyramid, 3) => places.push([1; 3]),
        (LagrangePyramid, 4) => places.extend(shifted(lagrange::lattice(kind, 1))),
        _ => {}
    }
    places
}

/// Places inside a quadrilateral of second to fourth order: round the rim, then the middle.
fn rounds(order: u16) -> Vec<[u16; 2]> {
    let far = order - 1;
    let mut places = Vec::new();
    if far > 1 {
        places.extend((1..far).map(|i| [i, 1]));
        places.extend((1..far).map(|i| [far, i]));
        places.extend((1..far).map(|i| [order - i, far]));
        places.extend((1..far).map(|i| [1, order - i]));
    }
    if order.is_multiple_of(2) {
        places.push([order / 2, order / 2]);
    }
    places
}

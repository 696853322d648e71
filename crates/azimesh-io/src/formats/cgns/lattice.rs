//! Node order of complete elements of third and fourth order in CGNS.
//!
//! Nodes are listed as in VTK's Lagrange cells: corners, edges, faces, inside. But where VTK goes along
//! the axes, CGNS goes round: edges and faces are cyclic, the nodes inside a quadrilateral are its
//! rim and then its middle, and the inside of a solid is a pile of layers.

use crate::mesh::CellKind::{self, *};
use crate::mesh::lagrange::{
    self, LatticePoint, inside_edge, inside_face, inside_triangle, permutation,
};

/// For each node of a Lagrange cell in VTK's order, its position in CGNS's order.
pub(super) fn vtk_from_cgns(kind: CellKind, order: u16) -> Vec<usize> {
    let vtk = lagrange::lattice(kind, order.into());
    permutation(&vtk, &places(kind, order)).expect("both orders list the same places")
}

/// Places in the order of the standard (SIDS, conventions for unstructured elements).
fn places(kind: CellKind, order: u16) -> Vec<LatticePoint> {
    let mut walk = Walk {
        order,
        places: corners(kind, order),
    };
    match kind {
        LagrangeQuadrilateral => {
            walk.edges(&[[0, 1], [1, 2], [2, 3], [3, 0]]);
            walk.quadrilaterals(&[[0, 1, 2, 3]]);
        }
        LagrangeTetrahedron => {
            walk.edges(&[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]]);
            walk.triangles(&[[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
            walk.places.extend((order == 4).then_some([1; 3]));
        }
        LagrangePyramid => walk.pyramid(),
        LagrangeWedge => walk.wedge(),
        LagrangeHexahedron => walk.hexahedron(),
        _ => {}
    }
    walk.places
}

fn corners(kind: CellKind, p: u16) -> Vec<LatticePoint> {
    let square = [[0, 0, 0], [p, 0, 0], [p, p, 0], [0, p, 0]];
    let triangle = [[0, 0, 0], [p, 0, 0], [0, p, 0]];
    let raised = |[i, j, _]: LatticePoint| [i, j, p];
    match kind {
        LagrangeQuadrilateral => square.to_vec(),
        LagrangeTetrahedron => [&triangle[..], &[[0, 0, p]]].concat(),
        LagrangePyramid => [&square[..], &[[0, 0, p]]].concat(),
        LagrangeWedge => [triangle, triangle.map(raised)].concat(),
        LagrangeHexahedron => [square, square.map(raised)].concat(),
        _ => Vec::new(),
    }
}

/// A list of places that grows edge by edge and face by face; the corners come first.
struct Walk {
    order: u16,
    places: Vec<LatticePoint>,
}

impl Walk {
    fn edges(&mut self, edges: &[[usize; 2]]) {
        for &[a, b] in edges {
            let (a, b) = (self.places[a], self.places[b]);
            self.places.extend(inside_edge(a, b, self.order));
        }
    }

    fn triangles(&mut self, triangles: &[[usize; 3]]) {
        for triangle in triangles {
            let corners = triangle.map(|i| self.places[i]);
            let inside = inside_triangle(self.order);
            self.places
                .extend(inside_face(corners, self.order, &inside));
        }
    }

    fn quadrilaterals(&mut self, quadrilaterals: &[[usize; 4]]) {
        for &[a, b, _, d] in quadrilaterals {
            let corners = [a, b, d].map(|i| self.places[i]);
            self.places
                .extend(inside_face(corners, self.order, &rounds(self.order)));
        }
    }

    /// Inner nodes of a solid between two faces: layer by layer, each like the faces.
    fn layers(&mut self, of_layer: &[[u16; 2]]) {
        for k in 1..self.order {
            self.places.extend(of_layer.iter().map(|&[i, j]| [i, j, k]));
        }
    }

    fn wedge(&mut self) {
        self.edges(&[[0, 1], [1, 2], [2, 0], [0, 3], [1, 4], [2, 5]]);
        self.edges(&[[3, 4], [4, 5], [5, 3]]);
        self.triangles(&[[0, 1, 2]]);
        self.quadrilaterals(&[[0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]);
        self.triangles(&[[3, 4, 5]]);
        self.layers(&inside_triangle(self.order));
    }

    fn hexahedron(&mut self) {
        self.edges(&[[0, 1], [1, 2], [2, 3], [3, 0]]);
        self.edges(&[[0, 4], [1, 5], [2, 6], [3, 7]]);
        self.edges(&[[4, 5], [5, 6], [6, 7], [7, 4]]);
        self.quadrilaterals(&[[0, 1, 2, 3], [0, 1, 5, 4], [1, 2, 6, 5]]);
        self.quadrilaterals(&[[2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]]);
        self.layers(&rounds(self.order));
    }

    /// The inside is a pyramid three orders lower, one layer above the base.
    fn pyramid(&mut self) {
        self.edges(&[[0, 1], [1, 2], [2, 3], [3, 0]]);
        self.edges(&[[0, 4], [1, 4], [2, 4], [3, 4]]);
        self.quadrilaterals(&[[0, 1, 2, 3]]);
        self.triangles(&[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]);
        match self.order {
            3 => self.places.push([1, 1, 1]),
            4 => {
                let inner = corners(LagrangePyramid, 1);
                self.places
                    .extend(inner.iter().map(|place| place.map(|i| i + 1)));
            }
            _ => {}
        }
    }
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

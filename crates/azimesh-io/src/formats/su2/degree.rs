//! Elements of SU2's discontinuous Galerkin solver: types above 100, with nodes row by row.
//!
//! A type is `VTK's number + 100 (degree - 1)`; one above 10000 has `10000 (degree of the solution
//! + 1)` on top. The nodes of a curved element run along its lattice, first direction fastest.

use crate::mesh::CellKind::{self, *};
use crate::mesh::lagrange::{self, LatticePoint};

/// Highest degree that is read.
const MAX_DEGREE: usize = 10;

/// Kinds of degree 1, of degree 2, and of any degree.
const CURVED: [[CellKind; 3]; 7] = [
    [Line, Line3, LagrangeCurve],
    [Triangle, Triangle6, LagrangeTriangle],
    [Quadrilateral, Quadrilateral9, LagrangeQuadrilateral],
    [Tetrahedron, Tetrahedron10, LagrangeTetrahedron],
    [Hexahedron, Hexahedron27, LagrangeHexahedron],
    [Wedge, Wedge18, LagrangeWedge],
    [Pyramid, LagrangePyramid, LagrangePyramid],
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Element {
    linear: CellKind,
    /// Polynomial degree of its shape.
    degree: usize,
    /// True if the degree of the solution is given, which a mesh does not keep.
    pub has_solution: bool,
}

impl Element {
    /// The element with SU2's number, or a sentence that refuses it.
    pub fn of(number: i64) -> Result<Self, String> {
        let has_solution = number > 10_000;
        let shape = if has_solution {
            number % 10_000
        } else {
            number
        };
        let linear = u8::try_from(shape % 100).ok().and_then(CellKind::from_vtk);
        let degree = usize::try_from(shape / 100).unwrap_or(0) + 1;
        let refused =
            || format!("element type {number} is not read; 1, 3, 5, 9, 10, 12, 13 and 14 are");
        let linear = linear.filter(|kind| super::holds(*kind));
        let linear = linear.ok_or_else(refused)?;
        if degree > 1 && linear == Vertex {
            return Err(refused());
        }
        if degree > MAX_DEGREE {
            let name = linear.name();
            return Err(format!(
                "element type {number} is a {name} of degree {degree}; degrees up to {MAX_DEGREE} are read"
            ));
        }
        Ok(Self {
            linear,
            degree,
            has_solution,
        })
    }

    pub fn kind(&self) -> CellKind {
        match self.degree {
            1 => self.linear,
            2 => self.curved()[1],
            _ => self.curved()[2],
        }
    }

    /// The kinds of its shape of degree 1, 2 and any.
    fn curved(&self) -> &'static [CellKind; 3] {
        let mut rows = CURVED.iter();
        let row = rows.find(|row| row[0] == self.linear);
        row.expect("vertices are not curved")
    }

    pub fn n_nodes(&self) -> usize {
        let n = if self.degree == 1 {
            self.linear.n_nodes()
        } else {
            lagrange::n_nodes(self.curved()[2], self.degree)
        };
        n.expect("every kind has a number of nodes at these degrees")
    }

    /// The order of VTK's nodes among SU2's: node `i` of VTK is node `order[i]` of SU2. `None` if both count alike.
    pub fn order(&self) -> Option<Vec<usize>> {
        if self.degree == 1 {
            return None;
        }
        let wanted = lagrange::lattice(self.curved()[2], self.degree);
        let order = lagrange::permutation(&wanted, &self.rows());
        Some(order.expect("both are the lattice of one cell"))
    }

    /// SU2's nodes: rows along the first axis, then along the second and the third.
    fn rows(&self) -> Vec<LatticePoint> {
        let n = self.degree as u16;
        let (height, depth) = match self.linear {
            Line => (0, 0),
            Triangle | Quadrilateral => (0, n),
            _ => (n, n),
        };
        let mut places = Vec::new();
        for k in 0..=height {
            let is_narrowing = matches!(self.linear, Tetrahedron | Pyramid);
            for j in 0..=if is_narrowing { n - k } else { depth } {
                let width = match self.linear {
                    Triangle | Wedge => n - j,
                    Tetrahedron => n - k - j,
                    Pyramid => n - k,
                    _ => n,
                };
                places.extend((0..=width).map(|i| [i, j, k]));
            }
        }
        places
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;

    const LINEAR: [i64; 7] = [3, 5, 9, 10, 12, 13, 14];

    #[test]
    fn a_cubic_triangle_starts_with_its_corners_and_ends_with_its_middle() {
        let element = Element::of(205).expect("a cubic triangle");
        assert_eq!((element.kind(), element.n_nodes()), (LagrangeTriangle, 10));
        let order = element.order().expect("rows are put in order");
        assert_eq!(order, [0, 3, 9, 1, 2, 6, 8, 7, 4, 5]);
    }

    #[test]
    fn every_node_of_a_curved_cell_has_its_place() {
        for number in LINEAR {
            for degree in 2..=MAX_DEGREE as i64 {
                let element = Element::of(number + 100 * (degree - 1)).expect("it is read");
                let mut order = element.order().expect("it is curved");
                order.sort_unstable();
                assert!(order.into_iter().eq(0..element.n_nodes()), "{element:?}");
                assert!(element.kind().can_have(element.n_nodes()), "{element:?}");
            }
        }
    }

    /// The middle of an edge or a face of a cell of second order, in half steps.
    fn middle(places: &[LatticePoint], corners: &[u8]) -> LatticePoint {
        let sum =
            |axis: usize| -> u16 { corners.iter().map(|c| places[usize::from(*c)][axis]).sum() };
        [0, 1, 2].map(|axis| sum(axis) / corners.len() as u16)
    }

    #[test]
    fn nodes_of_second_order_lie_on_the_edges_and_faces_that_vtk_says() {
        for number in [103, 105, 109, 110, 112, 113, 114] {
            let element = Element::of(number).expect("it is read");
            let rows = element.rows();
            let order = element.order().expect("it is curved");
            let places: Vec<LatticePoint> = order.into_iter().map(|i| rows[i]).collect();
            let kind = element.kind();
            let edges = kind.edges().iter().map(|edge| &edge[..]);
            let faces = kind.faces().iter().copied();
            let has_middle = |face: &&[u8]| kind.dimension() == 3 && face.len() == 4;
            let parts = edges.chain(faces.filter(has_middle));
            let first = kind.n_corners(places.len());
            for (i, corners) in parts.enumerate() {
                assert_eq!(places[first + i], middle(&places, corners), "{kind:?} {i}");
            }
        }
    }

    #[test]
    fn what_is_no_element_is_refused_in_a_sentence() {
        for number in [-5, 11, 101, i64::MAX, i64::MIN] {
            assert!(Element::of(number).is_err());
        }
        let refusal = Element::of(2009).expect_err("a high degree");
        assert_says(&refusal, "of degree 21");
    }
}

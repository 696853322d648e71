//! Elements of SU2's discontinuous Galerkin solver: types above 100, with nodes row by row.
//!
//! A type is `VTK's number + 100 (degree - 1)`; one above 10000 has `10000 (degree of the solution
//! + 1)` on top. The nodes of a curved element run along its lattice, first direction fastest.

use crate::mesh::CellKind::{self, *};

/// Highest degree that is read.
const MAX_DEGREE: usize = 10;

/// An element type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Element {
    /// The kind of its corners.
    linear: CellKind,
    /// Polynomial degree of its shape.
    degree: usize,
    /// Whether the degree of the solution is given, which a mesh does not keep.
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
        let element = linear
            .filter(|kind| super::holds(*kind))
            .map(|linear| Self {
                linear,
                degree,
                has_solution,
            });
        let element = element.ok_or_else(|| {
            format!("element type {number} is not read; 1, 3, 5, 9, 10, 12, 13 and 14 are")
        })?;
        match linear {
            _ if degree == 1 => Ok(element),
            Some(Line | Triangle | Quadrilateral) if degree <= MAX_DEGREE => Ok(element),
            Some(Line | Triangle | Quadrilateral) => Err(format!(
                "element type {number} is a {} of degree {degree}; those up to {MAX_DEGREE} are read",
                element.linear.name()
            )),
            _ => Err(format!(
                "element type {number} is a {} of degree {degree}; of solid cells those of \
                 degree 1 are read",
                element.linear.name()
            )),
        }
    }

    /// The kind in memory.
    pub fn kind(&self) -> CellKind {
        match (self.linear, self.degree) {
            (linear, 1) => linear,
            (Line, 2) => Line3,
            (Triangle, 2) => Triangle6,
            (Quadrilateral, 2) => Quadrilateral9,
            (Line, _) => LagrangeCurve,
            (Triangle, _) => LagrangeTriangle,
            _ => LagrangeQuadrilateral,
        }
    }

    /// Number of its nodes.
    pub fn n_nodes(&self) -> usize {
        let n = self.degree + 1;
        match self.linear {
            Line => n,
            Triangle => n * (n + 1) / 2,
            Quadrilateral => n * n,
            linear => linear
                .n_nodes()
                .expect("SU2's kinds have a number of nodes"),
        }
    }

    /// Where VTK's nodes are among SU2's: node `i` of VTK is node `order[i]` of SU2. `None` where
    /// both count alike.
    pub fn order(&self) -> Option<Vec<usize>> {
        let n = self.degree;
        if n == 1 {
            return None;
        }
        let lattice = match self.linear {
            Line => line(n),
            Triangle => triangle(n),
            _ => quadrilateral(n),
        };
        let row = |j: usize| match self.linear {
            Triangle => j * (n + 1) - j * j.saturating_sub(1) / 2,
            _ => j * (n + 1),
        };
        Some(lattice.into_iter().map(|[i, j]| row(j) + i).collect())
    }
}

/// VTK's nodes of a curve of degree `n`: both ends, then from end to end.
fn line(n: usize) -> Vec<[usize; 2]> {
    let inside = (1..n).map(|i| [i, 0]);
    [[0, 0], [n, 0]].into_iter().chain(inside).collect()
}

/// VTK's nodes of a triangle of degree `n`: corners, edges around, then the triangle inside.
fn triangle(n: usize) -> Vec<[usize; 2]> {
    if n == 0 {
        return vec![[0, 0]];
    }
    let mut nodes = vec![[0, 0], [n, 0], [0, n]];
    nodes.extend((1..n).map(|i| [i, 0]));
    nodes.extend((1..n).map(|i| [n - i, i]));
    nodes.extend((1..n).map(|i| [0, n - i]));
    if n >= 3 {
        let inside = triangle(n - 3).into_iter();
        nodes.extend(inside.map(|[i, j]| [i + 1, j + 1]));
    }
    nodes
}

/// VTK's nodes of a quadrilateral of degree `n`: corners, edges along the axes, rows inside.
fn quadrilateral(n: usize) -> Vec<[usize; 2]> {
    let mut nodes = vec![[0, 0], [n, 0], [n, n], [0, n]];
    nodes.extend((1..n).map(|i| [i, 0]));
    nodes.extend((1..n).map(|j| [n, j]));
    nodes.extend((1..n).map(|i| [i, n]));
    nodes.extend((1..n).map(|j| [0, j]));
    nodes.extend((1..n).flat_map(|j| (1..n).map(move |i| [i, j])));
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_triangle_starts_with_its_corners_and_ends_with_its_middle() {
        let element = Element::of(205).expect("a cubic triangle");
        assert_eq!((element.kind(), element.n_nodes()), (LagrangeTriangle, 10));
        let order = element.order().expect("rows are put in order");
        assert_eq!(order, [0, 3, 9, 1, 2, 6, 8, 7, 4, 5]);
    }

    #[test]
    fn every_node_of_a_curved_cell_has_its_place() {
        for number in [103, 203, 903, 105, 205, 905, 109, 209, 909, 30_209] {
            let element = Element::of(number).expect("it is read");
            let mut order = element.order().expect("it is curved");
            order.sort_unstable();
            assert!(order.into_iter().eq(0..element.n_nodes()), "{number}");
        }
    }

    #[test]
    fn what_is_no_element_is_refused_in_a_sentence() {
        assert!(Element::of(-5).is_err());
        assert!(Element::of(11).is_err());
        assert!(Element::of(2009).unwrap_err().contains("of degree 21"));
        assert!(
            Element::of(112)
                .unwrap_err()
                .contains("hexahedron of degree 2")
        );
    }
}

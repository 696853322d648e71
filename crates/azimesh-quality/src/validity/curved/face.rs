//! The map of a curved face or edge as a polynomial of its reference coordinates, to find points of it.

use super::{Nodes, Space, inverse, product};
use azimesh_io::mesh::CellKind::{self, *};

/// The highest order: at order 5 the monomials of a quadrilateral have rounding errors of 1e-8 of its size.
const MAX_ORDER: usize = 4;

/// The map of a face or an edge: `x(s) = sum_m s^m sum_i shares[m][i] x_i`.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceTerms {
    /// The reference coordinates of each node; the second one of an edge is 0.
    pub places: Vec<[f64; 2]>,
    /// The exponents `m`.
    pub exponents: Vec<[i32; 2]>,
    /// The share of each node in each coefficient (terms, nodes).
    pub shares: Vec<f64>,
}

impl FaceTerms {
    /// Returns the map of a kind with a number of nodes; `None` for flat kinds, for those whose nodes are not on the face
    /// (Bezier), and for orders above 4.
    pub fn new(kind: CellKind, n_nodes: usize) -> Option<Self> {
        let is_bezier = matches!(kind, BezierCurve | BezierTriangle | BezierQuadrilateral);
        if !kind.is_curved() || is_bezier || kind.dimension() == 3 {
            return None;
        }
        // VTK has a second name for the triangle with a node inside.
        let kind = match (kind, n_nodes) {
            (LagrangeTriangle, 7) => Triangle7,
            _ => kind,
        };
        let nodes = Nodes::of(kind, n_nodes)?;
        if nodes.degrees.iter().any(|&degree| degree > MAX_ORDER) {
            return None;
        }
        let space = Space::new(nodes.simplices, nodes.degrees.clone());
        let n = space.exponents.len();
        let degree = |axis: usize| nodes.degrees[axis.min(nodes.degrees.len() - 1)] as f64;
        let part = |steps: &[usize; 3]| [0, 1].map(|axis| steps[axis] as f64 / degree(axis));
        let lattice: Vec<[f64; 2]> = space.exponents.iter().map(part).collect();
        let exponents: Vec<[i32; 2]> = space
            .exponents
            .iter()
            .map(|a| [a[0] as i32, a[1] as i32])
            .collect();
        let monomials = |[s, t]: &[f64; 2]| -> Vec<f64> {
            exponents
                .iter()
                .map(|[i, j]| s.powi(*i) * t.powi(*j))
                .collect()
        };
        let at_lattice: Vec<f64> = lattice.iter().flat_map(monomials).collect();
        let to_terms = inverse(&at_lattice, n)?;
        let values: Vec<f64> = lattice
            .iter()
            .flat_map(|[s, t]| space.values([*s, *t, 0.0]))
            .collect();
        let shares = product(&product(&to_terms, &values, n), &nodes.control, n);
        let third = 1.0 / 3.0;
        let places = match n_nodes {
            7 if kind.linear() == Triangle => vec![
                [0.0, 0.0],
                [1.0, 0.0],
                [0.0, 1.0],
                [0.5, 0.0],
                [0.5, 0.5],
                [0.0, 0.5],
                [third, third],
            ],
            _ => nodes.places[..n_nodes].iter().map(part).collect(),
        };
        Some(Self {
            places,
            exponents,
            shares,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_io::mesh::lagrange;

    #[test]
    fn the_map_of_a_face_interpolates_its_nodes() {
        let fixed = [
            Line3,
            CubicLine,
            Triangle6,
            Triangle7,
            Quadrilateral8,
            Quadrilateral9,
            QuadraticLinearQuadrilateral,
        ];
        let any = [LagrangeCurve, LagrangeTriangle, LagrangeQuadrilateral];
        let of_any = any
            .iter()
            .flat_map(|&kind| (2..=MAX_ORDER).map(move |p| (kind, lagrange::n_nodes(kind, p))));
        let all = fixed
            .iter()
            .map(|&kind| (kind, kind.n_nodes()))
            .chain(of_any);
        for (kind, n) in all.chain([(LagrangeTriangle, Some(7))]) {
            let n = n.expect("it is known");
            let map = FaceTerms::new(kind, n).unwrap_or_else(|| panic!("{kind:?} {n}"));
            for (node, [s, t]) in map.places.iter().enumerate() {
                for other in 0..n {
                    let terms = map.exponents.iter().zip(map.shares.chunks(n));
                    let share: f64 = terms
                        .map(|([i, j], shares)| s.powi(*i) * t.powi(*j) * shares[other])
                        .sum();
                    let wanted = f64::from(u8::from(node == other));
                    assert!(
                        (share - wanted).abs() < 1e-9,
                        "{kind:?} {n}: {node} {other} {share}"
                    );
                }
            }
        }
        assert_eq!(FaceTerms::new(BezierTriangle, 6), None);
        assert_eq!(FaceTerms::new(Quadrilateral, 4), None);
    }
}

//! Flat pieces of a face or an edge through all of its nodes, for computations on surfaces.

use super::CellKind::{self, *};
use super::lagrange::{self, LatticePoint};

/// Triangles between the nodes of a face of this kind with `n_nodes` nodes, as indices into its nodes
/// and turning as the face does; an edge of a plane mesh gives segments with their second node twice.
/// Empty for cells of other dimensions. A quadrilateral whose orders along its axes differ gives the
/// triangles of its corners, because the number of nodes along each axis is not known.
pub fn facets(kind: CellKind, n_nodes: usize) -> Vec<[usize; 3]> {
    match kind {
        Line => vec![[0, 1, 1]],
        Line3 => chain(&[0, 2, 1]),
        CubicLine => chain(&[0, 2, 3, 1]),
        Triangle => vec![[0, 1, 2]],
        Triangle6 => vec![[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
        Triangle7 => around(6, &[0, 3, 1, 4, 2, 5]),
        Quadrilateral => vec![[0, 1, 2], [0, 2, 3]],
        QuadraticLinearQuadrilateral => vec![[0, 4, 5], [0, 5, 3], [4, 1, 2], [4, 2, 5]],
        Quadrilateral8 => ring(4),
        Quadrilateral9 => vec![
            [0, 4, 8],
            [0, 8, 7],
            [4, 1, 5],
            [4, 5, 8],
            [8, 5, 2],
            [8, 2, 6],
            [7, 8, 6],
            [7, 6, 3],
        ],
        Polygon => (2..n_nodes).map(|i| [0, i - 1, i]).collect(),
        QuadraticPolygon => ring(n_nodes / 2),
        LagrangeTriangle | BezierTriangle if n_nodes == 7 => facets(Triangle7, 7),
        _ => of_any_order(kind, n_nodes),
    }
}

/// Segments from node to node.
fn chain(nodes: &[usize]) -> Vec<[usize; 3]> {
    let pairs = nodes.windows(2);
    pairs.map(|pair| [pair[0], pair[1], pair[1]]).collect()
}

/// Triangles between a centre and the nodes around it.
fn around(centre: usize, nodes: &[usize]) -> Vec<[usize; 3]> {
    let next = nodes.iter().cycle().skip(1);
    let pairs = nodes.iter().zip(next);
    pairs.map(|(&a, &b)| [a, b, centre]).collect()
}

/// A face of `n` corners and then the middles of its edges: corners are cut off, and what is left
/// between the middles is a fan.
fn ring(n: usize) -> Vec<[usize; 3]> {
    let corner = |i: usize| [n + (i + n - 1) % n, i, n + i];
    let fan = (2..n).map(|i| [n, n + i - 1, n + i]);
    (0..n).map(corner).chain(fan).collect()
}

/// Facets of a Lagrange or Bezier cell, between neighbours on its lattice.
fn of_any_order(kind: CellKind, n_nodes: usize) -> Vec<[usize; 3]> {
    if !matches!(kind.dimension(), 1 | 2) {
        return Vec::new();
    }
    let Some(order) = lagrange::order(kind, n_nodes) else {
        let linear = kind.linear();
        return facets(linear, linear.n_nodes().unwrap_or(n_nodes));
    };
    let mut nodes: Vec<(LatticePoint, usize)> = lagrange::lattice(kind, order)
        .into_iter()
        .zip(0..)
        .collect();
    nodes.sort_unstable();
    let at = |i: u16, j: u16| {
        let found = nodes.binary_search_by_key(&[i, j, 0], |(place, _)| *place);
        found.ok().map(|at| nodes[at].1)
    };
    let pieces = |&([i, j, _], node): &(LatticePoint, usize)| {
        let (right, above, across) = (at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
        if kind.dimension() == 1 {
            return [right.map(|right| [node, right, right]), None];
        }
        let near = right.zip(above).map(|(right, above)| [node, right, above]);
        let far = right.zip(above).zip(across);
        [
            near,
            far.map(|((right, above), across)| [right, across, above]),
        ]
    };
    nodes.iter().flat_map(pieces).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn sizes(kind: CellKind) -> Vec<usize> {
        match kind.n_nodes() {
            Some(n) => vec![n],
            None if matches!(kind, Polygon | QuadraticPolygon) => vec![6, 8, 12],
            None => (1..=6).filter_map(|p| lagrange::n_nodes(kind, p)).collect(),
        }
    }

    #[test]
    fn pieces_of_a_face_use_every_node() {
        for kind in CellKind::ALL {
            for n in sizes(kind) {
                let used = facets(kind, n).concat();
                let is_face = matches!(kind.dimension(), 1 | 2);
                assert_eq!(
                    (0..n).all(|node| used.contains(&node)),
                    is_face,
                    "{kind:?} {n}"
                );
            }
        }
        assert_eq!(facets(BezierTriangle, 7).len(), 6);
        assert_eq!(facets(LagrangeQuadrilateral, 6), facets(Quadrilateral, 4));
    }

    /// Edges inside are passed once in each direction, so that pieces turn alike and leave no hole;
    /// what is left is the outline, which the corners' order closes.
    #[test]
    fn pieces_of_a_face_leave_no_gap() {
        for kind in CellKind::ALL
            .into_iter()
            .filter(|kind| kind.dimension() == 2)
        {
            for n in sizes(kind) {
                let mut passed: BTreeMap<(usize, usize), i32> = BTreeMap::new();
                for piece in facets(kind, n) {
                    for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                        let (a, b) = (piece[a], piece[b]);
                        *passed.entry((a.min(b), a.max(b))).or_default() +=
                            if a < b { 1 } else { -1 };
                    }
                }
                let outline = passed.values().filter(|times| **times != 0).count();
                assert!(
                    passed.values().all(|times| times.abs() <= 1),
                    "{kind:?} {n}"
                );
                let corners = kind.n_corners(n);
                let per_edge = match lagrange::order(kind, n) {
                    Some(order) => order,
                    None if kind == QuadraticLinearQuadrilateral => {
                        assert_eq!(outline, 6);
                        continue;
                    }
                    None if kind.is_curved() => 2,
                    None => 1,
                };
                assert_eq!(outline, corners * per_edge, "{kind:?} {n}");
            }
        }
    }
}

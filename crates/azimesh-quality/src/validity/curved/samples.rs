//! Derivatives of the map of a curved cell at the points of a lattice, corners included.

use super::{CurvedMap, Space};
use azimesh_core::geometry::vector::Vector;
use std::sync::Arc;

/// The derivatives of the functions of nodes by the coordinates of the cell, point by point.
#[derive(Debug)]
pub struct Samples {
    n_nodes: usize,
    n_corners: usize,
    of_nodes: Vec<Vector>,
    /// In the cell with straight edges.
    of_corners: Vec<Vector>,
}

impl Samples {
    /// Number of points.
    pub fn n_points(&self) -> usize {
        self.of_nodes.len() / self.n_nodes
    }

    /// Of each node at a point.
    #[inline]
    pub fn of_nodes(&self, point: usize) -> &[Vector] {
        &self.of_nodes[point * self.n_nodes..][..self.n_nodes]
    }

    /// Of each corner of the straight cell at a point.
    pub fn of_corners(&self, point: usize) -> &[Vector] {
        &self.of_corners[point * self.n_corners..][..self.n_corners]
    }
}

impl CurvedMap {
    /// Samples at the points of a lattice with one interval more than the order along each edge, or of twice as many.
    pub fn samples(&self, are_many: bool) -> &Arc<Samples> {
        self.samples[usize::from(are_many)].get_or_init(|| {
            let n = (1 + usize::from(are_many)) * (self.order + 1);
            let n_corners = self.kind.n_corners(self.n_nodes);
            let straight = Self::new(self.kind.linear(), n_corners);
            let straight = straight.expect("straight cells have a map");
            let simplices = self.determinant.simplices;
            let lattice = Space::new(simplices, vec![n; simplices.len()]);
            let points = lattice
                .exponents
                .iter()
                .map(|a| a.map(|i| i as f64 / n as f64));
            let of = |map: &Self| points.clone().flat_map(|at| map.node_slopes(at)).collect();
            Arc::new(Samples {
                n_nodes: self.n_nodes,
                n_corners,
                of_nodes: of(self),
                of_corners: of(&straight),
            })
        })
    }

    /// The derivatives of the function of each node at a point.
    fn node_slopes(&self, at: [f64; 3]) -> Vec<Vector> {
        let mut slopes = vec![[0.0; 3]; self.n_nodes];
        for (axis, derivative) in self.derivatives.iter().enumerate() {
            let values = derivative.space.values(at);
            for (value, &(next, this, factor)) in values.iter().zip(&derivative.terms) {
                for (point, sign) in [(next, 1.0), (this, -1.0)] {
                    for &(node, share) in &self.control[point] {
                        slopes[node][axis] += sign * factor * value * share;
                    }
                }
            }
        }
        slopes
    }
}

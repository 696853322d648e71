//! First cells at moving walls: each wall node with its nearest neighbour off the wall.

use crate::geometry::vector::{Vector, distance};
use crate::mesh::Mesh;
use crate::motion::{Motion, Role};
use rayon::prelude::*;

/// Edges that leave a moving wall, the shortest at each wall node.
#[derive(Debug, Clone, Default)]
pub struct FirstCells {
    /// Wall node, its neighbour, and the length of the edge in the reference mesh.
    edges: Vec<(u32, u32, f64)>,
}

impl FirstCells {
    /// Finds the edges in the reference mesh. Polyhedra and polygons have none.
    pub fn find(mesh: &Mesh, motion: &Motion) -> Self {
        let mut wall = vec![u32::MAX; mesh.points.len()];
        let surface = &motion.surface.nodes;
        let moving = surface.nodes.iter().zip(&surface.roles);
        let moving = moving.filter(|(_, role)| matches!(role, Role::Moving(_)));
        let nodes: Vec<u32> = moving.map(|(node, _)| *node).collect();
        for (at, &node) in nodes.iter().enumerate() {
            wall[node as usize] = at as u32;
        }
        let mut shortest = vec![(u32::MAX, f64::INFINITY); nodes.len()];
        for run in mesh.volume_runs() {
            let edges = run.kind.edges();
            for cell in run.cells() {
                for &[a, b] in edges {
                    let (a, b) = (cell[a as usize], cell[b as usize]);
                    for (on, off) in [(a, b), (b, a)] {
                        if wall[on as usize] != u32::MAX && wall[off as usize] == u32::MAX {
                            let length =
                                distance(mesh.points[on as usize], mesh.points[off as usize]);
                            let entry = &mut shortest[wall[on as usize] as usize];
                            if (length, off) < (entry.1, entry.0) {
                                *entry = (off, length);
                            }
                        }
                    }
                }
            }
        }
        let found = nodes
            .iter()
            .zip(shortest)
            .filter(|(_, (off, _))| *off != u32::MAX);
        Self {
            edges: found
                .map(|(&on, (off, length))| (on, off, length))
                .collect(),
        }
    }

    /// The smallest first-cell height, in mesh units.
    pub fn smallest(&self) -> Option<f64> {
        self.edges.iter().map(|edge| edge.2).min_by(f64::total_cmp)
    }

    /// The smallest ratio of first-cell height to that in the reference mesh.
    pub fn smallest_ratio(&self, points: &[Vector]) -> Option<f64> {
        let ratio = |&(on, off, length): &(u32, u32, f64)| {
            distance(points[on as usize], points[off as usize]) / length
        };
        self.edges.par_iter().map(ratio).min_by(f64::total_cmp)
    }

    /// The largest relative change of a first-cell height when coordinates are rounded to 32 bits.
    pub fn change_in_f32(&self, points: &[Vector]) -> f64 {
        let rounded = |node: u32| points[node as usize].map(|x| f64::from(x as f32));
        let change = |&(on, off, length): &(u32, u32, f64)| {
            (distance(rounded(on), rounded(off)) / length - 1.0).abs()
        };
        self.edges.par_iter().map(change).reduce(|| 0.0, f64::max)
    }
}

//! A block of structured nodes: the faces of its sides. `vtk::structured` has its cells.

use crate::mesh::{CellKind, Cells};
use std::ops::Range;

/// A grid of 1 to 3 indices; the ones that it does not have are 1 node wide.
pub(super) struct Grid {
    pub n_indices: usize,
    pub nodes: [usize; 3],
    pub cells: [usize; 3],
    pub first_node: usize,
}

impl Grid {
    /// A grid of so many nodes along each index.
    pub fn new(n_indices: usize, nodes: [usize; 3], first_node: usize) -> Self {
        Self {
            n_indices,
            nodes,
            cells: nodes.map(|n| n.saturating_sub(1).max(1)),
            first_node,
        }
    }

    pub fn node(&self, [i, j, k]: [usize; 3]) -> u32 {
        (self.first_node + i + self.nodes[0] * (j + self.nodes[1] * k)) as u32
    }

    /// Nodes of the face that spreads from `at` along the indices `along`, in VTK's order.
    pub fn corners(&self, at: [usize; 3], along: &[usize]) -> Vec<u32> {
        let moved = |steps: &[usize]| {
            let mut at = at;
            steps.iter().for_each(|&index| at[index] += 1);
            self.node(at)
        };
        match *along {
            [a] => vec![moved(&[]), moved(&[a])],
            [a, b] => vec![moved(&[]), moved(&[a]), moved(&[a, b]), moved(&[b])],
            _ => vec![moved(&[])],
        }
    }

    /// Appends the faces across an index whose lowest corners are in `ranges`, turned outward.
    pub fn append_faces(&self, across: usize, ranges: [Range<usize>; 3], cells: &mut Cells) {
        let along: Vec<usize> = match self.n_indices {
            3 => vec![(across + 1) % 3, (across + 2) % 3],
            2 => vec![1 - across],
            _ => Vec::new(),
        };
        let is_low = ranges[across].start == 0;
        let turned = is_low == (self.n_indices != 2 || across == 0);
        let kinds = [CellKind::Vertex, CellKind::Line, CellKind::Quadrilateral];
        let kind = kinds[self.n_indices - 1];
        for k in ranges[2].clone() {
            for j in ranges[1].clone() {
                for i in ranges[0].clone() {
                    let mut nodes = self.corners([i, j, k], &along);
                    if turned {
                        nodes.reverse();
                    }
                    cells.push(kind, &nodes);
                }
            }
        }
    }
}

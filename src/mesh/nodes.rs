//! Nodes of no cell, and nodes at the same place.

use super::Mesh;
use rayon::prelude::*;

impl Mesh {
    /// For each node, whether a cell has it.
    pub fn nodes_of_cells(&self) -> Vec<bool> {
        self.cells.used_nodes(self.points.len())
    }

    /// Number of nodes that no cell has.
    pub fn n_orphan_nodes(&self) -> usize {
        let used = self.nodes_of_cells();
        used.iter().filter(|&&used| !used).count()
    }

    /// Number of nodes at the very place of one before them.
    pub fn n_repeated_nodes(&self) -> usize {
        // -0 is the same place as 0.
        let place = |node: u32| self.points[node as usize].map(|x| (x + 0.0).to_bits());
        let mixed = |node: u32| {
            place(node).into_iter().fold(0u64, |hash, bits| {
                let product =
                    u128::from(hash ^ bits ^ 0xf39c_c060_5ced_c835) * 0x9e37_79b9_7f4a_7c15;
                (product >> 64) as u64 ^ product as u64
            })
        };
        let mut nodes: Vec<(u64, u32)> = (0..self.points.len() as u32)
            .into_par_iter()
            .map(|node| (mixed(node), node))
            .collect();
        nodes.par_sort_unstable();
        let alike = nodes
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|alike| alike.len() > 1);
        let repeated = alike.map(|alike| {
            let mut places: Vec<_> = alike.iter().map(|(_, node)| place(*node)).collect();
            places.sort_unstable();
            places.dedup();
            alike.len() - places.len()
        });
        repeated.sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::CellKind;
    use super::*;

    #[test]
    fn nodes_without_a_cell_and_nodes_at_one_place_are_counted() {
        let mut mesh = Mesh {
            points: vec![
                [0.0, 1.0, 2.0],
                [-0.0, 1.0, 2.0],
                [2.0, 1.0, 0.0],
                [0.0, 1.0, 2.0],
            ],
            ..Mesh::default()
        };
        mesh.cells.push(CellKind::Line, &[0, 2]);
        assert_eq!(mesh.n_orphan_nodes(), 2);
        assert_eq!(mesh.n_repeated_nodes(), 2);
    }
}

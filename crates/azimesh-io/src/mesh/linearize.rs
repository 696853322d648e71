//! Curved cells made straight: their corner nodes alone.

use super::arrays::select_tuples;
use super::{CellKind, Cells, Mesh};

impl Mesh {
    /// Replaces curved cells by linear ones with the same corners; nodes that only they had go, with
    /// their values in point arrays. Returns how many cells were curved and how many nodes went.
    pub fn linearize(&mut self) -> (usize, usize) {
        let curved = self.cells.runs().filter(|run| run.kind.is_curved());
        let n_curved = curved.map(|run| run.n_cells()).sum();
        if n_curved == 0 {
            return (0, 0);
        }
        let used_before = self.nodes_of_cells();
        self.cells = linear(&self.cells, |_| true);
        let used = self.nodes_of_cells();
        let keep: Vec<usize> = (0..self.points.len())
            .filter(|&node| used[node] || !used_before[node])
            .collect();
        let n_gone = self.points.len() - keep.len();
        self.keep_nodes(&keep);
        (n_curved, n_gone)
    }

    /// Keeps these nodes only, which are ascending and hold all nodes of cells.
    pub(super) fn keep_nodes(&mut self, keep: &[usize]) {
        let mut new_index = vec![u32::MAX; self.points.len()];
        for (new, &old) in keep.iter().enumerate() {
            new_index[old] = new as u32;
        }
        self.points = keep.iter().map(|&node| self.points[node]).collect();
        select_tuples(&mut self.point_arrays, keep);
        self.cells.renumber_nodes(&new_index);
    }
}

/// The cells, with some kinds made linear.
pub fn linear(cells: &Cells, makes: impl Fn(CellKind) -> bool) -> Cells {
    let mut linear = Cells::new();
    linear.reserve(cells.connectivity().len());
    for run in cells.runs() {
        if run.kind == CellKind::Polyhedron {
            for (i, nodes) in run.cells().enumerate() {
                let stream = cells.face_stream(run.first_cell + i);
                linear
                    .push_polyhedron_with_nodes(nodes, stream.expect("it is a polyhedron"))
                    .expect("it was checked when it was added");
            }
            continue;
        }
        let n_corners = run.kind.n_corners(run.n_nodes);
        if !run.kind.is_curved() || !makes(run.kind) {
            linear.push_run(run.kind, run.n_nodes, run.connectivity);
            continue;
        }
        let corners = run.cells().flat_map(|nodes| &nodes[..n_corners]);
        let corners: Vec<u32> = corners.copied().collect();
        linear.push_run(run.kind.linear(), n_corners, &corners);
    }
    linear
}

#[cfg(test)]
mod tests {
    use super::super::{DataArray, Values};
    use super::*;

    #[test]
    fn corners_stay_and_middles_go_with_their_values() {
        let mut mesh = Mesh::of_points((0..8).map(|i| [f64::from(i), 0.0, 0.0]).collect());
        mesh.cells.push(CellKind::Triangle6, &[6, 1, 2, 3, 4, 5]);
        mesh.cells.push(CellKind::Line, &[2, 6]);
        let id = Values::I32((0..8).collect());
        mesh.point_arrays.push(DataArray::scalar("id", id));
        assert_eq!(mesh.linearize(), (1, 3));
        // Node 0 and node 7 are no cell's before, and stay.
        assert_eq!(
            mesh.point_arrays[0].values,
            Values::I32(vec![0, 1, 2, 6, 7])
        );
        assert_eq!(mesh.cells.get(0).kind, CellKind::Triangle);
        assert_eq!(mesh.cells.get(0).nodes, [3, 1, 2]);
        assert_eq!(mesh.cells.get(1).nodes, [2, 3]);
        assert_eq!(mesh.points[3][0], 6.0);
        assert_eq!(mesh.linearize(), (0, 0));
    }
}

//! Numbers of elements: cells of the mesh's own dimension first, then those of one dimension less, and so on,
//! each in the order of the mesh. VTK's reader (and so ParaView's) takes the first elements of a zone, as many as it
//! has cells, for its cells.

use crate::mesh::{CellSet, MeshView};
use std::ops::Range;

/// Which number each cell has as an element.
pub(super) struct Numbering {
    /// Runs of cells with the number of their first one, in the order of the mesh.
    runs: Vec<(Range<usize>, usize)>,
}

impl Numbering {
    /// Of the cells of a mesh.
    pub fn of(mesh: &MeshView) -> Self {
        let mut runs: Vec<(Range<usize>, u8)> = Vec::new();
        for run in mesh.cells.runs() {
            let (range, of) = (
                run.first_cell..run.first_cell + run.n_cells(),
                run.kind.dimension(),
            );
            match runs.last_mut() {
                Some((last, dimension)) if *dimension == of => last.end = range.end,
                _ => runs.push((range, of)),
            }
        }
        let mut next = 1;
        let mut first = vec![0; runs.len()];
        for dimension in (0..=3).rev() {
            for (i, (range, _)) in runs
                .iter()
                .enumerate()
                .filter(|(_, run)| run.1 == dimension)
            {
                first[i] = next;
                next += range.len();
            }
        }
        let runs = runs.into_iter().zip(first);
        Self {
            runs: runs.map(|((range, _), first)| (range, first)).collect(),
        }
    }

    /// Whether elements come in the order of the cells.
    pub fn is_order_of_cells(&self) -> bool {
        self.runs
            .iter()
            .all(|(cells, first)| cells.start + 1 == *first)
    }

    /// The number of a cell.
    ///
    /// # Panics
    /// When there is no such cell.
    pub fn element(&self, cell: usize) -> usize {
        let at = self.runs.partition_point(|(cells, _)| cells.end <= cell);
        let (cells, first) = &self.runs[at];
        first + cell - cells.start
    }

    /// The numbers of some cells, each less 1.
    pub fn elements(&self, cells: &CellSet) -> CellSet {
        let mut found: Vec<Range<usize>> = Vec::new();
        for range in cells.ranges() {
            let from = self.runs.partition_point(|(run, _)| run.end <= range.start);
            let runs = self.runs[from..].iter();
            for (run, first) in runs.take_while(|(run, _)| run.start < range.end) {
                let (start, end) = (range.start.max(run.start), range.end.min(run.end));
                found.push(first - 1 + start - run.start..first - 1 + end - run.start);
            }
        }
        found.sort_unstable_by_key(|range| range.start);
        let mut elements = CellSet::new();
        for range in found {
            elements.push_range(range);
        }
        elements
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellKind, Mesh};

    #[test]
    fn cells_come_before_faces_and_edges_and_keep_their_order() {
        let mut mesh = Mesh {
            points: vec![[0.0; 3]; 4],
            ..Mesh::default()
        };
        mesh.cells.push(CellKind::Vertex, &[0]);
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        mesh.cells.push(CellKind::Line, &[0, 1]);
        mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 3, 2]);
        mesh.cells.push(CellKind::Triangle, &[0, 1, 3]);
        let numbering = Numbering::of(&mesh.view());
        let numbers: Vec<usize> = (0..6).map(|cell| numbering.element(cell)).collect();
        assert_eq!(numbers, [6, 3, 1, 5, 2, 4]);
        assert!(!numbering.is_order_of_cells());
        let all = [1, 2, 4, 5].into_iter().collect();
        let numbers: Vec<usize> = numbering.elements(&all).iter().collect();
        assert_eq!(numbers, [0, 1, 2, 3]);
        let last = mesh.cells.select([2, 4, 1, 5, 3, 0]);
        let ordered = Mesh {
            cells: last,
            ..mesh
        };
        assert!(Numbering::of(&ordered.view()).is_order_of_cells());
    }
}

//! Faces that belong to one cell only, for boundaries that a file gives by their nodes alone.

use crate::mesh::sides::{for_each_side, side};
use crate::mesh::{CellKind, CellRef, Cells};
use std::ops::Range;

/// No corner: of a face that has less than four.
const NONE: u32 = u32::MAX;

/// A face by its four smallest corners, ascending, and their number; its cell, and which face of it.
type Keyed = ([u32; 4], usize, u32, usize);

/// Faces with one cell only and with no corner but those that `is_in`, of the cells in a range that
/// have this dimension: kind and nodes, in the order of the cells. Faces whose nodes are not all
/// known are left out.
pub(super) fn exterior_faces(
    cells: &Cells,
    range: Range<usize>,
    dimension: u8,
    is_in: impl Fn(u32) -> bool,
) -> Vec<(CellKind, Vec<u32>)> {
    let mut faces: Vec<Keyed> = Vec::new();
    let runs = cells.runs_in(range);
    for run in runs.filter(|run| run.kind.dimension() == dimension) {
        for (i, nodes) in run.cells().enumerate() {
            let cell = CellRef {
                index: run.first_cell + i,
                kind: run.kind,
                nodes,
            };
            for_each_side(cells, &cell, |face, corners| {
                if corners.iter().all(|&corner| is_in(corner)) {
                    faces.push((smallest(corners), corners.len(), cell.index as u32, face));
                }
            });
        }
    }
    faces.sort_unstable();
    let mut alone: Vec<Keyed> = faces
        .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .filter(|faces| faces.len() == 1)
        .map(|faces| faces[0])
        .collect();
    alone.sort_unstable_by_key(|(_, _, cell, face)| (*cell, *face));
    let whole = |(_, _, cell, face): Keyed| side(cells, &cells.get(cell as usize), face);
    alone.into_iter().filter_map(whole).collect()
}

fn smallest(corners: &[u32]) -> [u32; 4] {
    let mut smallest = [NONE; 4];
    if let Some(few) = smallest.get_mut(..corners.len()) {
        few.copy_from_slice(corners);
        smallest.sort_unstable();
        return smallest;
    }
    let mut all = corners.to_vec();
    all.sort_unstable();
    smallest.copy_from_slice(&all[..4]);
    smallest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_third_order_and_polyhedra_have_faces_too() {
        let nodes: Vec<u32> = (0..20).collect();
        let mut cells = Cells::new();
        cells.push(CellKind::LagrangeTetrahedron, &nodes);
        let found = exterior_faces(&cells, 0..1, 3, |node| node < 3);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].0, CellKind::LagrangeTriangle);
        assert_eq!(found[0].1.len(), 10);

        // Two pyramids on a pentagon, which is between them.
        let mut cells = Cells::new();
        for apex in [5, 6] {
            let mut stream = vec![6, 5, 0, 1, 2, 3, 4];
            (0..5).for_each(|i| stream.extend([3, i, (i + 1) % 5, apex]));
            cells.push_polyhedron(&stream).expect("a good stream");
        }
        assert!(exterior_faces(&cells, 0..2, 3, |node| node < 5).is_empty());
        let found = exterior_faces(&cells, 0..1, 3, |node| node < 5);
        assert_eq!(found, [(CellKind::Polygon, vec![0, 1, 2, 3, 4])]);
    }
}

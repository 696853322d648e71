//! A mesh of tetrahedra alone, straight from its faces: one walk through them, in which each adds to the cells on its two
//! sides. The cells are those that `shapes` finds one by one.

use super::cells::{Blocks, INWARD};
use super::faces::FacesView;
use super::labels::Label;
use crate::mesh::{CellKind, Cells};
use azimesh_core::parallel::{map_items, n_threads, update};

/// What is known of a cell: its three upper faces, by the edge that they have on the base, then the base and the apex.
const SIDES: u8 = 0b111;
const BASE: u8 = 1 << 3;
const APEX: u8 = 1 << 4;
/// Its faces make no tetrahedron.
const WRONG: u8 = 1 << 5;

/// The cells, then the faces on the boundary as cells; `None` where any is no tetrahedron.
pub(in crate::formats) fn assemble(
    blocks: &Blocks,
    faces: FacesView,
    n_cells: usize,
) -> Option<Cells> {
    let n_inside = blocks.neighbour.len();
    let n_sides = blocks.owner.len() + n_inside;
    if faces.size != 3 || n_cells.checked_mul(4) != Some(n_sides) {
        return None;
    }
    let triangles = faces.nodes.as_chunks::<3>().0;
    let outside = &faces.nodes[3 * n_inside..];
    let mut nodes = vec![0; 4 * n_cells + outside.len()];
    let (of_cells, of_faces) = nodes.split_at_mut(4 * n_cells);
    // Each task walks through the faces of its cells, and faces of all cells may be among them: so there are few.
    let size = n_cells.div_ceil(n_threads()).max(1);
    let parts = of_cells.as_chunks_mut::<4>().0.chunks_mut(size);
    let are_whole = map_items(parts, &|i, part| fill(blocks, triangles, i * size, part));
    if are_whole.contains(&false) {
        return None;
    }
    update(of_faces, |i, node| *node = outside[i].get());
    let kinds = [
        (CellKind::Tetrahedron, 4, n_cells),
        (CellKind::Triangle, 3, outside.len() / 3),
    ];
    Some(Cells::from_connectivity(nodes, kinds))
}

/// Finds the nodes of the cells from `first` on; tells whether all of them are tetrahedra.
fn fill(blocks: &Blocks, triangles: &[[Label; 3]], first: usize, cells: &mut [[u32; 4]]) -> bool {
    let mut known = vec![0; cells.len()];
    blocks.visit(&(first..first + cells.len()), |cell, face| {
        let [x, y, z] = triangles[(face & !INWARD) as usize];
        let [x, y, z] = [x.get(), y.get(), z.get()];
        let outward = if face & INWARD == 0 {
            [x, y, z]
        } else {
            [x, z, y]
        };
        add(&mut cells[cell], &mut known[cell], outward);
    });
    known.iter().all(|known| *known == BASE | APEX | SIDES)
}

/// Adds a face, turned outward: the first one is the base, seen from inside; the second one has the apex.
#[inline]
fn add(cell: &mut [u32; 4], known: &mut u8, [x, y, z]: [u32; 3]) {
    if *known & BASE == 0 {
        *cell = [z, y, x, 0];
        *known = if x == y || y == z || z == x {
            WRONG | BASE
        } else {
            BASE
        };
        return;
    }
    let [a, b, c, _] = *cell;
    if *known & APEX == 0 {
        let is_new = |node: u32| node != a && node != b && node != c;
        cell[3] = match (is_new(x), is_new(y)) {
            (true, _) => x,
            (_, true) => y,
            _ => z,
        };
        *known |= if is_new(cell[3]) { APEX } else { WRONG };
    }
    let apex = cell[3];
    // The edge that a side has on the base.
    let (from, to) = match apex {
        _ if apex == z => (x, y),
        _ if apex == x => (y, z),
        _ => (z, x),
    };
    let edge = match (from, to) {
        _ if apex != x && apex != y && apex != z => WRONG,
        _ if from == a && to == b => 1,
        _ if from == b && to == c => 1 << 1,
        _ if from == c && to == a => 1 << 2,
        _ => WRONG,
    };
    // A side that is there twice is wrong.
    *known |= if *known & edge == 0 { edge } else { WRONG };
}

#[cfg(test)]
mod tests {
    use super::super::cells;
    use super::super::faces::Faces;
    use super::super::labels::Labels;
    use super::*;

    /// Two tetrahedra with a face in common, as faces, owners and neighbours.
    fn two() -> (Vec<[u32; 3]>, Vec<u32>, Vec<u32>) {
        let faces = vec![
            [1, 2, 3],
            [0, 2, 1],
            [0, 1, 3],
            [2, 0, 3],
            [1, 2, 4],
            [3, 1, 4],
            [2, 3, 4],
        ];
        (faces, vec![0, 0, 0, 0, 1, 1, 1], vec![1])
    }

    fn both(
        faces: &[[u32; 3]],
        owner: &[u32],
        neighbour: &[u32],
    ) -> (Option<Cells>, azimesh_core::error::Result<Cells>) {
        let labels = |list: &[u32]| Labels::from(list.to_vec());
        let (owner, neighbour) = (labels(owner), labels(neighbour));
        let starts: Vec<u32> = (0..=faces.len()).map(|face| 3 * face as u32).collect();
        let faces = Faces::new(starts, faces.concat());
        let blocks = Blocks::new(owner.view(), neighbour.view());
        let one_by_one = cells::one_by_one(&blocks, faces.view(), 2, 0);
        (assemble(&blocks, faces.view(), 2), one_by_one)
    }

    #[test]
    fn tetrahedra_are_those_that_are_found_one_by_one() {
        let (faces, owner, neighbour) = two();
        // Every corner of a face may be the first, and every face of a cell the base.
        for turn in 0..3usize.pow(7) {
            let mut turned = faces.clone();
            for (i, face) in turned.iter_mut().enumerate() {
                face.rotate_left(turn / 3usize.pow(i as u32) % 3);
            }
            turned[1..4].rotate_left(turn % 3);
            turned[4..].rotate_left(turn / 3 % 3);
            let (found, expected) = both(&turned, &owner, &neighbour);
            let expected = expected.expect("they are whole");
            assert_eq!(expected.get(1).kind, CellKind::Tetrahedron);
            assert_eq!(found, Some(expected));
        }
    }

    #[test]
    fn faces_that_make_other_cells_are_left_to_the_general_way() {
        let (faces, owner, neighbour) = two();
        let is_refused = |faces: &[[u32; 3]], owner: &[u32]| {
            let (found, one_by_one) = both(faces, owner, &neighbour);
            let has_tetrahedra = |cells: Cells| {
                let solid = cells.iter().take(2);
                solid
                    .filter(|cell| cell.kind == CellKind::Tetrahedron)
                    .count()
                    == 2
            };
            assert!(!one_by_one.is_ok_and(has_tetrahedra), "{faces:?}");
            found.is_none()
        };
        let with = |face: usize, nodes: [u32; 3]| {
            let mut faces = faces.clone();
            faces[face] = nodes;
            faces
        };
        // Turned round, twice there, of another node, with a node twice, with the apex twice; five faces and three.
        assert!(is_refused(&with(2, [1, 0, 3]), &owner));
        assert!(is_refused(&with(2, [0, 2, 1]), &owner));
        assert!(is_refused(&with(3, [2, 5, 3]), &owner));
        assert!(is_refused(&with(0, [1, 1, 3]), &owner));
        assert!(is_refused(&with(2, [0, 0, 3]), &owner));
        assert!(is_refused(&with(1, [3, 2, 1]), &owner));
        assert!(is_refused(&faces, &[0, 0, 0, 0, 0, 1, 1]));
    }
}

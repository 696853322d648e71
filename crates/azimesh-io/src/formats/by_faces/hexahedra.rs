//! A mesh of hexahedra alone, straight from its faces: the six faces of each cell in one walk, then the nodes above those of
//! its first face. The cells are those that `shapes` finds one by one.

use super::cells::{Blocks, INWARD};
use super::faces::FacesView;
use super::labels::Label;
use crate::mesh::{CellKind, Cells};
use azimesh_core::parallel::{map_items, n_threads, update};

/// The cells, then the faces on the boundary as cells; `None` where any is no hexahedron.
pub(super) fn assemble(blocks: &Blocks, faces: FacesView, n_cells: usize) -> Option<Cells> {
    let n_inside = blocks.neighbour.len();
    let n_sides = blocks.owner.len() + n_inside;
    if faces.size != 4 || n_cells.checked_mul(6) != Some(n_sides) {
        return None;
    }
    let quads = faces.nodes.as_chunks::<4>().0;
    let outside = &faces.nodes[4 * n_inside..];
    let mut nodes = vec![0; 8 * n_cells + outside.len()];
    let (of_cells, of_faces) = nodes.split_at_mut(8 * n_cells);
    // Each task walks through the faces of its cells, and faces of all cells may be among them: so there are few.
    let size = n_cells.div_ceil(n_threads()).max(1);
    let parts = of_cells.as_chunks_mut::<8>().0.chunks_mut(size);
    let are_whole = map_items(parts, &|i, part| {
        fill(blocks, quads, i * size, part).is_some()
    });
    if are_whole.contains(&false) {
        return None;
    }
    update(of_faces, |i, node| *node = outside[i].get());
    let kinds = [
        (CellKind::Hexahedron, 8, n_cells),
        (CellKind::Quadrilateral, 4, outside.len() / 4),
    ];
    Some(Cells::from_connectivity(nodes, kinds))
}

/// Finds the nodes of the cells from `first` on; `None` where one is no hexahedron.
fn fill(blocks: &Blocks, quads: &[[Label; 4]], first: usize, cells: &mut [[u32; 8]]) -> Option<()> {
    let mut found = vec![[0_u32; 6]; cells.len()];
    let mut counts = vec![0_u8; cells.len()];
    blocks.visit(&(first..first + cells.len()), |cell, face| {
        let count = &mut counts[cell];
        if let Some(own) = found[cell].get_mut(usize::from(*count)) {
            *own = face;
        }
        *count = count.saturating_add(1);
    });
    if counts.iter().any(|count| *count != 6) {
        return None;
    }
    for (cell, faces) in cells.iter_mut().zip(&found) {
        *cell = hexahedron(quads, faces)?;
    }
    Some(())
}

/// A face of a cell, turned outward.
#[inline]
fn outward(quads: &[[Label; 4]], face: u32) -> [u32; 4] {
    let [a, b, c, d] = quads[(face & !INWARD) as usize];
    let [a, b, c, d] = [a.get(), b.get(), c.get(), d.get()];
    match face & INWARD {
        0 => [a, b, c, d],
        _ => [a, d, c, b],
    }
}

/// The nodes of a hexahedron: those of its first face, seen from inside, then those above them.
#[inline]
fn hexahedron(quads: &[[Label; 4]], faces: &[u32; 6]) -> Option<[u32; 8]> {
    let [d, c, b, a] = outward(quads, faces[0]);
    let base = [a, b, c, d];
    let (mut above, mut below_next, mut sides) = ([0; 4], [0; 4], 0);
    let mut top = None;
    for face in &faces[1..] {
        let side = outward(quads, *face);
        let mut place = None;
        for corner in 0..4 {
            for edge in 0..4 {
                if side[corner] == base[edge] && side[(corner + 1) % 4] == base[(edge + 1) % 4] {
                    place = Some((corner, edge));
                }
            }
        }
        match place {
            Some((corner, edge)) => {
                above[(edge + 1) % 4] = side[(corner + 2) % 4];
                below_next[edge] = side[(corner + 3) % 4];
                sides |= 1 << edge;
            }
            None => top = Some(side),
        }
    }
    let top = top?;
    let turn = (0..4).find(|turn| top[*turn] == above[0])?;
    let is_closed = (0..4).all(|i| top[(turn + i) % 4] == above[i]);
    let nodes = [a, b, c, d, above[0], above[1], above[2], above[3]];
    let is_distinct = (0..8).all(|i| (i + 1..8).all(|j| nodes[i] != nodes[j]));
    (sides == 0b1111 && above == below_next && is_closed && is_distinct).then_some(nodes)
}

#[cfg(test)]
mod tests {
    use super::super::cells;
    use super::super::faces::Faces;
    use super::super::labels::Labels;
    use super::*;

    /// Two hexahedra side by side, as faces, owners and neighbours: the first face is between them.
    fn two() -> (Vec<[u32; 4]>, Vec<u32>, Vec<u32>) {
        // Nodes 0 to 3, 4 to 7 and 8 to 11 are one above the other.
        let sides = |low: u32| {
            (0..4).map(move |i| {
                [
                    low + i,
                    low + (i + 1) % 4,
                    low + 4 + (i + 1) % 4,
                    low + 4 + i,
                ]
            })
        };
        let mut faces = vec![[4, 5, 6, 7], [0, 3, 2, 1]];
        faces.extend(sides(0));
        faces.extend(sides(4));
        faces.push([8, 9, 10, 11]);
        (faces, vec![0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1], vec![1])
    }

    fn both(
        faces: &[[u32; 4]],
        owner: &[u32],
        neighbour: &[u32],
    ) -> (Option<Cells>, Option<Cells>) {
        let labels = |list: &[u32]| Labels::from(list.to_vec());
        let (owner, neighbour) = (labels(owner), labels(neighbour));
        let starts: Vec<u32> = (0..=faces.len()).map(|face| 4 * face as u32).collect();
        let faces = Faces::new(starts, faces.concat());
        let blocks = Blocks::new(owner.view(), neighbour.view());
        let one_by_one = cells::one_by_one(&blocks, faces.view(), 2, 0);
        (assemble(&blocks, faces.view(), 2), one_by_one.ok())
    }

    #[test]
    fn hexahedra_are_those_that_are_found_one_by_one() {
        let (faces, owner, neighbour) = two();
        // Every corner of a face may be the first, and every face of a cell the base.
        for turn in 0..4_usize.pow(6) {
            let mut turned = faces.clone();
            for (i, face) in turned.iter_mut().enumerate() {
                face.rotate_left(turn / 4_usize.pow(i as u32 % 6) % 4);
            }
            turned[1..6].rotate_left(turn % 5);
            turned[6..].rotate_left(turn / 5 % 5);
            let (found, expected) = both(&turned, &owner, &neighbour);
            assert_eq!(
                expected.as_ref().map(|cells| cells.get(1).kind),
                Some(CellKind::Hexahedron)
            );
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn faces_that_make_other_cells_are_left_to_the_general_way() {
        let (faces, owner, neighbour) = two();
        let is_refused = |faces: &[[u32; 4]], owner: &[u32]| {
            let (found, one_by_one) = both(faces, owner, &neighbour);
            let is_hexahedra = |cells: Cells| {
                let mut solid = cells.iter().take(2);
                solid.all(|cell| cell.kind == CellKind::Hexahedron)
            };
            assert!(!one_by_one.is_some_and(is_hexahedra), "{faces:?}");
            found.is_none()
        };
        let with = |face: usize, nodes: [u32; 4]| {
            let mut faces = faces.clone();
            faces[face] = nodes;
            faces
        };
        // Turned round, twice there, of another node, with a node twice, crossed; five faces and seven.
        assert!(is_refused(&with(1, [0, 1, 2, 3]), &owner));
        assert!(is_refused(&with(2, [4, 5, 1, 0]), &owner));
        assert!(is_refused(&with(2, [1, 2, 6, 5]), &owner));
        assert!(is_refused(&with(2, [0, 1, 5, 8]), &owner));
        assert!(is_refused(&with(2, [0, 0, 5, 4]), &owner));
        assert!(is_refused(&with(10, [8, 9, 11, 10]), &owner));
        assert!(is_refused(&with(10, [8, 9, 10, 5]), &owner));
        assert!(is_refused(&faces, &[0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1]));
    }
}

//! A mesh of tetrahedra or of hexahedra alone, straight from its faces. Faces are visited in one walk: each is added to
//! the cells on its two sides. The cells are the ones that `shapes` finds one by one.

use super::cells::{Blocks, INWARD};
use super::faces::{FacesView, Label};
use crate::mesh::{CellKind, Cells};
use azimesh_core::parallel::{map_items, n_threads, update};

/// Known parts of a tetrahedron: its three upper faces, by the edge that they have on the base, the base and the apex.
const SIDES: u8 = 0b111;
const BASE: u8 = 1 << 3;
const APEX: u8 = 1 << 4;
/// The faces make no tetrahedron.
const WRONG: u8 = 1 << 5;
/// All parts.
const WHOLE: u8 = BASE | APEX | SIDES;

/// The cells, then the faces on the boundary as cells; `None` where the cells are of other kinds.
pub(super) fn assemble(blocks: &Blocks, faces: FacesView, n_cells: usize) -> Option<Cells> {
    match faces.size {
        3 => cells(blocks, faces, n_cells, tetrahedra),
        4 => cells(blocks, faces, n_cells, hexahedra),
        _ => None,
    }
}

/// Finds the nodes of the cells from some cell on; `None` where one is of another kind.
type Fill<const F: usize, const N: usize> =
    fn(&Blocks, &[[Label; F]], usize, &mut [[u32; N]]) -> Option<()>;

/// Cells of `N` nodes and, on the boundary, faces of `F` nodes.
fn cells<const F: usize, const N: usize>(
    blocks: &Blocks,
    faces: FacesView,
    n_cells: usize,
    fill: Fill<F, N>,
) -> Option<Cells> {
    let (kind, face_kind) = match F {
        3 => (CellKind::Tetrahedron, CellKind::Triangle),
        _ => (CellKind::Hexahedron, CellKind::Quadrilateral),
    };
    let n_inside = blocks.neighbour.len();
    if n_cells.checked_mul(kind.faces().len()) != Some(blocks.owner.len() + n_inside) {
        return None;
    }
    let all = faces.nodes.as_chunks::<F>().0;
    let outside = &faces.nodes[F * n_inside..];
    let mut nodes = vec![0; N * n_cells + outside.len()];
    let (of_cells, of_faces) = nodes.split_at_mut(N * n_cells);
    // Each task walks through the faces of its cells, and faces of all cells may be among them: so there are few.
    let size = n_cells.div_ceil(n_threads()).max(1);
    let parts = of_cells.as_chunks_mut::<N>().0.chunks_mut(size);
    let filled = map_items(parts, &|i, part| fill(blocks, all, i * size, part));
    if filled.contains(&None) {
        return None;
    }
    update(of_faces, |i, node| *node = outside[i].get());
    Some(Cells::from_connectivity(
        nodes,
        [(kind, N, n_cells), (face_kind, F, outside.len() / F)],
    ))
}

/// A face of a cell, turned outward.
#[inline]
fn outward<const F: usize>(faces: &[[Label; F]], face: u32) -> [u32; F] {
    let mut nodes = faces[(face & !INWARD) as usize].map(Label::get);
    if face & INWARD != 0 {
        nodes[1..].reverse();
    }
    nodes
}

fn tetrahedra(
    blocks: &Blocks,
    triangles: &[[Label; 3]],
    first: usize,
    cells: &mut [[u32; 4]],
) -> Option<()> {
    let mut known = vec![0; cells.len()];
    blocks.visit(&(first..first + cells.len()), |cell, face| {
        add(&mut cells[cell], &mut known[cell], outward(triangles, face));
    });
    known.iter().all(|known| *known == WHOLE).then_some(())
}

/// The nodes of a tetrahedron, whose faces are turned outward: the base seen from inside, then the apex.
pub(super) fn tetrahedron(faces: [[u32; 3]; 4]) -> Option<[u32; 4]> {
    let (mut nodes, mut known) = ([0; 4], 0);
    for face in faces {
        add(&mut nodes, &mut known, face);
    }
    (known == WHOLE).then_some(nodes)
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

fn hexahedra(
    blocks: &Blocks,
    quads: &[[Label; 4]],
    first: usize,
    cells: &mut [[u32; 8]],
) -> Option<()> {
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
        *cell = hexahedron(faces.map(|face| outward(quads, face)))?;
    }
    Some(())
}

/// The nodes of a hexahedron, whose faces are turned outward: the first face, seen from inside, then the nodes above it.
#[inline]
pub(super) fn hexahedron(faces: [[u32; 4]; 6]) -> Option<[u32; 8]> {
    let [d, c, b, a] = faces[0];
    let base = [a, b, c, d];
    let (mut above, mut below_next, mut sides) = ([0; 4], [0; 4], 0);
    let mut top = None;
    for side in &faces[1..] {
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
            None => top = Some(*side),
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
    use super::super::faces::{Faces, Labels};
    use super::*;

    /// The cells of faces, and the cells that are found one by one.
    fn both<const F: usize>(
        faces: &[[u32; F]],
        owner: &[u32],
        neighbour: &[u32],
    ) -> (Option<Cells>, Option<Cells>) {
        let labels = |list: &[u32]| Labels::from(list.to_vec());
        let (owner, neighbour) = (labels(owner), labels(neighbour));
        let starts: Vec<u32> = (0..=faces.len()).map(|face| (F * face) as u32).collect();
        let faces = Faces::new(starts, faces.concat());
        let blocks = Blocks::new(owner.view(), neighbour.view());
        let one_by_one = cells::one_by_one(&blocks, faces.view(), 2, 0);
        (assemble(&blocks, faces.view(), 2), one_by_one.ok())
    }

    fn are_all(cells: Option<&Cells>, kind: CellKind) -> bool {
        cells.is_some_and(|cells| cells.iter().take(2).all(|cell| cell.kind == kind))
    }

    /// Two tetrahedra with a face in common, as faces, owners and neighbours.
    fn two_tetrahedra() -> (Vec<[u32; 3]>, Vec<u32>, Vec<u32>) {
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

    #[test]
    fn tetrahedra_are_those_that_are_found_one_by_one() {
        let (faces, owner, neighbour) = two_tetrahedra();
        // Every corner of a face may be the first, and every face of a cell the base.
        for turn in 0..3usize.pow(7) {
            let mut turned = faces.clone();
            for (i, face) in turned.iter_mut().enumerate() {
                face.rotate_left(turn / 3usize.pow(i as u32) % 3);
            }
            turned[1..4].rotate_left(turn % 3);
            turned[4..].rotate_left(turn / 3 % 3);
            let (found, expected) = both(&turned, &owner, &neighbour);
            assert!(are_all(expected.as_ref(), CellKind::Tetrahedron));
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn faces_that_make_no_tetrahedra_are_left_to_the_general_way() {
        let (faces, owner, neighbour) = two_tetrahedra();
        let is_refused = |faces: &[[u32; 3]], owner: &[u32]| {
            let (found, one_by_one) = both(faces, owner, &neighbour);
            assert!(!are_all(one_by_one.as_ref(), CellKind::Tetrahedron));
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

    /// Two hexahedra side by side, as faces, owners and neighbours: the first face is between them.
    fn two_hexahedra() -> (Vec<[u32; 4]>, Vec<u32>, Vec<u32>) {
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

    #[test]
    fn hexahedra_are_those_that_are_found_one_by_one() {
        let (faces, owner, neighbour) = two_hexahedra();
        // Every corner of a face may be the first, and every face of a cell the base.
        for turn in 0..4_usize.pow(6) {
            let mut turned = faces.clone();
            for (i, face) in turned.iter_mut().enumerate() {
                face.rotate_left(turn / 4_usize.pow(i as u32 % 6) % 4);
            }
            turned[1..6].rotate_left(turn % 5);
            turned[6..].rotate_left(turn / 5 % 5);
            let (found, expected) = both(&turned, &owner, &neighbour);
            assert!(are_all(expected.as_ref(), CellKind::Hexahedron));
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn faces_that_make_no_hexahedra_are_left_to_the_general_way() {
        let (faces, owner, neighbour) = two_hexahedra();
        let is_refused = |faces: &[[u32; 4]], owner: &[u32]| {
            let (found, one_by_one) = both(faces, owner, &neighbour);
            assert!(!are_all(one_by_one.as_ref(), CellKind::Hexahedron));
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

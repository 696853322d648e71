//! Orientations of cells relative to their neighbours.
//!
//! Two cells that share a face list its nodes in opposite directions, unless the nodes of one of them are in reverse order.
//! A cell that was turned over by moving its nodes still agrees with its neighbours.

use super::connected::UnionFind;
use super::sides::for_each_side;
use super::{Across, Adjacency, Mesh};
use azimesh_core::parallel::map;

/// The orientation of every volume cell, 1 or -1, from those that are known: `known` gives 1 or -1, or 0. Each connected
/// part of the mesh has the orientations with which most of its known cells agree; 0 for other cells. The work grows with
/// the number of cells.
pub fn orientations(
    mesh: &Mesh,
    adjacency: &Adjacency,
    known: &(dyn Fn(usize) -> i8 + Sync),
) -> Vec<i8> {
    let n_cells = mesh.cells.len();
    let volume_cells = || {
        mesh.volume_runs()
            .flat_map(|run| run.first_cell..run.first_cell + run.n_cells())
    };
    let has = |sign: i8| volume_cells().any(|cell| known(cell) == sign);
    let mut found = vec![0; n_cells];
    if !(has(1) && has(-1)) {
        let sign = if has(-1) { -1 } else { 1 };
        volume_cells().for_each(|cell| found[cell] = sign);
        return found;
    }
    // A number for each cell with each orientation: numbers that agree are joined.
    let number = |cell: usize, sign: i8| 2 * cell as u32 + u32::from(sign < 0);
    let mut parts = UnionFind::new(2 * n_cells);
    for (a, b, agree) in map(adjacency.n_chunks(), &|chunk| pairs(mesh, adjacency, chunk)).concat()
    {
        let other = if agree { 1 } else { -1 };
        for sign in [1, -1] {
            parts.join(&[number(a as usize, sign), number(b as usize, sign * other)]);
        }
    }
    let mut votes = vec![0u32; 2 * n_cells];
    for cell in volume_cells().filter(|&cell| known(cell) != 0) {
        votes[parts.of(number(cell, known(cell))) as usize] += 1;
    }
    for cell in volume_cells() {
        let mut votes_for = |sign| votes[parts.of(number(cell, sign)) as usize];
        found[cell] = if votes_for(-1) > votes_for(1) { -1 } else { 1 };
    }
    found
}

/// Pairs of cells that share a face, the first one in the chunk, and whether they list the face in opposite directions.
fn pairs(mesh: &Mesh, adjacency: &Adjacency, chunk: usize) -> Vec<(u32, u32, bool)> {
    let (cells, mut sides) = adjacency.chunk(chunk);
    let mut found = Vec::new();
    for run in mesh.volume_runs_in(cells) {
        for cell in run.cell_refs() {
            for_each_side(&mesh.cells, &cell, |_, corners| {
                if let Across::Cell(other) = sides.across()
                    && let Some(agree) = agrees(mesh, other, corners)
                {
                    found.push((cell.index as u32, other, agree));
                }
            });
        }
    }
    found
}

/// Returns whether a cell lists a face with these corners in the opposite direction; `None` if it does not have the face.
fn agrees(mesh: &Mesh, cell: u32, face: &[u32]) -> Option<bool> {
    let cell = mesh.cells.get(cell as usize);
    let mut found = None;
    for_each_side(&mesh.cells, &cell, |_, corners| {
        if found.is_none() && face.iter().all(|node| corners.contains(node)) {
            found = Some(is_opposite(face, corners));
        }
    });
    found
}

/// Returns whether a ring of nodes runs in the opposite direction to another one. An edge runs from its first node.
fn is_opposite(ring: &[u32], other: &[u32]) -> bool {
    match ring.len() {
        2 => other[0] != ring[0],
        _ => after(ring, ring[0]) != after(other, ring[0]),
    }
}

/// The node that follows on `first` in a ring, in which a node may be listed twice.
fn after(ring: &[u32], first: u32) -> Option<u32> {
    let twice = ring.iter().chain(ring).copied();
    let from_first = twice.skip_while(|&node| node != first);
    from_first.into_iter().find(|&node| node != first)
}

#[cfg(test)]
mod tests {
    use super::super::CellKind;
    use super::*;

    /// A row of hexahedra or squares, some listed in the other orientation.
    fn row(n: u32, solid: bool, reversed: &[u32]) -> Mesh {
        let mut mesh = Mesh::default();
        for i in 0..n {
            let ring = |i: u32| [0, 1, 2, 3].map(|k| 4 * i + k);
            let (mut a, mut b) = (ring(i), ring(i + 1));
            if reversed.contains(&i) {
                (a, b) = (b, a);
            }
            if solid {
                mesh.cells.push(CellKind::Hexahedron, &[a, b].concat())
            } else {
                mesh.cells
                    .push(CellKind::Quadrilateral, &[a[0], b[0], b[1], a[1]])
            }
        }
        mesh.points = vec![[0.0; 3]; 4 * n as usize + 4];
        mesh
    }

    #[test]
    fn a_reversed_cell_and_a_folded_one_are_told_from_each_other_by_their_neighbours() {
        for solid in [true, false] {
            let mesh = row(7, solid, &[2, 3]);
            // Cell 5 is folded where it is, cell 6 is not known.
            let signs = [1, 1, -1, -1, 1, -1, 0];
            let found = orientations(&mesh, &Adjacency::of(&mesh), &|cell| signs[cell]);
            assert_eq!(found, [1, 1, -1, -1, 1, 1, 1], "solid: {solid}");
            let mirrored = signs.map(|sign| -sign);
            let found = orientations(&mesh, &Adjacency::of(&mesh), &|cell| mirrored[cell]);
            assert_eq!(found, [-1, -1, 1, 1, -1, -1, -1], "solid: {solid}");
        }
    }

    #[test]
    fn each_connected_part_has_its_own_orientation() {
        let mut mesh = row(3, true, &[]);
        let other = row(3, true, &[]);
        let shift = mesh.points.len() as u32;
        for cell in 0..3 {
            let nodes: Vec<u32> = other
                .cells
                .get(cell)
                .nodes
                .iter()
                .map(|node| node + shift)
                .collect();
            mesh.cells.push(CellKind::Hexahedron, &nodes);
        }
        mesh.points.extend(other.points);
        let signs = [1, 1, -1, -1, 0, -1];
        let found = orientations(&mesh, &Adjacency::of(&mesh), &|cell| signs[cell]);
        assert_eq!(found, [1, 1, 1, -1, -1, -1]);
    }

    #[test]
    fn a_face_with_a_node_twice_goes_round_as_its_triangle_does() {
        for ring in [[0, 1, 1, 2], [0, 0, 1, 2], [2, 0, 0, 1], [0, 1, 2, 0]] {
            assert!(
                is_opposite(&ring, &[2, 1, 0]) && is_opposite(&[2, 1, 0], &ring),
                "{ring:?}"
            );
            assert!(
                !is_opposite(&ring, &[0, 1, 2]) && !is_opposite(&[1, 2, 0], &ring),
                "{ring:?}"
            );
        }
    }
}

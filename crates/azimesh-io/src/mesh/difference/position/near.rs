//! Nodes that are near each other, of those that share no place with any.

use super::Pairing;
use crate::mesh::near::Grid;
use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::point;
use azimesh_core::parallel::{block, try_map};

/// Edge of a box of the grid, in distances within which nodes belong together.
const BOX: f64 = 16.0;
/// Largest number of nodes of the second mesh in the boxes around a node of the first; with more, `within` is too large.
const MOST: usize = 1000;
/// Nodes that are looked at in one go.
const CHUNK: usize = 1 << 14;

/// Pairs nodes that have no other near them; others become candidates.
pub fn pair(a: &[[f64; 3]], b: &[[f64; 3]], within: f64, pairing: &mut Pairing) -> Result<()> {
    let [ours, theirs] = [0, 1].map(|mesh| left(pairing, mesh));
    if ours.is_empty() || theirs.is_empty() {
        return Ok(());
    }
    let grid = Grid::of(b, &theirs, within, BOX, MOST);
    let near = try_map(ours.len().div_ceil(CHUNK), &|i| {
        let mut near = Vec::new();
        for &node in &ours[block(ours.len(), CHUNK, i)] {
            let at = a[node as usize];
            let seen = grid.visit(at, |other| {
                let apart = [0, 1, 2].map(|i| at[i] - b[other as usize][i]);
                let squared: f64 = apart.iter().map(|x| x * x).sum();
                if squared <= within * within {
                    near.push((squared, node, other));
                }
            });
            if !seen {
                return Err(too_wide(node, at, within));
            }
        }
        Ok(near)
    })?
    .concat();
    let mut n_near = [vec![0u32; a.len()], vec![0u32; b.len()]];
    for (_, i, j) in &near {
        n_near[0][*i as usize] += 1;
        n_near[1][*j as usize] += 1;
    }
    for (squared, i, j) in near {
        if n_near[0][i as usize] == 1 && n_near[1][j as usize] == 1 {
            pairing.pair(i, j)
        } else {
            pairing.candidates.push((squared, i, j))
        }
    }
    Ok(())
}

/// Nodes of a mesh with no partner and at no shared place.
fn left(pairing: &Pairing, mesh: usize) -> Vec<u32> {
    let mut is_shared = vec![false; pairing.partners[mesh].len()];
    for (_, node) in &pairing.shared[mesh] {
        is_shared[*node as usize] = true;
    }
    let nodes = 0..is_shared.len() as u32;
    let is_left = |node: &u32| pairing.is_free(mesh, *node) && !is_shared[*node as usize];
    nodes.filter(is_left).collect()
}

fn too_wide(node: u32, at: [f64; 3], within: f64) -> Error {
    Error::input(format!(
        "nodes cannot be matched within {within:e}: more than {MOST} nodes of the second mesh \
         are near node {node} of the first at {}; use a smaller --match-tolerance",
        point(&at)
    ))
}

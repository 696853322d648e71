//! Nodes that are near each other, of those that share no place with any.

use super::Pairing;
use super::keys::{Keys, mixed};
use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::point;
use azimesh_core::parallel::{block, collect, sort, try_map};

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
    let grid = Grid::of(b, &theirs, within);
    let near = try_map(ours.len().div_ceil(CHUNK), &|i| {
        let mut near = Vec::new();
        for &node in &ours[block(ours.len(), CHUNK, i)] {
            let at = a[node as usize];
            let seen = grid.visit(at, within, |other| {
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

/// Nodes in boxes of a grid, by a key of the box.
struct Grid {
    edge: f64,
    keys: Keys,
    /// Index of the first key with each value of the leading bits.
    starts: Vec<u32>,
    shift: u32,
}

impl Grid {
    fn of(points: &[[f64; 3]], nodes: &[u32], within: f64) -> Self {
        let sizes = nodes.iter().flat_map(|&node| points[node as usize]);
        let largest = sizes.fold(0.0, |largest: f64, x| largest.max(x.abs()));
        // Boxes so small that their numbers are no whole numbers would hold everything at once.
        let edge = (BOX * within).max(1e-12 * largest);
        let mut keys: Keys = collect(nodes.len(), |i| {
            let corner = points[nodes[i] as usize].map(|x| (x / edge).floor());
            (key(corner), nodes[i])
        });
        sort(&mut keys);
        let n_leading = nodes.len().ilog2().clamp(1, 24);
        let shift = 64 - n_leading;
        let mut starts = vec![0; (1 << n_leading) + 1];
        for (key, _) in &keys {
            starts[(key >> shift) as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        Self {
            edge,
            keys,
            starts,
            shift,
        }
    }

    /// Calls `visit` for each node in the boxes that hold places at most `within` from a place;
    /// `false`, and none or some of them, where there are too many.
    fn visit(&self, at: [f64; 3], within: f64, mut visit: impl FnMut(u32)) -> bool {
        let low = at.map(|x| ((x - within) / self.edge).floor());
        let high = at.map(|x| ((x + within) / self.edge).floor());
        let mut n_seen = 0;
        for corner in 0..8 {
            let takes_high = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
            if (0..3).any(|axis| takes_high[axis] && low[axis] == high[axis]) {
                continue;
            }
            let place = [0, 1, 2].map(|axis| {
                if takes_high[axis] {
                    high[axis]
                } else {
                    low[axis]
                }
            });
            let nodes = self.in_box(key(place));
            n_seen += nodes.len();
            if n_seen > MOST {
                return false;
            }
            nodes.iter().for_each(|(_, node)| visit(*node));
        }
        true
    }

    fn in_box(&self, key: u64) -> &[(u64, u32)] {
        let leading = (key >> self.shift) as usize;
        let alike = &self.keys[self.starts[leading] as usize..self.starts[leading + 1] as usize];
        let from = alike.partition_point(|(other, _)| *other < key);
        let n = alike[from..].iter().take_while(|(other, _)| *other == key);
        &alike[from..from + n.count()]
    }
}

fn key(corner: [f64; 3]) -> u64 {
    let corner = corner.map(|x| (x + 0.0).to_bits());
    corner.into_iter().fold(0, |key, x| mixed(key ^ x))
}

//! Pairs nodes that their positions leave undecided, by means of their cells.
//!
//! Every node has the label of its pair or of its place. An undecided node repeatedly mixes the labels of its cells' nodes
//! into its own, while this distinguishes more nodes (colour refinement; Weisfeiler and Leman, 1968). Nodes with the same
//! label are paired.

use super::Pairing;
use super::keys::mixed;
use crate::mesh::Cells;
use crate::mesh::difference::partners::NONE;
use azimesh_core::parallel::{collect, map_blocks};

/// Times that labels are taken up at most.
const ROUNDS: usize = 8;
/// First labels of places, of nodes with candidates and of nodes without. Smaller labels are nodes of the first mesh.
const PLACES: u64 = 1 << 32;
const CANDIDATE: u64 = 2 << 32;
const ALONE: u64 = 3 << 32;

/// Pairs the nodes that are undecided; gives the number of those that were paired in order, as
/// nothing distinguishes them.
pub fn pair(a: &Cells, b: &Cells, pairing: &mut Pairing) -> usize {
    if pairing.candidates.is_empty() && pairing.shared.iter().all(Vec::is_empty) {
        return 0;
    }
    let [ours, theirs] = labels(a, b, pairing);
    pair_candidates(pairing, &ours, &theirs);
    pair_shared(pairing, &ours, &theirs)
}

/// Labels of all nodes of both meshes.
fn labels(a: &Cells, b: &Cells, pairing: &Pairing) -> [Vec<u64>; 2] {
    let mut ours = Labels::first(a, pairing, 0);
    let mut theirs = Labels::first(b, pairing, 1);
    let mut n_labels = 0;
    for _ in 0..ROUNDS {
        ours.take_up(a);
        theirs.take_up(b);
        let n = ours.count();
        if n == n_labels {
            break;
        }
        n_labels = n;
    }
    [ours.labels, theirs.labels]
}

/// The labels of one mesh.
struct Labels {
    labels: Vec<u64>,
    undecided: Vec<u32>,
    is_undecided: Vec<bool>,
    /// Cells with an undecided node.
    cells: Vec<usize>,
    /// Sum over the cells of each undecided node.
    sums: Vec<u64>,
}

impl Labels {
    fn first(cells: &Cells, pairing: &Pairing, mesh: usize) -> Self {
        let partners = &pairing.partners[mesh];
        let mut labels = collect(partners.len(), |node| match (partners[node], mesh) {
            (NONE, _) => mixed(ALONE),
            (_, 0) => mixed(node as u64),
            (partner, _) => mixed(partner.into()),
        });
        let mut undecided = Vec::new();
        for (place, node) in &pairing.shared[mesh] {
            labels[*node as usize] = mixed(PLACES + u64::from(*place));
            undecided.push(*node);
        }
        for (_, i, j) in &pairing.candidates {
            let node = [*i, *j][mesh];
            labels[node as usize] = mixed(CANDIDATE);
            undecided.push(node);
        }
        undecided.sort_unstable();
        undecided.dedup();
        let mut is_undecided = vec![false; labels.len()];
        for node in &undecided {
            is_undecided[*node as usize] = true;
        }
        Self {
            sums: vec![0; labels.len()],
            cells: with_any(cells, &is_undecided),
            labels,
            undecided,
            is_undecided,
        }
    }

    fn take_up(&mut self, cells: &Cells) {
        for cell in self.cells.iter().map(|&cell| cells.get(cell)) {
            let labels = cell.nodes.iter().map(|&node| self.labels[node as usize]);
            let kind = u64::from(cell.kind.vtk());
            let label = mixed(labels.fold(kind, u64::wrapping_add));
            for &node in cell.nodes {
                if self.is_undecided[node as usize] {
                    let sum = &mut self.sums[node as usize];
                    *sum = sum.wrapping_add(label);
                }
            }
        }
        for &node in &self.undecided {
            let sum = std::mem::take(&mut self.sums[node as usize]);
            let label = &mut self.labels[node as usize];
            *label = mixed(*label ^ mixed(sum));
        }
    }

    /// Number of labels that undecided nodes have.
    fn count(&self) -> usize {
        let of = |node: &u32| self.labels[*node as usize];
        let mut labels: Vec<u64> = self.undecided.iter().map(of).collect();
        labels.sort_unstable();
        labels.dedup();
        labels.len()
    }
}

/// Cells with a node of those marked.
fn with_any(cells: &Cells, marked: &[bool]) -> Vec<usize> {
    const CHUNK: usize = 1 << 14;
    let found = map_blocks(cells.len(), CHUNK, &|range| {
        let runs = cells.runs_in(range).flat_map(|run| {
            let numbered = (run.first_cell..).zip(run.cells());
            numbered.filter(|(_, nodes)| nodes.iter().any(|node| marked[*node as usize]))
        });
        runs.map(|(cell, _)| cell).collect::<Vec<_>>()
    });
    found.concat()
}

/// Candidates with one label first, then the nearest.
fn pair_candidates(pairing: &mut Pairing, ours: &[u64], theirs: &[u64]) {
    let mut candidates = std::mem::take(&mut pairing.candidates);
    let differ = |i: u32, j: u32| ours[i as usize] != theirs[j as usize];
    candidates.sort_unstable_by(|x, y| {
        let [p, q] = [x, y].map(|(_, i, j)| differ(*i, *j));
        let by_distance = p.cmp(&q).then(x.0.total_cmp(&y.0));
        by_distance.then((x.1, x.2).cmp(&(y.1, y.2)))
    });
    for (_, i, j) in candidates {
        if pairing.is_free(0, i) && pairing.is_free(1, j) {
            pairing.pair(i, j);
        }
    }
}

/// Nodes at one place: those with one label, then what is left, in order. Gives the number of those
/// that the order decided.
fn pair_shared(pairing: &mut Pairing, ours: &[u64], theirs: &[u64]) -> usize {
    let shared = std::mem::take(&mut pairing.shared);
    let by_label = |mesh: usize, labels: &[u64]| {
        let nodes = shared[mesh].iter();
        let mut nodes: Vec<_> = nodes
            .map(|&(place, node)| ((place, labels[node as usize]), node))
            .collect();
        nodes.sort_unstable();
        nodes
    };
    let mut n_in_order = pair_alike(pairing, &by_label(0, ours), &by_label(1, theirs));
    let [x, y] = [0, 1].map(|mesh| {
        let nodes = shared[mesh].iter();
        let free = nodes.filter(|(_, node)| pairing.is_free(mesh, *node));
        free.copied().collect::<Vec<_>>()
    });
    n_in_order += pair_alike(pairing, &x, &y);
    n_in_order
}

/// Pairs nodes with one key in order; both are sorted. Gives the number of nodes of the first that
/// had a choice.
fn pair_alike<K: Ord + Copy>(pairing: &mut Pairing, x: &[(K, u32)], y: &[(K, u32)]) -> usize {
    let mut n_in_order = 0;
    let mut rest = y;
    for alike in x.chunk_by(|p, q| p.0 == q.0) {
        let key = alike[0].0;
        rest = &rest[rest.partition_point(|entry| entry.0 < key)..];
        let n = rest.partition_point(|entry| entry.0 == key);
        for ((_, i), (_, j)) in alike.iter().zip(&rest[..n]) {
            pairing.pair(*i, *j);
        }
        if alike.len().max(n) > 1 && n > 0 {
            n_in_order += alike.len().min(n);
        }
    }
    n_in_order
}

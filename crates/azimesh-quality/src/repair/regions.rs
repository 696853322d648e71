//! Groups cells into patches: folded ones and rings of neighbours around them, split into parts that do not touch.

use super::freedom::Freedom;
use super::nearby::{Marked, Nearby};
use azimesh_core::parallel;
use azimesh_io::mesh::Mesh;

/// A part of the mesh that is solved by itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Region {
    /// Its cells: all that have a node that moves. Ascending.
    pub cells: Vec<u32>,
    /// Nodes that move, ascending.
    pub moving: Vec<u32>,
    /// Cells that it was grown from, ascending.
    pub seeds: Vec<u32>,
}

/// The regions of `rings` rings around the cells `seeds`, which are ascending, and the seeds that have no
/// node that could move.
pub(super) fn around(
    nearby: &Nearby<'_>,
    freedom: &Freedom,
    seeds: &[u32],
    rings: usize,
) -> (Vec<Region>, Vec<u32>) {
    let mesh = nearby.mesh();
    let mut marked = Marked::new(mesh.points.len());
    mark(mesh, freedom, seeds, &mut marked);
    for _ in 0..rings {
        let touched = nearby.cells_with(&marked, &|_| true);
        mark(mesh, freedom, &touched, &mut marked);
    }
    let moves = |node: u32| marked.has(node) && !freedom.is_fixed(node);
    let cells = nearby.cells_with(&marked, &moves);
    let mut moving: Vec<u32> = Vec::new();
    for &cell in &cells {
        let nodes = mesh.cells.get(cell as usize).nodes;
        moving.extend(nodes.iter().copied().filter(|&node| moves(node)));
    }
    parallel::sort(&mut moving);
    moving.dedup();
    split(mesh, freedom, seeds, cells, moving)
}

/// Marks the nodes of cells, and their partners.
fn mark(mesh: &Mesh, freedom: &Freedom, cells: &[u32], marked: &mut Marked) {
    for &cell in cells {
        for &node in mesh.cells.get(cell as usize).nodes {
            marked.insert(node);
        }
    }
    let partners = freedom.partners();
    // From followers to leaders, then to all followers of these.
    for partner in partners
        .iter()
        .filter(|partner| marked.has(partner.node))
        .map(|partner| partner.leader)
        .collect::<Vec<_>>()
    {
        marked.insert(partner);
    }
    for partner in partners {
        if marked.has(partner.leader) {
            marked.insert(partner.node);
        }
    }
}

/// Cuts a region into parts that share no node that moves.
fn split(
    mesh: &Mesh,
    freedom: &Freedom,
    seeds: &[u32],
    cells: Vec<u32>,
    moving: Vec<u32>,
) -> (Vec<Region>, Vec<u32>) {
    let mut parts = Parts::new(moving.len());
    let place = |node: u32| moving.binary_search(&node).ok();
    let mut first_of_cell = Vec::with_capacity(cells.len());
    for &cell in &cells {
        let nodes = mesh.cells.get(cell as usize).nodes;
        let mut own = nodes.iter().filter_map(|&node| place(node));
        let first = own.next().expect("it has a node that moves");
        own.for_each(|other| parts.join(first, other));
        first_of_cell.push(first);
    }
    for partner in freedom.partners() {
        if let (Some(a), Some(b)) = (place(partner.node), place(partner.leader)) {
            parts.join(a, b);
        }
    }
    // Parts in the order of their lowest nodes.
    let mut number = vec![usize::MAX; moving.len()];
    let mut regions: Vec<Region> = Vec::new();
    for (at, &node) in moving.iter().enumerate() {
        let root = parts.root(at);
        if number[root] == usize::MAX {
            number[root] = regions.len();
            regions.push(Region::default());
        }
        regions[number[root]].moving.push(node);
    }
    for (&cell, &first) in cells.iter().zip(&first_of_cell) {
        regions[number[parts.root(first)]].cells.push(cell);
    }
    let mut stuck = Vec::new();
    for &seed in seeds {
        match cells.binary_search(&seed) {
            Ok(at) => regions[number[parts.root(first_of_cell[at])]]
                .seeds
                .push(seed),
            Err(_) => stuck.push(seed),
        }
    }
    (regions, stuck)
}

/// Sets that are joined.
struct Parts {
    above: Vec<u32>,
}

impl Parts {
    fn new(n: usize) -> Self {
        Self {
            above: (0..n as u32).collect(),
        }
    }

    fn root(&mut self, mut at: usize) -> usize {
        while self.above[at] as usize != at {
            self.above[at] = self.above[self.above[at] as usize];
            at = self.above[at] as usize;
        }
        at
    }

    /// The lower root becomes the root of both.
    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.above[a.max(b)] = a.min(b) as u32;
    }
}

//! Nodes of two meshes paired by their places, cells by their nodes: for meshes that are numbered
//! differently.
//!
//! Nodes at the very same place first, then the nearest of those that are left. Where several nodes
//! of a mesh may be meant, their cells decide.

mod cells;
mod keys;
mod labels;
mod near;
mod places;

pub use cells::cells;

use super::super::Mesh;
use super::partners::{NONE, Partners};
use azimesh_core::error::Result;
use azimesh_core::numbers::point;
use azimesh_core::{Note, note};

/// Pairs of nodes of two meshes.
#[derive(Debug)]
pub struct Paired {
    /// The partner of each node of the first mesh.
    pub partners: Partners,
    /// The partner of each node of the second mesh, or [`NONE`].
    pub back: Vec<u32>,
    /// Nodes of each without a partner.
    pub n_unpaired: [usize; 2],
    /// A sentence for each mesh with such nodes.
    pub sentences: Vec<String>,
    /// Nodes that were paired by their order.
    pub notes: Vec<Note>,
}

/// The pairs that are known so far.
#[derive(Debug)]
struct Pairing {
    /// The partner of each node of the first mesh, and of the second.
    partners: [Vec<u32>; 2],
    /// Places with several nodes of a mesh: (number of the place, node), ascending, of each mesh.
    shared: [Vec<(u32, u32)>; 2],
    /// Nodes that may be meant by one another: (square of their distance, first, second).
    candidates: Vec<(f64, u32, u32)>,
}

impl Pairing {
    fn pair(&mut self, a: u32, b: u32) {
        self.partners[0][a as usize] = b;
        self.partners[1][b as usize] = a;
    }

    fn is_free(&self, mesh: usize, node: u32) -> bool {
        self.partners[mesh][node as usize] == NONE
    }
}

/// Pairs the nodes of two meshes within a distance of `within`.
pub fn nodes(a: &Mesh, b: &Mesh, within: f64) -> Result<Paired> {
    let mut pairing = places::pair(&a.points, &b.points);
    if within > 0.0 {
        near::pair(&a.points, &b.points, within, &mut pairing)?;
    }
    let notes = match labels::pair(&a.cells, &b.cells, &mut pairing) {
        0 => Vec::new(),
        n => vec![note!(
            "paired_in_order",
            "nodes at the same place ({n}) that their cells do not distinguish are paired in order"
        )],
    };
    let [partners, back] = pairing.partners;
    let mut sentences = Vec::new();
    let mut n_unpaired = [0; 2];
    for (mesh, partners, which, other) in [
        (a, &partners, 0, ["first", "second"]),
        (b, &back, 1, ["second", "first"]),
    ] {
        let mut alone = (0..partners.len()).filter(|&node| partners[node] == NONE);
        let Some(first) = alone.next() else { continue };
        n_unpaired[which] = 1 + alone.count();
        let [here, there] = other;
        sentences.push(format!(
            "nodes of the {here} mesh without a node of the {there} within {within:e}: {}, first {first} at {}",
            n_unpaired[which],
            point(&mesh.points[first])
        ));
    }
    Ok(Paired {
        partners: Partners::Listed(partners),
        back,
        n_unpaired,
        sentences,
        notes,
    })
}

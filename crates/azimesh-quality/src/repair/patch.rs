//! A patch: some cells, the nodes of them that move, and the sparse matrix over these.
//!
//! Knows the unknown of a node, its constraint and its leader. Sums go over the cells in order, whatever the
//! number of threads.

use super::density::Space;
use super::derivatives::{Derivatives, Sum, pair, transposed};
use super::elements::Elements;
use super::freedom::{Freedom, allowed};
use super::numbering::{NONE, order, pairs};
use azimesh_core::geometry::transform::Matrix;
use azimesh_core::geometry::vector::{Vector, add, dot};
use azimesh_core::linear::blocks::{Block, Blocks};
use azimesh_core::parallel::{self, Scratch};
use azimesh_rbf::constraint::Constraint;
use std::collections::BTreeMap;

/// Cells whose values are added up as one.
const BLOCK: usize = 64;
/// Cells whose derivatives are held at once.
const WAVE: usize = 1024;
/// As long as these have no more pairs of nodes than this.
const MOST_BLOCKS: usize = 1 << 20;
/// Set in a slot of a block that is added transposed.
const TURNED: u32 = 1 << 31;

/// A part of a mesh that is solved by itself.
pub(super) struct Patch {
    space: Space,
    /// Mesh node of each node of the patch, ascending.
    pub nodes: Vec<u32>,
    /// Places of the nodes.
    pub places: Vec<Vector>,
    /// The unknown of each node.
    unknown: Vec<u32>,
    /// Nodes that have the displacement of their unknown, rotated.
    turned: BTreeMap<u32, Matrix>,
    /// Constraints of the unknowns.
    held: BTreeMap<u32, Constraint>,
    pub elements: Elements,
    matrix: Blocks,
    /// For each pair of nodes of each cell, the slot below the diagonal.
    slots: Vec<u32>,
    first_slot: Vec<usize>,
}

/// The functional at some positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct State {
    /// Its value.
    pub value: f64,
    /// The least determinant of a simplex, relative to its target.
    pub least: f64,
    /// Simplices that are not positive.
    pub n_folded: usize,
}

impl State {
    const EMPTY: Self = Self {
        value: 0.0,
        least: f64::INFINITY,
        n_folded: 0,
    };

    fn plus(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            least: self.least.min(other.least),
            n_folded: self.n_folded + other.n_folded,
        }
    }
}

impl Patch {
    /// A patch of `elements` on these mesh nodes, ascending; nodes in `moving` move.
    pub(super) fn new(
        space: Space,
        nodes: Vec<u32>,
        places: Vec<Vector>,
        moving: &[u32],
        freedom: &Freedom,
        elements: Elements,
    ) -> Self {
        let moves = |node: u32| moving.binary_search(&node).is_ok();
        let local = |node: u32| nodes.binary_search(&node).ok();
        let leader = |node: u32| freedom.partner(node).map_or(node, |partner| partner.leader);
        // An unknown for each leader, in the order of the nodes; then put in the order of Cuthill and McKee.
        let mut unknown = vec![NONE; nodes.len()];
        let mut n = 0;
        for (at, &node) in nodes.iter().enumerate() {
            if moves(node) && leader(node) == node {
                unknown[at] = n;
                n += 1;
            }
        }
        for (at, &node) in nodes.iter().enumerate() {
            if moves(node) && leader(node) != node {
                unknown[at] = local(leader(node)).map_or(NONE, |at| unknown[at]);
            }
        }
        let order = order(n as usize, &pairs(&elements, &unknown));
        for unknown in unknown.iter_mut().filter(|unknown| **unknown != NONE) {
            *unknown = order[*unknown as usize];
        }
        let mut patch = Self {
            space,
            turned: BTreeMap::new(),
            held: BTreeMap::new(),
            matrix: Blocks::with_pattern(n as usize, pairs(&elements, &unknown)),
            slots: Vec::new(),
            first_slot: Vec::new(),
            nodes,
            places,
            unknown,
            elements,
        };
        patch.find_conditions(freedom);
        patch.find_slots();
        patch
    }

    fn find_conditions(&mut self, freedom: &Freedom) {
        for (at, &node) in self.nodes.iter().enumerate() {
            let unknown = self.unknown[at];
            if unknown == NONE {
                continue;
            }
            match freedom.partner(node) {
                None => {
                    if let Some(held) = freedom.held(node) {
                        self.held.insert(unknown, *held);
                    }
                }
                Some(partner) => {
                    let rotation = partner.map.rotation;
                    if rotation != azimesh_core::geometry::Transform::IDENTITY.rotation {
                        self.turned.insert(at as u32, rotation);
                    }
                }
            }
        }
    }

    fn find_slots(&mut self) {
        for cell in 0..self.elements.len() {
            self.first_slot.push(self.slots.len());
            let nodes = self.elements.nodes(cell);
            for a in 0..nodes.len() {
                for b in a..nodes.len() {
                    let [i, j] = [nodes[a], nodes[b]].map(|node| self.unknown[node as usize]);
                    let slot = match (i, j) {
                        (NONE, _) | (_, NONE) => None,
                        _ if i == j => Some(i),
                        _ if i > j => self.matrix.slot(i, j).map(|slot| slot as u32),
                        _ => self.matrix.slot(j, i).map(|slot| slot as u32 | TURNED),
                    };
                    self.slots.push(slot.unwrap_or(NONE));
                }
            }
        }
    }

    /// Number of nodes that move by themselves.
    pub(super) fn n_unknowns(&self) -> usize {
        self.matrix.n_rows()
    }

    /// The functional at the places.
    pub(super) fn state(&self, eps: f64, places: &[Vector]) -> State {
        let scratch = Scratch::new(Vec::new);
        let parts = parallel::map_blocks(self.elements.len(), BLOCK, &|range| {
            scratch.with(|points| {
                range.fold(State::EMPTY, |sum, cell| {
                    let (value, least, n_folded) = self.elements.value(cell, eps, places, points);
                    sum.plus(State {
                        value,
                        least,
                        n_folded,
                    })
                })
            })
        });
        parts.into_iter().fold(State::EMPTY, State::plus)
    }

    /// The sum at the places of the patch; `slope` becomes its slope, and the matrix its curvature.
    pub(super) fn derive(&mut self, sum: Sum, slope: &mut [Vector]) -> State {
        slope.fill([0.0; 3]);
        self.matrix.clear();
        let mut state = State::EMPTY;
        let n = self.elements.len();
        let n_nodes = (0..n).map(|cell| self.elements.nodes(cell).len()).max();
        let most = WAVE.min(MOST_BLOCKS / n_nodes.unwrap_or(1).pow(2)).max(1);
        let mut wave: Vec<Derivatives> = vec![Derivatives::default(); most.min(n)];
        for first in (0..n).step_by(most) {
            let n_cells = most.min(n - first);
            parallel::for_blocks(&mut wave[..n_cells], 16, &|start, found| {
                for (i, found) in found.iter_mut().enumerate() {
                    self.elements
                        .derive(first + start + i, sum, &self.places, found);
                }
            });
            for (i, found) in wave[..n_cells].iter().enumerate() {
                state = state.plus(State {
                    value: found.value,
                    least: found.least,
                    n_folded: found.n_folded,
                });
                self.scatter(first + i, found, slope);
            }
        }
        self.hold(slope);
        state
    }

    fn scatter(&mut self, cell: usize, found: &Derivatives, slope: &mut [Vector]) {
        let nodes = self.elements.nodes(cell);
        let n = nodes.len();
        let mut slots = self.slots[self.first_slot[cell]..].iter();
        for a in 0..n {
            let row = self.unknown[nodes[a] as usize];
            if row != NONE {
                let own = self.back(nodes[a], found.slope[a]);
                slope[row as usize] = add(slope[row as usize], own);
            }
            for b in a..n {
                let slot = *slots.next().expect("there is a slot for each pair");
                if slot == NONE {
                    continue;
                }
                let mut block = found.blocks[pair(n, a, b)];
                if !self.turned.is_empty() {
                    block = self.turned_back(nodes[a], nodes[b], &block);
                }
                let column = self.unknown[nodes[b] as usize];
                if row == column {
                    let diagonal = &mut self.matrix.diagonal_mut()[slot as usize];
                    add_to(diagonal, &block);
                    if a != b {
                        add_to(diagonal, &transposed(&block));
                    }
                } else if slot & TURNED != 0 {
                    let below = &mut self.matrix.below_mut()[(slot & !TURNED) as usize];
                    add_to(below, &transposed(&block));
                } else {
                    add_to(&mut self.matrix.below_mut()[slot as usize], &block);
                }
            }
        }
    }

    /// A slope at a node as one of its unknown.
    fn back(&self, node: u32, slope: Vector) -> Vector {
        match self.turned.get(&node) {
            None => slope,
            Some(r) => {
                [0, 1, 2].map(|k| r[0][k] * slope[0] + r[1][k] * slope[1] + r[2][k] * slope[2])
            }
        }
    }

    /// `R_a^T B R_b`.
    fn turned_back(&self, a: u32, b: u32, block: &Block) -> Block {
        let mut found = *block;
        if let Some(r) = self.turned.get(&a) {
            let old = found;
            found = std::array::from_fn(|k| {
                let (i, j) = (k / 3, k % 3);
                (0..3).map(|m| r[m][i] * old[3 * m + j]).sum()
            });
        }
        if let Some(r) = self.turned.get(&b) {
            let old = found;
            found = std::array::from_fn(|k| {
                let (i, j) = (k / 3, k % 3);
                (0..3).map(|m| old[3 * i + m] * r[m][j]).sum()
            });
        }
        found
    }

    /// Takes the directions in which unknowns are held out of the slope and the matrix.
    fn hold(&mut self, slope: &mut [Vector]) {
        let plane = self.is_plane();
        for (row, slope) in slope.iter_mut().enumerate() {
            let held = self.held.get(&(row as u32));
            *slope = allowed(held, *slope);
            let diagonal = &mut self.matrix.diagonal_mut()[row];
            let size = (diagonal[0] + diagonal[4] + diagonal[8]) / 3.0;
            let size = if size > 0.0 { size } else { 1.0 };
            if plane {
                slope[2] = 0.0;
                diagonal[8] = size;
            }
            if let Some(held) = held {
                *diagonal = transposed(&rows_held(held, &transposed(&rows_held(held, diagonal))));
                for column in held.columns() {
                    for k in 0..9 {
                        diagonal[k] += size * column[k / 3] * column[k % 3];
                    }
                }
            }
            if diagonal[0] + diagonal[4] + diagonal[8] <= 0.0 {
                *diagonal = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
            }
        }
        if !self.held.is_empty() {
            let held = &self.held;
            self.matrix.for_each_below(|row, column, block| {
                if let Some(held) = held.get(&row) {
                    *block = rows_held(held, block);
                }
                if let Some(held) = held.get(&column) {
                    *block = transposed(&rows_held(held, &transposed(block)));
                }
            });
        }
    }

    /// The curvature.
    pub(super) fn matrix(&self) -> &Blocks {
        &self.matrix
    }

    /// Writes the places to `to` after a step of `length` along `step`.
    pub(super) fn moved(&self, step: &[Vector], length: f64, to: &mut [Vector]) {
        for (at, place) in to.iter_mut().enumerate() {
            *place = self.places[at];
            let unknown = self.unknown[at];
            if unknown == NONE {
                continue;
            }
            let own = step[unknown as usize];
            let by = match self.turned.get(&(at as u32)) {
                None => own,
                Some(rotation) => rotation.map(|row| dot(row, own)),
            };
            for axis in 0..3 {
                place[axis] += length * by[axis];
            }
        }
    }

    /// Takes the held directions out of a step, which round-off has put in.
    pub(super) fn clean(&self, step: &mut [Vector]) {
        for (&row, held) in &self.held {
            step[row as usize] = held.remove(step[row as usize]);
        }
        if self.is_plane() {
            for step in step {
                step[2] = 0.0;
            }
        }
    }

    /// Returns whether it is in a plane of constant z.
    pub(super) fn is_plane(&self) -> bool {
        self.space == Space::Plane
    }

    /// Returns whether a node, by its number in the patch, moves.
    pub(super) fn moves(&self, at: usize) -> bool {
        self.unknown[at] != NONE
    }

    /// Returns whether it moves freely, and by itself.
    pub(super) fn is_free(&self, at: usize) -> bool {
        let unknown = self.unknown[at];
        unknown != NONE
            && !self.held.contains_key(&unknown)
            && !self.turned.contains_key(&(at as u32))
    }

    /// Mesh nodes that move, with their places.
    pub(super) fn moved_nodes(&self) -> impl Iterator<Item = (u32, Vector)> {
        let all = self.nodes.iter().zip(&self.unknown).zip(&self.places);
        all.filter(|((_, unknown), _)| **unknown != NONE)
            .map(|((node, _), place)| (*node, *place))
    }
}

#[inline(always)]
fn add_to(to: &mut Block, block: &Block) {
    for m in 0..9 {
        to[m] += block[m];
    }
}

/// `(I - N N^T) B`.
fn rows_held(held: &Constraint, block: &Block) -> Block {
    let columns = [0, 1, 2].map(|k| held.remove([block[k], block[3 + k], block[6 + k]]));
    std::array::from_fn(|k| columns[k % 3][k / 3])
}

//! What every rank has of the work: fields at its nodes, its part of the mesh and where the nodes of that are.

use super::kept::{Kept, OwnNodes};
use super::order::{Changed, LayerTask};
use super::placing::{Apart, Maps};
use super::rows::{NO_ROW, Rows};
use crate::deform::fields::{Chosen, Fields, MeshState};
use crate::deform::layer::Layer;
use crate::deform::step_memory::Rounding;
use crate::deform::wall_angles::WallAngles;
use crate::geometry::vector::Vector;
use crate::mesh::Mesh;
use crate::parallel::{self, SMALL_BLOCK};
use crate::progress::Progress;
use crate::quality::faces::FaceSummary;
use crate::quality::{Judge, Summary};
use crate::rbf::correct::Added;
use crate::rbf::select::Selection;
use std::collections::BTreeMap;
use std::ops::Range;
use twox_hash::XxHash3_128;

/// Nodes whose places are compared at once.
const BLOCK: usize = 256;
const EVALUATED: &str = "fields are evaluated before nodes are moved by them";
const SHARED: &str = "the mesh is shared before it is judged";

/// The hash of the places of a block.
pub(super) type BlockHash = u128;

/// What a rank has of the work.
#[derive(Default)]
pub(super) struct Work {
    pub(super) slabs: BTreeMap<usize, Slab>,
    pub part: Option<Part>,
    /// The nodes of the slab that may stay here.
    pub own: OwnNodes,
    /// The fields whose slab has the positions of a step, where they stay here.
    pub(super) stays_with: Option<usize>,
    pub(super) kept: Kept,
}

/// Some nodes with the fields there.
pub(super) struct Slab {
    layers: Vec<Layer>,
    fields: Fields,
    pub rows: Rows,
    /// Where they are at a step.
    pub moved: Vec<Vector>,
}

/// A part of the mesh, and where its nodes are.
pub(super) struct Part {
    pub mesh: Mesh,
    judge: Judge,
    walls: WallAngles,
    /// The places.
    pub points: Vec<Vector>,
    /// Nodes that are not where fields move them.
    apart: Apart,
    /// The fields that moved its nodes last.
    moved_by: Option<usize>,
}

impl Work {
    /// Evaluates fields at nodes of this rank, without the correction.
    pub fn evaluate(
        &mut self,
        id: usize,
        layers: Vec<LayerTask>,
        rows: Rows,
        progress: &dyn Progress,
    ) -> &mut Slab {
        let state = MeshState {
            nodes: &rows.nodes,
            deforming: None,
            surface: &[],
            facets: &[],
            is_reference: false,
        };
        let (tasks, mut layers) = (layers, Vec::new());
        let mut selections = Vec::new();
        for of in tasks {
            layers.push(Layer::elsewhere(of.kind, of.n_modes, of.coefficients));
            selections.push(Selection::elsewhere(of.interpolant));
        }
        let chosen = selections.iter().map(|selection| Chosen {
            selection,
            error: 0.0,
        });
        let chosen: Vec<_> = chosen.collect();
        let fields = Fields::at_rank(state, &layers, &chosen, progress);
        let slab = Slab {
            layers,
            fields,
            rows,
            moved: Vec::new(),
        };
        self.slabs.entry(id).or_insert(slab)
    }

    /// Moves the nodes of fields to a step, those of the part as well, and gives `take` the own ones; where these `stay` only those
    /// of which the first rank is told.
    pub fn move_to(
        &mut self,
        (id, step, from_zero): (usize, usize, bool),
        stay: bool,
        take: impl FnOnce(&[Vector]),
    ) {
        let slab = self.slabs.get_mut(&id).expect(EVALUATED);
        let mut moved = std::mem::take(&mut slab.moved);
        moved.resize(slab.rows.nodes.len(), [0.0; 3]);
        slab.move_to(step, from_zero, &mut moved);
        let own = &moved[slab.rows.own.clone()];
        match stay {
            false => take(own),
            true => {
                let told = self.own.told.iter();
                take(&told.map(|&node| own[node as usize]).collect::<Vec<_>>());
            }
        }
        self.stays_with = stay.then_some(id);
        if let Some(part) = self.part.as_mut().filter(|_| !from_zero) {
            part.move_to(&slab.rows.of_part, &moved);
            part.moved_by = Some(id);
        }
        slab.moved = moved;
    }

    pub fn forget(&mut self, id: usize) {
        self.slabs.remove(&id);
    }

    /// Takes a part of the mesh, with the faces of moving walls by their number in the whole mesh.
    pub fn take_part(&mut self, mesh: Mesh, moving_faces: &[u32], apart: Apart) {
        let judge = Judge::new(&mesh);
        let numbers = mesh.part.as_ref().map_or(&[][..], |part| &part.cells);
        let here = moving_faces
            .iter()
            .filter_map(|face| numbers.binary_search(face).ok());
        let here: Vec<u32> = here.map(|face| face as u32).collect();
        self.part = Some(Part {
            walls: WallAngles::find(&mesh, &judge.adjacency, &here),
            points: mesh.points.clone(),
            moved_by: None,
            judge,
            mesh,
            apart,
        });
    }

    /// Ends the move of the nodes of the rank to a step, as the first rank does for those that it has.
    pub fn end_move(&mut self, maps: &Maps, is_rounded: bool) {
        if let Some(slab) = self.stays_with.and_then(|id| self.slabs.get_mut(&id)) {
            let own = slab.rows.own.clone();
            let (rest, points) = (&slab.rows.nodes[own.clone()], &mut slab.moved[own]);
            self.own.apart.end_move(maps, |_| true, rest, points);
        }
        if let Some(part) = &mut self.part {
            let slab = part.moved_by.and_then(|id| self.slabs.get(&id));
            let rows = slab.map_or(&[][..], |slab| &slab.rows.of_part);
            let deforms = |node: usize| rows.get(node).is_some_and(|&row| row != NO_ROW);
            let rest = &part.mesh.points;
            (part.apart).end_move(maps, deforms, rest, &mut part.points);
        }
        if is_rounded {
            self.round();
        }
    }

    /// Whether the rank knows where nodes are that it has moved.
    pub fn has_places(&self) -> bool {
        self.part.is_some() || self.stays_with.is_some()
    }

    /// Rounds the places of all nodes of the rank.
    fn round(&mut self) {
        if let Some(part) = &mut self.part {
            Rounding::Single.apply(&mut part.points);
        }
        Rounding::Single.apply(self.own_points().unwrap_or_default());
    }

    /// Of how many nodes the first rank tells.
    pub fn n_told(&self) -> usize {
        let own = self.stays_with.map_or(0, |_| self.own.apart.told.len());
        self.n_told_of_part() + own
    }

    fn n_told_of_part(&self) -> usize {
        self.part.as_ref().map_or(0, |part| part.apart.told.len())
    }

    /// Takes the places of these nodes: first of those of the part, then of those of the slab.
    pub fn take_apart(&mut self, places: &[Vector]) {
        let (of_part, of_slab) = places.split_at(self.n_told_of_part());
        if let Some(part) = &mut self.part {
            part.apart.take(of_part, &mut part.points);
        }
        if let Some(slab) = self.stays_with.and_then(|id| self.slabs.get_mut(&id)) {
            let own = &mut slab.moved[slab.rows.own.clone()];
            self.own.apart.take(of_slab, own);
        }
    }

    pub fn part(&self) -> &Part {
        self.part.as_ref().expect(SHARED)
    }

    pub fn part_mut(&mut self) -> &mut Part {
        self.part.as_mut().expect(SHARED)
    }
}

impl Slab {
    /// Adds the correction of a layer; `row` gives the row of each number in it.
    pub fn add(&mut self, layer: usize, added: &Added, row: impl Fn(usize) -> u32) {
        let field = self.fields.of_layer(layer);
        let n_modes = field.n_modes;
        added.add_to(&mut field.values, n_modes, |at| row(at as usize));
    }

    fn move_to(&self, step: usize, from_zero: bool, moved: &mut [Vector]) {
        match from_zero {
            true => self.fields.vectors(&self.layers, step, moved),
            false => {
                let state = MeshState {
                    nodes: &self.rows.nodes,
                    deforming: None,
                    surface: &[],
                    facets: &[],
                    is_reference: false,
                };
                self.fields.displace(&self.layers, step, state, moved);
            }
        }
    }
}

impl Part {
    fn move_to(&mut self, rows: &[u32], moved: &[Vector]) {
        let rest = &self.mesh.points;
        parallel::update(&mut self.points, |node, x| {
            let row = rows.get(node).copied().unwrap_or(NO_ROW);
            *x = moved.get(row as usize).copied().unwrap_or(rest[node]);
        });
    }

    /// The hashes of all places.
    pub fn hashes(&self) -> Vec<BlockHash> {
        hashes(self.points.len(), |node| self.points[node])
    }

    /// Takes places that were others on the first rank.
    pub fn correct(&mut self, changed: Changed) {
        let n = self.points.len();
        let nodes = changed.blocks.iter().flat_map(|&block| nodes_of(block, n));
        for (node, place) in nodes.zip(changed.places) {
            self.points[node] = place;
        }
    }

    pub fn cells(&self) -> Summary {
        self.judge.cells(&self.mesh, &self.points)
    }

    pub fn faces(&self) -> FaceSummary {
        self.judge.faces(&self.mesh, &self.points)
    }

    pub fn normal_change(&self) -> Option<f64> {
        let own = self
            .walls
            .largest_change(&self.mesh, &self.points, &self.mesh.points);
        let all = self.mesh.ranks().all(own);
        all.into_iter().flatten().max_by(f64::total_cmp)
    }
}

/// The hash of places.
pub(super) fn hash(places: &[Vector]) -> BlockHash {
    let of_blocks = hashes(places.len(), |node| places[node]);
    XxHash3_128::oneshot(bytemuck::cast_slice(&of_blocks))
}

/// The hashes of the places of `n` nodes, block by block.
pub(super) fn hashes(n: usize, place: impl Fn(usize) -> Vector + Sync) -> Vec<BlockHash> {
    parallel::collect_in_blocks(n.div_ceil(BLOCK), SMALL_BLOCK, |block| {
        let mut places = [[0.0; 3]; BLOCK];
        let nodes = nodes_of(block as u32, n);
        let n_here = nodes.len();
        for (x, node) in places.iter_mut().zip(nodes) {
            *x = place(node);
        }
        XxHash3_128::oneshot(bytemuck::cast_slice(&places[..n_here]))
    })
}

/// The nodes of a block, of `n`.
fn nodes_of(block: u32, n: usize) -> Range<usize> {
    let start = block as usize * BLOCK;
    start..(start + BLOCK).min(n)
}

impl Changed {
    /// What a rank has to learn that has `n` nodes, from pairs of wanted and found hashes and from places that are wanted.
    pub fn between<'a>(
        hashes: impl Iterator<Item = (&'a BlockHash, &'a BlockHash)>,
        n: usize,
        place: impl Fn(usize) -> Vector,
    ) -> Self {
        let differ = (0..)
            .zip(hashes)
            .filter(|(_, (wanted, found))| wanted != found);
        let blocks: Vec<u32> = differ.map(|(block, _)| block).collect();
        let nodes = blocks.iter().flat_map(|&block| nodes_of(block, n));
        Self {
            places: nodes.map(place).collect(),
            blocks,
        }
    }
}

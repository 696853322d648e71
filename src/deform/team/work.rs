//! What every rank has of the work: its part of the mesh, fields at its nodes and where these are.

use super::kept::Kept;
use super::nodes::Nodes;
use super::order::{Changed, LayerTask, RowsFrom};
use super::placing::{Maps, Rates};
use super::shared_correction::{Corrected, Moved};
use crate::deform::fields::{Chosen, Fields, MeshState, RankPlaces};
use crate::deform::layer::Layer;
use crate::deform::step_memory::Rounding;
use crate::deform::velocity::IntoInertial;
use crate::deform::wall_angles::WallAngles;
use crate::geometry::vector::Vector;
use crate::mesh::{Mesh, among, node_slab};
use crate::parallel::{self, SMALL_BLOCK};
use crate::progress::Progress;
use crate::quality::faces::FaceSummary;
use crate::quality::{Judge, Summary};
use crate::ranks::Ranks;
use crate::ranks::raw::List;
use crate::rbf::correct::Added;
use crate::rbf::select::Selection;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
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
    pub(super) fields: BTreeMap<usize, RankFields>,
    /// A part of the mesh that was read, as long as nothing is made of it.
    pub read: Option<Mesh>,
    part: Option<RankMesh>,
    pub nodes: Nodes,
    /// Of which own nodes the first rank is told, where the others may stay here; ascending, from the first own one on.
    pub wanted: Vec<u32>,
    /// Whether the own nodes stay here at the step that they have moved to.
    pub(super) stays: bool,
    /// The nodes that the fields of that step have moved; none for all.
    moved: Option<Arc<[u32]>>,
    /// Which fields have moved them.
    moved_by: usize,
    /// Velocities of the nodes at that step, in the frame of the rotor, where they stay here.
    velocities: Vec<Vector>,
    /// What turns these into the inertial frame.
    to_inertial: Option<IntoInertial>,
    pub(super) kept: Kept,
}

/// Fields at the nodes of a rank.
pub(super) struct RankFields {
    layers: Vec<Layer>,
    fields: Fields,
    /// The nodes that deform, ascending; none for all.
    pub deforming: Option<Arc<[u32]>>,
    /// Where the nodes were before; none where they were at rest.
    from: Option<Vec<Vector>>,
}

/// Fields at the own nodes of a rank, by rows: the nodes that deform, in their order.
pub(super) struct OwnFields<'a> {
    places: &'a [Vector],
    deforming: Option<&'a [u32]>,
    first: usize,
    fields: &'a mut Fields,
}

impl Corrected for OwnFields<'_> {
    fn n_rows(&self) -> usize {
        self.deforming.map_or(self.places.len(), <[u32]>::len)
    }

    fn place(&self, row: usize) -> Vector {
        match self.deforming {
            None => self.places[row],
            Some(nodes) => self.places[nodes[row] as usize - self.first],
        }
    }

    fn add(&mut self, layer: usize, added: &Added, row: &dyn Fn(usize) -> u32) {
        let field = self.fields.of_layer(layer);
        let n_modes = field.n_modes;
        added.add_to(&mut field.values, n_modes, |at| row(at as usize));
    }
}

/// A part of the mesh.
struct RankMesh {
    mesh: Mesh,
    /// Where cells are judged, by what.
    judging: Option<Judging>,
}

/// What a part of the mesh is judged by.
struct Judging {
    judge: Judge,
    walls: WallAngles,
}

impl Work {
    fn mesh(&self) -> Option<&Mesh> {
        self.part.as_ref().map(|part| &part.mesh)
    }

    /// The mesh whose own cells this rank writes.
    pub fn cells_to_write(&self) -> &Mesh {
        self.read.as_ref().or(self.mesh()).expect(SHARED)
    }

    /// Where the own nodes are at rest.
    pub fn own_rest(&self) -> &[Vector] {
        match &self.read {
            Some(read) => {
                let part = read.part.as_ref().expect("it was read as a part");
                &read.points[part.own_nodes.clone()]
            }
            None => &self.nodes.rest(self.mesh())[self.own()],
        }
    }

    /// The numbers of all nodes in the whole mesh.
    pub fn numbers(&self) -> List<u32> {
        let part = self.mesh().and_then(|mesh| mesh.part.as_ref());
        List(part.map_or_else(Vec::new, |part| part.nodes.clone()))
    }

    /// The nodes of which the first rank tells, by their numbers in the whole mesh.
    pub fn told(&self) -> List<u32> {
        List(self.nodes.told(self.mesh()))
    }

    /// The number of the first own node in the whole mesh.
    pub fn first_own(&self) -> usize {
        let mesh = self.read.as_ref().or(self.mesh());
        self.nodes.first(mesh)
    }

    /// The own nodes, among those here.
    pub fn own(&self) -> Range<usize> {
        self.nodes.own(self.mesh())
    }

    /// Evaluates fields at the own nodes, without the correction.
    pub fn evaluate(
        &mut self,
        id: usize,
        layers: Vec<LayerTask>,
        from: RowsFrom,
        progress: &dyn Progress,
    ) {
        let from = match from {
            RowsFrom::Rest => None,
            RowsFrom::Told(List(from)) => Some(from),
            RowsFrom::Moved => {
                self.begin_at_rest();
                Some(self.nodes.places.clone())
            }
        };
        let deforming = self.nodes.deforming.clone();
        let own = self.own();
        let of_own = deforming.as_deref().map(|nodes| {
            let own_ones = among(nodes, &own).iter();
            own_ones
                .map(|node| node - own.start as u32)
                .collect::<Vec<_>>()
        });
        let places = from.as_deref().unwrap_or(self.nodes.rest(self.mesh()));
        let state = MeshState {
            nodes: &places[own],
            deforming: of_own.as_deref(),
            surface: &[],
            facets: &[],
            rank_places: RankPlaces::Told,
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
        let fields = RankFields {
            fields: Fields::at_rank(state, &layers, &chosen, progress),
            layers,
            deforming,
            from,
        };
        self.fields.insert(id, fields);
    }

    /// Fields at the own nodes, and where these were before they are moved by them.
    pub fn own_fields(&mut self, id: usize) -> OwnFields<'_> {
        let own = self.own();
        let mesh = self.part.as_ref().map(|part| &part.mesh);
        let fields = self.fields.get_mut(&id).expect(EVALUATED);
        let places = fields.from.as_deref().unwrap_or(self.nodes.rest(mesh));
        OwnFields {
            places: &places[own.clone()],
            deforming: fields.deforming.as_ref().map(|nodes| among(nodes, &own)),
            first: own.start,
            fields: &mut fields.fields,
        }
    }

    /// Gets the values of fields at the other nodes of the part from the ranks that these belong to.
    pub fn get_others(&mut self, id: usize, ranks: &Ranks) {
        let own = self.own();
        let Some(part) = self.part.as_ref().and_then(|part| part.mesh.part.as_ref()) else {
            return;
        };
        let (numbers, n_nodes) = (&part.nodes, self.nodes.n_nodes);
        let first = numbers.get(own.start).copied().unwrap_or(0);
        let fields = self.fields.get_mut(&id).expect(EVALUATED);
        let deforming = fields.deforming.clone();
        let deforming = deforming.as_deref();
        let rows_in = |range: Range<usize>| match deforming {
            None => numbers[range].to_vec(),
            Some(nodes) => {
                let here = among(nodes, &range).iter();
                here.map(|&at| numbers[at as usize]).collect()
            }
        };
        let of_owner = |owner: usize| match owner == ranks.rank() {
            true => Vec::new(),
            false => {
                let slab = node_slab(n_nodes, owner, ranks.n());
                let before = |end: usize| numbers.partition_point(|&n| (n as usize) < end);
                rows_in(before(slab.start)..before(slab.end))
            }
        };
        let asked = ranks.exchange((0..ranks.n()).map(of_owner).collect());
        let own_rows = deforming.map(|nodes| among(nodes, &own));
        let row = |number: &u32| {
            let at = number - first + own.start as u32;
            match own_rows {
                None => at as usize - own.start,
                Some(rows) => rows.partition_point(|&other| other < at),
            }
        };
        let mut answers: Vec<Vec<f64>> = vec![Vec::new(); ranks.n()];
        for (answer, asked) in answers.iter_mut().zip(&asked) {
            for layer in 0..fields.layers.len() {
                let field = fields.fields.of_layer(layer);
                let values =
                    |number: &u32| &field.values[row(number) * field.n_modes..][..field.n_modes];
                answer.extend(asked.iter().flat_map(values));
            }
        }
        let found = ranks.exchange(answers);
        fields.take_others(&found, ranks.rank());
    }

    /// Moves the nodes to a step by fields, and gives `take` the own ones that deform; where they `stay` only those of which the
    /// first rank is told. With `from_zero` the nodes stay where they are, and what is given is by how much they would move: where
    /// that stays, the fields are those of velocities.
    pub fn move_to(
        &mut self,
        (id, step, from_zero): (usize, usize, bool),
        stay: bool,
        take: impl FnOnce(&[Vector]),
    ) {
        let own = self.own();
        let mut places = match from_zero {
            true => Vec::new(),
            false => std::mem::take(&mut self.nodes.places),
        };
        let rest = self.nodes.rest(self.mesh());
        places.resize(rest.len(), [0.0; 3]);
        let fields = self.fields.get(&id).expect(EVALUATED);
        fields.move_to(step, from_zero, rest, &mut places);
        let here = &places[own.clone()];
        match (stay, &fields.deforming) {
            (false, None) => take(here),
            (false, Some(nodes)) => take(&picked(&places, among(nodes, &own))),
            (true, _) => take(&picked(here, &self.wanted)),
        }
        match (from_zero, stay) {
            (false, _) => {
                self.stays = stay;
                self.moved.clone_from(&fields.deforming);
                self.moved_by = id;
                self.nodes.places = places;
            }
            (true, true) => self.velocities = places,
            (true, false) => {}
        }
    }

    /// Completes the velocities at a step, where they stay here; the first rank has `told` those of some nodes.
    pub fn end_velocities(&mut self, rates: &Rates, told: &[Vector]) {
        let mut velocities = std::mem::take(&mut self.velocities);
        let (apart, rest) = (&self.nodes.apart, self.nodes.rest(self.mesh()));
        apart.set_velocities(rates, told, rest, &mut velocities);
        self.velocities = velocities;
        self.to_inertial = rates.to_inertial.map(IntoInertial::new);
    }

    /// Velocities of the own nodes at the step that they have moved to, in the final frame; none where they are not asked for.
    pub fn take_own_velocities(&mut self) -> Vec<Vector> {
        let mut velocities = std::mem::take(&mut self.velocities);
        if velocities.is_empty() {
            return velocities;
        }
        let own = self.own();
        velocities.truncate(own.end);
        velocities.drain(..own.start);
        if let Some(to_inertial) = self.to_inertial.take() {
            let places = self.own_places();
            let turn = |i: usize, v: &mut Vector| *v = to_inertial.at(places[i], *v);
            match self.nodes.deforming.as_deref() {
                None => parallel::update(&mut velocities, turn),
                Some(nodes) => {
                    for &at in among(nodes, &own) {
                        let i = at as usize - own.start;
                        turn(i, &mut velocities[i]);
                    }
                }
            }
        }
        velocities
    }

    /// Where the nodes are, until they are given back.
    pub fn take_places(&mut self) -> Vec<Vector> {
        std::mem::take(&mut self.nodes.places)
    }

    /// The nodes that fields have moved, at these places.
    pub fn moved<'a>(&'a self, places: &'a mut [Vector]) -> Moved<'a> {
        let by = self.fields.get(&self.moved_by).expect(EVALUATED);
        let from = by.from.as_deref();
        Moved {
            before: from.unwrap_or(self.nodes.rest(self.mesh())),
            moved: self.moved.as_deref(),
            places,
        }
    }

    pub fn forget(&mut self, id: usize) {
        self.fields.remove(&id);
    }

    /// Takes a part of the mesh, with the faces of moving walls by their number in the whole mesh where cells are judged.
    pub fn take_part(&mut self, mesh: Mesh, moving_faces: Option<&[u32]>, nodes: Nodes) {
        self.nodes = nodes;
        let judging = moving_faces.map(|faces| {
            let judge = Judge::new(&mesh);
            let here = cells_among(&mesh, faces);
            Judging {
                walls: WallAngles::find(&mesh, &judge.adjacency, &here),
                judge,
            }
        });
        self.part = Some(RankMesh { mesh, judging });
    }

    /// Ends the move of the nodes of the rank to a step, as the first rank does for those that it has.
    pub fn end_move(&mut self, maps: &Maps, rounding: Rounding) {
        if !self.has_places() {
            return;
        }
        let mesh = self.part.as_ref().map(|part| &part.mesh);
        let moved = self.moved.as_deref();
        self.nodes.end_move(maps, moved, rounding, mesh);
    }

    /// Whether it matters where the rank has its nodes: they are judged here, or stay here.
    pub fn has_places(&self) -> bool {
        self.judging().is_some() || self.stays
    }

    /// Puts nodes that nothing has moved yet where they are at rest.
    fn begin_at_rest(&mut self) {
        if self.nodes.places.is_empty() {
            self.nodes.places = self.nodes.rest(self.mesh()).to_vec();
        }
    }

    /// Takes the places of the nodes of which the first rank tells.
    pub fn take_told(&mut self, places: &[Vector]) {
        self.begin_at_rest();
        let Nodes {
            apart,
            places: points,
            ..
        } = &mut self.nodes;
        apart.take(places, points);
    }

    fn judging(&self) -> Option<(&Mesh, &Judging)> {
        let part = self.part.as_ref()?;
        Some((&part.mesh, part.judging.as_ref()?))
    }

    /// The quality of the cells of the part.
    pub fn cells(&self) -> Summary {
        let (mesh, by) = self.judging().expect(SHARED);
        by.judge.cells(mesh, &self.nodes.places)
    }

    /// The quality of its faces.
    pub fn faces(&self) -> FaceSummary {
        let (mesh, by) = self.judging().expect(SHARED);
        by.judge.faces(mesh, &self.nodes.places)
    }

    /// The largest change of the angle between a moving wall and its first cell, in degrees.
    pub fn normal_change(&self) -> Option<f64> {
        let (mesh, by) = self.judging().expect(SHARED);
        let own = by
            .walls
            .largest_change(mesh, &self.nodes.places, &mesh.points);
        let all = mesh.ranks().all(own);
        all.into_iter().flatten().max_by(f64::total_cmp)
    }

    /// The hashes of all places.
    pub fn hashes(&mut self) -> Vec<BlockHash> {
        self.begin_at_rest();
        let places = &self.nodes.places;
        hashes(places.len(), |node| places[node])
    }

    /// Takes places that are others on the first rank.
    pub fn correct(&mut self, changed: Changed) {
        let places = &mut self.nodes.places;
        let n = places.len();
        let nodes = changed.blocks.iter().flat_map(|&block| nodes_of(block, n));
        for (node, place) in nodes.zip(changed.places) {
            places[node] = place;
        }
    }
}

impl RankFields {
    /// Takes values of nodes that belong to other ranks, layer by layer from each; those of ranks before `rank` come before its own.
    fn take_others(&mut self, of_ranks: &[Vec<f64>], rank: usize) {
        let n_modes: usize = self.layers.iter().map(|layer| layer.modes.n_modes).sum();
        let mut before = 0;
        for (i, layer) in self.layers.iter().enumerate() {
            let r = layer.modes.n_modes;
            let of_layer = |values: &Vec<f64>| {
                let n_rows = values.len() / n_modes.max(1);
                before * n_rows..(before + r) * n_rows
            };
            let values = |ranks: &[Vec<f64>]| -> Vec<f64> {
                let parts = ranks.iter().flat_map(|values| &values[of_layer(values)]);
                parts.copied().collect()
            };
            let (below, above) = (values(&of_ranks[..rank]), values(&of_ranks[rank..]));
            let field = self.fields.of_layer(i);
            // The own values stay in their memory: others are few.
            field.values.reserve_exact(below.len() + above.len());
            field.values.splice(0..0, below);
            field.values.extend(above);
            field.nodes = self.deforming.as_deref().map(<[u32]>::to_vec);
            before += r;
        }
    }

    fn move_to(&self, step: usize, from_zero: bool, rest: &[Vector], places: &mut [Vector]) {
        match from_zero {
            true => self.fields.vectors(&self.layers, step, places),
            false => {
                let state = MeshState {
                    nodes: self.from.as_deref().unwrap_or(rest),
                    deforming: None,
                    surface: &[],
                    facets: &[],
                    rank_places: RankPlaces::Told,
                };
                self.fields.displace(&self.layers, step, state, places);
            }
        }
    }
}

/// Which cells of a part these cells of the whole mesh are; those of other parts are left out.
pub(super) fn cells_among(part: &Mesh, cells: &[u32]) -> Vec<u32> {
    let numbers = part.part.as_ref().map_or(&[][..], |part| &part.cells);
    let here = cells
        .iter()
        .filter_map(|cell| numbers.binary_search(cell).ok());
    here.map(|at| at as u32).collect()
}

fn picked(places: &[Vector], nodes: &[u32]) -> Vec<Vector> {
    nodes.iter().map(|&node| places[node as usize]).collect()
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
    /// What a rank has to learn, from pairs of wanted and found hashes and from the places that are wanted.
    pub fn between<'a>(
        hashes: impl Iterator<Item = (&'a BlockHash, &'a BlockHash)>,
        places: &[Vector],
    ) -> Self {
        let differ = (0..)
            .zip(hashes)
            .filter(|(_, (wanted, found))| wanted != found);
        let blocks: Vec<u32> = differ.map(|(block, _)| block).collect();
        let of_block = |&block: &u32| &places[nodes_of(block, places.len())];
        Self {
            places: blocks.iter().flat_map(of_block).copied().collect(),
            blocks,
        }
    }
}

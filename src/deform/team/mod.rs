//! Fields and quality that several ranks share. The first rank has the surface, or the whole mesh, and decides; the others do what it
//! orders, each for some of the nodes and cells.
//!
//! ```text
//! outline     what the first rank has of a mesh whose parts the ranks have read
//! selection   a slab of the surface, swept by each rank; the first picks among the worst points
//! fields      evaluated at the own nodes of each rank; it gets their values at the other nodes of its part from the ranks
//!             that own those
//! correction  the nodes around some of the surface, as many with each rank; where nodes slide on curved boundaries, what fades in
//!             from there at each step, in the same way
//! positions   each rank moves its nodes, and writes its own, with their velocities; the first gathers them where it has to know them
//! places      each rank places nodes at rest and those of rigid bodies; where the first puts a node elsewhere (where it
//!             slides, on a beam, by a repair) it tells the ranks that have it; and its velocity likewise
//! quality     a part of the cells with those around it, where the rank itself has moved the nodes
//! ```
//!
//! Every number is the one that a rank alone finds: a value at a node does not depend on the other nodes, and sums over
//! cells are added up in the order of the whole mesh.

mod kept;
mod near_surface;
mod nodes;
mod order;
mod outline;
mod placing;
mod serve;
mod shared_correction;
mod sweeps;
mod work;

use super::fields::{Chosen, MeshState, Narrow, RankPlaces};
use super::layer::Layer;
use super::step_memory::Rounding;
use crate::formats::{Shared, SharedFile};
use crate::geometry::vector::Vector;
use crate::mesh::{CellSet, Mesh, Numbering, Slots, node_slab};
use crate::parallel;
use crate::progress::Progress;
use crate::quality::Summary;
use crate::quality::faces::FaceSummary;
use crate::ranks::Ranks;
use crate::ranks::raw::List;
use crate::rbf::correct::Fading;
use near_surface::WholeSurface;
use nodes::OfNodes;
use order::{Changed, LayerTask, Order, RowsFrom, Task};
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use work::{BlockHash, Work, hash, hashes};

pub(crate) use placing::{Maps, Placing, Rates};
pub use serve::{dismiss, serve};
use serve::{evaluate, nodes_alone, part_of_file, take_part};

/// All ranks, as the first sees them.
pub struct Team {
    ranks: Ranks,
    /// Of which ranks read their parts.
    file: Shared,
    /// The same with copies of nodes, where cells get some.
    doubled: OnceLock<SharedFile>,
    state: Mutex<State>,
}

/// What the first rank has, and knows of the others.
#[derive(Default)]
struct State {
    work: Work,
    /// How many fields there have been.
    n_fields: usize,
    /// The nodes of each rank, once they have any.
    nodes: Vec<NodesOfRank>,
    /// The nodes that deform; none for all.
    deforming: Option<CellSet>,
    /// Why ranks do not read their parts themselves.
    why_cut: Option<String>,
    /// Whether what ranks write is to be on the disk.
    syncs: bool,
    /// The nodes of each rank of which the first tells, by their numbers in the whole mesh.
    apart: Vec<Vec<u32>>,
    /// Whether ranks know where these are at the step that they have moved to.
    is_told: bool,
    /// The step that the nodes of all parts have moved to by fields.
    moved_to: Option<usize>,
    /// The places that the parts have.
    placed: Option<Placed>,
    /// The nodes of which this rank is told where others stay with theirs.
    told: Vec<u32>,
    /// Those whose places it has then, where it has the outline of the mesh.
    known: Option<Arc<Numbering<'static>>>,
    /// Whether nodes stay with their ranks at the step that they have moved to.
    are_apart: bool,
}

/// Numbers of the nodes of a rank in the whole mesh.
enum NodesOfRank {
    /// Its own alone.
    Own(Range<usize>),
    /// Those of its part: the first rank asks for them when it has to know them.
    OfPart,
    /// These, ascending.
    All(Vec<u32>),
}

impl NodesOfRank {
    fn collect<T: Copy + Default + Send>(&self, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
        match self {
            Self::Own(own) => parallel::collect(own.len(), |i| of(own.start + i)),
            Self::OfPart => Vec::new(),
            Self::All(nodes) => parallel::collect(nodes.len(), |i| of(nodes[i] as usize)),
        }
    }

    /// Where the nodes of the rank are before fields move them.
    fn rows_from(&self, at: MeshState<'_>) -> RowsFrom {
        match at.rank_places {
            RankPlaces::Rest => RowsFrom::Rest,
            RankPlaces::Moved => RowsFrom::Moved,
            RankPlaces::Told => RowsFrom::Told(List(self.collect(|node| at.nodes[node]))),
        }
    }
}

/// Which places parts have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Placed {
    /// Those of a step by fields.
    ByFields(usize),
    /// Those with this hash.
    At(BlockHash),
}

/// Fields that lie with several ranks.
pub(crate) struct SharedFields {
    team: Arc<Team>,
    id: usize,
}

impl Team {
    /// The team of the first rank; none where it is alone.
    pub fn of(ranks: &Ranks, file: Shared) -> Option<Arc<Self>> {
        let has_others = ranks.is_first() && ranks.n() > 1;
        has_others.then(|| {
            Arc::new(Self {
                ranks: ranks.clone(),
                file,
                doubled: OnceLock::new(),
                state: Mutex::default(),
            })
        })
    }

    /// Why this rank has cut the mesh into parts for the others, where it has.
    pub(crate) fn why_cut(&self) -> Option<String> {
        self.state().why_cut.clone()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn order(&self, order: Order) {
        Order::give(Some(order), &self.ranks);
    }

    /// How many nodes of a mesh deform, which ranks have.
    pub(crate) fn n_deforming(&self, mesh: &Mesh) -> usize {
        self.state().deforming_among(0..mesh.points.len())
    }

    /// Has all ranks evaluate fields, as [`Fields::new`](super::fields::Fields::new) does.
    pub(crate) fn evaluate(
        self: &Arc<Self>,
        at: MeshState<'_>,
        layers: &[Layer],
        chosen: &[Chosen<'_>],
        correct: bool,
        progress: &dyn Progress,
    ) -> (SharedFields, Option<Narrow>) {
        let mut state = self.state();
        let id = state.n_fields;
        state.n_fields += 1;
        let whole = WholeSurface::new(at, layers, chosen, correct);
        if at.rank_places == RankPlaces::Told {
            self.ask_for_nodes(&mut state);
        }
        let task = Box::new(Task {
            layers: layers.iter().zip(chosen).map(LayerTask::of).collect(),
            boxes: whole.boxes(),
        });
        self.order(Order::Evaluate {
            id,
            task: task.clone(),
        });
        let from = (self.ranks).scatter(&mut |rank| Some(state.nodes[rank].rows_from(at)));
        evaluate(
            (id, *task, from),
            &mut state.work,
            Some(&whole),
            &self.ranks,
            progress,
        );
        let n_nodes = at.nodes.len();
        let own = state.deforming_among(node_slab(n_nodes, 0, self.ranks.n()));
        let elsewhere = state.deforming_among(0..n_nodes) - own;
        progress.advance((elsewhere * layers.len()) as u64);
        let fields = SharedFields {
            team: Arc::clone(self),
            id,
        };
        (fields, whole.narrow)
    }

    /// Gives each rank its nodes, once, and with `moving_faces` a part of the mesh to judge. These faces are ascending, and so are the
    /// nodes that `of_nodes` gives: those that are not where fields move them, and those that deform; none of these for all.
    pub(crate) fn share(
        &self,
        mesh: &Mesh,
        moving_faces: Option<&[u32]>,
        of_nodes: impl FnOnce() -> (Vec<(u32, Placing)>, Option<CellSet>),
    ) {
        let mut state = self.state();
        if !state.nodes.is_empty() {
            return;
        }
        let (apart, deforming) = of_nodes();
        let of_nodes = OfNodes {
            apart: &apart,
            deforming: deforming.as_ref(),
        };
        let (n_nodes, n_ranks) = (mesh.points.len(), self.ranks.n());
        match moving_faces.is_some() || state.work.read.is_some() {
            true => {
                self.share_parts(&mut state, mesh, moving_faces, &of_nodes);
                state.nodes = (0..n_ranks).map(|_| NodesOfRank::OfPart).collect();
            }
            false => {
                self.order(Order::TakeNodes { n_nodes });
                let slab = |rank| node_slab(n_nodes, rank, n_ranks);
                let rest = self
                    .ranks
                    .scatter(&mut |rank| Some(List(mesh.points[slab(rank)].to_vec())));
                state.work.nodes = nodes_alone((n_nodes, rest), Some(&of_nodes), &self.ranks);
                state.nodes = (0..n_ranks)
                    .map(|rank| NodesOfRank::Own(slab(rank)))
                    .collect();
            }
        }
        state.deforming = deforming;
        let told = self.ranks.gather(state.work.told()).unwrap_or_default();
        state.apart = told.into_iter().map(|List(nodes)| nodes).collect();
        state.moves();
    }

    fn share_parts(
        &self,
        state: &mut State,
        mesh: &Mesh,
        moving_faces: Option<&[u32]>,
        of_nodes: &OfNodes<'_>,
    ) {
        let n_nodes = mesh.points.len();
        let file = match &state.why_cut {
            Some(reason) => Err(reason.clone()),
            None => self.file().cloned().map_err(String::clone),
        };
        // Where it was not enough, the first rank has read the whole since then.
        let is_same = |file: &SharedFile| mesh.outline.is_some() || file.is_unchanged();
        let read = state.work.read.take();
        let read = read.filter(|_| file.as_ref().is_ok_and(is_same));
        self.order(Order::Share {
            is_read: read.is_some(),
            file: file.clone().ok().filter(|_| read.is_none()),
            n_nodes,
            moving_faces: moving_faces.map(<[u32]>::to_vec),
        });
        let part = match read {
            Some(read) => Ok(read),
            None => file.and_then(|file| part_of_file(&file, &self.ranks)),
        };
        let part = part.unwrap_or_else(|reason| {
            state.why_cut = Some(reason);
            Mesh::shared_of(Some(mesh), &self.ranks)
        });
        take_part(
            &mut state.work,
            part,
            moving_faces,
            (n_nodes, Some(of_nodes)),
            &self.ranks,
        );
    }

    /// Learns the nodes of all parts.
    fn ask_for_nodes(&self, state: &mut State) {
        if !state
            .nodes
            .iter()
            .any(|of| matches!(of, NodesOfRank::OfPart))
        {
            return;
        }
        self.order(Order::Numbers);
        let all = self.ranks.gather(state.work.numbers()).unwrap_or_default();
        state.nodes = all
            .into_iter()
            .map(|List(nodes)| NodesOfRank::All(nodes))
            .collect();
    }

    /// Ends the move to a step on all ranks as it is ended here, with places rounded as they are here.
    pub(crate) fn end_move(&self, step: usize, maps: Maps, rounding: Rounding) {
        let mut state = self.state();
        if !state.work.has_places() {
            return;
        }
        self.end_moves(&mut state, maps, rounding);
        state.moved_to = Some(step);
        // Those of which ranks were told at the end of a part have moved on.
        state.is_told = false;
    }

    /// Ends the move to a part of a step on all ranks, which go on from there.
    pub(crate) fn end_part(&self, maps: Maps, points: &[Vector]) {
        let mut state = self.state();
        self.end_moves(&mut state, maps, Rounding::None);
        self.tell_places(&mut state, points);
    }

    fn end_moves(&self, state: &mut State, maps: Maps, rounding: Rounding) {
        self.order(Order::EndMove {
            maps: maps.clone(),
            rounding,
        });
        let work = &mut state.work;
        self.ranks.together(|| work.end_move(&maps, rounding));
    }

    /// The quality of the cells with all nodes at `points`, which are those of a step `by_fields` where that says so: then
    /// all but the nodes that are apart are where ranks have moved them.
    pub(crate) fn cells(&self, points: &[Vector], by_fields: Option<usize>) -> Summary {
        let state = self.placed(points, by_fields);
        self.order(Order::Cells);
        self.ranks.together(|| state.work.cells())
    }

    /// The quality of the faces.
    pub(crate) fn faces(&self, points: &[Vector], by_fields: Option<usize>) -> FaceSummary {
        let state = self.placed(points, by_fields);
        self.order(Order::Faces);
        self.ranks.together(|| state.work.faces())
    }

    /// The largest change of the angle between a moving wall and its first cell, in degrees.
    pub(crate) fn normal_change(&self, points: &[Vector], by_fields: Option<usize>) -> Option<f64> {
        let state = self.placed(points, by_fields);
        self.order(Order::Walls);
        self.ranks.together(|| state.work.normal_change())
    }

    /// The state, once all parts have their nodes at `points`.
    fn placed(&self, points: &[Vector], by_fields: Option<usize>) -> MutexGuard<'_, State> {
        let mut state = self.state();
        let step = by_fields.filter(|_| state.moved_to == by_fields);
        let wanted = step.map_or_else(|| Placed::At(hash(points)), Placed::ByFields);
        if state.placed == Some(wanted) {
            return state;
        }
        self.tell_places(&mut state, points);
        // Once they are told of others, ranks are not where fields move them any more.
        state.moved_to = step;
        let is_whole = !state.work.stays;
        if step.is_none() || (cfg!(debug_assertions) && is_whole) {
            let n_changed = self.place_rest(&mut state, points);
            debug_assert!(
                step.is_none() || n_changed == 0,
                "fields move all other nodes"
            );
        }
        state.placed = Some(wanted);
        state
    }

    /// Tells each rank where nodes are that it does not place itself.
    fn tell_places(&self, state: &mut State, points: &[Vector]) {
        state.is_told = true;
        if state.apart.iter().all(Vec::is_empty) {
            return;
        }
        self.order(Order::PlaceApart);
        let own = self.tell_apart(state, points);
        state.work.take_told(&own);
    }

    /// Completes the velocities at a step on all ranks, with those that are known here.
    pub(crate) fn end_velocities(&self, rates: Rates, velocities: &[Vector]) {
        let mut state = self.state();
        self.order(Order::EndVelocities(rates.clone()));
        let own = self.tell_apart(&state, velocities);
        state.work.end_velocities(&rates, &own);
    }

    /// Tells each rank what is known here of the nodes of which this rank tells; gives what is of its own.
    fn tell_apart(&self, state: &State, of_nodes: &[Vector]) -> Vec<Vector> {
        let slots = state.slots();
        let apart = &state.apart;
        let place = |rank: usize, places: &mut [Vector]| {
            for (&node, x) in apart[rank].iter().zip(places) {
                *x = of_nodes[slots.of(node)];
            }
        };
        let lengths: Vec<usize> = apart.iter().map(Vec::len).collect();
        let mut own = vec![[0.0; 3]; lengths[0]];
        self.ranks.scatter_into(&place, &mut own, &lengths);
        own
    }

    /// Tells each rank where nodes are that it has elsewhere. Gives how many blocks of them other ranks had.
    fn place_rest(&self, state: &mut State, points: &[Vector]) -> usize {
        self.ask_for_nodes(state);
        self.order(Order::PlaceRest);
        let State { work, nodes, .. } = state;
        let places = |rank: usize| nodes[rank].collect(|node| points[node]);
        let wanted = |rank: usize| match rank {
            // The first rank takes its own from where they are.
            0 => Vec::new(),
            rank => {
                let places = places(rank);
                hashes(places.len(), |at| places[at])
            }
        };
        let wanted: Vec<_> = (0..nodes.len()).map(wanted).collect();
        let mut found = wanted.clone();
        let mut rooms: Vec<&mut [BlockHash]> = found.iter_mut().map(Vec::as_mut_slice).collect();
        self.ranks.receive_parts(&mut rooms);
        let mut n_changed = 0;
        self.ranks.scatter(&mut |rank| {
            let hashes = wanted[rank].iter().zip(&found[rank]);
            let changed = Changed::between(hashes, &places(rank));
            n_changed += changed.blocks.len();
            Some(changed)
        });
        work.nodes.places = places(0);
        n_changed
    }
}

impl State {
    /// Which entries nodes have among the positions that this rank has.
    fn slots(&self) -> Slots<'_> {
        match &self.known {
            Some(known) if self.are_apart => Slots::Known(known),
            _ => Slots::All,
        }
    }

    /// How many of some nodes deform.
    fn deforming_among(&self, nodes: Range<usize>) -> usize {
        match &self.deforming {
            Some(deforming) => deforming.ranges_in(nodes).map(|range| range.len()).sum(),
            None => nodes.len(),
        }
    }

    /// Nodes of parts move: they are nowhere known until they are placed.
    fn moves(&mut self) {
        (self.moved_to, self.placed) = (None, None);
        self.is_told = false;
    }
}

impl SharedFields {
    /// Has all ranks add changes (N_s, 3) of the surface to where they have moved their nodes, fading out.
    pub fn fade(&self, state: MeshState<'_>, fading: &Fading<'_>, changes: &[f64]) {
        let whole = WholeSurface::of_changes(state, fading, changes);
        let boxes = whole.boxes();
        let (team, mut state) = (&self.team, self.team.state());
        team.order(Order::Fade {
            boxes: boxes.clone(),
        });
        serve::fade(&mut state.work, boxes, Some(&whole), &team.ranks);
    }

    /// Writes the positions of the nodes at a step to `out`, from `nodes`, or with none by how much they move.
    pub fn move_to(&self, step: usize, nodes: Option<&[Vector]>, out: &mut [Vector]) {
        let (team, mut state) = (&self.team, self.team.state());
        let (id, from_zero) = (self.id, nodes.is_none());
        team.order(Order::Move {
            id,
            step,
            from_zero,
            stays: false,
        });
        if !from_zero {
            state.moves();
            state.are_apart = false;
        }
        let ranks = &team.ranks;
        let of_rank = |rank| state.deforming_among(node_slab(out.len(), rank, ranks.n()));
        let lengths: Vec<usize> = (0..ranks.n()).map(of_rank).collect();
        let State {
            work, deforming, ..
        } = &mut *state;
        let mut take = |parts: &mut Vec<&mut [Vector]>| {
            let own = &mut parts[0];
            let take = |moved: &[Vector]| own.copy_from_slice(moved);
            ranks.together(|| work.move_to((id, step, from_zero), false, take));
            ranks.receive_parts(parts);
        };
        let Some(deforming) = deforming else {
            return take(&mut kept::split(out, ranks.n()));
        };
        match nodes {
            Some(nodes) => out.copy_from_slice(nodes),
            None => out.fill([0.0; 3]),
        }
        let mut moved = vec![[0.0; 3]; deforming.len()];
        take(&mut kept::cut(&mut moved, lengths.into_iter()));
        for (node, place) in deforming.iter().zip(moved) {
            out[node] = place;
        }
    }
}

impl Drop for SharedFields {
    fn drop(&mut self) {
        let mut state = self.team.state();
        let id = self.id;
        self.team.order(Order::Forget { id });
        state.work.forget(id);
    }
}

//! Fields and quality that several ranks share. The first rank has the whole mesh and decides; the others do what it
//! orders, each for some of the nodes and cells.
//!
//! ```text
//! selection   a slab of the surface, swept by each rank; the first picks among the worst points
//! fields      a slab of the nodes that deform, and the nodes of the part; their values never leave the rank
//! correction  the nodes around some of the surface, as many with each rank
//! positions   each rank moves its nodes, the first gathers the slabs
//! places      each rank places nodes at rest and those of rigid bodies; where the first puts a node elsewhere (where it
//!             slides, on a beam, by a repair) it tells the ranks that have it
//! quality     a part of the cells with those around it, where the rank itself has moved the nodes
//! ```
//!
//! Every number is the one that a rank alone finds: a value at a node does not depend on the other nodes, and sums over
//! cells are added up in the order of the whole mesh.

mod kept;
mod near_surface;
mod order;
mod placing;
mod rows;
mod shared_correction;
mod sweeps;
mod work;

use super::fields::{Chosen, MeshState, Narrow};
use super::layer::Layer;
use super::step_memory::Rounding;
use crate::formats::{Shared, SharedFile, read_parts};
use crate::geometry::boxes::Boxes;
use crate::geometry::vector::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::progress::{Progress, Silent};
use crate::quality::Summary;
use crate::quality::faces::FaceSummary;
use crate::ranks::Ranks;
use near_surface::WholeSurface;
use order::{Changed, LayerTask, Order, Task};
use placing::Apart;
use rows::Rows;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use work::{BlockHash, Work, hash, hashes};

pub(crate) use kept::KeptPoints;
pub(crate) use placing::{Maps, Placing};

/// All ranks, as the first sees them.
pub(crate) struct Team {
    ranks: Ranks,
    /// Of which ranks read their parts.
    file: Shared,
    state: Mutex<State>,
}

/// What the first rank has, and knows of the others.
#[derive(Default)]
struct State {
    work: Work,
    /// How many fields there have been.
    n_fields: usize,
    /// The nodes of the part of each rank.
    nodes: Vec<Vec<u32>>,
    /// Why ranks have not read their parts themselves.
    why_cut: Option<String>,
    /// Of these, by their place there, those of which the first rank tells.
    apart: Vec<Vec<u32>>,
    /// The step that the nodes of all parts have moved to by fields.
    moved_to: Option<usize>,
    /// The places that the parts have.
    placed: Option<Placed>,
    /// The nodes of which this rank is told where slabs stay with theirs.
    told: Vec<u32>,
    /// The nodes of each slab of which the first rank tells, where slabs may stay with their ranks.
    own_apart: Vec<Vec<u32>>,
    /// Whether ranks know where these are at the step that they have moved to.
    own_is_placed: bool,
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
    /// The nodes that deform; `None` for all.
    nodes: Option<Vec<u32>>,
}

impl Team {
    /// The team of the first rank; none where it is alone.
    pub fn of(ranks: &Ranks, file: Shared) -> Option<Arc<Self>> {
        let has_others = ranks.is_first() && ranks.n() > 1;
        has_others.then(|| {
            Arc::new(Self {
                ranks: ranks.clone(),
                file,
                state: Mutex::default(),
            })
        })
    }

    /// Why this rank has cut the mesh into parts for the others, where it has.
    pub fn why_cut(&self) -> Option<String> {
        self.state().why_cut.clone()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn order(&self, order: Order) -> Order {
        Order::give(Some(order), &self.ranks)
    }

    /// Has all ranks evaluate fields, as [`Fields::new`](super::fields::Fields::new) does.
    pub fn evaluate(
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
        let n_rows = at.deforming.map_or(at.nodes.len(), <[u32]>::len);
        let task = Box::new(Task {
            layers: layers.iter().zip(chosen).map(LayerTask::of).collect(),
            n_rows,
            boxes: whole.boxes(),
        });
        let Order::Evaluate { task, .. } = self.order(Order::Evaluate { id, task }) else {
            unreachable!("a broadcast gives what it got")
        };
        let rows = rows::give(Some((at, &state.nodes)), n_rows, &state.work, &self.ranks);
        let elsewhere = n_rows.saturating_sub(rows.nodes.len());
        evaluate(
            (id, *task, rows),
            &mut state.work,
            Some(&whole),
            &self.ranks,
            progress,
        );
        progress.advance((elsewhere * layers.len()) as u64);
        let fields = SharedFields {
            team: Arc::clone(self),
            id,
            nodes: at.deforming.map(<[u32]>::to_vec),
        };
        (fields, whole.narrow)
    }

    /// Gives each rank a part of the mesh to judge, once; `moving_faces` are ascending, and so are nodes that are `apart`: not
    /// where fields move them.
    pub fn share(&self, mesh: &Mesh, moving_faces: &[u32], apart: &[(u32, Placing)]) {
        let mut state = self.state();
        if !state.nodes.is_empty() {
            return;
        }
        let order = Order::Share {
            file: self.file.as_ref().ok().cloned(),
            moving_faces: moving_faces.to_vec(),
        };
        self.order(order);
        let parts = (self.file.as_ref().map_err(String::clone))
            .and_then(|file| parts_of_file(file, &self.ranks));
        let (part, nodes) = match parts {
            Ok(parts) => parts,
            Err(reason) => {
                state.why_cut = Some(reason);
                Mesh::shared_of(Some(mesh), &self.ranks)
            }
        };
        let mut told = Vec::new();
        let of_rank = |rank: usize| Apart::among(&nodes[rank], apart);
        let own = self.ranks.scatter(&mut |rank| {
            let apart = of_rank(rank);
            told.push((rank, apart.told.clone()));
            Some(apart)
        });
        told.sort_unstable();
        state.apart = told.into_iter().map(|(_, told)| told).collect();
        let work = &mut state.work;
        self.ranks
            .together(|| work.take_part(part, moving_faces, own));
        state.nodes = nodes;
        state.moves();
    }

    /// Ends the move to a step on all ranks as it is ended here, with places rounded as they are here.
    pub fn end_move(&self, step: usize, maps: Maps, rounding: Rounding) {
        let mut state = self.state();
        if !state.work.has_places() {
            return;
        }
        let is_rounded = rounding == Rounding::Single;
        if let Order::EndMove { maps, .. } = self.order(Order::EndMove { maps, is_rounded }) {
            let work = &mut state.work;
            self.ranks.together(|| work.end_move(&maps, is_rounded));
        }
        state.moved_to = Some(step);
    }

    /// The quality of the cells with all nodes at `points`, which are those of a step `by_fields` where that says so: then
    /// all but the nodes that are apart are where ranks have moved them.
    pub fn cells(&self, points: &[Vector], by_fields: Option<usize>) -> Summary {
        let state = self.placed(points, by_fields);
        self.order(Order::Cells);
        let part = state.work.part();
        self.ranks.together(|| part.cells())
    }

    /// The quality of the faces.
    pub fn faces(&self, points: &[Vector], by_fields: Option<usize>) -> FaceSummary {
        let state = self.placed(points, by_fields);
        self.order(Order::Faces);
        let part = state.work.part();
        self.ranks.together(|| part.faces())
    }

    /// The largest change of the angle between a moving wall and its first cell, in degrees.
    pub fn normal_change(&self, points: &[Vector], by_fields: Option<usize>) -> Option<f64> {
        let state = self.placed(points, by_fields);
        self.order(Order::Walls);
        let part = state.work.part();
        self.ranks.together(|| part.normal_change())
    }

    /// The state, once all parts have their nodes at `points`.
    fn placed(&self, points: &[Vector], by_fields: Option<usize>) -> MutexGuard<'_, State> {
        let mut state = self.state();
        let step = by_fields.filter(|_| state.moved_to == by_fields);
        let wanted = step.map_or_else(|| Placed::At(hash(points)), Placed::ByFields);
        if state.placed == Some(wanted) {
            return state;
        }
        self.place_apart(&mut state, points);
        // Once they are told of others, ranks are not where fields move them any more.
        state.moved_to = step;
        let is_whole = state.work.stays_with.is_none();
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
    fn place_apart(&self, state: &mut State, points: &[Vector]) {
        state.own_is_placed = true;
        let mut told = state.apart.iter().chain(&state.own_apart);
        if told.all(Vec::is_empty) {
            return;
        }
        self.order(Order::PlaceApart);
        let State {
            work,
            nodes,
            apart,
            own_apart,
            ..
        } = state;
        let own_apart = match work.stays_with {
            Some(_) => &own_apart[..],
            None => &[],
        };
        let (apart, nodes) = (&*apart, &*nodes);
        let of_rank = |rank: usize| {
            let part = apart.get(rank).into_iter().flatten();
            let part = part.map(move |&at| nodes[rank][at as usize]);
            let own = own_apart.get(rank).into_iter().flatten();
            part.chain(own.copied())
        };
        let place_apart = |rank: usize, places: &mut [Vector]| {
            let nodes = of_rank(rank).zip(places);
            nodes.for_each(|(node, x)| *x = points[node as usize]);
        };
        let lengths: Vec<usize> = (0..self.ranks.n())
            .map(|rank| of_rank(rank).count())
            .collect();
        let mut own = vec![[0.0; 3]; lengths[0]];
        self.ranks.scatter_into(&place_apart, &mut own, &lengths);
        work.take_apart(&own);
    }

    /// Tells each rank where nodes are that it has elsewhere. Gives how many blocks of them other ranks had.
    fn place_rest(&self, state: &mut State, points: &[Vector]) -> usize {
        self.order(Order::PlaceRest);
        let State { work, nodes, .. } = state;
        let place = |rank: usize, at: usize| points[nodes[rank][at] as usize];
        let wanted = |rank: usize| match rank {
            // The first rank takes its own from where they are.
            0 => Vec::new(),
            rank => hashes(nodes[rank].len(), |at| place(rank, at)),
        };
        let wanted: Vec<_> = (0..nodes.len()).map(wanted).collect();
        let mut found = wanted.clone();
        let mut rooms: Vec<&mut [BlockHash]> = found.iter_mut().map(Vec::as_mut_slice).collect();
        self.ranks.receive_parts(&mut rooms);
        let mut n_changed = 0;
        self.ranks.scatter(&mut |rank| {
            let hashes = wanted[rank].iter().zip(&found[rank]);
            let place = |at: usize| place(rank, at);
            let changed = Changed::between(hashes, nodes[rank].len(), place);
            n_changed += changed.blocks.len();
            Some(changed)
        });
        let own = &nodes[0];
        parallel::update(&mut work.part_mut().points, |at, x| {
            *x = points[own[at] as usize];
        });
        n_changed
    }
}

impl State {
    /// Nodes of parts move: they are nowhere known until they are placed.
    fn moves(&mut self) {
        (self.moved_to, self.placed) = (None, None);
        self.own_is_placed = false;
    }
}

/// Sends the other ranks home.
pub fn dismiss(ranks: &Ranks) {
    if ranks.n() > 1 {
        Order::give(Some(Order::End), ranks);
    }
}

/// Does what the first rank orders, until there is no more to do.
pub fn serve(ranks: &Ranks) {
    let mut work = Work::default();
    let mut surface = None;
    let nothing = |_: usize, _: &mut [Vector]| {};
    loop {
        match Order::give(None, ranks) {
            Order::Select(order) => sweeps::serve(&mut surface, &order, ranks),
            Order::Evaluate { id, task } => {
                let rows = rows::give(None, task.n_rows, &work, ranks);
                evaluate((id, *task, rows), &mut work, None, ranks, &Silent);
            }
            Order::Move {
                id,
                step,
                from_zero,
                stays,
            } => work.move_to((id, step, from_zero), stays, |own| ranks.send_part(own)),
            Order::Forget { id } => work.forget(id),
            Order::Share { file, moving_faces } => {
                let parts = file.and_then(|file| parts_of_file(&file, ranks).ok());
                let (part, _) = parts.unwrap_or_else(|| Mesh::shared_of(None, ranks));
                let apart = ranks.scatter(&mut |_| None);
                work.take_part(part, &moving_faces, apart);
            }
            Order::EndMove { maps, is_rounded } => work.end_move(&maps, is_rounded),
            Order::PlaceApart => {
                let mut places = vec![[0.0; 3]; work.n_told()];
                ranks.scatter_into(&nothing, &mut places, &[]);
                work.take_apart(&places);
            }
            Order::PlaceRest => {
                let part = work.part_mut();
                ranks.send_part(&part.hashes());
                part.correct(ranks.scatter(&mut |_| None));
            }
            Order::Divide => work.own = ranks.scatter(&mut |_| None),
            Order::Collect => ranks.send_part(work.own_points().unwrap_or_default()),
            Order::Keep => work.keep(),
            Order::Write(task) => drop(ranks.gather(work.write(&task, ranks))),
            Order::Settle => drop(ranks.agree(work.settle(ranks))),
            Order::Cells => drop(work.part().cells()),
            Order::Faces => drop(work.part().faces()),
            Order::Walls => drop(work.part().normal_change()),
            Order::End => return,
        }
    }
}

/// The part of each rank, which reads it from the file; the first learns the nodes of all.
///
/// # Errors
/// Why it is not read, on all ranks.
fn parts_of_file(
    file: &SharedFile,
    ranks: &Ranks,
) -> std::result::Result<(Mesh, Vec<Vec<u32>>), String> {
    let part = ranks.together(|| read_parts(file, ranks))?;
    let nodes = part.nodes_of_parts().unwrap_or_default();
    Ok((part, nodes))
}

/// Evaluates fields at the nodes of a rank, and corrects them with all others; the first has the whole surface.
fn evaluate(
    (id, task, rows): (usize, Task, Rows),
    work: &mut Work,
    whole: Option<&WholeSurface<'_>>,
    ranks: &Ranks,
    progress: &dyn Progress,
) {
    let slab = ranks.together(|| work.evaluate(id, task.layers, rows, progress));
    if !task.boxes.is_empty() {
        ranks.is_for("correction");
        shared_correction::correct(slab, Boxes::new(task.boxes), whole, ranks);
    }
}

impl SharedFields {
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
        let ranks = &team.ranks;
        let n_ranks = ranks.n();
        let mut gather = |rows: &mut [Vector]| {
            let mut parts = kept::split(rows, n_ranks);
            if !from_zero {
                state.moves();
            }
            let own = &mut parts[0];
            let work = &mut state.work;
            let take = |moved: &[Vector]| own.copy_from_slice(moved);
            ranks.together(|| work.move_to((id, step, from_zero), false, take));
            ranks.receive_parts(&mut parts);
        };
        let Some(deforming) = &self.nodes else {
            return gather(out);
        };
        match nodes {
            Some(nodes) => out.copy_from_slice(nodes),
            None => out.fill([0.0; 3]),
        }
        let mut moved = vec![[0.0; 3]; deforming.len()];
        gather(&mut moved);
        for (&node, place) in deforming.iter().zip(moved) {
            out[node as usize] = place;
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

//! Fields and quality that several ranks share. The first rank has the whole mesh and decides; the others do what it
//! orders, each for some of the nodes and cells.
//!
//! ```text
//! fields      a slab of the nodes that deform; their values never leave the rank
//! positions   each rank moves its nodes, the first gathers them
//! quality     a part of the cells with those around it; the first gives the places of their nodes
//! ```
//!
//! Every number is the one that a rank alone finds: a value at a node does not depend on the other nodes, and sums over
//! cells are added up in the order of the whole mesh.

use super::fields::{Chosen, Fields, MeshState, Narrow};
use super::layer::{Layer, LayerKind};
use super::wall_angles::WallAngles;
use crate::geometry::vector::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::progress::{Progress, Silent};
use crate::quality::faces::FaceSummary;
use crate::quality::{Judge, Summary};
use crate::ranks::Ranks;
use crate::ranks::raw;
use crate::rbf::interpolant::Interpolant;
use crate::rbf::select::Selection;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Slabs of nodes begin at multiples of this.
const SLAB: usize = 256;
const EVALUATED: &str = "fields are evaluated before nodes are moved by them";
const SHARED: &str = "the mesh is shared before it is judged";

/// All ranks, as the first sees them.
pub(crate) struct Team {
    ranks: Ranks,
    work: Mutex<Work>,
}

/// What the first rank orders. What an order is about follows it.
#[derive(Serialize, Deserialize)]
enum Order {
    /// Evaluate fields at a slab of nodes.
    Evaluate { id: usize, task: Box<Task> },
    /// Tell where the nodes of a slab are at a step; with `from_zero` by how much they move.
    Move {
        id: usize,
        step: usize,
        from_zero: bool,
    },
    /// Fields are not needed any more.
    Forget { id: usize },
    /// Take a part of the mesh and of its moving faces.
    Share { moving_faces: Vec<u32> },
    /// Take new places for the nodes of the part.
    Place,
    /// Judge the cells of the part.
    Cells,
    /// Judge the faces of the part.
    Faces,
    /// Judge how walls lean.
    Walls,
    /// There is no more to do.
    End,
}

/// Fields that are to be evaluated.
#[derive(Serialize, Deserialize)]
struct Task {
    /// Nodes that deform.
    n_rows: usize,
    layers: Vec<LayerTask>,
    #[serde(with = "raw")]
    surface: Vec<Vector>,
    #[serde(with = "raw")]
    facets: Vec<[u32; 3]>,
    correct: bool,
}

/// What a rank has to know of a layer.
#[derive(Serialize, Deserialize)]
struct LayerTask {
    kind: LayerKind,
    n_modes: usize,
    #[serde(with = "raw")]
    coefficients: Vec<f64>,
    interpolant: Interpolant,
    #[serde(with = "raw")]
    residuals: Vec<f64>,
    error: f64,
}

impl Order {
    /// What messages after it are for.
    fn what(&self) -> &'static str {
        match self {
            Self::Evaluate { .. } | Self::Forget { .. } | Self::End => "fields",
            Self::Move { .. } => "positions",
            Self::Share { .. } => "parts",
            Self::Place => "places",
            Self::Cells | Self::Faces | Self::Walls => "quality",
        }
    }
}

/// What a rank has of the work.
#[derive(Default)]
struct Work {
    slabs: BTreeMap<usize, Slab>,
    part: Option<Part>,
    /// On the first rank: how many fields there have been.
    n_fields: usize,
    /// On the first rank: the nodes of the part of each rank.
    nodes: Vec<Vec<u32>>,
    /// On the first rank: the places that the parts have.
    places: Option<blake3::Hash>,
}

/// A slab of nodes with the fields there.
struct Slab {
    layers: Vec<Layer>,
    fields: Fields,
    nodes: Vec<Vector>,
    /// Where they were at the last step: memory that is used again.
    moved: Vec<Vector>,
}

/// A part of the mesh, and where its nodes are.
struct Part {
    mesh: Mesh,
    judge: Judge,
    walls: WallAngles,
    points: Vec<Vector>,
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
    pub fn of(ranks: &Ranks) -> Option<Arc<Self>> {
        let has_others = ranks.is_first() && ranks.n() > 1;
        has_others.then(|| {
            Arc::new(Self {
                ranks: ranks.clone(),
                work: Mutex::default(),
            })
        })
    }

    fn work(&self) -> MutexGuard<'_, Work> {
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Has all ranks evaluate fields, as [`Fields::new`] does.
    pub fn evaluate(
        self: &Arc<Self>,
        state: MeshState<'_>,
        layers: &[Layer],
        chosen: &[Chosen<'_>],
        correct: bool,
        progress: &dyn Progress,
    ) -> (SharedFields, Option<Narrow>) {
        let mut work = self.work();
        let id = work.n_fields;
        work.n_fields += 1;
        let n_layers = layers.len();
        let layers = layers.iter().zip(chosen).map(LayerTask::of).collect();
        let n_rows = state.deforming.map_or(state.nodes.len(), <[u32]>::len);
        let task = Box::new(Task {
            n_rows,
            layers,
            surface: state.surface.to_vec(),
            facets: state.facets.to_vec(),
            correct,
        });
        let given = order(&self.ranks, Order::Evaluate { id, task });
        let Order::Evaluate { task, .. } = given else {
            unreachable!("a broadcast gives what it got")
        };
        let place =
            |row: usize| state.nodes[state.deforming.map_or(row, |nodes| nodes[row] as usize)];
        let lengths = slabs(n_rows, self.ranks.n());
        let slab = |rank: usize, places: &mut [Vector]| {
            let start = rows(n_rows, rank, self.ranks.n()).start;
            parallel::update(places, |i, x| *x = place(start + i));
        };
        let narrow = work.evaluate(id, *task, &lengths, &slab, (&self.ranks, progress));
        let elsewhere = n_rows - lengths[0];
        progress.advance((elsewhere * n_layers) as u64);
        let fields = SharedFields {
            team: Arc::clone(self),
            id,
            nodes: state.deforming.map(<[u32]>::to_vec),
        };
        (fields, narrow)
    }

    /// Gives each rank a part of the mesh to judge; `moving_faces` are ascending.
    pub fn share(&self, mesh: &Mesh, moving_faces: &[u32]) {
        let mut work = self.work();
        let moving_faces = moving_faces.to_vec();
        order(
            &self.ranks,
            Order::Share {
                moving_faces: moving_faces.clone(),
            },
        );
        let (part, nodes) = Mesh::shared_of(Some(mesh), &self.ranks);
        work.take_part(part, &moving_faces);
        (work.nodes, work.places) = (nodes, None);
    }

    /// The quality of the cells with all nodes at `points`.
    pub fn cells(&self, points: &[Vector]) -> Summary {
        let work = self.placed(points);
        order(&self.ranks, Order::Cells);
        work.part().cells()
    }

    /// The quality of the faces.
    pub fn faces(&self, points: &[Vector]) -> FaceSummary {
        let work = self.placed(points);
        order(&self.ranks, Order::Faces);
        work.part().faces()
    }

    /// The largest change of the angle between a moving wall and its first cell, in degrees.
    pub fn normal_change(&self, points: &[Vector]) -> Option<f64> {
        let work = self.placed(points);
        order(&self.ranks, Order::Walls);
        work.part().normal_change()
    }

    /// The work, once all parts have their nodes at `points`.
    fn placed(&self, points: &[Vector]) -> MutexGuard<'_, Work> {
        let mut work = self.work();
        let mut hasher = blake3::Hasher::new();
        let hash = hasher.update_rayon(bytemuck::cast_slice(points)).finalize();
        if work.places == Some(hash) {
            return work;
        }
        order(&self.ranks, Order::Place);
        let Work { part, nodes, .. } = &mut *work;
        let of_rank = |rank: usize, places: &mut [Vector]| {
            let nodes = &nodes[rank];
            parallel::update(places, |i, x| *x = points[nodes[i] as usize]);
        };
        let lengths: Vec<usize> = nodes.iter().map(Vec::len).collect();
        let part = part.as_mut().expect(SHARED);
        self.ranks
            .scatter_into(&of_rank, &mut part.points, &lengths);
        work.places = Some(hash);
        work
    }
}

/// Gives an order to all ranks, and gives it back.
fn order(ranks: &Ranks, order: Order) -> Order {
    ranks.is_for(order.what());
    ranks.broadcast(Some(order))
}

/// Sends the other ranks home.
pub fn dismiss(ranks: &Ranks) {
    if ranks.n() > 1 {
        order(ranks, Order::End);
    }
}

/// Does what the first rank orders, until there is no more to do.
pub fn serve(ranks: &Ranks) {
    let mut work = Work::default();
    let nothing = |_: usize, _: &mut [Vector]| {};
    loop {
        let order = ranks.broadcast::<Order>(None);
        ranks.is_for(order.what());
        match order {
            Order::Evaluate { id, task } => {
                let lengths = slabs(task.n_rows, ranks.n());
                work.evaluate(id, *task, &lengths, &nothing, (ranks, &Silent));
            }
            Order::Move {
                id,
                step,
                from_zero,
            } => {
                let slab = work.slabs.get_mut(&id).expect(EVALUATED);
                let mut moved = std::mem::take(&mut slab.moved);
                moved.resize(slab.nodes.len(), [0.0; 3]);
                slab.move_to(step, from_zero, &mut moved);
                ranks.send_part(&moved);
                slab.moved = moved;
            }
            Order::Forget { id } => drop(work.slabs.remove(&id)),
            Order::Share { moving_faces } => {
                let (part, _) = Mesh::shared_of(None, ranks);
                work.take_part(part, &moving_faces);
            }
            Order::Place => {
                let part = work.part.as_mut().expect(SHARED);
                ranks.scatter_into(&nothing, &mut part.points, &[]);
            }
            Order::Cells => drop(work.part().cells()),
            Order::Faces => drop(work.part().faces()),
            Order::Walls => drop(work.part().normal_change()),
            Order::End => return,
        }
    }
}

/// The rows of a rank.
fn rows(n: usize, rank: usize, n_ranks: usize) -> Range<usize> {
    let start = |rank: usize| (rank * n.div_ceil(SLAB) / n_ranks * SLAB).min(n);
    start(rank)..start(rank + 1)
}

/// How many rows each rank has.
fn slabs(n: usize, n_ranks: usize) -> Vec<usize> {
    (0..n_ranks)
        .map(|rank| rows(n, rank, n_ranks).len())
        .collect()
}

impl LayerTask {
    fn of((layer, chosen): (&Layer, &Chosen<'_>)) -> Self {
        Self {
            kind: layer.kind.clone(),
            n_modes: layer.modes.n_modes,
            coefficients: layer.modes.coefficients.clone(),
            interpolant: chosen.selection.interpolant.clone(),
            residuals: chosen.selection.residuals.clone(),
            error: chosen.error,
        }
    }
}

impl Work {
    fn evaluate(
        &mut self,
        id: usize,
        task: Task,
        lengths: &[usize],
        slab: &dyn Fn(usize, &mut [Vector]),
        (ranks, progress): (&Ranks, &dyn Progress),
    ) -> Option<Narrow> {
        let mut nodes = vec![[0.0; 3]; lengths[ranks.rank()]];
        ranks.scatter_into(slab, &mut nodes, lengths);
        let state = MeshState {
            nodes: &nodes,
            deforming: None,
            surface: &task.surface,
            facets: &task.facets,
        };
        let mut layers = Vec::new();
        let mut selections = Vec::new();
        for of in task.layers {
            layers.push(Layer::elsewhere(of.kind, of.n_modes, of.coefficients));
            selections.push((Selection::elsewhere(of.interpolant, of.residuals), of.error));
        }
        let chosen = selections.iter().map(|(selection, error)| Chosen {
            selection,
            error: *error,
        });
        let chosen: Vec<_> = chosen.collect();
        let fields = Fields::new(state, &layers, &chosen, task.correct, progress, None);
        let narrow = fields.narrow;
        let slab = Slab {
            layers,
            fields,
            nodes,
            moved: Vec::new(),
        };
        self.slabs.insert(id, slab);
        narrow
    }

    fn take_part(&mut self, mesh: Mesh, moving_faces: &[u32]) {
        let judge = Judge::new(&mesh);
        let numbers = mesh.part.as_ref().map_or(&[][..], |part| &part.cells);
        let here = moving_faces
            .iter()
            .filter_map(|face| numbers.binary_search(face).ok());
        let here: Vec<u32> = here.map(|face| face as u32).collect();
        self.part = Some(Part {
            walls: WallAngles::find(&mesh, &judge.adjacency, &here),
            points: mesh.points.clone(),
            judge,
            mesh,
        });
    }

    fn part(&self) -> &Part {
        self.part.as_ref().expect(SHARED)
    }
}

impl Slab {
    fn move_to(&self, step: usize, from_zero: bool, moved: &mut [Vector]) {
        match from_zero {
            true => self.fields.vectors(&self.layers, step, moved),
            false => {
                let state = MeshState {
                    nodes: &self.nodes,
                    deforming: None,
                    surface: &[],
                    facets: &[],
                };
                self.fields.displace(&self.layers, step, state, moved);
            }
        }
    }
}

impl Part {
    fn cells(&self) -> Summary {
        self.judge.cells(&self.mesh, &self.points)
    }

    fn faces(&self) -> FaceSummary {
        self.judge.faces(&self.mesh, &self.points)
    }

    fn normal_change(&self) -> Option<f64> {
        let own = self
            .walls
            .largest_change(&self.mesh, &self.points, &self.mesh.points);
        let all = self.mesh.ranks().all(own);
        all.into_iter().flatten().max_by(f64::total_cmp)
    }
}

impl SharedFields {
    /// Writes the positions of the nodes at a step to `out`, from `nodes`, or with none by how much they move.
    pub fn move_to(&self, step: usize, nodes: Option<&[Vector]>, out: &mut [Vector]) {
        let (team, work) = (&self.team, self.team.work());
        let (id, from_zero) = (self.id, nodes.is_none());
        let ranks = &team.ranks;
        order(
            ranks,
            Order::Move {
                id,
                step,
                from_zero,
            },
        );
        let gather = |rows: &mut [Vector]| {
            let mut rest = rows;
            let mut parts = Vec::new();
            for length in slabs(rest.len(), ranks.n()) {
                let (part, others) = rest.split_at_mut(length);
                parts.push(part);
                rest = others;
            }
            work.slabs[&id].move_to(step, from_zero, parts[0]);
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
        let mut work = self.team.work();
        let id = self.id;
        order(&self.team.ranks, Order::Forget { id });
        work.slabs.remove(&id);
    }
}

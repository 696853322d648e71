//! One slab: its nodes moved, its cells judged.

use super::super::interval::Interval;
use super::super::mesh_file::MeshFile;
use super::super::plan::Plan;
use super::super::step_memory::Rounding;
use super::super::team::cells_among;
use super::super::wall_angles::WallAngles;
use super::SlabOf;
use super::stored::{Left, Moved, StoredStep, ToldOfStep};
use crate::error::Result;
use crate::geometry::vector::Vector;
use crate::mesh::{Mesh, node_slab};
use crate::motion::Step;
use crate::parallel;
use crate::quality::Judge;
use crate::ranks::{Ranks, Told};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// A slab of a mesh, with the cells around it.
pub struct OneSlab {
    /// Of which its part is read, where this process does not have the whole mesh.
    pub(in crate::deform) file: Option<Arc<MeshFile>>,
    /// Which it is.
    pub slab: SlabOf,
    /// Made when it is asked for where this process has the whole mesh.
    part: OnceLock<Mesh>,
    judging: OnceLock<Judging>,
}

/// What the cells of the slab are judged by.
struct Judging {
    judge: Judge,
    walls: WallAngles,
    /// What is told of the mesh at rest.
    at_rest: Told,
}

impl OneSlab {
    /// A slab of the mesh in a file, or of one that this process has as a whole.
    pub(super) fn new(file: Option<Arc<MeshFile>>, slab: SlabOf) -> Self {
        Self {
            file,
            slab,
            part: OnceLock::new(),
            judging: OnceLock::new(),
        }
    }

    /// The same slab of another file, if it is of one.
    pub(in crate::deform) fn of_file(
        &self,
        other: impl FnOnce(&Arc<MeshFile>) -> Arc<MeshFile>,
    ) -> Self {
        Self::new(self.file.as_ref().map(other), self.slab)
    }

    /// Reads its part, where this process does not have the whole mesh, and lets the outline know where its nodes are.
    pub(in crate::deform) fn read(&self, outline: &mut Arc<Mesh>) -> Result<()> {
        let Some(file) = &self.file else {
            return Ok(());
        };
        let SlabOf { number, n } = self.slab;
        let part = file
            .file()
            .by_pieces(|slabs, _| Mesh::part_by_pieces(slabs, (number, n), &Ranks::telling()))?;
        Arc::make_mut(outline).take_places(part.numbers_in_whole(), &part.points);
        assert!(self.part.set(part).is_ok(), "a slab is read once");
        Ok(())
    }

    /// Its part of a mesh: the whole, or the outline of that where it was read as a part.
    pub(crate) fn part(&self, mesh: &Mesh) -> &Mesh {
        let SlabOf { number, n } = self.slab;
        let cut = || mesh.part_of((number, n), &Ranks::telling());
        self.part.get_or_init(cut)
    }

    /// Its own nodes, by their numbers in the whole mesh.
    pub(crate) fn own_nodes(&self, plan: &Plan) -> Range<usize> {
        node_slab(plan.mesh.points.len(), self.slab.number, self.slab.n)
    }

    /// Finds what its cells are judged by.
    fn judging(&self, plan: &Plan) -> &Judging {
        self.judging.get_or_init(|| {
            let part = self.part(&plan.mesh);
            let judge = Judge::new(part);
            let moving = cells_among(part, &plan.moving_faces);
            Judging {
                walls: WallAngles::find(part, &judge.adjacency, &moving),
                judge,
                at_rest: part.ranks().told(),
            }
        })
    }

    /// Computes a step and leaves it where `left` says. `points` has room for all nodes of the whole mesh, of which those that
    /// the slab moves are written, in the slots of the mesh.
    pub(crate) fn leave_step(
        &self,
        interval: &Interval,
        step: &Step,
        rounding: Rounding,
        points: &mut [Vector],
        left: &Left<'_>,
    ) -> Result<()> {
        let plan = &interval.plan;
        let slots = plan.mesh.slots();
        let error = interval.points_at(step, points)?;
        match plan.mesh.outline {
            Some(_) => rounding.apply_to(self.part(&plan.mesh).numbers_in_whole(), (slots, points)),
            None => rounding.apply(points),
        }
        let told = match plan.judges() {
            true => self.judge(plan, points),
            false => ToldOfStep::default(),
        };
        let own = self.own_nodes(plan);
        let moved = Moved {
            step: step.index,
            base: interval.hash_of_base(),
            selection_error: error,
        };
        // All of them are known, if there are any.
        let first = match own.is_empty() {
            true => 0,
            false => slots.of(own.start as u32),
        };
        let velocities = interval.velocities_of_slab(step);
        let of_own = |all: &[Vector]| all[first..first + own.len()].to_vec();
        let velocities = velocities.map(|all| of_own(&all));
        let places = &points[first..first + own.len()];
        StoredStep::save(left, moved, own, (places, velocities.as_deref()), told)
    }

    /// What its cells are like with the nodes at `points`.
    fn judge(&self, plan: &Plan, points: &[Vector]) -> ToldOfStep {
        let Judging {
            judge,
            walls,
            at_rest,
        } = self.judging(plan);
        let part = self.part(&plan.mesh);
        let (ranks, nodes) = (part.ranks(), part.numbers_in_whole());
        let slots = plan.mesh.slots();
        let places = parallel::collect(nodes.len(), |i| points[slots.of(nodes[i])]);
        judge.cells(part, &places);
        let cells = ranks.told();
        judge.faces(part, &places);
        let faces = ranks.told();
        ranks.all(walls.largest_change(part, &places, &part.points));
        ToldOfStep {
            at_rest: at_rest.clone(),
            cells,
            faces,
            walls: ranks.told(),
        }
    }
}

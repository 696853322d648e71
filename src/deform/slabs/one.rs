//! One slab: its nodes moved, its cells judged.

use super::super::interval::Interval;
use super::super::plan::Plan;
use super::super::step_memory::Rounding;
use super::super::team::cells_among;
use super::super::wall_angles::WallAngles;
use super::SlabOf;
use super::mesh_file::MeshFile;
use super::stored::{Left, StoredStep, ToldOfStep};
use crate::error::Result;
use crate::geometry::vector::Vector;
use crate::mesh::{Mesh, Part, node_slab};
use crate::motion::Step;
use crate::parallel;
use crate::quality::Judge;
use crate::ranks::{Ranks, Told};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// A slab of a mesh, with the cells around it.
pub struct OneSlab {
    pub(in crate::deform) file: Arc<MeshFile>,
    /// Which it is.
    pub slab: SlabOf,
    part: Mesh,
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
    pub(super) fn read(file: &Arc<MeshFile>, slab: SlabOf) -> Result<Self> {
        let part = file.file().by_pieces(|slabs, _| {
            Mesh::part_by_pieces(slabs, (slab.number, slab.n), &Ranks::telling())
        })?;
        Ok(Self {
            file: Arc::clone(file),
            slab,
            part,
            judging: OnceLock::new(),
        })
    }

    fn part(&self) -> &Part {
        let part = self.part.part.as_ref();
        part.expect("it was read as a part of a mesh")
    }

    /// The nodes that it has, its own and those around, by their numbers in the whole mesh, ascending.
    pub(crate) fn nodes(&self) -> &[u32] {
        &self.part().nodes
    }

    /// Where these are at rest.
    pub(super) fn places(&self) -> &[Vector] {
        &self.part.points
    }

    /// Its own nodes, by their numbers in the whole mesh.
    pub(crate) fn own_nodes(&self) -> Range<usize> {
        node_slab(self.part().n_nodes, self.slab.number, self.slab.n)
    }

    /// Finds what its cells are judged by.
    fn judging(&self, plan: &Plan) -> &Judging {
        self.judging.get_or_init(|| {
            let judge = Judge::new(&self.part);
            let moving = cells_among(&self.part, &plan.moving_faces);
            Judging {
                walls: WallAngles::find(&self.part, &judge.adjacency, &moving),
                judge,
                at_rest: self.part().ranks.told(),
            }
        })
    }

    /// Computes a step and leaves it where `left` says. `points` has room for all nodes of the whole mesh, of which those that
    /// move are written.
    pub(crate) fn leave_step(
        &self,
        interval: &Interval,
        step: &Step,
        rounding: Rounding,
        points: &mut [Vector],
        left: &Left<'_>,
    ) -> Result<()> {
        let plan = &interval.plan;
        let moved = interval.deforming().expect("a slab moves some nodes");
        interval.moved_points_at(step, points);
        rounding.apply_to(moved, points);
        let told = match plan.judges() {
            true => self.judge(plan, points),
            false => ToldOfStep::default(),
        };
        let own = self.own_nodes();
        let of = (step.index, interval.hash_of_base());
        StoredStep::save(left, of, own.clone(), &points[own], told)
    }

    /// What its cells are like with the nodes at `points`.
    fn judge(&self, plan: &Plan, points: &[Vector]) -> ToldOfStep {
        let Judging {
            judge,
            walls,
            at_rest,
        } = self.judging(plan);
        let (part, ranks, nodes) = (&self.part, &self.part().ranks, self.nodes());
        let places = parallel::collect(nodes.len(), |i| points[nodes[i] as usize]);
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

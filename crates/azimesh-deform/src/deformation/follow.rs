//! A run on several ranks. The first rank reads the earlier run from the disk and decides what is computed. Before each
//! collective function it announces the call, and the other ranks make the same call in [`Deformation::follow`].

use super::{Deformation, Evaluated};
use crate::base::base_points::BasePoints;
use crate::base::choose::from_nodes;
use crate::base::tolerance::BaseOrigin;
use crate::step::evaluator::StepEvaluator;
use crate::step::step_memory::Rounding;
use crate::write::{OwnValues, write_together};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::progress::Silent;
use azimesh_io::mesh::Apart;
use azimesh_rbf::select::Selection;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

const ENTERED: &str = "an interval is entered before its steps are computed";

/// A collective call, announced by the first rank.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) enum Call {
    /// [`Deformation::choose`].
    Choose(Range<usize>),
    /// [`Deformation::enter`] at the first of some steps, with these base points or the ones selected last.
    Enter(usize, Option<BasePoints>),
    /// [`Deformation::set_added`], with the repaired ones of the last steps.
    Added(Vec<usize>, Vec<usize>),
    /// [`Deformation::join`] after a step.
    Seam(usize),
    /// [`Deformation::prepare_measures`].
    Measures,
    /// [`Deformation::quality_at_rest`].
    AtRest,
    /// [`Deformation::evaluate`] of a step.
    Evaluate(usize, Rounding),
    /// [`Deformation::place`] at a step.
    Place(usize, Rounding),
    /// [`Deformation::positions_to_write`] of the last step.
    Gather,
    /// [`Deformation::write_together`] of the last step, with sync or without.
    Write(bool),
    /// The end of the run.
    End,
}

impl Call {
    /// Returns the label under which messages of the call are counted.
    fn label(&self) -> &'static str {
        match self {
            Self::Choose(_) => "selection",
            Self::Enter(..) => "fields",
            Self::Added(..)
            | Self::Seam(_)
            | Self::Measures
            | Self::AtRest
            | Self::Evaluate(..)
            | Self::Place(..) => "steps",
            Self::Gather | Self::Write(_) => "writing",
            Self::End => "end",
        }
    }
}

impl Deformation {
    /// Makes the other ranks follow this one, the first.
    #[doc(hidden)]
    pub fn lead(&mut self) {
        self.is_leading = self.is_on_ranks();
    }

    /// Announces the next collective call to following ranks, on the first rank.
    pub(super) fn announce(&self, call: Call) {
        if self.is_leading {
            let ranks = self.part.ranks();
            ranks.set_label(call.label());
            ranks.broadcast(Some(call));
        }
    }

    /// Makes the calls that the first rank announces, until the run has ended; for all other ranks.
    #[doc(hidden)]
    pub fn follow(&self) {
        let ranks = self.part.ranks();
        let mut points = self.part.mesh.points.clone();
        let mut velocities = Vec::new();
        let mut chosen: Vec<Selection> = Vec::new();
        let mut current: Option<Arc<StepEvaluator>> = None;
        loop {
            // An error here also occurs on the first rank, which ends the run.
            let call = ranks.broadcast::<Call>(None);
            ranks.set_label(call.label());
            match call {
                Call::Choose(steps) => chosen = self.choose(&steps, &Silent).unwrap_or_default(),
                Call::Enter(step, base) => {
                    drop(current.take());
                    self.leave();
                    let step = &self.steps()[step];
                    let entered = self.enter(step, &Silent, &mut |plan, steps| match &base {
                        Some(base) => Ok((BaseOrigin::Given, from_nodes(plan, steps, base)?)),
                        None => Ok((BaseOrigin::Chosen, std::mem::take(&mut chosen))),
                    });
                    current = entered.ok();
                }
                Call::Added(after, repaired) => {
                    self.set_added(&after, |step| repaired.contains(&step));
                }
                Call::Seam(step) => {
                    let interval = current.as_ref().expect(ENTERED);
                    let _ = self.join(interval, &self.steps()[step]);
                }
                Call::Measures => self.prepare_measures(),
                Call::AtRest => drop(self.quality_at_rest()),
                Call::Evaluate(step, rounding) => {
                    let step = &self.steps()[step];
                    let interval = current.as_ref().expect(ENTERED);
                    let found = self.evaluate(interval, step, rounding, &mut points);
                    velocities = velocities_of(found);
                }
                Call::Place(step, rounding) => {
                    let step = &self.steps()[step];
                    let interval = current.as_ref().expect(ENTERED);
                    let found = self.place(interval, step, rounding, &mut points);
                    velocities = velocities_of(found);
                }
                Call::Gather => drop(self.positions_to_write(&points, &mut velocities)),
                Call::Write(sync) => {
                    // The first rank has the error of any rank.
                    let own = self.own_values(&points, &velocities);
                    let _ = write_together::<()>(own, sync, None);
                }
                Call::End => return,
            }
        }
    }
}

fn velocities_of(found: Result<Evaluated>) -> Vec<Vector> {
    let velocities = found.ok().and_then(|found| found.velocities);
    velocities.unwrap_or_default()
}

/// Functions of the first rank.
impl Deformation {
    /// Ends a run on several ranks.
    #[doc(hidden)]
    pub fn end(&self) {
        self.announce(Call::End);
    }

    /// Gathers the positions and velocities of all nodes on the first rank for writing. If all ranks write the mesh
    /// together, each rank keeps its own.
    pub fn positions_to_write<'a>(
        &self,
        points: &'a [Vector],
        velocities: &mut Vec<Vector>,
    ) -> Cow<'a, [Vector]> {
        if self.part.ranks().n() == 1 || self.is_written_together() {
            return Cow::Borrowed(points);
        }
        self.announce(Call::Gather);
        let mesh = &self.part.mesh;
        if self.plan.velocity.is_some() {
            velocities.resize(points.len(), [0.0; 3]);
            *velocities = mesh
                .gather_nodes(&velocities[mesh.own_nodes()])
                .unwrap_or_default();
        }
        Cow::Owned(
            mesh.gather_nodes(&points[mesh.own_nodes()])
                .unwrap_or_default(),
        )
    }

    /// Returns the nodes of the part of this rank.
    pub fn n_nodes_here(&self) -> usize {
        self.part.mesh.points.len()
    }

    /// Returns whether several ranks have parts of the mesh.
    pub fn is_on_ranks(&self) -> bool {
        self.part.ranks().n() > 1
    }

    /// Makes all ranks write a step; `write` receives the numbers of all of them.
    ///
    /// # Errors
    /// Of `write`, and if a rank cannot write its numbers.
    pub fn write_together<T>(
        &self,
        points: &[Vector],
        velocities: &[Vector],
        sync: bool,
        write: &mut dyn FnMut(&dyn Apart) -> Result<T>,
    ) -> Result<T> {
        self.announce(Call::Write(sync));
        let own = self.own_values(points, velocities);
        let written = write_together(own, sync, Some(write))?;
        Ok(written.expect("this is the first rank"))
    }

    fn own_values<'a>(&'a self, points: &'a [Vector], velocities: &'a [Vector]) -> OwnValues<'a> {
        OwnValues {
            mesh: &self.part.mesh,
            points,
            velocities,
        }
    }
}

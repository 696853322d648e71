//! The largest displacement of each body over the steps of a schedule, and whether it leaves the region that deforms.

use super::motion::{places_at, points_of};
use super::seams::Off;
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::numbers::in_digits;
use azimesh_core::{Note, note, parallel};
use azimesh_deform::Plan;
use std::collections::BTreeMap;

/// Tolerance of the region, as a part of its extent.
const OUTSIDE: f64 = 1e-9;
/// Largest number of surface points times steps to check.
const MOST: usize = 300_000_000;

/// The largest displacements of bodies over the steps, and the bodies that leave the deforming region.
#[derive(Debug, Clone, PartialEq)]
pub struct LargestDisplacements {
    /// Number of checked steps: all, or an even selection of very many.
    pub n_steps: usize,
    /// For each body the step of the largest displacement of one of its points, and that displacement in mesh units; the
    /// first step and 0 if it has no points.
    pub farthest: Vec<(usize, f64)>,
    /// The steps at which bodies leave the deforming region.
    pub leaving: BTreeMap<usize, Vec<usize>>,
    /// The zones that do not stay in their interfaces.
    pub(super) off: Vec<Off>,
}

impl LargestDisplacements {
    /// Computes them for a plan. Evaluates poses at surface points times steps.
    pub fn new(plan: &Plan) -> Self {
        let region = Region::new(plan);
        let all = &plan.motion.steps;
        let stride = (all.len() * plan.surface.points.len())
            .div_ceil(MOST)
            .max(1);
        let bodies = 0..plan.motion.bodies.len();
        let points: Vec<Vec<usize>> = bodies.map(|body| points_of(plan, body)).collect();
        let mut extremes = Self {
            n_steps: all.len().div_ceil(stride),
            farthest: vec![(0, 0.0); points.len()],
            leaving: BTreeMap::new(),
            off: Off::find(plan),
        };
        for step in all.iter().step_by(stride) {
            let places = places_at(plan, step);
            let poses = plan.motion.poses(step, 1.0);
            for &(body, x) in &plan.rigid_points {
                let off = distance(poses[body].apply(x), x);
                if off > extremes.farthest[body].1 {
                    extremes.farthest[body] = (step.index(), off);
                }
            }
            for (points, farthest) in points.iter().zip(&mut extremes.farthest) {
                let off = |at: usize| distance(places[at], plan.surface.points[at]);
                let off = parallel::largest(points.len(), |i| off(points[i]));
                if off > farthest.1 {
                    *farthest = (step.index(), off);
                }
            }
            for body in region.left_by(plan, &places) {
                extremes.leaving.entry(body).or_default().push(step.index());
            }
        }
        extremes
    }

    /// Refuses a body that leaves the deforming region: cells there are inverted, or left far behind. Free and periodic
    /// boundaries follow the body, and are not refused. Refuses zones that run into others as well.
    ///
    /// # Errors
    /// Of kind `Input`, with the distance.
    pub(crate) fn refuse_leaving(&self, plan: &Plan) -> Result<()> {
        self.refuse_turning_out(plan)?;
        let motion = &plan.motion;
        let follow =
            !motion.periodic.is_empty() || motion.surface.tags.iter().any(|tag| tag.role.is_none());
        let Some((&body, steps)) = self.leaving.first_key_value().filter(|_| !follow) else {
            return Ok(());
        };
        let (step, distance) = self.farthest[body];
        Err(Error::input(format!(
            "{}: it moves by up to {}, at step {step}, and the mesh is {} across; give the motion in mesh units, or allow this with \
             --allow-outside",
            self.leaves_box(plan, body, steps),
            in_digits(distance, 3),
            in_digits(plan.boundary.extent.diagonal(), 3),
        ))
        .at(motion.bodies[body].place.clone())
        .file(&plan.schedule.path))
    }

    /// Refuses zones that run into others while they turn or move.
    pub fn refuse_turning_out(&self, plan: &Plan) -> Result<()> {
        self.off.iter().try_for_each(|off| off.refuse(plan))
    }

    /// Returns a note on a body that leaves the deforming region at `steps`.
    pub(super) fn leaves_box(&self, plan: &Plan, body: usize, steps: &[usize]) -> Note {
        note!(
            "leaves_box",
            "body \"{}\" leaves the bounding box of the mesh at {} of the {} checked, first at step {}",
            plan.motion.bodies[body].name,
            steps.len(),
            counted(self.n_steps, "step"),
            steps[0]
        )
    }

    /// Returns the step of the largest displacement of any body, and that displacement.
    pub fn largest(&self) -> (usize, f64) {
        let bodies = self.farthest.iter().copied();
        bodies.fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a })
    }
}

/// The box around the deforming nodes.
struct Region {
    bounds: Bounds,
    /// For each body the sides, low then high, that it does not touch.
    held: Vec<[[bool; 3]; 2]>,
}

impl Region {
    fn new(plan: &Plan) -> Self {
        let bounds = plan.region;
        let slack = OUTSIDE * bounds.diagonal();
        let held = |body: usize| {
            let points = points_of(plan, body);
            let own = Bounds::around(points.iter().map(|&at| &plan.surface.points[at]));
            [
                std::array::from_fn(|i| own.low[i] > bounds.low[i] + slack),
                std::array::from_fn(|i| own.high[i] < bounds.high[i] - slack),
            ]
        };
        Self {
            held: (0..plan.motion.bodies.len()).map(held).collect(),
            bounds,
        }
    }

    /// Returns the bodies with a point beyond a side that they do not touch in the reference mesh, and beyond all other
    /// surfaces: the boundary may have moved with them.
    fn left_by(&self, plan: &Plan, places: &[Vector]) -> Vec<usize> {
        let slack = OUTSIDE * self.bounds.diagonal();
        // One entry per body, and a last one for points of no body.
        let mut bounds = vec![Bounds::EMPTY; self.held.len() + 1];
        for (place, body) in places.iter().zip(&plan.surface.body) {
            bounds[body.map_or(self.held.len(), usize::from)].include(place);
        }
        let leaves = |body: &usize| {
            let [low, high] = &self.held[*body];
            let others = bounds.iter().enumerate().filter(|(other, _)| other != body);
            let others = others.fold(self.bounds, |all, (_, of)| all.union(of));
            (0..3).any(|i| {
                low[i] && bounds[*body].low[i] < others.low[i] - slack
                    || high[i] && bounds[*body].high[i] > others.high[i] + slack
            })
        };
        (0..self.held.len()).filter(leaves).collect()
    }
}

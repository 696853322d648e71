//! Node positions at any step: the mode fields, the exact surface and the carrying round.

use super::plan::Plan;
use super::progress::Progress;
use crate::error::Result;
use crate::geometry::vector::{Vector, distance};
use crate::motion::{Role, Step};
use crate::rbf::correct::{Correction, REACH};
use crate::rbf::evaluate::WeightedBase;
use crate::rbf::field::Field;
use crate::rbf::select::Selection;
use rayon::prelude::*;

/// A gap between two surfaces under this many tolerances is warned of.
const NARROW: f64 = 20.0;

/// The deformation of a mesh at every step of its plan.
pub struct Deformer<'a> {
    plan: &'a Plan,
    field: Field,
    /// Warnings about the surface, as sentences.
    pub warnings: Vec<String>,
}

impl<'a> Deformer<'a> {
    /// Evaluates the modes at every node that deforms, and corrects them so that the surface is
    /// exact.
    pub fn new(plan: &'a Plan, selection: &Selection, progress: &dyn Progress) -> Result<Self> {
        let base: Vec<Vector> = selection
            .base
            .iter()
            .map(|&i| plan.surface.points[i])
            .collect();
        let weighted = WeightedBase {
            basis: plan.basis,
            points: &base,
            weights: &selection.weights,
            n_columns: plan.modes.n_modes,
        };
        let nodes = plan.deforming_nodes();
        let n_nodes = nodes.as_ref().map_or(plan.reference.len(), Vec::len);
        progress.start("modes", Some(n_nodes as u64));
        let report = |n: usize| progress.advance(n as u64);
        let mut field = Field::evaluate(&weighted, &plan.reference, nodes, &report);
        progress.finish();
        let mut warnings = Vec::new();
        if plan.schedule.selection.correction {
            correct(plan, selection, &mut field, &mut warnings);
        }
        Ok(Self {
            plan,
            field,
            warnings,
        })
    }

    /// Writes the node positions at a step to `out`.
    pub fn points_at(&self, step: &Step, out: &mut [Vector]) {
        let plan = self.plan;
        let coefficients = match plan.modes.n_modes {
            0 => &[],
            _ => plan.modes.at_step(step.index),
        };
        self.field.displace(coefficients, &plan.reference, out);
        if plan.schedule.selection.correction {
            self.set_surface(step, out);
        }
        if let Some(carry) = plan.motion.carry(step) {
            let inside = plan.motion.zone.as_ref().map(|zone| &zone.nodes);
            out.par_iter_mut().enumerate().for_each(|(node, x)| {
                if inside.is_none_or(|inside| inside[node]) {
                    *x = carry.apply(*x);
                }
            });
            if plan.schedule.selection.correction {
                self.set_moving(step, out);
            }
        }
    }

    /// Surface nodes where the motion puts them, in the rotating frame; fixed ones as they were.
    fn set_surface(&self, step: &Step, out: &mut [Vector]) {
        let surface = &self.plan.motion.surface.nodes;
        for (&node, role) in surface.nodes.iter().zip(&surface.roles) {
            if *role == Role::Fixed {
                out[node as usize] = self.plan.reference[node as usize];
            }
        }
        if self.plan.motion.carry(step).is_none() {
            self.set_moving(step, out);
        }
    }

    /// Moving nodes at their exact places, the carrying round included.
    fn set_moving(&self, step: &Step, out: &mut [Vector]) {
        let poses = self.plan.poses_at(step);
        let surface = &self.plan.motion.surface.nodes;
        for (&node, role) in surface.nodes.iter().zip(&surface.roles) {
            if let Role::Moving(body) = role {
                let pose = &poses[usize::from(*body)];
                out[node as usize] = pose.apply(self.plan.reference[node as usize]);
            }
        }
    }

    /// Largest and root-mean-square distance of the surface nodes in `points` from where the motion
    /// puts them.
    pub fn surface_error(&self, step: &Step, points: &[Vector]) -> (f64, f64) {
        let poses = self.plan.poses_at(step);
        let carry = self.plan.motion.carry(step);
        let surface = &self.plan.motion.surface.nodes;
        let (mut largest, mut squares) = (0.0, 0.0);
        for (&node, role) in surface.nodes.iter().zip(&surface.roles) {
            let x = self.plan.reference[node as usize];
            let exact = match (role, &carry) {
                (Role::Moving(body), _) => poses[usize::from(*body)].apply(x),
                (_, Some(carry)) => carry.apply(x),
                (_, None) => x,
            };
            let error = distance(points[node as usize], exact);
            largest = f64::max(largest, error);
            squares += error * error;
        }
        let n = surface.nodes.len().max(1) as f64;
        (largest, (squares / n).sqrt())
    }
}

fn correct(plan: &Plan, selection: &Selection, field: &mut Field, warnings: &mut Vec<String>) {
    let surface = &plan.surface;
    let correction = Correction::new(
        &surface.points,
        &surface.facets,
        &selection.residuals,
        plan.modes.n_modes,
        selection.error,
    );
    correction.add_to(field, &plan.reference);
    let narrow = correction
        .narrowest_gap
        .filter(|gap| gap.width < NARROW * plan.tolerance);
    if let Some(gap) = narrow {
        warnings.push(format!(
            "two surfaces are {:.3e} apart at node {}, which is under {NARROW} tolerances; the correction \
             fades out over half of that instead of {:.3e}, so a smaller tolerance would serve the cells there",
            gap.width,
            surface.nodes[gap.node],
            REACH * selection.error
        ));
    }
}

//! A step in substeps: the motion is divided into equal parts, and each is interpolated on the mesh of the previous part.

use super::evaluator::{StepEvaluator, largest_error, reference, uncorrected};
use crate::fields::sliding;
use crate::fields::{Chosen, Fields, MeshState};
use crate::motion::Step;
use crate::plan::layer;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::parallel;
use azimesh_core::progress::Silent;
use azimesh_rbf::Kernel;
use azimesh_rbf::modes::RigidSurface;
use azimesh_rbf::select::{self, Measure};
use azimesh_rbf::targets::Targets;

/// The equal parts of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parts {
    /// Their number.
    pub n: usize,
    /// The kernel of their interpolation; `None` for the kernel of the schedule.
    pub kernel: Option<Kernel>,
}

impl StepEvaluator {
    /// Computes a step in parts, each interpolated on the mesh of the previous part; returns the largest error of a part
    /// before its correction, or without the correction the error of the positions. All ranks call it.
    pub(crate) fn through_substeps(
        &self,
        step: &Step,
        parts: Parts,
        out: &mut [Vector],
    ) -> Result<f64> {
        let (plan, mesh) = (&*self.plan, &self.part.mesh);
        let mut nodes = mesh.points.clone();
        let mut worst: f64 = 0.0;
        let n = parts.n as f64;
        for part in 1..=parts.n {
            let (from, to) = ((part - 1) as f64 / n, part as f64 / n);
            let error = self.substep(step, from, to, parts.kernel, &nodes, out)?;
            worst = worst.max(error);
            plan.periodic.follow(plan, mesh, None, out);
            nodes.copy_from_slice(out);
        }
        if plan.schedule.selection.correction {
            return Ok(worst);
        }
        // Errors that the correction does not remove add up from part to part.
        Ok(self.off_place(&plan.motion.poses(step, 1.0), None, out).0)
    }

    /// Gathers the positions of all surface points from the nodes of all ranks.
    fn surface_points(&self, nodes: &[Vector]) -> Vec<Vector> {
        let of_nodes = self.part.surface_values(|node, _| nodes[node]);
        let (numbers, points) = (
            &self.plan.motion.surface.nodes.nodes,
            &self.plan.surface.nodes,
        );
        parallel::collect(points.len(), |at| {
            of_nodes[numbers.partition_point(|&node| node < points[at])]
        })
    }

    fn substep(
        &self,
        step: &Step,
        from: f64,
        to: f64,
        kernel: Option<Kernel>,
        nodes: &[Vector],
        out: &mut [Vector],
    ) -> Result<f64> {
        let plan = &*self.plan;
        let surface = self.surface_points(nodes);
        let rigid = RigidSurface {
            points: &surface,
            body: &plan.surface.body,
        };
        let given = plan.surface_displacements_between(std::slice::from_ref(step), from, to);
        let mut method = plan.method.clone();
        if let Some(kernel) = kernel {
            method.displacement.basis.kernel = kernel;
            method.rotation.basis.kernel = kernel;
        }
        if let Some(sliding) = sliding::on_moved_surface(&plan.motion, &plan.surface, &surface) {
            method.displacement.constraints = plan.surface.constraints(Some(&sliding));
        }
        let layers = layer::layers(rigid, &given, &method)?;
        let selections = layers
            .iter()
            .zip(&self.bases)
            .map(|(layer, base)| {
                let targets = Targets {
                    points: &surface,
                    values: layer.interpolated(),
                    criterion: &layer.criterion,
                    images: &plan.periodic.is_image,
                    lever_arms: &layer.lever_arms,
                };
                select::from_base(&layer.space, targets, base.clone(), Measure::Max)
            })
            .collect::<Result<Vec<_>>>()?;
        let chosen: Vec<Chosen<'_>> = selections
            .iter()
            .map(|selection| Chosen {
                selection,
                error: selection.error,
            })
            .collect();
        let before = surface.iter().zip(&plan.surface.points);
        let moved = before.map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max);
        let state = MeshState {
            nodes,
            surface: &surface,
            region: plan.region.grown(2.0 * moved),
            ..reference(plan, &self.part)
        };
        let (correct, ranks) = (plan.schedule.selection.correction, self.part.ranks());
        let fields = Fields::new(state, &layers, &chosen, correct, &ranks, &Silent);
        fields.displace(&layers, 0, nodes, out);
        self.place_surface_nodes(step, to, state, out);
        if !plan.modes_are_exact() {
            let values = uncorrected(&layers, &selections);
            let poses = plan.motion.poses(step, to);
            return Ok(largest_error(plan, &surface, &poses, &layers, &values, 0));
        }
        Ok(selections.iter().map(|selection| selection.error).sum())
    }
}

//! A step in substeps: the motion is cut into equal parts, and each is interpolated on the mesh that the
//! part before gave.

use super::fields::{Chosen, Fields, MeshState, RankPlaces};
use super::interval::{Interval, displace, largest_error, uncorrected};
use super::layer;
use super::sliding;
use crate::error::Result;
use crate::geometry::vector::Vector;
use crate::modes::RigidSurface;
use crate::motion::Step;
use crate::parallel;
use crate::progress::Silent;
use crate::rbf::Kernel;
use crate::rbf::select::{self, Measure};
use crate::rbf::targets::Targets;
use crate::sparse;

/// The parts of a step, which are equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Parts {
    /// Their number.
    pub n: usize,
    /// What they are interpolated with; the kernel of the schedule where there is none.
    pub kernel: Option<Kernel>,
}

impl Interval {
    /// A step in parts, each interpolated on the mesh left by the one before; gives the largest
    /// error of a part before its correction, or without the correction that of the positions. Where some nodes are `known`, of these
    /// and of the surface.
    pub(super) fn through_substeps(
        &self,
        step: &Step,
        parts: Parts,
        known: Option<&[u32]>,
        out: &mut [Vector],
    ) -> Result<f64> {
        let plan = &*self.plan;
        let slots = plan.slots(known.is_some());
        let carry = |from: &[Vector], to: &mut [Vector]| match known {
            None => to.copy_from_slice(from),
            Some(known) => {
                for &node in known.iter().chain(&plan.motion.surface.nodes.nodes) {
                    to[slots.of(node)] = from[slots.of(node)];
                }
            }
        };
        let mut nodes = match known {
            None => plan.whole().points.clone(),
            Some(_) => sparse::zeros(out.len(), [0.0; 3]),
        };
        carry(self.reference(known.is_some()).nodes, &mut nodes);
        let mut worst: f64 = 0.0;
        let n = parts.n as f64;
        for part in 1..=parts.n {
            let (from, to) = ((part - 1) as f64 / n, part as f64 / n);
            let error = self.substep(step, (from, to), parts.kernel, (&nodes, known), out)?;
            worst = worst.max(error);
            plan.periodic
                .follow(&plan.motion, &plan.mesh, None, (slots, out));
            if let (Some(team), Some(_)) = (plan.team(), known) {
                team.end_part(plan.maps_of_part(step, to), out);
            }
            carry(out, &mut nodes);
        }
        // What the correction does not take off adds up from part to part.
        Ok(if plan.schedule.selection.correction {
            worst
        } else {
            self.off_place(&plan.motion.poses(step, 1.0), None, (slots, out))
                .0
        })
    }

    fn substep(
        &self,
        step: &Step,
        (from, to): (f64, f64),
        kernel: Option<Kernel>,
        (nodes, known): (&[Vector], Option<&[u32]>),
        out: &mut [Vector],
    ) -> Result<f64> {
        let plan = &*self.plan;
        let of_points = &plan.surface.nodes;
        let slots = plan.slots(known.is_some());
        let surface = parallel::collect(of_points.len(), |at| nodes[slots.of(of_points[at])]);
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
        let state = MeshState {
            nodes,
            surface: &surface,
            rank_places: match known {
                Some(_) if from == 0.0 => RankPlaces::Rest,
                Some(_) => RankPlaces::Moved,
                None => RankPlaces::Told,
            },
            ..self.reference(known.is_some())
        };
        let correct = plan.schedule.selection.correction;
        let fields = Fields::new(state, &layers, &chosen, correct, &Silent, plan.team());
        displace(&fields, &layers, 0, (state, known), out);
        self.place_surface_nodes(step, to, (state, known), &fields, out);
        if !plan.modes_are_exact() {
            let values = uncorrected(&layers, &selections);
            let poses = plan.motion.poses(step, to);
            return Ok(largest_error(plan, &surface, &poses, (&layers, &values), 0));
        }
        Ok(selections.iter().map(|selection| selection.error).sum())
    }
}

//! Node positions at the steps of a selection interval: fields of the layers, the exact surface and the
//! rotation to the inertial frame.

use super::substeps::Parts;
use crate::base::choose;
use crate::base::round_off;
use crate::fields::sliding;
use crate::fields::velocity::{IntoInertial, Velocities};
use crate::fields::{Chosen, Fields, MeshState};
use crate::motion::{BodyMap, Role, Step, ToInertial};
use crate::part::Part;
use crate::plan::Plan;
use crate::plan::layer::Layer;
use azimesh_core::error::Result;
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{Vector, add, distance, sub};
use azimesh_core::numbers::{in_digits, short};
use azimesh_core::progress::Progress;
use azimesh_core::{Note, note, parallel};
use azimesh_rbf::field::BLOCK;
use azimesh_rbf::select::Selection;
use std::ops::Range;
use std::sync::Arc;

/// A gap between two surfaces narrower than this many tolerances gives a warning.
const NARROW: f64 = 20.0;

/// The deformation of a mesh at the steps of one selection interval: consecutive steps of the schedule that share base
/// points. Built once per interval; computes positions and velocities at any of its steps.
pub struct StepEvaluator {
    /// The plan.
    pub(crate) plan: Arc<Plan>,
    /// The mesh of this rank.
    pub(crate) part: Arc<Part>,
    /// The steps.
    steps: Range<usize>,
    evaluation: Evaluation,
    /// Base points of each layer.
    pub(crate) bases: Vec<Vec<usize>>,
    velocities: Option<Velocities>,
    /// Distinct base points of all layers.
    pub n_base: usize,
    /// Warnings about the surface.
    pub warnings: Vec<Note>,
}

/// Method of computing a step.
enum Evaluation {
    /// Directly from the reference mesh, by fields that are valid at every step.
    AtOnce { fields: Fields, errors: Errors },
    /// In the `substeps` of the schedule, each interpolated on the mesh of the previous substep.
    Substeps,
}

/// The largest error before the correction at each step.
enum Errors {
    /// Measured over all steps, for displacements that the modes reproduce exactly.
    ByStep(Vec<f64>),
    /// Computed from the values of the layers at the surface points before the correction.
    Uncorrected(Vec<Vec<f64>>),
}

impl StepEvaluator {
    /// Evaluates the layers at every deforming node of this rank, and corrects them to make the surface exact. All ranks
    /// call it.
    pub fn new(
        plan: &Arc<Plan>,
        part: &Arc<Part>,
        selections: Vec<Selection>,
        steps: &Range<usize>,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let mut interval = Self {
            plan: Arc::clone(plan),
            part: Arc::clone(part),
            steps: steps.clone(),
            n_base: distinct_points(&selections),
            evaluation: Evaluation::Substeps,
            bases: selections.iter().map(|s| s.base.clone()).collect(),
            velocities: None,
            warnings: choose::left_out(plan, &selections),
        };
        let noise = round_off::check(plan, &selections)?;
        interval.warnings.extend(noise);
        if plan.schedule.rbf.substeps == 1 {
            interval.evaluation = interval.at_once(selections, progress)?;
        }
        Ok(interval)
    }

    fn at_once(
        &mut self,
        selections: Vec<Selection>,
        progress: &dyn Progress,
    ) -> Result<Evaluation> {
        let plan = Arc::clone(&self.plan);
        let plan = &*plan;
        let by_step: Vec<Vec<f64>> = plan
            .layers
            .iter()
            .zip(&selections)
            .map(|(layer, selection)| match layer.modes.n_modes {
                0 => vec![0.0; plan.motion.steps.len()],
                _ => layer
                    .criterion
                    .largest_by_step(&selection.residuals, &layer.lever_arms),
            })
            .collect();
        let largest = |errors: &Vec<f64>| {
            errors[self.steps.clone()]
                .iter()
                .copied()
                .fold(0.0, f64::max)
        };
        let chosen: Vec<Chosen<'_>> = selections
            .iter()
            .zip(&by_step)
            .map(|(selection, errors)| Chosen {
                selection,
                error: largest(errors),
            })
            .collect();
        let part = Arc::clone(&self.part);
        let state = reference(plan, &part);
        let n_nodes = state.deforming.map_or(state.nodes.len(), <[u32]>::len);
        progress.start("modes", Some((n_nodes * plan.layers.len()) as u64));
        let (correct, ranks) = (plan.schedule.selection.correction, part.ranks());
        let fields = Fields::new(state, &plan.layers, &chosen, correct, &ranks, progress);
        progress.finish();
        if let (Some(layer), [chosen]) = (&plan.velocity, chosen.as_slice()) {
            let velocities = Velocities::new(plan, layer, state, &ranks, chosen, &self.steps)?;
            self.warnings.extend(velocities.warning.clone());
            self.velocities = Some(velocities);
        }
        self.warn_of_narrow(&fields);
        let errors = match by_step.len() {
            1 if plan.modes_are_exact() => Errors::ByStep(by_step.concat()),
            _ => Errors::Uncorrected(uncorrected(&plan.layers, &selections)),
        };
        Ok(Evaluation::AtOnce { fields, errors })
    }

    /// Returns the steps of the interval.
    pub fn steps(&self) -> &Range<usize> {
        &self.steps
    }

    /// Computes velocities of the nodes of this rank, at `points` at a step, if the schedule asks for them.
    pub fn velocities_at(&self, step: &Step, points: &[Vector]) -> Option<Vec<Vector>> {
        let velocities = self.velocities.as_ref()?;
        let mut out = vec![[0.0; 3]; points.len()];
        velocities.in_rotor_frame(&self.plan, &self.part, step, &mut out);
        IntoInertial::turn(&self.plan, &self.part, step, points, &mut out);
        Some(out)
    }

    fn warn_of_narrow(&mut self, fields: &Fields) {
        let plan = Arc::clone(&self.plan);
        let narrow = fields
            .narrow
            .filter(|gap| gap.width < NARROW * plan.tolerance);
        if let Some(gap) = narrow {
            self.warnings.push(note!(
                "narrow_gap",
                "two surfaces are {} apart at node {}, less than {} times the tolerance; the correction \
                 fades out over half of that instead of {}, and a smaller tolerance would give better \
                 cells there",
                in_digits(gap.width, 3),
                plan.surface.nodes[gap.point],
                short(NARROW),
                in_digits(gap.fade_radius, 3)
            ));
        }
    }

    /// Writes the positions of the nodes of this rank at a step to `out`; returns the largest displacement error before the
    /// correction. All ranks call it.
    pub fn points_at(&self, step: &Step, out: &mut [Vector]) -> Result<f64> {
        let plan = &*self.plan;
        let (fields, errors) = match &self.evaluation {
            Evaluation::AtOnce { fields, errors } => (fields, errors),
            Evaluation::Substeps => {
                let parts = Parts {
                    n: plan.schedule.rbf.substeps,
                    kernel: None,
                };
                return self.points_through(step, parts, out);
            }
        };
        let state = reference(plan, &self.part);
        fields.displace(&plan.layers, step.index, state.nodes, out);
        self.place_surface_nodes(step, 1.0, state, out);
        self.finish_positions(step, out);
        Ok(errors.at(plan, step))
    }

    /// Writes the node positions at a step to `out`, computed in substeps; returns the largest displacement error before
    /// the correction.
    pub(crate) fn points_through(
        &self,
        step: &Step,
        parts: Parts,
        out: &mut [Vector],
    ) -> Result<f64> {
        let error = self.through_substeps(step, parts, out)?;
        self.finish_positions(step, out);
        Ok(error)
    }

    /// Finishes a step: rotates it to the inertial frame, sets periodic followers by their leaders, and keeps a plane mesh
    /// in its plane.
    fn finish_positions(&self, step: &Step, out: &mut [Vector]) {
        let (plan, mesh) = (&*self.plan, &self.part.mesh);
        let to_inertial = plan.motion.to_inertial(step);
        if let Some(to_inertial) = &to_inertial {
            parallel::update(out, |node, x| {
                if let Some(turn) = to_inertial.of_node(mesh.number_of_node(node as u32)) {
                    *x = turn.apply(*x);
                }
            });
            if plan.schedule.selection.correction {
                let poses = plan.poses_at(step);
                self.place_nodes(out, |role, node, x| match role {
                    Role::Moving(body) => Some(poses[usize::from(body)].place(node, x)),
                    Role::Fixed | Role::Sliding => None,
                });
            }
        }
        if !plan.motion.parts.is_empty() {
            let poses = plan.poses_at(step);
            parallel::update(out, |node, x| {
                let number = mesh.number_of_node(node as u32);
                if let Some(body) = plan.motion.body_of_node(number) {
                    *x = poses[body].place(number, mesh.points[node]);
                }
            });
        }
        plan.periodic.follow(plan, mesh, to_inertial.as_ref(), out);
        if plan.motion.in_plane() {
            // Removes round-off out of the plane.
            parallel::update(out, |node, x| x[2] = mesh.points[node][2]);
        }
        if let Some(layer) = &plan.one_layer {
            layer.level(&mesh.points, out);
        }
    }

    /// Sets the surface nodes of `out` at a part of a step, in the rotating frame: sliding nodes on their boundary; with
    /// the correction also moving nodes exactly and fixed nodes at rest. `state` is the mesh before the deformation.
    pub(crate) fn place_surface_nodes(
        &self,
        step: &Step,
        part: f64,
        state: MeshState<'_>,
        out: &mut [Vector],
    ) {
        let plan = &*self.plan;
        sliding::place(plan, &self.part, state, out);
        if !plan.schedule.selection.correction {
            return;
        }
        let poses = plan.motion.poses(step, part);
        self.place_nodes(out, |role, node, x| match role {
            Role::Fixed => Some(x),
            Role::Moving(body) => Some(poses[usize::from(body)].place(node, x)),
            Role::Sliding => None,
        });
    }

    /// Sets surface nodes of this rank to the result of `place` for the role, the number and the position of a node in the
    /// reference mesh; `None` leaves a node unchanged.
    fn place_nodes(
        &self,
        out: &mut [Vector],
        place: impl Fn(Role, u32, Vector) -> Option<Vector> + Sync,
    ) {
        let (surface, here) = (&self.plan.motion.surface.nodes, &self.part.surface);
        parallel::for_blocks(out, BLOCK, &|first, out| {
            let before = |end: usize| here.partition_point(|of| (of[0] as usize) < end);
            for &[node, at] in &here[before(first)..before(first + out.len())] {
                let x = self.part.mesh.points[node as usize];
                let (role, number) = (surface.roles[at as usize], surface.nodes[at as usize]);
                if let Some(x) = place(role, number, x) {
                    out[node as usize - first] = x;
                }
            }
        });
    }

    /// Returns the largest and root-mean-square distance of the surface nodes from their prescribed positions. All ranks call
    /// it.
    pub(crate) fn surface_error(&self, step: &Step, points: &[Vector]) -> (f64, f64) {
        let to_inertial = self.plan.motion.to_inertial(step);
        let poses = self.plan.poses_at(step);
        let (largest, squares) = self.off_place(&poses, to_inertial.as_ref(), points);
        let n = self.plan.motion.surface.nodes.nodes.len().max(1) as f64;
        (largest, (squares / n).sqrt())
    }

    /// Returns the largest distance of the surface nodes at `points` from their positions by the poses of the bodies and
    /// the rotation to the inertial frame, and the sum of its squares.
    pub(crate) fn off_place(
        &self,
        poses: &[BodyMap<'_>],
        to_inertial: Option<&ToInertial<'_>>,
        points: &[Vector],
    ) -> (f64, f64) {
        let (plan, part) = (&*self.plan, &*self.part);
        let surface = &plan.motion.surface.nodes;
        let errors = part.surface_values(|node, at| {
            let x = part.mesh.points[node];
            let turn = to_inertial.and_then(|to| to.of_node(surface.nodes[at]));
            let exact = match (surface.roles[at], turn) {
                (Role::Sliding, _) => {
                    let sliding = plan.surface.sliding.as_ref();
                    let point = plan.surface.point_of[at] as usize;
                    let back = turn.map(Transform::inverse);
                    return sliding.map_or(0.0, |sliding| {
                        sliding::off_boundary(sliding, point, back.as_ref(), points[node])
                    });
                }
                (Role::Moving(body), _) => poses[usize::from(body)].place(surface.nodes[at], x),
                (Role::Fixed, Some(turn)) => turn.apply(x),
                (Role::Fixed, None) => x,
            };
            distance(points[node], exact)
        });
        let of_nodes = |range: Range<usize>, slides: bool| {
            let nodes = surface.roles[range.clone()].iter().zip(&errors[range]);
            let wanted = nodes.filter(|(role, _)| (**role == Role::Sliding) == slides);
            wanted.fold((0.0, 0.0), |sum, (_, &error)| {
                combined(sum, (error, error * error))
            })
        };
        let blocks = parallel::map_blocks(errors.len(), BLOCK, &|range| of_nodes(range, false));
        let sliding = of_nodes(0..errors.len(), true);
        blocks.into_iter().fold(sliding, combined)
    }
}

/// The reference mesh.
pub(crate) fn reference<'a>(plan: &'a Plan, part: &'a Part) -> MeshState<'a> {
    MeshState {
        nodes: &part.mesh.points,
        deforming: part.deforming.as_deref(),
        surface: &plan.surface.points,
        facets: &plan.surface.facets,
        images: &plan.surface.images,
        region: plan.region,
    }
}

/// Combines the largest errors and the sums of squares of two parts.
fn combined(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.max(b.0), a.1 + b.1)
}

/// Counts the distinct base points of all selections.
fn distinct_points(selections: &[Selection]) -> usize {
    let mut all: Vec<usize> = selections.iter().flat_map(|s| s.base.clone()).collect();
    all.sort_unstable();
    all.dedup();
    all.len()
}

/// Returns the values of the layers at the surface points as interpolated from the base points.
pub(crate) fn uncorrected(layers: &[Layer], selections: &[Selection]) -> Vec<Vec<f64>> {
    let layers = layers.iter().zip(selections);
    layers
        .map(|(layer, selection)| {
            let (values, residuals) = (&layer.modes.values, &selection.residuals);
            parallel::collect(values.len(), |at| values[at] - residuals[at])
        })
        .collect()
}

/// Returns the largest distance of the surface from `poses`, if the layers with these values move it from `points` at
/// a step.
pub(crate) fn largest_error(
    plan: &Plan,
    points: &[Vector],
    poses: &[BodyMap<'_>],
    layers: &[Layer],
    values: &[Vec<f64>],
    step: usize,
) -> f64 {
    let surface = &plan.surface;
    parallel::largest(points.len(), |at| {
        let x = points[at];
        let wanted = surface.body[at].map_or(x, |body| {
            poses[usize::from(body)].place(surface.nodes[at], surface.points[at])
        });
        let layers = layers.iter().zip(values);
        let moved = layers.fold([0.0; 3], |sum, (layer, values)| {
            let r = layer.modes.n_modes;
            let row = &values[at * r..(at + 1) * r];
            add(sum, layer.displacement(x, row, step))
        });
        distance(sub(wanted, x), moved)
    })
}

impl Errors {
    fn at(&self, plan: &Plan, step: &Step) -> f64 {
        match self {
            Self::ByStep(errors) => errors[step.index],
            Self::Uncorrected(values) => {
                let (points, poses) = (&plan.surface.points, plan.motion.poses(step, 1.0));
                largest_error(plan, points, &poses, &plan.layers, values, step.index)
            }
        }
    }
}

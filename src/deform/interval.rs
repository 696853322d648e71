//! Node positions at the steps of a selection interval: fields of the layers, the exact surface and the
//! rotation to the inertial frame.

use super::choose;
use super::fields::{Chosen, Fields, MeshState, RankPlaces};
use super::layer::Layer;
use super::plan::Plan;
use super::round_off;
use super::sliding;
use super::substeps::Parts;
use super::velocity::{IntoInertial, Velocities};
use crate::diagnostic::Diagnostic;
use crate::diagnostic::deform::DeformNote;
use crate::error::Result;
use crate::geometry::Transform;
use crate::geometry::vector::{Vector, add, distance, sub};
use crate::mesh::Slots;
use crate::motion::{BodyMap, Role, Step};
use crate::parallel;
use crate::progress::Progress;
use crate::rbf::correct::Fading;
use crate::rbf::field::BLOCK;
use crate::rbf::select::Selection;
use crate::sparse;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// A gap between two surfaces of fewer tolerances than this gives a warning.
const NARROW: f64 = 20.0;

/// The deformation of a mesh at the steps of one selection interval: consecutive steps of the schedule that
/// share base points. Made once per interval; gives positions and velocities at any of its steps.
pub struct Interval {
    /// The plan it follows.
    pub(super) plan: Arc<Plan>,
    /// The steps.
    steps: Range<usize>,
    way: Way,
    /// Base points of each layer.
    pub(super) bases: Vec<Vec<usize>>,
    velocities: Option<Velocities>,
    /// The nodes that deform, once they are asked for; none for all.
    deforming: OnceLock<Option<Vec<u32>>>,
    /// Distinct base points of all layers.
    pub n_base: usize,
    /// Warnings about the surface.
    pub warnings: Vec<Diagnostic>,
}

/// How a step is computed.
enum Way {
    /// From the reference mesh in one go, by fields that are valid at every step.
    AtOnce { fields: Fields, errors: Errors },
    /// In the `substeps` of the schedule, each interpolated on the mesh that the substep before gave.
    Substeps,
}

/// The largest error before the correction at each step.
enum Errors {
    /// As measured over all steps, of displacements that the modes reproduce exactly.
    ByStep(Vec<f64>),
    /// From the values that the layers have at the surface points before the correction.
    Uncorrected(Vec<Vec<f64>>),
}

impl Interval {
    /// Evaluates the layers at every node that deforms, and corrects them so that the surface is
    /// exact.
    pub fn new(
        plan: &Arc<Plan>,
        selections: Vec<Selection>,
        steps: &Range<usize>,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let mut interval = Self {
            plan: Arc::clone(plan),
            steps: steps.clone(),
            n_base: distinct_points(&selections),
            deforming: OnceLock::new(),
            way: Way::Substeps,
            bases: selections.iter().map(|s| s.base.clone()).collect(),
            velocities: None,
            warnings: choose::left_out(plan, &selections),
        };
        let noise = round_off::check(plan, &selections)?;
        interval.warnings.extend(noise);
        // Ranks evaluate fields where they judge cells.
        plan.share();
        if plan.schedule.rbf.substeps == 1 {
            interval.way = interval.at_once(selections, progress)?;
        }
        Ok(interval)
    }

    fn at_once(&mut self, selections: Vec<Selection>, progress: &dyn Progress) -> Result<Way> {
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
        let state = self.reference(plan.team().is_some());
        let n_nodes = match plan.team() {
            Some(team) => team.n_deforming(&plan.mesh),
            None => state.deforming.map_or(state.nodes.len(), <[u32]>::len),
        };
        progress.start("modes", Some((n_nodes * plan.layers.len()) as u64));
        let correct = plan.schedule.selection.correction;
        let fields = Fields::new(state, &plan.layers, &chosen, correct, progress, plan.team());
        progress.finish();
        if let (Some(layer), [chosen]) = (&plan.velocity, chosen.as_slice()) {
            let velocities = Velocities::new(plan, layer, state, chosen, &self.steps)?;
            let warning = velocities.warning.clone().map(Diagnostic::from);
            self.warnings.extend(warning);
            self.velocities = Some(velocities);
        }
        self.warn_of_narrow(&fields);
        let errors = match by_step.len() {
            1 if plan.modes_are_exact() => Errors::ByStep(by_step.concat()),
            _ => Errors::Uncorrected(uncorrected(&plan.layers, &selections)),
        };
        Ok(Way::AtOnce { fields, errors })
    }

    fn deforming(&self) -> Option<&[u32]> {
        let nodes = || self.plan.deforming_nodes();
        self.deforming.get_or_init(nodes).as_deref()
    }

    /// The steps of the interval.
    pub fn steps(&self) -> &Range<usize> {
        &self.steps
    }

    /// Velocities of the nodes, which are at `points` at a step, where the schedule asks for them. Where most nodes are `apart`, so
    /// are their velocities.
    pub fn velocities_at(
        &self,
        step: &Step,
        apart: bool,
        points: &[Vector],
    ) -> Option<Vec<Vector>> {
        let (plan, n_nodes) = (&*self.plan, points.len());
        let velocities = self.velocities.as_ref()?;
        let mut out = match apart {
            true => sparse::zeros(n_nodes, [0.0; 3]),
            false => vec![[0.0; 3]; n_nodes],
        };
        velocities.in_rotor_frame(plan, step, apart, &mut out);
        if !apart {
            IntoInertial::turn(plan, step, points, &mut out);
        }
        Some(out)
    }

    /// The reference mesh, of which the places may be those of an outline alone where nodes are `apart`.
    pub(super) fn reference(&self, are_apart: bool) -> MeshState<'_> {
        MeshState {
            nodes: match are_apart {
                true => &self.plan.mesh.points,
                false => self.plan.points(),
            },
            deforming: match are_apart {
                // Whoever moves them knows which deform.
                true => None,
                false => self.deforming(),
            },
            surface: &self.plan.surface.points,
            facets: &self.plan.surface.facets,
            rank_places: RankPlaces::Rest,
        }
    }

    fn warn_of_narrow(&mut self, fields: &Fields) {
        let plan = Arc::clone(&self.plan);
        let narrow = fields
            .narrow
            .filter(|gap| gap.width < NARROW * plan.tolerance);
        if let Some(gap) = narrow {
            let note = DeformNote::NarrowGap {
                width: gap.width,
                node: plan.surface.nodes[gap.point],
                tolerances: NARROW,
                fade_radius: gap.fade_radius,
            };
            self.warnings.push(note.into());
        }
    }

    /// Writes the node positions at a step to `out`; gives the largest displacement error before the
    /// correction.
    pub fn points_at(&self, step: &Step, out: &mut [Vector]) -> Result<f64> {
        self.known_points_at(step, None, out)
    }

    /// The same; where some nodes are `known`, of these alone: the others stay with the ranks that move them.
    pub(super) fn known_points_at(
        &self,
        step: &Step,
        known: Option<&[u32]>,
        out: &mut [Vector],
    ) -> Result<f64> {
        let plan = &*self.plan;
        let (fields, errors) = match &self.way {
            Way::AtOnce { fields, errors } => (fields, errors),
            Way::Substeps => {
                let parts = Parts {
                    n: plan.schedule.rbf.substeps,
                    kernel: None,
                };
                let error = self.through_substeps(step, parts, known, out)?;
                self.finish_positions(step, known, out);
                return Ok(error);
            }
        };
        let state = self.reference(known.is_some());
        displace(fields, &plan.layers, step.index, (state, known), out);
        self.place_surface_nodes(step, 1.0, (state, known), fields, out);
        self.finish_positions(step, known, out);
        Ok(errors.at(plan, step))
    }

    /// Whether ranks move nodes as they are moved here, of which some are `known`; where they tell of all, in `substeps`: but for what
    /// fades in from curved boundaries.
    pub(super) fn ranks_follow(&self, known: Option<&[u32]>, in_substeps: bool) -> bool {
        let at_once = matches!(self.way, Way::AtOnce { .. }) && !in_substeps;
        self.plan.moves_by_fields() && (at_once || known.is_some() || !self.plan.slides_on_curves())
    }

    /// Writes the node positions at a step to `out`, computed in substeps; gives the largest displacement
    /// error before the correction.
    pub(super) fn points_through(
        &self,
        step: &Step,
        parts: Parts,
        out: &mut [Vector],
    ) -> Result<f64> {
        let error = self.through_substeps(step, parts, None, out)?;
        self.finish_positions(step, None, out);
        Ok(error)
    }

    /// The last part of a step: rotates it to the inertial frame, places periodic followers by their
    /// leaders, and keeps a plane mesh in its plane.
    fn finish_positions(&self, step: &Step, known: Option<&[u32]>, out: &mut [Vector]) {
        let plan = &*self.plan;
        let slots = plan.slots(known.is_some());
        if let Some(to_inertial) = plan.motion.to_inertial(step) {
            let inside = plan.motion.zone.as_ref().map(|zone| &zone.sides.nodes);
            let turn = |node: usize, x: &mut Vector| {
                if inside.is_none_or(|inside| inside.has(node as u32)) {
                    *x = to_inertial.apply(*x);
                }
            };
            match known {
                Some(known) => {
                    (known.iter()).for_each(|&node| turn(node as usize, &mut out[slots.of(node)]))
                }
                None => parallel::update(out, turn),
            }
            if plan.schedule.selection.correction {
                place_moving_nodes(plan, &plan.poses_at(step), (slots, out));
            }
        }
        let to_inertial = plan.motion.to_inertial(step);
        plan.periodic
            .follow(&plan.motion, &plan.mesh, to_inertial.as_ref(), (slots, out));
        if plan.motion.rotor.in_plane {
            // Round-off lifts no node out of the plane.
            let reference = plan.points();
            parallel::update(out, |node, x| x[2] = reference[node][2]);
        }
        if let Some(layer) = &plan.one_layer {
            layer.level(plan.points(), out);
        }
    }

    /// Places the surface nodes of `out` at a part of a step, in the rotating frame: sliding nodes on their
    /// boundary; with the correction also moving nodes where the motion puts them and fixed nodes at rest.
    /// `state` is the mesh that was deformed by `fields`, of which some nodes may be `known` here alone.
    pub(super) fn place_surface_nodes(
        &self,
        step: &Step,
        part: f64,
        (state, known): (MeshState<'_>, Option<&[u32]>),
        fields: &Fields,
        out: &mut [Vector],
    ) {
        let plan = &*self.plan;
        let slots = plan.slots(known.is_some());
        let fading = known.filter(|_| plan.slides_on_curves());
        let deforming = fading.map(|known| {
            let nodes = plan.deforming_among(known);
            parallel::collect(nodes.len(), |at| slots.of(nodes[at]) as u32)
        });
        let here = MeshState {
            deforming: deforming.as_deref().or(state.deforming),
            ..state
        };
        let elsewhere = |fading: &Fading<'_>, changes: &[f64]| {
            if known.is_some() || state.rank_places == RankPlaces::Rest && plan.judges() {
                fields.fade_elsewhere(state, fading, changes);
            }
        };
        sliding::place(&plan.motion, &plan.surface, here, &elsewhere, (slots, out));
        if !plan.schedule.selection.correction {
            return;
        }
        let poses = plan.motion.poses(step, part);
        place_nodes(plan, (slots, out), |role, node, x| match role {
            Role::Fixed => Some(x),
            Role::Moving(body) => Some(poses[usize::from(body)].place(node, x)),
            Role::Sliding => None,
        });
    }

    /// Largest and root-mean-square distance of the surface nodes, which have `slots` in `points`, from where the motion
    /// puts them.
    pub(super) fn surface_error(
        &self,
        step: &Step,
        (slots, points): (Slots<'_>, &[Vector]),
    ) -> (f64, f64) {
        let to_inertial = self.plan.motion.to_inertial(step);
        let poses = self.plan.poses_at(step);
        let (largest, squares) = self.off_place(&poses, to_inertial.as_ref(), (slots, points));
        let n = self.plan.motion.surface.nodes.nodes.len().max(1) as f64;
        (largest, (squares / n).sqrt())
    }

    /// Largest distance of the surface nodes, which have `slots` in `points`, from where the poses of the bodies and the
    /// rotation to the inertial frame put them, and the sum of its squares.
    pub(super) fn off_place(
        &self,
        poses: &[BodyMap<'_>],
        to_inertial: Option<&Transform>,
        (slots, points): (Slots<'_>, &[Vector]),
    ) -> (f64, f64) {
        let plan = &*self.plan;
        let off = |(node, role): (&u32, &Role)| {
            let x = plan.mesh.place(*node);
            let exact = match (role, to_inertial) {
                (Role::Sliding, _) => return None,
                (Role::Moving(body), _) => poses[usize::from(*body)].place(*node, x),
                (_, Some(to_inertial)) => to_inertial.apply(x),
                (_, None) => x,
            };
            Some(distance(points[slots.of(*node)], exact))
        };
        let surface = &plan.motion.surface.nodes;
        let errors = parallel::map_blocks(surface.nodes.len(), BLOCK, &|range| {
            let nodes = surface.nodes[range.clone()].iter();
            let errors = nodes.zip(&surface.roles[range]).filter_map(off);
            errors.fold((0.0, 0.0), |sum, error| {
                combined(sum, (error, error * error))
            })
        });
        let sliding =
            sliding::off_boundary(&plan.motion, &plan.surface, to_inertial, (slots, points));
        errors.into_iter().fold(sliding, combined)
    }
}

/// Writes where fields move nodes; where some are `known`, these alone.
pub(super) fn displace(
    fields: &Fields,
    layers: &[Layer],
    step: usize,
    (state, known): (MeshState<'_>, Option<&[u32]>),
    out: &mut [Vector],
) {
    match known {
        Some(_) => fields.displace_apart(step, false, out),
        None => fields.displace(layers, step, state, out),
    }
}

/// The largest error and the sum of squares over both.
fn combined(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.max(b.0), a.1 + b.1)
}

/// Places moving nodes exactly where the motion puts them.
fn place_moving_nodes(plan: &Plan, poses: &[BodyMap<'_>], out: (Slots<'_>, &mut [Vector])) {
    place_nodes(plan, out, |role, node, x| match role {
        Role::Moving(body) => Some(poses[usize::from(body)].place(node, x)),
        Role::Fixed | Role::Sliding => None,
    });
}

/// Puts surface nodes, which have `slots` in `out`, where `place` says for a node of that role, number and place in the
/// reference mesh; `None` leaves it as it is.
fn place_nodes(
    plan: &Plan,
    (slots, out): (Slots<'_>, &mut [Vector]),
    place: impl Fn(Role, u32, Vector) -> Option<Vector> + Sync,
) {
    let surface = &plan.motion.surface.nodes;
    // Known nodes are the first of many.
    let end = surface.nodes.last().map_or(0, |&node| slots.of(node) + 1);
    parallel::for_blocks(&mut out[..end], BLOCK, &|first, out| {
        let before = |end: usize| surface.nodes.partition_point(|&node| slots.of(node) < end);
        for at in before(first)..before(first + out.len()) {
            let node = surface.nodes[at];
            let x = plan.mesh.place(node);
            if let Some(x) = place(surface.roles[at], node, x) {
                out[slots.of(node) - first] = x;
            }
        }
    });
}

/// Base points of all selections, each counted once.
fn distinct_points(selections: &[Selection]) -> usize {
    let mut all: Vec<usize> = selections.iter().flat_map(|s| s.base.clone()).collect();
    all.sort_unstable();
    all.dedup();
    all.len()
}

/// Values of the layers at the surface points as the base points give them.
pub(super) fn uncorrected(layers: &[Layer], selections: &[Selection]) -> Vec<Vec<f64>> {
    let layers = layers.iter().zip(selections);
    layers
        .map(|(layer, selection)| {
            let (values, residuals) = (&layer.modes.values, &selection.residuals);
            parallel::collect(values.len(), |at| values[at] - residuals[at])
        })
        .collect()
}

/// Largest distance of the surface from `poses`, where it is moved from `points` at a step of the layers, which have these
/// values there.
pub(super) fn largest_error(
    plan: &Plan,
    points: &[Vector],
    poses: &[BodyMap<'_>],
    (layers, values): (&[Layer], &[Vec<f64>]),
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
                largest_error(plan, points, &poses, (&plan.layers, values), step.index)
            }
        }
    }
}

//! Node velocities. The motion is differentiated at the surface; the interpolant of the displacements, which is linear in
//! its data, gives the velocities in the volume.
//!
//! ```text
//! x = X + Phi_vb Phi_bb^-1 d(t),   v = Phi_vb Phi_bb^-1 d'(t)
//! ```
//!
//! With the base points and the fade radius of the displacements this is the derivative of the positions. More base
//! points are added only if a moving body is at rest at all steps of an interval: there the displacements need none.

use super::{Chosen, Fields, MeshState};
use crate::motion::{BodyVelocity, Role, Step};
use crate::part::Part;
use crate::plan::Plan;
use crate::plan::layer::{Free, Layer, Method};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, distance, norm};
use azimesh_core::geometry::{Moving, Transform};
use azimesh_core::numbers::in_digits;
use azimesh_core::progress::Silent;
use azimesh_core::ranks::Ranks;
use azimesh_core::{Note, note, parallel};
use azimesh_rbf::select::{self, Limits, Measure, Selection};
use azimesh_rbf::targets::Targets;
use std::ops::Range;

/// Allowed error of the modes of velocities, as a part of the largest velocity.
const ACCURACY: f64 = 1e-6;
/// Allowed error of base points selected for velocities, as a part of the largest velocity of an interval.
const SERVES: f64 = 2e-3;
/// Round-off of a body at rest, as a part of the diagonal of the mesh.
const AT_REST: f64 = 1e-12;

/// Builds the layer of velocities of the surface points at every step.
pub(crate) fn layer(plan: &Plan) -> Result<Layer> {
    let steps = &plan.motion.steps;
    let of_bodies: Vec<Vec<BodyVelocity<'_>>> = steps
        .iter()
        .map(|step| plan.motion.velocities(step))
        .collect();
    let surface = &plan.surface;
    let velocity = |step: usize, at: usize| match surface.body[at] {
        Some(body) => {
            let of_body = &of_bodies[step][usize::from(body)];
            of_body.velocity(surface.nodes[at], surface.points[at])
        }
        None => [0.0; 3],
    };
    let largest = parallel::largest(surface.nodes.len(), |at| {
        let sizes = (0..steps.len()).map(|step| norm(velocity(step, at)));
        sizes.fold(0.0, f64::max)
    });
    let fill = |step: usize, points: Range<usize>, out: &mut [Vector]| {
        for (at, out) in points.zip(out) {
            *out = velocity(step, at);
        }
    };
    let free = Free {
        n_steps: steps.len(),
        rigid: (Vec::new(), Vec::new()),
        fill: Box::new(fill),
    };
    let method = Method {
        truncation: ACCURACY * largest,
        ..plan.method.clone()
    };
    free.layer(&surface.points, &method)
}

/// Velocities of the nodes of a mesh at the steps of an interval.
pub(crate) struct Velocities {
    fields: Fields,
    /// Note if base points leave too large an error and no more may be added.
    pub warning: Option<Note>,
}

impl Velocities {
    /// Builds velocities from the base points of the displacements of an interval; the largest error of the displacements
    /// sets the fade radius of the correction.
    pub fn new(
        plan: &Plan,
        layer: &Layer,
        state: MeshState<'_>,
        ranks: &Ranks,
        displacements: &Chosen<'_>,
        interval: &Range<usize>,
    ) -> Result<Self> {
        let base = displacements.selection.base.clone();
        let (own, warning) = select_for(plan, layer, base, interval)?;
        let chosen = [Chosen {
            selection: &own,
            ..*displacements
        }];
        let layers = std::slice::from_ref(layer);
        let correct = plan.schedule.selection.correction;
        let fields = Fields::new(state, layers, &chosen, correct, ranks, &Silent);
        Ok(Self { fields, warning })
    }

    /// Returns the velocities of the nodes of this rank at a step, in mesh units per second, in the frame of the rotor.
    pub fn in_rotor_frame(&self, plan: &Plan, part: &Part, step: &Step, out: &mut [Vector]) {
        let layers = plan.velocity.as_slice();
        self.fields.vectors(layers, step.index, out);
        if plan.schedule.selection.correction {
            set_surface_velocities(plan, part, step, out);
        }
        if !plan.motion.parts.is_empty() {
            let of_bodies = plan.motion.velocities(step);
            parallel::update(out, |node, v| {
                let number = part.mesh.number_of_node(node as u32);
                if let Some(body) = plan.motion.body_of_node(number) {
                    *v = of_bodies[body].velocity(number, part.mesh.points[node]);
                }
            });
        }
        plan.periodic.follow_directions(&part.mesh, out);
        if plan.motion.in_plane() {
            parallel::update(out, |_, v| v[2] = 0.0);
        }
        if let Some(layer) = &plan.one_layer {
            layer.level_directions(out);
        }
    }
}

/// Rotation of velocities into the inertial frame.
#[derive(Clone, Copy)]
pub(crate) struct IntoInertial {
    to: Moving,
    back: Transform,
}

impl IntoInertial {
    pub fn new(to: Moving) -> Self {
        let back = to.map.inverse();
        Self { to, back }
    }

    /// Returns the inertial velocity of a node at `x` whose velocity in the frame of the rotor is `v`.
    pub fn at(&self, x: Vector, v: Vector) -> Vector {
        self.to.velocity(self.back.apply(x), v)
    }

    /// Rotates the velocities of the deforming nodes, whose positions are `points`.
    pub fn turn(plan: &Plan, part: &Part, step: &Step, points: &[Vector], out: &mut [Vector]) {
        let Some(to) = plan.motion.to_inertial_moving(step) else {
            return;
        };
        let by = to.map(|to| Self::new(*to));
        parallel::update(out, |at, v| {
            if let Some(by) = by.of_node(part.mesh.number_of_node(at as u32)) {
                *v = by.at(points[at], *v);
            }
        });
    }
}

/// Builds the interpolant of the velocities of an interval from the base points of its displacements. Base points are
/// added if a body passes its place of rest.
fn select_for(
    plan: &Plan,
    layer: &Layer,
    base: Vec<usize>,
    interval: &Range<usize>,
) -> Result<(Selection, Option<Note>)> {
    let (space, targets) = (&layer.space, plan.targets(layer));
    if layer.modes.n_modes == 0 {
        return Ok((select::from_base(space, targets, base, Measure::Max)?, None));
    }
    let by_step = layer
        .criterion
        .largest_by_step(&layer.modes.values, &layer.lever_arms);
    let largest = |speeds: &[f64]| speeds.iter().copied().fold(0.0, f64::max);
    let speed = largest(&by_step[interval.clone()]);
    let allowed = f64::max(SERVES * speed, 2.0 * ACCURACY * largest(&by_step));
    let criterion = layer.criterion.of_steps(interval.clone())?;
    let targets = Targets {
        criterion: &criterion,
        ..targets
    };
    let most = plan.schedule.selection.max_points.max(base.len());
    let limits = Limits::in_rounds(allowed, most, plan.surface.nodes.len());
    let given = select::from_base(space, targets, base, Measure::Max)?;
    if given.error <= allowed || !passes_rest(plan, layer, interval, allowed) {
        return Ok((given, None));
    }
    let own = select::extend(space, targets, given.base, limits)?;
    let warning = (own.error > allowed).then(|| {
        note!(
            "velocities",
            "{} base points leave an error of {:.1e} in the velocities of the surface, which are up \
             to {}; the surface is corrected, but velocities in the volume have errors of that size",
            own.base.len(),
            own.error,
            in_digits(speed, 3)
        )
    });
    Ok((own, warning))
}

/// Returns whether a body faster than `least` at a step of an interval is at rest at all of its steps.
fn passes_rest(plan: &Plan, layer: &Layer, interval: &Range<usize>, least: f64) -> bool {
    let surface = &plan.surface;
    let still = AT_REST * plan.boundary.extent.diagonal();
    let n_bodies = plan.motion.bodies.len();
    let (mut moves, mut is_fast) = (vec![false; n_bodies], vec![false; n_bodies]);
    for step in &plan.motion.steps[interval.clone()] {
        let poses = plan.motion.poses(step, 1.0);
        for (at, body) in surface.body.iter().enumerate() {
            let Some(body) = body.map(usize::from) else {
                continue;
            };
            let x = surface.points[at];
            moves[body] |= distance(poses[body].place(surface.nodes[at], x), x) > still;
            is_fast[body] |= norm(layer.modes.displacement(at, step.index)) > least;
        }
        if moves.iter().all(|moves| *moves) {
            return false;
        }
    }
    moves
        .iter()
        .zip(is_fast)
        .any(|(moves, is_fast)| is_fast && !moves)
}

/// Surface nodes with the velocities of the motion; fixed nodes are at rest.
fn set_surface_velocities(plan: &Plan, part: &Part, step: &Step, out: &mut [Vector]) {
    let of_bodies = plan.motion.velocities(step);
    let surface = &plan.motion.surface.nodes;
    let exact = parallel::collect(part.surface.len(), |i| {
        let [node, at] = part.surface[i].map(|index| index as usize);
        match surface.roles[at] {
            Role::Moving(body) => {
                let x = part.mesh.points[node];
                Some(of_bodies[usize::from(body)].velocity(surface.nodes[at], x))
            }
            Role::Fixed => Some([0.0; 3]),
            Role::Sliding => None,
        }
    });
    for ([node, _], exact) in part.surface.iter().zip(exact) {
        if let Some(v) = exact {
            out[*node as usize] = v;
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::motion::Schedule;
    use crate::part::Part;
    use crate::{Plan, StepEvaluator, choose};
    use azimesh_core::geometry::vector::{Vector, distance, norm, sub};
    use azimesh_core::progress::Silent;
    use azimesh_core::ranks::Ranks;
    use azimesh_io::mesh::Mesh;
    use std::path::Path;
    use std::sync::Arc;

    /// Computes positions and velocities of all nodes of a moving airfoil at the steps of the first interval of some
    /// times, by a method.
    fn moved(times: &str, selection: &str, cyclic: &str) -> Vec<(Vec<Vector>, Vec<Vector>)> {
        let mesh = Mesh::read("testdata/naca0012.vtu").expect("it is good");
        let text = format!(
            "time = {{ values = {times}, frequency = 1.0 }}\noutput.velocity = true\n\
             selection = {{ {selection} }}\nboundaries.fixed = [\"farfield\"]\nrbf.support_radius = 10.0\n\
             body = [ {{ name = \"a\", tags = [\"airfoil\"], cyclic = {{ {cyclic} }} }} ]\n"
        );
        let schedule = Schedule::parse(&text, Path::new("s.toml")).expect("it is good");
        let (plan, part) = Plan::new(mesh, schedule).expect("they fit");
        let (plan, part) = (Arc::new(plan), Arc::new(part));
        let steps = plan.selection_intervals()[0].clone();
        let selections =
            choose(&plan, &steps, &Ranks::alone(), &Silent).expect("there are base points");
        let interval =
            StepEvaluator::new(&plan, &part, selections, &steps, &Silent).expect("it can be made");
        let at = |step| {
            let mut points = part.mesh.points.clone();
            interval.points_at(step, &mut points).expect("it deforms");
            let velocities = interval.velocities_at(step, &points);
            (points, velocities.expect("they are asked for"))
        };
        plan.motion.steps[steps].iter().map(at).collect()
    }

    /// Computes the velocities of all nodes at the first step of a schedule.
    fn at_first_step(mesh: Mesh, text: &str) -> (Arc<Part>, Arc<Plan>, Vec<Vector>) {
        let schedule = Schedule::parse(text, Path::new("s.toml")).expect("it is good");
        let (plan, part) = Plan::new(mesh, schedule).expect("they fit");
        let (plan, part) = (Arc::new(plan), Arc::new(part));
        let selections = choose(&plan, &(0..1), &Ranks::alone(), &Silent).expect("they are found");
        let interval =
            StepEvaluator::new(&plan, &part, selections, &(0..1), &Silent).expect("it can be made");
        let step = &plan.motion.steps[0];
        let mut points = part.mesh.points.clone();
        interval.points_at(step, &mut points).expect("it deforms");
        let velocities = interval.velocities_at(step, &points);
        let velocities = velocities.expect("they are asked for");
        drop(interval);
        (part, plan, velocities)
    }

    /// Computes velocities of a pitching airfoil at the first of some times.
    fn at_first(times: &str, selection: &str) -> Vec<Vector> {
        moved(times, selection, "pitch = [ { sin = 5.0 } ]")
            .swap_remove(0)
            .1
    }

    #[test]
    fn velocities_are_the_derivative_of_the_positions_however_loose_the_tolerance() {
        const H: f64 = 1e-5;
        let times = format!("[{}, 0.13, {}]", 0.13 - H, 0.13 + H);
        for selection in [
            "tolerance = 2e-2",
            "tolerance = 2e-2, correction = false",
            "tolerance = 1e-4",
        ] {
            let pitch = "collective = 10.0, pitch = [ { sin = -7.0, cos = -1.0 }, { sin = 3.0 } ]";
            let steps = moved(&times, selection, pitch);
            let way = steps[2].0.iter().zip(&steps[0].0);
            let rate = way.map(|(b, a)| sub(*b, *a).map(|x| x / (2.0 * H)));
            let off = rate.zip(&steps[1].1).map(|(rate, v)| distance(rate, *v));
            let off = off.fold(0.0, f64::max);
            let largest = steps[1].1.iter().copied().map(norm).fold(0.0, f64::max);
            assert!(off < 1e-6 * largest, "{selection}: {off} of {largest}");
        }
    }

    #[test]
    fn velocities_of_followers_are_turned_and_fixed_nodes_are_at_rest() {
        let mesh = Mesh::read("testdata/rotor_sector.vtu").expect("it is good");
        let text = "time = { values = [0.1], frequency = 1.0 }\noutput.velocity = true\n\
             boundaries = { fixed = [\"outer\", \"bottom\"], slide = [\"hub_wall\", \"top\"], periodic = [ { pair = [\"side_a\", \"side_b\"] } ] }\n\
             body = [ { name = \"b\", tags = [\"blade\"], cyclic = { pitch = [ { sin = 5.0 } ] } } ]\n";
        let (part, plan, v) = at_first_step(mesh, text);
        let followers = plan.periodic.followers();
        assert!(followers.len() > 10);
        for follower in followers {
            let turned = follower.map.turn(v[follower.leader as usize]);
            assert_eq!(v[follower.node as usize], turned);
        }
        let fixed = ["outer", "bottom"].map(|tag| part.mesh.tag_nodes(tag).expect("it is there"));
        for node in fixed.concat() {
            assert!(v[node as usize].iter().all(|v| *v == 0.0));
        }
        assert!(v.iter().copied().map(norm).fold(0.0, f64::max) > 0.1);
    }

    #[test]
    fn a_body_that_passes_its_place_of_rest_takes_the_mesh_along() {
        let expected = at_first("[0, 0.1, 0.25]", "");
        let largest = expected.iter().copied().map(norm).fold(0.0, f64::max);
        assert!(largest > 0.2);
        for (times, selection) in [
            ("[0]", ""),
            ("[0.5]", ""),
            ("[0, 0.25]", "method = \"real\""),
            ("[0]", "method = \"all\""),
            ("[0]", "method = \"constant\""),
        ] {
            let found = at_first(times, selection);
            let sign = if times == "[0.5]" { -1.0 } else { 1.0 };
            let off = |(found, expected): (&Vector, &Vector)| {
                distance(*found, expected.map(|v| sign * v))
            };
            let off = found.iter().zip(&expected).map(off).fold(0.0, f64::max);
            assert!(
                off < 0.03 * largest,
                "{times} {selection}: {off} of {largest}"
            );
        }
    }
}

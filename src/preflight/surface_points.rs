//! The surface points of a body, and where all of them are at a step.

use azimesh_core::geometry::vector::{Vector, dot, sub};
use azimesh_core::parallel;
use azimesh_deform::Plan;
use azimesh_deform::motion::Step;

/// The surface points that move with a body.
pub(super) fn points_of(plan: &Plan, body: usize) -> Vec<usize> {
    let bodies = plan.surface.body.iter().enumerate();
    let own = bodies.filter(|(_, of)| of.map(usize::from) == Some(body));
    own.map(|(at, _)| at).collect()
}

/// The outermost of some points along the span of a body's blade; `None` in 2D, and where neither the rotor nor the motion
/// of the body says what the span is.
pub(super) fn tip_of(plan: &Plan, body: usize, points: &[usize]) -> Option<usize> {
    let rotor = &plan.motion.rotor;
    if rotor.in_plane || !(rotor.has_span || plan.motion.is_of_blade(body)) {
        return None;
    }
    let offset = plan.motion.bodies[body].azimuth_offset;
    let span = rotor.turn(offset).turn(rotor.e_x);
    let station = |at: usize| dot(sub(plan.surface.points[at], rotor.hub), span);
    let points = points.iter().copied();
    points.reduce(|tip, at| if station(at) > station(tip) { at } else { tip })
}

/// Where the surface points are at a step, in the rotating frame.
pub(super) fn places_at(plan: &Plan, step: &Step) -> Vec<Vector> {
    let poses = plan.motion.poses(step, 1.0);
    let surface = &plan.surface;
    parallel::collect(surface.points.len(), |at| {
        let x = surface.points[at];
        match surface.body[at] {
            Some(body) => poses[usize::from(body)].place(surface.nodes[at], x),
            None => x,
        }
    })
}

//! The motion of bodies: their surface points at a step, and each body over the steps, for the output of `check` and the
//! plots of run.json.

use crate::record::{BodyRecord, MotionRecord};
use azimesh_core::geometry::vector::{Vector, distance, dot, norm, scale, sub};
use azimesh_core::parallel;
use azimesh_deform::Plan;
use azimesh_deform::motion::{Role, Step, TurningRotor};

/// Largest number of points of a body for the largest displacement in run.json: an even selection of so many is
/// accurate enough for a plot, and a surface of a million nodes costs no more than a small one.
const RECORDED: usize = 4096;

/// Returns the surface points that move with a body.
pub(super) fn points_of(plan: &Plan, body: usize) -> Vec<usize> {
    let bodies = plan.surface.body.iter().enumerate();
    let own = bodies.filter(|(_, of)| of.map(usize::from) == Some(body));
    own.map(|(at, _)| at).collect()
}

/// Returns the outermost of some points along the span of a body's blade; `None` in 2D, and if neither the rotor nor the
/// motion of the body defines the span.
pub(super) fn tip_of(plan: &Plan, body: usize, points: &[usize]) -> Option<usize> {
    let rotor = plan.motion.axes(body);
    if rotor.in_plane || !(rotor.has_span || plan.motion.is_of_blade(body)) {
        return None;
    }
    let offset = plan.motion.bodies[body].azimuth_offset;
    let span = rotor.turn(offset).turn(rotor.e_x);
    let station = |at: usize| dot(sub(plan.surface.points[at], rotor.hub), span);
    let points = points.iter().copied();
    points.reduce(|tip, at| if station(at) > station(tip) { at } else { tip })
}

/// Returns the positions of the surface points at a step, in the rotating frame.
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

/// A body at a step.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyAtStep {
    /// Its index in the schedule.
    pub body: usize,
    /// The step.
    pub step: usize,
    /// Pitch, flap and lag, if it has a cyclic motion, and the angle of `rigid.rotate`, if it has one; in radians.
    pub angles: [Option<f64>; 4],
    /// Displacement of its outermost point along its span, in mesh units; `None` in 2D and if nothing defines the span.
    pub tip: Option<Vector>,
    /// Largest displacement of one of its points, in mesh units.
    pub largest: f64,
}

/// Some surface points of a body, and its tip.
struct Followed {
    points: Vec<usize>,
    tip: Option<usize>,
}

/// Returns every body with its surface points, or an even selection of many.
fn followed(plan: &Plan, most: usize) -> Vec<Followed> {
    let of_body = |body: usize| {
        let points = points_of(plan, body);
        let every = points.len().div_ceil(most).max(1);
        Followed {
            tip: tip_of(plan, body, &points),
            points: points.into_iter().step_by(every).collect(),
        }
    };
    (0..plan.motion.bodies.len()).map(of_body).collect()
}

fn at_step(plan: &Plan, bodies: &[Followed], step: &Step) -> Vec<BodyAtStep> {
    let surface = &plan.surface;
    let poses = plan.motion.poses(step, 1.0);
    let of_body = |(body, followed): (usize, &Followed)| {
        let moved = |at: usize| {
            let x = surface.points[at];
            sub(poses[body].place(surface.nodes[at], x), x)
        };
        let points = &followed.points;
        let largest = parallel::largest(points.len(), |i| norm(moved(points[i])));
        let of_part = plan.rigid_points.iter().filter(|point| point.0 == body);
        let of_part = of_part.map(|&(_, x)| distance(poses[body].apply(x), x));
        let largest = of_part.fold(largest, f64::max);
        let tip = followed.tip.map(moved);
        let cyclic = plan.motion.cyclic_angles(body, step);
        let [pitch, flap, lag] = [0, 1, 2].map(|i| cyclic.map(|angles| angles[i]));
        BodyAtStep {
            body,
            step: step.index(),
            angles: [pitch, flap, lag, plan.motion.axis_angle(body, step)],
            tip,
            largest: largest.max(tip.map_or(0.0, norm)),
        }
    };
    bodies.iter().enumerate().map(of_body).collect()
}

/// Returns every body at some steps, in the order of the steps.
pub fn bodies_at(plan: &Plan, steps: &[&Step]) -> Vec<BodyAtStep> {
    let bodies = followed(plan, usize::MAX);
    let at_steps = steps.iter().flat_map(|step| at_step(plan, &bodies, step));
    at_steps.collect()
}

/// Returns the motion of the whole schedule in the rotating frame, and the rotation of the inertial frame against it.
pub(crate) fn body_motion(plan: &Plan) -> MotionRecord {
    let motion = &plan.motion;
    let bodies = followed(plan, RECORDED);
    let steps: Vec<Vec<BodyAtStep>> = parallel::map(motion.steps.len(), &|step| {
        at_step(plan, &bodies, &motion.steps[step])
    });
    let rotor = &motion.rotors[0].axes;
    let frame = match &motion.rotors[..] {
        [only] if only.is_inertial() => "inertial",
        rotors if rotors.iter().any(TurningRotor::is_inertial) => "several",
        _ => "rotating",
    };
    let records = (0..bodies.len()).map(|body| body_record(plan, body, &steps));
    MotionRecord {
        frame: frame.to_owned(),
        hub: rotor.hub,
        turn_axis: scale(rotor.e_z, rotor.signs.azimuth),
        bodies: records.collect(),
    }
}

fn body_record(plan: &Plan, body: usize, steps: &[Vec<BodyAtStep>]) -> BodyRecord {
    let motion = &plan.motion;
    let moves =
        |role: Option<Role>| matches!(role, Some(Role::Moving(b)) if usize::from(b) == body);
    let tags = motion.surface.tags.iter().filter(|tag| moves(tag.role));
    let steps = || steps.iter().map(|at| &at[body]);
    let degrees = |axis: usize| {
        let angles = steps().map(|at| Some(at.angles[axis]?.to_degrees()));
        angles.collect::<Option<Vec<f64>>>().unwrap_or_default()
    };
    let tips: Option<Vec<Vector>> = steps().map(|at| at.tip).collect();
    BodyRecord {
        name: motion.bodies[body].name.clone(),
        tags: tags.map(|tag| tag.tag.clone()).collect(),
        pitch_deg: degrees(0),
        flap_deg: degrees(1),
        lag_deg: degrees(2),
        angle_deg: degrees(3),
        tip_displacement: tips.unwrap_or_default(),
        max_displacement: steps().map(|at| at.largest).collect(),
    }
}

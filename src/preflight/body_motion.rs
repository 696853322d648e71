//! The motion of every body over the steps, as run.json keeps it for plots.

use super::surface_points::{points_of, tip_of};
use crate::record::{BodyRecord, MotionRecord};
use azimesh_core::geometry::vector::{Vector, distance, scale, sub};
use azimesh_core::parallel;
use azimesh_deform::Plan;
use azimesh_deform::motion::{Frame, Role, Step};

/// Nodes of a body whose displacements are looked at, at most: the largest of so many, evenly taken,
/// is close enough to draw, and a surface of a million nodes costs no more than a small one.
const LOOKED_AT: usize = 4096;

/// A body at a step.
struct At {
    angles: Option<[f64; 3]>,
    tip: Option<Vector>,
    largest: f64,
}

/// The motion of the whole schedule in the rotating frame, and how the inertial one turns against it.
pub(crate) fn body_motion(plan: &Plan) -> MotionRecord {
    let motion = &plan.motion;
    let bodies: Vec<Followed> = (0..motion.bodies.len())
        .map(|body| Followed::new(plan, body))
        .collect();
    let steps: Vec<Vec<At>> = parallel::map(motion.steps.len(), &|step| {
        at_step(plan, &bodies, &motion.steps[step])
    });
    let rotor = &motion.rotor;
    let frame = match rotor.frame {
        Frame::Rotating => "rotating",
        Frame::Inertial => "inertial",
    };
    MotionRecord {
        frame: frame.to_owned(),
        hub: rotor.hub,
        turn_axis: scale(rotor.e_z, rotor.signs.azimuth),
        bodies: (0..bodies.len())
            .map(|body| body_record(plan, body, &steps))
            .collect(),
    }
}

/// The surface points of a body that are followed.
struct Followed {
    points: Vec<usize>,
    tip: Option<usize>,
}

impl Followed {
    fn new(plan: &Plan, body: usize) -> Self {
        let points = points_of(plan, body);
        let tip = tip_of(plan, body, &points);
        let every = points.len().div_ceil(LOOKED_AT).max(1);
        Self {
            points: points.into_iter().step_by(every).collect(),
            tip,
        }
    }
}

fn at_step(plan: &Plan, bodies: &[Followed], step: &Step) -> Vec<At> {
    let surface = &plan.surface;
    let poses = plan.motion.poses(step, 1.0);
    let of_body = |(body, followed): (usize, &Followed)| {
        let place = |at: usize| poses[body].place(surface.nodes[at], surface.points[at]);
        let moved = followed.points.iter().chain(&followed.tip);
        let sizes = moved.map(|&at| distance(place(at), surface.points[at]));
        At {
            angles: plan.motion.cyclic_angles(body, step),
            tip: followed.tip.map(|at| sub(place(at), surface.points[at])),
            largest: sizes.fold(0.0, f64::max),
        }
    };
    bodies.iter().enumerate().map(of_body).collect()
}

fn body_record(plan: &Plan, body: usize, steps: &[Vec<At>]) -> BodyRecord {
    let motion = &plan.motion;
    let moves =
        |role: Option<Role>| matches!(role, Some(Role::Moving(b)) if usize::from(b) == body);
    let tags = motion.surface.tags.iter().filter(|tag| moves(tag.role));
    let steps = || steps.iter().map(|at| &at[body]);
    let degrees = |axis: usize| {
        let angles = steps().map(|at| Some(at.angles?[axis].to_degrees()));
        angles.collect::<Option<Vec<f64>>>().unwrap_or_default()
    };
    let tips: Option<Vec<Vector>> = steps().map(|at| at.tip).collect();
    BodyRecord {
        name: motion.bodies[body].name.clone(),
        tags: tags.map(|tag| tag.tag.clone()).collect(),
        pitch_deg: degrees(0),
        flap_deg: degrees(1),
        lag_deg: degrees(2),
        tip_displacement: tips.unwrap_or_default(),
        max_displacement: steps().map(|at| at.largest).collect(),
    }
}

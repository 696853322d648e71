//! The course of every body over the steps, as run.json keeps it for whoever draws it.

use super::bodies::{points_of, tip_of};
use crate::deform::Plan;
use crate::geometry::vector::{Vector, distance, scale, sub};
use crate::motion::{Frame, Role, Step};
use rayon::prelude::*;
use serde_json::{Map, Value, json};

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
pub(crate) fn body_motion(plan: &Plan) -> Value {
    let motion = &plan.motion;
    let bodies: Vec<Followed> = (0..motion.bodies.len())
        .map(|body| Followed::new(plan, body))
        .collect();
    let steps: Vec<Vec<At>> = motion
        .steps
        .par_iter()
        .map(|step| at_step(plan, &bodies, step))
        .collect();
    let rotor = &motion.rotor;
    let courses = (0..bodies.len()).map(|body| body_course(plan, body, &steps));
    json!({
        "frame": match rotor.frame {
            Frame::Rotating => "rotating",
            Frame::Inertial => "inertial",
        },
        "hub": rotor.hub,
        "turn_axis": scale(rotor.e_z, rotor.signs.azimuth),
        "bodies": courses.collect::<Vec<_>>(),
    })
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

fn body_course(plan: &Plan, body: usize, steps: &[Vec<At>]) -> Value {
    let motion = &plan.motion;
    let moves =
        |role: Option<Role>| matches!(role, Some(Role::Moving(b)) if usize::from(b) == body);
    let tags = motion.surface.tags.iter().filter(|tag| moves(tag.role));
    let tags: Vec<&str> = tags.map(|tag| tag.tag.as_str()).collect();
    let mut course = Map::new();
    course.insert("name".into(), json!(motion.bodies[body].name));
    course.insert("tags".into(), json!(tags));
    for (axis, key) in ["pitch_deg", "flap_deg", "lag_deg"].into_iter().enumerate() {
        let angles = steps.iter().map(|at| at[body].angles);
        let degrees = angles.map(|angles| angles.map(|angles| angles[axis].to_degrees()));
        if let Some(degrees) = degrees.collect::<Option<Vec<f64>>>() {
            course.insert(key.into(), json!(degrees));
        }
    }
    let tips = steps.iter().map(|at| at[body].tip);
    if let Some(tips) = tips.collect::<Option<Vec<Vector>>>() {
        course.insert("tip_displacement".into(), json!(tips));
    }
    let largest: Vec<f64> = steps.iter().map(|at| at[body].largest).collect();
    course.insert("max_displacement".into(), json!(largest));
    Value::Object(course)
}

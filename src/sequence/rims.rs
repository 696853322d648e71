//! What the user should know of bodies beside boundaries: those that leave a plane that they lie in, those
//! that stay, and a zone that turns out of the rest of the mesh.

use super::plan::Plan;
use crate::geometry::Bounds;
use crate::geometry::closest::ClosestSurface;
use crate::geometry::vector::{Vector, distance, dot, norm, scale, sub};
use crate::mesh::facets::facets;
use crate::motion::Step;
use std::collections::{BTreeMap, BTreeSet};

/// Parts of a displacement, and of the extent of the mesh, by which a node may leave its plane.
const ROUND_OFF: [f64; 2] = [1e-5, 1e-9];
/// Steps and nodes at which a turned interface is looked at, at most.
const TURNS: usize = 8;
const NODES: usize = 2000;

/// Bodies with nodes in a sliding plane that are moved out of it.
pub(super) fn leaving_planes(plan: &Plan) -> Vec<String> {
    let Some(sliding) = &plan.surface.sliding else {
        return Vec::new();
    };
    let surface = &plan.surface;
    let rims = sliding.rims().iter();
    let held: Vec<(usize, u16, Vector)> = rims
        .filter_map(|&(at, normal)| Some((at as usize, surface.body[at as usize]?, normal)))
        .collect();
    let [of_way, of_mesh] = ROUND_OFF;
    let least = of_mesh * Bounds::around(&plan.reference).diagonal();
    // For each body the points that leave, how far at most, and the step of that.
    let mut left: BTreeMap<u16, (BTreeSet<usize>, f64, usize)> = BTreeMap::new();
    for step in plan.motion.steps.iter().filter(|_| !held.is_empty()) {
        let poses = plan.motion.poses(step, 1.0);
        for &(at, body, normal) in &held {
            let x = surface.points[at];
            let by = sub(poses[usize::from(body)].place(surface.nodes[at], x), x);
            let out = dot(by, normal).abs();
            if out > least + of_way * norm(by) {
                let (points, most, worst) = left.entry(body).or_default();
                points.insert(at);
                if out > *most {
                    (*most, *worst) = (out, step.index);
                }
            }
        }
    }
    let sentence = |(body, (points, most, step)): (u16, (BTreeSet<usize>, f64, usize))| {
        format!(
            "{} nodes of body \"{}\" lie in a plane that slides and are moved out of it, by up to {most:.3e} at step \
             {step}; that boundary does not stay plane",
            points.len(),
            plan.motion.bodies[usize::from(body)].name
        )
    };
    left.into_iter().map(sentence).collect()
}

/// Bodies that no step moves.
pub(super) fn staying(plan: &Plan) -> Vec<String> {
    let bodies = &plan.motion.bodies;
    let mut points = vec![0; bodies.len()];
    let mut moves = vec![false; bodies.len()];
    for (at, body) in plan.surface.body.iter().enumerate() {
        let Some(body) = body.map(usize::from) else {
            continue;
        };
        points[body] += 1;
        moves[body] |= plan.layers.iter().any(|layer| {
            let values = &layer.modes.values[at * layer.modes.n_modes..];
            values
                .iter()
                .take(layer.modes.n_modes)
                .any(|value| *value != 0.0)
        });
    }
    let still = (0..bodies.len()).filter(|&body| points[body] > 0 && !moves[body]);
    still
        .map(|body| {
            format!(
                "body \"{}\" stays where it is at every step; its motions are all 0",
                bodies[body].name
            )
        })
        .collect()
}

/// A zone that is carried round although its interface to the rest is no surface of revolution: turned,
/// its nodes do not lie on it.
pub(super) fn turning_out(plan: &Plan) -> Option<String> {
    let zone = plan.motion.zone.as_ref()?;
    let rotor = &plan.motion.rotor;
    let turned: Vec<&Step> = plan.motion.steps.iter().collect();
    let turned: Vec<&Step> = turned
        .into_iter()
        .filter(|step| plan.motion.carry(step).is_some() && step.azimuth_deg % 360.0 != 0.0)
        .collect();
    let points: Vec<Vector> = zone
        .interface_nodes
        .iter()
        .map(|&node| plan.reference[node as usize])
        .collect();
    if turned.is_empty() || points.is_empty() {
        return None;
    }
    let mut triangles = Vec::new();
    for face in zone.interface_faces.iter() {
        for split in facets(face.kind, face.nodes.len()) {
            let corners = split.map(|i| zone.interface_nodes.binary_search(&face.nodes[i]));
            if let [Ok(a), Ok(b), Ok(c)] = corners {
                triangles.push([a as u32, b as u32, c as u32]);
            }
        }
    }
    let surface = ClosestSurface::new(points.as_slice(), &triangles);
    let mut worst = (0, 0.0);
    for step in turned.iter().step_by(turned.len().div_ceil(TURNS)) {
        let turn = rotor.turn(step.azimuth);
        for point in points.iter().step_by(points.len().div_ceil(NODES)) {
            let x = turn.apply(*point);
            let Some(foot) = surface.nearest(&x, f64::INFINITY) else {
                continue;
            };
            let [a, b, c] = foot.corners.map(|corner| points[corner as usize]);
            let edge = distance(a, b).max(distance(b, c)).max(distance(c, a));
            let out = sub(x, rotor.hub);
            let from_shaft = norm(sub(out, scale(rotor.e_z, dot(out, rotor.e_z))));
            // Twice what the flat facets of a surface of revolution are off it.
            let allowed = edge * f64::min(1.0, edge / (4.0 * from_shaft.max(f64::MIN_POSITIVE)));
            let off = foot.distance_squared.sqrt();
            if off > allowed && off > worst.1 {
                worst = (step.index, off);
            }
        }
    }
    let (step, off) = worst;
    (off > ROUND_OFF[1] * Bounds::around(&points).diagonal()).then(|| {
        format!(
            "the zones that are carried round meet the rest of the mesh in a surface that is none of revolution about \
             the shaft: at step {step} its nodes are up to {off:.3e} off where it was, so cells overlap there or \
             leave holes"
        )
    })
}

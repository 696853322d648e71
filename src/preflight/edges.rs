//! Warnings about bodies next to boundaries: bodies that leave a sliding plane, and bodies at rest.

use azimesh_core::error::counted;
use azimesh_core::geometry::vector::{Vector, dot, norm, sub};
use azimesh_core::numbers::in_digits;
use azimesh_core::{Note, note};
use azimesh_deform::Plan;
use std::collections::{BTreeMap, BTreeSet};

/// Distances that count as leaving a plane, as parts of a displacement and of the extent of the mesh.
const ROUND_OFF: [f64; 2] = [1e-5, 1e-9];

/// Returns warnings on bodies with nodes in a sliding plane that move out of it.
pub(super) fn leaving_planes(plan: &Plan) -> Vec<Note> {
    let Some(sliding) = &plan.surface.sliding else {
        return Vec::new();
    };
    let surface = &plan.surface;
    let rims = sliding.rims().iter();
    let held: Vec<(usize, u16, Vector)> = rims
        .filter_map(|&(at, normal)| Some((at as usize, surface.body[at as usize]?, normal)))
        .collect();
    let [of_way, of_mesh] = ROUND_OFF;
    let least = of_mesh * plan.boundary.extent.diagonal();
    // For each body the points that leave, their largest distance, and its step.
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
                    (*most, *worst) = (out, step.index());
                }
            }
        }
    }
    left.into_iter()
        .map(|(body, (points, distance, step))| {
            let body = &plan.motion.bodies[usize::from(body)].name;
            let note = note!(
                "leaves_plane",
                "body \"{body}\" moves {} of a sliding plane out of it, by up to {} at step {step}; that boundary does not stay \
                 plane",
                counted(points.len(), "node"),
                in_digits(distance, 4)
            );
            note.with("step", step).with("distance", distance)
        })
        .collect()
}

/// Returns warnings on bodies that no step moves.
pub(super) fn staying(plan: &Plan) -> Vec<Note> {
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
    let turns = |body: usize| plan.motion.rotors[bodies[body].rotor].is_inertial();
    let still = (0..bodies.len()).filter(|&body| points[body] > 0 && !moves[body] && !turns(body));
    still
        .map(|body| {
            let body = &bodies[body].name;
            note!(
                "body_stays",
                "body \"{body}\" does not move at any step of the schedule"
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preflight::tests::plan;

    /// Returns the wing with a motion; its root is in a sliding plane.
    fn wing(motion: &str) -> Plan {
        let schedule = format!(
            "azimuth.values = [0, 90]\nboundaries = {{ fixed = [\"farfield\"], slide = [\"symmetry\"] }}\n\
             rbf.support_radius = 8.0\nselection.tolerance = 1e-2\n\
             body = [ {{ name = \"wing\", tags = [\"wing\"], {motion} }} ]\n"
        );
        plan("testdata/wing_on_plane.vtu", &schedule)
    }

    #[test]
    fn nodes_that_are_moved_out_of_a_sliding_plane_are_told_of() {
        for (motion, out) in [
            ("rigid.translate = [0.1, -0.2, 0]", None),
            (
                "rigid.rotate = { axis = [0, 0, 1], origin = [0.3, 0, 0], angle = 30 }",
                None,
            ),
            ("rigid.translate = [0, 0, -0.001]", Some(0.001)),
            ("rigid.translate = [0.5, 0, 4]", Some(4.0)),
        ] {
            let told = leaving_planes(&wing(motion));
            assert_eq!(told.len(), usize::from(out.is_some()), "{motion} {told:?}");
            let is_right = |by: f64| {
                let distance = told[0].get("distance").as_f64().expect("a number");
                told[0].code == "leaves_plane"
                    && (distance - by).abs() < 1e-12
                    && told[0].get("step") == 0
            };
            assert!(out.is_none_or(is_right), "{motion} {told:?}");
        }
    }

    #[test]
    fn a_body_that_stays_is_told_of() {
        for (motion, stays) in [
            ("cyclic = {}", true),
            ("cyclic = { pitch = [] }", true),
            ("rigid.translate = [0, 0, 0]", true),
            ("rigid.translate = [0, 1e-6, 0]", false),
        ] {
            let told = staying(&wing(motion));
            let texts = ["body \"wing\" does not move at any step of the schedule"];
            let is_told = told.iter().map(|note| note.text.as_str()).eq(texts);
            assert_eq!(is_told, stays, "{motion} {told:?}");
        }
    }
}

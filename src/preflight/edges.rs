//! Warnings about bodies next to boundaries: bodies that leave a sliding plane, bodies at rest, and a zone that turns out
//! of the rest of the mesh.

use azimesh_core::error::counted;
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::closest::ClosestSurface;
use azimesh_core::geometry::vector::{Vector, distance, dot, norm, scale, sub};
use azimesh_core::numbers::in_digits;
use azimesh_core::{Note, note};
use azimesh_deform::Plan;
use azimesh_deform::motion::{RotorAxes, Step, ZonePart};
use azimesh_io::mesh::facets::facets;
use std::collections::{BTreeMap, BTreeSet};

/// Distances that count as leaving a plane, as parts of a displacement and of the extent of the mesh.
const ROUND_OFF: [f64; 2] = [1e-5, 1e-9];
/// Largest numbers of steps and nodes at which a turned interface is checked.
const TURNS: usize = 8;
const NODES: usize = 2000;

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

/// Returns notes on rotating zones whose interface to the rest is not a surface of revolution: the rotated nodes are
/// off the interface.
pub(super) fn turning_out(plan: &Plan) -> Vec<Note> {
    let zone = plan.motion.zone.as_ref();
    // There a sector meets its own images, and rigid parts meet the zone inside it.
    let is_whole = plan.motion.periodic.is_empty() && plan.motion.parts.is_empty();
    let parts = zone
        .filter(|_| is_whole)
        .map_or(&[][..], |zone| &zone.parts);
    parts
        .iter()
        .filter_map(|part| part_turning_out(plan, part))
        .collect()
}

fn part_turning_out(plan: &Plan, zone: &ZonePart) -> Option<Note> {
    let rotor = &plan.motion.rotors[zone.rotor?];
    let steps = plan.motion.steps.iter().map(|step| rotor.step(step));
    let is_turned = |step: &&Step| {
        step.azimuth_deg()
            .is_some_and(|degrees| degrees % 360.0 != 0.0)
    };
    let turned: Vec<&Step> = steps.filter(is_turned).collect();
    let nodes = zone.sides.interface_nodes.iter();
    let points: Vec<Vector> = nodes.map(|&node| plan.boundary.position(node)).collect();
    if turned.is_empty() || points.is_empty() {
        return None;
    }
    let surface = ClosestSurface::new(points.as_slice(), &interface_facets(zone));
    let mut worst = (0, 0.0);
    for step in turned.iter().step_by(turned.len().div_ceil(TURNS)) {
        let turn = rotor.axes.turn(step.azimuth);
        for point in points.iter().step_by(points.len().div_ceil(NODES)) {
            let off = off_surface(&rotor.axes, &points, &surface, turn.apply(*point));
            if off > worst.1 {
                worst = (step.index(), off);
            }
        }
    }
    let (step, distance) = worst;
    let is_off = distance > ROUND_OFF[1] * Bounds::around(&points).diagonal();
    is_off.then(|| {
        note!(
            "turns_out",
            "the interface between the rotating zones{} and the rest of the mesh is not a surface of revolution about the \
             shaft: at step {step} its nodes are up to {} away from it, so cells overlap there or leave gaps",
            of_rotor(rotor.name.as_deref()),
            in_digits(distance, 4)
        )
    })
}

/// Names a rotor in words, if it has a name.
fn of_rotor(name: Option<&str>) -> String {
    name.map_or_else(String::new, |name| format!(" of rotor \"{name}\""))
}

/// Returns the facets of the interface of a zone, by the indices of its nodes.
fn interface_facets(zone: &ZonePart) -> Vec<[u32; 3]> {
    let mut found = Vec::new();
    for face in zone.sides.interface_faces.iter() {
        for split in facets(face.kind, face.nodes.len()) {
            let corners = split.map(|i| zone.sides.interface_nodes.binary_search(&face.nodes[i]));
            if let [Ok(a), Ok(b), Ok(c)] = corners {
                found.push([a as u32, b as u32, c as u32]);
            }
        }
    }
    found
}

/// Returns the distance of `x` from the interface between `points`; 0 if it is at most twice the error of flat facets of
/// a surface of revolution.
fn off_surface(
    rotor: &RotorAxes,
    points: &[Vector],
    surface: &ClosestSurface<'_>,
    x: Vector,
) -> f64 {
    let Some(foot) = surface.nearest(&x, f64::INFINITY) else {
        return 0.0;
    };
    let [a, b, c] = foot.corners.map(|corner| points[corner as usize]);
    let edge = distance(a, b).max(distance(b, c)).max(distance(c, a));
    let out = sub(x, rotor.hub);
    let from_shaft = norm(sub(out, scale(rotor.e_z, dot(out, rotor.e_z))));
    let allowed = edge * f64::min(1.0, edge / (4.0 * from_shaft.max(f64::MIN_POSITIVE)));
    let off = foot.distance_squared.sqrt();
    if off > allowed { off } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preflight::tests::{plan, plan_of};
    use azimesh_io::mesh::{CellKind, Group, Mesh};

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

    /// Rings of cells around z with radii from 1 to 4, the inner two of zone \"rotor\".
    fn rings() -> Mesh {
        const AROUND: u32 = 16;
        let mut mesh = Mesh::default();
        for radius in 1..=4 {
            for around in 0..AROUND {
                let angle = std::f64::consts::TAU * f64::from(around) / f64::from(AROUND);
                let (sin, cos) = angle.sin_cos();
                let r = f64::from(radius);
                mesh.points
                    .extend([0.0, 1.0].map(|z| [r * cos, r * sin, z]));
            }
        }
        let node = |ring: u32, around: u32, up: u32| 2 * (ring * AROUND + around % AROUND) + up;
        let corners = |ring: u32, at: u32, up: u32| {
            [
                node(ring, at, up),
                node(ring + 1, at, up),
                node(ring + 1, at + 1, up),
                node(ring, at + 1, up),
            ]
        };
        for ring in 0..3 {
            for at in 0..AROUND {
                let hexahedron = [corners(ring, at, 0), corners(ring, at, 1)].concat();
                mesh.cells.push(CellKind::Hexahedron, &hexahedron);
            }
        }
        for ring in [0, 3] {
            for at in 0..AROUND {
                let face = [
                    node(ring, at, 0),
                    node(ring, at + 1, 0),
                    node(ring, at + 1, 1),
                    node(ring, at, 1),
                ];
                mesh.cells.push(CellKind::Quadrilateral, &face);
            }
        }
        let n = AROUND as usize;
        let group = |dimension, name: &str, cells: std::ops::Range<usize>| Group {
            dimension,
            name: name.into(),
            number: None,
            condition: None,
            cells: cells.collect(),
        };
        mesh.groups = vec![
            group(3, "rotor", 0..2 * n),
            group(3, "background", 2 * n..3 * n),
            group(2, "hub", 3 * n..4 * n),
            group(2, "far", 4 * n..5 * n),
        ];
        mesh
    }

    #[test]
    fn a_zone_that_turns_out_of_the_mesh_is_told_of() {
        for (frame, hub, is_told) in [
            ("inertial", "[0, 0, 0]", false),
            ("inertial", "[0, 0, 7]", false),
            ("inertial", "[0, 0.7, 0]", true),
            ("rotating", "[0, 0.7, 0]", false),
        ] {
            let schedule = format!(
                "azimuth.values = [0, 11, 45]\nrotor = {{ frame = \"{frame}\", hub = {hub} }}\n\
                 boundaries = {{ zones = [\"rotor\"], fixed = [\"far\"] }}\nrbf.support_radius = 5.0\n\
                 body = [ {{ name = \"b\", tags = [\"hub\"], rigid.translate = [0, 0, 0.01] }} ]\n"
            );
            let told = turning_out(&plan_of(rings(), &schedule));
            assert_eq!(!told.is_empty(), is_told, "{frame} {hub} {told:?}");
        }
        let sample = crate::sample::rotor(&crate::sample::BladeOptions::default());
        let sample = sample.expect("it can be made");
        let turning = sample
            .schedule
            .replace("frame = \"rotating\"", "frame = \"inertial\"");
        assert!(!turning_out(&plan_of(sample.mesh, &turning)).is_empty());
    }
}

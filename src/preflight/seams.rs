//! Interfaces of zones that turn or move rigidly: cells run into others, or leave gaps, where an interface does not stay in
//! its surface.

use super::evenly;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::closest::ClosestSurface;
use azimesh_core::geometry::rotation::rotation_vector_near;
use azimesh_core::geometry::vector::{Vector, add, cross, distance, dot, norm, scale, sub, unit};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_core::numbers::in_digits;
use azimesh_core::{Note, note, parallel};
use azimesh_deform::motion::Step;
use azimesh_deform::{Mover, Plan, Seam};

/// Largest numbers of steps and nodes at which an interface is checked.
const STEPS: usize = 36;
const NODES: usize = 2000;
/// Rotations by less, in radians, are translations; distances below this part of an interface are round-off.
const ROUND_OFF: f64 = 1e-9;
/// Refused distances, in edges of the interface there.
const REFUSED: f64 = 0.25;

/// The largest distance of the nodes of an interface from where it was.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Off {
    /// Its mover.
    part: Mover,
    step: usize,
    distance: f64,
    /// Length of the edges there.
    edge: f64,
}

impl Off {
    /// Finds the interfaces that do not stay in their surfaces; none in a sector, which meets its own images.
    pub fn find(plan: &Plan) -> Vec<Self> {
        let is_whole = plan.motion.periodic.is_empty();
        let seams = plan.seams.iter().filter(|_| is_whole);
        seams.filter_map(|seam| Self::of(plan, seam)).collect()
    }

    fn of(plan: &Plan, seam: &Seam) -> Option<Self> {
        let mut nodes: Vec<u32> = seam.facets.as_flattened().to_vec();
        nodes.sort_unstable();
        nodes.dedup();
        let points = nodes.iter().map(|&node| seam.points[node as usize]);
        let points: Vec<Vector> = points.step_by(nodes.len().div_ceil(NODES).max(1)).collect();
        let bounds = Bounds::around(&points);
        let least = ROUND_OFF * bounds.diagonal();
        let surface = ClosestSurface::new(seam.points.as_slice(), &seam.facets);
        let steps = evenly(plan, STEPS);
        let at_steps = parallel::map(steps.len(), &|at| {
            let turn = Turn::new(plan, seam, steps[at], bounds.centre());
            let off = points.iter().map(|&x| turn.off(x, seam, &surface));
            let off = off.filter(|off| off[0] > least);
            let worst = off.max_by(|a, b| (a[0] / a[1]).total_cmp(&(b[0] / b[1])))?;
            Some((steps[at].index(), worst))
        });
        let at_steps = at_steps.into_iter().flatten();
        let (step, [distance, edge]) = at_steps.reduce(|a, b| {
            let ratio = |at: &(usize, [f64; 2])| at.1[0] / at.1[1];
            if ratio(&b) > ratio(&a) { b } else { a }
        })?;
        Some(Self {
            part: seam.part,
            step,
            distance,
            edge,
        })
    }

    /// Refuses it if its cells run far into others.
    pub fn refuse(&self, plan: &Plan) -> Result<()> {
        if self.distance <= REFUSED * self.edge {
            return Ok(());
        }
        let place = match self.part {
            Mover::Body(body) => plan.motion.bodies[body].place.clone(),
            Mover::Rotor(_) => None,
        };
        let message = format!(
            "{}; zones turn in an interface that is a surface of revolution about their axis, or allow this with --allow-outside",
            self.note(plan)
        );
        Err(Error::input(message).at(place).file(&plan.schedule.path))
    }

    /// Returns a note on it.
    pub fn note(&self, plan: &Plan) -> Note {
        let of = match self.part {
            Mover::Body(body) => format!(" of body \"{}\"", plan.motion.bodies[body].name),
            Mover::Rotor(rotor) => (plan.motion.rotors[rotor].name.as_ref())
                .map_or_else(String::new, |name| format!(" of rotor \"{name}\"")),
        };
        let note = note!(
            "turns_out",
            "the zones{of} do not stay in their interface: at step {} its nodes are up to {} away from it, where its edges are {} \
             long, so cells overlap there or leave gaps",
            self.step,
            in_digits(self.distance, 3),
            in_digits(self.edge, 3)
        );
        note.with("step", self.step).with("distance", self.distance)
    }
}

/// The motion of a part relative to the cells across its interface.
struct Turn {
    map: Transform,
    /// Axis of the rotation and a point of it; `None` for a translation.
    axis: Option<[Vector; 2]>,
}

impl Turn {
    /// At a step; `centre` is a point near the interface.
    fn new(plan: &Plan, seam: &Seam, step: &Step, centre: Vector) -> Self {
        let map_of = |mover: Mover| match mover {
            Mover::Body(body) => plan.poses_at(step)[body].map(centre),
            Mover::Rotor(rotor) => {
                let rotor = &plan.motion.rotors[rotor];
                rotor.axes.turn(rotor.step(step).azimuth)
            }
        };
        let own = map_of(seam.part);
        let across = seam.across.map(map_of);
        let map = across.map_or(own, |across| own.then(&across.inverse()));
        let rotation = rotation_vector_near(&map.rotation, [0.0; 3]);
        let angle = norm(rotation);
        let axis = unit(rotation).filter(|_| angle > ROUND_OFF).map(|axis| {
            let by = sub(map.apply(centre), centre);
            let by = sub(by, scale(axis, dot(by, axis)));
            let to_axis = scale(cross(axis, by), 0.5 / (0.5 * angle).tan());
            [axis, add(add(centre, scale(by, 0.5)), to_axis)]
        });
        Self { map, axis }
    }

    /// Returns the distance of a moved node from the interface, and the length of the edges there. The distance is 0 if it is
    /// at most twice the error of flat facets of a surface of revolution, and for a node that slides in a plane.
    fn off(&self, x: Vector, seam: &Seam, surface: &ClosestSurface<'_>) -> [f64; 2] {
        let x = self.map.apply(x);
        let Some(foot) = surface.nearest(&x, f64::INFINITY) else {
            return [0.0; 2];
        };
        let [a, b, c] = foot.corners.map(|corner| seam.points[corner as usize]);
        let off = foot.distance_squared.sqrt();
        let Some([axis, origin]) = self.axis else {
            let edge = distance(a, b).max(distance(b, c)).max(distance(c, a));
            let off = match (unit(cross(sub(b, a), sub(c, a))), unit(sub(b, a))) {
                (Some(normal), _) => dot(sub(x, a), normal).abs(),
                (None, Some(along)) => norm(cross(sub(x, a), along)),
                (None, None) => off,
            };
            return [off, edge];
        };
        let from_axis = |x: Vector| norm(cross(x, axis));
        let around = |a: Vector, b: Vector| from_axis(sub(a, b));
        let edge = around(a, b).max(around(b, c)).max(around(c, a));
        let radius = from_axis(sub(x, origin)).max(f64::MIN_POSITIVE);
        let allowed = edge * f64::min(1.0, edge / (4.0 * radius));
        [if off > allowed { off } else { 0.0 }, edge]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preflight::tests::plan_of;
    use azimesh_io::mesh::{CellKind, Group, Mesh};

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

    /// Returns whether the zones of a schedule leave their interface, and whether that is refused.
    fn told(mesh: Mesh, schedule: &str) -> [bool; 2] {
        let plan = plan_of(mesh, schedule);
        let off = Off::find(&plan);
        [
            !off.is_empty(),
            off.iter().any(|off| off.refuse(&plan).is_err()),
        ]
    }

    #[test]
    fn a_zone_that_turns_out_of_the_mesh_is_told_of_or_refused() {
        let (none, told_of, refused) = ([false; 2], [true, false], [true; 2]);
        for (frame, hub, azimuths, expected) in [
            ("inertial", "[0, 0, 0]", "0, 11, 45", none),
            ("inertial", "[0, 0, 7]", "0, 11, 45", none),
            ("inertial", "[0, 0.7, 0]", "0, 20", told_of),
            ("inertial", "[0, 0.7, 0]", "0, 11, 45", refused),
            ("rotating", "[0, 0.7, 0]", "0, 11, 45", none),
        ] {
            let schedule = format!(
                "azimuth.values = [{azimuths}]\nrotor = {{ frame = \"{frame}\", hub = {hub} }}\n\
                 boundaries = {{ zones = [\"rotor\"], fixed = [\"far\"] }}\nrbf.support_radius = 5.0\n\
                 body = [ {{ name = \"b\", tags = [\"hub\"], rigid.translate = [0, 0, 0.01] }} ]\n"
            );
            assert_eq!(told(rings(), &schedule), expected, "{frame} {hub}");
        }
        for (motion, expected) in [
            ("rotate = { axis = [0, 0, 1], angle = 45 }", none),
            (
                "rotate = { axis = [0, 0, 1], origin = [0, 0.7, 0], angle = 45 }",
                refused,
            ),
            ("rotate = { axis = [1, 0, 0], angle = 45 }", refused),
            ("translate = [0, 0, 0.2]", none),
            ("translate = [0.01, 0, 0]", told_of),
            ("translate = [1, 0, 0]", refused),
        ] {
            let schedule = format!(
                "azimuth.values = [0, 90]\nboundaries.others = \"fixed\"\n\
                 body = [ {{ name = \"b\", zones = [\"rotor\"], rigid = {{ ramp = true, {motion} }} }} ]\n"
            );
            assert_eq!(told(rings(), &schedule), expected, "{motion}");
        }
        let sample = crate::sample::rotor(&crate::sample::BladeOptions::default());
        let sample = sample.expect("it can be made");
        let turning = sample
            .schedule
            .replace("frame = \"rotating\"", "frame = \"inertial\"");
        assert_eq!(told(sample.mesh, &turning), refused);
    }

    #[test]
    fn zones_that_turn_in_a_zone_that_turns_stay_in_it() {
        // The hub's ring of cells pitches about the shaft within the rotor, which turns in the rest.
        let mut mesh = rings();
        let (inner, outer) = (0..16, 16..32);
        mesh.groups[0].cells = outer.collect();
        mesh.groups.push(Group {
            name: "inner".into(),
            cells: inner.collect(),
            ..mesh.groups[0].clone()
        });
        let schedule = |origin: &str| {
            format!(
                "azimuth.values = [0, 33, 90]\nrotor.frame = \"inertial\"\n\
                 boundaries = {{ zones = [\"rotor\"], others = \"fixed\" }}\nrbf.support_radius = 5.0\n\
                 body = [ {{ name = \"b\", zones = [\"inner\"], \
                 rigid.rotate = {{ axis = [0, 0, 1], origin = {origin}, angle = 40 }} }} ]\n"
            )
        };
        assert_eq!(told(mesh.clone(), &schedule("[0, 0, 0]")), [false; 2]);
        assert_eq!(told(mesh, &schedule("[0.9, 0, 0]")), [true; 2]);
    }
}

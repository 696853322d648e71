//! The layers of `interpolate = "twist"` for bodies that bend: each surface point has the rotation and
//! translation of its own section, about the lifting line where the body has one.
//!
//! ```text
//! x' = x + tau(x) + exp(theta(x)) (x - c(x)) - (x - c(x)),   c(x) = x_ref(r(x)), r held within the span
//! ```

use super::Plan;
use super::layer::{Centre, Layer, Method, Turning, rotation_form, turning_bodies, twist_layers};
use crate::motion::BodyMap;
use azimesh_core::error::Result;
use azimesh_core::geometry::rotation::rotation_vector_near;
use azimesh_core::geometry::vector::{Vector, scale, sub};
use azimesh_rbf::modes::Modes;
use std::ops::Range;

/// Part of the allowed truncation for rotations, and for translations.
const EACH: f64 = 0.5;

/// The twists of the surface points at every step.
struct Twists<'a> {
    plan: &'a Plan,
    centres: Vec<Centre>,
    /// Per step, for every body.
    poses: Vec<Vec<BodyMap<'a>>>,
    /// Per step, for every body: an unwrapped rotation vector close to the vectors of its points.
    near: Vec<Vec<Vector>>,
}

/// Builds the layers of a plan whose bodies have rotations that differ from point to point.
pub(crate) fn layers(plan: &Plan, method: &Method) -> Result<Vec<Layer>> {
    let motion = &plan.motion;
    let bodies = || 0..motion.bodies.len();
    let centre = |body: usize| match motion.centre_line(body, &plan.surface.points_of(body)) {
        Some(line) => Centre::Line(line),
        None => Centre::Point(plan.centres[body]),
    };
    let steps = motion.steps.iter();
    let twists = Twists {
        plan,
        centres: bodies().map(centre).collect(),
        poses: steps.clone().map(|step| motion.poses(step, 1.0)).collect(),
        near: steps
            .map(|step| {
                bodies()
                    .map(|body| motion.rotation(body, step, 0.0, 1.0))
                    .collect()
            })
            .collect(),
    };
    let (turning, rotation) = twists.rotations(method)?;
    let translation = twists.translations(method)?;
    twist_layers(&plan.surface.points, turning, rotation, translation, method)
}

impl Twists<'_> {
    fn n_points(&self) -> usize {
        self.plan.surface.points.len()
    }

    fn theta(&self, step: usize, body: usize, at: usize) -> Vector {
        let map = self.poses[step][body].map(self.plan.surface.points[at]);
        rotation_vector_near(&map.rotation, self.near[step][body])
    }

    fn tau(&self, step: usize, body: usize, at: usize) -> Vector {
        let x = self.plan.surface.points[at];
        let centre = self.centres[body].at(x);
        sub(self.poses[step][body].map(x).apply(centre), centre)
    }

    /// Rotations as lengths, the modes of each body its own.
    fn rotations(&self, method: &Method) -> Result<(Vec<Turning>, Modes)> {
        let surface = &self.plan.surface;
        let (limit, form) = (EACH * method.truncation, rotation_form(method));
        let (n_steps, centres) = (self.poses.len(), self.centres.clone());
        turning_bodies(surface.rigid(), centres, n_steps, |body, lever_arm| {
            let fill = |step: usize, points: Range<usize>, out: &mut [Vector]| {
                for (at, out) in points.zip(out) {
                    *out = if surface.body[at].map(usize::from) == Some(body) {
                        scale(self.theta(step, body, at), lever_arm)
                    } else {
                        [0.0; 3]
                    };
                }
            };
            Modes::of_displacements(self.n_points(), n_steps, limit, form, fill)
        })
    }

    fn translations(&self, method: &Method) -> Result<Modes> {
        let fill = |step: usize, points: Range<usize>, out: &mut [Vector]| {
            for (at, out) in points.zip(out) {
                let body = self.plan.surface.body[at].map(usize::from);
                *out = body.map_or([0.0; 3], |body| self.tau(step, body, at));
            }
        };
        let limit = EACH * method.truncation;
        Modes::of_displacements(self.n_points(), self.poses.len(), limit, method.form, fill)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Schedule;
    use azimesh_core::geometry::vector::{add, distance};
    use azimesh_io::mesh::Mesh;

    const BEAM: &str = "azimuth_deg,station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n0,0,0,0,0,0,0,0\n0,1,0.01,0.02,0.05,10,2,1\n0,2,0.02,0.05,0.3,25,4,1\n180,0,0,0,0,0,0,0\n180,1,0,0,-0.05,-8,0,2\n180,2,0.01,-0.05,-0.2,-30,3,-2\n";
    const SCHEDULE: &str = "azimuth = { stop = 180, step = 45 }\nrotor = { span_axis = [0, 0, 1], shaft_axis = [0, 1, 0] }\nboundaries.others = \"fixed\"\nrbf = { support_radius = 4.0, interpolate = \"twist\" }\nselection.tolerance = 1e-3\n[[body]]\nname = \"wing\"\ntags = [\"wing\"]\nbeam = { table = \"beam.csv\" }\ncyclic = { collective = 200, flap = [ { sin = 3 } ] }\n";

    #[test]
    fn twists_of_sections_put_the_surface_where_the_motion_does() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("beam.csv"), BEAM).expect("it can be written");
        let schedule =
            Schedule::parse(SCHEDULE, &folder.path().join("s.toml")).expect("it is good");
        let mesh = Mesh::read("testdata/wing_on_plane.vtu").expect("it is good");
        let (plan, _) = Plan::new(mesh, schedule).expect("they fit");
        let [rotation, _] = &plan.layers[..] else {
            panic!("rotations and translations");
        };
        assert!(rotation.modes.n_modes > 0);
        let mut largest: f64 = 0.0;
        for step in &plan.motion.steps {
            let poses = plan.motion.poses(step, 1.0);
            for (at, x) in plan.surface.points.iter().enumerate() {
                let exact =
                    plan.surface.body[at].map_or(*x, |body| poses[usize::from(body)].apply(*x));
                let found = plan.layers.iter().fold(*x, |sum, layer| {
                    let r = layer.modes.n_modes;
                    let row = &layer.modes.values[at * r..(at + 1) * r];
                    add(sum, layer.displacement(*x, row, step.index))
                });
                largest = largest.max(distance(found, exact));
            }
        }
        assert!(largest <= 2.0 * plan.method.truncation, "{largest:e}");
    }
}

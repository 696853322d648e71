//! A body's motion as a rotation vector and the displacement of a centre: the data of `interpolate = "twist"`.

use super::motions::Rotation;
use super::options::{Interpolate, RbfOptions};
use super::resolved::Motion;
use super::steps::Step;
use azimesh_core::geometry::rotation::Quaternion;
use azimesh_core::geometry::vector::{Vector, add, cross, norm, scale, sub};
use azimesh_core::geometry::{Bounds, Twist};
use azimesh_core::numbers::named_step;
use azimesh_core::{Note, note};
use std::f64::consts::PI;

/// Largest rotation between two sampled points of the path of a body.
const INCREMENT: f64 = PI / 9.0;
/// Largest number of sampled points.
const MAX_INCREMENTS: f64 = 1e5;
/// Rotation in degrees beyond which an interpolated twist folds cells.
const FOLDS: f64 = 300.0;
/// Rotation in degrees of a part that does not fold cells.
const SERVES: f64 = 180.0;

impl Motion {
    /// Returns the point of a body about which its motion is split into rotation and translation: the origin of its rigid
    /// rotation or of its table's, else the pitch axis at the hub, else the middle of the body. It is moved to the nearest
    /// point of the box `bounds` around the body's nodes.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn twist_centre(&self, body: usize, bounds: &Bounds) -> Vector {
        let motions = self.bodies[body].motions.iter();
        let own = motions.filter_map(|motion| motion.centre()).next();
        let centre = own.unwrap_or_else(|| match bounds.low[0] > bounds.high[0] {
            // A body that shares all of its nodes with others has no node of its own.
            true => self.axes(body).hub,
            false => bounds.centre(),
        });
        bounds.nearest(&centre)
    }

    /// Returns the motion of a body between two parts of its [`pose_part`](Self::pose_part) at a step; the whole step is
    /// from 0 to 1.
    ///
    /// With `c` the position of `centre` (a point of the reference mesh) at `from`, a point `x` of the body at `from` is at
    ///
    /// ```text
    /// x' = c + tau + exp(theta) (x - c)
    /// ```
    ///
    /// at `to`, to round-off. `theta` is unwrapped, see [`rotation`](Self::rotation).
    ///
    /// # Panics
    /// If there is no such body.
    pub fn twist(&self, body: usize, step: &Step, centre: Vector, from: f64, to: f64) -> Twist {
        let [before, after] = [from, to].map(|part| self.pose_part(body, step, part));
        Twist {
            theta: self.rotation(body, step, from, to),
            tau: sub(after.apply(centre), before.apply(centre)),
        }
    }

    /// Returns the rotation vector (radians) of a body between two parts of its pose at a step, unwrapped: three quarters
    /// of a turn about an axis have 270 degrees, not -90.
    ///
    /// Rotations about one axis add up, exactly. For other rotations the path of parts is followed in increments of at
    /// most 20 degrees; of all rotation vectors of a pose, the one nearest to the previous increment's is taken. At a
    /// whole turn, where every axis gives the same rotation, the direction of the path is kept. A path about several axes
    /// that passes near a whole turn has a vector whose direction changes fast there; substeps avoid it.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn rotation(&self, body: usize, step: &Step, from: f64, to: f64) -> Vector {
        let mut rotations = self.rotations(body, step, [0.0; 3]);
        rotations.retain(|rotation| rotation.angle != 0.0);
        match about_one_axis(&rotations) {
            Some(theta) => scale(theta, to - from),
            None => followed(&rotations, from, to),
        }
    }

    /// Returns warnings about the motion before it is interpolated.
    pub fn warnings(&self, rbf: &RbfOptions) -> Vec<Note> {
        let bodies = self.bodies.iter();
        let mut warnings: Vec<Note> = bodies.flat_map(|body| body.warnings.clone()).collect();
        if rbf.interpolate == Interpolate::Twist {
            let bodies = 0..self.bodies.len();
            warnings.extend(bodies.filter_map(|body| self.turns_far(body, rbf.substeps)));
        }
        warnings
    }

    /// Returns a note if a body turns so far in a substep that cells would fold.
    fn turns_far(&self, body: usize, substeps: usize) -> Option<Note> {
        let angle = |step: &Step| norm(self.rotation(body, step, 0.0, 1.0)).to_degrees();
        let far = |angle: f64| angle / substeps as f64 > FOLDS;
        let angles = self.steps.iter().map(|step| (step, angle(step)));
        let (step, angle) = angles
            .filter(|(_, angle)| far(*angle))
            .reduce(|most, next| if next.1 > most.1 { next } else { most })?;
        let body = &self.bodies[body].name;
        let needed = (angle / SERVES).ceil() as usize;
        let note = note!(
            "turns_far",
            "body \"{body}\" turns by {angle:.0} degrees{} at {}; above about {FOLDS} degrees at once \
             interpolate = \"twist\" folds cells: set rbf.substeps = {needed}",
            match substeps {
                1 => String::new(),
                n => format!(" in {n} substeps"),
            },
            named_step(step.index, step.azimuth_deg(), step.time_s)
        );
        Some(note.with("angle_deg", angle).with("needed", needed))
    }
}

/// Returns the sum of rotations whose axes are parallel; `None` if they are not.
fn about_one_axis(rotations: &[Rotation]) -> Option<Vector> {
    let Some(first) = rotations.first() else {
        return Some([0.0; 3]);
    };
    let parallel = |next: &Rotation| cross(first.axis, next.axis) == [0.0; 3];
    rotations.iter().all(parallel).then(|| {
        let vectors = rotations.iter().map(|next| scale(next.axis, next.angle));
        vectors.fold([0.0; 3], add)
    })
}

fn followed(rotations: &[Rotation], from: f64, to: f64) -> Vector {
    let at = |part: f64| {
        let parts = rotations
            .iter()
            .map(|next| Quaternion::rotation(next.axis, part * next.angle));
        parts.fold(Quaternion::IDENTITY, Quaternion::then)
    };
    let whole: f64 = rotations.iter().map(|next| next.angle.abs()).sum();
    let increments = whole * (to - from).abs() / INCREMENT;
    let increments = increments.clamp(1.0, MAX_INCREMENTS);
    // Of two ends on one path, the shorter path is sampled at the points of the longer one, then at its end.
    let inner =
        (1..increments.ceil() as u32).map(|i| from + (to - from) * f64::from(i) / increments);
    let back = at(from).inverse();
    let mut theta = [0.0; 3];
    for part in inner.chain([to]) {
        theta = back.then(at(part)).rotation_vector_near(theta);
    }
    theta
}

//! The prescribed displacements of the surface points between two parts of each step: poses of rigid bodies, and
//! displacements of all others. Input of the layers; sets no node.

use super::Plan;
use super::layer::{BodyPath, Free, SurfaceDisplacements, Turns};
use crate::motion::{BodyMap, Interpolate, Step};
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{Vector, sub};
use std::ops::Range;

impl Plan {
    /// The motion of every body over all steps, from the reference mesh.
    pub fn surface_displacements(&self) -> SurfaceDisplacements<'_> {
        self.surface_displacements_between(&self.motion.steps, 0.0, 1.0)
    }

    /// Computes the motion of every body from part `from` to part `to` of each step.
    pub fn surface_displacements_between(
        &self,
        steps: &[Step],
        from: f64,
        to: f64,
    ) -> SurfaceDisplacements<'_> {
        let n_bodies = self.motion.bodies.len();
        if !(0..n_bodies).all(|body| self.motion.is_rigid(body)) {
            return SurfaceDisplacements::Free(self.free(steps, from, to));
        }
        let twist = self.schedule.rbf.interpolate == Interpolate::Twist;
        let path = |body: usize| BodyPath {
            poses: steps
                .iter()
                .map(|step| self.pose_between(body, step, from, to))
                .collect(),
            turns: twist.then(|| self.turns(body, steps, from, to)),
        };
        SurfaceDisplacements::Rigid((0..n_bodies).map(path).collect())
    }

    /// Computes displacements of the surface points between two parts of each step.
    fn free(&self, steps: &[Step], from: f64, to: f64) -> Free<'_> {
        let poses = |part: f64| -> Vec<Vec<BodyMap<'_>>> {
            let steps = steps.iter();
            steps.map(|step| self.motion.poses(step, part)).collect()
        };
        let before = (from > 0.0).then(|| poses(from));
        let after = poses(to);
        let surface = &self.surface;
        let fill = move |step: usize, points: Range<usize>, out: &mut [Vector]| {
            for (at, out) in points.zip(out) {
                let Some(body) = surface.body[at].map(usize::from) else {
                    *out = [0.0; 3];
                    continue;
                };
                // Points belong to the same beam sections in all parts, found in the reference mesh.
                let node = surface.nodes[at];
                let x = surface.points[at];
                let start = before
                    .as_ref()
                    .map_or(x, |before| before[step][body].place(node, x));
                *out = sub(after[step][body].place(node, x), start);
            }
        };
        Free {
            n_steps: steps.len(),
            rigid: self.rigid_part(steps, from, to),
            fill: Box::new(fill),
        }
    }

    /// Returns the surface points of rigid bodies, and their poses; empty if there are none.
    fn rigid_part(
        &self,
        steps: &[Step],
        from: f64,
        to: f64,
    ) -> (Vec<Option<u16>>, Vec<Vec<Transform>>) {
        let bodies = 0..self.motion.bodies.len();
        let rigid: Vec<bool> = bodies.map(|body| self.motion.is_rigid(body)).collect();
        if !rigid.contains(&true) {
            return (Vec::new(), Vec::new());
        }
        let body = self.surface.body.iter();
        let body = body.map(|body| body.filter(|&body| rigid[usize::from(body)]));
        let poses = rigid.iter().enumerate().map(|(body, rigid)| {
            if *rigid {
                let steps = steps.iter();
                let poses = steps.map(|step| self.pose_between(body, step, from, to));
                poses.collect()
            } else {
                vec![Transform::IDENTITY; steps.len()]
            }
        });
        (body.collect(), poses.collect())
    }

    fn pose_between(&self, body: usize, step: &Step, from: f64, to: f64) -> Transform {
        let map = |part| {
            let pose = self.motion.pose_part(body, step, part);
            *pose
                .rigid()
                .expect("only rigid bodies have a map of their own")
        };
        match from {
            0.0 => map(to),
            _ => map(from).inverse().then(&map(to)),
        }
    }

    fn turns(&self, body: usize, steps: &[Step], from: f64, to: f64) -> Turns {
        let centre = self.centres[body];
        let twists = steps
            .iter()
            .map(|step| self.motion.twist(body, step, centre, from, to));
        let (theta, tau) = twists.map(|twist| (twist.theta, twist.tau)).unzip();
        let start = match (from, steps.first()) {
            (0.0, _) | (_, None) => centre,
            (_, Some(step)) => self.motion.pose_part(body, step, from).apply(centre),
        };
        Turns {
            centre: start,
            theta,
            tau,
        }
    }
}

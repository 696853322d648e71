//! The bodies in space, step by step: the data with which the page shows them.

use super::html::count;
use super::pack::{self, Pose};
use super::surface::{Surface, Surfaces, is_near};
use crate::record::MotionRecord;
use azimesh_core::geometry::vector::{Vector, cross, distance, dot, sub, unit};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_io::mesh::Mesh;
use serde_json::{Value, json};

/// Coordinates of all frames together, at most.
const COORDINATES: usize = 12_000_000;
/// Width of a picture over its height.
const ASPECT: f64 = 10.0 / 7.0;

/// The first view.
#[derive(Debug, Clone, Copy)]
struct Camera {
    /// Middle of the picture.
    centre: Vector,
    /// Half of the height that is seen.
    radius: f64,
    /// From the middle towards the eye.
    towards: Vector,
    /// Upward.
    up: Vector,
}

impl Camera {
    /// Axes of the picture: right, up, towards the eye.
    fn axes(&self) -> [Vector; 3] {
        let towards = unit(self.towards).unwrap_or([0.0, 0.0, 1.0]);
        let right = unit(cross(self.up, towards)).unwrap_or([1.0, 0.0, 0.0]);
        [right, cross(towards, right), towards]
    }

    /// Distance of a point from the plane through the centre, towards the eye.
    fn depth(&self, x: Vector) -> f64 {
        dot(sub(x, self.centre), self.axes()[2])
    }

    /// Radius with which a point is just in view.
    fn needs(&self, x: Vector) -> f64 {
        let [right, up, _] = self.axes().map(|axis| dot(sub(x, self.centre), axis).abs());
        up.max(right / ASPECT)
    }
}

/// Surfaces and where they are at each frame.
pub struct Scene {
    surfaces: Surfaces,
    motion: MotionRecord,
    /// The bodies in the rotating frame: in the reference mesh, then at each frame.
    poses: Vec<Pose>,
    azimuths_deg: Vec<f64>,
    /// Of each other part, how far it is at the frames from where it would be if it stayed, and if it turned.
    strayed: Vec<[f64; 2]>,
    near: Vec<bool>,
}

impl Scene {
    /// Of the reference mesh, for so many frames; `None` where nothing moves in space.
    pub fn new(mesh: &Mesh, motion: Option<&MotionRecord>, n_frames: usize) -> Option<Self> {
        let motion = motion?.clone();
        let n_triangles = 2 * COORDINATES / (3 * n_frames.max(1));
        let surfaces = Surfaces::new(mesh, &motion.bodies, n_triangles)?;
        let around = surfaces.bodies.bounds();
        let near: Vec<bool> = surfaces
            .others
            .parts
            .iter()
            .map(|part| is_near(part, &around))
            .collect();
        Some(Self {
            poses: vec![surfaces.bodies.points.iter().map(|x| single(*x)).collect()],
            azimuths_deg: Vec::new(),
            strayed: vec![[0.0; 2]; near.len()],
            near,
            motion,
            surfaces,
        })
    }

    /// Adds the mesh of a frame.
    pub fn add(&mut self, mesh: &Mesh, azimuth_deg: f64) {
        let carry = self.motion.carry(azimuth_deg);
        let back = carry.inverse();
        let bodies = self.surfaces.bodies.vertices.iter();
        self.poses.push(
            bodies
                .map(|corner| single(back.apply(corner.place(mesh))))
                .collect(),
        );
        self.azimuths_deg.push(azimuth_deg);
        let others = &self.surfaces.others;
        for (part, [stays, turns]) in others.parts.iter().zip(&mut self.strayed) {
            for vertex in part.vertices.clone() {
                let (now, before) = (others.vertices[vertex].place(mesh), others.points[vertex]);
                *stays += distance(now, before);
                *turns += distance(now, carry.apply(before));
            }
        }
    }

    /// Whether another part goes round with the azimuth.
    fn turns(&self, part: usize) -> bool {
        let [stays, turns] = self.strayed[part];
        turns < 0.5 * stays
    }

    /// From where it is seen: from above, along the thinnest extent of what moves, and from the side of the bodies where
    /// other parts stand beside them; near enough that all of it is in view at all steps.
    fn camera(&self) -> Camera {
        let mut bounds = Bounds::EMPTY;
        self.for_each_point(&mut |x| bounds.include(&x));
        let centre = bounds.centre();
        let extent = sub(bounds.high, bounds.low);
        let by_length = |a: &usize, b: &usize| extent[*a].total_cmp(&extent[*b]);
        let up = (0..3).rev().min_by(by_length).unwrap_or(2);
        let long = (0..3)
            .filter(|axis| *axis != up)
            .max_by(by_length)
            .unwrap_or(0);
        let aside = sub(self.surfaces.bodies.bounds().centre(), centre);
        let towards = std::array::from_fn(|axis| {
            let is_aside = aside[axis].abs() > 0.02 * extent[axis];
            let side = |rest: f64| if is_aside { aside[axis].signum() } else { rest };
            if axis == up {
                0.55
            } else if axis == long {
                0.5 * side(1.0)
            } else {
                0.75 * side(-1.0)
            }
        });
        let up = std::array::from_fn(|axis| if axis == up { 1.0 } else { 0.0 });
        let mut camera = Camera {
            centre,
            radius: f64::MIN_POSITIVE,
            towards,
            up,
        };
        let mut radius = 0.0f64;
        self.for_each_point(&mut |x| radius = radius.max(camera.needs(x)));
        camera.radius = (1.08 * radius).max(f64::MIN_POSITIVE);
        camera
    }

    /// How far the nearest point is before the centre: what is nearer to the eye looks larger.
    fn depth(&self, camera: &Camera) -> f64 {
        let mut depth = 0.0f64;
        self.for_each_point(&mut |x| depth = depth.max(camera.depth(x)));
        depth
    }

    /// A part of all points of the bodies at all frames, and of what stands beside them.
    fn for_each_point(&self, visit: &mut dyn FnMut(Vector)) {
        let every = (self.surfaces.bodies.points.len() / 2000).max(1);
        for (frame, pose) in self
            .poses
            .iter()
            .enumerate()
            .skip(usize::from(self.poses.len() > 1))
        {
            let carry = self.carry(frame);
            for x in pose.iter().step_by(every) {
                visit(carry.apply(x.map(f64::from)));
            }
        }
        let others = &self.surfaces.others;
        for (part, _) in others
            .parts
            .iter()
            .zip(&self.near)
            .filter(|(_, near)| **near)
        {
            others.points[part.vertices.clone()]
                .iter()
                .for_each(|x| visit(*x));
        }
    }

    /// What carries the rotating frame to its place; `frame` counts the reference mesh.
    fn carry(&self, frame: usize) -> Transform {
        let azimuth = frame
            .checked_sub(1)
            .and_then(|frame| self.azimuths_deg.get(frame));
        self.motion.carry(azimuth.copied().unwrap_or(0.0))
    }

    /// What the script of the page shows. Frames of bodies begin with the reference mesh.
    pub fn data(&self) -> Value {
        let camera = self.camera();
        let others = &self.surfaces.others;
        let at_rest: Pose = others.points.iter().map(|x| single(*x)).collect();
        json!({
            "axis": self.motion.turn_axis,
            "hub": self.motion.hub,
            "turns_deg": match self.motion.frame.as_str() {
                "inertial" => self.azimuths_deg.clone(),
                _ => vec![0.0; self.azimuths_deg.len()],
            },
            "camera": {
                "centre": camera.centre, "radius": camera.radius, "towards": camera.towards, "up": camera.up,
                "depth": self.depth(&camera),
            },
            "bodies": surface(&self.surfaces.bodies, &self.poses, &|_| (true, true)),
            "others": surface(others, &[at_rest], &|part| (self.near[part], self.turns(part))),
        })
    }

    /// How many triangles are shown.
    pub fn sentence(&self) -> String {
        let [bodies, others] = [&self.surfaces.bodies, &self.surfaces.others];
        let of = |surface: &Surface, what: &str| {
            let (n, all) = (surface.triangles.len(), surface.n_given);
            match n == all {
                true => format!("all {} triangles of {what}", count(n)),
                false => format!(
                    "{} triangles instead of the {} of {what}",
                    count(n),
                    count(all)
                ),
            }
        };
        let plural = if self.motion.bodies.len() == 1 {
            "the body"
        } else {
            "the bodies"
        };
        let mut told = format!("Shown: {}", of(bodies, plural));
        if others.n_given > 0 {
            told += &format!(
                ", {}",
                of(
                    others,
                    "other boundaries, where they are in the reference mesh"
                )
            );
        }
        let is_decimated = |surface: &Surface| surface.triangles.len() < surface.n_given;
        if is_decimated(bodies) || is_decimated(others) {
            told += ". Edges were collapsed for this picture only; every corner that is left is a node of the mesh";
        }
        told + "."
    }
}

fn single(x: Vector) -> [f32; 3] {
    x.map(|x| x as f32)
}

/// A surface for the script; `is_shown_and_turns` of each part.
fn surface(
    surface: &Surface,
    poses: &[Pose],
    is_shown_and_turns: &dyn Fn(usize) -> (bool, bool),
) -> Value {
    let (boxes, positions) = pack::positions(surface, poses);
    let parts: Vec<Value> = (0..)
        .zip(&surface.parts)
        .zip(boxes)
        .map(|((at, part), scales)| {
            let (shown, turns) = is_shown_and_turns(at);
            let n = surface.triangles.iter().filter(|triangle| triangle.label as usize == at).count();
            json!({
                "name": part.name, "from": part.vertices.start, "to": part.vertices.end, "triangles": n,
                "low": scales["low"], "step": scales["step"], "shown": shown, "turns": turns,
            })
        })
        .collect();
    json!({
        "vertices": surface.vertices.len(),
        "frames": poses.len(),
        "parts": parts,
        "triangles": pack::triangles(surface),
        "positions": positions,
    })
}

//! The interpolated fields: displacements, or with `twist` rotations and translations. Each has modes at the surface and
//! the space of its interpolant.
//!
//! ```text
//! displacement   x' = x + d(x)
//! twist          x' = x + tau(x) + sum_b [ exp(theta_b(x)) (x - c_b) - (x - c_b) ]
//! ```
//!
//! For a body that turns in a [`Ring`], `theta_b` is the rotation of the body times the ring's weight; only the remainder at
//! the surface is interpolated.

use super::ring::{self, Ring};
use crate::motion::CentreLine;
use azimesh_core::error::Result;
use azimesh_core::geometry::rotation::rotate_by;
use azimesh_core::geometry::vector::{Vector, add, distance, norm, scale, sub, weighted_sum};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_rbf::criterion::Criterion;
use azimesh_rbf::modes::{Form, Modes, RigidSurface};
use azimesh_rbf::space::Space;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Component of an axis across a normal that counts as zero.
const ALONG_NORMAL: f64 = 1e-6;

/// The motion of one body over some steps, from the current mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyPath {
    /// Its exact map at each step.
    pub poses: Vec<Transform>,
    /// Its rotation vectors and translations; present with `interpolate = "twist"`.
    pub turns: Option<Turns>,
}

/// The prescribed displacements of the surface points over some steps.
pub enum SurfaceDisplacements<'a> {
    /// Every body is rigid.
    Rigid(Vec<BodyPath>),
    /// Displacements of any kind.
    Free(Free<'a>),
}

/// A function that writes the displacements of some surface points at a step.
pub type Fill<'a> = dyn Fn(usize, Range<usize>, &mut [Vector]) + Sync + 'a;

/// Displacements of any kind: `fill(step, points, out)` writes the displacements of some surface points.
pub struct Free<'a> {
    /// Number of steps.
    pub n_steps: usize,
    /// The surface points that move rigidly, and the poses of all bodies; poses of other bodies are not used. Empty if there
    /// are none.
    pub rigid: (Vec<Option<u16>>, Vec<Vec<Transform>>),
    /// Writes the displacements.
    pub fill: Box<Fill<'a>>,
}

/// Unwrapped rotation vectors about one point of a body, and the displacements of that point.
#[derive(Debug, Clone, PartialEq)]
pub struct Turns {
    /// The point, in the current mesh.
    pub centre: Vector,
    /// `theta` at each step, in radians.
    pub theta: Vec<Vector>,
    /// `tau` at each step, in mesh units.
    pub tau: Vec<Vector>,
}

/// One interpolated field.
#[derive(Debug, Clone)]
pub struct Layer {
    /// Kind of its values.
    pub kind: LayerKind,
    /// The space of its interpolant.
    pub space: Space,
    /// Its data at the surface.
    pub modes: Modes,
    /// The error of a residual over all steps, as a displacement.
    pub criterion: Criterion,
    /// Displacement due to a unit error at each surface point, by turning bodies (N, bodies); 1 everywhere if empty.
    pub lever_arms: Vec<f64>,
    /// Its part of the tolerance.
    pub tolerance: f64,
    /// The interpolated data (N, r): without the contribution of rings. `None` without rings.
    rest: Option<Vec<f64>>,
}

/// Kind of the values of a layer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum LayerKind {
    /// Displacements.
    Displacement,
    /// Rotation vectors of the bodies, each times the body's largest lever arm, so that they are lengths.
    Rotation(Vec<Turning>),
}

/// The rotation of one body among the modes of a layer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Turning {
    /// Its centre of rotation.
    pub centre: Centre,
    /// Its largest lever arm: the largest distance of its surface points from the centre, in mesh units.
    pub lever_arm: f64,
    /// Its modes.
    pub modes: Range<usize>,
    /// Its ring, if its rotation depends only on the distance from the axis, with the values of its modes on the body.
    pub ring: Option<(Ring, Vec<f64>)>,
}

/// Centre of rotation of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Centre {
    /// One point.
    Point(Vector),
    /// Each section about its own point.
    Line(CentreLine),
}

impl Centre {
    /// Returns the centre of rotation at `x`.
    #[inline]
    pub fn at(&self, x: Vector) -> Vector {
        match self {
            Self::Point(centre) => *centre,
            Self::Line(line) => line.at(x),
        }
    }
}

/// Options of the interpolation of the fields.
#[derive(Debug, Clone)]
pub struct Method {
    /// The space of displacements.
    pub displacement: Space,
    /// The space of rotations.
    pub rotation: Space,
    /// Scalar modes of displacements, or vector modes where their space couples the components.
    pub form: Form,
    /// Displacement error allowed, in mesh units.
    pub tolerance: f64,
    /// Allowed error of the modes, in mesh units.
    pub truncation: f64,
    /// True if rotations in rings decrease with the logarithm of the distance from the axis.
    pub rings: bool,
}

/// Builds the layers of a motion: displacements, or rotations and then translations.
pub fn layers(
    surface: RigidSurface<'_>,
    given: &SurfaceDisplacements<'_>,
    method: &Method,
) -> Result<Vec<Layer>> {
    let paths = match given {
        SurfaceDisplacements::Rigid(paths) => paths,
        SurfaceDisplacements::Free(free) => return Ok(vec![free.layer(surface.points, method)?]),
    };
    let turns: Option<Vec<&Turns>> = paths.iter().map(|path| path.turns.as_ref()).collect();
    let Some(turns) = turns.filter(|turns| !turns.is_empty()) else {
        let poses: Vec<_> = paths.iter().map(|path| path.poses.clone()).collect();
        let modes = Modes::of_rigid_bodies(surface, &poses, method.form)?;
        return Ok(vec![Layer::new(
            LayerKind::Displacement,
            method.displacement.clone(),
            modes,
            method.tolerance,
        )?]);
    };
    let (turning, rotation) = rotations(surface, &turns, method)?;
    let shifts: Vec<_> = turns
        .iter()
        .map(|turns| translations(turns.tau.iter().copied()))
        .collect();
    let translation = Modes::of_rigid_bodies(surface, &shifts, method.form)?;
    twist_layers(surface.points, turning, rotation, translation, method)
}

/// Returns the form of the modes of rotations.
pub(crate) fn rotation_form(method: &Method) -> Form {
    match method.rotation.constraints {
        Some(_) => Form::Vector,
        None => Form::Scalar,
    }
}

/// Builds the layers of rotations and of translations.
pub(crate) fn twist_layers(
    points: &[Vector],
    turning: Vec<Turning>,
    rotation: Modes,
    translation: Modes,
    method: &Method,
) -> Result<Vec<Layer>> {
    let both = rotation.n_modes > 0 && translation.n_modes > 0;
    let tolerance = method.tolerance * if both { 0.5 } else { 1.0 };
    Ok(vec![
        Layer {
            lever_arms: lever_arms(points, &turning),
            rest: ring::rest(points, &turning, &rotation),
            ..Layer::new(
                LayerKind::Rotation(turning),
                method.rotation.clone(),
                rotation,
                tolerance,
            )?
        },
        Layer::new(
            LayerKind::Displacement,
            method.displacement.clone(),
            translation,
            tolerance,
        )?,
    ])
}

impl Free<'_> {
    /// Builds the layer of the displacements of all surface points.
    pub fn layer(&self, points: &[Vector], method: &Method) -> Result<Layer> {
        let (n_steps, limit, form) = (self.n_steps, method.truncation, method.form);
        let (body, poses) = &self.rigid;
        let modes = if body.is_empty() {
            Modes::of_displacements(points.len(), n_steps, limit, form, &self.fill)?
        } else {
            let surface = RigidSurface { points, body };
            Modes::of_mixed(surface, poses, n_steps, limit, form, &self.fill)?
        };
        let space = method.displacement.clone();
        Layer::new(LayerKind::Displacement, space, modes, method.tolerance)
    }
}

fn translations(by: impl Iterator<Item = Vector>) -> Vec<Transform> {
    by.map(Transform::translation).collect()
}

/// Builds rotations about one point of each body.
fn rotations(
    surface: RigidSurface<'_>,
    turns: &[&Turns],
    method: &Method,
) -> Result<(Vec<Turning>, Modes)> {
    let form = rotation_form(method);
    let n_steps = turns.first().map_or(0, |turns| turns.theta.len());
    let centres = turns.iter().map(|turns| Centre::Point(turns.centre));
    let centres = centres.collect();
    let (mut turning, modes) = turning_bodies(surface, centres, n_steps, |body, lever_arm| {
        let own = surface.body.iter();
        let own: Vec<Option<u16>> = own
            .map(|of| of.filter(|of| usize::from(*of) == body).map(|_| 0))
            .collect();
        let theta = turns[body].theta.iter();
        let lengths = translations(theta.map(|theta| scale(*theta, lever_arm)));
        let own = RigidSurface {
            points: surface.points,
            body: &own,
        };
        Modes::of_rigid_bodies(own, &[lengths], form)
    })?;
    if method.rings {
        for (body, (turning, turns)) in turning.iter_mut().zip(turns).enumerate() {
            turning.ring = ring(surface, body, turns, method, &modes, &turning.modes);
        }
    }
    Ok((turning, modes))
}

/// Finds the ring of a body, with the values of its modes on it, which are equal at all of its points.
fn ring(
    surface: RigidSurface<'_>,
    body: usize,
    turns: &Turns,
    method: &Method,
    modes: &Modes,
    own: &Range<usize>,
) -> Option<(Ring, Vec<f64>)> {
    let constraints = method.rotation.constraints.as_ref();
    let may_turn = |point: usize, axis: Vector| {
        let held = constraints.map_or(axis, |held| held[point].project(axis));
        norm(held) < ALONG_NORMAL
    };
    let of = surface.body.iter();
    let at = of
        .clone()
        .position(|of| of.map(usize::from) == Some(body))?;
    let ring = Ring::around(surface, body, turns.centre, &turns.theta, may_turn)?;
    let row = &modes.values[at * modes.n_modes..][own.clone()];
    Some((ring, row.to_vec()))
}

/// Builds the rotations of all bodies about their centres, side by side. `modes_of(body, lever_arm)` returns the modes
/// of a body's rotation vectors times its largest lever arm; each body has its own modes, as it has its own centre.
pub(crate) fn turning_bodies(
    surface: RigidSurface<'_>,
    centres: Vec<Centre>,
    n_steps: usize,
    modes_of: impl Fn(usize, f64) -> Result<Modes>,
) -> Result<(Vec<Turning>, Modes)> {
    let mut all: Option<Modes> = None;
    let mut turning = Vec::new();
    for (body, centre) in centres.into_iter().enumerate() {
        let nodes = surface.points.iter().zip(surface.body);
        let lever_arm = nodes
            .filter(|(_, of)| of.map(usize::from) == Some(body))
            .map(|(point, _)| distance(*point, centre.at(*point)))
            .fold(0.0, f64::max);
        let modes = modes_of(body, lever_arm)?;
        let first = all.as_ref().map_or(0, |all| all.n_modes);
        turning.push(Turning {
            centre,
            lever_arm,
            modes: first..first + modes.n_modes,
            ring: None,
        });
        all = Some(match all {
            Some(all) => all.beside(modes, n_steps),
            None => modes,
        });
    }
    Ok((turning, all.unwrap_or_default()))
}

/// Returns the turning bodies.
fn turning(bodies: &[Turning]) -> impl Iterator<Item = &Turning> {
    bodies.iter().filter(|body| !body.modes.is_empty())
}

/// Returns the lever arm of each point about the centre of each turning body, relative to the largest one of that
/// body (N, bodies).
fn lever_arms(points: &[Vector], bodies: &[Turning]) -> Vec<f64> {
    let turning: Vec<&Turning> = turning(bodies).collect();
    let arm =
        |point: Vector, body: &Turning| distance(point, body.centre.at(point)) / body.lever_arm;
    let arms_of = |point: &Vector| {
        turning
            .iter()
            .map(|body| arm(*point, body))
            .collect::<Vec<_>>()
    };
    points.iter().flat_map(arms_of).collect()
}

impl Layer {
    fn new(kind: LayerKind, space: Space, modes: Modes, tolerance: f64) -> Result<Self> {
        let parts = match &kind {
            LayerKind::Displacement => std::iter::once(0..modes.n_modes).collect(),
            // Errors of bodies that turn about different centres do not cancel.
            LayerKind::Rotation(bodies) => turning(bodies).map(|body| body.modes.clone()).collect(),
        };
        Ok(Self {
            criterion: Criterion::of_parts(modes.n_modes, &modes.coefficients, parts)?,
            kind,
            space,
            modes,
            lever_arms: Vec::new(),
            tolerance,
            rest: None,
        })
    }

    /// Returns the data to interpolate (N, r), by rows.
    pub fn interpolated(&self) -> &[f64] {
        self.rest.as_ref().unwrap_or(&self.modes.values)
    }

    /// Adds the contribution of rings to values of the modes (N, r) at the positions `at`.
    pub(crate) fn add_rings(&self, values: &mut [f64], at: impl Fn(usize) -> Vector + Sync) {
        if let LayerKind::Rotation(bodies) = &self.kind {
            ring::add_rings(bodies, 1.0, self.modes.n_modes, values, at);
        }
    }

    /// Returns the rings in which bodies turn, with the index of the body.
    pub fn rings(&self) -> impl Iterator<Item = (usize, &Ring)> {
        let bodies = match &self.kind {
            LayerKind::Displacement => &[][..],
            LayerKind::Rotation(bodies) => bodies,
        };
        let rings = bodies.iter().enumerate();
        rings.filter_map(|(body, turning)| Some((body, &turning.ring.as_ref()?.0)))
    }

    /// Returns the displacement of a node at `x` with the values `row` of the modes, at a step.
    #[inline]
    pub fn displacement(&self, x: Vector, row: &[f64], step: usize) -> Vector {
        let coefficients = self.modes.at_step(step).as_chunks::<3>().0;
        match &self.kind {
            LayerKind::Displacement => weighted_sum(row, coefficients),
            LayerKind::Rotation(bodies) => bodies.iter().fold([0.0; 3], |sum, body| {
                let range = body.modes.clone();
                if range.is_empty() {
                    return sum;
                }
                let length = weighted_sum(&row[range.clone()], &coefficients[range]);
                let arm = sub(x, body.centre.at(x));
                let turned = rotate_by(scale(length, 1.0 / body.lever_arm), arm);
                add(sum, sub(turned, arm))
            }),
        }
    }

    /// Returns the name of its base points in base.toml.
    pub fn name(&self) -> &'static str {
        match self.kind {
            LayerKind::Displacement => "nodes",
            LayerKind::Rotation(_) => "rotation_nodes",
        }
    }
}

/// Returns the bounds of the points of one body.
pub fn bounds_of_body(surface: RigidSurface<'_>, body: usize) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for (point, of) in surface.points.iter().zip(surface.body) {
        if of.map(usize::from) == Some(body) {
            bounds.include(point);
        }
    }
    bounds
}

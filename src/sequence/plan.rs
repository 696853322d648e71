//! Everything that is decided before work starts: a mesh, what the schedule means on it, the modes,
//! the support radius and the tolerance.

use super::surface::SurfacePoints;
use super::wall::FirstCells;
use super::zone;
use crate::error::{Error, Result};
use crate::geometry::vector::{Vector, distance};
use crate::geometry::{Bounds, Transform};
use crate::mesh::Mesh;
use crate::modes::{Modes, RigidSurface};
use crate::motion::{KernelName, Motion, Schedule, SelectionMethod, Step};
use crate::rbf::criterion::Criterion;
use crate::rbf::select::Targets;
use crate::rbf::{Basis, Kernel};
use rayon::prelude::*;

/// The tolerance left out of a schedule, in diagonals of the moving bodies.
const DEFAULT_TOLERANCE: f64 = 1e-4;
/// The support radius left out, at most this many diagonals of the moving surfaces.
const DEFAULT_RADIUS: f64 = 10.0;
/// The modes may be off by this part of the tolerance, and of the smallest first cell.
const TRUNCATION: f64 = 0.01;

/// A mesh, a schedule and what follows from both.
pub struct Plan {
    /// The mesh as it is written; where a zone turns, its interface nodes are duplicated.
    pub mesh: Mesh,
    /// Node positions of the reference mesh.
    pub reference: Vec<Vector>,
    /// The schedule as read.
    pub schedule: Schedule,
    /// The schedule on this mesh.
    pub motion: Motion,
    /// The surface nodes.
    pub surface: SurfacePoints,
    /// First cells at the moving walls.
    pub first_cells: FirstCells,
    /// The motion at the surface as modes.
    pub modes: Modes,
    /// The error of a residual over all steps.
    pub criterion: Criterion,
    /// Kernel and support radius.
    pub basis: Basis,
    /// Displacement error allowed before the correction, in mesh units.
    pub tolerance: f64,
    /// What was chosen where the schedule says nothing, as sentences.
    pub choices: Vec<String>,
}

impl Plan {
    /// Resolves a schedule on a mesh and finds its modes.
    pub fn new(mut mesh: Mesh, schedule: Schedule) -> Result<Self> {
        let mut motion = schedule.resolve(&mesh)?;
        if motion.carry(&motion.steps[0]).is_some() {
            zone::detach(&mut mesh, &mut motion)?;
        }
        let surface = SurfacePoints::new(&mesh, &motion)?;
        let first_cells = FirstCells::find(&mesh, &motion);
        let mut choices = Vec::new();
        let moving = moving_bounds(&surface);
        let basis = basis(&schedule, &mesh, &motion, &moving, &mut choices);
        let tolerance = tolerance(&schedule, &moving, &first_cells, &mut choices)?;
        let modes = Modes::of_rigid_bodies(
            RigidSurface {
                points: &surface.points,
                body: &surface.body,
            },
            &poses(&motion),
        )?;
        let plan = Self {
            criterion: Criterion::new(modes.n_modes, &modes.coefficients)?,
            reference: mesh.points.clone(),
            mesh,
            schedule,
            motion,
            surface,
            first_cells,
            modes,
            basis,
            tolerance,
            choices,
        };
        plan.check_truncation()?;
        Ok(plan)
    }

    fn check_truncation(&self) -> Result<()> {
        let cell = self.first_cells.smallest().unwrap_or(f64::INFINITY);
        let limit = TRUNCATION * self.tolerance.min(cell);
        if self.modes.truncation > limit {
            return Err(Error::input(format!(
                "the modes of the motion are off by {:.1e}, which is more than 1% of the tolerance {:.1e} \
                 or of the smallest first cell {cell:.1e}; move the mesh near the origin or raise the tolerance",
                self.modes.truncation, self.tolerance
            )));
        }
        Ok(())
    }

    /// What the base points are to reproduce.
    pub fn targets(&self) -> Targets<'_> {
        Targets {
            points: &self.surface.points,
            values: &self.modes.values,
            criterion: &self.criterion,
        }
    }

    /// The exact map of every body at a step, the carrying round of the inertial frame included.
    pub fn poses_at(&self, step: &Step) -> Vec<Transform> {
        let carry = self.motion.carry(step).unwrap_or(Transform::IDENTITY);
        (0..self.motion.bodies.len())
            .map(|body| self.motion.pose(body, step).then(&carry))
            .collect()
    }

    /// Largest prescribed displacement of a surface node at a step, in the rotating frame.
    pub fn largest_displacement(&self, step: usize) -> f64 {
        let step = &self.motion.steps[step];
        let bodies = 0..self.motion.bodies.len();
        let poses: Vec<Transform> = bodies.map(|body| self.motion.pose(body, step)).collect();
        let nodes = self.surface.points.par_iter().zip(&self.surface.body);
        let moved = nodes.filter_map(|(x, body)| Some(distance(poses[(*body)?].apply(*x), *x)));
        moved.reduce(|| 0.0, f64::max)
    }

    /// The nodes that deform, ascending; `None` for all.
    pub fn deforming_nodes(&self) -> Option<Vec<u32>> {
        let zone = self.motion.zone.as_ref()?;
        let marked = zone.nodes.iter().zip(0..);
        Some(
            marked
                .filter(|(inside, _)| **inside)
                .map(|(_, node)| node)
                .collect(),
        )
    }
}

fn poses(motion: &Motion) -> Vec<Vec<Transform>> {
    let of_body = |body| {
        motion
            .steps
            .iter()
            .map(|step| motion.pose(body, step))
            .collect()
    };
    (0..motion.bodies.len()).map(of_body).collect()
}

fn moving_bounds(surface: &SurfacePoints) -> Bounds {
    let nodes = surface.points.iter().zip(&surface.body);
    let moving: Vec<Vector> = nodes
        .filter(|(_, body)| body.is_some())
        .map(|(point, _)| *point)
        .collect();
    Bounds::around(&moving)
}

fn basis(
    schedule: &Schedule,
    mesh: &Mesh,
    motion: &Motion,
    moving: &Bounds,
    choices: &mut Vec<String>,
) -> Basis {
    let kernel = match schedule.rbf.kernel {
        KernelName::WendlandC0 => Kernel::WendlandC0,
        KernelName::WendlandC2 => Kernel::WendlandC2,
        KernelName::WendlandC4 => Kernel::WendlandC4,
        KernelName::WendlandC6 => Kernel::WendlandC6,
    };
    let radius = schedule.rbf.support_radius.unwrap_or_else(|| {
        let region = match &motion.zone {
            None => Bounds::around(&mesh.points),
            Some(zone) => {
                let nodes = mesh.points.iter().zip(&zone.nodes);
                let inside: Vec<Vector> = nodes
                    .filter(|(_, inside)| **inside)
                    .map(|(point, _)| *point)
                    .collect();
                Bounds::around(&inside)
            }
        };
        let radius = region.diagonal().min(DEFAULT_RADIUS * moving.diagonal());
        choices.push(format!("support_radius = {radius} (chosen)"));
        radius
    });
    Basis { kernel, radius }
}

fn tolerance(
    schedule: &Schedule,
    moving: &Bounds,
    first_cells: &FirstCells,
    choices: &mut Vec<String>,
) -> Result<f64> {
    if let Some(tolerance) = schedule.selection.tolerance {
        return Ok(tolerance);
    }
    let chosen = match schedule.selection.correction {
        true => Some(DEFAULT_TOLERANCE * moving.diagonal()),
        false => first_cells.smallest(),
    };
    let tolerance = chosen.filter(|t| *t > 0.0).ok_or_else(|| {
        Error::input(
            "no tolerance can be chosen for this mesh; set selection.tolerance, in mesh units",
        )
        .file(&schedule.path)
    })?;
    if schedule.selection.method != SelectionMethod::All {
        choices.push(format!("selection.tolerance = {tolerance} (chosen)"));
    }
    Ok(tolerance)
}

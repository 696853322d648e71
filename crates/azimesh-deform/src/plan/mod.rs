//! Decisions before the selection of base points: the schedule resolved on the boundary of a mesh, the interpolated
//! layers, the support radius and the tolerance. Plain data, the same on every rank.

pub(crate) mod checks;
pub(crate) mod first_cells;
pub(crate) mod layer;
pub(crate) mod periodic;
pub(crate) mod prepare;
mod ring;
mod sections;
pub(crate) mod surface;
mod surface_displacements;
pub(crate) mod zone;

use self::layer::{Layer, Method};
use self::periodic::PeriodicNodes;
use self::surface::SurfacePoints;
use self::zone::Seam;
use crate::motion::{BodyMap, Motion, QualityOutput, Schedule, SelectionMethod, Step};
use azimesh_core::error::Result;
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::{Note, parallel};
use azimesh_io::mesh::{Boundary, OneLayer};
use azimesh_rbf::Basis;
use azimesh_rbf::targets::Targets;
use std::ops::Range;

/// Part of the tolerance for the base points; the rest is for the truncation of the modes.
pub(crate) const SELECTED: f64 = 0.99;

/// The boundary of a mesh, a schedule and the data derived from both.
#[derive(Clone)]
pub struct Plan {
    /// The boundary of the reference mesh; where a zone turns, its interface nodes are duplicated.
    pub boundary: Boundary,
    /// The BLAKE3 hash of the coordinates of its nodes.
    pub points_hash: String,
    /// True if boxes for free-form deformation were left out: they only fit the mesh at rest.
    pub without_boxes: bool,
    /// The schedule as read.
    pub schedule: Schedule,
    /// The schedule on this mesh, without the faces of its surface.
    pub motion: Motion,
    /// The surface nodes.
    pub surface: SurfacePoints,
    /// Positions of the tagged nodes of parts that move rigidly, each with its body.
    pub rigid_points: Vec<(usize, Vector)>,
    /// The interfaces of parts that turn or move rigidly.
    pub seams: Vec<Seam>,
    /// The smallest first-cell height at moving walls, in mesh units.
    pub smallest_first_cell: Option<f64>,
    /// The largest relative change of a first-cell height when coordinates are rounded to 32 bits.
    pub first_cell_change_in_f32: f64,
    /// The boundary faces of the moving walls, ascending.
    pub moving_faces: Vec<u32>,
    /// Faces of the moving walls that are not a side of any cell.
    pub loose_faces: Vec<u32>,
    /// The box around the nodes that deform.
    pub region: Bounds,
    /// Kernel and support radius of displacements.
    pub basis: Basis,
    /// Options of the interpolation of the layers.
    pub method: Method,
    /// Nodes over one another, where the mesh is one layer between sides called `empty`.
    pub one_layer: Option<OneLayer>,
    /// Nodes that follow their periodic partners.
    pub periodic: PeriodicNodes,
    /// The interpolated fields, over all steps of the schedule.
    pub layers: Vec<Layer>,
    /// Velocities over all steps, where they are requested.
    pub velocity: Option<Layer>,
    /// The centre of rotation of each body, in the reference mesh.
    pub centres: Vec<Vector>,
    /// Displacement error allowed before the correction, in mesh units.
    pub tolerance: f64,
    /// Notes on values that were chosen because the schedule does not give them.
    pub choices: Vec<Note>,
}

impl Plan {
    /// Returns the targets of the base points of a layer.
    pub fn targets<'a>(&'a self, layer: &'a Layer) -> Targets<'a> {
        Targets {
            points: &self.surface.points,
            values: layer.interpolated(),
            criterion: &layer.criterion,
            images: &self.periodic.is_image,
            lever_arms: &layer.lever_arms,
        }
    }

    /// Returns the number of modes, all layers together.
    pub fn n_modes(&self) -> usize {
        self.layers.iter().map(|layer| layer.modes.n_modes).sum()
    }

    /// Returns whether the modes are exact except for round-off: for rigid bodies.
    pub fn modes_are_exact(&self) -> bool {
        (0..self.motion.bodies.len()).all(|body| self.motion.is_rigid(body))
    }

    /// Returns the largest error of the modes at any node and step, in mesh units.
    pub fn truncation(&self) -> f64 {
        self.layers.iter().map(|layer| layer.modes.truncation).sum()
    }

    /// Returns the intervals of steps that share base points, in order. This is one interval, or with method `real` one per
    /// refresh, counted from the start of the schedule.
    pub fn selection_intervals(&self) -> Vec<Range<usize>> {
        let steps = &self.motion.steps;
        let selection = &self.schedule.selection;
        let refresh = selection.refresh.map(|refresh| refresh.azimuth_deg);
        let span = |step: &Step| match refresh {
            _ if selection.method != SelectionMethod::Real => 0,
            // A step on the border belongs to the interval that starts there.
            Some(refresh) => {
                let turned = (step.azimuth_deg - steps[0].azimuth_deg).abs();
                (turned / refresh + 1e-9).floor() as usize
            }
            None => step.index,
        };
        let mut intervals: Vec<Range<usize>> = Vec::new();
        for step in steps {
            match intervals.last_mut() {
                Some(last) if span(&steps[last.start]) == span(step) => last.end += 1,
                _ => intervals.push(step.index..step.index + 1),
            }
        }
        intervals
    }

    /// Returns the exact map of every body at a step, with the rotation to the inertial frame.
    pub fn poses_at(&self, step: &Step) -> Vec<BodyMap<'_>> {
        self.motion.poses_in_place(step)
    }

    /// Returns the plan of the first `n` steps, as for a schedule that has no others.
    ///
    /// # Errors
    /// If their modes cannot be found.
    pub(crate) fn of_first_steps(&self, n: usize) -> Result<Self> {
        let mut plan = Self {
            layers: Vec::new(),
            velocity: None,
            motion: self.motion.of_first_steps(n),
            ..self.clone()
        };
        plan.find_layers()?;
        Ok(plan)
    }

    /// Returns the first of the first `n` steps that a schedule without the later steps moves otherwise, and the largest
    /// distance between the positions of its surface nodes by both; `None` if the later steps change none of them.
    pub fn changed_step(&self, n: usize) -> Option<(Step, f64)> {
        let alone = self.motion.of_first_steps(n);
        let surface = &self.surface;
        alone.steps.iter().find_map(|step| {
            let both = [&alone, &self.motion].map(|motion| motion.poses_in_place(step));
            let moved = |body: usize, node: u32, x: Vector| {
                let [a, b] = both.each_ref().map(|poses| poses[body].place(node, x));
                distance(a, b)
            };
            let of_parts = parallel::largest(self.rigid_points.len(), |at| {
                let (body, x) = self.rigid_points[at];
                distance(both[0][body].apply(x), both[1][body].apply(x))
            });
            let of_surface = parallel::largest(surface.points.len(), |at| {
                let body = surface.body[at].map(usize::from);
                body.map_or(0.0, |body| {
                    moved(body, surface.nodes[at], surface.points[at])
                })
            });
            let largest = of_parts.max(of_surface);
            (largest > self.round_off()).then_some((*step, largest))
        })
    }

    /// Returns a distance, in mesh units, below which two positions of a body differ by round-off.
    pub fn round_off(&self) -> f64 {
        1e-9 * self.boundary.extent.diagonal()
    }

    /// Returns the largest prescribed displacement of a surface node or of a rigid part at a step, in the rotating frame.
    pub fn largest_displacement(&self, step: usize) -> f64 {
        let poses = self.motion.poses(&self.motion.steps[step], 1.0);
        let surface = &self.surface;
        let of_parts = parallel::largest(self.rigid_points.len(), |at| {
            let (body, x) = self.rigid_points[at];
            distance(poses[body].apply(x), x)
        });
        let of_surface = parallel::largest(surface.points.len(), |at| {
            let x = surface.points[at];
            surface.body[at].map_or(0.0, |body| {
                distance(poses[usize::from(body)].place(surface.nodes[at], x), x)
            })
        });
        of_parts.max(of_surface)
    }

    /// Returns whether the quality of every step is evaluated.
    pub(crate) fn has_quality(&self) -> bool {
        self.schedule.output.quality != QualityOutput::None
    }

    /// Returns whether a node, by its number in the whole mesh, is in the zones that deform.
    pub(crate) fn is_in_zone(&self, node: u32) -> bool {
        let zone = self.motion.zone.as_ref();
        zone.is_none_or(|zone| zone.sides.nodes.has(node))
    }
}

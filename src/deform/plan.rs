//! Everything that is decided before base points are chosen: a mesh, what the schedule means on it, the layers
//! that are interpolated, the support radius and the tolerance.

use super::first_cells::FirstCells;
use super::layer::{Layer, Method};
use super::periodic::PeriodicNodes;
use super::sharing::Holder;
use super::sharing::Sharing;
use super::surface::SurfacePoints;
use super::team::{Maps, Placing, Team};
use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::geometry::Transform;
use crate::geometry::vector::{Vector, distance};
use crate::mesh::{CellSet, Mesh, OneLayer, Slots, faces_on_no_cell};
use crate::motion::{BodyMap, Motion, QualityOutput, Role, Schedule, SelectionMethod, Step};
use crate::parallel;
use crate::rbf::Basis;
use crate::rbf::targets::Targets;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Part of the tolerance that the base points may use; the rest is for the truncation of the modes.
pub(super) const SELECTED: f64 = 0.99;

/// A mesh, a schedule and what follows from both.
pub struct Plan {
    /// The reference mesh; where a zone turns, its interface nodes are duplicated.
    pub mesh: Arc<Mesh>,
    /// Whether boxes for free-form deformation were left out: they fit the mesh at rest.
    pub without_boxes: bool,
    /// The schedule as read.
    pub schedule: Schedule,
    /// The schedule on this mesh, without the faces of its surface.
    pub motion: Motion,
    /// The surface nodes.
    pub surface: SurfacePoints,
    /// First cells at the moving walls.
    pub first_cells: FirstCells,
    /// The boundary faces of the moving walls, ascending.
    pub moving_faces: Vec<u32>,
    /// Kernel and support radius of displacements.
    pub basis: Basis,
    /// How the layers are interpolated.
    pub method: Method,
    /// Nodes over one another, where the mesh is one layer between sides called `empty`.
    pub one_layer: Option<OneLayer>,
    /// Nodes that follow their periodic partners.
    pub periodic: PeriodicNodes,
    /// What is interpolated, over all steps of the schedule.
    pub layers: Vec<Layer>,
    /// Velocities over all steps, where they are requested.
    pub velocity: Option<Layer>,
    /// The point each body turns about, in the reference mesh.
    pub centres: Vec<Vector>,
    /// Displacement error allowed before the correction, in mesh units.
    pub tolerance: f64,
    /// What was chosen where the schedule says nothing.
    pub choices: Vec<Diagnostic>,
    /// Who shares the work.
    pub(crate) sharing: Sharing,
    /// The hash of the coordinates of the reference mesh, once it is known.
    pub(crate) points_hash: OnceLock<String>,
    /// The whole mesh, once an outline is not enough, and the reason.
    pub(super) whole: OnceLock<(Arc<Mesh>, &'static str)>,
}

impl Plan {
    /// What the base points of a layer are to reproduce.
    pub fn targets<'a>(&'a self, layer: &'a Layer) -> Targets<'a> {
        Targets {
            points: &self.surface.points,
            values: layer.interpolated(),
            criterion: &layer.criterion,
            images: &self.periodic.is_image,
            lever_arms: &layer.lever_arms,
        }
    }

    /// Reads the whole mesh where this rank has the outline alone; `reason` is told with `-v`.
    pub(crate) fn take_whole(&self, reason: &'static str) -> Result<()> {
        if let (Some(_), None, Some(team)) = (&self.mesh.outline, self.whole.get(), self.team()) {
            let whole = Arc::new(team.whole()?);
            self.whole.get_or_init(|| (whole, reason));
        }
        Ok(())
    }

    /// The whole mesh.
    ///
    /// # Panics
    /// Where there is an outline, before [`take_whole`](Self::take_whole).
    pub(super) fn whole(&self) -> &Arc<Mesh> {
        match self.mesh.outline {
            None => &self.mesh,
            Some(_) => &self.whole.get().expect("it is taken before it is used").0,
        }
    }

    /// Who looks at all cells where this is the outline of the mesh.
    fn holder(&self) -> Option<&dyn Holder> {
        self.mesh.outline.as_ref()?;
        self.sharing.holder()
    }

    /// The ranks that share the work, where they do.
    pub(crate) fn team(&self) -> Option<&Arc<Team>> {
        self.sharing.team()
    }

    /// The hash of the file of the mesh, where this process has the outline.
    pub(crate) fn hash_of_file(&self) -> Option<Result<blake3::Hash>> {
        self.mesh.outline.as_ref()?;
        Some(self.team()?.hash_of_file())
    }

    /// Where the nodes are in the reference mesh: with an outline those that are known, in its [`Slots`], until the whole is taken.
    pub fn points(&self) -> &[Vector] {
        &self.whole.get().map_or(&self.mesh, |whole| &whole.0).points
    }

    /// Which entries nodes have in positions of a step, of which most are `apart` or which are all here.
    pub(super) fn slots(&self, are_apart: bool) -> Slots<'_> {
        match are_apart {
            true => self.mesh.slots(),
            false => Slots::All,
        }
    }

    /// Number of modes, all layers together.
    pub fn n_modes(&self) -> usize {
        self.layers.iter().map(|layer| layer.modes.n_modes).sum()
    }

    /// Whether the modes reproduce the motion but for round-off: that of rigid bodies.
    pub fn modes_are_exact(&self) -> bool {
        (0..self.motion.bodies.len()).all(|body| self.motion.is_rigid(body))
    }

    /// Largest error of the modes at any node and step, in mesh units.
    pub fn truncation(&self) -> f64 {
        self.layers.iter().map(|layer| layer.modes.truncation).sum()
    }

    /// The steps that share base points, in order: all of them, or with method `real` those between
    /// two refreshes, counted from the start of the schedule.
    pub fn selection_intervals(&self) -> Vec<Range<usize>> {
        let steps = &self.motion.steps;
        let selection = &self.schedule.selection;
        let refresh = selection.refresh.map(|refresh| refresh.azimuth_deg);
        let span = |step: &Step| match refresh {
            _ if selection.method != SelectionMethod::Real => 0,
            // A step on the border belongs to the interval that begins there.
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

    /// The exact map of every body at a step, with the rotation to the inertial frame.
    pub fn poses_at(&self, step: &Step) -> Vec<BodyMap<'_>> {
        let to_inertial = self.motion.to_inertial(step).unwrap_or(Transform::IDENTITY);
        let poses = self.motion.poses(step, 1.0).into_iter();
        poses.map(|pose| pose.then(&to_inertial)).collect()
    }

    /// Largest prescribed displacement of a surface node at a step, in the rotating frame.
    pub fn largest_displacement(&self, step: usize) -> f64 {
        let poses = self.motion.poses(&self.motion.steps[step], 1.0);
        let surface = &self.surface;
        parallel::largest(surface.points.len(), |at| {
            let x = surface.points[at];
            surface.body[at].map_or(0.0, |body| {
                distance(poses[usize::from(body)].place(surface.nodes[at], x), x)
            })
        })
    }

    /// Gives each rank its nodes, and where cells are judged its part of the mesh, where there are several.
    pub(super) fn share(&self) {
        if let Some(team) = self.team() {
            let moving_faces = self.judges().then_some(&self.moving_faces[..]);
            let of_nodes = || (self.placings(), self.deforming_set());
            team.share(&self.mesh, moving_faces, of_nodes);
        }
    }

    /// Moving faces that are a side of no cell.
    ///
    /// # Errors
    /// Where the mesh has to be read for that, and is not.
    pub fn moving_faces_on_no_cell(&self) -> Result<Vec<u32>> {
        match self.holder() {
            Some(holder) => holder.faces_on_no_cell(&self.mesh, &self.moving_faces),
            None => Ok(faces_on_no_cell(&self.mesh, &self.moving_faces)),
        }
    }

    /// Whether cells are judged at every step.
    pub(super) fn judges(&self) -> bool {
        self.schedule.output.quality != QualityOutput::None
    }

    /// The nodes that fields move to a place where they do not stay, ascending: those on the surface, and followers.
    fn placings(&self) -> Vec<(u32, Placing)> {
        let surface = &self.motion.surface.nodes;
        let of_body: Vec<Placing> = (0..self.motion.bodies.len())
            .map(|body| match self.motion.is_rigid(body) {
                true => Placing::Body(body as u16),
                false => Placing::Told,
            })
            .collect();
        let is_exact = self.schedule.selection.correction;
        let placing = |(&node, role): (&u32, &Role)| match role {
            Role::Sliding => Some((node, Placing::Told)),
            _ if !is_exact => None,
            Role::Fixed => Some((node, Placing::AtRest)),
            Role::Moving(body) => Some((node, of_body[usize::from(*body)])),
        };
        let followers = self.periodic.followers().iter();
        let mut placings: Vec<(u32, Placing)> =
            followers.map(|of| (of.node, Placing::Told)).collect();
        let on_surface = surface.nodes.iter().zip(&surface.roles);
        placings.extend(on_surface.filter_map(placing));
        // The first of a node counts: a follower goes where its leader is, whatever its role.
        placings.sort_by_key(|of| of.0);
        placings.dedup_by_key(|of| of.0);
        placings
    }

    /// How ranks end their move to a part of a step, in the rotating frame.
    pub(super) fn maps_of_part(&self, step: &Step, part: f64) -> Maps {
        let poses = self.motion.poses(step, part);
        Maps {
            bodies: poses.iter().map(|pose| pose.rigid().copied()).collect(),
            ..Maps::default()
        }
    }

    /// How ranks end their move to a step.
    pub(super) fn maps_at(&self, step: &Step) -> Maps {
        let to_inertial = self.motion.to_inertial(step);
        let poses = match to_inertial {
            Some(_) => self.poses_at(step),
            None => self.motion.poses(step, 1.0),
        };
        Maps {
            bodies: poses.iter().map(|pose| pose.rigid().copied()).collect(),
            to_inertial,
            in_plane: self.motion.rotor.in_plane,
        }
    }

    /// The nodes whose places this rank has to know at a step whose positions stay with the ranks that moved them, ascending;
    /// none where it has to know all. Tells the ranks which these are.
    pub(super) fn divide(&self) -> Option<Vec<u32>> {
        let team = self.team()?;
        let is_solid = self.mesh.dimension() == 3 && !self.motion.rotor.in_plane;
        if !(self.moves_by_fields() && is_solid) {
            return None;
        }
        let followers = self.periodic.followers().iter();
        let mut known = self.motion.surface.nodes.nodes.clone();
        known.extend(followers.flat_map(|of| [of.leader, of.node]));
        known.extend(self.first_cells.nodes());
        known.sort_unstable();
        known.dedup();
        team.divide(&self.mesh, self.told(&known));
        Some(known)
    }

    /// Which of some nodes ranks have to tell of: the surface that the correction makes exact is known without that.
    fn told(&self, nodes: &[u32]) -> Vec<u32> {
        let surface = &self.motion.surface.nodes;
        let is_exact = |node: &u32| match surface.nodes.binary_search(node) {
            Ok(at) => self.schedule.selection.correction && surface.roles[at] != Role::Sliding,
            Err(_) => false,
        };
        nodes
            .iter()
            .copied()
            .filter(|node| !is_exact(node))
            .collect()
    }

    /// Whether all nodes that are not on the surface and follow none are where fields move them, and what fades in from the surface:
    /// of one layer half of them are placed by the others.
    pub(super) fn moves_by_fields(&self) -> bool {
        self.one_layer.is_none()
    }

    /// Whether nodes slide on curved boundaries.
    pub(super) fn slides_on_curves(&self) -> bool {
        let sliding = self.surface.sliding.as_ref();
        sliding.is_some_and(|sliding| sliding.has_curved())
    }

    /// Those of some nodes that deform.
    pub(super) fn deforming_among(&self, nodes: &[u32]) -> Vec<u32> {
        let inside = self.motion.zone.as_ref().map(|zone| &zone.sides.nodes);
        let is_inside = |node: &&u32| inside.is_none_or(|inside| inside.has(**node));
        nodes.iter().filter(is_inside).copied().collect()
    }

    /// The nodes that deform, of one layer the lower ones, ascending; `None` for all.
    pub fn deforming_nodes(&self) -> Option<Vec<u32>> {
        let zone = self.motion.zone.as_ref().map(|zone| &zone.sides.nodes);
        let is_inside = |node: &u32| zone.is_none_or(|inside| inside.has(*node));
        if let Some(layer) = &self.one_layer {
            // The nodes over them go with them.
            let low = layer.pairs.iter().map(|[low, _]| *low);
            return Some(low.filter(is_inside).collect());
        }
        zone?;
        let all = 0..self.mesh.points.len() as u32;
        Some(all.filter(is_inside).collect())
    }

    /// The same as a set, where ranks share the work; the zones have most of them in few runs.
    fn deforming_set(&self) -> Option<CellSet> {
        let mut set = CellSet::new();
        match (&self.one_layer, &self.motion.zone) {
            (None, None) => return None,
            (None, Some(zone)) => {
                let nodes = 0..self.mesh.points.len();
                let inside = nodes.filter(|&node| zone.sides.nodes.has(node as u32));
                inside.for_each(|node| set.push(node));
            }
            (Some(_), _) => {
                let nodes = self.deforming_nodes().unwrap_or_default();
                nodes.iter().for_each(|&node| set.push(node as usize));
            }
        }
        Some(set)
    }
}

//! A schedule resolved on a mesh: steps, axes, bodies, and the role of every surface node.

use super::body::Body;
use super::motions::{
    At, Clock, Displacements, Link, MapScope, OnMesh, ResolvedMotion, Rigid, RigidLink,
};
use super::ramp::Ramp;
use super::rotor::{RotorAxes, TurningRotor};
use super::schedule::Schedule;
use super::steps::{Step, neighbours};
use super::surface::{Role, Surface, TagRole, nodes_of_tags};
use super::tags::{PeriodicTags, TagRoles};
use super::zones::{DeformingZone, RigidPart, SidesOf};
use azimesh_core::Note;
use azimesh_core::error::{Error, Position, Result};
use azimesh_io::mesh::{Boundary, Group, OneLayer};
use std::cell::{OnceCell, RefCell};
use std::sync::Arc;

/// A schedule resolved on a mesh.
#[derive(Debug, Clone)]
pub struct Motion {
    /// The steps, at least one.
    pub steps: Vec<Step>,
    /// The rotors, in the order of the schedule, at least one.
    pub rotors: Vec<TurningRotor>,
    /// The moving bodies, in the order of the schedule.
    pub bodies: Vec<MovingBody>,
    /// The surface nodes with their roles, and the faces between them.
    pub surface: Surface,
    /// The periodic pairs, in the order of the schedule.
    pub periodic: Vec<PeriodicTags>,
    /// The part of the mesh that deforms; the whole mesh when `None`.
    pub zone: Option<DeformingZone>,
    /// The parts that move rigidly, in the order of their bodies.
    pub parts: Vec<RigidPart>,
    /// Neighbours in time of each step.
    pub(super) neighbours: Vec<[u32; 2]>,
}

/// A body on a mesh.
#[derive(Debug, Clone)]
pub struct MovingBody {
    /// Its name, unique among the bodies.
    pub name: String,
    /// Its rotor.
    pub rotor: usize,
    /// Azimuth of its blade at rotor azimuth zero, in radians.
    pub azimuth_offset: f64,
    /// The body it moves with, which is declared earlier.
    pub(super) parent: Option<usize>,
    /// Smooth start of its motions.
    pub(super) ramp: Option<Ramp>,
    /// Sorted by the order in which they act; a rigid map is always among them.
    pub(super) motions: Vec<Arc<dyn ResolvedMotion>>,
    /// Position in the schedule.
    pub place: Option<Position>,
    /// Warnings about the input of its motions.
    pub(super) warnings: Vec<Note>,
}

impl Schedule {
    /// Finds axes, motions and the role of every surface node on the mesh with this boundary. `sides_of` is called if
    /// the schedule names zones.
    ///
    /// # Errors
    /// If the schedule contradicts itself, names something that the mesh does not have, or a file of it is wrong; or if
    /// `sides_of` fails.
    pub fn resolve(&self, boundary: &Boundary, sides_of: &SidesOf<'_>) -> Result<Motion> {
        let motion = self
            .check()
            .and_then(|()| Motion::new(self, boundary, sides_of));
        motion.map_err(|error| error.file(&self.path))
    }
}

impl Motion {
    fn new(schedule: &Schedule, boundary: &Boundary, sides_of: &SidesOf<'_>) -> Result<Self> {
        if boundary.n_cells == 0 {
            return Err(Error::input(
                "the mesh has no cells; there is nothing to deform",
            ));
        }
        let dimension = boundary.space_dimension();
        // A mesh of one layer in the plane of x and y moves like a mesh in that plane.
        let is_plane = dimension == 2 || OneLayer::axis_of(boundary)? == Some(2);
        if is_plane {
            check_plane(schedule)?;
        }
        let steps = schedule.steps()?;
        let rotor = |at: usize| {
            let rotor = schedule.rotor_in_time(at)?;
            let dimension = if is_plane { 2 } else { dimension };
            Ok(TurningRotor {
                name: rotor.rotor.name.clone(),
                axes: rotor.rotor.axes(dimension, &rotor.places)?,
                steps: if at == 0 { None } else { rotor.steps(&steps)? },
            })
        };
        let rotors: Result<Vec<_>> = (0..schedule.rotors.len()).map(rotor).collect();
        let rotors = rotors?;
        let parts = RigidPart::find_all(schedule, boundary, sides_of)?;
        let zone = DeformingZone::find(schedule, &parts, boundary, sides_of)?;
        let tags: Vec<&Group> = boundary.boundary_tags().collect();
        let named = TagRoles::find(&tags, schedule, zone.as_ref(), boundary)?;
        check_sliding(&tags, &named.tags, dimension)?;
        let mut motion = Self {
            neighbours: neighbours(&steps),
            steps,
            rotors,
            bodies: Vec::new(),
            surface: Surface::find(&tags, named.tags, zone.as_ref(), boundary),
            periodic: named.periodic,
            zone,
            parts,
        };
        for body in &schedule.bodies {
            let body = motion.resolve(body, schedule, boundary)?;
            motion.bodies.push(body);
        }
        motion.check_parents(schedule)?;
        Ok(motion)
    }

    /// Returns the motion over the first `n` steps, as in a schedule that has no others.
    pub fn of_first_steps(&self, n: usize) -> Self {
        let mut motion = self.clone();
        motion.steps.truncate(n);
        motion.neighbours = neighbours(&motion.steps);
        for steps in motion.rotors.iter_mut().flat_map(|own| &mut own.steps) {
            steps.truncate(n);
        }
        motion
    }

    /// Resolves the motions of the next body on the mesh.
    fn resolve(&self, body: &Body, schedule: &Schedule, boundary: &Boundary) -> Result<MovingBody> {
        let is_parent = |other: &MovingBody| Some(&other.name) == body.parent.as_ref();
        let parent = self.bodies.iter().position(is_parent);
        let rotor = schedule.rotor_of(body)?;
        let inherited = parent.map_or(0.0, |parent| self.bodies[parent].azimuth_offset);
        let azimuth_offset = body.azimuth_offset.unwrap_or(inherited);
        let on = OnMesh {
            boundary,
            faces: &self.surface.faces,
            surface_nodes: &self.surface.nodes,
            role: Role::Moving(self.bodies.len() as u16),
            blade: self.rotors[rotor].axes.blade(azimuth_offset),
            offset: azimuth_offset,
            clock: Clock {
                steps: self.rotors[rotor].steps.as_ref().unwrap_or(&self.steps),
                neighbours: &self.neighbours,
            },
            length_unit: schedule.output.length_unit.as_deref(),
            body,
            folder: schedule.path.with_file_name(""),
            nodes: OnceCell::new(),
            warnings: RefCell::default(),
        };
        if let Some(ramp) = &body.ramp {
            ramp.check_times(&self.steps, &body.places)?;
        }
        let mut motions = Vec::new();
        for motion in &body.motions {
            motions.push(motion.resolve(&on)?);
        }
        if body.motion::<Rigid>().is_none() {
            let nodes = motions
                .iter()
                .filter(|motion| motion.map_scope() == MapScope::Nodes);
            motions.insert(nodes.count(), Arc::new(AtRest));
        }
        Ok(MovingBody {
            name: body.name.clone(),
            rotor,
            azimuth_offset,
            parent,
            ramp: body.ramp.clone(),
            motions,
            place: body.places.of("name"),
            warnings: on.warnings.into_inner(),
        })
    }

    /// Refuses parents whose motion is known only at their own nodes.
    fn check_parents(&self, schedule: &Schedule) -> Result<()> {
        for (child, declared) in self.bodies.iter().zip(&schedule.bodies) {
            let has_nodes = |parent: &usize| {
                let mut motions = self.bodies[*parent].motions.iter();
                motions.any(|motion| motion.map_scope() == MapScope::Nodes)
            };
            if let Some(parent) = child.parent.filter(has_nodes) {
                let what = match schedule.bodies[parent].motion::<Displacements>() {
                    Some(_) => "displacements",
                    None => "`surface` or `modes`",
                };
                let message = format!(
                    "body \"{}\" cannot move with \"{}\", whose {what} are known only at its own nodes; give \
                     the child a motion of its own",
                    child.name, self.bodies[parent].name
                );
                return Err(declared.places.error("name", message));
            }
        }
        if let Some(part) = self.parts.iter().find(|part| !self.is_rigid(part.body)) {
            let declared = &schedule.bodies[part.body];
            let message = format!(
                "body \"{}\" moves its zones rigidly, and its parent bends; give it a parent that is rigid, or a motion of its own",
                declared.name
            );
            return Err(declared.places.error("parent", message));
        }
        Ok(())
    }

    /// Notes on the files of the motions.
    pub fn notes(&self) -> Vec<Note> {
        // Notes of beams before notes of displacements.
        let motions = self
            .bodies
            .iter()
            .flat_map(|body| body.motions.iter().rev());
        motions.flat_map(|motion| motion.notes()).cloned().collect()
    }

    /// Returns the body whose zones contain a node, by its number in the whole mesh.
    pub fn body_of_node(&self, node: u32) -> Option<usize> {
        let mut parts = self.parts.iter();
        parts
            .find(|part| part.sides.nodes.has(node))
            .map(|part| part.body)
    }

    /// Returns the rotor of a node, by its number in the whole mesh; `None` if it is in no zone of a rotor.
    pub fn rotor_of_node(&self, node: u32) -> Option<usize> {
        match (self.body_of_node(node), &self.zone) {
            (Some(body), _) => Some(self.bodies[body].rotor),
            (None, Some(zone)) => zone.part_of(node)?.rotor,
            (None, None) => Some(0),
        }
    }

    /// Returns the axes of the rotor of a body.
    pub fn axes(&self, body: usize) -> &RotorAxes {
        &self.rotors[self.bodies[body].rotor].axes
    }

    /// Returns whether the mesh is plane, in x and y.
    pub fn in_plane(&self) -> bool {
        self.rotors[0].axes.in_plane
    }

    /// Returns the nodes of both sides of a periodic pair, ascending; with zones, only nodes in the zones.
    pub fn periodic_nodes(&self, pair: &PeriodicTags, boundary: &Boundary) -> [Vec<u32>; 2] {
        [&pair.a, &pair.b].map(|tags| nodes_of_tags(tags, self.zone.as_ref(), boundary))
    }
}

/// The rigid motion of a body without `[body.rigid]`, so that every chain has a rigid map.
#[derive(Debug)]
struct AtRest;

impl ResolvedMotion for AtRest {
    fn link(&self, _: &At<'_>) -> Option<Link<'_>> {
        Some(Link::Rigid(RigidLink::default()))
    }
}

/// Nodes slide on the faces of a volume, or on edges in a plane; a shell and a point cloud have neither.
fn check_sliding(tags: &[&Group], roles: &[TagRole], space: u8) -> Result<()> {
    let of_shell = tags.iter().zip(roles).find(|(tag, role)| {
        role.role == Some(Role::Sliding) && tag.dimension + 1 < space && !tag.cells.is_empty()
    });
    match of_shell {
        None => Ok(()),
        Some((tag, _)) => Err(Error::input(format!(
            "tag \"{}\" cannot slide: it has no faces to slide on, since the mesh has no volume cells",
            tag.name
        ))),
    }
}

/// Refuses motion out of the plane of a 2D mesh.
fn check_plane(schedule: &Schedule) -> Result<()> {
    for body in &schedule.bodies {
        let upright = schedule.rotors[schedule.rotor_of(body)?].is_upright();
        let mut motions = body.motions.iter().rev();
        motions.try_for_each(|motion| motion.check_plane(body, upright))?;
    }
    Ok(())
}

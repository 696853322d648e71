//! A schedule on a mesh: steps, axes, bodies, and the role of every surface node.

use super::body::Body;
use super::driven::{BladeSurface, Clock, Driven};
use super::rotor::RotorAxes;
use super::schedule::Schedule;
use super::steps::{Step, neighbours};
use super::surface::{Role, Surface, nodes_of_tags};
use super::tags::{PeriodicTags, TagRoles};
use super::zones::DeformingZone;
use crate::error::{Error, Result};
use crate::geometry::Bounds;
use crate::mesh::{Group, Mesh};

/// Extent in z, relative to the diagonal, above which a mesh of 2D cells is not plane.
const PLANE: f64 = 1e-6;

/// A schedule on a mesh.
#[derive(Debug, Clone)]
pub struct Motion {
    /// The steps, at least one.
    pub steps: Vec<Step>,
    /// The rotor's axes.
    pub rotor: RotorAxes,
    /// The moving bodies, in the order of the schedule.
    pub bodies: Vec<Body>,
    /// The surface nodes with their roles, and the faces between them.
    pub surface: Surface,
    /// The periodic pairs, in the order of the schedule.
    pub periodic: Vec<PeriodicTags>,
    /// The part of the mesh that deforms; the whole mesh when `None`.
    pub zone: Option<DeformingZone>,
    /// By how much the azimuth grows, in radians a second, where the schedule says.
    pub azimuth_rate: Option<f64>,
    /// What the bodies' motions have from files, in the order of the bodies.
    pub(super) driven: Vec<Driven>,
    /// For each step those next to it in time.
    pub(super) neighbours: Vec<[u32; 2]>,
}

impl Motion {
    pub(super) fn new(schedule: &Schedule, mesh: &Mesh) -> Result<Self> {
        let dimension = mesh.dimension();
        if dimension < 2 {
            return Err(Error::input(
                "the mesh has no cells of two or three dimensions; there is nothing to deform",
            ));
        }
        if dimension == 2 {
            check_plane(mesh, &schedule.bodies)?;
        }
        let rotor = schedule.rotor.axes(dimension)?;
        let zone = DeformingZone::find(&schedule.boundaries.zones, mesh)?;
        let tags: Vec<&Group> = mesh.boundary_tags().collect();
        let named = TagRoles::find(
            &tags,
            &schedule.bodies,
            &schedule.boundaries,
            zone.as_ref(),
            mesh,
        )?;
        let surface = Surface::find(&tags, named.tags, zone.as_ref(), mesh);
        let neighbours = neighbours(&schedule.steps);
        let driven = read_driven(schedule, &neighbours, &rotor, &surface, mesh)?;
        Ok(Self {
            driven,
            neighbours,
            steps: schedule.steps.clone(),
            rotor,
            bodies: schedule.bodies.clone(),
            surface,
            periodic: named.periodic,
            zone,
            azimuth_rate: schedule.azimuth_rate,
        })
    }

    /// What the user should know of the files of the motions, as sentences.
    pub fn notes(&self) -> Vec<String> {
        self.driven
            .iter()
            .flat_map(Driven::notes)
            .cloned()
            .collect()
    }

    /// The nodes of both sides of a periodic pair, ascending; with zones, those in the zones.
    pub fn periodic_nodes(&self, pair: &PeriodicTags, mesh: &Mesh) -> [Vec<u32>; 2] {
        [&pair.a, &pair.b].map(|tags| nodes_of_tags(tags, self.zone.as_ref(), mesh))
    }
}

/// Reads the files that the bodies' motions name.
fn read_driven(
    schedule: &Schedule,
    neighbours: &[[u32; 2]],
    rotor: &RotorAxes,
    surface: &Surface,
    mesh: &Mesh,
) -> Result<Vec<Driven>> {
    let clock = Clock {
        steps: &schedule.steps,
        azimuth_rate: schedule.azimuth_rate,
        neighbours,
    };
    let in_plane = mesh.dimension() == 2;
    let read = |(body, index): (&Body, u16)| {
        let faces = BladeSurface {
            mesh,
            faces: &surface.faces,
            nodes: &surface.nodes,
            role: Role::Moving(index),
            blade: &rotor.blade(body.azimuth_offset),
        };
        Driven::read(body, &schedule.path, &clock, in_plane, &faces)
    };
    let driven: Vec<Driven> = (schedule.bodies.iter().zip(0..).map(read)).collect::<Result<_>>()?;
    for body in &schedule.bodies {
        if let Some(parent) = body
            .parent
            .filter(|&parent| driven[parent].has_displacements())
        {
            return Err(Error::input(format!(
                "body \"{}\" cannot move with \"{}\", whose `surface` or `modes` are known at its own nodes alone; \
                 give the child a motion of its own",
                body.name, schedule.bodies[parent].name
            ))
            .line(body.line));
        }
    }
    Ok(driven)
}

/// Refuses what would leave the plane of a 2D mesh.
fn check_plane(mesh: &Mesh, bodies: &[Body]) -> Result<()> {
    let bounds = Bounds::around(&mesh.points);
    let [low, high] = [bounds.low[2], bounds.high[2]];
    if high - low > PLANE * bounds.diagonal() {
        return Err(Error::input(format!(
            "the mesh has 2D cells only, but z runs from {low} to {high}; a 2D mesh must lie in a plane of constant z"
        )));
    }
    for body in bodies {
        if let Some(line) = body.cyclic.as_ref().and_then(|cyclic| cyclic.out_of_plane) {
            return Err(Error::input(format!(
                "body \"{}\" flaps or lags, which needs a 3D mesh; in 2D a cyclic motion is pitch alone",
                body.name
            ))
            .line(line));
        }
        if let Some(line) = body.rigid.as_ref().and_then(|rigid| rigid.out_of_plane) {
            return Err(Error::input(format!(
                "body \"{}\" leaves the plane of the 2D mesh; turn it about [0, 0, 1] and translate it in x and y",
                body.name
            ))
            .line(line));
        }
    }
    Ok(())
}

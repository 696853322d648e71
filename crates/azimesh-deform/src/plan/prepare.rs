//! Builds a [`Plan`]: resolves the schedule on the mesh, finds the interpolated layers, and chooses the values that the
//! schedule does not give.

use super::checks::{
    check_combination, check_constant, check_finite, check_one_layer, check_radii, check_size,
    repeated_time, unused,
};
use super::first_cells::FirstCells;
use super::layer::{self, Layer, Method};
use super::periodic::PeriodicNodes;
use super::sections;
use super::surface::SurfacePoints;
use super::zone::Cuts;
use super::{Plan, SELECTED};
use crate::fields::velocity;
use crate::motion::{
    DeformingZone, Interpolate, KernelName, Motion, Polynomial, Role, Schedule, SurfaceFaces,
};
use crate::part::Part;
use azimesh_core::error::{Error, Result, option};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::numbers::{in_digits, short};
use azimesh_core::{Note, note};
use azimesh_io::formats::{openfoam, su2};
use azimesh_io::mesh::{Boundary, CellSet, Mesh, OneLayer, ZoneSides, faces_on_no_cell};
use azimesh_quality::remarks;
use azimesh_rbf::modes::{Form, RigidSurface};
use azimesh_rbf::space::Space;
use azimesh_rbf::{Basis, Kernel};
use std::sync::Arc;

/// Default tolerance, in diagonals of the moving bodies.
const DEFAULT_TOLERANCE: f64 = 1e-4;
/// Largest default of the support radius, in diagonals of the moving surfaces.
const DEFAULT_RADIUS: f64 = 10.0;
/// Allowed error of the modes, as a part of the tolerance and of the smallest first cell.
const TRUNCATION: f64 = 0.01;
/// A body that moves by this many diagonals of the mesh is certainly outside of it.
const FAR: f64 = 100.0;

impl Plan {
    /// Resolves a schedule on a mesh and finds its modes. Also returns the mesh of this rank, with the interface nodes of
    /// turning zones duplicated. An error without a file is about the mesh. All ranks that share the mesh call it.
    pub fn new(mesh: impl Into<Arc<Mesh>>, mut schedule: Schedule) -> Result<(Self, Part)> {
        let mut mesh = mesh.into();
        let without_boxes = has_boxes(&mesh) && leave_out_boxes(Arc::make_mut(&mut mesh));
        let mut boundary = Boundary::of(&mesh);
        check_size(&boundary)?;
        let format = chosen_format(&mut schedule, &mesh);
        let sides_of = |cells: &CellSet| Ok(ZoneSides::of(&mesh, cells));
        // Ranks may see different files.
        let motion = schedule.resolve(&boundary, &sides_of);
        let mut motion = mesh.ranks().all_ok(motion)?;
        let cuts = Cuts::make(&mut mesh, &mut boundary, &mut motion)?;
        let is_turning = motion.parts.is_empty();
        let joined = cuts.is_joined.then(|| interface(&cuts.tags, is_turning));
        if let Some(zone) = &motion.zone {
            let sides = &zone.sides;
            boundary.add_nodes(&sides.interface_nodes, &sides.interface_places);
        }
        let in_schedule = |error: Error| error.file(&schedule.path);
        let interface = motion.zone.as_ref().map(|zone| &zone.sides.interface_faces);
        let mut surface =
            SurfacePoints::new(&boundary, &motion.surface, interface).map_err(in_schedule)?;
        check_finite(&motion, surface.rigid()).map_err(in_schedule)?;
        let mut choices = motion.notes();
        choices.extend(schedule.note());
        choices.extend(schedule.unmatched(&motion.surface.tags));
        choices.extend(remarks(&mesh));
        choices.extend(format);
        choices.extend(joined);
        // The facets between the surface points replace them.
        let faces = std::mem::take(&mut motion.surface.faces);
        let first_cells = FirstCells::find(&mesh, &motion);
        let moving = moving_bounds(&surface, &boundary);
        let basis = basis(&schedule, &boundary, &motion, &moving, &mut choices);
        check_radii(&schedule, &boundary).map_err(in_schedule)?;
        let smallest = first_cells.smallest();
        let tolerance = tolerance(&schedule, &moving, smallest, &mut choices)?;
        check_constant(&schedule, tolerance).map_err(in_schedule)?;
        if motion.parts.len() == motion.bodies.len() {
            // Nothing deforms.
            choices.retain(|note| !["support_radius", "tolerance"].contains(&&*note.code));
        }
        choices.extend(unused(&schedule));
        choices.extend(repeated_time(&motion.steps));
        let periodic = PeriodicNodes::find(&mesh, &boundary, &motion, &surface, basis.radius)
            .map_err(in_schedule)?;
        surface.set_images(&motion.surface.nodes, periodic.of_surface());
        choices.extend(periodic.found.iter().cloned());
        check_combination(&schedule, &motion, &surface, &periodic).map_err(in_schedule)?;
        let one_layer = OneLayer::find(&mesh)?;
        check_one_layer(one_layer.as_ref(), &mesh, &motion).map_err(in_schedule)?;
        let truncation = TRUNCATION * tolerance.min(smallest.unwrap_or(f64::INFINITY));
        let method = method(&schedule, &surface, &periodic, basis, tolerance, truncation);
        let moving_faces = moving_faces(&faces);
        let region = region(boundary.extent, &motion, one_layer.as_ref(), &mesh);
        let mut plan = Self {
            centres: centres(&motion, surface.rigid()),
            layers: Vec::new(),
            velocity: None,
            rigid_points: rigid_points(&motion, &boundary),
            points_hash: Part::points_hash(&mesh),
            seams: cuts.seams,
            boundary,
            without_boxes,
            schedule,
            motion,
            surface,
            smallest_first_cell: smallest,
            first_cell_change_in_f32: first_cells.change_in_f32(),
            loose_faces: faces_on_no_cell(&mesh, &moving_faces),
            moving_faces,
            region,
            basis,
            method,
            one_layer,
            periodic,
            tolerance,
            choices,
        };
        let path = plan.schedule.path.clone();
        plan.find_layers().map_err(|error| error.file(&path))?;
        let part = Part::new(&plan, mesh, first_cells, cuts.doubled);
        Ok((plan, part))
    }

    /// Finds the interpolated fields, over all steps.
    pub(super) fn find_layers(&mut self) -> Result<()> {
        let twist = self.schedule.rbf.interpolate == Interpolate::Twist;
        self.layers = if twist && !self.modes_are_exact() {
            sections::layers(self, &self.method)?
        } else {
            layer::layers(
                self.surface.rigid(),
                &self.surface_displacements(),
                &self.method,
            )?
        };
        self.check_truncation()?;
        for (body, ring) in self.layers.iter().flat_map(Layer::rings) {
            let note = note!(
                "turns_in_ring",
                "body \"{}\" turns about one axis with no other surface between the radii {} and {}: its rotation falls with \
                 the logarithm of the radius",
                self.motion.bodies[body].name,
                in_digits(ring.inner, 3),
                in_digits(ring.outer, 3)
            );
            self.choices.push(note);
        }
        if self.schedule.output.velocity {
            self.velocity = Some(velocity::layer(self)?);
        }
        Ok(())
    }

    fn check_truncation(&self) -> Result<()> {
        if self.truncation() <= self.method.truncation {
            return Ok(());
        }
        let cell = self.smallest_first_cell.unwrap_or(f64::INFINITY);
        Err(Error::input(format!(
            "the modes reproduce the motion only to {:.1e}, which is more than 1% of the tolerance {:.1e} \
             or of the smallest first cell {cell:.1e}; {}",
            self.truncation(),
            self.tolerance,
            self.better_modes(cell)
        ))
        .file(&self.schedule.path))
    }

    /// Returns the remedy for modes that are too coarse: the motion, the position of the mesh or the tolerance may be wrong.
    fn better_modes(&self, cell: f64) -> String {
        let bounds = self.boundary.extent;
        let diagonal = bounds.diagonal();
        let steps = 0..self.motion.steps.len();
        let largest = steps.map(|step| self.largest_displacement(step));
        let largest = largest.fold(0.0, f64::max);
        if largest > FAR * diagonal {
            return format!(
                "the motion moves bodies by {}, and the mesh is {} across: give the motion in mesh units",
                in_digits(largest, 3),
                in_digits(diagonal, 3)
            );
        }
        let away = distance(bounds.nearest(&[0.0; 3]), [0.0; 3]);
        if self.truncation() * diagonal <= self.method.truncation * away {
            return format!(
                "move the mesh near the origin, from which it is {} away",
                in_digits(away, 3)
            );
        }
        let moving = moving_bounds(&self.surface, &self.boundary);
        match default_tolerance(&self.schedule, &moving, self.smallest_first_cell) {
            Some(usual) if self.truncation() <= TRUNCATION * usual.min(cell) => format!(
                "double precision has no more digits: set a larger `tolerance`, or leave it out, and {} is chosen",
                short(usual)
            ),
            _ => "double precision has no more digits for first cells of that height; make them higher".to_owned(),
        }
    }
}

/// Returns whether a mesh has boxes for free-form deformation.
pub(crate) fn has_boxes(mesh: &Mesh) -> bool {
    mesh.field_arrays.iter().any(|a| a.name == su2::BOXES)
}

/// Removes boxes for free-form deformation, which only fit the mesh at rest; returns whether there were any.
pub(crate) fn leave_out_boxes(mesh: &mut Mesh) -> bool {
    !mesh.remove_field_arrays(&[su2::BOXES]).is_empty()
}

/// Sets the format of a case for the mesh of a case, if the schedule gives none; returns a note if it does.
fn chosen_format(schedule: &mut Schedule, mesh: &Mesh) -> Option<Note> {
    let output = &mut schedule.output;
    let format = openfoam::OPENFOAM.name;
    if output.format.is_some() || output.format() == format {
        return None;
    }
    let ranks = mesh.ranks();
    let is_case = ranks
        .is_first()
        .then(|| openfoam::hash_of_origin(mesh).is_some());
    if !ranks.broadcast(is_case) {
        return None;
    }
    output.format = Some(format.to_owned());
    Some(note!(
        "output_format",
        "output.format = \"{format}\" (chosen, since the mesh is of that format)"
    ))
}

/// Returns a note on the tags on both sides of the interface of zones that turn or move rigidly.
fn interface(tags: &[String], is_turning: bool) -> Note {
    let zones = if is_turning { "turning" } else { "moving" };
    if tags.is_empty() {
        return note!(
            "interface",
            "the interface of the {zones} zones has no tags, since their cells are curved (convert {} makes them linear)",
            option("linearize")
        );
    }
    note!(
        "interface",
        "the interface of the {zones} zones has the tags {}",
        tags.join(", ")
    )
}

/// Returns the box around the deforming nodes, in a mesh of this extent.
fn region(extent: Bounds, motion: &Motion, layer: Option<&OneLayer>, mesh: &Mesh) -> Bounds {
    let zone = motion.zone.as_ref();
    let Some(layer) = layer else {
        return zone.map_or(extent, |zone| bounds_of_zone(zone, extent));
    };
    let low = layer.pairs.iter().map(|[low, _]| *low);
    let inside = low.filter(|node| zone.is_none_or(|zone| zone.sides.nodes.has(*node)));
    Bounds::around(inside.map(|node| &mesh.points[node as usize]))
}

fn moving_faces(faces: &SurfaceFaces) -> Vec<u32> {
    let faces = faces.cells.iter().zip(&faces.roles);
    let moving = faces.filter(|(_, role)| matches!(role, Role::Moving(_)));
    moving.map(|(cell, _)| *cell).collect()
}

/// Returns the positions of the tagged nodes of rigid parts; of a part without tags the corners of its box.
fn rigid_points(motion: &Motion, boundary: &Boundary) -> Vec<(usize, Vector)> {
    let mut points = Vec::new();
    for part in &motion.parts {
        let role = Some(Role::Moving(part.body as u16));
        let tags = boundary.boundary_tags().zip(&motion.surface.tags);
        let own = tags.filter(|(_, tag)| tag.role == role);
        let mut nodes: Vec<u32> = own.flat_map(|(tag, _)| boundary.nodes_of(tag)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let Bounds { low, high } = part.sides.bounds;
        let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] });
        let corners = (0..8).filter(|_| nodes.is_empty()).map(corner);
        let places = nodes.iter().map(|&node| boundary.position(node));
        points.extend(places.chain(corners).map(|x| (part.body, x)));
    }
    points
}

/// Returns the centre of rotation of each body: on the body or near it.
fn centres(motion: &Motion, surface: RigidSurface<'_>) -> Vec<Vector> {
    (0..motion.bodies.len())
        .map(|body| motion.twist_centre(body, &layer::bounds_of_body(surface, body)))
        .collect()
}

fn method(
    schedule: &Schedule,
    surface: &SurfacePoints,
    periodic: &PeriodicNodes,
    basis: Basis,
    tolerance: f64,
    truncation: f64,
) -> Method {
    let radius = schedule.rbf.rotation_radius.unwrap_or(basis.radius);
    let linear = schedule.rbf.polynomial == Polynomial::Linear;
    Method {
        displacement: Space {
            linear,
            constraints: surface.constraints(surface.sliding.as_ref()),
            images: periodic.images.clone(),
            ..Space::radial(basis)
        },
        rotation: Space {
            linear,
            constraints: surface.rotation_constraints(),
            ..Space::radial(Basis { radius, ..basis })
        },
        form: if surface.sliding.is_none() && periodic.images.is_empty() {
            Form::Scalar
        } else {
            Form::Vector
        },
        tolerance: SELECTED * tolerance,
        truncation,
        rings: schedule.rbf.rotation_radius.is_none(),
    }
}

/// Returns the box around a zone; the `extent` of the mesh if it has no cells.
fn bounds_of_zone(zone: &DeformingZone, extent: Bounds) -> Bounds {
    if zone.cells.is_empty() {
        extent
    } else {
        zone.sides.bounds
    }
}

/// Returns the box around the moving surface; the box of the mesh if all bodies move zones.
fn moving_bounds(surface: &SurfacePoints, boundary: &Boundary) -> Bounds {
    let nodes = surface.points.iter().zip(&surface.body);
    let moving: Vec<Vector> = nodes
        .filter(|(_, body)| body.is_some())
        .map(|(point, _)| *point)
        .collect();
    if moving.is_empty() {
        return boundary.extent;
    }
    Bounds::around(&moving)
}

fn basis(
    schedule: &Schedule,
    boundary: &Boundary,
    motion: &Motion,
    moving: &Bounds,
    choices: &mut Vec<Note>,
) -> Basis {
    let radius = schedule.rbf.support_radius.unwrap_or_else(|| {
        let region = match &motion.zone {
            None => boundary.extent,
            Some(zone) => bounds_of_zone(zone, boundary.extent),
        };
        let radius = region.diagonal().min(DEFAULT_RADIUS * moving.diagonal());
        let note = note!(
            "support_radius",
            "support_radius = {} (chosen)",
            short(radius)
        );
        choices.push(note.with("radius", radius));
        radius
    });
    Basis {
        kernel: kernel(schedule.rbf.kernel),
        radius,
    }
}

/// Returns the kernel of a name.
pub(crate) fn kernel(name: KernelName) -> Kernel {
    match name {
        KernelName::WendlandC0 => Kernel::WendlandC0,
        KernelName::WendlandC2 => Kernel::WendlandC2,
        KernelName::WendlandC4 => Kernel::WendlandC4,
        KernelName::WendlandC6 => Kernel::WendlandC6,
    }
}

fn tolerance(
    schedule: &Schedule,
    moving: &Bounds,
    smallest_first_cell: Option<f64>,
    choices: &mut Vec<Note>,
) -> Result<f64> {
    if let Some(tolerance) = schedule.selection.tolerance {
        return Ok(tolerance);
    }
    let chosen = default_tolerance(schedule, moving, smallest_first_cell);
    let tolerance = chosen.ok_or_else(|| {
        Error::input(
            "no tolerance can be chosen for this mesh; set selection.tolerance, in mesh units",
        )
        .file(&schedule.path)
    })?;
    let note = note!(
        "tolerance",
        "selection.tolerance = {} (chosen)",
        short(tolerance)
    );
    choices.push(note.with("tolerance", tolerance));
    Ok(tolerance)
}

/// Returns the default tolerance; `None` if none can be chosen.
fn default_tolerance(
    schedule: &Schedule,
    moving: &Bounds,
    smallest_first_cell: Option<f64>,
) -> Option<f64> {
    let chosen = if schedule.selection.correction {
        Some(DEFAULT_TOLERANCE * moving.diagonal())
    } else {
        smallest_first_cell
    };
    chosen.filter(|tolerance| *tolerance > 0.0)
}

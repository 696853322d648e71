//! `[body.modes]`: mode shapes at the nodes of a body times generalised coordinates.

use super::clock::StepHistory;
use super::link::{Link, NodeField, NodeLink};
use super::nodes::{
    At as Given, BodyNodes, Filling, MISSING, Matching, NamedVectors, Wrong, arrays_of,
    place_columns, three, unused, vector,
};
use super::{At, BodyMotion, MapScope, OnMesh, ResolvedMotion, TableSource};
use crate::motion::body::Body;
use crate::motion::keys::{choice, keys, positive, string};
use crate::motion::setters::setters;
use crate::motion::table::{History, Interpolation, Table};
use azimesh_core::Note;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use std::path::Path;
use std::sync::Arc;

/// Content of these files, in messages.
const WHAT: &str = "shapes";

/// Displacements as a sum of mode shapes times generalised coordinates:
///
/// ```text
/// d(node, step) = sum over j of q_j(step) shape_j(node)
/// ```
///
/// Shapes are a table `node, mode, dx, dy, dz` (or `x, y, z` for `node`), modes counted from 1, or a mesh file
/// with a point array for each mode; coordinates a table of `azimuth_deg` (or another key), `q1`, `q2`, ...
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Body, Modes, Table};
///
/// // One mode from a file, which is read when the schedule is resolved on a mesh.
/// let coordinates = Table::from_rows(["time_s", "q1"], [[0.0, 0.0], [0.1, 0.02], [0.2, 0.0]]);
/// let wing = Body::new("wing", ["wing"]).modes(Modes::new("shapes.vtu", coordinates).cubic());
/// ```
#[derive(Debug, Clone)]
pub struct Modes {
    shapes: TableSource,
    coordinates: TableSource,
    interpolation: Interpolation,
    matching: Matching,
}

impl Modes {
    /// Creates a motion of shapes and coordinates, linear between rows; every node of the body needs its shapes.
    pub fn new(shapes: impl Into<TableSource>, coordinates: impl Into<TableSource>) -> Self {
        Self {
            shapes: shapes.into(),
            coordinates: coordinates.into(),
            interpolation: Interpolation::Linear,
            matching: Matching::default(),
        }
    }
}

setters! { Modes {
    /// Interpolates between rows with a cubic spline, which is periodic if the table is.
    cubic() |self| self.interpolation = Interpolation::Cubic;
    /// Sets the largest distance between a node and its position in the file, in mesh units; 1e-9 by default.
    match_tolerance(distance: f64) |self| self.matching.tolerance = distance;
    /// Keeps nodes that the file does not name at their positions.
    missing_fixed() |self| self.matching.missing_fixed = true;
} }

keys! { impl Modes "[body.modes]" = Self::new("", ""), {
    /// a table `node,mode,dx,dy,dz` (or `x,y,z` for `node`; nodes of the mesh counted from 0, modes from 1); or a mesh with point arrays whose names end in the number of the mode, as `mode1`, `mode2`
    shapes => shapes, string::<TableSource>(), needed "shapes = \"modes.csv\"";
    /// a table of `q1`, `q2`, ... over `azimuth_deg`, `time_s` or `step`
    coordinates => coordinates, string::<TableSource>(), needed "coordinates = \"q.csv\"";
    /// of the coordinates between rows
    interpolation => interpolation, choice::<Interpolation>(), default "linear";
    /// distance within which a position in the file matches a node
    match_tolerance => matching.tolerance, positive("length"), default 1e-9;
    /// nodes of the body that are not in the file stay; without this key they are an error
    missing => matching.missing_fixed, MISSING, or "none";
} }

impl BodyMotion for Modes {
    fn files(&self) -> Vec<&TableSource> {
        vec![&self.shapes, &self.coordinates]
    }

    fn check(&self, body: &Body) -> Result<()> {
        body.places
            .positive("modes.match_tolerance", self.matching.tolerance)
    }

    /// Reads shapes and coordinates; there must be coordinates at every step.
    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        let mesh_file = self.shapes.mesh_file();
        let mesh_file = mesh_file.map(|file| on.file(file, "modes")).transpose()?;
        let coordinates =
            read_coordinates(&*self.coordinates.read(on, "modes")?, self.interpolation)?;
        let n_modes = coordinates.n_values();
        let coordinates = StepHistory::new(coordinates, on, "modes")?;
        let ((shapes, others), path) = match mesh_file {
            Some(path) => (of_mesh(&path, self.matching, on, n_modes)?, path),
            None => {
                let table = self.shapes.read(on, "modes")?;
                let found = of_table(&table, self.matching, on, n_modes)?;
                (found, table.path().to_path_buf())
            }
        };
        let mut notes = unused(others, &path, &on.body.name);
        notes.extend(coordinates.note.clone());
        Ok(Arc::new(ModeShapes {
            shapes,
            coordinates,
            nodes: on.nodes(),
            notes,
        }))
    }
}

/// Shapes, and coordinates over azimuth, time or step.
#[derive(Debug)]
pub(super) struct ModeShapes {
    /// For every mode, the displacement of every node of the body at a coordinate of 1.
    pub shapes: Vec<Vec<Vector>>,
    pub coordinates: StepHistory,
    pub nodes: Arc<BodyNodes>,
    pub notes: Vec<Note>,
}

impl ResolvedMotion for ModeShapes {
    fn link(&self, at: &At<'_>) -> Option<Link<'_>> {
        let field = |factors| NodeField::shapes(&self.shapes, factors);
        let displacement = field(self.coordinates.values(at.step));
        Some(Link::Nodes(NodeLink {
            nodes: Arc::clone(&self.nodes),
            fields: vec![(
                displacement,
                at.rates.then(|| field(self.coordinates.rates(at))),
            )],
            part: at.part,
            growth: 0.0,
        }))
    }

    fn map_scope(&self) -> MapScope {
        MapScope::Nodes
    }

    fn notes(&self) -> &[Note] {
        &self.notes
    }
}

fn read_coordinates(table: &Table, interpolation: Interpolation) -> Result<History> {
    let mut columns = table.columns();
    let key = columns.require_key()?;
    let mut coordinates = vec![columns.require("q1")?];
    while let Some(next) = columns.optional(&format!("q{}", coordinates.len() + 1)) {
        coordinates.push(next);
    }
    columns.done()?;
    History::from_table(table, key, &coordinates, interpolation)
}

/// Shapes, and the number of rows for nodes of other bodies.
type Shapes = (Vec<Vec<Vector>>, usize);

/// Reads rows `node, mode, dx, dy, dz`; modes are counted from 1.
fn of_table(table: &Table, matching: Matching, on: &OnMesh<'_>, n_modes: usize) -> Result<Shapes> {
    let mut columns = table.columns();
    let place = place_columns(&mut columns, on.in_plane())?;
    let mode = columns.require("mode")?;
    let axes = three(&mut columns, ["dx", "dy", "dz"], on.in_plane())?;
    columns.done()?;
    let nodes = on.nodes();
    let mut filling = Filling::new(on, &nodes, (WHAT, matching), n_modes);
    let wrong = Wrong {
        at: &|row, message| table.error(row, message),
        twice: &|node, before, row| {
            format!(
                "node {node} of mode {} is given twice, first in line {}; keep one of the rows",
                table.value(row, mode),
                table.line(before)
            )
        },
    };
    for row in 0..table.n_rows() {
        let at_row = |message| table.error(row, message);
        let number = table.whole(row, mode)?;
        let mode = usize::try_from(number).unwrap_or(usize::MAX);
        if !(1..=n_modes).contains(&mode) {
            return Err(at_row(format!(
                "column `mode` has {number}; the table of coordinates has q1 to q{n_modes}, so it must be from \
                 1 to {n_modes}"
            )));
        }
        let found = filling.find(place.at(table, row)?).map_err(at_row)?;
        filling.put(
            (mode - 1, row),
            &found,
            |_| vector(table, row, axes),
            &wrong,
        )?;
    }
    let which = |mode| format!(" of mode {}", mode + 1);
    filling.finish(which, |_, row, message| table.error_at(row, message))
}

/// Reads the point arrays of a mesh whose names end in the number of the mode.
fn of_mesh(path: &Path, matching: Matching, on: &OnMesh<'_>, n_modes: usize) -> Result<Shapes> {
    let (mesh, arrays) = arrays_of(path)?;
    let modes = (1..=n_modes).map(|mode| array_of(mode, &arrays));
    let modes: Vec<&NamedVectors> = modes
        .collect::<std::result::Result<_, String>>()
        .map_err(|message| Error::input(message).file(path))?;
    let nodes = on.nodes();
    let mut filling = Filling::new(on, &nodes, (WHAT, matching), n_modes);
    let places = (mesh.points.iter()).map(|x| filling.find(Given::Place(*x)).unwrap_or_default());
    let places: Vec<Vec<usize>> = places.collect();
    let wrong = |mode: usize, message| Error::input(message).dataset(&modes[mode].0).file(path);
    for (mode, (_, values)) in modes.iter().enumerate() {
        let wrong = Wrong {
            at: &|_, message| wrong(mode, message),
            twice: &|node, before, row| {
                let mode = mode + 1;
                format!(
                    "points {before} and {row} are both at node {node} and differ in mode {mode}"
                )
            },
        };
        for (row, (found, value)) in places.iter().zip(values).enumerate() {
            filling.put((mode, row), found, |_| *value, &wrong)?;
        }
    }
    let which = |mode| format!(" of mode {}", mode + 1);
    filling.finish(which, |mode, _, message| wrong(mode, message))
}

/// Finds the array whose name ends in the number of a mode.
fn array_of(mode: usize, arrays: &[NamedVectors]) -> std::result::Result<&NamedVectors, String> {
    let number = |name: &str| {
        let digits = name.len() - name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        name[name.len() - digits..].parse::<usize>().ok()
    };
    let mut of_mode = arrays.iter().filter(|(name, _)| number(name) == Some(mode));
    match (of_mode.next(), of_mode.next()) {
        (Some(array), None) => Ok(array),
        _ => {
            let names: Vec<&str> = arrays.iter().map(|(name, _)| name.as_str()).collect();
            Err(format!(
                "mode {mode} needs one point array of 3 components whose name ends in {mode}, as in mode{mode}; found: {}",
                names.join(", ")
            ))
        }
    }
}

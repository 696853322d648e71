//! `[body.surface]`: displacements of the nodes of a body from another program: a table, a mesh with an array, or
//! SU2's surface positions.

use super::naming::{self, NamedColumns};
use super::nodes::{
    At as Given, Filling, MISSING, Matching, NamedVectors, PlaceColumns, Wrong, arrays_of,
    place_columns, three, unused, vector,
};
use super::sets::NodeSets;
use super::surface_map::{GivenPoints, MapMethod};
use super::{BodyMotion, OnMesh, ResolvedMotion, TableSource, step_files};
use crate::motion::body::Body;
use crate::motion::keys::{choice, keys, positive, string};
use crate::motion::setters::setters;
use crate::motion::table::{Column, ColumnNames, Interpolation, Key, Naming, Table, Unit};
use azimesh_core::Note;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, sub};
use azimesh_io::formats::Source;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Name of an array of displacements, in lower case.
const DISPLACEMENT: &str = "displacement";
/// Content of these files, in messages.
const WHAT: &str = "displacements";

/// Displacements or new positions of the nodes of a body from another program, the same at every step or one set
/// for each. The source is one of:
///
/// - a table `node, dx, dy, dz` (or `x, y, z` for `node`, or `x_new, y_new, z_new`), with a column `azimuth_deg`,
///   `azimuth_rad`, `time_s` or `step` if there are several sets;
/// - a mesh file with a point array;
/// - SU2's surface positions (`.dat`);
/// - a file for each step, with its number for the `*` in `surface_*.dat`.
///
/// Lengths are in mesh units.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Body, SurfaceMotion};
///
/// let moved = SurfaceMotion::new("surface_00010.dat").missing_fixed();
/// let wing = Body::new("wing", ["wing"]).surface(moved);
/// ```
#[derive(Debug, Clone)]
pub struct SurfaceMotion {
    source: TableSource,
    matching: Matching,
    map: Option<MapMethod>,
    interpolation: Option<Interpolation>,
    naming: Naming,
}

impl SurfaceMotion {
    /// Creates a motion from a file or a table; every node of the body needs a displacement.
    pub fn new(source: impl Into<TableSource>) -> Self {
        Self {
            source: source.into(),
            matching: Matching::default(),
            map: None,
            interpolation: None,
            naming: Naming::default(),
        }
    }
}

setters! { SurfaceMotion {
    /// Sets the largest distance between a node and its position in the file, in mesh units; 1e-9 by default.
    match_tolerance(distance: f64) |self| self.matching.tolerance = distance;
    /// Keeps nodes that the file does not name at their positions.
    missing_fixed() |self| self.matching.missing_fixed = true;
    /// Transfers displacements to the body from points that are not its nodes.
    map(method: MapMethod) |self| self.map = Some(method);
    /// Maps a column's name here to its name in a table: `column("dx", "DisplacementX")`. Columns of other names are ignored.
    column(name: impl Into<String>, in_file: impl Into<String>) |self| self.naming.columns.insert(name.into(), in_file.into());
    /// Sets the unit of a column of a table, by its name here: `unit("dx", "mm")`, or a factor.
    unit(name: impl Into<String>, unit: impl Into<Unit>) |self| self.naming.units.insert(name.into(), unit.into());
    /// Interpolates linearly between the sets of a table; otherwise every step needs its own set.
    linear() |self| self.interpolation = Some(Interpolation::Linear);
    /// Interpolates between the sets of a table with a cubic spline, which is periodic if the sets are.
    cubic() |self| self.interpolation = Some(Interpolation::Cubic);
} }

keys! { impl SurfaceMotion "[body.surface]" = Self::new(""), {
    /// relative to the schedule; a table (`.csv`), SU2's surface positions (`.dat`), or a mesh, by its ending. With a `*` in the name: a file for every step, whose number stands for it
    file => source, string::<TableSource>(), needed "file = \"surface.csv\"";
    /// distance within which a position in the file matches a node
    match_tolerance => matching.tolerance, positive("length"), default 1e-9;
    /// nodes of the body that are not in the file stay; without this key they are an error
    missing => matching.missing_fixed, MISSING, or "none";
    /// the points of the file are not nodes of the body; their displacements are [carried to its nodes](#displacements-at-points-that-are-not-nodes)
    map => map, choice::<MapMethod>(), or "none";
    /// interpolation between the sets of a table, by azimuth, time or step; without this key every step needs its own set
    interpolation => interpolation, choice::<Interpolation>(), or "none";
    /// [names in a table](#names-and-units-of-columns)
    columns => naming.columns, naming::columns::<Self>(), or "none";
    /// [units in a table](#names-and-units-of-columns)
    units => naming.units, naming::units::<Self>(), or "none";
} }

impl NamedColumns for SurfaceMotion {
    const COLUMNS: &'static str =
        "azimuth_deg azimuth_rad time_s step node x y z dx dy dz x_new y_new z_new";
}

impl BodyMotion for SurfaceMotion {
    fn files(&self) -> Vec<&TableSource> {
        vec![&self.source]
    }

    fn check(&self, body: &Body) -> Result<()> {
        naming::check::<Self>(&self.naming, body, "surface")?;
        body.places
            .positive("surface.match_tolerance", self.matching.tolerance)
    }

    /// Reads the file; there must be a set for every step.
    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        let file = self.source.file();
        let pattern = file.filter(|file| step_files::is_pattern(&on.folder, file));
        let (mut sets, path) = match pattern {
            Some(pattern) => self.of_series(pattern, on)?,
            None => self.of_source(&self.source, on)?,
        };
        if let Some(interpolation) = self.interpolation {
            return sets.interpolated(interpolation, on, &path);
        }
        sets.check(on, &path)?;
        Ok(Arc::new(sets))
    }
}

/// Returns whether a file has SU2's surface positions.
fn is_positions(path: &Path) -> bool {
    let kind = path.extension().map(|kind| kind.to_ascii_lowercase());
    kind.is_some_and(|kind| kind == "dat" || kind == "txt")
}

impl SurfaceMotion {
    /// Reads the sets of one file or table; also returns its path.
    fn of_source(&self, source: &TableSource, on: &OnMesh<'_>) -> Result<(NodeSets, PathBuf)> {
        let file = source.mesh_file();
        let path = file.map(|file| on.file(file, "surface")).transpose()?;
        let Some(path) = path else {
            let table = source.read(on, "surface")?;
            return Ok((self.of_table(&table, on)?, table.path().to_path_buf()));
        };
        for (key, is_empty) in [
            ("columns", self.naming.columns.is_empty()),
            ("units", self.naming.units.is_empty()),
        ] {
            if !is_empty {
                let message = format!(
                    "`{key}` is for tables (.csv); {} is none: leave it out",
                    path.display()
                );
                return Err(on.error(&format!("surface.{key}"), message));
            }
        }
        let sets = match is_positions(&path) {
            true => self.of_positions(&path, on)?,
            false => self.of_mesh(&path, on)?,
        };
        Ok((sets, path))
    }

    /// Reads the sets of a file for each step; also returns the path of the last file.
    fn of_series(&self, pattern: &str, on: &OnMesh<'_>) -> Result<(NodeSets, PathBuf)> {
        let files = step_files::files(&on.folder, pattern);
        let files = files.map_err(|message| on.error("surface.file", message))?;
        let steps = on.clock.steps.iter().map(|step| step.index as u64);
        let mut missing = steps.filter(|step| !files.iter().any(|(number, _)| number == step));
        if let Some(step) = missing.next().filter(|_| self.interpolation.is_none()) {
            let message = format!(
                "no file {pattern} has the number {step}; every step needs the file of its number, the first that of 0, or \
                 `interpolation`"
            );
            return Err(on.error("surface.file", message));
        }
        let (mut sets, mut notes, mut last) = (Vec::new(), Vec::new(), PathBuf::new());
        for (_, file) in &files {
            let (of_file, path) = self.of_source(&TableSource::File(file.clone()), on)?;
            let (set, of_file) = of_file.single().ok_or_else(|| {
                let message =
                    "a file of one step has no column of azimuth, time or step; leave it out";
                Error::input(message).line(1).file(&path)
            })?;
            sets.push(set);
            if notes.is_empty() {
                notes = of_file;
            }
            last = path;
        }
        let places = files.iter().map(|(number, _)| *number as f64).collect();
        let lines = vec![1; files.len()];
        Ok((
            NodeSets::at_places((Key::Step, places), sets, lines, notes, on),
            last,
        ))
    }

    fn of_table(&self, table: &Table, on: &OnMesh<'_>) -> Result<NodeSets> {
        let naming = self.naming.with_units_of(table, &Self::names())?;
        let names = naming::resolve(&naming, on, None, "surface")?;
        let (rows, others) = Rows::of(table, names.clone(), on.in_plane())?;
        let told = naming::notes(&naming, &names, &others, table, &on.body.name);
        let (places, key) = (&rows.places, rows.key.map(|(key, _)| key));
        let which = |set: usize| {
            key.map_or(String::new(), |key| {
                format!(" at {}", key.place(places[set]))
            })
        };
        if let Some(method) = self.map {
            let given = GivenPoints::of_rows(&rows, which)?;
            let (sets, notes) = given.carry(method, table.path(), on)?;
            return Ok(rows.sets(sets, [told, notes].concat(), on));
        }
        let nodes = on.nodes();
        let mut filling = Filling::new(on, &nodes, (WHAT, self.matching), places.len());
        let wrong = Wrong {
            at: &|row, message| table.error(row, message),
            twice: &|node, before, _| {
                let line = table.line(before);
                format!("node {node} is given twice, first in line {line}; keep one of the rows")
            },
        };
        for row in 0..table.n_rows() {
            let found = filling.find(rows.place.at(table, row)?);
            let found = found.map_err(|message| table.error(row, message))?;
            let value = |x: Vector| rows.displacement(row, x);
            filling.put((rows.set_of(row), row), &found, value, &wrong)?;
        }
        let (sets, others) =
            filling.finish(which, |_, row, message| table.error_at(row, message))?;
        let notes = unused(others, table.path(), &on.body.name);
        Ok(rows.sets(sets, [told, notes].concat(), on))
    }

    /// Reads SU2's surface positions: a line `node x y z` for each node, with its new position.
    fn of_positions(&self, path: &Path, on: &OnMesh<'_>) -> Result<NodeSets> {
        if self.map.is_some() {
            let message = "surface positions name nodes of the mesh, which a `map` has no use for; leave it out, or give a table \
                           with the columns x, y, z";
            return Err(on.error("surface.map", message));
        }
        let source = Source::open(path)?;
        let nodes = on.nodes();
        let mut filling = Filling::new(on, &nodes, (WHAT, self.matching), 1);
        let at_line =
            |line: usize, message: String| Error::input(message).line(line as u64 + 1).file(path);
        let wrong = Wrong {
            at: &at_line,
            twice: &|node, before, _| {
                format!("node {node} is given twice, first in line {}", before + 1)
            },
        };
        for (line, text) in source.bytes().split(|b| *b == b'\n').enumerate() {
            let text = String::from_utf8_lossy(text);
            let words: Vec<&str> = text.split_whitespace().collect();
            let first = words.first();
            if first.is_none_or(|word| word.starts_with(['%', '#'])) {
                continue;
            }
            let place = new_place(&words, on.in_plane()).ok_or_else(|| {
                let found: String = text.trim().chars().take(40).collect();
                let message = format!(
                    "found \"{}\"; a line of surface positions is a node and its new place: node x y z",
                    found.escape_debug()
                );
                at_line(line, message)
            });
            let (node, place) = place?;
            let found = filling.find(Given::Node(node));
            let found = found.map_err(|message| at_line(line, message))?;
            let value = |x: Vector| match sub(place, x) {
                [x, y, _] if words.len() == 3 => [x, y, 0.0],
                value => value,
            };
            filling.put((0, line), &found, value, &wrong)?;
        }
        let whole = |_, line: Option<usize>, message| at_line(line.unwrap_or(0), message);
        let (sets, others) = filling.finish(|_| String::new(), whole)?;
        Ok(NodeSets::one(sets, unused(others, path, &on.body.name), on))
    }

    /// Reads the displacement array of a mesh, whose nodes are matched by position.
    fn of_mesh(&self, path: &Path, on: &OnMesh<'_>) -> Result<NodeSets> {
        let (mesh, arrays) = arrays_of(path)?;
        let found = displacements(&arrays);
        let (name, values) = found.map_err(|message| Error::input(message).file(path))?;
        if let Some(method) = self.map {
            let given = GivenPoints::of_mesh(&mesh, values, method, on.in_plane());
            let (sets, notes) = given.carry(method, path, on)?;
            return Ok(NodeSets::one(sets, notes, on));
        }
        let nodes = on.nodes();
        let mut filling = Filling::new(on, &nodes, (WHAT, self.matching), 1);
        let whole = |message| Error::input(message).dataset(name).file(path);
        let wrong = Wrong {
            at: &|_, message| whole(message),
            twice: &|node, before, row| {
                format!(
                    "points {before} and {row} are both at node {node} and have different displacements"
                )
            },
        };
        for (row, (place, value)) in mesh.points.iter().zip(values).enumerate() {
            let found = filling.find(Given::Place(*place)).map_err(whole)?;
            filling.put((0, row), &found, |_| *value, &wrong)?;
        }
        let (sets, others) = filling.finish(|_| String::new(), |_, _, message| whole(message))?;
        Ok(NodeSets::one(sets, unused(others, path, &on.body.name), on))
    }
}

/// The rows of a table of displacements.
pub(super) struct Rows<'a> {
    pub table: &'a Table,
    pub key: Option<(Key, Column)>,
    pub place: PlaceColumns,
    /// Displacements, or new positions.
    axes: [Option<Column>; 3],
    is_new: bool,
    /// Positions of the sets, increasing; a single 0 without a key.
    pub places: Vec<f64>,
}

impl<'a> Rows<'a> {
    /// The rows, and columns that are passed over.
    fn of(table: &'a Table, names: ColumnNames, in_plane: bool) -> Result<(Self, Vec<String>)> {
        let mut columns = table.columns_as(names)?;
        let key = columns.optional_key()?;
        let place = place_columns(&mut columns, in_plane)?;
        let is_new = columns.has("x_new");
        let names = if is_new {
            ["x_new", "y_new", "z_new"]
        } else {
            ["dx", "dy", "dz"]
        };
        let axes = three(&mut columns, names, in_plane)?;
        let others = columns.done()?;
        let mut rows = Self {
            table,
            key,
            place,
            axes,
            is_new,
            places: Vec::new(),
        };
        rows.places = (0..table.n_rows()).map(|row| rows.at(row)).collect();
        rows.places.sort_by(f64::total_cmp);
        rows.places.dedup();
        Ok((rows, others))
    }

    fn at(&self, row: usize) -> f64 {
        self.key
            .map_or(0.0, |(_, column)| self.table.value(row, column))
    }

    /// Returns the set of a row.
    pub fn set_of(&self, row: usize) -> usize {
        let at = self.at(row);
        self.places.partition_point(|place| *place < at)
    }

    /// Returns the displacement in a row of the node at `x`.
    pub fn displacement(&self, row: usize, x: Vector) -> Vector {
        if !self.is_new {
            return vector(self.table, row, self.axes);
        }
        std::array::from_fn(|i| self.axes[i].map_or(0.0, |axis| self.table.value(row, axis) - x[i]))
    }

    /// Returns sets of displacements of the nodes of a body, one for each position of the key.
    fn sets(&self, sets: Vec<Vec<Vector>>, notes: Vec<Note>, on: &OnMesh<'_>) -> NodeSets {
        let Some((key, _)) = self.key else {
            return NodeSets::one(sets, notes, on);
        };
        let mut lines = vec![0; sets.len()];
        for row in 0..self.table.n_rows() {
            lines[self.set_of(row)] = self.table.line(row);
        }
        NodeSets::at_places((key, self.places.clone()), sets, lines, notes, on)
    }
}

/// Parses a node and its new position; in the plane z may be missing.
fn new_place(words: &[&str], in_plane: bool) -> Option<(u64, Vector)> {
    let number = |word: &&str| word.parse().ok().filter(|x: &f64| x.is_finite());
    let numbers: Vec<f64> = words.iter().map(number).collect::<Option<_>>()?;
    let node = words[0].parse().ok()?;
    match numbers[..] {
        [_, x, y] if in_plane => Some((node, [x, y, 0.0])),
        [_, x, y, z] => Some((node, [x, y, z])),
        _ => None,
    }
}

/// Finds the displacements among the vectors of a mesh: the only vectors, the vectors of this name, or the only
/// ones with it in their name.
fn displacements(arrays: &[NamedVectors]) -> std::result::Result<&NamedVectors, String> {
    let names: Vec<&str> = arrays.iter().map(|(name, _)| name.as_str()).collect();
    let is_named = |name: &str| name.eq_ignore_ascii_case(DISPLACEMENT);
    let has_it = |name: &str| name.to_ascii_lowercase().contains(DISPLACEMENT);
    let among = |meant: &dyn Fn(&str) -> bool| -> Vec<&NamedVectors> {
        let arrays = arrays.iter();
        arrays.filter(|(name, _)| meant(name)).collect()
    };
    let found = [among(&|_| true), among(&is_named), among(&has_it)];
    if let Some([one]) = found.iter().map(Vec::as_slice).find(|some| some.len() == 1) {
        return Ok(one);
    }
    Err(match arrays {
        [] => "the mesh has no point array of 3 components with the displacements".to_owned(),
        _ => format!(
            "several of its arrays could be the displacements: {}; name one of them `Displacement`",
            names.join(", ")
        ),
    })
}

//! `[body.surface]`: displacements of the nodes of a body as another program gives them: a table, a mesh with
//! an array, or SU2's surface positions.

use super::nodes::{
    At as Given, Filling, MISSING, Matching, NamedVectors, Wrong, arrays_of, place_columns, three,
    unused, vector,
};
use super::sets::NodeSets;
use super::{BodyMotion, OnMesh, ResolvedMotion, TableSource};
use crate::motion::body::Body;
use crate::motion::keys::{keys, positive, string};
use crate::motion::setters::setters;
use crate::motion::table::Table;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, sub};
use azimesh_io::formats::Source;
use std::path::Path;
use std::sync::Arc;

/// The name of an array of displacements, in small letters.
const DISPLACEMENT: &str = "displacement";
/// What these files have.
const WHAT: &str = "displacements";

/// Displacements or new positions of the nodes of a body from another program, the same at every step or one
/// set for each: a table `node, dx, dy, dz` (or `x, y, z` for `node`, or `x_new, y_new, z_new`), with a column
/// `azimuth_deg`, `azimuth_rad`, `time_s` or `step` where there is a set for each; a mesh file with a point
/// array; SU2's surface positions (`.dat`). Lengths are in mesh units.
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
}

impl SurfaceMotion {
    /// The displacements of a file or a table; every node of the body needs one.
    pub fn new(source: impl Into<TableSource>) -> Self {
        Self {
            source: source.into(),
            matching: Matching::default(),
        }
    }
}

setters! { SurfaceMotion {
    /// Distance at which a place in the file is that of a node, in mesh units; 1e-9 unless it is set.
    match_tolerance(distance: f64) |self| self.matching.tolerance = distance;
    /// Nodes that the file does not name stay where they are.
    missing_fixed() |self| self.matching.missing_fixed = true;
} }

keys! { impl SurfaceMotion "[body.surface]" = Self::new(""), {
    /// relative to the schedule; its ending decides: a table (`.csv`), SU2's surface positions (`.dat`), or a mesh
    file => source, string::<TableSource>(), needed "file = \"surface.csv\"";
    /// distance within which a position in the file matches a node
    match_tolerance => matching.tolerance, positive("length"), default 1e-9;
    /// nodes of the body that are not in the file stay; without this key they are an error
    missing => matching.missing_fixed, MISSING, or "none";
} }

impl BodyMotion for SurfaceMotion {
    fn order(&self) -> u8 {
        1
    }

    fn files(&self) -> Vec<&TableSource> {
        vec![&self.source]
    }

    fn check(&self, body: &Body) -> Result<()> {
        body.places
            .positive("surface.match_tolerance", self.matching.tolerance)
    }

    /// Reads the file; there must be a set for every step.
    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        let file = self.source.mesh_file();
        let path = file.map(|file| on.file(file, "surface")).transpose()?;
        let (mut sets, path) = match path {
            Some(path) if is_positions(&path) => (self.of_positions(&path, on)?, path),
            Some(path) => (self.of_mesh(&path, on)?, path),
            None => {
                let table = self.source.read(on, "surface")?;
                (self.of_table(&table, on)?, table.path().to_path_buf())
            }
        };
        sets.check(on, &path)?;
        Ok(Arc::new(sets))
    }
}

/// Returns whether a file is of SU2's surface positions.
fn is_positions(path: &Path) -> bool {
    let kind = path.extension().map(|kind| kind.to_ascii_lowercase());
    kind.is_some_and(|kind| kind == "dat" || kind == "txt")
}

impl SurfaceMotion {
    fn of_table(&self, table: &Table, on: &OnMesh<'_>) -> Result<NodeSets> {
        let mut columns = table.columns();
        let key = columns.optional_key()?;
        let place = place_columns(&mut columns, on.in_plane())?;
        let new = columns.has("x_new");
        let names = if new {
            ["x_new", "y_new", "z_new"]
        } else {
            ["dx", "dy", "dz"]
        };
        let axes = three(&mut columns, names, on.in_plane())?;
        columns.done()?;
        let at = |row: usize| key.map_or(0.0, |(_, column)| table.value(row, column));
        let mut places: Vec<f64> = (0..table.n_rows()).map(at).collect();
        places.sort_by(f64::total_cmp);
        places.dedup();
        let nodes = on.nodes();
        let mut filling = Filling::new(on, &nodes, (WHAT, self.matching), places.len());
        let mut lines = vec![0; places.len()];
        let wrong = Wrong {
            at: &|row, message| table.error(row, message),
            twice: &|node, before, _| {
                let line = table.line(before);
                format!("node {node} is given twice, first in line {line}; keep one of the rows")
            },
        };
        for row in 0..table.n_rows() {
            let found = filling.find(place.at(table, row)?);
            let found = found.map_err(|message| table.error(row, message))?;
            let set = places.partition_point(|place| *place < at(row));
            lines[set] = table.line(row);
            let value = |x: Vector| {
                if new {
                    std::array::from_fn(|i| {
                        axes[i].map_or(0.0, |axis| table.value(row, axis) - x[i])
                    })
                } else {
                    vector(table, row, axes)
                }
            };
            filling.put((set, row), &found, value, &wrong)?;
        }
        let key = key.map(|(key, _)| key);
        let which = |set: usize| {
            key.map_or(String::new(), |key| {
                format!(" at {}", key.place(places[set]))
            })
        };
        let (sets, others) =
            filling.finish(which, |_, row, message| table.error_at(row, message))?;
        let notes = unused(others, table.path(), &on.body.name);
        Ok(match key {
            Some(key) => NodeSets::at_places((key, places), sets, lines, notes, on),
            None => NodeSets::one(sets, notes, on),
        })
    }

    /// SU2's surface positions: a line `node x y z` for each node, with its new place.
    fn of_positions(&self, path: &Path, on: &OnMesh<'_>) -> Result<NodeSets> {
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

    /// The displacement array of a mesh, whose nodes are found by their places.
    fn of_mesh(&self, path: &Path, on: &OnMesh<'_>) -> Result<NodeSets> {
        let (points, arrays) = arrays_of(path)?;
        let found = displacements(&arrays);
        let (name, values) = found.map_err(|message| Error::input(message).file(path))?;
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
        for (row, (place, value)) in points.iter().zip(values).enumerate() {
            let found = filling.find(Given::Place(*place)).map_err(whole)?;
            filling.put((0, row), &found, |_| *value, &wrong)?;
        }
        let (sets, others) = filling.finish(|_| String::new(), |_, _, message| whole(message))?;
        Ok(NodeSets::one(sets, unused(others, path, &on.body.name), on))
    }
}

/// A node and its new place; in the plane z may be left out.
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

/// Of the vectors of a mesh those that are displacements: the only ones, those of this name, or the
/// only ones with it in their name.
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

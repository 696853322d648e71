//! `[body.surface]`: displacements of the nodes of a body as another program gives them: a table, a mesh with
//! an array, or SU2's surface positions.

use super::node_files::{NamedVectors, arrays_of, place_columns, unused};
use super::nodes::{At as Given, BodyNodes, Filled, Finder, Matching, check_plane};
use super::sets::{NodeSets, SurfaceSets};
use super::{BodyMotion, FromSchedule, OnMesh, ResolvedMotion, TableSource};
use crate::error::{Error, Result};
use crate::formats::Source;
use crate::geometry::vector::{Vector, sub};
use crate::motion::body::Body;
use crate::motion::reader::{AngleUnit, Entry};
use crate::motion::table::{Column, Table};
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

    /// Distance at which a place in the file is that of a node, in mesh units; 1e-9 unless it is set.
    #[must_use]
    pub fn match_tolerance(mut self, distance: f64) -> Self {
        self.matching.tolerance = distance;
        self
    }

    /// Nodes that the file does not name stay where they are.
    #[must_use]
    pub fn missing_fixed(mut self) -> Self {
        self.matching.missing_fixed = true;
        self
    }
}

impl FromSchedule for SurfaceMotion {
    const KEY: &'static str = "surface";

    fn read(entry: &Entry<'_>, _: AngleUnit) -> Result<Self> {
        let keys = ["file", "match_tolerance", "missing"];
        let section = entry.section("[body.surface]", &keys)?;
        let file = section.require("file", "file = \"surface.csv\"")?;
        Ok(Self {
            source: file.string()?.into(),
            matching: Matching::read(&section)?,
        })
    }
}

impl BodyMotion for SurfaceMotion {
    fn order(&self) -> u8 {
        1
    }

    fn files(&self) -> Vec<&str> {
        self.source.file().into_iter().collect()
    }

    fn check(&self, body: &Body) -> Result<()> {
        body.places
            .positive("surface.match_tolerance", self.matching.tolerance)
    }

    /// Reads the file; there must be a set for every step.
    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        let reading = Reading {
            matching: self.matching,
            nodes: on.nodes(),
            body: &on.body.name,
            in_plane: on.in_plane(),
        };
        let file = self.source.mesh_file();
        let path = file.map(|file| on.file(file, "surface")).transpose()?;
        let (sets, path) = match path {
            Some(path) if is_positions(&path) => (reading.of_positions(&path)?, path),
            Some(path) => (reading.of_mesh(&path)?, path),
            None => {
                let table = self.source.read(on, "surface")?;
                (reading.of_table(&table)?, table.path().to_path_buf())
            }
        };
        for step in on.clock.steps {
            sets.check(step, on, &path)?;
        }
        Ok(Arc::new(NodeSets::new(sets, on)))
    }
}

/// Whether a file is of SU2's surface positions.
fn is_positions(path: &Path) -> bool {
    let kind = path.extension().map(|kind| kind.to_ascii_lowercase());
    kind.is_some_and(|kind| kind == "dat" || kind == "txt")
}

/// The columns of the vectors.
struct Columns3 {
    /// Displacements or, when `new`, positions.
    values: [Option<Column>; 3],
    new: bool,
}

/// How a file is held against the nodes of a body.
struct Reading<'a> {
    matching: Matching,
    nodes: Arc<BodyNodes>,
    body: &'a str,
    in_plane: bool,
}

impl Reading<'_> {
    fn of_table(&self, table: &Table) -> Result<SurfaceSets> {
        let (nodes, in_plane) = (&self.nodes, self.in_plane);
        let mut columns = table.columns();
        let key = columns.optional_key()?;
        let place = place_columns(&mut columns, in_plane)?;
        let new = columns.has("x_new");
        let names = if new {
            ["x_new", "y_new", "z_new"]
        } else {
            ["dx", "dy", "dz"]
        };
        let [x, y] = [names[0], names[1]].map(|name| columns.require(name));
        let z = match in_plane {
            true => columns.optional(names[2]),
            false => Some(columns.require(names[2])?),
        };
        let values = Columns3 {
            values: [Some(x?), Some(y?), z],
            new,
        };
        columns.done()?;
        let at = |row: usize| key.map_or(0.0, |(_, column)| table.value(row, column));
        let mut places: Vec<f64> = (0..table.n_rows()).map(at).collect();
        places.sort_by(f64::total_cmp);
        places.dedup();
        let mut filled: Vec<Filled> = Vec::new();
        filled.resize_with(places.len(), || Filled::new(nodes.nodes.len()));
        let mut finder = Finder::new(nodes, self.matching.tolerance);
        let mut others = 0;
        let mut lines = vec![0; places.len()];
        for row in 0..table.n_rows() {
            let at_row = |message| table.error(row, message);
            let found = finder.find(place.at(table, row)?).map_err(at_row)?;
            others += usize::from(found.is_empty());
            let set = places.partition_point(|place| *place < at(row));
            filled[set].saw(row);
            lines[set] = table.line(row);
            for node in found {
                let value = values.displacement(table, row, nodes.places[node]);
                check_plane(value, in_plane, WHAT, self.body).map_err(at_row)?;
                filled[set].set(node, value, row).map_err(|before| {
                    let message = format!(
                        "node {} is given twice, first in line {}; keep one of the rows",
                        nodes.nodes[node],
                        table.line(before)
                    );
                    table.error(row, message)
                })?;
            }
        }
        let key = key.map(|(key, _)| key);
        let sets = filled.into_iter().zip(&places).map(|(filled, place)| {
            let what = key.map_or(String::new(), |key| format!(" at {}", key.place(*place)));
            let at_row = |row, message| table.error_at(row, message);
            filled.finish(&finder, self.matching, self.body, &what, &at_row)
        });
        Ok(SurfaceSets {
            sets: sets.collect::<Result<_>>()?,
            key,
            places,
            lines,
            notes: unused(others, table.path(), self.body),
        })
    }

    /// SU2's surface positions: a line `node x y z` for each node, with its new place.
    fn of_positions(&self, path: &Path) -> Result<SurfaceSets> {
        let (nodes, in_plane) = (&self.nodes, self.in_plane);
        let source = Source::open(path)?;
        let mut filled = Filled::new(nodes.nodes.len());
        let mut finder = Finder::new(nodes, self.matching.tolerance);
        let mut others = 0;
        let at_line = |line: Option<usize>, message: String| {
            let line = line.map_or(1, |line| line as u64 + 1);
            Error::input(message).line(line).file(path)
        };
        for (line, text) in source.bytes().split(|b| *b == b'\n').enumerate() {
            let wrong = |message: String| at_line(Some(line), message);
            let text = String::from_utf8_lossy(text);
            let words: Vec<&str> = text.split_whitespace().collect();
            if words
                .first()
                .is_none_or(|word| word.starts_with(['%', '#']))
            {
                continue;
            }
            let numbers: Option<Vec<f64>> = words
                .iter()
                .map(|word| word.parse().ok().filter(|x: &f64| x.is_finite()))
                .collect();
            let (node, place) = match (words[0].parse::<u64>(), numbers.as_deref()) {
                (Ok(node), Some([_, x, y])) if in_plane => (node, [*x, *y, 0.0]),
                (Ok(node), Some([_, x, y, z])) => (node, [*x, *y, *z]),
                _ => {
                    let found: String = text.trim().chars().take(40).collect();
                    return Err(wrong(format!(
                        "found \"{}\"; a line of surface positions is a node and its new place: node x y z",
                        found.escape_debug()
                    )));
                }
            };
            let found = finder.find(Given::Node(node)).map_err(wrong)?;
            others += usize::from(found.is_empty());
            filled.saw(line);
            for at in found {
                let mut value = sub(place, nodes.places[at]);
                if words.len() == 3 {
                    value[2] = 0.0;
                }
                check_plane(value, in_plane, WHAT, self.body).map_err(wrong)?;
                filled.set(at, value, line).map_err(|before| {
                    wrong(format!(
                        "node {node} is given twice, first in line {}",
                        before + 1
                    ))
                })?;
            }
        }
        let set = filled.finish(&finder, self.matching, self.body, "", &at_line)?;
        Ok(SurfaceSets::one(set, unused(others, path, self.body)))
    }

    /// The displacement array of a mesh, whose nodes are found by their places.
    fn of_mesh(&self, path: &Path) -> Result<SurfaceSets> {
        let (nodes, in_plane) = (&self.nodes, self.in_plane);
        let (points, arrays) = arrays_of(path)?;
        let found = displacements(&arrays);
        let (name, values) = found.map_err(|message| Error::input(message).file(path))?;
        let mut filled = Filled::new(nodes.nodes.len());
        let mut finder = Finder::new(nodes, self.matching.tolerance);
        let mut others = 0;
        for (row, (place, value)) in points.iter().zip(values).enumerate() {
            let found = finder.find(Given::Place(*place)).unwrap_or_default();
            others += usize::from(found.is_empty());
            let wrong = |message: String| Error::input(message).dataset(name).file(path);
            for at in found {
                check_plane(*value, in_plane, WHAT, self.body).map_err(wrong)?;
                filled.set(at, *value, row).map_err(|before| {
                    let message = format!(
                        "points {before} and {row} are both at node {} and have different displacements",
                        nodes.nodes[at]
                    );
                    wrong(message)
                })?;
            }
        }
        let whole = |_, message| Error::input(message).dataset(name).file(path);
        let set = filled.finish(&finder, self.matching, self.body, "", &whole)?;
        Ok(SurfaceSets::one(set, unused(others, path, self.body)))
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
        [] => "the mesh has no point array of 3 components; it must have the displacements as one"
            .to_owned(),
        _ => format!(
            "which of its vectors are the displacements is not clear: {}; call them `Displacement`",
            names.join(", ")
        ),
    })
}

impl Columns3 {
    fn displacement(&self, table: &Table, row: usize, place: Vector) -> Vector {
        std::array::from_fn(|i| match self.values[i] {
            Some(column) if self.new => table.value(row, column) - place[i],
            Some(column) => table.value(row, column),
            None => 0.0,
        })
    }
}

//! Displacements of the nodes of a body as another program gives them: a table, a mesh with an array,
//! or SU2's surface positions.

use super::Clock;
use super::nodes::{At, BodyNodes, Filled, Finder, check_plane};
use super::shapes::{NamedVectors, arrays_of, place_columns, unused};
use crate::error::{Error, Result};
use crate::formats::Source;
use crate::geometry::vector::{Vector, scale, sub};
use crate::motion::body::{Body, SurfaceMotion};
use crate::motion::steps::Step;
use crate::motion::table::{Column, Key, Table};
use std::path::Path;

/// Part of the distance to the next set by which a set may be off its step, and of its place by
/// which one alone may be.
const SAME: f64 = 1e-4;
/// Part of a place that is round-off.
const ROUND_OFF: f64 = 1e-14;

/// What these files have.
const WHAT: &str = "displacements";

/// A set of displacements for every step, or one for all.
#[derive(Debug, Clone)]
pub(in crate::motion) struct SurfaceSets {
    /// What the sets belong to; `None` is one for all steps.
    key: Option<Key>,
    /// Where the sets are, increasing.
    places: Vec<f64>,
    /// Displacements of the body's nodes.
    sets: Vec<Vec<Vector>>,
    /// The last line of each set, in a table.
    lines: Vec<u64>,
    /// What the user should know, as sentences.
    pub notes: Vec<String>,
}

/// The columns of the vectors.
struct Columns3 {
    /// Displacements or, when `new`, positions.
    values: [Option<Column>; 3],
    new: bool,
}

impl SurfaceSets {
    /// Reads the file at `path`; there must be a set for every step.
    pub fn read(
        motion: &SurfaceMotion,
        path: &Path,
        body: &Body,
        nodes: &BodyNodes,
        (clock, in_plane): (&Clock<'_>, bool),
    ) -> Result<Self> {
        let kind = path.extension().map(|kind| kind.to_ascii_lowercase());
        let sets = match kind.as_ref().and_then(|kind| kind.to_str()) {
            Some("csv" | "tsv") | None => Self::of_table(motion, path, body, nodes, in_plane)?,
            Some("dat" | "txt") => Self::of_positions(motion, path, body, nodes, in_plane)?,
            Some(_) => Self::of_mesh(motion, path, body, nodes, in_plane)?,
        };
        for step in clock.steps {
            sets.check(step, body.azimuth_offset, (path, motion.line))?;
        }
        Ok(sets)
    }

    fn of_table(
        motion: &SurfaceMotion,
        path: &Path,
        body: &Body,
        nodes: &BodyNodes,
        in_plane: bool,
    ) -> Result<Self> {
        let table = Table::read(path)?;
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
        let mut finder = Finder::new(nodes, motion.matching.tolerance);
        let mut others = 0;
        let mut lines = vec![0; places.len()];
        for row in 0..table.n_rows() {
            let at_row = |message| table.error(row, message);
            let found = finder.find(place.at(&table, row)?).map_err(at_row)?;
            others += usize::from(found.is_empty());
            let set = places.partition_point(|place| *place < at(row));
            filled[set].saw(row);
            lines[set] = table.line(row);
            for node in found {
                let value = values.displacement(&table, row, nodes.places[node]);
                check_plane(value, in_plane, WHAT, body).map_err(at_row)?;
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
            filled.finish(nodes, motion.matching, body, &what, &at_row)
        });
        Ok(Self {
            sets: sets.collect::<Result<_>>()?,
            key,
            places,
            lines,
            notes: unused(others, path, body),
        })
    }

    /// SU2's surface positions: a line `node x y z` for each node, with its new place.
    fn of_positions(
        motion: &SurfaceMotion,
        path: &Path,
        body: &Body,
        nodes: &BodyNodes,
        in_plane: bool,
    ) -> Result<Self> {
        let source = Source::open(path)?;
        let mut filled = Filled::new(nodes.nodes.len());
        let mut finder = Finder::new(nodes, motion.matching.tolerance);
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
            let found = finder.find(At::Node(node)).map_err(wrong)?;
            others += usize::from(found.is_empty());
            filled.saw(line);
            for at in found {
                let mut value = sub(place, nodes.places[at]);
                if words.len() == 3 {
                    value[2] = 0.0;
                }
                check_plane(value, in_plane, WHAT, body).map_err(wrong)?;
                filled.set(at, value, line).map_err(|before| {
                    wrong(format!(
                        "node {node} is given twice, first in line {}",
                        before + 1
                    ))
                })?;
            }
        }
        let set = filled.finish(nodes, motion.matching, body, "", &at_line)?;
        Ok(Self::one(set, unused(others, path, body)))
    }

    /// The displacement array of a mesh, whose nodes are found by their places.
    fn of_mesh(
        motion: &SurfaceMotion,
        path: &Path,
        body: &Body,
        nodes: &BodyNodes,
        in_plane: bool,
    ) -> Result<Self> {
        let (points, arrays) = arrays_of(path)?;
        let named = |array: &&NamedVectors| {
            let name = array.0.to_ascii_lowercase();
            name.contains("displacement") || ["disp", "d", "u"].contains(&name.as_str())
        };
        let found = match arrays.as_slice() {
            [one] => Some(one),
            _ => arrays.iter().find(named),
        };
        let Some((name, values)) = found else {
            let names: Vec<&str> = arrays.iter().map(|(name, _)| name.as_str()).collect();
            let message = format!(
                "the mesh has no point array `Displacement` of 3 components; its vectors are: {}",
                names.join(", ")
            );
            return Err(Error::input(message).file(path));
        };
        let mut filled = Filled::new(nodes.nodes.len());
        let mut finder = Finder::new(nodes, motion.matching.tolerance);
        let mut others = 0;
        for (row, (place, value)) in points.iter().zip(values).enumerate() {
            let found = finder.find(At::Place(*place)).unwrap_or_default();
            others += usize::from(found.is_empty());
            let wrong = |message: String| Error::input(message).dataset(name).file(path);
            for at in found {
                check_plane(*value, in_plane, WHAT, body).map_err(wrong)?;
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
        let set = filled.finish(nodes, motion.matching, body, "", &whole)?;
        Ok(Self::one(set, unused(others, path, body)))
    }

    fn one(set: Vec<Vector>, notes: Vec<String>) -> Self {
        Self {
            key: None,
            places: vec![0.0],
            sets: vec![set],
            lines: Vec::new(),
            notes,
        }
    }

    /// The set of a step.
    fn find(&self, step: &Step, offset: f64) -> Option<usize> {
        let Some(key) = self.key else { return Some(0) };
        let at = Clock::place(key, step, offset)?;
        let turned = || self.nearest_turned(at, key.revolution()?);
        self.nearest(at).or_else(turned)
    }

    /// Refuses a step without a set; `line` is that of the motion in the schedule. Where rows are
    /// missing, the error is at the last row before them.
    fn check(&self, step: &Step, offset: f64, (path, line): (&Path, u64)) -> Result<()> {
        let (Some(key), None) = (self.key, self.find(step, offset)) else {
            return Ok(());
        };
        let Some(at) = Clock::place(key, step, offset) else {
            let message = "the table is over `time_s`, but the steps have no time; give the schedule [time], or \
                           `rpm` in [rotor]";
            return Err(Error::input(message).line(line));
        };
        let before = self.places.partition_point(|place| *place < at);
        let message = format!(
            "there are no rows for {} (step {}); every step needs a set of its own, and they go from {} to {}",
            key.place(at),
            step.index,
            key.place(self.places[0]),
            key.place(self.places[self.places.len() - 1])
        );
        let line = self.lines[before.saturating_sub(1)];
        Err(Error::input(message).line(line).file(path))
    }

    /// The set nearest to a place, if it is that of the place.
    fn nearest(&self, at: f64) -> Option<usize> {
        let after = self.places.partition_point(|place| *place < at);
        let beside = after.saturating_sub(1)..(after + 1).min(self.places.len());
        let off = |set: &usize| (self.places[*set] - at).abs();
        let nearest = beside.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(&nearest) <= self.slack(nearest, at)).then_some(nearest)
    }

    /// The same among the places a number of turns away.
    fn nearest_turned(&self, at: f64, turn: f64) -> Option<usize> {
        let off = |set: &usize| {
            let off = (self.places[*set] - at).rem_euclid(turn);
            off.min(turn - off)
        };
        let nearest = (0..self.places.len()).min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(&nearest) <= self.slack(nearest, at)).then_some(nearest)
    }

    /// By how much a set may be off a place.
    fn slack(&self, set: usize, at: f64) -> f64 {
        let place = self.places[set];
        let before = set.checked_sub(1).map(|before| place - self.places[before]);
        let after = self.places.get(set + 1).map(|after| after - place);
        let spacing = before.into_iter().chain(after).reduce(f64::min);
        SAME * spacing.unwrap_or(place.abs()) + ROUND_OFF * at.abs()
    }

    /// The displacements of a step.
    pub fn at(&self, step: &Step, offset: f64) -> &[Vector] {
        let found = self.find(step, offset);
        &self.sets[found.expect("there is a set for every step")]
    }

    /// Velocities at a step: the slope between the steps beside it.
    pub fn rates(&self, step: &Step, offset: f64, clock: &Clock<'_>) -> Vec<Vector> {
        let last = clock.steps.len() - 1;
        let [before, after] = [step.index.saturating_sub(1), (step.index + 1).min(last)];
        let [from, to] = [before, after].map(|i| self.at(&clock.steps[i], offset));
        let steps = (after - before).max(1) as f64;
        let rate = clock.steps_a_second(step) / steps;
        let pairs = from.iter().zip(to);
        pairs
            .map(|(from, to)| scale(sub(*to, *from), rate))
            .collect()
    }
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

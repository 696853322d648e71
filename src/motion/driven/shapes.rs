//! Mode shapes at the nodes of a body, with their generalised coordinates; and what files of nodes have
//! in common.

use super::Clock;
use super::nodes::{At, BodyNodes, Filled, Finder, check_plane};
use crate::error::{Error, Result};
use crate::geometry::vector::{Vector, add, scale};
use crate::mesh::Mesh;
use crate::mesh::Values;
use crate::mesh::arrays::with_numbers;
use crate::motion::body::{Body, ModesMotion};
use crate::motion::steps::Step;
use crate::motion::table::{Column, Columns, History, Table};
use std::path::Path;

/// What these files have.
const WHAT: &str = "shapes";

/// Shapes, and coordinates over azimuth, time or step.
#[derive(Debug, Clone)]
pub(in crate::motion) struct ModeShapes {
    /// Of every mode the displacement of every node of the body at a coordinate of 1.
    shapes: Vec<Vec<Vector>>,
    coordinates: History,
    /// What the user should know, as sentences.
    pub notes: Vec<String>,
}

impl ModeShapes {
    /// Reads shapes and coordinates; there must be coordinates at every step.
    pub fn read(
        motion: &ModesMotion,
        (shapes, coordinates): (&Path, &Path),
        body: &Body,
        nodes: &BodyNodes,
        (clock, in_plane): (&Clock<'_>, bool),
    ) -> Result<Self> {
        let coordinates = read_coordinates(motion, coordinates)?;
        clock.check(&coordinates, body.azimuth_offset, motion.line)?;
        let n_modes = coordinates.n_values();
        let is_table = shapes.extension().is_none_or(|kind| {
            kind.eq_ignore_ascii_case("csv") || kind.eq_ignore_ascii_case("tsv")
        });
        let place = (nodes, body, in_plane);
        let (shapes_found, others) = match is_table {
            true => of_table(motion, shapes, place, n_modes)?,
            false => of_mesh(motion, shapes, place, n_modes)?,
        };
        Ok(Self {
            shapes: shapes_found,
            coordinates,
            notes: unused(others, shapes, body),
        })
    }

    /// Coordinates of all modes at a step.
    pub fn coordinates(&self, step: &Step, offset: f64) -> Vec<f64> {
        let promise = "the coordinates were checked at every step";
        let at = Clock::place(self.coordinates.key(), step, offset).expect(promise);
        self.coordinates.at(at).expect(promise)
    }

    /// Their rates, by seconds.
    pub fn rates(&self, step: &Step, offset: f64, clock: &Clock<'_>) -> Vec<f64> {
        let promise = "the coordinates were checked at every step";
        let key = self.coordinates.key();
        let at = Clock::place(key, step, offset).expect(promise);
        let rates = self.coordinates.rates_at(at).expect(promise);
        let each = clock.rate(key, step);
        rates.into_iter().map(|rate| each * rate).collect()
    }

    /// The sum of the shapes times `factors` at a node of the body.
    pub fn sum(&self, factors: &[f64], node: usize) -> Vector {
        let shapes = self.shapes.iter().zip(factors);
        shapes.fold([0.0; 3], |sum, (shape, q)| add(sum, scale(shape[node], *q)))
    }
}

fn read_coordinates(motion: &ModesMotion, path: &Path) -> Result<History> {
    let table = Table::read(path)?;
    let mut columns = table.columns();
    let key = columns.require_key()?;
    let mut coordinates = vec![columns.require("q1")?];
    while let Some(next) = columns.optional(&format!("q{}", coordinates.len() + 1)) {
        coordinates.push(next);
    }
    columns.done()?;
    History::from_table(&table, key, &coordinates, motion.interpolation)
}

/// The nodes of a body, and whether it is in the plane.
type Place<'a> = (&'a BodyNodes, &'a Body, bool);

/// Rows `node, mode, dx, dy, dz`, modes counted from 1; and how many are for nodes of others.
fn of_table(
    motion: &ModesMotion,
    path: &Path,
    (nodes, body, in_plane): Place<'_>,
    n_modes: usize,
) -> Result<(Vec<Vec<Vector>>, usize)> {
    let table = Table::read(path)?;
    let mut columns = table.columns();
    let place = place_columns(&mut columns, in_plane)?;
    let mode = columns.require("mode")?;
    let [dx, dy] = ["dx", "dy"].map(|name| columns.require(name));
    let dz = match in_plane {
        true => columns.optional("dz"),
        false => Some(columns.require("dz")?),
    };
    let axes = [Some(dx?), Some(dy?), dz];
    columns.done()?;
    let mut filled: Vec<Filled> = (0..n_modes)
        .map(|_| Filled::new(nodes.nodes.len()))
        .collect();
    let mut finder = Finder::new(nodes, motion.matching.tolerance);
    let mut others = 0;
    for row in 0..table.n_rows() {
        let at_row = |message| table.error(row, message);
        let number = table.whole(row, mode)?;
        let mode = usize::try_from(number).unwrap_or(usize::MAX);
        if !(1..=n_modes).contains(&mode) {
            return Err(at_row(format!(
                "column `mode` holds {number}; the table of coordinates has q1 to q{n_modes}, so it must be from 1 to {n_modes}"
            )));
        }
        let found = finder.find(place.at(&table, row)?).map_err(at_row)?;
        others += usize::from(found.is_empty());
        let value = axes.map(|axis| axis.map_or(0.0, |axis| table.value(row, axis)));
        filled[mode - 1].saw(row);
        for node in found {
            check_plane(value, in_plane, WHAT, body).map_err(at_row)?;
            filled[mode - 1].set(node, value, row).map_err(|before| {
                at_row(format!(
                    "node {} of mode {mode} is given twice, first in line {}; keep one of the rows",
                    nodes.nodes[node],
                    table.line(before)
                ))
            })?;
        }
    }
    let at_row = |row, message| table.error_at(row, message);
    let shapes = (1..).zip(filled).map(|(mode, filled)| {
        let what = format!(" of mode {mode}");
        filled.finish(&finder, motion.matching, body, &what, &at_row)
    });
    Ok((shapes.collect::<Result<_>>()?, others))
}

/// Point arrays of a mesh whose names end in the number of the mode.
fn of_mesh(
    motion: &ModesMotion,
    path: &Path,
    (nodes, body, in_plane): Place<'_>,
    n_modes: usize,
) -> Result<(Vec<Vec<Vector>>, usize)> {
    let (points, arrays) = arrays_of(path)?;
    let number = |name: &str| {
        let digits = name.len() - name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        name[name.len() - digits..].parse::<usize>().ok()
    };
    let mut finder = Finder::new(nodes, motion.matching.tolerance);
    let at: Vec<Vec<usize>> = points
        .iter()
        .map(|x| finder.find(At::Place(*x)).unwrap_or_default())
        .collect();
    let others = at.iter().filter(|found| found.is_empty()).count();
    let mut all = Vec::new();
    for mode in 1..=n_modes {
        let mut of_mode = arrays.iter().filter(|(name, _)| number(name) == Some(mode));
        let (Some((name, values)), None) = (of_mode.next(), of_mode.next()) else {
            let names: Vec<&str> = arrays.iter().map(|(name, _)| name.as_str()).collect();
            let message = format!(
                "mode {mode} needs one point array of 3 components whose name ends in {mode}, as in mode{mode}; found: {}",
                names.join(", ")
            );
            return Err(Error::input(message).file(path));
        };
        let wrong = |message: String| Error::input(message).dataset(name).file(path);
        let mut filled = Filled::new(nodes.nodes.len());
        for (row, (found, value)) in at.iter().zip(values).enumerate() {
            for &node in found {
                check_plane(*value, in_plane, WHAT, body).map_err(wrong)?;
                filled.set(node, *value, row).map_err(|before| {
                    wrong(format!(
                        "points {before} and {row} are both at node {} and differ in mode {mode}",
                        nodes.nodes[node]
                    ))
                })?;
            }
        }
        let what = format!(" of mode {mode}");
        let at_row = |_, message| wrong(message);
        all.push(filled.finish(&finder, motion.matching, body, &what, &at_row)?);
    }
    Ok((all, others))
}

/// Columns that say which node a row belongs to: `node`, or `x`, `y`, `z`.
pub(super) enum PlaceColumns {
    Node(Column),
    Place([Option<Column>; 3]),
}

pub(super) fn place_columns(columns: &mut Columns<'_>, in_plane: bool) -> Result<PlaceColumns> {
    if !columns.has("x") {
        return Ok(PlaceColumns::Node(columns.require("node")?));
    }
    if columns.has("node") {
        return Err(columns.both("node", "x"));
    }
    let [x, y] = ["x", "y"].map(|name| columns.require(name));
    let z = match in_plane {
        true => columns.optional("z"),
        false => Some(columns.require("z")?),
    };
    Ok(PlaceColumns::Place([Some(x?), Some(y?), z]))
}

impl PlaceColumns {
    pub fn at(&self, table: &Table, row: usize) -> Result<At> {
        Ok(match self {
            Self::Node(node) => At::Node(table.whole(row, *node)?),
            Self::Place(axes) => {
                let value = |axis: Option<Column>| axis.map_or(0.0, |axis| table.value(row, axis));
                At::Place(axes.map(value))
            }
        })
    }
}

/// A point array of three components with its name.
pub(super) type NamedVectors = (String, Vec<Vector>);

/// The points of a mesh file and its point arrays of three components.
pub(super) fn arrays_of(path: &Path) -> Result<(Vec<Vector>, Vec<NamedVectors>)> {
    let mesh = Mesh::read(path)?;
    let mut arrays = Vec::new();
    for array in mesh
        .point_arrays
        .iter()
        .filter(|array| array.n_components == 3)
    {
        if let Some(values) = numbers(&array.values) {
            let (vectors, _) = values.as_chunks::<3>();
            arrays.push((array.name.clone(), vectors.to_vec()));
        }
    }
    let finite = |(_, vectors): &NamedVectors| vectors.iter().flatten().all(|x| x.is_finite());
    if let Some((name, _)) = arrays.iter().find(|array| !finite(array)) {
        let message = "the array holds a value that is not a finite number";
        return Err(Error::input(message).dataset(name).file(path));
    }
    Ok((mesh.points, arrays))
}

/// The values as floats; `None` for text.
fn numbers(values: &Values) -> Option<Vec<f64>> {
    #[allow(clippy::unnecessary_cast)] // one arm for every type of number
    let numbers =
        with_numbers!(values, v => Some(v.iter().map(|x| *x as f64).collect()), _text => None);
    numbers
}

/// A sentence on rows that are for nodes of others.
pub(super) fn unused(rows: usize, path: &Path, body: &Body) -> Vec<String> {
    let told = (rows > 0).then(|| {
        format!(
            "{}: {rows} rows are for nodes that body \"{}\" does not have, and are not used",
            path.display(),
            body.name
        )
    });
    told.into_iter().collect()
}

//! The nodes of a body, found by number or by position, and a vector for each from a file: a table with a column
//! that names the node, or arrays of a mesh.

use super::OnMesh;
use crate::motion::keys::Kind;
use crate::motion::table::{Column, Columns, Table};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::numbers::short;
use azimesh_core::{Note, note};
use azimesh_io::mesh::Mesh;
use serde_json::json;
use std::collections::HashMap;
use std::path::Path;

/// Most nodes named in a message.
const LISTED: usize = 5;
/// Most unmatched nodes for which the nearest position is searched.
const ASKED: usize = 64;
/// Distance, as a part of the extent of a body, within which a position is assumed to be meant for a node.
const ALMOST: f64 = 1e-4;

/// Options for matching nodes of a file with nodes of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Matching {
    /// Largest distance between a node and its position in the file, in mesh units.
    pub tolerance: f64,
    /// True if nodes that the file does not name stay at rest; otherwise they are an error.
    pub missing_fixed: bool,
}

impl Default for Matching {
    fn default() -> Self {
        Self {
            tolerance: 1e-9,
            missing_fixed: false,
        }
    }
}

/// Sets [`Matching::missing_fixed`].
pub(super) const MISSING: Kind<bool> = Kind {
    words: "",
    read: |entry| entry.choice(&[("fixed", true)]),
    schema: || json!({ "enum": ["fixed"] }),
};

/// The nodes that move with a body.
#[derive(Debug, Clone)]
pub(in crate::motion) struct BodyNodes {
    /// Node numbers in the mesh, ascending.
    pub nodes: Vec<u32>,
    /// Their positions in the reference mesh.
    pub places: Vec<Vector>,
    /// Number of nodes of the mesh.
    pub n_mesh: usize,
}

/// The node or position to which a row of a file belongs.
#[derive(Debug, Clone, Copy)]
pub(super) enum At {
    /// A zero-based node of the mesh.
    Node(u64),
    /// A position in the reference mesh.
    Place(Vector),
}

/// Vectors for the nodes of a body, in one or several fields, filled row by row from a file.
pub(super) struct Filling<'a> {
    nodes: &'a BodyNodes,
    body: &'a str,
    in_plane: bool,
    /// Content of the file, in messages; plural.
    what: &'static str,
    matching: Matching,
    /// Nodes binned in cells of the size of the tolerance.
    cells: HashMap<[i64; 3], Vec<usize>>,
    /// Positions that match no node.
    strays: Vec<Vector>,
    /// Number of rows for nodes of other bodies.
    others: usize,
    fields: Vec<Field>,
}

#[derive(Clone)]
struct Field {
    values: Vec<Vector>,
    /// The row that set it, from 1; 0 if none.
    rows: Vec<u32>,
    /// The last row that names a node, of this body or not.
    last: Option<usize>,
}

/// Error messages for wrong rows.
pub(super) struct Wrong<'a> {
    /// Returns the error at a row.
    pub at: &'a dyn Fn(usize, String) -> Error,
    /// Returns the message for a node with two different vectors: the node, the row before, the row.
    pub twice: &'a dyn Fn(u32, usize, usize) -> String,
}

impl BodyNodes {
    pub fn of(on: &OnMesh<'_>) -> Self {
        let nodes = on.surface_nodes.nodes.iter().zip(&on.surface_nodes.roles);
        let own = nodes.filter(|(_, role)| **role == on.role);
        let nodes: Vec<u32> = own.map(|(node, _)| *node).collect();
        let places = nodes.iter().map(|&node| on.boundary.position(node));
        Self {
            places: places.collect(),
            nodes,
            n_mesh: on.boundary.n_nodes,
        }
    }

    /// Returns the index of a node of the mesh among these.
    #[inline]
    pub fn find(&self, node: u32) -> Option<usize> {
        self.nodes.binary_search(&node).ok()
    }
}

impl<'a> Filling<'a> {
    pub fn new(
        on: &'a OnMesh<'_>,
        nodes: &'a BodyNodes,
        (what, matching): (&'static str, Matching),
        n_fields: usize,
    ) -> Self {
        let field = Field {
            values: vec![[0.0; 3]; nodes.nodes.len()],
            rows: vec![0; nodes.nodes.len()],
            last: None,
        };
        Self {
            nodes,
            body: &on.body.name,
            in_plane: on.in_plane(),
            what,
            matching,
            cells: HashMap::new(),
            strays: Vec::new(),
            others: 0,
            fields: vec![field; n_fields],
        }
    }

    /// Finds the nodes of a row, as indices into the body's nodes; empty if the mesh has the node and the body
    /// does not.
    pub fn find(&mut self, at: At) -> std::result::Result<Vec<usize>, String> {
        let found = match at {
            At::Node(node) => match u32::try_from(node) {
                Ok(node) if (node as usize) < self.nodes.n_mesh => {
                    self.nodes.find(node).into_iter().collect()
                }
                _ => {
                    let last = self.nodes.n_mesh.saturating_sub(1);
                    return Err(format!(
                        "node {node} is not in the mesh, whose nodes are 0 to {last}"
                    ));
                }
            },
            At::Place(x) => self.near(x),
        };
        self.others += usize::from(found.is_empty());
        Ok(found)
    }

    fn cell(&self, x: Vector) -> [i64; 3] {
        x.map(|x| (x / self.matching.tolerance).floor() as i64)
    }

    fn near(&mut self, x: Vector) -> Vec<usize> {
        let places = &self.nodes.places;
        if self.cells.is_empty() {
            for (at, place) in places.iter().enumerate() {
                let cell = self.cell(*place);
                self.cells.entry(cell).or_default().push(at);
            }
        }
        let [i, j, k] = self.cell(x);
        let mut found = Vec::new();
        for n in 0..27 {
            let cell = [
                i.saturating_add(n % 3 - 1),
                j.saturating_add(n / 3 % 3 - 1),
                k.saturating_add(n / 9 - 1),
            ];
            let near = self.cells.get(&cell).into_iter().flatten();
            found.extend(near.filter(|&&at| distance(places[at], x) <= self.matching.tolerance));
        }
        found.sort_unstable();
        found.dedup();
        if found.is_empty() {
            self.strays.push(x);
        }
        found
    }

    /// Sets the vectors of the nodes of a row: `value` returns the vector at the position in the reference mesh.
    pub fn put(
        &mut self,
        (field, row): (usize, usize),
        found: &[usize],
        value: impl Fn(Vector) -> Vector,
        wrong: &Wrong<'_>,
    ) -> Result<()> {
        let field = &mut self.fields[field];
        field.last = field.last.max(Some(row));
        for &node in found {
            let value = value(self.nodes.places[node]);
            if self.in_plane && value[2] != 0.0 {
                let message = format!(
                    "body \"{}\" would leave the plane of the 2D mesh; {} along z must be 0",
                    self.body, self.what
                );
                return Err((wrong.at)(row, message));
            }
            match field.rows[node] {
                0 => {
                    field.values[node] = value;
                    field.rows[node] = u32::try_from(row + 1).unwrap_or(u32::MAX);
                }
                _ if field.values[node] == value => {}
                before => {
                    let message = (wrong.twice)(self.nodes.nodes[node], before as usize - 1, row);
                    return Err((wrong.at)(row, message));
                }
            }
        }
        Ok(())
    }

    /// Returns all fields, and the number of rows for nodes of other bodies. Nodes without a vector stay at rest where
    /// that is allowed. `which` names a field, and `wrong` returns an error after its last row.
    pub fn finish(
        self,
        which: impl Fn(usize) -> String,
        wrong: impl Fn(usize, Option<usize>, String) -> Error,
    ) -> Result<(Vec<Vec<Vector>>, usize)> {
        for (at, field) in self.fields.iter().enumerate() {
            if let Some(message) = self.missing(field, &which(at)) {
                return Err(wrong(at, field.last, message));
            }
        }
        let fields = self.fields.into_iter().map(|field| field.values);
        Ok((fields.collect(), self.others))
    }

    /// Returns a sentence if nodes have no vector and must not stay at rest.
    fn missing(&self, field: &Field, which: &str) -> Option<String> {
        let (nodes, body) = (&self.nodes.nodes, self.body);
        let missing: Vec<usize> = (0..nodes.len()).filter(|&at| field.rows[at] == 0).collect();
        if missing.len() == nodes.len() {
            return Some(format!(
                "no node of body \"{body}\" is in the file{which}; {}nodes are numbered from 0, and positions \
                 must agree within match_tolerance = {}",
                self.almost(&missing),
                short(self.matching.tolerance)
            ));
        }
        if missing.is_empty() || self.matching.missing_fixed {
            return None;
        }
        let listed = missing.iter().take(LISTED).map(|&at| nodes[at].to_string());
        let more = if missing.len() > LISTED { ", ..." } else { "" };
        Some(format!(
            "{} of the {} nodes of body \"{body}\" are missing{which}: {}{more}; {}add them, or set missing = \
             \"fixed\"",
            missing.len(),
            nodes.len(),
            listed.collect::<Vec<_>>().join(", "),
            self.almost(&missing)
        ))
    }

    /// Returns a sentence on positions that would match nodes with a larger tolerance; empty if the file has none
    /// nearby.
    fn almost(&self, missing: &[usize]) -> String {
        let places = &self.nodes.places;
        let nearest = |at: &usize| {
            let off = self.strays.iter().map(|x| distance(*x, places[*at]));
            off.fold(f64::INFINITY, f64::min)
        };
        let farthest = missing.iter().take(ASKED).map(nearest).fold(0.0, f64::max);
        if farthest <= ALMOST * Bounds::around(places).diagonal() {
            format!(
                "the nearest positions in the file are up to {farthest:.1e} away, which match_tolerance = \
                 {:.0e} would accept; ",
                10.0_f64.powf((1.01 * farthest).log10().ceil())
            )
        } else {
            String::new()
        }
    }
}

/// Columns that identify the node of a row: `node`, or `x`, `y`, `z`.
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
    Ok(PlaceColumns::Place(three(
        columns,
        ["x", "y", "z"],
        in_plane,
    )?))
}

/// Picks three columns; in the plane the last may be missing.
pub(super) fn three(
    columns: &mut Columns<'_>,
    [x, y, z]: [&str; 3],
    in_plane: bool,
) -> Result<[Option<Column>; 3]> {
    let [x, y] = [x, y].map(|name| columns.require(name));
    let z = if in_plane {
        columns.optional(z)
    } else {
        Some(columns.require(z)?)
    };
    Ok([Some(x?), Some(y?), z])
}

/// Returns the values of three columns in a row; a missing column is 0.
pub(super) fn vector(table: &Table, row: usize, axes: [Option<Column>; 3]) -> Vector {
    axes.map(|axis| axis.map_or(0.0, |axis| table.value(row, axis)))
}

impl PlaceColumns {
    pub fn at(&self, table: &Table, row: usize) -> Result<At> {
        Ok(match self {
            Self::Node(node) => At::Node(table.whole(row, *node)?),
            Self::Place(axes) => At::Place(vector(table, row, *axes)),
        })
    }
}

/// A point array of three components with its name.
pub(super) type NamedVectors = (String, Vec<Vector>);

/// A mesh and its point arrays of three components.
pub(super) fn arrays_of(path: &Path) -> Result<(Mesh, Vec<NamedVectors>)> {
    let mesh = Mesh::read(path)?;
    let mut arrays = Vec::new();
    for array in (mesh.point_arrays.iter()).filter(|array| array.n_components == 3) {
        if let Some(values) = array.values.to_f64() {
            let (vectors, _) = values.as_chunks::<3>();
            arrays.push((array.name.clone(), vectors.to_vec()));
        }
    }
    let finite = |(_, vectors): &NamedVectors| vectors.iter().flatten().all(|x| x.is_finite());
    if let Some((name, _)) = arrays.iter().find(|array| !finite(array)) {
        let message = "the array holds a value that is not a finite number";
        return Err(Error::input(message).dataset(name).file(path));
    }
    Ok((mesh, arrays))
}

/// Returns a note on rows for nodes of other bodies.
pub(super) fn unused(rows: usize, path: &Path, body: &str) -> Vec<Note> {
    if rows == 0 {
        return Vec::new();
    }
    let rows = counted(rows, "row");
    vec![
        note!(
            "other_nodes",
            "ignored {rows} of nodes that are not on body \"{body}\""
        )
        .file(path),
    ]
}

//! The nodes of a body, found by number or by place, and a vector for each of them from a file.

use super::OnMesh;
use crate::error::{Error, Result};
use crate::geometry::Bounds;
use crate::geometry::vector::{Vector, distance};
use crate::motion::reader::{Entry, Section};
use std::collections::HashMap;

/// Nodes that are named in a message.
const LISTED: usize = 5;
/// Nodes without a place for which the nearest one is looked for.
const ASKED: usize = 64;
/// Part of the extent of a body by which a place may be off a node that it is meant for.
const ALMOST: f64 = 1e-4;

/// How nodes of a file are found among those of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Matching {
    /// Distance at which a place is that of a node, in mesh units.
    pub tolerance: f64,
    /// Whether nodes that the file does not name stay where they are; else they are an error.
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

impl Matching {
    pub fn read(section: &Section<'_>) -> Result<Self> {
        let mut matching = Self::default();
        section.set("match_tolerance", &mut matching.tolerance, Entry::positive)?;
        let missing = |entry: &Entry<'_>| entry.choice(&[("fixed", true)]);
        section.set("missing", &mut matching.missing_fixed, missing)?;
        Ok(matching)
    }
}

/// The nodes that move with a body.
#[derive(Debug, Clone)]
pub(in crate::motion) struct BodyNodes {
    /// Node numbers in the mesh, ascending.
    pub nodes: Vec<u32>,
    /// Their places in the reference mesh.
    pub places: Vec<Vector>,
    /// Number of nodes of the mesh.
    pub n_mesh: usize,
}

/// Where a file says that a row belongs.
#[derive(Debug, Clone, Copy)]
pub(super) enum At {
    /// A zero-based node of the mesh.
    Node(u64),
    /// A place in the reference mesh.
    Place(Vector),
}

/// Finds the nodes of a body.
pub(super) struct Finder<'a> {
    of: &'a BodyNodes,
    tolerance: f64,
    /// Nodes in cells as large as the tolerance.
    cells: HashMap<[i64; 3], Vec<usize>>,
    /// Places at which there was no node.
    strays: Vec<Vector>,
}

impl BodyNodes {
    pub fn of(on: &OnMesh<'_>) -> Self {
        let nodes = on.surface_nodes.nodes.iter().zip(&on.surface_nodes.roles);
        let own = nodes.filter(|(_, role)| **role == on.role);
        let nodes: Vec<u32> = own.map(|(node, _)| *node).collect();
        let places = nodes.iter().map(|&node| on.mesh.points[node as usize]);
        Self {
            places: places.collect(),
            nodes,
            n_mesh: on.mesh.points.len(),
        }
    }

    /// The position of a node of the mesh among these.
    #[inline]
    pub fn find(&self, node: u32) -> Option<usize> {
        self.nodes.binary_search(&node).ok()
    }
}

impl<'a> Finder<'a> {
    pub fn new(of: &'a BodyNodes, tolerance: f64) -> Self {
        Self {
            of,
            tolerance,
            cells: HashMap::new(),
            strays: Vec::new(),
        }
    }

    fn cell(&self, x: Vector) -> [i64; 3] {
        x.map(|x| (x / self.tolerance).floor() as i64)
    }

    /// Positions among the body's nodes; none where the mesh has the node and the body has not.
    pub fn find(&mut self, at: At) -> std::result::Result<Vec<usize>, String> {
        match at {
            At::Node(node) => match u32::try_from(node) {
                Ok(node) if (node as usize) < self.of.n_mesh => {
                    Ok(self.of.find(node).into_iter().collect())
                }
                _ => Err(format!(
                    "node {node} is not in the mesh, whose nodes are 0 to {}",
                    self.of.n_mesh.saturating_sub(1)
                )),
            },
            At::Place(x) => Ok(self.near(x)),
        }
    }

    fn near(&mut self, x: Vector) -> Vec<usize> {
        if self.cells.is_empty() {
            for (at, place) in self.of.places.iter().enumerate() {
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
            found.extend(near.filter(|&&at| distance(self.of.places[at], x) <= self.tolerance));
        }
        found.sort_unstable();
        found.dedup();
        if found.is_empty() {
            self.strays.push(x);
        }
        found
    }

    /// A sentence on places that some nodes would be at, were the tolerance larger; empty where the file
    /// has none near them.
    fn almost(&self, missing: &[usize]) -> String {
        let bounds = Bounds::around(&self.of.places);
        let nearest = |at: &usize| {
            let strays = self.strays.iter();
            let off = strays.map(|x| distance(*x, self.of.places[*at]));
            off.fold(f64::INFINITY, f64::min)
        };
        let farthest = missing.iter().take(ASKED).map(nearest).fold(0.0, f64::max);
        match farthest <= ALMOST * bounds.diagonal() {
            true => format!(
                "the file has them up to {farthest:.1e} off, which match_tolerance = {:.0e} would take; ",
                10.0_f64.powf((1.01 * farthest).log10().ceil())
            ),
            false => String::new(),
        }
    }
}

/// A vector for each node, filled row by row.
pub(super) struct Filled {
    values: Vec<Vector>,
    /// The row that gave it, from 1; 0 where none has.
    rows: Vec<u32>,
    /// The last row that belongs here, of this body or not.
    last: Option<usize>,
}

/// The error at a row of a file, or of the file as a whole where there is none.
pub(super) type AtRow<'a> = &'a dyn Fn(Option<usize>, String) -> Error;

impl Filled {
    pub fn new(n: usize) -> Self {
        Self {
            values: vec![[0.0; 3]; n],
            rows: vec![0; n],
            last: None,
        }
    }

    /// Notes that a row belongs here, whether its node is the body's or not.
    pub fn saw(&mut self, row: usize) {
        self.last = self.last.max(Some(row));
    }

    /// Gives a node its vector; the row that has given it another one before is an error.
    pub fn set(&mut self, at: usize, value: Vector, row: usize) -> std::result::Result<(), usize> {
        match self.rows[at] {
            0 => {
                self.values[at] = value;
                self.rows[at] = u32::try_from(row + 1).unwrap_or(u32::MAX);
                Ok(())
            }
            _ if self.values[at] == value => Ok(()),
            before => Err(before as usize - 1),
        }
    }

    /// All vectors; nodes without one stay where that is allowed.
    pub fn finish(
        self,
        finder: &Finder<'_>,
        matching: Matching,
        body: &str,
        what: &str,
        at_row: AtRow<'_>,
    ) -> Result<Vec<Vector>> {
        let nodes = finder.of;
        let rows = self.rows.iter().enumerate();
        let missing: Vec<usize> = rows
            .filter(|(_, row)| **row == 0)
            .map(|(at, _)| at)
            .collect();
        if missing.len() == nodes.nodes.len() {
            let message = format!(
                "no node of body \"{body}\" is in the file{what}; {}its nodes are counted from 0, and places must agree \
                 to match_tolerance = {:e}",
                finder.almost(&missing),
                matching.tolerance
            );
            return Err(at_row(self.last, message));
        }
        if missing.is_empty() || matching.missing_fixed {
            return Ok(self.values);
        }
        let listed = missing.iter().take(LISTED);
        let listed: Vec<String> = listed.map(|&at| nodes.nodes[at].to_string()).collect();
        let more = if missing.len() > LISTED { ", ..." } else { "" };
        let message = format!(
            "{} of the {} nodes of body \"{body}\" are missing{what}: {}{more}; {}add them, or set missing = \"fixed\"",
            missing.len(),
            nodes.nodes.len(),
            listed.join(", "),
            finder.almost(&missing)
        );
        Err(at_row(self.last, message))
    }
}

/// Refuses a vector out of the plane of a 2D mesh; `what` is what the file has, in the plural.
pub(super) fn check_plane(
    value: Vector,
    in_plane: bool,
    what: &str,
    body: &str,
) -> std::result::Result<(), String> {
    if !in_plane || value[2] == 0.0 {
        return Ok(());
    }
    Err(format!(
        "body \"{body}\" would leave the plane of the 2D mesh; {what} along z must be 0"
    ))
}

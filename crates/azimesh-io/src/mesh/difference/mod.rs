//! Differences of two meshes: node by node, cell by cell, tag by tag, array by array.
//!
//! In order, node i belongs to node i; cells are compared in order within each dimension, because
//! formats may put boundary faces before or after the volume cells. By position, nodes belong
//! together that are at the same place, and cells that have the same nodes. Groups are compared by
//! dimension and name as sets of cells.

mod arrays;
mod cells;
mod groups;
mod nodes;
mod partners;
mod position;

use super::{CellKind, Mesh};
use azimesh_core::error::{Result, counted, one_line};
use azimesh_core::numbers::{short, with_verb};
use azimesh_core::{Note, note};
use partners::Partners;
use std::fmt;

/// Default distance within which nodes are paired by position, as a fraction of the diagonal.
const MATCHED: f64 = 1e-9;

/// Allowed difference of two coordinates; by default none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tolerance {
    /// Largest distance of two nodes, and of two values of an array, that count as the same.
    pub value: f64,
    /// True if `value` is a fraction: of the diagonal of the first mesh's box for nodes, of the
    /// largest magnitude in the first mesh's array for arrays.
    pub relative: bool,
}

impl Tolerance {
    fn absolute(self, scale: f64) -> f64 {
        if self.relative {
            self.value * scale
        } else {
            self.value
        }
    }
}

/// A pair of nodes that belong together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodePair {
    /// Index in the first mesh.
    pub node: usize,
    /// Index in the second mesh.
    pub partner: usize,
    /// Position in the first mesh.
    pub a: [f64; 3],
    /// Position in the second mesh.
    pub b: [f64; 3],
    /// Distance between them, in mesh units.
    pub distance: f64,
}

/// The differences between two meshes. See [`diff`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Difference {
    /// Number of nodes in each.
    pub n_nodes: [usize; 2],
    /// Number of paired nodes whose distance exceeds the tolerance.
    pub moved_nodes: usize,
    /// The first of them.
    pub first_moved: Option<NodePair>,
    /// The pair with the largest distance, moved or not.
    pub furthest: Option<NodePair>,
    /// Nodes of each with no node of the other at their place; by position only.
    pub unpaired_nodes: [usize; 2],
    /// Number of cells in each.
    pub n_cells: [usize; 2],
    /// Cells whose kind or nodes differ, with those that only one mesh has.
    pub changed_cells: usize,
    /// Nodes without a partner, a sentence for each mesh.
    pub nodes: Vec<String>,
    /// Differences of the cells, a sentence for each dimension and what differs.
    pub cells: Vec<String>,
    /// Differences of groups, a sentence each.
    pub groups: Vec<String>,
    /// Differences of arrays, a sentence each.
    pub arrays: Vec<String>,
    /// Remarks on the comparison that are not differences.
    pub notes: Vec<Note>,
}

/// Options of a comparison; by default all numbers must be equal and in the same order. See [`diff`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DiffOptions {
    /// Largest distance of two nodes, and of two values of an array, that count as the same: in mesh units,
    /// or a fraction where `relative`.
    pub tolerance: f64,
    /// True if `tolerance` is a fraction: see [`Tolerance`].
    pub relative: bool,
    /// True if nodes are paired by their positions rather than by their numbers.
    pub by_position: bool,
    /// With `by_position`, the largest distance of partners in mesh units; chosen from the meshes when `None`.
    pub match_tolerance: Option<f64>,
}

/// Compares two meshes: node by node, cell by cell, tag by tag, array by array.
///
/// ```
/// use azimesh_io::{DiffOptions, Difference, Mesh, diff};
///
/// # fn main() -> azimesh_io::Result<()> {
/// let a = Mesh::read("testdata/naca0012.vtu")?;
/// let mut b = a.clone();
/// b.points[5][0] += 0.25;
/// let found: Difference = diff(&a, &b, &DiffOptions::default())?;
/// assert_eq!(found.moved_nodes, 1);
/// let tolerance = DiffOptions { tolerance: 0.5, ..DiffOptions::default() };
/// assert!(diff(&a, &b, &tolerance)?.is_same());
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// If nodes are paired by position and `match_tolerance` is so large that it does not distinguish them.
pub fn diff(a: &Mesh, b: &Mesh, options: &DiffOptions) -> Result<Difference> {
    let tolerance = Tolerance {
        value: options.tolerance,
        relative: options.relative,
    };
    if options.by_position {
        Difference::by_position(a, b, tolerance, options.match_tolerance)
    } else {
        Ok(Difference::between(a, b, tolerance))
    }
}

impl Difference {
    /// Compares `a` with `b` in order. `O(n)`; memory: a few bytes a boundary face.
    pub fn between(a: &Mesh, b: &Mesh, tolerance: Tolerance) -> Self {
        let mut found = Self::new(a, b);
        let in_order = Partners::in_order(a.points.len(), b.points.len());
        found.compare_nodes(a, b, &in_order, tolerance);
        let cells = cells::compare(&a.cells, &b.cells);
        let all_same = cells.n_changed == 0;
        found.changed_cells = cells.n_changed;
        found.cells = cells.sentences;
        found.note_kinds(a, b);
        found.groups = groups::compare(a, b, all_same.then_some(&cells.partners));
        let pairs = [&in_order, &cells.partners];
        found.arrays = arrays::compare(a, b, pairs, true, tolerance);
        found
    }

    /// Compares `a` with `b` in any order of nodes and cells. Two nodes are paired if each is the nearest to the other,
    /// within `within` (mesh units; by default 1e-9 of the diagonal, and at least the tolerance). Cells are paired if they
    /// have the same nodes. Cells distinguish nodes at one place. `O(n log n)`; memory: about 60 bytes per node and per cell.
    ///
    /// # Errors
    /// [`ErrorKind::Input`](azimesh_core::error::ErrorKind::Input) if `within` is so large that it does not distinguish nodes.
    pub fn by_position(
        a: &Mesh,
        b: &Mesh,
        tolerance: Tolerance,
        within: Option<f64>,
    ) -> Result<Self> {
        let diagonal = diagonal(a);
        let least = tolerance.absolute(diagonal);
        let within = within.unwrap_or(MATCHED * diagonal).max(least);
        let mut found = Self::new(a, b);
        let paired = position::nodes(a, b, within)?;
        found.compare_nodes(a, b, &paired.partners, tolerance);
        found.unpaired_nodes = paired.n_unpaired;
        found.nodes = paired.sentences;
        found.notes = paired.notes;
        let cells = position::cells(&a.cells, &b.cells, &paired.back);
        found.changed_cells = cells.n_changed;
        found.cells = cells.sentences;
        found.note_kinds(a, b);
        found.groups = groups::compare(a, b, Some(&cells.partners));
        let pairs = [&paired.partners, &cells.partners];
        found.arrays = arrays::compare(a, b, pairs, false, tolerance);
        Ok(found)
    }

    fn new(a: &Mesh, b: &Mesh) -> Self {
        Self {
            n_nodes: [a.points.len(), b.points.len()],
            n_cells: [a.cells.len(), b.cells.len()],
            ..Self::default()
        }
    }

    /// A remark where cells differ since one mesh has them as polyhedra or polygons, and the other as cells of their shapes.
    fn note_kinds(&mut self, a: &Mesh, b: &Mesh) {
        let [ours, theirs] = [a, b].map(|mesh| {
            let is_general = |kind| matches!(kind, CellKind::Polygon | CellKind::Polyhedron);
            let runs = mesh.cells.runs().filter(|run| is_general(run.kind));
            runs.map(|run| run.n_cells()).sum::<usize>()
        });
        if self.changed_cells == 0 || self.n_cells[0] != self.n_cells[1] || ours == theirs {
            return;
        }
        let [more, less] = if ours > theirs {
            ["first", "second"]
        } else {
            ["second", "first"]
        };
        self.notes.push(note!(
            "more_polyhedra",
            "the {more} mesh has {} as polyhedra or polygons more than the {less}: formats that list faces, as OpenFOAM does, \
             keep the shapes of cells alone, and a polyhedron with the faces of a hexahedron is read from them as one",
            counted(ours.abs_diff(theirs), "cell")
        ));
    }

    fn compare_nodes(&mut self, a: &Mesh, b: &Mesh, partners: &Partners, tolerance: Tolerance) {
        let scale = if tolerance.relative { diagonal(a) } else { 0.0 };
        let moved = nodes::compare(&a.points, &b.points, partners, tolerance.absolute(scale));
        self.moved_nodes = moved.n;
        self.first_moved = moved.first;
        self.furthest = moved.furthest;
    }

    /// Returns whether nothing differs by more than the tolerance.
    pub fn is_same(&self) -> bool {
        self.n_nodes[0] == self.n_nodes[1]
            && self.moved_nodes == 0
            && self.nodes.is_empty()
            && self.cells.is_empty()
            && self.groups.is_empty()
            && self.arrays.is_empty()
    }

    /// Forgets what differs of anything but some parts of the meshes: number and positions of nodes, cells, groups,
    /// arrays.
    pub fn keep(&mut self, [nodes, cells, groups, arrays]: [bool; 4]) {
        if !nodes {
            self.moved_nodes = 0;
            self.first_moved = None;
            self.furthest = None;
            self.unpaired_nodes = [0; 2];
            self.n_nodes[1] = self.n_nodes[0];
            self.nodes.clear();
        }
        if !cells {
            self.changed_cells = 0;
            self.cells.clear();
        }
        if !groups {
            self.groups.clear();
        }
        if !arrays {
            self.arrays.clear();
        }
    }

    /// Largest distance between two nodes that belong together; 0 without nodes.
    pub fn max_distance(&self) -> f64 {
        self.furthest.map_or(0.0, |pair| pair.distance)
    }

    /// Lists the differences in one line; empty without any.
    pub fn what_differs(&self) -> String {
        let mut parts = Vec::new();
        let [ours, theirs] = self.n_nodes;
        if ours != theirs {
            parts.push(format!("{ours} and {theirs} nodes"));
        }
        if let (true, Some(worst)) = (self.moved_nodes > 0, self.furthest) {
            let (node, by) = (worst.node, short(worst.distance));
            parts.push(match self.moved_nodes {
                1 => format!("1 node differs: node {node}, by {by}"),
                n => format!("{n} nodes differ, node {node} by the most ({by})"),
            });
        }
        if !self.nodes.is_empty() {
            let [ours, theirs] = self.unpaired_nodes;
            parts.push(format!(
                "{} of the first mesh and {theirs} of the second have no partner",
                counted(ours, "node")
            ));
        }
        if !self.cells.is_empty() {
            parts.push(with_verb(self.changed_cells, "cell", "differs"));
        }
        for (what, sentences) in [("groups", &self.groups), ("arrays", &self.arrays)] {
            match &sentences[..] {
                [] => {}
                [one] => parts.push(one.clone()),
                many => parts.push(format!("{} {what} differ", many.len())),
            }
        }
        parts.join("; ")
    }
}

/// One line: what differs, or that nothing does.
impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.is_same() {
            return write!(f, "different: {}", one_line(&self.what_differs()));
        }
        let [n_nodes, n_cells] = [self.n_nodes[0], self.n_cells[0]];
        write!(
            f,
            "same: {}, {}",
            counted(n_nodes, "node"),
            counted(n_cells, "cell")
        )?;
        match self.max_distance() {
            0.0 => Ok(()),
            furthest => write!(f, ", nodes at most {} apart", short(furthest)),
        }
    }
}

fn diagonal(mesh: &Mesh) -> f64 {
    mesh.bounds()
        .map_or(0.0, |[low, high]| nodes::distance(low, high))
}

#[cfg(test)]
mod tests;

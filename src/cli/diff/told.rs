//! A difference as lines and as JSON.

use azimesh_core::error::one_line;
use azimesh_core::numbers::short;
use azimesh_io::mesh::Difference;
use azimesh_io::mesh::difference::NodePair;
use serde::Serialize;

/// A line for each difference, behind `indent`.
pub fn details(difference: &Difference, indent: &str) -> String {
    let mut lines = Vec::new();
    if let Some(pair) = difference.first_moved {
        lines.push(format!("first node that differs: {}", describe(&pair)));
    }
    if let (Some(pair), true) = (difference.furthest, difference.max_distance() > 0.0) {
        lines.push(format!("node that differs most: {}", describe(&pair)));
    }
    let sentences = [
        &difference.nodes,
        &difference.cells,
        &difference.groups,
        &difference.arrays,
    ];
    lines.extend(sentences.into_iter().flatten().cloned());
    lines
        .iter()
        .map(|line| format!("{indent}{}\n", one_line(line)))
        .collect()
}

fn describe(pair: &NodePair) -> String {
    let NodePair {
        node,
        partner,
        a,
        b,
        distance,
    } = pair;
    let partner = if node == partner {
        String::new()
    } else {
        format!(" and {partner}")
    };
    format!(
        "{node}{partner}, {a:?} and {b:?}, {} apart",
        short(*distance)
    )
}

/// The difference of two meshes.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MeshDifference {
    /// True if they are the same.
    same: bool,
    /// The line that is printed without `--json`.
    summary: String,
    /// Nodes of both meshes.
    nodes: [usize; 2],
    /// Nodes whose distance is above the tolerance.
    moved_nodes: usize,
    /// Largest distance of two nodes, mesh units.
    max_distance: f64,
    /// First node that differs; null where none does.
    first_moved: Option<Pair>,
    /// The nodes of the largest distance; null without nodes.
    furthest: Option<Pair>,
    /// Nodes without a partner, in both meshes.
    unpaired_nodes: [usize; 2],
    /// Cells of both meshes.
    cells: [usize; 2],
    /// Cells that differ.
    changed_cells: usize,
    /// Differences of nodes, as sentences.
    node_differences: Vec<String>,
    /// Differences of cells.
    cell_differences: Vec<String>,
    /// Differences of tags, zones and other groups.
    group_differences: Vec<String>,
    /// Differences of arrays.
    array_differences: Vec<String>,
}

/// Two nodes.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Pair {
    /// Node of the first mesh, from 0.
    node: usize,
    /// Node of the second mesh.
    partner: usize,
    /// Position in the first.
    a: [f64; 3],
    /// Position in the second.
    b: [f64; 3],
    /// Distance, mesh units.
    distance: f64,
}

impl MeshDifference {
    pub fn of(difference: &Difference) -> Self {
        Self {
            same: difference.is_same(),
            summary: difference.to_string(),
            nodes: difference.n_nodes,
            moved_nodes: difference.moved_nodes,
            max_distance: difference.max_distance(),
            first_moved: difference.first_moved.map(Pair::of),
            furthest: difference.furthest.map(Pair::of),
            unpaired_nodes: difference.unpaired_nodes,
            cells: difference.n_cells,
            changed_cells: difference.changed_cells,
            node_differences: difference.nodes.clone(),
            cell_differences: difference.cells.clone(),
            group_differences: difference.groups.clone(),
            array_differences: difference.arrays.clone(),
        }
    }
}

impl Pair {
    fn of(pair: NodePair) -> Self {
        let NodePair {
            node,
            partner,
            a,
            b,
            distance,
        } = pair;
        Self {
            node,
            partner,
            a,
            b,
            distance,
        }
    }
}

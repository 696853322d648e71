//! A difference as lines and as JSON.

use azimesh_core::diagnostic::short;
use azimesh_core::error::one_line;
use azimesh_io::mesh::Difference;
use azimesh_io::mesh::difference::NodePair;
use serde_json::{Value, json};

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
    let partner = match node == partner {
        true => String::new(),
        false => format!(" and {partner}"),
    };
    format!(
        "{node}{partner}, {a:?} and {b:?}, {} apart",
        short(*distance)
    )
}

/// All there is to know.
pub fn as_json(difference: &Difference) -> Value {
    let pair = |pair: &NodePair| {
        json!({
            "node": pair.node,
            "partner": pair.partner,
            "a": pair.a,
            "b": pair.b,
            "distance": pair.distance,
        })
    };
    json!({
        "same": difference.is_same(),
        "summary": difference.to_string(),
        "nodes": difference.n_nodes,
        "moved_nodes": difference.moved_nodes,
        "max_distance": difference.max_distance(),
        "first_moved": difference.first_moved.as_ref().map(pair),
        "furthest": difference.furthest.as_ref().map(pair),
        "unpaired_nodes": difference.unpaired_nodes,
        "cells": difference.n_cells,
        "changed_cells": difference.changed_cells,
        "node_differences": difference.nodes,
        "cell_differences": difference.cells,
        "group_differences": difference.groups,
        "array_differences": difference.arrays,
        "notes": difference.notes,
    })
}

//! The facts as JSON.

use super::facts::Facts;
use azimesh_io::mesh::{DataArray, Group};
use serde_json::{Value, json};

/// All facts.
pub fn of(facts: &Facts) -> Value {
    let mesh = facts.mesh;
    let kinds = facts.cells.iter();
    let by_kind: serde_json::Map<String, Value> = kinds
        .map(|(kind, count)| (kind.name().to_owned(), (*count).into()))
        .collect();
    let boundary = &facts.boundary;
    json!({
        "format": facts.format,
        "format_version": facts.version,
        "times": facts.times,
        "dimension": mesh.dimension(),
        "nodes": mesh.points.len(),
        "orphan_nodes": facts.n_orphan_nodes,
        "repeated_nodes": facts.n_repeated_nodes,
        "cells": mesh.cells.len(),
        "cells_by_kind": by_kind,
        "curved_cells": facts.n_curved,
        "negative_cells": facts.flaws.negative.n,
        "reversed_cells": facts.flaws.reversed.n,
        "degenerate_cells": facts.flaws.degenerate.n,
        "folded_cells": facts.flaws.folded.n,
        "zones": groups(mesh.zones(), "cells"),
        "boundary_tags": groups(mesh.boundary_tags(), "faces"),
        "other_groups": groups(facts.other_groups(), "cells"),
        "faces_without_tag": boundary.n_untagged,
        "open_faces": boundary.n_open,
        "inside_faces": boundary.n_inside,
        "loose_faces": boundary.n_dangling,
        "crowded_faces": boundary.n_non_manifold,
        "bounds": mesh.bounds(),
        "arrays": facts.arrays().map(|(at, array)| of_array(at, array)).collect::<Vec<_>>(),
        "notes": facts.notes,
    })
}

fn groups<'a>(groups: impl Iterator<Item = &'a Group>, of: &str) -> Vec<Value> {
    groups
        .map(|group| {
            json!({
                "name": group.name,
                "number": group.number,
                "condition": group.condition,
                of: group.cells.len(),
            })
        })
        .collect()
}

fn of_array(at: &str, array: &DataArray) -> Value {
    json!({
        "name": array.name,
        "at": at,
        "type": array.values.type_name(),
        "components": array.n_components,
        "ranges": array.values.ranges(array.n_components),
    })
}

//! `azimesh info`.

use super::{Context, Outcome};
use crate::error::Result;
use crate::mesh::{CellKind, DataArray, Group, Mesh};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

/// Arguments of `azimesh info`.
#[derive(Debug, clap::Args)]
pub struct InfoArgs {
    /// Mesh to look at; - is standard input
    mesh: PathBuf,
}

pub(super) fn run(args: &InfoArgs, context: &Context) -> Result<Outcome> {
    let mesh = context.read_mesh(&args.mesh)?;
    if context.common.json {
        context.print_json(as_json(&mesh))?;
    } else {
        context.print(&as_text(&mesh))?;
    }
    Ok(Outcome::Fine)
}

fn cells_by_kind(mesh: &Mesh) -> BTreeMap<CellKind, usize> {
    let mut counts = BTreeMap::new();
    for run in mesh.cells.runs() {
        *counts.entry(run.kind).or_default() += run.n_cells();
    }
    counts
}

/// Groups that are neither boundary tags nor zones.
fn other_groups(mesh: &Mesh) -> impl Iterator<Item = &Group> {
    let dimension = mesh.dimension();
    mesh.groups
        .iter()
        .filter(move |group| group.dimension + 1 < dimension || group.dimension > dimension)
}

/// Boundary faces in the file that no tag holds.
fn faces_without_tag(mesh: &Mesh) -> usize {
    let Some(dimension) = mesh.dimension().checked_sub(1) else {
        return 0;
    };
    let mut tagged = vec![false; mesh.cells.len()];
    for range in mesh.boundary_tags().flat_map(|tag| tag.cells.ranges()) {
        tagged[range].fill(true);
    }
    let runs = mesh
        .cells
        .runs()
        .filter(|run| run.kind.dimension() == dimension);
    runs.map(|run| {
        let cells = &tagged[run.first_cell..run.first_cell + run.n_cells()];
        cells.iter().filter(|&&tagged| !tagged).count()
    })
    .sum()
}

fn arrays(mesh: &Mesh) -> [(&'static str, &[DataArray]); 3] {
    [
        ("point", &mesh.point_arrays),
        ("cell", &mesh.cell_arrays),
        ("field", &mesh.field_arrays),
    ]
}

fn as_text(mesh: &Mesh) -> String {
    let mut rows: Vec<(String, String)> = vec![
        ("dimension".into(), mesh.dimension().to_string()),
        ("nodes".into(), mesh.points.len().to_string()),
        ("cells".into(), mesh.cells.len().to_string()),
    ];
    for (kind, count) in cells_by_kind(mesh) {
        rows.push((format!("  {}", kind.name()), count.to_string()));
    }
    list(&mut rows, "zones", mesh.zones(), "cells");
    list(&mut rows, "boundary tags", mesh.boundary_tags(), "faces");
    let untagged = faces_without_tag(mesh);
    if untagged > 0 {
        rows.push(("  without a tag".into(), format!("{untagged} faces")));
    }
    if other_groups(mesh).next().is_some() {
        list(&mut rows, "other groups", other_groups(mesh), "cells");
    }
    if let Some([low, high]) = mesh.bounds() {
        for (axis, i) in ["x", "y", "z"].into_iter().zip(0..) {
            rows.push((axis.into(), format!("{} to {}", low[i], high[i])));
        }
    }
    for (place, arrays) in arrays(mesh) {
        for array in arrays {
            let n = array.n_components;
            let components = if n == 1 { "" } else { "s" };
            let name = format!("{place} array");
            rows.push((name, format!("{} ({n} component{components})", array.name)));
        }
    }
    let width = rows.iter().map(|(name, _)| name.chars().count()).max();
    let width = width.unwrap_or(0) + 2;
    rows.iter().fold(String::new(), |mut text, (name, value)| {
        let line = format!("{name:width$}{value}");
        writeln!(text, "{}", line.trim_end()).expect("a string takes any text");
        text
    })
}

fn list<'a>(
    rows: &mut Vec<(String, String)>,
    title: &str,
    groups: impl Iterator<Item = &'a Group>,
    of: &str,
) {
    let first = rows.len();
    rows.extend(groups.map(|group| {
        let count = format!("{} {of}", group.cells.len());
        (format!("  {}", group.name), count)
    }));
    let n = rows.len() - first;
    let count = if n == 0 { "none".into() } else { n.to_string() };
    rows.insert(first, (title.into(), count));
}

fn as_json(mesh: &Mesh) -> Value {
    let by_kind: serde_json::Map<String, Value> = cells_by_kind(mesh)
        .into_iter()
        .map(|(kind, count)| (kind.name().to_owned(), count.into()))
        .collect();
    let group = |group: &Group, of: &str| json!({ "name": group.name, "number": group.number, of: group.cells.len() });
    let arrays: Vec<Value> = arrays(mesh)
        .into_iter()
        .flat_map(|(place, arrays)| arrays.iter().map(move |array| (place, array)))
        .map(|(place, array)| {
            let (name, components) = (&array.name, array.n_components);
            json!({ "name": name, "at": place, "components": components })
        })
        .collect();
    json!({
        "dimension": mesh.dimension(),
        "nodes": mesh.points.len(),
        "cells": mesh.cells.len(),
        "cells_by_kind": by_kind,
        "zones": mesh.zones().map(|g| group(g, "cells")).collect::<Vec<_>>(),
        "boundary_tags": mesh.boundary_tags().map(|g| group(g, "faces")).collect::<Vec<_>>(),
        "other_groups": other_groups(mesh).map(|g| group(g, "cells")).collect::<Vec<_>>(),
        "faces_without_tag": faces_without_tag(mesh),
        "bounds": mesh.bounds(),
        "arrays": arrays,
    })
}

//! The facts as lines of text.

use super::facts::Facts;
use crate::mesh::{DataArray, Group};
use std::fmt::Write;

/// Lines of a name and a value.
struct Rows(Vec<(String, String)>);

impl Rows {
    fn push(&mut self, name: impl Into<String>, value: impl ToString) {
        self.0.push((name.into(), value.to_string()));
    }

    /// A count that is told only where there is something to tell.
    fn push_some(&mut self, name: &str, n: usize, of: &str) {
        if n > 0 {
            self.push(format!("  {name}"), format!("{n}{of}"));
        }
    }

    fn list<'a>(&mut self, title: &str, groups: impl Iterator<Item = &'a Group>, of: &str) {
        let first = self.0.len();
        for group in groups {
            let condition = group.condition.as_ref();
            let condition = condition.map_or(String::new(), |words| format!(" ({words})"));
            let count = format!("{} {of}{condition}", group.cells.len());
            self.push(format!("  {}", group.name), count);
        }
        let n = self.0.len() - first;
        let count = if n == 0 { "none".into() } else { n.to_string() };
        self.0.insert(first, (title.into(), count));
    }
}

/// All facts, a line each.
pub fn of(facts: &Facts) -> String {
    let mesh = facts.mesh;
    let mut rows = Rows(Vec::new());
    let version = facts.version.as_ref();
    let version = version.map_or(String::new(), |version| format!(", version {version}"));
    rows.push("format", format!("{}{version}", facts.format));
    if let Some(times) = &facts.times {
        let from = times.iter().copied().fold(f64::INFINITY, f64::min);
        let to = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let n = times.len();
        rows.push(
            "steps",
            format!("{n}, times {from} to {to}; the last follows"),
        );
    }
    rows.push("dimension", mesh.dimension());
    rows.push("nodes", mesh.points.len());
    rows.push_some("in no cell", facts.n_orphan_nodes, "");
    rows.push_some("at the place of another", facts.n_repeated_nodes, "");
    rows.push("cells", mesh.cells.len());
    for (kind, count) in &facts.cells {
        let curved = if kind.is_curved() { " (curved)" } else { "" };
        rows.push(format!("  {}", kind.name()), format!("{count}{curved}"));
    }
    rows.list("zones", mesh.zones(), "cells");
    rows.list("boundary tags", mesh.boundary_tags(), "faces");
    let boundary = &facts.boundary;
    rows.push_some("without a tag", boundary.n_untagged, " faces");
    rows.push_some(
        "open",
        boundary.n_open,
        " faces of one cell that no tag holds",
    );
    rows.push_some(
        "inside",
        boundary.n_inside,
        " tagged faces between two cells",
    );
    rows.push_some("loose", boundary.n_loose, " boundary faces on no cell");
    rows.push_some(
        "crowded",
        boundary.n_crowded,
        " faces of more than two cells",
    );
    if facts.other_groups().next().is_some() {
        rows.list("other groups", facts.other_groups(), "cells");
    }
    if let Some([low, high]) = mesh.bounds() {
        for (axis, i) in ["x", "y", "z"].into_iter().zip(0..) {
            rows.push(axis, format!("{} to {}", low[i], high[i]));
        }
    }
    for (place, array) in facts.arrays() {
        rows.push(format!("{place} array"), told(array));
    }
    rows.0
        .iter()
        .fold(String::new(), |mut text, (name, value)| {
            let width = rows.0.iter().map(|(name, _)| name.chars().count()).max();
            let width = width.unwrap_or(0) + 2;
            let line = format!("{name:width$}{value}");
            writeln!(text, "{}", line.trim_end()).expect("a string takes any text");
            text
        })
}

/// Name, type, components and range of an array.
fn told(array: &DataArray) -> String {
    let n = array.n_components;
    let plural = if n == 1 { "" } else { "s" };
    let what = format!(
        "{} ({}, {n} component{plural})",
        array.name,
        array.values.type_name()
    );
    let ranges = array.values.ranges(n);
    if ranges.is_empty() || n > 3 {
        return what;
    }
    let ranges: Vec<String> = ranges
        .iter()
        .map(|range| match range {
            Some([low, high]) => format!("{low} to {high}"),
            None => "no number".to_owned(),
        })
        .collect();
    format!("{what} {}", ranges.join(", "))
}

//! The quality as text.

use super::worst::WorstCell;
use super::{Findings, Judged};
use azimesh_core::error::one_line;
use azimesh_core::numbers::{point, short};
use azimesh_quality::{Assessment, CURVED_COLUMNS, Extreme, Flawed, Statistic};
use std::fmt::Write;

/// Number of rows of a sequence printed by default.
const WORST_ROWS: usize = 10;

const ANY_TEXT: &str = "a string takes any text";

/// Formats the results as text: a line per number of one mesh, a row per mesh of a sequence.
pub(super) fn as_text(findings: &Findings<'_>) -> String {
    let mut text = match &findings.meshes[..] {
        [
            Judged {
                step: None,
                quality,
                ..
            },
        ] => of_mesh(quality, findings.flaws.negative),
        meshes => of_sequence(meshes, findings),
    };
    if let Some(metrics) = &findings.metrics {
        text += &of_metrics(metrics);
    }
    for cell in findings.listed() {
        writeln!(text, "{}", one_line(&of_cell(cell))).expect(ANY_TEXT);
    }
    text
}

fn of_mesh(quality: &Assessment, negative: Flawed) -> String {
    let summary = &quality.cells;
    let mut text = String::new();
    // As wide as the longest name.
    let width = if summary.min_curved[1].is_some() {
        26
    } else {
        23
    };
    let mut row = |name: &str, value: String| {
        writeln!(text, "{name:width$} {value}").expect(ANY_TEXT);
    };
    row("cells", summary.n_cells.to_string());
    row(
        "faces",
        (quality.faces.n_inner + quality.faces.n_outer).to_string(),
    );
    let first = |cell| format!("  (cell {cell})");
    let first = negative.first.map_or_else(String::new, first);
    row("negative_cells", format!("{}{first}", negative.n));
    for (name, value) in quality.columns() {
        if value.is_none() && CURVED_COLUMNS.contains(&name) {
            continue;
        }
        let at =
            extreme(quality, name).map_or_else(String::new, |e| format!("  (cell {})", e.cell));
        let value = value.map_or_else(|| "-".into(), short);
        row(name, format!("{value}{at}"));
    }
    row("total_volume", short(summary.total_volume));
    if !summary.inverted_cells.is_empty() {
        let named = summary.inverted_cells.iter().map(usize::to_string);
        row("inverted cells", named.collect::<Vec<_>>().join(" "));
    }
    text
}

/// A column is as wide as its name and numbers need.
fn of_sequence(meshes: &[Judged], findings: &Findings<'_>) -> String {
    let mut shown: Vec<&Judged> = meshes.iter().collect();
    if !findings.all && meshes.len() > WORST_ROWS {
        let jacobian = |mesh: &Judged| {
            let least = mesh.quality.cells.min_scaled_jacobian;
            least.map_or(f64::INFINITY, |least| least.value)
        };
        shown.sort_by(|a, b| jacobian(a).total_cmp(&jacobian(b)));
        shown.truncate(WORST_ROWS);
    }
    let mut text = rows_of(&shown);
    if shown.len() < meshes.len() {
        writeln!(
            text,
            "the {WORST_ROWS} worst of {} steps; --all prints every row",
            meshes.len()
        )
        .expect(ANY_TEXT);
    }
    if let Some(cell) = findings.worst_of_sequence() {
        writeln!(text, "worst: {}", one_line(&of_cell(cell))).expect(ANY_TEXT);
    }
    text
}

fn rows_of(meshes: &[&Judged]) -> String {
    let names = ["step", "time"].into_iter();
    let is_curved = |mesh: &&Judged| mesh.quality.cells.min_curved[1].is_some();
    let is_shown = |name: &str| !CURVED_COLUMNS.contains(&name) || meshes.iter().any(is_curved);
    let columns = Assessment::default().columns();
    let columns = columns.iter().map(|(name, _)| *name);
    let columns = columns.filter(|name| is_shown(name));
    let mut rows: Vec<Vec<String>> = vec![names.chain(columns).map(str::to_owned).collect()];
    for mesh in meshes {
        let place = mesh.step.map_or(Vec::new(), |step| {
            vec![step.index.to_string(), short(step.time)]
        });
        let values = mesh.quality.columns().into_iter();
        let values = values.filter(|(name, _)| is_shown(name));
        let values = values.map(|(_, value)| value.map_or_else(|| "-".into(), short));
        rows.push(place.into_iter().chain(values).collect());
    }
    aligned(&rows)
}

fn of_metrics(metrics: &[Statistic]) -> String {
    let head = ["metric", "cells", "min", "mean", "max", "min at", "max at"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for metric in metrics {
        let (Some(min), Some(max)) = (metric.min, metric.max) else {
            continue;
        };
        rows.push(vec![
            metric.name.to_owned(),
            metric.n_cells.to_string(),
            short(min.value),
            metric.mean.map_or_else(|| "-".into(), short),
            short(max.value),
            min.cell.to_string(),
            max.cell.to_string(),
        ]);
    }
    format!("\n{}", aligned(&rows))
}

/// The first column to the left, the others to the right.
fn aligned(rows: &[Vec<String>]) -> String {
    let n_columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter()
            .filter_map(|row| row.get(column))
            .map(String::len)
            .max()
    };
    let widths: Vec<usize> = (0..n_columns)
        .map(|column| width(column).unwrap_or(0))
        .collect();
    let mut text = String::new();
    for row in rows {
        for (i, (cell, width)) in row.iter().zip(&widths).enumerate() {
            match i {
                0 => write!(text, "{cell:width$}"),
                _ => write!(text, "  {cell:>width$}"),
            }
            .expect(ANY_TEXT);
        }
        text.push('\n');
    }
    text
}

fn of_cell(cell: &WorstCell) -> String {
    let step = cell.step.map_or_else(String::new, |step| {
        format!("step {} (time {}), ", step.index, short(step.time))
    });
    let (kind, i) = (cell.kind, cell.found.cell);
    let volume = short(cell.found.volume);
    let scaled = match cell.found.scaled_jacobian {
        none if none.is_nan() => String::new(),
        scaled => format!("scaled Jacobian {}, ", short(scaled)),
    };
    let touching = if cell.tags.is_empty() {
        String::new()
    } else {
        format!(", at {}", cell.tags.join(", "))
    };
    let nearest = cell
        .nearest
        .as_ref()
        .map_or_else(String::new, |(name, distance)| {
            format!(", nearest tag {name} at distance {}", short(*distance))
        });
    let position = point(&cell.position);
    format!("{step}{kind} {i} at {position}: {scaled}volume {volume}{touching}{nearest}")
}

fn extreme(quality: &Assessment, column: &str) -> Option<Extreme> {
    let (summary, faces) = (&quality.cells, &quality.faces);
    match column {
        "min_volume" => summary.min_volume,
        "min_scaled_jacobian" => summary.min_scaled_jacobian,
        "min_curved_jacobian" => summary.min_curved[0],
        "min_curved_scaled_jacobian" => summary.min_curved[1],
        "max_edge_ratio" => summary.max_edge_ratio,
        "max_skew" => summary.max_skew,
        "max_non_orthogonality" => faces.max_non_orthogonality,
        "max_face_skewness" => faces.max_face_skewness,
        "min_volume_ratio" => faces.min_volume_ratio,
        "min_face_weight" => faces.min_face_weight,
        "min_size_skew" => quality.cells.size_skew.min,
        _ => None,
    }
}

//! What `azimesh quality` prints: text for people, JSON for programs.

use super::worst::WorstCell;
use super::{Findings, Judged};
use azimesh_core::diagnostic::{point, short};
use azimesh_core::error::one_line;
use azimesh_quality::{Assessment, Extreme, Statistic};
use serde_json::{Map, Value, json};
use std::fmt::Write;

const ANY_TEXT: &str = "a string takes any text";

/// As text: a line a number of one mesh, a row a mesh of a sequence.
pub(super) fn as_text(findings: &Findings<'_>) -> String {
    let mut text = match &findings.meshes[..] {
        [
            Judged {
                step: None,
                quality,
                ..
            },
        ] => of_mesh(quality),
        meshes => of_sequence(meshes),
    };
    if let Some(metrics) = &findings.metrics {
        text += &of_metrics(metrics);
    }
    for cell in &findings.worst.cells {
        writeln!(text, "{}", one_line(&of_cell(cell))).expect(ANY_TEXT);
    }
    text
}

fn of_mesh(quality: &Assessment) -> String {
    let summary = &quality.cells;
    let mut text = String::new();
    let mut row = |name: &str, value: String| {
        writeln!(text, "{name:24}{value}").expect(ANY_TEXT);
    };
    row("cells", summary.n_cells.to_string());
    row(
        "faces",
        (quality.faces.n_inner + quality.faces.n_outer).to_string(),
    );
    for (name, value) in quality.columns() {
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
fn of_sequence(meshes: &[Judged]) -> String {
    let names = ["step", "time"].into_iter();
    let columns = Assessment::default().columns();
    let columns = columns.iter().map(|(name, _)| *name);
    let mut rows: Vec<Vec<String>> = vec![names.chain(columns).map(str::to_owned).collect()];
    for mesh in meshes {
        let place = mesh.step.map_or(Vec::new(), |step| {
            vec![step.index.to_string(), short(step.time)]
        });
        let values = mesh.quality.columns().into_iter();
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
    let step = cell
        .step
        .map_or_else(String::new, |step| format!("step {}, ", step.index));
    let (kind, i) = (cell.kind, cell.found.cell);
    let volume = short(cell.found.volume);
    let scaled = match cell.found.scaled_jacobian {
        none if none.is_nan() => String::new(),
        scaled => format!("scaled Jacobian {}, ", short(scaled)),
    };
    let touching = match cell.tags.is_empty() {
        true => String::new(),
        false => format!(", at {}", cell.tags.join(", ")),
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

/// The values as JSON: the numbers of one mesh at the top, those of a sequence in `steps`.
pub(super) fn as_json(findings: &Findings<'_>) -> Value {
    let mut object = Map::new();
    match &findings.meshes[..] {
        [
            Judged {
                step: None,
                quality,
                ..
            },
        ] => json_of_mesh(&mut object, quality),
        meshes => {
            let steps = meshes.iter().map(|mesh| {
                let mut row = Map::new();
                if let Some(step) = mesh.step {
                    row.insert("step".into(), step.index.into());
                    row.insert("time".into(), json!(step.time));
                }
                json_of_mesh(&mut row, &mesh.quality);
                Value::Object(row)
            });
            object.insert("steps".into(), steps.collect());
        }
    }
    if let Some(metrics) = &findings.metrics {
        object.insert("metrics".into(), json_of_metrics(metrics));
    }
    let worst = findings.worst.cells.iter().map(json_of_cell);
    object.insert("worst".into(), worst.collect());
    let met = findings.met();
    let failed = met.iter().map(|(criterion, _)| criterion.to_string());
    object.insert("failed_on".into(), failed.collect());
    let failures = met.iter().flat_map(|(criterion, met)| {
        met.iter().map(|(step, value)| {
            let place = step.map_or_else(String::new, |step| format!("step {}: ", step.index));
            json!({
                "message": place + &criterion.sentence("", *value),
                "metric": criterion.column(),
                "value": value,
                "limit": criterion.limit(),
                "step": step.map(|step| step.index),
            })
        })
    });
    object.insert("failures".into(), failures.collect());
    if findings.meshes.iter().any(|mesh| mesh.step.is_some()) {
        let steps = met.iter().map(|(criterion, met)| {
            let steps = met
                .iter()
                .filter_map(|(step, _)| Some(step.as_ref()?.index));
            (criterion.to_string(), steps.collect())
        });
        let steps: Map<String, Value> = steps.collect();
        object.insert("failed_steps".into(), Value::Object(steps));
    }
    Value::Object(object)
}

fn json_of_mesh(object: &mut Map<String, Value>, quality: &Assessment) {
    let summary = &quality.cells;
    object.insert("cells".into(), summary.n_cells.into());
    object.insert("inner_faces".into(), quality.faces.n_inner.into());
    object.insert("outer_faces".into(), quality.faces.n_outer.into());
    for (name, value) in quality.columns() {
        let value = match (name, value) {
            ("inverted" | "inverted_reference" | "unproven", Some(count)) => json!(count as u64),
            (_, value) => json!(value),
        };
        object.insert(name.into(), value);
        if let Some(extreme) = extreme(quality, name) {
            object.insert(format!("{name}_cell"), extreme.cell.into());
        }
    }
    object.insert("total_volume".into(), json!(summary.total_volume));
    object.insert("inverted_cells".into(), json!(summary.inverted_cells));
}

fn json_of_metrics(metrics: &[Statistic]) -> Value {
    let value = |extreme: Option<Extreme>| extreme.map(|e| e.value);
    let cell = |extreme: Option<Extreme>| extreme.map(|e| e.cell);
    let entries = metrics.iter().map(|metric| {
        let entry = json!({
            "cells": metric.n_cells,
            "min": value(metric.min),
            "mean": metric.mean,
            "max": value(metric.max),
            "min_cell": cell(metric.min),
            "max_cell": cell(metric.max),
        });
        (metric.name.to_owned(), entry)
    });
    Value::Object(entries.collect())
}

fn json_of_cell(cell: &WorstCell) -> Value {
    let mut object = Map::new();
    if let Some(step) = cell.step {
        object.insert("step".into(), step.index.into());
    }
    let nearest = cell.nearest.as_ref();
    let rest = [
        ("cell", json!(cell.found.cell)),
        ("kind", json!(cell.kind)),
        ("position", json!(cell.position)),
        ("scaled_jacobian", json!(cell.found.scaled_jacobian)),
        ("volume", json!(cell.found.volume)),
        ("tags", json!(cell.tags)),
        ("nearest_tag", json!(nearest.map(|(name, _)| name))),
        ("distance", json!(nearest.map(|(_, distance)| distance))),
    ];
    object.extend(rest.map(|(key, value)| (key.to_owned(), value)));
    Value::Object(object)
}

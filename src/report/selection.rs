//! How the error fell while base points were chosen.

use super::folder::Sequence;
use super::plot::Plot;
use super::series::Series;
use crate::record::LayerRecord;
use std::collections::BTreeMap;

/// Selections that are drawn in one plot.
const DRAWN: usize = 6;

/// A plot for each kind of layer: residuals of every selection, or of some of them.
pub fn plots(sequence: &Sequence) -> Vec<Plot> {
    let mut by_layer: BTreeMap<&str, Vec<(usize, &LayerRecord)>> = BTreeMap::new();
    for selection in &sequence.record.selections {
        for layer in &selection.layers {
            let drawn = by_layer.entry(&layer.of).or_default();
            drawn.push((selection.first_step, layer));
        }
    }
    let plots = by_layer
        .into_iter()
        .filter_map(|(of, layers)| plot(of, &layers, sequence.length_unit()));
    plots.collect()
}

fn plot(of: &str, layers: &[(usize, &LayerRecord)], length_unit: &str) -> Option<Plot> {
    let drawn = layers.len().min(DRAWN);
    let place = |i: usize| match drawn {
        1 => 0,
        _ => i * (layers.len() - 1) / (drawn - 1),
    };
    let series = (0..drawn).flat_map(|style| {
        let (first_step, layer) = layers[place(style)];
        series_of(layer, style, (layers.len() > 1).then_some(first_step))
    });
    let series: Vec<Series> = series.collect();
    let (title, unit) = match of {
        "rotation_nodes" => ("Base points of the rotation", "of the rotation"),
        _ => ("Base points", length_unit),
    };
    let tolerance = layers.first().and_then(|(_, layer)| layer.tolerance);
    let remark = match layers.len() > drawn {
        true => format!("{drawn} of {} selections.", layers.len()),
        false => String::new(),
    };
    (!series.is_empty()).then(|| Plot {
        title: title.to_owned(),
        x: "base points".to_owned(),
        y: format!("error, {unit}"),
        is_log: true,
        series,
        levels: tolerance
            .map(|value| ("tolerance".to_owned(), value))
            .into_iter()
            .collect(),
        remark,
        ..Plot::default()
    })
}

/// The residual of each base point, and the errors of the sweeps where there is one selection;
/// `first_step` is that of one selection among several.
fn series_of(layer: &LayerRecord, style: usize, first_step: Option<usize>) -> Vec<Series> {
    let residuals = (0..).zip(&layer.residuals);
    let residuals = residuals.map(|(n, residual): (u32, _)| (f64::from(n), *residual));
    let sweeps = layer.history.iter().map(|(n, error)| (*n as f64, *error));
    let name = match first_step {
        None => "error of the base point chosen next".to_owned(),
        Some(step) => format!("chosen at step {step}"),
    };
    let mut lines = vec![(name, style, residuals.collect::<Vec<_>>())];
    if first_step.is_none() {
        let name = "largest error at a sweep over all nodes".to_owned();
        lines.push((name, 1, sweeps.collect()));
    }
    lines.retain(|(_, _, points)| !points.is_empty());
    let series = lines.into_iter().map(|(name, style, points)| Series {
        name,
        style,
        column: None,
        points,
    });
    series.collect()
}

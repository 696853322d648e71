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
        .filter_map(|(of, layers)| plot(of, &layers));
    plots.collect()
}

fn plot(of: &str, layers: &[(usize, &LayerRecord)]) -> Option<Plot> {
    let drawn = layers.len().min(DRAWN);
    let place = |i: usize| match drawn {
        1 => 0,
        _ => i * (layers.len() - 1) / (drawn - 1),
    };
    let mut series = Vec::new();
    for style in 0..drawn {
        let (first_step, layer) = layers[place(style)];
        let name = match layers.len() {
            1 => "error of the base point chosen next".to_owned(),
            _ => format!("chosen at step {first_step}"),
        };
        let residuals = (0..).zip(&layer.residuals);
        let points: Vec<_> = residuals
            .map(|(n, residual): (u32, _)| (f64::from(n), *residual))
            .collect();
        if !points.is_empty() {
            series.push(Series {
                name,
                style,
                column: None,
                points,
            });
        }
        let sweeps: Vec<_> = layer
            .history
            .iter()
            .map(|(n, error)| (*n as f64, *error))
            .collect();
        if layers.len() == 1 && !sweeps.is_empty() {
            let name = "largest error at a sweep over all nodes".to_owned();
            series.push(Series {
                name,
                style: 1,
                column: None,
                points: sweeps,
            });
        }
    }
    let unit = match of {
        "rotation_nodes" => "of the rotation",
        _ => "mesh units",
    };
    let tolerance = layers.first().and_then(|(_, layer)| layer.tolerance);
    let remark = match layers.len() > drawn {
        true => format!("{drawn} of {} selections.", layers.len()),
        false => String::new(),
    };
    (!series.is_empty()).then(|| Plot {
        title: match of {
            "rotation_nodes" => "Base points of the rotation".to_owned(),
            _ => "Base points".to_owned(),
        },
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

//! The plots of the page: motion, errors, quality and time over the steps, and the choice of base points.

use super::folder::Sequence;
use super::plot::{Plot, Series, evenly};
use crate::record::LayerRecord;
use std::collections::BTreeMap;

/// Selections that are drawn in one plot.
const DRAWN: usize = 6;

/// Draws the columns of a sequence.
pub struct Charts<'a> {
    sequence: &'a Sequence,
    abscissa: &'static str,
}

impl<'a> Charts<'a> {
    /// Draws over the azimuth, the time or the number of the step.
    pub fn new(sequence: &'a Sequence) -> Self {
        let abscissa = sequence.abscissa();
        Self { sequence, abscissa }
    }

    /// Returns the places of the steps along the horizontal axis.
    pub fn places(&self) -> Vec<f64> {
        let x = self.sequence.table.numbers(self.abscissa);
        x.into_iter().map(|x| x.unwrap_or(0.0)).collect()
    }

    /// Draws columns with their names; `None` where none has a value.
    fn plot(&self, title: &str, y: &str, columns: &[(String, String)]) -> Option<Plot> {
        let known = columns
            .iter()
            .filter(|(column, _)| self.sequence.table.has(column));
        let series = known.enumerate().map(|(style, (column, name))| Series {
            name: name.clone(),
            style,
            column: Some(column.clone()),
            points: Vec::new(),
        });
        let series: Vec<Series> = series.collect();
        (!series.is_empty()).then(|| Plot {
            title: title.to_owned(),
            x: self.sequence.with_unit(self.abscissa),
            y: y.to_owned(),
            in_degrees: self.abscissa == "azimuth_deg",
            is_marked: true,
            series,
            ..Plot::default()
        })
    }

    /// Draws columns of the run with other names than their own.
    fn of_run(&self, title: &str, y: &str, columns: &[(&str, &str)]) -> Option<Plot> {
        let columns = columns
            .iter()
            .map(|(column, name)| ((*column).to_owned(), (*name).to_owned()));
        self.plot(title, y, &columns.collect::<Vec<_>>())
    }

    /// Draws one column under its own name.
    fn of_column(&self, column: &str) -> Option<Plot> {
        let (name, unit) = self.sequence.label(column);
        let y = if unit.is_empty() { &name } else { &unit };
        self.of_run(&capitalized(&name), y, &[(column, &name)])
    }

    /// Draws angles and displacements of the bodies.
    pub fn motion(&self) -> Vec<Plot> {
        let bodies = self.sequence.bodies();
        let length = self.sequence.length_unit();
        let mut plots = Vec::new();
        for (title, key, unit) in [
            ("Pitch", "pitch_deg", "degrees"),
            ("Flap", "flap_deg", "degrees"),
            ("Lag", "lag_deg", "degrees"),
            ("Angle", "angle_deg", "degrees"),
            ("Largest displacement", "max_displacement", length),
        ] {
            let columns = bodies
                .iter()
                .map(|body| (format!("{}/{key}", body.name), body.name.clone()));
            plots.extend(self.plot(title, unit, &columns.collect::<Vec<_>>()));
        }
        if let Some(body) = bodies.first() {
            let columns = ["x", "y", "z"]
                .map(|axis| (format!("{}/tip_{axis}", body.name), format!("along {axis}")));
            let title = format!("Displacement of the tip of {}", body.name);
            plots.extend(self.plot(&title, length, &columns));
        }
        if plots.is_empty() {
            plots.extend(self.of_column("max_displacement"));
        }
        plots
    }

    /// Draws base points, and errors at the surface.
    pub fn accuracy(&self) -> Vec<Plot> {
        let columns = ["selection_error", "max_surface_error", "rms_surface_error"];
        let labelled = columns.map(|column| (column.to_owned(), self.sequence.label(column).0));
        let errors = self.plot(
            "Errors at the surface",
            self.sequence.length_unit(),
            &labelled,
        );
        let errors = errors.map(|plot| Plot {
            is_log: true,
            levels: tolerance(self.sequence.record.options.tolerance),
            ..plot
        });
        from_zero(self.of_column("base_points"))
            .into_iter()
            .chain(errors)
            .collect()
    }

    /// Draws the quality of the cells.
    pub fn quality(&self) -> Vec<Plot> {
        let scaled = [
            ("min_scaled_jacobian", "smallest"),
            ("p01_scaled_jacobian", "first percentile"),
            ("mean_scaled_jacobian", "mean"),
        ];
        let change = [("min_size_skew", "smallest"), ("mean_size_skew", "mean")];
        let scaled = self.of_run("Scaled Jacobian", "1 is best, below 0 inverted", &scaled);
        let change = self.of_run("Size-skew against the reference", "1 is unchanged", &change);
        let mut plots: Vec<Plot> = scaled.into_iter().chain(change).collect();
        for plot in &mut plots {
            plot.bands = (1..plot.series.len()).map(|i| [i - 1, i]).collect();
        }
        for column in [
            "min_first_cell_ratio",
            "max_normal_change_deg",
            "max_skew",
            "max_non_orthogonality",
            "max_edge_ratio",
            "min_volume",
        ] {
            plots.extend(self.of_column(column));
        }
        if self
            .sequence
            .table
            .numbers("inverted")
            .into_iter()
            .flatten()
            .any(|n| n > 0.0)
        {
            plots.extend(self.of_column("inverted"));
        }
        plots
    }

    /// Draws the seconds of every step.
    pub fn time(&self) -> Option<Plot> {
        let title = "Seconds for each step".to_owned();
        from_zero(self.of_column("seconds")).map(|plot| Plot { title, ..plot })
    }

    /// Draws, for each kind of layer, the residuals of every selection or of some.
    pub fn base_points(&self) -> Vec<Plot> {
        let mut by_layer: BTreeMap<&str, Vec<(usize, &LayerRecord)>> = BTreeMap::new();
        for selection in &self.sequence.record.selections {
            for layer in &selection.layers {
                by_layer
                    .entry(&layer.of)
                    .or_default()
                    .push((selection.first_step, layer));
            }
        }
        let layers = by_layer.into_iter();
        layers
            .filter_map(|(of, layers)| residuals(of, &layers, self.sequence.length_unit()))
            .collect()
    }
}

fn residuals(of: &str, layers: &[(usize, &LayerRecord)], length_unit: &str) -> Option<Plot> {
    let drawn = evenly(layers.len(), DRAWN);
    let mut series = Vec::new();
    let mut add = |name: String, style: usize, points: Vec<(f64, Option<f64>)>| {
        if !points.is_empty() {
            series.push(Series {
                name,
                style,
                column: None,
                points,
            });
        }
    };
    for (style, &at) in drawn.iter().enumerate() {
        let (first_step, layer) = layers[at];
        let points = (0u32..)
            .map(f64::from)
            .zip(layer.residuals.iter().copied())
            .collect();
        if layers.len() > 1 {
            add(format!("chosen at step {first_step}"), style, points);
            continue;
        }
        let sweeps = layer
            .history
            .iter()
            .map(|(n, error)| (*n as f64, *error))
            .collect();
        add("error of the base point chosen next".to_owned(), 0, points);
        add(
            "largest error at a sweep over all nodes".to_owned(),
            1,
            sweeps,
        );
    }
    let (title, unit) = match of {
        "rotation_nodes" => ("Base points of the rotation", "of the rotation"),
        _ => ("Base points", length_unit),
    };
    let is_part = layers.len() > drawn.len();
    (!series.is_empty()).then(|| Plot {
        title: title.to_owned(),
        x: "base points".to_owned(),
        y: format!("error, {unit}"),
        is_log: true,
        series,
        levels: tolerance(layers.first().and_then(|(_, layer)| layer.tolerance)),
        remark: if is_part {
            format!("{} of {} selections.", drawn.len(), layers.len())
        } else {
            String::new()
        },
        ..Plot::default()
    })
}

fn from_zero(plot: Option<Plot>) -> Option<Plot> {
    let include = vec![0.0];
    plot.map(|plot| Plot { include, ..plot })
}

fn tolerance(value: Option<f64>) -> Vec<(String, f64)> {
    value
        .map(|value| ("tolerance".to_owned(), value))
        .into_iter()
        .collect()
}

/// Returns a text with a capital at the start.
pub fn capitalized(text: &str) -> String {
    let mut characters = text.chars();
    let first = characters.next().map(|c| c.to_uppercase().to_string());
    first.unwrap_or_default() + characters.as_str()
}

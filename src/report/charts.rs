//! The plots over the steps: motion, errors, quality, time.

use super::folder::Sequence;
use super::plot::Plot;
use super::series::Series;

/// Draws the columns of a sequence.
pub struct Charts<'a> {
    sequence: &'a Sequence,
    x: Vec<f64>,
    x_label: String,
    in_degrees: bool,
}

impl<'a> Charts<'a> {
    /// Over the azimuth, the time or the number of the step.
    pub fn new(sequence: &'a Sequence) -> Self {
        let abscissa = sequence.abscissa();
        let x = sequence.table.numbers(abscissa);
        Self {
            sequence,
            x: x.into_iter().map(|x| x.unwrap_or(0.0)).collect(),
            x_label: sequence.with_unit(abscissa),
            in_degrees: abscissa == "azimuth_deg",
        }
    }

    /// Places of the steps along the horizontal axis.
    pub fn places(&self) -> &[f64] {
        &self.x
    }

    /// A plot of columns; `None` where none has a value.
    fn plot(&self, title: &str, y: &str, columns: &[(String, String)]) -> Option<Plot> {
        let table = &self.sequence.table;
        let known = columns.iter().filter(|(column, _)| table.has(column));
        let series: Vec<Series> = known
            .enumerate()
            .map(|(style, (column, name))| Series {
                name: name.clone(),
                style,
                column: Some(column.clone()),
                points: self.x.iter().copied().zip(table.numbers(column)).collect(),
            })
            .collect();
        (!series.is_empty()).then(|| Plot {
            title: title.to_owned(),
            x: self.x_label.clone(),
            y: y.to_owned(),
            in_degrees: self.in_degrees,
            is_marked: true,
            series,
            ..Plot::default()
        })
    }

    /// A plot of one column under its own name.
    fn of_column(&self, column: &str) -> Option<Plot> {
        let (name, unit) = self.sequence.label(column);
        let title = capitalized(&name);
        let y = if unit.is_empty() { &name } else { &unit };
        self.plot(&title, y, &[(column.to_owned(), name.clone())])
    }

    /// Pitch, flap, lag and displacements of the bodies.
    pub fn motion(&self) -> Vec<Plot> {
        let bodies = self.sequence.bodies();
        let of_bodies = |key: &str| -> Vec<(String, String)> {
            let columns = bodies
                .iter()
                .map(|body| (format!("{}/{key}", body.name), body.name.clone()));
            columns.collect()
        };
        let length = self.sequence.length_unit();
        let mut plots = Vec::new();
        for (title, key, unit) in [
            ("Pitch", "pitch_deg", "degrees"),
            ("Flap", "flap_deg", "degrees"),
            ("Lag", "lag_deg", "degrees"),
            ("Largest displacement", "max_displacement", length),
        ] {
            plots.extend(self.plot(title, unit, &of_bodies(key)));
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

    /// Base points, and errors at the surface.
    pub fn accuracy(&self) -> Vec<Plot> {
        let errors = ["selection_error", "max_surface_error", "rms_surface_error"]
            .map(|column| (column.to_owned(), self.sequence.label(column).0));
        let base = self.of_column("base_points").map(|plot| Plot {
            include: vec![0.0],
            ..plot
        });
        let tolerance = self.sequence.record.options.tolerance;
        let errors = self
            .plot(
                "Errors at the surface",
                self.sequence.length_unit(),
                &errors,
            )
            .map(|plot| {
                let has_zeros = plot
                    .series
                    .iter()
                    .flat_map(Series::known)
                    .any(|(_, y)| y <= 0.0);
                Plot {
                    is_log: true,
                    levels: tolerance
                        .map(|value| ("tolerance".to_owned(), value))
                        .into_iter()
                        .collect(),
                    remark: match has_zeros {
                        true => "Errors of zero are not shown on this axis.".to_owned(),
                        false => String::new(),
                    },
                    ..plot
                }
            });
        base.into_iter().chain(errors).collect()
    }

    /// Quality of the cells.
    pub fn quality(&self) -> Vec<Plot> {
        let scaled = [
            ("min_scaled_jacobian", "smallest"),
            ("p01_scaled_jacobian", "first percentile"),
            ("mean_scaled_jacobian", "mean"),
        ]
        .map(|(column, name)| (column.to_owned(), name.to_owned()));
        let change = [("min_size_skew", "smallest"), ("mean_size_skew", "mean")]
            .map(|(column, name)| (column.to_owned(), name.to_owned()));
        let bands = |plot: Plot| Plot {
            bands: (1..plot.series.len()).map(|i| [i - 1, i]).collect(),
            ..plot
        };
        let mut plots = Vec::new();
        plots.extend(
            self.plot("Scaled Jacobian", "1 is best, below 0 inverted", &scaled)
                .map(bands),
        );
        plots.extend(
            self.plot("Size-skew against the reference", "1 is unchanged", &change)
                .map(bands),
        );
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
        let inverted = self.sequence.table.numbers("inverted");
        if inverted.into_iter().flatten().any(|n| n > 0.0) {
            plots.extend(self.of_column("inverted"));
        }
        plots
    }

    /// Seconds of every step.
    pub fn time(&self) -> Option<Plot> {
        let plot = self.of_column("seconds")?;
        Some(Plot {
            title: "Seconds for each step".to_owned(),
            include: vec![0.0],
            ..plot
        })
    }
}

/// With a capital at the start.
pub fn capitalized(text: &str) -> String {
    let mut characters = text.chars();
    let first = characters.next().map(|c| c.to_uppercase().to_string());
    first.unwrap_or_default() + characters.as_str()
}

//! A plot of the page: its data for the script that draws it.

use super::html::{escape, json_text};
use serde::Serialize;

/// A plot of lines, bands and bars. The script takes the values of a marked plot from the steps of the page.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Plot {
    /// Heading.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x: String,
    /// Label of the vertical axis, with its unit.
    pub y: String,
    /// True if the horizontal axis is in degrees.
    pub in_degrees: bool,
    /// True if the vertical axis is logarithmic.
    pub is_log: bool,
    /// True if a line marks the chosen step.
    pub is_marked: bool,
    /// Values that the vertical axis must show.
    pub include: Vec<f64>,
    /// Areas between two of the series.
    pub bands: Vec<[usize; 2]>,
    /// The lines.
    pub series: Vec<Series>,
    /// Name, and left edge and height of each bar, of sets of bars of one width. The second set is an outline over the first.
    pub bars: Vec<(String, Vec<Bar>)>,
    /// Horizontal lines with their names.
    pub levels: Vec<(String, f64)>,
    /// A sentence under the plot.
    pub remark: String,
}

/// Left edge and height of a bar.
pub type Bar = (f64, Option<f64>);

/// A line of a plot.
#[derive(Debug, Clone, Serialize)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Index of the colour and the dashes.
    pub style: usize,
    /// Column of the table that it shows.
    pub column: Option<String>,
    /// Places and values, in order, where it shows no column; a gap where a value is not known.
    pub points: Vec<(f64, Option<f64>)>,
}

impl Plot {
    /// Writes the figure.
    pub fn figure(&self) -> String {
        let data = serde_json::to_value(self).unwrap_or_default();
        let (title, data) = (escape(&self.title), json_text(&data));
        format!(
            "<figure class=\"plot\"><figcaption>{title}</figcaption><script type=\"application/json\">{data}</script></figure>\n"
        )
    }
}

/// Chooses at most `most` of `n` things, from the first to the last.
pub fn evenly(n: usize, most: usize) -> Vec<usize> {
    let drawn = n.min(most);
    (0..drawn)
        .map(|i| i * (n - 1) / (drawn - 1).max(1))
        .collect()
}

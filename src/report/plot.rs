//! A plot of the page: its data for the script that draws it, a legend, and a description in words.

use super::html::{embedded, escape};
use super::series::Series;
use azimesh_core::diagnostic::short;
use serde_json::{Value, json};
use std::fmt::Write;

/// A name, and the left edge and the height of each bar.
pub type Bars = (String, Vec<(f64, Option<f64>)>);

/// A plot of lines, bands and bars.
#[derive(Debug, Clone, Default)]
pub struct Plot {
    /// What it shows.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x: String,
    /// Label of the vertical axis, with its unit.
    pub y: String,
    /// Whether the horizontal axis is in degrees.
    pub in_degrees: bool,
    /// Whether the vertical axis is logarithmic.
    pub is_log: bool,
    /// Whether a line marks the chosen step.
    pub is_marked: bool,
    /// Values that the vertical axis must show.
    pub include: Vec<f64>,
    /// Areas between two of the series.
    pub bands: Vec<[usize; 2]>,
    /// The lines.
    pub series: Vec<Series>,
    /// Sets of bars of one width. The second set is an outline over the first.
    pub bars: Vec<Bars>,
    /// Horizontal lines with their names.
    pub levels: Vec<(String, f64)>,
    /// A sentence under the plot.
    pub remark: String,
}

impl Plot {
    /// The figure.
    pub fn figure(&self) -> String {
        let remark = if self.remark.is_empty() {
            String::new()
        } else {
            format!("<p class=\"remark\">{}</p>", escape(&self.remark))
        };
        format!(
            "<figure class=\"plot\"><figcaption>{}</figcaption><div class=\"live-plot\" role=\"group\" tabindex=\"0\" \
             aria-label=\"{}\"></div>{}{remark}<script type=\"application/json\">{}</script></figure>\n",
            escape(&self.title),
            escape(&self.in_words()),
            self.legend(),
            self.data(),
        )
    }

    /// The data of the script. It reads the values of marked plots from the steps of the page.
    fn data(&self) -> String {
        let lines = self.series.iter().map(|series| {
            let mut line = json!({
                "name": series.name, "style": series.style, "column": series.column, "points": series.known().count(),
            });
            if !self.is_marked {
                (line["x"], line["y"]) = columns(&series.points);
            }
            line
        });
        let bars = self.bars.iter().enumerate().map(|(style, (name, bars))| {
            let (x, y) = columns(bars);
            json!({ "name": name, "style": style, "bars": true, "x": x, "y": y })
        });
        embedded(&json!({
            "x": self.x, "y": self.y, "degrees": self.in_degrees, "log": self.is_log, "marked": self.is_marked,
            "include": self.include, "bands": self.bands, "levels": self.levels,
            "series": lines.chain(bars).collect::<Vec<_>>(),
        }))
    }

    fn legend(&self) -> String {
        let mut items = String::new();
        let swatch = |class: &str, d: &str| {
            format!(
                "<svg viewBox=\"0 0 24 10\" aria-hidden=\"true\"><path class=\"{class}\" d=\"{d}\"/></svg>"
            )
        };
        for series in &self.series {
            let column = series.column.as_ref().filter(|_| self.is_marked);
            let value = column.map_or_else(String::new, |column| {
                format!(" <output data-column=\"{}\"></output>", escape(column))
            });
            let line = swatch(&format!("line s{}", series.style), "M1 5H23");
            let name = escape(&series.name);
            write!(items, "<li>{line}<span>{name}{value}</span></li>")
                .expect("a string takes any text");
        }
        for (at, (name, _)) in self.bars.iter().enumerate() {
            let class = format!("{} s{at}", ["bars", "outline"][at.min(1)]);
            let line = swatch(&class, "M3 9V2H21V9");
            write!(items, "<li>{line}<span>{}</span></li>", escape(name))
                .expect("a string takes any text");
        }
        for (name, value) in &self.levels {
            let line = swatch("level", "M1 5H23");
            let (name, value) = (escape(name), short(*value));
            write!(items, "<li>{line}<span>{name} <b>{value}</b></span></li>")
                .expect("a string takes any text");
        }
        format!("<ul class=\"legend\">{items}</ul>")
    }

    /// What the plot shows, for those who do not see it.
    fn in_words(&self) -> String {
        let mut words = format!("{} ({}) against {}.", self.title, self.y, self.x);
        for series in &self.series {
            if let Some([least, most]) = series.extremes() {
                let [low, at_low, high, at_high] = [least.1, least.0, most.1, most.0].map(short);
                write!(
                    words,
                    " {}: smallest {low} at {at_low}, largest {high} at {at_high}.",
                    series.name
                )
                .expect("a string takes any text");
            }
        }
        for (name, value) in &self.levels {
            write!(words, " {name}: {}.", short(*value)).expect("a string takes any text");
        }
        for (name, bars) in &self.bars {
            let known = bars
                .iter()
                .filter_map(|(from, height)| Some((*from, (*height)?)));
            if let Some((from, height)) = known.max_by(|a, b| a.1.total_cmp(&b.1)) {
                let [from, height] = [from, height].map(short);
                write!(words, " {name}: most, {height}, from {from}.")
                    .expect("a string takes any text");
            }
        }
        words
    }
}

/// Points as two lists.
fn columns(points: &[(f64, Option<f64>)]) -> (Value, Value) {
    let (x, y): (Vec<f64>, Vec<Option<f64>>) = points.iter().copied().unzip();
    (json!(x), json!(y))
}

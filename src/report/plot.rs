//! A plot as a figure of the page: SVG with classes for colours, and a legend in the page's own text.

use super::axis::Axis;
use super::html::{embedded, escape};
use super::series::Series;
use azimesh_core::diagnostic::short;
use serde_json::{Value, json};
use std::fmt::Write;

const WIDTH: f64 = 400.0;
const HEIGHT: f64 = 232.0;
/// Room for the vertical axis: at least so much, and for a title and labels of digits so wide.
const LEFT: f64 = 64.0;
const TITLE: f64 = 24.0;
const DIGIT: f64 = 7.7;
const RIGHT: f64 = 12.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 40.0;

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
    /// Bars: from, to, height. A second set of bars is drawn as an outline over them.
    pub bars: Vec<(String, Vec<[f64; 3]>)>,
    /// Horizontal lines with their names.
    pub levels: Vec<(String, f64)>,
    /// A sentence under the plot.
    pub remark: String,
}

/// A plot's axes.
struct Axes {
    x: Axis,
    y: Axis,
    /// Where the vertical axis is.
    left: f64,
}

impl Axes {
    fn new(x: Axis, y: Axis) -> Self {
        let labels = y.ticks.iter().map(|(_, label)| label.chars().count());
        let widest = labels.max().unwrap_or(0) as f64;
        Self {
            x,
            y,
            left: LEFT.max((TITLE + DIGIT * widest).round()),
        }
    }

    fn width(&self) -> f64 {
        WIDTH - self.left - RIGHT
    }

    fn x(&self, value: f64) -> Option<f64> {
        Some(self.left + self.x.at(value)? * self.width())
    }

    fn y(&self, value: f64) -> Option<f64> {
        let place = self.y.at(value)?.clamp(-0.02, 1.02);
        Some(HEIGHT - BOTTOM - place * (HEIGHT - TOP - BOTTOM))
    }
}

impl Plot {
    /// The figure.
    pub fn figure(&self) -> String {
        let axes = self.axes();
        let mut svg = String::new();
        self.draw_axes(&axes, &mut svg);
        self.draw_bands(&axes, &mut svg);
        self.draw_bars(&axes, &mut svg);
        self.draw_levels(&axes, &mut svg);
        for series in &self.series {
            draw_line(series, &axes, &mut svg);
        }
        let marks = match self.is_marked {
            true => {
                let bottom = HEIGHT - BOTTOM;
                write!(svg, "<path class=\"mark\" d=\"M0 {TOP}V{bottom}\"/>")
                    .expect("a string takes any text");
                format!(
                    " data-from=\"{}\" data-to=\"{}\" data-left=\"{}\" data-width=\"{}\"",
                    axes.x.low,
                    axes.x.high,
                    axes.left,
                    axes.width()
                )
            }
            false => String::new(),
        };
        let remark = match self.remark.is_empty() {
            true => String::new(),
            false => format!("<p class=\"remark\">{}</p>", escape(&self.remark)),
        };
        format!(
            "<figure class=\"plot\"><figcaption>{}</figcaption>\
             <svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\"{marks}>{svg}</svg>{}{remark}{}</figure>\n",
            escape(&self.title),
            escape(&self.in_words()),
            self.legend(),
            self.live(),
        )
    }

    /// What the script draws in place of the picture; bars stay a picture.
    fn live(&self) -> String {
        if self.series.is_empty() {
            return String::new();
        }
        let series = self.series.iter().map(|series| {
            let mut line = json!({
                "name": series.name, "style": series.style, "column": series.column, "points": series.known().count(),
            });
            if !self.is_marked {
                let (x, y): (Vec<f64>, Vec<Option<f64>>) = series.points.iter().copied().unzip();
                line["x"] = json!(x);
                line["y"] = json!(y);
            }
            line
        });
        let series: Vec<Value> = series.collect();
        let data = json!({
            "x": self.x, "y": self.y, "degrees": self.in_degrees, "log": self.is_log, "marked": self.is_marked,
            "include": self.include, "bands": self.bands, "levels": self.levels, "series": series,
        });
        format!(
            "<script type=\"application/json\">{}</script>",
            embedded(&data)
        )
    }

    fn axes(&self) -> Axes {
        let known = || self.series.iter().flat_map(Series::known);
        let bars = || self.bars.iter().flat_map(|(_, bars)| bars);
        let across = self.series.iter().flat_map(|series| &series.points);
        let across = across.map(|(x, _)| *x);
        let ends = bars().flat_map(|[from, to, _]| [*from, *to]);
        let levels = self.levels.iter().map(|(_, value)| *value);
        let heights = bars().map(|bar| bar[2]);
        let up = known().map(|(_, y)| y).chain(levels).chain(heights);
        let up = up.chain(self.include.iter().copied());
        let x = Axis::tight(across.chain(ends), 5, self.in_degrees);
        match self.is_log {
            true => Axes::new(x, Axis::log(up)),
            false => Axes::new(x, Axis::round(up, 5)),
        }
    }

    fn draw_axes(&self, axes: &Axes, svg: &mut String) {
        let (left, right, bottom) = (axes.left, WIDTH - RIGHT, HEIGHT - BOTTOM);
        let mut grid = String::new();
        for (value, label) in &axes.y.ticks {
            let Some(y) = axes.y(*value) else { continue };
            write!(grid, "M{left} {y:.1}H{right}").expect("a string takes any text");
            text(svg, left - 6.0, y + 4.0, "end", label);
        }
        for (value, label) in &axes.x.ticks {
            let Some(x) = axes.x(*value) else { continue };
            write!(grid, "M{x:.1} {bottom}v4").expect("a string takes any text");
            text(svg, x, bottom + 16.0, "middle", label);
        }
        let middle = (left + right) / 2.0;
        text(svg, middle, HEIGHT - 6.0, "middle", &self.x);
        let middle = (TOP + bottom) / 2.0;
        let power = axes.y.power.as_ref();
        let power = power.map_or_else(String::new, |power| format!(", {power}"));
        write!(
            svg,
            "<text transform=\"translate(11 {middle}) rotate(-90)\" text-anchor=\"middle\">{}{power}</text>\
             <path class=\"grid\" d=\"{grid}\"/><path class=\"axis\" d=\"M{left} {TOP}V{bottom}H{right}\"/>",
            escape(&self.y)
        )
        .expect("a string takes any text");
    }

    fn draw_bands(&self, axes: &Axes, svg: &mut String) {
        for [low, high] in &self.bands {
            let along = |series: usize| {
                let points = self.series[series].thinned().into_iter();
                points.filter_map(|(x, y)| Some((axes.x(x)?, axes.y(y?)?)))
            };
            let back: Vec<(f64, f64)> = along(*low).collect();
            let outline = along(*high).chain(back.into_iter().rev());
            let style = self.series[*low].style;
            let d = path(outline.map(Some));
            write!(svg, "<path class=\"band s{style}\" d=\"{d}Z\"/>")
                .expect("a string takes any text");
        }
    }

    fn draw_bars(&self, axes: &Axes, svg: &mut String) {
        let bottom = HEIGHT - BOTTOM;
        for (at, (_, bars)) in self.bars.iter().enumerate() {
            let mut d = String::new();
            for [from, to, height] in bars {
                let (Some(x), Some(end), Some(y)) = (axes.x(*from), axes.x(*to), axes.y(*height))
                else {
                    continue;
                };
                write!(d, "M{x:.1} {bottom}V{y:.1}H{end:.1}V{bottom}")
                    .expect("a string takes any text");
            }
            let class = ["bars", "outline"][at.min(1)];
            write!(svg, "<path class=\"{class} s{at}\" d=\"{d}\"/>")
                .expect("a string takes any text");
        }
    }

    fn draw_levels(&self, axes: &Axes, svg: &mut String) {
        let (left, right) = (axes.left, WIDTH - RIGHT);
        for y in self.levels.iter().filter_map(|(_, value)| axes.y(*value)) {
            write!(svg, "<path class=\"level\" d=\"M{left} {y:.1}H{right}\"/>")
                .expect("a string takes any text");
        }
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
            let most = bars.iter().max_by(|a, b| a[2].total_cmp(&b[2]));
            if let Some([from, to, height]) = most {
                let [from, to, height] = [from, to, height].map(|value| short(*value));
                write!(words, " {name}: most, {height}, from {from} to {to}.")
                    .expect("a string takes any text");
            }
        }
        words
    }
}

fn draw_line(series: &Series, axes: &Axes, svg: &mut String) {
    let points = series.thinned().into_iter();
    let placed: Vec<Option<(f64, f64)>> = points
        .map(|(x, y)| Some((axes.x(x)?, axes.y(y?)?)))
        .collect();
    let known: Vec<(f64, f64)> = placed.iter().copied().flatten().collect();
    let style = series.style;
    if known.len() < 40 {
        for (x, y) in &known {
            write!(
                svg,
                "<circle class=\"dot s{style}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2\"/>"
            )
            .expect("a string takes any text");
        }
    }
    let d = path(placed.into_iter());
    write!(svg, "<path class=\"line s{style}\" d=\"{d}\"/>").expect("a string takes any text");
}

/// A path through points, broken where there is none.
fn path(points: impl Iterator<Item = Option<(f64, f64)>>) -> String {
    let mut d = String::new();
    let mut command = 'M';
    for point in points {
        match point {
            Some((x, y)) => {
                write!(d, "{command}{x:.1} {y:.1}").expect("a string takes any text");
                command = 'L';
            }
            None => command = 'M',
        }
    }
    d
}

fn text(svg: &mut String, x: f64, y: f64, anchor: &str, text: &str) {
    let text = escape(text);
    write!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>"
    )
    .expect("a string takes any text");
}

//! The facts as lines of text.

use super::facts::{Boundary, Facts};
use azimesh_core::error::{counted, one_line};
use azimesh_core::numbers::short;
use azimesh_io::mesh::{DataArray, Group};
use azimesh_quality::Flaws;

/// Lines of a name and a value.
struct Rows(Vec<(String, String)>);

impl Rows {
    fn push(&mut self, name: impl Into<String>, value: impl ToString) {
        let (name, value) = (name.into(), value.to_string());
        let row = (one_line(&name).into_owned(), one_line(&value).into_owned());
        self.0.push(row);
    }

    /// Adds a count if it is not zero.
    fn push_some(&mut self, name: &str, n: usize, told: impl ToString) {
        if n > 0 {
            self.push(format!("  {name}"), told);
        }
    }

    fn list<'a>(&mut self, title: &str, groups: impl Iterator<Item = &'a Group>, of: &str) {
        let first = self.0.len();
        for group in groups {
            let condition = group.condition.as_ref();
            let condition = condition.map_or(String::new(), |words| format!(" ({words})"));
            let count = counted(group.cells.len(), of) + &condition;
            self.push(format!("  {}", group.name), count);
        }
        let n = self.0.len() - first;
        let count = if n == 0 { "none".into() } else { n.to_string() };
        self.0.insert(first, (title.into(), count));
    }

    /// Adds cells that no solver accepts.
    fn flaws(&mut self, found: &Flaws) {
        for (name, flawed, what) in [
            ("negative", found.negative, " of negative volume"),
            ("degenerate", found.degenerate, " of no volume"),
            ("folded", found.folded, " folded"),
        ] {
            let first = flawed.first.unwrap_or_default();
            let told = format!(
                "{}{what} (the first is cell {first})",
                counted(flawed.n, "cell")
            );
            self.push_some(name, flawed.n, told);
            if name == "negative" {
                self.reversed(found);
            }
        }
        let told = counted(found.n_invalid, "cell") + " not valid; azimesh repair moves nodes";
        self.push_some("invalid", found.n_invalid, told);
    }

    /// Adds the cells of negative volume that are valid with reversed nodes.
    fn reversed(&mut self, found: &Flaws) {
        let n = found.reversed.n;
        let which = if n == found.negative.n {
            "these".to_owned()
        } else {
            format!("{n} of these")
        };
        let told = format!(
            "{which} are valid with their nodes in the other orientation; quality evaluates them as mirror images"
        );
        self.push_some("reversed", n, told);
    }

    /// Adds unusual findings about the faces around the mesh.
    fn boundary(&mut self, found: &Boundary) {
        let of_one = " of one cell that no tag holds";
        for (name, n, noun, what) in [
            ("without a tag", found.n_untagged, "face", ""),
            ("open", found.n_open, "face", of_one),
            (
                "inside",
                found.n_inside,
                "tagged face",
                " between two cells",
            ),
            ("dangling", found.n_dangling, "boundary face", " on no cell"),
            (
                "non-manifold",
                found.n_non_manifold,
                "face",
                " of more than two cells",
            ),
        ] {
            self.push_some(name, n, counted(n, noun) + what);
        }
    }

    /// Returns the lines, with aligned values.
    fn text(&self) -> String {
        let width = self.0.iter().map(|(name, _)| name.chars().count()).max();
        let width = width.unwrap_or(0) + 2;
        let lines = self.0.iter().map(|(name, value)| {
            let line = format!("{name:width$}{value}");
            line.trim_end().to_owned() + "\n"
        });
        lines.collect()
    }
}

/// Returns all facts, one per line.
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
            format!(
                "{n}, times {} to {}; {} follows",
                short(from),
                short(to),
                facts
                    .step
                    .map_or("the last".to_owned(), |step| format!("step {step}"))
            ),
        );
    }
    rows.push("dimension", mesh.dimension());
    rows.push("nodes", mesh.points.len());
    let n = facts.n_orphan_nodes;
    rows.push_some("unused", n, format!("{n} (in no cell)"));
    let n = facts.n_repeated_nodes;
    rows.push_some(
        "repeated",
        n,
        format!("{n} (at the position of another node)"),
    );
    rows.push("cells", mesh.cells.len());
    for (kind, count) in &facts.cells {
        let curved = if kind.is_curved() { " (curved)" } else { "" };
        rows.push(format!("  {}", kind.name()), format!("{count}{curved}"));
    }
    rows.flaws(&facts.flaws);
    rows.list("zones", mesh.zones(), "cell");
    rows.list("boundary tags", mesh.boundary_tags(), "face");
    rows.boundary(&facts.boundary);
    if facts.other_groups().next().is_some() {
        rows.list("other groups", facts.other_groups(), "cell");
    }
    if let Some([low, high]) = mesh.bounds() {
        for (axis, i) in ["x", "y", "z"].into_iter().zip(0..) {
            rows.push(axis, format!("{} to {}", short(low[i]), short(high[i])));
        }
    }
    for (place, array) in facts.arrays() {
        rows.push(format!("{place} array"), told(array));
    }
    rows.text()
}

/// Returns name, type, components and range of an array.
fn told(array: &DataArray) -> String {
    let n = array.n_components;
    let what = format!(
        "{} ({}, {})",
        array.name,
        array.values.type_name(),
        counted(n, "component")
    );
    let ranges = array.values.ranges(n);
    if ranges.is_empty() || n > 3 {
        return what;
    }
    let ranges: Vec<String> = ranges
        .iter()
        .map(|range| match range {
            Some([low, high]) => format!("{} to {}", short(*low), short(*high)),
            None => "no numbers".to_owned(),
        })
        .collect();
    format!("{what} {}", ranges.join(", "))
}

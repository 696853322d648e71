//! Values over azimuth, time or step, interpolated between the rows of a table.

use super::{ADD, Column, Key, Period, Table, spline, why_once};
use crate::motion::keys::names;
use azimesh_core::error::{Error, Result};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Allowed difference of the last row of whole revolutions from the first, as a part of a component's largest value.
const REPEATED: f64 = 1e-3;
/// Distance by which a step may be outside the rows, as a part of the spacing of the two rows at that end, or of the
/// position of a single row. A table that ends at 0.0999999 then covers 0.1.
const ROUNDED: f64 = 1e-4;

/// Interpolation between rows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Linear. The rate at a row is the slope after it.
    #[default]
    Linear,
    /// A cubic spline: periodic where the table is, else with the ends "not a knot".
    Cubic,
}

names! {
    Interpolation { "linear" => Linear, "cubic" => Cubic }
}

/// Rows of `n` values over increasing knots.
///
/// Over azimuth it is periodic if it covers whole revolutions, by the rule of [`Period`]. Otherwise it has no values
/// outside of its range. A single row holds everywhere, or only at its own position if it was given one.
#[derive(Debug, Clone)]
pub struct History {
    path: PathBuf,
    /// Lines of the rows at the first and the last knot, where they are known.
    lines: Option<[u64; 2]>,
    key: Key,
    knots: Vec<f64>,
    /// (knots, n), by rows.
    values: Vec<f64>,
    /// Slopes at the knots of a cubic spline: (knots, n), by rows.
    slopes: Option<Vec<f64>>,
    n_values: usize,
    /// Period, if it is periodic.
    period: Option<f64>,
    /// True if it has no row at the end of the period.
    fills_gap: bool,
    /// True if a single row holds only at its own position.
    is_held: bool,
    /// Reason why the table is not periodic, in words.
    open: Option<String>,
}

/// A position between two knots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Knots before and after.
    knots: [usize; 2],
    /// Distance of the knots, and the part of it before the position.
    step: f64,
    part: f64,
}

impl History {
    /// Creates a history from knots and rows of values, `(knots, n)`; `path` is the file that errors name.
    ///
    /// # Panics
    /// If there are no knots, they do not increase, or the number of rows differs.
    pub fn new(
        path: &Path,
        key: Key,
        knots: Vec<f64>,
        values: Vec<f64>,
        interpolation: Interpolation,
    ) -> Self {
        let n_values = values.len() / knots.len();
        assert_eq!(values.len(), n_values * knots.len());
        assert!(knots.windows(2).all(|pair| pair[0] < pair[1]));
        let mut history = Self {
            path: path.to_path_buf(),
            lines: None,
            key,
            knots,
            values,
            slopes: None,
            n_values,
            period: None,
            fills_gap: false,
            is_held: false,
            open: None,
        };
        history.close();
        if interpolation == Interpolation::Cubic {
            let (knots, values) = (&history.knots, &history.values);
            history.slopes = Some(match history.period {
                Some(period) => spline::periodic(knots, values, n_values, period),
                None => spline::not_a_knot(knots, values, n_values),
            });
        }
        history
    }

    /// Creates a history from columns of a table whose rows are in order.
    pub fn from_table(
        table: &Table,
        (key, place): (Key, Column),
        columns: &[Column],
        interpolation: Interpolation,
    ) -> Result<Self> {
        let rows = 0..table.n_rows();
        let knots: Vec<f64> = rows.clone().map(|row| table.value(row, place)).collect();
        for row in 1..table.n_rows() {
            if knots[row] > knots[row - 1] {
                continue;
            }
            let (here, before) = (key.place(knots[row]), key.place(knots[row - 1]));
            let what = if knots[row] == knots[row - 1] {
                "repeats"
            } else {
                "comes after"
            };
            let message = format!(
                "{here} {what} {before} of line {}; `{}` must increase from row to row",
                table.line(row - 1),
                key.name()
            );
            return Err(table.error(row, message));
        }
        let values = rows.flat_map(|row| columns.iter().map(move |c| table.value(row, *c)));
        let values = values.collect();
        let lines = [0, table.n_rows() - 1].map(|row| table.line(row));
        let history = Self::new(table.path(), key, knots, values, interpolation);
        Ok(history.with_lines(lines).held())
    }

    /// Adds the lines of its first and last knot, for errors.
    #[must_use]
    pub fn with_lines(mut self, lines: [u64; 2]) -> Self {
        self.lines = Some(lines);
        self
    }

    /// Makes a history of a single row valid at its own place only.
    #[must_use]
    pub fn held(mut self) -> Self {
        self.is_held = true;
        self
    }

    /// Finds out whether the table is periodic; removes a last row that repeats the first.
    fn close(&mut self) {
        match Period::of(self.key, &self.knots, || self.last_row_differs()) {
            Ok(period) => {
                self.fills_gap = period.n_rows == self.knots.len();
                self.knots.truncate(period.n_rows);
                self.values.truncate(period.n_rows * self.n_values);
                self.period = Some(period.length);
            }
            Err(open) => self.open = open,
        }
    }

    /// Returns whether some value of the last row differs from the first row.
    fn last_row_differs(&self) -> bool {
        let n = self.n_values;
        let mut largest = vec![0.0; n];
        for row in self.values.chunks_exact(n.max(1)) {
            for (largest, value) in largest.iter_mut().zip(row) {
                *largest = f64::max(*largest, value.abs());
            }
        }
        let (first, last) = (&self.values[..n], &self.values[self.values.len() - n..]);
        let mut values = first.iter().zip(last).zip(largest);
        values.any(|((first, last), largest)| (last - first).abs() > REPEATED * largest)
    }

    /// Number of values in a row.
    pub fn n_values(&self) -> usize {
        self.n_values
    }

    /// Number of rows, without a last one that repeats the first.
    pub fn n_rows(&self) -> usize {
        self.knots.len()
    }

    /// The rows, `n_values` numbers each.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.n_values.max(1))
    }

    /// Returns the position of a row in words.
    pub fn place_of(&self, row: usize) -> String {
        self.key.place(self.knots[row])
    }

    /// Period, in the unit of its key.
    #[cfg(test)]
    pub fn period(&self) -> Option<f64> {
        self.period
    }

    /// Returns whether it is periodic.
    pub fn repeats(&self) -> bool {
        self.period.is_some()
    }

    /// Returns whether a position is past the last row of a revolution that has no row at its end.
    pub fn is_past_last_row(&self, place: Place) -> bool {
        let inside = ROUNDED..=1.0 - ROUNDED;
        self.fills_gap && place.knots[1] == 0 && inside.contains(&place.part)
    }

    /// Returns whether interpolation between rows is linear.
    pub fn is_linear(&self) -> bool {
        self.slopes.is_none()
    }

    /// Returns the reason why it is not periodic, in words.
    pub fn why_once(&self) -> String {
        why_once(self.open.as_deref())
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The key of its rows.
    pub fn key(&self) -> Key {
        self.key
    }

    /// Returns the first and last knot, without a last row that repeats the first.
    pub fn range(&self) -> (f64, f64) {
        (self.knots[0], self.knots[self.knots.len() - 1])
    }

    /// Returns the end of its first period, or its last knot if it is not periodic.
    pub fn end(&self) -> f64 {
        let (first, last) = self.range();
        self.period.map_or(last, |period| first + period)
    }

    /// Locates `at`, in the unit of the key, among the knots; an error outside of a table that is not periodic.
    pub fn locate(&self, at: f64) -> Result<Place> {
        let (first, last) = self.range();
        let n = self.knots.len();
        if n == 1 {
            if self.is_held && self.period.is_none() && (at - first).abs() > ROUNDED * first.abs() {
                return Err(self.outside(at));
            }
            let (step, part) = (1.0, 0.0);
            let knots = [0, 0];
            return Ok(Place { knots, step, part });
        }
        let at = match self.period {
            Some(period) => {
                let wrapped = at - period * ((at - first) / period).floor();
                // Round-off may place it slightly outside.
                if wrapped < first + period {
                    wrapped.max(first)
                } else {
                    first
                }
            }
            None => {
                let [before, after] =
                    [1, n - 1].map(|i| ROUNDED * (self.knots[i] - self.knots[i - 1]));
                if !(first - before..=last + after).contains(&at) {
                    return Err(self.outside(at));
                }
                at.clamp(first, last)
            }
        };
        let after = self.knots.partition_point(|knot| *knot <= at);
        let lower = match self.period {
            Some(_) => after - 1,
            None => (after - 1).min(n - 2),
        };
        let upper = (lower + 1) % n;
        let end = match upper {
            0 => first + self.period.expect("only a periodic one wraps"),
            upper => self.knots[upper],
        };
        let step = end - self.knots[lower];
        Ok(Place {
            knots: [lower, upper],
            step,
            part: (at - self.knots[lower]) / step,
        })
    }

    fn outside(&self, at: f64) -> Error {
        let (first, last) = self.range();
        let end = usize::from(at > last);
        let (first, last) = (self.key.place(first), self.key.place(last));
        let at = self.key.place(at);
        let open = self.open.iter().map(|open| format!("; {open}"));
        let mut open: String = open.collect();
        if !open.contains(ADD) {
            open += &format!("; {ADD}");
        }
        let message =
            format!("the motion needs {at}, but the table goes from {first} to {last}{open}");
        let error = Error::input(message).file(&self.path);
        match self.lines {
            Some(lines) => error.line(lines[end]),
            None => error,
        }
    }

    /// Evaluates some components at a position, into `out`.
    pub fn values(&self, place: Place, components: Range<usize>, out: &mut [f64]) {
        let Place { step, part: t, .. } = place;
        let [p, q] = self.between(&self.values, place, &components);
        let Some(slopes) = &self.slopes else {
            for ((out, p), q) in out.iter_mut().zip(p).zip(q) {
                *out = (1.0 - t) * p + t * q;
            }
            return;
        };
        let [a, b] = self.between(slopes, place, &components);
        // Hermite's cubics; 1 and 0 exactly at the knots.
        let rest = 1.0 - t;
        let (of_p, of_q) = (rest * rest * (1.0 + 2.0 * t), t * t * (3.0 - 2.0 * t));
        let (of_a, of_b) = (step * t * rest * rest, -step * t * t * rest);
        for (c, out) in out.iter_mut().enumerate() {
            *out = of_p * p[c] + of_q * q[c] + (of_a * a[c] + of_b * b[c]);
        }
    }

    /// Evaluates derivatives of some components with respect to the key, in its unit, into `out`.
    pub fn rates(&self, place: Place, components: Range<usize>, out: &mut [f64]) {
        let Place { step, part: t, .. } = place;
        let [p, q] = self.between(&self.values, place, &components);
        let Some(slopes) = &self.slopes else {
            for ((out, p), q) in out.iter_mut().zip(p).zip(q) {
                *out = (q - p) / step;
            }
            return;
        };
        let [a, b] = self.between(slopes, place, &components);
        let of_rise = 6.0 * t * (1.0 - t) / step;
        let (of_a, of_b) = ((1.0 - t) * (1.0 - 3.0 * t), t * (3.0 * t - 2.0));
        for (c, out) in out.iter_mut().enumerate() {
            *out = of_rise * (q[c] - p[c]) + (of_a * a[c] + of_b * b[c]);
        }
    }

    /// Returns all values at a position in the unit of the key.
    pub fn at(&self, at: f64) -> Result<Vec<f64>> {
        let mut values = vec![0.0; self.n_values];
        self.values(self.locate(at)?, 0..self.n_values, &mut values);
        Ok(values)
    }

    /// Returns all derivatives with respect to the key, in its unit.
    pub fn rates_at(&self, at: f64) -> Result<Vec<f64>> {
        let mut rates = vec![0.0; self.n_values];
        self.rates(self.locate(at)?, 0..self.n_values, &mut rates);
        Ok(rates)
    }

    fn between<'a>(&self, of: &'a [f64], place: Place, range: &Range<usize>) -> [&'a [f64]; 2] {
        place
            .knots
            .map(|knot| &of[knot * self.n_values..][range.clone()])
    }
}

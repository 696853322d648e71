//! Values along a horizontal axis.

/// A line of a plot; a gap where a value is not known.
#[derive(Debug, Clone)]
pub struct Series {
    /// What it is, for the legend.
    pub name: String,
    /// Which of the colours and dashes of the style sheet.
    pub style: usize,
    /// Column of the table whose value at the chosen step stands in the legend.
    pub column: Option<String>,
    /// Places and values, in order.
    pub points: Vec<(f64, Option<f64>)>,
}

impl Series {
    /// Its known points.
    pub fn known(&self) -> impl Iterator<Item = (f64, f64)> {
        self.points.iter().filter_map(|(x, y)| Some((*x, (*y)?)))
    }

    /// Its smallest and largest value, with their places.
    pub fn extremes(&self) -> Option<[(f64, f64); 2]> {
        let by_value = |a: &(f64, f64), b: &(f64, f64)| a.1.total_cmp(&b.1);
        // Of equal values the first.
        let least = self.known().min_by(by_value)?;
        let most = self.known().reduce(|a, b| if b.1 > a.1 { b } else { a })?;
        Some([least, most])
    }
}

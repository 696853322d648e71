//! Values along a horizontal axis, made few enough to draw.

/// Points of a line that are drawn, at most twice as many.
const DRAWN: usize = 400;

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

    /// This line with fewer points: the least and the greatest of each of some equal parts.
    pub fn thinned(&self) -> Vec<(f64, Option<f64>)> {
        if self.points.len() <= 2 * DRAWN {
            return self.points.clone();
        }
        let stretch = self.points.len().div_ceil(DRAWN);
        let mut thinned = Vec::new();
        for points in self.points.chunks(stretch) {
            let value = |at: &usize| points[*at].1.unwrap_or(f64::NAN);
            let known = || (0..points.len()).filter(|at| points[*at].1.is_some());
            let by_value = |a: &usize, b: &usize| value(a).total_cmp(&value(b));
            match (known().min_by(by_value), known().max_by(by_value)) {
                (Some(a), Some(b)) if a == b => thinned.push(points[a]),
                (Some(a), Some(b)) => thinned.extend([points[a.min(b)], points[a.max(b)]]),
                _ => thinned.push(points[0]),
            }
        }
        thinned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_line_keeps_its_extremes() {
        let value = |i: usize| match i {
            7_777 => Some(9.0),
            8_000 => None,
            _ => Some((i as f64 * 0.01).sin()),
        };
        let series = Series {
            name: String::new(),
            style: 0,
            column: None,
            points: (0..10_000).map(|i| (i as f64, value(i))).collect(),
        };
        let thinned = series.thinned();
        assert!(thinned.len() <= 2 * DRAWN);
        assert!(thinned.contains(&(7777.0, Some(9.0))));
        let [least, most] = series.extremes().expect("there are values");
        assert!(thinned.contains(&(least.0, Some(least.1))));
        assert_eq!(most, (7777.0, 9.0));
    }
}

//! Slopes of cubic splines at their knots.
//!
//! Between knots `i` and `i + 1`, at distance `h_i` with mean slope `m_i`, a spline is the cubic with the
//! values and slopes `s` of both. Its second derivative is continuous when
//!
//! ```text
//! h_i s_{i-1} + 2 (h_{i-1} + h_i) s_i + h_{i-1} s_{i+1} = 3 (h_i m_{i-1} + h_{i-1} m_i)
//! ```
//!
//! Values are rows of `n` components, one row per knot. O(knots n); cannot fail for increasing knots.

/// A tridiagonal system with rows of `n` right-hand sides, solved by elimination without pivots: the
/// diagonals of splines allow it.
struct Tridiagonal {
    below: Vec<f64>,
    diagonal: Vec<f64>,
    above: Vec<f64>,
}

impl Tridiagonal {
    fn zeros(size: usize) -> Self {
        Self {
            below: vec![0.0; size],
            diagonal: vec![0.0; size],
            above: vec![0.0; size],
        }
    }

    fn solve(mut self, right: &mut [f64], n: usize) {
        let size = self.diagonal.len();
        for i in 1..size {
            let factor = self.below[i] / self.diagonal[i - 1];
            self.diagonal[i] -= factor * self.above[i - 1];
            let (before, here) = right.split_at_mut(i * n);
            for (here, before) in here[..n].iter_mut().zip(&before[(i - 1) * n..]) {
                *here -= factor * before;
            }
        }
        for i in (0..size).rev() {
            let (here, after) = right.split_at_mut((i + 1) * n);
            for (c, here) in here[i * n..].iter_mut().enumerate() {
                let after = after.get(c).map_or(0.0, |after| self.above[i] * after);
                *here = (*here - after) / self.diagonal[i];
            }
        }
    }
}

/// Steps between knots and mean slopes, `m (knots - 1, n)`.
fn intervals(knots: &[f64], values: &[f64], n: usize) -> (Vec<f64>, Vec<f64>) {
    let h: Vec<f64> = knots.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let rises = values[n..].iter().zip(values).enumerate();
    let slopes = rises.map(|(at, (after, before))| (after - before) / h[at / n]);
    let slopes = slopes.collect();
    (h, slopes)
}

/// Returns slopes of the spline whose third derivative is continuous at the second knot and the last but one ("not a
/// knot"): a parabola through three points, a line through two.
pub(super) fn not_a_knot(knots: &[f64], values: &[f64], n: usize) -> Vec<f64> {
    let size = knots.len();
    let (h, m) = intervals(knots, values, n);
    match size {
        0 | 1 => return vec![0.0; size * n],
        2 => return [&m[..], &m[..]].concat(),
        3 => return parabola(&h, &m, n),
        _ => {}
    }
    let mut system = Tridiagonal::zeros(size);
    let mut right = vec![0.0; size * n];
    let last = size - 1;
    interior(&mut system, &mut right, &h, &m, n);
    let end = |near: f64, next: f64, m_near: f64, m_next: f64| {
        ((near + 2.0 * (near + next)) * next * m_near + near * near * m_next) / (near + next)
    };
    (system.diagonal[0], system.above[0]) = (h[1], h[0] + h[1]);
    (system.below[last], system.diagonal[last]) = (h[last - 1] + h[last - 2], h[last - 2]);
    for c in 0..n {
        right[c] = end(h[0], h[1], m[c], m[n + c]);
        let (near, next) = (m[(last - 1) * n + c], m[(last - 2) * n + c]);
        right[last * n + c] = end(h[last - 1], h[last - 2], near, next);
    }
    system.solve(&mut right, n);
    right
}

/// The equations of the knots that are not ends.
fn interior(system: &mut Tridiagonal, right: &mut [f64], h: &[f64], m: &[f64], n: usize) {
    for i in 1..h.len() {
        system.below[i] = h[i];
        system.diagonal[i] = 2.0 * (h[i - 1] + h[i]);
        system.above[i] = h[i - 1];
        for c in 0..n {
            let (before, after) = (m[(i - 1) * n + c], m[i * n + c]);
            right[i * n + c] = 3.0 * (h[i] * before + h[i - 1] * after);
        }
    }
}

fn parabola(h: &[f64], m: &[f64], n: usize) -> Vec<f64> {
    let mut slopes = vec![0.0; 3 * n];
    for c in 0..n {
        let (before, after) = (m[c], m[n + c]);
        let bend = (after - before) / (h[0] + h[1]);
        slopes[c] = before - bend * h[0];
        slopes[n + c] = before + bend * h[0];
        slopes[2 * n + c] = after + bend * h[1];
    }
    slopes
}

/// Returns slopes of the spline of this `period`; the last knot is before its end.
pub(super) fn periodic(knots: &[f64], values: &[f64], n: usize, period: f64) -> Vec<f64> {
    let size = knots.len();
    if size < 2 {
        return vec![0.0; size * n];
    }
    let closed: Vec<f64> = knots.iter().copied().chain([knots[0] + period]).collect();
    let values: Vec<f64> = values.iter().chain(&values[..n]).copied().collect();
    let (h, m) = intervals(&closed, &values, n);
    let before = |i: usize| (i + size - 1) % size;
    let rise =
        |i: usize, c: usize| 3.0 * (h[i] * m[before(i) * n + c] + h[before(i)] * m[i * n + c]);
    if size == 2 {
        // Both equations give the same slope.
        let slope = |c: usize| rise(0, c) / (3.0 * (h[0] + h[1]));
        return (0..2 * n).map(|at| slope(at % n)).collect();
    }
    // The corners are taken out by a rank-one change (Sherman and Morrison): one more right-hand side.
    let (top, bottom) = (h[0], h[size - 2]);
    let gamma = -2.0 * (h[size - 1] + h[0]);
    let mut system = Tridiagonal::zeros(size);
    let wide = n + 1;
    let mut right = vec![0.0; size * wide];
    for i in 0..size {
        system.below[i] = h[i];
        system.diagonal[i] = 2.0 * (h[before(i)] + h[i]);
        system.above[i] = h[before(i)];
        for c in 0..n {
            right[i * wide + c] = rise(i, c);
        }
    }
    system.below[0] = 0.0;
    system.above[size - 1] = 0.0;
    system.diagonal[0] -= gamma;
    system.diagonal[size - 1] -= top * bottom / gamma;
    right[n] = gamma;
    right[(size - 1) * wide + n] = bottom;
    system.solve(&mut right, wide);
    let along = |row: &[f64], last: &[f64], c: usize| row[c] + top / gamma * last[c];
    let (first, last) = (&right[..wide], &right[(size - 1) * wide..]);
    let factor: Vec<f64> = (0..n)
        .map(|c| along(first, last, c) / (1.0 + along(first, last, n)))
        .collect();
    let rows = right.chunks_exact(wide);
    rows.flat_map(|row| (0..n).map(|c| row[c] - factor[c] * row[n]))
        .collect()
}

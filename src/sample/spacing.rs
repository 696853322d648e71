//! Positions of nodes along a line: graded between its ends, or growing from a wall.

/// Steps of the integration a cell of the wanted size is cut into.
const STEPS_PER_CELL: f64 = 20.0;

/// Positions of `n_cells + 1` nodes on a line of the given length, the cell size following
/// `spacing(position)`: equal increments of `integral dx / spacing`, so that every cell is the
/// wanted size times one common factor.
///
/// `spacing` must be positive; O(length / spacing).
pub fn graded(length: f64, n_cells: usize, spacing: impl Fn(f64) -> f64) -> Vec<f64> {
    let (at, count) = cell_count(length, spacing);
    let total = count[count.len() - 1];
    let mut segment = 0;
    let mut positions: Vec<f64> = (0..=n_cells)
        .map(|i| {
            let wanted = total * i as f64 / n_cells as f64;
            while segment + 2 < count.len() && count[segment + 1] < wanted {
                segment += 1;
            }
            let part = (wanted - count[segment]) / (count[segment + 1] - count[segment]);
            at[segment] + part * (at[segment + 1] - at[segment])
        })
        .collect();
    positions[n_cells] = length;
    positions
}

/// Positions along the line and the number of wanted cells up to each.
fn cell_count(length: f64, spacing: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
    let (mut at, mut count) = (vec![0.0], vec![0.0]);
    let (mut x, mut n) = (0.0, 0.0);
    while x < length {
        let guess = spacing(x) / STEPS_PER_CELL;
        let size = spacing((x + 0.5 * guess).min(length));
        let step = (size / STEPS_PER_CELL).min(length - x);
        n += step / size;
        x = if length - x - step < 1e-9 * length {
            length
        } else {
            x + step
        };
        at.push(x);
        count.push(n);
    }
    (at, count)
}

/// An end of a line: the size of the cells there, and how far they keep it.
#[derive(Debug, Clone, Copy)]
pub struct LineEnd {
    /// Size of the cells.
    pub size: f64,
    /// Distance from the end up to which cells have that size.
    pub hold: f64,
}

/// Positions of `n_cells + 1` nodes between two ends, the cells growing away from both at the rate
/// that makes `n_cells` fit. Where no rate does, all sizes are scaled alike.
pub fn graded_from_ends(length: f64, n_cells: usize, ends: [LineEnd; 2]) -> Vec<f64> {
    let from = |end: LineEnd, rate: f64, x: f64| end.size + rate * (x - end.hold).max(0.0);
    let size = |rate: f64| {
        move |x: f64| {
            let sizes = [from(ends[0], rate, x), from(ends[1], rate, length - x)];
            1.0 / (1.0 / sizes[0] + 1.0 / sizes[1])
        }
    };
    let fits = |rate: f64| {
        let (_, count) = cell_count(length, size(rate));
        count[count.len() - 1] <= n_cells as f64
    };
    let (mut slow, mut fast) = (0.01, 3.0);
    for _ in 0..30 {
        let rate = 0.5 * (slow + fast);
        *if fits(rate) { &mut fast } else { &mut slow } = rate;
    }
    graded(length, n_cells, size(fast))
}

/// Ratio of neighbouring cells when `n_cells` that start at `first` fill `length`:
/// `first (q^n - 1) / (q - 1) = length`, by bisection. Below one when `first` is large.
pub fn growth(first: f64, length: f64, n_cells: usize) -> f64 {
    let wanted = length / first;
    let (mut low, mut high) = (-8.0f64, 8.0f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *if cells_high(middle, n_cells) > wanted {
            &mut high
        } else {
            &mut low
        } = middle;
    }
    (0.5 * (low + high)).exp()
}

/// `(q^n - 1) / (q - 1)` with `q = exp(log_ratio)`: the distance covered by `n` cells, in first
/// cells.
fn cells_high(log_ratio: f64, n_cells: usize) -> f64 {
    if log_ratio.abs() < 1e-12 {
        return n_cells as f64;
    }
    (n_cells as f64 * log_ratio).exp_m1() / log_ratio.exp_m1()
}

/// Distance from the wall of layer `layer` when the first cell has height one and neighbours the
/// ratio `growth`.
#[inline]
pub fn height(growth: f64, layer: usize) -> f64 {
    if (growth - 1.0).abs() < 1e-12 {
        return layer as f64;
    }
    (growth.powi(layer as i32) - 1.0) / (growth - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn graded_nodes_ascend_from_end_to_end() {
        let at = graded_from_ends(
            1.0,
            40,
            [1e-3, 1e-2].map(|size| LineEnd { size, hold: 0.0 }),
        );
        assert_eq!((at.len(), at[0], at[40]), (41, 0.0, 1.0));
        assert!(at.windows(2).all(|pair| pair[0] < pair[1]));
        assert!((at[1] - 1e-3).abs() < 3e-4, "{}", at[1]);
        assert!((at[40] - at[39] - 1e-2).abs() < 3e-3);
    }

    #[test]
    fn grown_layers_fill_the_length() {
        for (first, n) in [(1e-5, 40), (0.1, 10), (0.2, 10)] {
            let growth = growth(first, 1.0, n);
            assert!((first * height(growth, n) - 1.0).abs() < 1e-9);
        }
    }
}

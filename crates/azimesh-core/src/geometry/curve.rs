//! Order along a space-filling curve, so that neighbours in space are neighbours in memory.

use super::bounds::Bounds;
use super::vector::Vector;
use crate::parallel;

const BITS: u32 = 21;
/// Bits an axis where the order may be rough.
const FEW_BITS: u32 = 10;

/// Indices of `points` in the order of a Morton curve over their bounding box; ties to the lowest
/// index.
pub fn order(points: &[Vector]) -> Vec<u32> {
    let along = along(points);
    parallel::collect(along.len(), |at| along[at].1)
}

/// Position along the curve and index of each of `points`, in the order of [`order`]. Equal points
/// have equal positions.
pub fn along(points: &[Vector]) -> Vec<(u64, u32)> {
    let bounds = Bounds::around(points);
    let mut keyed = parallel::collect(points.len(), |i| (key(&points[i], &bounds), i as u32));
    parallel::sort(&mut keyed);
    keyed
}

/// Indices of the points, out of `n`, that are in a box, in the order of a Morton curve over it with
/// 1024 cells an axis; in one cell by index. `12` bytes a point on the way.
pub fn rough_order(n: usize, point: impl Fn(usize) -> Vector + Sync, within: &Bounds) -> Vec<u32> {
    let keyed = |i: usize| {
        let point = point(i);
        let inside = (0..3).all(|k| within.low[k] <= point[k] && point[k] <= within.high[k]);
        inside.then(|| (key(&point, within) >> (3 * (BITS - FEW_BITS))) << 32 | i as u64)
    };
    let mut keyed = parallel::filter_map(n, keyed);
    parallel::sort(&mut keyed);
    parallel::collect(keyed.len(), |at| keyed[at] as u32)
}

/// Position along the curve, 21 bits an axis.
fn key(point: &Vector, bounds: &Bounds) -> u64 {
    let extent = (0..3)
        .map(|i| bounds.high[i] - bounds.low[i])
        .fold(f64::MIN_POSITIVE, f64::max);
    let cells = f64::from((1u32 << BITS) - 1);
    (0..3).fold(0, |key, i| {
        let cell = ((point[i] - bounds.low[i]) / extent * cells) as u64;
        key | spread(cell) << i
    })
}

/// Puts two zero bits between each two of the lowest 21.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_is_a_permutation_and_coincident_points_keep_theirs() {
        let mut points: Vec<Vector> = (0..100)
            .map(|i| [f64::from(i * 37 % 100), f64::from(i * 11 % 7), 0.0])
            .collect();
        points[40] = points[3];
        let order = order(&points);
        let at = |node: u32| order.iter().position(|&i| i == node);
        assert!(at(3) < at(40));
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &x)| i as u32 == x));
    }

    #[test]
    fn the_first_axis_changes_fastest_along_the_curve_and_points_on_the_faces_of_the_box_are_in_it()
    {
        let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
        let points: Vec<Vector> = (0..8).rev().map(corner).collect();
        assert_eq!(order(&points), [7, 6, 5, 4, 3, 2, 1, 0]);
        let within = Bounds::around(&points[..7]);
        assert_eq!(
            rough_order(8, |i| points[i], &within),
            [7, 6, 5, 4, 3, 2, 1, 0]
        );
        let lower = Bounds::around(&[[0.0; 3], [1.0, 1.0, 0.5]]);
        assert_eq!(rough_order(8, |i| points[i], &lower), [7, 6, 5, 4]);
    }
}

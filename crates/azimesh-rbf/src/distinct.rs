//! Points with a least distance from each other.

use azimesh_core::geometry::vector::{Vector, distance};
use std::collections::HashMap;

/// Returns the indices of the points, without images and without points within a distance of `apart` from an earlier one. `O(N)`.
pub fn distinct(points: &[Vector], apart: f64, images: &[bool]) -> Vec<usize> {
    let cell = |x: &Vector| x.map(|x| (x / apart).floor() as i64);
    let mut kept: Vec<usize> = Vec::new();
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (at, point) in points.iter().enumerate() {
        if images.get(at).is_some_and(|image| *image) {
            continue;
        }
        let [i, j, k] = cell(point);
        let around = (0..27).map(|n| {
            [
                i.saturating_add(n % 3 - 1),
                j.saturating_add(n / 3 % 3 - 1),
                k.saturating_add(n / 9 - 1),
            ]
        });
        let near = around
            .filter_map(|cell| cells.get(&cell))
            .flatten()
            .any(|&other| distance(*point, points[other]) < apart);
        if !near {
            cells.entry([i, j, k]).or_default().push(at);
            kept.push(at);
        }
    }
    kept
}

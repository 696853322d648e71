//! The interpolant of every mode at the nodes that deform: `M = Phi_vb W`, one pass over the mesh.

use super::interpolant::Interpolant;
use azimesh_core::geometry::vector::{Vector, add, weighted_sum};
use azimesh_core::geometry::{Bounds, curve};
use azimesh_core::parallel;

/// Nodes that one task moves or places; sums over surface nodes are taken in blocks of it.
pub const BLOCK: usize = 4096;
/// Nodes evaluated between two reports of progress.
const BATCH: usize = 1 << 18;

/// Values of the modes at the nodes that deform.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Nodes that it covers, ascending; `None` for all.
    pub nodes: Option<Vec<u32>>,
    /// Number of modes, r.
    pub n_modes: usize,
    /// `M (N, r)`, by rows, in the order of `nodes`.
    pub values: Vec<f64>,
}

impl Field {
    /// Evaluates the weighted base points at `points`, or at the `points` in `nodes`.
    /// `N n` kernel evaluations. Where the support radius is smaller than the mesh, nodes are taken
    /// along a space-filling curve, so that a block of them sees few base points. `progress` is
    /// called with the number of nodes done.
    pub fn evaluate(
        base: &Interpolant,
        points: &[Vector],
        nodes: Option<Vec<u32>>,
        progress: &dyn Fn(usize),
    ) -> Self {
        let r = base.n_columns;
        let mut field = Self {
            n_modes: r,
            values: vec![0.0; nodes.as_ref().map_or(points.len(), Vec::len) * r],
            nodes,
        };
        if r == 0 {
            return field;
        }
        match &field.nodes {
            None => evaluate_at(base, points, &mut field.values, progress),
            Some(nodes) => {
                let points: Vec<Vector> = nodes.iter().map(|&i| points[i as usize]).collect();
                evaluate_at(base, &points, &mut field.values, progress);
            }
        }
        field
    }

    /// `points + M C` for one step: `coefficients (r, 3)` by rows. Nodes that the field does not
    /// cover are left as they are. `3 r` multiply-adds a node.
    pub fn displace(&self, coefficients: &[f64], reference: &[Vector], out: &mut [Vector]) {
        if self.n_modes == 0 {
            out.copy_from_slice(reference);
            return;
        }
        let (coefficients, _) = coefficients.as_chunks::<3>();
        let r = self.n_modes;
        parallel::for_blocks(out, BLOCK, &|first, out| {
            let reference = &reference[first..][..out.len()];
            let Some(nodes) = &self.nodes else {
                let values = &self.values[first * r..][..out.len() * r];
                return displace_block(values, coefficients, reference, out);
            };
            out.copy_from_slice(reference);
            let from = nodes.partition_point(|&node| (node as usize) < first);
            let to = nodes.partition_point(|&node| (node as usize) < first + out.len());
            for row in from..to {
                let at = nodes[row] as usize - first;
                let values = &self.values[row * r..][..r];
                out[at] = add(reference[at], weighted_sum(values, coefficients));
            }
        });
    }
}

/// Loops over few modes are unrolled.
fn displace_block(values: &[f64], c: &[[f64; 3]], reference: &[Vector], out: &mut [Vector]) {
    match c.len() {
        1 => displace_rows::<1>(values, c, reference, out),
        2 => displace_rows::<2>(values, c, reference, out),
        3 => displace_rows::<3>(values, c, reference, out),
        4 => displace_rows::<4>(values, c, reference, out),
        6 => displace_rows::<6>(values, c, reference, out),
        8 => displace_rows::<8>(values, c, reference, out),
        _ => displace_any(values, c, reference, out),
    }
}

fn displace_rows<const R: usize>(
    values: &[f64],
    c: &[[f64; 3]],
    reference: &[Vector],
    out: &mut [Vector],
) {
    let (rows, _) = values.as_chunks::<R>();
    let c: &[[f64; 3]; R] = c.try_into().expect("there is a coefficient for each mode");
    for ((row, reference), out) in rows.iter().zip(reference).zip(out) {
        *out = add(*reference, weighted_sum(row, c));
    }
}

fn displace_any(values: &[f64], c: &[[f64; 3]], reference: &[Vector], out: &mut [Vector]) {
    let rows = values.chunks_exact(c.len());
    for ((values, reference), out) in rows.zip(reference).zip(out) {
        *out = add(*reference, weighted_sum(values, c));
    }
}

fn evaluate_at(base: &Interpolant, points: &[Vector], out: &mut [f64], progress: &dyn Fn(usize)) {
    let r = base.n_columns;
    let everywhere = Bounds::around(points).union(&Bounds::around(&base.points));
    if base.basis.radius >= everywhere.diagonal() {
        for (points, out) in points.chunks(BATCH).zip(out.chunks_mut(BATCH * r)) {
            base.add_at(points, out);
            progress(points.len());
        }
        return;
    }
    // Blocks much smaller than the support radius are fine enough; a finer order would take twice the memory.
    let order = curve::rough_order(points.len(), |i| points[i], &everywhere);
    evaluate_along(base, points, &order, out, progress);
}

/// Writes the interpolant at the `points` in `order` to their rows of `out`; neighbours
/// in the order should be neighbours in space.
pub fn evaluate_along(
    base: &Interpolant,
    points: &[Vector],
    order: &[u32],
    out: &mut [f64],
    progress: &dyn Fn(usize),
) {
    let r = base.n_columns;
    let mut values = vec![0.0; BATCH.min(order.len()) * r];
    for batch in order.chunks(BATCH) {
        let near: Vec<Vector> = batch.iter().map(|&i| points[i as usize]).collect();
        let values = &mut values[..batch.len() * r];
        values.fill(0.0);
        base.add_at(&near, values);
        for (&node, row) in batch.iter().zip(values.chunks_exact(r)) {
            out[node as usize * r..][..r].copy_from_slice(row);
        }
        progress(batch.len());
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Basis, Kernel};
    use super::*;

    #[test]
    fn a_small_radius_gives_the_same_field_as_evaluation_point_by_point() {
        let points: Vec<Vector> = (0..3000)
            .map(|i| std::array::from_fn(|k| ((i * 3 + k) as f64 * 12.9898).sin() * 4.0))
            .collect();
        let base: Vec<Vector> = points.iter().step_by(37).copied().collect();
        let weights: Vec<f64> = (0..base.len() * 2).map(|i| (i as f64).cos()).collect();
        let weighted = Interpolant {
            basis: Basis {
                kernel: Kernel::WendlandC4,
                radius: 1.1,
            },
            points: base.clone(),
            weights: weights.clone(),
            n_columns: 2,
            polynomial: None,
        };
        let nodes: Vec<u32> = (0..3000).step_by(2).collect();
        let field = Field::evaluate(&weighted, &points, Some(nodes.clone()), &|_| {});
        for (row, &node) in field.values.chunks(2).zip(&nodes) {
            for column in 0..2 {
                let sum: f64 = base
                    .iter()
                    .zip(weights.chunks(2))
                    .map(|(b, w)| weighted.basis.between(&points[node as usize], b) * w[column])
                    .sum();
                assert!((row[column] - sum).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn a_step_is_the_reference_plus_modes_times_coefficients() {
        let field = Field {
            nodes: Some(vec![1]),
            n_modes: 2,
            values: vec![2.0, -1.0],
        };
        let reference = [[0.0; 3], [1.0, 1.0, 1.0]];
        let mut out = [[9.0; 3]; 2];
        field.displace(&[1.0, 0.0, 0.5, 0.0, 1.0, 0.0], &reference, &mut out);
        assert_eq!(out, [[0.0; 3], [3.0, 0.0, 2.0]]);
    }
}

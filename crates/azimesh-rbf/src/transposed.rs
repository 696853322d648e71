//! The transpose of evaluation: `Phi^T (n, N) . values (N, 3)`, without storing `Phi`.

use super::Basis;
use super::evaluate::WeightedBase;
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, add};
use azimesh_core::parallel;

/// Points whose values one task sums up.
const CHUNK: usize = 4096;
/// Tasks whose sums are kept until they are added, in order.
const CHUNKS: usize = 64;

/// The product `Phi^T v` at every base point:
///
/// ```text
/// sum_i phi(|x_i - b_j| / R) v_i
/// ```
///
/// over the `points` in `order`, neighbours in which should be neighbours in space, as those in `base`.
/// On all threads; the sums of fixed-size chunks are added in order. `N n` kernel evaluations, fewer
/// where a chunk is beyond the support radius or its values are zero.
pub fn transposed(
    basis: Basis,
    base: &[Vector],
    points: &[Vector],
    order: &[u32],
    values: &[Vector],
) -> Vec<Vector> {
    let mut sums = vec![[0.0; 3]; base.len()];
    for order in order.chunks(CHUNK * CHUNKS) {
        let parts = parallel::map_blocks(order.len(), CHUNK, &|nodes| {
            ChunkSums::of(basis, base, points, &order[nodes], values)
        });
        for part in &parts {
            for (&j, sum) in part.base.iter().zip(&part.sums) {
                sums[j as usize] = add(sums[j as usize], *sum);
            }
        }
    }
    sums
}

/// The sums over one chunk of points.
struct ChunkSums {
    /// The base points within the support radius.
    base: Vec<u32>,
    sums: Vec<Vector>,
}

impl ChunkSums {
    /// The points replace base points, their values for weights: the kernel is symmetric.
    fn of(
        basis: Basis,
        base: &[Vector],
        points: &[Vector],
        nodes: &[u32],
        values: &[Vector],
    ) -> Self {
        let (near, weights): (Vec<Vector>, Vec<Vector>) = nodes
            .iter()
            .map(|&node| (points[node as usize], values[node as usize]))
            .filter(|(_, value)| *value != [0.0; 3])
            .unzip();
        let bounds = Bounds::around(&near);
        let reached = |j: &u32| {
            let apart = bounds.distance_squared(&base[*j as usize]);
            !near.is_empty() && apart < basis.radius * basis.radius
        };
        let reached: Vec<u32> = (0..base.len() as u32).filter(reached).collect();
        let places: Vec<Vector> = reached.iter().map(|&j| base[j as usize]).collect();
        let mut sums = vec![[0.0; 3]; places.len()];
        let weighted = WeightedBase {
            basis,
            points: &near,
            weights: weights.as_flattened(),
            n_columns: 3,
        };
        weighted.add_at(&places, sums.as_flattened_mut());
        Self {
            base: reached,
            sums,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Kernel;

    fn cloud(n: usize, seed: f64) -> Vec<Vector> {
        let value = |i: usize| (i as f64 * 12.9898 + seed).sin() * 3.0;
        (0..n)
            .map(|i| std::array::from_fn(|k| value(3 * i + k)))
            .collect()
    }

    #[test]
    fn the_transpose_is_the_double_sum_over_the_points_in_the_order() {
        let (points, base) = (cloud(CHUNK + 901, 0.3), cloud(70, 0.9));
        let mut values = cloud(points.len(), 0.5);
        values[17] = [0.0; 3];
        let order: Vec<u32> = (0..points.len() as u32).rev().step_by(2).collect();
        for radius in [0.7, 20.0] {
            let basis = Basis {
                kernel: Kernel::WendlandC2,
                radius,
            };
            let sums = transposed(basis, &base, &points, &order, &values);
            for (b, sum) in base.iter().zip(&sums) {
                for axis in 0..3 {
                    let terms = order.iter().map(|&i| i as usize);
                    let wanted: f64 = terms
                        .map(|i| basis.between(&points[i], b) * values[i][axis])
                        .sum();
                    assert!((sum[axis] - wanted).abs() < 1e-10, "{radius}");
                }
            }
        }
    }
}

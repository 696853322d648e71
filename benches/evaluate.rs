//! Kernel evaluations a second and core, for each kernel and number of modes, beside the rate of
//! plain square roots: each evaluation needs one, so that is the limit.
//!
//! Run with `cargo bench --bench evaluate`; medians of seven runs.

#![allow(clippy::print_stdout)] // a benchmark prints its table

use azimesh::rbf::evaluate::WeightedBase;
use azimesh::rbf::{Basis, Kernel};
use multiversion::multiversion;
use std::hint::black_box;
use std::time::Instant;

const N_POINTS: usize = 1 << 17;
const N_BASE: usize = 1000;
const RUNS: usize = 7;

fn cloud(n: usize, seed: usize) -> Vec<[f64; 3]> {
    let value = |i: usize| ((i + seed) as f64 * 12.9898).sin();
    (0..n)
        .map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2)])
        .collect()
}

fn median_seconds(mut run: impl FnMut()) -> f64 {
    let mut seconds: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[RUNS / 2]
}

#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn square_roots(values: &[f64], repeat: usize) -> f64 {
    let mut sums = [0.0; 32];
    for k in 0..repeat {
        let shift = k as f64;
        for chunk in values.as_chunks::<32>().0 {
            for lane in 0..32 {
                sums[lane] += (chunk[lane] + shift).sqrt();
            }
        }
    }
    sums.iter().sum()
}

fn main() {
    let threads = rayon::current_num_threads() as f64;
    let values: Vec<f64> = (0..1024).map(f64::from).collect();
    let repeat = 100_000;
    let seconds = median_seconds(|| {
        black_box(square_roots(black_box(&values), repeat));
    });
    let limit = (values.len() * repeat) as f64 / seconds / 1e9;
    println!("square roots, one core: {limit:.2} G/s");
    println!("kernel          modes   G evaluations/s/core   of the limit");
    let (points, base) = (cloud(N_POINTS, 1), cloud(N_BASE, 77));
    for kernel in [
        Kernel::WendlandC0,
        Kernel::WendlandC2,
        Kernel::WendlandC4,
        Kernel::WendlandC6,
    ] {
        for n_columns in [1, 3, 4, 8, 30] {
            let weights = vec![0.5; N_BASE * n_columns];
            let weighted = WeightedBase {
                basis: Basis {
                    kernel,
                    radius: 4.0,
                },
                points: &base,
                weights: &weights,
                n_columns,
            };
            let mut out = vec![0.0; N_POINTS * n_columns];
            let seconds = median_seconds(|| weighted.add_at(&points, &mut out));
            black_box(&out);
            let rate = (N_POINTS * N_BASE) as f64 / seconds / threads / 1e9;
            println!(
                "{:<14} {n_columns:>6} {rate:>22.2} {:>13.0}%",
                kernel.name(),
                100.0 * rate / limit
            );
        }
    }
}

//! Kernel evaluations per second and core, for each kernel and number of columns, next to the rate of
//! plain square roots in the same run: each evaluation needs one, so that is the limit.
//!
//! Run with `cargo bench --bench evaluate`. Repetitions take one to four milliseconds and alternate between all
//! measurements, and the best of many counts: other programs on the machine disturb one thread little. Two threads need both
//! cores at once; the rate of roots on two threads, at the end of the line, shows whether both were available.

#![allow(clippy::print_stdout)] // a benchmark prints its tables

use azimesh_rbf::evaluate::WeightedBase;
use azimesh_rbf::{Basis, Kernel};
use multiversion::multiversion;
use pulp::Arch;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::hint::black_box;
use std::time::Instant;

const RUNS: usize = 60;
const KERNELS: [Kernel; 4] = [
    Kernel::WendlandC0,
    Kernel::WendlandC2,
    Kernel::WendlandC4,
    Kernel::WendlandC6,
];

fn main() {
    let pools = [1, 2].map(|n_threads| {
        let pool = ThreadPoolBuilder::new().num_threads(n_threads).build();
        pool.expect("threads can be started")
    });
    println!(
        "billions of evaluations a second and core, one and two threads; parts of the rate of square roots on as many"
    );
    println!("kernel          columns     one     two  scaling  of the limit  default target");
    for kernel in KERNELS {
        for n_columns in [1, 2, 3, 4, 8, 24] {
            Case::new(kernel, n_columns, 1 << 11, 1000, 4.0).print(&pools);
        }
    }
    println!("10,000 base points within the support radius of all:");
    for n_columns in [4, 24] {
        Case::new(Kernel::WendlandC2, n_columns, 1 << 9, 10_000, 4.0).print(&pools);
    }
    println!("10,000 base points, a tenth of the radius of the cloud, each pair counted:");
    for n_columns in [4, 24] {
        Case::new(Kernel::WendlandC2, n_columns, 1 << 12, 10_000, 0.1).print(&pools);
    }
}

/// Points and base points to evaluate.
struct Case {
    basis: Basis,
    n_columns: usize,
    points: Vec<[f64; 3]>,
    base: Vec<[f64; 3]>,
    weights: Vec<f64>,
    out: Vec<f64>,
}

impl Case {
    fn new(kernel: Kernel, n_columns: usize, n_points: usize, n_base: usize, radius: f64) -> Self {
        Self {
            basis: Basis { kernel, radius },
            n_columns,
            points: cloud(n_points, 1),
            base: cloud(n_base, 77),
            weights: vec![0.5; n_base * n_columns],
            out: vec![0.0; n_points * n_columns],
        }
    }

    /// Evaluates once on the threads of a pool; gives billions of pairs a second and core.
    fn rate(&mut self, pool: &ThreadPool, arch: Arch) -> f64 {
        let weighted = WeightedBase {
            basis: self.basis,
            points: &self.base,
            weights: &self.weights,
            n_columns: self.n_columns,
        };
        let n_pairs = self.points.len() * self.base.len();
        rate(pool, n_pairs, || {
            weighted.add_at_with(arch, &self.points, &mut self.out);
        })
    }

    /// Measures everything in turn and prints a line of the best rates.
    fn print(&mut self, pools: &[ThreadPool; 2]) {
        let mut best = [0.0_f64; 5];
        for _ in 0..RUNS {
            let rates = [
                root_rate(&pools[0]),
                self.rate(&pools[0], Arch::new()),
                root_rate(&pools[1]),
                self.rate(&pools[1], Arch::new()),
                self.rate(&pools[0], Arch::Scalar),
            ];
            best = std::array::from_fn(|i| best[i].max(rates[i]));
        }
        let [root_one, one, root_two, two, scalar] = best;
        println!(
            "{:<14} {:>8} {one:>7.2} {two:>7.2} {:>8.2} {:>5.0}% {:>5.0}% {scalar:>15.2}   (roots {root_one:.2}, {root_two:.2})",
            self.basis.kernel.name(),
            self.n_columns,
            2.0 * two / one,
            100.0 * one / root_one,
            100.0 * two / root_two,
        );
    }
}

/// Points in a cube, sorted into small boxes as the nodes of a run are.
fn cloud(n: usize, seed: usize) -> Vec<[f64; 3]> {
    let value = |i: usize| ((i + seed) as f64 * 12.9898).sin();
    let mut points: Vec<[f64; 3]> = (0..n)
        .map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2)])
        .collect();
    points.sort_by_key(|point| point.map(|x| (x * 8.0).floor() as i64));
    points
}

/// Billions of items a second and thread of a pool.
fn rate(pool: &ThreadPool, n_items: usize, run: impl FnOnce() + Send) -> f64 {
    let seconds = pool.install(|| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    });
    n_items as f64 / seconds / pool.current_num_threads() as f64 / 1e9
}

/// Billions of square roots a second and thread.
fn root_rate(pool: &ThreadPool) -> f64 {
    const REPEAT: usize = 1_000;
    let values: Vec<f64> = (0..1024).map(f64::from).collect();
    let n_roots = values.len() * REPEAT * pool.current_num_threads();
    rate(pool, n_roots, || {
        rayon::broadcast(|_| black_box(square_roots(black_box(&values), REPEAT)));
    })
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

//! A morph on the sample blade: what is done once, then positions and the transpose, once and ten times.
//!
//! Run with `cargo bench --bench morph`; numbers of nodes and of base points may be given:
//! `cargo bench --bench morph -- 1000000 1000`.

#![allow(clippy::print_stdout)] // a benchmark prints its table

use azimesh::sample::{BladeOptions, SizeOptions, blade};
use azimesh::{Morph, MorphOptions};
use std::time::Instant;

/// Runs of each part; the quickest counts.
const RUNS: usize = 5;

/// Seconds that `work` takes.
fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

/// The quickest of some runs, and ten in a row.
fn print(name: &str, work: impl Fn()) {
    let least = (0..RUNS).map(|_| seconds(&work)).fold(f64::MAX, f64::min);
    let ten = seconds(|| (0..10).for_each(|_| work()));
    println!("{name:<12} {least:>7.3} s   ten times {ten:>7.3} s");
}

/// Largest memory that the process has had, in MB; where the system tells.
fn peak_mb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes / 1000)
}

fn main() {
    let sizes: Vec<usize> = std::env::args()
        .filter_map(|arg| arg.parse().ok())
        .collect();
    let size = SizeOptions {
        nodes: Some(sizes.first().copied().unwrap_or(1_000_000)),
        ..SizeOptions::default()
    };
    let options = BladeOptions {
        size,
        ..BladeOptions::default()
    };
    let mesh = blade(&options).expect("it can be made").mesh;
    println!(
        "{} nodes, mesh {} MB, peak so far {:?} MB, {} threads",
        mesh.points.len(),
        mesh.memory_bytes() / 1_000_000,
        peak_mb(),
        rayon::current_num_threads()
    );
    let options = MorphOptions {
        moving: "blade".into(),
        fixed: "outer".into(),
        max_points: sizes.get(1).copied().unwrap_or(1000),
        tolerance: 1e-9,
        ..MorphOptions::default()
    };
    let start = Instant::now();
    let morph = Morph::new(mesh, options).expect("it fits the mesh");
    println!(
        "new          {:>7.3} s   {} moving nodes, {} base points, radius {:.3}, peak so far {:?} MB",
        start.elapsed().as_secs_f64(),
        morph.moving().len(),
        morph.base_points().len(),
        morph.basis().radius,
        peak_mb()
    );
    let points = &morph.mesh().points;
    let bent = |&node: &u32| [0.0, 0.0, 1e-2 * points[node as usize][0].powi(2)];
    let displacements: Vec<_> = morph.moving().iter().map(bent).collect();
    let gradient = vec![[1.0, -0.5, 0.25]; points.len()];
    print("points", || drop(morph.points(&displacements)));
    print("pull_back", || drop(morph.pull_back(&gradient)));
    print("report", || drop(morph.report(&displacements)));
    println!("peak {:?} MB", peak_mb());
}

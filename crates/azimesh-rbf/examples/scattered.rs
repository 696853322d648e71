//! Scattered values of a known function, interpolated with each kernel, and the error between the points.
//!
//! Run with `cargo run --example scattered`. The error at the given points is at most the tolerance. A smoother
//! kernel needs fewer base points, and its error at other points is smaller.

#![allow(clippy::print_stdout)] // it prints its table

use azimesh_rbf::{Basis, Kernel, Result, Selection, Vector};

const TOLERANCE: f64 = 1e-3;

fn main() -> Result<()> {
    let points = cloud(4000, 1);
    let others = cloud(1000, 70_001);
    let values: Vec<f64> = points.iter().map(function).collect();
    println!("kernel       base points  error at the points  error at others");
    for kernel in [Kernel::WendlandC0, Kernel::WendlandC2, Kernel::WendlandC4] {
        let basis = Basis {
            kernel,
            radius: 2.0,
        };
        let selection = Selection::to_tolerance(basis, &points, &values, 1, TOLERANCE)?;
        let found = selection.interpolant.at(&others);
        let errors = found
            .iter()
            .zip(&others)
            .map(|(s, x)| (s - function(x)).abs());
        println!(
            "{:<12} {:>11} {:>20.1e} {:>16.1e}",
            kernel.name(),
            selection.base.len(),
            selection.error,
            errors.fold(0.0, f64::max),
        );
    }
    Ok(())
}

fn function(x: &Vector) -> f64 {
    (2.0 * x[0]).sin() * x[1] + (-x[2] * x[2]).exp()
}

/// `n` points in a cube of side 1, by a sequence that fills it evenly.
fn cloud(n: usize, first: usize) -> Vec<Vector> {
    let steps = [0.819_172_513, 0.671_043_607, 0.549_700_478];
    let point = |i: usize| steps.map(|step| (i as f64 * step).fract());
    (first..first + n).map(point).collect()
}

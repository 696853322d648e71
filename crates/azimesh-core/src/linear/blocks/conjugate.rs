//! Conjugate gradients with the incomplete factorisation.

use super::{Blocks, Incomplete, Vector};

/// Result of the solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solved {
    /// Iterations that it took.
    pub iterations: usize,
}

/// Solves `A x = b` from `x = 0` until the residual, measured by the preconditioner, has fallen to `tolerance` of
/// what it was, or for `most` iterations.
pub fn solve(
    matrix: &Blocks,
    factors: &Incomplete,
    b: &[Vector],
    x: &mut [Vector],
    tolerance: f64,
    most: usize,
) -> Solved {
    let n = b.len();
    x.fill([0.0; 3]);
    let mut r = b.to_vec();
    let mut z = vec![[0.0; 3]; n];
    let mut q = vec![[0.0; 3]; n];
    factors.apply(matrix, &r, &mut z);
    let mut p = z.clone();
    let mut rho = product(&r, &z);
    let wanted = tolerance * tolerance * rho;
    let mut iterations = 0;
    while iterations < most && rho > wanted && rho > 0.0 {
        matrix.multiply(&p, &mut q);
        let curvature = product(&p, &q);
        if curvature.is_nan() || curvature <= 0.0 {
            break;
        }
        let alpha = rho / curvature;
        for i in 0..n {
            for axis in 0..3 {
                x[i][axis] += alpha * p[i][axis];
                r[i][axis] -= alpha * q[i][axis];
            }
        }
        factors.apply(matrix, &r, &mut z);
        let next = product(&r, &z);
        let beta = next / rho;
        rho = next;
        for i in 0..n {
            for axis in 0..3 {
                p[i][axis] = z[i][axis] + beta * p[i][axis];
            }
        }
        iterations += 1;
    }
    if iterations == 0 {
        x.copy_from_slice(&p);
    }
    Solved { iterations }
}

/// `a . b`, summed in order.
fn product(a: &[Vector], b: &[Vector]) -> f64 {
    let terms = a.iter().zip(b);
    terms
        .map(|(a, b)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
        .sum()
}

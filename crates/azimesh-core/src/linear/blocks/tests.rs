//! Products and solutions against dense arithmetic.

use super::*;

/// A chain and some couplings across it, diagonally dominant.
fn matrix(n: u32) -> Blocks {
    let pairs: Vec<(u32, u32)> = (1..n)
        .flat_map(|i| [(i, i - 1), (i, i.saturating_sub(5).min(i - 1))])
        .collect();
    let mut matrix = Blocks::with_pattern(n as usize, pairs);
    let mut number = 1u32;
    let mut next = || {
        number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(number >> 8) / f64::from(1 << 24) - 0.5
    };
    for block in matrix.below_mut() {
        *block = std::array::from_fn(|_| next());
    }
    for block in matrix.diagonal_mut() {
        let a: [f64; 9] = std::array::from_fn(|_| 0.3 * next());
        *block = std::array::from_fn(|k| {
            let (i, j) = (k / 3, k % 3);
            (0..3).map(|m| a[3 * i + m] * a[3 * j + m]).sum::<f64>()
                + if i == j { 4.0 } else { 0.0 }
        });
    }
    matrix
}

/// `A x` entry by entry.
fn dense_product(matrix: &Blocks, x: &[Vector]) -> Vec<Vector> {
    let n = x.len() as u32;
    let entry = |i: u32, j: u32, a: usize, b: usize| match i.cmp(&j) {
        std::cmp::Ordering::Equal => matrix.diagonal[i as usize][3 * a + b],
        std::cmp::Ordering::Greater => matrix
            .slot(i, j)
            .map_or(0.0, |at| matrix.below[at][3 * a + b]),
        std::cmp::Ordering::Less => matrix
            .slot(j, i)
            .map_or(0.0, |at| matrix.below[at][3 * b + a]),
    };
    let sum = |i: u32, a: usize| {
        let terms = (0..n).flat_map(|j| (0..3).map(move |b| (j, b)));
        terms
            .map(|(j, b)| entry(i, j, a, b) * x[j as usize][b])
            .sum()
    };
    (0..n).map(|i| std::array::from_fn(|a| sum(i, a))).collect()
}

#[test]
fn a_product_is_that_of_the_whole_symmetric_matrix() {
    let matrix = matrix(40);
    let x: Vec<Vector> = (0..40)
        .map(|i| [f64::from(i).sin(), f64::from(i).cos(), 1.0])
        .collect();
    let mut y = vec![[9.0; 3]; 40];
    matrix.multiply(&x, &mut y);
    for (found, wanted) in y.iter().zip(dense_product(&matrix, &x)) {
        for axis in 0..3 {
            assert!((found[axis] - wanted[axis]).abs() < 1e-12);
        }
    }
}

#[test]
fn conjugate_gradients_solve_the_system() {
    let matrix = matrix(200);
    let wanted: Vec<Vector> = (0..200).map(|i| [1.0, f64::from(i % 7), -2.0]).collect();
    let mut b = vec![[0.0; 3]; 200];
    matrix.multiply(&wanted, &mut b);
    let factors = Incomplete::new(&matrix).expect("it is positive");
    let mut x = vec![[0.0; 3]; 200];
    let solved = solve(&matrix, &factors, &b, &mut x, 1e-12, 200);
    assert!(solved.iterations < 60, "{}", solved.iterations);
    for (found, wanted) in x.iter().zip(&wanted) {
        for axis in 0..3 {
            assert!((found[axis] - wanted[axis]).abs() < 1e-8);
        }
    }
}

#[test]
fn the_factors_of_a_chain_are_exact() {
    let mut chain = Blocks::with_pattern(50, (1..50).map(|i| (i, i - 1)).collect());
    chain
        .below_mut()
        .fill([-1.0, 0.2, 0.0, 0.0, -1.0, 0.0, 0.1, 0.0, -1.0]);
    chain
        .diagonal_mut()
        .fill([2.5, 0.1, 0.0, 0.1, 2.5, 0.0, 0.0, 0.0, 2.5]);
    let factors = Incomplete::new(&chain).expect("it is positive");
    let wanted: Vec<Vector> = (0..50).map(|i| [f64::from(i), 1.0, 0.5]).collect();
    let (mut b, mut x) = (vec![[0.0; 3]; 50], vec![[0.0; 3]; 50]);
    chain.multiply(&wanted, &mut b);
    factors.apply(&chain, &b, &mut x);
    for (found, wanted) in x.iter().zip(&wanted) {
        for axis in 0..3 {
            assert!((found[axis] - wanted[axis]).abs() < 1e-9);
        }
    }
}

#[test]
fn a_matrix_that_is_not_positive_gets_a_larger_diagonal() {
    let mut matrix = Blocks::with_pattern(2, vec![(1, 0)]);
    matrix
        .diagonal_mut()
        .fill([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    matrix.below_mut()[0] = [2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    assert!(Incomplete::new(&matrix).is_some());
    matrix.diagonal_mut()[1] = [0.0; 9];
    assert!(Incomplete::new(&matrix).is_none());
}

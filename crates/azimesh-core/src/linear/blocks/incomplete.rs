//! An incomplete factorisation on the pattern of the matrix, as a preconditioner.
//!
//! ```text
//! A ~ L D L^T,   L_ii = I,   L_ij = W_ij / D_j,
//! W_ij = A_ij - sum_k W_ik L_jk^T,   D_i = A_ii - sum_k W_ik L_ik^T
//! ```
//!
//! with sums over the blocks that the pattern has. It is exact for chains of nodes, as the normals of a boundary
//! layer are. Where a pivot is not positive, all of the diagonal is raised and the factorisation is repeated
//! (T. A. Manteuffel, An incomplete factorization technique for positive definite linear systems, Math. Comp. 34,
//! 1980).

use super::{Block, Blocks, Vector, subtract_times, subtract_transposed_times, times};
use multiversion::multiversion;

/// Part of the diagonal that is added if a pivot is not positive; four times as much at each attempt.
const FIRST_SHIFT: f64 = 1e-3;
/// A pivot below this part of its diagonal entry counts as zero.
const LEAST_PIVOT: f64 = 1e-10;

/// The factors of a matrix.
#[derive(Debug, Clone)]
pub struct Incomplete {
    lower: Vec<Block>,
    inverse_diagonal: Vec<Block>,
}

impl Incomplete {
    /// Factorises; `None` where even a matrix of the diagonal alone has a block that is not positive.
    pub fn new(matrix: &Blocks) -> Option<Self> {
        let mut shift = 0.0;
        while shift < 100.0 {
            let mut factors = Self {
                lower: vec![[0.0; 9]; matrix.below.len()],
                inverse_diagonal: vec![[0.0; 9]; matrix.n_rows()],
            };
            if factorise(matrix, shift, &mut factors) {
                return Some(factors);
            }
            shift = if shift == 0.0 {
                FIRST_SHIFT
            } else {
                4.0 * shift
            };
        }
        None
    }

    /// `z = (L D L^T)^-1 r`.
    pub fn apply(&self, matrix: &Blocks, r: &[Vector], z: &mut [Vector]) {
        apply(self, &matrix.starts, &matrix.columns, r, z);
    }
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn factorise(matrix: &Blocks, shift: f64, factors: &mut Incomplete) -> bool {
    let n = matrix.n_rows();
    // Index of each column in the current row.
    let mut place = vec![usize::MAX; n];
    let mut row_values: Vec<Block> = Vec::new();
    for row in 0..n {
        let range = matrix.starts[row]..matrix.starts[row + 1];
        let columns = &matrix.columns[range.clone()];
        row_values.clear();
        row_values.extend_from_slice(&matrix.below[range.clone()]);
        for (at, &column) in columns.iter().enumerate() {
            place[column as usize] = at;
        }
        let mut pivot = matrix.diagonal[row];
        let limits = [pivot[0], pivot[4], pivot[8]].map(|entry| LEAST_PIVOT * entry);
        for axis in [0, 4, 8] {
            pivot[axis] *= 1.0 + shift;
        }
        for (at, &column) in columns.iter().enumerate() {
            let column = column as usize;
            let mut w = row_values[at];
            let of_column = matrix.starts[column]..matrix.starts[column + 1];
            for k in of_column {
                let found = place[matrix.columns[k] as usize];
                if found != usize::MAX {
                    subtract_product_transposed(&mut w, &row_values[found], &factors.lower[k]);
                }
            }
            row_values[at] = w;
            let l = product(&w, &factors.inverse_diagonal[column]);
            subtract_product_transposed(&mut pivot, &w, &l);
            factors.lower[range.start + at] = l;
        }
        for &column in columns {
            place[column as usize] = usize::MAX;
        }
        match inverse(&pivot, limits) {
            Some(inverse) => factors.inverse_diagonal[row] = inverse,
            None => return false,
        }
    }
    true
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn apply(factors: &Incomplete, starts: &[usize], columns: &[u32], r: &[Vector], z: &mut [Vector]) {
    let n = r.len();
    for row in 0..n {
        let mut sum = r[row];
        let range = starts[row]..starts[row + 1];
        for (&column, block) in columns[range.clone()].iter().zip(&factors.lower[range]) {
            subtract_times(&mut sum, block, z[column as usize]);
        }
        z[row] = sum;
    }
    for row in 0..n {
        z[row] = times(&factors.inverse_diagonal[row], z[row]);
    }
    for row in (0..n).rev() {
        let own = z[row];
        let range = starts[row]..starts[row + 1];
        for (&column, block) in columns[range.clone()].iter().zip(&factors.lower[range]) {
            subtract_transposed_times(&mut z[column as usize], block, own);
        }
    }
}

/// `A B`.
#[inline(always)]
fn product(a: &Block, b: &Block) -> Block {
    let mut c = [0.0; 9];
    for i in 0..3 {
        for j in 0..3 {
            c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
        }
    }
    c
}

/// `C -= A B^T`.
#[inline(always)]
fn subtract_product_transposed(c: &mut Block, a: &Block, b: &Block) {
    for i in 0..3 {
        for j in 0..3 {
            c[3 * i + j] -=
                a[3 * i] * b[3 * j] + a[3 * i + 1] * b[3 * j + 1] + a[3 * i + 2] * b[3 * j + 2];
        }
    }
}

/// The inverse of a symmetric block by its Cholesky factors; `None` where a pivot is not above its limit.
#[inline(always)]
fn inverse(a: &Block, limits: [f64; 3]) -> Option<Block> {
    let d0 = a[0];
    if d0.is_nan() || d0 <= limits[0] {
        return None;
    }
    let (l10, l20) = (a[3] / d0, a[6] / d0);
    let d1 = a[4] - l10 * a[3];
    if d1.is_nan() || d1 <= limits[1] {
        return None;
    }
    let m21 = a[7] - l20 * a[3];
    let l21 = m21 / d1;
    let d2 = a[8] - l20 * a[6] - l21 * m21;
    if d2.is_nan() || d2 <= limits[2] {
        return None;
    }
    // L^-1, then L^-T D^-1 L^-1.
    let (i10, i21) = (-l10, -l21);
    let i20 = l10 * l21 - l20;
    let (e0, e1, e2) = (1.0 / d0, 1.0 / d1, 1.0 / d2);
    let b00 = e0 + i10 * i10 * e1 + i20 * i20 * e2;
    let b10 = i10 * e1 + i21 * i20 * e2;
    let b20 = i20 * e2;
    let b11 = e1 + i21 * i21 * e2;
    let b21 = i21 * e2;
    Some([b00, b10, b20, b10, b11, b21, b20, b21, e2])
}

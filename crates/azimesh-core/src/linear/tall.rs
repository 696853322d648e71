//! Matrices of many rows and few columns, stored by rows: an orthonormal basis of their columns, and
//! products of their blocks of rows.

use super::Matrix;
use crate::parallel;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Rows that one task factors.
const CHUNK_ROWS: usize = 8192;

/// Puts an orthonormal basis in the place of the columns of `rows (m, n_cols)`: `Q` of a QR
/// factorization in two levels, of chunks and of their triangular factors. Columns that depend on
/// those before them leave directions of no meaning; with fewer rows than columns, the last columns
/// are zero. O(m n_cols^2).
pub fn orthonormalize(rows: &mut [f64], n_cols: usize) {
    let factor = |_, chunk: &mut [f64]| {
        let mut chunk = row_major_mut(chunk, n_cols);
        let qr = chunk.as_ref().qr();
        chunk.fill(0.0);
        let n = chunk.nrows().min(n_cols);
        chunk.subcols_mut(0, n).copy_from(qr.compute_thin_Q());
        qr.thin_R().to_owned()
    };
    let factors = parallel::map_items(rows.chunks_mut(CHUNK_ROWS * n_cols), &factor);
    let n_stacked = factors.iter().map(Mat::nrows).sum();
    let mut stacked = Mat::zeros(n_stacked, n_cols);
    let mut starts = Vec::with_capacity(factors.len());
    let mut start = 0;
    for factor in &factors {
        starts.push(start..start + factor.nrows());
        let rows = stacked.subrows_mut(start, factor.nrows());
        rows.get_mut(.., ..).copy_from(factor);
        start += factor.nrows();
    }
    let basis = stacked.qr().compute_thin_Q();
    parallel::for_blocks(rows, CHUNK_ROWS * n_cols, &|first, chunk| {
        let block = &starts[first / (CHUNK_ROWS * n_cols)];
        let mut chunk = row_major_mut(chunk, n_cols);
        let own = chunk.as_ref().subcols(0, block.len()).to_owned();
        let block = basis.subrows(block.start, block.len());
        chunk.fill(0.0);
        let product = chunk.subcols_mut(0, basis.ncols());
        matmul(product, Accum::Replace, own, block, 1.0, Par::Seq);
    });
}

/// `rows (m, n) := rows . by (n, n)`, a chunk at a time.
pub fn multiply(rows: &mut [f64], by: &Matrix) {
    let n = by.n_rows();
    parallel::for_blocks(rows, CHUNK_ROWS * n, &|_, chunk| {
        let mut chunk = row_major_mut(chunk, n);
        let own = chunk.to_owned();
        matmul(
            chunk.as_mut(),
            Accum::Replace,
            own,
            by.as_faer(),
            1.0,
            Par::Seq,
        );
    });
}

/// `out (n_cols, n) += rows (m, n_cols)^T . tile (m, n)`; `out` and `tile` by columns, on one thread.
pub fn add_transposed_product(out: &mut [f64], rows: &[f64], tile: &[f64], n_cols: usize) {
    let m = rows.len() / n_cols;
    let n = tile.len() / m;
    matmul(
        MatMut::from_column_major_slice_mut(out, n_cols, n),
        Accum::Add,
        MatRef::from_row_major_slice(rows, m, n_cols).transpose(),
        MatRef::from_column_major_slice(tile, m, n),
        1.0,
        Par::Seq,
    );
}

/// `tile (m, n) -= left (m, r) . right (n, r)^T`, `tile` by columns, the others by rows; on one thread.
pub fn subtract_product(tile: &mut [f64], left: &[f64], right: &[f64], r: usize) {
    let (m, n) = (left.len() / r, right.len() / r);
    matmul(
        MatMut::from_column_major_slice_mut(tile, m, n),
        Accum::Add,
        MatRef::from_row_major_slice(left, m, r),
        MatRef::from_row_major_slice(right, n, r).transpose(),
        -1.0,
        Par::Seq,
    );
}

fn row_major_mut(values: &mut [f64], n_cols: usize) -> MatMut<'_, f64> {
    let n_rows = values.len() / n_cols;
    MatMut::from_row_major_slice_mut(values, n_rows, n_cols)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of `n_cols` columns whose last depends on the first two.
    fn dependent(n_rows: usize, n_cols: usize) -> Vec<f64> {
        let entry = |at: usize| ((at * at % 1013) as f64 * 0.7).sin();
        let mut rows: Vec<f64> = (0..n_rows * n_cols).map(entry).collect();
        for row in rows.chunks_exact_mut(n_cols) {
            row[n_cols - 1] = row[0] - 3.0 * row[1];
        }
        rows
    }

    #[test]
    fn a_basis_is_orthonormal_and_spans_the_columns() {
        for n_rows in [5, 100, 2 * CHUNK_ROWS + 3] {
            let n_cols = 5;
            let rows = dependent(n_rows, n_cols);
            let mut basis = rows.clone();
            orthonormalize(&mut basis, n_cols);
            let mut gram = vec![0.0; n_cols * n_cols];
            let columns = Matrix::from_fn(n_rows, n_cols, |i, j| basis[i * n_cols + j]);
            add_transposed_product(&mut gram, &basis, &columns.values, n_cols);
            for (at, value) in gram.iter().enumerate() {
                let identity = f64::from(u8::from(at % n_cols == at / n_cols));
                assert!((value - identity).abs() < 1e-13, "{n_rows} rows: {value}");
            }
            // The columns minus their projection.
            let mut rest = Matrix::from_fn(n_rows, n_cols, |i, j| rows[i * n_cols + j]);
            let mut along = vec![0.0; n_cols * n_cols];
            add_transposed_product(&mut along, &basis, &rest.values, n_cols);
            subtract_product(&mut rest.values, &basis, &along, n_cols);
            assert!(rest.values.iter().all(|value| value.abs() < 1e-12));
        }
    }

    #[test]
    fn fewer_rows_than_columns_are_a_basis_and_zeros() {
        let mut rows = dependent(2, 5);
        orthonormalize(&mut rows, 5);
        let product =
            |i: usize, j: usize| -> f64 { (0..2).map(|k| rows[k * 5 + i] * rows[k * 5 + j]).sum() };
        assert!((product(0, 0) - 1.0).abs() < 1e-14 && (product(1, 1) - 1.0).abs() < 1e-14);
        assert!(product(0, 1).abs() < 1e-14 && product(2, 2) == 0.0 && product(4, 4) == 0.0);
    }

    #[test]
    fn rows_are_multiplied_in_place() {
        let mut rows = dependent(CHUNK_ROWS + 1, 3);
        let (first, last) = (rows[0], rows[3 * CHUNK_ROWS]);
        multiply(
            &mut rows,
            &Matrix::from_fn(3, 3, |i, j| f64::from(u8::from(i == 0 && j == 2))),
        );
        assert_eq!((rows[2], rows[3 * CHUNK_ROWS + 2]), (first, last));
        assert_eq!((rows[0], rows[1]), (0.0, 0.0));
    }
}

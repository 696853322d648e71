//! Modes of rigid bodies together with nodes that move in any other way.

use super::{Form, Modes, RigidSurface, right_factor};
use azimesh_core::error::Result;
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::linear::Matrix;
use azimesh_core::parallel;
use std::ops::Range;

impl Modes {
    /// Computes the modes of a surface some of whose nodes move with rigid bodies, exact to round-off; the others move freely,
    /// and are within `limit`. See [`Modes::of_rigid_bodies`] and [`Modes::of_displacements`].
    ///
    /// `displacements(step, nodes, out)` is called for all nodes; its results for nodes of bodies are not used, and it need not
    /// write them.
    pub fn of_mixed(
        surface: RigidSurface<'_>,
        poses: &[Vec<Transform>],
        n_steps: usize,
        limit: f64,
        form: Form,
        displacements: impl Fn(usize, Range<usize>, &mut [Vector]) + Sync,
    ) -> Result<Self> {
        let rigid = Self::of_rigid_bodies(surface, poses, form)?;
        let others = |step: usize, nodes: Range<usize>, out: &mut [Vector]| {
            displacements(step, nodes.clone(), out);
            for (out, body) in out.iter_mut().zip(&surface.body[nodes]) {
                if body.is_some() {
                    *out = [0.0; 3];
                }
            }
        };
        let n_nodes = surface.points.len();
        let others = Self::of_displacements(n_nodes, n_steps, limit, form, others)?;
        if rigid.n_modes == 0 || others.n_modes == 0 {
            let truncation = rigid.truncation.max(others.truncation);
            let some = if rigid.n_modes == 0 { others } else { rigid };
            return Ok(Self { truncation, ..some });
        }
        rigid.joined(others, n_steps, form)
    }

    /// Computes the modes of the sum of two motions that share no node: `D = [U U'] [C; C']`. The columns of `U` and `U'` are
    /// orthogonal, so the singular values equal the singular values of `[C; C']` with its rows scaled by their lengths. As C C^T = I
    /// for both parts, modes with the same course in time become one.
    fn joined(self, other: Self, n_steps: usize, form: Form) -> Result<Self> {
        let truncation = self.truncation.max(other.truncation);
        let (lengths, others) = (self.lengths(form), other.lengths(form));
        let lengths = [lengths, others].concat();
        let both = self.beside(other, n_steps);
        let rows = both.rows(n_steps, form);
        let scaled = Matrix::from_fn(rows.n_rows(), rows.n_cols(), |i, j| {
            lengths[i] * rows[(i, j)]
        });
        let right = right_factor(&scaled)?;
        let to_modes = rows.times(&right);
        let values = both.combined(&to_modes, form);
        let modes = match form {
            Form::Scalar => Self::scalar(&right, n_steps),
            Form::Vector => Self::vector(&right, n_steps),
        };
        Ok(Self {
            values,
            truncation,
            ..modes
        })
    }

    /// Columns of `values` that one mode has.
    fn columns_a_mode(form: Form) -> usize {
        match form {
            Form::Scalar => 1,
            Form::Vector => 3,
        }
    }

    /// The length of each mode over all nodes, summed in chunks of fixed size.
    fn lengths(&self, form: Form) -> Vec<f64> {
        let columns = Self::columns_a_mode(form);
        let chunk = super::CHUNK * self.n_modes;
        let parts = parallel::map_blocks(self.values.len(), chunk, &|rows| {
            let mut squares = vec![0.0; self.n_modes / columns];
            for row in self.values[rows].chunks_exact(self.n_modes) {
                for (square, values) in squares.iter_mut().zip(row.chunks_exact(columns)) {
                    *square += values.iter().map(|value| value * value).sum::<f64>();
                }
            }
            squares
        });
        let n = self.n_modes / columns;
        let sum = |mode: usize| parts.iter().map(|part| part[mode]).sum::<f64>();
        (0..n).map(|mode| sum(mode).sqrt()).collect()
    }

    /// The coefficients by modes: (r, 3K), or (r_v, K) of vector modes.
    fn rows(&self, n_steps: usize, form: Form) -> Matrix {
        let columns = Self::columns_a_mode(form);
        let a_step = 3 / columns;
        Matrix::from_fn(self.n_modes / columns, n_steps * a_step, |mode, column| {
            self.at_step(column / a_step)[3 * columns * mode + column % a_step]
        })
    }

    /// Values times a matrix of modes to modes; the components of vector modes alike.
    fn combined(&self, to_modes: &Matrix, form: Form) -> Vec<f64> {
        let columns = Self::columns_a_mode(form);
        let r = columns * to_modes.n_cols();
        let mut values = vec![0.0; self.values.len() / self.n_modes * r];
        let block = super::CHUNK * r.max(1);
        parallel::for_blocks(&mut values, block, &|first, values| {
            let own = self.values[first / r * self.n_modes..].chunks_exact(self.n_modes);
            for (out, row) in values.chunks_exact_mut(r).zip(own) {
                for (at, out) in out.iter_mut().enumerate() {
                    let weights = to_modes.column(at / columns).iter();
                    let own = row.iter().skip(at % columns).step_by(columns);
                    *out = own.zip(weights).map(|(value, weight)| value * weight).sum();
                }
            }
        });
        values
    }
}

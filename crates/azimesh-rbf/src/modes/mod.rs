//! Any motion as a few fields times coefficients per step.
//!
//! ```text
//! D (N_s, 3K) = U (N_s, r) C (r, 3K),   C C^T = I
//! ```
//!
//! `D` holds the prescribed displacements of the surface nodes at every step and is never stored.
//! Rigid bodies are factored here, exactly; any other motion in `sketch`; both together in `mixed`.
//! Knows node positions and rigid transforms; nothing of schedules or base points.

mod displacements;
mod measure;
mod mixed;
mod sketch;

use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, scale, sub, weighted_sum};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_core::linear::{Matrix, qr_factor, svd};
use azimesh_core::parallel;
use multiversion::multiversion;

/// Fields of a rigid body: 1, x, y, z.
const FIELDS: usize = 4;
/// Singular values below this part of the largest are round-off.
const ROUND_OFF: f64 = 1e-15;
/// Nodes of one task, and those that are measured side by side.
const CHUNK: usize = 2048;
const LANES: usize = 8;

/// Modes of a motion at the surface nodes, with their coefficients at every step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Modes {
    /// Number of modes, r.
    pub n_modes: usize,
    /// `U (N_s, r)`, by rows, in mesh units: the singular values are in it.
    pub values: Vec<f64>,
    /// `C_k` by steps: (K, r, 3).
    pub coefficients: Vec<f64>,
    /// Largest distance between a displacement and its modes at any node and step, in mesh units.
    pub truncation: f64,
}

/// Form of the factors of data with three components.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Fields of one value at a node, with three coefficients each: the components are interpolated
    /// alike.
    Scalar,
    /// Fields of three values at a node, with one coefficient each: column `3 m + a` is component `a`
    /// of vector mode `m`. For interpolants that couple the components.
    Vector,
}

/// Surface nodes that move rigidly in groups: `body[i]` says with which body node `i` moves, `None`
/// that it stays.
#[derive(Debug, Clone, Copy)]
pub struct RigidSurface<'a> {
    /// Surface nodes, N_s of them.
    pub points: &'a [Vector],
    /// The body of each node.
    pub body: &'a [Option<u16>],
}

impl Modes {
    /// The modes of rigid bodies, exact to round-off: each spans at most the four fields 1, x, y, z
    /// on its nodes, so the factors follow from a QR of those fields and the singular values of
    /// (4, 3K) coefficients. `poses[b][k]` is body `b` at step `k`.
    pub fn of_rigid_bodies(
        surface: RigidSurface<'_>,
        poses: &[Vec<Transform>],
        form: Form,
    ) -> Result<Self> {
        let n_steps = poses.first().map_or(0, Vec::len);
        let scalings = scalings(surface, poses.len());
        let coefficients = coefficients(&scalings, poses, n_steps);
        // F = Q R, so D = Q (R A) = Q U' S V^T, and U = Q U' S = F R^-1 U' S = F A V.
        let projected = stacked_factor(surface, &scalings).times(&coefficients);
        let right = match form {
            Form::Scalar => right_factor(&projected)?,
            Form::Vector => right_factor(&components_as_rows(&projected))?,
        };
        let mut modes = match form {
            Form::Scalar => Self::scalar(&right, n_steps),
            Form::Vector => Self::vector(&right, n_steps),
        };
        let to_modes = match form {
            Form::Scalar => coefficients.times(&right),
            Form::Vector => {
                let to_modes = components_as_rows(&coefficients).times(&right);
                Matrix::from_fn(coefficients.n_rows(), modes.n_modes, |field, column| {
                    to_modes[(3 * field + column % 3, column / 3)]
                })
            }
        };
        modes.values = mode_values(surface, &scalings, &to_modes);
        modes.truncation = modes.largest_truncation(surface, poses);
        Ok(modes)
    }

    /// Scalar modes with coefficients from `V (3K, r)`; values are still to come.
    fn scalar(right: &Matrix, n_steps: usize) -> Self {
        let r = right.n_cols();
        Self {
            n_modes: r,
            values: Vec::new(),
            coefficients: (0..n_steps * r * 3)
                .map(|at| {
                    let (step, rest) = (at / (3 * r), at % (3 * r));
                    right[(3 * step + rest % 3, rest / 3)]
                })
                .collect(),
            truncation: 0.0,
        }
    }

    /// Three columns for each vector mode, with coefficients `V (K, r_v)` on the diagonal of the
    /// components; values are still to come.
    fn vector(right: &Matrix, n_steps: usize) -> Self {
        let r = 3 * right.n_cols();
        let mut coefficients = vec![0.0; n_steps * r * 3];
        for step in 0..n_steps {
            for column in 0..r {
                coefficients[(step * r + column) * 3 + column % 3] = right[(step, column / 3)];
            }
        }
        Self {
            n_modes: r,
            values: Vec::new(),
            coefficients,
            truncation: 0.0,
        }
    }

    /// These modes followed by others of the same nodes and steps: the sum of both motions.
    pub fn beside(self, other: Self, n_steps: usize) -> Self {
        let (a, b) = (self.n_modes, other.n_modes);
        let n_nodes = (self.values.len() + other.values.len()) / (a + b).max(1);
        let values = interleave(n_nodes, &self.values, a, &other.values, b);
        let (c, d) = (&self.coefficients, &other.coefficients);
        let coefficients = interleave(n_steps, c, 3 * a, d, 3 * b);
        Self {
            n_modes: a + b,
            values,
            coefficients,
            truncation: self.truncation + other.truncation,
        }
    }

    /// Number of steps.
    pub fn n_steps(&self) -> usize {
        self.coefficients.len() / (3 * self.n_modes).max(1)
    }

    /// `C_k (r, 3)`, by rows.
    pub fn at_step(&self, step: usize) -> &[f64] {
        &self.coefficients[step * 3 * self.n_modes..][..3 * self.n_modes]
    }

    /// The displacement of a surface node at a step.
    pub fn displacement(&self, node: usize, step: usize) -> Vector {
        let values = &self.values[node * self.n_modes..][..self.n_modes];
        weighted_sum(values, self.at_step(step).as_chunks::<3>().0)
    }

    /// Largest absolute value of each component over all nodes and steps.
    pub fn largest_components(&self) -> Vector {
        if self.n_modes == 0 {
            return [0.0; 3];
        }
        let larger = |a: Vector, b: Vector| {
            let of = |axis: usize| a[axis].max(b[axis].abs());
            [of(0), of(1), of(2)]
        };
        let at_node = |node: usize| {
            let moved = (0..self.n_steps()).map(|step| self.displacement(node, step));
            moved.fold([0.0; 3], larger)
        };
        let n_nodes = self.values.len() / self.n_modes;
        let blocks = parallel::map_blocks(n_nodes, CHUNK, &|nodes| {
            nodes.map(at_node).fold([0.0; 3], larger)
        });
        blocks.into_iter().fold([0.0; 3], larger)
    }

    /// Over nodes in chunks, each chunk by runs of nodes of one body; nodes that stay have no error.
    fn largest_truncation(&self, surface: RigidSurface<'_>, poses: &[Vec<Transform>]) -> f64 {
        if self.n_modes == 0 {
            return 0.0;
        }
        let r = self.n_modes;
        let largest = parallel::map_blocks(surface.points.len(), CHUNK, &|nodes| {
            let mut first = nodes.start;
            let runs = surface.body[nodes].chunk_by(|a, b| a == b);
            runs.fold(0.0, |worst, run| {
                let of_run = first..first + run.len();
                first = of_run.end;
                let Some(body) = run[0] else { return worst };
                let values = &self.values[of_run.start * r..of_run.end * r];
                let points = &surface.points[of_run];
                let square = largest_square(self, points, values, &poses[usize::from(body)]);
                f64::max(worst, square)
            })
        });
        largest.into_iter().fold(0.0, f64::max).sqrt()
    }
}

/// Largest square of the distance between the displacement of some nodes by `poses` and that by
/// their values of the modes. Plain loops over nodes side by side, so that each line is one
/// instruction for all: 40 flops a node and step.
#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn largest_square(modes: &Modes, points: &[Vector], values: &[f64], poses: &[Transform]) -> f64 {
    let r = modes.n_modes;
    let mut largest = [0.0; LANES];
    let mut x = [[0.0; LANES]; 3];
    let mut u = vec![[0.0; LANES]; r];
    for first in (0..points.len()).step_by(LANES) {
        for lane in 0..LANES {
            // The last node again in lanes that are left.
            let node = (first + lane).min(points.len() - 1);
            for axis in 0..3 {
                x[axis][lane] = points[node][axis];
            }
            for mode in 0..r {
                u[mode][lane] = values[node * r + mode];
            }
        }
        for (step, pose) in poses.iter().enumerate() {
            let (coefficients, _) = modes.at_step(step).as_chunks::<3>();
            let mut square = [0.0; LANES];
            for axis in 0..3 {
                let (row, shift) = (pose.rotation[axis], pose.translation[axis]);
                let mut moved = [0.0; LANES];
                for (u, c) in u.iter().zip(coefficients) {
                    for lane in 0..LANES {
                        moved[lane] += u[lane] * c[axis];
                    }
                }
                for lane in 0..LANES {
                    let turned = row[0] * x[0][lane] + row[1] * x[1][lane] + row[2] * x[2][lane];
                    let off = turned + shift - x[axis][lane] - moved[lane];
                    square[lane] += off * off;
                }
            }
            for lane in 0..LANES {
                largest[lane] = if square[lane] > largest[lane] {
                    square[lane]
                } else {
                    largest[lane]
                };
            }
        }
    }
    largest.into_iter().fold(0.0, f64::max)
}

/// The right singular vectors of a matrix, except round-off.
fn right_factor(matrix: &Matrix) -> Result<Matrix> {
    let (_, singular, right) = svd(matrix)?;
    let floor = singular.first().copied().unwrap_or(0.0) * ROUND_OFF;
    let n_modes = singular.iter().filter(|s| **s > floor).count();
    Ok(Matrix::from_fn(right.n_rows(), n_modes, |i, j| {
        right[(i, j)]
    }))
}

/// (n, 3K) as (3n, K): entry (i, 3k + a) goes to (3i + a, k).
fn components_as_rows(matrix: &Matrix) -> Matrix {
    Matrix::from_fn(3 * matrix.n_rows(), matrix.n_cols() / 3, |row, step| {
        matrix[(row / 3, 3 * step + row % 3)]
    })
}

/// `n` rows of `a` and `b` values in turn.
fn interleave(n: usize, first: &[f64], a: usize, second: &[f64], b: usize) -> Vec<f64> {
    let row = |row: usize| {
        let first = &first[row * a..(row + 1) * a];
        first.iter().chain(&second[row * b..(row + 1) * b])
    };
    (0..n).flat_map(row).copied().collect()
}

/// Centre and scale of a body's fields, so that they are of order one.
#[derive(Clone, Copy)]
struct Scaling {
    centre: Vector,
    size: f64,
}

fn scalings(surface: RigidSurface<'_>, n_bodies: usize) -> Vec<Scaling> {
    let mut bounds = vec![Bounds::EMPTY; n_bodies];
    for (point, body) in surface.points.iter().zip(surface.body) {
        if let Some(body) = body {
            bounds[usize::from(*body)].include(point);
        }
    }
    let scaling = |b: &Bounds| Scaling {
        centre: std::array::from_fn(|i| {
            if b.low[i] <= b.high[i] {
                0.5 * (b.low[i] + b.high[i])
            } else {
                0.0
            }
        }),
        size: match b.diagonal() {
            0.0 => 1.0,
            diagonal => 0.5 * diagonal,
        },
    };
    bounds.iter().map(scaling).collect()
}

fn fields(point: &Vector, scaling: &Scaling) -> [f64; FIELDS] {
    let [x, y, z] = scale(sub(*point, scaling.centre), 1.0 / scaling.size);
    [1.0, x, y, z]
}

/// `A (4 bodies, 3K)`: displacements in the bodies' fields. With x = c + s q, a pose `R x + t` moves
/// by `(R c + t - c) + s (R - I) q`.
fn coefficients(scalings: &[Scaling], poses: &[Vec<Transform>], n_steps: usize) -> Matrix {
    let mut a = Matrix::zeros(FIELDS * scalings.len(), 3 * n_steps);
    for (body, scaling) in scalings.iter().enumerate() {
        for (step, pose) in poses[body].iter().enumerate() {
            let moved = sub(pose.apply(scaling.centre), scaling.centre);
            for axis in 0..3 {
                let column = a.column_mut(3 * step + axis);
                column[FIELDS * body] = moved[axis];
                for field in 0..3 {
                    let identity = f64::from(u8::from(axis == field));
                    column[FIELDS * body + 1 + field] =
                        scaling.size * (pose.rotation[axis][field] - identity);
                }
            }
        }
    }
    a
}

/// The triangular factors of the bodies' fields on one diagonal: (4 bodies, 4 bodies).
fn stacked_factor(surface: RigidSurface<'_>, scalings: &[Scaling]) -> Matrix {
    let mut stacked = Matrix::zeros(FIELDS * scalings.len(), FIELDS * scalings.len());
    for (body, scaling) in scalings.iter().enumerate() {
        let nodes = surface.points.iter().zip(surface.body);
        let rows: Vec<[f64; FIELDS]> = nodes
            .filter(|(_, of)| of.map(usize::from) == Some(body))
            .map(|(point, _)| fields(point, scaling))
            .collect();
        let factor = qr_factor(&Matrix::from_fn(rows.len(), FIELDS, |i, j| rows[i][j]));
        for i in 0..factor.n_rows() {
            for j in 0..factor.n_cols() {
                stacked[(FIELDS * body + i, FIELDS * body + j)] = factor[(i, j)];
            }
        }
    }
    stacked
}

/// `U = F A V`: (N_s, r), by rows; zero rows where nothing moves.
fn mode_values(surface: RigidSurface<'_>, scalings: &[Scaling], to_modes: &Matrix) -> Vec<f64> {
    let r = to_modes.n_cols();
    let mut values = vec![0.0; surface.points.len() * r];
    if r == 0 {
        return values;
    }
    parallel::for_blocks(&mut values, CHUNK * r, &|first, rows| {
        for (node, row) in (first / r..).zip(rows.chunks_exact_mut(r)) {
            let Some(body) = surface.body[node].map(usize::from) else {
                continue;
            };
            let fields = fields(&surface.points[node], &scalings[body]);
            for (mode, value) in row.iter_mut().enumerate() {
                let column = &to_modes.column(mode)[FIELDS * body..][..FIELDS];
                *value = fields.iter().zip(column).map(|(f, c)| f * c).sum();
            }
        }
    });
    values
}

#[cfg(test)]
mod tests;

//! One patch of given points: radial basis functions with a linear polynomial along the directions in which it extends.
//!
//! ```text
//! s(x) = sum_j phi(|x - x_j| / R) w_j + P(x) beta,   P(x) = (1, a_1 . (x - c) / r, ..)
//!
//! (Phi  P) (w   )   (values)
//! (P^T  0) (beta) = (0     )
//! ```
//!
//! If the points are close to a plane, the polynomial has no term across it: such points do not determine how displacements
//! change across. The offset of a wall point from the interpolated surface then turns with it.

use super::frame::{Frame, Slopes};
use crate::{Basis, Error, Kernel, Result, Vector};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{add, cross, dot, scale, sub, unit};
use azimesh_core::linear::{Cholesky, Matrix, svd};

/// Least ratio of an extent of a patch to its longest extent.
pub(super) const FLAT: f64 = 0.1;
/// Support radius in radii of a patch.
const SUPPORT: f64 = 8.0;

/// Given points around a centre.
#[derive(Debug, Clone)]
pub(super) struct Patch {
    pub centre: Vector,
    /// Distance of the farthest point.
    pub radius: f64,
    /// Indices of its points.
    pub points: Vec<u32>,
    /// Orthonormal, by decreasing extent.
    axes: [Vector; 3],
    /// Axes along which it extends.
    n_axes: usize,
    /// Range of the points along each axis, from the centre.
    range: Bounds,
}

/// The factored system of a patch.
pub(super) struct System<'a> {
    patch: &'a Patch,
    places: Vec<Vector>,
    basis: Basis,
    kernels: Cholesky,
    /// `P (n, m)` and `Phi^-1 P`.
    terms: Matrix,
    solved: Matrix,
    /// Of `P^T Phi^-1 P`.
    schur: Cholesky,
}

/// Weights and coefficients of some columns.
pub(super) struct Solution {
    weights: Matrix,
    beta: Matrix,
}

impl Patch {
    /// Builds a patch of points sorted by their distance from `centre`. `None` if they extend in one direction only, that is if
    /// the second extent is below the part `line` of the first; in the plane one direction is enough.
    pub fn new(
        centre: Vector,
        points: Vec<u32>,
        given: &[Vector],
        in_plane: bool,
        line: f64,
    ) -> Option<Self> {
        let from_centre = |&i: &u32| sub(given[i as usize], centre);
        let radius = points.last().map(from_centre).map(|x| dot(x, x).sqrt())?;
        let n = points.len() as f64;
        let middle = points
            .iter()
            .map(from_centre)
            .fold([0.0; 3], |sum, x| add(sum, scale(x, 1.0 / n)));
        let moments = Matrix::from_fn(3, 3, |i, j| {
            let from_middle = points
                .iter()
                .map(from_centre)
                .map(|x| scale(sub(x, middle), 1.0 / radius));
            from_middle.map(|x| x[i] * x[j]).sum()
        });
        let (_, extents, directions) = svd(&moments).ok()?;
        let direction =
            |k: usize| unit([directions[(0, k)], directions[(1, k)], directions[(2, k)]]);
        let first = direction(0)?;
        let (second, third) = match in_plane {
            true => (cross([0.0, 0.0, 1.0], first), [0.0, 0.0, 1.0]),
            false => {
                let second = direction(1)?;
                (second, unit(cross(first, second))?)
            }
        };
        let axes = [first, second, third];
        let extends = |k: usize, part: f64| extents[k] > part * part * extents[0];
        let n_axes = match (
            extends(1, if in_plane { FLAT } else { line }),
            extends(2, FLAT),
            in_plane,
        ) {
            (true, true, false) => 3,
            (true, ..) => 2,
            (false, _, true) => 1,
            (false, ..) => return None,
        };
        let locals: Vec<Vector> = points
            .iter()
            .map(from_centre)
            .map(|x| axes.map(|axis| dot(axis, x)))
            .collect();
        Some(Self {
            centre,
            radius,
            points,
            axes,
            n_axes,
            range: Bounds::around(&locals),
        })
    }

    /// Returns the position at which a wall point is interpolated: within the points across a flat patch.
    fn place(&self, y: &Vector) -> Vector {
        let from_centre = sub(*y, self.centre);
        let mut local = self.axes.map(|axis| dot(axis, from_centre));
        for k in self.n_axes..3 {
            local[k] = local[k].clamp(self.range.low[k], self.range.high[k]);
        }
        (0..3).fold(self.centre, |x, k| add(x, scale(self.axes[k], local[k])))
    }

    fn term(&self, m: usize, x: &Vector) -> f64 {
        match m {
            0 => 1.0,
            _ => dot(self.axes[m - 1], sub(*x, self.centre)) / self.radius,
        }
    }

    /// Factors the system.
    pub fn system(&self, given: &[Vector]) -> Result<System<'_>> {
        let places: Vec<Vector> = self.points.iter().map(|&i| given[i as usize]).collect();
        let basis = Basis {
            kernel: Kernel::WendlandC2,
            radius: SUPPORT * self.radius,
        };
        let (n, m) = (places.len(), self.n_axes + 1);
        let phi = Matrix::from_fn(n, n, |i, j| basis.between(&places[i], &places[j]));
        let close = || {
            let at = places[0];
            Error::input(format!(
                "given points near {at:?} are too close to one another to be interpolated"
            ))
        };
        let kernels = Cholesky::factor(phi).map_err(|_| close())?;
        let terms = Matrix::from_fn(n, m, |i, j| self.term(j, &places[i]));
        let mut solved = terms.clone();
        kernels.solve(&mut solved);
        let schur = Cholesky::factor(transposed_times(&terms, &solved)).map_err(|_| close())?;
        Ok(System {
            patch: self,
            places,
            basis,
            kernels,
            terms,
            solved,
            schur,
        })
    }
}

fn transposed_times(a: &Matrix, b: &Matrix) -> Matrix {
    Matrix::from_fn(a.n_cols(), b.n_cols(), |i, j| {
        a.column(i)
            .iter()
            .zip(b.column(j))
            .map(|(a, b)| a * b)
            .sum()
    })
}

impl System<'_> {
    /// Solves with `values (n, r)` and `right (m, r)`, the right side of the polynomial's rows.
    fn solve(&self, values: Matrix, right: &Matrix) -> Solution {
        let mut weights = values;
        self.kernels.solve(&mut weights);
        let sums = transposed_times(&self.terms, &weights);
        let mut beta = Matrix::from_fn(sums.n_rows(), sums.n_cols(), |i, j| {
            sums[(i, j)] - right[(i, j)]
        });
        self.schur.solve(&mut beta);
        let polynomial = self.solved.times(&beta);
        for (weight, p) in weights.values_mut().iter_mut().zip(columns(&polynomial)) {
            *weight -= p;
        }
        Solution { weights, beta }
    }

    /// Returns the interpolants of the positions of the given points, from the centre, and of their displacements.
    pub fn through(&self, given: &[Vector], displacements: Option<&[Vector]>) -> Solution {
        let Patch { points, centre, .. } = self.patch;
        let n_columns = if displacements.is_some() { 6 } else { 3 };
        let values = Matrix::from_fn(points.len(), n_columns, |i, j| {
            let i = points[i] as usize;
            match displacements {
                Some(displacements) if j >= 3 => displacements[i][j - 3],
                _ => given[i][j] - centre[j],
            }
        });
        self.solve(values, &Matrix::zeros(self.terms.n_cols(), n_columns))
    }

    /// Returns factors of the weights at a position, and of their slopes along the first two axes.
    fn kernels_at(&self, place: &Vector, point: &Vector) -> [f64; 3] {
        let away = sub(*place, *point);
        let radius = self.basis.radius;
        let xi = dot(away, away).sqrt() / radius;
        let rest = (1.0 - xi).max(0.0);
        let slope = -20.0 * rest.powi(3) / (radius * radius); // phi' / xi / R^2
        let [a1, a2, _] = self.patch.axes;
        [
            self.basis.kernel.value(xi),
            slope * dot(a1, away),
            slope * dot(a2, away),
        ]
    }

    /// `P(x)` and its slopes along the first two axes, by term.
    fn terms_at(&self, place: &Vector, m: usize) -> [f64; 3] {
        let slope = |axis: usize| {
            if m == axis {
                1.0 / self.patch.radius
            } else {
                0.0
            }
        };
        [self.patch.term(m, place), slope(1), slope(2)]
    }

    /// The first `N` vectors of a solution at a wall point, with their slopes.
    fn at<const N: usize>(&self, solution: &Solution, place: &Vector) -> [(Vector, Slopes); N] {
        let mut sums = [[[0.0; 3]; 3]; N];
        let mut include = |factors: [f64; 3], values: &Matrix, row: usize| {
            for (which, sum) in sums.iter_mut().enumerate() {
                for axis in 0..3 {
                    let value = values[(row, 3 * which + axis)];
                    for k in 0..3 {
                        sum[k][axis] += factors[k] * value;
                    }
                }
            }
        };
        for (row, point) in self.places.iter().enumerate() {
            include(self.kernels_at(place, point), &solution.weights, row);
        }
        for m in 0..self.terms.n_cols() {
            include(self.terms_at(place, m), &solution.beta, m);
        }
        sums.map(|[value, first, second]| (value, [first, second]))
    }

    /// The displacement of a wall point, from a solution for displacements and places.
    pub fn displacement(&self, solution: &Solution, y: &Vector) -> Vector {
        let [(foot, tangents), (displacement, slopes)] = self.at(solution, &self.patch.place(y));
        if self.patch.n_axes == 3 {
            return displacement;
        }
        let frame = Frame::new(self.tangents(tangents));
        add(
            displacement,
            frame.turned(slopes, sub(sub(*y, self.patch.centre), foot)),
        )
    }

    /// In the plane a line has one tangent.
    fn tangents(&self, tangents: Slopes) -> Slopes {
        match self.patch.n_axes {
            1 => [tangents[0], [0.0; 3]],
            _ => tangents,
        }
    }

    /// The forces at the given points of the patch for forces at wall points; `at_rest` is the solution for places.
    pub fn pull_back(
        &self,
        at_rest: &Solution,
        forces: impl Iterator<Item = (Vector, Vector)>,
    ) -> Vec<Vector> {
        let (n, m) = (self.places.len(), self.terms.n_cols());
        let (mut kernels, mut terms) = (Matrix::zeros(n, 3), Matrix::zeros(m, 3));
        for (y, force) in forces {
            let place = self.patch.place(&y);
            let [(foot, tangents)] = self.at(at_rest, &place);
            let couple = match self.patch.n_axes {
                3 => [[0.0; 3]; 2],
                _ => Frame::new(self.tangents(tangents))
                    .couple(cross(sub(sub(y, self.patch.centre), foot), force)),
            };
            let loads = [force, couple[0], couple[1]];
            let include = |factors: [f64; 3], sums: &mut Matrix, row: usize| {
                for axis in 0..3 {
                    sums[(row, axis)] += (0..3).map(|k| factors[k] * loads[k][axis]).sum::<f64>();
                }
            };
            for (row, point) in self.places.iter().enumerate() {
                include(self.kernels_at(&place, point), &mut kernels, row);
            }
            for row in 0..m {
                include(self.terms_at(&place, row), &mut terms, row);
            }
        }
        let Solution { weights, .. } = self.solve(kernels, &terms);
        (0..n)
            .map(|i| std::array::from_fn(|axis| weights[(i, axis)]))
            .collect()
    }
}

fn columns(matrix: &Matrix) -> impl Iterator<Item = &f64> {
    (0..matrix.n_cols()).flat_map(|j| matrix.column(j))
}

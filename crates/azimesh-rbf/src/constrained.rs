//! The interpolation system where displacements are prescribed along some directions only, and where
//! the field repeats in periodic images.
//!
//! ```text
//! s(x) = sum_j sum_g phi(|x - g x_j| / R) R_g N_j w_j,      N_i^T s(x_i) = N_i^T d_i
//! ```
//!
//! `N_i (3, m_i)` holds the directions of base point `i`, `g` runs over the identity and the images,
//! rigid maps with the rotation `R_g`. The unknowns `w_i` are the strengths along the directions. As
//! the images are a group, `s(g x) = R_g s(x)`, and the blocks `N_i^T [sum_g phi(|x_i - g x_j| / R)
//! R_g] N_j` make a symmetric positive definite matrix.

use super::Basis;
use super::constraint::Constraint;
#[cfg(test)]
use super::evaluate::WeightedBase;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{Vector, add, distance, dot, scale};
use azimesh_core::linear::{Cholesky, Matrix};
use azimesh_core::parallel;

mod factored;

pub use factored::FactoredSystem;

/// A point that an image puts within this part of the support radius of itself is its own image.
const OWN_IMAGE: f64 = 1e-9;
/// Components of a unit direction below this are round-off.
const ZERO: f64 = 1e-12;

/// Base points with their images, ready to be evaluated.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Expanded {
    /// The base points, then the first image of each, and so on.
    pub points: Vec<Vector>,
    /// Weights (points, 3 r), by rows: column `3 m + a` is component `a` of vector mode `m`.
    pub weights: Vec<f64>,
    /// Number of columns, 3 r.
    pub n_columns: usize,
}

impl Expanded {
    /// Converts it to the form for evaluation.
    #[cfg(test)]
    pub fn weighted(&self, basis: Basis) -> WeightedBase<'_> {
        WeightedBase {
            basis,
            points: &self.points,
            weights: &self.weights,
            n_columns: self.n_columns,
        }
    }
}

/// Weights for which the field at every base point has the components of `values (n, 3 r)` along its
/// constraint. Column `3 m + a` of `values` is component `a` of vector mode `m`.
///
/// `images` is the group without the identity (with a map its inverse; of translations as many as the
/// support radius reaches) and may be empty. Of points that are images of each other only one may be
/// a base point. A point that is its own image, on the axis of a rotation, is held along the axis
/// alone: across it the field is zero by symmetry.
///
/// By Cholesky, `m^3 / 3` multiply-adds and `m^2` numbers for the m directions; those along axes that
/// neither constraints nor images mix are solved by themselves.
///
/// # Errors
/// If a base point is an image of another, and where the matrix is not positive definite to working
/// precision: base points that nearly coincide against the support radius.
pub fn constrained_weights(
    basis: Basis,
    base: &[Vector],
    constraints: &[Constraint],
    images: &[Transform],
    values: &[f64],
) -> Result<Expanded> {
    let n = base.len();
    assert_eq!(constraints.len(), n, "one constraint a base point");
    if n == 0 {
        return Ok(Expanded::default());
    }
    let n_columns = values.len() / n;
    assert!(values.len() == n * n_columns && n_columns.is_multiple_of(3));
    let system = System::new(basis, base, images)?;
    let mut own = vec![0.0; values.len()];
    let moves = |block: &Block| !block.is_at_rest(values, n_columns);
    for block in system.distinct_blocks(constraints, moves) {
        system.solve(&block, &system.factor(&block)?, values, &mut own);
    }
    Ok(system.expand(&own, n_columns))
}

/// Axes, as bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Axes(u8);

impl Axes {
    /// The axes along which a direction has a component.
    fn of(direction: &Vector) -> Self {
        Self((0..3).fold(0, |bits, k| bits | u8::from(direction[k] != 0.0) << k))
    }
}

/// The directions within some axes, an unknown each.
#[derive(Debug, Clone)]
struct Block {
    axes: Axes,
    /// Other axes along which the same points have the same matrix.
    alike: Vec<u8>,
    /// Base points of the block, ascending, with their first unknown.
    points: Vec<(usize, usize)>,
    directions: Vec<Vector>,
}

impl Block {
    fn new(axes: u8, constraints: &[Constraint]) -> Self {
        let mut block = Self {
            axes: Axes(axes),
            alike: Vec::new(),
            points: Vec::new(),
            directions: Vec::new(),
        };
        for (point, constraint) in constraints.iter().enumerate() {
            let first = block.directions.len();
            let columns = constraint.columns().iter();
            block
                .directions
                .extend(columns.filter(|n| Axes::of(n).0 & axes != 0));
            if block.directions.len() > first {
                block.points.push((point, first));
            }
        }
        block
    }

    /// Directions of the point at a position in `points`.
    fn of_point(&self, at: usize) -> std::ops::Range<usize> {
        let next = self.points.get(at + 1);
        self.points[at].1..next.map_or(self.directions.len(), |next| next.1)
    }

    /// Returns whether every prescribed component is zero.
    fn is_at_rest(&self, values: &[f64], n_columns: usize) -> bool {
        (0..self.points.len()).all(|at| {
            let row = &values[self.points[at].0 * n_columns..][..n_columns];
            let mut directions = self.directions[self.of_point(at)].iter();
            directions.all(|n| row.as_chunks::<3>().0.iter().all(|d| dot(*n, *d) == 0.0))
        })
    }
}

#[derive(Debug, Clone)]
struct System {
    basis: Basis,
    base: Vec<Vector>,
    /// The identity, then the images.
    group: Vec<Transform>,
}

impl System {
    /// # Errors
    /// If a base point is an image of another.
    fn new(basis: Basis, base: &[Vector], images: &[Transform]) -> Result<Self> {
        let mut group = vec![Transform::IDENTITY];
        group.extend_from_slice(images);
        let near = OWN_IMAGE * basis.radius;
        let image_of = |i: usize| {
            let places: Vec<Vector> = images.iter().map(|g| g.apply(base[i])).collect();
            let mut others = base[..i].iter();
            let meets = |other: &Vector| places.iter().any(|y| distance(*y, *other) <= near);
            others.position(meets).map(|other| (other, i))
        };
        let found = parallel::map(base.len(), &image_of);
        match found.into_iter().flatten().next() {
            Some((i, j)) => Err(Error::check(format!(
                "the base points {i} and {j} are periodic images of each other; only one of them \
                 may be chosen"
            ))),
            None => Ok(Self {
                basis,
                base: base.to_vec(),
                group,
            }),
        }
    }

    /// Returns the wanted blocks, one for each distinct matrix.
    fn distinct_blocks(
        &self,
        constraints: &[Constraint],
        is_wanted: impl Fn(&Block) -> bool,
    ) -> Vec<Block> {
        let mut distinct: Vec<Block> = Vec::new();
        for block in self.blocks(constraints).into_iter().filter(is_wanted) {
            match distinct.iter_mut().find(|one| self.are_alike(one, &block)) {
                Some(one) => one.alike.push(block.axes.0),
                None => distinct.push(block),
            }
        }
        distinct
    }

    /// Splits the unknowns into independent blocks.
    fn blocks(&self, constraints: &[Constraint]) -> Vec<Block> {
        let constraints: Vec<Constraint> = constraints
            .iter()
            .zip(&self.base)
            .map(|(constraint, x)| self.within_symmetry(constraint, *x))
            .collect();
        let columns = constraints.iter().flat_map(Constraint::columns);
        let mut mixed: Vec<u8> = columns.map(|n| Axes::of(n).0).collect();
        for g in &self.group {
            for (k, row) in g.rotation.iter().enumerate() {
                mixed.push(Axes::of(row).0 | 1 << k);
            }
        }
        let mut sets: Vec<u8> = vec![0b001, 0b010, 0b100];
        for axes in mixed {
            let (joined, rest): (Vec<u8>, Vec<u8>) = sets.iter().partition(|&&s| s & axes != 0);
            sets = rest;
            sets.push(joined.iter().fold(0, |all, s| all | s));
            sets.retain(|&set| set != 0);
        }
        sets.sort_unstable();
        let blocks = sets.iter().map(|&axes| Block::new(axes, &constraints));
        blocks.filter(|block| !block.points.is_empty()).collect()
    }

    /// Returns the constraint of a point, reduced by symmetry: a point that is its own image has only the directions that
    /// these images leave.
    fn within_symmetry(&self, constraint: &Constraint, x: Vector) -> Constraint {
        let near = OWN_IMAGE * self.basis.radius;
        let own = self
            .group
            .iter()
            .filter(|g| distance(g.apply(x), x) <= near);
        let own: Vec<&Transform> = own.collect();
        if own.len() == 1 {
            return *constraint;
        }
        let mean = |n: &Vector| {
            let sum = own.iter().fold([0.0; 3], |sum, g| add(sum, g.turn(*n)));
            let mean = scale(sum, 1.0 / own.len() as f64);
            mean.map(|x| if x.abs() < ZERO { 0.0 } else { x })
        };
        let left: Vec<Vector> = constraint.columns().iter().map(mean).collect();
        Constraint::of_normals(&left)
    }

    /// Returns whether two blocks have the same matrix: the same points, each along one axis, on which the
    /// images act alike.
    fn are_alike(&self, a: &Block, b: &Block) -> bool {
        let (Axes(p), Axes(q)) = (a.axes, b.axes);
        let (i, j) = (p.trailing_zeros() as usize, q.trailing_zeros() as usize);
        p.count_ones() == 1
            && q.count_ones() == 1
            && a.points == b.points
            && self
                .group
                .iter()
                .all(|g| g.rotation[i][i] == g.rotation[j][j])
    }

    /// Adds the weights of the base points by a block and by those with the same matrix to `own (n, 3 r)`.
    fn solve(&self, block: &Block, factor: &Cholesky, values: &[f64], own: &mut [f64]) {
        let n_columns = values.len() / self.base.len();
        let r = n_columns / 3;
        let axis_of = |axes: &u8| axes.trailing_zeros() as usize;
        let shifts: Vec<usize> = block.alike.iter().map(axis_of).collect();
        let first = axis_of(&block.axes.0);
        // Returns the directions of an equal block: the same along its own axis, signs included.
        let turned = |n: Vector, axis: usize| {
            let mut turned = [0.0; 3];
            turned[axis] = n[first];
            turned
        };
        let mut rhs = Matrix::zeros(block.directions.len(), r * (1 + shifts.len()));
        for (at, &(point, _)) in block.points.iter().enumerate() {
            for row in block.of_point(at) {
                let d = values[point * n_columns..][..n_columns].as_chunks::<3>().0;
                let n = block.directions[row];
                for (m, d) in d.iter().enumerate() {
                    rhs[(row, m)] = dot(n, *d);
                    for (s, &axis) in shifts.iter().enumerate() {
                        rhs[(row, r * (s + 1) + m)] = dot(turned(n, axis), *d);
                    }
                }
            }
        }
        factor.solve(&mut rhs);
        for (at, &(point, _)) in block.points.iter().enumerate() {
            for row in block.of_point(at) {
                let w = own[point * n_columns..][..n_columns].as_chunks_mut::<3>().0;
                let n = block.directions[row];
                for (m, w) in w.iter_mut().enumerate() {
                    *w = add(*w, scale(n, rhs[(row, m)]));
                    for (s, &axis) in shifts.iter().enumerate() {
                        *w = add(*w, scale(turned(n, axis), rhs[(row, r * (s + 1) + m)]));
                    }
                }
            }
        }
    }

    fn factor(&self, block: &Block) -> Result<Cholesky> {
        Cholesky::factor(self.matrix(block)).map_err(|at| {
            let point = block.points.partition_point(|point| point.1 <= at.0) - 1;
            Error::check(format!(
                "the base point {} of {} is too close to another or to a periodic image for a support \
                 radius of {} ({}); a smaller support radius, a kernel of lower order or selection by \
                 tolerance would help",
                block.points[point].0,
                self.base.len(),
                self.basis.radius,
                self.basis.kernel.name()
            ))
        })
    }

    /// Returns the lower triangle of the block's matrix, with the rest of the blocks on its diagonal.
    fn matrix(&self, block: &Block) -> Matrix {
        let n = block.directions.len();
        let mut matrix = Matrix::zeros(n, n);
        let mut columns = Vec::with_capacity(block.points.len());
        let mut rest = matrix.values_mut();
        for at in 0..block.points.len() {
            let (own, after) = rest.split_at_mut(block.of_point(at).len() * n);
            columns.push((at, own));
            rest = after;
        }
        parallel::for_items(columns, &|_, (at, columns)| {
            let x = self.base[block.points[at].0];
            let places: Vec<Vector> = self.group.iter().map(|g| g.apply(x)).collect();
            for below in at..block.points.len() {
                let kernel = self.kernel(&self.base[block.points[below].0], &places);
                for (column, q) in columns.chunks_exact_mut(n).zip(block.of_point(at)) {
                    let image = kernel.map(|row| dot(row, block.directions[q]));
                    for p in block.of_point(below) {
                        column[p] = dot(block.directions[p], image);
                    }
                }
            }
        });
        matrix
    }

    /// `sum_g phi(|x - y_g| / R) R_g`, by rows, for the images `y_g` of a base point.
    fn kernel(&self, x: &Vector, places: &[Vector]) -> [Vector; 3] {
        let mut sum = [[0.0; 3]; 3];
        for (place, g) in places.iter().zip(&self.group) {
            let phi = self.basis.between(x, place);
            if phi != 0.0 {
                for (sum, row) in sum.iter_mut().zip(g.rotation) {
                    *sum = add(*sum, scale(row, phi));
                }
            }
        }
        sum
    }

    fn expand(&self, own: &[f64], n_columns: usize) -> Expanded {
        let mut expanded = Expanded {
            points: Vec::with_capacity(self.base.len() * self.group.len()),
            weights: Vec::with_capacity(own.len() * self.group.len()),
            n_columns,
        };
        for g in &self.group {
            expanded
                .points
                .extend(self.base.iter().map(|x| g.apply(*x)));
            let turned = own.as_chunks::<3>().0.iter().flat_map(|w| g.turn(*w));
            expanded.weights.extend(turned);
        }
        expanded
    }
}

#[cfg(test)]
mod tests;

//! The directions in which the displacement of a surface point is prescribed.
//!
//! A moving or fixed point has all three, a point that slides on a surface the normal, on an edge two of them. `slide`
//! assigns constraints to points.

use azimesh_core::geometry::vector::{Vector, dot, norm, scale, sub};

/// Normals whose sine with those before is below this count as the same: 0.6 degrees.
const SAME: f64 = 0.01;

/// The orthonormal columns of `N (3, m)`: the displacement of a point is prescribed along these and
/// free across them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constraint {
    columns: [Vector; 3],
    n_columns: u8,
}

impl Constraint {
    /// Every direction: a point that moves with a body or stays.
    pub const ALL: Self = Self {
        columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        n_columns: 3,
    };

    /// The span of these normals, made orthonormal in turn, those along an axis first. Normals that
    /// are within 0.6 degrees of the span of others add nothing; three directions are [`Self::ALL`].
    pub fn of_normals(normals: &[Vector]) -> Self {
        let mut span = Self {
            columns: [[0.0; 3]; 3],
            n_columns: 0,
        };
        let along_axes = normals.iter().filter(|n| axis(n).is_some());
        let others = normals.iter().filter(|n| axis(n).is_none());
        for &normal in along_axes.chain(others) {
            let length = norm(normal);
            // Twice, as one pass leaves a part of the columns that round-off has put in.
            let rest = span.remove(span.remove(normal));
            let sine = norm(rest) / length;
            if sine > SAME && span.n_columns < 3 {
                span.columns[usize::from(span.n_columns)] = scale(rest, 1.0 / norm(rest));
                span.n_columns += 1;
            }
        }
        if span.n_columns == 3 { Self::ALL } else { span }
    }

    /// Returns the directions along which a rotation vector is held if a point keeps to a plane: only a rotation about the
    /// plane's normal maps the plane to itself. Points held in other ways have all directions.
    pub fn of_rotation(&self) -> Self {
        let [normal] = self.columns() else {
            return Self::ALL;
        };
        let axes = Self::ALL.columns;
        let beside = axes.map(|axis| sub(axis, scale(*normal, dot(axis, *normal))));
        let mut two: Vec<Vector> = beside.to_vec();
        two.sort_by(|a, b| norm(*b).total_cmp(&norm(*a)));
        Self::of_normals(&two[..2])
    }

    /// The orthonormal columns.
    #[inline]
    pub fn columns(&self) -> &[Vector] {
        &self.columns[..usize::from(self.n_columns)]
    }

    /// Number of directions.
    #[inline]
    pub fn rank(&self) -> usize {
        usize::from(self.n_columns)
    }

    /// The part of `v` along the columns, `N N^T v`.
    pub fn project(&self, v: Vector) -> Vector {
        let mut sum = [0.0; 3];
        for column in self.columns() {
            let part = dot(*column, v);
            for axis in 0..3 {
                sum[axis] += column[axis] * part;
            }
        }
        sum
    }

    /// Returns `v` without its part along the columns, `(I - N N^T) v`. Along an axis that is a column the
    /// component is exactly zero.
    pub fn remove(&self, v: Vector) -> Vector {
        let columns = self.columns().iter();
        columns.fold(v, |rest, column| {
            sub(rest, scale(*column, dot(*column, rest)))
        })
    }

    /// Returns `moved` with its position along the columns restored from `at`. A coordinate along an axis that is a column
    /// equals `at` to the last bit, and a coordinate that no column touches equals `moved`.
    pub fn hold(&self, at: Vector, moved: Vector) -> Vector {
        let mut held = moved;
        for column in self.columns() {
            match axis(column) {
                Some(k) => held[k] = at[k],
                None => held = sub(held, scale(*column, dot(*column, sub(held, at)))),
            }
        }
        held
    }
}

/// The axis that a direction is exactly parallel to.
fn axis(v: &Vector) -> Option<usize> {
    let mut nonzero = (0..3).filter(|&k| v[k] != 0.0);
    let axis = nonzero.next()?;
    nonzero.next().is_none().then_some(axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_core::geometry::vector::{add, distance};

    #[test]
    fn an_axis_normal_leaves_exactly_nothing_along_it() {
        let plane = Constraint::of_normals(&[[0.0, 0.0, -2.0]]);
        assert_eq!(plane.rank(), 1);
        let rest = plane.remove([0.1, -0.7, 1.0 / 3.0]);
        assert_eq!(rest, [0.1, -0.7, 0.0]);
        let x = [0.3, 0.2, 0.1];
        assert_eq!(add(x, rest)[2].to_bits(), x[2].to_bits());
        let moved = [0.5, 1.0 / 7.0, 0.6];
        assert_eq!(plane.hold(x, moved), [0.5, 1.0 / 7.0, 0.1]);
    }

    #[test]
    fn an_axis_stays_exact_beside_an_oblique_normal() {
        for normals in [
            [[0.6, 0.8, 1e-3], [0.0, 0.0, 1.0]],
            [[0.0, 0.0, 1.0], [0.3, -0.1, 0.9]],
        ] {
            let edge = Constraint::of_normals(&normals);
            assert_eq!(edge.rank(), 2);
            let at = [1.0, 2.0, -0.0];
            let held = edge.hold(at, [1.5, 1.7, 3.0]);
            assert_eq!(held[2].to_bits(), at[2].to_bits());
            for normal in normals {
                assert!(dot(normal, sub(held, at)).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn parallel_normals_count_once_and_three_make_all() {
        let same = [[0.6, 0.8, 0.0], [-0.6, -0.8, 1e-9]];
        assert_eq!(Constraint::of_normals(&same).rank(), 1);
        let corner = [[0.6, 0.8, 0.0], [0.5, 0.1, 1.0], [1.0, 1.0, -3.0]];
        assert_eq!(Constraint::of_normals(&corner), Constraint::ALL);
        assert_eq!(Constraint::ALL.hold([1.0; 3], [2.0; 3]), [1.0; 3]);
        assert_eq!(Constraint::of_normals(&[[0.0; 3]]).rank(), 0);
    }

    #[test]
    fn a_rotation_about_the_normal_of_a_plane_is_free_and_no_other() {
        for normal in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.2, -0.5, 0.4]] {
            let plane = Constraint::of_normals(&[normal]);
            let held = plane.of_rotation();
            assert_eq!(held.rank(), 2);
            assert!(norm(held.project(normal)) < 1e-15);
        }
        let edge = Constraint::of_normals(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(edge.of_rotation(), Constraint::ALL);
        assert_eq!(Constraint::ALL.of_rotation(), Constraint::ALL);
        let z = Constraint::of_normals(&[[0.0, 0.0, 1.0]]).of_rotation();
        assert_eq!(z.columns(), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    }

    #[test]
    fn the_two_parts_of_a_vector_add_up() {
        let edge = Constraint::of_normals(&[[0.2, 0.9, -0.3], [0.7, 0.1, 0.4]]);
        let v = [0.3, -2.0, 5.0];
        assert!(distance(add(edge.project(v), edge.remove(v)), v) < 1e-14);
        assert!(distance(edge.project(edge.remove(v)), [0.0; 3]) < 1e-14);
    }
}

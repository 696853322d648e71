//! Rotates, moves and mirrors the positions and vectors of a mesh.

use super::arrays::Values;
use super::{DataArray, Mesh};
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;

/// Names of arrays at nodes and cells after a rotation.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Turned {
    /// Vectors (three components) and tensors (nine, by rows), which are rotated.
    pub turned: Vec<String>,
    /// Arrays that may hold vectors or tensors in another form; their components are kept.
    pub kept: Vec<String>,
}

impl Mesh {
    /// Moves all nodes and rotates arrays of three and nine real components at nodes and cells. The matrix may be a reflection.
    pub fn transform(&mut self, by: &Transform) -> Turned {
        parallel::update(&mut self.points, |_, point| *point = by.apply(*point));
        self.turn_arrays(by)
    }

    /// Rotates vectors and tensors, without the nodes.
    pub(super) fn turn_arrays(&mut self, by: &Transform) -> Turned {
        let mut names = Turned::default();
        if by.rotation == Transform::IDENTITY.rotation {
            return names;
        }
        for arrays in [&mut self.point_arrays, &mut self.cell_arrays] {
            let parts = parts(arrays);
            for array in arrays {
                let list = match turn(array, by) {
                    true => &mut names.turned,
                    false if is_other_form(array) || parts.contains(&array.name) => &mut names.kept,
                    false => continue,
                };
                if !list.contains(&array.name) {
                    list.push(array.name.clone());
                }
            }
        }
        names
    }
}

/// Rotates an array of vectors or tensors; returns `false` for other arrays.
fn turn(array: &mut DataArray, by: &Transform) -> bool {
    let of_vector = |v: Vector| by.turn(v);
    // T' = R T R^T: rows of R T^T R^T are turned columns.
    let of_tensor = |t: [Vector; 3]| {
        let turned = t.map(of_vector);
        let columns = [0, 1, 2].map(|k| of_vector([turned[0][k], turned[1][k], turned[2][k]]));
        [0, 1, 2].map(|i| [0, 1, 2].map(|k| columns[k][i]))
    };
    macro_rules! turn {
        ($values:expr, $real:ty) => {
            match array.n_components {
                3 => $values.chunks_exact_mut(3).for_each(|v| {
                    let turned = of_vector([v[0].into(), v[1].into(), v[2].into()]);
                    v.iter_mut()
                        .zip(turned)
                        .for_each(|(to, x)| *to = x as $real);
                }),
                9 => $values.chunks_exact_mut(9).for_each(|v| {
                    let at = |i: usize, k: usize| v[3 * i + k].into();
                    let tensor = [0, 1, 2].map(|i| [0, 1, 2].map(|k| at(i, k)));
                    let turned = of_tensor(tensor);
                    v.iter_mut()
                        .zip(turned.as_flattened())
                        .for_each(|(to, x)| *to = *x as $real);
                }),
                _ => return false,
            }
        };
    }
    #[allow(clippy::unnecessary_cast)] // one text for both types
    match &mut array.values {
        Values::F32(values) => turn!(values, f32),
        Values::F64(values) => turn!(values, f64),
        _ => return false,
    }
    true
}

/// Returns whether an array may hold plane vectors or symmetric tensors; files do not give the order of their components.
fn is_other_form(array: &DataArray) -> bool {
    let is_real = matches!(array.values, Values::F32(_) | Values::F64(_));
    is_real && [2, 4, 6].contains(&array.n_components)
}

/// Endings of names of components, and how many of them, from the first on, make a vector or tensor.
const COMPONENTS: [(&[&str], usize); 4] = [
    (&["x", "y", "z"], 2),
    (&["X", "Y", "Z"], 2),
    (&["XX", "XY", "XZ", "YY", "YZ", "ZZ"], 2),
    (&["_1", "_2", "_3", "_4", "_5", "_6", "_7", "_8", "_9"], 3),
];

/// Returns the names of scalar arrays that are components of a vector or tensor: names that differ only
/// in such an ending.
fn parts(arrays: &[DataArray]) -> Vec<String> {
    let is_real = |array: &&DataArray| {
        array.n_components == 1 && matches!(array.values, Values::F32(_) | Values::F64(_))
    };
    let scalars = arrays.iter().filter(is_real);
    let names: Vec<&str> = scalars.map(|array| &*array.name).collect();
    let is_part = |name: &&&str| {
        COMPONENTS.iter().any(|(ends, n_needed)| {
            let stem = ends.iter().find_map(|end| name.strip_suffix(end));
            let has = |stem: &str, end: &str| names.contains(&&*format!("{stem}{end}"));
            stem.is_some_and(|stem| ends[..*n_needed].iter().all(|end| has(stem, end)))
        })
    };
    let found = names.iter().filter(is_part);
    found.map(|name| (*name).to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_and_tensors_turn_and_what_may_be_one_is_named() {
        let reals = |n: usize| Values::F64((0..n).map(|i| i as f64).collect());
        let mut mesh = Mesh {
            points: vec![[1.0, 2.0, 3.0]],
            point_arrays: vec![
                DataArray::tuples("U", 3, Values::F32(vec![1.0, 2.0, 3.0])),
                DataArray::tuples("grad", 9, reals(9)),
                DataArray::tuples("stress", 6, reals(6)),
                DataArray::tuples("rgb", 3, Values::U8(vec![1, 2, 3])),
                DataArray::scalar("p", reals(1)),
                DataArray::scalar("VelocityX", reals(1)),
                DataArray::scalar("VelocityY", reals(1)),
                DataArray::scalar("r_1", reals(1)),
                DataArray::scalar("r_2", reals(1)),
                DataArray::scalar("r_3", reals(1)),
            ],
            ..Mesh::default()
        };
        let quarter = Transform {
            rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [10.0, 0.0, 0.0],
        };
        let names = mesh.transform(&quarter);
        assert_eq!(names.turned, ["U", "grad"]);
        assert_eq!(
            names.kept,
            ["stress", "VelocityX", "VelocityY", "r_1", "r_2", "r_3"]
        );
        assert_eq!(mesh.points, [[8.0, 1.0, 3.0]]);
        let values = |i: usize| mesh.point_arrays[i].values.to_f64().expect("reals");
        assert_eq!(values(0), [-2.0, 1.0, 3.0]);
        // Rows of R T R^T.
        let expected = [4.0, -3.0, -5.0, -1.0, 0.0, 2.0, -7.0, 6.0, 8.0];
        assert_eq!(values(1), expected);
        assert_eq!(values(3), [1.0, 2.0, 3.0]);
    }
}

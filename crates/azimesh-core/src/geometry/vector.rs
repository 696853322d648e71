//! Arithmetic of points and directions in space.

/// A point or a direction.
pub type Vector = [f64; 3];

/// `a + b`.
#[inline]
pub fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
#[inline]
pub fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `s a`.
#[inline]
pub fn scale(a: Vector, s: f64) -> Vector {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// `a . b`.
#[inline]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a x b`.
#[inline]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `sum_m values_m vectors_m`, in the order of `m`.
#[inline(always)]
pub fn weighted_sum(values: &[f64], vectors: &[Vector]) -> Vector {
    let mut sum = [0.0; 3];
    for (value, vector) in values.iter().zip(vectors) {
        for axis in 0..3 {
            sum[axis] += value * vector[axis];
        }
    }
    sum
}

/// Length of `a`.
#[inline]
pub fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// Distance from `a` to `b`.
#[inline]
pub fn distance(a: Vector, b: Vector) -> f64 {
    norm(sub(a, b))
}

/// `a` with length one; `None` for a vector of no length or of components that are not finite.
pub fn unit(a: Vector) -> Option<Vector> {
    let square = dot(a, a);
    if square.is_normal() {
        return Some(scale(a, 1.0 / square.sqrt()));
    }
    // Squares overflow or underflow: the largest component becomes one first.
    let largest = a.iter().fold(0.0, |most, x| f64::max(most, x.abs()));
    let a = a.map(|x| x / largest);
    let square = dot(a, a);
    square.is_normal().then(|| scale(a, 1.0 / square.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_of_any_length_has_a_unit_vector() {
        for length in [1.0, 1e308, 1e155, 1e-155, 1e-300, 5e-324] {
            assert_eq!(
                unit([0.0, 0.0, -length]),
                Some([0.0, 0.0, -1.0]),
                "{length:e}"
            );
        }
        for length in [1e308, 1e-300] {
            let found = unit([length, length, 0.0]).expect("it has a direction");
            assert!((found[0] - 0.5f64.sqrt()).abs() < 1e-15 && found[0] == found[1]);
        }
        for none in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 1.0, 0.0]] {
            assert_eq!(unit(none), None, "{none:?}");
        }
    }
}

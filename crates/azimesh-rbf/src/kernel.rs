//! The four Wendland functions, each defined once.
//!
//! Source: Sheng and Allen, AIAA Journal 51(3), 2013, table 1; H. Wendland, Scattered Data
//! Approximation, 2005, and Adv. Comput. Math. 4, 1995. All are normalised to `phi(0) = 1` and strictly positive definite in space.

use pulp::Simd;
use serde::{Deserialize, Serialize};

/// A compactly supported radial basis function of the scaled distance `xi = |x - b| / R`; zero from 1 on.
///
/// A smoother kernel gives smaller errors between base points, and a kernel matrix that is worse conditioned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kernel {
    /// `(1 - xi)^2`, continuous.
    WendlandC0,
    /// `(1 - xi)^4 (4 xi + 1)`, twice continuously differentiable.
    WendlandC2,
    /// `(1 - xi)^6 (35 xi^2 + 18 xi + 3) / 3`, four times.
    WendlandC4,
    /// `(1 - xi)^8 (32 xi^3 + 25 xi^2 + 8 xi + 1)`, six times.
    WendlandC6,
}

/// A function of the scaled distance `xi >= 0`, zero from 1 on; written once for one number and for
/// a vector register of them.
pub trait Radial: Copy + Send + Sync {
    /// `phi(xi)` in every lane.
    fn value<S: Simd>(simd: S, xi: S::f64s) -> S::f64s;
}

macro_rules! radial {
    ($(#[$doc:meta])* $name:ident, |$simd:ident, $xi:ident, $m:ident| $value:expr) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy)]
        pub struct $name;
        impl Radial for $name {
            #[inline(always)]
            fn value<S: Simd>($simd: S, $xi: S::f64s) -> S::f64s {
                let rest = $simd.sub_f64s($simd.splat_f64s(1.0), $xi);
                let $m = $simd.max_f64s(rest, $simd.splat_f64s(0.0));
                $value
            }
        }
    };
}

radial!(
    /// `(1 - xi)^2`
    C0, |simd, xi, m| simd.mul_f64s(m, m)
);
radial!(
    /// `(1 - xi)^4 (4 xi + 1)`; the last factor is `5 - 4 m` with `m = 1 - xi`, which saves a register.
    C2, |simd, xi, m| {
        let m2 = simd.mul_f64s(m, m);
        simd.mul_f64s(simd.mul_f64s(m2, m2), polynomial(simd, m, [-4.0, 5.0]))
    }
);
radial!(
    /// `(1 - xi)^6 (35 xi^2 + 18 xi + 3) / 3`
    C4, |simd, xi, m| {
        let m2 = simd.mul_f64s(m, m);
        let m6 = simd.mul_f64s(simd.mul_f64s(m2, m2), m2);
        simd.mul_f64s(m6, polynomial(simd, xi, [35.0 / 3.0, 6.0, 1.0]))
    }
);
radial!(
    /// `(1 - xi)^8 (32 xi^3 + 25 xi^2 + 8 xi + 1)`
    C6, |simd, xi, m| {
        let m2 = simd.mul_f64s(m, m);
        let m4 = simd.mul_f64s(m2, m2);
        simd.mul_f64s(simd.mul_f64s(m4, m4), polynomial(simd, xi, [32.0, 25.0, 8.0, 1.0]))
    }
);

/// Horner's scheme, highest power first.
#[inline(always)]
fn polynomial<S: Simd, const N: usize>(simd: S, x: S::f64s, coefficients: [f64; N]) -> S::f64s {
    let mut sum = simd.splat_f64s(coefficients[0]);
    for c in &coefficients[1..] {
        sum = simd.mul_add_e_f64s(sum, x, simd.splat_f64s(*c));
    }
    sum
}

impl Kernel {
    /// Evaluates `phi(xi)`, `xi` the distance over the support radius.
    pub fn value(self, xi: f64) -> f64 {
        match self {
            Kernel::WendlandC0 => C0::value(pulp::Scalar, xi),
            Kernel::WendlandC2 => C2::value(pulp::Scalar, xi),
            Kernel::WendlandC4 => C4::value(pulp::Scalar, xi),
            Kernel::WendlandC6 => C6::value(pulp::Scalar, xi),
        }
    }

    /// Gives the steepest slope, `max |phi'(xi)|`.
    pub fn steepest(self) -> f64 {
        match self {
            Kernel::WendlandC0 => 2.0,
            Kernel::WendlandC2 => 2.109,
            Kernel::WendlandC4 => 2.499,
            Kernel::WendlandC6 => 2.818,
        }
    }

    /// Gives the name in schedules and messages.
    pub fn name(self) -> &'static str {
        match self {
            Kernel::WendlandC0 => "wendland-c0",
            Kernel::WendlandC2 => "wendland-c2",
            Kernel::WendlandC4 => "wendland-c4",
            Kernel::WendlandC6 => "wendland-c6",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Kernel::*;

    #[test]
    fn every_kernel_is_one_at_zero_and_falls_to_zero_at_its_radius() {
        for kernel in [WendlandC0, WendlandC2, WendlandC4, WendlandC6] {
            assert_eq!(kernel.value(0.0), 1.0);
            assert_eq!(kernel.value(1.0), 0.0);
            assert_eq!(kernel.value(1.7), 0.0);
            let values: Vec<f64> = (0..=100)
                .map(|i| kernel.value(f64::from(i) / 100.0))
                .collect();
            assert!(values.windows(2).all(|pair| pair[0] > pair[1]));
        }
    }

    #[test]
    fn values_are_those_of_the_table() {
        let xi: f64 = 0.25;
        let m: f64 = 0.75;
        let table = [
            (WendlandC0, m.powi(2)),
            (WendlandC2, m.powi(4) * (4.0 * xi + 1.0)),
            (
                WendlandC4,
                m.powi(6) * (35.0 * xi * xi + 18.0 * xi + 3.0) / 3.0,
            ),
            (
                WendlandC6,
                m.powi(8) * (32.0 * xi.powi(3) + 25.0 * xi * xi + 8.0 * xi + 1.0),
            ),
        ];
        for (kernel, value) in table {
            assert!((kernel.value(xi) - value).abs() < 1e-15);
        }
    }
}

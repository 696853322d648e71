//! Radial basis functions: kernels, base points, weights, evaluation and the exact surface.
//!
//! Knows surface nodes, mode values and distances; nothing of rotors, schedules or files.

use serde::{Deserialize, Serialize};

pub mod constrained;
pub mod constraint;
pub mod correct;
pub mod criterion;
pub mod distinct;
pub mod evaluate;
pub mod field;
pub mod interpolant;
pub mod kernel;
mod newton;
pub mod power;
pub mod select;
pub mod slide;
pub mod space;
pub mod sweeps;
pub mod system;
pub mod targets;
pub mod transposed;

pub use kernel::Kernel;

/// A kernel with its support radius, in mesh units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Basis {
    /// The function of the scaled distance.
    pub kernel: Kernel,
    /// Distance at which it has fallen to zero, in mesh units.
    pub radius: f64,
}

impl Basis {
    /// `phi(|a - b| / R)`.
    pub fn between(&self, a: &[f64; 3], b: &[f64; 3]) -> f64 {
        let squared: f64 = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum();
        self.kernel.value(squared.sqrt() / self.radius)
    }
}

//! Base points: their selection, and checks against the tolerance.

pub(crate) mod base_points;
pub(crate) mod choose;
mod rank_sweeps;
pub(crate) mod round_off;
pub(crate) mod tolerance;

//! Base points: how they are chosen, and whether they meet the tolerance.

pub(crate) mod base_points;
pub(crate) mod choose;
mod rank_sweeps;
pub(crate) mod round_off;
pub(crate) mod tolerance;

//! The measures of one cell, before and after its orientation is known.

use super::angles::Angles;
use super::span::Span;

/// Measures of one cell in the node order of the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Metrics {
    /// Signed volume or area.
    pub volume: f64,
    /// Smallest and largest Jacobian at a corner, up to positive factors: only signs count.
    pub corner: Span,
    /// `low` is the scaled Jacobian of the cell, `-high` the value of its mirror image; NaN
    /// where it is not defined.
    pub scaled: Span,
    /// Smallest and largest squared edge length; NaN where it is not defined.
    pub edge: Span,
    /// Extreme angles of its faces and between them.
    pub angles: Angles,
    /// Of [`size_skew`](super::size_skew); not numbers for kinds that do not have it.
    pub knupp: Knupp,
}

/// Knupp's measures of the corners of a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Knupp {
    /// Sum of all `alpha_k`.
    pub size: f64,
    /// `f_skew`, which is 0 where the `alpha_k` are not all of one sign.
    pub skew: f64,
}

impl Knupp {
    pub(super) const UNDEFINED: Self = Self {
        size: f64::NAN,
        skew: f64::NAN,
    };

    /// `corner` holds the extremes of the `alpha_k`.
    #[inline(always)]
    pub(super) fn new(size: f64, corner: Span, skew: f64) -> Self {
        let is_upright = (corner.low > 0.0) | (corner.high < 0.0);
        Self {
            size,
            skew: if is_upright { skew } else { 0.0 },
        }
    }
}

impl Metrics {
    /// Orientation of a cell that is valid: 1 or -1 where all corner Jacobians have
    /// that sign, 0 where one vanishes or signs are mixed.
    #[inline]
    pub(super) fn orientation(&self) -> i8 {
        i8::from(self.corner.low > 0.0) - i8::from(self.corner.high < 0.0)
    }

    /// Returns whether all corner Jacobians are positive once the cell is turned by `sign`.
    #[inline]
    pub(super) fn is_valid(&self, sign: i8) -> bool {
        self.orientation() == sign
    }

    /// Volume, positive for a cell of orientation `sign`.
    #[inline]
    pub(super) fn volume(&self, sign: i8) -> f64 {
        f64::from(sign) * self.volume
    }

    /// Scaled Jacobian of the cell in the node order that `sign` says is positive.
    #[inline]
    pub(super) fn scaled_jacobian(&self, sign: i8) -> f64 {
        if sign < 0 {
            -self.scaled.high
        } else {
            self.scaled.low
        }
    }

    /// Square of the longest edge over the shortest.
    #[inline]
    pub(super) fn edge_ratio_squared(&self) -> f64 {
        self.edge.high / self.edge.low
    }
}

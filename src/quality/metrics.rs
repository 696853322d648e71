//! What is measured on one cell, before and after its orientation is known.

use super::angles::Angles;

/// Measures of one cell in the node order of the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Metrics {
    /// Signed volume or area.
    pub volume: f64,
    /// Smallest and largest Jacobian at a corner, up to positive factors: only signs count.
    pub corner: Span,
    /// `low` is the scaled Jacobian of the cell as it is, `-high` that of its mirror image; NaN
    /// where it is not defined.
    pub scaled: Span,
    /// Smallest and largest squared edge length; NaN where it is not defined.
    pub edge: Span,
    /// Extreme angles of its faces and between them.
    pub angles: Angles,
}

/// A smallest and a largest value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub low: f64,
    pub high: f64,
}

impl Span {
    pub(super) const EMPTY: Self = Self {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };
    pub(super) const UNDEFINED: Self = Self {
        low: f64::NAN,
        high: f64::NAN,
    };

    #[inline(always)]
    pub(super) fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut span = Self::EMPTY;
        for value in values {
            span.include(value);
        }
        span
    }

    /// Of an array; with indices, because iterators by value stay in memory.
    #[inline(always)]
    pub(super) fn of_array<const N: usize>(values: [f64; N]) -> Self {
        let mut span = Self::EMPTY;
        for i in 0..N {
            span.include(values[i]);
        }
        span
    }

    /// A span of one value.
    #[inline(always)]
    pub(super) fn at(value: f64) -> Self {
        Self {
            low: value,
            high: value,
        }
    }

    /// Widens the span to `value`; what is not a number is left out.
    #[inline(always)]
    pub(super) fn include(&mut self, value: f64) {
        self.merge(Self::at(value));
    }

    #[inline(always)]
    pub(super) fn merge(&mut self, other: Self) {
        self.low = lesser(other.low, self.low);
        self.high = greater(other.high, self.high);
    }
}

/// The smaller value, `b` where `a` is not a number: one instruction, unlike `f64::min`.
#[inline(always)]
pub(super) fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger value, `b` where `a` is not a number.
#[inline(always)]
pub(super) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl Metrics {
    /// Orientation of a cell that is valid as it stands: 1 or -1 where all corner Jacobians have
    /// that sign, 0 where one vanishes or signs are mixed.
    #[inline]
    pub(super) fn orientation(&self) -> i8 {
        i8::from(self.corner.low > 0.0) - i8::from(self.corner.high < 0.0)
    }

    /// Whether all corner Jacobians are positive once the cell is turned by `sign`.
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

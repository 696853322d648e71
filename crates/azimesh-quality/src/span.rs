//! The smallest and the largest of some values, without branches.

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

//! Sums and extremes of numbers side by side, without what is not a number.

use super::span::{greater, lesser};

/// Number of finite values.
#[inline(always)]
pub(super) fn known(values: &[f64]) -> usize {
    values.iter().filter(|value| !value.is_nan()).count()
}

/// Sums and extremes go side by side in as many lanes.
const LANES: usize = 8;

/// Without what is not a number.
#[inline(always)]
pub(super) fn sum(values: &[f64]) -> f64 {
    let known = |value: f64| if value.is_nan() { 0.0 } else { value };
    let (groups, rest) = values.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for group in groups {
        for lane in 0..LANES {
            sums[lane] += known(group[lane]);
        }
    }
    sums.iter().chain(rest).map(|&value| known(value)).sum()
}

/// The least value; infinite where all are not numbers.
#[inline(always)]
pub(super) fn least(values: &[f64]) -> f64 {
    let (groups, rest) = values.as_chunks::<LANES>();
    let mut found = [f64::INFINITY; LANES];
    for group in groups {
        for lane in 0..LANES {
            found[lane] = lesser(group[lane], found[lane]);
        }
    }
    let all = found.iter().chain(rest);
    all.fold(f64::INFINITY, |least, &value| lesser(value, least))
}

/// The greatest value; minus infinity where all are not numbers.
#[inline(always)]
pub(super) fn greatest(values: &[f64]) -> f64 {
    let (groups, rest) = values.as_chunks::<LANES>();
    let mut found = [f64::NEG_INFINITY; LANES];
    for group in groups {
        for lane in 0..LANES {
            found[lane] = greater(group[lane], found[lane]);
        }
    }
    let all = found.iter().chain(rest);
    all.fold(f64::NEG_INFINITY, |most, &value| greater(value, most))
}

//! A percentile of scaled Jacobians from counts, in memory that does not grow with the mesh.

use azimesh_core::ranks::raw;
use serde::{Deserialize, Serialize};

/// Bins over [-1, 1].
const N_UNIT: i32 = 1 << 16;
/// Bins below and above that: values of wedges are between -1.16 and 1.16, of pyramids not less than -1.42.
const N_BELOW: i32 = N_UNIT / 4;
const N_ABOVE: i32 = N_UNIT / 8;
const N_BINS: usize = (N_BELOW + N_UNIT + N_ABOVE) as usize;

/// Counts of values in equal bins; values outside count in the outermost bins.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Histogram {
    #[serde(with = "raw")]
    counts: Vec<u32>,
}

impl Histogram {
    pub(super) fn new() -> Self {
        Self {
            counts: vec![0; N_BINS],
        }
    }

    /// Counts a value in the bin that [`bin`] has for it.
    #[inline]
    pub(super) fn add_to(&mut self, bin: u32) {
        self.counts[bin as usize] += 1;
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for (a, b) in self.counts.iter_mut().zip(&other.counts) {
            *a += b;
        }
    }

    /// The value below which the fraction `part` of all is, to one bin (3.1e-5), linear within it.
    pub(super) fn percentile(&self, part: f64) -> Option<f64> {
        let total: u64 = self.counts.iter().map(|&n| u64::from(n)).sum();
        let wanted = part * total as f64;
        let mut below = 0.0;
        for (bin, &count) in self.counts.iter().enumerate() {
            let count = f64::from(count);
            if count > 0.0 && below + count >= wanted {
                let within = (wanted - below) / count;
                let bin = bin as f64 - f64::from(N_BELOW);
                return Some((bin + within) * (2.0 / f64::from(N_UNIT)) - 1.0);
            }
            below += count;
        }
        None
    }
}

/// The bin of a value; of what is not a number the first.
#[inline(always)]
pub(super) fn bin(value: f64) -> u32 {
    let bin = ((value + 1.0) * (0.5 * f64::from(N_UNIT))).floor() as i32; // saturates
    // Many cells have exactly 1, which is no more than 1.
    let n_above = if value > 1.0 { N_ABOVE } else { 0 };
    (bin.clamp(-N_BELOW, N_UNIT + n_above - 1) + N_BELOW) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_percentile_of_even_values_is_found_to_a_bin() {
        let mut histogram = Histogram::new();
        (0..=10_000).for_each(|i| histogram.add_to(bin(f64::from(i) * 1e-4)));
        let found = histogram.percentile(0.01).expect("there are values");
        assert!((found - 0.01).abs() < 2e-4, "{found}");
        assert!(Histogram::new().percentile(0.01).is_none());
    }

    #[test]
    fn values_of_wedges_and_pyramids_beyond_one_count_where_they_are() {
        for wanted in [-1.4, -1.066, -1.0, 1.0, 1.1547] {
            let mut histogram = Histogram::new();
            (0..100).for_each(|_| histogram.add_to(bin(wanted)));
            let found = histogram.percentile(0.01).expect("there are values");
            assert!((found - wanted).abs() < 4e-5, "{found} {wanted}");
            assert!(found <= 1.0 || wanted > 1.0, "{found} {wanted}");
        }
    }
}

//! Sums and extremes over the cells of a block, each in its orientation in the reference mesh.

use super::angles::N_CLASSES;
use super::block::{BLOCK, Block, Column, Spans};
use super::column::{greatest, known, least, sum};
use super::percentile;
use super::reference::BY_VOLUME;
use super::size_skew::size_skew;
use super::span::Span;
use multiversion::multiversion;

/// Metrics of a block's cells, their sums and their extremes. Entries of columns beyond the cells of
/// the block are undefined.
pub(super) struct Folded {
    pub volume: Column,
    /// Smallest corner Jacobian: positive for a cell that is not inverted. For a cell that is not valid in the
    /// reference its volume, or infinite.
    pub corner: Column,
    pub scaled: Column,
    /// Bin of a scaled Jacobian in the histogram.
    pub bins: [u32; BLOCK],
    pub edge_ratio_squared: Column,
    pub size_skew: Column,
    /// Cells that have a scaled Jacobian.
    pub n_scaled: usize,
    pub volume_sum: f64,
    pub scaled_sum: f64,
    pub least_volume: f64,
    /// Cells that are not inverted.
    pub n_good: usize,
    pub least_scaled: f64,
    pub most_edge_ratio_squared: f64,
    pub angles: [Span; N_CLASSES],
    /// Cells that have a size-skew.
    pub n_size_skew: usize,
    pub size_skew_sum: f64,
    pub least_size_skew: f64,
}

impl Folded {
    pub(super) const EMPTY: Self = Self {
        volume: [0.0; BLOCK],
        corner: [0.0; BLOCK],
        scaled: [0.0; BLOCK],
        bins: [0; BLOCK],
        edge_ratio_squared: [0.0; BLOCK],
        size_skew: [0.0; BLOCK],
        n_scaled: 0,
        volume_sum: 0.0,
        scaled_sum: 0.0,
        least_volume: 0.0,
        n_good: 0,
        least_scaled: 0.0,
        most_edge_ratio_squared: 0.0,
        angles: [Span::EMPTY; N_CLASSES],
        n_size_skew: 0,
        size_skew_sum: 0.0,
        least_size_skew: 0.0,
    };
}

/// Folds a block; `signs` come from [`Reference::signs_from`](super::Reference::signs_from), `sizes` the sums of their
/// `alpha_k` there.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(super) fn fold(block: &Block, signs: &[i8], sizes: &[f64], folded: &mut Folded) {
    let n = block.n.min(BLOCK);
    for (i, &sign) in signs[..n].iter().enumerate() {
        let turned = f64::from(sign.signum());
        folded.volume[i] = turned * block.volume[i];
        let corner = facing(&block.corner, i, turned);
        let by_volume = sign.abs() == BY_VOLUME;
        let unjudged = if by_volume {
            folded.volume[i]
        } else {
            f64::INFINITY
        };
        folded.corner[i] = if sign.abs() == 1 { corner } else { unjudged };
        folded.scaled[i] = facing(&block.scaled, i, turned);
        folded.edge_ratio_squared[i] = block.edge.high[i] / block.edge.low[i];
    }
    for i in 0..n {
        folded.bins[i] = percentile::bin(folded.scaled[i]);
    }
    for (i, &before) in sizes[..n].iter().enumerate() {
        folded.size_skew[i] = size_skew(block.size[i], block.skew[i], before);
    }
    let size_skew = &folded.size_skew[..n];
    folded.n_size_skew = known(size_skew);
    folded.size_skew_sum = sum(size_skew);
    folded.least_size_skew = least(size_skew);
    let scaled = &folded.scaled[..n];
    folded.n_scaled = known(scaled);
    folded.scaled_sum = sum(scaled);
    folded.least_scaled = least(scaled);
    folded.volume_sum = sum(&folded.volume[..n]);
    folded.least_volume = least(&folded.volume[..n]);
    folded.n_good = folded.corner[..n].iter().filter(|x| **x > 0.0).count();
    folded.most_edge_ratio_squared = greatest(&folded.edge_ratio_squared[..n]);
    for (extreme, spans) in folded.angles.iter_mut().zip(&block.angles) {
        *extreme = Span {
            low: least(&spans.low[..n]),
            high: greatest(&spans.high[..n]),
        };
    }
}

#[inline(always)]
fn facing(spans: &Spans, i: usize, sign: f64) -> f64 {
    let mirrored = -spans.high[i];
    if sign < 0.0 { mirrored } else { spans.low[i] }
}

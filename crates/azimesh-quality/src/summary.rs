//! Quality of a whole mesh in a few numbers, found in one pass over its cells.

use super::angles::{Angles, N_CLASSES};
use super::block::Block;
use super::detail;
use super::fold::{Folded, fold};
use super::percentile::Histogram;
use super::reference::Reference;
use super::size_skew::{ReferenceSizes, SizeSkew};
use super::span::Span;
use super::validity::Validity;
use super::visit::{self, CHUNK};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel::{self, Scratch};
use azimesh_io::mesh::Mesh;
use serde::{Deserialize, Serialize};

/// Inverted cells that are kept by index; all are counted.
const N_NAMED: usize = 20;

/// An extreme value and the cell that has it; of several the one with the lowest index.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Extreme {
    /// The value.
    pub value: f64,
    /// Index of the cell among all cells of the mesh.
    pub cell: usize,
}

/// Quality of the volume cells of a mesh. `None` where no cell has the metric.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Summary {
    /// Number of volume cells.
    pub n_cells: usize,
    /// Cells that are valid in the reference and have a Jacobian of zero or of the other sign now, at a corner or
    /// between the corners; and cells not valid there, of positive volume, whose volume is not positive now.
    pub inverted: usize,
    /// The first inverted cells, at most 20, ascending.
    pub inverted_cells: Vec<usize>,
    /// Cells whose corner Jacobians are not all positive in the reference: zero, of mixed signs, or
    /// of a solid cell with its nodes in reverse order.
    pub inverted_reference: usize,
    /// Cells that are valid at their corners and neither proven to be so between them nor refuted.
    pub unproven: usize,
    /// Smallest volume (area in 2D), positive for a cell that is oriented as in the reference.
    pub min_volume: Option<Extreme>,
    /// Sum of all volumes.
    pub total_volume: f64,
    /// Smallest scaled Jacobian.
    pub min_scaled_jacobian: Option<Extreme>,
    /// Mean scaled Jacobian.
    pub mean_scaled_jacobian: Option<f64>,
    /// First percentile of the scaled Jacobian, to 3.1e-5.
    pub p01_scaled_jacobian: Option<f64>,
    /// Least Jacobian of a curved cell relative to its mean in the cell with straight edges, and least scaled Jacobian
    /// ([`CurvedMap::least`](super::validity::CurvedMap::least)).
    pub min_curved: [Option<Extreme>; 2],
    /// Largest ratio of longest to shortest edge; infinite where an edge has no length.
    pub max_edge_ratio: Option<Extreme>,
    /// Largest equiangle skew.
    pub max_skew: Option<Extreme>,
    /// Against the reference mesh.
    pub size_skew: SizeSkew,
}

impl Summary {
    /// Counts the own cells of a mesh that are not proven to be valid between their corners; takes the least values of its
    /// `curved` cells.
    pub(super) fn take_validity(
        &mut self,
        validity: &Validity,
        curved: [Option<Extreme>; 2],
        mesh: &Mesh,
    ) {
        let named = validity.inside.iter().take(N_NAMED);
        let named = named.map(|&cell| cell as usize + mesh.own_offset());
        let own = (
            validity.unproven.len(),
            validity.inside.len(),
            named.collect::<Vec<_>>(),
            curved,
        );
        let nothing = (0, 0, Vec::new(), [None; 2]);
        let whole = mesh.ranks().ordered_fold(nothing, own, |all, own| {
            all.0 += own.0;
            all.1 += own.1;
            all.2.extend(own.2);
            all.2.truncate(N_NAMED);
            all.3 = detail::least_of_both(all.3, own.3);
        });
        let (unproven, inside, named, curved) = whole;
        self.min_curved = curved;
        self.unproven = unproven;
        self.inverted += inside;
        self.inverted_cells.extend(named);
        self.inverted_cells.sort_unstable();
        self.inverted_cells.truncate(N_NAMED);
    }

    /// Returns whether something is worse than in another summary of the mesh: more cells that are not valid, or a least value
    /// below the other's.
    pub fn is_worse_than(&self, other: &Self) -> bool {
        self.inverted > other.inverted
            || self.unproven > other.unproven
            || self.fallen(other).is_some()
    }

    /// The cell of the first least value that is below the other summary's: volume, scaled Jacobian, Jacobians of curved cells.
    pub(super) fn fallen(&self, other: &Self) -> Option<usize> {
        let least = |of: &Self| {
            let [jacobian, scaled] = of.min_curved;
            [of.min_volume, of.min_scaled_jacobian, jacobian, scaled]
        };
        let pairs = least(self).into_iter().zip(least(other));
        let mut pairs = pairs.filter_map(|(own, other)| Some((own?, other?)));
        let fallen = pairs.find(|(own, other)| own.value < other.value);
        fallen.map(|(own, _)| own.cell)
    }

    /// The columns in the order and by the names of `steps.csv`; a metric that is not defined is
    /// `None`.
    pub fn columns(&self) -> [(&'static str, Option<f64>); 8] {
        let value = |extreme: Option<Extreme>| extreme.map(|e| e.value);
        [
            ("inverted", Some(self.inverted as f64)),
            ("inverted_reference", Some(self.inverted_reference as f64)),
            ("min_volume", value(self.min_volume)),
            ("min_scaled_jacobian", value(self.min_scaled_jacobian)),
            ("mean_scaled_jacobian", self.mean_scaled_jacobian),
            ("p01_scaled_jacobian", self.p01_scaled_jacobian),
            ("max_edge_ratio", value(self.max_edge_ratio)),
            ("max_skew", value(self.max_skew)),
        ]
    }
}

/// Quality of the cells of `mesh` with their nodes at `points`, relative to `reference` and the `sizes` there.
///
/// One parallel pass. Sums are folded over fixed chunks of cells in order, so the result is the
/// same on any number of threads.
///
/// # Panics
/// When `points` has fewer nodes than the mesh, or `reference` and `sizes` are of a mesh with fewer cells.
pub fn assess(
    mesh: &Mesh,
    points: &[Vector],
    reference: &Reference,
    sizes: &ReferenceSizes,
) -> Summary {
    let histograms = Scratch::new(Histogram::new);
    let offset = mesh.own_offset();
    let of_chunk = |range, histogram: &mut Histogram| {
        let (mut part, mut folded) = (CellTotals::new(), Folded::EMPTY);
        visit::volume_cells(mesh, points, reference.facing(), range, |first, block| {
            fold(
                block,
                reference.signs_from(first),
                sizes.from(first),
                &mut folded,
            );
            part.take(first + offset, block, &folded, histogram);
        });
        part
    };
    let parts = parallel::map_blocks_in(mesh.own_cells(), CHUNK, &|range| {
        histograms.with(|histogram| of_chunk(range, histogram))
    });
    let nothing = (CellTotals::new(), Histogram::new());
    let mut own = Histogram::new();
    for counts in histograms.into_all() {
        own.merge(&counts);
    }
    let (whole, histogram) =
        mesh.ranks()
            .ordered_fold(nothing, (parts, own), |all, (parts, own)| {
                for part in &parts {
                    all.0.append(part);
                }
                all.1.merge(&own);
            });
    whole.finish(reference, &histogram)
}

/// Sums and extremes over a chunk of cells.
#[derive(Serialize, Deserialize)]
struct CellTotals {
    n_cells: usize,
    n_scaled: usize,
    inverted: usize,
    inverted_cells: Vec<usize>,
    volume_sum: f64,
    scaled_sum: f64,
    min_volume: Option<Extreme>,
    min_scaled: Option<Extreme>,
    max_edge_ratio_squared: Option<Extreme>,
    max_skew: Option<Extreme>,
    /// Of the chunk alone.
    #[serde(skip, default = "no_angles")]
    angles: Angles,
    n_size_skew: usize,
    size_skew_sum: f64,
    min_size_skew: Option<Extreme>,
}

fn no_angles() -> Angles {
    Angles::NONE
}

impl CellTotals {
    fn new() -> Self {
        Self {
            n_cells: 0,
            n_scaled: 0,
            inverted: 0,
            inverted_cells: Vec::new(),
            volume_sum: 0.0,
            scaled_sum: 0.0,
            min_volume: None,
            min_scaled: None,
            max_edge_ratio_squared: None,
            max_skew: None,
            angles: Angles::NONE,
            n_size_skew: 0,
            size_skew_sum: 0.0,
            min_size_skew: None,
        }
    }

    fn take(&mut self, first: usize, block: &Block, folded: &Folded, all: &mut Histogram) {
        let n = block.n;
        self.n_cells += n;
        self.volume_sum += folded.volume_sum;
        lower(
            &mut self.min_volume,
            folded.least_volume,
            &folded.volume[..n],
            first,
        );
        if folded.n_good < n {
            self.name_inverted(first, &folded.corner[..n]);
        }
        self.n_scaled += folded.n_scaled;
        self.scaled_sum += folded.scaled_sum;
        lower(
            &mut self.min_scaled,
            folded.least_scaled,
            &folded.scaled[..n],
            first,
        );
        let is_defined = |i: &usize| folded.n_scaled == n || !folded.scaled[*i].is_nan();
        for i in (0..n).filter(is_defined) {
            all.add_to(folded.bins[i]);
        }
        let ratios = &folded.edge_ratio_squared[..n];
        raise(
            &mut self.max_edge_ratio_squared,
            folded.most_edge_ratio_squared,
            ratios,
            first,
        );
        self.take_angles(first, block, &folded.angles);
        self.n_size_skew += folded.n_size_skew;
        self.size_skew_sum += folded.size_skew_sum;
        lower(
            &mut self.min_size_skew,
            folded.least_size_skew,
            &folded.size_skew[..n],
            first,
        );
    }

    fn name_inverted(&mut self, first: usize, corner: &[f64]) {
        let is_bad = |(_, corner): &(usize, &f64)| corner.is_nan() || **corner <= 0.0;
        for (i, _) in corner.iter().enumerate().filter(is_bad) {
            self.inverted += 1;
            if self.inverted_cells.len() < N_NAMED {
                self.inverted_cells.push(first + i);
            }
        }
    }

    /// An arc cosine only for angles beyond all seen before.
    fn take_angles(&mut self, first: usize, block: &Block, extremes: &[Span; N_CLASSES]) {
        let classes = self.angles.classes.iter_mut();
        for ((mine, spans), extreme) in classes.zip(&block.angles).zip(extremes) {
            let (low, high) = (&spans.low[..block.n], &spans.high[..block.n]);
            let (smallest, largest) = (extreme.low, extreme.high);
            let sides = [
                (smallest < mine.low, low, smallest),
                (largest > mine.high, high, largest),
            ];
            for (is_beyond, values, extreme) in sides {
                if !is_beyond {
                    continue;
                }
                let position = values.iter().position(|&value| value == extreme);
                if let Some(i) = position
                    && let Some(skew) = block.angles(i).skew()
                {
                    keep_greater(&mut self.max_skew, skew, first + i);
                }
            }
            mine.merge(*extreme);
        }
    }

    fn append(&mut self, next: &Self) {
        self.n_cells += next.n_cells;
        self.n_scaled += next.n_scaled;
        self.inverted += next.inverted;
        let free = N_NAMED - self.inverted_cells.len();
        let named = next.inverted_cells.iter().take(free);
        self.inverted_cells.extend(named);
        self.volume_sum += next.volume_sum;
        self.scaled_sum += next.scaled_sum;
        self.n_size_skew += next.n_size_skew;
        self.size_skew_sum += next.size_skew_sum;
        for (mine, theirs) in [
            (&mut self.min_volume, next.min_volume),
            (&mut self.min_scaled, next.min_scaled),
            (&mut self.min_size_skew, next.min_size_skew),
        ] {
            if let Some(e) = theirs {
                keep_less(mine, e.value, e.cell);
            }
        }
        for (mine, theirs) in [
            (
                &mut self.max_edge_ratio_squared,
                next.max_edge_ratio_squared,
            ),
            (&mut self.max_skew, next.max_skew),
        ] {
            if let Some(e) = theirs {
                keep_greater(mine, e.value, e.cell);
            }
        }
    }

    fn finish(self, reference: &Reference, histogram: &Histogram) -> Summary {
        Summary {
            n_cells: self.n_cells,
            inverted: self.inverted,
            inverted_cells: self.inverted_cells,
            inverted_reference: reference.n_inverted(),
            unproven: 0,
            min_curved: [None; 2],
            min_volume: self.min_volume,
            total_volume: self.volume_sum,
            min_scaled_jacobian: self.min_scaled,
            mean_scaled_jacobian: (self.n_scaled > 0)
                .then(|| self.scaled_sum / self.n_scaled as f64),
            // No further than the smallest value itself.
            p01_scaled_jacobian: histogram
                .percentile(0.01)
                .map(|p| self.min_scaled.map_or(p, |min| p.max(min.value))),
            max_edge_ratio: self.max_edge_ratio_squared.map(|e| Extreme {
                value: e.value.sqrt(),
                ..e
            }),
            max_skew: self.max_skew,
            size_skew: SizeSkew {
                min: self.min_size_skew,
                mean: (self.n_size_skew > 0).then(|| self.size_skew_sum / self.n_size_skew as f64),
            },
        }
    }
}

fn lower(extreme: &mut Option<Extreme>, value: f64, values: &[f64], first: usize) {
    if extreme.is_none_or(|e| value < e.value)
        && let Some(i) = values.iter().position(|&x| x == value)
    {
        keep_less(extreme, value, first + i);
    }
}

fn raise(extreme: &mut Option<Extreme>, value: f64, values: &[f64], first: usize) {
    if extreme.is_none_or(|e| value > e.value)
        && let Some(i) = values.iter().position(|&x| x == value)
    {
        keep_greater(extreme, value, first + i);
    }
}

pub(super) fn keep_less(extreme: &mut Option<Extreme>, value: f64, cell: usize) {
    if extreme.is_none_or(|e| value < e.value || (value == e.value && cell < e.cell)) {
        *extreme = Some(Extreme { value, cell });
    }
}

fn keep_greater(extreme: &mut Option<Extreme>, value: f64, cell: usize) {
    if extreme.is_none_or(|e| value > e.value || (value == e.value && cell < e.cell)) {
        *extreme = Some(Extreme { value, cell });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_is_worse_if_a_count_rises_or_any_least_value_falls() {
        let at = |value: f64| Some(Extreme { value, cell: 7 });
        let one = Summary {
            inverted: 1,
            unproven: 1,
            min_volume: at(0.5),
            min_scaled_jacobian: at(0.5),
            min_curved: [at(0.5); 2],
            ..Summary::default()
        };
        let changes: [fn(&mut Summary, f64); 4] = [
            |of, by| of.min_volume.as_mut().expect("set").value += by,
            |of, by| of.min_scaled_jacobian.as_mut().expect("set").value += by,
            |of, by| of.min_curved[0].as_mut().expect("set").value += by,
            |of, by| of.min_curved[1].as_mut().expect("set").value += by,
        ];
        assert!(!one.is_worse_than(&one));
        for change in changes {
            let (mut worse, mut better) = (one.clone(), one.clone());
            change(&mut worse, -1e-12);
            change(&mut better, 1e-12);
            assert!(worse.is_worse_than(&one) && !better.is_worse_than(&one));
            assert_eq!((worse.fallen(&one), better.fallen(&one)), (Some(7), None));
        }
        let counts: [fn(&mut Summary); 2] = [|of| of.inverted += 1, |of| of.unproven += 1];
        for raise in counts {
            let mut worse = one.clone();
            raise(&mut worse);
            assert!(worse.is_worse_than(&one) && !one.is_worse_than(&worse));
        }
    }
}

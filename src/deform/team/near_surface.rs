//! The surface near some of it: what the correction of fields at nodes there needs of it.
//!
//! The first rank has the whole surface, in patches of points that follow each other along a space-filling curve. The nodes
//! around a patch are within its box, grown by how far the correction reaches. Each rank corrects the nodes around
//! consecutive patches and gets the facets that are in reach of those.

use crate::deform::fields::{Chosen, MeshState, Narrow, fading, narrowest};
use crate::deform::layer::Layer;
use crate::geometry::Bounds;
use crate::geometry::boxes::Boxes;
use crate::geometry::vector::Vector;
use crate::parallel;
use crate::ranks::raw;
use crate::rbf::correct::{Added, Correction, Fading};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// By so much of its size a box is larger than it has to be: round-off leaves out no facet.
const MARGIN: f64 = 1e-9;
/// Points of a patch at least, and patches at most.
const PATCH: usize = 16;
const MOST_PATCHES: usize = 1 << 16;
/// Facets that are looked at by one task.
const BLOCK: usize = 1 << 14;

/// The whole surface, with how far the correction of each layer reaches. The first rank has it.
pub(super) struct WholeSurface<'a> {
    state: MeshState<'a>,
    layers: Vec<Reach<'a>>,
    /// The largest reach of any layer, with a margin; zero where nothing is corrected.
    reach: f64,
    /// Where two surfaces come closest.
    pub narrow: Option<Narrow>,
}

/// What the correction of a layer adds, and how far it reaches.
struct Reach<'a> {
    residuals: &'a [f64],
    n_modes: usize,
    fade_radius: Vec<f64>,
    largest_fade_radius: f64,
}

/// Some of the facets, in the order of the whole surface.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct NearSurface {
    #[serde(with = "raw")]
    points: Vec<Vector>,
    #[serde(with = "raw")]
    facets: Vec<[u32; 3]>,
    layers: Vec<NearLayer>,
}

/// The correction of a layer at the points of a near surface.
#[derive(Serialize, Deserialize)]
struct NearLayer {
    n_modes: usize,
    #[serde(with = "raw")]
    residuals: Vec<f64>,
    #[serde(with = "raw")]
    fade_radius: Vec<f64>,
    largest_fade_radius: f64,
}

impl<'a> WholeSurface<'a> {
    /// Finds how far the correction of each layer reaches; without `correct` there is none.
    pub fn new(
        state: MeshState<'a>,
        layers: &[Layer],
        chosen: &[Chosen<'a>],
        correct: bool,
    ) -> Self {
        let mut narrow = None;
        let reach = |(layer, chosen): (&Layer, &Chosen<'a>)| {
            let n_modes = layer.modes.n_modes;
            let mut reach = Reach {
                residuals: &chosen.selection.residuals,
                n_modes,
                fade_radius: Vec::new(),
                largest_fade_radius: 0.0,
            };
            if correct && n_modes > 0 {
                let found = fading(state, chosen);
                narrow = narrowest(narrow, chosen, &found);
                reach.largest_fade_radius = found.largest_fade_radius;
                reach.fade_radius = found.fade_radius;
            }
            reach
        };
        let layers: Vec<Reach<'_>> = layers.iter().zip(chosen).map(reach).collect();
        let reaches = layers.iter().map(|layer| layer.largest_fade_radius);
        let reach = reaches.fold(0.0, f64::max);
        Self {
            reach: with_margin(reach, state),
            state,
            layers,
            narrow,
        }
    }

    /// With changes (N_s, 3) of the surface that fade out.
    pub fn of_changes(state: MeshState<'a>, fading: &Fading<'_>, changes: &'a [f64]) -> Self {
        let reach = fading.largest_fade_radius;
        Self {
            reach: with_margin(reach, state),
            layers: vec![Reach {
                residuals: changes,
                n_modes: 3,
                fade_radius: fading.fade_radius.clone(),
                largest_fade_radius: reach,
            }],
            state,
            narrow: None,
        }
    }

    fn n_patches(&self) -> usize {
        self.state.surface.len().div_ceil(PATCH).min(MOST_PATCHES)
    }

    /// The patch of a facet: that of the first of its corners along the curve.
    fn patch(&self, facet: [u32; 3]) -> usize {
        let first = facet.into_iter().min().unwrap_or(0) as usize;
        first * self.n_patches() / self.state.surface.len()
    }

    /// The box around a facet with all that it corrects.
    fn reach_of(&self, facet: [u32; 3]) -> Bounds {
        let corners = facet.map(|point| self.state.surface[point as usize]);
        Bounds::around(&corners).grown(self.reach)
    }

    /// The boxes of the patches, in which all nodes lie that are corrected; none where there are none.
    pub fn boxes(&self) -> Vec<Bounds> {
        if self.reach == 0.0 {
            return Vec::new();
        }
        let facets = self.state.facets;
        let blocks = parallel::map_blocks(facets.len(), BLOCK, &|range| {
            let mut boxes = BTreeMap::new();
            for &facet in &facets[range] {
                let bounds = boxes.entry(self.patch(facet)).or_insert(Bounds::EMPTY);
                *bounds = bounds.union(&self.reach_of(facet));
            }
            boxes
        });
        let mut boxes = vec![Bounds::EMPTY; self.n_patches()];
        for (patch, bounds) in blocks.into_iter().flatten() {
            boxes[patch] = boxes[patch].union(&bounds);
        }
        boxes
    }

    /// The facets near the patches of each rank; of those of rank `i` the first is `starts[i]`, the last comes before
    /// `starts[i + 1]`.
    pub fn near_each(&self, boxes: &Boxes, starts: &[u32]) -> Vec<Vec<u32>> {
        let facets = self.state.facets;
        let found = parallel::concat_blocks(facets.len(), BLOCK, &|range| {
            let mut found: Vec<[u32; 2]> = Vec::new();
            for facet in range {
                let first = found.len();
                boxes.each_meeting(&self.reach_of(facets[facet]), |patch| {
                    let rank = rank_of(starts, patch as u32) as u32;
                    if found[first..].iter().all(|of| of[0] != rank) {
                        found.push([rank, facet as u32]);
                    }
                });
            }
            found
        });
        let mut each = vec![Vec::new(); starts.len() - 1];
        for [rank, facet] in found {
            each[rank as usize].push(facet);
        }
        each
    }

    /// Some facets, by their numbers.
    pub fn some(&self, facets: &[u32]) -> NearSurface {
        let mut facets = parallel::collect(facets.len(), |i| self.state.facets[facets[i] as usize]);
        let mut points = facets.as_flattened().to_vec();
        parallel::sort(&mut points);
        points.dedup();
        parallel::update(&mut facets, |_, facet| {
            *facet = facet.map(|point| points.partition_point(|&other| other < point) as u32);
        });
        NearSurface {
            facets,
            layers: self.layers.iter().map(|layer| layer.at(&points)).collect(),
            points: parallel::collect(points.len(), |i| self.state.surface[points[i] as usize]),
        }
    }
}

/// How far a correction reaches, with a margin; zero where nothing is corrected.
fn with_margin(reach: f64, state: MeshState<'_>) -> f64 {
    let margin = MARGIN * (reach + Bounds::around(state.surface).diagonal());
    if reach > 0.0 { reach + margin } else { 0.0 }
}

/// The rank that has a patch; of those of rank `i` the first is `starts[i]`.
pub(super) fn rank_of(starts: &[u32], patch: u32) -> usize {
    starts.partition_point(|&start| start <= patch) - 1
}

impl Reach<'_> {
    /// At some points of the surface.
    fn at(&self, points: &[u32]) -> NearLayer {
        let r = self.n_modes;
        let rows = points.iter().map(|&at| at as usize * r);
        let rho = |&at: &u32| self.fade_radius.get(at as usize).copied();
        NearLayer {
            n_modes: r,
            residuals: rows
                .flat_map(|at| &self.residuals[at..at + r])
                .copied()
                .collect(),
            fade_radius: points.iter().filter_map(rho).collect(),
            largest_fade_radius: self.largest_fade_radius,
        }
    }
}

impl NearSurface {
    /// What the correction of each layer adds at each list of points.
    pub fn added_at(&self, lists: &[Vec<Vector>]) -> Vec<Vec<Added>> {
        let mut added: Vec<Vec<Added>> = lists.iter().map(|_| Vec::new()).collect();
        for near in &self.layers {
            let correction = self.correction(near);
            for (points, added) in lists.iter().zip(&mut added) {
                let of_layer = correction.as_ref().map(|correction| correction.at(points));
                added.push(of_layer.unwrap_or_default());
            }
        }
        added
    }

    /// The correction of a layer; none where it adds nothing.
    fn correction<'a>(&'a self, near: &'a NearLayer) -> Option<Correction<'a>> {
        if near.largest_fade_radius == 0.0 || self.facets.is_empty() {
            return None;
        }
        let fading = Fading::of_some(
            &self.points,
            &self.facets,
            near.fade_radius.clone(),
            near.largest_fade_radius,
        );
        let correction = Correction::fading(fading, &near.residuals, near.n_modes);
        Some(correction)
    }
}

//! The surface near the nodes of a rank: what the correction of the fields there needs of it.

use crate::deform::fields::{Chosen, MeshState, Narrow, fading, narrowest};
use crate::deform::layer::Layer;
use crate::geometry::Bounds;
use crate::geometry::vector::Vector;
use crate::parallel;
use crate::ranks::raw;
use crate::rbf::correct::{Correction, Fading};
use crate::rbf::field::Field;
use serde::{Deserialize, Serialize};

/// By so much of its size a box is larger than it has to be: round-off leaves out no facet.
const MARGIN: f64 = 1e-9;
/// A surface point that is not near.
const FAR: u32 = u32::MAX;

/// The whole surface, with how far the correction of each layer reaches. The first rank has it.
pub(super) struct WholeSurface<'a> {
    state: MeshState<'a>,
    layers: Vec<Reach<'a>>,
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

/// Facets near the nodes of a rank, in the order of the whole surface.
#[derive(Serialize, Deserialize)]
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
        let layers = layers.iter().zip(chosen).map(reach).collect();
        Self {
            state,
            layers,
            narrow,
        }
    }

    /// What is near some nodes.
    pub fn near(&self, nodes: &[Vector]) -> NearSurface {
        let MeshState {
            surface, facets, ..
        } = self.state;
        let reaches = self.layers.iter().map(|layer| layer.largest_fade_radius);
        let reach = reaches.fold(0.0, f64::max);
        let bounds = Bounds::around(nodes);
        let bounds = bounds.grown(reach + MARGIN * (reach + bounds.diagonal()));
        let is_near = |facet: &[u32; 3]| {
            let corners = facet.iter().map(|&point| &surface[point as usize]);
            reach > 0.0 && bounds.meets(&Bounds::around(corners))
        };
        let found = |at: usize| Some(facets[at]).filter(is_near);
        let mut near = parallel::filter_map(facets.len(), found);
        let mut number = vec![FAR; surface.len()];
        for &point in near.iter().flatten() {
            number[point as usize] = 0;
        }
        let points = parallel::filter_map(number.len(), |at| (number[at] == 0).then_some(at));
        for (new, &point) in (0..).zip(&points) {
            number[point] = new;
        }
        parallel::update(&mut near, |_, facet| {
            *facet = facet.map(|point| number[point as usize]);
        });
        NearSurface {
            facets: near,
            layers: self.layers.iter().map(|layer| layer.at(&points)).collect(),
            points: points.into_iter().map(|point| surface[point]).collect(),
        }
    }
}

impl Reach<'_> {
    /// At some points of the surface.
    fn at(&self, points: &[usize]) -> NearLayer {
        let r = self.n_modes;
        let rows = points.iter().flat_map(|&at| &self.residuals[at * r..][..r]);
        NearLayer {
            n_modes: r,
            residuals: rows.copied().collect(),
            fade_radius: points
                .iter()
                .filter_map(|&at| self.fade_radius.get(at).copied())
                .collect(),
            largest_fade_radius: self.largest_fade_radius,
        }
    }
}

impl NearSurface {
    /// Adds the correction of a layer to its field at `nodes`.
    pub fn correct(&self, layer: usize, field: &mut Field, nodes: &[Vector]) {
        let near = &self.layers[layer];
        if near.largest_fade_radius > 0.0 && !self.facets.is_empty() {
            let fading = Fading::of_some(
                &self.points,
                &self.facets,
                near.fade_radius.clone(),
                near.largest_fade_radius,
            );
            Correction::fading(fading, &near.residuals, near.n_modes).add_to(field, nodes);
        }
    }
}

//! The fields of all layers: their interpolants evaluated at the nodes of a rank, with the correction
//! that makes the surface exact.

pub(crate) mod rank_correction;
pub(crate) mod sliding;
pub(crate) mod velocity;

use self::rank_correction::add_correction;
use super::plan::layer::{Layer, LayerKind};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, add};
use azimesh_core::parallel;
use azimesh_core::progress::Progress;
use azimesh_core::ranks::Ranks;
use azimesh_rbf::correct::{Correction, FADE_RADIUS_PER_ERROR, Fading};
use azimesh_rbf::field::{BLOCK, Field};
use azimesh_rbf::images::Images;
use azimesh_rbf::select::Selection;

/// The state of the mesh that is deformed: the reference mesh, or the result of a substep.
#[derive(Debug, Clone, Copy)]
pub struct MeshState<'a> {
    /// Positions of the nodes of this rank.
    pub nodes: &'a [Vector],
    /// The nodes that deform, ascending; `None` for all.
    pub deforming: Option<&'a [u32]>,
    /// Positions of all surface points.
    pub surface: &'a [Vector],
    /// Facets between them.
    pub facets: &'a [[u32; 3]],
    /// Their periodic images.
    pub images: &'a Images,
    /// A box around the nodes that deform.
    pub region: Bounds,
}

impl<'a> MeshState<'a> {
    /// Builds the correction by residuals (N_s, r) of the surface of at most `error`, which its images have too, and finds the
    /// narrowest gap.
    fn correction(
        &self,
        residuals: &'a [f64],
        n_modes: usize,
        error: f64,
    ) -> (Correction<'a>, Option<Narrow>) {
        let fade_radius = FADE_RADIUS_PER_ERROR * error;
        let radii = vec![fade_radius; self.surface.len()];
        let (fading, all) =
            Fading::continued(self.images, self.surface, self.facets, &self.region, &radii);
        let residuals = all.values(residuals, n_modes);
        let narrow = fading.narrowest_gap.map(|gap| Narrow {
            point: all.source(gap.node),
            width: gap.width,
            fade_radius,
        });
        (Correction::fading(fading, residuals, n_modes), narrow)
    }
}

/// Base points of a layer, with the largest error that the correction has to remove.
#[derive(Debug, Clone, Copy)]
pub struct Chosen<'a> {
    /// Base points, interpolant and residuals.
    pub selection: &'a Selection,
    /// Largest displacement error over the relevant steps.
    pub error: f64,
}

/// A narrow gap: two surfaces closer than the fade radius of the correction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Narrow {
    /// Index of a surface point.
    pub point: usize,
    /// Width of the gap, in mesh units.
    pub width: f64,
    /// Fade radius of the correction without the gap.
    pub fade_radius: f64,
}

/// Fields of all layers at the nodes of a rank.
pub struct Fields {
    fields: Vec<Field>,
    /// The narrowest gap between two surfaces within twice the fade radius.
    pub narrow: Option<Narrow>,
}

impl Fields {
    /// Evaluates every layer at the deforming nodes of this rank; `correct` makes the surface exact. All ranks call it.
    pub fn new(
        state: MeshState<'_>,
        layers: &[Layer],
        chosen: &[Chosen<'_>],
        correct: bool,
        ranks: &Ranks,
        progress: &dyn Progress,
    ) -> Self {
        let report = |n: usize| progress.advance(n as u64);
        let mut narrow: Option<Narrow> = None;
        let evaluate = |(layer, chosen)| evaluate(state, layer, chosen, &report);
        let mut fields: Vec<Field> = layers.iter().zip(chosen).map(evaluate).collect();
        for (field, (layer, chosen)) in fields.iter_mut().zip(layers.iter().zip(chosen)) {
            if correct && layer.modes.n_modes > 0 {
                let residuals = &chosen.selection.residuals;
                let (correction, found) =
                    state.correction(residuals, layer.modes.n_modes, chosen.error);
                let both = narrow.into_iter().chain(found);
                narrow = both.min_by(|a, b| a.width.total_cmp(&b.width));
                add_correction(&correction, field, state.nodes, ranks);
            }
        }
        Self { fields, narrow }
    }

    /// Writes the displacements of the nodes at a step of displacement layers.
    pub fn vectors(&self, layers: &[Layer], step: usize, out: &mut [Vector]) {
        let still = vec![[0.0; 3]; out.len()];
        self.displace(layers, step, &still, out);
    }

    /// Writes the positions at a step of the layers to `out`. The fields were evaluated at `nodes`.
    pub fn displace(&self, layers: &[Layer], step: usize, nodes: &[Vector], out: &mut [Vector]) {
        let translation = layers
            .iter()
            .zip(&self.fields)
            .find(|(layer, _)| layer.kind == LayerKind::Displacement);
        match translation {
            Some((layer, field)) => field.displace(layer.modes.at_step(step), nodes, out),
            None => out.copy_from_slice(nodes),
        }
        for (layer, field) in layers.iter().zip(&self.fields) {
            if layer.kind != LayerKind::Displacement && layer.modes.n_modes > 0 {
                rotate(layer, field, step, nodes, out);
            }
        }
    }
}

/// Evaluates the modes of a layer at the deforming nodes, before the correction.
fn evaluate(
    state: MeshState<'_>,
    layer: &Layer,
    chosen: &Chosen<'_>,
    report: &dyn Fn(usize),
) -> Field {
    let deforming = state.deforming.map(<[u32]>::to_vec);
    let interpolant = &chosen.selection.interpolant;
    let mut field = Field::evaluate(interpolant, state.nodes, deforming, report);
    if field.n_modes != layer.modes.n_modes {
        // Without a base point every value is zero.
        field.n_modes = layer.modes.n_modes;
        let n_nodes = field.nodes.as_ref().map_or(state.nodes.len(), Vec::len);
        field.values = vec![0.0; n_nodes * field.n_modes];
    }
    let Field { nodes, values, .. } = &mut field;
    match nodes {
        None => layer.add_rings(values, |row| state.nodes[row]),
        Some(nodes) => layer.add_rings(values, |row| state.nodes[nodes[row] as usize]),
    }
    field
}

/// Adds the displacements by the rotations of a layer at a step.
fn rotate(layer: &Layer, field: &Field, step: usize, at: &[Vector], out: &mut [Vector]) {
    let r = field.n_modes;
    let turned = |x: Vector, row: &[f64]| layer.displacement(x, row, step);
    match &field.nodes {
        None => parallel::for_blocks(out, BLOCK, &|first, out| {
            let nodes = out.iter_mut().zip(&at[first..]);
            for ((out, x), row) in nodes.zip(field.values[first * r..].chunks_exact(r)) {
                *out = add(*out, turned(*x, row));
            }
        }),
        Some(nodes) => {
            let moved = parallel::collect(nodes.len(), |i| {
                turned(at[nodes[i] as usize], &field.values[i * r..][..r])
            });
            for (&node, moved) in nodes.iter().zip(moved) {
                out[node as usize] = add(out[node as usize], moved);
            }
        }
    }
}

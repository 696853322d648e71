//! The fields of all layers: their interpolants evaluated at every node of one mesh, with the correction
//! that makes the surface exact.

use super::layer::{Layer, LayerKind};
use super::team::{SharedFields, Team};
use crate::geometry::vector::{Vector, add};
use crate::parallel;
use crate::progress::Progress;
use crate::rbf::correct::{Correction, FADE_RADIUS_PER_ERROR, Fading};
use crate::rbf::field::{BLOCK, Field};
use crate::rbf::select::Selection;
use std::sync::Arc;

const ELSEWHERE: &str = "fields lie with this process";

/// The state of the mesh that is deformed: the reference mesh, or the result of a substep.
#[derive(Debug, Clone, Copy)]
pub struct MeshState<'a> {
    /// Positions of all nodes.
    pub nodes: &'a [Vector],
    /// The nodes that deform, ascending; `None` for all.
    pub deforming: Option<&'a [u32]>,
    /// Positions of the surface points.
    pub surface: &'a [Vector],
    /// Facets between them.
    pub facets: &'a [[u32; 3]],
    /// Where ranks have the nodes too.
    pub rank_places: RankPlaces,
}

/// Where ranks have the nodes of a mesh that is deformed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RankPlaces {
    /// At rest: it is the reference mesh.
    Rest,
    /// Where they have moved them to.
    Moved,
    /// They have to be told.
    Told,
}

/// Base points of a layer, with the largest error that the correction has to remove.
#[derive(Debug, Clone, Copy)]
pub struct Chosen<'a> {
    /// Base points, interpolant and residuals.
    pub selection: &'a Selection,
    /// Largest displacement error over the steps that are meant.
    pub error: f64,
}

/// A place where two surfaces come closer than the fade radius of the correction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Narrow {
    /// Surface point, by its position.
    pub point: usize,
    /// Width of the gap, in mesh units.
    pub width: f64,
    /// The fade radius that the correction would have.
    pub fade_radius: f64,
}

/// Fields of all layers.
pub struct Fields {
    way: Way,
    /// The narrowest gap between two surfaces within twice the fade radius.
    pub narrow: Option<Narrow>,
}

/// Where fields lie.
enum Way {
    /// All with this rank.
    Here(Vec<Field>),
    /// With all ranks, a slab each.
    Shared(SharedFields),
}

impl Fields {
    /// Evaluates every layer at the nodes that deform, with the ranks of a `team` where there is one; with `correct` the surface
    /// is made exact.
    pub(crate) fn new(
        state: MeshState<'_>,
        layers: &[Layer],
        chosen: &[Chosen<'_>],
        correct: bool,
        progress: &dyn Progress,
        team: Option<&Arc<Team>>,
    ) -> Self {
        if let Some(team) = team {
            let (shared, narrow) = team.evaluate(state, layers, chosen, correct, progress);
            let way = Way::Shared(shared);
            return Self { way, narrow };
        }
        let mut narrow: Option<Narrow> = None;
        let mut fields = evaluate_all(state, layers, chosen, progress);
        for (field, (layer, chosen)) in fields.iter_mut().zip(layers.iter().zip(chosen)) {
            if correct && layer.modes.n_modes > 0 {
                let fading = fading(state, chosen);
                narrow = narrowest(narrow, chosen, &fading);
                let residuals = &chosen.selection.residuals;
                let correction = Correction::fading(fading, residuals, layer.modes.n_modes);
                correction.add_to(field, state.nodes);
            }
        }
        let way = Way::Here(fields);
        Self { way, narrow }
    }

    /// Evaluates every layer at the nodes of a rank, without the correction.
    pub(super) fn at_rank(
        state: MeshState<'_>,
        layers: &[Layer],
        chosen: &[Chosen<'_>],
        progress: &dyn Progress,
    ) -> Self {
        Self {
            way: Way::Here(evaluate_all(state, layers, chosen, progress)),
            narrow: None,
        }
    }

    /// The field of a layer.
    ///
    /// # Panics
    /// Where it lies with several ranks.
    pub(super) fn of_layer(&mut self, layer: usize) -> &mut Field {
        match &mut self.way {
            Way::Here(fields) => &mut fields[layer],
            Way::Shared(_) => panic!("{ELSEWHERE}"),
        }
    }

    /// Writes by how much the nodes move at a step of layers of displacements.
    pub fn vectors(&self, layers: &[Layer], step: usize, out: &mut [Vector]) {
        match &self.way {
            Way::Shared(shared) => shared.move_to(step, None, out),
            Way::Here(_) => {
                let still = vec![[0.0; 3]; out.len()];
                let state = MeshState {
                    nodes: &still,
                    deforming: None,
                    surface: &[],
                    facets: &[],
                    rank_places: RankPlaces::Told,
                };
                self.displace(layers, step, state, out);
            }
        }
    }

    /// Moves all nodes to a step, and writes to `out` where those are of which ranks tell: the others stay with their ranks. With
    /// `from_zero` nothing moves, and what is found is by how much it would.
    ///
    /// # Panics
    /// Where there are no other ranks.
    pub(super) fn displace_apart(&self, step: usize, from_zero: bool, out: &mut [Vector]) {
        match &self.way {
            Way::Shared(shared) => shared.move_apart(step, from_zero, out),
            Way::Here(_) => panic!("nodes stay with ranks where there are several"),
        }
    }

    /// Has other ranks add changes (N_s, 3) of the surface to where they have moved nodes to, fading out.
    pub(super) fn fade_elsewhere(
        &self,
        state: MeshState<'_>,
        fading: &Fading<'_>,
        changes: &[f64],
    ) {
        if let Way::Shared(shared) = &self.way {
            shared.fade(state, fading, changes);
        }
    }

    /// Writes the positions at a step of the layers to `out`; `state` is what the fields were evaluated for.
    pub fn displace(
        &self,
        layers: &[Layer],
        step: usize,
        state: MeshState<'_>,
        out: &mut [Vector],
    ) {
        let fields = match &self.way {
            Way::Here(fields) => fields,
            Way::Shared(shared) => return shared.move_to(step, Some(state.nodes), out),
        };
        let translation = layers
            .iter()
            .zip(fields)
            .find(|(layer, _)| layer.kind == LayerKind::Displacement);
        match translation {
            Some((layer, field)) => field.displace(layer.modes.at_step(step), state.nodes, out),
            None => out.copy_from_slice(state.nodes),
        }
        for (layer, field) in layers.iter().zip(fields) {
            if layer.kind != LayerKind::Displacement && layer.modes.n_modes > 0 {
                rotate(layer, field, step, state, out);
            }
        }
    }
}

/// The values of the modes of a layer at the nodes that deform, before the correction.
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
        // There is no base point: every value is zero.
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

fn evaluate_all(
    state: MeshState<'_>,
    layers: &[Layer],
    chosen: &[Chosen<'_>],
    progress: &dyn Progress,
) -> Vec<Field> {
    let report = |n: usize| progress.advance(n as u64);
    let layers = layers.iter().zip(chosen);
    layers
        .map(|(layer, chosen)| evaluate(state, layer, chosen, &report))
        .collect()
}

/// Where the correction of a layer fades out.
pub(super) fn fading<'a>(state: MeshState<'a>, chosen: &Chosen<'_>) -> Fading<'a> {
    let fade_radius = vec![FADE_RADIUS_PER_ERROR * chosen.error; state.surface.len()];
    Fading::new(state.surface, state.facets, fade_radius)
}

/// The narrower of a gap and that of another layer.
pub(super) fn narrowest(
    before: Option<Narrow>,
    chosen: &Chosen<'_>,
    fading: &Fading<'_>,
) -> Option<Narrow> {
    let found = fading.narrowest_gap.map(|gap| Narrow {
        point: gap.node,
        width: gap.width,
        fade_radius: FADE_RADIUS_PER_ERROR * chosen.error,
    });
    let both = before.into_iter().chain(found);
    both.min_by(|a, b| a.width.total_cmp(&b.width))
}

/// Adds what the rotations of a layer do at a step.
fn rotate(layer: &Layer, field: &Field, step: usize, state: MeshState<'_>, out: &mut [Vector]) {
    let r = field.n_modes;
    let turned = |x: Vector, row: &[f64]| layer.displacement(x, row, step);
    match &field.nodes {
        None => parallel::for_blocks(out, BLOCK, &|first, out| {
            let nodes = out.iter_mut().zip(&state.nodes[first..]);
            for ((out, x), row) in nodes.zip(field.values[first * r..].chunks_exact(r)) {
                *out = add(*out, turned(*x, row));
            }
        }),
        Some(nodes) => {
            let moved = parallel::collect(nodes.len(), |at| {
                turned(
                    state.nodes[nodes[at] as usize],
                    &field.values[at * r..][..r],
                )
            });
            for (&node, moved) in nodes.iter().zip(moved) {
                out[node as usize] = add(out[node as usize], moved);
            }
        }
    }
}

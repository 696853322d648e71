//! The layers evaluated at every node of one mesh, corrected so that the surface is exact.

use super::layer::{Kind, Layer};
use crate::geometry::vector::{Vector, add};
use crate::progress::Progress;
use crate::rbf::correct::{Correction, REACH};
use crate::rbf::field::Field;
use crate::rbf::select::Selection;
use rayon::prelude::*;

/// Nodes that one task moves.
const BLOCK: usize = 4096;

/// The mesh that is deformed: the reference mesh, or what a substep left.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// Positions of all nodes.
    pub nodes: &'a [Vector],
    /// The nodes that deform, ascending; `None` for all.
    pub deforming: Option<&'a [u32]>,
    /// Positions of the surface points.
    pub surface: &'a [Vector],
    /// Facets between them.
    pub facets: &'a [[u32; 3]],
}

/// Base points of a layer, with the largest error that the correction has to carry.
#[derive(Debug, Clone, Copy)]
pub struct Chosen<'a> {
    /// Base points, interpolant and residuals.
    pub selection: &'a Selection,
    /// Largest displacement error over the steps that are meant.
    pub error: f64,
}

/// A place where two surfaces come closer than the correction reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Narrow {
    /// Surface point, by its position.
    pub point: usize,
    /// Width of the gap, in mesh units.
    pub width: f64,
    /// What the correction would have reached.
    pub reach: f64,
}

/// Fields of all layers.
#[derive(Debug, Clone)]
pub struct Fields {
    fields: Vec<Field>,
    /// The narrowest gap between two surfaces within twice the reach of the correction.
    pub narrow: Option<Narrow>,
}

impl Fields {
    /// Evaluates every layer at the nodes that deform; with `correct` the surface is made exact.
    pub fn new(
        frame: Frame<'_>,
        layers: &[Layer],
        chosen: &[Chosen<'_>],
        correct: bool,
        progress: &dyn Progress,
    ) -> Self {
        let report = |n: usize| progress.advance(n as u64);
        let mut narrow: Option<Narrow> = None;
        let fields = layers
            .iter()
            .zip(chosen)
            .map(|(layer, chosen)| {
                let deforming = frame.deforming.map(<[u32]>::to_vec);
                let interpolant = &chosen.selection.interpolant;
                let mut field = Field::evaluate(interpolant, frame.nodes, deforming, &report);
                if correct && layer.modes.n_modes > 0 {
                    let found = add_correction(frame, layer, chosen, &mut field);
                    narrow = narrow
                        .into_iter()
                        .chain(found)
                        .min_by(|a, b| a.width.total_cmp(&b.width));
                }
                field
            })
            .collect();
        Self { fields, narrow }
    }

    /// Writes the positions at a step of the layers to `out`.
    pub fn displace(&self, layers: &[Layer], step: usize, frame: Frame<'_>, out: &mut [Vector]) {
        let translation = layers
            .iter()
            .zip(&self.fields)
            .find(|(layer, _)| layer.kind == Kind::Displacement);
        match translation {
            Some((layer, field)) => field.displace(layer.modes.at_step(step), frame.nodes, out),
            None => out.copy_from_slice(frame.nodes),
        }
        for (layer, field) in layers.iter().zip(&self.fields) {
            if layer.kind != Kind::Displacement && layer.modes.n_modes > 0 {
                rotate(layer, field, step, frame, out);
            }
        }
    }
}

fn add_correction(
    frame: Frame<'_>,
    layer: &Layer,
    chosen: &Chosen<'_>,
    field: &mut Field,
) -> Option<Narrow> {
    let correction = Correction::new(
        frame.surface,
        frame.facets,
        &chosen.selection.residuals,
        layer.modes.n_modes,
        chosen.error,
    );
    correction.add_to(field, frame.nodes);
    let gap = correction.narrowest_gap()?;
    Some(Narrow {
        point: gap.node,
        width: gap.width,
        reach: REACH * chosen.error,
    })
}

/// Adds what the rotations of a layer do at a step.
fn rotate(layer: &Layer, field: &Field, step: usize, frame: Frame<'_>, out: &mut [Vector]) {
    let r = field.n_modes;
    let turned = |x: Vector, row: &[f64]| layer.displacement(x, row, step);
    match &field.nodes {
        None => out
            .par_chunks_mut(BLOCK)
            .zip(frame.nodes.par_chunks(BLOCK))
            .zip(field.values.par_chunks(BLOCK * r))
            .for_each(|((out, nodes), values)| {
                for ((out, x), row) in out.iter_mut().zip(nodes).zip(values.chunks_exact(r)) {
                    *out = add(*out, turned(*x, row));
                }
            }),
        Some(nodes) => {
            let moved: Vec<Vector> = nodes
                .par_iter()
                .zip(field.values.par_chunks(r))
                .map(|(&node, row)| turned(frame.nodes[node as usize], row))
                .collect();
            for (&node, moved) in nodes.iter().zip(moved) {
                out[node as usize] = add(out[node as usize], moved);
            }
        }
    }
}

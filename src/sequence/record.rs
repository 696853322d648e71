//! run.json: what a run was given, what it did and how it ended.

use super::course::course;
use super::plan::Plan;
use crate::error::{Error, Result};
use crate::formats::save_text;
use crate::rbf::select::Selection;
use serde_json::{Value, json};
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Bytes that are read at once.
const PIECE: usize = 4 << 20;

/// The record of a run; written at its start and completed at its end.
pub struct Record {
    path: PathBuf,
    content: Value,
}

/// Seconds of each stage of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Timings {
    /// Choosing base points.
    pub selection: f64,
    /// Evaluating the modes at the nodes, and the correction.
    pub modes: f64,
    /// Node positions and quality, all steps.
    pub steps: f64,
    /// Writing meshes, all steps; overlaps with the next step's positions.
    pub writing: f64,
    /// The whole run.
    pub total: f64,
}

/// A clock that gives seconds.
pub struct Clock(Instant);

impl Clock {
    /// Starts now.
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

impl Record {
    /// The record of a run of `plan`, not yet written.
    pub fn new(path: PathBuf, plan: &Plan, mesh: &Path, schedule: &Path) -> Result<Self> {
        let mut inputs = vec![input(mesh)?, input(schedule)?];
        for file in plan.schedule.files() {
            inputs.push(input(&file)?);
        }
        let content = json!({
            "version": 1,
            "program": concat!("azimesh ", env!("CARGO_PKG_VERSION")),
            "outcome": "running",
            "inputs": inputs,
            "options": {
                "kernel": plan.basis.kernel.name(),
                "support_radius": plan.basis.radius,
                "tolerance": plan.tolerance,
                "max_points": plan.schedule.selection.max_points,
                "correction": plan.schedule.selection.correction,
                "format": plan.schedule.output.format,
            },
            "chosen": plan.choices,
            "nodes": plan.reference.len(),
            "cells": plan.mesh.cells.len(),
            "surface_points": plan.surface.nodes.len(),
            "coincident_surface_nodes": plan.surface.n_coincident,
            "steps": plan.motion.steps.len(),
            "modes": plan.n_modes(),
            "mode_truncation": plan.truncation(),
            "motion": course(plan),
        });
        Ok(Self { path, content })
    }

    /// Adds a value.
    pub fn set(&mut self, key: &str, value: Value) {
        self.content[key] = value;
    }

    /// Adds the timings.
    pub fn timings(&mut self, t: &Timings) {
        self.content["seconds"] = json!({
            "selection": t.selection,
            "modes": t.modes,
            "steps": t.steps,
            "writing": t.writing,
            "total": t.total,
        });
    }

    /// Writes the record as it stands.
    pub fn save(&self) -> Result<()> {
        save_text(&format!("{:#}\n", self.content), &self.path)
    }
}

fn input(path: &Path) -> Result<Value> {
    if path.as_os_str() == "-" {
        return Ok(json!({ "file": "-" }));
    }
    let hash = hash_of(path).map_err(|error| Error::io(path, &error))?;
    Ok(json!({
        "file": path.display().to_string(),
        "blake3": hash.to_string(),
    }))
}

/// The hash of a file, read piece by piece: a mapped file would count as memory of the run.
fn hash_of(path: &Path) -> std::io::Result<blake3::Hash> {
    let mut file = File::open(path)?;
    let mut hasher = blake3::Hasher::new();
    let mut piece = Vec::with_capacity(PIECE);
    loop {
        piece.clear();
        if file.by_ref().take(PIECE as u64).read_to_end(&mut piece)? == 0 {
            return Ok(hasher.finalize());
        }
        hasher.update_rayon(&piece);
    }
}

/// What the selections of a stretch came to. `history` holds pairs of base points and the largest
/// error over all nodes, a pair a sweep; `residuals` the error of each base point when it was chosen.
pub(super) fn selection_record(
    plan: &Plan,
    stretch: &Range<usize>,
    selections: &[Selection],
) -> Value {
    let layers = plan.layers.iter().zip(selections);
    let layers = layers.map(|(layer, selection)| {
        let history = selection.history.iter();
        json!({
            "of": layer.name(),
            "base_points": selection.base.len(),
            "tolerance": layer.tolerance,
            "error": selection.error,
            "measured": selection.measured,
            "skipped": selection.skipped,
            "history": history.map(|(n, error)| json!([n, error])).collect::<Vec<_>>(),
            "residuals": selection.picked,
        })
    });
    json!({
        "first_step": stretch.start,
        "steps": stretch.len(),
        "layers": layers.collect::<Vec<_>>(),
    })
}

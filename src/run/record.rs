//! run.json: what a run was given, what it did and how it ended.

use super::finished::Finished;
use super::names::Names;
use super::run::Request;
use crate::deform::Plan;
use crate::error::{Error, Result};
use crate::formats::{Commit, Precision, check_file, check_no_device, hash_of_folder, save_text};
use crate::preflight::body_motion;
use crate::rbf::select::Selection;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Bytes that are read at once.
const PIECE: usize = 4 << 20;

/// The record of a run; written at its start and completed at its end.
pub struct Record {
    path: PathBuf,
    content: Value,
    commit: Commit,
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

impl Timings {
    /// Those that a record holds; zero where it holds none.
    pub(super) fn of(record: &Value) -> Self {
        let seconds = |stage: &str| record["seconds"][stage].as_f64().unwrap_or(0.0);
        Self {
            selection: seconds("selection"),
            modes: seconds("modes"),
            steps: seconds("steps"),
            writing: seconds("writing"),
            total: seconds("total"),
        }
    }

    /// Of two runs together.
    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            selection: self.selection + other.selection,
            modes: self.modes + other.modes,
            steps: self.steps + other.steps,
            writing: self.writing + other.writing,
            total: self.total + other.total,
        }
    }
}

impl Record {
    /// The record of a run of `plan`, not yet written.
    pub fn new(names: &Names, plan: &Plan, request: &Request) -> Result<Self> {
        let mut inputs = vec![
            input("mesh", &request.mesh)?,
            input("schedule", &plan.schedule.path)?,
        ];
        for file in plan.schedule.files() {
            inputs.push(input("file", &file)?);
        }
        if let Some(base) = &request.base {
            inputs.push(input("base", base)?);
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
                "precision": match plan.schedule.output.precision {
                    Precision::F64 => "f64",
                    Precision::F32 => "f32",
                },
                "tag_array": request.tag_array,
            },
            "chosen": plan.choices,
            "dimension": plan.mesh.dimension(),
            "nodes": plan.reference.len(),
            "cells": plan.mesh.cells.len(),
            "surface_points": plan.surface.nodes.len(),
            "coincident_surface_nodes": plan.surface.n_coincident,
            "steps": plan.motion.steps.len(),
            "modes": plan.n_modes(),
            "mode_truncation": plan.truncation(),
            "motion": body_motion(plan),
        });
        Ok(Self::of(names, content))
    }

    /// A record that was read.
    pub fn of(names: &Names, content: Value) -> Self {
        Self {
            path: names.record(),
            content,
            commit: names.commit,
        }
    }

    /// Its content.
    pub fn content(&self) -> &Value {
        &self.content
    }

    /// Adds a value.
    pub fn set(&mut self, key: &str, value: Value) {
        self.content[key] = value;
    }

    /// Adds what the run came to; `error` is what ended it. Its seconds are added to those that are
    /// there.
    pub fn close(&mut self, finished: &Finished, error: Option<&Error>) {
        let outcome = match (error, finished.passed_over.len()) {
            (Some(error), _) => error.to_string(),
            (None, 0) => "complete".to_owned(),
            (None, n) => format!("complete but for {n} steps"),
        };
        self.set("outcome", json!(outcome));
        self.set("steps_written", json!(finished.n_steps));
        self.set("inverted_steps", json!(finished.inverted_steps));
        self.set("max_surface_error", json!(finished.surface_error));
        self.set("passed_over", json!(finished.passed_over));
        self.set("warnings", json!(finished.warnings));
        self.set("failures", json!(finished.failures));
        self.set_timings(self.timings().plus(finished.timings));
    }

    /// Where the time went, in all runs so far.
    pub fn timings(&self) -> Timings {
        Timings::of(&self.content)
    }

    /// Says where the time went.
    pub fn set_timings(&mut self, t: Timings) {
        self.content["seconds"] = json!({
            "selection": t.selection,
            "modes": t.modes,
            "steps": t.steps,
            "writing": t.writing,
            "total": t.total,
        });
    }

    /// Leaves a value out.
    pub fn remove(&mut self, key: &str) {
        if let Some(object) = self.content.as_object_mut() {
            object.shift_remove(key);
        }
    }

    /// Writes the record as it stands.
    pub fn save(&self) -> Result<()> {
        save_text(&format!("{:#}\n", self.content), &self.path, self.commit)
    }
}

/// An input and its hash; what came from a pipe is gone and has none.
fn input(what: &str, path: &Path) -> Result<Value> {
    let is_pipe = |found: std::fs::Metadata| !found.is_file() && !found.is_dir();
    if path.as_os_str() == "-" || path.metadata().is_ok_and(is_pipe) {
        return Ok(json!({ "what": what, "file": path.display().to_string() }));
    }
    let hash = hash_of(path).map_err(|error| Error::io(path, &error))?;
    Ok(json!({
        "what": what,
        "file": path.display().to_string(),
        "blake3": hash.to_string(),
    }))
}

/// A record on disk; `None` where it is not whole, as after a power cut: empty, cut, or no record.
pub(super) fn read(path: &Path) -> Result<Option<Value>> {
    let text = check_file(path).and_then(|()| std::fs::read(path));
    let text = text.map_err(|error| Error::io(path, &error))?;
    let read: Option<Value> = serde_json::from_slice(&text).ok();
    Ok(read.filter(|record| record["inputs"].is_array() && record["options"].is_object()))
}

/// The hash of a file, read piece by piece: a mapped file would count as memory of the run; of a folder, that of
/// its files.
pub(super) fn hash_of(path: &Path) -> std::io::Result<blake3::Hash> {
    match path.is_dir() {
        true => hash_of_folder(path, hash_of),
        false => hash_of_range(path, 0..u64::MAX),
    }
}

/// The hash of some bytes of a file.
pub(super) fn hash_of_range(path: &Path, bytes: Range<u64>) -> std::io::Result<blake3::Hash> {
    check_no_device(path)?;
    let mut file = File::open(path)?;
    file.seek(SeekFrom::Start(bytes.start))?;
    let mut file = file.take(bytes.end.saturating_sub(bytes.start));
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

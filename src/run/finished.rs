//! The result of a run: a summary of its rows of steps.csv, and the time of each stage.

use super::names::{Names, bytes_of};
use crate::record::Criterion;
use crate::record::{Row, Rows, SelectionRecord, Timings, WorstStep};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::numbers::named_step;
use azimesh_core::{Note, note};
use std::collections::BTreeMap;

/// The result of a run.
#[derive(Debug, Default)]
pub struct Finished {
    /// The end of the run, for run.json.
    pub outcome: String,
    /// The failed check that ended the run before its last step.
    pub ended_by: Option<Error>,
    /// Number of finished steps, including steps of earlier runs.
    pub n_steps: usize,
    /// Number of steps finished by an earlier run.
    pub n_kept: usize,
    /// Number of base points, the largest at any step.
    pub n_base: usize,
    /// Largest displacement error before the correction, in mesh units.
    pub selection_error: f64,
    /// Largest distance of a written surface node from its prescribed position.
    pub surface_error: f64,
    /// Number of steps with inverted cells; `None` if no cell was evaluated.
    pub inverted_steps: Option<usize>,
    /// Most inverted cells in one step; `None` if no cell was evaluated.
    pub max_inverted: Option<usize>,
    /// Smallest scaled Jacobian at any step.
    pub min_scaled_jacobian: Option<f64>,
    /// The step with it.
    pub worst_step: Option<WorstStep>,
    /// Steps with inverted cells; they are among the warnings as well.
    pub inverted: Vec<Note>,
    /// Conditions that failed.
    pub failures: Vec<Note>,
    /// Steps that were skipped, with the reason.
    pub skipped: Vec<Note>,
    /// Notes for the user.
    pub warnings: Vec<Note>,
    /// Bytes of one mesh file, the largest.
    pub mesh_bytes: u64,
    /// The time of each stage.
    pub timings: Timings,
}

impl Finished {
    /// Checks if the result has failures.
    pub fn is_failed(&self) -> bool {
        self.inverted_steps.is_some_and(|n| n > 0)
            || !self.failures.is_empty()
            || !self.skipped.is_empty()
    }

    /// Adds the data of the rows. `first_inverted` holds the first inverted cell of steps if it is known; without
    /// `has_azimuth` notes name a step by its time.
    pub(super) fn take_rows(
        &mut self,
        names: &Names,
        rows: &Rows,
        first_inverted: &BTreeMap<usize, usize>,
        fail_on: &[Criterion],
        has_azimuth: bool,
    ) -> Result<()> {
        self.n_steps = rows.len();
        for (step, row) in rows {
            self.take_row(row);
            if row.inverted.is_some_and(|n| n > 0) {
                let note = inverted(row, has_azimuth, first_inverted.get(step).copied());
                self.inverted.push(note.clone());
                self.warnings.push(note);
            }
        }
        for criterion in fail_on {
            let of_row = |(step, row): (&usize, &Row)| {
                let held = criterion.met_by(&row.numbers())?;
                Ok(held.map(|value| criterion.note(Some(*step), value)))
            };
            let all = rows.iter().map(of_row).collect::<Result<Vec<_>>>()?;
            let mut held: Vec<Note> = all.into_iter().flatten().collect();
            held.sort_by(|a, b| {
                let [a, b] = [a, b].map(|note| note.get("value").as_f64().unwrap_or(f64::NAN));
                criterion.worst_first(a, b)
            });
            self.failures.extend(held);
        }
        let sizes = rows.values().map(|row| bytes_of(&names.path(&row.file)));
        self.mesh_bytes = sizes.max().unwrap_or(0);
        Ok(())
    }

    /// Adds the position of the worst cell, if it belongs to the worst step.
    pub(super) fn take_place(&mut self, known: &WorstStep) {
        if let Some(worst) = &mut self.worst_step
            && worst.step == known.step
        {
            worst.clone_from(known);
        }
    }

    /// Adds results of base points that led to no step.
    pub(super) fn take_selections(&mut self, selections: &[SelectionRecord]) {
        for layer in selections.iter().flat_map(|selection| &selection.layers) {
            self.n_base = self.n_base.max(layer.base_points);
            if layer.of == "nodes" {
                let error = layer.measured.unwrap_or(f64::INFINITY);
                self.selection_error = self.selection_error.max(error);
            }
        }
    }

    fn take_row(&mut self, row: &Row) {
        self.n_base = self.n_base.max(row.base_points);
        self.selection_error = self.selection_error.max(row.selection_error);
        self.surface_error = self.surface_error.max(row.max_surface_error);
        if let Some(inverted) = row.inverted {
            let (n, most) = (self.inverted_steps, self.max_inverted);
            self.inverted_steps = Some(n.unwrap_or(0) + usize::from(inverted > 0));
            self.max_inverted = Some(most.unwrap_or(0).max(inverted));
        }
        if let Some(jacobian) = row.min_scaled_jacobian {
            let least = self.min_scaled_jacobian.unwrap_or(f64::INFINITY);
            self.min_scaled_jacobian = Some(least.min(jacobian));
            if jacobian < least {
                self.worst_step = Some(WorstStep {
                    step: row.step,
                    azimuth_deg: row.azimuth_deg,
                    time_s: row.time_s,
                    scaled_jacobian: jacobian,
                    cell: None,
                    position: None,
                    nearest_tag: None,
                    distance: None,
                });
            }
        }
    }
}

/// Returns the note on the inverted cells of a step.
pub(super) fn inverted(row: &Row, has_azimuth: bool, first: Option<usize>) -> Note {
    let azimuth_deg = row.azimuth_deg.filter(|_| has_azimuth);
    let n = row.inverted.unwrap_or(0);
    let note = note!(
        "inverted",
        "{} has {}{}",
        named_step(row.step, azimuth_deg, row.time_s),
        counted(n, "inverted cell"),
        first.map_or(String::new(), |cell| format!(", the first is cell {cell}"))
    );
    note.with("step", row.step).with("inverted", n)
}

//! What a run came to: everything that its rows of steps.csv tell, and where the time went.

use super::names::Names;
use crate::error::Result;
use crate::quality::Criterion;
use crate::record::{Row, Rows, Timings};
use std::collections::BTreeMap;

/// What a run came to.
#[derive(Debug, Clone, Default)]
pub struct Finished {
    /// Steps that are finished, those of earlier runs included.
    pub n_steps: usize,
    /// Steps that an earlier run had finished.
    pub n_kept: usize,
    /// Base points used, the most at any step.
    pub n_base: usize,
    /// Largest displacement error before the correction, in mesh units.
    pub selection_error: f64,
    /// Largest distance of a written surface node from its place.
    pub surface_error: f64,
    /// Steps with inverted cells; `None` where no cell was judged.
    pub inverted_steps: Option<usize>,
    /// Most inverted cells in one step; `None` where no cell was judged.
    pub most_inverted: Option<usize>,
    /// Smallest scaled Jacobian at any step.
    pub min_scaled_jacobian: Option<f64>,
    /// Sentences about steps with inverted cells; they are among the warnings as well.
    pub inverted: Vec<String>,
    /// Sentences about conditions that failed.
    pub failures: Vec<String>,
    /// Sentences about steps that were passed over, with the reason.
    pub passed_over: Vec<String>,
    /// Sentences about what the user should know.
    pub warnings: Vec<String>,
    /// Bytes of one mesh file, the largest.
    pub mesh_bytes: u64,
    /// Where the time went.
    pub timings: Timings,
}

impl Finished {
    /// Whether there is something to complain about.
    pub fn is_failed(&self) -> bool {
        self.inverted_steps.is_some_and(|n| n > 0)
            || !self.failures.is_empty()
            || !self.passed_over.is_empty()
    }

    /// Takes over what the rows tell. `first_inverted` holds the first inverted cell of steps where it
    /// is known.
    pub(super) fn take_rows(
        &mut self,
        names: &Names,
        rows: &Rows,
        first_inverted: &BTreeMap<usize, usize>,
        fail_on: &[Criterion],
    ) -> Result<()> {
        self.n_steps = rows.len();
        for (step, row) in rows {
            self.take_row(row);
            if row.inverted.is_some_and(|n| n > 0) {
                let sentence = inverted(row, first_inverted.get(step).copied());
                self.inverted.push(sentence.clone());
                self.warnings.push(sentence);
            }
            let values = row.numbers();
            for criterion in fail_on {
                if let Some(value) = criterion.met_by(&values)? {
                    let sentence = format!("step {step}: {}", criterion.sentence("", value));
                    self.failures.push(sentence);
                }
            }
        }
        let sizes = rows.values().filter_map(|row| {
            let found = std::fs::metadata(names.path(&row.file));
            found.ok().map(|found| found.len())
        });
        self.mesh_bytes = sizes.max().unwrap_or(0);
        Ok(())
    }

    fn take_row(&mut self, row: &Row) {
        self.n_base = self.n_base.max(row.base_points);
        self.selection_error = self.selection_error.max(row.selection_error);
        self.surface_error = self.surface_error.max(row.max_surface_error);
        if let Some(inverted) = row.inverted {
            let (n, most) = (self.inverted_steps, self.most_inverted);
            self.inverted_steps = Some(n.unwrap_or(0) + usize::from(inverted > 0));
            self.most_inverted = Some(most.unwrap_or(0).max(inverted));
        }
        if let Some(jacobian) = row.min_scaled_jacobian {
            let least = self.min_scaled_jacobian.unwrap_or(f64::INFINITY);
            self.min_scaled_jacobian = Some(least.min(jacobian));
        }
    }
}

/// A sentence about the inverted cells of a step.
pub(super) fn inverted(row: &Row, first: Option<usize>) -> String {
    let first = first.map_or(String::new(), |cell| format!(", cell {cell} first"));
    format!(
        "step {} (azimuth {} degrees) has {} inverted cells{first}",
        row.step,
        row.azimuth_deg,
        row.inverted.unwrap_or(0),
    )
}

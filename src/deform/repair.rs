//! `on_inverted = "substeps"`: a step with inverted cells is repeated in 2, 4 and 8 substeps, from
//! the same base points. With `"repair"` the cells that are left are untangled after that.

use super::plan::Plan;
use crate::error::{ErrorKind, Result};
use crate::geometry::vector::Vector;
use crate::motion::{OnInverted, Step};
use crate::quality::Summary;
use crate::record::{PatchRecord, RepairRecord};
use crate::repair::Repaired;

/// Substeps that are tried, one after the other.
const TRIES: [usize; 3] = [2, 4, 8];

/// The result of repeating a step with inverted cells.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Repair {
    /// Substeps of the result; none where they did not help.
    pub substeps: Option<usize>,
    /// Inverted cells without them.
    before: usize,
    /// Inverted cells with them.
    after: usize,
    /// What was untangled then; none where nothing was.
    untangled: Option<Untangled>,
}

/// The cells of a step that were untangled.
#[derive(Debug, Clone, PartialEq)]
struct Untangled {
    repaired: Repaired,
    /// Inverted and unproven cells after it.
    left: usize,
}

/// Whether a step is to be repaired.
pub(super) fn wants_repair(plan: &Plan, summary: &Summary) -> bool {
    match plan.schedule.output.on_inverted {
        OnInverted::Substeps => summary.inverted > 0,
        OnInverted::Repair => summary.inverted + summary.unproven > 0,
        OnInverted::Warn | OnInverted::Stop => false,
    }
}

/// Tries substeps until no cell is inverted; `points`, `summary` and `error` become those of the try
/// with the fewest inverted cells, of the first of these where several have as few. `attempt` takes the
/// step in so many parts.
pub(super) fn repair(
    plan: &Plan,
    points: &mut [Vector],
    summary: &mut Summary,
    error: &mut f64,
    attempt: impl Fn(usize, &mut [Vector]) -> Result<(f64, Summary)>,
) -> Result<Repair> {
    let before = summary.inverted;
    let mut substeps = None;
    let mut trial = points.to_vec();
    for n in TRIES {
        if n <= plan.schedule.rbf.substeps || summary.inverted == 0 {
            continue;
        }
        let (found_error, found) = match attempt(n, &mut trial) {
            Ok(found) => found,
            Err(error) if error.kind == ErrorKind::System => return Err(error),
            // A part that cannot be interpolated repairs nothing.
            Err(_) => continue,
        };
        if found.inverted < summary.inverted {
            points.copy_from_slice(&trial);
            (*error, *summary, substeps) = (found_error, found, Some(n));
        }
    }
    Ok(Repair {
        substeps,
        before,
        after: summary.inverted,
        untangled: None,
    })
}

impl Repair {
    /// Takes in what was untangled after the substeps; `summary` is of the result.
    pub(super) fn untangled(&mut self, repaired: Repaired, summary: &Summary) {
        self.untangled = Some(Untangled {
            repaired,
            left: summary.inverted + summary.unproven,
        });
    }

    /// Cells that were made valid by moving nodes near them.
    pub(crate) fn n_untangled(&self) -> usize {
        let untangled = self.untangled.as_ref();
        untangled.map_or(0, |untangled| untangled.repaired.n_repaired())
    }

    /// What run.json holds.
    pub fn record(&self, step: &Step) -> RepairRecord {
        let mut record = RepairRecord {
            step: step.index,
            substeps: self.substeps,
            inverted_before: self.before,
            inverted: self.after,
            patches: self.untangled.as_ref().map(Untangled::records),
            unrepaired: self.untangled.as_ref().map(|untangled| untangled.left),
            sentence: String::new(),
        };
        record.sentence = record.note(step.azimuth_deg(), step.time_s()).to_string();
        record
    }
}

impl Untangled {
    fn records(&self) -> Vec<PatchRecord> {
        let patches = self.repaired.patches.iter();
        patches
            .map(|log| PatchRecord {
                first_cell: log.first_cell,
                invalid_before: log.invalid_before,
                invalid: log.invalid,
                cells: log.n_cells,
                nodes: log.n_nodes,
                rings: log.rings,
                min_jacobian_before: log.least_before,
                min_jacobian: log.least,
                largest_move: log.largest_move,
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Schedule, Steps};

    #[test]
    fn a_repaired_step_without_an_azimuth_is_named_by_its_time() {
        let steps = Schedule::new(Steps::times_s([0.25])).steps();
        let repair = Repair {
            substeps: Some(2),
            before: 3,
            after: 0,
            untangled: None,
        };
        let record = repair.record(&steps.expect("they are good")[0]);
        assert_eq!(
            record.sentence,
            "step 0 (0.25 s) had 3 inverted cells: 2 substeps leave none"
        );
    }
}

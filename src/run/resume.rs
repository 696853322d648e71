//! A valid earlier run in the folder: its inputs equal this run's, and its files have the hashes in its table.

use super::compatibility::{Pair, difference};
use super::names::{Names, existing_outputs};
use super::outputs;
use super::record;
use super::surface::SurfaceFiles;
use super::table;
use crate::record::{Criterion, Diagnostic, RepairRecord, Row, Rows, RunRecord};
use azimesh_core::error::{Error, Result, counted, option};
use azimesh_core::numbers::{in_digits, named_step, with_verb};
use azimesh_core::{Note, note};
use azimesh_deform::{Deformation, Plan};
use azimesh_io::formats::Format;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;

/// Largest number of notes of one kind that are listed one by one.
const MOST_NOTES: usize = 10;

/// An earlier run.
#[derive(Debug, Default)]
pub(super) struct Earlier {
    /// Rows of the steps that need not be computed again; if one file holds all steps, rows to be verified in it.
    pub rows: Rows,
    /// Its record; empty if it is lost, or if there is no earlier run.
    pub record: RunRecord,
    /// Steps with inverted cells that it repaired.
    pub repairs: BTreeMap<usize, RepairRecord>,
    /// Number of times that it was resumed, including this one.
    n_resumed: u64,
    /// Notes on steps that are computed again.
    pub notes: Vec<Note>,
    /// True if its record is lost: a row counts only if its step gives the same bytes again.
    pub is_unverified: bool,
    /// True if steps were added to the schedule, now or before.
    pub adds_steps: bool,
    /// Number of steps that its schedule had; `None` if its record is lost.
    pub n_steps: Option<usize>,
    /// The steps of its table, with files or without.
    pub listed: BTreeSet<usize>,
}

impl Earlier {
    /// Finds the run to be resumed; empty if the folder holds none.
    ///
    /// # Errors
    /// If another mesh, schedule or program was used, or if it has no record.
    pub fn find(
        deformation: &Deformation,
        names: &Names,
        format: &'static Format,
        now: &RunRecord,
    ) -> Result<Self> {
        let path = names.record();
        let mut earlier = match record::read(&path)? {
            Some(then) => {
                let n_steps = then.steps;
                let then = with_added(now, then, names)?;
                let repairs = then.repairs.iter().flatten().cloned();
                Self {
                    repairs: repairs.map(|repair| (repair.step, repair)).collect(),
                    n_resumed: then.resumed.unwrap_or(0) + 1,
                    adds_steps: !then.extended.is_empty(),
                    n_steps,
                    record: then,
                    ..Self::default()
                }
            }
            None if existing_outputs(names).is_empty() => return Ok(Self::default()),
            None => Self::without_record(names)?,
        };
        let has_record = earlier.record.is_whole();
        earlier.take_rows(deformation.plan(), names)?;
        if earlier.adds_steps {
            earlier
                .check_motion(deformation.plan())
                .map_err(|error| error.file(&path))?;
        }
        outputs::refuse_foreign(deformation.plan(), names, &earlier)?;
        if !names.is_in_one {
            earlier.check_files(deformation, names, format, &now.companions);
        }
        earlier.is_unverified = !has_record && !earlier.rows.is_empty();
        Ok(earlier)
    }

    /// Returns a run whose record was lost in a power cut: a file of it exists, or its table.
    fn without_record(names: &Names) -> Result<Self> {
        let path = names.record();
        let record = path.file_name().unwrap_or_default().display();
        let has_parts = names.has_parts();
        if !path.exists() && !names.table().exists() || has_parts {
            let hint = " (parts are resumed with their own --steps; `azimesh finish` joins them, also again)";
            let hint = if has_parts { hint } else { "" };
            return Err(Error::input(format!(
                "holds files of an earlier run but no whole {record}, so nothing can be verified; --force starts a new run{hint}"
            ))
            .file(&names.folder));
        }
        let note = note!(
            "lost_record",
            "{record} is {}: finished steps are computed again, and kept where that gives the same bytes; the {} \
             conditions of the earlier run are lost",
            if path.exists() { "damaged" } else { "missing" },
            option("fail-on")
        );
        Ok(Self {
            n_resumed: 1,
            notes: vec![note],
            ..Self::default()
        })
    }

    /// Takes the rows of this run's steps from the table.
    ///
    /// # Errors
    /// If an existing mesh would now have another name and be written again; if a step was at another azimuth or time.
    fn take_rows(&mut self, plan: &Plan, names: &Names) -> Result<()> {
        let table = names.table();
        for (step, row) in table::of_run(names)? {
            if !names.steps().contains(&step) {
                continue;
            }
            self.listed.insert(step);
            let (name, now) = (names.mesh(step), &plan.motion.steps[step]);
            if row.file != name {
                if names.path(&row.file).exists() {
                    return Err(self.other_name(step, &row.file, &name).file(&table));
                }
            } else if (row.azimuth_deg, row.time_s) == (now.azimuth_deg(), now.time_s()) {
                self.rows.insert(step, row);
            } else {
                let then = named_step(step, row.azimuth_deg, row.time_s);
                return Err(Error::input(format!(
                    "this run cannot be resumed: it has {then}, which is {now} in the schedule now; steps can be added behind \
                     the last one only; --force starts a new run"
                ))
                .file(&table));
            }
        }
        Ok(())
    }

    fn other_name(&self, step: usize, old: &str, new: &str) -> Error {
        let way_out = "use another folder";
        Error::input(match self.record.inputs.first() {
            Some(mesh) => format!(
                "the mesh of this run was {}, and the files are named after it: step {step} is {old}, and would be {new} \
                 now. Give the mesh (or a link to it) that name again, or {way_out}",
                mesh.file
            ),
            None => format!(
                "step {step} of the earlier run is {old}, and would be {new} now: the mesh had another name, or the run \
                 another format. Use the same again, or {way_out}"
            ),
        })
    }

    /// Refuses added steps that change the motion of the finished ones: by the positions of the bodies without the added
    /// steps, and by the displacements in the table.
    fn check_motion(&self, plan: &Plan) -> Result<()> {
        let n_before = self.record.extended.last().copied().unwrap_or(0);
        let in_table = || {
            self.rows.iter().find_map(|(step, row)| {
                let off = (row.max_displacement - plan.largest_displacement(*step)).abs();
                (off > plan.round_off()).then(|| (plan.motion.steps[*step], off))
            })
        };
        match plan.changed_step(n_before).or_else(in_table) {
            None => Ok(()),
            Some((step, distance)) => Err(Error::input(format!(
                "this run cannot be resumed: the schedule with more steps moves {step} otherwise than the finished run, by {}; \
                 steps can be added only where the motion of the finished ones stays; --force starts a new run of all steps",
                in_digits(distance, 3)
            ))),
        }
    }

    /// Returns whether the repair of a step may have moved nodes.
    pub fn may_be_repaired(&self, step: usize) -> bool {
        !self.listed.contains(&step) || self.repairs.contains_key(&step)
    }

    /// Returns the steps that its base points serve, including the added ones.
    pub fn take_intervals(&mut self, intervals: &[Range<usize>]) {
        for selection in &mut self.record.selections {
            let mut intervals = intervals.iter();
            let own = intervals.find(|interval| interval.start == selection.first_step);
            selection.steps = own.map_or(selection.steps, Range::len);
        }
    }

    /// Adds the earlier run to the record of this one. Returns the conditions of this run: its own, or else the earlier
    /// ones.
    pub fn enter(&self, record: &mut RunRecord, own: &[Criterion]) -> Vec<Criterion> {
        let then = &self.record;
        let earlier = then.fail_on.iter().filter_map(|text| text.parse().ok());
        let conditions = match own {
            [] => earlier.collect(),
            own => own.to_vec(),
        };
        record.resumed = Some(self.n_resumed);
        record.steps_kept = Some(self.rows.len());
        record.base_files.clone_from(&then.base_files);
        record.selections.clone_from(&then.selections);
        record.extended.clone_from(&then.extended);
        record.fail_on = conditions.iter().map(Criterion::to_string).collect();
        record.seconds = Some(then.seconds.unwrap_or_default());
        record.parts.clone_from(&then.parts);
        record.repairs = self.all_repairs();
        conditions
    }

    /// Returns repairs in the order of their steps; `None` if there are none.
    pub fn all_repairs(&self) -> Option<Vec<RepairRecord>> {
        let repairs = self.repairs.values().cloned().collect();
        (!self.repairs.is_empty()).then_some(repairs)
    }

    /// Returns the warnings of its selections.
    pub fn selection_warnings(&self) -> impl Iterator<Item = Note> {
        let selections = self.record.selections.iter();
        let lists = selections.flat_map(|own| &own.diagnostics);
        lists.flatten().map(Diagnostic::note)
    }

    /// Leaves out steps whose file is missing or has changed.
    fn check_files(
        &mut self,
        deformation: &Deformation,
        names: &Names,
        format: &'static Format,
        companions: &BTreeMap<String, String>,
    ) {
        let progress = deformation.progress();
        progress.start("verifying", Some(self.rows.len() as u64));
        let surface = SurfaceFiles::of(deformation.plan()).ok().flatten();
        let mut wrong: Vec<Note> = Vec::new();
        self.rows.retain(|&step, row| {
            let has_surface = || {
                let mut surface = surface.iter();
                surface.all(|surface| surface.is_there(names, format, row))
            };
            let fault = match fault_of(names, row, companions) {
                None if !has_surface() => Some(no_companion()),
                fault => fault,
            };
            progress.advance(1);
            let is_good = fault.is_none();
            wrong.extend(fault.map(|fault| step_again(step, &row.file, &fault)));
            is_good
        });
        progress.finish();
        let steps = wrong.len().saturating_sub(MOST_NOTES);
        self.notes.extend(wrong.into_iter().take(MOST_NOTES));
        if steps > 0 {
            let steps = with_verb(steps, "more step", "is");
            self.notes
                .push(note!("more_again", "{steps} computed again"));
        }
    }
}

/// Adds a note on a finished step that is computed again because its file is wrong.
pub(super) fn step_again(step: usize, file: &str, fault: &str) -> Note {
    let note = note!(
        "step_again",
        "step {step} is computed again: {file} {fault}"
    );
    note.with("step", step).with("file", file)
}

fn no_companion() -> String {
    "lacks its companion file".to_owned()
}

/// Returns the fault of the file of a row, or of a file next to it.
fn fault_of(names: &Names, row: &Row, companions: &BTreeMap<String, String>) -> Option<String> {
    let path = names.path(&row.file);
    if !path.exists() {
        return Some("is missing".to_owned());
    }
    match names.has_hash(&path, &row.blake3) {
        Ok(true) => names.changed(companions, [row]).map(|_| no_companion()),
        Ok(false) => Some("does not have the hash in steps.csv".to_owned()),
        Err(error) => Some(format!("cannot be read ({error})")),
    }
}

/// Returns the record of an earlier run, to which the schedule may have added steps since.
///
/// # Errors
/// If it had other inputs.
fn with_added(now: &RunRecord, mut then: RunRecord, names: &Names) -> Result<RunRecord> {
    let path = &names.record();
    if names.is_part() {
        // Parts are joined by the hash of their schedule.
        (then.inputs.iter_mut()).for_each(|input| input.but_steps = None);
    }
    check_same(now, &then, path)?;
    let (n_now, n_then) = (now.steps.unwrap_or(0), then.steps.unwrap_or(0));
    if n_now < n_then {
        return Err(Error::input(format!(
            "this run cannot be resumed: it has {}, and the schedule {n_now} now; steps can be added, not taken away; --force \
             starts a new run",
            counted(n_then, "step")
        ))
        .file(path));
    }
    if n_now > n_then {
        then.extended.push(n_then);
    }
    Ok(then)
}

/// Refuses a run with other inputs.
fn check_same(now: &RunRecord, then: &RunRecord, path: &Path) -> Result<()> {
    match difference(Pair::Resumed, now, then) {
        None => Ok(()),
        Some(difference) => Err(Error::input(format!(
            "this run cannot be resumed: {difference}; --force starts a new run"
        ))
        .file(path)),
    }
}

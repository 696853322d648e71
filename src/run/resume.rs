//! What an earlier run left in the folder, as far as it holds: its inputs are those of this run, and
//! its files have the hashes that it noted.

use super::compatibility::difference;
use super::names::{Names, existing_outputs};
use super::parts;
use super::record::{self, merged};
use super::surface::SurfaceFiles;
use super::table;
use crate::record::Criterion;
use crate::record::{RepairRecord, Row, Rows, RunRecord, SelectionRecord, Timings};
use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::diagnostic::run::{FileFault, RunNote};
use azimesh_core::error::{Error, Result};
use azimesh_deform::{Deformation, Plan};
use azimesh_io::formats::{Format, read_file};
use azimesh_io::mesh::MeshView;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Notes of one sort that are given one by one.
const MOST_NOTES: usize = 10;

/// An earlier run.
#[derive(Debug, Default)]
pub(super) struct Earlier {
    /// Rows of the steps that need not be done again; where one file holds all steps, those that are
    /// to be verified in it.
    pub rows: Rows,
    /// Files of base points that it chose, and their hashes.
    pub bases: BTreeMap<String, String>,
    /// What it noted of each selection.
    selections: Vec<SelectionRecord>,
    /// Steps that it took in substeps, as it had inverted cells.
    pub repairs: BTreeMap<usize, RepairRecord>,
    /// Conditions that it was to fail by.
    fail_on: Vec<Criterion>,
    /// Where its time went.
    timings: Timings,
    /// How often it was resumed before.
    n_before: u64,
    /// What has to be done again.
    pub notes: Vec<Diagnostic>,
    /// Parts that were joined to it.
    parts: Option<Vec<String>>,
    /// Whether its record is lost: rows count then where the same step gives the same bytes.
    pub is_unverified: bool,
}

impl Earlier {
    /// The run that is to be resumed; empty where the folder holds none.
    ///
    /// # Errors
    /// Where another mesh, schedule or program was used, or it left no record of itself.
    pub fn find(
        deformation: &Deformation,
        names: &Names,
        format: &Format,
        now: &RunRecord,
    ) -> Result<Self> {
        let plan = deformation.plan();
        let path = names.record();
        let then = record::read(&path)?;
        let mut earlier = match &then {
            Some(then) => {
                check_same(now, then, &path)?;
                Self::of(then.clone())
            }
            None if existing_outputs(names).is_empty() => return Ok(Self::default()),
            None => Self::without_record(names)?,
        };
        earlier.rows = table::of_run(names)?;
        check_names(&earlier.rows, then.as_ref(), names)?;
        if then.is_none() {
            check_azimuths(&earlier.rows, plan, names)?;
        }
        earlier.check_rows(plan, names);
        if !names.is_in_one() {
            earlier.check_files(deformation, names, format)?;
        }
        earlier.is_unverified = then.is_none() && !earlier.rows.is_empty();
        Ok(earlier)
    }

    /// A run whose record a power cut has taken: a file of it is left, or its table.
    fn without_record(names: &Names) -> Result<Self> {
        let record = names.record();
        if !record.exists() && !names.table().exists() || has_parts(names) {
            return Err(no_record(names));
        }
        let name = record.file_name().unwrap_or_default();
        let note = RunNote::LostRecord {
            record: name.display().to_string(),
            is_damaged: record.exists(),
        };
        Ok(Self {
            n_before: 1,
            notes: vec![note.into()],
            ..Self::default()
        })
    }

    /// What a record tells.
    fn of(then: RunRecord) -> Self {
        let repairs = then.repairs.unwrap_or_default().into_iter();
        let fail_on = then.fail_on.iter();
        Self {
            bases: then.base_files,
            selections: then.selections,
            repairs: repairs.map(|repair| (repair.step, repair)).collect(),
            fail_on: fail_on.filter_map(|text| text.parse().ok()).collect(),
            timings: then.seconds.unwrap_or_default(),
            n_before: then.resumed.unwrap_or(0) + 1,
            parts: then.parts,
            ..Self::default()
        }
    }

    /// Writes what is known of the earlier run into the record of this one.
    pub fn note_in(&self, record: &mut RunRecord) {
        record.resumed = Some(self.n_before);
        record.steps_kept = Some(self.rows.len());
        record.base_files.clone_from(&self.bases);
        record.selections.clone_from(&self.selections);
        record.fail_on = self.fail_on.iter().map(Criterion::to_string).collect();
        record.seconds = Some(self.timings);
        record.parts.clone_from(&self.parts);
        record.repairs = self.all_repairs();
    }

    /// Repairs in the order of their steps; `None` where there are none.
    pub fn all_repairs(&self) -> Option<Vec<RepairRecord>> {
        let repairs = self.repairs.values().cloned().collect();
        (!self.repairs.is_empty()).then_some(repairs)
    }

    /// Conditions of the run that resumes this one: its own, or else those that this one had.
    pub fn take_conditions(&mut self, own: &[Criterion]) -> Vec<Criterion> {
        if !own.is_empty() {
            self.fail_on = own.to_vec();
        }
        self.fail_on.clone()
    }

    /// The selections of both runs by their first step; those of this one count.
    pub fn with_selections(&self, new: &[SelectionRecord]) -> Vec<SelectionRecord> {
        merged(&self.selections, new)
    }

    /// What its selections gave rise to.
    pub fn selection_warnings(&self) -> impl Iterator<Item = Diagnostic> {
        let lists = self.selections.iter().flat_map(|own| &own.warnings);
        lists.flatten().map(|text| {
            RunNote::Recorded {
                sentence: text.clone(),
            }
            .into()
        })
    }

    /// Leaves out rows that are none of this run's steps.
    fn check_rows(&mut self, plan: &Plan, names: &Names) {
        let steps = &plan.motion.steps;
        self.rows.retain(|&index, row| {
            names.steps().contains(&index)
                && row.file == names.mesh(index)
                && row.azimuth_deg == steps[index].azimuth_deg()
        });
    }

    /// Leaves out steps whose file is missing or another.
    fn check_files(
        &mut self,
        deformation: &Deformation,
        names: &Names,
        format: &Format,
    ) -> Result<()> {
        let (progress, mesh) = (deformation.progress(), deformation.view_to_write()?);
        progress.start("verifying", Some(self.rows.len() as u64));
        let surface = SurfaceFiles::of(deformation.plan()).ok().flatten();
        let mut wrong: Vec<Diagnostic> = Vec::new();
        self.rows.retain(|&step, row| {
            let fault = fault_of(&mesh, names, format, row);
            let is_there = |surface: &SurfaceFiles| surface.is_there(names, format, row);
            let lacks = || surface.as_ref().is_some_and(|surface| !is_there(surface));
            let fault = fault.or_else(|| lacks().then_some(FileFault::NoCompanion));
            progress.advance(1);
            let file = row.file.clone();
            let note = fault.map(|fault| RunNote::StepAgain { step, file, fault });
            let is_good = note.is_none();
            wrong.extend(note.map(Diagnostic::from));
            is_good
        });
        progress.finish();
        let steps = wrong.len().saturating_sub(MOST_NOTES);
        self.notes.extend(wrong.into_iter().take(MOST_NOTES));
        if steps > 0 {
            self.notes.push(RunNote::MoreAgain { steps }.into());
        }
        Ok(())
    }
}

/// What is wrong with the file of a row, or with what belongs beside it.
fn fault_of(mesh: &MeshView<'_>, names: &Names, format: &Format, row: &Row) -> Option<FileFault> {
    let path = names.path(&row.file);
    if !path.exists() {
        return Some(FileFault::Missing);
    }
    match names.has_hash(&path, &row.blake3) {
        Ok(true) => {}
        Ok(false) => return Some(FileFault::OtherHash("steps.csv")),
        Err(error) => return Some(FileFault::Unreadable(error.to_string())),
    }
    let companions = (format.companions)(mesh, &path);
    let differs =
        |(path, content): &(PathBuf, Vec<u8>)| read_file(path).ok().as_ref() != Some(content);
    companions
        .iter()
        .any(differs)
        .then_some(FileFault::NoCompanion)
}

/// Refuses a run with other inputs.
fn check_same(now: &RunRecord, then: &RunRecord, path: &Path) -> Result<()> {
    match difference(now, then) {
        None => Ok(()),
        Some(difference) => Err(Error::input(format!(
            "this run cannot be resumed: {}; --force starts a new run",
            difference.since()
        ))
        .file(path)),
    }
}

/// Refuses rows of meshes that are there and would have another name now: they would be written again
/// beside the ones that are there.
fn check_names(rows: &Rows, then: Option<&RunRecord>, names: &Names) -> Result<()> {
    let is_other = |(step, row): &(&usize, &Row)| {
        let file = &row.file;
        names.steps().contains(step) && *file != names.mesh(**step) && names.path(file).exists()
    };
    let Some((step, row)) = rows.iter().find(is_other) else {
        return Ok(());
    };
    let (old, new) = (&row.file, names.mesh(*step));
    let way_out = "use another folder";
    Err(Error::input(match then.and_then(|then| then.inputs.first()) {
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
    .file(&names.table()))
}

/// Refuses rows of a run whose record is lost that are of other steps than those of the schedule.
fn check_azimuths(rows: &Rows, plan: &Plan, names: &Names) -> Result<()> {
    let steps = &plan.motion.steps[names.steps()];
    let other = steps.iter().find_map(|step| {
        let row = rows.get(&step.index())?;
        let (then, now) = (row.azimuth_deg, step.azimuth_deg());
        let is_other = row.file == names.mesh(step.index()) && then != now;
        let shown =
            |azimuth: Option<f64>| azimuth.map_or("none".to_owned(), |azimuth| azimuth.to_string());
        is_other.then(|| (step.index(), shown(then), shown(now)))
    });
    match other {
        None => Ok(()),
        Some((step, then, now)) => Err(Error::input(format!(
            "this run cannot be resumed: step {step} was at azimuth {then}; now it is at {now}; --force starts a new run"
        ))
        .file(&names.table())),
    }
}

/// Whether there are parts in the folder of a whole sequence.
fn has_parts(names: &Names) -> bool {
    let is_part = |path: &PathBuf| parts::steps_of(path).is_some();
    !names.is_part() && existing_outputs(names).iter().any(is_part)
}

fn no_record(names: &Names) -> Error {
    let record = names.record();
    let record = record.file_name().unwrap_or_default().display();
    let hint = match has_parts(names) {
        false => "",
        true => {
            " (parts are resumed with their own --steps; `azimesh finish` joins them, also again)"
        }
    };
    Error::input(format!(
        "holds files of an earlier run but no whole {record}, so nothing can be verified; --force starts a new run{hint}"
    ))
    .file(&names.folder)
}

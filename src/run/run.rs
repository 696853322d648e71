//! The run: plan, base points once an interval, mode fields, then step after step; a step is written
//! while the next one is computed.

use super::base;
use super::finished::Finished;
use super::intervals::Intervals;
use super::lock::Lock;
use super::names::{self, Names, Part};
use super::parts;
use super::record::{Clock, RecordFile, sentences};
use super::resume::Earlier;
use super::step_loop::Pass;
use super::writer::Writer;
use crate::deform::{Deformation, Plan, missed};
use crate::diagnostic::Diagnostic;
use crate::diagnostic::run::RunNote;
use crate::error::Result;
use crate::formats::{self, Begin, Format, Notes};
use crate::motion::Step;
use crate::preflight::{self, Demand, before_work, check_disk};
use crate::quality::Criterion;
use crate::record::Rows;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;

/// What a run is asked for.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// The mesh file, for names and hashes.
    pub mesh: PathBuf,
    /// Where the files go.
    pub folder: PathBuf,
    /// Base points chosen before.
    pub base: Option<PathBuf>,
    /// The steps to write, counted from 0; all when left out.
    pub steps: Option<Range<usize>>,
    /// The cell array that the boundary tags were read from, where it was named.
    pub tag_array: Option<String>,
    /// Whether files of an earlier run are replaced.
    pub force: bool,
    /// Whether an earlier run is gone on with.
    pub resume: bool,
    /// Whether steps that cannot be written are passed over.
    pub keep_going: bool,
    /// Whether a disk without room for all steps is written to nevertheless.
    pub no_space_check: bool,
    /// Whether steps need not outlive a power cut.
    pub no_sync: bool,
    /// Conditions that fail the run.
    pub fail_on: Vec<Criterion>,
}

/// Writes a deformation: base points, mode fields, and one mesh a step in the request's folder.
///
/// # Errors
/// [`ErrorKind::Check`](crate::error::ErrorKind::Check) when the tolerance cannot be met (base points are saved, no mesh is written), and
/// where `on_inverted = "stop"` stops it; [`ErrorKind::Interrupted`](crate::error::ErrorKind::Interrupted) between two steps when `stop` was
/// asked to.
pub fn run(deformation: &Deformation, request: &Request) -> Result<Finished> {
    let clock = Clock::start();
    let plan = deformation.plan();
    let format = formats::by_name(&plan.schedule.output.format)?;
    let (mut warnings, mesh_bytes) = before_work(plan, format, &request.fail_on)?;
    warnings.extend(preflight::warnings(plan));
    if plan.without_boxes {
        warnings.push(RunNote::NoBoxes.into());
    }
    let n_steps = plan.motion.steps.len();
    let part = Part::new(request.steps.clone(), n_steps)?;
    let mut names = Names::new(&request.folder, &request.mesh, format, n_steps, part);
    names.commit.sync = !request.no_sync;
    let mut record = RecordFile::new(&names, plan, request)?;
    let base = request.base.as_deref();
    let loaded = base.map(|path| base::load(plan, path)).transpose()?;
    let lock = Lock::take(&names)?;
    warnings.extend(lock.warning.clone());
    if !request.force {
        parts::refuse_overlap(&names)?;
    }
    let mut earlier = match request.resume {
        true => Earlier::find(deformation, &names, format, &record.content)?,
        false => Earlier::default(),
    };
    if !request.resume && !request.force {
        names::refuse_existing(&names)?;
    }
    formats::clear_left(&names.folder);
    if !request.no_space_check {
        let steps = (names.steps().len(), earlier.rows.len());
        let demand = Demand::of(plan, format, steps, mesh_bytes);
        let freed = if request.force {
            names::bytes_of_existing(&names)
        } else {
            0
        };
        warnings.extend(check_disk(plan, &names.folder, &demand, freed)?);
    }
    if request.force {
        names::remove_existing(&names)?;
    }
    warnings.append(&mut earlier.notes);
    let fail_on = earlier.take_conditions(&request.fail_on);
    earlier.note_in(&mut record.content);
    let base_files = earlier.bases.clone();
    let mut intervals = Intervals::new(deformation, &names, loaded, base_files);
    let rows = earlier.rows.clone();
    let mut run = Run {
        deformation,
        plan,
        request,
        names: &names,
        format,
        fail_on,
        record,
        n_kept: rows.len(),
        rows,
        earlier,
        passed_over: Vec::new(),
        first_inverted: BTreeMap::new(),
        warnings,
        seconds: (0.0, 0.0),
    };
    run.save_record()?;
    let result = run.steps(&mut intervals);
    run.close(result, intervals, &clock)
}

/// A run under way.
pub(super) struct Run<'a> {
    pub deformation: &'a Deformation,
    pub plan: &'a Plan,
    pub request: &'a Request,
    pub names: &'a Names,
    pub format: &'static dyn Format,
    /// Conditions that fail the run.
    fail_on: Vec<Criterion>,
    pub record: RecordFile,
    /// What is known of the run that is gone on with; its rows are those that still count.
    pub earlier: Earlier,
    pub n_kept: usize,
    /// Rows of all steps that are finished.
    pub rows: Rows,
    pub passed_over: Vec<Diagnostic>,
    pub first_inverted: BTreeMap<usize, usize>,
    pub warnings: Vec<Diagnostic>,
    /// Of positions and quality, and of writing.
    pub seconds: (f64, f64),
}

impl Run<'_> {
    fn steps(&mut self, intervals: &mut Intervals<'_>) -> Result<()> {
        let restored = intervals.restore();
        self.note_choices(intervals)?;
        self.warnings.extend(restored?);
        if self.is_complete() {
            return Ok(());
        }
        self.choose_first(intervals)?;
        if self.earlier.is_unproven && !self.is_to_be_retraced() {
            self.prove(intervals)?;
            self.note_choices(intervals)?;
            if self.is_complete() {
                return Ok(());
            }
        }
        loop {
            let begin = match self.request.resume {
                true => Begin::Retrace,
                false => Begin::Anew,
            };
            let mut writer = Writer::start(
                self.names,
                self.format,
                self.plan.schedule.output.write_options(),
                self.earlier.rows.clone(),
                self.deformation.stop(),
                begin,
            )?;
            let pass = self.pass(&mut writer, intervals);
            let settled = writer.settle();
            self.seconds.1 += writer.seconds;
            if self.names.is_in_one() {
                self.record.content.step_ends = Some(writer.ends().to_vec());
            }
            self.take_notes(writer.notes());
            let mended = match (&pass, &settled) {
                (Ok(Pass::Done), Ok(())) => writer.end()?,
                _ => false,
            };
            self.rows = writer.rows();
            if mended {
                self.warn_of_more();
            }
            let pass = pass?;
            settled?;
            if pass == Pass::Done {
                self.vouch()?;
                self.deformation.progress().finish();
                return Ok(());
            }
        }
    }

    /// Ends the run where it was asked to.
    pub(super) fn check_stop(&self) -> Result<()> {
        self.deformation.stop().check().map_err(|mut error| {
            error.message += "; finished steps are kept, and --resume goes on from there";
            error
        })
    }

    /// Keeps in mind what a format could not hold, once for all steps.
    fn take_notes(&mut self, notes: &Notes) {
        for note in notes.iter() {
            if !self.warnings.contains(note) {
                self.warnings.push(note.clone());
            }
        }
    }

    /// Whether nothing is left to be done, or gone over.
    fn is_complete(&self) -> bool {
        let is_all = self.rows.len() == self.names.steps().len();
        is_all && !self.is_to_be_retraced() && !self.earlier.is_unproven
    }

    /// Steps of an earlier run lie in a file that only those who go over them can go on with.
    fn is_to_be_retraced(&self) -> bool {
        self.names.is_in_one()
    }

    /// The steps that have to be gone over.
    pub(super) fn todo(&self) -> Vec<Step> {
        let steps = &self.plan.motion.steps[self.names.steps()];
        let wanted =
            |step: &&Step| self.is_to_be_retraced() || !self.earlier.rows.contains_key(&step.index);
        steps.iter().filter(wanted).copied().collect()
    }

    /// Base points for the first step: without them there is no table of steps either.
    fn choose_first(&mut self, intervals: &mut Intervals<'_>) -> Result<()> {
        let todo = self.todo();
        let Some(first) = todo.first() else {
            return Ok(());
        };
        let entered = intervals.enter(first).map(|_| ());
        self.note_choices(intervals)?;
        match entered {
            Err(error) if self.plan.intervals().len() > 1 && self.passes_over(&error) => Ok(()),
            entered => entered,
        }
    }

    /// Puts into run.json what a resumed run must know of base points.
    pub(super) fn note_choices(&mut self, intervals: &Intervals<'_>) -> Result<()> {
        let content = &mut self.record.content;
        if content.base_files == intervals.base_files {
            return Ok(());
        }
        content.base_files.clone_from(&intervals.base_files);
        content.selections = self.earlier.with_selections(&intervals.selections);
        self.save_record()
    }

    /// Puts into run.json which steps were taken in substeps; before they are written.
    pub(super) fn note_repairs(&mut self) -> Result<()> {
        self.record.content.repairs = self.earlier.all_repairs();
        self.save_record()
    }

    /// What was done about inverted cells, in this run or an earlier one.
    fn tell_repairs(&self, finished: &mut Finished) {
        let repairs = self.earlier.repairs.iter();
        let written = repairs.filter(|(step, _)| self.rows.contains_key(step));
        let notes = written.map(|(step, repair)| {
            let azimuth_deg = self.plan.motion.steps[*step].azimuth_deg;
            Diagnostic::from(repair.note(azimuth_deg))
        });
        finished.warnings.extend(notes);
    }

    /// Steps that miss the tolerance that their base points were chosen by.
    fn note_misses(&self, finished: &mut Finished) {
        for (index, row) in &self.rows {
            let (step, n_base) = (&self.plan.motion.steps[*index], row.base_points);
            match missed(self.plan, step, n_base, row.selection_error) {
                Some((note, true)) => finished.failures.push(note.into()),
                Some((note, false)) => finished.warnings.push(note.into()),
                None => {}
            }
        }
    }

    /// Writes what closes a run, whether it went well or not.
    fn close(
        mut self,
        result: Result<()>,
        intervals: Intervals<'_>,
        clock: &Clock,
    ) -> Result<Finished> {
        let _held = self.deformation.stop().hold();
        let mut finished = Finished {
            n_kept: self.n_kept,
            warnings: std::mem::take(&mut self.warnings),
            passed_over: std::mem::take(&mut self.passed_over),
            ..Finished::default()
        };
        self.tell_repairs(&mut finished);
        let has_azimuth = self.plan.motion.steps[0].has_azimuth;
        finished.take_rows(
            self.names,
            &self.rows,
            &self.first_inverted,
            &self.fail_on,
            has_azimuth,
        )?;
        self.note_misses(&mut finished);
        let warnings = self.earlier.selection_warnings();
        for warning in intervals.warnings.into_iter().chain(warnings) {
            // An earlier run may have recorded the sentence of one that is made again.
            let sentence = warning.to_string();
            if !sentences(&finished.warnings).contains(&sentence) {
                finished.warnings.push(warning);
            }
        }
        finished.timings.selection = intervals.seconds_selection;
        finished.timings.modes = intervals.seconds_modes;
        (finished.timings.steps, finished.timings.writing) = self.seconds;
        finished.timings.total = clock.seconds();
        if self.earlier.is_unproven {
            return result.map(|()| finished);
        }
        self.record.close(&finished, result.as_ref().err());
        let lists = names::series(self.names, &self.rows);
        let mut lists = lists.iter();
        let saved =
            lists.try_for_each(|(path, text)| formats::save_text(text, path, self.names.commit));
        let saved = saved.and_then(|()| self.record.save());
        // The first failure is the one to tell of.
        result.and(saved).map(|()| finished)
    }
}

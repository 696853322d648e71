//! The order of the work of a run: checks, the folder, base points once an interval, then step after step; a
//! step is written while the next one is computed.

use super::base_file;
use super::base_points::BasePointStore;
use super::finished::Finished;
use super::lock::Lock;
use super::names::{self, Names, RunSteps};
use super::parts;
use super::record::{Clock, RecordFile, sentences};
use super::request::Request;
use super::resume::Earlier;
use super::surface::SurfaceFiles;
use super::table;
use super::writer::Writer;
use crate::preflight::{
    self, Demand, LargestDisplacements, before_work, check_disk, check_surface_files,
};
use crate::record::Criterion;
use crate::record::{Row, Rows};
use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::diagnostic::run::RunNote;
use azimesh_core::error::{Error, ErrorKind, Result, counted};
use azimesh_core::geometry::vector::Vector;
use azimesh_deform::motion::{Step, SurfaceOutput};
use azimesh_deform::{Deformation, Plan, missed_at_step};
use azimesh_io::formats::{self, Begin, Format, Inputs, Notes};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Writes a deformation: base points, mode fields, and one mesh a step in the request's folder. A tolerance that cannot be
/// met (base points are saved, no mesh is written) and `on_inverted = "stop"` end it early, with
/// [`ended_by`](Finished::ended_by).
///
/// # Errors
/// For inputs that do not fit and failures of the system; [`ErrorKind::Interrupted`] between two steps when `stop` was asked to.
pub fn run(deformation: &Deformation, request: &Request) -> Result<Finished> {
    run_after(deformation, request, &mut |_| {})
}

/// As [`run`]; `warn` gets the first of its warnings before the work starts.
///
/// # Errors
/// As of [`run`].
pub fn run_after(
    deformation: &Deformation,
    request: &Request,
    warn: &mut dyn FnMut(&[Diagnostic]),
) -> Result<Finished> {
    // The order matters. What refuses the mesh, the schedule and the options comes before the folder is made. The
    // folder is locked before its files are read. An earlier run and the free disk are checked before anything
    // is removed, and run.json is written before the first mesh.
    let clock = Clock::start();
    let plan = deformation.plan();
    let format = formats::by_name(&plan.schedule.output.format)?;
    let names = names_of(deformation, format, request)?;
    let (mut warnings, mesh_bytes) = warnings_before(deformation, format, &names, request)?;
    let mut record = RecordFile::new(&names, deformation, request)?;
    let base = request.base.as_deref();
    let loaded = base.map(|path| base_file::load(plan, path)).transpose()?;
    names::refuse_inputs(&names, &inputs_of(plan, request))?;
    let lock = Lock::take(&names)?;
    warnings.extend(lock.warning.clone());
    let mut earlier = earlier_run(deformation, &names, format, &record, request)?;
    formats::clear_left(&names.folder);
    if !request.no_space_check {
        let steps = (names.steps().len(), earlier.rows.len());
        let demand = Demand::of(
            plan,
            &deformation.view_to_write()?,
            format,
            steps,
            mesh_bytes,
        );
        let freed = if request.force {
            names::bytes_of_existing(&names)
        } else {
            0
        };
        let room = (freed, request.bytes_in_files);
        warnings.extend(check_disk(plan, &names.folder, &demand, room)?);
    }
    names::refuse_special(&names)?;
    warnings.append(&mut earlier.notes);
    let fail_on = earlier.take_conditions(&request.fail_on);
    earlier.note_in(&mut record.content);
    warn(&warnings);
    if request.force {
        names::remove_existing(&names)?;
    }
    let base_files = earlier.bases.clone();
    let mut base_points = BasePointStore::new(deformation, &names, loaded, base_files);
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
        skipped: Vec::new(),
        first_inverted: BTreeMap::new(),
        warnings,
        seconds_steps: 0.0,
        seconds_writing: 0.0,
        lock,
        displaced_from: None,
    };
    run.save_record()?;
    run.record.keep_room();
    let result = run.steps(&mut base_points);
    run.close(result, base_points, &clock)
}

/// Refuses what can be refused without the folder; gives the warnings, and the bytes of one mesh.
fn warnings_before(
    deformation: &Deformation,
    format: &Format,
    names: &Names,
    request: &Request,
) -> Result<(Vec<Diagnostic>, u64)> {
    let (plan, mesh) = (deformation.plan(), deformation.view_to_write()?);
    let (mut warnings, mesh_bytes) = before_work(plan, &mesh, format, &request.fail_on)?;
    check_surface_files(plan, &mesh, &request.mesh)?;
    let extremes = LargestDisplacements::new(plan);
    // What a run was started with it is resumed with.
    let is_resumed = request.resume && names.record().is_file();
    if !request.allow_outside && !is_resumed {
        extremes.refuse_leaving(plan)?;
    }
    warnings.extend(preflight::warnings(plan, &extremes));
    if plan.without_boxes {
        warnings.push(RunNote::NoBoxes.into());
    }
    Ok((warnings, mesh_bytes))
}

/// The files that the run reads, but for base points, which may lie among its outputs.
fn inputs_of(plan: &Plan, request: &Request) -> Inputs {
    let own = [&request.mesh, &plan.schedule.path].map(PathBuf::clone);
    Inputs::of(own.into_iter().chain(plan.schedule.files()))
}

/// The names of the files that the request is for.
fn names_of(deformation: &Deformation, format: &Format, request: &Request) -> Result<Names> {
    let plan = deformation.plan();
    let n_steps = plan.motion.steps.len();
    let part = RunSteps::new(request.steps.clone(), n_steps)?;
    let mut names = Names::new(&request.folder, &request.mesh, format, n_steps, part);
    names.commit.sync = !request.no_sync;
    let picture = request.base.as_deref().map(base_file::picture_of);
    names.given = Inputs::of(request.base.iter().chain(&picture));
    names.place_steps(&deformation.view_to_write()?, &plan.motion.steps)?;
    names.check_lengths(plan.schedule.output.surface != SurfaceOutput::None)?;
    Ok(names)
}

/// The run that is resumed; none where a run is created, which is refused where the folder holds another one
/// that it may not replace.
fn earlier_run(
    deformation: &Deformation,
    names: &Names,
    format: &Format,
    record: &RecordFile,
    request: &Request,
) -> Result<Earlier> {
    if !request.force {
        parts::refuse_overlap(names)?;
    }
    if request.resume {
        return Earlier::find(deformation, names, format, &record.content);
    }
    if !request.force {
        names::refuse_existing(names)?;
    }
    Ok(Earlier::default())
}

/// How a loop over the steps ended.
#[derive(PartialEq, Eq)]
pub(super) enum LoopEnd {
    /// All steps are finished.
    Done,
    /// The file of all steps differs from the rows: fewer of them count from now on, and the loop starts again.
    Restart,
}

/// A run under way.
pub(super) struct Run<'a> {
    pub deformation: &'a Deformation,
    pub plan: &'a Plan,
    pub request: &'a Request,
    pub names: &'a Names,
    pub format: &'static Format,
    /// Conditions that fail the run.
    fail_on: Vec<Criterion>,
    pub record: RecordFile,
    /// What is known of the run that is resumed; its rows are those that still count.
    pub earlier: Earlier,
    pub n_kept: usize,
    /// Rows of all steps that are finished.
    pub rows: Rows,
    pub skipped: Vec<Diagnostic>,
    pub first_inverted: BTreeMap<usize, usize>,
    pub warnings: Vec<Diagnostic>,
    /// Seconds of positions and quality.
    pub seconds_steps: f64,
    pub seconds_writing: f64,
    lock: Lock,
    /// Positions that displacements are measured from, where they are not those of the mesh that was read.
    pub displaced_from: Option<Vec<Vector>>,
}

impl Run<'_> {
    fn steps(&mut self, base_points: &mut BasePointStore<'_>) -> Result<()> {
        let restored = base_points.restore();
        self.note_choices(base_points)?;
        self.warnings.extend(restored?);
        if self.is_complete() {
            return self.begin_case();
        }
        self.choose_first(base_points)?;
        self.find_start(base_points)?;
        if self.earlier.is_unverified && !self.is_to_be_verified() {
            self.verify_steps(base_points)?;
            self.note_choices(base_points)?;
            if self.is_complete() {
                return self.begin_case();
            }
        }
        self.begin_case()?;
        loop {
            let begin = self.begin();
            let mut writer = Writer::start(
                self.names,
                self.format,
                self.plan.schedule.output.write_options(),
                SurfaceFiles::of(self.plan)?,
                self.earlier.rows.clone(),
                self.deformation.stop(),
                begin,
            )?;
            let pass = self.step_loop(&mut writer, base_points);
            let settled = writer.settle();
            self.seconds_writing += writer.seconds;
            if self.names.is_in_one() {
                self.record.content.step_ends = Some(writer.ends().to_vec());
            }
            self.take_notes(writer.notes());
            let mended = match (&pass, &settled) {
                (Ok(LoopEnd::Done), Ok(())) => writer.end()?,
                _ => false,
            };
            self.rows = writer.rows();
            if mended {
                self.warn_of_more();
            }
            let pass = pass?;
            settled?;
            if pass == LoopEnd::Done {
                self.mark_verified()?;
                self.deformation.progress().finish();
                return Ok(());
            }
        }
    }

    /// What happens to files that are there.
    fn begin(&self) -> Begin {
        match self.request.resume {
            true => Begin::Resume,
            false => Begin::Create,
        }
    }

    /// Writes what all steps share, where they are in a case.
    fn begin_case(&mut self) -> Result<()> {
        let options = self.plan.schedule.output.write_options();
        // What is copied may be large: until it gets its names, a request to stop ends the run.
        let begun = self
            .names
            .begin(&self.deformation.view_to_write()?, &options, self.begin())?;
        self.check_stop(!self.rows.is_empty())?;
        let _held = self.deformation.stop().hold();
        begun.staged.keep()?;
        self.take_notes(&begun.notes);
        let files = begun.files.into_iter();
        let named = files.map(|(file, hash)| (format!("../{file}"), hash.to_string()));
        self.record.content.companions.extend(named);
        Ok(())
    }

    /// Ends the run where it was asked to, which tells whether it has finished steps.
    pub(super) fn check_stop(&self, has_steps: bool) -> Result<()> {
        self.deformation.stop().check().map_err(|mut error| {
            error.message += match has_steps {
                true => "; finished steps are kept, and --resume continues from there",
                false => "; no step was finished",
            };
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

    /// Whether no step is left to be written or verified.
    fn is_complete(&self) -> bool {
        let is_all = self.rows.len() == self.names.steps().len();
        is_all && !self.is_to_be_verified() && !self.earlier.is_unverified
    }

    /// Whether steps of an earlier run are verified as they are appended again: so a file of all steps is resumed.
    fn is_to_be_verified(&self) -> bool {
        self.names.is_in_one()
    }

    /// The steps that have to be written or verified.
    pub(super) fn todo(&self) -> Vec<Step> {
        let steps = &self.plan.motion.steps[self.names.steps()];
        let wanted = |step: &&Step| {
            self.is_to_be_verified() || !self.earlier.rows.contains_key(&step.index())
        };
        steps.iter().filter(wanted).copied().collect()
    }

    /// Base points for the first step: without them there is no table of steps either.
    fn choose_first(&mut self, base_points: &mut BasePointStore<'_>) -> Result<()> {
        let todo = self.todo();
        let Some(first) = todo.first() else {
            return Ok(());
        };
        let entered = base_points.enter(first).map(|_| ());
        self.note_choices(base_points)?;
        match entered {
            Err(error) if self.plan.selection_intervals().len() > 1 && self.passes_over(&error) => {
                Ok(())
            }
            entered => entered,
        }
    }

    /// Puts into run.json what a resumed run must know of base points.
    pub(super) fn note_choices(&mut self, base_points: &BasePointStore<'_>) -> Result<()> {
        let content = &mut self.record.content;
        if content.base_files == base_points.base_files {
            return Ok(());
        }
        content.base_files.clone_from(&base_points.base_files);
        content.selections = self.earlier.with_selections(&base_points.selections);
        self.save_record()
    }

    /// Puts into run.json which steps were taken in substeps; before they are written.
    pub(super) fn note_repairs(&mut self) -> Result<()> {
        self.record.content.repairs = self.earlier.all_repairs();
        self.save_record()
    }

    /// What was done about cells that were not valid, in this run or an earlier one. Of steps that take a part in the repair of
    /// others run.json tells.
    fn tell_repairs(&self, finished: &mut Finished) {
        let repairs = self.earlier.repairs.iter();
        let folded = repairs.filter(|(_, repair)| repair.was_folded());
        let written = folded.filter(|(step, _)| self.rows.contains_key(step));
        let notes = written.map(|(step, repair)| {
            let step = &self.plan.motion.steps[*step];
            Diagnostic::from(repair.note(step.azimuth_deg(), step.time_s()))
        });
        finished.warnings.extend(notes);
    }

    /// Steps that miss the tolerance that their base points were chosen by.
    fn note_misses(&self, finished: &mut Finished) {
        for (index, row) in &self.rows {
            let step = &self.plan.motion.steps[*index];
            let repair = self.earlier.repairs.get(index);
            let in_substeps = repair.is_some_and(|repair| repair.substeps.is_some());
            let (n_base, error) = (row.base_points, row.selection_error);
            match missed_at_step(self.plan, step, n_base, in_substeps, error) {
                Some((note, true)) => finished.failures.push(note.into()),
                Some((note, false)) => finished.warnings.push(note.into()),
                None => {}
            }
        }
    }

    /// Refuses to end well where another program has replaced the folder, or removed files from it.
    fn check_folder(&self) -> Result<()> {
        let names = self.names;
        let table = names.table();
        let there = table::read(&table).unwrap_or_default();
        let is_there = |(step, row): (&usize, &Row)| {
            there.get(step).is_some_and(|own| own.line() == row.line())
        };
        let mut gone: Vec<PathBuf> = Vec::new();
        if !self.rows.iter().all(is_there) {
            gone.push(table.clone());
        }
        let files = self.rows.values().map(|row| names.path(&row.file));
        let bases = self.record.content.base_files.keys();
        let files = files.chain(bases.map(|name| names.path(name)));
        gone.extend(files.filter(|path| !path.exists()));
        let message = match (self.lock.holds(), gone.first()) {
            (true, None) => return Ok(()),
            (false, _) => "another program has replaced this folder during the run".to_owned(),
            (true, Some(first)) => format!(
                "another program has removed or changed {} of this run, such as {}",
                counted(gone.len(), "file"),
                first.file_name().unwrap_or_default().display()
            ),
        };
        let message = format!("{message}; --resume writes again what is missing");
        Err(Error::system(message).file(&names.folder))
    }

    /// Writes what closes a run, whether it went well or not.
    fn close(
        mut self,
        result: Result<()>,
        base_points: BasePointStore<'_>,
        clock: &Clock,
    ) -> Result<Finished> {
        let _held = self.deformation.stop().hold();
        let mut finished = Finished {
            n_kept: self.n_kept,
            warnings: std::mem::take(&mut self.warnings),
            skipped: std::mem::take(&mut self.skipped),
            ..Finished::default()
        };
        self.tell_repairs(&mut finished);
        let has_azimuth = self.plan.motion.steps[0].azimuth_deg().is_some();
        finished.take_rows(
            self.names,
            &self.rows,
            &self.first_inverted,
            &self.fail_on,
            has_azimuth,
        )?;
        self.note_misses(&mut finished);
        if self.rows.is_empty() {
            finished.take_selections(&self.record.content.selections);
        }
        let warnings = self.earlier.selection_warnings();
        for warning in base_points.warnings.into_iter().chain(warnings) {
            // An earlier run may have recorded the sentence of one that is made again.
            let sentence = warning.to_string();
            if !sentences(&finished.warnings).contains(&sentence) {
                finished.warnings.push(warning);
            }
        }
        finished.timings.selection = base_points.seconds_selection;
        finished.timings.modes = base_points.seconds_modes;
        finished.timings.steps = self.seconds_steps;
        finished.timings.writing = self.seconds_writing;
        finished.timings.total = clock.seconds();
        if self.earlier.is_unverified {
            return result.map(|()| finished);
        }
        // Without its folder a run fails in many ways, for one reason.
        let result = match self.lock.holds() {
            true => result.and_then(|()| self.check_folder()),
            false => self.check_folder(),
        };
        let lists = names::series(self.names, &self.rows);
        let mut lists = lists.iter();
        let saved =
            lists.try_for_each(|(path, text)| formats::save_text(text, path, self.names.commit));
        let result = result.and(saved);
        self.record.close(&finished, result.as_ref().err());
        finished.outcome.clone_from(&self.record.content.outcome);
        let saved = self.record.save_last();
        // The first failure is the one to tell of.
        match result.and(saved) {
            Err(error) if error.kind == ErrorKind::Check => finished.ended_by = Some(error),
            ended => ended?,
        }
        Ok(finished)
    }
}

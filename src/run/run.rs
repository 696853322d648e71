//! The order of the work of a run: checks, the folder, base points once per interval, then step after step; a step is
//! written while the next one is computed.

use super::base_file;
use super::base_points::BasePointStore;
use super::finished::Finished;
use super::lock::Lock;
use super::names::{self, Names};
use super::parts;
use super::record::{RecordFile, companions, latest};
use super::resume::Earlier;
use super::surface::SurfaceFiles;
use super::table;
use super::writer::Writer;
use crate::preflight::{
    self, Demand, LargestDisplacements, before_work, check_disk, check_surface_files,
};
use crate::record::{Criterion, Row, Rows, WorstStep};
use azimesh_core::error::{Error, ErrorKind, Result, counted};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::numbers::short;
use azimesh_core::{Note, note};
use azimesh_deform::motion::{Step, SurfaceOutput};
use azimesh_deform::{Deformation, Plan, missed_at_step};
use azimesh_io::formats::{self, Begin, Format, Inputs, Notes, openfoam};
use azimesh_io::mesh::Mesh;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;
use std::time::Instant;

/// Options of a run that are not options of its deformation.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// The command line without the program, for the record.
    pub arguments: Vec<String>,
    /// The mesh file, for names and hashes.
    pub mesh: PathBuf,
    /// Further files that were read for the mesh or by files of the schedule: pieces, linked files, conditions of tags.
    pub files: Vec<PathBuf>,
    /// The folder of the files.
    pub folder: PathBuf,
    /// Base points selected before.
    pub base: Option<PathBuf>,
    /// The steps to write, counted from 0; all when left out.
    pub steps: Option<Range<usize>>,
    /// The cell array from which the boundary tags were read, if it was named.
    pub tag_array: Option<String>,
    /// True if files of an earlier run are replaced.
    pub force: bool,
    /// True if an earlier run is resumed.
    pub resume: bool,
    /// True if a step that cannot be written is skipped and the run continues.
    pub keep_going: bool,
    /// True if bodies may leave the mesh.
    pub allow_outside: bool,
    /// True if the run starts even without disk space for all steps.
    pub no_space_check: bool,
    /// True if steps need not survive a power cut.
    pub no_sync: bool,
    /// Bytes of arrays stored on the disk during the run.
    pub bytes_in_files: u64,
    /// Conditions that fail the run.
    pub fail_on: Vec<Criterion>,
}

/// Writes a deformation: base points, mode fields, and one mesh per step in the request's folder. A missed tolerance (base
/// points are saved, no mesh is written) and `on_inverted = "stop"` end it early, with [`ended_by`](Finished::ended_by).
///
/// # Errors
/// For inputs that do not fit and failures of the system; [`ErrorKind::Interrupted`] between two steps if `stop` was requested.
pub fn run(deformation: &Deformation, request: &Request) -> Result<Finished> {
    run_after(deformation, request, &mut |_| {})
}

/// Like [`run`]; passes the first of its warnings to `warn` before the work starts.
///
/// # Errors
/// Like [`run`].
pub fn run_after(
    deformation: &Deformation,
    request: &Request,
    warn: &mut dyn FnMut(&[Note]),
) -> Result<Finished> {
    // The order matters. Checks of the mesh, the schedule and the options come before the folder is created. The folder is
    // locked before its files are read. An earlier run and the free disk space are checked before anything is removed, and
    // run.json is written before the first mesh.
    let clock = Instant::now();
    let plan = deformation.plan();
    let format = formats::by_name(plan.schedule.output.format())?;
    let names = names_of(deformation, format, request)?;
    let (mut warnings, mesh_bytes) = warnings_before(deformation, format, &names, request)?;
    let mut record = RecordFile::new(&names, deformation, request)?;
    let base = request.base.as_deref();
    let loaded = base.map(|path| base_file::load(plan, path)).transpose()?;
    // Base points may be among the outputs.
    let inputs = [&request.mesh, &plan.schedule.path]
        .into_iter()
        .chain(&request.files);
    let inputs = inputs.cloned().chain(plan.schedule.files());
    let of_case = openfoam::files_of_origin(deformation.mesh_to_write()?);
    let inputs = Inputs::of(inputs.chain(of_case));
    names::refuse_inputs(&names, &inputs)?;
    let lock = Lock::take(&names)?;
    warnings.extend(lock.warning.clone());
    let mut earlier = earlier_run(deformation, &names, format, &record, request)?;
    formats::clear_left(&names.folder);
    if !request.no_space_check {
        let steps = (names.steps().len(), earlier.rows.len());
        let mesh = deformation.view_to_write()?;
        let demand = Demand::of(plan, &mesh, format, steps, mesh_bytes);
        let replaced = names::existing_outputs(&names);
        let replaced = replaced.iter().filter(|_| request.force);
        let freed = replaced.map(|path| names::bytes_of(path)).sum();
        let room = (freed, request.bytes_in_files);
        warnings.extend(check_disk(plan, &names.folder, &demand, room)?);
    }
    names::refuse_special(&names)?;
    deformation.set_added(&earlier.record.extended, |step| {
        earlier.may_be_repaired(step)
    });
    let mut base_points = BasePointStore::new(deformation, &names, loaded, &earlier.record);
    if earlier.adds_steps {
        if !request.allow_outside {
            LargestDisplacements::new(plan).refuse_leaving(plan)?;
        }
        base_points.check_added()?;
        earlier.take_intervals(&plan.selection_intervals());
    }
    warnings.append(&mut earlier.notes);
    let fail_on = earlier.enter(&mut record.content, &request.fail_on);
    if earlier.rows.is_empty() && fail_on.iter().any(|own| own.check_of_meshes().is_ok()) {
        let columns = deformation.quality_at_rest().columns();
        warnings.extend(fail_on.iter().filter_map(|own| own.note_at_rest(&columns)));
    }
    warn(&warnings);
    if request.force {
        names::remove_existing(&names)?;
    }
    let rows = earlier.rows.clone();
    let is_whole = plan.schedule.output.boundary_faces;
    let volume = || Ok(deformation.mesh_to_write()?.volume_alone());
    let volume = (!is_whole).then(volume).transpose()?;
    let mut run = Run {
        deformation,
        plan,
        request,
        names: &names,
        format,
        fail_on,
        record,
        finished: Finished {
            n_kept: rows.len(),
            warnings,
            ..Finished::default()
        },
        rows,
        worst: (earlier.record.end.as_ref()).and_then(|end| end.worst_step.clone()),
        earlier,
        first_inverted: BTreeMap::new(),
        lock,
        displaced_from: None,
        volume,
    };
    run.save_record()?;
    run.record.keep_room();
    let result = run.steps(&mut base_points);
    run.close(result, base_points, clock)
}

/// Makes all checks that do not need the folder; returns the warnings, and the bytes of one mesh.
fn warnings_before(
    deformation: &Deformation,
    format: &Format,
    names: &Names,
    request: &Request,
) -> Result<(Vec<Note>, u64)> {
    let (plan, mesh) = (deformation.plan(), deformation.view_to_write()?);
    let (mut warnings, mesh_bytes) = before_work(plan, &mesh, format, &request.fail_on)?;
    check_surface_files(plan, &mesh, &request.mesh)?;
    let extremes = LargestDisplacements::new(plan);
    // A run is resumed with its original options.
    let is_resumed = request.resume && names.record().is_file();
    if !request.allow_outside && !is_resumed {
        extremes.refuse_leaving(plan)?;
    }
    warnings.extend(preflight::warnings(plan, &extremes));
    if plan.without_boxes {
        warnings.push(note!(
            "no_boxes",
            "the boxes of free-form deformation (su2:FFD) fit the undeformed mesh only; they are left out"
        ));
    }
    Ok((warnings, mesh_bytes))
}

/// Returns the names of the files of the request.
fn names_of(deformation: &Deformation, format: &Format, request: &Request) -> Result<Names> {
    let plan = deformation.plan();
    let n_steps = plan.motion.steps.len();
    let mut names = Names::new(&request.folder, &request.mesh, format, n_steps);
    if let Some(steps) = &request.steps {
        names = names.part(steps.clone())?;
    }
    names.commit.sync = !request.no_sync;
    let picture = request.base.as_deref().map(base_file::picture_of);
    names.given = Inputs::of(request.base.iter().chain(&picture));
    names.companions = companions(&names, deformation)?;
    let output = &plan.schedule.output;
    names.has_surfaces = output.surface != SurfaceOutput::None;
    names.has_displacements = output.displacement;
    names.place_steps(&deformation.view_to_write()?, &plan.motion.steps)?;
    names.check_lengths()?;
    Ok(names)
}

/// Finds the run to be resumed, or an empty one if a run is created. Creation is refused if the folder holds another run
/// that must not be replaced.
fn earlier_run(
    deformation: &Deformation,
    names: &Names,
    format: &'static Format,
    record: &RecordFile,
    request: &Request,
) -> Result<Earlier> {
    if !request.force {
        parts::refuse_overlap(names)?;
        parts::refuse_others(names, &record.content)?;
    }
    if request.resume {
        return Earlier::find(deformation, names, format, &record.content);
    }
    if !request.force {
        names::refuse_existing(names)?;
    }
    Ok(Earlier::default())
}

/// The end of a loop over the steps.
#[derive(PartialEq, Eq)]
pub(super) enum LoopEnd {
    /// All steps are finished.
    Done,
    /// The file of all steps differs from the rows: fewer of them are valid from now on, and the loop starts again.
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
    /// The run that is resumed, with its valid rows.
    pub earlier: Earlier,
    /// The result so far.
    pub finished: Finished,
    /// Rows of all steps that are finished.
    pub rows: Rows,
    pub first_inverted: BTreeMap<usize, usize>,
    /// The worst step so far.
    pub worst: Option<WorstStep>,
    lock: Lock,
    /// Reference positions of displacements, if they differ from the mesh that was read.
    pub displaced_from: Option<Vec<Vector>>,
    /// The volume cells and their numbers, where the schedule leaves out boundary faces.
    pub volume: Option<(Mesh, Vec<usize>)>,
}

impl Run<'_> {
    fn steps(&mut self, base_points: &mut BasePointStore<'_>) -> Result<()> {
        let restored = base_points.restore();
        self.note_choices(base_points)?;
        self.finished.warnings.extend(restored?);
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
            let mut writer = Writer::start(
                self.names,
                self.format,
                self.plan.schedule.output.write_options(),
                SurfaceFiles::of(self.plan)?,
                (self.earlier.rows.clone(), self.earlier.listed.clone()),
                self.deformation.stop(),
                self.begin(),
            )?;
            let pass = self.step_loop(&mut writer, base_points);
            let settled = writer.settle();
            self.finished.timings.writing += writer.seconds;
            if self.names.is_in_one {
                self.record.content.step_ends = Some(writer.ends.clone());
            }
            self.take_notes(&writer.notes);
            let mended = match (&pass, &settled) {
                (Ok(LoopEnd::Done), Ok(())) => writer.end()?,
                _ => false,
            };
            self.rows = writer.rows();
            if mended {
                let file = self.names.mesh(self.names.steps().start);
                self.finished.warnings.push(note!(
                    "cut_off",
                    "{file} does not end with its last step; what follows it is cut off"
                ));
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

    /// Returns the treatment of existing files.
    fn begin(&self) -> Begin {
        if self.request.resume {
            Begin::Resume
        } else {
            Begin::Create
        }
    }

    /// Writes the data that all steps share, if they are in a case.
    fn begin_case(&mut self) -> Result<()> {
        let options = self.plan.schedule.output.write_options();
        let mesh = self.deformation.view_to_write()?;
        // Copied data may be large: until it gets its names, a request to stop ends the run.
        let begun = self.names.begin(&mesh, &options, self.begin())?;
        self.check_stop(!self.rows.is_empty())?;
        let _held = self.deformation.stop().hold();
        begun.staged.keep()?;
        self.take_notes(&begun.notes);
        let files = begun.files.into_iter();
        let named = files.map(|(file, hash)| (format!("../{file}"), hash.to_string()));
        self.record.content.companions.extend(named);
        Ok(())
    }

    /// Ends the run if a stop was requested; the error says whether it has finished steps.
    pub(super) fn check_stop(&self, has_steps: bool) -> Result<()> {
        self.deformation.stop().check().map_err(|mut error| {
            error.message += if has_steps {
                "; finished steps are kept, and --resume continues from there"
            } else {
                "; no step was finished"
            };
            error
        })
    }

    /// Records notes on data that a format could not hold, once for all steps.
    fn take_notes(&mut self, notes: &Notes) {
        for note in notes.iter() {
            if !self.finished.warnings.contains(note) {
                self.finished.warnings.push(note.clone());
            }
        }
    }

    /// Checks if no step remains to be written or verified.
    fn is_complete(&self) -> bool {
        let is_all = self.rows.len() == self.names.steps().len();
        is_all && !self.is_to_be_verified() && !self.earlier.is_unverified
    }

    /// Checks if steps of an earlier run are verified when they are appended again: a file of all steps is resumed this way.
    fn is_to_be_verified(&self) -> bool {
        self.names.is_in_one
    }

    /// Returns the steps that remain to be written or verified.
    pub(super) fn todo(&self) -> Vec<Step> {
        let steps = &self.plan.motion.steps[self.names.steps()];
        let wanted = |step: &&Step| {
            self.is_to_be_verified() || !self.earlier.rows.contains_key(&step.index())
        };
        steps.iter().filter(wanted).copied().collect()
    }

    /// Base points for the first step: without them there is no table of steps either.
    fn choose_first(&mut self, base_points: &mut BasePointStore<'_>) -> Result<()> {
        let Some(first) = self.todo().first().copied() else {
            return Ok(());
        };
        let entered = base_points.enter(&first);
        self.note_choices(base_points)?;
        let has_several = self.plan.selection_intervals().len() > 1;
        match entered {
            Err(error) if !has_several || !self.passes_over(&error) => Err(error),
            _ => Ok(()),
        }
    }

    /// Adds the data of base points to run.json that a resumed run needs.
    pub(super) fn note_choices(&mut self, base_points: &BasePointStore<'_>) -> Result<()> {
        let content = &mut self.record.content;
        if content.base_files == base_points.base_files {
            return Ok(());
        }
        content.base_files.clone_from(&base_points.base_files);
        let earlier = self.earlier.record.selections.iter();
        let selections = earlier.chain(&base_points.selections);
        content.selections = latest(selections, |selection| selection.first_step);
        self.save_record()
    }

    /// Adds the steps computed in substeps to run.json, before they are written.
    pub(super) fn note_repairs(&mut self) -> Result<()> {
        self.record.content.repairs = self.earlier.all_repairs();
        self.save_record()
    }

    /// Adds notes on repairs of invalid cells, in this run or an earlier one. run.json also has the steps that take part in the
    /// repair of others.
    fn tell_repairs(&self, finished: &mut Finished) {
        for (index, repair) in &self.earlier.repairs {
            if repair.was_folded() && self.rows.contains_key(index) {
                let step = &self.plan.motion.steps[*index];
                let note = repair.note(step.azimuth_deg(), step.time_s());
                finished.warnings.push(note);
            }
        }
        for start in &self.record.content.extended {
            let mut repairs = self.earlier.repairs.values();
            let window = repairs.find_map(|repair| repair.window.filter(|own| own[0] == *start));
            let note = window.map(|[start, end]| {
                note!(
                    "window_at_seam",
                    "the window of repaired steps {start} to {} begins at the first step that was added: the finished steps before \
                     it stay as they are, and the repair grows from their positions",
                    end - 1
                )
            });
            finished.warnings.extend(note);
        }
        let low = self
            .earlier
            .repairs
            .iter()
            .filter(|(index, repair)| repair.low.is_some() && self.rows.contains_key(index));
        let low: Vec<usize> = low.map(|(index, _)| *index).collect();
        if let (Some(wanted), false) = (self.plan.schedule.output.improve, low.is_empty()) {
            let note = note!(
                "not_reached",
                "{} left with cells below `improve` = {}: no better positions were found",
                parts::told(&low),
                short(wanted)
            );
            finished.warnings.push(note.with("steps", low));
        }
    }

    /// Adds notes on steps that miss the tolerance of their base points.
    fn note_misses(&self, finished: &mut Finished) {
        for (index, row) in &self.rows {
            let step = &self.plan.motion.steps[*index];
            let repair = self.earlier.repairs.get(index);
            let in_substeps = repair.is_some_and(|repair| repair.substeps.is_some());
            let (n_base, error) = (row.base_points, row.selection_error);
            match missed_at_step(self.plan, step, n_base, in_substeps, error) {
                Some((note, true)) => finished.failures.push(note),
                Some((note, false)) => finished.warnings.push(note),
                None => {}
            }
        }
    }

    /// Returns an error if another program has replaced the folder, or removed files from it.
    fn check_folder(&self) -> Result<()> {
        let names = self.names;
        let table = names.table();
        let there = table::read(&table).unwrap_or_default();
        let is_gone = |(step, row): (&usize, &Row)| {
            let own = there.get(step);
            own.is_none_or(|own| own.line() != row.line())
        };
        let gone = self.rows.iter().any(is_gone).then_some(table);
        let mut gone: Vec<PathBuf> = gone.into_iter().collect();
        let files = self.rows.values().map(|row| &row.file);
        let files = files.chain(self.record.content.base_files.keys());
        let files = files.map(|name| names.path(name));
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

    /// Writes the final files of a run, whether it succeeded or not.
    fn close(
        mut self,
        result: Result<()>,
        base_points: BasePointStore<'_>,
        clock: Instant,
    ) -> Result<Finished> {
        let _held = self.deformation.stop().hold();
        let mut finished = std::mem::take(&mut self.finished);
        self.tell_repairs(&mut finished);
        let has_azimuth = self.plan.motion.steps[0].azimuth_deg().is_some();
        let (rows, first) = (&self.rows, &self.first_inverted);
        finished.take_rows(self.names, rows, first, &self.fail_on, has_azimuth)?;
        if let Some(known) = &self.worst {
            finished.take_place(known);
        }
        self.note_misses(&mut finished);
        if self.rows.is_empty() {
            finished.take_selections(&self.record.content.selections);
        }
        let warnings = self.earlier.selection_warnings();
        for warning in base_points.warnings.into_iter().chain(warnings) {
            if !finished.warnings.contains(&warning) {
                finished.warnings.push(warning);
            }
        }
        finished.timings.selection = base_points.seconds_selection;
        finished.timings.modes = base_points.seconds_modes;
        finished.timings.total = clock.elapsed().as_secs_f64();
        if self.earlier.is_unverified {
            return result.map(|()| finished);
        }
        // Without its folder a run fails in many ways, for one reason.
        let result = if self.lock.holds() {
            result.and_then(|()| self.check_folder())
        } else {
            self.check_folder()
        };
        let commit = self.names.commit;
        let mut lists = names::series(self.names, &self.rows).into_iter();
        let result =
            result.and(lists.try_for_each(|(path, text)| formats::save_text(&text, &path, commit)));
        self.record.close(&finished, result.as_ref().err());
        finished.outcome.clone_from(&self.record.content.outcome);
        let saved = self.record.save_last();
        // The first failure is reported.
        match result.and(saved) {
            Err(error) if error.kind == ErrorKind::Check => finished.ended_by = Some(error),
            ended => ended?,
        }
        Ok(finished)
    }
}

//! Base points of the current step: selected and saved when a step enters a new selection interval.

use super::base_file;
use super::names::Names;
use super::record::selection_record;
use crate::record::{Diagnostic, RunRecord, SelectionRecord};
use azimesh_core::error::{Error, Result};
use azimesh_core::progress::{Progress, Silent};
use azimesh_core::{Note, note};
use azimesh_deform::motion::{SelectionMethod, Step};
use azimesh_deform::{BaseOrigin, Deformation, Plan, StepEvaluator, check_tolerance};
use azimesh_io::formats::hash_of;
use azimesh_rbf::select::Selection;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// The base points of a run by selection interval: selected, loaded and saved.
pub(super) struct BasePointStore<'a> {
    pub deformation: &'a Deformation,
    names: &'a Names,
    /// Base points selected before the run.
    loaded: Option<Vec<Selection>>,
    /// Number of steps of an earlier schedule to which this one adds steps; they keep their base points.
    n_earlier: usize,
    /// Files of base points of this run or an earlier one, with their hashes.
    pub base_files: BTreeMap<String, String>,
    /// The result of each selection, for run.json.
    pub selections: Vec<SelectionRecord>,
    /// Notes for the user.
    pub warnings: Vec<Note>,
    /// Seconds of the selection.
    pub seconds_selection: f64,
    /// Seconds of the evaluation at the nodes.
    pub seconds_modes: f64,
}

impl<'a> BasePointStore<'a> {
    pub fn new(
        deformation: &'a Deformation,
        names: &'a Names,
        loaded: Option<Vec<Selection>>,
        earlier: &RunRecord,
    ) -> Self {
        Self {
            deformation,
            names,
            loaded,
            n_earlier: earlier.extended.last().copied().unwrap_or(0),
            base_files: earlier.base_files.clone(),
            selections: Vec::new(),
            warnings: Vec::new(),
            seconds_selection: 0.0,
            seconds_modes: 0.0,
        }
    }

    /// Refuses a run with added steps if the base points of the finished steps are lost, or do not meet the tolerance at the
    /// added ones.
    pub fn check_added(&mut self) -> Result<()> {
        let n_earlier = self.n_earlier;
        let plan = self.deformation.plan();
        let intervals = plan.selection_intervals().into_iter();
        for interval in intervals.filter(|interval| interval.start < n_earlier) {
            let path = self.path_of(&interval);
            if self.has_noted(&path) {
                // The file serves the plans of all segments.
                self.loaded = None;
            } else if self.loaded.is_some() {
                self.base_points(plan, &interval)?;
            } else {
                return Err(Error::input(
                    "is missing or does not have the hash in run.json; without the base points of the finished steps no steps \
                     can be added to them: --force starts a new run of all steps",
                )
                .file(&path));
            }
            if interval.end > n_earlier {
                self.enter(&plan.motion.steps[n_earlier])?;
            }
        }
        Ok(())
    }

    /// Returns the interval of a step; when it is entered, base points are selected and saved.
    pub fn enter(&mut self, step: &Step) -> Result<Arc<StepEvaluator>> {
        let clock = Instant::now();
        let (deformation, progress) = (self.deformation, self.progress());
        let mut selecting = None;
        let interval = deformation.enter(step, progress, &mut |plan, steps| {
            let origin = match &self.loaded {
                _ if self.n_earlier > steps.start => BaseOrigin::Earlier,
                Some(_) => BaseOrigin::Given,
                None => BaseOrigin::Chosen,
            };
            let selections = self.base_points(plan, steps)?;
            check_tolerance(plan, &selections.1, origin)?;
            selecting = Some(clock.elapsed().as_secs_f64());
            Ok(selections)
        })?;
        let Some(selecting) = selecting else {
            return Ok(interval);
        };
        self.seconds_selection += selecting;
        self.seconds_modes += clock.elapsed().as_secs_f64() - selecting;
        self.warnings.extend(interval.warnings.iter().cloned());
        let selected = self.selections.last_mut();
        if let Some(own) = selected.filter(|own| own.first_step == interval.steps().start) {
            own.diagnostics = Some(Diagnostic::warnings(&interval.warnings));
        }
        Ok(interval)
    }

    /// Returns base points for an interval: given, read from the file of an earlier run, or selected and saved.
    fn base_points(
        &mut self,
        plan: &Plan,
        interval: &Range<usize>,
    ) -> Result<(BaseOrigin, Vec<Selection>)> {
        let path = self.path_of(interval);
        let progress = self.progress();
        match (self.loaded.take(), self.has_noted(&path)) {
            (Some(loaded), _) => {
                let given = self.note(interval, loaded, &path)?;
                Ok((BaseOrigin::Given, given))
            }
            (None, true) => {
                let selections = base_file::load_for(plan, interval, &path)?;
                let picture = base_file::picture_of(&path);
                if !self.has_noted(&picture) {
                    base_file::save_picture(plan, &selections, &picture, self.names.commit)?;
                    self.note_file(&picture)?;
                }
                Ok((BaseOrigin::Given, selections))
            }
            (None, false) => {
                let chosen = self.deformation.choose(interval, progress)?;
                let chosen = self.note(interval, chosen, &path)?;
                Ok((BaseOrigin::Chosen, chosen))
            }
        }
    }

    /// Writes changed files of base points of an earlier run again; adds a note for each.
    pub fn restore(&mut self) -> Result<Vec<Note>> {
        let steps = self.names.steps();
        let mut notes: Vec<Note> = Vec::new();
        for interval in self.deformation.plan().selection_intervals() {
            let path = self.path_of(&interval);
            let is_ours = interval.start < steps.end && steps.start < interval.end;
            if !is_ours || !self.base_files.contains_key(&name_of(&path)) {
                continue;
            }
            let files = [base_file::picture_of(&path), path];
            let wrong: Vec<_> = files.iter().filter(|path| !self.has_noted(path)).collect();
            if wrong.is_empty() {
                continue;
            }
            notes.extend(wrong.into_iter().map(|path| {
                let is_there = path.is_file();
                let hash = is_there.then_some("does not have the hash in run.json");
                let fault = hash.unwrap_or("is missing");
                let file = name_of(path);
                note!("base_again", "{file} {fault}; it is written again")
            }));
            let clock = Instant::now();
            self.base_points(self.deformation.plan(), &interval)?;
            self.seconds_selection += clock.elapsed().as_secs_f64();
        }
        Ok(notes)
    }

    /// The steps report their progress themselves.
    fn progress(&self) -> &'a dyn Progress {
        if self.selections.is_empty() {
            self.deformation.progress()
        } else {
            &Silent
        }
    }

    fn path_of(&self, interval: &Range<usize>) -> PathBuf {
        let method = self.deformation.plan().schedule.selection.method;
        let first = (method == SelectionMethod::Real).then_some(interval.start);
        self.names.base(first)
    }

    /// Checks if a file was written for this plan.
    fn has_noted(&self, path: &Path) -> bool {
        let noted = self.base_files.get(&name_of(path));
        let found = || hash_of(path).ok().map(|hash| hash.to_string());
        noted.is_some_and(|noted| found().as_ref() == Some(noted))
    }

    /// Records the file that was written.
    fn note_file(&mut self, path: &Path) -> Result<()> {
        let hash = hash_of(path).map_err(|error| Error::io(path, &error))?;
        self.base_files.insert(name_of(path), hash.to_string());
        Ok(())
    }

    /// Writes base points, and records their result.
    fn note(
        &mut self,
        interval: &Range<usize>,
        selections: Vec<Selection>,
        path: &Path,
    ) -> Result<Vec<Selection>> {
        self.selections.push(selection_record(
            self.deformation.plan(),
            interval,
            &selections,
        ));
        let (plan, picture) = (self.deformation.plan(), base_file::picture_of(path));
        let is_given = |path: &Path| self.names.given.find(path).is_some();
        match is_given(path) {
            false => base_file::save(plan, &selections, path, self.names.commit)?,
            true if is_given(&picture) => {}
            true => base_file::save_picture(plan, &selections, &picture, self.names.commit)?,
        }
        self.note_file(path)?;
        self.note_file(&picture)?;
        Ok(selections)
    }
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

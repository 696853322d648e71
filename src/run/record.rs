//! run.json of a run under way: created, completed and updated during the run; files and their hashes.

use super::finished::Finished;
use super::names::Names;
use super::run::Request;
use crate::preflight::body_motion;
use crate::record::{
    Diagnostic, EndRecord, Failed, Failure, FunctionRecord, InputRecord, LayerRecord,
    OptionsRecord, PatchRecord, RepairRecord, RunRecord, SelectionRecord, sentences,
};
use azimesh_core::error::{Error, Result, counted};
use azimesh_deform::motion::{Step, SurfaceOutput};
use azimesh_deform::{Deformation, Plan, Repair};
use azimesh_io::formats::{
    self, Commit, Precision, Reserve, hash_of_input, hash_of_read, read_file, save_text,
};
use azimesh_quality::repair::PatchLog;
use azimesh_rbf::select::Selection;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The record of a run with its path on the disk.
pub(super) struct RecordFile {
    path: PathBuf,
    commit: Commit,
    /// Reserved disk space, for the final record of a run that fills the disk.
    room: Option<Reserve>,
    /// Its content.
    pub content: RunRecord,
}

/// Largest growth of a record until it is closed, in bytes.
const GROWTH: usize = 64 << 10;

impl RecordFile {
    /// Creates the record of a run, not yet written.
    pub fn new(names: &Names, deformation: &Deformation, request: &Request) -> Result<Self> {
        let plan = deformation.plan();
        let mesh = deformation.mesh_to_write()?;
        let hash_of_mesh = |path: &Path| hash_of_input(path, mesh);
        let mut inputs = vec![
            input("mesh", &request.mesh, hash_of_mesh)?,
            InputRecord {
                but_steps: hash_but_steps(&plan.schedule.text),
                ..input("schedule", &plan.schedule.path, hash_of_read)?
            },
        ];
        for file in &plan.schedule.files() {
            inputs.push(input("file", file, hash_of_read)?);
        }
        for file in &request.files {
            inputs.push(input("linked file", file, hash_of_read)?);
        }
        if let Some(base) = &request.base {
            inputs.push(input("base", base, hash_of_read)?);
        }
        let content = RunRecord {
            version: 1,
            program: concat!("azimesh ", env!("CARGO_PKG_VERSION")).to_owned(),
            arguments: request.arguments.clone(),
            title: plan.schedule.output.title.clone(),
            length_unit: plan.schedule.output.length_unit.clone(),
            outcome: "running".to_owned(),
            inputs,
            functions: functions(plan),
            options: options(plan, request),
            chosen: sentences(&plan.choices),
            dimension: Some(plan.boundary.dimension().into()),
            nodes: Some(plan.boundary.n_nodes),
            cells: Some(plan.boundary.n_cells),
            surface_points: Some(plan.surface.nodes.len()),
            coincident_surface_nodes: Some(plan.surface.n_coincident),
            steps: Some(plan.motion.steps.len()),
            modes: Some(plan.n_modes()),
            mode_truncation: Some(plan.truncation()),
            motion: Some(body_motion(plan)),
            companions: names.companions.clone(),
            ..RunRecord::default()
        };
        Ok(Self::of(names, content))
    }

    /// Creates a record that was read, or joined.
    pub fn of(names: &Names, content: RunRecord) -> Self {
        Self {
            path: names.record(),
            commit: names.commit,
            room: None,
            content,
        }
    }

    /// Adds the result of the run; `error` is the error that ended it. Its seconds are added to existing ones.
    pub fn close(&mut self, finished: &Finished, error: Option<&Error>) {
        let content = &mut self.content;
        content.outcome = match (error, finished.skipped.len()) {
            (Some(error), _) => error.to_string(),
            (None, 0) => "complete".to_owned(),
            (None, n) => format!("complete but for {}", counted(n, "step")),
        };
        content.end = Some(EndRecord {
            steps_written: finished.n_steps,
            base_points: Some(finished.n_base),
            selection_error: Some(finished.selection_error),
            inverted_steps: finished.inverted_steps,
            max_inverted: finished.max_inverted,
            min_scaled_jacobian: finished.min_scaled_jacobian,
            worst_step: finished.worst_step.clone(),
            max_surface_error: Some(finished.surface_error),
            skipped_steps: sentences(&finished.skipped),
            diagnostics: Diagnostic::warnings(&finished.warnings),
            failures: finished.failures.iter().map(Failure::from).collect(),
            error: error.map(Failed::from),
        });
        let before = content.seconds.unwrap_or_default();
        content.seconds = Some(before.plus(finished.timings));
    }

    /// Reserves disk space for the record of a run that fills the disk.
    pub fn keep_room(&mut self) {
        let n_bytes = self.content.text().len() + GROWTH;
        self.room = Some(Reserve::beside(&self.path, n_bytes));
    }

    /// Writes the record of a run that has ended, in the reserved space.
    pub fn save_last(&mut self) -> Result<()> {
        self.room = None;
        self.save()
    }

    /// Writes the record in its current state.
    pub fn save(&self) -> Result<()> {
        save_text(&self.content.text(), &self.path, self.commit)
    }
}

fn options(plan: &Plan, request: &Request) -> OptionsRecord {
    let (selection, output) = (&plan.schedule.selection, &plan.schedule.output);
    let precision = match output.precision {
        Precision::F64 => "f64",
        Precision::F32 => "f32",
    };
    OptionsRecord {
        kernel: Some(plan.basis.kernel.name().to_owned()),
        support_radius: Some(plan.basis.radius),
        tolerance: Some(plan.tolerance),
        max_points: Some(selection.max_points),
        correction: Some(selection.correction),
        format: Some(output.format().to_owned()),
        precision: Some(precision.to_owned()),
        tag_array: request.tag_array.clone(),
        surface: (output.surface == SurfaceOutput::Su2).then(|| "su2".to_owned()),
    }
}

/// Returns the files next to the mesh of each step that do not depend on the step: their endings and hashes.
pub(super) fn companions(
    names: &Names,
    deformation: &Deformation,
) -> Result<BTreeMap<String, String>> {
    let format = formats::by_name(deformation.plan().schedule.output.format())?;
    let mesh = names.path(&format!("no mesh.{}", format.extensions[0]));
    let files = (format.companions)(&deformation.view_to_write()?, &mesh);
    let named = files.into_iter().map(|(path, content)| {
        let ending = path.extension().unwrap_or_default().display();
        (format!("*.{ending}"), blake3::hash(&content).to_string())
    });
    Ok(named.collect())
}

fn functions(plan: &Plan) -> Vec<FunctionRecord> {
    let record = |(body, name): (&str, Option<&str>)| FunctionRecord {
        body: body.to_owned(),
        name: name.map(str::to_owned),
    };
    plan.schedule.functions().into_iter().map(record).collect()
}

/// Returns an input and its hash; data from a pipe is gone and has none.
fn input(
    what: &str,
    path: &Path,
    hash_of: impl FnOnce(&Path) -> std::io::Result<blake3::Hash>,
) -> Result<InputRecord> {
    let is_pipe = |found: std::fs::Metadata| !found.is_file() && !found.is_dir();
    let has_hash = path.as_os_str() != "-" && !path.metadata().is_ok_and(is_pipe);
    let hash = has_hash.then(|| hash_of(path)).transpose();
    let hash = hash.map_err(|error| Error::io(path, &error))?;
    Ok(InputRecord {
        what: what.to_owned(),
        file: path.display().to_string(),
        blake3: hash.map(|hash| hash.to_string()),
        but_steps: None,
    })
}

/// Returns the hash of the text of a schedule without the keys that count its steps; `None` without a text.
fn hash_but_steps(text: &str) -> Option<String> {
    let mut schedule: toml::Table = text.parse().ok().filter(|_| !text.is_empty())?;
    schedule.remove("steps");
    for section in ["azimuth", "time"] {
        let Some(toml::Value::Table(of_steps)) = schedule.get_mut(section) else {
            continue;
        };
        for key in ["start", "stop", "step", "values"] {
            of_steps.remove(key);
        }
    }
    let rest = toml::to_string(&schedule).ok()?;
    Some(blake3::hash(rest.as_bytes()).to_string())
}

/// Reads a record on disk; `None` if there is none, or if a power cut has left it empty, cut or invalid.
pub(super) fn read(path: &Path) -> Result<Option<RunRecord>> {
    if !path.exists() {
        return Ok(None);
    }
    let bytes = read_file(path).map_err(|error| Error::io(path, &error))?;
    Ok(RunRecord::parse(&bytes).ok().filter(RunRecord::is_whole))
}

/// Sorts records by their key; of several with one key the last is kept.
pub(super) fn latest<'a, T: Clone + 'a>(
    records: impl Iterator<Item = &'a T>,
    key: impl Fn(&T) -> usize,
) -> Vec<T> {
    let by_key: BTreeMap<usize, &T> = records.map(|record| (key(record), record)).collect();
    by_key.into_values().cloned().collect()
}

/// Builds the record of the selections of an interval.
pub(super) fn selection_record(
    plan: &Plan,
    interval: &Range<usize>,
    selections: &[Selection],
) -> SelectionRecord {
    let layers = plan.layers.iter().zip(selections);
    let layers = layers.map(|(layer, selection)| LayerRecord {
        of: layer.name().to_owned(),
        base_points: selection.base.len(),
        tolerance: Some(layer.tolerance),
        error: Some(selection.error),
        measured: Some(selection.measured),
        skipped: selection.skipped,
        history: (selection.history.iter().map(|&(n, error)| (n, Some(error)))).collect(),
        residuals: selection.picked.iter().copied().map(Some).collect(),
    });
    SelectionRecord {
        first_step: interval.start,
        steps: interval.len(),
        layers: layers.collect(),
        diagnostics: None,
    }
}

/// Builds the record of the repair of a step.
pub(super) fn repair_record(repair: &Repair, step: &Step) -> RepairRecord {
    let untangled = repair.untangled.as_ref();
    let patch = |log: &PatchLog| PatchRecord {
        first_cell: log.first_cell,
        invalid_before: log.invalid_before,
        invalid: log.invalid,
        cells: log.n_cells,
        nodes: log.n_nodes,
        rings: log.rings,
        min_jacobian_before: log.least_before,
        min_jacobian: log.least,
        largest_move: log.largest_move,
    };
    let window = repair.window.as_ref();
    let kernel = repair.substeps.and_then(|parts| parts.kernel);
    let mut record = RepairRecord {
        step: step.index(),
        substeps: repair.substeps.map(|parts| parts.n),
        kernel: kernel.map(|kernel| kernel.name().to_owned()),
        inverted_before: repair.before.inverted,
        inverted: repair.after.inverted,
        unproven_before: (repair.before.unproven > 0).then_some(repair.before.unproven),
        low_before: (repair.low > 0).then_some(repair.low),
        low: (repair.still_low > 0).then_some(repair.still_low),
        window: window.map(|part| [part.steps.start, part.steps.end]),
        weight: window.map(|part| part.weight),
        patches: untangled.map(|untangled| untangled.patches.iter().map(patch).collect()),
        unrepaired: untangled.map(|untangled| untangled.left),
        sentence: String::new(),
    };
    record.sentence = record.note(step.azimuth_deg(), step.time_s()).to_string();
    record
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_deform::motion::{Schedule, Steps};

    #[test]
    fn a_repaired_step_without_an_azimuth_is_named_by_its_time() {
        let steps = Schedule::new(Steps::times_s([0.25])).steps();
        let record = RepairRecord {
            substeps: Some(2),
            inverted_before: 3,
            ..RepairRecord::default()
        };
        let step = &steps.expect("they are good")[0];
        assert_eq!(
            record.note(step.azimuth_deg(), step.time_s()).to_string(),
            "step 0 (0.25 s) had 3 inverted cells: 2 substeps leave none"
        );
    }
}

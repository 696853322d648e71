//! The run: plan, base points once a stretch, mode fields, then step after step; a step is written
//! while the next one is computed.

use super::base;
use super::checks::before_work;
use super::choose::missed;
use super::meshes::Meshes;
use super::output::{self, COLUMNS, Names, Part, Table};
use super::plan::Plan;
use super::progress::Progress;
use super::record::{Clock, Record, Timings};
use super::step::{Computed, add_arrays, compute, row, set};
use super::stretches::Stretches;
use crate::error::{Error, Result};
use crate::formats::{self, Format, WriteOptions, su2};
use crate::mesh::Mesh;
use crate::motion::{OnInverted, QualityOutput, Step};
use crate::quality::{Criterion, Reference};
use serde_json::json;
use std::ops::Range;
use std::path::PathBuf;

/// What a run is asked for.
#[derive(Debug, Clone)]
pub struct Request {
    /// The mesh file, for names and hashes.
    pub mesh: PathBuf,
    /// Where the files go.
    pub folder: PathBuf,
    /// Base points chosen before.
    pub base: Option<PathBuf>,
    /// The steps to write, counted from 0; all when left out.
    pub steps: Option<Range<usize>>,
    /// Whether files of an earlier run are replaced.
    pub force: bool,
    /// Conditions that fail the run.
    pub fail_on: Vec<Criterion>,
}

/// What a run came to.
#[derive(Debug, Clone, Default)]
pub struct Finished {
    /// Steps written.
    pub n_steps: usize,
    /// Base points used, the most at any step.
    pub n_base: usize,
    /// Largest displacement error before the correction, in mesh units.
    pub selection_error: f64,
    /// Largest distance of a written surface node from its place.
    pub surface_error: f64,
    /// Steps with inverted cells, and the most in one step.
    pub inverted_steps: usize,
    /// Most inverted cells in one step.
    pub most_inverted: usize,
    /// Smallest scaled Jacobian at any step.
    pub min_scaled_jacobian: Option<f64>,
    /// Sentences about conditions that failed.
    pub failures: Vec<String>,
    /// Sentences about what the user should know.
    pub warnings: Vec<String>,
    /// Bytes of one mesh file, the largest.
    pub mesh_bytes: u64,
    /// Where the time went.
    pub timings: Timings,
}

/// Bytes that the meshes of a sequence take: an estimate from nodes and cells.
pub fn estimate_bytes(plan: &Plan) -> u64 {
    let mesh = &plan.mesh;
    let cells = mesh.cells.connectivity().len() * 4 + mesh.cells.len() * 9;
    let arrays = mesh.point_arrays.iter().chain(&mesh.cell_arrays);
    let arrays: usize = arrays.map(|array| array.values.memory_bytes()).sum();
    ((plan.reference.len() * 24 + cells + arrays) * plan.motion.steps.len()) as u64
}

/// Runs a plan: base points, mode fields, and one mesh a step in the request's folder.
///
/// # Errors
/// [`Kind::Check`](crate::error::Kind::Check) when the tolerance cannot be met (base points are saved, no mesh is written), and
/// where `on_inverted = "stop"` stops it.
pub fn run(plan: &mut Plan, request: &Request, progress: &dyn Progress) -> Result<Finished> {
    let clock = Clock::start();
    let format = formats::by_name(&plan.schedule.output.format)?;
    let mut warnings = before_work(plan, format, &request.fail_on)?;
    warnings.extend(plan.warnings());
    if !plan.mesh.remove_field_arrays(&[su2::BOXES]).is_empty() {
        let sentence =
            "the boxes for free-form deformation (su2:FFD) fit the mesh at rest; left out";
        warnings.push(sentence.to_owned());
    }
    let part = Part::new(request.steps.clone(), plan.motion.steps.len())?;
    let names = Names::new(
        &request.folder,
        &request.mesh,
        format,
        plan.motion.steps.len(),
        part,
    );
    let record = Record::new(names.record(), plan, &request.mesh, &plan.schedule.path)?;
    let loaded = request
        .base
        .as_deref()
        .map(|path| base::load(plan, path))
        .transpose()?;
    output::prepare(&names, request.force)?;
    record.save()?;
    let mut mesh = std::mem::take(&mut plan.mesh);
    let mut stretches = Stretches::new(plan, &names, loaded, progress);
    let mut run = Run {
        plan,
        names: &names,
        format,
        record,
        finished: Finished {
            warnings,
            ..Finished::default()
        },
        written: Vec::new(),
        fail_on: request.fail_on.clone(),
    };
    let result = run.steps(&mut stretches, &mut mesh, progress);
    run.prepared(stretches);
    run.close(result, &clock)
}

/// How meshes are written.
pub(super) fn write_options(plan: &Plan) -> WriteOptions {
    let output = &plan.schedule.output;
    WriteOptions {
        encoding: output.encoding,
        compression: output.compression,
        precision: output.precision,
        tag_names: true,
    }
}

/// A run under way.
struct Run<'a> {
    plan: &'a Plan,
    names: &'a Names,
    format: &'static dyn Format,
    record: Record,
    finished: Finished,
    written: Vec<(Step, String)>,
    fail_on: Vec<Criterion>,
}

impl Run<'_> {
    fn steps(
        &mut self,
        stretches: &mut Stretches<'_>,
        mesh: &mut Mesh,
        progress: &dyn Progress,
    ) -> Result<()> {
        let plan = self.plan;
        let steps = &plan.motion.steps[self.names.steps()];
        stretches.enter(&steps[0])?;
        mesh.points.clone_from(&plan.reference);
        let wanted = plan.schedule.output.quality != QualityOutput::None;
        let reference = wanted.then(|| Reference::new(mesh));
        let mut table = Table::create(self.names.table())?;
        let mut meshes = Meshes::new(self.names, self.format, write_options(plan))?;
        progress.start("steps", Some(steps.len() as u64));
        let mut next = vec![[0.0; 3]; mesh.points.len()];
        let mut computed = compute(stretches, reference.as_ref(), mesh, &steps[0], &mut next)?;
        for (i, step) in steps.iter().enumerate() {
            std::mem::swap(&mut mesh.points, &mut next);
            self.judge(step, &computed)?;
            add_arrays(plan, mesh, &mut computed, reference.as_ref());
            let (written, following) = rayon::join(
                || self.write(&mut meshes, mesh, step),
                || {
                    let following = steps.get(i + 1)?;
                    Some(compute(
                        stretches,
                        reference.as_ref(),
                        mesh,
                        following,
                        &mut next,
                    ))
                },
            );
            let written = written?;
            self.finish_step(step, &computed, written, &mut table)?;
            progress.advance(1);
            if let Some(following) = following {
                computed = following?;
            }
        }
        progress.finish();
        Ok(())
    }

    fn write(&self, meshes: &mut Meshes, mesh: &Mesh, step: &Step) -> Result<Written> {
        let clock = Clock::start();
        let hash = meshes.write(mesh, step)?;
        Ok(Written {
            file: self.names.mesh(step.index),
            hash,
            seconds: clock.seconds(),
        })
    }

    /// The row of a step that is written, and what it adds to the run.
    fn finish_step(
        &mut self,
        step: &Step,
        computed: &Computed,
        written: Written,
        table: &mut Table,
    ) -> Result<()> {
        let finished = &mut self.finished;
        finished.timings.steps += computed.seconds;
        finished.timings.writing += written.seconds;
        finished.n_base = finished.n_base.max(computed.n_base);
        finished.selection_error = finished.selection_error.max(computed.selection_error);
        finished.n_steps += 1;
        if let Some((sentence, fails)) = missed(self.plan, step, computed.selection_error) {
            match fails {
                true => finished.failures.push(sentence),
                false => finished.warnings.push(sentence),
            }
        }
        let mut row = row(step, computed);
        let seconds = computed.seconds + written.seconds;
        set(&mut row, "file", written.file.clone());
        set(&mut row, "blake3", written.hash.to_string());
        set(&mut row, "seconds", format!("{seconds:.3}"));
        self.check_conditions(step, &row)?;
        table.row(&row)?;
        self.written.push((*step, written.file));
        Ok(())
    }

    /// Takes over what choosing base points and evaluating them came to.
    fn prepared(&mut self, stretches: Stretches<'_>) {
        self.record.set("selections", json!(stretches.selections));
        self.finished.warnings.extend(stretches.warnings);
        self.finished.timings.selection = stretches.seconds_selection;
        self.finished.timings.modes = stretches.seconds_modes;
    }

    /// Counts what is wrong with a step; stops where the schedule says so.
    fn judge(&mut self, step: &Step, computed: &Computed) -> Result<()> {
        let finished = &mut self.finished;
        finished.surface_error = finished.surface_error.max(computed.surface_error.0);
        let Some(summary) = &computed.summary else {
            return Ok(());
        };
        if let Some(worst) = summary.min_scaled_jacobian {
            let least = finished.min_scaled_jacobian.unwrap_or(f64::INFINITY);
            finished.min_scaled_jacobian = Some(least.min(worst.value));
        }
        if summary.inverted == 0 {
            return Ok(());
        }
        finished.inverted_steps += 1;
        finished.most_inverted = finished.most_inverted.max(summary.inverted);
        let sentence = format!(
            "step {} (azimuth {} degrees) has {} inverted cells, cell {} first",
            step.index,
            step.azimuth_deg,
            summary.inverted,
            summary.inverted_cells.first().copied().unwrap_or_default()
        );
        match self.plan.schedule.output.on_inverted {
            OnInverted::Stop => Err(Error::check(format!(
                "{sentence}; stopped before writing it"
            ))),
            OnInverted::Warn => {
                finished.warnings.push(sentence);
                Ok(())
            }
        }
    }

    fn check_conditions(&mut self, step: &Step, row: &[String]) -> Result<()> {
        let columns: Vec<(&str, Option<f64>)> = COLUMNS
            .iter()
            .zip(row)
            .map(|(column, value)| (*column, value.parse().ok()))
            .collect();
        for criterion in &self.fail_on {
            if criterion.is_met(&columns)? {
                let sentence = format!("step {}: {criterion}", step.index);
                self.finished.failures.push(sentence);
            }
        }
        Ok(())
    }

    /// Writes what closes a run, whether it went well or not.
    fn close(mut self, result: Result<()>, clock: &Clock) -> Result<Finished> {
        self.finished.timings.total = clock.seconds();
        let sizes = self.written.iter().filter_map(|(_, file)| {
            std::fs::metadata(self.names.path(file))
                .ok()
                .map(|found| found.len())
        });
        self.finished.mesh_bytes = sizes.max().unwrap_or(0);
        let outcome = match &result {
            Ok(()) => "complete".to_owned(),
            Err(error) => error.to_string(),
        };
        self.record.set("outcome", json!(outcome));
        self.record.set("steps_written", json!(self.written.len()));
        self.record
            .set("inverted_steps", json!(self.finished.inverted_steps));
        self.record
            .set("max_surface_error", json!(self.finished.surface_error));
        self.record.set("warnings", json!(self.finished.warnings));
        self.record.set("failures", json!(self.finished.failures));
        self.record.timings(&self.finished.timings);
        let series = match self.written.is_empty() {
            true => Ok(()),
            false => output::series(self.names, &self.written)
                .iter()
                .try_for_each(|(path, text)| formats::save_text(text, path)),
        };
        let saved = series.and_then(|()| self.record.save());
        // The first failure is the one to tell of.
        result.and(saved).map(|()| self.finished)
    }
}

/// A mesh that stands in the folder.
struct Written {
    file: String,
    hash: blake3::Hash,
    seconds: f64,
}

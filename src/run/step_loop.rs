//! The loop over the steps of a run: each is computed while the previous one is written or, if the file of all steps holds
//! it already, verified.

use super::base_points::BasePointStore;
use super::finish::read_step;
use super::finished::inverted;
use super::record::repair_record;
use super::resume::step_again;
use super::run::{LoopEnd, Run};
use super::step::{Computed, StepMesh, compute, row};
use super::writer::{Writer, hash_of};
use crate::record::WorstStep;
use azimesh_core::error::{Error, ErrorKind, Result};
use azimesh_core::geometry::vector::{Vector, add, scale};
use azimesh_core::note;
use azimesh_deform::motion::{OnInverted, QualityOutput, Step};
use azimesh_io::mesh::{Apart, MeshView};
use azimesh_quality::TaggedSurface;

/// The remaining work of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Task {
    /// To compute and write it.
    New,
    /// To compute its positions, which the file of all steps should hold.
    Recompute,
    /// To compute it with the repair of inverted cells, and to compare it with the file of all steps. Its record is lost, or
    /// velocities depend on the repair.
    Verify,
    /// To read its positions from the file of all steps, since computing them again would take as long as the first time.
    ReadBack,
}

impl Run<'_> {
    /// Writes or verifies all remaining steps.
    pub(super) fn step_loop(
        &mut self,
        writer: &mut Writer<'_>,
        base_points: &mut BasePointStore<'_>,
    ) -> Result<LoopEnd> {
        let todo = self.todo();
        let Some(first) = todo.first() else {
            return Ok(LoopEnd::Done);
        };
        let progress = self.deformation.progress();
        let mut task = self.task(first);
        if task == Task::New && self.plan.schedule.output.quality != QualityOutput::None {
            progress.start("reference", None);
            self.deformation.prepare_measures();
        }
        progress.start("steps", Some(todo.len() as u64));
        let (mut points, mut next) = (self.room_for_points(), self.room_for_points());
        let mut computed = task.run(base_points, first, &mut next);
        for (i, step) in todo.iter().enumerate() {
            self.check_stop(i > 0 || !self.rows.is_empty())?;
            if task == Task::New {
                self.mark_verified()?;
            }
            std::mem::swap(&mut points, &mut next);
            if task == Task::ReadBack && !self.read_back(writer, step, &mut points) {
                return Ok(self.restart_from(step));
            }
            let mut ready = self.accept(step, computed, task)?;
            if let Some(ready) = &ready {
                self.note_worst(step, ready, &points)?;
            }
            let following = todo.get(i + 1).map(|step| (step, self.task(step)));
            let was_resuming = writer.is_resuming;
            let mut compute = || {
                let (step, task) = following?;
                Some(task.run(base_points, step, &mut next))
            };
            let (is_same, then) = match &mut ready {
                None => (true, compute()),
                Some(ready) => {
                    let mut velocities = ready.found.velocities.take().unwrap_or_default();
                    let all_points = self
                        .deformation
                        .positions_to_write(&points, &mut velocities);
                    let mesh = self.step_mesh(&all_points, &mut velocities)?;
                    let mut write =
                        |by: Option<&dyn Apart>| write(writer, &mesh.view(by), step, ready, task);
                    let (written, then) = if self.deformation.is_on_ranks() {
                        // All ranks call both.
                        let written = self.write_on_ranks(&points, &velocities, &mut write);
                        (written, compute())
                    } else {
                        rayon::join(|| write(None), &mut compute)
                    };
                    (written?, then)
                }
            };
            self.note_choices(base_points)?;
            if !is_same {
                return Ok(self.restart_from(step));
            }
            if task != Task::New && was_resuming && !writer.is_resuming {
                self.warn_of_damage(step);
            }
            progress.advance(1);
            if let (Some((_, next_task)), Some(then)) = (following, then) {
                (task, computed) = (next_task, then);
            } else {
                break;
            }
        }
        Ok(LoopEnd::Done)
    }

    /// Records the worst cell of a step, if it is the worst so far.
    fn note_worst(&mut self, step: &Step, computed: &Computed, points: &[Vector]) -> Result<()> {
        let quality = computed.found.quality.as_ref();
        let least = quality.and_then(|quality| quality.cells.min_scaled_jacobian);
        let Some(least) = least.filter(|_| !self.deformation.is_on_ranks()) else {
            return Ok(());
        };
        let is_no_worse = |worst: &WorstStep| {
            let order = worst.scaled_jacobian.total_cmp(&least.value);
            order.then(worst.step.cmp(&step.index())).is_le()
        };
        if self.worst.as_ref().is_some_and(is_no_worse) {
            return Ok(());
        }
        let mesh = self.deformation.mesh_to_write()?;
        let nodes = mesh.cells.get(least.cell).nodes;
        let sum = nodes.iter().map(|&node| points[node as usize]);
        let position = scale(sum.fold([0.0; 3], add), 1.0 / nodes.len() as f64);
        let tagged = TaggedSurface::new(mesh);
        let nearest = tagged.nearest(points, &[position])[0];
        self.worst = Some(WorstStep {
            step: step.index(),
            azimuth_deg: step.azimuth_deg(),
            time_s: step.time_s(),
            scaled_jacobian: least.value,
            cell: Some(least.cell),
            position: Some(position),
            nearest_tag: nearest.map(|(_, tag)| tagged.name(tag).to_owned()),
            distance: nearest.map(|(squared, _)| squared.sqrt()),
        });
        Ok(())
    }

    /// Allocates the positions of a step of the nodes of this rank.
    pub(super) fn room_for_points(&self) -> Vec<Vector> {
        vec![[0.0; 3]; self.deformation.n_nodes_here()]
    }

    /// Returns the mesh of a step, with its arrays.
    fn step_mesh<'a>(
        &'a self,
        points: &'a [Vector],
        velocities: &mut Vec<Vector>,
    ) -> Result<StepMesh<'a>> {
        let origin = self.displaced_from.as_deref();
        let (deformation, volume) = (self.deformation, self.volume.as_ref());
        StepMesh::new(deformation, self.format, points, velocities, origin, volume)
    }

    /// Writes a step; this rank has positions and velocities of its own nodes.
    pub(super) fn write_on_ranks<T>(
        &self,
        points: &[Vector],
        velocities: &[Vector],
        write: &mut dyn FnMut(Option<&dyn Apart>) -> Result<T>,
    ) -> Result<T> {
        if !self.deformation.is_written_together() {
            return write(None);
        }
        let sync = self.names.commit.sync;
        (self.deformation).write_together(points, velocities, sync, &mut |by| write(Some(by)))
    }

    /// Finds the reference of displacements: the mesh that all steps share. It is the mesh of the first step if that replaces
    /// the mesh that was read.
    pub(super) fn find_start(&mut self, base_points: &mut BasePointStore<'_>) -> Result<()> {
        let first = &self.plan.motion.steps[0];
        let is_moved = self.plan.largest_displacement(0) > 0.0;
        if self.plan.schedule.output.displacement && is_moved && self.names.is_shared(0) {
            let mut points = self.room_for_points();
            compute(base_points, first, true, &mut points)?;
            let points = self
                .deformation
                .positions_to_write(&points, &mut Vec::new());
            self.displaced_from = Some(points.into_owned());
        }
        Ok(())
    }

    /// Returns the remaining work of a step.
    fn task(&self, step: &Step) -> Task {
        let is_kept = self.earlier.rows.contains_key(&step.index());
        let is_repaired = self.earlier.repairs.contains_key(&step.index());
        // Steps of an earlier schedule have modes and fields of their own.
        let n_earlier = self.record.content.extended.last().copied().unwrap_or(0);
        let is_slow =
            self.plan.schedule.rbf.substeps > 1 || is_repaired || step.index() < n_earlier;
        match (is_kept, self.earlier.is_unverified, is_slow) {
            (false, _, _) => Task::New,
            (true, true, _) => Task::Verify,
            (true, false, false) => Task::Recompute,
            // Velocities are not read back, and the positions in a file belong to all ranks.
            (true, false, true)
                if self.plan.velocity.is_some() || self.deformation.is_on_ranks() =>
            {
                Task::Verify
            }
            (true, false, true) => Task::ReadBack,
        }
    }

    /// Reads the positions of a step from the file of all steps; returns whether it has them.
    fn read_back(&self, writer: &Writer<'_>, step: &Step, points: &mut Vec<Vector>) -> bool {
        let path = self.names.path(&self.names.mesh(step.index()));
        let read = read_step(&path, self.format, writer.ends.len());
        let read = read.map_or(Vec::new(), |read| read.mesh.points);
        let is_whole = read.len() == points.len();
        if is_whole {
            *points = read;
        }
        is_whole
    }

    /// Discards rows of the earlier run from a step on.
    fn restart_from(&mut self, step: &Step) -> LoopEnd {
        self.warn_of_damage(step);
        self.earlier.rows.split_off(&step.index());
        self.finished.n_kept = self.earlier.rows.len();
        LoopEnd::Restart
    }

    fn warn_of_damage(&mut self, step: &Step) {
        let (file, step) = (self.names.mesh(step.index()), step.index());
        let note = note!(
            "differs_from_table",
            "{file}: step {step} is not what steps.csv says; the file is written again from there on"
        );
        if !self.finished.warnings.contains(&note) {
            self.finished.warnings.push(note);
        }
    }

    /// Returns a step that can be written; `None` if it is skipped.
    fn accept(
        &mut self,
        step: &Step,
        computed: Result<Computed>,
        task: Task,
    ) -> Result<Option<Computed>> {
        let is_new = matches!(task, Task::New | Task::Verify);
        let judged = match computed {
            Ok(computed) if is_new => self.judge(step, computed),
            computed => computed.map_err(|error| at_step(step, error)),
        };
        match judged {
            Ok(computed) => Ok(Some(computed)),
            Err(error) if self.passes_over(&error) => {
                let note = note!("skipped", "{}; skipped", error.message);
                let note = note.with("step", step.index());
                self.finished.skipped.push(note);
                Ok(None)
            }
            Err(mut error) => {
                if is_of_the_step(&error) {
                    error.message += "; stopped before writing it";
                }
                Err(error)
            }
        }
    }

    pub(super) fn passes_over(&self, error: &Error) -> bool {
        self.request.keep_going && is_of_the_step(error)
    }

    /// Computes the finished steps of a run whose record is lost again, and leaves out steps whose bytes differ, so that
    /// other inputs or another version are found. If one file holds all steps, [`Run::step_loop`] does that.
    ///
    /// # Errors
    /// If the first of them that moves anything differs: its file is whole, so its run had other inputs.
    pub(super) fn verify_steps(&mut self, base_points: &mut BasePointStore<'_>) -> Result<()> {
        let kept: Vec<usize> = self.earlier.rows.keys().copied().collect();
        let progress = self.deformation.progress();
        progress.start("verifying", Some(kept.len() as u64));
        let mut is_ours = false;
        for index in kept {
            self.check_stop(!self.rows.is_empty())?;
            let step = self.plan.motion.steps[index];
            let moves = self.plan.largest_displacement(index) > 0.0;
            if self.is_same(&step, base_points)? {
                is_ours |= moves;
            } else if moves && !is_ours {
                return Err(self.not_ours(index));
            } else {
                self.earlier.rows.remove(&index);
                let fault = "is not what this run writes";
                let note = step_again(index, &self.names.mesh(index), fault);
                self.finished.warnings.push(note);
            }
            progress.advance(1);
        }
        progress.finish();
        self.rows.clone_from(&self.earlier.rows);
        self.finished.n_kept = self.rows.len();
        self.mark_verified()
    }

    /// Checks if a step, computed again, gives the bytes of its row.
    fn is_same(&mut self, step: &Step, base_points: &mut BasePointStore<'_>) -> Result<bool> {
        let mut points = self.room_for_points();
        let computed = compute(base_points, step, true, &mut points)?;
        let computed = self.judge(step, computed)?;
        let mut velocities = computed.found.velocities.unwrap_or_default();
        let all_points = self
            .deformation
            .positions_to_write(&points, &mut velocities);
        let mesh = self.step_mesh(&all_points, &mut velocities)?;
        let options = self.plan.schedule.output.write_options();
        let hash = self.write_on_ranks(&points, &velocities, &mut |by| {
            let mesh = mesh.view(by);
            hash_of(&mesh, self.names, step.index(), self.format, &options)
        })?;
        Ok(self.earlier.rows[&step.index()].blake3 == hash.to_string())
    }

    fn not_ours(&self, index: usize) -> Error {
        let record = self.names.record();
        Error::input(format!(
            "this run cannot be resumed: {} is not what the mesh and the schedule give at step {index}, so the earlier run \
             had another mesh, schedule, option or version of azimesh (its {} is lost); --force starts a new run",
            self.names.mesh(index),
            record.file_name().unwrap_or_default().display()
        ))
        .file(&self.names.folder)
    }

    /// Marks the kept rows as verified, and writes run.json.
    pub(super) fn mark_verified(&mut self) -> Result<()> {
        if !self.earlier.is_unverified {
            return Ok(());
        }
        self.earlier.is_unverified = false;
        self.record.content.steps_kept = Some(self.finished.n_kept);
        self.record.save()
    }

    /// Writes run.json, unless it would hold rows that are not verified.
    pub(super) fn save_record(&self) -> Result<()> {
        if self.earlier.is_unverified {
            return Ok(());
        }
        self.record.save()
    }

    /// Records faults of a step; returns an error if the schedule asks for that.
    pub(super) fn judge(&mut self, step: &Step, computed: Computed) -> Result<Computed> {
        self.finished.timings.steps += computed.seconds;
        if let Some(repair) = &computed.found.repair {
            let record = repair_record(repair, step);
            self.earlier.repairs.insert(step.index(), record);
            self.note_repairs()?;
        }
        let Some(first) = computed.found.first_inverted() else {
            return Ok(computed);
        };
        self.first_inverted.insert(step.index(), first);
        if self.plan.schedule.output.on_inverted == OnInverted::Stop {
            let row = row(step, &computed.found);
            let note = inverted(&row, step.azimuth_deg().is_some(), Some(first));
            return Err(Error::check(note.to_string()));
        }
        Ok(computed)
    }
}

/// Checks if another step may succeed after this error.
fn is_of_the_step(error: &Error) -> bool {
    matches!(error.kind, ErrorKind::Check | ErrorKind::Input)
}

/// Adds the step to the error of a computation.
fn at_step(step: &Step, mut error: Error) -> Error {
    if is_of_the_step(&error) {
        error.message = format!("{step}: {}", error.message);
    }
    error
}

impl Task {
    fn run(
        self,
        base_points: &mut BasePointStore<'_>,
        step: &Step,
        points: &mut [Vector],
    ) -> Result<Computed> {
        match self {
            Task::New | Task::Verify => compute(base_points, step, true, points),
            Task::Recompute => compute(base_points, step, false, points),
            Task::ReadBack => Ok(Computed::default()),
        }
    }
}

/// Writes a step, or verifies it; returns whether it agrees with the rows.
fn write(
    writer: &mut Writer<'_>,
    mesh: &MeshView<'_>,
    step: &Step,
    computed: &Computed,
    task: Task,
) -> Result<bool> {
    if task != Task::New {
        return writer.verify(mesh, step);
    }
    let row = row(step, &computed.found);
    writer.write(mesh, step, row, computed.seconds)?;
    Ok(true)
}

//! The loop over the steps of a run: each is computed while the one before is written or, where the file of all
//! steps holds it already, verified there.

use super::base_points::BasePointStore;
use super::finished::inverted;
use super::record::repair_record;
use super::run::{LoopEnd, Run};
use super::step::{Computed, StepMesh, compute, recompute, row};
use super::writer::Writer;
use azimesh_core::diagnostic::run::RunNote;
use azimesh_core::error::{Error, ErrorKind, Result};
use azimesh_core::geometry::vector::Vector;
use azimesh_deform::motion::{OnInverted, QualityOutput, Step};
use azimesh_io::formats::{self, Location, ReadOptions};
use azimesh_io::mesh::{Apart, MeshView};

/// What is to be done for a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Task {
    /// To compute and write it.
    New,
    /// To compute its positions, which the file of all steps should hold.
    Recompute,
    /// To compute it with the repair of inverted cells, of which no record is left or on which velocities depend, and to
    /// compare it with the file of all steps.
    Verify,
    /// To read its positions from the file of all steps: to compute them again would take as long as the
    /// first time.
    ReadBack,
}

impl Run<'_> {
    /// Writes or verifies all steps that are left.
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
            let following = todo.get(i + 1).map(|step| (step, self.task(step)));
            let was_resuming = writer.is_resuming();
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
                    let (written, then) = match self.deformation.is_on_ranks() {
                        false => rayon::join(|| write(None), &mut compute),
                        // All ranks call both.
                        true => {
                            let written = self.write_on_ranks(&points, &velocities, &mut write);
                            (written, compute())
                        }
                    };
                    (written?, then)
                }
            };
            self.note_choices(base_points)?;
            if !is_same {
                return Ok(self.restart_from(step));
            }
            if task != Task::New && was_resuming && !writer.is_resuming() {
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

    /// Room for the positions of a step of the nodes of this rank.
    pub(super) fn room_for_points(&self) -> Vec<Vector> {
        vec![[0.0; 3]; self.deformation.n_nodes_here()]
    }

    /// The mesh of a step with the arrays that its format holds: it would say of each other one that it is left out, which is known
    /// already.
    pub(super) fn step_mesh<'a>(
        &'a self,
        points: &'a [Vector],
        velocities: &mut Vec<Vector>,
    ) -> Result<StepMesh<'a>> {
        let mesh = StepMesh::new(self.deformation, points)?;
        match (self.format.holds.arrays, self.format.holds.displacement) {
            (true, _) => mesh.with_arrays(self.deformation, velocities),
            (false, true) => {
                let from = self.displaced_from.as_deref();
                Ok(mesh.with_displacement(self.plan, from))
            }
            (false, false) => Ok(mesh),
        }
    }

    /// Writes a step of which this rank has the positions and velocities `own`.
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

    /// Finds where displacements begin: at the mesh that all steps share. That is the one of the first step where it is
    /// in the place of the mesh that was read.
    pub(super) fn find_start(&mut self, base_points: &mut BasePointStore<'_>) -> Result<()> {
        let first = &self.plan.motion.steps[0];
        let is_moved = self.plan.largest_displacement(0) > 0.0;
        if self.plan.schedule.output.displacement
            && is_moved
            && (self.names.in_case(0)).is_some_and(|case| case.format.is_shared(case.file))
        {
            let mut points = self.room_for_points();
            compute(base_points, first, &mut points)?;
            let points = self
                .deformation
                .positions_to_write(&points, &mut Vec::new());
            self.displaced_from = Some(points.into_owned());
        }
        Ok(())
    }

    /// What is to be done for a step.
    fn task(&self, step: &Step) -> Task {
        let is_kept = self.earlier.rows.contains_key(&step.index());
        let is_repaired = self.earlier.repairs.contains_key(&step.index());
        let is_slow = self.plan.schedule.rbf.substeps > 1 || is_repaired;
        match (is_kept, self.earlier.is_unverified, is_slow) {
            (false, _, _) => Task::New,
            (true, true, _) => Task::Verify,
            (true, false, false) => Task::Recompute,
            // Velocities are not read back, and a file has the positions of all ranks.
            (true, false, true)
                if self.plan.velocity.is_some() || self.deformation.is_on_ranks() =>
            {
                Task::Verify
            }
            (true, false, true) => Task::ReadBack,
        }
    }

    /// Takes the positions of a step from the file of all steps; tells whether they are there.
    fn read_back(&self, writer: &Writer<'_>, step: &Step, points: &mut Vec<Vector>) -> bool {
        let path = self.names.path(&self.names.mesh(step.index()));
        let options = ReadOptions {
            step: Some(writer.ends().len()),
            ..ReadOptions::default()
        };
        let read =
            Location::open(&path).and_then(|file| formats::read_as(self.format, &file, &options));
        match read {
            Ok(read) if read.mesh.points.len() == points.len() => {
                *points = read.mesh.points;
                true
            }
            _ => false,
        }
    }

    /// Rows of the earlier run from a step on do not count any more.
    fn restart_from(&mut self, step: &Step) -> LoopEnd {
        self.warn_of_damage(step);
        self.earlier.rows.split_off(&step.index());
        self.n_kept = self.earlier.rows.len();
        LoopEnd::Restart
    }

    pub(super) fn warn_of_more(&mut self) {
        let file = self.names.mesh(self.names.steps().start);
        self.warnings.push(RunNote::CutOff { file }.into());
    }

    fn warn_of_damage(&mut self, step: &Step) {
        let note = RunNote::DiffersFrom {
            file: self.names.mesh(step.index()),
            step: step.index(),
        };
        let note = note.into();
        if !self.warnings.contains(&note) {
            self.warnings.push(note);
        }
    }

    /// A step that can be written; `None` where it is passed over.
    fn accept(
        &mut self,
        step: &Step,
        computed: Result<Computed>,
        task: Task,
    ) -> Result<Option<Computed>> {
        let judged =
            computed
                .map_err(|error| at_step(step, error))
                .and_then(|computed| match task {
                    Task::New | Task::Verify => self.judge(step, computed),
                    Task::Recompute | Task::ReadBack => Ok(computed),
                });
        match judged {
            Ok(computed) => Ok(Some(computed)),
            Err(error) if self.passes_over(&error) => {
                let reason = error.message;
                self.skipped.push(RunNote::Skipped { reason }.into());
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

    /// Keeps in mind what is wrong with a step; refuses it where the schedule says so.
    pub(super) fn judge(&mut self, step: &Step, computed: Computed) -> Result<Computed> {
        self.seconds_steps += computed.seconds;
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

/// Whether another step may go well where this one failed.
fn is_of_the_step(error: &Error) -> bool {
    matches!(error.kind, ErrorKind::Check | ErrorKind::Input)
}

/// Says at which step a computation failed.
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
            Task::New | Task::Verify => compute(base_points, step, points),
            Task::Recompute => recompute(base_points, step, points),
            Task::ReadBack => Ok(Computed::default()),
        }
    }
}

/// Writes a step, or verifies it; tells whether it agrees with the rows.
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

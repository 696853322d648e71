//! Finished steps of a run whose record is lost: they are computed again, and kept where that gives the
//! bytes that they have. So neither other inputs nor another version slips in. Where one file holds all
//! steps, the step loop ([`super::step_loop`]) does that.

use super::base_points::BasePointStore;
use super::meshes::hash_of;
use super::run::Run;
use super::step::compute;
use azimesh_core::diagnostic::run::{FileFault, RunNote};
use azimesh_core::error::{Error, Result};
use azimesh_deform::motion::Step;

impl Run<'_> {
    /// Computes the finished steps again, and leaves out those whose bytes differ.
    ///
    /// # Errors
    /// Where the first of them that moves anything is such a one: its file is whole, so that its run had
    /// other inputs.
    pub(super) fn verify_steps(&mut self, base_points: &mut BasePointStore<'_>) -> Result<()> {
        let kept: Vec<usize> = self.earlier.rows.keys().copied().collect();
        let progress = self.deformation.progress();
        progress.start("verifying", Some(kept.len() as u64));
        let mut is_ours = false;
        for index in kept {
            self.check_stop(!self.rows.is_empty())?;
            let step = self.plan.motion.steps[index];
            let moves = self.plan.largest_displacement(index) > 0.0;
            match self.is_same(&step, base_points)? {
                true => is_ours |= moves,
                false if moves && !is_ours => return Err(self.not_ours(index)),
                false => self.leave_out(index),
            }
            progress.advance(1);
        }
        progress.finish();
        self.rows.clone_from(&self.earlier.rows);
        self.n_kept = self.rows.len();
        self.mark_verified()
    }

    /// Whether a step, computed again, gives the bytes of its row.
    fn is_same(&mut self, step: &Step, base_points: &mut BasePointStore<'_>) -> Result<bool> {
        let mut points = self.room_for_points();
        let computed = compute(base_points, step, &mut points)?;
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

    fn leave_out(&mut self, index: usize) {
        self.earlier.rows.remove(&index);
        let note = RunNote::StepAgain {
            step: index,
            file: self.names.mesh(index),
            fault: FileFault::OtherBytes,
        };
        self.warnings.push(note.into());
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
        self.record.content.steps_kept = Some(self.n_kept);
        self.record.save()
    }

    /// Writes run.json, unless it would hold rows that are not verified.
    pub(super) fn save_record(&self) -> Result<()> {
        match self.earlier.is_unverified {
            true => Ok(()),
            false => self.record.save(),
        }
    }
}

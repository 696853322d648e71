//! Checks and estimates before a run: warnings, and the memory and disk that it needs.
//!
//! Owns the effects of the motion on the mesh that the user should know. `deform` refuses invalid input, and `run` writes
//! files.

mod bodies;
mod disk;
mod displacements;
mod edges;
mod memory;
mod motion;
mod output;
mod seams;
mod surface_files;
mod tags;
mod words;

pub use disk::existing_folder;
pub(crate) use disk::{Demand, check_disk};
pub use displacements::LargestDisplacements;
pub use memory::{Fits, check_memory, estimate_memory};
pub(crate) use motion::body_motion;
pub use motion::{BodyAtStep, bodies_at};
pub(crate) use output::before_work;
pub use output::estimate_bytes;
pub use surface_files::check_surface_files;
pub use words::motion_in_words;

use azimesh_core::{Note, note};
use azimesh_deform::motion::{Step, TurningRotor};
use azimesh_deform::{Layer, Plan};

/// Number of steps at which surfaces are checked for intersections.
const LOOKED_AT: usize = 72;

/// Returns warnings about the motion before interpolation.
pub fn warnings(plan: &Plan, extremes: &LargestDisplacements) -> Vec<Note> {
    let mut warnings = plan.motion.shared_nodes(&plan.boundary);
    warnings.extend(plan.motion.warnings(&plan.schedule.rbf));
    warnings.extend(tags::fixed_that_move(plan));
    warnings.extend(tags::on_no_cell(plan));
    warnings.extend(bodies::small_radius(plan, extremes));
    warnings.extend(edges::staying(plan));
    warnings.extend(edges::leaving_planes(plan));
    warnings.extend(extremes.off.iter().map(|off| off.note(plan)));
    warnings.extend(surface_files::begins_moved(plan));
    warnings.extend(bodies::of_several_blades(plan));
    // A rotating mesh has that velocity too.
    let is_carried = plan.motion.rotors.iter().any(TurningRotor::is_inertial);
    let no_velocity = |layer: &Layer| layer.modes.n_modes == 0 && !is_carried;
    if plan.velocity.as_ref().is_some_and(no_velocity) {
        warnings.push(note!(
            "no_velocity",
            "output.velocity is set, but the velocities of all bodies are 0 at every step"
        ));
    }
    warnings.extend(bodies::conflicts(plan, &evenly(plan, LOOKED_AT), extremes));
    warnings
}

/// Returns all steps, or an even selection of many.
pub fn evenly(plan: &Plan, most: usize) -> Vec<&Step> {
    let steps = &plan.motion.steps;
    steps.iter().step_by(steps.len().div_ceil(most)).collect()
}

#[cfg(test)]
mod tests {
    use azimesh_deform::Plan;
    use azimesh_deform::motion::Schedule;
    use azimesh_io::mesh::Mesh;
    use std::path::Path;

    /// Builds the plan of a schedule on the mesh in a file.
    pub(super) fn plan(mesh: &str, schedule: &str) -> Plan {
        plan_of(Mesh::read(mesh).expect("it is good"), schedule)
    }

    pub(super) fn plan_of(mesh: Mesh, schedule: &str) -> Plan {
        let schedule = Schedule::parse(schedule, Path::new("s.toml")).expect("it is good");
        Plan::new(mesh, schedule).expect("they fit").0
    }
}

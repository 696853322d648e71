//! Checks of surface files for a solver that moves its volume itself.

use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::in_digits;
use azimesh_core::{Note, note};
use azimesh_deform::Plan;
use azimesh_deform::motion::{Step, SurfaceOutput};
use azimesh_io::formats::{by_extension, by_name, n_su2_zones, without_compression};
use azimesh_io::mesh::MeshView;
use std::path::Path;

/// Tolerance of the steps' times, as a part of their interval.
const UNEVEN: f64 = 1e-6;

/// Refuses surface files with node numbers that differ from the mesh of SU2, or with steps that are not its iterations;
/// `path` is the file from which the mesh was read.
///
/// # Errors
/// If SU2 would move other nodes, or at other times.
pub fn check_surface_files(plan: &Plan, mesh: &MeshView<'_>, path: &Path) -> Result<()> {
    if plan.schedule.output.surface == SurfaceOutput::None {
        return Ok(());
    }
    let refused = |message: String| {
        let message = format!("output.surface = \"su2\": {message}");
        Err(Error::input(message).file(&plan.schedule.path))
    };
    let name = path.to_string_lossy();
    let is_su2 = by_extension(Path::new(without_compression(&name)));
    let is_su2 = is_su2.is_ok_and(|format| format.name == "su2");
    if !is_su2 && plan.schedule.output.format() != "su2" {
        return refused(format!(
            "the nodes of {name} have numbers, but SU2 needs those of its own mesh; give the .su2 file as the mesh, or \
             set output.format = \"su2\" and let SU2 read what is written for step 0"
        ));
    }
    if by_name(plan.schedule.output.format())?.is_folder() {
        return refused(format!(
            "there is no place for these files in the folder of format = \"{}\"; use another format",
            plan.schedule.output.format()
        ));
    }
    let n_zones = n_su2_zones(mesh);
    if n_zones > 1 {
        return refused(format!(
            "the mesh has {n_zones} SU2 zones, each with node numbers of its own; one zone is possible"
        ));
    }
    match uneven(&plan.motion.steps) {
        None => Ok(()),
        Some(step) => refused(format!(
            "step {step} is not as far from the last one as step 1 is from step 0; SU2 takes a step for each iteration, \
             so that all need the same interval, its TIME_STEP"
        )),
    }
}

/// Returns a note if the surfaces are not at rest at step 0, at which SU2 starts.
pub(super) fn begins_moved(plan: &Plan) -> Option<Note> {
    let distance = plan.largest_displacement(0);
    let is_asked = plan.schedule.output.surface == SurfaceOutput::Su2;
    (is_asked && distance > 0.0).then(|| {
        note!(
            "begins_moved",
            "output.surface = \"su2\": step 0 has moved the surfaces by up to {}; SU2 begins with its mesh as it is, so that its \
             first iteration moves them by that within one TIME_STEP",
            in_digits(distance, 4)
        )
    })
}

/// Returns the first step whose interval differs from the first interval; by time if it is known, else by azimuth.
fn uneven(steps: &[Step]) -> Option<usize> {
    let at = Step::time;
    let [first, second, ..] = steps else {
        return None;
    };
    let interval = at(second) - at(first);
    let is_even = |(i, step): (usize, &Step)| {
        let wanted = at(first) + i as f64 * interval;
        (at(step) - wanted).abs() <= UNEVEN * interval.abs()
    };
    (0..steps.len()).find(|&i| !is_even((i, &steps[i])))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(times: &[f64]) -> Vec<Step> {
        let steps = azimesh_deform::motion::Steps::times_s(times.iter().copied());
        let schedule = azimesh_deform::motion::Schedule::new(steps);
        schedule.steps().expect("they are good")
    }

    #[test]
    fn the_first_step_of_another_interval_is_found() {
        assert_eq!(uneven(&at(&[0.0])), None);
        assert_eq!(uneven(&at(&[0.0, 0.5])), None);
        let tenths: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.1).collect();
        assert_eq!(uneven(&at(&tenths)), None);
        assert_eq!(uneven(&at(&[0.0, 0.1, 0.2, 0.4])), Some(3));
    }
}

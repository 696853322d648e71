//! Whether the support radius is large enough for the motion to fade out within it.

use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::diagnostic::preflight::PreflightNote;
use azimesh_core::geometry::vector::distance;
use azimesh_deform::Plan;
use azimesh_deform::motion::Interpolate;

/// Surface points times steps that are looked at, at most.
const MOST: usize = 2_000_000;
/// The advice is on the safe side by this factor.
const SAFE: f64 = 1.1;

/// A warning where cells fold whatever the mesh: with a displacement `d` that is zero at the distance `R`, the slope
/// of the field reaches `s d / R`, `s` the steepest slope of the kernel, and cells fold where that is above one. Not of
/// rotations that are interpolated as such.
pub(super) fn small(plan: &Plan) -> Option<Diagnostic> {
    let surface = &plan.surface;
    let turns = plan.schedule.rbf.interpolate == Interpolate::Twist;
    let rings = plan
        .layers
        .iter()
        .any(|layer| layer.rings().next().is_some());
    let has_still = surface.body.contains(&None)
        || plan
            .motion
            .surface
            .tags
            .iter()
            .any(|tag| tag.role.is_none());
    if turns || rings || !has_still {
        return None;
    }
    let (steps, substeps) = (&plan.motion.steps, plan.schedule.rbf.substeps);
    let stride = (steps.len() * surface.points.len()).div_ceil(MOST).max(1);
    let mut worst = (0.0, 0, 0);
    for step in steps.iter().step_by(stride) {
        let poses = plan.motion.poses(step, 1.0);
        for (at, body) in surface.body.iter().enumerate() {
            let Some(body) = body.map(usize::from) else {
                continue;
            };
            let x = surface.points[at];
            let by = distance(poses[body].place(surface.nodes[at], x), x);
            if by > worst.0 {
                worst = (by, body, step.index());
            }
        }
    }
    let (whole, body, step) = worst;
    let (radius, slope) = (plan.basis.radius, plan.basis.kernel.steepest());
    let by = whole / substeps as f64;
    if slope * by <= radius {
        return None;
    }
    let note = PreflightNote::SmallRadius {
        radius,
        kernel: plan.basis.kernel.name(),
        body: plan.motion.bodies[body].name.clone(),
        distance: by,
        step,
        substeps,
        needed: (
            SAFE * slope * by,
            (SAFE * slope * whole / radius).ceil() as usize,
        ),
    };
    Some(note.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_core::diagnostic::NoteKind;
    use azimesh_deform::motion::Schedule;
    use azimesh_io::mesh::Mesh;
    use std::path::Path;

    /// The radius and the substeps that are advised, where the airfoil moves by 0.35.
    fn advised(rbf: &str) -> Option<(f64, usize)> {
        let text = format!(
            "azimuth.values = [0]\nboundaries.others = \"fixed\"\nrbf = {{ {rbf} }}\nselection.tolerance = 1e-2\n\
             body = [ {{ name = \"a\", tags = [\"airfoil\"], rigid.translate = [0, 0.35, 0] }} ]\n"
        );
        let schedule = Schedule::parse(&text, Path::new("s.toml")).expect("it is good");
        let mesh = Mesh::read("testdata/naca0012.vtu").expect("it is good");
        let plan = Plan::new(mesh, schedule).expect("they fit").0;
        small(&plan).map(|note| match note.kind {
            NoteKind::Preflight(PreflightNote::SmallRadius { needed, .. }) => needed,
            other => panic!("{other}"),
        })
    }

    #[test]
    fn a_radius_within_which_the_motion_cannot_fade_out_is_told_with_one_that_is_enough() {
        assert_eq!(advised("support_radius = 2.0"), None);
        for kernel in ["c0", "c2", "c4", "c6"] {
            let rbf = |radius: f64, substeps: usize| {
                format!(
                    "kernel = \"wendland-{kernel}\", support_radius = {radius:?}, substeps = {substeps}"
                )
            };
            let (radius, substeps) = advised(&rbf(0.5, 1)).expect("it is too small");
            assert_eq!(advised(&rbf(radius, 1)), None, "{kernel}");
            assert_eq!(advised(&rbf(0.5, substeps)), None, "{kernel}");
        }
    }
}

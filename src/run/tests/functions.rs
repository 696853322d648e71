//! Runs of a schedule made in memory whose body is moved by a function.

use crate::preflight::estimate_memory;
use crate::run::{Finished, Request, run};
use azimesh_core::error::Result;
use azimesh_deform::motion::{Body, Role, Schedule, Step, Steps};
use azimesh_deform::{Deformation, Plan};
use azimesh_io::mesh::Mesh;
use std::path::Path;

const MESH: &str = "testdata/sphere_in_box_raw.vtu";

fn bend(step: &Step, places: &[[f64; 3]], displacements: &mut [[f64; 3]]) {
    for (x, d) in places.iter().zip(displacements) {
        d[1] = 0.01 * step.index() as f64 * x[0];
    }
}

fn deformation(folder: &Path, body: Body) -> Deformation {
    let mut schedule = Schedule::new(Steps::azimuths_deg([0.0, 45.0]))
        .body(body)
        .fixed(["inlet", "outlet", "walls"]);
    // A run notes the hash of a file.
    schedule.path = folder.join("s.toml");
    std::fs::write(&schedule.path, "").expect("it can be written");
    let mesh = Mesh::read(MESH).expect("it is there");
    let deformation = Deformation::builder(mesh, schedule).plan();
    deformation.expect("they fit")
}

fn resume(folder: &Path, body: Body) -> Result<Finished> {
    let request = Request {
        mesh: MESH.into(),
        folder: folder.join("out"),
        resume: true,
        no_sync: true,
        ..Request::default()
    };
    run(&deformation(folder, body), &request)
}

fn sphere() -> Body {
    Body::new("ball", ["sphere"])
}

#[test]
fn a_run_is_resumed_with_a_function_of_the_same_name_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let begun = resume(folder.path(), sphere().displacements_named("bend 1", bend));
    assert_eq!(begun.expect("it runs").n_kept, 0);
    let again = resume(folder.path(), sphere().displacements_named("bend 1", bend));
    assert_eq!(again.expect("it is the same").n_kept, 2);
    let other = resume(folder.path(), sphere().displacements_named("bend 2", bend));
    let error = other.expect_err("the name is another").to_string();
    let told =
        "its functions were \"bend 1\" of body \"ball\"; now they are \"bend 2\" of body \"ball\"";
    assert!(error.contains(told), "{error}");
}

#[test]
fn a_run_is_not_resumed_where_a_function_has_no_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let begun = resume(folder.path(), sphere().displacements(bend));
    assert_eq!(begun.expect("it runs").n_steps, 2);
    let error = resume(folder.path(), sphere().displacements(bend));
    let error = error.expect_err("the function has no name").to_string();
    let told = "body \"ball\" is moved by a function without a name";
    assert!(error.contains(told), "{error}");
}

#[test]
fn the_memory_forecast_counts_the_displacements_that_a_function_gives() {
    let folder = tempfile::tempdir().expect("a folder");
    let deformation = deformation(folder.path(), sphere().displacements(bend));
    let (mut plan, part) = Plan::new(
        Mesh::read(MESH).expect("it is there"),
        deformation.plan().schedule.clone(),
    )
    .expect("they fit");
    let counted = estimate_memory(&plan, &part.mesh);
    let roles = &plan.motion.surface.nodes.roles;
    let moving = |role: &&Role| matches!(role, Role::Moving(_));
    let n_nodes = roles.iter().filter(moving).count();
    let bytes = plan.motion.memory_bytes();
    assert_eq!(bytes, 2 * 24 * n_nodes);
    plan.motion.bodies.clear();
    let without = estimate_memory(&plan, &part.mesh);
    assert!(counted - without >= bytes as u64, "{counted} {without}");
}

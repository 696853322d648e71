//! Runs of schedules and formats that cannot be given in files.

mod functions;
mod surface;
mod times;

use super::{Finished, Request, run};
use azimesh_core::error::Result;
use azimesh_deform::Deformation;
use azimesh_deform::motion::Schedule;
use azimesh_io::mesh::Mesh;
use std::path::Path;

/// Runs a schedule on a mesh; the meshes go to the folder `out` in `folder`.
fn deform(folder: &Path, mesh: &str, schedule: &str, request: Request) -> Result<Finished> {
    let path = folder.join("s.toml");
    std::fs::write(&path, schedule).expect("it can be written");
    let schedule = Schedule::parse(schedule, &path)?;
    let deformation = Deformation::builder(Mesh::read(mesh)?, schedule).plan()?;
    let request = Request {
        mesh: mesh.into(),
        folder: folder.join("out"),
        no_sync: true,
        ..request
    };
    run(&deformation, &request)
}

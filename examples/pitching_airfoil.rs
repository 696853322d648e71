//! An airfoil that pitches by five degrees, in 37 steps of ten degrees: a row of quality a step.
//!
//! `cargo run --release --example pitching_airfoil`

#![allow(clippy::print_stdout)] // an example prints what it does

use azimesh::{Body, Cyclic, Deformation, Mesh, Schedule, Steps};

fn main() -> azimesh::Result<()> {
    let mesh = Mesh::read("testdata/naca0012.vtu")?;
    let schedule = Schedule::new(Steps::azimuth_deg(0.0, 360.0, 10.0))
        .body(Body::new("airfoil", ["airfoil"]).cyclic(Cyclic::new().pitch_deg(1, 5.0, 0.0)))
        .fixed(["farfield"]);
    let deformation = Deformation::new(mesh, schedule)?;
    for step in deformation.steps() {
        let points = deformation.points_at(step)?;
        let quality = deformation.quality_of(&points)?;
        println!(
            "{step}: least scaled Jacobian {:.3}",
            quality.min_scaled_jacobian
        );
    }
    Ok(())
}

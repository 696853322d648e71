//! A wing that bends and twists as a table of a structural code says, while it pitches; velocities of the
//! nodes, and one mesh written by hand.
//!
//! `cargo run --release --example elastic_blade -- bent.vtu`

#![allow(clippy::print_stdout)] // an example prints what it does

use azimesh::{Beam, Body, Cyclic, Deformation, Mesh, Rotor, Schedule, Steps, Table};

/// Stations along the span, from the root to the tip, in mesh units.
const STATIONS: [f64; 4] = [0.0, 0.4, 0.8, 1.2];

fn main() -> azimesh::Result<()> {
    let mesh = Mesh::read("testdata/wing_on_plane.vtu")?;
    let rotor = Rotor::new()
        .span_axis([0.0, 0.0, 1.0])
        .shaft_axis([0.0, 1.0, 0.0])
        .rpm(60.0);
    let wing = Body::new("wing", ["wing"])
        .beam(Beam::new(bending()))
        .cyclic(Cyclic::new().collective_deg(2.0));
    let schedule = Schedule::new(Steps::azimuth_deg(0.0, 315.0, 45.0))
        .rotor(rotor)
        .body(wing)
        .fixed(["farfield"])
        .slide(["symmetry"])
        .support_radius(8.0)
        .tolerance(1e-3)
        .velocity();
    let deformation = Deformation::new(mesh, schedule)?;
    let tip = tip_of(deformation.mesh())?;
    let mut most = 0.0;
    let mut bent = Vec::new();
    for step in deformation.steps() {
        let points = deformation.points_at(step)?;
        let velocities = deformation.velocities_at(step)?;
        let fastest = velocities.iter().map(|v| v[0].hypot(v[1]).hypot(v[2]));
        let up = points[tip][1] - deformation.mesh().points()[tip][1];
        println!(
            "{step}: the tip is up by {up:.3}, velocities are up to {:.3}, {} inverted cells",
            fastest.fold(0.0, f64::max),
            deformation.quality_of(&points)?.inverted
        );
        if up > most {
            (most, bent) = (up, points);
        }
    }
    if let Some(path) = std::env::args().nth(1) {
        let view = deformation.mesh().view().with_points(&bent);
        for note in view.write(path)? {
            println!("note: {note}");
        }
    }
    Ok(())
}

/// The outermost node of the wing.
fn tip_of(mesh: &Mesh) -> azimesh::Result<usize> {
    let span = |node: &usize| mesh.points()[*node][2];
    let nodes = mesh
        .tag_nodes("wing")?
        .into_iter()
        .map(|node| node as usize);
    let tip = nodes.max_by(|a, b| span(a).total_cmp(&span(b)));
    Ok(tip.expect("a tag has nodes"))
}

/// Bending up with the square of the station, once a revolution, and a twist with it.
fn bending() -> Table {
    let columns = [
        "azimuth_deg",
        "station",
        "dx",
        "dy",
        "dz",
        "rot_x_deg",
        "rot_y_deg",
        "rot_z_deg",
    ];
    let rows = (0..8).flat_map(|k| {
        let azimuth = 45.0 * f64::from(k);
        let size = azimuth.to_radians().sin();
        STATIONS.map(|r| {
            let along = r / STATIONS[3];
            let up = 0.15 * size * along * along;
            let slope = (0.3 * size * along / STATIONS[3]).atan().to_degrees();
            [azimuth, r, 0.0, 0.0, up, -3.0 * size * along, -slope, 0.0]
        })
    });
    Table::from_rows(columns, rows)
}

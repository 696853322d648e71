//! Modes of a bending blade: 670,000 surface nodes and 360 steps, of which none is stored.
//!
//! Run with `cargo bench --bench modes`; other numbers may be given:
//! `cargo bench --bench modes -- 100000 360`.

#![allow(clippy::print_stdout)] // a benchmark prints its table

use azimesh::sample::{BladeOptions, SizeOptions, blade};
use azimesh_core::geometry::vector::{Vector, sub};
use azimesh_deform::motion::{Motion, Schedule};
use azimesh_io::mesh::{Boundary, ZoneSides};
use azimesh_rbf::modes::{Form, Modes};
use std::fmt::Write as _;
use std::ops::Range;
use std::time::Instant;

const STATIONS: usize = 20;

/// A table of flap bending and twist in four harmonics.
fn table() -> String {
    let mut text = String::from("azimuth_deg,station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n");
    for azimuth in (0..360).step_by(2) {
        let psi = f64::from(azimuth).to_radians();
        for station in 0..STATIONS {
            let r = 0.9 + 4.7 * station as f64 / (STATIONS - 1) as f64;
            let s = r / 5.6;
            let bend = s * s * (0.2 * psi.cos() + 0.05 * (3.0 * psi).sin());
            let slope = -2.0 * bend.to_degrees() / r;
            let twist = s * (2.0 * psi.sin() + 0.7 * (4.0 * psi).cos());
            writeln!(text, "{azimuth},{r},0,0,{bend},{twist},{slope},0").expect("a string grows");
        }
    }
    text
}

/// The motion, and the mesh's surface nodes that move.
fn motion(n_surface: usize, n_steps: usize) -> (Motion, Vec<(u32, Vector)>) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("beam.csv"), table()).expect("it can be written");
    let schedule = format!(
        "azimuth = {{ stop = {}, step = {} }}\nboundaries.fixed = [\"outer\"]\n[[body]]\nname = \"blade\"\ntags = [\"blade\"]\n\
         beam = {{ table = \"beam.csv\", interpolation = \"cubic\" }}\ncyclic = {{ collective = 8, pitch = [ {{ sin = -5 }} ], coning = 3 }}\n",
        360.0 - 180.0 / n_steps as f64,
        360.0 / n_steps as f64
    );
    let path = folder.path().join("bend.toml");
    std::fs::write(&path, schedule).expect("it can be written");
    let size = SizeOptions {
        surface_nodes: Some(2 * n_surface),
        layers: Some(4),
        ..SizeOptions::default()
    };
    let sample = blade(&BladeOptions {
        size,
        ..BladeOptions::default()
    });
    let mesh = sample.expect("it can be made").mesh;
    let sides_of = |cells: &_| Ok(ZoneSides::of(&mesh, cells));
    let motion = Schedule::read(&path)
        .and_then(|schedule| schedule.resolve(&Boundary::of(&mesh), &sides_of));
    // The blade's nodes are the first layer.
    let n_wall = mesh.points.len() / 5;
    let nodes = (0..n_wall as u32).zip(mesh.points[..n_wall].iter().copied());
    let nodes = nodes.collect();
    (motion.expect("it is good"), nodes)
}

fn main() {
    let numbers: Vec<usize> = std::env::args()
        .filter_map(|arg| arg.parse().ok())
        .collect();
    let n_surface = numbers.first().copied().unwrap_or(670_000);
    let (motion, nodes) = motion(n_surface, numbers.get(1).copied().unwrap_or(360));
    let poses: Vec<_> = motion
        .steps
        .iter()
        .map(|step| motion.poses(step, 1.0))
        .collect();
    let fill = |step: usize, range: Range<usize>, out: &mut [Vector]| {
        for ((node, x), out) in nodes[range].iter().zip(out) {
            *out = sub(poses[step][0].place(*node, *x), *x);
        }
    };
    let start = Instant::now();
    let mut out = vec![[0.0; 3]; nodes.len()];
    for step in 0..motion.steps.len().min(10) {
        fill(step, 0..nodes.len(), &mut out);
    }
    let places = (nodes.len() * motion.steps.len().min(10)) as f64;
    println!(
        "{:.0} ns to move a node on one thread",
        1e9 * start.elapsed().as_secs_f64() / places
    );
    for tolerance in [1e-4, 1e-6] {
        let start = Instant::now();
        let modes = Modes::of_displacements(
            nodes.len(),
            poses.len(),
            0.01 * tolerance,
            Form::Scalar,
            fill,
        );
        let modes = modes.expect("displacements are finite");
        println!(
            "{} nodes, {} steps, within {:.0e}: {} modes, {:.2} s",
            nodes.len(),
            poses.len(),
            0.01 * tolerance,
            modes.n_modes,
            start.elapsed().as_secs_f64()
        );
    }
}

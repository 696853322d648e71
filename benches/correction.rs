//! The correction of the exact surface: the tree of facets, the gaps between surfaces and the closest
//! points of the nodes within the fade radius, on the sample blade.
//!
//! Run with `cargo bench --bench correction`; numbers of nodes and of surface nodes may be given:
//! `cargo bench --bench correction -- 8000000 670000`.

#![allow(clippy::print_stdout)] // a benchmark prints its table

use azimesh::sample::{BladeOptions, SizeOptions, blade};
use azimesh_core::geometry::closest::ClosestSurface;
use azimesh_deform::Plan;
use azimesh_deform::motion::Schedule;
use azimesh_rbf::correct::{Correction, FADE_RADIUS_PER_ERROR};
use azimesh_rbf::field::Field;
use std::path::Path;
use std::time::Instant;

/// Runs of each part; the quickest counts.
const RUNS: usize = 3;

/// The result of `work`, and the seconds that its quickest run took.
fn timed<T>(work: impl Fn() -> T) -> (T, f64) {
    let run = || {
        let start = Instant::now();
        let result = work();
        (result, start.elapsed().as_secs_f64())
    };
    let (mut result, mut least) = run();
    for _ in 1..RUNS {
        let (next, seconds) = run();
        result = next;
        least = least.min(seconds);
    }
    (result, least)
}

fn main() {
    let sizes: Vec<usize> = std::env::args()
        .filter_map(|arg| arg.parse().ok())
        .collect();
    let size = SizeOptions {
        nodes: Some(sizes.first().copied().unwrap_or(400_000)),
        surface_nodes: sizes.get(1).copied(),
        ..SizeOptions::default()
    };
    let sample = blade(&BladeOptions {
        size,
        ..BladeOptions::default()
    })
    .expect("it can be made");
    let schedule = Schedule::parse(&sample.schedule, Path::new("blade.toml")).expect("it is good");
    let (plan, part) = Plan::new(sample.mesh, schedule).expect("it fits");
    let (surface, n_modes) = (&plan.surface, plan.n_modes());
    let error = plan.tolerance;
    let residuals: Vec<f64> = (0..surface.points.len() * n_modes)
        .map(|i| error * (i as f64).sin())
        .collect();
    println!(
        "{} nodes, {} facets, {n_modes} modes, fade radius {:.2e}, {} threads",
        part.mesh.points.len(),
        surface.facets.len(),
        FADE_RADIUS_PER_ERROR * error,
        rayon::current_num_threads()
    );
    let (_, tree) = timed(|| ClosestSurface::new(&surface.points[..], &surface.facets));
    println!("tree:         {tree:>8.3} s");
    let (correction, built) =
        timed(|| Correction::new(&surface.points, &surface.facets, &residuals, n_modes, error));
    println!("tree, gaps:   {built:>8.3} s");
    let empty = || Field {
        nodes: None,
        n_modes,
        values: vec![0.0; part.mesh.points.len() * n_modes],
    };
    let (_, zeros) = timed(empty);
    let (field, added) = timed(|| {
        let mut field = empty();
        correction.add_to(&mut field, &part.mesh.points);
        field
    });
    let rows = field.values.chunks_exact(n_modes);
    let near = rows
        .filter(|row| row.iter().any(|value| *value != 0.0))
        .count();
    let seconds = (added - zeros).max(0.0);
    println!(
        "closest point {seconds:>8.3} s for {near} nodes within it: {:.0} ns each and thread",
        seconds * 1e9 * rayon::current_num_threads() as f64 / near.max(1) as f64
    );
}

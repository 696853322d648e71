//! Selection in rounds against one point a sweep, with the same Cholesky factor and the same sweep,
//! on a blade with 100,000 surface nodes and 36 steps of cyclic pitch and flap.
//!
//! Run with `cargo bench --bench selection`; the plain greedy takes minutes. A tolerance in chords
//! may be given: `cargo bench --bench selection -- 1e-3`.

#![allow(clippy::print_stdout)] // a benchmark prints its table

use azimesh::sample::{BladeOptions, SizeOptions, blade};
use azimesh_deform::Plan;
use azimesh_deform::motion::Schedule;
use azimesh_rbf::select::{Limits, Selection, select};
use std::path::Path;
use std::time::Instant;

fn timed(plan: &Plan, limits: Limits) -> (Selection, f64) {
    let start = Instant::now();
    let selection = select(
        &plan.layers[0].space,
        plan.targets(&plan.layers[0]),
        limits,
        &mut |_, _| {},
    )
    .expect("it can be solved");
    (selection, start.elapsed().as_secs_f64())
}

fn main() {
    let relative = std::env::args()
        .find_map(|arg| arg.parse::<f64>().ok())
        .unwrap_or(1e-4);
    let size = SizeOptions {
        nodes: Some(1_000_000),
        surface_nodes: Some(100_000),
        ..SizeOptions::default()
    };
    let sample = blade(&BladeOptions {
        size,
        ..BladeOptions::default()
    })
    .expect("it can be made");
    let schedule = Schedule::parse(&sample.schedule, Path::new("blade.toml")).expect("it is good");
    let (plan, _) = Plan::new(sample.mesh, schedule).expect("it fits");
    let tolerance = plan.tolerance * relative / 1e-4;
    println!(
        "{} surface nodes, {} modes, tolerance {tolerance:.2e}",
        plan.surface.nodes.len(),
        plan.n_modes()
    );
    let rounds = Limits::in_rounds(tolerance, 20_000, plan.surface.nodes.len());
    let (in_rounds, quick) = timed(&plan, rounds);
    println!(
        "in rounds:    {:>5} points, {quick:>8.2} s, {} sweeps, error {:.2e}",
        in_rounds.base.len(),
        in_rounds.history.len(),
        in_rounds.error
    );
    let (one_by_one, slow) = timed(
        &plan,
        Limits {
            candidates: 1,
            ..rounds
        },
    );
    println!(
        "one by one:   {:>5} points, {slow:>8.2} s, error {:.2e}",
        one_by_one.base.len(),
        one_by_one.error
    );
    println!(
        "ratio:        {:.3} points, {:.1} times faster",
        in_rounds.base.len() as f64 / one_by_one.base.len() as f64,
        slow / quick
    );
}

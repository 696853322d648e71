//! A flexible airfoil in a flow: a made-up structure and a made-up load take turns until they agree, and
//! the mesh follows. Then the derivative of the lift's moment by the surface, as a shape optimiser wants it.
//!
//! `cargo run --release --example fluid_structure`

#![allow(clippy::print_stdout)] // an example prints what it does

use azimesh::{Mesh, Morph, MorphOptions, Result};

/// Load of one surface node per unit of slope.
const LOAD: f64 = 0.3;
/// Bending of the camber line by a unit of load at its end.
const COMPLIANCE: f64 = 0.6;

fn main() -> Result<()> {
    let mesh = Mesh::read("testdata/naca0012.vtu")?;
    let morph = Morph::new(
        mesh,
        MorphOptions {
            moving: "airfoil".into(),
            fixed: "farfield".into(),
            max_points: 80,
            ..Default::default()
        },
    )?;
    println!(
        "{} nodes, {} of them move, {} base points",
        morph.mesh().points.len(),
        morph.moving().len(),
        morph.base_points().len()
    );

    let mut displacements = vec![[0.0; 3]; morph.moving().len()];
    for iteration in 1..=8 {
        let points = morph.points(&displacements)?;
        let next = structure(&morph, &flow(&morph, &points));
        let change = largest_change(&displacements, &next);
        displacements = next;
        println!(
            "iteration {iteration}: displacements change by {change:.2e}, the correction is up to {:.1e} steep",
            morph.report(&displacements)?.largest_slope
        );
    }
    let report = morph.report(&displacements)?;
    println!(
        "the base points leave {:.1e}, which the correction takes off; steepest at node {}: {:.3}",
        report.largest_residual, report.steepest_node, report.largest_slope
    );

    // The sum of the heights of all nodes, each weighted by its place along the chord.
    let gradient: Vec<[f64; 3]> = morph
        .mesh()
        .points
        .iter()
        .map(|x| [0.0, x[0], 0.0])
        .collect();
    let by_surface = morph.pull_back(&gradient)?;
    let largest = by_surface.iter().map(|g| g[1].abs()).fold(0.0, f64::max);
    println!(
        "derivatives by {} surface nodes, the largest {largest:.3}",
        by_surface.len()
    );
    Ok(())
}

/// Loads on the moving nodes: upwards, the more the more the airfoil bends up ahead of them.
fn flow(morph: &Morph, points: &[[f64; 3]]) -> Vec<f64> {
    let at_rest = &morph.mesh().points;
    let load = |&node: &u32| {
        let (x, rest) = (points[node as usize], at_rest[node as usize]);
        LOAD * (0.1 + x[1] - rest[1])
    };
    morph.moving().iter().map(load).collect()
}

/// A beam clamped at a quarter of its chord: its nodes rise with the square of the distance from there
/// times the moment of the loads.
fn structure(morph: &Morph, loads: &[f64]) -> Vec<[f64; 3]> {
    let arm = |&node: &u32| morph.mesh().points[node as usize][0] - 0.25;
    let arms: Vec<f64> = morph.moving().iter().map(arm).collect();
    let moment: f64 = arms.iter().zip(loads).map(|(arm, load)| arm * load).sum();
    let bent = |arm: &f64| [0.0, COMPLIANCE * moment * arm * arm, 0.0];
    arms.iter().map(bent).collect()
}

fn largest_change(before: &[[f64; 3]], after: &[[f64; 3]]) -> f64 {
    let changes = before.iter().zip(after).map(|(a, b)| (a[1] - b[1]).abs());
    changes.fold(0.0, f64::max)
}

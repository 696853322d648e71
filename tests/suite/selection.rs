//! What the selection promises, by brute force on random schedules: with `sequence` and a tolerance
//! the interpolant is within it at every surface node at every step.

use azimesh::sample::{BladeOptions, SizeOptions, blade, naca0012};
use azimesh_core::geometry::vector::{distance, sub};
use azimesh_core::progress::Silent;
use azimesh_core::ranks::Ranks;
use azimesh_deform::motion::{Role, Schedule};
use azimesh_deform::{Plan, choose};
use proptest::prelude::*;
use std::path::Path;

/// Largest distance between a prescribed displacement and the plain double sum over the base
/// points, over all surface nodes and steps.
fn true_error(plan: &Plan) -> (usize, f64) {
    let selection = &choose(
        plan,
        &plan.selection_intervals()[0],
        &Ranks::alone(),
        &Silent,
    )
    .expect("it can be solved")[0];
    let layer_modes = &plan.layers[0].modes;
    let r = layer_modes.n_modes;
    let surface = &plan.motion.surface.nodes;
    let mut worst: f64 = 0.0;
    for (&node, role) in surface.nodes.iter().zip(&surface.roles) {
        let x = plan.boundary.position(node);
        let mut modes = vec![0.0; r];
        for (j, &at) in selection.base.iter().enumerate() {
            let phi = plan.basis.between(&x, &plan.surface.points[at]);
            for (mode, weight) in modes
                .iter_mut()
                .zip(&selection.interpolant.weights[j * r..])
            {
                *mode += phi * weight;
            }
        }
        for step in &plan.motion.steps {
            let exact = match role {
                Role::Moving(body) => {
                    let pose = plan.motion.pose(usize::from(*body), step);
                    sub(pose.apply(x), x)
                }
                _ => [0.0; 3],
            };
            let mut interpolated = [0.0; 3];
            if r > 0 {
                for (mode, c) in modes
                    .iter()
                    .zip(layer_modes.at_step(step.index()).chunks(3))
                {
                    for axis in 0..3 {
                        interpolated[axis] += mode * c[axis];
                    }
                }
            }
            worst = worst.max(distance(exact, interpolated));
        }
    }
    (selection.base.len(), worst)
}

fn size(nodes: usize) -> SizeOptions {
    SizeOptions {
        nodes: Some(nodes),
        ..SizeOptions::default()
    }
}

fn plan(mesh: azimesh_io::mesh::Mesh, schedule: &str) -> Plan {
    let schedule = Schedule::parse(schedule, Path::new("random.toml")).expect("it is a schedule");
    Plan::new(mesh, schedule).expect("it fits the mesh").0
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 10, ..ProptestConfig::default() })]

    #[test]
    fn sequence_keeps_its_tolerance_at_every_node_and_step(
        collective in -10.0..15.0f64,
        sine in -8.0..8.0f64,
        cosine in -8.0..8.0f64,
        coning in 0.0..3.0f64,
        flap in -3.0..3.0f64,
        exponent in 2.5..4.0f64,
        step in 15.0..60.0f64,
        kernel in prop::sample::select(vec!["wendland-c0", "wendland-c2", "wendland-c4"]),
    ) {
        let tolerance = 10f64.powf(-exponent);
        let mesh = blade(&BladeOptions { size: size(8000), ..BladeOptions::default() })
            .expect("it can be made")
            .mesh;
        let schedule = format!(
            "[azimuth]\nstop = 360.0\nstep = {step}\n\
             [[body]]\nname = \"blade\"\ntags = [\"blade\"]\n\
             [body.cyclic]\ncollective = {collective}\npitch = [{{ sin = {sine}, cos = {cosine} }}]\n\
             coning = {coning}\nflap = [{{ sin = {flap} }}]\n\
             [boundaries]\nfixed = [\"outer\"]\n\
             [rbf]\nkernel = \"{kernel}\"\nsupport_radius = 5.0\n\
             [selection]\ntolerance = {tolerance}\n"
        );
        let plan = plan(mesh, &schedule);
        let (n_base, error) = true_error(&plan);
        prop_assert!(n_base > 0);
        prop_assert!(error <= tolerance, "{n_base} base points leave {error} of {tolerance}");
    }
}

#[test]
fn all_leaves_nothing_at_any_surface_node() {
    let mesh = naca0012(&size(2000)).expect("it can be made").mesh;
    let schedule = "[azimuth]\nvalues = [0.0, 90.0, 200.0]\n\
        [[body]]\nname = \"airfoil\"\ntags = [\"airfoil\"]\n[body.cyclic]\npitch = [{ sin = 12.0 }]\n\
        [boundaries]\nfixed = [\"farfield\"]\n[rbf]\nsupport_radius = 5.0\n\
        [selection]\nmethod = \"all\"\n";
    let plan = plan(mesh, schedule);
    let (n_base, error) = true_error(&plan);
    assert_eq!(n_base, plan.surface.nodes.len());
    assert!(error < 1e-9, "{error}");
}

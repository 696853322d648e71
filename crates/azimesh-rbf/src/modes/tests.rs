//! Modes against the motions that they stand for.

use super::*;
use azimesh_core::geometry::vector::{add, norm};

fn cloud(n: usize) -> Vec<Vector> {
    (0..n)
        .map(|i| std::array::from_fn(|k| ((i * 3 + k) as f64 * 12.9898).sin() * 2.0 + 5.0))
        .collect()
}

fn pitch_and_flap(k: usize) -> Transform {
    let psi = k as f64 * 0.1;
    Transform::rotation([1.0, 0.0, 0.0], [0.0; 3], 0.2 * psi.sin()).then(&Transform::rotation(
        [0.0, 1.0, 0.0],
        [0.5, 0.0, 0.0],
        0.1 * psi.cos(),
    ))
}

#[test]
fn modes_give_the_displacements_of_two_rigid_bodies_to_round_off() {
    let points = cloud(300);
    let body: Vec<_> = (0..300)
        .map(|i| match i % 3 {
            0 => None,
            b => Some(b - 1),
        })
        .collect();
    let poses: Vec<Vec<_>> = [0, 7]
        .iter()
        .map(|start| (0..36).map(|k| pitch_and_flap(k + start)).collect())
        .collect();
    let surface = RigidSurface {
        points: &points,
        body: &body,
    };
    let vector = Modes::of_rigid_bodies(surface, &poses, Form::Vector).expect("it converges");
    assert!(vector.n_modes <= 3 * 16 && vector.n_modes.is_multiple_of(3));
    assert!(vector.truncation < 1e-13, "{}", vector.truncation);
    let modes = Modes::of_rigid_bodies(surface, &poses, Form::Scalar).expect("it converges");
    assert!(modes.n_modes <= 8);
    assert!(modes.truncation < 1e-13, "{}", modes.truncation);
    for mode in 0..modes.n_modes {
        let square: f64 = (0..36)
            .flat_map(|k| (0..3).map(move |axis| (k, axis)))
            .map(|(k, axis)| modes.at_step(k)[3 * mode + axis].powi(2))
            .sum();
        assert!((square - 1.0).abs() < 1e-12, "C C^T = I");
    }
}

#[test]
fn the_truncation_is_the_largest_distance_over_nodes_and_steps() {
    let points = cloud(300);
    let body: Vec<_> = (0..300).map(|i| (i % 50 > 7).then_some(i / 150)).collect();
    let surface = RigidSurface {
        points: &points,
        body: &body,
    };
    let poses: Vec<Vec<_>> = [0, 7]
        .iter()
        .map(|start| (0..5).map(|k| pitch_and_flap(k + start)).collect())
        .collect();
    let mut modes = Modes::of_rigid_bodies(surface, &poses, Form::Scalar).expect("it converges");
    for value in modes.values.iter_mut().filter(|value| **value != 0.0) {
        *value *= 1.0 + 1e-3 * value.sin();
    }
    let distances = (0..300).flat_map(|node| (0..5).map(move |step| (node, step)));
    let distances = distances.filter_map(|(node, step)| {
        let moved = poses[usize::from(body[node]?)][step].apply(points[node]);
        let displaced = add(points[node], modes.displacement(node, step));
        Some(norm(sub(moved, displaced)))
    });
    let largest = distances.fold(0.0, f64::max);
    assert!(largest > 1e-4);
    assert!((modes.largest_truncation(surface, &poses) - largest).abs() < 1e-13);
}

#[test]
fn a_translation_takes_one_mode_and_no_motion_none() {
    let points = cloud(10);
    let body = vec![Some(0); 10];
    let surface = RigidSurface {
        points: &points,
        body: &body,
    };
    let shift = vec![vec![Transform::translation([0.0, 0.3, 0.1]); 4]];
    let modes = Modes::of_rigid_bodies(surface, &shift, Form::Scalar).expect("it converges");
    assert_eq!(modes.n_modes, 1);
    let still = vec![vec![Transform::IDENTITY; 4]];
    let modes = Modes::of_rigid_bodies(surface, &still, Form::Scalar).expect("it converges");
    assert_eq!(modes.n_modes, 0);
}

/// A stretched blade of span 1, and its displacement when it bends, twists and flaps (eqs. 2 and 3 of
/// the method, with smooth shapes along the span).
fn blade(n: usize) -> Vec<Vector> {
    let part = |i: usize, by: f64| (i as f64 * by).fract();
    let point = |i: usize| {
        [
            0.2 + 0.8 * part(i, 0.754_877_666),
            0.06 * (part(i, 0.569_840_291) - 0.3),
            0.007 * (part(i, 0.437_159_141) - 0.5),
        ]
    };
    (0..n).map(point).collect()
}

fn bent(x: &Vector, step: usize, n_steps: usize) -> Vector {
    let psi = std::f64::consts::TAU * step as f64 / n_steps as f64;
    let r = x[0];
    let (flap, lag) = (
        r * r * (0.05 + 0.03 * psi.sin() + 0.01 * (2.0 * psi).cos()),
        0.01 * r * r * psi.cos(),
    );
    let twist = 0.17 - 0.13 * psi.sin() + 0.03 * r * (2.0 * psi).sin();
    let (rot_y, rot_z) = (-2.0 * flap / r, 2.0 * lag / r);
    let line = [r, 0.0, 0.0];
    let axis = |i: usize| std::array::from_fn(|k| f64::from(u8::from(k == i)));
    let turn = [twist, rot_y, rot_z]
        .iter()
        .enumerate()
        .fold(Transform::IDENTITY, |turn, (i, angle)| {
            turn.then(&Transform::rotation(axis(i), [0.0; 3], *angle))
        });
    let section = turn.apply(sub(*x, line));
    let beta = 0.046 + 0.056 * psi.sin() - 0.007 * psi.cos();
    let hinge = Transform::rotation([0.0, 1.0, 0.0], [0.0; 3], -beta);
    sub(hinge.apply(add(section, [r, lag, flap])), *x)
}

const STEPS: usize = 72;

fn of_blade(points: &[Vector], limit: f64, form: Form) -> Modes {
    Modes::of_displacements(points.len(), STEPS, limit, form, |step, nodes, out| {
        for (out, x) in out.iter_mut().zip(&points[nodes]) {
            *out = bent(x, step, STEPS);
        }
    })
    .expect("it converges")
}

/// The largest distance of modes from a motion, node by node and step by step.
fn largest_error(
    modes: &Modes,
    n: usize,
    n_steps: usize,
    of: impl Fn(usize, usize) -> Vector,
) -> f64 {
    let places = (0..n).flat_map(|node| (0..n_steps).map(move |step| (node, step)));
    let error = |(node, step)| norm(sub(modes.displacement(node, step), of(node, step)));
    places.map(error).fold(0.0, f64::max)
}

fn assert_orthonormal(modes: &Modes, n_steps: usize) {
    for (i, j) in [
        (0, 0),
        (0, 1),
        (modes.n_modes - 1, modes.n_modes - 1),
        (0, modes.n_modes - 1),
    ] {
        let product: f64 = (0..n_steps)
            .flat_map(|step| (0..3).map(move |axis| (step, axis)))
            .map(|(step, axis)| {
                modes.at_step(step)[3 * i + axis] * modes.at_step(step)[3 * j + axis]
            })
            .sum();
        let form = if i == j { 1.0 } else { 0.0 };
        assert!(
            (product - form).abs() < 1e-12,
            "C C^T = I at {i}, {j}: {product}"
        );
    }
}

#[test]
fn a_bending_blade_is_met_within_its_limit_by_the_fewest_modes() {
    let points = blade(1100);
    for (limit, most) in [(1e-3, 11), (1e-6, 20), (0.0, 40)] {
        let modes = of_blade(&points, limit, Form::Scalar);
        let error = largest_error(&modes, 1100, STEPS, |node, step| {
            bent(&points[node], step, STEPS)
        });
        assert!((error - modes.truncation).abs() < 1e-14);
        assert!(error <= f64::max(limit, 1e-14), "{limit}: {error}");
        assert!(modes.n_modes <= most, "{limit}: {}", modes.n_modes);
        assert_orthonormal(&modes, STEPS);
        // One mode less would not do.
        let mut fewer = modes.clone();
        let last = modes.n_modes - 1;
        for row in fewer.values.chunks_exact_mut(modes.n_modes) {
            row[last] = 0.0;
        }
        let error = largest_error(&fewer, 1100, STEPS, |node, step| {
            bent(&points[node], step, STEPS)
        });
        assert!(error > f64::max(limit, 5e-15), "{limit}: {error}");
    }
}

#[test]
fn vector_modes_meet_the_same_limit_with_one_coefficient_each() {
    let points = blade(1500);
    let modes = of_blade(&points, 1e-4, Form::Vector);
    let error = largest_error(&modes, 1500, STEPS, |node, step| {
        bent(&points[node], step, STEPS)
    });
    assert!(
        (error - modes.truncation).abs() < 1e-14 && error <= 1e-4,
        "{error}"
    );
    assert!(
        modes.n_modes.is_multiple_of(3) && modes.n_modes <= 3 * 12,
        "{}",
        modes.n_modes
    );
    for step in 0..STEPS {
        for (at, c) in modes.at_step(step).iter().enumerate() {
            assert!(
                *c == 0.0 || at % 3 == at / 3 % 3,
                "component a of column 3 m + a"
            );
        }
    }
}

#[test]
fn more_modes_than_the_first_columns_are_found() {
    // Each node goes its own way.
    let random = |node: usize, step: usize| -> Vector {
        std::array::from_fn(|axis| {
            (((node * 31 + step) * 3 + axis) as f64 * 78.233).sin() * 43758.5453 % 1.0
        })
    };
    for (n, n_steps, form) in [
        (700, 30, Form::Scalar),
        (50, 30, Form::Scalar),
        (700, 90, Form::Vector),
        (9, 90, Form::Vector),
    ] {
        let modes = Modes::of_displacements(n, n_steps, 1e-9, form, |step, nodes, out| {
            for (out, node) in out.iter_mut().zip(nodes) {
                *out = random(node, step);
            }
        })
        .expect("it converges");
        let error = largest_error(&modes, n, n_steps, random);
        assert!(
            error < 1e-9 && (error - modes.truncation).abs() < 1e-13,
            "{error}"
        );
        let (most, columns) = match form {
            Form::Scalar => (n.min(3 * n_steps), 1),
            Form::Vector => ((3 * n).min(n_steps), 3),
        };
        assert_eq!(modes.n_modes, most * columns);
    }
}

#[test]
fn one_step_one_node_and_no_motion_have_their_modes() {
    let of = |n: usize, n_steps: usize, by: f64, form: Form| {
        Modes::of_displacements(n, n_steps, 0.0, form, |step, nodes, out| {
            for (out, node) in out.iter_mut().zip(nodes) {
                let (node, step) = (node as f64, step as f64);
                *out = [by * (node + step).sin(), by * node * step, by];
            }
        })
        .expect("it converges")
    };
    for form in [Form::Scalar, Form::Vector] {
        for (n, n_steps) in [(1, 1), (1, 9), (40, 1), (600, 2)] {
            let modes = of(n, n_steps, 0.1, form);
            let error = largest_error(&modes, n, n_steps, |node, step| {
                let (node, step) = (node as f64, step as f64);
                [0.1 * (node + step).sin(), 0.1 * node * step, 0.1]
            });
            assert!(
                error <= 1e-13 * 100.0,
                "{n} nodes, {n_steps} steps: {error}"
            );
            assert_eq!(modes.n_steps(), n_steps);
        }
        assert_eq!(of(30, 5, 0.0, form).n_modes, 0);
        assert_eq!(of(0, 5, 0.1, form).n_modes, 0);
        assert_eq!(of(5, 0, 0.1, form).n_modes, 0);
    }
}

#[test]
fn a_displacement_that_is_no_number_is_refused() {
    for wrong in [f64::NAN, f64::INFINITY, 1e200] {
        let modes = Modes::of_displacements(900, 3, 1e-3, Form::Scalar, |step, nodes, out| {
            for (out, node) in out.iter_mut().zip(nodes) {
                *out = [0.0, 1.0, if (node, step) == (700, 2) { wrong } else { 0.5 }];
            }
        });
        assert!(modes.is_err(), "{wrong}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "takes long without optimization")]
fn modes_are_the_same_bytes_on_any_number_of_threads() {
    let points = blade(3_000);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads are there");
        pool.install(|| of_blade(&points, 1e-4, Form::Scalar))
    };
    let one = on(1);
    for threads in [2, 3] {
        assert!(on(threads) == one, "{threads} threads");
    }
}

#[test]
fn rigid_bodies_stay_exact_beside_a_bending_blade() {
    let points = blade(900);
    let body: Vec<_> = (0..900).map(|i| (i % 3 == 0).then_some(0)).collect();
    let poses = vec![(0..STEPS).map(pitch_and_flap).collect::<Vec<_>>()];
    let surface = RigidSurface {
        points: &points,
        body: &body,
    };
    let exact = |node: usize, step: usize| match body[node] {
        Some(_) => sub(poses[0][step].apply(points[node]), points[node]),
        None if node % 3 == 1 => bent(&points[node], step, STEPS),
        None => [0.0; 3],
    };
    for form in [Form::Scalar, Form::Vector] {
        let modes = Modes::of_mixed(surface, &poses, STEPS, 1e-4, form, |step, nodes, out| {
            for (out, node) in out.iter_mut().zip(nodes) {
                *out = match node % 3 {
                    1 => bent(&points[node], step, STEPS),
                    2 => [0.0; 3],
                    _ => continue,
                };
            }
        })
        .expect("it converges");
        let error = largest_error(&modes, 900, STEPS, exact);
        assert!(error <= 1e-4 && (error - modes.truncation).abs() < 1e-12);
        let rigid = |node: usize, step: usize| match body[node] {
            Some(_) => exact(node, step),
            None => modes.displacement(node, step),
        };
        assert!(largest_error(&modes, 900, STEPS, rigid) < 1e-13);
        if form == Form::Scalar {
            assert_orthonormal(&modes, STEPS);
        }
    }
}

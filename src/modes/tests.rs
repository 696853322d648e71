//! Modes against the motions that they stand for.

use super::*;
use crate::geometry::vector::{add, norm};

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

use super::super::{Kernel, system};
use super::*;
use azimesh_core::geometry::vector::unit;

const BASIS: Basis = Basis {
    kernel: Kernel::WendlandC2,
    radius: 1.3,
};

fn noise(seed: usize, i: usize) -> f64 {
    ((seed * 7919 + i) as f64 * 12.9898).sin()
}

fn points(n: usize) -> Vec<Vector> {
    (0..n)
        .map(|i| std::array::from_fn(|k| noise(1, 3 * i + k)))
        .collect()
}

/// All directions, one normal and two by turns.
fn oblique(n: usize) -> Vec<Constraint> {
    let normal = |i: usize| unit(std::array::from_fn(|k| noise(2, 3 * i + k))).expect("not zero");
    (0..n)
        .map(|i| match i % 3 {
            0 => Constraint::ALL,
            1 => Constraint::of_normals(&[normal(i)]),
            _ => Constraint::of_normals(&[normal(i), normal(i + n)]),
        })
        .collect()
}

fn sixths() -> Vec<Transform> {
    let turn = |j: i32| {
        let angle = std::f64::consts::TAU * f64::from(j) / 6.0;
        Transform::rotation([0.3, -0.2, 1.0], [0.1, 0.2, -0.1], angle)
    };
    (1..6).map(turn).collect()
}

fn field(expanded: &Expanded, at: &[Vector]) -> Vec<f64> {
    let mut out = vec![0.0; at.len() * expanded.n_columns];
    expanded.weighted(BASIS).add_at(at, &mut out);
    out
}

/// Largest error of the prescribed components at the base points.
fn largest_error(
    expanded: &Expanded,
    base: &[Vector],
    constraints: &[Constraint],
    values: &[f64],
) -> f64 {
    let s = field(expanded, base);
    let mut largest = 0.0;
    for (i, constraint) in constraints.iter().enumerate() {
        let row = |of: &[f64]| of[i * expanded.n_columns..][..expanded.n_columns].to_vec();
        let (s, d) = (row(&s), row(values));
        for (s, d) in s.as_chunks::<3>().0.iter().zip(d.as_chunks::<3>().0) {
            for n in constraint.columns() {
                largest = f64::max(largest, (dot(*n, *s) - dot(*n, *d)).abs());
            }
        }
    }
    largest
}

/// `a x = b` by elimination with pivots, `a` by rows.
fn eliminate(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n)
            .max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))
            .expect("a row is left");
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            for j in k..n {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        for j in k + 1..n {
            b[k] -= a[k][j] * b[j];
        }
        b[k] /= a[k][k];
    }
    b
}

#[test]
fn the_prescribed_components_are_reproduced_under_any_group() {
    let base = points(60);
    let constraints = oblique(60);
    let values: Vec<f64> = (0..60 * 6).map(|i| noise(3, i)).collect();
    let shifts = [4.0, -4.0].map(|x| Transform::translation([x, 0.5 * x, 0.0]));
    for images in [vec![], sixths(), shifts.to_vec()] {
        let expanded = constrained_weights(BASIS, &base, &constraints, &images, &values)
            .expect("positive definite");
        assert_eq!(expanded.points.len(), 60 * (1 + images.len()));
        let error = largest_error(&expanded, &base, &constraints, &values);
        assert!(error < 1e-10, "{error}");
    }
}

#[test]
fn weights_are_those_of_the_full_system_solved_plainly() {
    let base = points(20);
    let constraints = oblique(20);
    let images = sixths();
    let values: Vec<f64> = (0..60).map(|i| noise(4, i)).collect();
    let expanded =
        constrained_weights(BASIS, &base, &constraints, &images, &values).expect("it is definite");
    let mut group = vec![Transform::IDENTITY];
    group.extend(images);
    let unknowns: Vec<(usize, Vector)> = (0..20)
        .flat_map(|i| {
            constraints[i]
                .columns()
                .iter()
                .map(move |n| (i, *n))
                .collect::<Vec<_>>()
        })
        .collect();
    let entry = |(i, n): &(usize, Vector), (j, m): &(usize, Vector)| {
        let term =
            |g: &Transform| BASIS.between(&base[*i], &g.apply(base[*j])) * dot(*n, g.turn(*m));
        group.iter().map(term).sum::<f64>()
    };
    let matrix: Vec<Vec<f64>> = unknowns
        .iter()
        .map(|row| unknowns.iter().map(|column| entry(row, column)).collect())
        .collect();
    for (p, row) in matrix.iter().enumerate() {
        for (q, value) in row.iter().enumerate() {
            assert!((value - matrix[q][p]).abs() < 1e-13);
        }
    }
    let d = |i: usize| [values[3 * i], values[3 * i + 1], values[3 * i + 2]];
    let rhs = unknowns.iter().map(|(i, n)| dot(*n, d(*i))).collect();
    let solution = eliminate(matrix, rhs);
    let mut weights = vec![[0.0; 3]; 20];
    for ((i, n), w) in unknowns.iter().zip(&solution) {
        weights[*i] = add(weights[*i], scale(*n, *w));
    }
    let images = group
        .iter()
        .flat_map(|g| weights.iter().map(|w| g.turn(*w)));
    for (found, expected) in expanded.weights.as_chunks::<3>().0.iter().zip(images) {
        assert!(distance(*found, expected) < 1e-10, "{found:?} {expected:?}");
    }
}

#[test]
fn planes_along_axes_are_scalar_systems_of_the_points_they_hold() {
    let base = points(50);
    let planes = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]];
    let constraints: Vec<Constraint> = (0..50)
        .map(|i| match i % 5 {
            0 => Constraint::of_normals(&planes[..1]),
            1 => Constraint::of_normals(&planes[1..]),
            2 => Constraint::of_normals(&planes),
            _ => Constraint::ALL,
        })
        .collect();
    let values: Vec<f64> = (0..150).map(|i| noise(5, i)).collect();
    let expanded =
        constrained_weights(BASIS, &base, &constraints, &[], &values).expect("it is definite");
    for axis in 0..3 {
        let held = |i: &usize| constraints[*i].columns().iter().any(|n| n[axis] != 0.0);
        let of: Vec<usize> = (0..50).filter(held).collect();
        let points: Vec<Vector> = of.iter().map(|&i| base[i]).collect();
        let wanted: Vec<f64> = of.iter().map(|&i| values[3 * i + axis]).collect();
        let scalar = system::interpolant(BASIS, &points, &wanted, false)
            .expect("it is definite")
            .weights;
        for i in 0..50 {
            let at = of.iter().position(|&j| j == i);
            let expected = at.map_or(0.0, |at| scalar[at]);
            assert!((expanded.weights[3 * i + axis] - expected).abs() < 1e-11);
        }
    }
}

#[test]
fn axes_with_the_same_points_share_a_factor_whatever_the_signs_of_their_normals() {
    let base = points(30);
    let signed = |i: usize| {
        let sign = if i.is_multiple_of(3) { -1.0 } else { 1.0 };
        Constraint::of_normals(&[[sign, 0.0, 0.0], [0.0, 1.0, 0.0]])
    };
    let constraints: Vec<Constraint> = (0..30).map(signed).collect();
    let values: Vec<f64> = (0..90).map(|i| noise(6, i)).collect();
    let expanded =
        constrained_weights(BASIS, &base, &constraints, &[], &values).expect("it is definite");
    assert!(largest_error(&expanded, &base, &constraints, &values) < 1e-10);
    assert!(
        expanded
            .weights
            .iter()
            .skip(2)
            .step_by(3)
            .all(|w| *w == 0.0)
    );
}

#[test]
fn the_field_turns_with_its_images() {
    let base = points(40);
    let values: Vec<f64> = (0..120).map(|i| noise(7, i)).collect();
    let images = sixths();
    let expanded =
        constrained_weights(BASIS, &base, &oblique(40), &images, &values).expect("it is definite");
    let asked: Vec<Vector> = (0..30)
        .map(|i| std::array::from_fn(|k| noise(8, 3 * i + k)))
        .collect();
    let here = field(&expanded, &asked);
    let turned: Vec<Vector> = asked.iter().map(|x| images[0].apply(*x)).collect();
    let there = field(&expanded, &turned);
    for (a, b) in here.as_chunks::<3>().0.iter().zip(there.as_chunks::<3>().0) {
        assert!(distance(images[0].turn(*a), *b) < 1e-12);
    }
}

#[test]
fn a_point_on_the_axis_of_its_images_moves_along_it() {
    let mut base = points(20);
    base[3] = [0.0, 0.0, 0.4];
    base[4] = [0.0, 0.0, -0.8];
    let mut values: Vec<f64> = (0..60).map(|i| noise(9, i)).collect();
    values[9..15].copy_from_slice(&[0.0, 0.0, 0.3, 0.0, 0.0, 0.0]);
    let mut constraints = oblique(20);
    constraints[4] = Constraint::of_normals(&[[0.0, 1.0, 0.0]]);
    let quarters: Vec<Transform> = (1..4)
        .map(|j| {
            let angle = std::f64::consts::FRAC_PI_2 * f64::from(j);
            Transform::rotation([0.0, 0.0, 1.0], [0.0; 3], angle)
        })
        .collect();
    let expanded = constrained_weights(BASIS, &base, &constraints, &quarters, &values)
        .expect("positive definite");
    assert!(largest_error(&expanded, &base, &constraints, &values) < 1e-10);
}

#[test]
fn the_field_repeats_under_translations() {
    let base = points(40);
    let values: Vec<f64> = (0..120).map(|i| noise(10, i)).collect();
    let images: Vec<Transform> = [-2, -1, 1, 2]
        .map(|j| Transform::translation([0.0, 2.5 * f64::from(j), 0.0]))
        .to_vec();
    let all = [Constraint::ALL; 40];
    let expanded =
        constrained_weights(BASIS, &base, &all, &images, &values).expect("it is definite");
    let here = field(&expanded, &[[0.2, -1.25, 0.1]]);
    let there = field(&expanded, &[[0.2, 1.25, 0.1]]);
    for (a, b) in here.iter().zip(&there) {
        assert!((a - b).abs() < 1e-12);
    }
}

#[test]
fn a_base_point_and_its_own_image_are_refused() {
    let base = [[0.0; 3], [1.0, 0.0, 0.0]];
    let images = [1.0, -1.0].map(|x| Transform::translation([x, 0.0, 0.0]));
    let error = constrained_weights(BASIS, &base, &[Constraint::ALL; 2], &images, &[1.0; 6])
        .expect_err("singular");
    assert!(
        error.message.contains("points 0 and 1 are periodic images"),
        "{error}"
    );
}

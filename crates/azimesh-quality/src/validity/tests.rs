//! Proofs against values at many points.

use super::*;
use azimesh_core::geometry::vector::{add, cross, dot, scale, sub};
use proptest::prelude::*;

const CUBE: [Vector; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];

/// The Jacobian of the trilinear map at a point of the unit cube.
fn hexahedron_jacobian(p: &[Vector; 8], x: Vector) -> f64 {
    let mut columns = [[0.0; 3]; 3];
    for (corner, at) in CUBE.iter().zip(p) {
        let factor = |axis: usize| {
            if corner[axis] > 0.5 {
                x[axis]
            } else {
                1.0 - x[axis]
            }
        };
        for axis in 0..3 {
            let slope = if corner[axis] > 0.5 { 1.0 } else { -1.0 };
            let others = [(axis + 1) % 3, (axis + 2) % 3].map(factor);
            columns[axis] = add(columns[axis], scale(*at, slope * others[0] * others[1]));
        }
    }
    dot(columns[0], cross(columns[1], columns[2]))
}

/// The Jacobian of a wedge at a point of its triangle and its height.
fn wedge_jacobian(p: &[Vector; 6], a: f64, b: f64, t: f64) -> f64 {
    let between = |i: usize, j: usize| add(scale(p[i], 1.0 - t), scale(p[j], t));
    let q = [between(0, 3), between(1, 4), between(2, 5)];
    let up = [0, 1, 2].map(|k| sub(p[k + 3], p[k]));
    let along = add(
        add(scale(up[0], 1.0 - a - b), scale(up[1], a)),
        scale(up[2], b),
    );
    dot(cross(sub(q[1], q[0]), sub(q[2], q[0])), along)
}

fn samples() -> impl Iterator<Item = Vector> {
    let places = (0..11).map(|i| f64::from(i) / 10.0);
    let places: Vec<f64> = places.collect();
    let all = places.clone().into_iter().flat_map(move |x| {
        let places = places.clone();
        places.clone().into_iter().flat_map(move |y| {
            let places = places.clone();
            places.into_iter().map(move |z| [x, y, z])
        })
    });
    all.collect::<Vec<_>>().into_iter()
}

fn moved<const N: usize>(corners: &[Vector; N], by: &[f64]) -> [Vector; N] {
    std::array::from_fn(|i| add(corners[i], [by[3 * i], by[3 * i + 1], by[3 * i + 2]]))
}

proptest! {
    #[test]
    fn a_hexahedron_is_judged_as_its_values_say(by in prop::collection::vec(-0.55f64..0.55, 24)) {
        let p = moved(&CUBE, &by);
        let least = samples().map(|x| hexahedron_jacobian(&p, x)).fold(f64::INFINITY, f64::min);
        let corners = CUBE.map(|x| hexahedron_jacobian(&p, x));
        let at_corners = corners.into_iter().fold(f64::INFINITY, f64::min);
        let found = hexahedron(&p, 1.0);
        prop_assert_eq!(found == Proof::Corner, at_corners <= 0.0);
        if least < 0.0 && at_corners > 0.0 {
            prop_assert_eq!(found, Proof::Inside);
        }
        if found == Proof::Valid {
            prop_assert!(least > 0.0);
        }
        let mirrored = p.map(|x| [-x[0], x[1], x[2]]);
        prop_assert_eq!(hexahedron(&mirrored, -1.0), found);
    }

    #[test]
    fn a_wedge_is_judged_as_its_values_say(by in prop::collection::vec(-0.6f64..0.6, 18)) {
        let right = [CUBE[0], CUBE[1], CUBE[3], CUBE[4], CUBE[5], CUBE[7]];
        let p = moved(&right, &by);
        let ends = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)];
        let least = |n: u32| {
            let values = ends.iter().flat_map(|&(a, b)| {
                (0..=n).map(move |i| wedge_jacobian(&p, a, b, f64::from(i) / f64::from(n)))
            });
            values.fold(f64::INFINITY, f64::min)
        };
        let found = wedge(&p, 1.0);
        prop_assert_eq!(found == Proof::Corner, least(1) <= 0.0);
        if least(1) > 0.0 {
            let inside = least(200);
            if inside < 0.0 {
                prop_assert_eq!(found, Proof::Inside);
            } else if inside > 1e-3 {
                prop_assert_eq!(found, Proof::Valid);
            }
        }
    }
}

#[test]
fn hexahedra_of_good_corners_are_found_to_be_inverted_between_them() {
    let mut number = 1u32;
    let mut next = || {
        number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(number >> 8) / f64::from(1 << 24) - 0.5
    };
    let (mut n_valid, mut n_inside) = (0, 0);
    for _ in 0..20_000 {
        let by: Vec<f64> = (0..24).map(|_| 1.2 * next()).collect();
        match hexahedron(&moved(&CUBE, &by), 1.0) {
            Proof::Valid => n_valid += 1,
            Proof::Inside => n_inside += 1,
            Proof::Unproven => panic!("random cells are never on the edge"),
            Proof::Corner => {}
        }
    }
    assert!(n_valid > 1000 && n_inside > 10, "{n_valid} {n_inside}");
}

#[test]
fn a_wedge_of_good_corners_is_found_to_be_inverted_between_them() {
    // Its triangles have the area e / 2, and half way up the Jacobian is (2 e - 1 - e^2) / 4 for each height.
    let with = |e: f64| {
        let p = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, e, 0.0],
            [0.0, 0.0, 1.0],
            [-e, 0.0, 1.0],
            [0.0, -1.0, 1.0],
        ];
        assert!((wedge_jacobian(&p, 0.2, 0.3, 0.5) - (2.0 * e - 1.0 - e * e) / 4.0).abs() < 1e-15);
        wedge(&p, 1.0)
    };
    assert_eq!(with(0.1), Proof::Inside);
    assert_eq!(with(0.9), Proof::Inside);
}

use super::*;
use azimesh_core::geometry::vector::distance;
use std::f64::consts::TAU;

fn noise(i: usize) -> f64 {
    (i as f64 * 12.9898).sin()
}

/// Points of a curved side with uneven spacing, on `n` by `m` lines from `x = low` on, as (radius,
/// sideways, height).
fn side(n: usize, m: usize, low: f64) -> Vec<Vector> {
    (0..n * m)
        .map(|at| {
            let (i, j) = ((at % n) as f64, (at / n) as f64);
            let x = low + i + 0.2 * i * i / n as f64;
            [x, 0.1 * (x - low) * (1.0 + j), 0.7 * j + 0.05 * j * j]
        })
        .collect()
}

/// Both sides in one list, the second side shuffled, and their nodes.
fn joined(a: &[Vector], map: impl Fn(Vector) -> Vector) -> (Vec<Vector>, Vec<u32>, Vec<u32>) {
    let n = a.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| noise(i).total_cmp(&noise(j)));
    let mut points = a.to_vec();
    points.extend(order.iter().map(|&i| map(a[i])));
    let second = (n as u32..2 * n as u32).collect();
    (points, (0..n as u32).collect(), second)
}

fn find(points: &[Vector], a: &[u32], b: &[u32], axis: Option<Axis>) -> Result<Periodic> {
    let none = vec![[0.0; 3]; a.len().max(b.len())];
    find_between(points, (a, &none), (b, &none), axis)
}

/// The pairs of two sides with the directions into the mesh at their nodes.
fn find_between(
    points: &[Vector],
    a: (&[u32], &[Vector]),
    b: (&[u32], &[Vector]),
    axis: Option<Axis>,
) -> Result<Periodic> {
    let side = |name, (nodes, inward)| Side {
        name,
        nodes,
        inward,
    };
    Periodic::find(
        &|node| points[node as usize],
        side("left", a),
        side("right", b),
        axis,
    )
}

fn check_pairs(periodic: &Periodic, points: &[Vector], n: usize) {
    assert_eq!(periodic.pairs.len(), n);
    let mut partners: Vec<u32> = periodic.pairs.iter().map(|pair| pair.1).collect();
    partners.sort_unstable();
    partners.dedup();
    assert_eq!(partners.len(), n);
    for &(a, b) in &periodic.pairs {
        let image = periodic.transform.apply(points[a as usize]);
        assert!(distance(image, points[b as usize]) <= periodic.mismatch + 1e-15);
    }
}

const Z: Axis = Axis {
    origin: [0.0; 3],
    direction: [0.0, 0.0, 1.0],
};

#[test]
fn a_translation_along_an_axis_is_found_exactly() {
    let (points, a, b) = joined(&side(7, 5, 1.0), |x| [x[0], x[1] + 0.1, x[2]]);
    let shift = points[b[0] as usize][1] - 0.1;
    let periodic = find(&points, &a, &b, Some(Z)).expect("it is a translation");
    check_pairs(&periodic, &points, 35);
    assert!(shift.is_finite() && periodic.mismatch < 1e-15);
    let by = periodic.transform.translation;
    assert_eq!((by[0], by[2]), (0.0, 0.0));
    assert!((by[1] - 0.1).abs() < 1e-15);
    assert_eq!(periodic.transform.rotation, Transform::IDENTITY.rotation);
}

#[test]
fn a_sixth_of_a_circle_is_found_about_the_shaft_and_without_one() {
    let turn = Transform::rotation(Z.direction, Z.origin, -TAU / 6.0);
    let (points, a, b) = joined(&side(7, 5, 1.0), |x| turn.apply(x));
    for axis in [Some(Z), None] {
        let periodic = find(&points, &a, &b, axis).expect("it is a rotation");
        check_pairs(&periodic, &points, 35);
        assert!(periodic.mismatch < 1e-13, "{}", periodic.mismatch);
        let Symmetry::Rotation { axis, angle } = periodic.symmetry else {
            panic!("{periodic:?}");
        };
        assert!((angle * axis.direction[2] + TAU / 6.0).abs() < 1e-15);
        assert_eq!(axis.direction[..2], [0.0, 0.0]);
    }
}

#[test]
fn any_axis_and_angle_are_found_from_the_nodes() {
    for angle in [0.3, 1.2, 2.9] {
        let turn = Transform::rotation([0.2, -0.5, 1.0], [3.0, -1.0, 0.5], angle);
        let (points, a, b) = joined(&side(6, 4, 0.5), |x| turn.apply(x));
        let periodic = find(&points, &a, &b, Some(Z)).expect("it is a rotation");
        check_pairs(&periodic, &points, 24);
        for x in [[0.0; 3], [1.0, -4.0, 2.0]] {
            assert!(distance(periodic.transform.apply(x), turn.apply(x)) < 1e-11);
        }
    }
}

#[test]
fn a_quarter_turn_has_exact_entries_and_nodes_on_the_axis_are_their_own_partners() {
    let radii = [0.0, 0.4, 1.0, 1.7];
    let mut points: Vec<Vector> = Vec::new();
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for z in [0.0, 0.5, 1.5] {
        for r in radii {
            a.push(points.len() as u32);
            points.push([r, 0.0, z]);
            if r > 0.0 {
                points.push([0.0, r, z]);
            }
            b.push(points.len() as u32 - 1);
        }
    }
    let periodic = find(&points, &a, &b, Some(Z)).expect("it is a rotation");
    check_pairs(&periodic, &points, 12);
    assert_eq!(periodic.pairs[0], (0, 0));
    let exact = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(periodic.transform.rotation, exact);
    assert_eq!(periodic.transform.translation, [0.0; 3]);
    assert_eq!(periodic.mismatch, 0.0);
    let bounds = Bounds::around(&points);
    let images = images(&[periodic], 100.0, &bounds).expect("it divides the circle");
    assert_eq!(images.len(), 3);
    assert_eq!(images[1].rotation[0], [-1.0, 0.0, 0.0]);
}

#[test]
fn the_halves_of_a_cut_are_half_a_turn_apart_and_no_translation() {
    let half: Vec<Vector> = (0..20)
        .map(|i| [1.0 + f64::from(i % 5), 0.0, f64::from(i / 5)])
        .collect();
    let (points, a, b) = joined(&half, |x| [-x[0], 0.0, x[2]]);
    let up = [[0.0, 1.0, 0.0]; 20];
    for axis in [Some(Z), None] {
        let periodic =
            find_between(&points, (&a, &up), (&b, &up), axis).expect("it is half a turn");
        let Symmetry::Rotation { axis, angle } = periodic.symmetry else {
            panic!("{periodic:?}");
        };
        assert_eq!(angle.abs(), std::f64::consts::PI);
        assert_eq!(axis.direction[2].abs(), 1.0);
        assert_eq!(periodic.mismatch, 0.0);
    }
}

#[test]
fn sides_across_from_each_other_do_not_match_by_half_a_turn() {
    let graded: Vec<Vector> = (0..10).map(|i| [0.0, f64::from(i * i), 0.0]).collect();
    let (points, a, b) = joined(&graded, |x| [50.0, 81.0 - x[1], 0.0]);
    let (right, left) = ([[1.0, 0.0, 0.0]; 10], [[-1.0, 0.0, 0.0]; 10]);
    let error = find_between(&points, (&a, &right), (&b, &left), None);
    let error = error.expect_err("they are graded the other way");
    assert!(error.message.contains("moved by (50, "), "{error}");
    assert!(
        error.message.contains(
            "a rotation by -180 degrees about the direction (0, 0, 1) through (25, 40.5, 0) matches their nodes, but leaves the mesh on the same side of both"
        ),
        "{error}"
    );
}

#[test]
fn of_the_maps_between_even_sides_the_one_with_the_mesh_between_them_is_taken() {
    let turn = Transform::rotation(Z.direction, Z.origin, TAU / 6.0);
    for heights in [1, 4] {
        let even: Vec<Vector> = (0..9 * heights)
            .map(|i| [1.0 + f64::from(i % 9) / 8.0, 0.0, f64::from(i / 9)])
            .collect();
        let (points, a, b) = joined(&even, |x| turn.apply(x));
        let into = [0.0, 1.0, 0.0];
        let of_a = vec![into; even.len()];
        let of_b = vec![turn.turn(scale(into, -1.0)); even.len()];
        for axis in [Some(Z), None] {
            let periodic = find_between(&points, (&a, &of_a), (&b, &of_b), axis);
            let periodic = periodic.expect("one is right");
            check_pairs(&periodic, &points, even.len());
            for x in [[0.0; 3], [1.0, 0.0, 0.0], [1.5, 0.3, 0.2]] {
                let off = distance(periodic.transform.apply(x), turn.apply(x));
                assert!(off < 1e-9, "{heights} {axis:?}: {off:e}");
            }
        }
    }
}

#[test]
fn two_maps_that_remain_are_both_named() {
    // The rim of a disk and a hole of the same size.
    let rim: Vec<Vector> = (0..6)
        .map(|i| (f64::from(i) * TAU / 6.0).sin_cos())
        .map(|(sin, cos)| [cos, sin, 0.0])
        .collect();
    let (points, a, b) = joined(&rim, |x| [x[0] + 5.0, x[1], 0.0]);
    let of_a: Vec<Vector> = a.iter().map(|&i| scale(points[i as usize], -1.0)).collect();
    let of_b: Vec<Vector> = b
        .iter()
        .map(|&i| sub(points[i as usize], [5.0, 0.0, 0.0]))
        .collect();
    let error = find_between(&points, (&a, &of_a), (&b, &of_b), None).expect_err("there are six");
    assert!(
        error.message.starts_with(
            "the periodic sides \"left\" and \"right\" match by a translation by (5, 0, 0) and by a rotation by "
        ),
        "{error}"
    );
    assert!(
        error.message.contains("set rotor.hub and rotor.shaft_axis"),
        "{error}"
    );
}

#[test]
fn sides_of_a_plane_mesh_turn_in_the_plane() {
    let line: Vec<Vector> = (0..9)
        .map(|i| [1.0 + f64::from(i * i) / 10.0, 0.0, 0.0])
        .collect();
    let turn = Transform::rotation([0.0, 0.0, 1.0], [0.0; 3], TAU / 8.0);
    let (points, a, b) = joined(&line, |x| turn.apply(x));
    let shaft = Axis {
        origin: [0.0; 3],
        direction: [0.0, 1.0, 0.0],
    };
    let periodic = find(&points, &a, &b, Some(shaft)).expect("it is a rotation");
    check_pairs(&periodic, &points, 9);
    let images = images(&[periodic], 1.0, &Bounds::around(&points)).expect("an eighth");
    assert_eq!(images.len(), 7);
}

#[test]
fn nodes_at_one_place_are_all_paired() {
    let (mut points, mut a, mut b) = joined(&side(4, 3, 1.0), |x| [x[0], x[1] + 2.0, x[2]]);
    points.push(points[5]);
    a.push(24);
    points.push(points[b[2] as usize]);
    b.push(25);
    let periodic = find(&points, &a, &b, None).expect("it is a translation");
    for node in &a {
        assert!(periodic.pairs.iter().any(|pair| pair.0 == *node));
    }
    for node in &b {
        assert!(periodic.pairs.iter().any(|pair| pair.1 == *node));
    }
    let followers = followers(&[periodic], &Bounds::around(&points)).expect("one map");
    let twin = followers.iter().find(|f| f.node == 24).expect("it follows");
    assert_eq!((twin.leader, twin.map), (5, Transform::IDENTITY));
}

#[test]
fn the_first_node_without_a_partner_is_named_with_its_distance() {
    let (mut points, a, b) = joined(&side(7, 5, 1.0), |x| [x[0], x[1] + 2.0, x[2]]);
    let partner = b.iter().find(|&&i| {
        distance(
            points[i as usize],
            [points[11][0], points[11][1] + 2.0, points[11][2]],
        ) < 1e-9
    });
    points[*partner.expect("it was made") as usize][2] += 0.01;
    let error = find(&points, &a, &b, Some(Z)).expect_err("one is off");
    let named = "node 11 of the periodic side \"left\" has no partner on \"right\"";
    assert!(error.message.contains(named), "{error}");
    assert!(
        error.message.contains("is 0.01 from the nearest"),
        "{error}"
    );
    let error = find(&points, &a, &b[1..], None).expect_err("one is missing");
    assert!(error.message.contains("35 and 34 nodes"), "{error}");
    let error = find(&points, &a, &[], None).expect_err("none");
    assert!(error.message.contains("\"right\" has no nodes"), "{error}");
    let error = find(&points, &a, &a, None).expect_err("the same");
    assert!(error.message.contains("different sides"), "{error}");
}

#[test]
fn images_reach_as_far_as_the_support_and_too_many_are_refused() {
    let (points, a, b) = joined(&side(7, 5, 1.0), |x| [x[0], x[1] + 2.0, x[2]]);
    let periodic = find(&points, &a, &b, None).expect("it is a translation");
    let bounds = Bounds {
        low: [0.0; 3],
        high: [50.0, 2.0, 50.0],
    };
    let found = images(std::slice::from_ref(&periodic), 3.0, &bounds).expect("a few");
    let mut shifts: Vec<f64> = found.iter().map(|g| g.translation[1]).collect();
    shifts.sort_by(f64::total_cmp);
    assert_eq!(shifts, [-6.0, -4.0, -2.0, 2.0, 4.0, 6.0]);
    let twice = images(&[periodic.clone(), periodic.clone()], 3.0, &bounds).expect("the same map");
    assert_eq!(twice.len(), 6);
    let error = images(&[periodic], 500.0, &bounds).expect_err("too many");
    assert!(error.message.contains("rbf.support_radius"), "{error}");
}

#[test]
fn an_angle_that_does_not_divide_the_circle_is_refused() {
    let turn = Transform::rotation(Z.direction, Z.origin, 1.0);
    let (points, a, b) = joined(&side(7, 5, 1.0), |x| turn.apply(x));
    let periodic = find(&points, &a, &b, Some(Z)).expect("it is a rotation");
    let error = images(&[periodic], 1.0, &Bounds::around(&points)).expect_err("57.3 degrees");
    assert!(
        error.message.contains("does not divide the full circle"),
        "{error}"
    );
}

#[test]
fn a_corner_between_two_pairs_has_one_leader_and_combined_images() {
    let mut points = Vec::new();
    let mut sides = vec![Vec::new(); 4];
    for i in 0..=3u32 {
        for j in 0..=3u32 {
            for k in 0..2u32 {
                let node = points.len() as u32;
                points.push([f64::from(i), f64::from(j) * 2.0, f64::from(k)]);
                for (side, on) in [i == 0, i == 3, j == 0, j == 3].into_iter().enumerate() {
                    if on {
                        sides[side].push(node);
                    }
                }
            }
        }
    }
    let between = |a: &[u32], b: &[u32], into: Vector| {
        let (of_a, of_b) = (vec![into; a.len()], vec![scale(into, -1.0); b.len()]);
        find_between(&points, (a, &of_a), (b, &of_b), None)
    };
    let pairs = [
        between(&sides[0], &sides[1], [1.0, 0.0, 0.0]).expect("along x"),
        between(&sides[2], &sides[3], [0.0, 1.0, 0.0]).expect("along y"),
    ];
    let bounds = Bounds::around(&points);
    let last = points.len() as u32 - 1;
    let followers = followers(&pairs, &bounds).expect("they commute");
    let corner = followers
        .iter()
        .find(|f| f.node == last)
        .expect("it follows");
    assert_eq!(corner.leader, 1);
    assert_eq!(corner.map, Transform::translation([3.0, 6.0, 0.0]));
    assert_eq!(images(&pairs, 2.0, &bounds).expect("a few").len(), 24);
}

#[test]
fn two_nodes_near_one_place_need_two_partners() {
    let mut a = side(4, 3, 1.0);
    a.push(add(a[5], [1e-9, 0.0, 0.0]));
    let (mut points, first, second) = joined(&a, |x| add(x, [0.0, 0.0, 9.0]));
    let copy = add(a[12], [0.0, 0.0, 9.0]);
    let at = points
        .iter()
        .rposition(|x| *x == copy)
        .expect("it is there");
    points[at] = add(copy, [0.0, 0.5, 0.0]);
    find(&points, &first, &second, None).expect_err("a partner is taken");
}

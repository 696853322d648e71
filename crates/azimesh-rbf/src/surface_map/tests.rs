//! Maps of rigid motions, bending and forces.

use super::*;
use azimesh_core::geometry::rotation::rotate_by;
use azimesh_core::geometry::vector::{distance, dot};

/// A number between -1 and 1.
fn random(seed: usize) -> f64 {
    let x = (seed as f64 * 12.9898).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

/// Half the thickness of the wing at a part of its chord.
fn thickness(x: f64) -> f64 {
    0.6 * (0.2969 * x.sqrt() - 0.126 * x - 0.3516 * x * x + 0.2843 * x.powi(3) - 0.1036 * x.powi(4))
}

/// The skin of a wing of span 8: points by chord and span, both sides, and its triangles.
fn skin(n_chord: usize, n_span: usize, shift: f64) -> (Vec<Vector>, Vec<[u32; 3]>) {
    let ring = 2 * n_chord;
    let (mut points, mut facets) = (Vec::new(), Vec::new());
    for j in 0..=n_span {
        for i in 0..ring {
            let angle = std::f64::consts::TAU * (i as f64 + shift) / ring as f64;
            let x = 0.5 + 0.5 * angle.cos();
            points.push([
                x,
                8.0 * j as f64 / n_span as f64,
                angle.sin().signum() * thickness(x),
            ]);
            if j < n_span {
                let at = |i: usize, j: usize| (j * ring + i % ring) as u32;
                facets.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                facets.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    (points, facets)
}

/// A plate at the middle of the wing.
fn plate(n_chord: usize, n_span: usize) -> (Vec<Vector>, Vec<[u32; 3]>) {
    let (mut points, mut facets) = (Vec::new(), Vec::new());
    for j in 0..=n_span {
        for i in 0..=n_chord {
            points.push([
                i as f64 / n_chord as f64,
                8.0 * j as f64 / n_span as f64,
                0.0,
            ]);
            if i < n_chord && j < n_span {
                let at = |i: usize, j: usize| (j * (n_chord + 1) + i) as u32;
                facets.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                facets.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    (points, facets)
}

/// Bends the wing along a circle of radius 6: lengths on z = 0 are kept.
fn bent([x, y, z]: Vector) -> Vector {
    let angle = y / 6.0;
    [x, (6.0 - z) * angle.sin(), 6.0 - (6.0 - z) * angle.cos()]
}

fn displacements(points: &[Vector], moved: impl Fn(Vector) -> Vector) -> Vec<Vector> {
    points.iter().map(|x| sub(moved(*x), *x)).collect()
}

/// The largest error at the wall.
fn error(
    map: &SurfaceMap,
    given: &[Vector],
    wall: &[Vector],
    moved: impl Fn(Vector) -> Vector,
) -> f64 {
    let found = map
        .displacements(&displacements(given, &moved))
        .expect("it maps");
    let errors = wall
        .iter()
        .zip(&found)
        .map(|(y, d)| distance(add(*y, *d), moved(*y)));
    errors.fold(0.0, f64::max)
}

#[test]
fn rigid_motions_are_exact() {
    let turned = |x: Vector| add(rotate_by([0.7, -1.1, 0.4], x), [3.0, -2.0, 1.0]);
    let (wall, _) = skin(16, 24, 0.3);
    for (given, facets) in [skin(12, 20, 0.0), plate(8, 20)] {
        let rbf = SurfaceMap::rbf(&given, &wall).expect("a surface");
        let plane = SurfaceMap::plane(&given, &facets, &wall).expect("facets");
        for (name, map) in [("rbf", rbf), ("plane", plane)] {
            let error = error(&map, &given, &wall, turned);
            assert!(error < 1e-12, "{name} of {} points: {error:e}", given.len());
        }
    }
}

#[test]
fn bending_is_near_and_nearer_with_more_points() {
    let (wall, _) = skin(24, 36, 0.3);
    let mut before = [f64::INFINITY; 3];
    for n in [1, 2] {
        let (given, facets) = skin(10 * n, 20 * n, 0.0);
        let (flat, _) = plate(10 * n, 20 * n);
        let rbf = SurfaceMap::rbf(&given, &wall).expect("a surface");
        let of_plate = SurfaceMap::rbf(&flat, &wall).expect("a surface");
        let plane = SurfaceMap::plane(&given, &facets, &wall).expect("facets");
        let errors = [
            error(&rbf, &given, &wall, bent),
            error(&of_plate, &flat, &wall, bent),
            error(&plane, &given, &wall, bent),
        ];
        assert!(
            (0..3).all(|k| errors[k] < 0.5 * before[k]),
            "{n}: {errors:?} {before:?}"
        );
        before = errors;
    }
    assert!(
        before[0] < 5e-4 && before[1] < 5e-4 && before[2] < 1e-3,
        "{before:?}"
    );
}

#[test]
fn forces_and_moments_are_kept() {
    let (wall, _) = skin(16, 24, 0.3);
    let forces: Vec<Vector> = (0..wall.len())
        .map(|i| std::array::from_fn(|k| random(3 * i + k)))
        .collect();
    let sums = |points: &[Vector], forces: &[Vector]| {
        points
            .iter()
            .zip(forces)
            .fold([[0.0; 3]; 2], |[f, m], (x, force)| {
                [add(f, *force), add(m, cross(*x, *force))]
            })
    };
    let expected = sums(&wall, &forces);
    let size = forces.iter().map(|f| norm(*f)).sum::<f64>();
    for (given, facets) in [skin(12, 20, 0.0), plate(8, 20)] {
        let rbf = SurfaceMap::rbf(&given, &wall).expect("a surface");
        let plane = SurfaceMap::plane(&given, &facets, &wall).expect("facets");
        let nearest = SurfaceMap::nearest(&given, &wall).expect("points");
        for (name, map) in [("rbf", &rbf), ("plane", &plane), ("nearest", &nearest)] {
            let found = sums(&given, &map.pull_back(&forces).expect("it maps"));
            let n_kept = if name == "nearest" { 1 } else { 2 };
            for k in 0..n_kept {
                let off = distance(found[k], expected[k]) / size;
                assert!(off < 1e-13, "{name}: {k} is off by {off:e}");
            }
        }
        // Virtual work of a small displacement, which is not rigid.
        for map in [&rbf, &plane, &nearest] {
            let small: Vec<Vector> = given
                .iter()
                .map(|x| scale([x[1], x[0] * x[2], x[1] * x[1]], 1e-7))
                .collect();
            let pairs =
                |a: &[Vector], b: &[Vector]| a.iter().zip(b).map(|(a, b)| dot(*a, *b)).sum::<f64>();
            let at_wall = pairs(&map.displacements(&small).expect("it maps"), &forces);
            let at_given = pairs(&small, &map.pull_back(&forces).expect("it maps"));
            assert!(
                (at_wall - at_given).abs() < 1e-6 * 1e-7 * size,
                "{at_wall:e} {at_given:e}"
            );
        }
    }
}

#[test]
fn a_line_in_the_plane_turns_its_wall() {
    let line: Vec<Vector> = (0..30).map(|i| [f64::from(i) / 29.0, 0.0, 0.0]).collect();
    let edges: Vec<[u32; 3]> = (0..29).map(|i| [i, i + 1, i + 1]).collect();
    let wall: Vec<Vector> = (0..100)
        .map(|i| 0.0628 * f64::from(i))
        .map(|a| [0.5 + 0.55 * a.cos(), 0.06 * a.sin(), 0.0])
        .collect();
    let turned = |x: Vector| add(rotate_by([0.0, 0.0, 2.0], x), [3.0, -2.0, 0.0]);
    for map in [
        SurfaceMap::rbf(&line, &wall),
        SurfaceMap::plane(&line, &edges, &wall),
    ] {
        let map = map.expect("in the plane");
        let error = error(&map, &line, &wall, turned);
        assert!(error < 1e-12, "{error:e}");
        let forces = vec![[0.3, 0.4, 0.0]; wall.len()];
        let sums = |points: &[Vector], forces: &[Vector]| {
            points
                .iter()
                .zip(forces)
                .fold([0.0; 3], |m, (x, f)| add(m, cross(*x, *f)))
        };
        let off = distance(
            sums(&wall, &forces),
            sums(&line, &map.pull_back(&forces).expect("it maps")),
        );
        assert!(off < 1e-11, "{off:e}");
    }
}

#[test]
fn points_that_do_not_fit_are_refused() {
    let refused = |map: Result<SurfaceMap>| map.expect_err("it is refused").message;
    let line: Vec<Vector> = (0..60)
        .map(|i| [f64::from(i), 0.5 * f64::from(i), f64::from(i)])
        .collect();
    let wall = [[1.0, 2.0, 3.0]];
    assert!(refused(SurfaceMap::rbf(&line, &wall)).contains("on a line"));
    assert!(refused(SurfaceMap::rbf(&[], &wall)).contains("no given points"));
    assert!(refused(SurfaceMap::nearest(&[[f64::NAN; 3]], &wall)).contains("given point 0"));
    assert!(refused(SurfaceMap::plane(&line, &[[0, 1, 60]], &wall)).contains("none of the 60"));
    assert!(refused(SurfaceMap::plane(&line, &[], &wall)).contains("no facets"));
    let (mut given, _) = plate(4, 4);
    given.push(given[7]);
    let map = SurfaceMap::rbf(&given, &wall).expect("twins are one point");
    let mut moved = vec![[0.0; 3]; given.len()];
    assert!(map.displacements(&moved).is_ok() && map.displacements(&moved[1..]).is_err());
    moved[7] = [1.0; 3];
    assert!(
        map.displacements(&moved)
            .expect_err("they differ")
            .message
            .contains("7 and 25")
    );
}

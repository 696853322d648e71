//! Closest points against brute force.

use super::super::facet::closest_weights;
use super::super::vector::{dot, sub};
use super::*;

/// The closest point by sampling the triangle finely.
fn sampled_distance(p: &Vector, corners: &[Vector; 3]) -> f64 {
    let n = 200;
    let mut best = f64::INFINITY;
    for i in 0..=n {
        for j in 0..=n - i {
            let (v, w) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            let x = add(
                scale(corners[0], 1.0 - v - w),
                add(scale(corners[1], v), scale(corners[2], w)),
            );
            let away = sub(*p, x);
            best = f64::min(best, dot(away, away));
        }
    }
    best.sqrt()
}

#[test]
fn the_foot_is_the_closest_point_of_all_triangles() {
    let value = |i: usize| ((i as f64) * 12.9898).sin();
    let points: Vec<Vector> = (0..60)
        .map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2)])
        .collect();
    let facets: Vec<[u32; 3]> = (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let surface = ClosestSurface::new(&points[..], &facets);
    for q in 0..40 {
        let p = [
            2.0 * value(500 + 3 * q),
            2.0 * value(501 + 3 * q),
            2.0 * value(502 + 3 * q),
        ];
        let brute = facets
            .iter()
            .map(|f| sampled_distance(&p, &f.map(|i| points[i as usize])))
            .fold(f64::INFINITY, f64::min);
        let foot = surface.nearest(&p, f64::INFINITY).expect("there is one");
        assert!((foot.distance_squared.sqrt() - brute).abs() < 0.02);
        assert!(foot.distance_squared.sqrt() <= brute + 1e-12);
        assert!(
            surface
                .nearest(&p, 0.99 * foot.distance_squared.sqrt())
                .is_none()
        );
    }
}

#[test]
fn an_edge_of_the_plane_has_its_foot_by_projection() {
    let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let surface = ClosestSurface::new(&points[..], &[[0, 1, 1]]);
    let foot = surface.nearest(&[0.5, 3.0, 0.0], 10.0).expect("it is near");
    assert_eq!(foot.weights, [0.75, 0.25, 0.0]);
    assert_eq!(foot.distance_squared, 9.0);
}

/// The nearest facet by asking each, ties to the first.
fn brute(points: &[Vector], facets: &[[u32; 3]], p: &Vector) -> (f64, usize) {
    let mut best = (f64::INFINITY, usize::MAX);
    for (facet, corners) in facets.iter().enumerate() {
        let corners = corners.map(|i| sub(points[i as usize], *p));
        let w = closest_weights(&corners);
        let away = add(
            add(scale(corners[0], w[0]), scale(corners[1], w[1])),
            scale(corners[2], w[2]),
        );
        if dot(away, away) < best.0 {
            best = (dot(away, away), facet);
        }
    }
    best
}

#[test]
fn a_search_in_blocks_finds_what_asking_every_facet_finds() {
    let n = 14;
    let shapes: [fn(f64, f64) -> Vector; 4] = [
        |s, t| [s, t, 0.0],
        |s, t| [s + 5.0, 0.6 * t - 0.3 * s, 0.8 * t],
        |s, t| [s, 0.05 * t, 0.3 * (3.0 * s).sin()],
        |s, _| [s, 0.0, 0.0],
    ];
    for shape in shapes {
        let at = |k: usize| shape((k % n) as f64 / 9.0, (k / n) as f64 / 9.0);
        let mut points: Vec<Vector> = (0..n * n).map(at).collect();
        let below = points.iter().map(|p| [p[0], p[1], p[2] - 1e-4]);
        points.extend(below.collect::<Vec<_>>());
        let mut facets = Vec::new();
        for k in (0..2 * n * n).filter(|k| k % n < n - 1 && k % (n * n) < n * (n - 1)) {
            let [a, b, c, d] = [k, k + 1, k + n + 1, k + n].map(|i| i as u32);
            facets.extend([[a, b, c], [a, c, d], [a, b, b]]);
        }
        let surface = ClosestSurface::new(&points[..], &facets);
        let asked: Vec<Vector> = (0..400)
            .map(|i| {
                let [x, y, z] = points[(i * 7) % points.len()];
                [x, y + 1e-3 * (i % 3) as f64, z + 0.02 * (i as f64).sin()]
            })
            .collect();
        let mut found = vec![None; asked.len()];
        surface.nearest_each(&asked, 0.015, &mut |i, foot| found[i] = Some(*foot));
        for (p, foot) in asked.iter().zip(found) {
            let (square, facet) = brute(&points, &facets, p);
            let expected = (square < 0.015 * 0.015).then_some((square, facet));
            assert_eq!(
                foot.map(|foot| (foot.distance_squared, foot.facet)),
                expected
            );
        }
    }
}

//! Closest points against brute force.

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
fn coordinates_whose_squares_overflow_have_a_foot_or_none() {
    for far in [1e150, 1e160, 1e200, 1e308] {
        let points: Vec<Vector> = (0..40)
            .map(|i| [far * f64::from(i % 7) / 7.0, f64::from(i), far])
            .collect();
        let facets: Vec<[u32; 3]> = (0..38).map(|i| [i, i + 1, i + 2]).collect();
        let surface = ClosestSurface::new(&points[..], &facets);
        for point in [[0.0; 3], [far, 0.0, 0.0], [-far, far, far], [1.0, 2.0, 3.0]] {
            let known = |foot: &ClosestPoint| foot.facet < facets.len();
            assert!(
                surface
                    .nearest(&point, f64::INFINITY)
                    .as_ref()
                    .is_none_or(known),
                "{far}"
            );
            let many = vec![point; 50];
            surface.nearest_each(&many, f64::INFINITY, &mut |_, foot| assert!(known(foot)));
        }
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

/// Barycentric weights of the point of a triangle closest to the origin. A triangle whose last two
/// corners coincide is an edge.
///
/// Source: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5: the Voronoi regions of
/// corners and edges are tried in turn.
fn closest_weights([a, b, c]: &[Vector; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (sub(*b, *a), sub(*c, *a), scale(*a, -1.0));
    if b == c {
        let square = dot(ab, ab);
        let t = if square > 0.0 {
            dot(ap, ab) / square
        } else {
            0.0
        };
        let t = t.clamp(0.0, 1.0);
        return [1.0 - t, t, 0.0];
    }
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = scale(*b, -1.0);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = ratio(d1, d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = scale(*c, -1.0);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = ratio(d2, d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = ratio(d4 - d3, (d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let total = va + vb + vc;
    let (v, w) = (ratio(vb, total), ratio(vc, total));
    [1.0 - v - w, v, w]
}

/// `a / b`, zero for a degenerate facet.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
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

#[test]
fn no_point_of_a_box_has_a_foot_where_the_surface_is_not_within_the_limit() {
    let value = |i: usize| ((i as f64) * 12.9898).sin();
    let points: Vec<Vector> = (0..600)
        .map(|i| [value(3 * i), value(3 * i + 1), 0.1 * value(3 * i + 2)])
        .collect();
    let facets: Vec<[u32; 3]> = (0..199).map(|i| [3 * i, 3 * i + 1, 3 * i + 3]).collect();
    for n in [0, 1, 9, 199] {
        let surface = ClosestSurface::new(&points[..], &facets[..n]);
        let mut n_far = 0;
        for q in 0..200 {
            let at = |i: usize| 2.0 * value(7000 + 3 * q + i);
            let corners = [[at(0), at(1), at(2)], [at(0) + 0.1, at(1), at(2) - 0.2]];
            let block = Bounds::around(&corners);
            let one = Bounds::around(&corners[..1]);
            for limit in [0.01, 0.3, 1.0] {
                if surface.may_be_within(limit, &block) {
                    continue;
                }
                n_far += 1;
                assert!(!surface.may_be_within(limit, &one));
                assert!(corners.iter().all(|p| surface.nearest(p, limit).is_none()));
            }
            if let Some(foot) = surface.nearest(&corners[0], f64::INFINITY) {
                let distance = foot.distance_squared.sqrt();
                assert!(surface.may_be_within(distance * (1.0 + 1e-12), &one));
            }
        }
        assert!(n_far > 200, "{n_far}");
    }
}

//! Size-skew of cells whose values are known.

use super::super::QualityEvaluator;
use super::*;
use azimesh_core::geometry::vector::{add, cross, dot, norm, scale, sub};
use azimesh_io::mesh::CellKind;

fn one(kind: CellKind, points: &[Vector]) -> Mesh {
    let mut mesh = Mesh {
        points: points.to_vec(),
        ..Mesh::default()
    };
    let nodes: Vec<u32> = (0..points.len() as u32).collect();
    mesh.cells.push(kind, &nodes);
    mesh
}

/// `alpha_k` and what corner `k` adds to `n / f_skew`, for each corner, straight from the definitions.
fn corners(kind: CellKind, p: &[Vector]) -> Vec<(f64, f64)> {
    let triple = |[u, v, w]: [Vector; 3]| dot(u, cross(v, w));
    let edges = |k: usize, to: [usize; 3]| to.map(|to| sub(p[to], p[k]));
    let box_like = |k: usize, to: [usize; 3], ideal: f64| {
        let [u, v, w] = edges(k, to);
        let alpha = triple([u, v, w]);
        let lengths = dot(u, u) * dot(v, v) * dot(w, w);
        (alpha, (ideal * lengths / (alpha * alpha)).cbrt())
    };
    match kind {
        CellKind::Triangle => {
            let [u, v] = [sub(p[1], p[0]), sub(p[2], p[0])];
            let alpha = cross(u, v)[2];
            let lengths = dot(u, u) + dot(v, v) - dot(u, v);
            vec![(alpha, lengths / (3f64.sqrt() * alpha.abs()))]
        }
        CellKind::Quadrilateral => {
            let across = cross(sub(p[2], p[0]), sub(p[3], p[1]));
            let normal = scale(across, 1.0 / norm(across).copysign(across[2]));
            let corner = |k: usize| {
                let [u, v] = [sub(p[(k + 1) % 4], p[k]), sub(p[(k + 3) % 4], p[k])];
                let alpha = dot(cross(u, v), normal);
                (alpha, norm(u) * norm(v) / alpha.abs())
            };
            (0..4).map(corner).collect()
        }
        CellKind::Tetrahedron => {
            let [u, v, w] = edges(0, [1, 2, 3]);
            let alpha = triple([u, v, w]);
            let squares = dot(u, u) + dot(v, v) + dot(w, w);
            let products = dot(u, v) + dot(v, w) + dot(w, u);
            let ideal = 3.0 * (2.0 * alpha * alpha).cbrt();
            vec![(alpha, (1.5 * squares - products) / ideal)]
        }
        CellKind::Pyramid => {
            let corner = |k: usize| {
                let [u, v, w] = edges(k, [(k + 1) % 4, (k + 3) % 4, 4]);
                let alpha = triple([u, v, w]);
                let leaning = sub(scale(w, 2.0), add(u, v));
                let squares = dot(u, u) + dot(v, v) + 0.5 * dot(leaning, leaning);
                (alpha, squares / (3.0 * (2.0 * alpha * alpha).cbrt()))
            };
            (0..4).map(corner).collect()
        }
        CellKind::Wedge => {
            let below = (0..3).map(|k| box_like(k, [(k + 1) % 3, (k + 2) % 3, k + 3], 0.75));
            let above =
                (0..3).map(|k| box_like(k + 3, [(k + 2) % 3 + 3, (k + 1) % 3 + 3, k], 0.75));
            below.chain(above).collect()
        }
        _ => {
            let below = (0..4).map(|k| box_like(k, [(k + 1) % 4, (k + 3) % 4, k + 4], 1.0));
            let above = (0..4).map(|k| box_like(k + 4, [(k + 3) % 4 + 4, (k + 1) % 4 + 4, k], 1.0));
            below.chain(above).collect()
        }
    }
}

/// Size-skew by the definitions, of a cell that is upright in the reference mesh.
fn by_definition(kind: CellKind, now: &[Vector], before: &[Vector]) -> f64 {
    let sum = |p: &[Vector]| corners(kind, p).iter().map(|(alpha, _)| alpha).sum::<f64>();
    let all = corners(kind, now);
    if all.iter().any(|(alpha, _)| *alpha <= 0.0) {
        return 0.0;
    }
    let tau = sum(now) / sum(before);
    let skew = all.len() as f64 / all.iter().map(|(_, badness)| badness).sum::<f64>();
    tau.min(1.0 / tau).sqrt() * skew
}

#[test]
fn shaken_cells_of_every_kind_have_the_size_skew_of_the_definitions() {
    for (kind, before) in ideal() {
        let mesh = one(kind, &before);
        for seed in 0..200 {
            let shift =
                |i: usize, k: usize| (f64::from(seed * 31) + (7 * i + k) as f64 * 12.9898).sin();
            let size = 0.004 * f64::from(seed % 100);
            let is_plane = kind.dimension() == 2;
            let moved = (0..before.len()).map(|i| {
                let [x, y, z] = before[i];
                let z = if is_plane {
                    0.0
                } else {
                    z + size * 0.1 * shift(i, 2)
                };
                [x + size * shift(i, 0), y + size * shift(i, 1), z]
            });
            let moved: Vec<Vector> = moved.collect();
            let (found, wanted) = (value(&mesh, &moved), by_definition(kind, &moved, &before));
            assert!(
                (found - wanted).abs() < 1e-13,
                "{kind:?} {seed}: {found} {wanted}"
            );
        }
    }
}

/// Cells with equal angles; edges of a hexahedron, and those along a wedge, may differ.
fn ideal() -> Vec<(CellKind, Vec<Vector>)> {
    let h = 0.75f64.sqrt();
    let triangle = |z: f64| [[0., 0., z], [1., 0., z], [0.5, h, z]];
    let square = |z: f64| [[0., 0., z], [1., 0., z], [1., 1., z], [0., 1., z]];
    let apex = [0.5, 0.5, 0.5f64.sqrt()];
    let peak = [0.5, h / 3.0, (2.0f64 / 3.0).sqrt()];
    vec![
        (CellKind::Triangle, triangle(0.0).to_vec()),
        (
            CellKind::Quadrilateral,
            square(0.0).map(|[x, y, z]| [3.0 * x, y, z]).to_vec(),
        ),
        (
            CellKind::Tetrahedron,
            [&triangle(0.0)[..], &[peak]].concat(),
        ),
        (CellKind::Pyramid, [&square(0.0)[..], &[apex]].concat()),
        (CellKind::Wedge, [triangle(0.0), triangle(0.1)].concat()),
        (CellKind::Hexahedron, [square(0.0), square(0.1)].concat()),
    ]
}

fn value(mesh: &Mesh, points: &[Vector]) -> f64 {
    let judge = QualityEvaluator::new(mesh);
    let found = judge.assess(mesh, points).cells.size_skew;
    assert_eq!(found.min.map(|e| e.value), found.mean);
    let (_, sizes) = Reference::with_sizes(mesh);
    let array = per_cell(mesh, points, &judge.reference, &sizes);
    assert_eq!(
        array.values,
        Values::F64(vec![found.mean.expect("it is defined")])
    );
    found.mean.expect("it is defined")
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-13
}

#[test]
fn an_ideal_cell_has_one_and_loses_by_its_size_alone() {
    for (kind, points) in ideal() {
        let mesh = one(kind, &points);
        assert!(close(value(&mesh, &points), 1.0), "{kind:?}");
        let grown: Vec<Vector> = points.iter().map(|p| p.map(|x| 2.0 * x)).collect();
        let lost = 2f64.powi(-i32::from(kind.dimension())).sqrt();
        assert!(close(value(&mesh, &grown), lost), "{kind:?}");
        let shrunk: Vec<Vector> = points.iter().map(|p| p.map(|x| 0.5 * x)).collect();
        assert!(close(value(&mesh, &shrunk), lost), "{kind:?}");
    }
}

#[test]
fn a_cell_that_turns_over_has_nothing_whichever_way_its_nodes_go() {
    for (kind, points) in ideal() {
        let mirrored: Vec<Vector> = points.iter().map(|&[x, y, z]| [-x, y, z]).collect();
        let (mesh, other) = (one(kind, &points), one(kind, &mirrored));
        assert_eq!(value(&mesh, &mirrored), 0.0, "{kind:?}");
        assert!(close(value(&other, &mirrored), 1.0), "{kind:?}");
        assert_eq!(value(&other, &points), 0.0, "{kind:?}");
        let flat: Vec<Vector> = points.iter().map(|&[x, _, z]| [x, 0.0, z]).collect();
        assert_eq!(value(&mesh, &flat), 0.0, "{kind:?}");
    }
}

#[test]
fn a_sheared_hexahedron_has_the_skew_of_its_angle() {
    let (kind, points) = ideal().pop().expect("the last is a hexahedron");
    let sheared: Vec<Vector> = points.iter().map(|&[x, y, z]| [x + y, y, z]).collect();
    // The sine of 45 degrees at every corner; the volume stays.
    let wanted = 0.5f64.powf(1.0 / 3.0);
    assert!(close(value(&one(kind, &points), &sheared), wanted));
}

#[test]
fn cells_bad_in_the_reference_and_kinds_without_it_are_left_out() {
    let dart = [[0., 0., 0.], [2., 0., 0.], [0.4, 0.4, 0.], [0., 2., 0.]];
    let mut mesh = one(CellKind::Quadrilateral, &dart);
    mesh.cells.push(CellKind::Polygon, &[0, 1, 3]);
    let found = QualityEvaluator::new(&mesh).assess(&mesh, &mesh.points);
    assert_eq!(found.cells.size_skew, SizeSkew::default());
}

#[test]
fn inverse_cube_roots_are_right_to_the_last_places() {
    for i in -280..280 {
        for factor in [1.0, 1.3, 1.7, 2.4, 3.3, 4.9, 7.1, 9.99] {
            let x = factor * 10f64.powi(i);
            let root = inverse_cube_root(x);
            assert!((root * x.cbrt() - 1.0).abs() < 1e-15, "{x}");
        }
    }
}

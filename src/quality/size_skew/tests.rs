//! Size-skew of cells whose values are known.

use super::super::{Judge, Reference};
use super::*;

fn one(kind: CellKind, points: &[Vector]) -> Mesh {
    let mut mesh = Mesh {
        points: points.to_vec(),
        ..Mesh::default()
    };
    let nodes: Vec<u32> = (0..points.len() as u32).collect();
    mesh.cells.push(kind, &nodes);
    mesh
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
    let judge = Judge::new(mesh);
    let found = judge.assess(mesh, points, &mesh.points).size_skew;
    assert_eq!(found.min.map(|e| e.value), found.mean);
    let array = per_cell(mesh, points, &mesh.points, &judge.reference);
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
    let found = assess(&mesh, &mesh.points, &mesh.points, &Reference::new(&mesh));
    assert_eq!(found, SizeSkew::default());
}

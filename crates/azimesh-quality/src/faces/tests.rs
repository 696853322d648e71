//! Face metrics of cells whose values are known.

use super::super::QualityEvaluator;
use azimesh_io::mesh::{CellKind, Cells, Mesh};

/// Two unit cubes side by side, the second a polyhedron where `as_polyhedron`.
fn two_cubes(as_polyhedron: bool) -> Mesh {
    let mut mesh = Mesh::default();
    for k in 0..2 {
        for j in 0..2 {
            for i in 0..3 {
                mesh.points.push([i, j, k].map(f64::from));
            }
        }
    }
    mesh.cells
        .push(CellKind::Hexahedron, &[0, 1, 4, 3, 6, 7, 10, 9]);
    let second = [1, 2, 5, 4, 7, 8, 11, 10];
    if as_polyhedron {
        let mut stream = vec![6];
        for face in CellKind::Hexahedron.faces() {
            stream.push(4);
            stream.extend(face.iter().map(|&k| second[usize::from(k)]));
        }
        mesh.cells.push_polyhedron(&stream).expect("a good stream");
    } else {
        mesh.cells.push(CellKind::Hexahedron, &second)
    }
    mesh
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-12
}

#[test]
fn two_cubes_are_orthogonal_and_a_slanted_one_is_not() {
    for as_polyhedron in [false, true] {
        let mesh = two_cubes(as_polyhedron);
        let evaluator = QualityEvaluator::new(&mesh);
        let good = evaluator.assess(&mesh, &mesh.points).faces;
        assert_eq!((good.n_inner, good.n_outer), (1, 10));
        let value = |name: &str, quality: &super::FaceSummary| {
            let found = quality.columns().into_iter().find(|(n, _)| *n == name);
            found.and_then(|(_, value)| value).expect("it is defined")
        };
        assert!(close(value("max_non_orthogonality", &good), 0.0));
        assert!(close(value("max_face_skewness", &good), 0.0));
        assert!(close(value("min_volume_ratio", &good), 1.0));
        assert!(close(value("min_face_weight", &good), 0.5));
        // The second cube leans to y by 45 degrees and is twice as long: its centre is at (2, 1.5, 0.5),
        // and the line between the centres passes the face at y = 5/6, 1/3 above its centre.
        let moved: Vec<_> = mesh
            .points
            .iter()
            .map(|&[x, y, z]| {
                if x > 1.5 {
                    [3.0, y + 2.0, z]
                } else {
                    [x, y, z]
                }
            })
            .collect();
        let bad = evaluator.assess(&mesh, &moved).faces;
        let angle = (1.0f64 / 1.5).atan().to_degrees();
        assert!(close(value("max_non_orthogonality", &bad), angle));
        assert!(close(value("mean_non_orthogonality", &bad), angle));
        assert!(close(value("min_volume_ratio", &bad), 0.5));
        assert!(close(value("min_face_weight", &bad), 1.0 / 3.0));
        let arrays = super::per_cell(&mesh, &moved, &evaluator.reference, &evaluator.adjacency);
        assert!(close(arrays.non_orthogonality[0], angle));
        assert!(close(arrays.non_orthogonality[1], angle));
        assert!(close(arrays.volume_ratio[0], 0.5));
        assert!(close(arrays.skewness[0], (1.0 / 3.0) / 0.5));
    }
}

#[test]
fn a_mirrored_mesh_has_the_metrics_of_the_upright_one_and_is_as_valid() {
    for as_polyhedron in [false, true] {
        let upright = two_cubes(as_polyhedron);
        let mut mirrored = upright.clone();
        mirrored.points.iter_mut().for_each(|x| x[0] = -x[0]);
        // Leaning cells, and a corner pushed so far in that a polyhedron is not proven.
        let columns = |mesh: &Mesh, sign: f64, push: f64| {
            let evaluator = QualityEvaluator::new(mesh);
            let lean = |[x, y, z]: [f64; 3]| [x + 0.1 * sign * z, y + 0.4 * sign * x, z];
            let mut points: Vec<_> = mesh.points.iter().map(|x| lean(*x)).collect();
            points[11] = [0, 1, 2].map(|k| points[11][k] - push * [sign, 1.0, 1.0][k]);
            let mut columns = evaluator.assess(mesh, &points).columns();
            columns.retain(|(name, _)| *name != "inverted_reference");
            columns
        };
        for push in [0.0, 0.75] {
            let pairs =
                std::iter::zip(columns(&upright, 1.0, push), columns(&mirrored, -1.0, push));
            for ((name, wanted), (_, found)) in pairs {
                let [wanted, found] = [wanted, found].map(|of| of.unwrap_or(-1.0));
                assert!((wanted - found).abs() < 1e-12, "{name}: {wanted} {found}");
                if name == "unproven" {
                    assert_eq!(found > 0.0, as_polyhedron && push > 0.0);
                }
            }
        }
    }
}

#[test]
fn the_skewness_of_an_outer_face_is_measured_against_two_fifths_of_the_height() {
    // A box of 1 x 1 x 10 whose top is shifted by 1: 0.5 off the middle, and 2/5 of 5 high.
    let mut mesh = Mesh::default();
    for [x, z] in [[0.0, 0.0], [1.0, 10.0]] {
        for [dx, dy] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            mesh.points.push([x + dx, dy, z]);
        }
    }
    mesh.cells
        .push(CellKind::Hexahedron, &[0, 1, 2, 3, 4, 5, 6, 7]);
    let evaluator = QualityEvaluator::new(&mesh);
    let columns = evaluator.assess(&mesh, &mesh.points).columns();
    let skewness = columns
        .iter()
        .find(|(name, _)| *name == "max_face_skewness");
    assert!(close(
        skewness.and_then(|of| of.1).expect("it has faces"),
        0.25
    ));
}

/// Every kind of cell with a neighbour of its own kind, mirrored at a face: the line between the centres
/// then is along the normal, whichever way the kind's faces point.
#[test]
fn a_cell_and_its_mirror_image_are_orthogonal_for_every_kind() {
    let ideal: [(CellKind, &[[f64; 3]]); 7] = [
        (
            CellKind::Triangle,
            &[[0., 0., 0.], [1., 0.3, 0.], [0., 1., 0.]],
        ),
        (
            CellKind::Quadrilateral,
            &[[0., 0., 0.], [1., 0., 0.], [1.3, 1., 0.], [0., 1., 0.]],
        ),
        (
            CellKind::Tetrahedron,
            &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0.3, 1.]],
        ),
        (
            CellKind::Pyramid,
            &[
                [0., 0., 0.],
                [1., 0., 0.],
                [1., 1., 0.],
                [0., 1., 0.],
                [0., 0.5, 1.],
            ],
        ),
        (
            CellKind::Wedge,
            &[
                [0., 0., 0.],
                [1., 0., 0.],
                [0., 1., 0.],
                [0., 0., 1.],
                [1., 0., 1.2],
                [0., 1., 1.],
            ],
        ),
        (
            CellKind::Hexahedron,
            &[
                [0., 0., 0.],
                [1., 0., 0.],
                [1., 1., 0.],
                [0., 1., 0.],
                [0., 0., 1.],
                [1., 0., 1.],
                [1., 1.4, 1.],
                [0., 1., 1.],
            ],
        ),
        (
            CellKind::Polygon,
            &[
                [0., 0., 0.],
                [1., 0., 0.],
                [1.5, 0.5, 0.],
                [1., 1., 0.],
                [0., 1., 0.],
            ],
        ),
    ];
    for (kind, corners) in ideal {
        // The cells share the face at x = 0 (in the plane an edge), which every one of them has.
        let mut mesh = Mesh {
            points: corners.to_vec(),
            ..Mesh::default()
        };
        let own: Vec<u32> = (0..corners.len() as u32).collect();
        mesh.cells.push(kind, &own);
        let mirrored: Vec<u32> = corners
            .iter()
            .zip(0..)
            .map(|(&[x, y, z], node)| {
                if x == 0.0 {
                    node
                } else {
                    mesh.points.push([-x, y, z]);
                    mesh.points.len() as u32 - 1
                }
            })
            .collect();
        mesh.cells.push(kind, &mirrored);
        let faces = QualityEvaluator::new(&mesh)
            .assess(&mesh, &mesh.points)
            .faces;
        assert_eq!(faces.n_inner, 1, "{kind:?}");
        let angle = faces.max_non_orthogonality.expect("a face").value;
        assert!(angle < 1e-5, "{kind:?}: {angle}");
        let ratio = faces.min_volume_ratio.expect("a face").value;
        assert!(close(ratio, 1.0), "{kind:?}: {ratio}");
    }
}

#[test]
fn a_cell_that_turns_over_has_a_negative_ratio_and_more_than_a_right_angle() {
    let mesh = two_cubes(false);
    let evaluator = QualityEvaluator::new(&mesh);
    let moved: Vec<_> = mesh
        .points
        .iter()
        .map(|&[x, y, z]| [if x > 1.5 { 0.75 } else { x }, y, z])
        .collect();
    let faces = evaluator.assess(&mesh, &moved).faces;
    assert!(faces.min_volume_ratio.expect("a face").value < 0.0);
    let angle = |x: f64| {
        let moved: Vec<_> = mesh
            .points
            .iter()
            .map(|&p| if p[0] > 1.5 { [x, p[1], p[2]] } else { p })
            .collect();
        let faces = evaluator.assess(&mesh, &moved).faces;
        faces.max_non_orthogonality.expect("a face").value
    };
    assert!(close(angle(0.75), 0.0) && close(angle(-1.5), 180.0));
}

#[test]
fn a_collapsed_cell_has_the_centre_of_what_it_is() {
    let mut mesh = two_cubes(false);
    // The far side of the second cube becomes a line, whose area is zero only but for rounding.
    (mesh.points[2], mesh.points[5]) = ([2.1, 0.3, 0.7], [1.9, 1.13, 0.57]);
    let mut cells = Cells::new();
    cells.push(CellKind::Hexahedron, mesh.cells.get(0).nodes);
    cells.push(CellKind::Hexahedron, &[1, 2, 5, 4, 7, 2, 5, 10]);
    mesh.cells = cells;
    let mut plain = mesh.clone();
    assert_eq!(plain.uncollapse().n_cells, 1);
    let [found, expected] = [&mesh, &plain].map(|mesh| {
        let evaluator = QualityEvaluator::new(mesh);
        evaluator.assess(mesh, &mesh.points).faces.columns()
    });
    for ((name, found), (_, expected)) in found.into_iter().zip(expected) {
        let [found, expected] = [found, expected].map(|value| value.expect("one inner face"));
        assert!(close(found, expected), "{name}: {found} {expected}");
    }
}

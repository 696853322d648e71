//! Metrics against VTK's, and orientation against the reference.

use super::*;
use crate::cells::CellMetrics;
use crate::detail::detail_arrays;
use azimesh_io::mesh::{CellKind, Mesh, Values};

fn assess(mesh: &Mesh, points: &[[f64; 3]], reference: &Reference) -> Summary {
    summary::assess(mesh, points, reference, &Reference::with_sizes(mesh).1)
}

/// Cells and metrics from VTK, by `testdata/generate/make_cell_quality.py`.
const FROM_VTK: &str = include_str!("../testdata/cell_quality.csv");

fn mesh_of(kind: CellKind, points: Vec<[f64; 3]>) -> Mesh {
    let mut mesh = Mesh {
        points,
        ..Mesh::default()
    };
    let nodes: Vec<u32> = (0..mesh.points.len() as u32).collect();
    mesh.cells.push(kind, &nodes);
    mesh
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs().max(1.0)
}

/// VTK's values, where it has the cell the other way round: the values of its mirror image.
fn as_vtk_has_it(mesh: &Mesh) -> CellMetrics {
    let upright = mesh_of(mesh.cells.get(0).kind, ideal(mesh.cells.get(0).kind));
    per_cell(mesh, &mesh.points, &Reference::new(&upright))
}

fn ideal(kind: CellKind) -> Vec<[f64; 3]> {
    let first = FROM_VTK
        .lines()
        .skip(1)
        .find(|line| line.starts_with(&format!("{},", kind.vtk())));
    coordinates(first.expect("the file has every kind"))
}

fn coordinates(line: &str) -> Vec<[f64; 3]> {
    let numbers: Vec<f64> = line
        .split(',')
        .skip(12)
        .map(|x| x.parse().expect("a number"))
        .collect();
    numbers.as_chunks::<3>().0.to_vec()
}

/// The kind of cell in a line, and its metrics; `None` where VTK has none.
fn metrics_of(line: &str) -> (CellKind, Vec<Option<f64>>) {
    let (kind, rest) = line.split_once(',').expect("a kind and metrics");
    let kind = CellKind::from_vtk(kind.parse().expect("a number")).expect("a known kind");
    let metrics = rest.split(',').take(11);
    (kind, metrics.map(|x| x.parse().ok()).collect())
}

#[test]
fn metrics_equal_those_of_vtk_on_random_cells_of_each_kind() {
    let mut n = 0;
    for line in FROM_VTK.lines().skip(1) {
        let (kind, vtk) = metrics_of(line);
        let vtk: Vec<f64> = vtk.iter().map(|x| x.unwrap_or(f64::NAN)).collect();
        let mesh = mesh_of(kind, coordinates(line));
        let ours = as_vtk_has_it(&mesh);
        let (size, scaled, skew) = (ours.volume[0], ours.scaled_jacobian[0], ours.skew[0]);
        if kind.dimension() == 2 {
            // VTK's are without the sign of the orientation.
            assert!(
                close(size.abs(), vtk[0].abs(), 1e-12),
                "{line}: area {size}"
            );
            assert!(
                close(scaled.abs(), vtk[1].abs(), 1e-12),
                "{line}: scaled {scaled}"
            );
        } else {
            assert!(close(size, vtk[0], 1e-12), "{line}: volume {size}");
            let scaled = if kind == CellKind::Pyramid {
                scaled.max(0.0)
            } else {
                scaled
            };
            assert!(close(scaled, vtk[1], 1e-12), "{line}: scaled {scaled}");
        }
        assert!(close(skew, vtk[2], 1e-9), "{line}: skew {skew}");
        let edge_ratio = ours.edge_ratio[0];
        assert!(
            vtk[3].is_nan() || close(edge_ratio, vtk[3], 1e-12),
            "{line}: edge ratio {edge_ratio}"
        );
        n += 1;
    }
    assert_eq!(n, 240);
}

#[test]
fn further_metrics_equal_those_of_vtk_on_random_cells_of_each_kind() {
    let mut n = 0;
    for line in FROM_VTK.lines().skip(1) {
        let (kind, vtk) = metrics_of(line);
        let mesh = mesh_of(kind, coordinates(line));
        // In 2D VTK does not know which way round a cell should be.
        let as_vtk = match kind.dimension() {
            2 => Reference::new(&mesh),
            _ => Reference::new(&mesh_of(kind, ideal(kind))),
        };
        let arrays = detail_arrays(&mesh, &mesh.points, &as_vtk);
        for (array, vtk) in arrays.iter().zip(&vtk[4..]) {
            let Values::F64(ours) = &array.values else {
                panic!("{} should hold numbers of 64 bits", array.name);
            };
            let Some(vtk) = vtk else {
                continue;
            };
            // VTK writes infinity so.
            let vtk = if *vtk >= 1e30 { f64::INFINITY } else { *vtk };
            let same = ours[0] == vtk || close(ours[0], vtk, 1e-9);
            assert!(same, "{line}: {} {} {vtk}", array.name, ours[0]);
            n += 1;
        }
    }
    assert_eq!(n, 40 * (5 + 7 + 4 + 1 + 3 + 4));
}

#[test]
fn a_cell_that_has_turned_over_has_no_shape() {
    for vtk in [5, 9, 10, 12, 13, 14] {
        let kind = CellKind::from_vtk(vtk).expect("a known kind");
        let upright = mesh_of(kind, ideal(kind));
        let mirrored: Vec<_> = upright.points.iter().map(|p| [-p[0], p[1], p[2]]).collect();
        for (reference, shape) in [
            (Reference::new(&upright), 0.0),
            (Reference::new(&mesh_of(kind, mirrored.clone())), 1.0),
        ] {
            let arrays = detail_arrays(&upright, &mirrored, &reference);
            let value = |name: &str| match &arrays.iter().find(|a| a.name == name) {
                Some(array) => match &array.values {
                    Values::F64(values) => values[0],
                    _ => f64::NAN,
                },
                None => f64::NAN,
            };
            assert!(close(value("Shape"), shape, 1e-14), "{kind:?}");
            assert_eq!(value("Jacobian") > 0.0, shape > 0.0, "{kind:?}");
        }
    }
}

#[test]
fn the_smallest_angle_of_a_tetrahedron_is_between_any_two_faces() {
    // 160 degrees at edge 02, which VTK 9.7 takes for 20.
    let turn = 160f64.to_radians();
    let points = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.5, 0.0],
        [0.0, 1.0, 0.0],
        [turn.cos(), 0.5, turn.sin()],
    ];
    let mesh = mesh_of(CellKind::Tetrahedron, points);
    let found = statistics(&mesh, &mesh.points, &Reference::new(&mesh));
    let angle = |name: &str| {
        let found = found.iter().find(|statistic| statistic.name == name);
        found.and_then(|f| f.min).map_or(f64::NAN, |e| e.value)
    };
    assert!(close(angle("min_angle"), 21.518_282_084_826_875, 1e-12));
    assert!(close(angle("max_angle"), 160.0, 1e-12));
}

#[test]
fn statistics_and_the_worst_cells_agree_with_the_cells() {
    let mut mesh = Mesh::default();
    for line in FROM_VTK.lines().skip(1) {
        let (kind, _) = metrics_of(line);
        if kind.dimension() == 3 {
            let first = mesh.points.len() as u32;
            mesh.points.extend(coordinates(line));
            let nodes: Vec<u32> = (first..mesh.points.len() as u32).collect();
            mesh.cells.push(kind, &nodes);
        }
    }
    let reference = Reference::new(&mesh);
    let cells = per_cell(&mesh, &mesh.points, &reference);
    let found = statistics(&mesh, &mesh.points, &reference);
    let scaled = &found[1];
    let mut sorted: Vec<(f64, usize)> = cells.scaled_jacobian.iter().copied().zip(0..).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    assert_eq!((scaled.name, scaled.n_cells), ("scaled_jacobian", 160));
    let min = scaled.min.expect("it is defined");
    assert_eq!((min.value, min.cell), sorted[0]);
    assert_eq!(scaled.max.map(|e| e.value), Some(sorted[159].0));
    let mean = sorted.iter().map(|(value, _)| value).sum::<f64>() / 160.0;
    assert!(close(scaled.mean.expect("it is defined"), mean, 1e-14));
    let names = |name| found.iter().find(|s| s.name == name).map(|s| s.n_cells);
    assert_eq!(names("aspect_ratio"), Some(40));
    assert_eq!(names("shape"), Some(160));
    let listed = worst(&mesh, &mesh.points, &reference, 7);
    let expected: Vec<usize> = sorted[..7].iter().map(|(_, cell)| *cell).collect();
    assert_eq!(listed.iter().map(|c| c.cell).collect::<Vec<_>>(), expected);
    assert!(worst(&mesh, &mesh.points, &reference, 0).is_empty());
    assert_eq!(worst(&mesh, &mesh.points, &reference, 1000).len(), 160);
}

#[test]
fn a_cell_is_judged_by_its_own_orientation_in_the_reference() {
    for vtk in [5, 9, 10, 12, 13, 14] {
        let kind = CellKind::from_vtk(vtk).expect("a known kind");
        let upright = ideal(kind);
        let mirrored: Vec<_> = upright.iter().map(|p| [-p[0], p[1], p[2]]).collect();
        for (reference, other) in [(&upright, &mirrored), (&mirrored, &upright)] {
            let mesh = mesh_of(kind, reference.clone());
            let as_is = Reference::new(&mesh);
            let good = assess(&mesh, reference, &as_is);
            let reversed = kind.dimension() == 3 && std::ptr::eq(reference, &mirrored);
            let expected = (0, usize::from(reversed));
            assert_eq!(
                (good.inverted, good.inverted_reference),
                expected,
                "{kind:?}"
            );
            let best = good.min_scaled_jacobian.expect("it is defined").value;
            assert!(close(best, 1.0, 1e-14), "{kind:?}: {best}");
            assert!(good.min_volume.expect("it is defined").value > 0.0);
            let bad = assess(&mesh, other, &as_is);
            assert_eq!((bad.inverted, bad.inverted_cells), (1, vec![0]), "{kind:?}");
            assert!(bad.min_volume.expect("it is defined").value < 0.0);
            assert!(bad.min_scaled_jacobian.expect("it is defined").value < 0.0);
        }
    }
}

#[test]
fn a_cell_that_is_bad_in_the_reference_never_counts_as_inverted() {
    let dart = vec![[0., 0., 0.], [2., 0., 0.], [0.4, 0.4, 0.], [0., 2., 0.]];
    let mesh = mesh_of(CellKind::Quadrilateral, dart.clone());
    let reference = Reference::new(&mesh);
    let summary = assess(&mesh, &dart, &reference);
    assert_eq!((summary.inverted, summary.inverted_reference), (0, 1));
    assert!(summary.min_scaled_jacobian.expect("it is defined").value < 0.0);
}

#[test]
fn a_cell_with_nodes_twice_has_the_metrics_of_the_cell_that_it_is() {
    let corners = ideal(CellKind::Hexahedron);
    let through = |points: &[[f64; 3]]| -> Vec<[f64; 3]> {
        points.iter().map(|p| [p[0], p[1], -p[2]]).collect()
    };
    for (listed, kind, nodes) in [
        // The edge of nodes 3 and 7 coincides with the edge of nodes 0 and 4.
        (
            [0, 1, 2, 0, 4, 5, 6, 4],
            CellKind::Wedge,
            &[0, 1, 2, 4, 5, 6][..],
        ),
        (
            [4, 5, 6, 4, 0, 1, 2, 0],
            CellKind::Wedge,
            &[4, 5, 6, 0, 1, 2],
        ),
        (
            [0, 1, 2, 3, 6, 6, 6, 6],
            CellKind::Pyramid,
            &[0, 1, 2, 3, 6],
        ),
        (
            [0, 1, 2, 2, 4, 4, 4, 4],
            CellKind::Tetrahedron,
            &[0, 1, 2, 4],
        ),
    ] {
        let mesh = |kind, nodes: &[u32]| {
            let mut mesh = Mesh {
                points: corners.clone(),
                ..Mesh::default()
            };
            mesh.cells.push(kind, nodes);
            mesh
        };
        let [listed, known] = [mesh(CellKind::Hexahedron, &listed), mesh(kind, nodes)];
        let references = [&listed, &known].map(Reference::new);
        for points in [corners.clone(), through(&corners), vec![[0.0; 3]; 8]] {
            let [found, expected] = [(&listed, &references[0]), (&known, &references[1])]
                .map(|(mesh, reference)| assess(mesh, &points, reference));
            assert_eq!(found, expected, "{kind:?}");
            let [found, expected] = [(&listed, &references[0]), (&known, &references[1])]
                .map(|(mesh, reference)| statistics(mesh, &points, reference));
            assert_eq!(format!("{found:?}"), format!("{expected:?}"), "{kind:?}");
            let [found, expected] = [(&listed, &references[0]), (&known, &references[1])]
                .map(|(mesh, reference)| validity::invalid(mesh, &points, reference));
            assert_eq!(found, expected, "{kind:?}");
        }
        assert_eq!(
            assess(&listed, &through(&corners), &references[0]).inverted,
            1
        );
    }
}

#[test]
fn the_shape_of_a_pyramid_does_not_depend_on_its_numbering_and_is_zero_where_a_corner_is_folded() {
    let warped = [
        [0., 0., 0.],
        [1., 0., 0.3],
        [1., 1., 0.],
        [0., 1., 0.2],
        [0.4, 0.5, 0.9],
    ];
    let shape = |points: [[f64; 3]; 5]| {
        let mesh = mesh_of(CellKind::Pyramid, points.to_vec());
        let upright = mesh_of(CellKind::Pyramid, ideal(CellKind::Pyramid));
        let found = statistics(&mesh, &mesh.points, &Reference::new(&upright));
        let shape = found.iter().find(|metric| metric.name == "shape");
        shape
            .and_then(|shape| shape.mean)
            .expect("a pyramid has a shape")
    };
    let first = shape(warped);
    assert!(first > 0.5);
    for turn in 1..4 {
        let base = |i: usize| warped[(i + turn) % 4];
        let turned = [base(0), base(1), base(2), base(3), warped[4]];
        assert!(close(shape(turned), first, 1e-14));
    }
    let mut folded = warped;
    folded[0] = [0.9, 0.9, 0.0];
    assert_eq!(shape(folded), 0.0);
}

#[test]
fn a_curved_surface_mesh_is_judged_by_each_cells_own_normal() {
    let mut mesh = mesh_of(
        CellKind::Triangle,
        vec![[0., 0., 0.], [0., 1., 0.], [0., 0., 1.]],
    );
    let reference = Reference::new(&mesh);
    assert_eq!(assess(&mesh, &mesh.points, &reference).inverted, 0);
    mesh.points[2] = [0., 0., -1.];
    assert_eq!(assess(&mesh, &mesh.points, &reference).inverted, 1);
}

#[test]
fn polygons_and_polyhedra_have_a_size_and_boundary_faces_have_nothing() {
    let mut mesh = mesh_of(CellKind::Hexahedron, ideal(CellKind::Hexahedron));
    let faces = [
        6, 4, 0, 4, 7, 3, 4, 1, 2, 6, 5, 4, 0, 1, 5, 4, 4, 3, 7, 6, 2, 4, 0, 3, 2, 1, 4, 4, 5, 6, 7,
    ];
    mesh.cells.push_polyhedron(&faces).expect("a good stream");
    mesh.cells.push(CellKind::Quadrilateral, &[0, 1, 2, 3]);
    let reference = Reference::new(&mesh);
    let cells = per_cell(&mesh, &mesh.points, &reference);
    assert!(close(cells.volume[0], 1.0, 1e-14) && close(cells.volume[1], 1.0, 1e-14));
    assert!(cells.scaled_jacobian[1].is_nan() && cells.volume[2].is_nan());
    let summary = assess(&mesh, &mesh.points, &reference);
    assert_eq!((summary.n_cells, summary.inverted), (2, 0));
    assert!(close(summary.total_volume, 2.0, 1e-14));
}

#[test]
fn the_summary_is_the_same_on_any_number_of_threads_and_agrees_with_the_cells() {
    let mut mesh = Mesh::default();
    let mut seed = 1u64;
    let mut random = || {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    for cell in 0..30_000u32 {
        for corner in ideal(CellKind::Tetrahedron) {
            mesh.points.push(corner.map(|x| x + 0.5 * random()));
        }
        let nodes: Vec<u32> = (4 * cell..4 * cell + 4).collect();
        mesh.cells.push(CellKind::Tetrahedron, &nodes);
    }
    let reference = Reference::new(&mesh);
    let moved: Vec<_> = mesh
        .points
        .iter()
        .map(|p| p.map(|x| x + 0.3 * random()))
        .collect();
    let on = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build();
        pool.expect("threads start")
            .install(|| assess(&mesh, &moved, &reference))
    };
    let summary = on(1);
    assert_eq!(summary, on(2));
    assert_eq!(summary, on(3));
    let cells = per_cell(&mesh, &moved, &reference);
    let max_skew = cells.skew.iter().copied().fold(0.0, f64::max);
    assert_eq!(summary.max_skew.map(|e| e.value), Some(max_skew));
    assert_eq!(
        summary.inverted,
        cells.inverted.iter().filter(|&&x| x).count()
    );
    assert!(summary.inverted > 0);
    let mut scaled = cells.scaled_jacobian;
    scaled.sort_by(f64::total_cmp);
    let p01 = summary.p01_scaled_jacobian.expect("it is defined");
    assert!(close(p01, scaled[300], 1e-3), "{p01} {}", scaled[300]);
}

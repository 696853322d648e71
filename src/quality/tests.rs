//! Metrics against VTK's, and orientation against the reference.

use super::*;
use crate::mesh::{CellKind, Mesh};

/// Cells and metrics from VTK, by `scripts/make_cell_quality.py`.
const FROM_VTK: &str = include_str!("../../testdata/cell_quality.csv");

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

/// VTK's values, where it has the cell the other way round: those of its mirror image.
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
        .skip(4)
        .map(|x| x.parse().expect("a number"))
        .collect();
    numbers.as_chunks::<3>().0.to_vec()
}

#[test]
fn metrics_equal_those_of_vtk_on_random_cells_of_each_kind() {
    let mut n = 0;
    for line in FROM_VTK.lines().skip(1) {
        let fields: Vec<f64> = line
            .split(',')
            .map(|x| x.parse().expect("a number"))
            .collect();
        let kind = CellKind::from_vtk(fields[0] as u8).expect("a known kind");
        let mesh = mesh_of(kind, coordinates(line));
        let ours = as_vtk_has_it(&mesh);
        let (size, scaled, skew) = (ours.volume[0], ours.scaled_jacobian[0], ours.skew[0]);
        if kind.dimension() == 2 {
            // VTK's are without the sign of the orientation.
            assert!(
                close(size.abs(), fields[1].abs(), 1e-12),
                "{line}: area {size}"
            );
            assert!(
                close(scaled.abs(), fields[2].abs(), 1e-12),
                "{line}: scaled {scaled}"
            );
        } else {
            assert!(close(size, fields[1], 1e-12), "{line}: volume {size}");
            let scaled = if kind == CellKind::Pyramid {
                scaled.max(0.0)
            } else {
                scaled
            };
            assert!(close(scaled, fields[2], 1e-12), "{line}: scaled {scaled}");
        }
        assert!(close(skew, fields[3], 1e-9), "{line}: skew {skew}");
        n += 1;
    }
    assert_eq!(n, 240);
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

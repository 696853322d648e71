//! Folded meshes become valid, and only where they were folded.

use super::*;
use crate::mesh::{Adjacency, CellKind};

/// A grid of `n` cells along each axis in the unit square or cube.
pub(super) fn grid(kind: CellKind, n: usize) -> Mesh {
    let solid = kind == CellKind::Hexahedron;
    let layers = if solid { n + 1 } else { 1 };
    let mut mesh = Mesh::default();
    let h = 1.0 / n as f64;
    for k in 0..layers {
        for j in 0..=n {
            for i in 0..=n {
                mesh.points.push([i as f64 * h, j as f64 * h, k as f64 * h]);
            }
        }
    }
    let node = |i: usize, j: usize, k: usize| (i + (n + 1) * (j + (n + 1) * k)) as u32;
    for k in 0..layers.max(2) - 1 {
        for j in 0..n {
            for i in 0..n {
                let ring = |k: usize| {
                    [
                        node(i, j, k),
                        node(i + 1, j, k),
                        node(i + 1, j + 1, k),
                        node(i, j + 1, k),
                    ]
                };
                let nodes = if solid {
                    [ring(k), ring(k + 1)].concat()
                } else {
                    ring(0).to_vec()
                };
                mesh.cells.push(kind, &nodes);
            }
        }
    }
    mesh
}

fn repaired(mesh: &Mesh, points: &mut [Vector]) -> Repaired {
    let reference = Reference::new(mesh);
    let freedom = Freedom::inner(mesh, &Adjacency::of(mesh));
    let task = Task {
        mesh,
        reference: &reference,
        freedom: &freedom,
    };
    let found =
        untangle(task, points, Limits::default(), &Stop::default()).expect("nobody stops it");
    assert_eq!(
        invalid(mesh, points, &reference).len(),
        found.unrepaired.len()
    );
    found
}

#[test]
fn a_node_that_was_pushed_through_its_neighbours_comes_back() {
    for kind in [CellKind::Quadrilateral, CellKind::Hexahedron] {
        let mesh = grid(kind, 12);
        let mut points = mesh.points.clone();
        let middle = points.iter().position(|x| {
            x[..2].iter().all(|x| (x - 0.5).abs() < 1e-9)
                && (x[2] - 0.5).abs() < 0.6
                && (kind == CellKind::Quadrilateral || (x[2] - 0.5).abs() < 1e-9)
        });
        let middle = middle.expect("the middle is a node");
        points[middle][0] += 0.19;
        points[middle][1] += 0.11;
        let before = points.clone();
        let found = repaired(&mesh, &mut points);
        assert!(found.unrepaired.is_empty(), "{found:?}");
        assert_eq!(found.patches.len(), 1);
        let patch = &found.patches[0];
        assert!(patch.invalid_before > 1 && patch.invalid == 0 && patch.least_before < 0.0);
        assert!(patch.least > 0.0, "{patch:?}");
        let moved = points.iter().zip(&before).filter(|(a, b)| a != b).count();
        assert!(moved > 0 && moved <= patch.n_nodes && moved < mesh.points.len());
    }
}

#[test]
fn a_valid_mesh_stays_as_it_is() {
    let mesh = grid(CellKind::Hexahedron, 4);
    let mut points = mesh.points.clone();
    assert_eq!(repaired(&mesh, &mut points), Repaired::default());
    assert_eq!(points, mesh.points);
}

#[test]
fn a_cell_of_fixed_nodes_is_named() {
    let mesh = grid(CellKind::Quadrilateral, 6);
    let mut points = mesh.points.clone();
    // The corner of the square goes through the diagonal of its cell.
    points[0] = [0.2, 0.2, 0.0];
    let found = repaired(&mesh, &mut points);
    assert_eq!(
        found.unrepaired,
        [Unrepaired {
            cell: 0,
            reason: Reason::Fixed
        }]
    );
}

//! Folded meshes become valid, and only where they were folded.

use super::*;
use crate::QualityEvaluator;
use azimesh_core::geometry::Transform;
use azimesh_io::mesh::{Adjacency, CellKind, Coincident};
use azimesh_rbf::constraint::Constraint;

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
    repaired_with(
        mesh,
        points,
        &Freedom::inner(mesh, &Adjacency::of(mesh), &Coincident::default()),
    )
}

pub(super) fn repaired_with(mesh: &Mesh, points: &mut [Vector], freedom: &Freedom) -> Repaired {
    let reference = Reference::new(mesh);
    let task = Task {
        mesh,
        reference: &reference,
        freedom,
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

#[test]
fn sliding_nodes_make_room_along_their_line() {
    let mesh = grid(CellKind::Quadrilateral, 10);
    let mut points = mesh.points.clone();
    // A node of the lower side passes the next one.
    points[4][0] = 0.53;
    let adjacency = Adjacency::of(&mesh);
    let stays = repaired(&mesh, &mut points.clone());
    assert!(!stays.unrepaired.is_empty());
    assert!(
        stays
            .unrepaired
            .iter()
            .all(|left| left.reason == Reason::Boundary)
    );
    assert_eq!(stays.overtaken[0].nodes, [4, 5]);
    let mut freedom = Freedom::inner(&mesh, &adjacency, &Coincident::default());
    for node in (1..10).filter(|node| *node != 4) {
        freedom.hold(
            node,
            Constraint::of_normals(&[[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        );
    }
    let found = repaired_with(&mesh, &mut points, &freedom);
    assert_eq!(
        (found.unrepaired, found.overtaken),
        (Vec::new(), Vec::new())
    );
    assert_eq!(points[4], [0.53, 0.0, 0.0]);
    assert!(points[5][0] > 0.53);
    assert!(
        (0..=10).all(|node| points[node][1] == 0.0),
        "they stay on the line"
    );
}

#[test]
fn periodic_partners_move_together() {
    for turned in [false, true] {
        let mut mesh = grid(CellKind::Hexahedron, 8);
        // Sides x = 0 and x = 1, or these two with the second turned about the z axis by 20 degrees.
        let turn = Transform::rotation([0.0, 0.0, 1.0], [0.0, -3.0, 0.0], -20f64.to_radians());
        let map = if turned {
            turn
        } else {
            Transform::translation([1.0, 0.0, 0.0])
        };
        if turned {
            for x in &mut mesh.points {
                let by = Transform::rotation(
                    [0.0, 0.0, 1.0],
                    [0.0, -3.0, 0.0],
                    -x[0] * 20f64.to_radians(),
                );
                *x = by.apply([0.0, x[1], x[2]]);
            }
        }
        let mut freedom = Freedom::inner(&mesh, &Adjacency::of(&mesh), &Coincident::default());
        let mut partners = Vec::new();
        for (j, k) in (1..8).flat_map(|j| (1..8).map(move |k| (j, k))) {
            let leader = 9 * (j + 9 * k);
            freedom.free(leader);
            freedom.free(leader + 8);
            partners.push(Partner {
                node: leader + 8,
                leader,
                map,
            });
        }
        freedom.pair(partners.clone());
        let mut points = mesh.points.clone();
        // A node of one side is pushed through its neighbours, and its partner alike.
        let pushed = 9 * (4 + 9 * 4);
        let by = [0.03, 0.17, 0.16];
        for axis in 0..3 {
            points[pushed as usize][axis] += by[axis];
            points[pushed as usize + 8][axis] += map.turn(by)[axis];
        }
        let found = repaired_with(&mesh, &mut points, &freedom);
        let invalid_before = found.patches.iter().map(|log| log.invalid_before);
        assert!(invalid_before.sum::<usize>() > 4, "{found:?}");
        assert_eq!(found.unrepaired, []);
        for partner in partners {
            let wanted = map.apply(points[partner.leader as usize]);
            assert!(distance(wanted, points[partner.node as usize]) < 1e-12);
        }
    }
}

#[test]
fn polyhedra_that_are_only_unproven_become_proven() {
    let hexahedra = grid(CellKind::Hexahedron, 4);
    let mut mesh = Mesh {
        points: hexahedra.points.clone(),
        ..Mesh::default()
    };
    for cell in hexahedra.cells.iter() {
        let mut stream = vec![6];
        for face in CellKind::Hexahedron.faces() {
            stream.push(4);
            stream.extend(face.iter().map(|&corner| cell.nodes[usize::from(corner)]));
        }
        mesh.cells.push_polyhedron(&stream).expect("a good stream");
    }
    // The node in the middle goes beyond the middle of a cell, which keeps a volume.
    let mut points = mesh.points.clone();
    points[62] = points[62].map(|x| x + 0.75 * 0.25);
    let before = invalid(&mesh, &points, &Reference::new(&mesh));
    assert!(!before.is_empty());
    assert!(before.iter().all(|(_, proof)| *proof == Proof::Unproven));
    let found = repaired(&mesh, &mut points);
    assert_eq!(found.patches[0].invalid_before, before.len());
    assert_eq!(found.unrepaired, []);
    assert_ne!(points[62], mesh.points[62].map(|x| x + 0.75 * 0.25));
}

#[test]
fn improvement_reaches_what_is_wanted_or_makes_nothing_worse() {
    for kind in [CellKind::Quadrilateral, CellKind::Hexahedron] {
        let mesh = grid(kind, 6);
        let evaluator = QualityEvaluator::new(&mesh);
        let reference = &evaluator.reference;
        let freedom = Freedom::inner(&mesh, &evaluator.adjacency, &Coincident::default());
        let task = Task {
            mesh: &mesh,
            reference,
            freedom: &freedom,
        };
        let mut shaken = mesh.points.clone();
        for (i, x) in shaken.iter_mut().enumerate() {
            if !freedom.is_fixed(i as u32) {
                x[0] += 0.06 * (7.0 * i as f64).sin();
                x[1] += 0.06 * (5.0 * i as f64).cos();
            }
        }
        let least = |points: &[Vector]| {
            let values = crate::scaled_jacobians(&mesh, points, reference);
            values.into_iter().fold(f64::INFINITY, f64::min)
        };
        let before = least(&shaken);
        assert!((0.05..0.8).contains(&before), "{before}");
        for (wanted, is_possible) in [(0.85, true), (1.0, false)] {
            let mut points = shaken.clone();
            improve(task, &evaluator, &mut points, wanted, &Stop::default())
                .expect("nobody stops it");
            let after = least(&points);
            assert_eq!(after >= wanted, is_possible, "{kind:?} {after}");
            assert!(after > before && invalid(&mesh, &points, reference).is_empty());
        }
    }
}

#[test]
fn a_patch_without_gain_keeps_its_bits() {
    // The middle of four cells is where their least value is largest; cells folded beyond repair are no better elsewhere.
    for (mesh, to) in [
        (grid(CellKind::Quadrilateral, 2), [0.5, 1.2, 0.0]),
        (curved_grid(CellKind::Triangle6, 1), [0.5, 5.0, 0.0]),
    ] {
        let evaluator = QualityEvaluator::new(&mesh);
        let freedom = Freedom::inner(&mesh, &evaluator.adjacency, &Coincident::default());
        let task = Task {
            mesh: &mesh,
            reference: &evaluator.reference,
            freedom: &freedom,
        };
        let mut points = mesh.points.clone();
        let logs = improve(task, &evaluator, &mut points, 1.0, &Stop::default());
        assert_eq!(logs.expect("nobody stops it"), []);
        assert_eq!(points, mesh.points);
        // The middle of the lower side passes the upper one.
        points[1] = to;
        let folded = points.clone();
        let found = repaired_with(&mesh, &mut points, &freedom);
        assert!(!found.unrepaired.is_empty());
        assert_eq!(points, folded);
    }
}

#[test]
fn a_grossly_folded_thin_layer_is_taken_from_its_rim() {
    // Cells of edge ratio 1,000, one of whose nodes has gone 300 layers up.
    let mut mesh = grid(CellKind::Quadrilateral, 12);
    for x in &mut mesh.points {
        x[1] *= 1e-3;
    }
    let mut points = mesh.points.clone();
    let middle = 6 + 13 * 6;
    points[middle][1] += 0.3e-1;
    points[middle][0] += 0.2;
    let found = repaired(&mesh, &mut points);
    assert_eq!(found.unrepaired, []);
    assert_eq!((found.patches.len(), found.patches[0].rings), (1, 1));
}

#[test]
fn a_wall_that_went_through_all_of_its_layers_takes_few_steps() {
    // Layers that grow by 1.3 from 1e-5 on; the wall bulges by 6,000 of the first.
    let mut mesh = grid(CellKind::Quadrilateral, 40);
    for x in &mut mesh.points {
        x[1] = 1e-5 * (1.3f64.powf(40.0 * x[1]) - 1.0) / 0.3;
    }
    let mut points = mesh.points.clone();
    for x in &mut points[..41] {
        let from_middle = (x[0] - 0.5) / 0.15;
        x[1] = if from_middle.abs() < 3.0 {
            0.06 * (-from_middle * from_middle).exp()
        } else {
            0.0
        };
    }
    let found = repaired(&mesh, &mut points);
    assert_eq!(found.unrepaired, []);
    assert!(found.patches[0].steps < 80, "{:?}", found.patches);
}

/// A grid of `n` cells of second order without nodes inside faces and cells along each axis; other points are in no cell.
fn curved_grid(kind: CellKind, n: usize) -> Mesh {
    let is_solid = kind.dimension() == 3;
    let side = 2 * n + 1;
    let places = |n: usize| (0..n).flat_map(move |k| (0..n).map(move |j| (j, k)));
    let mut mesh = Mesh::default();
    let h = 0.5 / n as f64;
    for (j, k) in places(side).filter(|(_, k)| is_solid || *k == 0) {
        let row = (0..side).map(|i| [i, j, k].map(|i| i as f64 * h));
        mesh.points.extend(row);
    }
    let node = |at: [usize; 3]| (at[0] + side * (at[1] + side * at[2])) as u32;
    let ring = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]];
    let up = |[i, j, _]: [usize; 3]| [i, j, 2];
    let [a, b, c, d] = ring;
    let cells: Vec<Vec<[usize; 3]>> = match kind {
        CellKind::Triangle6 => vec![vec![a, b, c], vec![a, c, d]],
        CellKind::Quadrilateral8 => vec![ring.to_vec()],
        CellKind::Wedge15 => {
            let wedge = |base: [[usize; 3]; 3]| [base, base.map(up)].concat();
            vec![wedge([a, c, b]), wedge([a, d, c])]
        }
        CellKind::Hexahedron20 => vec![[ring, ring.map(up)].concat()],
        _ => [
            [0, 1, 2],
            [1, 2, 0],
            [2, 0, 1],
            [0, 2, 1],
            [2, 1, 0],
            [1, 0, 2],
        ]
        .map(|axes| {
            let mut at = [0; 3];
            let path = axes.map(|axis| {
                at[axis] = 2;
                at
            });
            [vec![[0; 3]], path.to_vec()].concat()
        })
        .to_vec(),
    };
    for (i, j, k) in places(n).flat_map(|(j, k)| (0..n).map(move |i| (i, j, k))) {
        if !is_solid && k > 0 {
            continue;
        }
        for corners in &cells {
            let at =
                |corner: &[usize; 3]| [corner[0] + 2 * i, corner[1] + 2 * j, corner[2] + 2 * k];
            let mut nodes: Vec<u32> = corners.iter().map(|corner| node(at(corner))).collect();
            for edge in kind.edges() {
                let [from, to] = edge.map(|end| at(&corners[usize::from(end)]));
                nodes.push(node([0, 1, 2].map(|axis| (from[axis] + to[axis]) / 2)));
            }
            mesh.cells.push(kind, &nodes);
        }
    }
    mesh
}

const CURVED: [CellKind; 5] = [
    CellKind::Triangle6,
    CellKind::Quadrilateral8,
    CellKind::Tetrahedron10,
    CellKind::Hexahedron20,
    CellKind::Wedge15,
];

#[test]
fn a_bent_edge_is_unbent_without_its_corners() {
    for kind in CURVED {
        let mesh = curved_grid(kind, 3);
        let mut points = mesh.points.clone();
        // The middle of an inner edge along x.
        let middle = 3 + 7 * if kind.dimension() == 3 { 2 + 7 * 2 } else { 2 };
        points[middle][0] += 0.13;
        points[middle][1] += 0.2;
        let bent = points.clone();
        let found = repaired(&mesh, &mut points);
        assert_eq!(found.unrepaired, [], "{kind:?}");
        assert!(!found.patches.is_empty() && found.patches[0].rings == 0);
        let corners = mesh
            .cells
            .iter()
            .flat_map(|cell| &cell.nodes[..cell.kind.n_corners(cell.nodes.len())]);
        for &corner in corners {
            assert_eq!(points[corner as usize], bent[corner as usize]);
        }
        assert_ne!(points[middle], bent[middle]);
    }
}

#[test]
fn a_corner_that_left_the_middles_of_its_edges_behind_comes_back() {
    for kind in CURVED {
        let mesh = curved_grid(kind, 4);
        let mut points = mesh.points.clone();
        let corner = 4 + 9 * if kind.dimension() == 3 { 4 + 9 * 4 } else { 4 };
        points[corner][0] += 0.22;
        points[corner][1] += 0.16;
        let found = repaired(&mesh, &mut points);
        assert_eq!(found.unrepaired, [], "{kind:?}");
        assert!(!found.patches.is_empty(), "{kind:?}");
        let freedom = Freedom::inner(&mesh, &Adjacency::of(&mesh), &Coincident::default());
        for (node, (now, then)) in points.iter().zip(&mesh.points).enumerate() {
            assert!(
                now == then || !freedom.is_fixed(node as u32),
                "the boundary stays"
            );
        }
    }
}

#[test]
fn a_curved_boundary_that_folds_a_cell_is_named() {
    let mesh = curved_grid(CellKind::Triangle6, 2);
    let mut points = mesh.points.clone();
    // The upper side leaves its corner to the other side, and both sides there are of one triangle.
    points[21] = [-0.2, 1.0, 0.0];
    let before = points.clone();
    let found = repaired(&mesh, &mut points);
    let reasons = found.unrepaired.iter().map(|left| left.reason);
    assert_eq!(reasons.collect::<Vec<_>>(), [Reason::Fixed]);
    assert_eq!(points[21], before[21]);
}

//! Meshes that are numbered differently.

use crate::mesh::difference::{Difference, Tolerance};
use crate::mesh::{CellKind, Cells, DataArray, Group, Mesh, Values};
use crate::testing::assert_says;
use azimesh_core::error::ErrorKind;

/// A block of `n` hexahedra along each axis with tags "low" and "high" at its ends in x, a zone, and
/// arrays that distinguish nodes and cells.
fn block(n: usize) -> Mesh {
    let m = n + 1;
    let mut mesh = Mesh::default();
    for i in 0..m * m * m {
        let [x, y, z] = [i % m, i / m % m, i / m / m].map(|i| i as f64);
        mesh.points.push([x + 0.1 * y, y, 0.7 * z]);
    }
    let node = |x: usize, y: usize, z: usize| (x + m * (y + m * z)) as u32;
    for i in 0..n * n * n {
        let (x, y, z) = (i % n, i / n % n, i / n / n);
        let floor = |z: usize| {
            [
                node(x, y, z),
                node(x + 1, y, z),
                node(x + 1, y + 1, z),
                node(x, y + 1, z),
            ]
        };
        let corners = [floor(z), floor(z + 1)].concat();
        mesh.cells.push(CellKind::Hexahedron, &corners);
    }
    let mut group = |dimension: u8, name: &str, cells: std::ops::Range<usize>| {
        mesh.groups
            .push(Group::new(dimension, name, None, cells.collect()));
    };
    let n_cells = n * n * n;
    group(3, "all", 0..n_cells);
    group(2, "low", n_cells..n_cells + n * n);
    group(2, "high", n_cells + n * n..n_cells + 2 * n * n);
    for x in [0, n] {
        for (y, z) in (0..n * n).map(|i| (i % n, i / n)) {
            let corners = [
                node(x, y, z),
                node(x, y + 1, z),
                node(x, y + 1, z + 1),
                node(x, y, z + 1),
            ];
            mesh.cells.push(CellKind::Quadrilateral, &corners);
        }
    }
    with_ids(mesh)
}

fn with_ids(mut mesh: Mesh) -> Mesh {
    let ids = |n: usize| Values::I32((0..n as i32).collect());
    mesh.point_arrays = vec![DataArray::scalar("node", ids(mesh.points.len()))];
    mesh.cell_arrays = vec![DataArray::scalar("cell", ids(mesh.cells.len()))];
    mesh
}

/// 0 to `n` in some other order.
fn shuffled(n: usize, seed: u64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..n).collect();
    let mut state = seed;
    for i in (1..n).rev() {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        order.swap(i, (state >> 33) as usize % (i + 1));
    }
    order
}

/// The same mesh with its nodes and cells in another order; cells begin at other nodes.
fn renumbered(mesh: &Mesh, seed: u64) -> Mesh {
    let nodes = shuffled(mesh.points.len(), seed);
    let cells = shuffled(mesh.cells.len(), seed + 1);
    let mut new_node = vec![0; nodes.len()];
    for (new, &old) in nodes.iter().enumerate() {
        new_node[old] = new as u32;
    }
    let mut new_cell = vec![0; cells.len()];
    let mut other = Mesh::default();
    for (new, &old) in cells.iter().enumerate() {
        new_cell[old] = new;
        let cell = mesh.cells.get(old);
        let mut corners: Vec<u32> = cell.nodes.iter().map(|&n| new_node[n as usize]).collect();
        match cell.kind {
            CellKind::Hexahedron => {
                corners[..4].rotate_left(new % 4);
                corners[4..].rotate_left(new % 4);
            }
            CellKind::Tetrahedron => corners[..3].rotate_left(new % 3),
            _ => corners.reverse(),
        }
        other.cells.push(cell.kind, &corners);
    }
    other.points = nodes.iter().map(|&old| mesh.points[old]).collect();
    other.groups = mesh.groups.clone();
    for group in &mut other.groups {
        group.cells = group.cells.iter().map(|old| new_cell[old]).collect();
    }
    let pick = |arrays: &[DataArray], order: &[usize]| {
        arrays.iter().map(|array| array.select(order)).collect()
    };
    other.point_arrays = pick(&mesh.point_arrays, &nodes);
    other.cell_arrays = pick(&mesh.cell_arrays, &cells);
    other
}

fn compare(a: &Mesh, b: &Mesh) -> Difference {
    Difference::by_position(a, b, Tolerance::default(), None).expect("a suitable tolerance")
}

#[test]
fn a_renumbered_mesh_is_the_same_mesh() {
    let a = block(5);
    for seed in 1..6 {
        let b = renumbered(&a, seed);
        assert!(!Difference::between(&a, &b, Tolerance::default()).is_same());
        let found = compare(&a, &b);
        assert!(found.is_same() && found.notes.is_empty(), "{found:?}");
        assert_eq!(found.to_string(), "same: 216 nodes, 175 cells");
    }
}

#[test]
fn in_a_renumbered_mesh_one_node_moved_by_1e_9_is_found() {
    let a = block(4);
    let mut b = renumbered(&a, 7);
    b.points[17][2] += 1e-9;
    let found = compare(&a, &b);
    assert_eq!((found.moved_nodes, found.changed_cells), (1, 0));
    let pair = found.first_moved.expect("a node moved");
    assert_eq!(pair.partner, 17);
    assert!((pair.distance - 1e-9).abs() < 1e-15);
    let tolerance = Tolerance {
        value: 2e-9,
        relative: false,
    };
    let lenient = Difference::by_position(&a, &b, tolerance, None).expect("a suitable tolerance");
    assert!(lenient.is_same(), "{lenient:?}");
}

#[test]
fn in_a_renumbered_mesh_one_swapped_tag_and_one_changed_value_are_found() {
    let a = block(4);
    let mut b = a.clone();
    let (low, high): (Vec<usize>, Vec<usize>) = (
        a.groups[1].cells.iter().collect(),
        a.groups[2].cells.iter().collect(),
    );
    b.groups[1].cells = low[1..].iter().chain(&high[..1]).copied().collect();
    b.groups[2].cells = high[1..].iter().chain(&low[..1]).copied().collect();
    let found = compare(&a, &renumbered(&b, 3));
    assert_eq!(found.groups.len(), 2, "{found:?}");
    assert_says(&found.groups[0], "\"low\": 1 of 16 cells");
    assert!(
        found.cells.is_empty() && found.arrays.is_empty(),
        "{found:?}"
    );
    let mut c = a.clone();
    c.cell_arrays[0].values =
        Values::F64((0..96).map(|i| f64::from(i) + f64::from(i == 50)).collect());
    let found = compare(&a, &renumbered(&c, 4));
    assert_eq!(
        found.arrays,
        ["cell array \"cell\" differs in 1 of 96 values, first at 50: 50 and 51"]
    );
}

#[test]
fn a_cell_turned_inside_out_and_one_wired_otherwise_are_found() {
    let a = block(2);
    for (what, order) in [
        ("mirrored", [4, 5, 6, 7, 0, 1, 2, 3]),
        ("crossed", [0, 2, 1, 3, 4, 5, 6, 7]),
    ] {
        let mut b = a.clone();
        b.cells = Cells::new();
        for cell in a.cells.iter() {
            match cell.index {
                3 => b
                    .cells
                    .push(cell.kind, &order.map(|i: usize| cell.nodes[i])),
                _ => b.cells.push(cell.kind, cell.nodes),
            }
        }
        let found = compare(&a, &renumbered(&b, 5));
        assert_eq!(found.changed_cells, 1, "{what}: {found:?}");
        assert!(found.cells[0].contains("hexahedron 3"), "{what}: {found:?}");
    }
}

#[test]
fn nodes_and_cells_that_one_mesh_lacks_are_counted() {
    let a = block(3);
    let mut b = a.clone();
    b.points[0] = [-50.0, 0.0, 0.0];
    let found = compare(&a, &renumbered(&b, 9));
    assert_eq!(found.unpaired_nodes, [1, 1]);
    // The cell at the corner, and its face in "low".
    assert_eq!(found.changed_cells, 2, "{found:?}");
    assert_says(&found, "1 node of the first mesh and 1 of the second");
    b.points.pop();
    let mut c = Mesh::of_points(a.points.clone());
    c.points.push([9.0; 3]);
    let found = compare(&a, &c);
    assert_eq!((found.unpaired_nodes, found.changed_cells), ([0, 1], 45));
}

/// Two blocks that touch and share no nodes, as zones do.
fn two_zones(n: usize) -> Mesh {
    let one = block(n);
    let mut mesh = one.clone();
    let n_nodes = one.points.len() as u32;
    let n_cells = one.cells.len();
    mesh.points
        .extend(one.points.iter().map(|p| [p[0] + n as f64, p[1], p[2]]));
    for cell in one.cells.iter() {
        let nodes: Vec<u32> = cell.nodes.iter().map(|node| node + n_nodes).collect();
        mesh.cells.push(cell.kind, &nodes);
    }
    for group in &one.groups {
        mesh.groups.push(Group {
            name: format!("second {}", group.name),
            cells: group.cells.iter().map(|cell| cell + n_cells).collect(),
            ..group.clone()
        });
    }
    with_ids(mesh)
}

#[test]
fn nodes_at_one_place_are_told_apart_by_their_cells() {
    let a = two_zones(3);
    assert_eq!(a.n_repeated_nodes(), 16);
    for seed in 1..4 {
        let found = compare(&a, &renumbered(&a, seed));
        assert!(found.is_same() && found.notes.is_empty(), "{found:?}");
    }
    // The same where the places are not quite the same.
    let mut b = renumbered(&a, 4);
    for (node, point) in b.points.iter_mut().enumerate() {
        point[0] += if node % 2 == 0 { 1e-10 } else { -1e-10 };
    }
    let tolerance = Tolerance {
        value: 1e-9,
        relative: false,
    };
    let found = Difference::by_position(&a, &b, tolerance, None).expect("a suitable tolerance");
    assert!(found.is_same(), "{found:?}");
}

#[test]
fn nodes_that_nothing_tells_apart_are_paired_in_order_and_it_is_said() {
    let one = block(2);
    let mut a = one.clone();
    a.points.extend(one.points.clone());
    for cell in one.cells.iter() {
        let nodes: Vec<u32> = cell.nodes.iter().map(|node| node + 27).collect();
        a.cells.push(cell.kind, &nodes);
    }
    let a = with_ids(a);
    let found = compare(&a, &a);
    assert!(found.is_same(), "{found:?}");
    assert_eq!(found.notes.len(), 1);
    assert!(
        found.notes[0]
            .text
            .starts_with("nodes at the same place (54)"),
        "{found:?}"
    );
}

#[test]
fn rounded_coordinates_match_within_a_tolerance() {
    let a = block(4);
    let mut b = renumbered(&a, 11);
    for point in &mut b.points {
        *point = point.map(|x| f64::from(x as f32));
    }
    assert!(compare(&a, &b).unpaired_nodes[0] > 0);
    let tolerance = Tolerance {
        value: 1e-6,
        relative: true,
    };
    let found = Difference::by_position(&a, &b, tolerance, None).expect("a suitable tolerance");
    assert!(found.is_same() && found.max_distance() > 0.0, "{found:?}");
    let strict = Tolerance::default();
    let found = Difference::by_position(&a, &b, strict, Some(1e-5)).expect("a suitable tolerance");
    assert!(
        found.moved_nodes > 0 && found.unpaired_nodes == [0, 0],
        "{found:?}"
    );
}

#[test]
fn a_tolerance_that_tells_no_nodes_apart_is_refused() {
    let a = block(10);
    let mut b = a.clone();
    b.points.iter_mut().for_each(|point| point[0] += 1e-3);
    let error = Difference::by_position(&a, &b, Tolerance::default(), Some(100.0));
    let error = error.expect_err("everything is near everything");
    assert_eq!(error.kind, ErrorKind::Input);
    assert_says(&error.message, "--match-tolerance");
}

#[test]
fn polyhedra_are_known_by_their_faces() {
    let stream = [4, 3, 0, 1, 2, 3, 0, 3, 1, 3, 1, 3, 2, 3, 0, 2, 3];
    let turned = [4, 3, 2, 3, 0, 3, 2, 0, 1, 3, 3, 1, 0, 3, 3, 2, 1];
    let inside_out = [4, 3, 2, 1, 0, 3, 0, 3, 1, 3, 1, 3, 2, 3, 0, 2, 3];
    let mesh = |stream: &[u32]| {
        let mut mesh =
            Mesh::of_points(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]);
        mesh.cells.push_polyhedron(stream).expect("a good stream");
        mesh
    };
    assert!(compare(&mesh(&stream), &mesh(&turned)).is_same());
    let found = compare(&mesh(&stream), &mesh(&inside_out));
    assert_eq!(found.changed_cells, 1, "{found:?}");
}

#[test]
fn meshes_without_nodes_or_cells_are_the_same() {
    assert!(compare(&Mesh::default(), &Mesh::default()).is_same());
    let found = compare(&block(1), &Mesh::default());
    assert_eq!((found.unpaired_nodes, found.changed_cells), ([8, 0], 3));
}

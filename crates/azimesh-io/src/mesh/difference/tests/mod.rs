//! Each kind of difference, in order.

mod position;

use super::*;
use crate::mesh::{CellKind, Cells, DataArray, Group, Values};
use crate::testing::assert_says;

fn square(faces_first: bool) -> Mesh {
    let mut mesh = Mesh::of_points(vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]);
    let volume = |mesh: &mut Mesh| {
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        mesh.cells.push(CellKind::Triangle, &[0, 2, 3]);
    };
    if !faces_first {
        volume(&mut mesh);
    }
    let first = mesh.cells.len();
    mesh.cells.push(CellKind::Line, &[0, 1]);
    mesh.cells.push(CellKind::Line, &[1, 2]);
    if faces_first {
        volume(&mut mesh);
    }
    mesh.groups.push(Group::new(
        1,
        "wall",
        None,
        [first, first + 1].into_iter().collect(),
    ));
    let ids = if faces_first {
        vec![3, 4, 1, 2]
    } else {
        vec![1, 2, 3, 4]
    };
    mesh.cell_arrays
        .push(DataArray::scalar("id", Values::I32(ids)));
    mesh
}

fn between(a: &Mesh, b: &Mesh) -> Difference {
    Difference::between(a, b, Tolerance::default())
}

#[test]
fn faces_before_or_after_volumes_are_the_same_mesh() {
    let found = between(&square(true), &square(false));
    assert!(found.is_same(), "{found:?}");
    assert_eq!(found.to_string(), "same: 4 nodes, 4 cells");
}

#[test]
fn a_moved_node_is_named_and_a_tolerance_lets_it_pass() {
    let (a, mut b) = (square(true), square(true));
    b.points[2][0] += 1e-3;
    let found = between(&a, &b);
    assert_eq!(found.moved_nodes, 1);
    assert_eq!(found.furthest.map(|pair| pair.node), Some(2));
    assert!(!found.is_same() && found.to_string().contains("node 2, by 0.001"));
    let relative = true;
    for (value, relative, same) in [
        (1.1e-3, false, true),
        (9e-4, false, false),
        (8e-4, relative, true),
    ] {
        let found = Difference::between(&a, &b, Tolerance { value, relative });
        assert_eq!(found.is_same(), same, "{value} {relative}");
    }
}

#[test]
fn cells_groups_and_arrays_that_differ_are_each_told() {
    let a = square(true);
    let mut b = square(true);
    b.groups[0].name = "inlet".into();
    b.cell_arrays[0].values = Values::F64(vec![3.0, 4.0, 1.0, 2.5]);
    b.cells.push(CellKind::Line, &[2, 3]);
    b.cell_arrays.clear();
    let found = between(&a, &b);
    assert_eq!(
        (found.changed_cells, found.groups.len(), found.arrays.len()),
        (1, 2, 1)
    );
    let mut c = square(true);
    c.groups[0].cells = [1].into_iter().collect();
    c.cell_arrays[0].values = Values::F64(vec![3.0, 4.0, 1.0, 2.5]);
    let found = between(&a, &c);
    assert_eq!((found.groups.len(), found.arrays.len()), (1, 1));
    assert!(
        found.arrays[0].contains("first at 3: 2 and 2.5"),
        "{}",
        found.arrays[0]
    );
    let mut d = square(true);
    let turned = [0u32, 3, 2];
    d.cells = Cells::new();
    for cell in a.cells.iter() {
        let last = cell.index == 3;
        d.cells
            .push(cell.kind, if last { &turned } else { cell.nodes });
    }
    assert_eq!(between(&a, &d).changed_cells, 1);
}

#[test]
fn one_node_moved_by_1e_9_is_found() {
    let (a, mut b) = (square(true), square(true));
    b.points[3][1] += 1e-9;
    let found = between(&a, &b);
    assert_eq!(found.moved_nodes, 1);
    assert_eq!(found.first_moved.map(|pair| pair.node), Some(3));
    assert!((found.max_distance() - 1e-9).abs() < 1e-15);
    b.points[3][1] = 1.0 + f64::EPSILON;
    assert_eq!(between(&a, &b).moved_nodes, 1);
}

#[test]
fn a_distance_too_small_or_too_large_to_square_is_one() {
    assert_eq!(nodes::distance([0.0; 3], [1e-200, 0.0, 0.0]), 1e-200);
    assert_eq!(nodes::distance([0.0; 3], [0.0, -1e200, 0.0]), 1e200);
    assert_eq!(nodes::distance([3.0, 0.0, 0.0], [0.0, 4.0, 0.0]), 5.0);
}

#[test]
fn one_swapped_tag_is_found() {
    let mut a = square(true);
    let far = Group {
        name: "far".into(),
        ..a.groups[0].clone()
    };
    a.groups.push(far);
    let mut b = a.clone();
    a.groups[0].cells = [0].into_iter().collect();
    a.groups[1].cells = [1].into_iter().collect();
    b.groups[0].cells = [1].into_iter().collect();
    b.groups[1].cells = [0].into_iter().collect();
    let found = between(&a, &b);
    assert!(found.cells.is_empty() && found.moved_nodes == 0);
    assert_eq!(found.groups.len(), 2);
    assert_eq!(
        found.groups[0],
        "boundary tag \"wall\": 1 of 1 cells differ"
    );
}

#[test]
fn one_reordered_cell_is_found() {
    let a = square(true);
    let mut b = a.clone();
    b.cells = Cells::new();
    for cell in [1, 0, 2, 3].map(|cell| a.cells.get(cell)) {
        b.cells.push(cell.kind, cell.nodes);
    }
    let found = between(&a, &b);
    assert_eq!(found.changed_cells, 2, "{found:?}");
    assert_says(&found, "2 cells differ");
}

#[test]
fn numbers_of_any_type_are_compared_by_their_values() {
    let with = |values: Values| {
        let mut mesh = square(true);
        mesh.point_arrays.push(DataArray::scalar("x", values));
        mesh
    };
    let integers = with(Values::U64(vec![0, 1, 2, u64::MAX]));
    let near = with(Values::U64(vec![0, 1, 2, u64::MAX - 1]));
    assert_eq!(between(&integers, &near).arrays.len(), 1);
    let reals = with(Values::F32(vec![0.0, 1.0, 2.0, f32::NAN]));
    assert!(between(&reals, &reals).is_same());
    let found = between(&with(Values::I8(vec![0, 1, 2, 3])), &reals).arrays;
    assert_says(&found[0], "1 of 4 values, first at 3: 3 and NaN");
    let text = with(Values::Text(
        ["a", "b", "c", "d"].map(String::from).to_vec(),
    ));
    assert!(between(&text, &reals).arrays[0].contains("text in one"));
}

//! Each kind of difference, in order and by position.

use super::super::CellKind;
use super::*;

fn square(faces_first: bool) -> Mesh {
    let mut mesh = Mesh {
        points: vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
        ..Mesh::default()
    };
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
    mesh.groups.push(Group {
        dimension: 1,
        name: "wall".into(),
        number: None,
        condition: None,
        cells: [first, first + 1].into_iter().collect(),
    });
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
    assert!(!found.is_same() && found.to_string().contains("node 2 most"));
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

//! A block of cubes for tests of the parts of a mesh.

use super::{CellKind, CellSet, Group, Mesh};

/// A block of `n` cubes along each axis: zones `rotor` and `stator`, a tag for each side of the block, `itf` on a half of the interface of the
/// zones, and `loose` of two faces on no cell.
pub fn cubes(n: u32) -> Mesh {
    let at = |[i, j, k]: [u32; 3]| i + (n + 1) * (j + (n + 1) * k);
    let mut mesh = Mesh::default();
    for node in 0..(n + 1).pow(3) {
        let [i, j, k] = [
            node % (n + 1),
            node / (n + 1) % (n + 1),
            node / (n + 1).pow(2),
        ];
        let bend = 0.1 * (f64::from(i) * 0.7).sin();
        let place = [f64::from(i), f64::from(j) + bend, f64::from(k) * 0.3];
        mesh.points.push(place);
    }
    let mut groups: Vec<Group> = Vec::new();
    let mut add = |dimension: u8, name: &str, cell: usize| {
        if groups.iter().all(|group| group.name != name) {
            groups.push(Group::new(dimension, name, None, CellSet::new()));
        }
        let group = groups.iter_mut().find(|group| group.name == name);
        group.expect("it is there").cells.push(cell);
    };
    for cell in 0..n.pow(3) {
        let [i, j, k] = [cell % n, cell / n % n, cell / n.pow(2)];
        let low = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[x, y]| at([i + x, j + y, k]));
        let high = low.map(|node| node + (n + 1).pow(2));
        mesh.cells.push(CellKind::Hexahedron, &[low, high].concat());
        let zone = if i < n / 3 { "rotor" } else { "stator" };
        add(3, zone, cell as usize);
    }
    let mut face = |tag: &str, (axis, level): (usize, u32), [a, b]: [u32; 2]| {
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[x, y]| {
            let mut place = [0; 3];
            place[axis] = level;
            place[(axis + 1) % 3] = a + x;
            place[(axis + 2) % 3] = b + y;
            at(place)
        });
        add(2, tag, mesh.cells.len());
        mesh.cells.push(CellKind::Quadrilateral, &corners);
    };
    for (axis, tags) in [["left", "right"], ["front", "back"], ["low", "high"]]
        .into_iter()
        .enumerate()
    {
        for (tag, level) in tags.into_iter().zip([0, n]) {
            (0..n * n).for_each(|i| face(tag, (axis, level), [i % n, i / n]));
        }
    }
    (0..n * n / 2).for_each(|i| face("itf", (0, n / 3), [i % n, i / n]));
    for nodes in [[0, n, 7, 9 * n], [3, n * n, 5 * n * n, 11]] {
        add(2, "loose", mesh.cells.len());
        mesh.cells.push(CellKind::Quadrilateral, &nodes);
    }
    mesh.groups = groups;
    mesh.validate().expect("it is good");
    mesh
}

/// The mesh with nodes and cells in another order.
pub fn shuffled(mesh: &Mesh) -> Mesh {
    const STEP: usize = 7919;
    let (n_nodes, n_cells) = (mesh.points.len(), mesh.cells.len());
    let moved = |at: usize, n: usize| (at * STEP + 5) % n;
    let new_node: Vec<u32> = (0..n_nodes).map(|at| moved(at, n_nodes) as u32).collect();
    let mut old_cell = vec![usize::MAX; n_cells];
    (0..n_cells).for_each(|at| old_cell[moved(at, n_cells)] = at);
    assert!(!old_cell.contains(&usize::MAX), "each place has a cell");
    let mut found = Mesh {
        points: mesh.points.clone(),
        cells: mesh.cells.select(old_cell),
        ..Mesh::default()
    };
    for (point, new) in mesh.points.iter().zip(&new_node) {
        found.points[*new as usize] = *point;
    }
    found.cells.renumber_nodes(&new_node);
    let group = |group: &Group| Group {
        cells: (group.cells.iter().map(|cell| moved(cell, n_cells))).collect(),
        ..group.clone()
    };
    found.groups = mesh.groups.iter().map(group).collect();
    found.validate().expect("it is good");
    found
}

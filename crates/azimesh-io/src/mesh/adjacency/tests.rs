use super::super::Faces;
use super::super::sides::for_each_side;
use super::*;

/// Cell, side, and the result across it.
fn listed(mesh: &Mesh) -> Vec<(usize, usize, Across)> {
    let adjacency = Adjacency::of(mesh);
    let mut found = Vec::new();
    for chunk in 0..adjacency.n_chunks() {
        let (cells, mut sides) = adjacency.chunk(chunk);
        for cell in cells.map(|cell| mesh.cells.get(cell)) {
            if cell.kind.dimension() == mesh.dimension() {
                for_each_side(&mesh.cells, &cell, |side, _| {
                    found.push((cell.index, side, sides.across()));
                });
            }
        }
    }
    found
}

fn with_points(n: usize) -> Mesh {
    Mesh::of_points(vec![[0.0; 3]; n])
}

#[test]
fn a_face_belongs_to_its_first_cell_and_knows_the_other_and_what_lies_on_it() {
    let mut mesh = with_points(6);
    mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
    mesh.cells.push(CellKind::Triangle, &[2, 1, 0]);
    mesh.cells.push(CellKind::Triangle, &[3, 2, 1]);
    mesh.cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
    let outside = Across::Outside(None);
    let wanted = [
        (0, 0, outside),
        (0, 1, Across::Cell(3)),
        (0, 2, outside),
        (0, 3, Across::Outside(Some(1))),
        (3, 0, outside),
        (3, 1, outside),
        (3, 2, outside),
        (3, 3, Across::Elsewhere),
    ];
    assert_eq!(listed(&mesh), wanted);
}

#[test]
fn polyhedra_meet_and_collapsed_sides_are_no_faces() {
    let mut mesh = with_points(12);
    let hexagons = [
        2, 6, 0, 1, 2, 3, 4, 5, 3, 0, 1, 6, //
    ];
    let other = [2, 6, 5, 4, 3, 2, 1, 0, 3, 0, 1, 7];
    let unlike = [1, 6, 0, 1, 2, 3, 4, 8];
    for stream in [&hexagons[..], &other, &unlike] {
        mesh.cells.push_polyhedron(stream).expect("a good stream");
    }
    mesh.cells
        .push(CellKind::Hexahedron, &[0, 1, 2, 2, 8, 9, 10, 10]);
    let found = listed(&mesh);
    assert_eq!(found[0], (0, 0, Across::Cell(1)));
    assert_eq!(found[2].2, Across::Elsewhere);
    assert_eq!(found[4], (2, 0, Across::Outside(None)));
    let collapsed = found.iter().filter(|side| side.0 == 3);
    let collapsed = collapsed.filter(|side| side.2 == Across::Elsewhere);
    assert_eq!(collapsed.count(), 1);
}

/// Cells of a grid of squares in an order that leaves no neighbours in one chunk.
#[test]
fn cells_far_apart_in_the_file_find_each_other() {
    let (n, m) = (200usize, 200usize);
    let mut mesh = with_points((n + 1) * (m + 1));
    let mut order: Vec<usize> = (0..n * m).collect();
    order.sort_by_key(|&cell| (cell.wrapping_mul(0x9e37_79b9) & 0xffff, cell));
    for &cell in &order {
        let (i, j) = (cell % n, cell / n);
        let a = (j * (n + 1) + i) as u32;
        let d = a + n as u32 + 1;
        mesh.cells
            .push(CellKind::Quadrilateral, &[a, a + 1, d + 1, d]);
    }
    let adjacency = Adjacency::of(&mesh);
    assert_eq!(adjacency.n_inner(), 2 * n * m - n - m);
    assert_eq!(adjacency.n_outer(), 2 * (n + m));
    assert_eq!(adjacency.n_outer(), Faces::of(&mesh).outer.len());
    for (cell, side, across) in listed(&mesh) {
        if let Across::Cell(other) = across {
            assert!(cell < other as usize);
            let (here, there) = (order[cell], order[other as usize]);
            let apart = [
                here.wrapping_sub(n),
                here + 1,
                here + n,
                here.wrapping_sub(1),
            ];
            assert_eq!(apart[side], there);
        }
    }
    let (bytes, foreseen) = (adjacency.memory_bytes(), Adjacency::estimate_bytes(&mesh));
    assert!(bytes.abs_diff(foreseen) < bytes / 50, "{bytes} {foreseen}");
}

//! Cells split, compared with plain sums over the faces of the cells before.

use super::super::sides::for_each_side;
use super::super::{CellKind, Cells, DataArray, Faces, Group, Mesh, Values};
use super::*;
use azimesh_core::geometry::vector::{Vector, cross, dot, sub};

/// The stream of a prism over a polygon, from its lower nodes and its upper ones.
fn prism(below: &[u32], above: &[u32]) -> Vec<u32> {
    let n = below.len();
    let mut stream = vec![2 + n as u32, n as u32];
    stream.extend(below.iter().rev());
    stream.push(n as u32);
    stream.extend(above);
    for i in 0..n {
        let next = (i + 1) % n;
        stream.extend([4, below[i], below[next], above[next], above[i]]);
    }
    stream
}

/// Prisms on top of one another over a polygon in the plane.
fn tower(outline: &[[f64; 2]], heights: &[f64]) -> Mesh {
    let n = outline.len() as u32;
    let level = |&z: &f64| outline.iter().map(move |&[x, y]| [x, y, z]);
    let mut mesh = Mesh::of_points(heights.iter().flat_map(level).collect());
    let ring = |k: usize| (k as u32 * n..(k as u32 + 1) * n).collect::<Vec<u32>>();
    for k in 1..heights.len() {
        let stream = prism(&ring(k - 1), &ring(k));
        mesh.cells.push_polyhedron(&stream).expect("a good stream");
    }
    mesh
}

const HEXAGON: [[f64; 2]; 6] = [
    [2.0, 0.0],
    [1.0, 1.5],
    [-1.0, 1.5],
    [-2.0, 0.0],
    [-1.0, -1.5],
    [1.0, -1.5],
];

/// A fan of three arms. It is seen from a small part of it alone, in which the mean of its corners is not.
const ARMS: [[f64; 2]; 8] = [
    [0.0, 0.0],
    [4.0, 0.0],
    [4.0, 0.2],
    [0.6, 0.4],
    [0.7, 4.0],
    [0.5, 4.0],
    [0.1, 0.5],
    [-0.2, 0.3],
];

/// A letter U, in which no point sees all others.
const U: [[f64; 2]; 8] = [
    [0.0, 0.0],
    [3.0, 0.0],
    [3.0, 3.0],
    [2.0, 3.0],
    [2.0, 1.0],
    [1.0, 1.0],
    [1.0, 3.0],
    [0.0, 3.0],
];

fn det(a: Vector, b: Vector, c: Vector) -> f64 {
    dot(a, cross(b, c))
}

/// Six times the volume at each corner of a tetrahedron or pyramid except its apex.
fn corner_volumes(nodes: &[u32], points: &[Vector]) -> Vec<f64> {
    let at = |i: usize| points[nodes[i] as usize];
    let n = nodes.len() - 1;
    let apex = at(n);
    let of = |i: usize| {
        let (next, before) = (at((i + 1) % n), at((i + n - 1) % n));
        det(sub(next, at(i)), sub(before, at(i)), sub(apex, at(i)))
    };
    (0..n).map(of).collect()
}

/// Of a tetrahedron or pyramid.
fn part_volume(nodes: &[u32], points: &[Vector]) -> f64 {
    let all: f64 = corner_volumes(nodes, points).iter().sum();
    all / if nodes.len() == 4 { 18.0 } else { 12.0 }
}

/// By the divergence theorem, with each face a fan around the mean of its nodes.
fn whole_volume(mesh: &Mesh, cell: usize) -> f64 {
    let mut volume = 0.0;
    for_each_side(&mesh.cells, &mesh.cells.get(cell), |_, nodes| {
        let at: Vec<Vector> = nodes.iter().map(|&n| mesh.points[n as usize]).collect();
        let mean = flat::mean(&at);
        for i in 0..at.len() {
            volume += det(mean, at[i], at[(i + 1) % at.len()]) / 6.0;
        }
    });
    volume
}

/// The mesh after, with its counts; its parts have the volumes of their cells, and no face is left open.
fn split(before: &Mesh) -> (Mesh, SplitCounts) {
    let mut mesh = before.clone();
    let origin = Values::I64((0..mesh.cells.len() as i64).collect());
    mesh.cell_arrays.push(DataArray::scalar("origin", origin));
    let counts = mesh.split_polyhedra().expect("there is room");
    mesh.validate().expect("it stays a good mesh");
    let Some(DataArray {
        values: Values::I64(origin),
        ..
    }) = mesh.cell_arrays.pop()
    else {
        panic!("the array is still there");
    };
    let mut volumes = vec![0.0; before.cells.len()];
    for cell in mesh.cells.iter().filter(is_part) {
        volumes[origin[cell.index] as usize] += part_volume(cell.nodes, &mesh.points);
    }
    for cell in before
        .cells
        .iter()
        .filter(|cell| is_split(cell.kind) && is_part(cell))
    {
        let (found, wanted) = (volumes[cell.index], whole_volume(before, cell.index).abs());
        assert!(
            (found - wanted).abs() <= 1e-13 * wanted,
            "cell {}: {found}, not {wanted}",
            cell.index
        );
    }
    let faces = Faces::of(&mesh);
    assert_eq!((faces.n_non_manifold, faces.dangling.len()), (0, 0));
    (mesh, counts)
}

/// Returns whether it is a solid cell other than a hexahedron, which no cell becomes.
fn is_part(cell: &CellRef<'_>) -> bool {
    cell.kind.dimension() == 3 && cell.kind != CellKind::Hexahedron
}

fn assert_positive(mesh: &Mesh) {
    for cell in mesh.cells.iter().filter(is_part) {
        let least = corner_volumes(cell.nodes, &mesh.points);
        assert!(
            least.iter().all(|volume| *volume > 0.0),
            "{cell:?}: {least:?}"
        );
    }
}

fn kinds(cells: &Cells) -> Vec<(CellKind, usize)> {
    cells.runs().map(|run| (run.kind, run.n_cells())).collect()
}

#[test]
fn two_cells_split_their_common_face_alike_and_the_boundary_follows() {
    let mut before = tower(&HEXAGON, &[0.0, 1.0, 3.0]);
    before.cells.push(CellKind::Polygon, &[5, 4, 3, 2, 1, 0]);
    before.cells.push(CellKind::Polygon, &[0, 1, 7, 6]);
    before
        .cells
        .push(CellKind::Polygon, &[14, 15, 16, 17, 12, 13]);
    before
        .groups
        .push(Group::new(2, "ends", None, [2, 4].into_iter().collect()));
    before
        .groups
        .push(Group::new(3, "upper", None, [1].into_iter().collect()));
    let (mesh, counts) = split(&before);
    let expected = SplitCounts {
        n_cells: 2,
        n_faces: 2,
        n_nodes: 5,
        ..SplitCounts::default()
    };
    assert_eq!(counts, expected);
    use CellKind::{Pyramid, Quadrilateral, Tetrahedron, Triangle};
    let wanted = [
        (Tetrahedron, 24),
        (Pyramid, 12),
        (Triangle, 12),
        (Quadrilateral, 1),
    ];
    assert_eq!(kinds(&mesh.cells), wanted);
    assert_positive(&mesh);
    // Two ends of six triangles and twelve sides are left outside, and on them all parts of the boundary.
    let faces = Faces::of(&mesh);
    assert_eq!((faces.outer.len(), faces.inside.len()), (2 * 6 + 12, 0));
    assert_eq!(faces.bare().count(), 11);
    let cells = |name: &str| {
        let group = mesh.groups.iter().find(|group| group.name == name);
        group
            .expect("it is kept")
            .cells
            .ranges()
            .collect::<Vec<_>>()
    };
    assert_eq!(cells("ends"), vec![36..48; 1]);
    assert_eq!(cells("upper"), [12..24, 30..36]);
}

#[test]
fn a_cell_beside_keeps_its_faces_and_prisms_of_five_and_six_sides_are_split_as_well() {
    let mut before = tower(&HEXAGON, &[0.0, 1.0, 2.0]);
    let ring: Vec<u32> = (6..18).collect();
    let lower = before.cells.select([0]);
    before.cells = lower;
    before.cells.push(CellKind::HexagonalPrism, &ring);
    before.points.extend([
        [4.0, 0.0, 0.0],
        [3.0, 1.5, 0.0],
        [4.0, 0.0, 1.0],
        [3.0, 1.5, 1.0],
    ]);
    before
        .cells
        .push(CellKind::Hexahedron, &[0, 18, 19, 1, 6, 20, 21, 7]);
    before
        .cells
        .push(CellKind::PentagonalPrism, &[0, 5, 4, 3, 2, 6, 11, 10, 9, 8]);
    let (alone, _) = split(&Mesh {
        cells: before.cells.select([0, 1, 2]),
        ..before.clone()
    });
    // The cells share the hexagon, split into six triangles, and the side at the hexahedron.
    let n_outer = Faces::of(&alone).outer.len();
    assert_eq!(n_outer, 2 * 6 + 12 + 6 - 2);
    assert_positive(&alone);
    let pentagonal = Mesh {
        cells: before.cells.select([3]),
        ..before.clone()
    };
    let mut split = pentagonal.clone();
    let counts = split.split_polyhedra().expect("there is room");
    assert_eq!((counts.n_cells, counts.n_nodes), (1, 3));
}

#[test]
fn a_cell_that_is_seen_from_one_place_only_has_positive_parts() {
    let before = tower(&ARMS, &[0.0, 0.5]);
    let mean = flat::mean(&before.points);
    let (mesh, counts) = split(&before);
    assert_eq!(counts.first_not_positive, None);
    assert_positive(&mesh);
    assert_ne!(mesh.points[mesh.points.len() - 1], mean);
}

#[test]
fn a_cell_that_is_not_seen_from_any_place_is_counted_and_keeps_its_volume() {
    let mut before = tower(&U, &[0.0, 1.0]);
    before.cells.push(CellKind::Vertex, &[0]);
    let (_, counts) = split(&before);
    assert_eq!(
        (counts.n_not_positive, counts.first_not_positive),
        (1, Some(0))
    );
}

#[test]
fn faces_that_turn_inward_or_differently_are_turned_outward() {
    let plain = tower(&HEXAGON, &[0.0, 1.0]);
    let (expected, _) = split(&plain);
    for turned in [&[0, 1, 2, 3, 4, 5, 6, 7][..], &[1, 4, 5], &[7]] {
        let mut stream = vec![8];
        for (i, face) in plain.cells.polyhedron_faces(0).enumerate() {
            stream.push(face.len() as u32);
            if turned.contains(&i) {
                stream.extend(face.iter().rev())
            } else {
                stream.extend(face)
            }
        }
        let mut mesh = Mesh::of_points(plain.points.clone());
        mesh.cells.push_polyhedron(&stream).expect("a good stream");
        let counts = mesh.split_polyhedra().expect("there is room");
        assert_eq!(counts.n_not_positive, 0, "{turned:?}");
        assert_positive(&mesh);
        assert_eq!(kinds(&mesh.cells), kinds(&expected.cells));
    }
}

#[test]
fn warped_faces_keep_the_volume_between_them() {
    let mut before = tower(&HEXAGON, &[0.0, 1.0, 2.5]);
    for (i, point) in before.points.iter_mut().enumerate() {
        for (k, x) in point.iter_mut().enumerate() {
            *x += 0.1 * ((7 * i + 3 * k) as f64).sin();
        }
    }
    let (mesh, counts) = split(&before);
    assert_eq!(counts.n_not_positive, 0);
    assert_positive(&mesh);
}

#[test]
fn a_cell_with_a_hole_is_counted() {
    let mut stream = prism(&[0, 1, 2, 3, 4, 5], &[6, 7, 8, 9, 10, 11]);
    stream.truncate(stream.len() - 5);
    stream[0] -= 1;
    let mut mesh = tower(&HEXAGON, &[0.0, 1.0]);
    mesh.cells = Cells::new();
    mesh.cells.push_polyhedron(&stream).expect("a good stream");
    let counts = mesh.split_polyhedra().expect("there is room");
    assert_eq!(counts.n_not_positive, 1);
    mesh.validate().expect("it stays a good mesh");
}

/// Polygons in the plane: six corners turning left, eight turning right, five, four and three.
fn plane() -> Mesh {
    let mut mesh = Mesh::default();
    let mut add = |corners: &[[f64; 2]]| {
        let first = mesh.points.len() as u32;
        mesh.points
            .extend(corners.iter().map(|&[x, y]| [x, y, 0.0]));
        let nodes: Vec<u32> = (first..first + corners.len() as u32).collect();
        mesh.cells.push(CellKind::Polygon, &nodes);
    };
    add(&HEXAGON);
    add(&ARMS.iter().rev().copied().collect::<Vec<_>>());
    add(&HEXAGON[..5]);
    add(&HEXAGON[..4]);
    add(&HEXAGON[..3]);
    mesh.cells.push(CellKind::Line, &[0, 1]);
    mesh
}

fn area(nodes: &[u32], points: &[Vector]) -> f64 {
    let at = |i: usize| points[nodes[i % nodes.len()] as usize];
    let of = |i: usize| at(i)[0] * at(i + 1)[1] - at(i + 1)[0] * at(i)[1];
    (0..nodes.len()).map(of).sum::<f64>() / 2.0
}

#[test]
fn polygons_of_a_plane_mesh_keep_their_areas_and_the_way_they_turn() {
    let before = plane();
    let mut mesh = before.clone();
    let id = Values::I32((0..6).collect());
    mesh.cell_arrays.push(DataArray::scalar("id", id));
    let counts = mesh.split_polyhedra().expect("there is room");
    assert_eq!(
        (counts.n_cells, counts.n_nodes, counts.n_not_positive),
        (3, 3, 0)
    );
    let Values::I32(id) = &mesh.cell_arrays[0].values else {
        panic!("integers stay integers");
    };
    assert_eq!(mesh.cells.len(), 6 + 8 + 5 + 1 + 1 + 1);
    for cell in before
        .cells
        .iter()
        .filter(|cell| cell.kind == CellKind::Polygon)
    {
        let whole = area(cell.nodes, &before.points);
        let parts = mesh
            .cells
            .iter()
            .filter(|part| id[part.index] as usize == cell.index);
        let parts: Vec<f64> = parts.map(|part| area(part.nodes, &mesh.points)).collect();
        assert!(parts.iter().all(|part| part * whole > 0.0), "{parts:?}");
        assert!((parts.iter().sum::<f64>() - whole).abs() < 1e-14 * whole.abs().max(1.0));
    }
    assert!(mesh.points.iter().all(|point| point[2] == 0.0));
}

#[test]
fn a_concave_quadrilateral_stays_and_is_counted() {
    let mut mesh = Mesh::of_points(vec![
        [0., 0., 0.],
        [2., 0., 0.],
        [0.5, 0.5, 0.],
        [0., 2., 0.],
    ]);
    mesh.cells.push(CellKind::Polygon, &[0, 1, 2, 3]);
    let counts = mesh.split_polyhedra().expect("there is room");
    assert_eq!((counts.n_cells, counts.n_not_positive), (0, 1));
    assert_eq!(kinds(&mesh.cells), [(CellKind::Quadrilateral, 1)]);
}

#[test]
fn new_nodes_have_the_mean_of_a_face_or_a_cell() {
    let mut mesh = tower(&HEXAGON, &[0.0, 1.0]);
    let n = mesh.points.len();
    let places = mesh.points.as_flattened().to_vec();
    let words = (0..n).map(|i| i.to_string()).collect();
    mesh.point_arrays = vec![
        DataArray::tuples("place", 3, Values::F64(places)),
        DataArray::scalar("low", Values::I8((0..n).map(|i| i as i8 - 12).collect())),
        DataArray::scalar("half", Values::F32((0..n).map(|i| i as f32).collect())),
        DataArray::scalar("word", Values::Text(words)),
    ];
    mesh.split_polyhedra().expect("there is room");
    mesh.validate().expect("it stays a good mesh");
    // The lower hexagon's middle, the upper one's, the cell's.
    let [place, low, half, word] = &mesh.point_arrays[..] else {
        panic!("four arrays stay four");
    };
    assert_eq!(
        place.values,
        Values::F64(mesh.points.as_flattened().to_vec())
    );
    let Values::I8(low) = &low.values else {
        panic!("integers stay integers");
    };
    assert_eq!(
        low[n..],
        [-9, -3, -6],
        "means are -9.5, -3.5 and -6.5, and halves go up"
    );
    let Values::F32(half) = &half.values else {
        panic!("numbers keep their type");
    };
    assert_eq!(half[n..], [2.5, 8.5, 5.5]);
    let Values::Text(word) = &word.values else {
        panic!("text stays text");
    };
    assert!(word[n..].iter().all(String::is_empty));
}

#[test]
fn a_mesh_without_polyhedra_stays_as_it_is() {
    let mut mesh = Mesh::of_points(vec![[0.0; 3]; 4]);
    mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
    let before = mesh.clone();
    assert_eq!(
        mesh.split_polyhedra().expect("nothing to do"),
        SplitCounts::default()
    );
    assert_eq!(mesh, before);
}

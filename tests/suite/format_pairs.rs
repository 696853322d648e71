//! Round trips through every pair of formats, and `diff` as their judge.

use azimesh::sample::{self, BladeOptions, CellShape, SizeOptions};
use azimesh_io::formats::{self, Commit, WriteOptions};
use azimesh_io::mesh::{CellKind, Cells, DiffOptions, Difference, Group, Mesh, diff};
use std::path::Path;

const EXTENSIONS: [&str; 7] = ["vtu", "vtk", "vtkhdf", "cgns", "msh", "msh2", "su2"];
/// Solid meshes only, in an order of cells of its own: a start, not a stop on the way.
const UGRID: &str = "lb8.ugrid";

/// The mesh as it is read after it has been written, and whether a note tells of zones.
fn through(mesh: &Mesh, path: &Path) -> (Mesh, bool) {
    let commit = Commit {
        sync: false,
        ..Commit::REPLACE
    };
    let format = formats::by_extension(path).unwrap();
    let notes = formats::save(&mesh.view(), path, format, &WriteOptions::default(), commit);
    let notes = notes.unwrap();
    let of_zones = notes.iter().any(|note| note.to_string().contains("zone"));
    (Mesh::read(path).unwrap(), of_zones)
}

fn difference(a: &Mesh, b: &Mesh) -> Difference {
    diff(a, b, &DiffOptions::default()).unwrap()
}

/// A hexahedron with a pyramid on top, a tetrahedron at its side and a wedge beside it; triangles
/// and quadrilaterals in two tags; `zones` in two zones.
fn mixed(zones: bool) -> Mesh {
    let mut mesh = Mesh::default();
    let thirds = |x: [i32; 3]| x.map(|x| f64::from(x) / 3.0);
    mesh.points = [
        [0, 0, 0],
        [1, 0, 0],
        [1, 1, 0],
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 1],
        [1, 1, 1],
        [0, 1, 1],
        [1, 1, 2],
        [2, 0, 0],
        [2, 0, 1],
        [0, 2, 2],
    ]
    .map(thirds)
    .to_vec();
    let cells = &mut mesh.cells;
    cells.push(CellKind::Hexahedron, &[0, 1, 2, 3, 4, 5, 6, 7]);
    cells.push(CellKind::Pyramid, &[4, 5, 6, 7, 8]);
    cells.push(CellKind::Wedge, &[1, 2, 9, 5, 6, 10]);
    cells.push(CellKind::Tetrahedron, &[7, 6, 8, 11]);
    cells.push(CellKind::Quadrilateral, &[0, 3, 2, 1]);
    cells.push(CellKind::Quadrilateral, &[0, 1, 5, 4]);
    cells.push(CellKind::Triangle, &[4, 5, 8]);
    cells.push(CellKind::Triangle, &[5, 6, 8]);
    let mut group = |dimension, name: &str, cells: std::ops::Range<usize>| {
        mesh.groups.push(Group {
            dimension,
            name: name.into(),
            number: None,
            condition: None,
            cells: cells.collect(),
        });
    };
    group(2, "lower-wall", 4..6);
    group(2, "far", 6..8);
    if zones {
        group(3, "rotor", 0..2);
        group(3, "background", 2..4);
    }
    mesh
}

fn airfoil() -> Mesh {
    let size = SizeOptions {
        nodes: Some(800),
        ..SizeOptions::default()
    };
    sample::naca0012(&size).unwrap().mesh
}

/// Meshes by their names, and whether they have zones.
fn meshes() -> [(&'static str, Mesh, bool); 7] {
    let options = |cells| BladeOptions {
        size: SizeOptions {
            surface_nodes: Some(800),
            layers: Some(4),
            first_cell: Some(0.01),
            ..SizeOptions::default()
        },
        cells,
        ..BladeOptions::default()
    };
    let blade = |cells| sample::blade(&options(cells)).unwrap().mesh;
    let rotor = sample::rotor(&options(CellShape::Hex)).unwrap().mesh;
    [
        ("airfoil", airfoil(), false),
        ("hex", blade(CellShape::Hex), false),
        ("wedge", blade(CellShape::Wedge), false),
        ("tet", blade(CellShape::Tet), false),
        ("mixed", mixed(false), false),
        ("rotor", rotor, true),
        ("zones", mixed(true), true),
    ]
}

#[test]
fn every_mesh_survives_every_pair_of_formats() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str, extension| folder.path().join(format!("{name}.{extension}"));
    for (name, mesh, zones) in meshes() {
        let starts = EXTENSIONS.into_iter().chain([UGRID]);
        for a in starts.filter(|a| *a != UGRID || name != "airfoil") {
            let (start, _) = through(&mesh, &path("a", a));
            for b in EXTENSIONS {
                let (there, told) = through(&start, &path("b", b));
                let (back, _) = through(&there, &path("c", a));
                let loses_zones = zones && a != "su2" && a != UGRID && b == "su2";
                let found = difference(&start, &back);
                assert_eq!(found.is_same(), !loses_zones, "{name} {a} {b}: {found}");
                assert_eq!(told, loses_zones, "{name} {a} {b}");
            }
        }
    }
}

/// The mesh with the last node of its first boundary face replaced.
fn with_a_changed_cell(mesh: &Mesh) -> Mesh {
    let changed = mesh
        .boundary_tags()
        .next()
        .unwrap()
        .cells
        .iter()
        .next()
        .unwrap();
    let mut cells = Cells::new();
    for cell in mesh.cells.iter() {
        let mut nodes = cell.nodes.to_vec();
        if cell.index == changed {
            let other = (0..).find(|node| !nodes.contains(node)).unwrap();
            *nodes.last_mut().unwrap() = other;
        }
        cells.push(cell.kind, &nodes);
    }
    Mesh {
        cells,
        ..mesh.clone()
    }
}

#[test]
fn diff_finds_a_node_a_tag_and_a_cell_that_changed_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    for (name, mesh) in [("airfoil", airfoil()), ("mixed", mixed(false))] {
        let mut moved = mesh.clone();
        moved.points[5][0] = moved.points[5][0].next_up();
        let mut renamed = mesh.clone();
        renamed.groups[0].name = "other".into();
        let mut regrouped = mesh.clone();
        let (first, second) = (&mesh.groups[0].cells, &mesh.groups[1].cells);
        let given = first.iter().last().unwrap();
        regrouped.groups[0].cells = first.iter().filter(|cell| *cell != given).collect();
        regrouped.groups[1].cells = [given].into_iter().chain(second.iter()).collect();
        for extension in EXTENSIONS {
            let read = |mesh: &Mesh| through(mesh, &folder.path().join(format!("x.{extension}"))).0;
            let right = read(&mesh);
            assert!(difference(&right, &read(&mesh)).is_same());
            for (what, changed) in [
                ("a node", &moved),
                ("a tag's name", &renamed),
                ("a tag's faces", &regrouped),
                ("a cell", &with_a_changed_cell(&mesh)),
            ] {
                let found = difference(&right, &read(changed));
                assert!(!found.is_same(), "{name}.{extension}, {what}");
            }
        }
    }
}

//! Files that gmsh wrote, by `testdata/generate/make_gmsh_versions.py`.

use super::super::{Encoding, Notes, ReadOptions, Source, WriteOptions};
use super::{MSH22, MSH41};
use crate::mesh::{CellKind, Mesh, Values, lagrange};
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/gmsh")
}

fn read_with(name: &str, options: &ReadOptions) -> (Mesh, Notes) {
    let source = Source::open(&folder().join(name)).expect("the file is there");
    let mut notes = Notes::default();
    let mesh = MSH41
        .read_file(&source, options, &mut notes)
        .map(|mut mesh| {
            mesh.validate().expect("a good mesh");
            mesh.merge_repeated_faces();
            mesh
        });
    (mesh.expect("a good file"), notes)
}

fn read(name: &str) -> Mesh {
    read_with(name, &ReadOptions::default()).0
}

/// A position, to the 16 digits of gmsh's text.
type LatticePoint = [i64; 3];
type Cell = (CellKind, Vec<LatticePoint>);
/// Places of the nodes; cells by the places of their nodes, sorted; groups by dimension and number,
/// with cells. Some of gmsh's writers number nodes anew.
type Canonical = (
    Vec<LatticePoint>,
    Vec<Cell>,
    Vec<(u8, Option<i32>, Vec<Cell>)>,
);

fn canonical(mesh: &Mesh) -> Canonical {
    let place = |node: u32| mesh.points[node as usize].map(|x| (x * 1e12).round() as i64);
    let mut nodes: Vec<LatticePoint> = (0..mesh.points.len() as u32).map(place).collect();
    nodes.sort_unstable();
    let cell = |cell: usize| -> Cell {
        let cell = mesh.cells.get(cell);
        (
            cell.kind,
            cell.nodes.iter().map(|node| place(*node)).collect(),
        )
    };
    let sorted = |mut cells: Vec<Cell>| {
        cells.sort();
        cells
    };
    let cells = sorted((0..mesh.cells.len()).map(cell).collect());
    let groups = mesh.groups.iter().map(|group| {
        let cells = sorted(group.cells.iter().map(cell).collect());
        (group.dimension, group.number, cells)
    });
    let mut groups: Vec<_> = groups.collect();
    groups.sort();
    (nodes, cells, groups)
}

#[test]
fn one_model_is_the_same_mesh_in_every_version() {
    let expected = canonical(&read("cylinder_v41.msh"));
    assert_eq!(expected.2.len(), 4);
    let mut n_files = 0;
    for entry in std::fs::read_dir(folder()).expect("the folder is there") {
        let name = entry
            .expect("a file")
            .file_name()
            .into_string()
            .expect("plain");
        if !name.starts_with("cylinder_") {
            continue;
        }
        n_files += 1;
        let (mesh, notes) = read_with(&name, &ReadOptions::default());
        assert_eq!(canonical(&mesh), expected, "{name}");
        let names: Vec<&str> = mesh.groups.iter().map(|group| &group.name[..]).collect();
        if name.starts_with("cylinder_v1") {
            assert_eq!(names, ["7", "8", "9", "7"]);
        } else {
            assert_eq!(names, ["outer wall", "both", "air in it", "8"], "{name}");
        }
        let parametric = name.contains("parametric") || name.contains("binary");
        let said = notes.has("parametric_coordinates");
        assert_eq!(said, parametric, "{name} {notes:?}");
    }
    assert_eq!(n_files, 10);
}

#[test]
fn partitions_are_an_array_and_leave_the_mesh_whole() {
    let expected = canonical(&read("partitioned_v41_binary.msh"));
    assert_eq!(expected.2.len(), 4);
    for name in ["partitioned_v2.msh", "partitioned_v40.msh"] {
        let (mesh, notes) = read_with(name, &ReadOptions::default());
        assert_eq!(canonical(&mesh), expected, "{name}");
        let partition = mesh
            .cell_arrays
            .iter()
            .find(|array| array.name == "gmsh:partition");
        let partition = partition.and_then(|array| array.values.to_integers());
        let partition = partition.expect("partitions");
        assert!(partition.iter().all(|p| (1..=3).contains(p)), "{name}");
        assert!((1..=3).all(|p| partition.contains(&p)), "{name}");
        let ghosts = notes
            .iter()
            .any(|note| note.get("section") == "GhostElements");
        assert_eq!(ghosts, name.contains("v40"), "{name} {notes:?}");
    }
}

/// The corners' mean at a place of the lattice.
fn between(kind: CellKind, corners: &[[f64; 3]], [i, j, k]: [f64; 3]) -> [f64; 3] {
    let square = |[i, j]: [f64; 2]| [(1.0 - i) * (1.0 - j), i * (1.0 - j), i * j, (1.0 - i) * j];
    let triangle = [1.0 - i - j, i, j];
    let two = |flat: &[f64]| {
        let low = flat.iter().map(|weight| weight * (1.0 - k));
        low.chain(flat.iter().map(|weight| weight * k)).collect()
    };
    let weights: Vec<f64> = match kind.linear() {
        CellKind::Line => vec![1.0 - i, i],
        CellKind::Triangle => triangle.to_vec(),
        CellKind::Quadrilateral => square([i, j]).to_vec(),
        CellKind::Tetrahedron => vec![1.0 - i - j - k, i, j, k],
        CellKind::Hexahedron => two(&square([i, j])),
        CellKind::Wedge => two(&triangle),
        // Along the base the places of a layer are stretched to the whole.
        _ => {
            let layer = (1.0 - k).max(1e-300);
            let base = square([i / layer, j / layer]).map(|weight| weight * (1.0 - k));
            base.into_iter().chain([k]).collect()
        }
    };
    std::array::from_fn(|axis| {
        let parts = weights.iter().zip(corners);
        parts.map(|(weight, corner)| weight * corner[axis]).sum()
    })
}

#[test]
fn nodes_of_high_order_lie_where_their_lattice_says() {
    for order in [3, 4] {
        for name in [
            format!("order{order}_v41.msh"),
            format!("order{order}_v22_binary.msh"),
        ] {
            let mesh = read(&name);
            assert_eq!(mesh.cells.len(), 7, "{name}");
            for cell in mesh.cells.iter() {
                let points: Vec<[f64; 3]> = cell
                    .nodes
                    .iter()
                    .map(|node| mesh.points[*node as usize])
                    .collect();
                assert_eq!(lagrange::order(cell.kind, points.len()), Some(order));
                let corners = &points[..cell.kind.n_corners(points.len())];
                for (place, point) in lagrange::lattice(cell.kind, order).iter().zip(&points) {
                    let expected = between(
                        cell.kind,
                        corners,
                        place.map(|i| f64::from(i) / order as f64),
                    );
                    let off = (0..3).map(|axis| (point[axis] - expected[axis]).abs());
                    assert!(
                        off.fold(0.0, f64::max) < 1e-7,
                        "{name} {:?} {place:?}",
                        cell.kind
                    );
                }
            }
        }
    }
}

#[test]
fn values_at_nodes_and_elements_are_read_at_each_time() {
    let source = Source::open(&folder().join("data_v41.msh")).expect("the file is there");
    assert_eq!((MSH41.steps)(&source).expect("a good file"), [0.0, 0.5]);
    let text = std::fs::read_to_string(folder().join("data_v41.msh")).expect("it is text");
    let comment = "$NodeData\n$Comments\nby hand\n$EndComments\n";
    let commented = text.replace("$NodeData\n", comment);
    assert_eq!(
        super::read::steps(commented.as_bytes()).expect("a good file"),
        [0.0, 0.5]
    );
    for (step, factor) in [(Some(0), 1.0), (Some(1), 2.0), (None, 2.0)] {
        let options = ReadOptions {
            step,
            ..ReadOptions::default()
        };
        let (mesh, _) = read_with("data_v41.msh", &options);
        let Values::F64(heights) = &mesh.point_arrays[0].values else {
            panic!("reals");
        };
        for (height, point) in heights.iter().zip(&mesh.points) {
            assert!((height - factor * point[2]).abs() < 1e-14);
        }
        let velocity = &mesh.cell_arrays[0];
        assert_eq!((&velocity.name[..], velocity.n_components), ("velocity", 3));
        let Values::F64(values) = &velocity.values else {
            panic!("reals");
        };
        let volumes = mesh
            .cells
            .iter()
            .filter(|cell| cell.kind == CellKind::Tetrahedron);
        for cell in volumes {
            let at = 3 * cell.index;
            assert_eq!(values[at..at + 3], [cell.index as f64 + 1.0, 0.25, -1.0]);
        }
        assert!(values[0].is_nan());
    }
    let options = ReadOptions {
        step: Some(2),
        ..ReadOptions::default()
    };
    let error = MSH41.read_file(&source, &options, &mut Notes::default());
    assert!(
        error
            .expect_err("two steps")
            .to_string()
            .contains("steps 0 to 1")
    );
}

/// Two triangles in two groups each, and values under one number of each.
#[test]
fn an_element_listed_for_each_of_its_groups_has_the_value_of_any_of_its_numbers() {
    for numbers in [[1, 3], [2, 4], [1, 4]] {
        let [first, second] = numbers;
        let file = format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n\
             $EndNodes\n$Elements\n4\n1 2 2 100 1 1 2 3\n2 2 2 101 1 1 2 3\n3 2 2 100 1 1 3 4\n\
             4 2 2 101 1 1 3 4\n$EndElements\n$ElementData\n1\n\"T\"\n1\n0\n3\n0\n1\n2\n\
             {first} 10\n{second} 20\n$EndElementData\n"
        );
        let source = Source::from_bytes(Path::new("twice.msh"), file.into_bytes());
        let mut notes = Notes::default();
        let mesh = MSH41.read_file(&source, &ReadOptions::default(), &mut notes);
        let mesh = mesh.expect("a good file");
        assert!(notes.is_empty(), "{notes:?}");
        assert_eq!(mesh.cells.len(), 2);
        assert_eq!(mesh.cell_arrays[0].values, Values::F64(vec![10.0, 20.0]));
    }
}

#[test]
fn what_gmsh_wrote_comes_back_from_both_versions() {
    for entry in std::fs::read_dir(folder()).expect("the folder is there") {
        let name = entry
            .expect("a file")
            .file_name()
            .into_string()
            .expect("plain");
        let mesh = read(&name);
        for (format, encoding) in [
            (&MSH41, Encoding::Raw),
            (&MSH41, Encoding::Ascii),
            (&MSH22, Encoding::Raw),
            (&MSH22, Encoding::Ascii),
        ] {
            let options = WriteOptions {
                encoding,
                ..WriteOptions::default()
            };
            let mut file = Vec::new();
            format
                .write_file(&mesh.view(), &mut file, &options)
                .expect("MSH holds it");
            let source = Source::from_bytes(Path::new("copy"), file);
            let mut back = MSH41
                .read_file(&source, &ReadOptions::default(), &mut Notes::default())
                .expect("a good file");
            back.merge_repeated_faces();
            assert_eq!(canonical(&back), canonical(&mesh), "{name} {}", format.name);
            for (old, new) in [
                (&mesh.point_arrays, &back.point_arrays),
                (&mesh.cell_arrays, &back.cell_arrays),
            ] {
                for array in old {
                    let same = new.iter().find(|other| other.name == array.name);
                    let same = same.unwrap_or_else(|| panic!("{name}: {} is lost", array.name));
                    assert_eq!(same.n_tuples(), array.n_tuples(), "{name} {}", array.name);
                }
            }
        }
    }
}

#[test]
fn a_section_without_its_end_is_passed_over_when_times_are_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("open.msh");
    let file = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$Elements\n1\n1 2 2 0 1 1 2 3\n$EndElements\n";
    std::fs::write(&path, file).expect("it can be written");
    let source = Source::open(&path).expect("it is there");
    assert_eq!((MSH41.steps)(&source).expect("it is good enough"), [0.0; 0]);
    let mesh = crate::formats::read(&source.into(), &ReadOptions::default());
    assert_eq!(mesh.expect("it is good enough").mesh.cells.len(), 1);
}

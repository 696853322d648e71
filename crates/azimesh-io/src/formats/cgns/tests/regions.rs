//! Groups by numbers: wrong ones are refused, and what a mesh cannot hold is named.

use super::*;
use crate::formats::hdf5::{Id, Tree};
use crate::testing::assert_says;

/// A hexahedron with its six faces in a tag.
fn boxed() -> Mesh {
    let corner = |i: u32| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)];
    let mut mesh = Mesh::of_points((0..8).map(corner).collect());
    mesh.cells
        .push(CellKind::Hexahedron, &[0, 1, 3, 2, 4, 5, 7, 6]);
    for face in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        mesh.cells.push(CellKind::Quadrilateral, &face);
    }
    mesh.groups = vec![group(2, "wall", 1..7)];
    mesh
}

/// A change of the first or the last occurrence of some bytes.
enum Change {
    First(&'static [i32], &'static [i32]),
    Last(&'static [i32], &'static [i32]),
    Text(&'static str, &'static str),
}

use Change::{First, Last, Text};

impl Change {
    fn apply(&self, bytes: &mut [u8]) {
        let (from, to): (&[u8], &[u8]) = match self {
            First(from, to) | Last(from, to) => {
                (bytemuck::cast_slice(from), bytemuck::cast_slice(to))
            }
            Text(from, to) => (from.as_bytes(), to.as_bytes()),
        };
        let at = match self {
            First(..) => memchr::memmem::find(bytes, from),
            _ => memchr::memmem::rfind(bytes, from),
        };
        let at = at.expect("it is there");
        bytes[at..at + from.len()].copy_from_slice(to);
    }
}

#[test]
fn regions_of_nodes_or_elements_that_are_not_there_are_refused() {
    let (good, _) = written(&boxed());
    let to_nodes = Text("FaceCenter", "Vertex\0\0\0\0");
    for (changes, expected) in [
        (
            &[Last(&[2, 7], &[2, 9])][..],
            "/Base/Zone/ZoneBC/wall: it has element 8, which is in no section; the sections have elements 1 to 7",
        ),
        (&[Last(&[2, 7], &[0, 5])], "it has element 0"),
        (
            &[Last(&[2, 7], &[2, 9]), to_nodes],
            "/Base/Zone/ZoneBC/wall: it has node 9; the zone has nodes 1 to 8",
        ),
        (
            &[Text("FaceCenter", "FacesCente")],
            "/Base/Zone/ZoneBC/wall/GridLocation: the location \"FacesCente\" is not known",
        ),
        (
            &[First(&[2, 7], &[1, 6])],
            "/Base/Zone/wall: its elements have numbers 1 to 6, and the elements of \"HEXA_8\" have 1 to 1",
        ),
    ] {
        let mut bytes = good.clone();
        changes.iter().for_each(|change| change.apply(&mut bytes));
        let message = refused(&bytes).to_string();
        assert_says(&message, expected);
    }
}

#[test]
fn conditions_without_faces_are_named_and_missing_cells_counted() {
    let (mut bytes, _) = written(&boxed());
    Text("FaceCenter", "Vertex\0\0\0\0").apply(&mut bytes);
    Last(&[2, 7], &[2, 3]).apply(&mut bytes);
    // Gmsh leaves out cells of high order, but counts them.
    First(&[8, 1, 0], &[8, 2, 0]).apply(&mut bytes);
    let source = Source::from_bytes(Path::new("m.cgns"), bytes);
    let mut notes = Notes::default();
    let mesh = CGNS.read_file(&source, &ReadOptions::default(), &mut notes);
    assert!(mesh.is_ok());
    assert_eq!(notes, ["cell_count", "names_not_kept"]);
    for text in [
        "/Base/Zone: the number of cells of dimension 3 is given as 2, but its sections have 1",
        "boundary conditions for which no cells were found are not kept: wall",
    ] {
        assert!(notes.says(text), "{text}: {notes:?}");
    }
}

#[test]
fn a_coordinate_that_is_not_finite_is_told_with_its_node_as_cgns_counts() {
    let mut mesh = boxed();
    mesh.points[2][1] = f64::NAN;
    let (bytes, _) = written(&mesh);
    let message = refused(&bytes).to_string();
    let expected = "/Base/Zone/GridCoordinates/CoordinateY: node 3 has the coordinate NaN";
    assert_says(&message, expected);
}

#[test]
fn single_nodes_come_back_with_and_without_a_group() {
    let mut mesh = boxed();
    mesh.cells.push(CellKind::Vertex, &[3]);
    mesh.cells.push(CellKind::Vertex, &[5]);
    for groups in [vec![], vec![group(0, "probe", 7..8)]] {
        mesh.groups.truncate(1);
        mesh.groups.extend(groups);
        let (bytes, notes) = written(&mesh);
        assert_eq!(notes, []);
        // cgnscheck takes no subregions of nodes.
        assert!(memchr::memmem::find(&bytes, b"ZoneSubRegion_t").is_none());
        let again = parse(&CGNS, &bytes, &ReadOptions::default()).expect("it is read again");
        assert_eq!(again.groups.len(), mesh.groups.len());
        let difference = Difference::between(&mesh, &again, Tolerance::default());
        assert!(difference.is_same(), "{difference:?}");
    }
}

#[test]
fn a_base_without_zones_is_refused() {
    let mut tree = Tree::new();
    let mut node = |parent: Id, name: &str, label: &str, sizes: &[i32]| {
        let id = tree.group(parent, name);
        tree.text_field(id, "label", label, (33, true));
        tree.numbers(id, " data", sizes);
    };
    node(
        Tree::ROOT,
        "CGNSLibraryVersion",
        "CGNSLibraryVersion_t",
        &[4],
    );
    node(Tree::ROOT, "Base", "CGNSBase_t", &[3, 3]);
    let mut bytes = Vec::new();
    tree.write(&mut bytes).expect("it can be written");
    let message = refused(&bytes).to_string();
    assert_says(&message, "/Base: it has no zone");
}

#[test]
fn a_link_into_a_file_that_lacks_its_target_is_told_in_full() {
    let folder = tempfile::tempdir().expect("a folder");
    let copy = |from: &str, to: &str| {
        std::fs::copy(path(from), folder.path().join(to)).expect("it can be copied")
    };
    copy("linked_families.cgns", "linked_families.cgns");
    copy("two_bases.cgns", "linked_grid.cgns");
    let source = Source::open(&folder.path().join("linked_families.cgns")).expect("a file");
    let error = read(&source.into(), &ReadOptions::default()).err();
    let message = error.expect("there is no such target").to_string();
    for part in ["linked_families.cgns: /Base/Zone/", "\"linked_grid.cgns\""] {
        assert_says(&message, part);
    }
}

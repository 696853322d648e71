//! Files of every layout, links, and what is refused.

use super::Node;
use super::fixture::{Draft, Layout, PLAIN, file, layouts, patched, place};
use crate::formats::Source;
use crate::mesh::Values;
use crate::testing::assert_says;
use azimesh_core::error::Result;
use std::path::Path;

fn root(bytes: &[u8]) -> Result<Node> {
    Node::root(&Source::from_bytes(Path::new("f.cgns"), bytes.to_vec()))
}

fn message<T>(result: Result<T>) -> String {
    result.err().expect("it should be refused").to_string()
}

fn values(node: &Node) -> Values {
    let data = node.data().unwrap().expect("it has data");
    data.values().unwrap()
}

fn text(node: &Node) -> Vec<u8> {
    node.data().unwrap().expect("it has data").bytes()
}

/// The node at a path, links followed.
fn at(root: &Node, path: &str) -> Result<Node> {
    path.split('/').try_fold(root.clone(), |node, name| {
        let children = node.children()?.into_iter();
        let mut named = children.filter(|child| child.name() == name.as_bytes());
        named.next().expect("it is there").target()
    })
}

fn arrays() -> Vec<(&'static str, Values)> {
    vec![
        ("C1", Values::I8(b"text".map(|byte| byte as i8).to_vec())),
        ("B1", Values::U8(vec![0, 200])),
        ("I4", Values::I32(vec![-1, 2, 1 << 30])),
        ("I8", Values::I64(vec![-1, 2, -(1 << 30)])),
        ("U4", Values::U32(vec![u32::MAX, 2])),
        ("U8", Values::U64(vec![u64::from(u32::MAX), 2])),
        ("R4", Values::F32(vec![0.5, -1e30, 3.0])),
        (
            "R8",
            Values::F64((0..40).map(|i| f64::from(i) / 7.0).collect()),
        ),
    ]
}

#[test]
fn nodes_and_numbers_of_every_layout_are_read() {
    for layout in layouts() {
        let draft =
            |(kind, values): (&'static str, Values)| Draft::data(kind, "DataArray_t", kind, values);
        let all: Vec<Draft> = arrays().into_iter().map(draft).collect();
        let bytes = file(layout, vec![Draft::new("Base", "CGNSBase_t", all)]);
        let root = root(&bytes).unwrap_or_else(|error| panic!("{layout:?}: {error}"));
        let base = at(&root, "Base").unwrap();
        assert_eq!(base.label(), b"CGNSBase_t");
        assert!(base.data().unwrap().is_none());
        let children = base.children().unwrap();
        assert_eq!(children.len(), arrays().len());
        for (child, (kind, expected)) in children.iter().zip(arrays()) {
            assert_eq!(child.name(), kind.as_bytes());
            assert_eq!(values(child), expected, "{kind} in {layout:?}");
            let data = child.data().unwrap().unwrap();
            let n = data.n_rows();
            let (head, tail) = (data.rows(0..1).unwrap(), data.rows(1..n).unwrap());
            let mut joined = head;
            assert!(joined.append(&tail));
            assert_eq!(joined, expected, "{kind} in {layout:?}, row by row");
            assert!(data.rows(0..n + 1).is_err());
        }
    }
}

#[test]
fn the_last_index_of_a_shape_runs_fastest() {
    let mut draft = Draft::data("a", "", "I4", Values::I32((0..6).collect()));
    draft.data.as_mut().unwrap().1 = vec![2, 3];
    for layout in layouts() {
        let root = root(&file(layout, vec![draft.clone()])).unwrap();
        let data = at(&root, "a").unwrap().data().unwrap().unwrap();
        assert_eq!(data.shape(), [3, 2]);
        assert_eq!(data.row().unwrap(), 2);
        assert_eq!(data.rows(1..2).unwrap(), Values::I32(vec![2, 3]));
    }
}

#[test]
fn links_lead_through_links_to_nodes_of_any_file() {
    let folder = tempfile::tempdir().unwrap();
    for (layout, mark) in
        layouts().map(|layout| (layout, if layout.version < "A02" { " " } else { ">" }))
    {
        let other = vec![
            Draft::new(
                "There",
                "",
                vec![Draft::link("inside", &format!("{mark}/Real"))],
            ),
            Draft::new("Real", "Real_t", vec![Draft::text("word", "", "found")]),
        ];
        std::fs::write(folder.path().join("other.cgns"), file(PLAIN, Vec::new())).unwrap();
        std::fs::write(folder.path().join("other.cgns"), file(layout, other)).unwrap();
        let main = vec![
            Draft::link("here", &format!("{mark}/Base/near")),
            Draft::new(
                "Base",
                "",
                vec![
                    Draft::text("near", "Near_t", "near"),
                    Draft::link("far", &format!("other.cgns{mark}/There/inside/word")),
                    Draft::link("whole", &format!("other.cgns{mark}There/inside")),
                ],
            ),
        ];
        let path = folder.path().join("main.cgns");
        std::fs::write(&path, file(layout, main)).unwrap();
        let root = Node::root(&Source::open(&path).unwrap()).unwrap();
        let near = at(&root, "here").unwrap();
        assert_eq!(
            (near.label(), text(&near)),
            (&b"Near_t"[..], b"near".to_vec()),
            "{layout:?}"
        );
        assert_eq!(
            text(&at(&root, "Base/far").unwrap()),
            b"found",
            "{layout:?}"
        );
        assert_eq!(text(&at(&root, "Base/whole/word").unwrap()), b"found");
    }
}

#[test]
fn links_that_lead_nowhere_are_told() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("hdf5.cgns"), b"\x89HDF\r\n\x1a\n").unwrap();
    std::fs::write(folder.path().join("adf.cgns"), file(PLAIN, Vec::new())).unwrap();
    let cases = [
        (">/loop", "its links form a loop"),
        (">/loop/inside", "its links form a loop"),
        (">/a/b", "this links to \"/a/b\", which is not in the file"),
        (
            "none.cgns>/a",
            "this links to \"/a\" in the file \"none.cgns\"; that file is not in the folder of this one",
        ),
        (
            "adf.cgns>/a",
            "this links to \"/a\" in the file \"adf.cgns\"; that file has no such node",
        ),
        (
            "hdf5.cgns>/a",
            "that is no ADF file. Files that are linked must all be of one kind",
        ),
    ];
    for (to, expected) in cases {
        let path = folder.path().join("main.cgns");
        std::fs::write(&path, file(PLAIN, vec![Draft::link("loop", to)])).unwrap();
        let root = Node::root(&Source::open(&path).unwrap()).unwrap();
        let found = message(at(&root, "loop"));
        assert!(found.contains(expected), "{to}: {found}");
    }
}

#[test]
fn other_machines_and_versions_are_refused_in_words() {
    let good = file(PLAIN, Vec::new());
    let cases: [(usize, &[u8], &str); 7] = [
        (
            100,
            b"C",
            "byte 100: this ADF file has numbers of Cray machines, which are not read; convert it",
        ),
        (
            100,
            b"N",
            "byte 100: the numbers of this ADF file are of the format \"N\"; B and L are read",
        ),
        (
            25,
            b"C",
            "this is \"ADF Database Version C02011>\"; databases of version A00",
        ),
        (28, b">", "databases of version A00"),
        (
            110,
            b"08",
            "char 1, short 2, int 8, long 8, float 4, double 8; char 1, int 4",
        ),
        (
            102,
            b"AdF9",
            "byte 102: the header has the tag \"AdF3\" here; this file has \"AdF9\"",
        ),
        (134, b"nonsense", "byte 134: \"nonsense0"),
    ];
    for (at, new, expected) in cases {
        let found = message(root(&patched(&good, at, new)));
        assert_says(&found, expected);
    }
    let found = message(root(&good[..100]));
    assert!(
        found
            .contains("byte 100: the file ends after 100 bytes; the header of an ADF file has 186"),
        "{found}"
    );
}

#[test]
fn what_is_cut_off_is_told_with_its_byte() {
    let values = Values::F64(vec![1.0; 100]);
    let good = file(PLAIN, vec![Draft::data("a", "", "R8", values)]);
    let n = good.len();
    // The root is there; its table of children is at the end.
    let found = message(root(&good[..n - 300]).and_then(|root| root.children().map(|_| ())));
    let expected = format!(
        "but the file has {} bytes of the {n} that its header states",
        n - 300
    );
    assert!(
        found.contains(&expected) && found.contains("f.cgns: byte "),
        "{found}"
    );
}

#[test]
fn no_node_is_its_own_parent_or_has_two() {
    let nodes = vec![
        Draft::new(
            "a",
            "",
            vec![Draft::new("b", "", vec![Draft::new("c", "", Vec::new())])],
        ),
        Draft::new("d", "", Vec::new()),
    ];
    let good = file(PLAIN, nodes);
    let children_of_b = |bytes: &[u8]| at(&root(bytes)?, "a/b")?.children();
    assert_eq!(children_of_b(&good).unwrap().len(), 1);
    let entry = |name: &str, at: usize| format!("{name:32}{at:012X}").into_bytes();
    let of_c = memchr::memmem::find(&good, &entry("c", place(&good, "c"))).unwrap();
    for (node, expected) in [
        ("a", "this belongs to the node at byte 266 and"),
        ("b", "this belongs to the node at byte"),
        ("d", "again; it can have one place only"),
        ("ADF MotherNode", "has the root of the file as its child"),
    ] {
        let bad = patched(&good, of_c, &entry("c", place(&good, node)));
        let found = message(children_of_b(&bad));
        let byte = format!("byte {}: ", place(&good, node));
        assert!(
            found.contains(expected) && found.contains(&byte),
            "{node}: {found}"
        );
    }
}

#[test]
fn lying_sizes_are_refused_with_the_byte() {
    let data = Draft::data("data", "", "I4", Values::I32(vec![7; 10]));
    let other = Draft::data("other", "", "I4", Values::I32(vec![8; 10]));
    let good = file(PLAIN, vec![data, other]);
    let (at_data, at_other) = (place(&good, "data"), place(&good, "other"));
    let pointer = good[at_other + 230..at_other + 242].to_vec();
    let chunk = memchr::memmem::find(&good, b"DaTa").unwrap();
    let table = memchr::memmem::find(&good, b"SNTb").unwrap();
    let cases: [(usize, &[u8], String); 9] = [
        (
            at_data + 130,
            b"0000000B",
            format!(
                "byte {}: the dimensions of data need 44 bytes; there are 40",
                at_data + 130
            ),
        ),
        (
            at_data + 130,
            b"FFFFFFFF",
            "data of the dimensions [4294967295] is more than the file".to_owned(),
        ),
        (
            at_data + 130,
            b"0000000x",
            format!("byte {}: a dimension must be hexadecimal", at_data + 130),
        ),
        (
            at_data + 128,
            b"0D",
            "data has 13 dimensions; there can be 12".to_owned(),
        ),
        (
            at_data + 226,
            b"FFFF",
            "a table of pieces of data has the tag \"DCtb\" here".to_owned(),
        ),
        (
            at_data + 96,
            b"X8",
            "data of the type \"X8\" is not read; C1, B1, I4".to_owned(),
        ),
        (
            at_data + 96,
            b"I4,R8",
            "data of the type \"I4,R8\" is not read".to_owned(),
        ),
        (
            chunk + 4,
            b"000000000100",
            "the end of data has the tag \"dEnD\" here".to_owned(),
        ),
        (
            table + 4,
            b"000000000100",
            "the end of a table of children has the tag \"snTE\" here".to_owned(),
        ),
    ];
    let read = |bytes: &[u8]| {
        let children = root(bytes)?.children()?;
        children
            .iter()
            .try_for_each(|child| child.data().map(|_| ()))
    };
    read(&good).unwrap();
    for (at, new, expected) in cases {
        let found = message(read(&patched(&good, at, new)));
        assert_says(&found, &expected);
    }
    let shared = patched(&good, at_data + 230, &pointer);
    assert!(message(read(&shared)).contains("it can have one place only"));
    let root_at = place(&good, "ADF MotherNode");
    let more = patched(&good, root_at + 68, b"00000009");
    assert!(
        message(read(&more))
            .contains("a table of children has room for 8; its node says that there are 9")
    );
}

#[test]
fn pieces_may_be_longer_than_the_data_but_not_than_themselves() {
    let layout = Layout { piece: 16, ..PLAIN };
    let good = file(
        layout,
        vec![Draft::data("a", "", "I4", Values::I32((0..10).collect()))],
    );
    let node = place(&good, "a");
    let read = |bytes: &[u8]| root(bytes)?.children().map(|all| values(&all[0]));
    let fewer = patched(&good, node + 130, b"00000006");
    assert_eq!(read(&fewer).unwrap(), Values::I32((0..6).collect()));
    let table = memchr::memmem::find(&good, b"DCtb").unwrap();
    let end = String::from_utf8(good[table + 28..table + 40].to_vec()).unwrap();
    let end = format!("{:012X}", u64::from_str_radix(&end, 16).unwrap() + 4);
    let wrong = patched(&good, table + 28, end.as_bytes());
    let root = root(&wrong).unwrap();
    let found = message(root.children().unwrap()[0].data());
    assert_says(&found, "by its table and at byte");
}

#[test]
fn data_that_was_never_written_is_none() {
    let good = file(
        PLAIN,
        vec![Draft::data("a", "", "I4", Values::I32(vec![1]))],
    );
    let none = patched(&good, place(&good, "a") + 226, b"0000");
    assert!(
        root(&none).unwrap().children().unwrap()[0]
            .data()
            .unwrap()
            .is_none()
    );
}

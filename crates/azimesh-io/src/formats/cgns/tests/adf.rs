//! Files in ADF: the same meshes as in HDF5.

use super::*;
use crate::formats::adf::fixture::{Draft, PLAIN, file, layouts};
use crate::formats::cgns::node::Node;
use crate::testing::assert_says;

/// The nodes below one of an HDF5 file, links followed, as nodes of ADF.
fn drafts(node: &Node) -> Vec<Draft> {
    let draft = |node: &Node| {
        let data = node.data().ok().map(|data| {
            let values = data.values().expect("it is read");
            let kind = match &values {
                Values::I32(_) => "I4",
                Values::I64(_) => "I8",
                Values::F32(_) => "R4",
                Values::F64(_) => "R8",
                Values::U8(_) | Values::I8(_) => "C1",
                other => panic!("{other:?}"),
            };
            (kind, node.sizes().expect("it has data"), values)
        });
        Draft {
            name: node.name().to_owned(),
            label: node.label().to_owned(),
            data,
            children: drafts(node),
        }
    };
    let children = node.children().expect("they are read").iter();
    children.map(draft).collect()
}

fn drafts_of(name: &str) -> Vec<Draft> {
    let source = Source::open(&path(name)).expect("the file is there");
    drafts(&Node::root(&source).expect("it is good").0)
}

fn child<'a>(drafts: &'a mut [Draft], path: &str) -> &'a mut Draft {
    let (name, rest) = path.split_once('/').unwrap_or((path, ""));
    let found = drafts.iter_mut().find(|draft| draft.name == name);
    let found = found.unwrap_or_else(|| panic!("{name} is there"));
    match rest {
        "" => found,
        rest => child(&mut found.children, rest),
    }
}

#[test]
fn every_file_of_hdf5_is_the_same_mesh_in_adf() {
    let folder = std::fs::read_dir(path("")).expect("the folder is there");
    let mut n = 0;
    for entry in folder {
        let name = entry.expect("it is there").file_name();
        let name = name.to_str().expect("it is ASCII");
        let bytes = std::fs::read(path(name)).expect("the file is there");
        if !crate::formats::hdf5::is_hdf5(&bytes) || name == "linked_grid.cgns" {
            continue;
        }
        let drafts = drafts_of(name);
        let n_steps = (CGNS.steps)(&Source::open(&path(name)).expect("it is there"));
        let n_steps = n_steps.expect("it has steps").len();
        for (i, layout) in layouts().enumerate() {
            let bytes = file(layout, drafts.clone());
            let step = (n_steps > 0).then(|| i % n_steps);
            let (expected, _) = load(name, step);
            let options = ReadOptions {
                step,
                ..ReadOptions::default()
            };
            let source = Source::from_bytes(Path::new("f.cgns"), bytes);
            let found = read(&source.into(), &options);
            let found = found.unwrap_or_else(|error| panic!("{name} in {layout:?}: {error}"));
            assert_eq!(found.mesh, expected, "{name} in {layout:?}");
            n += 1;
        }
    }
    assert!(n >= 9 * 12, "{n} files were compared");
}

#[test]
fn a_mesh_from_adf_is_written_in_hdf5_and_told() {
    let bytes = file(PLAIN, drafts_of("polyhedra_offsets.cgns"));
    let mesh = parse(&CGNS, &bytes, &ReadOptions::default()).expect("it is good");
    let (out, notes) = written(&mesh);
    assert!(crate::formats::hdf5::is_hdf5(&out));
    assert!(notes.has("hdf5_for_adf"), "{notes:?}");
    let again = parse(&CGNS, &out, &ReadOptions::default()).expect("it is good");
    assert!(!written(&again).1.has("hdf5_for_adf"));
}

#[test]
fn a_grid_in_another_file_is_followed_and_told_when_it_is_not_there() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let mut drafts = drafts_of("polyhedra_offsets.cgns");
    let grid = child(&mut drafts, "Base/Zone/GridCoordinates");
    let there = Draft::new("Grids", "UserDefinedData_t", vec![grid.clone()]);
    *grid = Draft::link("GridCoordinates", "grid.cgns>/Grids/GridCoordinates");
    let main = folder.path().join("main.cgns");
    std::fs::write(&main, file(PLAIN, drafts)).expect("it is written");
    let open = || {
        CGNS.read_file(
            &Source::open(&main)?,
            &ReadOptions::default(),
            &mut Notes::default(),
        )
    };
    let error = open().expect_err("the grid is not there").to_string();
    assert!(
        error.contains("/Base/Zone/GridCoordinates: this links to \"/Grids/GridCoordinates\" in the file \"grid.cgns\"; that"),
        "{error}"
    );
    std::fs::write(folder.path().join("grid.cgns"), file(PLAIN, vec![there]))
        .expect("it is written");
    let (expected, _) = load("polyhedra_offsets.cgns", None);
    assert_eq!(open().expect("the grid is there"), expected);
}

#[test]
fn a_file_without_a_base_is_not_cgns() {
    let bytes = file(PLAIN, vec![Draft::text("Other", "Other_t", "x")]);
    assert!((CGNS.detect)(&Source::from_bytes(
        Path::new("a"),
        bytes.clone()
    )));
    let message = refused(&bytes).to_string();
    assert_says(&message, "this is not a CGNS file: it has no CGNSBase_t");
}

#[test]
fn texts_that_are_not_utf8_are_read_as_latin1_and_told() {
    let mut drafts = drafts_of("polyhedra_offsets.cgns");
    child(&mut drafts, "Base/Zone").name = "Fl?gel".to_owned();
    let mut bytes = file(PLAIN, drafts);
    let at: Vec<usize> = memchr::memmem::find_iter(&bytes, b"Fl?gel").collect();
    at.into_iter().for_each(|at| bytes[at + 2] = 0xfc);
    let mut notes = Notes::default();
    let source = Source::from_bytes(Path::new("f"), bytes);
    let read = CGNS.read_file(&source, &ReadOptions::default(), &mut notes);
    read.expect("it is good");
    notes.close();
    let text = "texts that are not UTF-8 are read as Latin-1: \"Fl\u{fc}gel\"";
    assert!(notes.says(text), "{notes:?}");
}

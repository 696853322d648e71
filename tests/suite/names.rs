//! Names of tags and arrays: written by every format and read back, each still another.

use crate::support::{assert_says, succeed};
use azimesh_io::formats::{self, ReadOptions, WriteOptions};
use azimesh_io::mesh::{CellKind, DataArray, Group, Mesh, Values};
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;
use std::path::Path;

/// Endings of every format that can be written, one of each way of storing UGRID.
const ENDINGS: [&str; 9] = [
    "vtu", "pvtu", "vtk", "vtkhdf", "cgns", "msh", "msh2", "su2", "b8.ugrid",
];

const LONG: &str = "a long name of forty characters, number ";

/// Names that become the same when they are cleaned, cut or decoded.
fn names() -> Vec<String> {
    let odd = [
        "a b",
        "a_b",
        "a%b",
        "a\"b",
        "a'b",
        "é",
        "wing/upper",
        "wing_upper",
        "x\ny",
        "x y",
        "x_y",
        "e\u{1b}[31m",
        "e_[31m",
        "nul\0",
        "nul_",
        "",
        "_",
        "SEND_RECEIVE",
        "untagged",
        " x",
        "x ",
        "x",
        "NULL_ARRAY",
        "metadata",
        "Zone",
        "2",
        "a_b_2",
        "\u{9b}c1",
    ];
    let long = ["1", "2"].map(|end| format!("{LONG}{end}"));
    odd.into_iter().map(str::to_owned).chain(long).collect()
}

/// A row of cubes: one face of each is in a tag of its own, the face above it in none.
fn cubes(names: &[String]) -> Mesh {
    let mut mesh = Mesh::default();
    for x in 0..=names.len() {
        for corner in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            mesh.points.push([x as f64, corner[0], corner[1]]);
        }
    }
    for i in 0..names.len() as u32 {
        let nodes: Vec<u32> = (0..8).map(|k| 4 * i + k).collect();
        mesh.cells.push(CellKind::Hexahedron, &nodes);
    }
    for i in 0..names.len() as u32 {
        let [a, b] = [4 * i, 4 * i + 4];
        mesh.cells
            .push(CellKind::Quadrilateral, &[a, a + 1, b + 1, b]);
    }
    mesh.cells.push(CellKind::Quadrilateral, &[0, 1, 2, 3]);
    for (i, name) in names.iter().enumerate() {
        mesh.groups.push(group(name, names.len() + i));
    }
    mesh
}

fn group(name: &str, cell: usize) -> Group {
    Group {
        dimension: 2,
        name: name.to_owned(),
        number: None,
        condition: None,
        cells: [cell].into_iter().collect(),
    }
}

/// The tag of each face, known by its nodes.
fn tags(mesh: &Mesh) -> BTreeMap<Vec<u32>, String> {
    let faces = mesh.boundary_tags().flat_map(|tag| {
        tag.cells.iter().map(|cell| {
            let mut nodes = mesh.cells.get(cell).nodes.to_vec();
            nodes.sort_unstable();
            (nodes, tag.name.clone())
        })
    });
    faces.collect()
}

struct Loaded {
    mesh: Mesh,
    notes: Vec<String>,
}

fn read(path: &Path) -> Loaded {
    let loaded = Mesh::read_with(path, &ReadOptions::default()).unwrap();
    Loaded {
        mesh: loaded.mesh,
        notes: loaded.notes.iter().map(ToString::to_string).collect(),
    }
}

fn save(mesh: &Mesh, path: &Path) -> Vec<String> {
    let format = formats::by_extension(path).unwrap();
    let options = WriteOptions {
        pieces: NonZeroUsize::new(3.min(mesh.cells.len() / 2)),
        ..WriteOptions::default()
    };
    let replace = formats::Commit::REPLACE;
    let notes = formats::save(&mesh.view(), path, format, &options, replace).unwrap();
    notes.iter().map(ToString::to_string).collect()
}

#[test]
fn as_many_tags_come_back_from_every_format_with_the_same_faces() {
    let folder = tempfile::tempdir().unwrap();
    let names = names();
    let mesh = cubes(&names);
    let before = tags(&mesh);
    for ending in ENDINGS {
        let path = folder.path().join(format!("m.{ending}"));
        let notes = save(&mesh, &path);
        let after = tags(&read(&path).mesh);
        let mut distinct = BTreeSet::new();
        for (face, name) in &before {
            let back = &after[face];
            assert!(distinct.insert(back), "{ending}: {back:?} twice");
            let told = |note: &String| note.contains(&format!("{name:?} is written as "));
            assert!(
                back == name || notes.iter().any(told),
                "{ending}: {name:?} is {back:?} without a word: {notes:?}"
            );
        }
        // What can stay stays: no tag makes another one give way.
        for name in ["a_b", "a'b", "é", "wing_upper", "x", "2"] {
            assert!(distinct.contains(&name.to_owned()), "{ending}: {name}");
        }
    }
}

#[test]
fn a_good_name_is_kept_to_the_letter_and_no_note_is_made_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let names = ["wall", "é", "blade-1.upper(a)", "7"].map(str::to_owned);
    let mut mesh = cubes(&names);
    mesh.groups.push(group("back", 2 * names.len()));
    for ending in ENDINGS {
        let path = folder.path().join(format!("m.{ending}"));
        let notes = save(&mesh, &path);
        let loaded = read(&path);
        assert_eq!(tags(&loaded.mesh), tags(&mesh), "{ending}");
        // Names of nodes in CGNS are ASCII; the full name is next to it.
        let is_ascii = |note: &str| ending == "cgns" && note.contains('é');
        let renamed = notes
            .iter()
            .any(|note| note.contains("is written as") && !is_ascii(note));
        let is_joined = |note: &String| note.contains("pieces are joined");
        let is_quiet = loaded.notes.iter().all(is_joined);
        assert!(
            !renamed && is_quiet,
            "{ending}: {notes:?} {:?}",
            loaded.notes
        );
    }
}

#[test]
fn arrays_of_one_name_are_all_there_under_names_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = cubes(&["wall".to_owned()]);
    let names = [
        "p",
        "p",
        "q/r",
        "q_r",
        "q r",
        "s\u{1}t",
        "s_t",
        "n\"m",
        "n'm",
        "",
        "_",
        "NULL_ARRAY",
        "metadata",
        "BoundaryTag",
        "nul\0",
        "nul_",
    ];
    let values = |i: usize| Values::F64((0..8).map(|k| (10 * i + k) as f64).collect());
    for (i, name) in names.iter().enumerate() {
        mesh.point_arrays.push(DataArray::scalar(*name, values(i)));
    }
    for ending in ["vtu", "pvtu", "vtk", "vtkhdf", "cgns", "msh", "msh2"] {
        let path = folder.path().join(format!("m.{ending}"));
        let notes = save(&mesh, &path);
        let back = read(&path).mesh.point_arrays;
        let distinct: BTreeSet<&str> = back.iter().map(|array| &array.name[..]).collect();
        assert_eq!(distinct.len(), back.len(), "{ending}: {distinct:?}");
        for (i, name) in names.iter().enumerate() {
            let told = |word: &str| notes.iter().any(|note| note.contains(word));
            match back.iter().find(|array| array.values == values(i)) {
                // The formats of VTK have tags under this name.
                None => assert!(
                    *name == "BoundaryTag" && told(name),
                    "{ending}: {name:?} is lost"
                ),
                Some(array) => assert!(
                    array.name == *name || told(&format!("array {name:?} is written as")),
                    "{ending}: {name:?} is {:?}: {notes:?}",
                    array.name
                ),
            }
        }
    }
}

/// A file of these bytes, its boundary tags and the notes on it.
fn told(name: &str, bytes: &[u8]) -> (Vec<String>, String, Mesh) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let Loaded { mesh, notes } = read(&path);
    let tags = mesh.boundary_tags().map(|tag| tag.name.clone()).collect();
    (tags, notes.join("\n"), mesh)
}

/// Text in Latin-1, whatever characters it has.
fn latin1(text: &str) -> Vec<u8> {
    text.chars().map(|c| u8::try_from(c).unwrap()).collect()
}

const LATIN1: &str =
    "texts that are not UTF-8 are read as Latin-1: \"Fl\u{e4}che\", \"Fl\u{f6}che\"";

const SQUARE_SU2: &str = "NDIME= 2\nNELEM= 1\n9 0 1 2 3\nNPOIN= 4\n0 0\n1 0\n1 1\n0 1\nNMARK= 2\n\
    MARKER_TAG= ONE\nMARKER_ELEMS= 1\n3 0 1\nMARKER_TAG= TWO\nMARKER_ELEMS= 1\n3 2 3\n";

const SQUARE_MSH: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"ONE\"\n1 2 \"TWO\"\n\
    $EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n3\n\
    1 1 2 1 1 1 2\n2 1 2 2 2 3 4\n3 3 2 0 1 1 2 3 4\n$EndElements\n";

/// The square with its two tags renamed.
fn square(text: &str, one: &str, two: &str) -> String {
    text.replace("ONE", one).replace("TWO", two)
}

#[test]
fn latin1_names_stay_apart_in_lines_of_text() {
    for (file, text) in [("m.su2", SQUARE_SU2), ("m.msh", SQUARE_MSH)] {
        let text = square(text, "Fl\u{e4}che", "Fl\u{f6}che");
        let (tags, notes, _) = told(file, &latin1(&text));
        assert_eq!(tags, ["Fl\u{e4}che", "Fl\u{f6}che"], "{file}");
        assert!(notes.contains(LATIN1), "{file}: {notes}");
        let (tags, notes, _) = told(file, text.as_bytes());
        assert_eq!(tags, ["Fl\u{e4}che", "Fl\u{f6}che"], "{file}");
        assert_eq!(notes, "", "{file}");
    }
}

#[test]
fn one_name_in_two_encodings_is_noted() {
    // UTF-8 in one marker, Latin-1 in the other.
    let bytes = square(SQUARE_SU2, "\u{e9}", "\u{ff}")
        .replace('\u{ff}', "TWO")
        .into_bytes();
    let at = bytes.windows(3).position(|three| three == b"TWO").unwrap();
    let bytes = [&bytes[..at], b"\xe9", &bytes[at + 3..]].concat();
    let (_, notes, mesh) = told("m.su2", &bytes);
    assert_says(&notes, &["2 markers", "\"\u{e9}\""]);
    assert_eq!(
        mesh.boundary_tags()
            .map(|tag| tag.cells.len())
            .sum::<usize>(),
        2
    );
}

#[test]
fn latin1_names_of_a_mapbc_stay_apart() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = cubes(&["ONE".to_owned(), "TWO".to_owned()]);
    let path = folder.path().join("m.b8.ugrid");
    save(&mesh, &path);
    let lines = "2\n1 4000 Fl\u{e4}che\n2 4000 Fl\u{f6}che\n";
    std::fs::write(folder.path().join("m.mapbc"), latin1(lines)).unwrap();
    let Loaded { mesh, notes } = read(&path);
    let tags: Vec<_> = mesh.boundary_tags().map(|tag| tag.name.as_str()).collect();
    assert_eq!(tags[..2], ["Fl\u{e4}che", "Fl\u{f6}che"]);
    assert!(notes.contains(&LATIN1.to_owned()), "{notes:?}");
}

/// A legacy file and an XML file of a triangle with two point arrays of these names.
fn triangles(a: &str, b: &str) -> [(&'static str, String); 2] {
    let vtk = format!(
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n\
         CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\nPOINT_DATA 3\nSCALARS {a} int 1\nLOOKUP_TABLE default\n1 2 3\n\
         SCALARS {b} int 1\nLOOKUP_TABLE default\n4 5 6\n"
    );
    let array = |name: &str, values: &str| {
        format!("<DataArray type=\"Int32\" Name=\"{name}\" format=\"ascii\">{values}</DataArray>")
    };
    let piece = format!(
        "<Piece NumberOfPoints=\"3\" NumberOfCells=\"1\"><PointData>{}{}</PointData><Points>\
         <DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray>\
         </Points><Cells>{}{}<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">5</DataArray>\
         </Cells></Piece>",
        array(a, "1 2 3"),
        array(b, "4 5 6"),
        array("connectivity", "0 1 2"),
        array("offsets", "3"),
    );
    let vtu = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" \
         byte_order=\"LittleEndian\"><UnstructuredGrid>{piece}{piece}</UnstructuredGrid></VTKFile>\n"
    );
    [("m.vtk", vtk), ("m.vtu", vtu)]
}

/// Names and first values of the point arrays.
fn point_arrays(mesh: &Mesh) -> Vec<(String, Vec<i64>)> {
    let arrays = mesh.point_arrays.iter();
    let integers = |array: &DataArray| array.values.to_integers().unwrap();
    arrays
        .map(|array| (array.name.clone(), integers(array)))
        .collect()
}

#[test]
fn latin1_names_of_arrays_stay_apart() {
    for (file, text) in triangles("Fl\u{e4}che", "Fl\u{f6}che") {
        let (_, notes, mesh) = told(file, &latin1(&text));
        let names: Vec<_> = mesh
            .point_arrays
            .iter()
            .map(|array| &array.name[..])
            .collect();
        assert_eq!(names, ["Fl\u{e4}che", "Fl\u{f6}che"], "{file}");
        assert!(notes.contains("read as Latin-1"), "{file}: {notes}");
    }
    // XML may say that it is Latin-1; then nothing is odd about it.
    let [_, (file, text)] = triangles("Fl\u{e4}che", "Fl\u{f6}che");
    let text = text.replace(
        "version=\"1.0\"?",
        "version=\"1.0\" encoding=\"ISO-8859-1\"?",
    );
    let (_, notes, mesh) = told(file, &latin1(&text));
    assert_eq!(mesh.point_arrays[1].name, "Fl\u{f6}che");
    assert_eq!(notes, "");
}

#[test]
fn latin1_names_in_hdf5_stay_apart() {
    let folder = tempfile::tempdir().unwrap();
    // In CGNS the end of a long name stands in a descriptor only.
    let names = [format!("{LONG}#1"), format!("{LONG}#2")];
    for ending in ["cgns", "vtkhdf"] {
        let path = folder.path().join(format!("m.{ending}"));
        save(&cubes(&names), &path);
        let mut bytes = std::fs::read(&path).unwrap();
        let places: Vec<usize> = (0..bytes.len() - 1)
            .filter(|&i| bytes[i] == b'#' && b"12".contains(&bytes[i + 1]))
            .collect();
        assert_eq!(places.len(), 2, "{ending}");
        places.iter().for_each(|&at| bytes[at] = 0xe4);
        std::fs::write(&path, bytes).unwrap();
        let Loaded { mesh, notes } = read(&path);
        let found: Vec<_> = mesh.boundary_tags().map(|tag| tag.name.clone()).collect();
        assert_eq!(
            found[..2],
            names.clone().map(|name| name.replace('#', "\u{e4}")),
            "{ending}"
        );
        assert!(
            notes[0].starts_with("texts that are not UTF-8 are read as Latin-1"),
            "{notes:?}"
        );
    }
}

#[test]
fn tags_of_one_name_in_a_file_are_noted() {
    let (tags, notes, mesh) = told("m.su2", square(SQUARE_SU2, "wall", "wall").as_bytes());
    assert_eq!(tags, ["wall"]);
    assert_eq!(mesh.boundary_tags().next().unwrap().cells.len(), 2);
    assert_says(&notes, &["2 markers", "\"wall\""]);
    let (tags, notes, _) = told("m.msh", square(SQUARE_MSH, "wall", "wall").as_bytes());
    assert_eq!(tags, ["wall", "wall"]);
    assert_says(&notes, &["2", "\"wall\""]);
    let twice = SQUARE_MSH.replace("1 2 \"TWO\"", "1 1 \"TWO\"");
    let (_, notes, _) = told("m.msh", twice.as_bytes());
    assert_says(&notes, &["\"ONE\"", "\"TWO\""]);
}

#[test]
fn arrays_of_one_name_in_a_file_are_told_apart() {
    for (file, text) in triangles("p", "p") {
        let (_, notes, mesh) = told(file, text.as_bytes());
        let n = mesh.points.len() / 3;
        let expected = [("p", [1, 2, 3]), ("p_2", [4, 5, 6])];
        let expected = expected.map(|(name, values)| (name.to_owned(), values.repeat(n)));
        assert_eq!(point_arrays(&mesh), expected, "{file}");
        assert_eq!(notes.lines().count(), 1, "{file}: {notes}");
        assert_says(&notes, &["point array", "\"p\"", "\"p_2\""]);
    }
}

#[test]
fn data_of_one_name_that_contradict_one_another_are_two_arrays() {
    let data = |rows: &str, n: usize| {
        format!("$NodeData\n1\n\"p\"\n1\n0\n3\n0\n1\n{n}\n{rows}\n$EndNodeData\n")
    };
    // Parts of a partitioned mesh share nodes, and agree on them.
    let parts = data("1 1\n2 2", 2) + &data("2 2\n3 3\n4 4", 3);
    let (_, _, mesh) = told("m.msh", (SQUARE_MSH.to_owned() + &parts).as_bytes());
    assert_eq!(point_arrays(&mesh), [("p".to_owned(), vec![1, 2, 3, 4])]);
    let (low, high) = ("1 1\n2 2\n3 3\n4 4", "1 5\n2 6\n3 7\n4 8");
    let both = data(low, 4) + &data(high, 4);
    let (_, notes, mesh) = told("m.msh", (SQUARE_MSH.to_owned() + &both).as_bytes());
    let expected = [("p", vec![1, 2, 3, 4]), ("p_2", vec![5, 6, 7, 8])];
    assert_eq!(
        point_arrays(&mesh),
        expected.map(|(name, values)| (name.to_owned(), values))
    );
    assert_says(&notes, &["point array", "\"p\""]);
}

const ESCAPES: &str = "x\ny\u{1b}[31mred\u{7f}\u{9b}2J\t\r";
const SEEN: &str = r"x\ny\u{1b}[31mred\u{7f}\u{9b}2J\t\r";

#[test]
fn no_name_moves_the_cursor_or_ends_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let strange = cubes(&[ESCAPES.to_owned(), "b".to_owned()]);
    let plain = cubes(&["c".to_owned(), "b".to_owned()]);
    for (name, mesh) in [("strange.vtu", &strange), ("plain.vtu", &plain)] {
        let mut mesh = mesh.clone();
        let name_of_array = mesh.groups[0].name.clone();
        let values = Values::Text(vec![name_of_array.clone()]);
        mesh.field_arrays
            .push(DataArray::scalar(name_of_array, values));
        save(&mesh, &folder.join(name));
    }
    for args in [
        "info MESH -v",
        "diff -v MESH other.vtu",
        "quality MESH --worst 2",
        "convert MESH out.su2 --force -v",
        "convert MESH out.msh --force",
        "convert MESH out.vtu --force --rename-tag none=other",
        "check MESH s.toml",
    ] {
        let [strange, plain] = ["strange.vtu", "plain.vtu"].map(|mesh| {
            save(&cubes(&["other".to_owned()]), &folder.join("other.vtu"));
            std::fs::write(
                folder.join("s.toml"),
                "[[body]]\nname = \"b\"\ntags = [\"none\"]\n",
            )
            .unwrap();
            let run = crate::support::azimesh(folder, args.replace("MESH", mesh));
            (run.code, run.out, run.err)
        });
        assert_eq!(strange.0, plain.0, "{strange:?} {plain:?}");
        for (strange, plain) in [(&strange.1, &plain.1), (&strange.2, &plain.2)] {
            let is_seen = |c: char| c == '\n' || !c.is_control();
            assert!(strange.chars().all(is_seen), "{args:?}: {strange:?}");
            let most = plain.lines().count() + 1; // of a name that changes there is a note
            assert!(strange.lines().count() <= most, "{args:?}: {strange}");
        }
    }
    let info = succeed(folder, "info strange.vtu").out;
    assert!(info.contains(SEEN), "{info}");
    let json = succeed(folder, "info --json strange.vtu").out;
    assert!(json.chars().all(|c| c == '\n' || !c.is_control()), "{json}");
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(value.to_string().contains("red"), "{json}");
    assert!(json.contains("\\u007f\\u009b2J"), "{json}");
}

#[test]
fn lists_of_files_have_no_bare_control_characters() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    save(&cubes(&["a".to_owned()]), &folder.join("m.vtu"));
    save(&cubes(&["a".to_owned()]), &folder.join("n.vtu"));
    succeed(folder, ["-q", "convert", "m.vtu", "n.vtu", "a\tb\n.pvd"]);
    let list = std::fs::read_to_string(folder.join("a\tb\n.pvd")).unwrap();
    assert!(list.contains("file=\"a&#9;b&#10;_0000.vtu\""), "{list}");
    let back = succeed(folder, ["info", "a\tb\n.pvd"]);
    assert!(back.out.contains("2, times"), "{back:?}");
    let refused = crate::support::azimesh(folder, ["convert", "m.vtu", "n.vtu", "a\u{1b}b.pvd"]);
    assert_eq!(refused.code, 2, "{refused:?}");
    assert!(refused.err.contains("a\\u{1b}b"), "{refused:?}");
}

#[test]
fn a_run_of_a_mesh_with_a_strange_name_leaves_files_with_plain_ones() {
    let folder = crate::support::short();
    let folder = folder.path();
    std::fs::rename(folder.join("n.vtu"), folder.join("n\n\u{1b}.vtu")).unwrap();
    let run = succeed(folder, ["deform", "n\n\u{1b}.vtu", "few.toml", "-o", "o"]);
    assert!(
        !run.out.contains('\u{1b}') && !run.err.contains('\u{1b}'),
        "{run:?}"
    );
    let names = crate::support::names(&folder.join("o"));
    assert!(names.contains(&"n___0000.vtu".to_owned()), "{names:?}");
    assert!(names.contains(&"n__.pvd".to_owned()), "{names:?}");
    let page = succeed(folder, "report o");
    assert!(!page.out.contains('\u{1b}'), "{page:?}");
}

/// Seconds that a command may take with tens of thousands of names: it took minutes where each name was looked for among
/// all others, and takes less than three.
const LONG_ENOUGH: f64 = 30.0;

#[test]
fn tens_of_thousands_of_tags_and_arrays_take_seconds() {
    const N: usize = 60_000;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let within = |args: &[&str]| {
        let start = std::time::Instant::now();
        let run = succeed(folder, args);
        let seconds = start.elapsed().as_secs_f64();
        assert!(seconds < LONG_ENOUGH, "{args:?}: {seconds} s");
        run.out
    };
    let mut su2 =
        format!("NDIME= 2\nNELEM= 1\n9 0 1 2 3\nNPOIN= 4\n0 0\n1 0\n1 1\n0 1\nNMARK= {N}\n");
    let (mut vtu, mut msh) = (String::new(), String::new());
    for i in 0..N {
        su2 += &format!(
            "MARKER_TAG= tag{i}\nMARKER_ELEMS= 1\n3 {} {}\n",
            i % 4,
            (i + 1) % 4
        );
        vtu += &format!("<DataArray type=\"Float64\" Name=\"a{i}\" format=\"ascii\">1</DataArray>");
        msh += &format!("$NodeData\n1\n\"a{i}\"\n1\n0\n3\n0\n1\n1\n1 1\n$EndNodeData\n");
    }
    std::fs::write(folder.join("tags.su2"), su2).unwrap();
    let head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n1 15 2 1 1 1\n$EndElements\n";
    std::fs::write(folder.join("arrays.msh"), format!("{head}{msh}")).unwrap();
    let piece = |arrays: &str| {
        let integers = ["connectivity", "offsets", "types"]
            .map(|name| format!("<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\"/>"));
        format!(
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"><UnstructuredGrid>\
             <Piece NumberOfPoints=\"1\" NumberOfCells=\"0\"><PointData>{arrays}</PointData><Points>\
             <DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0</DataArray></Points>\
             <Cells>{}</Cells></Piece></UnstructuredGrid></VTKFile>",
            integers.concat()
        )
    };
    std::fs::write(folder.join("arrays.vtu"), piece(&vtu)).unwrap();
    for (mesh, last) in [
        ("tags.su2", "tag59999"),
        ("arrays.vtu", "a59999"),
        ("arrays.msh", "a59999"),
    ] {
        assert!(
            within(&["-q", "info", "--json", mesh]).contains(last),
            "{mesh}"
        );
    }
    within(&["-q", "convert", "tags.su2", "again.su2"]);
    within(&["-q", "convert", "tags.su2", "again.msh"]);
    within(&["-q", "diff", "tags.su2", "again.msh"]);
    within(&["-q", "convert", "arrays.vtu", "again.vtu"]);
    within(&["-q", "diff", "arrays.vtu", "again.vtu"]);
}

#[test]
fn the_sequence_of_a_mesh_with_a_hidden_name_is_found() {
    let folder = crate::support::short();
    let folder = folder.path();
    std::fs::rename(folder.join("n.vtu"), folder.join(".h.vtu")).unwrap();
    for format in ["vtu", "vtkhdf"] {
        let run = format!("-q deform .h.vtu few.toml -o {format} --format {format}");
        succeed(folder, &run);
        let found = succeed(folder, ["info", format]);
        assert!(found.out.contains("steps"), "{found:?}");
        succeed(folder, ["quality", format]);
        succeed(folder, ["diff", format, "vtu"]);
        succeed(
            folder,
            format!("-q convert {format} --step 2 -o one.vtk --force"),
        );
    }
}

#[test]
fn names_of_nodes_in_cgns_and_of_solids_are_ascii_and_cgns_keeps_the_full_ones() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let names = ["Fläche ä", "Fläche ö", "a=b c"].map(str::to_owned);
    save(&cubes(&names), &folder.join("m.vtu"));
    let run = succeed(folder, "convert m.vtu m.cgns");
    assert_says(
        &run.err,
        &["\"Fläche ä\"", "\"Fl_che _\"", "\"Fl_che __2\"", "ASCII"],
    );
    let bytes = std::fs::read(folder.join("m.cgns")).unwrap();
    let has = |text: &[u8]| memchr::memmem::find(&bytes, text).is_some();
    assert!(has(b"Fl_che __2") && has("Fläche ö".as_bytes()));
    let tags = |mesh: &str| -> BTreeSet<String> {
        let mesh = Mesh::read(folder.join(mesh)).unwrap();
        mesh.boundary_tags().map(|tag| tag.name.clone()).collect()
    };
    assert_eq!(tags("m.cgns"), names.iter().cloned().collect());
    let run = succeed(folder, "convert m.vtu m.stl --encoding ascii");
    assert_says(&run.err, &["\"a=b c\"", "\"a=b_c\"", "ASCII"]);
    let text = std::fs::read_to_string(folder.join("m.stl")).unwrap();
    assert!(
        text.is_ascii() && text.contains("solid Fl_che__\n"),
        "{text}"
    );
    // The last = ends the old name, as in --patch-type.
    let rename = [
        "-q",
        "convert",
        "m.vtu",
        "r.vtu",
        "--rename-tag",
        "a=b c=wall",
    ];
    succeed(folder, rename);
    assert!(tags("r.vtu").contains("wall"));
}

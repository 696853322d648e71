//! Written files are read back by another implementation; h5py and VTK do so in scripts/verify.

use super::*;
use crate::formats::column::Data;
use crate::formats::{Begin, Source};
use crate::mesh::Values;
use std::path::Path;

fn open(bytes: Vec<u8>) -> Group {
    let source = Source::from_bytes(Path::new("test.h5"), bytes);
    File::open(&source)
        .and_then(|file| file.root())
        .expect("it is HDF5")
}

fn values(group: &Group, name: &str) -> Values {
    group
        .need(name)
        .and_then(|dataset| dataset.values())
        .expect("it can be read")
}

fn names(group: &Group) -> Vec<String> {
    group
        .names()
        .map(|(groups, sets)| [groups, sets].concat())
        .expect("it can be listed")
}

#[test]
fn a_tree_is_read_back_in_the_order_it_was_made() {
    let names_of = ["blade".to_owned(), String::new(), "größe".to_owned()];
    let mut tree = Tree::new();
    let zone = tree.group(Tree::ROOT, "zone");
    tree.text_field(zone, "label", "Zone_t", (33, true));
    tree.text_attribute(zone, "Type", "UnstructuredGrid");
    tree.number_attribute(zone, "flags", &[1_i32], false);
    tree.number_attribute(zone, "one", &[2.5_f64], true);
    let point = tree.numbers(zone, "x", &[1.0, 2.5, -1e300]);
    tree.number_attribute(point, "unit", &[7_u8], true);
    let made = Data::made(|sink| (0..6_i16).try_for_each(|i| sink(&i.to_ne_bytes())));
    tree.dataset(zone, "a", Element::Int16, &[3, 2], made);
    tree.dataset(zone, "names", Element::String, &[3], Data::text(&names_of));
    tree.numbers::<f32>(zone, "empty", &[]);
    tree.group(Tree::ROOT, "another");
    let mut bytes = Vec::new();
    tree.write(&mut bytes).expect("it is written");

    let root = open(bytes);
    assert_eq!(names(&root), ["zone", "another"]);
    let zone = root
        .group("zone")
        .expect("it is read")
        .expect("it is there");
    assert_eq!(names(&zone), ["x", "a", "names", "empty"]);
    assert_eq!(zone.text("label").expect("text"), Some("Zone_t".into()));
    assert_eq!(
        zone.text("Type").expect("text"),
        Some("UnstructuredGrid".into())
    );
    assert_eq!(
        zone.attribute("flags").expect("numbers"),
        Some(Values::I32(vec![1]))
    );
    assert_eq!(
        zone.attribute("one").expect("numbers"),
        Some(Values::F64(vec![2.5]))
    );
    assert_eq!(zone.attribute("none").expect("it is no error"), None);
    assert_eq!(values(&zone, "x"), Values::F64(vec![1.0, 2.5, -1e300]));
    assert_eq!(values(&zone, "a"), Values::I16((0..6).collect()));
    assert_eq!(values(&zone, "names"), Values::Text(names_of.to_vec()));
    assert_eq!(values(&zone, "empty"), Values::F32(vec![]));
    let a = zone.need("a").expect("it is there");
    assert_eq!((a.shape(), a.row().expect("it is short")), (&[3, 2][..], 2));
    assert_eq!(
        a.rows(1..2).expect("it has the row"),
        Values::I16(vec![2, 3])
    );
    assert!(a.rows(2..4).is_err());
}

#[test]
fn many_children_and_many_strings_fit() {
    let strings: Vec<String> = (0..70_000).map(|i| i.to_string()).collect();
    let mut tree = Tree::new();
    for i in 0..3000_i64 {
        let child = tree.group(Tree::ROOT, &i.to_string());
        tree.number_attribute(child, "i", &[i], true);
    }
    let data = Data::text(&strings);
    tree.dataset(Tree::ROOT, "strings", Element::String, &[70_000], data);
    let mut bytes = Vec::new();
    tree.write(&mut bytes).expect("it is written");
    let root = open(bytes);
    let groups = root.groups().expect("they are read");
    assert_eq!(groups.len(), 3000);
    assert_eq!(
        groups[2999].attribute("i").expect("it is read"),
        Some(Values::I64(vec![2999]))
    );
    assert_eq!(values(&root, "strings"), Values::Text(strings.clone()));
}

/// A sequence with everything that grows.
struct Sequence {
    file: StepFile,
    _folder: tempfile::TempDir,
    fixed: Stored,
    chunks: Chunks,
    links: Links,
    steps: Rows,
    names: Rows,
    /// Alike up to a step.
    alike: Rows,
    n: u64,
}

/// The column `alike` at a step.
fn alike(step: u64) -> i64 {
    step.saturating_sub(70) as i64 * 3 % 200
}

fn name(step: u64) -> String {
    format!("{:<32}", format!("step#{step:04}"))
}

impl Sequence {
    fn start() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("steps.h5");
        let mut file = StepFile::create(&path, Begin::Create, false).expect("it starts");
        Self {
            _folder: folder,
            fixed: file
                .store(&Data::slice(&[1_u8, 2, 3]))
                .expect("it is stored"),
            file,
            chunks: Chunks::new(2),
            links: Links::default(),
            steps: Rows::new(Element::UInt64, &[]),
            names: Rows::new(Element::Int8, &[32]),
            alike: Rows::new(Element::Int64, &[]),
            n: 0,
        }
    }

    fn append(&mut self) {
        self.try_append().expect("it is written");
    }

    fn try_append(&mut self) -> azimesh_core::error::Result<()> {
        let (step, file) = (self.n, &mut self.file);
        let x = [step as f64; 4];
        self.chunks.push(file.store(&Data::slice(&x))?);
        file.store_index(&mut self.chunks)?;
        let mut tree = Tree::new();
        tree.number_attribute(Tree::ROOT, "step", &[step], true);
        let object = file.store_object(&tree)?;
        self.links.add(&format!("{step}"), object)?;
        file.store_links(&mut self.links)?;
        self.steps.push(&[step]);
        self.names.push(name(step).as_bytes());
        self.alike.push(&[alike(step)]);
        for rows in [&mut self.steps, &mut self.names, &mut self.alike] {
            file.store_rows(rows)?;
        }
        let mut tree = Tree::new();
        let group = tree.group(Tree::ROOT, "same");
        tree.dataset(group, "fixed", Element::UInt8, &[3], self.fixed);
        let group = tree.group(Tree::ROOT, "links");
        tree.links(group, &self.links);
        tree.numbers(group, "last", &[step]);
        let data = Payload::Chunks {
            rows: 2,
            chunks: &self.chunks,
        };
        tree.dataset(
            Tree::ROOT,
            "x",
            Element::Float64,
            &[2 * (step + 1), 2],
            data,
        );
        tree.rows(Tree::ROOT, "steps", &self.steps);
        tree.rows(Tree::ROOT, "names", &self.names);
        tree.rows(Tree::ROOT, "alike", &self.alike);
        file.finish_step(&tree)?;
        file.commit()?;
        self.n += 1;
        Ok(())
    }

    fn bytes(&self) -> Vec<u8> {
        self.file.bytes()
    }
}

/// A sequence of `n` steps; the bytes of the file after each.
fn grown(n: usize) -> Vec<Vec<u8>> {
    let mut sequence = Sequence::start();
    let mut step = || {
        sequence.append();
        sequence.bytes()
    };
    (0..n).map(|_| step()).collect()
}

#[test]
fn a_file_of_many_steps_grows_by_little_more_than_their_values() {
    const N: usize = 6000;
    let mut sequence = Sequence::start();
    let mut sizes = vec![0];
    for step in 0..N {
        sequence.append();
        sizes.push(sequence.file.n_bytes());
        let n = step as u64 + 1;
        // Around the numbers at which an index or a list gets a block or a level more.
        if !matches!(n, 1..=5 | 20..=23 | 64..=66 | 313..=318 | 511..=514 | 4723..=4727 | 6000) {
            continue;
        }
        let root = open(sequence.bytes());
        let x: Vec<f64> = (0..n).flat_map(|i| [i as f64; 4]).collect();
        assert_eq!(values(&root, "x"), Values::F64(x), "{n} steps");
        let last = root.need("x").and_then(|x| x.rows(2 * n - 2..2 * n));
        let wanted = Values::F64(vec![n as f64 - 1.0; 4]);
        assert_eq!(last.expect("it has the rows"), wanted);
        assert_eq!(values(&root, "steps"), Values::U64((0..n).collect()));
        assert_eq!(
            values(&root, "alike"),
            Values::I64((0..n).map(alike).collect())
        );
        let names: String = (0..n).map(name).collect();
        let names = names.bytes().map(|byte| byte as i8).collect();
        assert_eq!(values(&root, "names"), Values::I8(names), "{n} steps");
        let same = root.group("same").expect("it is read").expect("a group");
        assert_eq!(values(&same, "fixed"), Values::U8(vec![1, 2, 3]));
        let links = root.group("links").expect("it is read").expect("a group");
        assert_eq!(values(&links, "last"), Values::U64(vec![n - 1]));
        let steps = links.groups().expect("they are read");
        let steps = steps.iter().map(|step| step.attribute("step").ok()?);
        let wanted: Vec<_> = (0..n).map(|step| Some(Values::U64(vec![step]))).collect();
        assert_eq!(steps.collect::<Vec<_>>(), wanted, "{n} steps");
    }
    let growth = |at: usize| (sizes[at] - sizes[at - 500]) / 500;
    let (early, late) = (growth(1000), growth(N));
    assert!(
        early < 6_000 && late < 9_000,
        "{early}, {late} bytes a step"
    );
}

#[test]
fn a_growing_file_cut_anywhere_holds_the_steps_before() {
    let states = grown(3);
    let (before, after) = (&states[1], &states[2]);
    for n in before.len()..after.len() {
        let mut cut = after[..n].to_vec();
        cut[..before.len()].copy_from_slice(before);
        let root = open(cut);
        assert_eq!(values(&root, "steps"), Values::U64(vec![0, 1]));
    }
    assert_eq!(
        before[48..],
        after[48..before.len()],
        "nothing is written over"
    );
}

#[test]
fn damaged_files_are_refused_without_a_panic() {
    let whole = grown(2).pop().expect("two steps");
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x55;
        let source = Source::from_bytes(Path::new("damaged.h5"), bytes);
        let Ok(root) = File::open(&source).and_then(|file| file.root()) else {
            continue;
        };
        for dataset in root.datasets().unwrap_or_default() {
            let _ = dataset.values();
        }
    }
}

//! Sequences in one file.

use super::*;
use crate::formats::{Begin, SequenceFile};
use crate::testing::assert_says;

/// Three steps of the mesh: nodes move, one array changes at the last step.
fn moving(step: usize) -> Mesh {
    let mut mesh = mesh();
    for point in &mut mesh.points {
        point[2] += step as f64;
    }
    if let (2, Values::U8(values)) = (step, &mut mesh.point_arrays[1].values) {
        values[3] = 99;
    }
    mesh
}

fn sequence(folder: &Path) -> (Box<dyn SequenceFile>, std::path::PathBuf) {
    let path = folder.join("moving.vtkhdf");
    let create = VTKHDF.sequence.expect("it has sequences");
    let sequence =
        create(&path, &WriteOptions::default(), Begin::Create, false).expect("it can be made");
    (sequence, path)
}

#[test]
fn a_sequence_is_whole_under_its_name_after_each_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut sequence, path) = sequence(folder.path());
    assert!(!path.exists());
    let mut sizes = Vec::new();
    for step in 0..3 {
        sequence
            .push(step as f64 * 0.25, &moving(step).view())
            .expect("it is appended");
        let source = Source::open(&path).expect("it has its name");
        let times: Vec<f64> = (0..=step).map(|i| i as f64 * 0.25).collect();
        assert_eq!((VTKHDF.steps)(&source).expect("it has steps"), times);
        for earlier in 0..=step {
            assert_same(&read(&source, Some(earlier)), &moving(earlier));
        }
        sizes.push(source.bytes().len());
    }
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("a folder").count(),
        1
    );
    assert!(
        sizes[1] - sizes[0] < sizes[0],
        "what stays is written once: {sizes:?}"
    );
}

#[test]
fn a_sequence_is_gone_on_with_to_the_same_bytes_wherever_it_ended_or_was_damaged() {
    let folder = tempfile::tempdir().expect("a folder");
    let append = |sequence: &mut Box<dyn SequenceFile>, steps: std::ops::Range<usize>| {
        let mut append = |step| sequence.push(step as f64, &moving(step).view());
        steps
            .map(|step| append(step).expect("it is appended"))
            .collect::<Vec<_>>()
    };
    let (mut whole, path) = sequence(folder.path());
    let mut hashes = append(&mut whole, 0..1);
    let first = std::fs::read(&path).expect("it is there");
    hashes.extend(append(&mut whole, 1..3));
    drop(whole);
    let wanted = std::fs::read(&path).expect("it is there");
    let create = VTKHDF.sequence.expect("it has sequences");
    let resume =
        || create(&path, &WriteOptions::default(), Begin::Resume, false).expect("it opens");
    let check = |content: &[u8], what: &str| {
        std::fs::write(&path, content).expect("it can be written");
        let mut sequence = resume();
        assert_eq!(append(&mut sequence, 0..3), hashes, "{what}");
        assert!(
            std::fs::read(&path).expect("it is there") == wanted,
            "{what}"
        );
        sequence.is_resuming()
    };
    assert!(check(&wanted, "whole"));
    for end in (first.len()..wanted.len()).step_by(97) {
        // After a kill: the file begins as after the first step.
        let content = [&first[..48], &wanted[48..end]].concat();
        assert!(!check(&content, &format!("{end} bytes")));
    }
    for at in (48..wanted.len()).step_by(131) {
        let mut content = wanted.clone();
        content[at] ^= 1;
        assert!(!check(&content, &format!("damaged at {at}")));
    }
    std::fs::remove_file(&path).expect("it is there");
    assert_eq!(append(&mut resume(), 0..3), hashes, "from nothing");
    // A file damaged in its second step keeps the first while it is written again.
    let mut content = wanted.clone();
    content[first.len() + 80] ^= 1;
    std::fs::write(&path, content).expect("it can be written");
    let mut sequence = resume();
    append(&mut sequence, 0..1);
    let mut lacking = moving(1);
    lacking.point_arrays.clear();
    assert!(
        sequence.push(1.0, &lacking.view()).is_err(),
        "arrays are missing"
    );
    drop(sequence);
    let source = Source::open(&path).expect("it is there");
    assert_same(&read(&source, Some(0)), &moving(0));
}

#[test]
fn a_step_too_large_for_a_chunk_is_cut() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cut.vtkhdf");
    let sequence = super::super::sequence::Sequence::create(
        &path,
        &WriteOptions::default(),
        Begin::Create,
        false,
    );
    let mut sequence = sequence.expect("it can be made");
    // 14 nodes of 24 bytes: four chunks of four, the last one half filled.
    sequence.chunk_limit = 100;
    for step in 0..3 {
        sequence
            .push(step as f64, &moving(step).view())
            .expect("it is appended");
    }
    let source = Source::open(&path).expect("it is there");
    let points = grid(&source)
        .expect("it is HDF5")
        .expect("it is VTK's")
        .need("Points");
    assert_eq!(points.expect("it has points").shape(), [3 * 16, 3]);
    for step in 0..3 {
        assert_same(&read(&source, Some(step)), &moving(step));
    }
}

#[test]
fn a_sequence_has_the_same_bytes_every_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut hashes = Vec::new();
    for _ in 0..2 {
        let (mut sequence, path) = sequence(folder.path());
        let step = |i| {
            sequence
                .push(i as f64, &moving(i).view())
                .expect("it is appended")
        };
        let of_steps: Vec<blake3::Hash> = (0..3).map(step).collect();
        hashes.push((of_steps, std::fs::read(path).expect("it is there")));
    }
    assert!(hashes[0] == hashes[1]);
    assert!(hashes[0].0[1] != hashes[0].0[2]);
}

#[test]
fn a_sequence_refuses_other_cells_and_other_arrays() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut sequence, path) = sequence(folder.path());
    sequence.push(0.0, &mesh().view()).expect("it is appended");
    let mut other = mesh();
    other.cells.push(CellKind::Triangle, &[0, 1, 3]);
    for array in &mut other.cell_arrays {
        array.values = array.values.select(1, &[0, 1, 2, 3, 4, 4]);
    }
    let error = sequence
        .push(1.0, &other.view())
        .expect_err("it has another cell")
        .to_string();
    assert_says(&error, "other nodes, cells");
    let mut other = mesh();
    other
        .point_arrays
        .push(DataArray::scalar("new", Values::U8(vec![0; 14])));
    let error = sequence
        .push(1.0, &other.view())
        .expect_err("it has another array")
        .to_string();
    assert_says(&error, "\"new\" is not in the first step");
    drop(sequence);
    let source = Source::open(&path).expect("the first step is there");
    assert_eq!((VTKHDF.steps)(&source).expect("it has a step"), [0.0]);
}

#[test]
fn a_sequence_given_up_before_its_first_step_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    drop(sequence(folder.path()));
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("a folder").count(),
        0
    );
}

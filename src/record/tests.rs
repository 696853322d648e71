//! Files of many kinds of runs, in testdata/records: read and written again they are identical.

use super::{BaseFile, RunRecord, parse, text};
use std::fs;
use std::path::{Path, PathBuf};

fn files(extension: &str) -> Vec<PathBuf> {
    let folder = Path::new("testdata/records");
    let entries = fs::read_dir(folder).expect("it is there");
    let paths = entries.map(|entry| entry.expect("it can be listed").path());
    paths
        .filter(|path| path.extension().is_some_and(|found| found == extension))
        .collect()
}

fn record(name: &str) -> RunRecord {
    let path = Path::new("testdata/records").join(name);
    let bytes = fs::read(path).expect("it is there");
    RunRecord::parse(&bytes).expect("it is a record")
}

#[test]
fn a_record_that_is_read_and_written_is_the_same_file() {
    let found = files("json");
    assert!(found.len() >= 12, "{found:?}");
    for path in found {
        let before = fs::read_to_string(&path).expect("it is text");
        let record = RunRecord::parse(before.as_bytes()).expect("it is a record");
        assert!(record.is_whole(), "{path:?}");
        let after = record.text();
        if path.ends_with("joined.json") {
            // Its first writer had `step_ends`, `repairs` and `parts` at the end.
            let [before, after] = [&before, &after].map(|text| {
                let value: serde_json::Value = serde_json::from_str(text).expect("it is JSON");
                value
            });
            assert_eq!(before, after, "{path:?}");
        } else {
            assert_eq!(before, after, "{path:?}");
        }
    }
}

#[test]
fn a_record_says_how_far_its_run_came() {
    assert_eq!(record("running.json").end, None);
    let end = |name: &str| record(name).end.expect("it is over");
    assert_eq!(end("passed_over.json").skipped_steps.len(), 2);
    assert_eq!(end("not_judged.json").inverted_steps, None);
    assert_eq!(end("repairs.json").failures.len(), 4);
    let joined = record("joined.json");
    assert_eq!((joined.resumed, joined.steps_kept), (None, None));
    assert_eq!(
        joined.parts,
        Some(vec!["0..1".to_owned(), "1..4".to_owned()])
    );
    assert_eq!(joined.step_ends.map(|ends| ends.len()), Some(4));
    assert_eq!(record("pipe.json").inputs[0].blake3, None);
    assert_eq!(record("twist.json").selections[0].layers.len(), 2);
    assert_eq!(record("real.json").selections.len(), 2);
}

/// Longest first: each is cut within the braces of the whole.
#[test]
fn a_record_that_is_cut_is_none() {
    let text = record("plain.json").text();
    for end in (0..text.len() - 2).step_by(7) {
        assert!(RunRecord::parse(&text.as_bytes()[..end]).is_err(), "{end}");
    }
}

#[test]
fn what_another_version_does_not_say_is_left_empty() {
    let record =
        RunRecord::parse(br#"{"outcome": "complete", "later": [1], "options": {"kernel": "x"}}"#);
    let record = record.expect("it is a record");
    assert!(!record.is_whole(), "it has no inputs");
    assert_eq!(
        (record.seconds, record.end, record.motion),
        (None, None, None)
    );
    let error = RunRecord::parse(b"{\n\"steps\": \"all\"}").expect_err("\"all\" is not a number");
    assert_eq!(error.position, Some(azimesh_core::error::Position::Line(2)));
}

#[test]
fn errors_that_are_not_finite_are_null_and_stay_so() {
    let mut record = record("plain.json");
    record.selections[0].layers[0].residuals[0] = Some(f64::INFINITY);
    record.selections[0].layers[0].history[0].1 = Some(f64::NAN);
    let text = record.text();
    let read = RunRecord::parse(text.as_bytes()).expect("it is a record");
    assert_eq!(read.selections[0].layers[0].residuals[0], None);
    assert_eq!(read.text(), text);
}

#[test]
fn a_table_that_is_read_and_written_is_the_same_file() {
    let found = files("csv");
    assert!(found.len() >= 3, "{found:?}");
    for path in found {
        let before = fs::read_to_string(&path).expect("it is text");
        let rows = parse(before.as_bytes()).expect("it is a table");
        assert_eq!(rows.keys().copied().collect::<Vec<_>>(), [0, 1, 2, 3]);
        assert_eq!(text(&rows), before, "{path:?}");
        let other = before.replacen(",min_face_weight", "", 1);
        assert!(parse(other.as_bytes()).is_err());
    }
}

#[test]
fn base_points_that_are_read_and_written_are_the_same_file() {
    let found = files("toml");
    assert!(found.len() >= 2, "{found:?}");
    for path in found {
        let before = fs::read_to_string(&path).expect("it is text");
        let base = BaseFile::parse(before.as_bytes()).expect("they are base points");
        assert_eq!(base.text().expect("it can be written"), before, "{path:?}");
    }
}

#[test]
fn base_points_that_are_none_are_told_with_their_line() {
    let error = BaseFile::parse(b"version = 1\nkernel = 3\n").expect_err("it is no text");
    assert_eq!(error.position, Some(azimesh_core::error::Position::Line(2)));
}

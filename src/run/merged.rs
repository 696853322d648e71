//! What the parts of a sequence give together: the file of all steps where the format has one, rows, and a
//! record; and whether the folder holds it already.

use super::compatibility::difference;
use super::finished::Finished;
use super::merge::{Written, damaged};
use super::names::{self, Names};
use super::record::{self, Record, Timings};
use super::table;
use crate::error::{Error, Result};
use crate::formats::{
    self, Encoding, Format, Location, Precision, ReadOptions, WriteOptions, stage_sequence,
};
use crate::progress::Progress;
use crate::record::COLUMNS;
use crate::record::{Row, Rows};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::PathBuf;

/// Rows, and where each ends where one file holds all steps.
pub(super) type RowsAndEnds = (Rows, Vec<u64>);

/// What a folder holds in the place of the joined sequence.
#[derive(Default)]
pub(super) struct Standing {
    /// Its record, where that is whole.
    pub record: Option<Value>,
    /// Its rows, where they, and the file of all steps, are what the parts give.
    pub rows: Option<RowsAndEnds>,
}

impl Standing {
    /// What an earlier join has left, as far as it is whole.
    ///
    /// # Errors
    /// Where it is the sequence of other inputs, or a run that was not made of parts and has other steps.
    pub fn find(
        names: &Names,
        format: &'static dyn Format,
        parts: &[Written],
        progress: &dyn Progress,
    ) -> Result<Self> {
        let path = names.record();
        let record = match path.exists() {
            true => record::read(&path)?,
            false => None,
        };
        // Without a record it is what a join that was ended has left.
        let Some(record) = record else {
            return Ok(Self::default());
        };
        let is_other = |reason: &str| {
            let message = format!(
                "this is not the record of these parts joined: {reason}; --force replaces it"
            );
            Err(Error::input(message).file(&path))
        };
        if let Some(difference) = difference(&parts[0].record, &record) {
            return is_other(&difference.beside());
        }
        let rows = rows_there(names, format, parts, &record, progress);
        let standing = Self {
            record: Some(record),
            rows,
        };
        if standing.is_of_one_run() && !standing.is_complete() {
            return is_other("it is of a run of the whole sequence that has other steps");
        }
        Ok(standing)
    }

    /// Whether a run in one go has written it, which has the steps of the parts.
    fn is_of_one_run(&self) -> bool {
        let record = self.record.as_ref();
        record.is_some_and(|record| !record["parts"].is_array())
    }

    fn is_complete(&self) -> bool {
        let record = self.record.as_ref();
        self.rows.is_some() && record.is_some_and(|record| record["outcome"] == "complete")
    }

    /// Whether nothing is left to be written of this record and these texts.
    pub fn is_whole(&self, joined: &Record, texts: &[(PathBuf, String)]) -> bool {
        let keys = [
            "outcome",
            "parts",
            "steps_written",
            "inverted_steps",
            "failures",
            "fail_on",
        ];
        let own = self.record.as_ref();
        let says = |key: &str| own.is_some_and(|own| own[key] == joined.content()[key]);
        let is_there = |(path, text): &(PathBuf, String)| {
            fs::read(path).is_ok_and(|own| own == text.as_bytes())
        };
        self.is_complete()
            && (self.is_of_one_run() || keys.into_iter().all(says) && texts.iter().all(is_there))
    }
}

/// The rows of the folder, where they and their meshes are what the parts give.
fn rows_there(
    names: &Names,
    format: &'static dyn Format,
    parts: &[Written],
    record: &Value,
    progress: &dyn Progress,
) -> Option<RowsAndEnds> {
    let there = table::read(&names.table()).ok()?;
    // A run in one go took other seconds; a mesh among others lies elsewhere than in the file of its part.
    let other: &[&str] = match (record["parts"].is_array(), names.is_in_one()) {
        (true, true) => &["file", "blake3"],
        (true, false) => &[],
        (false, true) => &["file", "blake3", "seconds"],
        (false, false) => &["seconds"],
    };
    let wanted = rows(parts);
    let mut pairs = there.iter().zip(&wanted);
    let is_same = there.len() == wanted.len()
        && pairs.all(|((step, row), (other_step, wanted))| {
            let mut columns = COLUMNS.iter().filter(|column| !other.contains(column));
            step == other_step && columns.all(|column| row.text(column) == wanted.text(column))
        });
    if !is_same {
        return None;
    }
    let ends = step_ends(record);
    match names.is_in_one() {
        true => is_file_of(names, format, &there, &ends, progress).then_some((there, ends)),
        false => Some((there, Vec::new())),
    }
}

/// Whether the file of all steps is the one that these rows speak of.
fn is_file_of(
    names: &Names,
    format: &'static dyn Format,
    rows: &Rows,
    ends: &[u64],
    progress: &dyn Progress,
) -> bool {
    let path = names.path(&names.mesh(0));
    let ends_there = || fs::metadata(&path).is_ok_and(|found| Some(&found.len()) == ends.last());
    if ends.len() != rows.len() || !ends_there() {
        return false;
    }
    progress.start("verifying", Some(rows.len() as u64));
    let is_as_written = damaged(names, rows, ends, progress).is_empty();
    progress.finish();
    // No hash covers the first bytes, which say where the steps are.
    let options = ReadOptions {
        step: Some(rows.len() - 1),
        tag_array: None,
    };
    let read = || formats::read_as(format, &Location::open(&path)?, &options);
    is_as_written && read().is_ok()
}

/// Where each step ends in a file of all, by the record of its run.
pub(super) fn step_ends(record: &Value) -> Vec<u64> {
    let ends = record["step_ends"].as_array().into_iter().flatten();
    ends.filter_map(Value::as_u64).collect()
}

/// run.json goes before what it speaks of changes, and comes back last.
pub(super) fn remove_record(names: &Names) -> Result<()> {
    let path = names.record();
    match fs::remove_file(&path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::io(&path, &error)),
        _ => Ok(()),
    }
}

/// The rows of all parts.
pub(super) fn rows(parts: &[Written]) -> Rows {
    parts.iter().flat_map(|part| part.rows.clone()).collect()
}

/// Writes the meshes of all parts into one file, which takes its name when all are in it.
pub(super) fn join_meshes(
    names: &Names,
    format: &'static dyn Format,
    parts: &[Written],
    progress: &dyn Progress,
) -> Result<RowsAndEnds> {
    let options = write_options(parts);
    let path = names.path(&names.mesh(0));
    let (rows, file) = stage_sequence(&path, format, &options, names.commit, |file| {
        let (mut rows, mut ends) = (Rows::new(), Vec::new());
        progress.start("joining", Some(names.steps().len() as u64));
        for (step, (part, at, row)) in in_order(parts) {
            let from = part.names.path(row.text("file"));
            // Parts have their boundary tags under the common name.
            let options = ReadOptions {
                step: Some(at),
                tag_array: None,
            };
            let loaded = formats::read_as(format, &Location::open(&from)?, &options)?;
            let time = names::time(row).unwrap_or(step as f64);
            let hash = file.push(time, &loaded.mesh.view());
            let hash = hash.map_err(|error| error.file(&path))?;
            let mut row = row.clone();
            row.set("file", names.mesh(step));
            row.set("blake3", hash.to_string());
            rows.insert(step, row);
            ends.push(file.n_bytes());
            progress.advance(1);
        }
        progress.finish();
        Ok((rows, ends))
    })?;
    remove_record(names)?;
    file.keep()?;
    Ok(rows)
}

/// Each step with its part, its place in that and its row.
fn in_order(parts: &[Written]) -> BTreeMap<usize, (&Written, usize, &Row)> {
    let steps = parts.iter().flat_map(|part| {
        let rows = part.rows.iter().enumerate();
        rows.map(move |(at, (step, row))| (*step, (part, at, row)))
    });
    steps.collect()
}

/// Coordinates are written as the parts have them.
fn write_options(parts: &[Written]) -> WriteOptions {
    let precision = match parts[0].record["options"]["precision"].as_str() {
        Some("f32") => Precision::F32,
        _ => Precision::F64,
    };
    WriteOptions {
        precision,
        encoding: Encoding::Raw,
        ..WriteOptions::default()
    }
}

/// What the rows and the records of the parts tell.
pub(super) fn finished(names: &Names, parts: &[Written], rows: &Rows) -> Result<Finished> {
    let mut finished = Finished::default();
    finished.take_rows(names, rows, &BTreeMap::new(), &[])?;
    finished.warnings = union(parts, "warnings");
    finished.failures = union(parts, "failures");
    Ok(finished)
}

/// Texts of a list that the records of the parts have, each once.
fn union(parts: &[Written], key: &str) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for text in values(parts, key).iter().filter_map(Value::as_str) {
        if !all.iter().any(|known| known == text) {
            all.push(text.to_owned());
        }
    }
    all
}

fn values(parts: &[Written], key: &str) -> Vec<Value> {
    let lists = parts.iter().filter_map(|part| part.record[key].as_array());
    lists.flatten().cloned().collect()
}

/// The record of the whole sequence.
pub(super) fn record(
    names: &Names,
    parts: &[Written],
    ends: &[u64],
    finished: &Finished,
) -> Record {
    let mut record = Record::of(names, parts[0].record.clone());
    for key in ["resumed", "steps_kept", "step_ends"] {
        record.remove(key);
    }
    if names.is_in_one() {
        record.set("step_ends", json!(ends));
    }
    let by_step = |key: &str, step: &str| -> Vec<Value> {
        let all = values(parts, key).into_iter();
        let by_step: BTreeMap<_, _> = all.map(|value| (value[step].as_u64(), value)).collect();
        by_step.into_values().collect()
    };
    let bases = parts
        .iter()
        .filter_map(|part| part.record["base_files"].as_object());
    let bases: BTreeMap<&String, &Value> = bases.flatten().collect();
    let ranges = parts
        .iter()
        .map(|part| format!("{}..{}", part.steps.start, part.steps.end));
    let seconds = parts.iter().map(|part| Timings::of(&part.record));
    record.set_timings(seconds.fold(Timings::default(), Timings::plus));
    record.set("selections", json!(by_step("selections", "first_step")));
    record.set("repairs", json!(by_step("repairs", "step")));
    record.set("base_files", json!(bases));
    record.set("parts", json!(ranges.collect::<Vec<_>>()));
    record.set("fail_on", json!(union(parts, "fail_on")));
    record.close(finished, None);
    record
}

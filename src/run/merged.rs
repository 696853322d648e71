//! What the parts of a sequence give together: the file of all steps where the format has one, rows, and a
//! record; and whether the folder holds it already.

use super::compatibility::difference;
use super::finished::Finished;
use super::names::{self, Names};
use super::parts::{PartRun, damaged};
use super::record::{self, RecordFile};
use super::table;
use crate::record::{Row, Rows, RunRecord, Timings};
use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::diagnostic::run::RunNote;
use azimesh_core::error::{Error, Result};
use azimesh_core::progress::Progress;
use azimesh_io::formats::{
    self, Encoding, Format, Location, Precision, ReadOptions, WriteOptions, read_file,
    stage_sequence,
};
use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::PathBuf;

/// Rows, and where each ends where one file holds all steps.
pub(super) type RowsAndEnds = (Rows, Vec<u64>);

/// What a folder holds in the place of the joined sequence.
#[derive(Default)]
pub(super) struct Standing {
    /// Its record, where that is whole.
    record: Option<RunRecord>,
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
        format: &'static Format,
        parts: &[PartRun],
        progress: &dyn Progress,
    ) -> Result<Self> {
        let path = names.record();
        // Without a record it is what a join that was ended has left.
        let Some(record) = record::read(&path)? else {
            return Ok(Self::default());
        };
        let is_other = |reason: &str| {
            let message = format!(
                "this is the record of another sequence than these parts: {reason}; --force replaces it"
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
            return is_other("it is from a run in one go that has other steps");
        }
        Ok(standing)
    }

    /// Whether a run in one go has written it, which has the steps of the parts.
    fn is_of_one_run(&self) -> bool {
        let record = self.record.as_ref();
        record.is_some_and(|record| record.parts.is_none())
    }

    fn is_complete(&self) -> bool {
        let record = self.record.as_ref();
        self.rows.is_some() && record.is_some_and(|record| record.outcome == "complete")
    }

    /// Whether nothing is left to be written of this record and these texts.
    pub fn is_whole(&self, joined: &RunRecord, texts: &[(PathBuf, String)]) -> bool {
        let is_same = |own: &RunRecord| {
            let ends = [own, joined].map(|record| {
                let end = record.end.as_ref()?;
                Some((end.steps_written, end.inverted_steps, &end.failures))
            });
            own.outcome == joined.outcome
                && own.parts == joined.parts
                && own.fail_on == joined.fail_on
                && ends[0] == ends[1]
        };
        let is_there = |(path, text): &(PathBuf, String)| {
            read_file(path).is_ok_and(|own| own == text.as_bytes())
        };
        let is_joined = || self.record.as_ref().is_some_and(is_same) && texts.iter().all(is_there);
        self.is_complete() && (self.is_of_one_run() || is_joined())
    }

    /// Where the time of what is there went.
    pub fn seconds(&self) -> Option<Timings> {
        self.record.as_ref()?.seconds
    }
}

/// The rows of the folder, where they and their meshes are what the parts give.
fn rows_there(
    names: &Names,
    format: &'static Format,
    parts: &[PartRun],
    record: &RunRecord,
    progress: &dyn Progress,
) -> Option<RowsAndEnds> {
    let there = table::read(&names.table()).ok()?;
    // A run in one go took other seconds; a mesh among others lies elsewhere than in the file of its part.
    let comparable = |row: &Row| {
        let mut row = row.clone();
        if record.parts.is_none() {
            row.seconds = 0.0;
        }
        if names.is_in_one() {
            (row.file, row.blake3) = Default::default();
        }
        row.line()
    };
    let wanted = rows(parts);
    if !there
        .values()
        .map(comparable)
        .eq(wanted.values().map(comparable))
    {
        return None;
    }
    if !names.is_in_one() {
        return Some((there, Vec::new()));
    }
    let ends = record.step_ends.clone().unwrap_or_default();
    is_file_of(names, format, &there, &ends, progress).then_some((there, ends))
}

/// Whether the file of all steps is the one that these rows speak of.
fn is_file_of(
    names: &Names,
    format: &'static Format,
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

/// run.json goes before what it speaks of changes, and comes back last.
pub(super) fn remove_record(names: &Names) -> Result<()> {
    let path = names.record();
    match fs::remove_file(&path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::io(&path, &error)),
        _ => Ok(()),
    }
}

/// The rows of all parts.
pub(super) fn rows(parts: &[PartRun]) -> Rows {
    parts.iter().flat_map(|part| part.rows.clone()).collect()
}

/// Writes the meshes of all parts into one file, which takes its name when all are in it.
pub(super) fn join_meshes(
    names: &Names,
    format: &'static Format,
    parts: &[PartRun],
    progress: &dyn Progress,
) -> Result<RowsAndEnds> {
    let options = write_options(parts);
    let path = names.path(&names.mesh(0));
    let (rows, file) = stage_sequence(&path, format, &options, names.commit, |file| {
        let (mut rows, mut ends) = (Rows::new(), Vec::new());
        progress.start("joining", Some(names.steps().len() as u64));
        for (step, (part, at, row)) in in_order(parts) {
            let from = part.names.path(&row.file);
            // Parts have their boundary tags under the common name.
            let options = ReadOptions {
                step: Some(at),
                tag_array: None,
            };
            let loaded = formats::read_as(format, &Location::open(&from)?, &options)?;
            let hash = file.push(names::time(row), &loaded.mesh.view());
            let hash = hash.map_err(|error| error.file(&path))?;
            let mut row = row.clone();
            row.file = names.mesh(step);
            row.blake3 = hash.to_string();
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
fn in_order(parts: &[PartRun]) -> BTreeMap<usize, (&PartRun, usize, &Row)> {
    let steps = parts.iter().flat_map(|part| {
        let rows = part.rows.iter().enumerate();
        rows.map(move |(at, (step, row))| (*step, (part, at, row)))
    });
    steps.collect()
}

/// Coordinates are written as the parts have them.
fn write_options(parts: &[PartRun]) -> WriteOptions {
    let precision = match parts[0].record.options.precision.as_deref() {
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
pub(super) fn finished(names: &Names, parts: &[PartRun], rows: &Rows) -> Result<Finished> {
    let mut finished = Finished::default();
    let has_azimuth = |row: &Row| row.azimuth_deg.is_some();
    let has_azimuth = rows.values().any(has_azimuth);
    finished.take_rows(names, rows, &BTreeMap::new(), &[], has_azimuth)?;
    let ends = || parts.iter().filter_map(|part| part.record.end.as_ref());
    finished.warnings = recorded(union(ends().map(|end| &end.warnings)));
    finished.failures = recorded(union(ends().map(|end| &end.failures)));
    Ok(finished)
}

fn recorded(sentences: Vec<String>) -> Vec<Diagnostic> {
    let notes = sentences
        .into_iter()
        .map(|sentence| RunNote::Recorded { sentence });
    notes.map(Diagnostic::from).collect()
}

/// Texts of several lists, each once.
fn union<'a>(lists: impl Iterator<Item = &'a Vec<String>>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for text in lists.flatten() {
        if !all.contains(text) {
            all.push(text.clone());
        }
    }
    all
}

/// The record of the whole sequence.
pub(super) fn record(
    names: &Names,
    parts: &[PartRun],
    ends: &[u64],
    finished: &Finished,
) -> RecordFile {
    let records = || parts.iter().map(|part| &part.record);
    let selections = records().flat_map(|record| &record.selections);
    let selections: BTreeMap<usize, _> = selections
        .map(|selection| (selection.first_step, selection.clone()))
        .collect();
    let repairs = records().flat_map(|record| record.repairs.iter().flatten());
    let repairs: BTreeMap<usize, _> = repairs
        .map(|repair| (repair.step, repair.clone()))
        .collect();
    let bases = records().flat_map(|record| record.base_files.clone());
    let ranges = parts.iter().map(|part| &part.steps);
    let seconds = records().filter_map(|record| record.seconds);
    let content = RunRecord {
        resumed: None,
        steps_kept: None,
        step_ends: names.is_in_one().then(|| ends.to_vec()),
        seconds: seconds.reduce(Timings::plus),
        selections: selections.into_values().collect(),
        repairs: Some(repairs.into_values().collect()),
        base_files: bases.collect(),
        parts: Some(
            ranges
                .map(|Range { start, end }| format!("{start}..{end}"))
                .collect(),
        ),
        fail_on: union(records().map(|record| &record.fail_on)),
        ..parts[0].record.clone()
    };
    let mut record = RecordFile::of(names, content);
    record.close(finished, None);
    record
}

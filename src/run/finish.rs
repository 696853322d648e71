//! Joins the parts of a sequence: checks that every step exists once and as it was written, then writes the files that a
//! single run would have written. Existing whole files are kept.

use super::compatibility::{Pair, difference};
use super::finished::Finished;
use super::lock::{self, Lock};
use super::names::{self, Names};
use super::outputs::foreign_file;
use super::parts::{self, Found, PartRun, damaged};
use super::record::{self, RecordFile, latest};
use super::table;
use crate::record::{Diagnostic, Row, Rows, RunRecord, Timings};
use azimesh_core::Note;
use azimesh_core::error::{Error, Result};
use azimesh_core::progress::Progress;
use azimesh_io::formats::{
    self, Encoding, Format, Inputs, Loaded, Location, Precision, ReadOptions, WriteOptions,
    clear_left, hash_of, read_file, records_in, replaced, save_text, stage_sequence,
};
use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Rows, and the end of each if one file holds all steps.
type RowsAndEnds = (Rows, Vec<u64>);

/// Joins the parts in `folder`. It completes an earlier join; `force` replaces it, and the files of another run.
///
/// # Errors
/// If a step is missing, written twice or differs from its row, if parts have different inputs, if one is being written,
/// or if the folder holds another run.
pub fn finish(folder: &Path, force: bool, progress: &dyn Progress) -> Result<Finished> {
    let clock = Instant::now();
    let in_case = records_in(folder);
    let folder = in_case.as_deref().unwrap_or(folder);
    let records = parts::records(folder)?;
    let (names, format) = parts::sequence(folder, &records[0])?;
    refuse_inputs(&names, &records)?;
    let _lock = Lock::take(&names)?;
    names::refuse_special(&names)?;
    let first = records[0].record.clone();
    let records = records.into_iter();
    let parts = records.map(|found| PartRun::read(&names, &first, found));
    let parts = parts.collect::<Result<Vec<PartRun>>>()?;
    parts::check(&names, &parts, progress)?;
    let standing = if force {
        None
    } else {
        Standing::find(&names, format, &parts, progress)?
    };
    clear_left(&names.folder);
    let may_replace = force || standing.is_some();
    let kept = standing.as_ref().and_then(|standing| standing.rows.clone());
    let (rows, ends) = match kept {
        Some(kept) => kept,
        None if names.is_in_one => join_meshes(&names, format, &parts, may_replace, progress)?,
        None => (rows(&parts), Vec::new()),
    };
    let mut finished = finished(&names, &parts, &rows)?;
    finished.timings.total = clock.elapsed().as_secs_f64();
    let record = record(&names, &parts, &ends, &finished);
    let mut texts = vec![(names.table(), crate::record::text(&rows))];
    texts.extend(names::series(&names, &rows));
    // A join that was interrupted leaves these texts without a record.
    let is_own = |path: &Path, text: &str| read_file(path).is_ok_and(|own| own == text.as_bytes());
    let is_foreign = |(path, text): &&(PathBuf, String)| path.exists() && !is_own(path, text);
    if let Some((path, _)) = texts.iter().find(is_foreign).filter(|_| !may_replace) {
        return Err(foreign_file(path));
    }
    if let Some(standing) = standing.filter(|there| there.is_whole(&record.content, &texts)) {
        finished.n_kept = finished.n_steps;
        finished.timings = standing.record.seconds.unwrap_or(finished.timings);
    } else {
        remove_record(&names)?;
        let mut texts = texts.iter();
        texts.try_for_each(|(path, text)| save_text(text, path, names.commit))?;
        record.save()?;
        finished.timings = record.content.seconds.unwrap_or_default();
    }
    finished.outcome = record.content.outcome;
    lock::remove_left(folder)?;
    Ok(finished)
}

/// Refuses to replace an input by the joined sequence. An input is found by its path, or a mesh by its hash if the path
/// was relative to another folder.
fn refuse_inputs(names: &Names, records: &[Found]) -> Result<()> {
    let all = || records.iter().flat_map(|found| &found.record.inputs);
    let read = all().filter(|input| input.what != "base");
    names::refuse_inputs(names, &Inputs::of(read.map(|input| &input.file)))?;
    let joined = names.path(&names.mesh(0));
    if names.is_in_one && joined.is_file() {
        let hash = hash_of(&joined).map_err(|error| Error::io(&joined, &error))?;
        let hash = Some(hash.to_string());
        if let Some(mesh) = all().find(|input| input.what == "mesh" && input.blake3 == hash) {
            return Err(replaced(&joined, Path::new(&mesh.file)));
        }
    }
    Ok(())
}

/// The sequence in the folder that is to be joined.
struct Standing {
    record: RunRecord,
    /// Its rows, if they and the file of all steps match the parts.
    rows: Option<RowsAndEnds>,
}

impl Standing {
    /// Finds the valid result of an earlier join; without a record the join was interrupted.
    ///
    /// # Errors
    /// If it is the sequence of other inputs, or a run that was not joined from parts and has other steps.
    fn find(
        names: &Names,
        format: &'static Format,
        parts: &[PartRun],
        progress: &dyn Progress,
    ) -> Result<Option<Self>> {
        let path = names.record();
        let Some(record) = record::read(&path)? else {
            return Ok(None);
        };
        let reason = difference(Pair::Parts, &parts[0].record, &record);
        let rows = match reason {
            None => rows_there(names, format, parts, &record, progress),
            Some(_) => None,
        };
        let standing = Self { record, rows };
        let has_other_steps = standing.record.parts.is_none() && !standing.is_complete();
        let other = "it is from a run in one go that has other steps".to_owned();
        match reason.or(has_other_steps.then_some(other)) {
            None => Ok(Some(standing)),
            Some(reason) => Err(Error::input(format!(
                "this is the record of another sequence than these parts: {reason}; --force replaces it"
            ))
            .file(&path)),
        }
    }

    fn is_complete(&self) -> bool {
        self.rows.is_some() && self.record.is_complete()
    }

    /// Checks if nothing of this record and these texts remains to be written.
    fn is_whole(&self, joined: &RunRecord, texts: &[(PathBuf, String)]) -> bool {
        let of = |record: &RunRecord| {
            let end = record.end.clone().unwrap_or_default();
            let lists = [
                record.parts.clone().unwrap_or_default(),
                record.fail_on.clone(),
            ];
            let counts = (end.steps_written, end.inverted_steps);
            (record.outcome.clone(), lists, counts, end.failures)
        };
        let mut texts = texts.iter();
        let mut are_there =
            || texts.all(|(path, text)| read_file(path).is_ok_and(|own| own == text.as_bytes()));
        self.is_complete()
            && (self.record.parts.is_none() || of(&self.record) == of(joined) && are_there())
    }
}

/// Returns the rows of the folder, if they and their meshes match the parts.
fn rows_there(
    names: &Names,
    format: &'static Format,
    parts: &[PartRun],
    record: &RunRecord,
    progress: &dyn Progress,
) -> Option<RowsAndEnds> {
    let there = table::read(&names.table()).ok()?;
    // A single run has other seconds; a mesh in a file of all steps has another position than in the file of its part.
    let comparable = |row: &Row| {
        let mut row = row.clone();
        if record.parts.is_none() {
            row.seconds = 0.0;
        }
        if names.is_in_one {
            (row.file, row.blake3) = Default::default();
        }
        row.line()
    };
    let wanted = rows(parts);
    let wanted = wanted.values().map(comparable);
    if !there.values().map(comparable).eq(wanted) {
        return None;
    }
    if !names.is_in_one {
        return Some((there, Vec::new()));
    }
    let ends = record.step_ends.clone().unwrap_or_default();
    is_file_of(names, format, &there, &ends, progress).then_some((there, ends))
}

/// Checks if the file of all steps matches these rows.
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
    // No hash covers the first bytes, which locate the steps.
    is_as_written && read_step(&path, format, rows.len() - 1).is_ok()
}

/// run.json is removed before its files change, and written last.
fn remove_record(names: &Names) -> Result<()> {
    let path = names.record();
    match fs::remove_file(&path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::io(&path, &error)),
        _ => Ok(()),
    }
}

/// Returns the rows of all parts.
fn rows(parts: &[PartRun]) -> Rows {
    parts.iter().flat_map(|part| part.rows.clone()).collect()
}

/// Writes the meshes of all parts into one file, which gets its name when it is complete.
fn join_meshes(
    names: &Names,
    format: &'static Format,
    parts: &[PartRun],
    may_replace: bool,
    progress: &dyn Progress,
) -> Result<RowsAndEnds> {
    // Coordinates are written as the parts have them.
    let options = WriteOptions {
        precision: match parts[0].record.options.precision.as_deref() {
            Some("f32") => Precision::F32,
            _ => Precision::F64,
        },
        encoding: Encoding::Raw,
        ..WriteOptions::default()
    };
    let path = names.path(&names.mesh(0));
    let (rows, file) = stage_sequence(&path, format, &options, names.commit, |file| {
        let (mut rows, mut ends) = (Rows::new(), Vec::new());
        progress.start("joining", Some(names.steps().len() as u64));
        for (step, (part, at, row)) in in_order(parts) {
            let loaded = read_step(&part.names.path(&row.file), format, at)?;
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
    // A file that a power cut has shortened holds at least the first step.
    let is_own = || damaged(names, &rows.0, &rows.1, progress).len() < rows.0.len();
    if !may_replace && path.exists() && !is_own() {
        return Err(foreign_file(&path));
    }
    remove_record(names)?;
    file.keep()?;
    Ok(rows)
}

/// Returns each step with its part, its index in the part and its row.
fn in_order(parts: &[PartRun]) -> BTreeMap<usize, (&PartRun, usize, &Row)> {
    let steps = parts.iter().flat_map(|part| {
        let rows = part.rows.iter().enumerate();
        rows.map(move |(at, (step, row))| (*step, (part, at, row)))
    });
    steps.collect()
}

/// Reads a step of a file of several. Runs store their boundary tags under the common name.
pub(super) fn read_step(path: &Path, format: &'static Format, at: usize) -> Result<Loaded> {
    let options = ReadOptions {
        step: Some(at),
        ..ReadOptions::default()
    };
    formats::read_as(format, &Location::open(path)?, &options)
}

/// Returns the result of all parts, from their rows and records.
fn finished(names: &Names, parts: &[PartRun], rows: &Rows) -> Result<Finished> {
    let mut finished = Finished::default();
    let has_azimuth = rows.values().any(|row| row.azimuth_deg.is_some());
    finished.take_rows(names, rows, &BTreeMap::new(), &[], has_azimuth)?;
    let ends = || parts.iter().filter_map(|part| part.record.end.as_ref());
    let warnings = union(ends().map(|end| &end.diagnostics));
    let failures = union(ends().map(|end| &end.failures));
    finished.warnings = warnings.iter().map(Diagnostic::note).collect();
    finished.failures = failures.into_iter().map(Note::from).collect();
    for known in ends().filter_map(|end| end.worst_step.as_ref()) {
        finished.take_place(known);
    }
    Ok(finished)
}

/// Merges lists without duplicates.
fn union<'a, T: Clone + PartialEq + 'a>(lists: impl Iterator<Item = &'a Vec<T>>) -> Vec<T> {
    let mut all: Vec<T> = Vec::new();
    for item in lists.flatten() {
        if !all.contains(item) {
            all.push(item.clone());
        }
    }
    all
}

/// Builds the record of the whole sequence.
fn record(names: &Names, parts: &[PartRun], ends: &[u64], finished: &Finished) -> RecordFile {
    let records = || parts.iter().map(|part| &part.record);
    let selections = records().flat_map(|record| &record.selections);
    let repairs = records().flat_map(|record| record.repairs.iter().flatten());
    let ranges = parts.iter().map(|part| &part.steps);
    let ranges = ranges.map(|steps| format!("{}..{}", steps.start, steps.end));
    let bases = records().flat_map(|record| record.base_files.clone());
    let seconds = records().filter_map(|record| record.seconds);
    let content = RunRecord {
        arguments: parts[0].record.arguments_of_all_steps(),
        resumed: None,
        steps_kept: None,
        step_ends: names.is_in_one.then(|| ends.to_vec()),
        seconds: seconds.reduce(Timings::plus),
        selections: latest(selections, |selection| selection.first_step),
        repairs: Some(latest(repairs, |repair| repair.step)),
        base_files: bases.collect(),
        parts: Some(ranges.collect()),
        fail_on: union(records().map(|record| &record.fail_on)),
        ..parts[0].record.clone()
    };
    let mut record = RecordFile::of(names, content);
    record.close(finished, None);
    record
}

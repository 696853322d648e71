//! Joins the parts of a sequence: checks that every step is there once and as it was written, then
//! writes what a run in one go would have left.

use super::differs::difference;
use super::finished::Finished;
use super::lock::{self, Lock};
use super::output::{self, Names, Part};
use super::parts;
use super::progress::Progress;
use super::record::{self, Clock, Record, Timings, hash_of, hash_of_range};
use super::table::{self, Row, Rows};
use crate::error::{Error, Result};
use crate::formats::{
    self, Begin, Encoding, Format, Precision, ReadOptions, Source, WriteOptions, save_text,
};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Steps that are named one by one in a sentence.
const MOST_NAMED: usize = 12;
/// Bytes at the start of a file of all steps that belong to none of them.
const SUPERBLOCK: u64 = 48;

/// A part of a sequence as its run has left it.
struct Written {
    steps: Range<usize>,
    names: Names,
    record: Value,
    rows: Rows,
}

/// Joins the parts in `folder`; `force` replaces what an earlier join has left.
///
/// # Errors
/// Where a step is missing, written twice or another than its row says, where parts come from
/// different inputs, and where one is being written.
pub fn finish(folder: &Path, force: bool, progress: &dyn Progress) -> Result<Finished> {
    let clock = Clock::start();
    let records = records(folder)?;
    let (first, names, format) = sequence(folder, &records)?;
    let _lock = Lock::take(&names)?;
    let parts: Vec<Written> = records
        .iter()
        .map(|(path, content)| part(&names, &first, path, content))
        .collect::<Result<_>>()?;
    check_outputs(&names, force)?;
    check_steps(&names, &parts)?;
    check_files(&names, &parts, progress)?;
    let rows = match names.is_in_one() {
        true => join_meshes(&names, format, &parts, progress)?,
        false => parts.iter().flat_map(|part| part.rows.clone()).collect(),
    };
    let mut finished = Finished::default();
    finished.take_rows(&names, &rows, &BTreeMap::new(), &[])?;
    finished.warnings = union(&parts, "warnings");
    finished.failures = union(&parts, "failures");
    finished.timings.total = clock.seconds();
    save_text(&table::text(&rows), &names.table(), names.commit)?;
    let record = joined(&names, &parts, &finished);
    record.save()?;
    finished.timings = record.timings();
    for (path, text) in output::series(&names, &rows) {
        save_text(&text, &path, names.commit)?;
    }
    lock::remove_left(folder)?;
    Ok(finished)
}

/// The records of all parts, by their first step.
fn records(folder: &Path) -> Result<Vec<(PathBuf, Value)>> {
    let entries = fs::read_dir(folder).map_err(|error| Error::io(folder, &error))?;
    let found = entries.filter_map(|entry| {
        let path = entry.ok()?.path();
        let steps = parts::steps_of(&path)?;
        Some(((steps.start, steps.end), path))
    });
    let found: BTreeMap<(usize, usize), PathBuf> = found.collect();
    if found.is_empty() {
        return Err(Error::input(
            "holds no parts of a sequence: `azimesh deform --steps A..B` leaves a run_A-B.json for each",
        )
        .file(folder));
    }
    let read = |path: PathBuf| Ok((path.clone(), record::read(&path)?));
    found.into_values().map(read).collect()
}

/// What all parts have in common: a record, and the names of the whole sequence.
fn sequence(
    folder: &Path,
    records: &[(PathBuf, Value)],
) -> Result<(Value, Names, &'static dyn Format)> {
    let (path, first) = &records[0];
    let wrong = || Error::input("this is no record of a part of a sequence").file(path);
    let mesh = first["inputs"][0]["file"].as_str().ok_or_else(wrong)?;
    let format = first["options"]["format"].as_str().ok_or_else(wrong)?;
    let n_steps = first["steps"].as_u64().ok_or_else(wrong)? as usize;
    let format = formats::by_name(format).map_err(|error| error.file(path))?;
    let whole = Part::new(None, n_steps).map_err(|error| error.file(path))?;
    let names = Names::new(folder, Path::new(mesh), format, n_steps, whole);
    Ok((first.clone(), names, format))
}

fn part(names: &Names, first: &Value, path: &Path, content: &Value) -> Result<Written> {
    let steps = parts::steps_of(path).expect("it was found by its name");
    if let Some(difference) = difference(first, content) {
        return Err(Error::input(format!(
            "this part does not belong to the first one: {}",
            difference.beside()
        ))
        .file(path));
    }
    let n_steps = names.steps().len();
    let part = Part::new(Some(steps.clone()), n_steps).map_err(|error| error.file(path))?;
    let names = names.part(part);
    let table = names.table();
    let rows = match table.exists() {
        true => table::read(&table)?,
        false => Rows::new(),
    };
    if let Some(step) = rows.keys().find(|step| !steps.contains(step)) {
        return Err(Error::input(format!("step {step} is not one of this part")).file(&table));
    }
    Ok(Written {
        steps,
        names,
        record: content.clone(),
        rows,
    })
}

/// Refuses to replace what an earlier join has left.
fn check_outputs(names: &Names, force: bool) -> Result<()> {
    let mesh = names.is_in_one().then(|| names.path(&names.mesh(0)));
    let outputs = [
        Some(names.table()),
        Some(names.record()),
        names.series(),
        mesh,
    ];
    match outputs.into_iter().flatten().find(|path| path.exists()) {
        Some(path) if !force => {
            Err(Error::input("exists already; --force replaces it").file(&path))
        }
        _ => Ok(()),
    }
}

/// Every step is in one part.
fn check_steps(names: &Names, parts: &[Written]) -> Result<()> {
    let mut count = vec![0; names.steps().len()];
    for step in parts.iter().flat_map(|part| part.rows.keys()) {
        count[*step] += 1;
    }
    let with = |wanted: fn(usize) -> bool| -> Vec<usize> {
        let all = count.iter().enumerate();
        all.filter(|(_, n)| wanted(**n))
            .map(|(step, _)| step)
            .collect()
    };
    let (missing, twice) = (with(|n| n == 0), with(|n| n > 1));
    let message = match (missing.as_slice(), twice.as_slice()) {
        ([], []) => return Ok(()),
        ([], twice) => format!(
            "{} in more than one part: {}; remove the files of one of them (run_A-B.json, steps_A-B.csv, and \
             its meshes where they are in one file) and write what is missing then by `azimesh deform --steps A..B`",
            told(twice),
            ranges(
                parts
                    .iter()
                    .filter(|part| twice.iter().any(|step| part.rows.contains_key(step)))
            )
        ),
        (missing, _) => format!(
            "{} missing; `azimesh deform --steps A..B` writes them, with --resume where a part was begun",
            told(missing)
        ),
    };
    Err(Error::input(message).file(&names.folder))
}

/// Parts as they are asked for.
fn ranges<'a>(parts: impl Iterator<Item = &'a Written>) -> String {
    let range = |part: &Written| format!("{}..{}", part.steps.start, part.steps.end);
    parts.map(range).collect::<Vec<_>>().join(", ")
}

/// Steps as a subject: runs of them where there are several in a row.
fn told(steps: &[usize]) -> String {
    let runs = steps.chunk_by(|a, b| a + 1 == *b);
    let mut names: Vec<String> = runs
        .map(|run| match run {
            [step] => step.to_string(),
            [first, .., last] => format!("{first} to {last}"),
            [] => String::new(),
        })
        .collect();
    if names.len() > MOST_NAMED {
        let more = names.len() - MOST_NAMED;
        names.truncate(MOST_NAMED);
        names.push(format!("and {more} more ranges"));
    }
    match steps {
        [step] => format!("step {step} is"),
        _ => format!("steps {} are", names.join(", ")),
    }
}

/// Every mesh has the hash that its row says.
fn check_files(names: &Names, parts: &[Written], progress: &dyn Progress) -> Result<()> {
    progress.start("verifying", Some(names.steps().len() as u64));
    let mut wrong = Vec::new();
    for part in parts {
        let ends = ends(part)?;
        let mut from = SUPERBLOCK;
        for (at, (step, row)) in part.rows.iter().enumerate() {
            let path = names.path(row.text("file"));
            let found = match ends.get(at) {
                Some(end) => hash_of_range(&path, from..*end),
                None => hash_of(&path),
            };
            from = ends.get(at).copied().unwrap_or(from);
            if !found.is_ok_and(|hash| hash.to_string() == row.text("blake3")) {
                wrong.push(*step);
            }
            progress.advance(1);
        }
    }
    progress.finish();
    if wrong.is_empty() {
        return Ok(());
    }
    Err(Error::input(format!(
        "{} not there as written (no file, or another hash than the table says); --resume of their part writes \
         them again",
        told(&wrong)
    ))
    .file(&names.folder))
}

/// Where each step ends in the file of a part; empty where each step has a file of its own.
fn ends(part: &Written) -> Result<Vec<u64>> {
    if !part.names.is_in_one() {
        return Ok(Vec::new());
    }
    let ends = part.record["step_ends"].as_array();
    let ends: Vec<u64> = ends
        .into_iter()
        .flatten()
        .filter_map(Value::as_u64)
        .collect();
    match ends.len() == part.rows.len() {
        true => Ok(ends),
        false => Err(Error::input(format!(
            "the run of this part did not come to its end; `azimesh deform --steps {}..{} --resume` brings it there",
            part.steps.start, part.steps.end
        ))
        .file(&part.names.record())),
    }
}

/// Writes the meshes of all parts into one file; gives the rows of that.
fn join_meshes(
    names: &Names,
    format: &'static dyn Format,
    parts: &[Written],
    progress: &dyn Progress,
) -> Result<Rows> {
    let path = names.path(&names.mesh(0));
    let create = format.sequence().expect("one file holds all steps");
    let mut file = create(&path, &write_options(parts)?, Begin::Anew, true)?;
    let mut rows = Rows::new();
    progress.start("joining", Some(names.steps().len() as u64));
    let steps = parts.iter().flat_map(|part| {
        let rows = part.rows.iter().enumerate();
        rows.map(move |(at, (step, row))| (*step, part, at, row))
    });
    let in_order: BTreeMap<usize, (&Written, usize, &Row)> = steps
        .map(|(step, part, at, row)| (step, (part, at, row)))
        .collect();
    for (step, (part, at, row)) in in_order {
        let from = part.names.path(row.text("file"));
        // Parts have their boundary tags under the common name.
        let options = ReadOptions {
            step: Some(at),
            tag_array: None,
        };
        let loaded = formats::read_as(format, &Source::open(&from)?, &options)?;
        let time = output::time(row).unwrap_or(step as f64);
        let hash = file.push(time, &loaded.mesh);
        let hash = hash.map_err(|error| error.file(&path))?;
        let mut row = row.clone();
        row.set("file", names.mesh(step));
        row.set("blake3", hash.to_string());
        rows.insert(step, row);
        progress.advance(1);
    }
    progress.finish();
    Ok(rows)
}

/// Coordinates are written as the parts have them.
fn write_options(parts: &[Written]) -> Result<WriteOptions> {
    let precision = match parts[0].record["options"]["precision"].as_str() {
        Some("f32") => Precision::F32,
        _ => Precision::F64,
    };
    Ok(WriteOptions {
        precision,
        encoding: Encoding::Raw,
        ..WriteOptions::default()
    })
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
fn joined(names: &Names, parts: &[Written], finished: &Finished) -> Record {
    let mut record = Record::of(names, parts[0].record.clone());
    for key in ["resumed", "steps_kept", "step_ends"] {
        record.remove(key);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_told_as_ranges() {
        assert_eq!(told(&[4]), "step 4 is");
        assert_eq!(told(&[0, 1, 2, 5, 7, 8]), "steps 0 to 2, 5, 7 to 8 are");
        let many: Vec<usize> = (0..40).step_by(2).collect();
        assert!(
            told(&many).ends_with("22, and 8 more ranges are"),
            "{}",
            told(&many)
        );
    }

    #[test]
    fn a_part_is_known_by_the_name_of_its_record() {
        assert_eq!(parts::steps_of(Path::new("d/run_0-12.json")), Some(0..12));
        for other in [
            "run.json",
            "run_0-12.csv",
            "steps_0-12.json",
            "run_a-b.json",
        ] {
            assert_eq!(parts::steps_of(Path::new(other)), None, "{other}");
        }
    }
}

//! Parts of a sequence in one folder: their records and rows, and the checks before they are joined.

use super::compatibility::{Pair, difference};
use super::names::Names;
use super::outputs::foreign_file;
use super::record;
use super::table;
use crate::record::{Rows, RunRecord, file_name, parts_in};
use azimesh_core::error::{Error, Result};
use azimesh_core::progress::Progress;
use azimesh_io::formats::{self, Format, hash_of_range};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Bytes at the start of a file of all steps that belong to no step.
const SUPERBLOCK: u64 = 48;
/// Largest number of steps or parts named in a sentence.
const MOST_NAMED: usize = 12;

/// A part of a sequence, as its run has left it.
pub(super) struct PartRun {
    pub steps: Range<usize>,
    pub names: Names,
    pub record: RunRecord,
    pub rows: Rows,
}

/// The record of a part, and its file.
pub(super) struct Found {
    steps: Range<usize>,
    path: PathBuf,
    pub record: RunRecord,
}

/// Refuses a part if some of its steps belong to another part, or to a whole sequence: a step that exists twice cannot be
/// joined.
pub(super) fn refuse_overlap(names: &Names) -> Result<()> {
    let Range { start, end } = names.steps();
    let is_begun = names.record().exists() || names.table().exists();
    if !names.is_part() || is_begun {
        return Ok(());
    }
    let parts = parts_in(&names.folder, "run", "json").unwrap_or_default();
    let mut parts = parts.into_iter().map(|(part, _)| part);
    let whole = names.path("run.json");
    let (other, record) = if whole.exists() {
        let n_steps = record::read(&whole)?.and_then(|run| run.steps);
        if let Some(n) = n_steps.filter(|n| *n <= start) {
            return Err(Error::input(format!(
                "the run of the whole sequence in this folder has the steps 0..{n}, and parts cannot be joined with it; --resume \
                 without --steps adds the steps {n}..{} of the schedule to it",
                names.all_steps()
            ))
            .file(&whole));
        }
        let other = "a run of the whole sequence".to_owned();
        (other, file_name("run", None, "json"))
    } else if let Some(part) = parts.find(|part| part.start < end && start < part.end) {
        let other = format!("the part {}..{}", part.start, part.end);
        (other, file_name("run", Some(&part), "json"))
    } else {
        return Ok(());
    };
    Err(Error::input(format!(
        "some of the steps {start}..{end} belong to {other} ({record}); give other --steps, continue that run with --resume \
         and its own --steps, or remove its files"
    ))
    .file(&names.folder))
}

/// Refuses a part of another mesh or schedule than the parts that are there, whose base points and mesh it would replace, and
/// a first part where another program has written such files.
pub(super) fn refuse_others(names: &Names, now: &RunRecord) -> Result<()> {
    if !names.is_part() {
        return Ok(());
    }
    // Files are found before records: a part that starts at the same time writes its record first.
    let shared = names.shared_files();
    let mut has_record = false;
    for (part, path) in parts_in(&names.folder, "run", "json").unwrap_or_default() {
        let Some(mut other) = record::read(&path)? else {
            continue;
        };
        has_record = true;
        (other.inputs.iter_mut()).for_each(|input| input.but_steps = None);
        let is_own = part == names.steps();
        if let Some(reason) = difference(Pair::Resumed, now, &other).filter(|_| !is_own) {
            return Err(Error::input(format!(
                "this is a part of another run, whose files this part would replace: {reason}; give another folder, or replace \
                 each part with --force",
            ))
            .file(&path));
        }
    }
    match shared.first().filter(|_| !has_record) {
        Some(path) => Err(foreign_file(path)),
        None => Ok(()),
    }
}

/// Finds steps whose mesh differs from its row; `ends` has the end of each if one file holds all.
pub(super) fn damaged(
    names: &Names,
    rows: &Rows,
    ends: &[u64],
    progress: &dyn Progress,
) -> Vec<usize> {
    let mut from = SUPERBLOCK;
    let mut ends = ends.iter().copied();
    let mut is_damaged = |hash: &str, file: &str| {
        let path = names.path(file);
        let is_same = match ends.next() {
            Some(end) => hash_of_range(&path, std::mem::replace(&mut from, end)..end)
                .map(|own| own.to_string() == hash),
            None => names.has_hash(&path, hash),
        };
        progress.advance(1);
        !is_same.unwrap_or(false)
    };
    let wrong = rows.iter();
    let wrong = wrong.filter(|(_, row)| is_damaged(&row.blake3, &row.file));
    wrong.map(|(step, _)| *step).collect()
}

/// Reads the records of all parts, by their first step.
pub(super) fn records(folder: &Path) -> Result<Vec<Found>> {
    let found = parts_in(folder, "run", "json").map_err(|error| Error::io(folder, &error))?;
    if found.is_empty() {
        let run = record::read(&folder.join("run.json")).ok().flatten();
        let message = if run.is_some_and(|run| run.is_finished()) {
            "the sequence in this folder is complete, and no parts that could be joined again are there"
        } else {
            "holds no parts of a sequence: `azimesh deform --steps A..B` leaves a run_A-B.json for each"
        };
        return Err(Error::input(message).file(folder));
    }
    let read = |(steps, path): (Range<usize>, PathBuf)| {
        let record = record::read(&path)?.ok_or_else(|| {
            let Range { start, end } = steps;
            Error::input(format!(
                "this is not a whole record of a part; `azimesh deform --steps {start}..{end} --resume`, with the mesh and \
                 the schedule of the part, verifies its steps and writes it again"
            ))
            .file(&path)
        })?;
        Ok(Found {
            steps,
            path,
            record,
        })
    };
    found.into_iter().map(read).collect()
}

/// Returns the names of the whole sequence and its format, from the first of its parts.
pub(super) fn sequence(folder: &Path, first: &Found) -> Result<(Names, &'static Format)> {
    let Found { path, record, .. } = first;
    let wrong = || Error::input("this is not the record of a part of a sequence").file(path);
    let mesh = &record.inputs.first().ok_or_else(wrong)?.file;
    let format = record.options.format.as_ref().ok_or_else(wrong)?;
    let n_steps = record.steps.ok_or_else(wrong)?;
    let format = formats::by_name(format).map_err(|error| error.file(path))?;
    let names = Names::new(folder, Path::new(mesh), format, n_steps);
    Ok((names, format))
}

impl PartRun {
    /// Reads the rows of a part, which has the inputs and options of the `first` part.
    pub fn read(names: &Names, first: &RunRecord, found: Found) -> Result<Self> {
        let Found {
            steps,
            path,
            record,
        } = found;
        if let Some(difference) = difference(Pair::Parts, first, &record) {
            let message = format!("this part does not belong to the first part: {difference}");
            return Err(Error::input(message).file(&path));
        }
        let names = names.part(steps.clone());
        let names = names.map_err(|error| error.file(&path))?;
        let rows = table::of_run(&names)?;
        if let Some(step) = rows.keys().find(|step| !steps.contains(step)) {
            let message = format!("step {step} is not one of this part");
            return Err(Error::input(message).file(&names.table()));
        }
        Ok(Self {
            steps,
            names,
            record,
            rows,
        })
    }

    /// Returns the end of each step in the file of the part; empty if each step has its own file.
    fn ends(&self) -> Result<Vec<u64>> {
        if !self.names.is_in_one {
            return Ok(Vec::new());
        }
        let ends = self.record.step_ends.clone().unwrap_or_default();
        if ends.len() == self.rows.len() {
            return Ok(ends);
        }
        Err(Error::input(format!(
            "the run of this part has not finished; `azimesh deform --steps {}..{} --resume` finishes it",
            self.steps.start, self.steps.end
        ))
        .file(&self.names.record()))
    }

    /// Refuses parts whose files of base points, or files next to their meshes, have changed.
    fn check_companions(&self) -> Result<()> {
        let files = self.record.companions.iter().chain(&self.record.base_files);
        let Some(path) = self.names.changed(files, self.rows.values()) else {
            return Ok(());
        };
        let Range { start, end } = self.steps;
        Err(Error::input(format!(
            "this file is missing, or does not have the hash in run_{start}-{end}.json; `azimesh deform --steps {start}..{end} \
             --resume` writes it again"
        ))
        .file(&path))
    }
}

/// Refuses parts that do not contain every step once, with unchanged files.
pub(super) fn check(names: &Names, parts: &[PartRun], progress: &dyn Progress) -> Result<()> {
    check_steps(names, parts)?;
    check_files(names, parts, progress)?;
    parts.iter().try_for_each(PartRun::check_companions)
}

fn check_steps(names: &Names, parts: &[PartRun]) -> Result<()> {
    let mut count = vec![0; names.steps().len()];
    for step in parts.iter().flat_map(|part| part.rows.keys()) {
        count[*step] += 1;
    }
    let with = |wanted: fn(usize) -> bool| -> Vec<usize> {
        (0..count.len()).filter(|&at| wanted(count[at])).collect()
    };
    let (missing, twice) = (with(|n| n == 0), with(|n| n > 1));
    let message = if !missing.is_empty() {
        format!("{} missing: {}", told(&missing), lacking(&missing, parts))
    } else if !twice.is_empty() {
        let has_one = |part: &&PartRun| twice.iter().any(|step| part.rows.contains_key(step));
        let parts = parts.iter().filter(has_one);
        let ranges = parts.map(|part| format!("{}..{}", part.steps.start, part.steps.end));
        format!(
            "{} in more than one part: {}; remove the files of one of these parts (run_A-B.json, \
             steps_A-B.csv, and its meshes if they are in one file), then write the steps that are missing with \
             `azimesh deform --steps A..B`",
            told(&twice),
            ranges.collect::<Vec<_>>().join(", ")
        )
    } else {
        return Ok(());
    };
    Err(Error::input(message).file(&names.folder))
}

/// Names the parts that lack steps, or the steps that no part has, and the command that writes them.
fn lacking(missing: &[usize], parts: &[PartRun]) -> String {
    let record = |part: &PartRun| file_name("run", Some(&part.steps), "json");
    let mut rest = missing.to_vec();
    let mut sentences = Vec::new();
    for part in parts {
        let own: Vec<usize> = rest
            .extract_if(.., |step| part.steps.contains(step))
            .collect();
        if !own.is_empty() {
            let Range { start, end } = part.steps;
            let (record, own) = (record(part), runs(&own));
            sentences.push(format!(
                "the run of {record} has not written {own} (`azimesh deform --steps {start}..{end} --resume` does)"
            ));
        }
    }
    if !rest.is_empty() {
        let all = some(parts.iter().map(record).collect(), "parts");
        let rest = runs(&rest);
        sentences.push(format!(
            "no part has {rest} (there are {all}; `azimesh deform --steps A..B` writes one)"
        ));
    }
    sentences.truncate(MOST_NAMED);
    sentences.join("; ")
}

/// Formats steps as a subject; consecutive ones as ranges.
pub(super) fn told(steps: &[usize]) -> String {
    match steps {
        [step] => format!("step {step} is"),
        _ => format!("steps {} are", runs(steps)),
    }
}

/// Formats steps as a list of ranges.
fn runs(steps: &[usize]) -> String {
    let runs = steps.chunk_by(|a, b| a + 1 == *b);
    let names = runs.map(|run| match run {
        [step] => step.to_string(),
        [first, .., last] => format!("{first} to {last}"),
        [] => String::new(),
    });
    some(names.collect(), "ranges")
}

/// Formats a list; only the first items are named.
fn some(mut names: Vec<String>, what: &str) -> String {
    if names.len() > MOST_NAMED {
        let more = names.len() - MOST_NAMED;
        names.truncate(MOST_NAMED);
        names.push(format!("and {more} more {what}"));
    }
    names.join(", ")
}

/// Refuses parts with a mesh that does not have the hash in its row.
fn check_files(names: &Names, parts: &[PartRun], progress: &dyn Progress) -> Result<()> {
    progress.start("verifying", Some(names.steps().len() as u64));
    let mut wrong = Vec::new();
    for part in parts {
        wrong.extend(damaged(names, &part.rows, &part.ends()?, progress));
    }
    progress.finish();
    if parts[0].record.options.surface.is_some() {
        let has_surface = |step: &usize| names.path(&names.surface(*step)).exists();
        let steps = parts.iter().flat_map(|part| part.rows.keys().copied());
        wrong.extend(steps.filter(|step| !has_surface(step)));
        wrong.sort_unstable();
        wrong.dedup();
    }
    if wrong.is_empty() {
        return Ok(());
    }
    Err(Error::input(format!(
        "{} damaged: the file is missing, or does not have the hash in the table; --resume of that part writes it again",
        told(&wrong)
    ))
    .file(&names.folder))
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
}

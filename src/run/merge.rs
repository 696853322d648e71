//! Joins the parts of a sequence: checks that every step is there once and as it was written, then
//! leaves what a run in one go would have left. What is there already and whole is left as it is.

use super::compatibility::difference;
use super::finished::Finished;
use super::lock::{self, Lock};
use super::merged::{self, Standing};
use super::names::{self, Names, RunSteps};
use super::parts::{PartRun, damaged};
use super::record::{self, Clock};
use super::table;
use crate::record::{RunRecord, file_name, parts_in};
use azimesh_core::error::{Error, Result};
use azimesh_core::progress::Progress;
use azimesh_io::formats::{
    self, Format, Inputs, case_name, clear_left, folder_of, hash_of, records_in, replaced,
    save_text,
};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Steps or parts that are named one by one in a sentence.
const MOST_NAMED: usize = 12;
/// Joins the parts in `folder`. What an earlier join has left is completed; `force` replaces it, and what
/// another run has left.
///
/// # Errors
/// Where a step is missing, written twice or another than its row says, where parts come from
/// different inputs, where one is being written, and where the folder holds another run.
pub fn finish(folder: &Path, force: bool, progress: &dyn Progress) -> Result<Finished> {
    let clock = Clock::start();
    let in_case = records_in(folder);
    let folder = in_case.as_deref().unwrap_or(folder);
    let records = records(folder)?;
    let (names, format) = sequence(folder, &records[0])?;
    refuse_inputs(&names, &records)?;
    let _lock = Lock::take(&names)?;
    names::refuse_special(&names)?;
    let first = records[0].record.clone();
    let parts: Vec<PartRun> = records
        .into_iter()
        .map(|found| part(&names, &first, found))
        .collect::<Result<_>>()?;
    check_steps(&names, &parts)?;
    check_files(&names, &parts, progress)?;
    parts.iter().try_for_each(check_companions)?;
    let standing = match force {
        true => Standing::default(),
        false => Standing::find(&names, format, &parts, progress)?,
    };
    clear_left(&names.folder);
    let (rows, ends) = match &standing.rows {
        Some(kept) => kept.clone(),
        None if names.is_in_one() => merged::join_meshes(&names, format, &parts, progress)?,
        None => (merged::rows(&parts), Vec::new()),
    };
    let mut finished = merged::finished(&names, &parts, &rows)?;
    finished.timings.total = clock.seconds();
    let record = merged::record(&names, &parts, &ends, &finished);
    let mut texts = vec![(names.table(), crate::record::text(&rows))];
    texts.extend(names::series(&names, &rows));
    if standing.is_whole(&record.content, &texts) {
        finished.n_kept = finished.n_steps;
        finished.timings = standing.seconds().unwrap_or(finished.timings);
    } else {
        merged::remove_record(&names)?;
        let mut texts = texts.iter();
        texts.try_for_each(|(path, text)| save_text(text, path, names.commit))?;
        record.save()?;
        finished.timings = record.content.seconds.unwrap_or_default();
    }
    finished.outcome = record.content.outcome;
    lock::remove_left(folder)?;
    Ok(finished)
}

/// The record of a part and where it lies.
struct Found {
    steps: Range<usize>,
    path: PathBuf,
    record: RunRecord,
}

/// The records of all parts, by their first step.
fn records(folder: &Path) -> Result<Vec<Found>> {
    let found = parts_in(folder, "run", "json").map_err(|error| Error::io(folder, &error))?;
    let of_run = || record::read(&folder.join("run.json")).ok().flatten();
    let is_finished = |run: RunRecord| run.outcome.starts_with("complete");
    if found.is_empty() && of_run().is_some_and(is_finished) {
        return Err(Error::input(
            "the sequence in this folder is complete, and no parts that could be joined again are there",
        )
        .file(folder));
    }
    if found.is_empty() {
        return Err(Error::input(
            "holds no parts of a sequence: `azimesh deform --steps A..B` leaves a run_A-B.json for each",
        )
        .file(folder));
    }
    let read = |(steps, path): (Range<usize>, PathBuf)| match record::read(&path)? {
        Some(record) => Ok(Found {
            steps,
            path,
            record,
        }),
        None => Err(lost(&path, &steps)),
    };
    found.into_iter().map(read).collect()
}

fn lost(record: &Path, steps: &Range<usize>) -> Error {
    let Range { start, end } = steps;
    Error::input(format!(
        "this is not a whole record of a part; `azimesh deform --steps {start}..{end} --resume`, with the mesh and the \
         schedule of the part, verifies its steps and writes it again"
    ))
    .file(record)
}

/// Refuses to put the joined sequence in the place of an input: one that is found by its path or, where the path was given
/// from another folder, a mesh that is found by its hash.
fn refuse_inputs(names: &Names, records: &[Found]) -> Result<()> {
    let all = || records.iter().flat_map(|found| &found.record.inputs);
    let read = all().filter(|input| input.what != "base");
    names::refuse_inputs(names, &Inputs::of(read.map(|input| &input.file)))?;
    let joined = names.path(&names.mesh(0));
    if names.is_in_one() && joined.is_file() {
        let hash = hash_of(&joined).map_err(|error| Error::io(&joined, &error))?;
        let hash = Some(hash.to_string());
        if let Some(mesh) = all().find(|input| input.what == "mesh" && input.blake3 == hash) {
            return Err(replaced(&joined, Path::new(&mesh.file)));
        }
    }
    Ok(())
}

/// What all parts have in common, by the first of them: the names of the whole sequence and its format.
fn sequence(folder: &Path, first: &Found) -> Result<(Names, &'static Format)> {
    let Found { path, record, .. } = first;
    let wrong = || Error::input("this is not the record of a part of a sequence").file(path);
    let mesh = &record.inputs.first().ok_or_else(wrong)?.file;
    let format = record.options.format.as_ref().ok_or_else(wrong)?;
    let n_steps = record.steps.ok_or_else(wrong)?;
    let format = formats::by_name(format).map_err(|error| error.file(path))?;
    let whole = RunSteps::new(None, n_steps).map_err(|error| error.file(path))?;
    let names = Names::new(folder, Path::new(mesh), format, n_steps, whole);
    Ok((names, format))
}

fn part(names: &Names, first: &RunRecord, found: Found) -> Result<PartRun> {
    let Found {
        steps,
        path,
        record,
    } = found;
    if let Some(difference) = difference(first, &record) {
        return Err(Error::input(format!(
            "this part does not belong to the first part: {}",
            difference.beside()
        ))
        .file(&path));
    }
    let n_steps = names.steps().len();
    let part = RunSteps::new(Some(steps.clone()), n_steps).map_err(|error| error.file(&path))?;
    let names = names.part(part);
    let table = names.table();
    let rows = table::of_run(&names)?;
    if let Some(step) = rows.keys().find(|step| !steps.contains(step)) {
        return Err(Error::input(format!("step {step} is not one of this part")).file(&table));
    }
    Ok(PartRun {
        steps,
        names,
        record,
        rows,
    })
}

/// Every step is in one part.
fn check_steps(names: &Names, parts: &[PartRun]) -> Result<()> {
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
            "{} in more than one part: {}; remove the files of one of these parts (run_A-B.json, \
             steps_A-B.csv, and its meshes if they are in one file), then write the steps that are missing with \
             `azimesh deform --steps A..B`",
            told(twice),
            ranges(
                parts
                    .iter()
                    .filter(|part| twice.iter().any(|step| part.rows.contains_key(step)))
            )
        ),
        (missing, _) => format!("{} missing: {}", told(missing), lacking(missing, parts)),
    };
    Err(Error::input(message).file(&names.folder))
}

/// Parts as they are asked for.
fn ranges<'a>(parts: impl Iterator<Item = &'a PartRun>) -> String {
    let range = |part: &PartRun| format!("{}..{}", part.steps.start, part.steps.end);
    parts.map(range).collect::<Vec<_>>().join(", ")
}

/// Where steps are missing, in which parts or in none, and what writes them.
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

/// Steps as a subject: runs of them where there are several in a row.
fn told(steps: &[usize]) -> String {
    match steps {
        [step] => format!("step {step} is"),
        _ => format!("steps {} are", runs(steps)),
    }
}

/// Steps as a list of runs.
fn runs(steps: &[usize]) -> String {
    let runs = steps.chunk_by(|a, b| a + 1 == *b);
    let names = runs.map(|run| match run {
        [step] => step.to_string(),
        [first, .., last] => format!("{first} to {last}"),
        [] => String::new(),
    });
    some(names.collect(), "ranges")
}

/// A list of which the first are named.
fn some(mut names: Vec<String>, what: &str) -> String {
    if names.len() > MOST_NAMED {
        let more = names.len() - MOST_NAMED;
        names.truncate(MOST_NAMED);
        names.push(format!("and {more} more {what}"));
    }
    names.join(", ")
}

/// Every mesh has the hash that its row says.
fn check_files(names: &Names, parts: &[PartRun], progress: &dyn Progress) -> Result<()> {
    progress.start("verifying", Some(names.steps().len() as u64));
    let mut wrong = Vec::new();
    for part in parts {
        wrong.extend(damaged(names, &part.rows, &ends(part)?, progress));
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

/// The files beside the meshes of a part, and those of its base points, are as they were written.
fn check_companions(part: &PartRun) -> Result<()> {
    let record = &part.record;
    for (name, hash) in record.companions.iter().chain(&record.base_files) {
        let paths: Vec<PathBuf> = match name.strip_prefix("*.") {
            Some(ending) => {
                let rows = part.rows.values();
                rows.map(|row| companion(&part.names.path(&row.file), ending))
                    .collect()
            }
            None => vec![match name.strip_prefix("../") {
                Some(inside) => folder_of(&part.names.folder).join(inside),
                None => part.names.path(name),
            }],
        };
        let is_as_written =
            |path: &&PathBuf| hash_of(path).is_ok_and(|own| own.to_string() == *hash);
        if let Some(path) = paths.iter().find(|path| !is_as_written(path)) {
            let Range { start, end } = part.steps;
            return Err(Error::input(format!(
                "this file is missing, or does not have the hash in run_{start}-{end}.json; `azimesh deform --steps {start}..{end} \
                 --resume` writes it again"
            ))
            .file(path));
        }
    }
    Ok(())
}

/// The file with another ending beside a mesh, whose own ending may have dots.
fn companion(mesh: &Path, ending: &str) -> PathBuf {
    let name = mesh.file_name().unwrap_or_default().to_string_lossy();
    mesh.with_file_name(format!("{}.{ending}", case_name(&name)))
}

/// Where each step ends in the file of a part; empty where each step has a file of its own.
fn ends(part: &PartRun) -> Result<Vec<u64>> {
    if !part.names.is_in_one() {
        return Ok(Vec::new());
    }
    let ends = part.record.step_ends.clone().unwrap_or_default();
    match ends.len() == part.rows.len() {
        true => Ok(ends),
        false => Err(Error::input(format!(
            "the run of this part has not finished; `azimesh deform --steps {}..{} --resume` finishes it",
            part.steps.start, part.steps.end
        ))
        .file(&part.names.record())),
    }
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

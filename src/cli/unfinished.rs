//! Unfinished runs, and the commands that continue them.

use crate::record::{RunRecord, in_shell, parts_in};
use azimesh_core::{Note, note};
use azimesh_io::formats::read_file;
use std::io::BufRead;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Returns a note on a folder whose run is not finished, or whose parts are not joined.
pub fn unfinished(folder: &Path) -> Option<Note> {
    records(folder).flatten()
}

/// Returns whether a run has left its records in a folder.
pub fn is_of_run(folder: &Path) -> bool {
    records(folder).is_some()
}

/// As [`of_records`]; the records of a case are in a folder of its own.
fn records(folder: &Path) -> Option<Option<Note>> {
    let places = [folder.to_path_buf(), folder.join("azimesh")];
    places.iter().find_map(|place| of_records(place, folder))
}

/// `None` where there are no records, `Some(None)` where all is finished.
fn of_records(place: &Path, folder: &Path) -> Option<Option<Note>> {
    if let Some(record) = read(&place.join("run.json")) {
        if record.is_finished() {
            return Some(None);
        }
        let rows = read_file(&place.join("steps.csv")).unwrap_or_default();
        let n = rows.lines().count().saturating_sub(1);
        let of = record
            .steps
            .map_or(String::new(), |all| format!(" of {all}"));
        let command = format!("{} --resume", record.command(folder));
        let note = note!(
            "run_not_finished",
            "the run in this folder is not finished, {n}{of} steps are there: if nothing runs there any more, continue it with  \
             {command}"
        );
        return Some(Some(note.with("commands", vec![command])));
    }
    let parts = parts(place);
    let (_, last) = parts.last()?;
    let command = last.command(folder);
    let open = parts.iter().filter(|(_, part)| !part.is_finished());
    let resume = open.map(|(steps, _)| format!("{command} --steps {steps:?} --resume"));
    let ranges = || parts.iter().map(|(steps, _)| steps.clone());
    let missing = missing(ranges(), last.steps.unwrap_or(0)).into_iter();
    let missing = missing.map(|steps| format!("{command} --steps {steps:?}"));
    let finish = std::iter::once(format!(
        "azimesh finish {}",
        in_shell(&folder.display().to_string())
    ));
    let commands: Vec<String> = resume.chain(missing).chain(finish).collect();
    let there: Vec<String> = ranges().map(|steps| format!("{steps:?}")).collect();
    let of = last.steps.map_or(String::new(), |all| format!(" of {all}"));
    let note = note!(
        "parts_not_joined",
        "the parts of the run in this folder are not joined, steps {}{of} are there; to finish it:  {}",
        there.join(", "),
        commands.join(" ;  ")
    );
    Some(Some(note.with("commands", commands)))
}

fn read(path: &Path) -> Option<RunRecord> {
    RunRecord::parse(&read_file(path).ok()?).ok()
}

/// Returns the records of parts, by their first step.
fn parts(place: &Path) -> Vec<(Range<usize>, RunRecord)> {
    let parts = parts_in(place, "run", "json").unwrap_or_default();
    let read = |(steps, path): (Range<usize>, PathBuf)| Some((steps, read(&path)?));
    parts.into_iter().filter_map(read).collect()
}

/// Returns the steps below `n` that are in no range; ranges are in order.
fn missing(ranges: impl Iterator<Item = Range<usize>>, n: usize) -> Vec<Range<usize>> {
    let mut next = 0;
    let gap = |steps: Range<usize>| {
        let from = next;
        next = next.max(steps.end);
        (steps.start > from).then_some(from..steps.start)
    };
    ranges
        .chain(std::iter::once(n..n))
        .filter_map(gap)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_no_part_has_are_found() {
        assert_eq!(missing([0..3, 5..7].into_iter(), 9), [3..5, 7..9]);
        assert!(missing([0..5, 3..9].into_iter(), 9).is_empty());
    }
}

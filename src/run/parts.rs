//! Parts of a sequence beside each other in a folder.

use super::names::{Names, files};
use crate::record::{Rows, RunRecord, part_of};
use azimesh_core::error::{Error, Result};
use azimesh_core::progress::Progress;
use azimesh_io::formats::hash_of_range;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Bytes at the start of a file of all steps that belong to none of them.
const SUPERBLOCK: u64 = 48;

/// A part of a sequence as its run has left it.
pub(super) struct PartRun {
    pub steps: Range<usize>,
    pub names: Names,
    pub record: RunRecord,
    pub rows: Rows,
}

/// The steps of the part that a record is of; `None` for one of a whole sequence.
pub(super) fn steps_of(record: &Path) -> Option<Range<usize>> {
    part_of(record.file_name()?.to_str()?, "run", "json")
}

/// Refuses a part some steps of which belong to another part, or to a whole sequence: a step that is
/// there twice cannot be joined.
pub(super) fn refuse_overlap(names: &Names) -> Result<()> {
    let wanted = names.steps();
    let is_begun = names.record().exists() || names.table().exists();
    if !names.is_part() || is_begun {
        return Ok(());
    }
    let overlaps = |record: &PathBuf| match steps_of(record) {
        Some(other) => other.start < wanted.end && wanted.start < other.end,
        None => true,
    };
    let records = files(names, |name| {
        name == "run.json" || steps_of(Path::new(name)).is_some()
    });
    let Some(record) = records.iter().find(|record| overlaps(record)) else {
        return Ok(());
    };
    let other = match steps_of(record) {
        Some(other) => format!("the part {}..{}", other.start, other.end),
        None => "a run of the whole sequence".to_owned(),
    };
    Err(Error::input(format!(
        "some of the steps {}..{} belong to {other} ({}); give other --steps, continue that run with --resume and its own \
         --steps, or remove its files",
        wanted.start,
        wanted.end,
        record.file_name().unwrap_or_default().display(),
    ))
    .file(&names.folder))
}

/// Steps whose mesh is not what its row says; `ends` tells where each ends where one file holds all.
pub(super) fn damaged(
    names: &Names,
    rows: &Rows,
    ends: &[u64],
    progress: &dyn Progress,
) -> Vec<usize> {
    let mut wrong = Vec::new();
    let mut from = SUPERBLOCK;
    for (at, (step, row)) in rows.iter().enumerate() {
        let path = names.path(&row.file);
        let found = match ends.get(at) {
            Some(end) => {
                hash_of_range(&path, from..*end).map(|hash| hash.to_string() == row.blake3)
            }
            None => names.has_hash(&path, &row.blake3),
        };
        from = ends.get(at).copied().unwrap_or(from);
        if !found.is_ok_and(|is_same| is_same) {
            wrong.push(*step);
        }
        progress.advance(1);
    }
    wrong
}

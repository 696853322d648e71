//! Parts of a sequence beside each other in a folder.

use super::names::{Names, files};
use crate::error::{Error, Result};
use crate::record::part_of;
use std::ops::Range;
use std::path::{Path, PathBuf};

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
        "some of the steps {}..{} belong to {other}, which {} tells of; give --steps that are not among its own, \
         go on with it by --resume and its own steps, or remove its files",
        wanted.start,
        wanted.end,
        record.file_name().unwrap_or_default().display(),
    ))
    .file(&names.folder))
}

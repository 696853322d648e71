//! Files that are in the folder of a run under names that it writes, and that it has not written.

use super::base_file::picture_of;
use super::names::{self, Names};
use super::resume::Earlier;
use crate::record::{Row, Rows};
use azimesh_core::error::{Error, Result};
use azimesh_deform::Plan;
use azimesh_deform::motion::{SelectionMethod, Step};
use azimesh_io::formats::{hash_of, read_file, refuse_special};
use std::collections::BTreeSet;
use std::path::Path;

/// Refuses to resume a run where another program has written a file with the name of one that is to be written. A file of a
/// step that the run had already begun is compared when the step is computed.
///
/// # Errors
/// With the first such file.
pub(super) fn refuse_foreign(plan: &Plan, names: &Names, earlier: &Earlier) -> Result<()> {
    let n_before = earlier.n_steps.unwrap_or(names.all_steps());
    let steps = names.steps().filter(|step| !earlier.listed.contains(step));
    for step in steps {
        let files = names.files_of_step(step).into_iter();
        let mut foreign = files.filter(|path| step >= n_before || !may_be_of_run(names, path));
        foreign
            .next()
            .map_or(Ok(()), |path| Err(foreign_file(&path)))?;
    }
    let is_real = plan.schedule.selection.method == SelectionMethod::Real;
    let added = plan.selection_intervals().into_iter();
    let added = added.filter(|interval| is_real && interval.start >= n_before);
    let bases = added.map(|interval| names.base(Some(interval.start)));
    let mut bases = bases.flat_map(|path| [picture_of(&path), path]);
    if let Some(path) = bases.find(|path| path.exists()) {
        return Err(foreign_file(&path));
    }
    let mut lists = names::series(names, &all_rows(plan, names)).into_iter();
    let foreign = lists.find(|(path, text)| path.exists() && !is_part_of(path, text));
    foreign.map_or(Ok(()), |(path, _)| Err(foreign_file(&path)))
}

/// The refusal of a file that a run would replace.
pub(super) fn foreign_file(path: &Path) -> Error {
    if let Err(error) = refuse_special(path) {
        return error;
    }
    Error::input(
        "another program has written this file, which the run would replace; rename it or use another folder, or let --force \
         start a new run that replaces it",
    )
    .file(path)
}

/// Checks if a file of a step that the run had begun may be of the run.
fn may_be_of_run(names: &Names, path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let ending = |key: &String| {
        key.strip_prefix('*')
            .is_some_and(|ending| name.ends_with(ending))
    };
    match names.companions.iter().find(|(key, _)| ending(key)) {
        Some((_, hash)) => hash_of(path).is_ok_and(|own| own.to_string() == *hash),
        // Only points and a field are written at a time.
        None => !names.has_case() || ["points", "wantedDisplacement"].contains(&&*name),
    }
}

/// Returns rows of all steps, as far as lists of steps need them.
fn all_rows(plan: &Plan, names: &Names) -> Rows {
    let steps = plan.motion.steps.iter();
    let row = |step: &Step| Row {
        step: step.index(),
        azimuth_deg: step.azimuth_deg(),
        time_s: step.time_s(),
        file: names.mesh(step.index()),
        ..Row::default()
    };
    steps.map(|step| (step.index(), row(step))).collect()
}

/// Checks if a list has no other lines than this text; commas separate the entries of one.
fn is_part_of(path: &Path, text: &str) -> bool {
    let line = |line: &str| line.trim_end_matches(',').to_owned();
    let lines: BTreeSet<String> = text.lines().map(line).collect();
    let found = read_file(path)
        .ok()
        .and_then(|bytes| String::from_utf8(bytes).ok());
    found.is_some_and(|found| found.lines().all(|own| lines.contains(&line(own))))
}

//! The case that holds the steps of a sequence, in formats that have that: its folders and files.

use super::names::Names;
use super::table;
use crate::record::{Row, file_name, parts_in};
use azimesh_io::formats::CaseFormat;
use std::path::{Path, PathBuf};

/// A case that holds the steps of a sequence; the folder of [`Names`] lies in it.
#[derive(Clone)]
pub(super) struct Case {
    pub format: CaseFormat,
    pub folder: PathBuf,
    /// File of each step, from the case on; empty until [`Names::place_steps`].
    pub files: Vec<String>,
    /// Folder of the mesh that all steps share.
    pub shared: String,
}

impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Case")
            .field("folder", &self.folder)
            .finish_non_exhaustive()
    }
}

impl Case {
    /// The case that a folder is, or whose records are in it.
    pub fn of(format: CaseFormat, folder: &Path) -> Self {
        let is_records = folder
            .file_name()
            .is_some_and(|name| name == format.records());
        let is_there = is_records && !folder.join(format.records()).exists() && has_records(folder);
        Self {
            format,
            folder: match folder.parent() {
                Some(above) if is_there => above.to_path_buf(),
                _ => folder.to_path_buf(),
            },
            files: Vec::new(),
            shared: String::new(),
        }
    }

    /// The folder of the records.
    pub fn records(&self) -> PathBuf {
        self.folder.join(self.format.records())
    }
}

/// Whether runs have left records in a folder.
fn has_records(folder: &Path) -> bool {
    let is_there = |name: &str| folder.join(file_name(name, None, "json")).exists();
    is_there("run") || parts_in(folder, "run", "json").is_ok_and(|parts| !parts.is_empty())
}

/// Files of the steps that the tables of earlier runs in a case name.
pub(super) fn steps_in_case(names: &Names, case: &Case) -> Vec<PathBuf> {
    let mut tables = vec![names.table()];
    if !names.is_part() {
        let parts = parts_in(&names.folder, "steps", "csv").unwrap_or_default();
        tables.extend(parts.into_iter().map(|(_, path)| path));
    }
    let rows = tables
        .iter()
        .filter_map(|table| table::read(table).ok())
        .flatten();
    // The mesh that all steps share is no step's own.
    let own = |row: &Row| !case.format.is_shared(row.file.trim_start_matches("../"));
    let files = rows
        .filter(|(_, row)| own(row))
        .flat_map(|(_, row)| case.format.files_of(&names.path(&row.file)));
    files.collect()
}

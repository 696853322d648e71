//! steps.csv: a row per step, on disk as soon as the step is finished, and read back by later runs.

use super::names::Names;
use crate::record::{Row, Rows, parse, text};
use azimesh_core::error::{Error, Result};
use azimesh_io::formats::{Commit, read_file, save_text};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The table of a run under way.
pub(super) struct Table {
    file: File,
    path: PathBuf,
    n_bytes: u64,
    rows: Rows,
    commit: Commit,
}

impl Table {
    /// Starts a table with these rows; it replaces an existing one.
    pub fn start(path: PathBuf, rows: Rows, commit: Commit) -> Result<Self> {
        let text = text(&rows);
        save_text(&text, &path, commit)?;
        let file = OpenOptions::new().append(true).open(&path);
        Ok(Self {
            file: file.map_err(|error| Error::io(&path, &error))?,
            path,
            n_bytes: text.len() as u64,
            rows,
            commit,
        })
    }

    /// Adds the row of a step: appended in one write, or inserted if later steps have theirs.
    pub fn add(&mut self, row: Row) -> Result<()> {
        let step = row.step;
        let is_last = self
            .rows
            .last_key_value()
            .is_none_or(|(last, _)| *last < step);
        let line = row.line();
        self.rows.insert(step, row);
        if !is_last {
            let rows = std::mem::take(&mut self.rows);
            *self = Self::start(std::mem::take(&mut self.path), rows, self.commit)?;
            return Ok(());
        }
        if let Err(error) = self.file.write_all(line.as_bytes()) {
            // The error is reported; readers would skip half a row too.
            let _ = self.file.set_len(self.n_bytes);
            return Err(Error::io(&self.path, &error));
        }
        self.n_bytes += line.len() as u64;
        if self.commit.sync {
            let synced = self.file.sync_data();
            synced.map_err(|error| Error::io(&self.path, &error))?;
        }
        Ok(())
    }

    /// Returns the rows so far.
    pub fn rows(&self) -> &Rows {
        &self.rows
    }
}

/// Reads the rows of a run; empty if it has no table yet.
pub(super) fn of_run(names: &Names) -> Result<Rows> {
    let table = names.table();
    if table.exists() {
        read(&table)
    } else {
        Ok(Rows::new())
    }
}

/// Reads the rows of a table on disk.
pub(super) fn read(path: &Path) -> Result<Rows> {
    let bytes = read_file(path);
    let bytes = bytes.map_err(|error| Error::io(path, &error))?;
    parse(&bytes).map_err(|error| error.file(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(step: usize, file: &str) -> Row {
        Row {
            step,
            file: file.to_owned(),
            ..Row::default()
        }
    }

    #[test]
    fn rows_come_back_in_the_order_of_steps_whenever_they_were_added() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("steps.csv");
        let mut table =
            Table::start(path.clone(), Rows::new(), Commit::REPLACE).expect("it starts");
        for step in [0, 3, 1, 4] {
            table.add(row(step, "a, \"b\".vtu")).expect("it is added");
            assert_eq!(&read(&path).expect("it is whole"), table.rows());
        }
        let steps: Vec<usize> = table.rows().keys().copied().collect();
        assert_eq!(steps, [0, 1, 3, 4]);
        assert_eq!(table.rows()[&3].file, "a, \"b\".vtu");
        let written = std::fs::read_to_string(&path).expect("it is there");
        assert_eq!(written, text(table.rows()));
    }

    #[test]
    fn a_table_cut_anywhere_has_its_whole_rows() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("steps.csv");
        let rows: Rows = (0..3).map(|step| (step, row(step, "m.vtu"))).collect();
        let text = text(&rows);
        for end in 0..=text.len() {
            std::fs::write(&path, &text[..end]).expect("it can be written");
            let whole = text[..end].matches('\n').count().saturating_sub(1);
            let found = read(&path).expect("what is cut is left out");
            assert_eq!(found.len(), whole, "{end}");
            assert!(found.iter().all(|(step, row)| rows[step] == *row));
        }
    }

    #[test]
    fn what_a_power_cut_leaves_of_a_table_has_its_whole_rows() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("steps.csv");
        let rows: Rows = (0..3).map(|step| (step, row(step, "m.vtu"))).collect();
        let text = text(&rows);
        let second = text.lines().nth(2).expect("there are three rows");
        for (tail, wanted) in [
            (&[0; 50][..], 3),
            (b"\0\0\0\n", 3),
            (b"9,\xff\xfe\n", 3),
            (format!("{second}\n").as_bytes(), 3),
            (b"nonsense\n3,0\n", 3),
        ] {
            std::fs::write(&path, [text.as_bytes(), tail].concat()).expect("it can be written");
            let found = read(&path).expect("the tail is left out");
            assert_eq!((found.len(), &found), (wanted, &rows), "{tail:?}");
        }
        // The first page of the file is lost, or all of it.
        let at = text.find(second).expect("it is there") - 10;
        for (end, wanted) in [(at, 2), (text.len(), 0)] {
            let mut bytes = text.clone().into_bytes();
            bytes[..end].fill(0);
            std::fs::write(&path, bytes).expect("it can be written");
            let found = read(&path).expect("what is lost is left out");
            assert_eq!(found.len(), wanted);
        }
    }

    #[test]
    fn a_table_with_other_columns_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("steps.csv");
        std::fs::write(&path, "step,file\n0,a\n").expect("it can be written");
        let error = read(&path).expect_err("columns are missing").to_string();
        assert!(
            error.contains("steps.csv:1: the columns are \"step,file\""),
            "{error}"
        );
    }
}

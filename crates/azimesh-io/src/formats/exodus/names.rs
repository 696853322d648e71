//! Names and numbers of blocks, sets and variables.

use super::super::Notes;
use super::super::names::text_of;
use super::super::netcdf::File;
use azimesh_core::error::Result;

/// A block or a set.
#[derive(Debug, Clone)]
pub(super) struct Named {
    /// Its number, by which applications know it.
    pub id: i64,
    /// Its name; its number where the file gives none.
    pub name: String,
}

impl Named {
    /// The number, where it is one that groups can have.
    pub fn number(&self) -> Option<i32> {
        i32::try_from(self.id).ok()
    }
}

/// Names of `n` blocks or sets: their numbers are the property of this name, their names another variable's.
pub(super) fn named(
    file: &File,
    n: usize,
    [ids, names]: [&str; 2],
    notes: &mut Notes,
) -> Result<Vec<Named>> {
    let ids = match file.variable(ids)? {
        Some(ids) => ids.integers()?,
        None => Vec::new(),
    };
    let names = lines(file, names, notes)?;
    let of = |i: usize| {
        let id = ids.get(i).copied().unwrap_or(i as i64 + 1);
        let name = names.get(i).filter(|name| !name.is_empty());
        Named {
            id,
            name: name.cloned().unwrap_or_else(|| id.to_string()),
        }
    };
    Ok((0..n).map(of).collect())
}

/// The lines of text of a variable; none where there is no such variable.
pub(super) fn lines(file: &File, variable: &str, notes: &mut Notes) -> Result<Vec<String>> {
    let Some(variable) = file.variable(variable)? else {
        return Ok(Vec::new());
    };
    let lines = variable.lines()?;
    Ok(lines.iter().map(|line| text_of(line, notes)).collect())
}

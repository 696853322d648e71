//! Reads rows of datasets, window by window.

use super::super::hdf5::{Dataset, Group};
use crate::mesh::Values;
use azimesh_core::error::{Error, Result};
use std::ops::Range;

/// Rows that are in memory twice while they are converted: so few that it is the same memory for all windows, which the
/// system clears once.
pub(super) const WINDOW: u64 = 1 << 17;

/// A number of nodes or cells, which must fit in an index of 32 bits.
pub(super) fn count(rows: &Range<u64>) -> Result<usize> {
    match rows.end - rows.start {
        n if n < u64::from(u32::MAX) => Ok(n as usize),
        n => Err(Error::input(format!(
            "{n} rows are more than the 4294967294 nodes or cells that a mesh can have"
        ))),
    }
}

/// A dataset of one value a row.
pub(super) fn column(grid: &Group, name: &str) -> Result<Dataset> {
    let dataset = grid.need(name)?;
    match dataset.row()? {
        1 => Ok(dataset),
        n => Err(Error::input(format!("its rows have {n} values; they must have 1")).dataset(name)),
    }
}

/// Hands some rows of a dataset to `take`, part by part.
pub(super) fn windows(
    dataset: &Dataset,
    rows: &Range<u64>,
    mut take: impl FnMut(Values) -> Result<()>,
) -> Result<()> {
    dataset.check_rows(rows)?;
    // A chunk is decoded anew for each window that has some of it.
    let n = dataset.whole_chunks(WINDOW);
    let mut start = rows.start;
    while start < rows.end {
        let end = rows.end.min(start.saturating_add(n));
        take(dataset.rows(start..end)?)?;
        start = end;
    }
    Ok(())
}

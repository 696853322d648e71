//! The time at which results are read.

use super::super::netcdf::File;
use azimesh_core::error::{Error, Result};

/// Variable of the times.
const TIMES: &str = "time_whole";

/// Times of the steps; none where the file has no results.
pub(super) fn times(file: &File) -> Result<Vec<f64>> {
    file.variable(TIMES)?
        .map_or(Ok(Vec::new()), |times| times.reals())
}

/// The step that is read: the one asked for, else the last; `None` where there are no times.
pub(super) fn choose(file: &File, asked: Option<usize>) -> Result<Option<usize>> {
    let n = times(file)?.len();
    let message = match asked {
        Some(step) if step < n.max(1) => return Ok(asked.filter(|_| n > 0)),
        None => return Ok(n.checked_sub(1)),
        Some(step) if n <= 1 => format!("there is no step {step}: the file holds one mesh"),
        Some(step) => format!("there is no step {step}: the file has steps 0 to {}", n - 1),
    };
    Err(Error::input(message).dataset(TIMES))
}

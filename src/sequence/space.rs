//! Whether the disk has room for what a run will write.

use super::output::Names;
use super::plan::Plan;
use crate::error::{Error, Result};
use crate::formats::{Compression, Precision};
use crate::motion::QualityOutput;
use std::path::{Path, PathBuf};

/// Bytes of the cell arrays of `quality = "cells"`, for one cell: eleven numbers and a flag.
const QUALITY_BYTES: u64 = 11 * 8 + 1;

/// What a run will write.
#[derive(Debug, Clone, Copy)]
pub(super) struct Demand {
    /// Steps still to be written.
    pub n_steps: u64,
    /// Bytes of the first of them.
    pub first: u64,
    /// Bytes of each of the others.
    pub others: u64,
}

impl Demand {
    /// Of the steps that are not among the `n_kept` of an earlier run, where one mesh alone takes
    /// `mesh_bytes` without the arrays that are added. Where one file holds all steps, what does not
    /// change is written once.
    pub fn of(
        plan: &Plan,
        names: &Names,
        n_kept: usize,
        mesh_bytes: u64,
        holds_arrays: bool,
    ) -> Self {
        let output = &plan.schedule.output;
        let n_nodes = plan.reference.len() as u64;
        let at_nodes = u64::from(output.displacement) + u64::from(output.velocity);
        let at_cells = match output.quality {
            QualityOutput::Cells => plan.mesh.cells.len() as u64 * QUALITY_BYTES,
            QualityOutput::Summary | QualityOutput::None => 0,
        };
        let arrays = match holds_arrays {
            true => at_nodes * n_nodes * 24 + at_cells,
            false => 0,
        };
        let number = match output.precision {
            Precision::F64 => 8,
            Precision::F32 => 4,
        };
        let whole = mesh_bytes + arrays;
        // CGNS leaves out the third coordinate of a plane mesh.
        let is_plane = plan.reference.iter().all(|x| x[2] == 0.0);
        let n_axes: u64 = if is_plane { 2 } else { 3 };
        let others = match names.is_in_one() {
            true => n_axes * n_nodes * number + arrays,
            false => whole,
        };
        Self {
            n_steps: (names.steps().len() - n_kept) as u64,
            first: if n_kept == 0 { whole } else { others },
            others,
        }
    }

    fn bytes(&self) -> u64 {
        match self.n_steps.checked_sub(1) {
            None => 0,
            Some(others) => others
                .saturating_mul(self.others)
                .saturating_add(self.first),
        }
    }
}

/// Refuses a run whose meshes do not fit on the disk, or warns where packing may make them fit;
/// `freed` are the bytes of files that it replaces.
pub(super) fn check(
    plan: &Plan,
    names: &Names,
    demand: &Demand,
    freed: u64,
) -> Result<Option<String>> {
    let Ok(free) = fs4::available_space(existing(&names.folder)) else {
        return Ok(None);
    };
    let (needed, free) = (demand.bytes(), free.saturating_add(freed));
    if needed <= free {
        return Ok(None);
    }
    let figures = format!(
        "{} steps take {} ({} each), and {} are free",
        demand.n_steps,
        size(needed),
        size(demand.others),
        size(free)
    );
    if plan.schedule.output.compression != Compression::None {
        return Ok(Some(format!(
            "{}: unpacked, {figures}",
            names.folder.display()
        )));
    }
    Err(Error::system(format!(
        "{figures}; free some, write fewer with --steps, or go on until the disk is full with --no-space-check"
    ))
    .file(&names.folder))
}

/// The folder, or the nearest one above it that is there.
fn existing(folder: &Path) -> PathBuf {
    let here = PathBuf::from(".");
    let mut above = folder.ancestors().filter(|path| path.is_dir());
    above.next().map_or(here, Path::to_path_buf)
}

/// Bytes as people read them.
pub(super) fn size(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["B", "kB", "MB", "GB", "TB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 999.5 && unit + 1 < UNITS.len() {
        value /= 1000.0;
        unit += 1;
    }
    match unit {
        0 => format!("{bytes} B"),
        _ => format!("{value:.3} {}", UNITS[unit]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_told_in_units_that_fit() {
        assert_eq!(size(12), "12 B");
        assert_eq!(size(1_500), "1.500 kB");
        assert_eq!(size(999_600), "1.000 MB");
        assert_eq!(size(7_654_000_000_000_000), "7654.000 TB");
    }

    #[test]
    fn one_file_of_all_steps_takes_the_cells_once() {
        let of = |n_steps, others| Demand {
            n_steps,
            first: 100,
            others,
        };
        assert_eq!(of(0, 24).bytes(), 0);
        assert_eq!(of(1, 24).bytes(), 100);
        assert_eq!(of(10, 24).bytes(), 316);
        assert_eq!(of(10, 100).bytes(), 1000);
    }
}

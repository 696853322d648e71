//! Rows of each dataset that belong to a step.
//!
//! The parts of a mesh are consecutive in every dataset. A file without steps consists of all parts. Each step uses some
//! of them, and offsets into the other datasets.

use super::super::ReadOptions;
use super::super::hdf5::{Dataset, Group};
use azimesh_core::error::{Error, Result, counted};
use std::ops::Range;

/// Rows of one part of a mesh.
#[derive(Clone)]
pub(super) struct PartRows {
    pub points: Range<u64>,
    pub cells: Range<u64>,
    pub connectivity: Range<u64>,
    /// Rows of `Offsets`, one more than cells.
    pub offsets: Range<u64>,
    pub faces: Option<FaceRows>,
}

/// Rows of the faces of the polyhedra of a part.
#[derive(Clone)]
pub(super) struct FaceRows {
    pub connectivity: Range<u64>,
    /// Rows of `FaceOffsets`, one more than faces.
    pub offsets: Range<u64>,
    /// Rows of `PolyhedronToFaces`.
    pub of_cells: Range<u64>,
}

/// The rows of a mesh, or of one step of a sequence.
pub(super) struct Extent {
    pub parts: Vec<PartRows>,
    steps: Option<Steps>,
}

/// A step of a file with `n` steps.
struct Steps {
    group: Group,
    step: usize,
    n: usize,
}

/// Times of the steps; none where the file holds one mesh.
pub(super) fn times(grid: &Group) -> Result<Vec<f64>> {
    let Some(steps) = grid.group("Steps")? else {
        return Ok(Vec::new());
    };
    let values = steps.need("Values")?.values()?;
    let refused = || Error::input("times must be numbers").dataset("Steps/Values");
    values.to_f64().ok_or_else(refused)
}

impl Extent {
    /// The extent of a step, by default of the last one; of the whole mesh where there are no steps.
    pub fn new(grid: &Group, options: &ReadOptions) -> Result<Self> {
        let n = times(grid)?.len();
        let step = options.step_of(n).map_err(|error| error.dataset("Steps"))?;
        let steps = match (grid.group("Steps")?, step) {
            (Some(group), Some(step)) => Some(Steps { group, step, n }),
            (Some(_), None) => {
                return Err(Error::input("the file has no step yet").dataset("Steps"));
            }
            (None, _) => None,
        };
        let mut extent = Self {
            parts: Vec::new(),
            steps,
        };
        extent.parts = extent.read_parts(grid)?;
        Ok(extent)
    }

    /// Checks if it is a step; otherwise it is all that the file holds.
    pub fn has_steps(&self) -> bool {
        self.steps.is_some()
    }

    /// The rows of all nodes, and of all cells.
    pub fn rows(&self) -> (Range<u64>, Range<u64>) {
        let (Some(first), Some(last)) = (self.parts.first(), self.parts.last()) else {
            return (0..0, 0..0);
        };
        let points = first.points.start..last.points.end;
        (points, first.cells.start..last.cells.end)
    }

    fn read_parts(&self, grid: &Group) -> Result<Vec<PartRows>> {
        let points = counts(grid, "NumberOfPoints")?;
        let cells = counts(grid, "NumberOfCells")?;
        let entries = counts(grid, "NumberOfConnectivityIds")?;
        let n_parts = points.len().min(cells.len()).min(entries.len());
        let parts = self.part_range(n_parts)?;
        let of_faces = |name| enough(counts(grid, name)?, parts.end, "part", name);
        let faces = match grid.dataset("NumberOfFaces")? {
            Some(_) => Some([
                of_faces("NumberOfFaceConnectivityIds")?,
                of_faces("NumberOfFaces")?,
                of_faces("NumberOfPolyhedronToFaceIds")?,
            ]),
            None => None,
        };
        let next = |name, counts: Vec<u64>| -> Result<NextRows> {
            let row = self.start(name, sum(&counts[..parts.start])?)?;
            Ok(NextRows { counts, row })
        };
        let mut points = next("PointOffsets", points)?;
        let mut cells = next("CellOffsets", cells)?;
        let mut entries = next("ConnectivityIdOffsets", entries)?;
        let mut faces = match faces {
            Some([entries, faces, of_cells]) => Some([
                next("FaceConnectivityOffsets", entries)?,
                next("FaceOffsetsOffsets", faces)?,
                next("PolyhedronToFaceIdOffsets", of_cells)?,
            ]),
            None => None,
        };
        let rows = |part| {
            let faces = faces.as_mut().map(|[entries, faces, of_cells]| {
                Ok(FaceRows {
                    connectivity: entries.take(part)?,
                    offsets: faces.take_with_end(part)?.1,
                    of_cells: of_cells.take(part)?,
                })
            });
            let (cells, offsets) = cells.take_with_end(part)?;
            Ok(PartRows {
                points: points.take(part)?,
                cells,
                connectivity: entries.take(part)?,
                offsets,
                faces: faces.transpose()?,
            })
        };
        parts.clone().map(rows).collect()
    }

    /// The parts of the step, of so many in the file.
    fn part_range(&self, n_parts: usize) -> Result<Range<usize>> {
        let Some(Steps { step, .. }) = self.steps else {
            return Ok(0..n_parts);
        };
        let starts = self.of_steps("", "PartOffsets")?.unwrap_or_default();
        let start = starts.get(step).copied().unwrap_or(0);
        let n = match self.of_steps("", "NumberOfParts")? {
            Some(numbers) => numbers[step],
            // Without counts, the parts of a step end where the next step begins.
            None => {
                let later = starts.iter().copied().filter(|other| *other > start).min();
                later.unwrap_or(n_parts as u64).saturating_sub(start)
            }
        };
        let end = start.checked_add(n).filter(|end| *end <= n_parts as u64);
        let end = end.ok_or_else(|| {
            Error::input(format!(
                "step {step} has {n} parts, from part {start} on; the file has {n_parts}"
            ))
            .dataset("Steps")
        })?;
        Ok(start as usize..end as usize)
    }

    /// First row of the step in some datasets; `otherwise` if the file does not say.
    fn start(&self, name: &str, otherwise: u64) -> Result<u64> {
        let starts = self.of_steps("", name)?;
        Ok(match (starts, &self.steps) {
            // Of several topologies the first.
            (Some(starts), Some(steps)) => starts[steps.step * (starts.len() / steps.n)],
            _ => otherwise,
        })
    }

    /// Integers, at least one per step, of a dataset in `Steps` or in a group in it; `None` if there is no such dataset.
    fn of_steps(&self, group: &str, name: &str) -> Result<Option<Vec<u64>>> {
        let Some(steps) = &self.steps else {
            return Ok(None);
        };
        let group = match group {
            "" => Some(steps.group.clone()),
            group => steps.group.group(group)?,
        };
        let values = group.map_or(Ok(None), |group| integers(&group, name))?;
        let values = values.map(|values| enough(values, steps.n, "step", name));
        values.transpose()
    }

    /// The rows of an array in `PointData` or `CellData`, from the rows `rows` of the grid itself.
    pub fn array_rows(&self, offsets: &str, name: &str, rows: &Range<u64>) -> Result<Range<u64>> {
        let start = match (self.of_steps(offsets, name)?, &self.steps) {
            (Some(starts), Some(steps)) => starts[steps.step],
            _ => rows.start,
        };
        rows_from(start, rows.end - rows.start)
    }

    /// The rows of an array in `FieldData`.
    pub fn field_rows(&self, array: &Dataset) -> Result<Range<u64>> {
        let offsets = self.of_steps("FieldDataOffsets", array.name())?;
        let sizes = self.of_steps("FieldDataSizes", array.name())?;
        let (Some(starts), Some(steps)) = (offsets, &self.steps) else {
            return Ok(0..array.n_rows());
        };
        // Without sizes one tuple per step.
        let n = sizes.and_then(|sizes| sizes.get(steps.step * 2 + 1).copied());
        rows_from(starts[steps.step], n.unwrap_or(1))
    }
}

/// Counts of all parts, and the row at which the next part starts.
struct NextRows {
    counts: Vec<u64>,
    row: u64,
}

impl NextRows {
    fn take(&mut self, part: usize) -> Result<Range<u64>> {
        let rows = rows_from(self.row, self.counts[part])?;
        self.row = rows.end;
        Ok(rows)
    }

    /// The rows of a part, and of its offsets: every part has one more.
    fn take_with_end(&mut self, part: usize) -> Result<(Range<u64>, Range<u64>)> {
        let rows = self.take(part)?;
        let start = rows.start.checked_add(part as u64).ok_or_else(too_large)?;
        let n = (rows.end - rows.start).checked_add(1);
        Ok((rows, rows_from(start, n.ok_or_else(too_large)?)?))
    }
}

fn rows_from(start: u64, n: u64) -> Result<Range<u64>> {
    Ok(start..start.checked_add(n).ok_or_else(too_large)?)
}

fn sum(counts: &[u64]) -> Result<u64> {
    let sum = counts.iter().try_fold(0_u64, |sum, n| sum.checked_add(*n));
    sum.ok_or_else(too_large)
}

fn too_large() -> Error {
    Error::input("the sum of its counts is out of range")
}

/// Refuses fewer values than there are steps or parts.
fn enough(values: Vec<u64>, n: usize, what: &str, name: &str) -> Result<Vec<u64>> {
    if values.len() >= n {
        return Ok(values);
    }
    let (found, wanted) = (counted(values.len(), "value"), counted(n, what));
    Err(Error::input(format!("{found} for {wanted}")).dataset(name))
}

/// Counts that must be there.
fn counts(group: &Group, name: &str) -> Result<Vec<u64>> {
    let found = integers(group, name)?;
    found.ok_or_else(|| Error::input("the dataset is missing").dataset(name))
}

/// Integers of 0 and more; `None` where the dataset is not there.
fn integers(group: &Group, name: &str) -> Result<Option<Vec<u64>>> {
    let Some(dataset) = group.dataset(name)? else {
        return Ok(None);
    };
    let numbers = dataset.values()?.to_integers();
    let counts = numbers.and_then(|n| n.into_iter().map(|n| u64::try_from(n).ok()).collect());
    let wrong = || Error::input("it must hold integers from 0 on").dataset(name);
    counts.map(Some).ok_or_else(wrong)
}

//! Which rows of each dataset belong to a step.
//!
//! The parts of a mesh follow one another in every dataset. A file without steps consists of all parts; a step has
//! some of them, and offsets into the other datasets.

use super::super::hdf5::{Dataset, Group};
use crate::mesh::Values;
use azimesh_core::error::{Error, Result, counted};
use std::ops::Range;

/// One part of a mesh, with counts of what it has and where that starts.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct PartRows {
    pub points: Range<u64>,
    pub cells: Range<u64>,
    pub connectivity: Range<u64>,
    /// Rows of `Offsets`, one more than cells.
    pub offsets: Range<u64>,
    pub faces: Option<FaceRows>,
}

/// Faces of the polyhedra of a part.
#[derive(Debug, Clone, Default, PartialEq)]
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
    /// Number of the step and of all steps, where there are steps.
    step: Option<(usize, usize)>,
    steps: Option<Group>,
}

/// Times of the steps; none where the file holds one mesh.
pub(super) fn times(grid: &Group) -> Result<Vec<f64>> {
    let Some(steps) = grid.group("Steps")? else {
        return Ok(Vec::new());
    };
    let values = steps.need("Values")?.values()?;
    reals(&values).ok_or_else(|| Error::input("times must be numbers").dataset("Steps/Values"))
}

impl Extent {
    /// The extent of a step, by default of the last one; of the whole mesh where there are no steps.
    pub fn new(grid: &Group, wanted: Option<usize>) -> Result<Self> {
        let steps = grid.group("Steps")?;
        let n_steps = times(grid)?.len();
        let step = match (&steps, wanted) {
            (Some(_), None) if n_steps > 0 => Some((n_steps - 1, n_steps)),
            (Some(_), None) => {
                return Err(Error::input("the file has no step yet").dataset("Steps"));
            }
            (Some(_), Some(step)) if step < n_steps => Some((step, n_steps)),
            (None, None | Some(0)) => None,
            (_, Some(step)) => {
                let message = match n_steps {
                    0 | 1 => format!("there is no step {step}: the file holds one mesh"),
                    n => format!("there is no step {step}; the file has steps 0 to {}", n - 1),
                };
                return Err(Error::input(message).dataset("Steps"));
            }
        };
        let mut extent = Self {
            parts: Vec::new(),
            step,
            steps,
        };
        extent.parts = extent.read_parts(grid)?;
        Ok(extent)
    }

    /// Whether it is that of a step; otherwise it is all that the file holds.
    pub fn has_steps(&self) -> bool {
        self.step.is_some()
    }

    fn read_parts(&self, grid: &Group) -> Result<Vec<PartRows>> {
        let n_points = counts(grid, "NumberOfPoints")?;
        let n_cells = counts(grid, "NumberOfCells")?;
        let n_entries = counts(grid, "NumberOfConnectivityIds")?;
        let lengths = [n_points.len(), n_cells.len(), n_entries.len()];
        let parts = self.part_range(*lengths.iter().min().unwrap_or(&0))?;
        let mut faces = FaceCounts::read(grid, parts.end)?;
        let mut points = self.start("PointOffsets", sum(&n_points[..parts.start])?)?;
        let mut cells = self.start("CellOffsets", sum(&n_cells[..parts.start])?)?;
        let mut entries = self.start("ConnectivityIdOffsets", sum(&n_entries[..parts.start])?)?;
        if let Some(faces) = &mut faces {
            faces.start_at(self, parts.start)?;
        }
        parts
            .map(|part| {
                Ok(PartRows {
                    points: take(&mut points, n_points[part])?,
                    offsets: offset_rows(cells, part, n_cells[part])?,
                    cells: take(&mut cells, n_cells[part])?,
                    connectivity: take(&mut entries, n_entries[part])?,
                    faces: faces.as_mut().map(|faces| faces.take(part)).transpose()?,
                })
            })
            .collect()
    }

    /// The parts of the step, of so many in the file.
    fn part_range(&self, n_parts: usize) -> Result<Range<usize>> {
        let (Some((step, _)), Some(steps)) = (self.step, &self.steps) else {
            return Ok(0..n_parts);
        };
        let starts = self.of_steps(steps, "PartOffsets")?.unwrap_or_default();
        let start = starts.get(step).copied().unwrap_or(0);
        let n = match self.of_steps(steps, "NumberOfParts")? {
            Some(numbers) => numbers[step],
            // Without numbers, a step has the parts up to the next one's.
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

    /// Where a step starts in some datasets; `otherwise` where the file does not say.
    fn start(&self, name: &str, otherwise: u64) -> Result<u64> {
        let (Some((step, n_steps)), Some(steps)) = (self.step, &self.steps) else {
            return Ok(otherwise);
        };
        // Of several topologies the first.
        let of_step = |starts: Vec<u64>| starts[step * (starts.len() / n_steps)];
        Ok(self.of_steps(steps, name)?.map_or(otherwise, of_step))
    }

    /// Integers of which there are one or several a step; `None` where the dataset is not there.
    fn of_steps(&self, group: &Group, name: &str) -> Result<Option<Vec<u64>>> {
        let values = integers(group, name)?;
        match (&values, self.step) {
            (Some(values), Some((_, n_steps))) if values.len() < n_steps => {
                Err(Error::input(format!(
                    "{} for {}",
                    counted(values.len(), "value"),
                    counted(n_steps, "step")
                ))
                .dataset(name))
            }
            _ => Ok(values),
        }
    }

    /// The rows of an array in `PointData` or `CellData`, `rows` being those of the grid itself.
    pub fn array_rows(&self, offsets: &str, name: &str, rows: Range<u64>) -> Result<Range<u64>> {
        let n = rows.end - rows.start;
        let starts = match self.group(offsets)? {
            Some(group) => self.of_steps(&group, name)?,
            None => None,
        };
        let mut start = match (starts, self.step) {
            (Some(starts), Some((step, _))) => starts[step],
            _ => rows.start,
        };
        take(&mut start, n)
    }

    /// The rows of an array in `FieldData`.
    pub fn field_rows(&self, array: &Dataset) -> Result<Range<u64>> {
        let Some((step, _)) = self.step else {
            return Ok(0..array.n_rows());
        };
        let of_step = |group: &str, per_step: usize, at: usize| -> Result<Option<u64>> {
            let Some(group) = self.group(group)? else {
                return Ok(None);
            };
            let values = self.of_steps(&group, array.name())?;
            Ok(values.and_then(|values| values.get(step * per_step + at).copied()))
        };
        match (
            of_step("FieldDataOffsets", 1, 0)?,
            of_step("FieldDataSizes", 2, 1)?,
        ) {
            (Some(mut start), Some(n)) => take(&mut start, n),
            // One tuple a step.
            (Some(mut start), None) => take(&mut start, 1),
            (None, _) => Ok(0..array.n_rows()),
        }
    }

    fn group(&self, name: &str) -> Result<Option<Group>> {
        self.steps
            .as_ref()
            .map_or(Ok(None), |steps| steps.group(name))
    }
}

/// How many faces and indices of faces each part has, and where the next one starts.
struct FaceCounts {
    n_entries: Vec<u64>,
    n_faces: Vec<u64>,
    n_of_cells: Vec<u64>,
    entries: u64,
    faces: u64,
    of_cells: u64,
}

impl FaceCounts {
    /// `None` for a file without polyhedra.
    fn read(grid: &Group, n_parts: usize) -> Result<Option<Self>> {
        if grid.dataset("NumberOfFaces")?.is_none() {
            return Ok(None);
        }
        let list = |name: &str| {
            let found = counts(grid, name)?;
            match found.len() < n_parts {
                true => Err(Error::input(format!(
                    "{} for {}",
                    counted(found.len(), "value"),
                    counted(n_parts, "part")
                ))
                .dataset(name)),
                false => Ok(found),
            }
        };
        Ok(Some(Self {
            n_entries: list("NumberOfFaceConnectivityIds")?,
            n_faces: list("NumberOfFaces")?,
            n_of_cells: list("NumberOfPolyhedronToFaceIds")?,
            entries: 0,
            faces: 0,
            of_cells: 0,
        }))
    }

    fn start_at(&mut self, extent: &Extent, part: usize) -> Result<()> {
        let before = sum(&self.n_entries[..part])?;
        self.entries = extent.start("FaceConnectivityOffsets", before)?;
        self.faces = extent.start("FaceOffsetsOffsets", sum(&self.n_faces[..part])?)?;
        let before = sum(&self.n_of_cells[..part])?;
        self.of_cells = extent.start("PolyhedronToFaceIdOffsets", before)?;
        Ok(())
    }

    fn take(&mut self, part: usize) -> Result<FaceRows> {
        Ok(FaceRows {
            connectivity: take(&mut self.entries, self.n_entries[part])?,
            offsets: {
                let rows = offset_rows(self.faces, part, self.n_faces[part])?;
                take(&mut self.faces, self.n_faces[part])?;
                rows
            },
            of_cells: take(&mut self.of_cells, self.n_of_cells[part])?,
        })
    }
}

/// Rows of offsets, of which every part has one more than it has cells or faces.
fn offset_rows(start: u64, part: usize, n: u64) -> Result<Range<u64>> {
    let mut start = start.checked_add(part as u64).ok_or_else(too_large)?;
    take(&mut start, n.checked_add(1).ok_or_else(too_large)?)
}

/// The next `n` rows.
fn take(start: &mut u64, n: u64) -> Result<Range<u64>> {
    let end = start.checked_add(n).ok_or_else(too_large)?;
    Ok(std::mem::replace(start, end)..end)
}

fn sum(counts: &[u64]) -> Result<u64> {
    let sum = counts.iter().try_fold(0_u64, |sum, n| sum.checked_add(*n));
    sum.ok_or_else(too_large)
}

fn too_large() -> Error {
    Error::input("the sum of its counts is out of range")
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

/// Values as real numbers; `None` for text.
fn reals(values: &Values) -> Option<Vec<f64>> {
    match values {
        Values::F64(values) => Some(values.clone()),
        Values::F32(values) => Some(values.iter().map(|x| f64::from(*x)).collect()),
        other => Some(other.to_integers()?.into_iter().map(|x| x as f64).collect()),
    }
}

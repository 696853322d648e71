//! The rows of a step as a mesh: nodes, arrays, and tags from them.

use super::super::hdf5::{Dataset, Group};
use super::super::vtk::{cells::repeat_tuples, order, tags};
use super::super::{Notes, ReadOptions};
use super::cells;
use super::extent::{Extent, PartRows};
use super::rows::{count, windows};
use crate::mesh::{DataArray, Mesh, Values};
use azimesh_core::diagnostic::formats::{ArrayRead, NotKept};
use azimesh_core::error::{Error, Result, counted};
use std::ops::Range;

/// Reads a mesh or a step of a sequence. Parts share no nodes.
pub(super) fn read(grid: &Group, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let extent = Extent::new(grid, options.step)?;
    let (point_rows, cell_rows) = rows(&extent);
    let points = points(grid, &point_rows)?;
    let built = cells::read(grid, &extent.parts, &cell_rows, notes)?;
    let mut mesh = Mesh {
        points,
        cells: built.cells,
        ..Mesh::default()
    };
    mesh.point_arrays = arrays(grid, &extent, ("Point", "point"), &point_rows, notes)?;
    mesh.cell_arrays = arrays(grid, &extent, ("Cell", "cell"), &cell_rows, notes)?;
    mesh.field_arrays = fields(grid, &extent, notes)?;
    if let Some(origin) = &built.origin {
        repeat_tuples(&mut mesh.cell_arrays, origin);
    }
    note_others(grid, notes)?;
    order::turn_wedges(&mut mesh, has_marked_wedges(grid)?, notes);
    tags::extract(&mut mesh, options.tag_array.as_deref())?;
    Ok(mesh)
}

/// Whether wedges are marked to be in the order of VTK up to 9.6.
pub(super) fn has_marked_wedges(grid: &Group) -> Result<bool> {
    Ok(grid.text(order::WEDGES)?.as_deref() == Some(order::OUTWARD))
}

/// The rows of all nodes, and of all cells.
pub(super) fn rows(extent: &Extent) -> (Range<u64>, Range<u64>) {
    let rows = |of: fn(&PartRows) -> &Range<u64>| match (extent.parts.first(), extent.parts.last())
    {
        (Some(first), Some(last)) => of(first).start..of(last).end,
        _ => 0..0,
    };
    (rows(|part| &part.points), rows(|part| &part.cells))
}

pub(super) fn points(grid: &Group, rows: &Range<u64>) -> Result<Vec<[f64; 3]>> {
    if rows.is_empty() {
        return Ok(Vec::new());
    }
    let dataset = grid.need("Points")?;
    let n = count(rows)?;
    let wrong = |found: &str| {
        let message = format!("it has {found}; it must have 3 real numbers for each point");
        Error::input(message).dataset("Points")
    };
    if dataset.shape().len() != 2 || dataset.row()? != 3 {
        return Err(wrong(&format!("{:?} values", dataset.shape())));
    }
    if dataset.n_rows() < rows.end {
        let found = counted(dataset.n_rows() as usize, "row");
        let message = format!("it has {found}, but NumberOfPoints asks for {}", rows.end);
        return Err(Error::input(message).dataset("Points"));
    }
    dataset.check_rows(rows)?;
    let mut points: Vec<[f64; 3]> = Vec::with_capacity(n);
    windows(&dataset, rows, |values| {
        match values {
            Values::F64(values) => points.extend_from_slice(values.as_chunks().0),
            Values::F32(values) => {
                let some = values.as_chunks::<3>().0.iter();
                points.extend(some.map(|point| point.map(f64::from)));
            }
            _ => return Err(wrong("other values")),
        }
        Ok(())
    })?;
    Ok(points)
}

/// The arrays in `PointData` or `CellData`, those of the rows of the grid. One that is longer than the
/// whole grid is left out, with a note.
pub(super) fn arrays(
    grid: &Group,
    extent: &Extent,
    of: (&str, &'static str),
    rows: &Range<u64>,
    notes: &mut Notes,
) -> Result<Vec<DataArray>> {
    let located = located(grid, extent, of, rows, notes)?.into_iter();
    located
        .map(|(dataset, rows)| array(&dataset, rows, notes))
        .collect()
}

/// Where the arrays are that [`arrays`] reads.
pub(super) fn located(
    grid: &Group,
    extent: &Extent,
    (of, what): (&str, &'static str),
    rows: &Range<u64>,
    notes: &mut Notes,
) -> Result<Vec<(Dataset, Range<u64>)>> {
    let group_name = format!("{of}Data");
    let Some(group) = grid.group(&group_name)? else {
        return Ok(Vec::new());
    };
    let offsets = format!("{of}DataOffsets");
    let mut arrays = Vec::new();
    for dataset in group.datasets()? {
        let (name, n) = (dataset.name(), dataset.n_rows());
        if !extent.has_steps() && n > rows.end {
            notes.push(ArrayRead::TooLong {
                what,
                name: name.to_owned(),
            });
            continue;
        }
        let of_grid = extent.array_rows(&offsets, name, rows.clone())?;
        if n < of_grid.end {
            let needed = of_grid.end;
            let found = counted(n as usize, "row");
            let message = format!("it has {found}; it must have {needed}, one for each {what}");
            return Err(Error::input(message).dataset(&format!("{group_name}/{name}")));
        }
        arrays.push((dataset, of_grid));
    }
    Ok(arrays)
}

pub(super) fn fields(grid: &Group, extent: &Extent, notes: &mut Notes) -> Result<Vec<DataArray>> {
    let Some(group) = grid.group("FieldData")? else {
        return Ok(Vec::new());
    };
    let datasets = group.datasets()?;
    let datasets = datasets.iter();
    datasets
        .map(|dataset| array(dataset, extent.field_rows(dataset)?, notes))
        .collect()
}

/// The components of an array that has these rows.
pub(super) fn check_array(dataset: &Dataset, rows: &Range<u64>) -> Result<usize> {
    dataset.check_rows(rows)?;
    match dataset.row()? {
        0 => Err(Error::input("its tuples have no values").dataset(dataset.name())),
        n => Ok(n),
    }
}

fn array(dataset: &Dataset, rows: Range<u64>, notes: &mut Notes) -> Result<DataArray> {
    let n_components = check_array(dataset, &rows)?;
    let values = dataset.rows(rows)?;
    dataset.note_latin1(notes);
    Ok(DataArray::tuples(dataset.name(), n_components, values))
}

/// Notes groups that are not read.
pub(super) fn note_others(grid: &Group, notes: &mut Notes) -> Result<()> {
    const KNOWN: [&str; 4] = ["PointData", "CellData", "FieldData", "Steps"];
    for name in grid.names()?.0 {
        if !KNOWN.contains(&name.as_str()) {
            notes.push(NotKept::Named {
                what: "group",
                name,
            });
        }
    }
    Ok(())
}

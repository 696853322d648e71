//! Slabs of a mesh or of a step: the rows of some nodes or cells, and no others.
//!
//! Of a dataset in chunks those chunks are decoded whole of which a row is wanted. In a file of a sequence a step is one chunk,
//! of up to 2 GiB, of each dataset that changes: while a rank reads its slab of the coordinates, it holds those of all nodes.

use super::super::hdf5::{Dataset, Group};
use super::super::slabs::{Refusal, Slabs, whole};
use super::super::vtk::{split, tags};
use super::super::{Notes, ReadOptions};
use super::extent::{Extent, PartRows};
use super::rows::{WINDOW, column, count};
use super::{cells, read};
use crate::mesh::{CellKind, Cells, DataArray, Mesh, Values};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use std::collections::BTreeSet;
use std::ops::Range;

type Found<T> = std::result::Result<T, Refusal>;

/// An open mesh or step.
struct Open {
    grid: Group,
    extent: Extent,
    points: Range<u64>,
    cells: Range<u64>,
    /// The array of boundary tags, where the user has chosen one.
    tag_array: Option<String>,
}

/// Opens a mesh or a step. What a reader of the whole finds wrong with its arrays, or remarks on, is found here, but for chunks
/// that are damaged: the values of arrays are not read.
pub(super) fn open(grid: Group, options: &ReadOptions) -> Found<impl Slabs + use<>> {
    let extent = Extent::new(&grid, options.step)?;
    let (points, cells) = read::rows(&extent);
    if count(&points)? == 0 || count(&cells)? == 0 {
        return Err(whole("it has no nodes or no cells"));
    }
    let mut faces = extent.parts.iter().filter_map(|part| part.faces.as_ref());
    if faces.any(|faces| !faces.of_cells.is_empty()) {
        return Err(whole("it has polyhedra"));
    }
    if !read::has_marked_wedges(&grid)? && has_wedges(&grid, &cells)? {
        return Err(whole(
            "all volumes say which order of nodes its wedges have",
        ));
    }
    check_fields(&grid, &extent)?;
    let mut notes = Notes::default();
    let of_points = read::located(&grid, &extent, ("Point", "point"), &points, &mut notes)?;
    let of_cells = read::located(&grid, &extent, ("Cell", "cell"), &cells, &mut notes)?;
    read::note_others(&grid, &mut notes)?;
    if !notes.is_empty() {
        return Err(whole("it has what is not kept"));
    }
    for (array, rows) in of_points.iter().chain(&of_cells) {
        read::check_array(array, rows)?;
        if !array.is_of_numbers() {
            return Err(whole("it has text at nodes or cells"));
        }
        if array.whole_chunks(1) == 1 && !rows.is_empty() {
            // An array that is not in chunks may lie behind the end of a file that is damaged.
            array.rows(rows.start..rows.start + 1)?;
            array.rows(rows.end - 1..rows.end)?;
        }
    }
    check_tags(&grid, &cells, &of_cells, options)?;
    Ok(Open {
        grid,
        extent,
        points,
        cells,
        tag_array: options.tag_array.clone(),
    })
}

fn has_wedges(grid: &Group, cells: &Range<u64>) -> Result<bool> {
    let step = column(grid, "Types")?.whole_chunks(WINDOW);
    for start in (cells.start..cells.end).step_by(step as usize) {
        let types = cells::types(grid, &(start..cells.end.min(start + step)))?;
        if types.contains(&CellKind::Wedge.vtk()) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Refuses field arrays for which the whole has to be read.
fn check_fields(grid: &Group, extent: &Extent) -> Found<()> {
    let mut notes = Notes::default();
    let fields = Mesh {
        field_arrays: read::fields(grid, extent, &mut notes)?,
        ..Mesh::default()
    };
    fields.validate()?;
    notes.close();
    if fields.field_arrays.iter().any(has_shared_names) {
        return Err(whole("tags share a name"));
    }
    match notes.is_empty() {
        true => Ok(()),
        false => Err(whole("it has text of Latin-1")),
    }
}

/// Whether these are names of groups, some of which are the same.
fn has_shared_names(array: &DataArray) -> bool {
    let mut labels = [tags::BOUNDARY, tags::ZONE, tags::LOWER].into_iter();
    let Values::Text(names) = &array.values else {
        return false;
    };
    let mut seen = BTreeSet::new();
    let mut names = names.iter().filter(|name| !name.is_empty());
    labels.any(|labels| labels.names == array.name) && !names.all(|name| seen.insert(name))
}

/// Refuses an array of boundary tags for which the whole has to be read.
fn check_tags(
    grid: &Group,
    cells: &Range<u64>,
    arrays: &[(Dataset, Range<u64>)],
    options: &ReadOptions,
) -> Found<()> {
    let chosen = options.tag_array.as_deref();
    let name = chosen.unwrap_or(tags::BOUNDARY.array);
    let named = arrays.iter().find(|(array, _)| array.name() == name);
    let has_one = |(array, _): &&(Dataset, Range<u64>)| array.row().is_ok_and(|n| n == 1);
    let of_integers = named.filter(|(array, _)| array.is_of_integers());
    match (of_integers.filter(has_one), chosen) {
        (None, Some(_)) => Err(whole("the array of its tags is not one")),
        (Some((array, rows)), None) if !is_no_surface(grid, cells, array, rows)? => {
            Err(whole("it may be the surface of a solid"))
        }
        _ => Ok(()),
    }
}

/// Whether cells and boundary tags tell that the mesh is no surface in space that bounds a solid ([`Mesh::space`]): by a
/// solid cell, an edge that has a tag, or no cell that is two-dimensional.
fn is_no_surface(
    grid: &Group,
    cells: &Range<u64>,
    tags: &Dataset,
    rows: &Range<u64>,
) -> Result<bool> {
    let step = column(grid, "Types")?.whole_chunks(WINDOW) as usize;
    let mut highest = 0;
    for at in (0..cells.end - cells.start).step_by(step) {
        let end = (at + step as u64).min(cells.end - cells.start);
        let types = cells::types(grid, &(cells.start + at..cells.start + end))?;
        let dimension = |vtk: &u8| split::kind(*vtk).map_or(0, |kind| kind.dimension());
        let dimensions: Vec<u8> = types.iter().map(dimension).collect();
        highest = dimensions.iter().copied().fold(highest, u8::max);
        if highest == 3 {
            return Ok(true);
        }
        if dimensions.contains(&1) {
            let numbers = tags.rows(rows.start + at..rows.start + end)?.to_integers();
            let mut numbers = numbers.iter().flatten().zip(&dimensions);
            if numbers.any(|(number, dimension)| *number != 0 && *dimension == 1) {
                return Ok(true);
            }
        }
    }
    Ok(highest < 2)
}

impl Slabs for Open {
    fn n_nodes(&self) -> usize {
        (self.points.end - self.points.start) as usize
    }

    fn n_cells(&self) -> usize {
        (self.cells.end - self.cells.start) as usize
    }

    fn points(&self, nodes: Range<usize>) -> Result<Vec<Vector>> {
        let first = self.points.start;
        let rows = first + nodes.start as u64..first + nodes.end as u64;
        super::placed(read::points(&self.grid, &rows))
    }

    fn cells(&self, cells: Range<usize>) -> Result<Cells> {
        let first = self.cells.start;
        let rows = first + cells.start as u64..first + cells.end as u64;
        super::placed(self.some_cells(&rows))
    }

    fn complete(&self, mesh: &mut Mesh, notes: &mut Notes) -> Found<()> {
        let (grid, extent) = (&self.grid, &self.extent);
        mesh.point_arrays = read::arrays(grid, extent, ("Point", "point"), &self.points, notes)?;
        mesh.cell_arrays = read::arrays(grid, extent, ("Cell", "cell"), &self.cells, notes)?;
        mesh.field_arrays = read::fields(grid, extent, notes)?;
        Ok(tags::extract(mesh, self.tag_array.as_deref())?)
    }
}

impl Open {
    fn some_cells(&self, rows: &Range<u64>) -> Result<Cells> {
        let parts = self.extent.parts.iter().map(|part| self.cut(part, rows));
        let parts = parts.collect::<Result<Vec<_>>>()?;
        let mut notes = Notes::default();
        let built = cells::read(&self.grid, &parts, rows, &mut notes)?;
        match built.origin.is_none() && notes.is_empty() {
            true => {
                let mut cells = built.cells;
                cells.mirror_wedges();
                Ok(cells)
            }
            false => Err(Error::input("it has cells that are split or left out")),
        }
    }

    /// A part with those of its cells that are among these rows.
    fn cut(&self, part: &PartRows, rows: &Range<u64>) -> Result<PartRows> {
        let start = rows.start.clamp(part.cells.start, part.cells.end);
        let cells = start..rows.end.clamp(start, part.cells.end);
        let mut cut = PartRows {
            points: part.points.clone(),
            connectivity: 0..0,
            offsets: 0..0,
            faces: None,
            cells,
        };
        if cut.cells.is_empty() {
            return Ok(cut);
        }
        let row = |cell: u64| part.offsets.start + (cell - part.cells.start);
        cut.offsets = row(cut.cells.start)..row(cut.cells.end) + 1;
        let [first, last] = [row(part.cells.start), row(part.cells.end)];
        let [first, last] = [self.offset(first)?, self.offset(last)?];
        let ends = [cut.offsets.start, cut.offsets.end - 1];
        let [start, end] = [self.offset(ends[0])?, self.offset(ends[1])?];
        let n = part.connectivity.end - part.connectivity.start;
        if first < 0
            || first > start
            || start > end
            || end > last
            || last.checked_sub(first) != Some(n as i64)
        {
            return Err(Error::input("they do not fit the node indices").dataset("Offsets"));
        }
        let entry = |offset: i64| part.connectivity.start + (offset - first) as u64;
        cut.connectivity = entry(start)..entry(end);
        Ok(cut)
    }

    /// Where the nodes of a cell start.
    fn offset(&self, row: u64) -> Result<i64> {
        let value = column(&self.grid, "Offsets")?.rows(row..row + 1)?;
        let value = value
            .to_integers()
            .and_then(|values| values.first().copied());
        value.ok_or_else(|| Error::input("it must hold integers").dataset("Offsets"))
    }
}

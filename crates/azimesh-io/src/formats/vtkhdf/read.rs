//! Rows of a mesh or of a step: all of them as a mesh, or the slabs of ranks.
//!
//! Of a dataset in chunks, every chunk that has a row of a slab is decoded as a whole. In a file of a sequence a step is one chunk
//! of up to 2 GiB of each dataset that changes: a rank that reads its slab of the coordinates holds the coordinates of all nodes meanwhile.

use super::super::hdf5::{Dataset, Group};
use super::super::slabs::{Refusal, Slabs, whole};
use super::super::vtk::{ghosts, order, split, tags};
use super::super::{Notes, ReadOptions};
use super::cells::{self, WINDOW, column, windows};
use super::extent::Extent;
use super::placed;
use crate::formats::notes::too_long;
use crate::mesh::arrays::select_tuples;
use crate::mesh::{CellKind, Cells, DataArray, Mesh, Values};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::note;
use std::collections::BTreeSet;
use std::ops::Range;

type Found<T> = std::result::Result<T, Refusal>;
/// An array, and its rows of the mesh.
type ArrayRows = (Dataset, Range<u64>);

/// A mesh of a file, or a step.
pub(super) struct Reader {
    grid: Group,
    extent: Extent,
    points: Range<u64>,
    cells: Range<u64>,
    /// The array of boundary tags that the user has chosen.
    tag_array: Option<String>,
}

impl Reader {
    pub fn new(grid: Group, options: &ReadOptions) -> Result<Self> {
        let extent = Extent::new(&grid, options)?;
        let (points, cells) = extent.rows();
        Ok(Self {
            grid,
            extent,
            points,
            cells,
            tag_array: options.tag_array.clone(),
        })
    }

    /// Reads all of it. Parts share no nodes.
    pub fn read(&self, notes: &mut Notes) -> Result<Mesh> {
        let points = self.points_at(&self.points)?;
        let built = cells::read(&self.grid, &self.extent.parts, &self.cells, notes)?;
        let mut mesh = Mesh {
            points,
            cells: built.cells,
            ..Mesh::default()
        };
        self.read_arrays(&mut mesh, notes)?;
        if let Some(origin) = &built.origin {
            select_tuples(&mut mesh.cell_arrays, origin);
        }
        self.note_others(notes)?;
        ghosts::leave_out([&mut mesh], notes);
        order::turn_wedges(&mut mesh, self.has_marked_wedges()?, notes);
        tags::extract(&mut mesh, self.tag_array.as_deref())?;
        Ok(mesh)
    }

    /// Checks if wedges are marked to be in the order of VTK up to 9.6.
    fn has_marked_wedges(&self) -> Result<bool> {
        Ok(self.grid.text(order::WEDGES)?.as_deref() == Some(order::OUTWARD))
    }

    fn points_at(&self, rows: &Range<u64>) -> Result<Vec<Vector>> {
        if rows.is_empty() {
            return Ok(Vec::new());
        }
        let dataset = self.grid.need("Points")?;
        let n = cells::count(rows)?;
        let refused = |message: String| Error::input(message).dataset("Points");
        let wrong = |found: &str| {
            refused(format!(
                "it has {found}; it must have 3 real numbers for each point"
            ))
        };
        if dataset.shape().len() != 2 || dataset.row()? != 3 {
            return Err(wrong(&format!("{:?} values", dataset.shape())));
        }
        if dataset.n_rows() < rows.end {
            let (found, end) = (counted(dataset.n_rows() as usize, "row"), rows.end);
            let message = format!("it has {found}, but NumberOfPoints asks for {end}");
            return Err(refused(message));
        }
        dataset.check_rows(rows)?;
        let mut points: Vec<Vector> = Vec::with_capacity(n);
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

    fn read_arrays(&self, mesh: &mut Mesh, notes: &mut Notes) -> Result<()> {
        mesh.point_arrays = read_all(self.point_arrays(notes)?, notes)?;
        mesh.cell_arrays = read_all(self.cell_arrays(notes)?, notes)?;
        mesh.field_arrays = self.fields(notes)?;
        Ok(())
    }

    fn point_arrays(&self, notes: &mut Notes) -> Result<Vec<ArrayRows>> {
        self.arrays("Point", "point", &self.points, notes)
    }

    fn cell_arrays(&self, notes: &mut Notes) -> Result<Vec<ArrayRows>> {
        self.arrays("Cell", "cell", &self.cells, notes)
    }

    /// The arrays in `PointData` or `CellData`. One that is longer than the whole grid is left out, with a note.
    fn arrays(
        &self,
        of: &str,
        what: &'static str,
        rows: &Range<u64>,
        notes: &mut Notes,
    ) -> Result<Vec<ArrayRows>> {
        let group_name = format!("{of}Data");
        let Some(group) = self.grid.group(&group_name)? else {
            return Ok(Vec::new());
        };
        let offsets = format!("{of}DataOffsets");
        let mut arrays = Vec::new();
        for dataset in group.datasets()? {
            let (name, n) = (dataset.name(), dataset.n_rows());
            if !self.extent.has_steps() && n > rows.end {
                notes.push(too_long(what, name));
                continue;
            }
            let of_grid = self.extent.array_rows(&offsets, name, rows)?;
            if n < of_grid.end {
                let (found, needed) = (counted(n as usize, "row"), of_grid.end);
                let message = format!("it has {found}; it must have {needed}, one for each {what}");
                return Err(Error::input(message).dataset(&format!("{group_name}/{name}")));
            }
            arrays.push((dataset, of_grid));
        }
        Ok(arrays)
    }

    fn fields(&self, notes: &mut Notes) -> Result<Vec<DataArray>> {
        let Some(group) = self.grid.group("FieldData")? else {
            return Ok(Vec::new());
        };
        let datasets = group.datasets()?.into_iter();
        let arrays = datasets.map(|dataset| {
            let rows = self.extent.field_rows(&dataset)?;
            read_array(&dataset, rows, notes)
        });
        arrays.collect()
    }

    /// Notes groups that are not read.
    fn note_others(&self, notes: &mut Notes) -> Result<()> {
        let names = self.grid.names()?.0;
        let is_known = |name: &String| {
            ["PointData", "CellData", "FieldData", "Steps"].contains(&name.as_str())
        };
        let others = names.into_iter().filter(|name| !is_known(name));
        notes.extend(others.map(|name| note!("name_not_kept", "the group \"{name}\" is not kept")));
        Ok(())
    }
}

fn read_all(arrays: Vec<ArrayRows>, notes: &mut Notes) -> Result<Vec<DataArray>> {
    let arrays = arrays.into_iter();
    arrays
        .map(|(dataset, rows)| read_array(&dataset, rows, notes))
        .collect()
}

fn read_array(dataset: &Dataset, rows: Range<u64>, notes: &mut Notes) -> Result<DataArray> {
    let n_components = n_components(dataset, &rows)?;
    let values = dataset.rows(rows)?;
    dataset.note_latin1(notes);
    Ok(DataArray::tuples(dataset.name(), n_components, values))
}

/// The components of an array, which must have these rows.
fn n_components(dataset: &Dataset, rows: &Range<u64>) -> Result<usize> {
    dataset.check_rows(rows)?;
    match dataset.row()? {
        0 => Err(Error::input("its tuples have no values").dataset(dataset.name())),
        n => Ok(n),
    }
}

impl Reader {
    /// Refuses a mesh that is not read by slabs. Finds all that a reader of the whole refuses or notes, except damaged chunks:
    /// the values of arrays are not read.
    pub fn check_slabs(&self) -> Found<()> {
        if cells::count(&self.points)? == 0 || cells::count(&self.cells)? == 0 {
            return Err(whole("it has no nodes or no cells"));
        }
        let mut faces = self
            .extent
            .parts
            .iter()
            .filter_map(|part| part.faces.as_ref());
        if faces.any(|faces| !faces.of_cells.is_empty()) {
            return Err(whole("it has polyhedra"));
        }
        let wedge = CellKind::Wedge.vtk();
        if !self.has_marked_wedges()? && self.any_types(|_, types| Ok(types.contains(&wedge)))? {
            return Err(whole(
                "all volumes say which order of nodes its wedges have",
            ));
        }
        self.check_fields()?;
        let mut notes = Notes::default();
        let of_points = self.point_arrays(&mut notes)?;
        let of_cells = self.cell_arrays(&mut notes)?;
        self.note_others(&mut notes)?;
        if !notes.is_empty() {
            return Err(whole("it has what is not kept"));
        }
        for (array, rows) in of_points.iter().chain(&of_cells) {
            if ghosts::is_mark(array.name()) {
                return Err(whole("it may have ghost cells"));
            }
            n_components(array, rows)?;
            if !array.is_of_numbers() {
                return Err(whole("it has text at nodes or cells"));
            }
            if array.whole_chunks(1) == 1 && !rows.is_empty() {
                // An array that is not in chunks may be behind the end of a file that is damaged.
                array.rows(rows.start..rows.start + 1)?;
                array.rows(rows.end - 1..rows.end)?;
            }
        }
        self.check_tags(&of_cells)
    }

    /// Checks if VTK's types of any window of cells, with the index of the first, meet a condition.
    fn any_types(&self, mut is_met: impl FnMut(u64, &[u8]) -> Result<bool>) -> Result<bool> {
        let step = column(&self.grid, "Types")?.whole_chunks(WINDOW);
        for start in self.cells.clone().step_by(step as usize) {
            let rows = start..self.cells.end.min(start + step);
            if is_met(start - self.cells.start, &cells::types(&self.grid, &rows)?)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Refuses field arrays for which the whole has to be read.
    fn check_fields(&self) -> Found<()> {
        let mut notes = Notes::default();
        let fields = Mesh {
            field_arrays: self.fields(&mut notes)?,
            ..Mesh::default()
        };
        fields.validate()?;
        notes.close();
        if fields.field_arrays.iter().any(has_shared_names) {
            return Err(whole("tags share a name"));
        }
        if !notes.is_empty() {
            return Err(whole("it has text of Latin-1"));
        }
        Ok(())
    }

    /// Refuses an array of boundary tags for which the whole has to be read.
    fn check_tags(&self, arrays: &[ArrayRows]) -> Found<()> {
        let chosen = self.tag_array.as_deref();
        let name = chosen.unwrap_or(tags::BOUNDARY.array);
        let named = arrays.iter().find(|(array, _)| array.name() == name);
        let is_one = |array: &Dataset| array.is_of_integers() && array.row().is_ok_and(|n| n == 1);
        match (named.filter(|(array, _)| is_one(array)), chosen) {
            (None, Some(_)) => Err(whole("the array of its tags is not one")),
            (Some((array, rows)), None) if !self.is_no_surface(array, rows.start)? => {
                Err(whole("it may be the surface of a solid"))
            }
            _ => Ok(()),
        }
    }

    /// Checks if cells and boundary tags show that the mesh is no surface in space that bounds a solid ([`Mesh::space`]): by a
    /// solid cell, an edge that has a tag, or no cell that is two-dimensional.
    fn is_no_surface(&self, tags: &Dataset, first_tag: u64) -> Result<bool> {
        let mut has_faces = false;
        let is_shown = self.any_types(|first, types| {
            let dimension = |vtk: &u8| split::kind(*vtk).map_or(0, |kind| kind.dimension());
            let dimensions: Vec<u8> = types.iter().map(dimension).collect();
            if dimensions.contains(&3) {
                return Ok(true);
            }
            has_faces |= dimensions.contains(&2);
            if !dimensions.contains(&1) {
                return Ok(false);
            }
            let start = first_tag + first;
            let numbers = tags.rows(start..start + types.len() as u64)?.to_integers();
            let mut numbers = numbers.iter().flatten().zip(&dimensions);
            Ok(numbers.any(|(number, dimension)| *number != 0 && *dimension == 1))
        })?;
        Ok(is_shown || !has_faces)
    }
}

/// Checks if these are names of groups, with some equal.
fn has_shared_names(array: &DataArray) -> bool {
    let mut labels = [tags::BOUNDARY, tags::ZONE, tags::LOWER].into_iter();
    let Values::Text(names) = &array.values else {
        return false;
    };
    let mut seen = BTreeSet::new();
    let mut names = names.iter().filter(|name| !name.is_empty());
    labels.any(|labels| labels.names == array.name) && !names.all(|name| seen.insert(name))
}

/// Rows of some nodes or cells.
fn slab(of: &Range<u64>, items: Range<usize>) -> Range<u64> {
    of.start + items.start as u64..of.start + items.end as u64
}

impl Slabs for Reader {
    fn n_nodes(&self) -> usize {
        (self.points.end - self.points.start) as usize
    }

    fn n_cells(&self) -> usize {
        (self.cells.end - self.cells.start) as usize
    }

    fn points(&self, nodes: Range<usize>) -> Result<Vec<Vector>> {
        placed(self.points_at(&slab(&self.points, nodes)))
    }

    fn cells(&self, cells: Range<usize>) -> Result<Cells> {
        let rows = slab(&self.cells, cells);
        let parts = self.extent.parts.iter();
        let parts = parts.map(|part| cells::cut(&self.grid, part, &rows));
        let mut notes = Notes::default();
        let built = parts
            .collect::<Result<Vec<_>>>()
            .and_then(|parts| cells::read(&self.grid, &parts, &rows, &mut notes));
        let mut built = placed(built)?;
        if built.origin.is_some() || !notes.is_empty() {
            let message = "it has cells that are split or left out";
            return placed(Err(Error::input(message)));
        }
        built.cells.mirror_wedges();
        Ok(built.cells)
    }

    fn complete(&self, mesh: &mut Mesh, notes: &mut Notes) -> Found<()> {
        self.read_arrays(mesh, notes)?;
        Ok(tags::extract(mesh, self.tag_array.as_deref())?)
    }
}

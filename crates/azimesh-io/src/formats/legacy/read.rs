//! A legacy file as a mesh: which grid it holds, and its parts in whatever order.

use super::super::tokens::{line_of, shown};
use super::super::vtk::cells::{Built, CellTable};
use super::super::vtk::list::List;
use super::super::vtk::polyhedra::PieceNodes;
use super::super::vtk::split::polygonal;
use super::super::vtk::structured::Grid;
use super::super::vtk::{ghosts, order, structured, tags};
use super::attributes::{Section, metadata};
use super::cursor::Cursor;
use super::values::{self, Type};
use crate::formats::notes::blanking;
use crate::formats::{Notes, ReadOptions};
use crate::mesh::arrays::select_tuples;
use crate::mesh::{Cells, DataArray, Mesh};
use azimesh_core::error::{Error, Position, Result};

/// Files of this version on have hexahedra of high order in VTK's present order of nodes.
const FIRST_WITH_PRESENT_ORDER: (u32, u32) = (5, 1);

pub(super) fn read(bytes: &[u8], options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let mut cursor = Cursor::open(bytes)?;
    let file = parts(&mut cursor, notes).and_then(|file| file.mesh(&cursor, notes));
    // Errors of all parts together are placed at the end of the last one.
    let mut mesh = file.map_err(|error| {
        if cursor.binary {
            error.byte(cursor.at as u64)
        } else {
            error.line(line_of(bytes, cursor.at.saturating_sub(1)))
        }
    })?;
    if cursor.version < FIRST_WITH_PRESENT_ORDER {
        order::swap(&mut mesh, notes);
    }
    ghosts::leave_out([&mut mesh], notes);
    let is_marked = cursor.title == order::TITLE.as_bytes();
    order::turn_wedges(&mut mesh, is_marked, notes);
    tags::extract(&mut mesh, options.tag_array.as_deref())?;
    Ok(mesh)
}

/// Reads every part of the file.
fn parts(cursor: &mut Cursor, notes: &mut Notes) -> Result<File> {
    let mut file = File {
        grid: grid(cursor)?,
        ..File::default()
    };
    while let Some(keyword) = cursor.keyword() {
        let at = cursor.at.saturating_sub(1);
        file.part(&keyword, cursor, notes)?;
        file.last = (keyword.to_ascii_uppercase(), at);
    }
    Ok(file)
}

/// VTK's names of the grids.
const GRIDS: [&str; 5] = [
    "UNSTRUCTURED_GRID",
    "POLYDATA",
    "STRUCTURED_GRID",
    "RECTILINEAR_GRID",
    "STRUCTURED_POINTS",
];

fn grid(cursor: &mut Cursor) -> Result<Grid> {
    match cursor.keyword().as_deref() {
        Some("dataset") => {}
        Some("field") => {
            let message = "the file has a field but no grid; it must have a DATASET";
            return Err(cursor.error(message));
        }
        _ => return Err(cursor.error("DATASET must follow the header")),
    }
    let name = cursor.need("the kind of the dataset")?;
    let grid = std::str::from_utf8(name).ok();
    let grid = grid.and_then(|name| Grid::named(name, GRIDS));
    grid.ok_or_else(|| {
        let (found, known) = (shown(name), GRIDS.join(", "));
        cursor.error(format!(
            "the dataset {found} is not read; those that are: {known}"
        ))
    })
}

/// The parts of the file that have been read.
#[derive(Default)]
struct File {
    grid: Grid,
    points: Vec<[f64; 3]>,
    dimensions: Option<[usize; 3]>,
    /// Coordinates along each axis; of an image origin and spacing.
    axes: [Vec<f64>; 3],
    origin: [f64; 3],
    spacing: Option<[f64; 3]>,
    cells: List,
    types: Option<Vec<u8>>,
    /// Vertices, lines, polygons, strips: the order of polygonal data.
    lists: [List; 4],
    /// Position of each list, then unstructured cells and their types.
    places: [usize; 6],
    /// The last keyword, and its position.
    last: (String, usize),
    /// Items whose arrays are being read: 0 of the whole, 1 at points, 2 of cells.
    items: usize,
    n_tuples: usize,
    arrays: [Vec<DataArray>; 3],
}

impl File {
    /// Reads what follows a keyword.
    fn part(&mut self, keyword: &str, cursor: &mut Cursor, notes: &mut Notes) -> Result<()> {
        const LISTS: [&str; 4] = ["vertices", "lines", "polygons", "triangle_strips"];
        match keyword {
            "points" => {
                let n = cursor.count("a number of points")?;
                values::check_count(cursor, n, "points")?;
                let kind = Type::read(cursor)?;
                self.points = values::points(cursor, kind, n)?;
            }
            "cells" => {
                self.places[4] = cursor.at;
                self.cells = values::list(cursor)?;
            }
            "cell_types" => {
                self.places[5] = cursor.at;
                self.types = Some(values::types(cursor)?);
            }
            "dimensions" => {
                let mut next = || cursor.count("a dimension");
                self.dimensions = Some([next()?, next()?, next()?]);
            }
            "origin" => self.origin = vector(cursor)?,
            "spacing" | "aspect_ratio" => self.spacing = Some(vector(cursor)?),
            "x_coordinates" => self.axes[0] = axis(cursor)?,
            "y_coordinates" => self.axes[1] = axis(cursor)?,
            "z_coordinates" => self.axes[2] = axis(cursor)?,
            "blanking" => {
                let n = cursor.count("a number of points")?;
                let kind = Type::read(cursor)?;
                values::read(cursor, kind, n, notes)?;
                notes.push(blanking());
            }
            "point_data" | "cell_data" => {
                self.n_tuples = cursor.count("a number of tuples")?;
                self.items = if keyword == "point_data" { 1 } else { 2 };
                self.check_tuples(cursor)?;
            }
            "metadata" => {
                let arrays = Some(&mut self.arrays[self.items]).filter(|_| self.items > 0);
                metadata(cursor, arrays.and_then(|arrays| arrays.last_mut()), notes);
            }
            _ => match LISTS.iter().position(|list| *list == keyword) {
                Some(list) => {
                    self.places[list] = cursor.at;
                    self.lists[list] = values::list(cursor)?;
                }
                None => return self.arrays(keyword, cursor, notes),
            },
        }
        Ok(())
    }

    fn arrays(&mut self, keyword: &str, cursor: &mut Cursor, notes: &mut Notes) -> Result<()> {
        let has_items = self.items > 0;
        let mut section = Section {
            what: ["field", "point", "cell"][self.items],
            n_tuples: has_items.then_some(self.n_tuples),
            arrays: &mut self.arrays[self.items],
        };
        let known =
            (has_items || keyword == "field") && section.attribute(keyword, cursor, notes)?;
        if known {
            return Ok(());
        }
        let found = shown(keyword.as_bytes());
        let (last, at) = &self.last;
        if !cursor.binary && keyword.parse::<f64>().is_ok() {
            let message =
                format!("{last} has more values than its counts say: {found} comes after them");
            return Err(cursor.error_at(*at, message));
        }
        Err(cursor.error(format!("the keyword {found} is not known here")))
    }

    fn n_points(&self) -> Result<usize> {
        match (self.grid, self.dimensions) {
            (Grid::Image | Grid::Rectilinear, Some(dimensions)) => structured::n_points(dimensions),
            _ => Ok(self.points.len()),
        }
    }

    fn n_cells(&self) -> usize {
        match (self.grid, self.dimensions) {
            (Grid::Unstructured, _) => self.cells.n_cells(),
            (Grid::Poly, _) => self.lists.iter().map(List::n_cells).sum(),
            (_, dimensions) => dimensions.map_or(0, structured::n_cells),
        }
    }

    fn check_tuples(&self, cursor: &Cursor) -> Result<()> {
        let (n, what) = match self.items {
            1 => (self.n_points()?, "points"),
            _ => (self.n_cells(), "cells"),
        };
        if n != self.n_tuples {
            let found = self.n_tuples;
            return Err(cursor.error(format!(
                "the data are for {found} {what}, but there are {n}"
            )));
        }
        Ok(())
    }

    fn mesh(self, cursor: &Cursor, notes: &mut Notes) -> Result<Mesh> {
        match self.grid {
            Grid::Unstructured | Grid::Poly => self.unstructured(cursor, notes),
            Grid::Structured => self.structured(),
            Grid::Rectilinear | Grid::Image => self.block(cursor),
        }
    }

    fn unstructured(mut self, cursor: &Cursor, notes: &mut Notes) -> Result<Mesh> {
        let (base, limit) = (0, self.points.len() as u64);
        let nodes = PieceNodes { base, limit };
        let mut table = CellTable::new("CELL_TYPES");
        if self.grid == Grid::Poly {
            for (list, which) in std::mem::take(&mut self.lists).into_iter().zip(0..) {
                let at = self.places[which];
                list.append(&mut table, nodes, |_, n| polygonal(which, n))
                    .map_err(|error| place(error, cursor, at))?;
            }
        } else {
            let types = self.types.take().unwrap_or_default();
            let at = self.places[4];
            if types.len() != self.cells.n_cells() {
                let (found, n) = (types.len(), self.cells.n_cells());
                let message = format!("CELL_TYPES has {found} types for {n} cells");
                return Err(cursor.error_at(at, message));
            }
            std::mem::take(&mut self.cells)
                .append(&mut table, nodes, |cell, _| types[cell])
                .map_err(|error| match &error.position {
                    Some(Position::Dataset(name)) if name == "CELL_TYPES" => {
                        place(error, cursor, self.places[5])
                    }
                    _ => place(error, cursor, at),
                })?;
        }
        let built = table.finish(notes);
        let Built { cells, origin } = built.map_err(|error| Error::input(error.message))?;
        if let Some(origin) = origin {
            select_tuples(&mut self.arrays[2], &origin);
        }
        let points = std::mem::take(&mut self.points);
        Ok(self.with(points, cells))
    }

    /// The mesh of these nodes and cells, with the arrays of the file.
    fn with(self, points: Vec<[f64; 3]>, cells: Cells) -> Mesh {
        let [field_arrays, point_arrays, cell_arrays] = self.arrays;
        Mesh {
            points,
            cells,
            point_arrays,
            cell_arrays,
            field_arrays,
            ..Mesh::default()
        }
    }

    fn needed_dimensions(&self) -> Result<[usize; 3]> {
        self.dimensions
            .ok_or_else(|| Error::input("the DIMENSIONS of the grid are missing"))
    }

    fn structured(mut self) -> Result<Mesh> {
        let dimensions = self.needed_dimensions()?;
        let (n, found) = (structured::n_points(dimensions)?, self.points.len());
        if n != found {
            let message = format!("the DIMENSIONS give {n} points, but there are {found}");
            return Err(Error::input(message));
        }
        let points = std::mem::take(&mut self.points);
        Ok(self.with(points, structured::cells(dimensions, 0)))
    }

    /// A block whose nodes follow from coordinates along its axes.
    fn block(mut self, cursor: &Cursor) -> Result<Mesh> {
        let dimensions = self.needed_dimensions()?;
        let n_points = structured::n_points(dimensions)?;
        structured::check_implied(n_points, cursor.bytes.len())?;
        let mut axes = std::mem::take(&mut self.axes);
        for (i, axis) in axes.iter_mut().enumerate() {
            let (n, name) = (dimensions[i], ["X", "Y", "Z"][i]);
            if self.grid == Grid::Image {
                let spacing = self.spacing.unwrap_or([1.0; 3])[i];
                let along = (0..n).map(|k| self.origin[i] + k as f64 * spacing);
                *axis = along.collect();
            } else if axis.len() != n {
                let found = axis.len();
                return Err(Error::input(format!(
                    "{name}_COORDINATES has {found} values, but the dimension is {n}"
                )));
            }
        }
        let points = structured::points([&axes[0], &axes[1], &axes[2]]);
        Ok(self.with(points, structured::cells(dimensions, 0)))
    }
}

fn place(error: Error, cursor: &Cursor, at: usize) -> Error {
    cursor.error_at(at, error.message)
}

fn vector(cursor: &mut Cursor) -> Result<[f64; 3]> {
    let mut next = || cursor.real("a coordinate");
    Ok([next()?, next()?, next()?])
}

fn axis(cursor: &mut Cursor) -> Result<Vec<f64>> {
    let n = cursor.count("a number of coordinates")?;
    let kind = Type::read(cursor)?;
    values::coordinates(cursor, kind, n)
}

//! Content of a VTK XML file: the grid, and the arrays of its pieces.

use super::super::names::tell_apart;
use super::super::vtk::order::{OUTWARD, WEDGES};
use super::super::vtk::structured::Grid;
use super::super::{Compression, Notes, ReadOptions};
use super::xml::{Array, Layout, Parser, as_utf8};
use azimesh_core::error::Result;
use quick_xml::events::BytesStart;

/// VTK's names of the grids.
const GRIDS: [&str; 5] = [
    "UnstructuredGrid",
    "PolyData",
    "StructuredGrid",
    "RectilinearGrid",
    "ImageData",
];

pub(super) struct Document<'a> {
    pub grid: Grid,
    /// Version of the file, major and minor.
    pub version: (u32, u32),
    /// True if wedges are marked to be in the order of VTK up to 9.6.
    pub has_marked_wedges: bool,
    pub layout: Layout,
    /// Of an image: its first node, the distance between nodes, its axes as rows of a matrix.
    pub origin: [f64; 3],
    pub spacing: [f64; 3],
    pub direction: Option<[f64; 9]>,
    /// Times of the steps; none where the file has one mesh.
    pub times: Vec<f64>,
    /// Arrays of the mesh as a whole.
    pub field_data: Vec<Array<'a>>,
    pub pieces: Vec<Piece<'a>>,
}

/// One piece of the mesh, which shares no nodes with the others.
#[derive(Default)]
pub(super) struct Piece<'a> {
    pub n_points: u64,
    pub n_cells: u64,
    /// First and last node along each axis, of a structured grid.
    pub extent: Option<[i64; 6]>,
    pub points: Vec<Array<'a>>,
    /// Cells, or the coordinates along the axes.
    pub cells: Vec<Array<'a>>,
    /// Vertices, lines, polygons and strips of polygonal data.
    pub lists: [(u64, Vec<Array<'a>>); 4],
    pub point_data: Vec<Array<'a>>,
    pub cell_data: Vec<Array<'a>>,
    /// Name of the array with the number of each node in a mesh of several files.
    pub global_nodes: Option<String>,
    /// Name of the array with the number of each cell in a mesh of several files.
    pub global_cells: Option<String>,
}

impl Document<'_> {
    /// Leaves out the arrays of all steps but one, by default the last, and pieces whose arrays are all of other steps. VTK
    /// writes arrays in place as if all were of step 0, with pieces of their own for each step.
    pub fn keep_step(&mut self, step: Option<usize>) -> Result<()> {
        let n = self.times.len();
        let options = ReadOptions {
            step,
            ..ReadOptions::default()
        };
        let Some(step) = options.step_of(n)? else {
            return Ok(());
        };
        let is_of_step = |array: &Array| array.steps.is_empty() || array.steps.contains(&step);
        let all = self.pieces.iter_mut().flat_map(Piece::arrays).flatten();
        if all.flat_map(|array| &array.steps).all(|step| *step == 0) {
            if self.pieces.len().is_multiple_of(n) {
                let n_pieces = self.pieces.len() / n;
                self.pieces.truncate((step + 1) * n_pieces);
                self.pieces.drain(..step * n_pieces);
            }
            return Ok(());
        }
        self.pieces.retain_mut(|piece| {
            let (mut had_any, mut has_any) = (false, false);
            for arrays in piece.arrays() {
                had_any |= !arrays.is_empty();
                arrays.retain(is_of_step);
                has_any |= !arrays.is_empty();
            }
            has_any || !had_any
        });
        self.field_data.retain(is_of_step);
        Ok(())
    }

    /// Gives arrays of one name in one place different names, in every piece the same.
    pub fn tell_arrays_apart(&mut self, notes: &mut Notes) {
        let fields = self.field_data.iter_mut();
        tell_apart("field", fields.map(|array| &mut array.name), notes);
        for piece in &mut self.pieces {
            for (what, arrays) in [
                ("point", &mut piece.point_data),
                ("cell", &mut piece.cell_data),
            ] {
                tell_apart(what, arrays.iter_mut().map(|array| &mut array.name), notes);
            }
        }
    }
}

impl<'a> Piece<'a> {
    fn arrays(&mut self) -> impl Iterator<Item = &mut Vec<Array<'a>>> {
        let lists = self.lists.iter_mut().map(|(_, arrays)| arrays);
        lists.chain([
            &mut self.points,
            &mut self.cells,
            &mut self.point_data,
            &mut self.cell_data,
        ])
    }
}

/// Times of the steps of a file, which its first element gives.
pub(super) fn times(bytes: &[u8]) -> Result<Vec<f64>> {
    const HEAD: usize = 4096;
    let head = &bytes[..bytes.len().min(HEAD)];
    if memchr::memmem::find(head, b"TimeValues").is_none() {
        return Ok(Vec::new());
    }
    let bytes = as_utf8(bytes, &mut Notes::default());
    parse(&bytes).map(|document| document.times)
}

pub(super) fn parse(bytes: &[u8]) -> Result<Document<'_>> {
    let mut parser = Parser::open(bytes)?;
    let root = parser.root()?;
    let kind = parser.attribute(&root, "type")?.unwrap_or_default();
    if kind == "Collection" {
        return Err(
            parser.error("a .pvd lists the meshes of a sequence; give the file of one of them")
        );
    }
    let grid = Grid::named(&kind, GRIDS).filter(|_| GRIDS.contains(&&*kind));
    let grid = grid.ok_or_else(|| {
        parser.error(format!(
            "the file has the VTK type {kind}; those that are read: {}, and PUnstructuredGrid (.pvtu)",
            GRIDS.join(", ")
        ))
    })?;
    let mut document = Document {
        grid,
        version: parser.version(&root)?,
        has_marked_wedges: parser.attribute(&root, WEDGES)?.as_deref() == Some(OUTWARD),
        layout: parser.read_layout(&root)?,
        origin: [0.0; 3],
        spacing: [1.0; 3],
        direction: None,
        times: Vec::new(),
        field_data: Vec::new(),
        pieces: Vec::new(),
    };
    parser.layout = document.layout;
    let mut found = false;
    parser.each("VTKFile", |parser, name, element| {
        let is_grid = name == kind;
        if is_grid {
            found = true;
            parser.grid(element, name, &mut document)?;
        }
        Ok(is_grid)
    })?;
    if found {
        return Ok(document);
    }
    Err(parser.error(format!("there is no element {kind}")))
}

impl<'a> Parser<'a> {
    fn version(&self, root: &BytesStart) -> Result<(u32, u32)> {
        let version = self.attribute(root, "version")?.unwrap_or_default();
        let mut numbers = version.trim().split('.').map(|n| n.parse().unwrap_or(0));
        Ok((numbers.next().unwrap_or(0), numbers.next().unwrap_or(0)))
    }

    fn read_layout(&self, root: &BytesStart) -> Result<Layout> {
        let unknown =
            |name, value: &str| Err(self.error(format!("{name} \"{value}\" is not known")));
        Ok(Layout {
            big_endian: match self.attribute(root, "byte_order")?.as_deref() {
                Some("BigEndian") => true,
                Some("LittleEndian") | None => false,
                Some(other) => return unknown("byte_order", other),
            },
            header_bytes: match self.attribute(root, "header_type")?.as_deref() {
                Some("UInt32") | None => 4,
                Some("UInt64") => 8,
                Some(other) => return unknown("header_type", other),
            },
            compression: match self.attribute(root, "compressor")?.as_deref() {
                None | Some("") => Compression::None,
                Some("vtkZLibDataCompressor") => Compression::Zlib,
                Some("vtkLZ4DataCompressor") => Compression::Lz4,
                Some("vtkLZMADataCompressor") => Compression::Lzma,
                Some(other) => return unknown("compressor", other),
            },
        })
    }

    fn grid(
        &mut self,
        element: &BytesStart,
        name: &str,
        document: &mut Document<'a>,
    ) -> Result<()> {
        document.origin = self.numbers(element, "Origin")?.unwrap_or([0.0; 3]);
        document.spacing = self.numbers(element, "Spacing")?.unwrap_or([1.0; 3]);
        document.direction = self.numbers(element, "Direction")?;
        document.times = self.list(element, "TimeValues")?;
        self.each(name, |parser, name, element| {
            match name {
                "FieldData" => document.field_data.extend(parser.arrays(name)?),
                "Piece" => document.pieces.push(parser.piece(element)?),
                _ => return Ok(false),
            }
            Ok(true)
        })
    }

    fn piece(&mut self, element: &BytesStart) -> Result<Piece<'a>> {
        const LISTS: [&str; 4] = ["Verts", "Lines", "Polys", "Strips"];
        let mut piece = Piece {
            n_points: self.count(element, "NumberOfPoints")?.unwrap_or(0),
            n_cells: self.count(element, "NumberOfCells")?.unwrap_or(0),
            extent: self.numbers(element, "Extent")?,
            ..Piece::default()
        };
        for (list, name) in piece.lists.iter_mut().zip(LISTS) {
            list.0 = self
                .count(element, &format!("NumberOf{name}"))?
                .unwrap_or(0);
        }
        self.each("Piece", |parser, name, element| {
            match name {
                "Points" => {
                    piece.points.extend(parser.arrays(name)?);
                    // Errors name the array, whatever the file calls it.
                    let arrays = piece.points.iter_mut();
                    arrays.for_each(|array| array.name = name.into());
                }
                "Cells" | "Coordinates" => piece.cells.extend(parser.arrays(name)?),
                "PointData" => {
                    piece.global_nodes = parser.attribute(element, "GlobalIds")?;
                    piece.point_data.extend(parser.arrays(name)?);
                }
                "CellData" => {
                    piece.global_cells = parser.attribute(element, "GlobalIds")?;
                    piece.cell_data.extend(parser.arrays(name)?);
                }
                _ => match LISTS.iter().position(|list| *list == name) {
                    Some(list) => piece.lists[list].1.extend(parser.arrays(name)?),
                    None => return Ok(false),
                },
            }
            Ok(true)
        })?;
        Ok(piece)
    }

    /// An attribute that is a list of `N` numbers.
    fn numbers<T: std::str::FromStr + Copy, const N: usize>(
        &self,
        element: &BytesStart,
        name: &str,
    ) -> Result<Option<[T; N]>> {
        let numbers = self.list(element, name)?;
        if numbers.is_empty() {
            return Ok(None);
        }
        let wrong = |numbers: Vec<T>| {
            let found = numbers.len();
            self.error(format!("{name} has {found} numbers; it must have {N}"))
        };
        numbers.try_into().map(Some).map_err(wrong)
    }
}

//! Meshes of azimesh to and from the model of the crate [`vtkio`], for programs that use it.
//!
//! Owns: the unstructured grid of that model for a mesh, and the mesh for a grid, also of several pieces.
//! The model has no field data and no strings: names of tags are not kept; their numbers are, in the cell
//! arrays of the VTK formats. A polyhedron has its face stream in place of its nodes, as in legacy files. A
//! note names each thing that is not kept.
//!
//! Leaves to others: meshes, and VTK files of every kind (`azimesh-io`, which needs no vtkio); reading and
//! writing of the model (`vtkio`). The project's tests use this crate as a second reader of what is written.
//!
//! ```text
//!               ── to_vtkio ────>
//! Mesh, MeshView                  vtkio::model::Vtk (UnstructuredGrid)     Notes: losses in either direction
//!               <── from_vtkio ──
//! ```
//!
//! ```
//! use azimesh_io::{CellKind, Cells, Mesh, Notes, ReadOptions};
//! use azimesh_vtkio::{from_vtkio, to_vtkio};
//!
//! # fn main() -> azimesh_io::Result<()> {
//! let mut cells = Cells::new();
//! cells.push(CellKind::Quadrilateral, &[0, 1, 2, 3]);
//! cells.push(CellKind::Line, &[0, 1]);
//! let points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
//! let mut mesh = Mesh::new(points, cells)?;
//! mesh.add_tag("wall", [1])?;
//!
//! let mut notes = Notes::default(); // of what is not kept
//! let model = to_vtkio(&mesh.view(), &mut notes)?;
//! let back = from_vtkio(&model, &ReadOptions::default(), &mut notes)?;
//! assert_eq!(back.points(), mesh.points());
//! assert_eq!(back.cells(), mesh.cells());
//! assert_eq!(back.tags().next().map(|tag| tag.name.as_str()), Some("1")); // a number, no name
//! # Ok(())
//! # }
//! ```

use ::vtkio::model;
use azimesh_core::error::{Error, Result};
use azimesh_core::note;
use azimesh_io::formats::column::Column;
use azimesh_io::formats::pvtu::merge::{self, Piece};
use azimesh_io::formats::vtk::arrays::VtkArrays;
use azimesh_io::formats::vtk::cells::{Built, CellTable};
use azimesh_io::formats::vtk::list::List;
use azimesh_io::formats::vtk::number::Element;
use azimesh_io::formats::vtk::polyhedra::PieceNodes;
use azimesh_io::formats::vtk::{order, tags};
use azimesh_io::formats::vtu::NAMES;
use azimesh_io::formats::{Notes, ReadOptions, WriteOptions};
use azimesh_io::mesh::{CellKind, Cells, DataArray, Mesh, MeshView, Values};
use std::borrow::Cow;

pub use ::vtkio;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// The mesh as an unstructured grid of vtkio's model; a note for each thing that it cannot hold.
pub fn to_vtkio(mesh: &MeshView, notes: &mut Notes) -> Result<model::Vtk> {
    if !mesh.field_arrays.is_empty() {
        let names = mesh.field_arrays.iter();
        let names: Vec<String> = names.map(|array| format!("\"{}\"", array.name)).collect();
        let names = names.join(", ");
        notes.push(note!(
            "arrays_left_out",
            "vtkio holds no field arrays; left out: {names}"
        ));
    }
    let options = WriteOptions {
        tag_names: false,
        ..WriteOptions::default()
    };
    let plan = VtkArrays::new(mesh, &options, &NAMES);
    notes.extend(plan.notes.iter().cloned());
    let sections = plan.sections();
    let attributes = |arrays: &[Column]| -> Result<Vec<model::Attribute>> {
        arrays.iter().map(attribute).collect()
    };
    let piece = model::UnstructuredGridPiece {
        points: model::IOBuffer::F64(mesh.points.as_flattened().to_vec()),
        cells: cells(&in_vtk_order(mesh.cells), &plan.repeated)?,
        data: model::Attributes {
            point: attributes(&sections.point_data)?,
            cell: attributes(&sections.cell_data)?,
        },
    };
    Ok(model::Vtk {
        version: model::Version::Auto,
        title: if order::has_wedges(mesh.cells) {
            order::TITLE.into()
        } else {
            "written by azimesh".into()
        },
        // Legacy files are big-endian.
        byte_order: model::ByteOrder::BigEndian,
        data: model::DataSet::inline(piece),
        file_path: None,
    })
}

fn attribute(column: &Column) -> Result<model::Attribute> {
    let mut bytes = Vec::with_capacity(column.n_bytes());
    column.for_each(&mut |some| {
        bytes.extend_from_slice(some);
        Ok(())
    })?;
    macro_rules! buffer {
        ($($element:ident => $variant:ident),*) => {
            match column.element {
                $(Element::$element => {
                    model::IOBuffer::$variant(bytemuck::pod_collect_to_vec(&bytes))
                })*
                Element::String => return Err(Error::input("vtkio holds no strings").dataset(column.name)),
            }
        };
    }
    let data = buffer!(
        Int8 => I8, UInt8 => U8, Int16 => I16, UInt16 => U16, Int32 => I32, UInt32 => U32,
        Int64 => I64, UInt64 => U64, Float32 => F32, Float64 => F64
    );
    Ok(model::Attribute::DataArray(model::DataArray {
        name: column.name.to_owned(),
        elem: model::ElementType::Generic(column.n_components as u32),
        data,
    }))
}

fn in_vtk_order(cells: &Cells) -> Cow<'_, Cells> {
    let mut cells = Cow::Borrowed(cells);
    if order::has_wedges(&cells) {
        cells.to_mut().mirror_wedges();
    }
    cells
}

/// Cells, and after them those that are repeated for their second tag.
fn cells(cells: &Cells, repeated: &[usize]) -> Result<model::Cells> {
    let all = || {
        cells
            .iter()
            .chain(repeated.iter().map(|cell| cells.get(*cell)))
    };
    let mut types = Vec::with_capacity(cells.len() + repeated.len());
    for cell in all() {
        types.push(cell_type(cell.kind)?);
    }
    if cells.has_polyhedra() {
        let mut vertices = Vec::new();
        for cell in all() {
            let entries = cells.face_stream(cell.index).unwrap_or(cell.nodes);
            vertices.push(entries.len() as u32);
            vertices.extend_from_slice(entries);
        }
        let num_cells = types.len() as u32;
        let cell_verts = model::VertexNumbers::Legacy {
            num_cells,
            vertices,
        };
        return Ok(model::Cells { cell_verts, types });
    }
    let mut connectivity = Vec::with_capacity(cells.connectivity().len());
    let mut offsets = Vec::with_capacity(types.len());
    for cell in all() {
        connectivity.extend(cell.nodes.iter().map(|node| u64::from(*node)));
        offsets.push(connectivity.len() as u64);
    }
    let cell_verts = model::VertexNumbers::XML {
        connectivity,
        offsets,
    };
    Ok(model::Cells { cell_verts, types })
}

/// The cell types of vtkio, by VTK's number.
const TYPES: [model::CellType; 59] = {
    use model::CellType::*;
    [
        Vertex,
        PolyVertex,
        Line,
        PolyLine,
        Triangle,
        TriangleStrip,
        Polygon,
        Pixel,
        Quad,
        Tetra,
        Voxel,
        Hexahedron,
        Wedge,
        Pyramid,
        QuadraticEdge,
        QuadraticTriangle,
        QuadraticQuad,
        QuadraticTetra,
        QuadraticHexahedron,
        QuadraticWedge,
        QuadraticPyramid,
        BiquadraticQuad,
        TriquadraticHexahedron,
        QuadraticLinearQuad,
        QuadraticLinearWedge,
        BiquadraticQuadraticWedge,
        BiquadraticQuadraticHexahedron,
        BiquadraticTriangle,
        CubicLine,
        ConvexPointSet,
        Polyhedron,
        ParametricCurve,
        ParametricSurface,
        ParametricTriSurface,
        ParametricQuadSurface,
        ParametricTetraRegion,
        ParametricHexRegion,
        HigherOrderEdge,
        HigherOrderTriangle,
        HigherOrderQuad,
        HigherOrderPolygon,
        HigherOrderTetrahedron,
        HigherOrderWedge,
        HigherOrderPyramid,
        HigherOrderHexahedron,
        LagrangeCurve,
        LagrangeTriangle,
        LagrangeQuadrilateral,
        LagrangeTetrahedron,
        LagrangeHexahedron,
        LagrangeWedge,
        LagrangePyramid,
        BezierCurve,
        BezierTriangle,
        BezierQuadrilateral,
        BezierTetrahedron,
        BezierHexahedron,
        BezierWedge,
        BezierPyramid,
    ]
};

fn cell_type(kind: CellKind) -> Result<model::CellType> {
    let of_kind = |known: &model::CellType| *known as u8 == kind.vtk();
    TYPES.into_iter().find(of_kind).ok_or_else(|| {
        let name = kind.name();
        Error::input(format!("vtkio has no cell of the kind {name}"))
    })
}

/// The mesh in an unstructured grid of vtkio's model; a note for each thing that is not kept.
///
/// Pieces must be in memory (`Vtk::load_all_pieces`); nodes that several of them have at the same
/// place become one, as when a .pvtu is read.
pub fn from_vtkio(vtk: &model::Vtk, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let mut pieces = Vec::new();
    grid_pieces(&vtk.data, &mut |piece| {
        pieces.push(Piece {
            mesh: piece_mesh(piece, notes)?,
            node_ids: None,
            cell_ids: None,
        });
        Ok(())
    })?;
    let mut mesh = match pieces.len() {
        1 => pieces.remove(0).mesh,
        _ => merge::merge(pieces, notes)?,
    };
    order::turn_wedges(&mut mesh, vtk.title == order::TITLE, notes);
    tags::extract(&mut mesh, options.tag_array.as_deref())?;
    mesh.validate()?;
    mesh.merge_repeated_faces();
    Ok(mesh)
}

fn grid_pieces(
    data: &model::DataSet,
    act: &mut dyn FnMut(&model::UnstructuredGridPiece) -> Result<()>,
) -> Result<()> {
    let model::DataSet::UnstructuredGrid { pieces, .. } = data else {
        return Err(Error::input("the data set is not an UnstructuredGrid"));
    };
    for piece in pieces {
        match piece {
            model::Piece::Inline(piece) => act(piece)?,
            model::Piece::Loaded(data) => grid_pieces(data, act)?,
            model::Piece::Source(name, _) => {
                return Err(Error::input(format!("the piece \"{name}\" is not loaded")));
            }
        }
    }
    Ok(())
}

fn piece_mesh(piece: &model::UnstructuredGridPiece, notes: &mut Notes) -> Result<Mesh> {
    let coordinates = coordinates(&piece.points)?;
    let (points, []) = coordinates.as_chunks::<3>() else {
        let n = coordinates.len();
        return Err(Error::input(format!(
            "there are {n} coordinates, not 3 for each point"
        )));
    };
    let points = points.to_vec();
    let Built { cells, origin } = mesh_cells(&piece.cells, points.len(), notes)?;
    let mut mesh = Mesh {
        point_arrays: arrays(&piece.data.point)?,
        cell_arrays: arrays(&piece.data.cell)?,
        points,
        cells,
        ..Mesh::default()
    };
    check_tuples(&mesh.cell_arrays, piece.cells.types.len(), "cells")?;
    if let Some(origin) = origin {
        azimesh_io::mesh::arrays::select_tuples(&mut mesh.cell_arrays, &origin);
    }
    check_tuples(&mesh.point_arrays, mesh.points.len(), "points")?;
    Ok(mesh)
}

fn mesh_cells(cells: &model::Cells, n_points: usize, notes: &mut Notes) -> Result<Built> {
    let list = match &cells.cell_verts {
        model::VertexNumbers::Legacy {
            num_cells,
            vertices,
        } => List::counted(*num_cells as usize, vertices.clone()),
        model::VertexNumbers::XML {
            connectivity,
            offsets,
        } => {
            // Legacy files of version 5 bring a zero at the start.
            let has_zero = offsets.first() == Some(&0) && offsets.len() > cells.types.len();
            let ends = &offsets[usize::from(has_zero)..];
            let narrow = |node: &u64| u32::try_from(*node).unwrap_or(u32::MAX);
            let ends = ends.iter().map(|end| *end as i64).collect();
            List::ending(ends, connectivity.iter().map(narrow).collect())
        }
    };
    if list.n_cells() != cells.types.len() {
        let (found, n) = (cells.types.len(), list.n_cells());
        return Err(Error::input(format!(
            "there are {found} types for {n} cells"
        )));
    }
    let nodes = PieceNodes {
        base: 0,
        limit: n_points as u64,
    };
    let mut table = CellTable::default();
    list.append(&mut table, nodes, |cell, _| cells.types[cell] as u8)?;
    table.finish(notes)
}

fn coordinates(buffer: &model::IOBuffer) -> Result<Vec<f64>> {
    match buffer {
        model::IOBuffer::F64(values) => Ok(values.clone()),
        model::IOBuffer::F32(values) => Ok(values.iter().map(|x| f64::from(*x)).collect()),
        other => {
            let integers = values(other).to_integers();
            let integers = integers.ok_or_else(|| Error::input("points are not numbers"))?;
            Ok(integers.into_iter().map(|x| x as f64).collect())
        }
    }
}

fn arrays(attributes: &[model::Attribute]) -> Result<Vec<DataArray>> {
    let mut arrays = Vec::new();
    for attribute in attributes {
        match attribute {
            model::Attribute::DataArray(array) => {
                arrays.push(tuples(&array.name, array.num_comp(), &array.data)?);
            }
            model::Attribute::Field { data_array, .. } => {
                for array in data_array {
                    arrays.push(tuples(&array.name, array.num_comp(), &array.data)?);
                }
            }
        }
    }
    Ok(arrays)
}

fn tuples(name: &str, n_components: usize, buffer: &model::IOBuffer) -> Result<DataArray> {
    if n_components == 0 {
        return Err(Error::input("tuples of 0 components").dataset(name));
    }
    Ok(DataArray::tuples(name, n_components, values(buffer)))
}

fn check_tuples(arrays: &[DataArray], n: usize, what: &str) -> Result<()> {
    let wrong = |array: &&DataArray| n.checked_mul(array.n_components) != Some(array.values.len());
    match arrays.iter().find(wrong) {
        None => Ok(()),
        Some(array) => {
            let found = array.values.len();
            let message = format!("there are {found} values for {n} {what}");
            Err(Error::input(message).dataset(&array.name))
        }
    }
}

fn values(buffer: &model::IOBuffer) -> Values {
    use model::IOBuffer;
    match buffer {
        IOBuffer::Bit(values) | IOBuffer::U8(values) => Values::U8(values.clone()),
        IOBuffer::I8(values) => Values::I8(values.clone()),
        IOBuffer::U16(values) => Values::U16(values.clone()),
        IOBuffer::I16(values) => Values::I16(values.clone()),
        IOBuffer::U32(values) => Values::U32(values.clone()),
        IOBuffer::I32(values) => Values::I32(values.clone()),
        IOBuffer::U64(values) => Values::U64(values.clone()),
        IOBuffer::I64(values) => Values::I64(values.clone()),
        IOBuffer::F32(values) => Values::F32(values.clone()),
        IOBuffer::F64(values) => Values::F64(values.clone()),
    }
}

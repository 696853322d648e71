//! VTK XML polygonal data (.vtp): the surface of a mesh, as vertices, lines and polygons. Read like any XML of VTK.

use super::super::column::{Column, Data};
use super::super::format::{OuterFaces, surface_of};
use super::super::vtk::arrays::{VtkArrays, ends_of, index_type};
use super::super::vtk::number::Element;
use super::super::{Format, Notes, WriteOptions};
use super::write::{File, NAMES};
use super::{XML, start_of_xml};
use crate::formats::Out;
use crate::mesh::{Cells, Mesh, MeshView};
use azimesh_core::error::Result;

/// VTK XML polygonal data (.vtp).
pub static VTP: Format = Format {
    name: "vtp",
    title: "VTK XML polygonal data (.vtp)",
    extensions: &["vtp"],
    is_surface: true,
    detect: |source| {
        let is_poly = |element: &[u8]| {
            let element = &element[..memchr::memchr(b'>', element).unwrap_or(element.len())];
            memchr::memmem::find(element, b"PolyData").is_some()
        };
        start_of_xml(source.bytes()).is_some_and(is_poly)
    },
    surface: Some(|mesh, outer| surface_of(mesh, "VTP", outer)),
    write: Some(write_surface),
    ..XML
};

fn write_surface(mesh: &MeshView, out: &mut dyn Out, options: &WriteOptions) -> Result<Notes> {
    let (surface, mut notes) = surface_of(mesh, "VTP", OuterFaces::All);
    notes.extend(options.check_coordinates(&surface.view())?);
    let surface = with_faces_apart(surface);
    let view = surface.view();
    let lists = lists(&surface.cells);
    let plan = VtkArrays::new(&view, options, &NAMES);
    notes.extend(plan.notes.clone());
    let mut sections = plan.sections();
    sections.cells = lists
        .iter()
        .flat_map(|(nodes, ends)| columns(nodes, ends))
        .collect();
    let file = File {
        sections,
        n_points: surface.points.len(),
        n_cells: plan.n_cells(),
        lists: Some([0, 1, 2, 3].map(|list| lists[list].1.len())),
        version: "1.0",
        has_wedges: false,
        options,
    };
    file.write(out)?;
    Ok(notes)
}

/// Connectivity and offsets of one list.
fn columns<'a>(nodes: &'a [u32], ends: &'a [i64]) -> [Column<'a>; 2] {
    [
        Column::scalar(
            "connectivity",
            index_type(nodes.len()),
            nodes.len(),
            Data::slice(nodes),
        ),
        Column::scalar("offsets", Element::Int64, ends.len(), Data::slice(ends)),
    ]
}

/// Vertices, lines, strips (none) and polygons of cells that are sorted by dimension, VTK's order of the lists: their
/// nodes, and the ends of the nodes of each.
fn lists(cells: &Cells) -> [(&[u32], Vec<i64>); 4] {
    let (mut first_cell, mut first) = (0, 0);
    let all_ends: Vec<i64> = ends_of(cells).collect();
    [Some(0), Some(1), None, Some(2)].map(|dimension| {
        let runs = cells.runs();
        let runs = runs.filter(|run| Some(run.kind.dimension()) == dimension);
        let n: usize = runs.map(|run| run.n_cells()).sum();
        let own = all_ends[first_cell..first_cell + n].iter();
        let ends: Vec<i64> = own.map(|end| end - first as i64).collect();
        let last = first + ends.last().map_or(0, |end| *end as usize);
        let nodes = &cells.connectivity()[first..last];
        (first_cell, first) = (first_cell + n, last);
        (nodes, ends)
    })
}

/// The mesh with a cell more for each further boundary tag of a face, after the cells of its dimension.
fn with_faces_apart(mesh: Mesh) -> Mesh {
    let Some(boundary) = mesh.boundary_tags().next().map(|tag| tag.dimension) else {
        return mesh;
    };
    let runs = mesh.cells.runs();
    let below = runs.filter(|run| run.kind.dimension() <= boundary);
    let n_below: usize = below.map(|run| run.n_cells()).sum();
    let mut is_taken = vec![false; mesh.cells.len()];
    let mut further: Vec<usize> = Vec::new();
    let mut groups = mesh.groups.clone();
    for group in groups.iter_mut().filter(|of| of.dimension == boundary) {
        let own = group.cells.iter().map(|cell| {
            if !std::mem::replace(&mut is_taken[cell], true) {
                return cell;
            }
            further.push(cell);
            n_below + further.len() - 1
        });
        group.cells = own.collect();
    }
    if further.is_empty() {
        return mesh;
    }
    for group in groups.iter_mut().filter(|group| group.dimension > boundary) {
        let own = group.cells.iter().map(|cell| cell + further.len());
        group.cells = own.collect();
    }
    let mut sources: Vec<usize> = (0..n_below).collect();
    sources.extend(&further);
    sources.extend(n_below..mesh.cells.len());
    let cell_arrays = mesh.cell_arrays.iter();
    let cell_arrays = cell_arrays.map(|array| array.select(&sources)).collect();
    Mesh {
        cells: mesh.cells.select(sources.iter().copied()),
        groups,
        cell_arrays,
        ..mesh
    }
}

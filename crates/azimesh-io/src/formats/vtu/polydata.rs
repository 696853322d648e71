//! VTK XML polygonal data (.vtp): the surface of a mesh, as vertices, lines and polygons. Read like any XML of VTK.

use super::super::column::{Column, Data};
use super::super::format::{OuterFaces, surface_of};
use super::super::vtk::arrays::VtkArrays;
use super::super::vtk::number::Element;
use super::super::{Format, Notes, WriteOptions};
use super::file::{File, NAMES};
use super::{XML, start_of_xml, write};
use crate::formats::Out;
use crate::mesh::{CellSet, Cells, Group, Mesh, MeshView};
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
    sections.cells = lists.iter().flat_map(List::columns).collect();
    let file = File {
        sections,
        n_points: surface.points.len(),
        n_cells: plan.n_cells(),
        lists: Some([0, 1, 2, 3].map(|list| lists[list].ends.len())),
        version: "1.0",
        has_wedges: false,
        options,
    };
    write::write_file(&file, out)?;
    Ok(notes)
}

/// The cells of one list: their nodes, and where the nodes of each end.
struct List<'a> {
    nodes: &'a [u32],
    ends: Vec<i64>,
}

impl List<'_> {
    fn columns(&self) -> [Column<'_>; 2] {
        let n = self.nodes.len();
        let nodes = match i32::try_from(n) {
            Ok(_) => Element::Int32,
            Err(_) => Element::UInt32,
        };
        [
            Column::scalar("connectivity", nodes, n, Data::slice(self.nodes)),
            Column::scalar(
                "offsets",
                Element::Int64,
                self.ends.len(),
                Data::owned(&self.ends),
            ),
        ]
    }
}

/// Vertices, lines, strips (none) and polygons of cells that are sorted by dimension: VTK's order of the lists.
fn lists(cells: &Cells) -> [List<'_>; 4] {
    let mut first = 0;
    [Some(0), Some(1), None, Some(2)].map(|dimension| {
        let runs = cells.runs();
        let runs = runs.filter(|run| Some(run.kind.dimension()) == dimension);
        let (mut ends, mut end) = (Vec::new(), 0);
        for run in runs {
            for _ in 0..run.n_cells() {
                end += run.n_nodes;
                ends.push(end as i64);
            }
        }
        let nodes = &cells.connectivity()[first..first + end];
        first += end;
        List { nodes, ends }
    })
}

/// The mesh with a cell more for each further boundary tag of a face, beside those of its dimension.
fn with_faces_apart(mesh: Mesh) -> Mesh {
    let mut is_taken = vec![false; mesh.cells.len()];
    let tags: Vec<&Group> = mesh.boundary_tags().collect();
    let mut further: Vec<usize> = Vec::new();
    for group in &tags {
        for cell in group.cells.iter() {
            if std::mem::replace(&mut is_taken[cell], true) {
                further.push(cell);
            }
        }
    }
    if further.is_empty() {
        return mesh;
    }
    let boundary = tags[0].dimension;
    let is_above = |cell: &usize| mesh.cells.get(*cell).kind.dimension() > boundary;
    let n_below = (0..mesh.cells.len())
        .find(is_above)
        .unwrap_or(mesh.cells.len());
    // Where each cell comes from: those up to the boundary's dimension, the further faces, the others.
    let mut sources: Vec<usize> = (0..n_below).collect();
    sources.extend(&further);
    sources.extend(n_below..mesh.cells.len());
    let moved = |cell: usize| {
        if cell < n_below {
            cell
        } else {
            cell + further.len()
        }
    };
    let mut seen = vec![false; mesh.cells.len()];
    let mut at_further = 0;
    let mut groups = mesh.groups.clone();
    for group in &mut groups {
        let is_tag = group.dimension == boundary;
        let own = group.cells.iter().map(|cell| {
            match is_tag && std::mem::replace(&mut seen[cell], true) {
                true => {
                    at_further += 1;
                    n_below + at_further - 1
                }
                false => moved(cell),
            }
        });
        let mut own: Vec<usize> = own.collect();
        own.sort_unstable();
        group.cells = own.into_iter().collect::<CellSet>();
    }
    let mut cell_arrays = mesh.cell_arrays.clone();
    for array in &mut cell_arrays {
        array.values = array.values.select(array.n_components, &sources);
    }
    Mesh {
        cells: mesh.cells.select(sources.iter().copied()),
        groups,
        cell_arrays,
        ..mesh
    }
}

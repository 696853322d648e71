//! A surface made of triangles alone.

use crate::formats::Notes;
use crate::mesh::{CellKind, Cells, Mesh, facets::facets};
use azimesh_core::diagnostic::formats::Written;

/// The surface with its faces cut into triangles and without edges and vertices; groups and arrays follow.
pub(super) fn of(mut mesh: Mesh, notes: &mut Notes) -> Mesh {
    let is_triangle = |kind| kind == CellKind::Triangle;
    if mesh.cells.runs().all(|run| is_triangle(run.kind)) {
        return mesh;
    }
    let (mut triangles, mut sources) = (Cells::new(), Vec::new());
    // Where the triangles of each cell begin.
    let mut starts = vec![0];
    let (mut n_cut, mut n_lower) = (0, 0);
    for cell in mesh.cells.iter() {
        if cell.kind.dimension() == 2 {
            n_cut += usize::from(!is_triangle(cell.kind));
            for corners in facets(cell.kind, cell.nodes.len()) {
                triangles.push(CellKind::Triangle, &corners.map(|i| cell.nodes[i]));
                sources.push(cell.index);
            }
        } else {
            n_lower += 1;
        }
        starts.push(sources.len());
    }
    notes.count(n_lower, |n| Written::LowerCellsLeftOut { n });
    if n_cut > 0 {
        notes.push(Written::CutIntoTriangles { n: n_cut });
    }
    for group in &mut mesh.groups {
        let own = group.cells.iter();
        group.cells = own
            .flat_map(|cell| starts[cell]..starts[cell + 1])
            .collect();
    }
    mesh.groups.retain(|group| group.dimension == 2);
    for array in &mut mesh.cell_arrays {
        array.values = array.values.select(array.n_components, &sources);
    }
    mesh.cells = triangles;
    mesh
}

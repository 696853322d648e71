//! Contents that a format holds and the programs that read it do not take: notes, and meshes without them.

use crate::mesh::{CellKind, Mesh, MeshView, inner_faces, linear};
use azimesh_core::error::option;
use azimesh_core::{Note, note};
use std::collections::BTreeSet;

/// The remedy for cells of a kind that a format cannot hold, as the end of a sentence.
pub(super) fn remedy(kind: CellKind) -> String {
    match kind {
        kind if kind.is_curved() => format!("; {} keeps only corner nodes", option("linearize")),
        CellKind::Polyhedron
        | CellKind::Polygon
        | CellKind::PentagonalPrism
        | CellKind::HexagonalPrism => format!(
            "; {} makes tetrahedra and pyramids of polyhedra, triangles and quadrilaterals of polygons",
            option("split-polyhedra")
        ),
        _ => String::new(),
    }
}

/// Contents of a mesh that readers of a format do not take.
pub(super) fn not_taken(mesh: &MeshView<'_>, format: &str) -> Option<Note> {
    let portable = option("portable");
    match format {
        "su2" => {
            let mut tagged = inner_faces(mesh);
            tagged.retain(|face| {
                let mut tags = mesh.boundary_tags();
                tags.any(|tag| tag.cells.contains(*face as usize))
            });
            let first = *tagged.first()?;
            let n = tagged.len();
            let note = note!(
                "inner_markers",
                "tagged faces between two cells ({n}, the first is cell {first}) become markers, and SU2 takes markers on the \
                 boundary only; {portable} leaves them out"
            );
            Some(note.with("n", n))
        }
        "cgns" => {
            let n = far_below(mesh).count();
            let note = note!(
                "lower_cells",
                "with cells of lower dimension than boundary faces ({n}) ParaView shows no cell array of a CGNS file, and Gmsh \
                 may refuse it; {portable} leaves these cells out"
            );
            (n > 0).then(|| note.with("n", n))
        }
        "vtu" | "pvtu" | "vtk" | "vtk42" | "vtkhdf" => {
            let pyramids = mesh.cells.runs().filter(|run| is_pyramid(run.kind));
            let n: usize = pyramids.map(|run| run.n_cells()).sum();
            let note = note!(
                "lagrange_pyramids",
                "VTK has no Lagrange pyramids and leaves them out when it reads the file ({n}); {portable} keeps their corner \
                 nodes only"
            );
            (n > 0).then(|| note.with("n", n))
        }
        _ => None,
    }
}

/// Changes a mesh to what readers of a format take; says what was changed.
pub fn make_portable(mesh: &mut Mesh, format: &str) -> Option<Note> {
    let note = not_taken(&mesh.view(), format)?;
    let change = match &*note.code {
        "inner_markers" => {
            let inner = inner_faces(&mesh.view());
            leave_out(mesh, inner.into_iter().map(|face| face as usize).collect());
            "faces between two cells left out"
        }
        "lower_cells" => {
            let lower = far_below(&mesh.view()).collect();
            leave_out(mesh, lower);
            "cells of lower dimension than boundary faces left out"
        }
        _ => {
            // The other nodes stay, in no cell.
            mesh.cells = linear(&mesh.cells, is_pyramid);
            "Lagrange pyramids made linear"
        }
    };
    let n = note.get("n").clone();
    let portable = option("portable");
    Some(note!("made_portable", "{portable}: {change}: {n}").with("n", n))
}

fn is_pyramid(kind: CellKind) -> bool {
    kind == CellKind::LagrangePyramid
}

/// Cells of two dimensions less than the mesh, or fewer.
fn far_below<'a>(mesh: &MeshView<'a>) -> impl Iterator<Item = usize> + use<'a> {
    let dimension = mesh.dimension();
    let runs = mesh.cells.runs();
    let runs = runs.filter(move |run| run.kind.dimension() + 1 < dimension);
    runs.flat_map(|run| run.range())
}

/// Removes cells; groups and arrays follow, and groups that had only these go.
fn leave_out(mesh: &mut Mesh, cells: BTreeSet<usize>) {
    let all = 0..mesh.cells.len();
    let keep: Vec<usize> = all.filter(|cell| !cells.contains(cell)).collect();
    mesh.keep_cells(&keep);
    mesh.groups.retain(|group| !group.cells.is_empty());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{DataArray, Values};
    use crate::testing::assert_says;

    /// Two tetrahedra with a tagged face outside and one between them, an edge, and an array.
    fn mesh() -> Mesh {
        let point = |i| [f64::from(i % 2), f64::from(i / 2), f64::from(i % 3)];
        let mut mesh = Mesh::of_points((0..5).map(point).collect());
        mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        mesh.cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        mesh.cells.push(CellKind::Triangle, &[1, 2, 3]);
        mesh.cells.push(CellKind::Line, &[0, 1]);
        mesh.add_tag("wall", [2]).expect("it is a face");
        mesh.add_tag("inside", [3]).expect("it is a face");
        mesh.cell_arrays = vec![DataArray::scalar("p", Values::I32(vec![0, 1, 2, 3, 4]))];
        mesh
    }

    #[test]
    fn tagged_faces_inside_are_told_of_for_su2_and_left_out() {
        let mut mesh = mesh();
        let note = not_taken(&mesh.view(), "su2").expect("there is one");
        assert_eq!((&*note.code, note.get("n")), ("inner_markers", &1.into()));
        assert_says(&note.text, "(1, the first is cell 3)");
        assert!(make_portable(&mut mesh, "su2").is_some());
        let tags: Vec<&str> = mesh.boundary_tags().map(|tag| tag.name.as_str()).collect();
        assert_eq!((tags, mesh.cells.len()), (vec!["wall"], 4));
        assert_eq!(mesh.cell_arrays[0].values, Values::I32(vec![0, 1, 2, 4]));
        assert_eq!(not_taken(&mesh.view(), "su2"), None);
    }

    #[test]
    fn edges_get_a_note_in_cgns_and_are_left_out_with_and_without_cell_arrays() {
        let mut bare = mesh();
        bare.cell_arrays.clear();
        assert!(make_portable(&mut bare, "cgns").is_some());
        assert_eq!(bare.cells.len(), 4);
        let mut mesh = mesh();
        let note = not_taken(&mesh.view(), "cgns").expect("there is one");
        assert_eq!((&*note.code, note.get("n")), ("lower_cells", &1.into()));
        assert!(make_portable(&mut mesh, "cgns").is_some());
        assert_eq!((mesh.cells.len(), mesh.groups.len()), (4, 2));
        assert_eq!(not_taken(&mesh.view(), "cgns"), None);
        assert_eq!(not_taken(&mesh.view(), "vtu"), None);
    }

    #[test]
    fn lagrange_pyramids_are_told_of_for_vtk_and_made_linear() {
        let mut mesh = Mesh::of_points(vec![[0.0; 3]; 14]);
        let nodes: Vec<u32> = (0..14).collect();
        mesh.cells.push(CellKind::LagrangePyramid, &nodes);
        for format in ["vtu", "vtk", "vtkhdf", "pvtu"] {
            let note = not_taken(&mesh.view(), format).expect("there is one");
            assert_eq!(
                (&*note.code, note.get("n")),
                ("lagrange_pyramids", &1.into())
            );
        }
        assert_eq!(not_taken(&mesh.view(), "msh"), None);
        assert!(make_portable(&mut mesh, "vtu").is_some());
        assert_eq!(mesh.cells.get(0).kind, CellKind::Pyramid);
        assert_eq!(mesh.cells.get(0).nodes, [0, 1, 2, 3, 4]);
    }
}

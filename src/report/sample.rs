//! Quality of some cells of a mesh, without looking at the others.

use azimesh_io::mesh::{Cells, Mesh};
use azimesh_quality::{Reference, per_cell};

/// Scaled Jacobians of these cells of a mesh, oriented as in `before`, which has the same cells.
pub fn scaled_jacobians(cells: &[usize], mesh: &Mesh, before: &Mesh) -> Vec<f64> {
    let before = part(before, cells);
    let mesh = part(mesh, cells);
    per_cell(&mesh, &mesh.points, &Reference::new(&before)).scaled_jacobian
}

/// A mesh of some cells.
fn part(mesh: &Mesh, cells: &[usize]) -> Mesh {
    let streams = cells
        .iter()
        .filter_map(|&cell| mesh.cells.face_stream(cell));
    let mut nodes: Vec<u32> = streams.flat_map(stream_nodes).collect();
    nodes.extend(cells.iter().flat_map(|&cell| mesh.cells.get(cell).nodes));
    nodes.sort_unstable();
    nodes.dedup();
    let place = |node: &u32| nodes.binary_search(node).map_or(0, |at| at as u32);
    let mut some = Cells::new();
    for &cell in cells {
        let whole = mesh.cells.get(cell);
        let renumbered: Vec<u32> = whole.nodes.iter().map(place).collect();
        match mesh.cells.face_stream(cell) {
            None => some.push(whole.kind, &renumbered),
            Some(_) => {
                let faces: Vec<&[u32]> = mesh.cells.polyhedron_faces(cell).collect();
                let mut stream = vec![faces.len() as u32];
                for face in faces {
                    stream.push(face.len() as u32);
                    stream.extend(face.iter().map(place));
                }
                let pushed = some.push_polyhedron_with_nodes(&renumbered, &stream);
                pushed.expect("a polyhedron of a mesh is one of a part of it");
            }
        }
    }
    Mesh {
        points: nodes
            .iter()
            .map(|&node| mesh.points[node as usize])
            .collect(),
        cells: some,
        space: Some(mesh.dimension()),
        ..Mesh::default()
    }
}

/// The nodes in a face stream.
fn stream_nodes(stream: &[u32]) -> Vec<u32> {
    let mut nodes = Vec::new();
    let mut at = 1;
    while at < stream.len() {
        let n = stream[at] as usize;
        nodes.extend(&stream[at + 1..at + 1 + n]);
        at += 1 + n;
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn some_cells_have_the_quality_that_they_have_among_all() {
        for name in [
            "mixed_cells_base64.vtu",
            "polyhedra_ascii.vtu",
            "naca0012.vtu",
        ] {
            let before = Mesh::read(Path::new("testdata").join(name)).expect("it is good");
            let mut mesh = before.clone();
            for (i, x) in mesh.points.iter_mut().enumerate() {
                x[0] += 0.02 * (i as f64).sin();
            }
            let all = per_cell(&mesh, &mesh.points, &Reference::new(&before)).scaled_jacobian;
            let volume = mesh
                .volume_runs()
                .flat_map(|run| run.first_cell..run.first_cell + run.n_cells());
            let cells: Vec<usize> = volume.filter(|cell| cell % 3 != 1).collect();
            let some = scaled_jacobians(&cells, &mesh, &before);
            for (&cell, value) in cells.iter().zip(&some) {
                assert!(
                    all[cell] == *value || all[cell].is_nan() && value.is_nan(),
                    "{name} {cell}"
                );
            }
        }
    }
}

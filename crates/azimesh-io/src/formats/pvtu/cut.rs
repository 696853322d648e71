//! Assigns cells to pieces: intervals of about equal length along a space-filling curve.

use crate::mesh::MeshView;
use azimesh_core::error::counted;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::curve;

/// The piece, from 0 to `n - 1`, of every cell. Cells of lower dimension go where the mesh's own
/// cells at their first node are.
pub(super) fn pieces(mesh: &MeshView, n: usize) -> Result<Vec<u32>> {
    let volume: Vec<usize> = mesh
        .volume_runs()
        .flat_map(|run| run.first_cell..run.first_cell + run.n_cells())
        .collect();
    let n_volume = volume.len();
    if n == 0 || n > n_volume {
        return Err(Error::input(format!(
            "a mesh of {} cannot be cut into {n} pieces",
            counted(n_volume, "cell")
        )));
    }
    let center = |cell: &usize| {
        let nodes = mesh.cells.get(*cell).nodes;
        let mut sum = [0.0; 3];
        for &node in nodes {
            for (sum, x) in sum.iter_mut().zip(mesh.points[node as usize]) {
                *sum += x;
            }
        }
        sum.map(|x| x / nodes.len() as f64)
    };
    let centers: Vec<[f64; 3]> = volume.iter().map(center).collect();
    let mut of_cells = vec![0; mesh.cells.len()];
    for (place, along) in curve::order(&centers).into_iter().enumerate() {
        let piece = place as u128 * n as u128 / n_volume as u128;
        of_cells[volume[along as usize]] = piece as u32;
    }
    let mut of_nodes = vec![0; mesh.points.len()];
    for &cell in volume.iter().rev() {
        for &node in mesh.cells.get(cell).nodes {
            of_nodes[node as usize] = of_cells[cell];
        }
    }
    let dimension = mesh.dimension();
    for run in mesh
        .cells
        .runs()
        .filter(|run| run.kind.dimension() < dimension)
    {
        for (i, nodes) in run.cells().enumerate() {
            of_cells[run.first_cell + i] = of_nodes[nodes[0] as usize];
        }
    }
    Ok(of_cells)
}

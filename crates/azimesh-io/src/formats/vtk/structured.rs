//! Cells of a structured block of nodes, which VTK does not list: hexahedra, in a plane
//! quadrilaterals, on a line lines.

use crate::mesh::{CellKind, Cells};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::for_blocks;

/// The grids of VTK, in the order of the lists of their names.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[allow(missing_docs)] // VTK's names
pub enum Grid {
    #[default]
    Unstructured,
    Poly,
    Structured,
    Rectilinear,
    Image,
}

impl Grid {
    /// The grid whose name is in a list, in any capitals.
    pub fn named(name: &str, names: [&str; 5]) -> Option<Self> {
        use Grid::*;
        let at = names.iter().position(|of| of.eq_ignore_ascii_case(name))?;
        Some([Unstructured, Poly, Structured, Rectilinear, Image][at])
    }
}

/// Number of nodes of a block with these dimensions.
pub fn n_points(dimensions: [usize; 3]) -> Result<usize> {
    let mut each = dimensions.iter();
    let n = each.try_fold(1usize, |n, along| n.checked_mul(*along));
    n.filter(|n| *n < u32::MAX as usize).ok_or_else(|| {
        let [x, y, z] = dimensions;
        Error::input(format!(
            "{x} x {y} x {z} nodes are more than the 4294967294 that a mesh can have"
        ))
    })
}

/// Refuses a block that has more nodes than a file of `n_bytes` bytes can have data for.
pub fn check_implied(n_points: usize, n_bytes: usize) -> Result<()> {
    const WITHOUT_DATA: usize = 1 << 22;
    if n_points > WITHOUT_DATA.max(n_bytes) {
        return Err(Error::input(format!(
            "{n_points} nodes cannot have data in a file of {n_bytes} bytes"
        )));
    }
    Ok(())
}

/// Number of cells of a block with these dimensions.
pub fn n_cells(dimensions: [usize; 3]) -> usize {
    if dimensions.contains(&0) {
        return 0;
    }
    dimensions.iter().map(|n| (n - 1).max(1)).product()
}

/// The cells, the first axis running fastest. The number of nodes was checked.
pub fn cells(dimensions: [usize; 3], first_node: u32) -> Cells {
    let mut cells = Cells::new();
    append(&mut cells, dimensions, first_node);
    cells
}

/// Appends the cells of a block.
pub fn append(cells: &mut Cells, dimensions: [usize; 3], first_node: u32) {
    let strides = [1, dimensions[0], dimensions[0] * dimensions[1]];
    let axes: Vec<usize> = (0..3).filter(|axis| dimensions[*axis] > 1).collect();
    let (kind, corners) = match axes[..] {
        [] => (CellKind::Vertex, vec![0]),
        [i] => (CellKind::Line, vec![0, strides[i]]),
        [i, j] => (CellKind::Quadrilateral, face(strides[i], strides[j])),
        _ => {
            let bottom = face(strides[0], strides[1]);
            let top = bottom.iter().map(|corner| corner + strides[2]).collect();
            (CellKind::Hexahedron, [bottom, top].concat())
        }
    };
    let along = dimensions.map(|n| n.saturating_sub(1).max(1));
    let mut nodes = vec![0u32; n_cells(dimensions) * corners.len()];
    let row_length = along[0] * corners.len();
    for_blocks(&mut nodes, row_length, &|first, nodes| {
        let row = first / row_length;
        let start = row % along[1] * strides[1] + row / along[1] * strides[2];
        for (i, cell) in nodes.chunks_exact_mut(corners.len()).enumerate() {
            for (node, corner) in cell.iter_mut().zip(&corners) {
                *node = first_node + (start + i + corner) as u32;
            }
        }
    });
    cells.push_run(kind, corners.len(), &nodes);
}

fn face(i: usize, j: usize) -> Vec<usize> {
    vec![0, i, i + j, j]
}

/// Nodes at all combinations of coordinates along three axes.
pub fn points(axes: [&[f64]; 3]) -> Vec<[f64; 3]> {
    let [x, y, z] = axes;
    let mut points = Vec::with_capacity(x.len() * y.len() * z.len());
    for &z in z {
        for &y in y {
            points.extend(x.iter().map(|&x| [x, y, z]));
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_has_hexahedra_a_plane_quadrilaterals() {
        let block = cells([3, 2, 2], 0);
        assert_eq!(block.len(), 2);
        assert_eq!(block.get(1).nodes, [1, 2, 5, 4, 7, 8, 11, 10]);
        let plane = cells([2, 1, 3], 10);
        assert_eq!(plane.get(1).kind, CellKind::Quadrilateral);
        assert_eq!(plane.get(1).nodes, [12, 13, 15, 14]);
        assert_eq!(cells([1, 4, 1], 0).get(2).nodes, [2, 3]);
        assert!(cells([0, 4, 1], 0).is_empty());
        assert!(n_points([usize::MAX, 3, 1]).is_err());
    }
}

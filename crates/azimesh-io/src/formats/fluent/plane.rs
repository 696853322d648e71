//! Cells of a plane mesh from their edges: the edges of a cell one after another, with the cell to their left.

use super::join::Joined;
use crate::mesh::{CellKind, Cells};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::map_blocks;

/// In the number of an edge of a cell: the cell is to its right.
const REVERSED: u32 = 1 << 31;
/// Cells that one task puts together.
const BLOCK: usize = 1 << 12;
/// Cells of more edges have them sorted before they are put one after another.
const FEW: usize = 16;

/// The cells, then the edges on the boundary as cells.
pub(super) fn assemble(joined: &Joined) -> Result<Cells> {
    let (starts, edges) = edges_of_cells(joined);
    let blocks = map_blocks(joined.n_cells, BLOCK, &|range| {
        let (mut part, mut own) = (Cells::new(), Vec::new());
        for cell in range {
            own.clear();
            let found = &edges[starts[cell] as usize..starts[cell + 1] as usize];
            own.extend(found.iter().map(|edge| {
                let nodes = joined.faces.nodes((edge & !REVERSED) as usize);
                match edge & REVERSED {
                    0 => [nodes[0], nodes[1]],
                    _ => [nodes[1], nodes[0]],
                }
            }));
            push(&mut part, &mut own)
                .map_err(|why| Error::input(format!("cell {} {why}", cell + 1)))?;
        }
        Ok(part)
    });
    let mut cells = Cells::new();
    for block in blocks {
        cells.append(&block?);
    }
    let outside = 2 * joined.n_inside;
    cells.push_run(CellKind::Line, 2, &joined.faces.nodes[outside..]);
    Ok(cells)
}

/// Where the edges of each cell start, and the edges.
fn edges_of_cells(joined: &Joined) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0_u32; joined.n_cells + 2];
    let sides = |edge: usize| {
        let [left, right] = joined.faces.cells[edge];
        let right = (edge < joined.n_inside).then_some((right, edge as u32 | REVERSED));
        std::iter::once((left, edge as u32)).chain(right)
    };
    let n = joined.faces.len();
    (0..n)
        .flat_map(sides)
        .for_each(|(cell, _)| starts[cell as usize + 2] += 1);
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut edges = vec![0; starts.last().map_or(0, |n| *n as usize)];
    for (cell, edge) in (0..n).flat_map(sides) {
        let end = &mut starts[cell as usize + 1];
        edges[*end as usize] = edge;
        *end += 1;
    }
    (starts, edges)
}

/// Appends the cell around which these edges go.
fn push(cells: &mut Cells, edges: &mut [[u32; 2]]) -> std::result::Result<(), String> {
    let n = edges.len();
    if n < 3 {
        let edges = azimesh_core::error::counted(n, "edge");
        return Err(format!("has {edges}; it must have at least 3"));
    }
    let open = "has edges that do not go round it one after another";
    if n > FEW {
        edges[1..].sort_unstable();
    }
    let first = edges[0][0];
    let mut nodes = Vec::with_capacity(n);
    let mut at = edges[0];
    loop {
        nodes.push(at[0]);
        if at[1] == first {
            break;
        }
        let next = match n > FEW {
            true => edges[1..]
                .binary_search_by_key(&at[1], |edge| edge[0])
                .ok()
                .map(|i| i + 1),
            false => edges.iter().position(|edge| edge[0] == at[1]),
        };
        match next {
            Some(next) if nodes.len() < n => at = edges[next],
            _ => return Err(open.to_owned()),
        }
    }
    if nodes.len() != n {
        return Err(open.to_owned());
    }
    let kind = match n {
        3 => CellKind::Triangle,
        4 => CellKind::Quadrilateral,
        _ => CellKind::Polygon,
    };
    cells.push(kind, &nodes);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(edges: &[[u32; 2]]) -> std::result::Result<(CellKind, Vec<u32>), String> {
        let mut cells = Cells::new();
        push(&mut cells, &mut edges.to_vec())?;
        Ok((cells.get(0).kind, cells.get(0).nodes.to_vec()))
    }

    #[test]
    fn edges_in_any_order_make_a_cell() {
        assert_eq!(
            cell(&[[4, 7], [2, 4], [7, 2]]),
            Ok((CellKind::Triangle, vec![4, 7, 2]))
        );
        assert_eq!(
            cell(&[[1, 2], [5, 1], [2, 9], [9, 5]]),
            Ok((CellKind::Quadrilateral, vec![1, 2, 9, 5]))
        );
        let n = 40;
        let edges: Vec<[u32; 2]> = (0..n).map(|i| [i * 7 % n, (i * 7 + 1) % n]).collect();
        assert_eq!(cell(&edges), Ok((CellKind::Polygon, (0..n).collect())));
    }

    #[test]
    fn edges_that_close_no_cell_are_refused() {
        assert!(cell(&[[0, 1], [1, 0]]).is_err_and(|why| why.contains("2 edges")));
        for edges in [
            vec![[0, 1], [1, 2], [2, 3]],
            vec![[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3]],
            vec![[0, 1], [2, 1], [2, 0]],
            vec![[0, 1], [1, 2], [2, 1]],
            (0..40).map(|i| [i, i + 1]).collect(),
        ] {
            assert!(
                cell(&edges).is_err_and(|why| why.contains("round")),
                "{edges:?}"
            );
        }
    }
}

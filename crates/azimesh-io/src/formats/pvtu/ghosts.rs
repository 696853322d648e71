//! Removes ghost cells: copies of cells of neighbouring pieces.

use super::merge::Piece;
use super::subset::Subsets;
use crate::formats::Notes;
use crate::mesh::DataArray;
use azimesh_core::diagnostic::formats::Pieces;

/// Bits of the type of a cell: a copy of a neighbour's; not to be shown.
const TYPE: &str = "vtkGhostType";
const DUPLICATE: i64 = 1;
const HIDDEN: i64 = 32;
/// The older array: how far from the piece's own cells.
const LEVELS: &str = "vtkGhostLevels";

/// The piece without its ghost cells, the nodes of those alone, and the arrays that mark them.
pub(super) fn left_out(mut piece: Piece, notes: &mut Notes) -> Piece {
    let is_ghost = marks(&piece.mesh.cell_arrays, notes);
    if let Some(is_ghost) = is_ghost.filter(|marks| marks.contains(&true)) {
        let n_cells = piece.mesh.cells.len();
        let (ghosts, own): (Vec<usize>, Vec<usize>) =
            (0..n_cells).partition(|cell| is_ghost[*cell]);
        let mut of_ghosts = vec![false; piece.mesh.points.len()];
        for &cell in &ghosts {
            for &node in piece.mesh.cells.get(cell).nodes {
                of_ghosts[node as usize] = true;
            }
        }
        let others: Vec<usize> = (0..of_ghosts.len())
            .filter(|node| !of_ghosts[*node])
            .collect();
        piece.mesh = Subsets::of(&piece.mesh.view()).take(&own, &others).0;
        notes.push(Pieces::GhostsLeftOut);
    }
    let is_mark = |array: &DataArray| [TYPE, LEVELS].contains(&array.name.as_str());
    piece.mesh.cell_arrays.retain(|array| !is_mark(array));
    piece.mesh.point_arrays.retain(|array| !is_mark(array));
    piece
}

/// Ghost cells, by the array that marks them.
fn marks(arrays: &[DataArray], notes: &mut Notes) -> Option<Vec<bool>> {
    let numbers = |name: &str| {
        let array = arrays
            .iter()
            .find(|array| array.name == name && array.n_components == 1);
        array?.values.to_integers()
    };
    if let Some(types) = numbers(TYPE) {
        if types.iter().any(|kind| kind & HIDDEN != 0) {
            notes.push(Pieces::Hidden);
        }
        return Some(types.iter().map(|kind| kind & DUPLICATE != 0).collect());
    }
    let levels = numbers(LEVELS)?;
    Some(levels.iter().map(|level| *level > 0).collect())
}

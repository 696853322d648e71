//! Ghost cells in the files of VTK: copies of cells of another piece, which a mesh has once, and cells that viewers hide,
//! which are read like others.

use crate::formats::Notes;
use crate::mesh::{DataArray, Mesh, Values};
use azimesh_core::note;

/// The array at cells and at nodes. Its values are bits.
const TYPE: &str = "vtkGhostType";
const COPY: i64 = 1;
const HIDDEN_NODE: i64 = 2;
const HIDDEN_CELL: i64 = 32;
/// The older array: distance of a copy from the piece's own cells, 0 of those.
const LEVELS: &str = "vtkGhostLevels";

/// Checks if an array of this name marks ghost cells.
pub fn is_mark(name: &str) -> bool {
    [TYPE, LEVELS].contains(&name)
}

/// Leaves out the copies in the pieces of a mesh, and the nodes that only copies have. Arrays of marks stay where a piece has other marks.
pub fn leave_out<'m>(pieces: impl IntoIterator<Item = &'m mut Mesh>, notes: &mut Notes) {
    let mut pieces: Vec<&mut Mesh> = pieces.into_iter().collect();
    let (mut n_copies, mut hides, mut marks) = (0, false, false);
    for piece in &mut pieces {
        n_copies += without_copies(piece);
        let of_cells = other_marks(&mut piece.cell_arrays);
        let of_nodes = other_marks(&mut piece.point_arrays);
        hides |= of_cells & HIDDEN_CELL != 0 || of_nodes & HIDDEN_NODE != 0;
        marks |= (of_cells | of_nodes) != 0;
    }
    notes.count(n_copies, |n| {
        note!("ghosts_left_out", "ghost cells left out: {n}")
    });
    if hides {
        notes.push(note!(
            "hidden",
            "cells marked as hidden are read like others"
        ));
    }
    for piece in pieces.iter_mut().filter(|_| !marks) {
        piece.cell_arrays.retain(|array| !is_mark(&array.name));
        piece.point_arrays.retain(|array| !is_mark(&array.name));
    }
}

/// Removes the copies; returns how many there were.
fn without_copies(mesh: &mut Mesh) -> usize {
    let numbers = |name| marks_in(&mesh.cell_arrays, name).map(|at| &mesh.cell_arrays[at].values);
    let numbers = |name| numbers(name).and_then(Values::to_integers);
    let is_copy: Vec<bool> = match (numbers(TYPE), numbers(LEVELS)) {
        (Some(types), _) => types.iter().map(|kind| kind & COPY != 0).collect(),
        (None, Some(levels)) => levels.iter().map(|level| *level > 0).collect(),
        (None, None) => return 0,
    };
    let own: Vec<usize> = (0..is_copy.len()).filter(|cell| !is_copy[*cell]).collect();
    mesh.keep_cells(&own);
    is_copy.len() - own.len()
}

/// Removes the marks of copies; returns the bits of all other marks.
fn other_marks(arrays: &mut Vec<DataArray>) -> i64 {
    arrays.retain(|array| array.name != LEVELS);
    let Some(at) = marks_in(arrays, TYPE) else {
        return 0;
    };
    let marks = arrays[at].values.to_integers().unwrap_or_default();
    let marks: Vec<u8> = marks.iter().map(|mark| (mark & !COPY) as u8).collect();
    let all = marks.iter().fold(0, |all, mark| all | mark);
    arrays[at].values = Values::U8(marks);
    i64::from(all)
}

/// The array of integers of this name.
fn marks_in(arrays: &[DataArray], name: &str) -> Option<usize> {
    let is_it = |of: &DataArray| of.name == name && of.n_components == 1 && of.values.is_integer();
    arrays.iter().position(is_it)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;

    /// Three lines in a row with marks; only the last line has a node that no other has.
    fn lines(array: &str, marks: [u8; 3]) -> Mesh {
        let mut mesh = Mesh::of_points((0..4).map(|i| [f64::from(i), 0.0, 0.0]).collect());
        for i in 0..3 {
            mesh.cells.push(CellKind::Line, &[i, i + 1]);
        }
        mesh.cell_arrays = vec![DataArray::scalar(array, Values::U8(marks.to_vec()))];
        mesh
    }

    fn left(mut pieces: Vec<Mesh>) -> (Vec<Mesh>, Notes) {
        let mut notes = Notes::default();
        leave_out(&mut pieces, &mut notes);
        (pieces, notes)
    }

    #[test]
    fn copies_are_left_out_with_their_nodes_and_marks() {
        for (array, marks) in [(TYPE, [0, 0, 1]), (LEVELS, [0, 0, 2])] {
            let (pieces, notes) = left(vec![lines(array, marks)]);
            assert_eq!((pieces[0].cells.len(), pieces[0].points.len()), (2, 3));
            assert!(pieces[0].cell_arrays.is_empty() && notes.has("ghosts_left_out"));
        }
    }

    #[test]
    fn every_piece_has_the_marks_of_hidden_cells() {
        let (pieces, notes) = left(vec![lines(TYPE, [1, 32, 0]), lines(TYPE, [0, 1, 1])]);
        let marks = |mesh: &Mesh| mesh.cell_arrays[0].values.clone();
        assert_eq!(marks(&pieces[0]), Values::U8(vec![32, 0]));
        assert_eq!(marks(&pieces[1]), Values::U8(vec![0]));
        assert!(notes.has("hidden"));
        let (pieces, notes) = left(vec![lines(TYPE, [0; 3])]);
        assert!(pieces[0].cell_arrays.is_empty() && notes.is_empty());
    }
}

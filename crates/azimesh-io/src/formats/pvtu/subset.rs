//! Some cells of a mesh, with their nodes and arrays, without groups; a piece without its ghost cells, which are copies
//! of cells of neighbouring pieces.

use super::merge::Piece;
use crate::formats::Notes;
use crate::mesh::{DataArray, Mesh, MeshView};
use azimesh_core::note;

/// Bits of the type of a cell: a copy of a neighbour's; not to be shown.
const TYPE: &str = "vtkGhostType";
const DUPLICATE: i64 = 1;
const HIDDEN: i64 = 32;
/// The older array: how far from the piece's own cells.
const LEVELS: &str = "vtkGhostLevels";

/// Takes parts out of a mesh, each in a time that goes by its own size.
pub(super) struct Subsets<'m> {
    mesh: &'m MeshView<'m>,
    /// `u32::MAX` but for the nodes of the part that is taken.
    new_index: Vec<u32>,
}

impl<'m> Subsets<'m> {
    /// Parts of this mesh.
    pub fn of(mesh: &'m MeshView<'m>) -> Self {
        Self {
            mesh,
            new_index: vec![u32::MAX; mesh.points.len()],
        }
    }

    /// These cells, ascending, with their nodes and some more, as a mesh; and its nodes, ascending.
    pub fn take(&mut self, cells: &[usize], more_nodes: &[usize]) -> (Mesh, Vec<usize>) {
        let mesh = self.mesh;
        let mut nodes: Vec<usize> = Vec::new();
        let of_cells = cells.iter().flat_map(|cell| mesh.cells.get(*cell).nodes);
        let of_cells = of_cells.map(|node| *node as usize);
        for node in of_cells.chain(more_nodes.iter().copied()) {
            if self.new_index[node] == u32::MAX {
                self.new_index[node] = 0;
                nodes.push(node);
            }
        }
        nodes.sort_unstable();
        for (new, &old) in nodes.iter().enumerate() {
            self.new_index[old] = new as u32;
        }
        let mut new_cells = mesh.cells.select(cells.iter().copied());
        new_cells.renumber_nodes(&self.new_index);
        for &node in &nodes {
            self.new_index[node] = u32::MAX;
        }
        let part = Mesh {
            points: nodes.iter().map(|&node| mesh.points[node]).collect(),
            cells: new_cells,
            point_arrays: select(&mesh.point_arrays, &nodes),
            cell_arrays: select(&mesh.cell_arrays, cells),
            field_arrays: mesh.field_arrays.iter().copied().cloned().collect(),
            space: mesh.space,
            ..Mesh::default()
        };
        (part, nodes)
    }
}

fn select(arrays: &[&DataArray], keep: &[usize]) -> Vec<DataArray> {
    arrays.iter().map(|array| array.select(keep)).collect()
}

/// The piece without its ghost cells, the nodes of those alone, and the arrays that mark them.
pub(super) fn without_ghosts(mut piece: Piece, notes: &mut Notes) -> Piece {
    let is_ghost = marks(&piece.mesh.cell_arrays, notes);
    if let Some(is_ghost) = is_ghost.filter(|marks| marks.contains(&true)) {
        let cells = 0..piece.mesh.cells.len();
        let (ghosts, own): (Vec<usize>, Vec<usize>) = cells.partition(|cell| is_ghost[*cell]);
        let mut of_ghosts = vec![false; piece.mesh.points.len()];
        for cell in ghosts {
            for &node in piece.mesh.cells.get(cell).nodes {
                of_ghosts[node as usize] = true;
            }
        }
        let others = (0..of_ghosts.len()).filter(|node| !of_ghosts[*node]);
        let others: Vec<usize> = others.collect();
        piece.mesh = Subsets::of(&piece.mesh.view()).take(&own, &others).0;
        notes.push(note!(
            "ghosts_left_out",
            "ghost cells of the pieces are left out"
        ));
    }
    let is_mark = |array: &DataArray| [TYPE, LEVELS].contains(&array.name.as_str());
    piece.mesh.cell_arrays.retain(|array| !is_mark(array));
    piece.mesh.point_arrays.retain(|array| !is_mark(array));
    piece
}

/// Ghost cells, by the array that marks them.
fn marks(arrays: &[DataArray], notes: &mut Notes) -> Option<Vec<bool>> {
    let numbers = |name: &str| {
        let mut arrays = arrays.iter();
        let array = arrays.find(|array| array.name == name && array.n_components == 1);
        array?.values.to_integers()
    };
    if let Some(types) = numbers(TYPE) {
        if types.iter().any(|kind| kind & HIDDEN != 0) {
            notes.push(note!(
                "hidden",
                "cells marked as hidden are read like others"
            ));
        }
        return Some(types.iter().map(|kind| kind & DUPLICATE != 0).collect());
    }
    let levels = numbers(LEVELS)?;
    Some(levels.iter().map(|level| *level > 0).collect())
}

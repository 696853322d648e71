//! Mesh files that can be read by ranges of nodes and cells, so that each rank reads its own.

use super::Notes;
use crate::mesh::{Cells, Mesh};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use std::ops::Range;

/// A mesh in a file that can be read by slabs of nodes or cells. Nodes and cells have the numbers that they
/// have in the mesh that [`Format::read`](super::Format::read) gives.
pub trait Slabs: Send + Sync {
    /// Number of nodes of the mesh.
    fn n_nodes(&self) -> usize;
    /// Number of cells, with boundary faces.
    fn n_cells(&self) -> usize;
    /// [`Mesh::space`](crate::mesh::Mesh::space) of the mesh.
    fn space(&self) -> Option<u8> {
        None
    }
    /// The coordinates of some nodes.
    fn points(&self, nodes: Range<usize>) -> Result<Vec<Vector>>;
    /// Some cells, in memory of about their size; each of their nodes is one of the mesh.
    fn cells(&self, cells: Range<usize>) -> Result<Cells>;
    /// Gives the layout of the mesh, which has the kinds of all cells, its groups and its arrays, which are read as a whole;
    /// notes what a reader of the whole notes.
    ///
    /// # Errors
    /// Why that is not all that the mesh has, as for [`Opened`].
    fn complete(&self, _mesh: &mut Mesh, _notes: &mut Notes) -> std::result::Result<(), Refusal> {
        Err(whole("its groups are not read by themselves"))
    }
}

/// A file opened by slabs, or why it has to be read as a whole: in words that complete "read whole by one rank: ...".
pub type Opened<'a> = std::result::Result<Box<dyn Slabs + 'a>, String>;

/// Why a file is not opened by slabs.
#[derive(Debug)]
pub enum Refusal {
    /// It has to be read as a whole, also to find its fault.
    Whole(String),
    /// It is damaged.
    Damaged(Error),
}

impl From<Error> for Refusal {
    fn from(error: Error) -> Self {
        Self::Damaged(error)
    }
}

/// Refuses a file that has to be read as a whole.
pub(super) fn whole(reason: impl Into<String>) -> Refusal {
    Refusal::Whole(reason.into())
}

/// The result of [`Format::slabs`](super::Format::slabs).
pub(super) fn opened<'a>(
    found: std::result::Result<impl Slabs + 'a, Refusal>,
) -> Result<Opened<'a>> {
    match found {
        Ok(slabs) => Ok(Ok(Box::new(slabs))),
        Err(Refusal::Whole(reason)) => Ok(Err(reason)),
        Err(Refusal::Damaged(error)) => Err(error),
    }
}

/// Of consecutive pieces with their nodes or cells, those that have some of `wanted`, each with these as counted from its
/// first.
pub(super) fn overlapping<P>(
    pieces: &[P],
    items: impl Fn(&P) -> Range<usize>,
    wanted: Range<usize>,
) -> impl Iterator<Item = (&P, Range<usize>)> {
    let first = pieces.partition_point(|piece| items(piece).end <= wanted.start);
    let of_pieces = pieces[first..].iter().map_while(move |piece| {
        let own = items(piece);
        let start = wanted.start.max(own.start) - own.start;
        let end = wanted.end.min(own.end).saturating_sub(own.start);
        (own.start < wanted.end).then_some((piece, start..end))
    });
    of_pieces.filter(|(_, items)| !items.is_empty())
}

/// The coordinates of some nodes of consecutive pieces; `put` sets the nodes of a piece, counted from its first.
pub(super) fn points_of<P>(
    pieces: &[P],
    items: impl Fn(&P) -> Range<usize>,
    nodes: Range<usize>,
    put: impl Fn(&P, Range<usize>, &mut [Vector]) -> Result<()>,
) -> Result<Vec<Vector>> {
    let mut points = vec![[0.0; 3]; nodes.len()];
    let mut rest = &mut points[..];
    for (piece, own) in overlapping(pieces, items, nodes) {
        let (out, others) = rest.split_at_mut(own.len());
        put(piece, own, out)?;
        rest = others;
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_are_cut_where_pieces_end() {
        let pieces = [0..3, 3..3, 3..4, 4..9];
        let cut = |wanted| -> Vec<_> {
            let found = overlapping(&pieces, Clone::clone, wanted);
            found.map(|(piece, own)| (piece.start, own)).collect()
        };
        assert_eq!(cut(0..9), [(0, 0..3), (3, 0..1), (4, 0..5)]);
        assert_eq!(cut(2..5), [(0, 2..3), (3, 0..1), (4, 0..1)]);
        assert_eq!(cut(5..6), [(4, 1..2)]);
        assert_eq!(cut(3..3), []);
        assert_eq!(cut(9..12), []);
    }
}

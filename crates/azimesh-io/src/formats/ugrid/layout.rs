//! The content of a UGRID file, its order, and how its numbers are stored.

use super::{fortran, read};
use crate::formats::number::DType;
use crate::mesh::{CellKind, Cells, Coordinates, Listing, NodesOfCells};
use azimesh_core::parallel::{BLOCK, for_blocks};
use std::borrow::Cow;

/// Kinds of cells in the order of the file, boundary faces first.
pub(super) const KINDS: [CellKind; 6] = [
    CellKind::Triangle,
    CellKind::Quadrilateral,
    CellKind::Tetrahedron,
    CellKind::Pyramid,
    CellKind::Wedge,
    CellKind::Hexahedron,
];
/// Nodes of a cell of each of [`KINDS`].
pub(super) const N_NODES: [usize; 6] = [3, 4, 4, 5, 6, 8];
/// Number of [`KINDS`] that are boundary faces.
pub(super) const N_FACE_KINDS: usize = 2;
/// Names of the counts at the start, as errors call them.
const COUNTED: [&str; 7] = [
    "nodes",
    "triangles",
    "quadrilaterals",
    "tetrahedra",
    "pyramids",
    "prisms",
    "hexahedra",
];
/// VTK's node `i` of a pyramid is UGRID's node `PYRAMID[i]`: in UGRID the third is the apex, and the base goes round by
/// the first, fourth, fifth and second.
const PYRAMID: [usize; 5] = [1, 0, 3, 4, 2];

/// The nodes of cells of a kind in UGRID's order.
pub fn in_order(kind: CellKind, nodes: &[u32]) -> Cow<'_, [u32]> {
    if kind != CellKind::Pyramid {
        return Cow::Borrowed(nodes);
    }
    let mut turned = nodes.to_vec();
    let cells = nodes.chunks_exact(PYRAMID.len());
    for (cell, turned) in cells.zip(turned.chunks_exact_mut(PYRAMID.len())) {
        for (node, to) in cell.iter().zip(PYRAMID) {
            turned[to] = *node;
        }
    }
    Cow::Owned(turned)
}

/// Puts the nodes of pyramids into VTK's order.
fn turn(pyramids: &mut [u32]) {
    for_blocks(pyramids, PYRAMID.len() * BLOCK, &|_, pyramids| {
        for nodes in pyramids.chunks_exact_mut(PYRAMID.len()) {
            let old: [u32; 5] = std::array::from_fn(|i| nodes[i]);
            for (node, from) in nodes.iter_mut().zip(PYRAMID) {
                *node = old[from];
            }
        }
    });
}

/// The counts at the start of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Counts {
    pub n_nodes: usize,
    /// Number of cells of each of [`KINDS`].
    pub n_cells: [usize; 6],
}

impl Counts {
    /// From the seven numbers of a file; a sentence refuses impossible ones.
    pub fn of(numbers: [i64; 7]) -> Result<Self, String> {
        let mut counts = [0; 7];
        for ((count, &number), what) in counts.iter_mut().zip(&numbers).zip(COUNTED) {
            *count = usize::try_from(number).map_err(|_| {
                format!("the number of {what} is {number}; it must be zero or more")
            })?;
        }
        let [n_nodes, n_cells @ ..] = counts;
        let total = n_cells.iter().fold(0usize, |a, b| a.saturating_add(*b));
        if n_nodes.max(total) >= u32::MAX as usize {
            return Err(format!(
                "the counts at the start are {n_nodes} nodes and {total} cells; a mesh can have at most {} of each",
                u32::MAX - 1
            ));
        }
        Ok(Self { n_nodes, n_cells })
    }

    pub fn numbers(&self) -> impl Iterator<Item = u64> {
        let numbers = std::iter::once(self.n_nodes).chain(self.n_cells);
        numbers.map(|n| n as u64)
    }

    pub fn n_faces(&self) -> usize {
        self.n_cells[..N_FACE_KINDS].iter().sum()
    }

    /// Node indices of the first `kinds` of [`KINDS`].
    pub fn n_entries(&self, kinds: usize) -> usize {
        let counts = N_NODES.iter().zip(self.n_cells).take(kinds);
        counts.map(|(n_nodes, n)| n_nodes * n).sum()
    }

    /// Integers before the nodes of a kind: node indices and, before solid cells, face numbers.
    pub fn n_before(&self, kind: usize) -> usize {
        let n_face_numbers = usize::from(kind >= N_FACE_KINDS) * self.n_faces();
        self.n_entries(kind) + n_face_numbers
    }

    /// Integers after the coordinates.
    pub fn n_integers(&self) -> usize {
        self.n_before(KINDS.len())
    }

    /// Cells of these nodes, which are in UGRID's order.
    pub fn cells(&self, mut connectivity: Vec<u32>) -> Cells {
        // Pyramids are the fourth of the kinds.
        turn(&mut connectivity[self.n_entries(3)..self.n_entries(4)]);
        let runs = (0..KINDS.len()).map(|i| (KINDS[i], N_NODES[i], self.n_cells[i]));
        Cells::from_connectivity(connectivity, runs.filter(|(_, _, n)| *n > 0))
    }

    /// Checks if there are nodes and cells.
    pub fn is_mesh(&self) -> bool {
        self.n_nodes > 0 && self.n_cells.iter().any(|n| *n > 0)
    }
}

/// Storage of numbers as bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Binary {
    pub is_big_endian: bool,
    pub real: usize,
    /// Bytes of a count, a node or a face number.
    pub integer: usize,
    /// Between record marks, as Fortran writes.
    pub has_records: bool,
}

/// Storage of numbers: as text, or as bytes.
pub(super) type Layout = Option<Binary>;

/// C binary, or Fortran records.
pub(super) const fn binary(
    is_big_endian: bool,
    real: usize,
    integer: usize,
    has_records: bool,
) -> Layout {
    Some(Binary {
        is_big_endian,
        real,
        integer,
        has_records,
    })
}

/// Checks if the counts at the start fit the length of the file: there is no magic number.
pub(super) fn fits(layout: &Layout, bytes: &[u8]) -> bool {
    layout.map_or_else(|| read::fits_text(bytes), |binary| binary.fits(bytes))
}

impl Binary {
    pub fn header(&self) -> usize {
        7 * self.integer
    }

    /// Bytes after the counts.
    pub fn body(&self, counts: &Counts) -> u128 {
        3 * counts.n_nodes as u128 * self.real as u128
            + counts.n_integers() as u128 * self.integer as u128
    }

    /// The counts, where `bytes` holds them.
    pub fn counts(&self, bytes: &[u8]) -> Option<Result<Counts, String>> {
        let bytes = bytes.get(..self.header())?;
        let mut numbers = [0; 7];
        for (number, bytes) in numbers.iter_mut().zip(bytes.chunks_exact(self.integer)) {
            *number = self.integer(bytes);
        }
        Some(Counts::of(numbers))
    }

    /// Coordinates as ranks write them.
    pub fn coordinates(&self) -> Coordinates {
        Coordinates {
            axis: None,
            is_single: self.real == 4,
            is_big_endian: self.is_big_endian,
        }
    }

    /// The nodes of the cells of a kind, of a mesh of `n_cells`, as ranks write them.
    pub fn nodes_of(&self, kind: CellKind, n_cells: usize) -> NodesOfCells {
        NodesOfCells {
            cells: 0..n_cells,
            kind: Some(kind),
            listing: Listing::Ugrid,
            is_wide: self.integer == 8,
            is_big_endian: self.is_big_endian,
        }
    }

    pub fn integer(&self, bytes: &[u8]) -> i64 {
        DType::integer(bytes.len(), self.is_big_endian)
            .of(bytes)
            .integer(0)
    }

    /// Ignores marks of records: some writers get them wrong.
    fn fits(&self, bytes: &[u8]) -> bool {
        let before = usize::from(self.has_records) * fortran::MARK;
        let Some(Ok(counts)) = bytes.get(before..).and_then(|from| self.counts(from)) else {
            return false;
        };
        let body = self.body(&counts);
        let marks = 2 * fortran::MARK as u128 + fortran::marks(body);
        let marks = u128::from(self.has_records) * marks;
        counts.is_mesh() && bytes.len() as u128 == self.header() as u128 + body + marks
    }
}

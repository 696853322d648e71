//! The content of a UGRID file, its order, and how its numbers are stored.

use crate::formats::Notes;
use crate::mesh::{CellKind, Coordinates, Listing, NodesOfCells};
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
/// How many of [`KINDS`] are boundary faces.
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
/// VTK's node `i` of a pyramid is UGRID's node `PYRAMID[i]`: in UGRID the third is the apex, and
/// the base goes round by the first, fourth, fifth and second.
pub(super) const PYRAMID: [usize; 5] = [1, 0, 3, 4, 2];

/// The nodes of cells of a kind in UGRID's order.
pub fn in_order(kind: CellKind, nodes: &[u32]) -> Cow<'_, [u32]> {
    if kind != CellKind::Pyramid {
        return Cow::Borrowed(nodes);
    }
    let mut turned = vec![0; nodes.len()];
    let cells = nodes.chunks_exact(PYRAMID.len());
    for (cell, turned) in cells.zip(turned.chunks_exact_mut(PYRAMID.len())) {
        for (node, to) in cell.iter().zip(PYRAMID) {
            turned[to] = *node;
        }
    }
    Cow::Owned(turned)
}

/// How numbers are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layout {
    /// As text.
    Text,
    /// As bytes.
    Binary(Binary),
}

/// How numbers are stored as bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Binary {
    /// Most significant byte first.
    pub is_big_endian: bool,
    /// Bytes of a coordinate.
    pub real: usize,
    /// Bytes of a count, a node or a face number.
    pub integer: usize,
    /// Between record marks, as Fortran writes.
    pub has_records: bool,
}

impl Layout {
    /// How numbers are stored as bytes, where they are.
    pub fn binary(&self) -> Option<&Binary> {
        match self {
            Self::Text => None,
            Self::Binary(binary) => Some(binary),
        }
    }

    /// C binary.
    pub const fn c_binary(is_big_endian: bool, real: usize, integer: usize) -> Self {
        Self::Binary(Binary {
            is_big_endian,
            real,
            integer,
            has_records: false,
        })
    }

    /// Fortran records.
    pub const fn fortran(is_big_endian: bool, real: usize) -> Self {
        Self::Binary(Binary {
            is_big_endian,
            real,
            integer: 4,
            has_records: true,
        })
    }
}

/// The counts at the start of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Counts {
    /// Number of nodes.
    pub n_nodes: usize,
    /// Number of cells of each of [`KINDS`].
    pub n_cells: [usize; 6],
}

impl Counts {
    /// From the seven numbers of a file; a sentence refuses what cannot be.
    pub fn of(numbers: [i64; 7]) -> Result<Self, String> {
        let mut counts = [0; 7];
        for ((count, &number), what) in counts.iter_mut().zip(&numbers).zip(COUNTED) {
            *count = usize::try_from(number).map_err(|_| {
                format!("the number of {what} is {number}; it must be zero or more")
            })?;
        }
        let total = counts[1..].iter().fold(0usize, |a, b| a.saturating_add(*b));
        if counts[0].max(total) >= u32::MAX as usize {
            return Err(format!(
                "the counts at the start are {} nodes and {total} cells; a mesh can have at most {} of each",
                counts[0],
                u32::MAX - 1
            ));
        }
        let [n_nodes, n_cells @ ..] = counts;
        Ok(Self { n_nodes, n_cells })
    }

    /// The seven numbers.
    pub fn numbers(&self) -> [u64; 7] {
        let mut numbers = [self.n_nodes as u64; 7];
        for (number, n) in numbers[1..].iter_mut().zip(self.n_cells) {
            *number = n as u64;
        }
        numbers
    }

    /// Number of boundary faces.
    pub fn n_faces(&self) -> usize {
        self.n_cells[..N_FACE_KINDS].iter().sum()
    }

    /// Node indices of the faces, and of all cells.
    pub fn n_entries(&self) -> [usize; 2] {
        let entries = |kinds: usize| {
            let counts = KINDS.iter().zip(self.n_cells).take(kinds);
            counts.map(|(kind, n)| n_nodes(*kind) * n).sum()
        };
        [entries(N_FACE_KINDS), entries(KINDS.len())]
    }

    /// Integers after the coordinates: node indices and face numbers.
    pub fn n_integers(&self) -> usize {
        self.n_entries()[1] + self.n_faces()
    }

    /// Whether there is a mesh at all.
    pub fn is_mesh(&self) -> bool {
        self.n_nodes > 0 && self.n_cells.iter().any(|n| *n > 0)
    }
}

/// The numbers of a file.
pub(super) struct Content {
    /// The counts at its start.
    pub counts: Counts,
    /// Coordinates.
    pub points: Vec<[f64; 3]>,
    /// Node indices of all cells, in the order of [`KINDS`], counted from 0; each is one of the
    /// mesh.
    pub connectivity: Vec<u32>,
    /// Number of each boundary face.
    pub face_numbers: Vec<i32>,
    /// Notes on what is damaged or not kept.
    pub notes: Notes,
}

/// Nodes of a cell of one of [`KINDS`].
pub(super) fn n_nodes(kind: CellKind) -> usize {
    kind.n_nodes()
        .expect("UGRID's kinds have a number of nodes")
}

impl Binary {
    /// Bytes of the seven counts.
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

    /// One signed integer.
    pub fn integer(&self, bytes: &[u8]) -> i64 {
        let extend = |byte: u8| if byte >= 0x80 { -1i64 } else { 0 };
        let append = |value: i64, byte: &u8| value << 8 | i64::from(*byte);
        match self.is_big_endian {
            true => bytes.iter().fold(extend(bytes[0]), append),
            false => bytes
                .iter()
                .rev()
                .fold(extend(bytes[bytes.len() - 1]), append),
        }
    }
}

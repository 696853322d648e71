//! Contents of a file of any storage: nodes, zones of faces with their two cells, zones of cells, names.

use super::numbers::line_of_word;
use azimesh_core::error::{Error, Position};
use std::collections::BTreeMap;
use std::ops::Range;

/// No cell, or no node.
pub(super) const NONE: u32 = u32::MAX;

/// Faces between two cells.
pub(super) const INTERIOR: u32 = 2;
/// Faces that were refined: other faces replace them.
pub(super) const PARENT: u32 = 31;
/// Cells that were refined.
pub(super) const INACTIVE: u32 = 32;
/// The first type of faces where two zones of an interface overlap; these are on the faces of the zones.
pub(super) const OVERLAP: u32 = 1000;

/// The word for a type of zones of faces.
pub(super) fn kind_of_faces(kind: u32) -> &'static str {
    match kind {
        INTERIOR => "interior",
        3 => "wall",
        4 => "pressure-inlet",
        5 => "pressure-outlet",
        7 => "symmetry",
        8 => "periodic-shadow",
        9 => "pressure-far-field",
        10 => "velocity-inlet",
        12 => "periodic",
        14 => "fan",
        20 => "mass-flow-inlet",
        24 => "interface",
        25 => "overset",
        PARENT => "parent",
        36 => "outflow",
        37 => "axis",
        _ => "boundary",
    }
}

/// The word for a type of zones of cells, as HDF5 files number them.
pub(super) fn kind_of_cells(kind: u32) -> &'static str {
    match kind {
        17 => "solid",
        INACTIVE => "inactive",
        _ => "fluid",
    }
}

/// All that a file says of its mesh. Nodes, faces and cells count from 0.
#[derive(Default)]
pub(super) struct Content {
    /// Dimension of the mesh: 2 or 3.
    pub dimension: u8,
    pub points: Vec<[f64; 3]>,
    /// Faces, zone by zone in the order of the file.
    pub faces: Vec<FaceZone>,
    /// Zones of cells in the order of the file.
    pub cells: Vec<CellZone>,
    pub n_cells: usize,
    /// Types and names of zones by their numbers.
    pub names: BTreeMap<u32, Named>,
    /// Faces that were refined: their parts replace them.
    pub refined_faces: Vec<Range<usize>>,
    /// Cells that were refined.
    pub refined_cells: Vec<Range<usize>>,
    /// Pairs of periodic zones: a zone and its shadow.
    pub shadows: Vec<[u32; 2]>,
}

/// A zone's type and name.
pub(super) struct Named {
    /// Word for the type: `wall`, `fluid`.
    pub kind: String,
    pub name: String,
}

/// Some faces of a zone: in 2D edges.
pub(super) struct FaceZone {
    /// Number of the zone.
    pub zone: u32,
    /// The first face.
    pub first: usize,
    /// Number of its type.
    pub kind: u32,
    /// Position of the section in the file.
    pub place: Position,
    /// Bytes of its numbers, if they are text.
    pub body: Option<Range<usize>>,
    pub list: FaceList,
}

/// Faces with the cells on their two sides.
#[derive(Debug, Default, PartialEq)]
pub(super) struct FaceList {
    /// The size of all faces; 0 if `ends` has the end of each in `nodes`.
    pub size: usize,
    pub ends: Vec<u32>,
    /// Nodes of all faces.
    pub nodes: Vec<u32>,
    /// For each face the cell that its normal by the right-hand rule points into, and the other one; in 2D the cell to
    /// the left of the edge, and that to the right. [`NONE`] if there is none.
    pub cells: Vec<[u32; 2]>,
}

/// Some cells of a zone.
pub(super) struct CellZone {
    pub zone: u32,
    pub cells: Range<usize>,
    /// True if they are cells of the mesh now; others were refined.
    pub is_active: bool,
}

impl Content {
    /// The name of a zone; the word for its type and its number if the file gives none.
    pub fn name(&self, zone: u32, kind: &str) -> String {
        match self.names.get(&zone) {
            Some(named) if !named.name.is_empty() => named.name.clone(),
            _ => format!("{kind}-{zone}"),
        }
    }

    /// The word for the type of a zone of faces.
    pub fn kind(&self, zone: &FaceZone) -> &str {
        let named = self.names.get(&zone.zone);
        named.map_or_else(|| kind_of_faces(zone.kind), |named| &named.kind)
    }

    /// Returns whether faces of this zone between two cells are inside of the mesh and nothing else.
    pub fn is_interior(&self, zone: &FaceZone) -> bool {
        self.kind(zone) == "interior"
    }
}

impl FaceList {
    /// Number of faces.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Range of a face in all nodes.
    #[inline]
    pub fn range(&self, face: usize) -> Range<usize> {
        if self.size > 0 {
            return face * self.size..(face + 1) * self.size;
        }
        let start = face.checked_sub(1).map_or(0, |before| self.ends[before]);
        start as usize..self.ends[face] as usize
    }

    /// Nodes of a face.
    #[inline]
    pub fn nodes(&self, face: usize) -> &[u32] {
        &self.nodes[self.range(face)]
    }
}

impl FaceZone {
    /// An error about a face: at the line of one of its words, counted from its first node, if the file is text.
    pub fn error(&self, bytes: &[u8], face: usize, word: usize, message: &str) -> Error {
        let error = Error::input(format!("face {} {message}", self.first + face + 1));
        let Some(body) = &self.body else {
            return error.at(Some(self.place.clone()));
        };
        let before = match self.list.size {
            0 => self.list.range(face).start + 3 * face + 1,
            size => face * (size + 2),
        };
        error.line(line_of_word(bytes, body, before + word))
    }
}

/// Checks that each of `n` items is in one part; fails with the index of a part and a sentence.
pub(super) fn check_cover(
    parts: impl Iterator<Item = Range<usize>>,
    n: usize,
    what: &str,
) -> std::result::Result<(), (usize, String)> {
    let mut parts: Vec<(usize, Range<usize>)> = parts.enumerate().collect();
    parts.sort_by_key(|(_, range)| range.start);
    let (mut end, mut last) = (0, 0);
    let missing =
        |end: usize, next: usize| format!("{what}s {} to {next} are in no section", end + 1);
    for (part, range) in parts.into_iter().filter(|(_, range)| !range.is_empty()) {
        if range.start > end {
            return Err((part, missing(end, range.start)));
        }
        if range.start < end {
            let message = format!("{what} {} is in two sections", range.start + 1);
            return Err((part, message));
        }
        (end, last) = (range.end, part);
    }
    if end < n {
        return Err((last, missing(end, n)));
    }
    Ok(())
}

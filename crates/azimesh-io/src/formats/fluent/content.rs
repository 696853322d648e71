//! What a file holds, in whichever way it is stored: nodes, zones of faces with their two cells, zones of cells, names.

use super::kinds::INTERIOR;
use super::text::line_of_word;
use azimesh_core::error::Error;
use std::collections::BTreeMap;
use std::ops::Range;

/// In place of a cell or a node that is not there.
pub(super) const NONE: u32 = u32::MAX;

/// All that a file says of its mesh.
#[derive(Default)]
pub(super) struct Content {
    /// Dimension of the mesh: 2 or 3.
    pub dimension: u8,
    /// Nodes.
    pub points: Vec<[f64; 3]>,
    /// Faces, zone by zone in the order of the file.
    pub faces: Vec<FaceZone>,
    /// Zones of cells in the order of the file.
    pub cells: Vec<CellZone>,
    /// Number of cells.
    pub n_cells: usize,
    /// Types and names of zones by their numbers.
    pub names: BTreeMap<u32, Named>,
    /// Faces and cells that were refined, from 0: their parts stand in their place.
    pub refined_faces: Vec<Range<usize>>,
    /// As `refined_faces`.
    pub refined_cells: Vec<Range<usize>>,
    /// Pairs of periodic zones: a zone and its shadow.
    pub shadows: Vec<[u32; 2]>,
}

/// A zone's type and name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Named {
    /// Word for its type: `wall`, `fluid`.
    pub kind: String,
    /// Name.
    pub name: String,
}

/// Some faces of a zone: in 2D edges.
pub(super) struct FaceZone {
    /// Number of the zone.
    pub zone: u32,
    /// The first face, from 0.
    pub first: usize,
    /// Number of its type.
    pub kind: u32,
    /// Where it stands in the file.
    pub place: Place,
    /// Where its numbers lie, if they are text.
    pub body: Option<Range<usize>>,
    /// Its faces.
    pub list: FaceList,
}

/// Faces with the cells on their two sides. Nodes and cells count from 0.
#[derive(Debug, Default, PartialEq)]
pub(super) struct FaceList {
    /// The size of all faces; 0 where `ends` tells where each ends in `nodes`.
    pub size: usize,
    /// Ends of the faces, where they have several sizes.
    pub ends: Vec<u32>,
    /// Nodes of all faces.
    pub nodes: Vec<u32>,
    /// For each face the cell that its normal by the right-hand rule points into, and the other one; in 2D the cell to
    /// the left of the edge, and that to the right. [`NONE`] where there is none.
    pub cells: Vec<[u32; 2]>,
}

/// Some cells of a zone.
pub(super) struct CellZone {
    /// Number of the zone.
    pub zone: u32,
    /// Cells, from 0.
    pub cells: Range<usize>,
    /// Whether they are cells of the mesh now; others were refined.
    pub is_active: bool,
}

/// Where something stands in a file.
#[derive(Debug, Clone)]
pub(super) enum Place {
    /// A line of text.
    Line(u64),
    /// A byte, in a file that is not all text.
    Byte(u64),
    /// A dataset of HDF5.
    Dataset(String),
}

impl Place {
    /// An error there.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.of(Error::input(message))
    }

    /// The error, there.
    pub fn of(&self, error: Error) -> Error {
        match self {
            Self::Line(line) => error.line(*line),
            Self::Byte(byte) => error.byte(*byte),
            Self::Dataset(name) => error.dataset(name),
        }
    }
}

impl Content {
    /// The name of a zone; the word for its type and its number where the file gives none.
    pub fn name(&self, zone: u32, kind: &str) -> String {
        match self.names.get(&zone) {
            Some(named) if !named.name.is_empty() => named.name.clone(),
            _ => format!("{kind}-{zone}"),
        }
    }

    /// The word for the type of a zone of faces.
    pub fn kind(&self, zone: &FaceZone) -> String {
        match self.names.get(&zone.zone) {
            Some(named) => named.kind.clone(),
            None => super::kinds::of_faces(zone.kind).to_owned(),
        }
    }

    /// Whether faces of this zone between two cells are inside of the mesh and nothing else.
    pub fn is_interior(&self, zone: &FaceZone) -> bool {
        match self.names.get(&zone.zone) {
            Some(named) => named.kind == "interior",
            None => zone.kind == INTERIOR,
        }
    }
}

impl FaceList {
    /// Number of faces.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Where the nodes of a face lie.
    #[inline]
    pub fn range(&self, face: usize) -> Range<usize> {
        match self.size {
            0 => {
                let start = face.checked_sub(1).map_or(0, |before| self.ends[before]);
                start as usize..self.ends[face] as usize
            }
            size => face * size..(face + 1) * size,
        }
    }

    /// Nodes of a face.
    #[inline]
    pub fn nodes(&self, face: usize) -> &[u32] {
        &self.nodes[self.range(face)]
    }
}

/// What parts do not have once.
#[derive(Debug)]
pub(super) struct Uncovered {
    /// A sentence without a place.
    pub message: String,
    /// The part that it is seen at.
    pub part: usize,
}

/// Checks that parts have each of `n` items once.
pub(super) fn check_cover(
    parts: Vec<Range<usize>>,
    n: usize,
    what: &str,
) -> std::result::Result<(), Uncovered> {
    let mut parts: Vec<(usize, Range<usize>)> = parts.into_iter().enumerate().collect();
    parts.sort_by_key(|(_, range)| range.start);
    let wrong = |part: usize, message: String| Err(Uncovered { message, part });
    let (mut end, mut last) = (0, 0);
    for (part, range) in parts.into_iter().filter(|(_, range)| !range.is_empty()) {
        if range.start > end {
            return wrong(part, missing(end..range.start, what));
        }
        if range.start < end {
            let message = format!("{what} {} is in two sections", range.start + 1);
            return wrong(part, message);
        }
        (end, last) = (range.end, part);
    }
    match end < n {
        true => wrong(last, missing(end..n, what)),
        false => Ok(()),
    }
}

fn missing(range: Range<usize>, what: &str) -> String {
    format!(
        "{what}s {} to {} are in no section",
        range.start + 1,
        range.end
    )
}

impl FaceZone {
    /// Where a word of a face stands, counted from its first node: its line, in text.
    pub fn place_of(&self, bytes: &[u8], face: usize, word: usize) -> Place {
        let Some(body) = &self.body else {
            return self.place.clone();
        };
        let before = match self.list.size {
            0 => self.list.range(face).start + 3 * face + 1,
            size => face * (size + 2),
        };
        Place::Line(line_of_word(bytes, body, before + word))
    }
}

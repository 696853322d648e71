//! What a file holds, in whichever way it is stored: nodes, zones of faces with their two cells, zones of cells, names.

use super::kinds::INTERIOR;
use crate::error::Error;
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

/// Checks that parts have each of `n` items once.
///
/// # Errors
/// A sentence without a place.
pub(super) fn check_cover(
    mut parts: Vec<Range<usize>>,
    n: usize,
    what: &str,
) -> std::result::Result<(), String> {
    parts.sort_by_key(|part| part.start);
    let mut end = 0;
    for part in parts.iter().filter(|part| !part.is_empty()) {
        if part.start > end {
            return Err(missing(end..part.start, what));
        }
        if part.start < end {
            return Err(format!("{what} {} is in two sections", part.start + 1));
        }
        end = part.end;
    }
    match end < n {
        true => Err(missing(end..n, what)),
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

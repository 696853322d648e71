//! The mesh of a decomposed case: reads the pieces of `processorN` or collated `processorsN` folders, and joins them by
//! the numbers that their cells, faces and points had in the whole (`addressed`) or, without these, by the faces that
//! they share (`matched`).

use super::case::{Case, Instances};
use super::file::FoamFile;
use super::folders::{Pieces, Step};
use super::read::{LabelFiles, Lists};
use super::topology::{Patch, StoredFile, StoredPiece, StoredPieces};
use super::zones::{self, Zone, of_name};
use super::{addressed, lists, matched};
use crate::formats::Notes;
use crate::formats::names::Places;
use azimesh_core::diagnostic::formats::Foam;
use azimesh_core::error::{Error, Result};
use std::path::PathBuf;

/// One piece of a decomposed case.
pub(super) struct Piece {
    /// Its number.
    pub number: usize,
    /// The folder of its files, for errors.
    pub folder: PathBuf,
    /// Its mesh, with the numbers of the piece.
    pub lists: Lists,
    /// Its numbers in the whole.
    pub numbers: Option<Numbers>,
}

/// What points, faces and cells of a piece are called in the whole.
pub(super) struct Numbers {
    pub points: Vec<u32>,
    /// From 1 on; negative where the face is turned round.
    pub faces: Vec<i64>,
    pub cells: Vec<u32>,
}

impl Piece {
    /// An error in this piece.
    pub fn refuse(&self, message: String) -> Error {
        let piece = format!("piece {}", self.number);
        Error::input(message).file(&self.folder).dataset(&piece)
    }

    /// Patches that are shared with other pieces.
    pub fn shared(&self) -> impl Iterator<Item = &Patch> {
        self.lists.patches.iter().filter(|patch| is_shared(patch))
    }
}

/// Whether a patch is there only because the mesh is in pieces.
pub(super) fn is_shared(patch: &Patch) -> bool {
    patch.kind.starts_with("processor")
}

/// The patch of the whole that the faces of a piece's patch are in, `None` where they lie between two cells.
pub(super) fn whole_patch(patch: &Patch) -> Option<&str> {
    match is_shared(patch) {
        false => Some(&patch.name),
        true => patch.entry("referPatch"),
    }
}

/// The names of the files that say what points, faces, cells and patches of a piece are called in the whole.
const NUMBERS: [&str; 4] = [
    "pointProcAddressing",
    "faceProcAddressing",
    "cellProcAddressing",
    "boundaryProcAddressing",
];

/// The zones of all pieces, those of one name as one; `whole` gives the number in the whole of a cell of a piece.
pub(super) fn zones_of(pieces: &[Piece], whole: impl Fn(&Piece, u32) -> u32) -> Vec<Zone> {
    let mut zones: Vec<Zone> = Vec::new();
    let mut places = Places::default();
    for piece in pieces {
        for zone in &piece.lists.zones {
            let labels = zone.labels.iter().map(|cell| whole(piece, *cell));
            of_name(&zone.name, &mut zones, &mut places).extend(labels);
        }
    }
    zones
}

/// Reads and joins the pieces at a step; gives what is left for the writer too.
pub(super) fn read(
    case: &Case,
    step: &Step,
    notes: &mut Notes,
) -> Result<(Lists, Vec<StoredPieces>)> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut stored = Vec::new();
    for folder in &case.pieces {
        let files = pieces_of(folder, &case.of_pieces(folder, step), &mut pieces)?;
        stored.push((folder, files));
    }
    for (i, piece) in pieces.iter().enumerate() {
        if piece.number != i {
            return Err(
                Error::input(format!("the case is decomposed, but piece {i} is missing"))
                    .file(&case.root),
            );
        }
    }
    let has_numbers = |piece: &Piece| piece.numbers.is_some();
    let n = pieces.len();
    let (lists, nodes, by) = match pieces.iter().all(has_numbers) {
        true => {
            let lists = addressed::join(&pieces)?;
            let numbers = pieces.iter_mut().map(|piece| piece.numbers.take());
            let nodes = numbers.map(|numbers| numbers.map_or(Vec::new(), |numbers| numbers.points));
            (lists, nodes.collect(), "the numbers of the whole")
        }
        false => {
            let (lists, nodes) = matched::join(&pieces)?;
            (lists, nodes, "the faces that they share")
        }
    };
    notes.push(Foam::Joined { n, by });
    Ok((lists, left(stored, pieces, nodes)))
}

/// What is left for the writer: files folder by folder, and of each piece its nodes in the whole and its patches.
fn left(
    folders: Vec<(&Pieces, Vec<StoredFile>)>,
    pieces: Vec<Piece>,
    nodes: Vec<Vec<u32>>,
) -> Vec<StoredPieces> {
    let mut all = pieces.into_iter().zip(nodes).peekable();
    let mut left = Vec::new();
    for (folder, files) in folders {
        let name = folder.folder.file_name().unwrap_or_default();
        let mut own = Vec::new();
        while let Some((piece, nodes)) = all.next_if(|(piece, _)| piece.folder == folder.folder) {
            own.push(StoredPiece {
                nodes,
                patches: piece.lists.patches,
            });
        }
        left.push(StoredPieces {
            folder: name.to_string_lossy().into_owned(),
            is_collated: folder.is_collated,
            files,
            pieces: own,
        });
    }
    left
}

/// Reads the pieces of one folder; gives the files of their topology.
fn pieces_of(
    folder: &Pieces,
    found: &Instances,
    pieces: &mut Vec<Piece>,
) -> Result<Vec<StoredFile>> {
    let topology = found.since_faces();
    let files = |instances: &Instances, name: &str| -> Result<Option<Vec<FoamFile>>> {
        let Some(file) = instances.find(name)? else {
            return Ok(None);
        };
        Ok(Some(match folder.is_collated {
            true => file.blocks()?,
            false => vec![file],
        }))
    };
    let needed = |instances: &Instances, name: &str| {
        let missing =
            || Error::input(format!("the mesh has no file \"{name}\"")).file(&folder.folder);
        files(instances, name)?.ok_or_else(missing)
    };
    let points = needed(found, "points")?;
    let [faces, owner, neighbour, boundary] = ["faces", "owner", "neighbour", "boundary"];
    let mesh = [faces, owner, neighbour, boundary].map(|name| needed(&topology, name));
    let [faces, owner, neighbour, boundary] = mesh;
    let mesh = [faces?, owner?, neighbour?, boundary?];
    let [points_in, faces_in, cells_in, _] = NUMBERS;
    let further = [points_in, faces_in, cells_in, "cellZones"];
    let further = further.map(|name| files(&topology, name));
    let mut optional = Vec::new();
    for files in further {
        optional.push(files?);
    }
    let n = points.len();
    for list in mesh.iter().chain(optional.iter().flatten()) {
        if list.len() != n {
            let message = format!("the file has {} blocks, but \"points\" has {n}", list.len());
            let file = list.first().unwrap_or(&points[0]);
            return Err(file.refuse(Error::input(message).byte(0)));
        }
    }
    for (i, points) in points.iter().enumerate() {
        let files = LabelFiles {
            faces: mesh[0][i].clone(),
            owner: mesh[1][i].clone(),
            neighbour: mesh[2][i].clone(),
            boundary: mesh[3][i].clone(),
        };
        let of_piece = |list: &Option<Vec<FoamFile>>| list.as_ref().map(|list| list[i].clone());
        let mut lists = files.lists(points)?;
        if let Some(file) = of_piece(&optional[3]) {
            lists.zones = zones::zones(&file, "cellLabels", lists.owner.len())?;
        }
        let numbers = [0, 1, 2].map(|i| of_piece(&optional[i]));
        pieces.push(Piece {
            number: folder.first + i,
            folder: folder.folder.clone(),
            numbers: numbers_of(&lists, numbers)?,
            lists,
        });
    }
    stored_files(&topology)
}

/// The files of the topology as they are.
fn stored_files(topology: &Instances) -> Result<Vec<StoredFile>> {
    let mesh = ["faces", "owner", "neighbour", "boundary"];
    let zones = ["cellZones", "faceZones", "pointZones"];
    let mut stored = Vec::new();
    for name in mesh.into_iter().chain(zones).chain(NUMBERS) {
        stored.extend(topology.find(name)?.as_ref().map(StoredFile::of));
    }
    Ok(stored)
}

/// The numbers of a piece in the whole, where all of them are there and fit.
fn numbers_of(of: &Lists, files: [Option<FoamFile>; 3]) -> Result<Option<Numbers>> {
    let [Some(points), Some(faces), Some(cells)] = files else {
        return Ok(None);
    };
    let index = |label: i64| {
        u32::try_from(label)
            .ok()
            .filter(|label| *label < u32::MAX - 1)
    };
    let most = of.owner.len();
    let numbers = Numbers {
        points: lists::labels(&points, most, index)?,
        faces: lists::labels(&faces, most, |label| {
            let is_number = label != 0 && label.unsigned_abs() < u64::from(u32::MAX);
            is_number.then_some(label)
        })?,
        cells: lists::labels(&cells, most, index)?,
    };
    for (file, found, needed) in [
        (&points, numbers.points.len(), of.points.len()),
        (&faces, numbers.faces.len(), of.faces.len()),
        (&cells, numbers.cells.len(), of.n_cells()),
    ] {
        if found != needed {
            let message = format!("the list has {found} numbers; the piece needs {needed}");
            return Err(file.refuse(file.text().error(message)));
        }
    }
    Ok(Some(numbers))
}

//! The mesh of a decomposed case: reads the pieces of `processorN` or collated `processorsN` folders, and joins them by
//! the numbers that their points, faces and cells have in the whole. Pieces without files of these numbers get them from
//! the faces that they share.

use super::case::{Case, Step};
use super::lists;
use super::read::{Files, Lists, read_lists};
use super::topology::{Patch, StoredPiece, StoredPieces};
use super::zones::{Zone, of_name};
use crate::formats::Notes;
use crate::formats::by_faces::{Faces, Label, NONE};
use crate::formats::names::Places;
use crate::mesh::UnionFind;
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::note;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;

/// Distance of the nodes of one face in two pieces, times the largest coordinate.
const SAME_PLACE: f64 = 1e-6;

/// Files of the numbers that points, faces, cells and patches of a piece have in the whole.
const NUMBERS: [&str; 4] = [
    "pointProcAddressing",
    "faceProcAddressing",
    "cellProcAddressing",
    "boundaryProcAddressing",
];

/// One piece of a decomposed case.
struct Piece {
    /// Its number.
    number: usize,
    /// The folder of its files, for errors.
    folder: PathBuf,
    /// Its mesh, with the numbers of the piece.
    lists: Lists,
    /// Its numbers in the whole.
    numbers: Numbers,
}

/// Numbers in the whole of the points, faces and cells of a piece.
#[derive(Default)]
struct Numbers {
    points: Vec<u32>,
    /// From 1 on; negative where the face is turned round.
    faces: Vec<i64>,
    cells: Vec<u32>,
}

impl Piece {
    /// An error in this piece.
    fn refuse(&self, message: String) -> Error {
        let piece = format!("piece {}", self.number);
        Error::input(message).file(&self.folder).dataset(&piece)
    }

    /// The patches between this piece and another one.
    fn shared(&self) -> impl Iterator<Item = &Patch> {
        let patches = self.lists.patches.iter();
        patches.filter(|patch| is_shared(patch) && whole_patch(patch).is_none())
    }

    /// Index in the whole of a face, and whether the face is turned round.
    fn whole_face(&self, face: usize) -> (usize, bool) {
        let number = self.numbers.faces[face];
        (number.unsigned_abs() as usize - 1, number < 0)
    }

    /// Refuses a number that is not below the number of things in all pieces.
    fn check_number(&self, what: &str, number: usize, n: usize) -> Result<()> {
        if number < n {
            return Ok(());
        }
        Err(self.refuse(format!(
            "a {what} has number {number} in the whole, but all pieces have only {n} {what}s together"
        )))
    }
}

/// Checks if a patch is there only because the mesh is in pieces.
fn is_shared(patch: &Patch) -> bool {
    patch.kind.starts_with("processor")
}

/// The patch of the whole that the faces of a piece's patch are in; `None` of faces between two cells.
fn whole_patch(patch: &Patch) -> Option<&str> {
    if is_shared(patch) {
        patch.entry("referPatch")
    } else {
        Some(&patch.name)
    }
}

fn faces_of(patch: &Patch) -> Range<usize> {
    patch.start_face..patch.start_face + patch.n_faces
}

/// Reads and joins the pieces at a step. Returns the whole mesh, and what the writer needs of the pieces.
pub(super) fn read(
    case: &Case,
    step: &Step,
    notes: &mut Notes,
) -> Result<(Lists, Vec<StoredPieces>)> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut has_numbers = true;
    let mut folders = Vec::new();
    for dirs in &case.pieces {
        let folder = case.path.root.join(&dirs.name);
        let found = case.folders(step, Some(dirs));
        let (meshes, files) = read_lists(&found, Some((dirs, &folder)), &NUMBERS)?;
        folders.push((dirs, files, meshes.len()));
        for (i, (lists, files)) in meshes.into_iter().enumerate() {
            let numbers = read_numbers(&lists, &files)?;
            has_numbers &= numbers.is_some();
            pieces.push(Piece {
                number: dirs.first + i,
                folder: folder.clone(),
                lists,
                numbers: numbers.unwrap_or_default(),
            });
        }
    }
    if let Some(i) = (0..pieces.len()).find(|i| pieces[*i].number != *i) {
        let message = format!("the case is decomposed, but piece {i} is missing");
        return Err(Error::input(message).file(&case.path.root));
    }
    if !has_numbers {
        let numbers = find_numbers(&pieces)?;
        for (piece, numbers) in pieces.iter_mut().zip(numbers) {
            piece.numbers = numbers;
        }
    }
    let lists = join(&pieces)?;
    let n = pieces.len();
    let by = if has_numbers {
        "the numbers of the whole"
    } else {
        "the faces that they share"
    };
    let n = counted(n, "piece");
    notes.push(note!(
        "pieces_joined",
        "the mesh is joined from {n} by {by}"
    ));
    let mut stored = pieces.into_iter().map(|piece| StoredPiece {
        nodes: piece.numbers.points,
        patches: piece.lists.patches,
    });
    let folders = folders.into_iter().map(|(dirs, files, n)| StoredPieces {
        folder: dirs.name.clone(),
        is_collated: dirs.is_collated,
        files,
        pieces: stored.by_ref().take(n).collect(),
    });
    Ok((lists, folders.collect()))
}

/// The numbers of a piece in the whole, where all files of them are there.
fn read_numbers(of: &Lists, files: &Files) -> Result<Option<Numbers>> {
    let [Some(points), Some(faces), Some(cells)] = [0, 1, 2].map(|i| files.get(NUMBERS[i])) else {
        return Ok(None);
    };
    let index = |label: i64| {
        let index = u32::try_from(label).ok();
        index.filter(|index| *index < u32::MAX - 1)
    };
    let most = of.owner.len();
    let numbers = Numbers {
        points: lists::labels(points, most, index)?,
        faces: lists::labels(faces, most, |label| {
            let is_number = label != 0 && label.unsigned_abs() < u64::from(u32::MAX);
            is_number.then_some(label)
        })?,
        cells: lists::labels(cells, most, index)?,
    };
    for (file, found, needed) in [
        (points, numbers.points.len(), of.points.len()),
        (faces, numbers.faces.len(), of.faces.len()),
        (cells, numbers.cells.len(), of.n_cells()),
    ] {
        if found != needed {
            let message = format!("the list has {found} numbers; the piece needs {needed}");
            return Err(file.refuse(file.text().error(message)));
        }
    }
    Ok(Some(numbers))
}

/// The whole mesh, in the order of the numbers.
fn join(pieces: &[Piece]) -> Result<Lists> {
    // Of a face in two pieces, the one that is not turned round.
    let faces = pieces.iter().flat_map(|piece| {
        (0..piece.lists.faces.len()).map(move |face| {
            let (number, is_turned) = piece.whole_face(face);
            (piece, number, (piece.number, face, is_turned))
        })
    });
    let n_faces = pieces.iter().map(|piece| piece.lists.faces.len()).sum();
    let places = in_order(pieces, "face", n_faces, faces, |old, new| old.2 && !new.2)?;
    let (owner, neighbour) = sides(pieces, places.len())?;
    let n_internal = neighbour.iter().take_while(|cell| **cell != NONE).count();
    if let Some(face) = (n_internal..neighbour.len()).find(|face| neighbour[*face] != NONE) {
        return Err(pieces[0].refuse(format!(
            "face {face} of the whole mesh is between two cells, but face {n_internal} before it is not"
        )));
    }
    let patches = patches(pieces, n_internal)?;
    let mut faces = Faces::default();
    for (piece, face, is_turned) in places {
        let piece = &pieces[piece];
        let nodes = piece.lists.faces.view().get(face);
        let whole = |node: &Label| piece.numbers.points[node.get() as usize];
        if is_turned {
            faces.push(turned(nodes).map(whole));
        } else {
            faces.push(nodes.iter().map(whole));
        }
    }
    let points = pieces.iter().flat_map(|piece| {
        let numbers = piece.numbers.points.iter().zip(&piece.lists.points);
        numbers.map(move |(number, point)| (piece, *number as usize, *point))
    });
    let n_points = pieces.iter().map(|piece| piece.lists.points.len()).sum();
    Ok(Lists {
        points: in_order(pieces, "point", n_points, points, |_, _| false)?,
        faces,
        owner: owner.into(),
        neighbour: neighbour[..n_internal].to_vec().into(),
        patches,
        zones: zones(pieces),
    })
}

/// The nodes of a face from the other side.
fn turned(nodes: &[Label]) -> impl Iterator<Item = &Label> + Clone {
    nodes[..1].iter().chain(nodes[1..].iter().rev())
}

/// Values at the places of their numbers. Of two with one number the first is taken unless the second `replaces` it.
fn in_order<'p, T: Copy>(
    pieces: &[Piece],
    what: &str,
    n: usize,
    values: impl Iterator<Item = (&'p Piece, usize, T)>,
    replaces: impl Fn(T, T) -> bool,
) -> Result<Vec<T>> {
    let mut all: Vec<Option<T>> = Vec::new();
    for (piece, number, value) in values {
        piece.check_number(what, number, n)?;
        if number >= all.len() {
            all.resize(number + 1, None);
        }
        if all[number].is_none_or(|old| replaces(old, value)) {
            all[number] = Some(value);
        }
    }
    let missing = |i| pieces[0].refuse(format!("{what} {i} of the whole is in no piece"));
    let all = all.into_iter().enumerate();
    all.map(|(i, value)| value.ok_or_else(|| missing(i)))
        .collect()
}

/// Owners and neighbours of the faces of the whole.
fn sides(pieces: &[Piece], n_faces: usize) -> Result<(Vec<u32>, Vec<u32>)> {
    let n_cells: usize = pieces.iter().map(|piece| piece.lists.n_cells()).sum();
    let mut owner = vec![NONE; n_faces];
    let mut neighbour = vec![NONE; n_faces];
    for piece in pieces {
        let cells = &piece.numbers.cells;
        for cell in cells {
            piece.check_number("cell", *cell as usize, n_cells)?;
        }
        let (owners, neighbours) = (piece.lists.owner.view(), piece.lists.neighbour.view());
        for face in 0..owners.len() {
            let (number, is_turned) = piece.whole_face(face);
            let cell =
                |label: Option<&Label>| label.map_or(NONE, |cell| cells[cell.get() as usize]);
            let mut own = [cell(owners.get(face)), cell(neighbours.get(face))];
            if is_turned {
                own.reverse();
            }
            for (side, cell) in [&mut owner[number], &mut neighbour[number]]
                .into_iter()
                .zip(own)
            {
                if cell != NONE && ![NONE, cell].contains(side) {
                    return Err(piece.refuse(format!(
                        "face {number} of the whole has cells {side} and {cell} on one side"
                    )));
                }
                if cell != NONE {
                    *side = cell;
                }
            }
        }
    }
    if let Some(face) = owner.iter().position(|cell| *cell == NONE) {
        return Err(pieces[0].refuse(format!(
            "face {face} of the whole has no owner in any piece"
        )));
    }
    Ok((owner, neighbour))
}

/// The patches of the whole by their names, each once, in the order of the pieces.
fn whole_patches(pieces: &[Piece]) -> Vec<Patch> {
    let (mut patches, mut places) = (Vec::new(), Places::default());
    let all = pieces.iter().flat_map(|piece| &piece.lists.patches);
    for patch in all.filter(|patch| !is_shared(patch)) {
        places.entry(&patch.name, &mut patches, || patch.clone());
    }
    patches
}

/// The patches of the whole; the faces of each must be in a row.
fn patches(pieces: &[Piece], n_internal: usize) -> Result<Vec<Patch>> {
    // First and last face and number of faces of each name.
    let mut found: BTreeMap<&str, (usize, usize, usize)> = BTreeMap::new();
    for piece in pieces {
        for patch in &piece.lists.patches {
            let Some(name) = whole_patch(patch) else {
                continue;
            };
            for face in faces_of(patch) {
                let (number, _) = piece.whole_face(face);
                let span = found.entry(name).or_insert((number, number, 0));
                *span = (span.0.min(number), span.1.max(number), span.2 + 1);
            }
        }
    }
    let mut patches = whole_patches(pieces);
    let mut end = n_internal;
    for patch in &mut patches {
        (patch.start_face, patch.n_faces) = match found.get(&*patch.name) {
            Some((first, last, n)) if last - first + 1 == *n => (*first, *n),
            Some(_) => {
                let name = &patch.name;
                let message =
                    format!("the faces of patch \"{name}\" are not in a row in the whole");
                return Err(Error::input(message)
                    .file(&pieces[0].folder)
                    .dataset("faceProcAddressing"));
            }
            None => (end, 0),
        };
        end = patch.start_face + patch.n_faces;
    }
    patches.sort_by_key(|patch| patch.start_face);
    Ok(patches)
}

/// The zones of all pieces, joined by name.
fn zones(pieces: &[Piece]) -> Vec<Zone> {
    let (mut zones, mut places) = (Vec::new(), Places::default());
    for piece in pieces {
        let cells = &piece.numbers.cells;
        for zone in &piece.lists.zones {
            let labels = zone.labels.iter();
            let labels = labels.map(|cell| cells.get(*cell as usize).copied().unwrap_or(NONE));
            of_name(&zone.name, &mut zones, &mut places).extend(labels);
        }
    }
    zones
}

/// Numbers for pieces without files of them. Points and cells come piece by piece. So do faces: first inside the pieces,
/// then between two pieces, then on each patch. Two patches between two pieces have their faces in
/// one order, each face turned round and with the same first node.
fn find_numbers(pieces: &[Piece]) -> Result<Vec<Numbers>> {
    let starts_of = |n: fn(&Lists) -> usize| {
        let mut starts = vec![0];
        for piece in pieces {
            starts.push(starts[piece.number] + n(&piece.lists));
        }
        starts
    };
    let point_starts = starts_of(|lists| lists.points.len());
    let cell_starts = starts_of(Lists::n_cells);
    let n_points = point_starts[pieces.len()];
    if n_points.max(cell_starts[pieces.len()]) >= u32::MAX as usize {
        return Err(pieces[0].refuse(crate::mesh::too_many("nodes or cells")));
    }
    let mut n = 0;
    let mut next = || {
        n += 1;
        n
    };
    let inside = pieces.iter().map(|piece| {
        let mut faces = vec![0; piece.lists.faces.len()];
        let inside = piece.lists.neighbour.len();
        faces[..inside].fill_with(&mut next);
        faces
    });
    let mut faces: Vec<Vec<i64>> = inside.collect();
    let mut same = UnionFind::new(n_points);
    for piece in pieces {
        for patch in piece.shared() {
            let (other, theirs) = partner(pieces, piece, patch)?;
            for pair in faces_of(patch).zip(faces_of(theirs)) {
                join_nodes(&mut same, &point_starts, [piece, other], pair.into())?;
                if piece.number < other.number {
                    faces[piece.number][pair.0] = next();
                    faces[other.number][pair.1] = -faces[piece.number][pair.0];
                }
            }
        }
    }
    for patch in whole_patches(pieces) {
        for piece in pieces {
            let is_part = |own: &&Patch| own.n_faces > 0 && whole_patch(own) == Some(&patch.name);
            for own in piece.lists.patches.iter().filter(is_part) {
                faces[piece.number][faces_of(own)].fill_with(&mut next);
            }
        }
    }
    let in_no_patch = faces.iter_mut().flatten().filter(|number| **number == 0);
    in_no_patch.for_each(|number| *number = next());
    // The number of a point is the number of the first point at its place.
    let (mut new_index, mut n) = (Vec::with_capacity(n_points), 0);
    for i in 0..n_points {
        let first = same.of(i as u32) as usize;
        new_index.push(new_index.get(first).copied().unwrap_or(n));
        n += u32::from(first == i);
    }
    let numbers = faces.into_iter().enumerate().map(|(i, faces)| Numbers {
        points: new_index[point_starts[i]..point_starts[i + 1]].to_vec(),
        faces,
        cells: (cell_starts[i] as u32..cell_starts[i + 1] as u32).collect(),
    });
    Ok(numbers.collect())
}

/// The patch on the other side of one between two pieces, and its piece.
fn partner<'p>(
    pieces: &'p [Piece],
    piece: &Piece,
    patch: &Patch,
) -> Result<(&'p Piece, &'p Patch)> {
    let name = &patch.name;
    let number = patch.entry("neighbProcNo");
    let number: Option<usize> = number.and_then(|number| number.parse().ok());
    let number = number.ok_or_else(|| {
        piece.refuse(format!(
            "patch \"{name}\" does not name the piece on its other side (neighbProcNo)"
        ))
    })?;
    let other = pieces.get(number).filter(|_| number != piece.number);
    let other = other.ok_or_else(|| {
        piece.refuse(format!(
            "patch \"{name}\" is shared with piece {number}, which is not there"
        ))
    })?;
    let back = piece.number.to_string();
    let mut theirs = other.shared();
    let theirs = theirs.find(|theirs| theirs.entry("neighbProcNo") == Some(&back));
    let theirs = theirs.filter(|theirs| theirs.n_faces == patch.n_faces);
    let theirs = theirs.ok_or_else(|| {
        piece.refuse(format!(
            "patch \"{name}\" has {} faces, but piece {number} has no patch of as many on the other side",
            patch.n_faces
        ))
    })?;
    Ok((other, theirs))
}

/// Joins the nodes of a face in two pieces, whose points begin at `starts`.
fn join_nodes(
    same: &mut UnionFind,
    starts: &[usize],
    pieces: [&Piece; 2],
    faces: [usize; 2],
) -> Result<()> {
    let [one, other] = [0, 1].map(|i| pieces[i].lists.faces.view().get(faces[i]));
    let [a, b] = pieces.map(|piece| &piece.lists.points);
    let is_near = |(one, other): (&Label, &Label)| {
        let [p, q] = [a[one.get() as usize], b[other.get() as usize]];
        let size = p.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        (0..3).all(|i| (p[i] - q[i]).abs() <= SAME_PLACE * size.max(f64::MIN_POSITIVE))
    };
    if one.len() != other.len() || !one.iter().zip(turned(other)).all(is_near) {
        return Err(pieces[0].refuse(format!(
            "face {} is not face {} of piece {}, which should be the same",
            faces[0], faces[1], pieces[1].number
        )));
    }
    let [first, second] = pieces.map(|piece| starts[piece.number] as u32);
    for (one, other) in one.iter().zip(turned(other)) {
        same.join(&[first + one.get(), second + other.get()]);
    }
    Ok(())
}

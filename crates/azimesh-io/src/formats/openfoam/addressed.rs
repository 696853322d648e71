//! Pieces joined by the numbers that their points, faces and cells have in the whole: the result is the mesh that was
//! decomposed, in its order.

use super::decomposed::{Piece, is_shared, whole_patch, zones_of};
use super::read::Lists;
use super::topology::Patch;
use crate::formats::by_faces::Faces;
use crate::formats::by_faces::Label;
use crate::formats::by_faces::NONE;
use crate::formats::names::Places;
use azimesh_core::error::{Error, Result};
use std::collections::BTreeMap;

/// Where a face of the whole is found.
#[derive(Clone, Copy)]
struct Place {
    piece: u32,
    face: u32,
    is_turned: bool,
}

/// The whole mesh.
pub(super) fn join(pieces: &[Piece]) -> Result<Lists> {
    let places = places(pieces)?;
    let (owner, neighbour) = sides(pieces, places.len())?;
    let n_internal = neighbour.iter().take_while(|cell| **cell != NONE).count();
    if let Some(face) = (n_internal..neighbour.len()).find(|face| neighbour[*face] != NONE) {
        return Err(pieces[0].refuse(format!(
            "face {face} of the whole lies between two cells, but face {n_internal} before it does not"
        )));
    }
    let patches = patches(pieces, owner.len())?;
    let mut faces = Faces::default();
    for place in &places {
        let piece = &pieces[place.piece as usize];
        let numbers = piece.numbers.as_ref().expect("all pieces have numbers");
        let nodes = piece.lists.faces.view().get(place.face as usize);
        let whole = |node: &Label| numbers.points[node.get() as usize];
        match place.is_turned {
            false => faces.push(nodes.iter().map(whole)),
            true => faces.push(nodes[..1].iter().chain(nodes[1..].iter().rev()).map(whole)),
        }
    }
    Ok(Lists {
        points: points(pieces)?,
        faces,
        owner: owner.into(),
        neighbour: neighbour[..n_internal].to_vec().into(),
        patches,
        zones: zones_of(pieces, |piece, cell| {
            let cells = &numbers(piece).cells;
            cells.get(cell as usize).copied().unwrap_or(NONE)
        }),
    })
}

/// The numbers of a piece; every piece has them here.
fn numbers(piece: &Piece) -> &super::decomposed::Numbers {
    piece.numbers.as_ref().expect("all pieces have numbers")
}

/// Number in the whole of a face, from 0, and whether it is turned round.
fn number_of(piece: &Piece, face: usize) -> (usize, bool) {
    let number = numbers(piece).faces[face];
    (number.unsigned_abs() as usize - 1, number < 0)
}

/// Refuses a number for which there are not as many things in all pieces.
fn check_number(piece: &Piece, what: &str, number: usize, n: usize) -> Result<()> {
    match number < n {
        true => Ok(()),
        false => Err(piece.refuse(format!(
            "a {what} has number {number} in the whole, but all pieces have only {n} {what}s together"
        ))),
    }
}

/// One place for each face of the whole: one that is not turned round, where there is one.
fn places(pieces: &[Piece]) -> Result<Vec<Place>> {
    let n_all = pieces.iter().map(|piece| piece.lists.faces.len()).sum();
    let mut places: Vec<Option<Place>> = Vec::new();
    for (i, piece) in pieces.iter().enumerate() {
        for face in 0..piece.lists.faces.len() {
            let (number, is_turned) = number_of(piece, face);
            check_number(piece, "face", number, n_all)?;
            if number >= places.len() {
                places.resize(number + 1, None);
            }
            let place = &mut places[number];
            if place.is_none_or(|place| place.is_turned && !is_turned) {
                *place = Some(Place {
                    piece: i as u32,
                    face: face as u32,
                    is_turned,
                });
            }
        }
    }
    let missing = |i| pieces[0].refuse(format!("face {i} of the whole is in no piece"));
    let all = places.into_iter().enumerate();
    all.map(|(i, place)| place.ok_or_else(|| missing(i)))
        .collect()
}

/// Owners and neighbours of the faces of the whole.
fn sides(pieces: &[Piece], n_faces: usize) -> Result<(Vec<u32>, Vec<u32>)> {
    let n_cells: usize = pieces.iter().map(|piece| piece.lists.n_cells()).sum();
    let mut owner = vec![NONE; n_faces];
    let mut neighbour = vec![NONE; n_faces];
    for piece in pieces {
        let cells = &numbers(piece).cells;
        for cell in cells {
            check_number(piece, "cell", *cell as usize, n_cells)?;
        }
        let (owners, neighbours) = (piece.lists.owner.view(), piece.lists.neighbour.view());
        for face in 0..piece.lists.faces.len() {
            let (number, is_turned) = number_of(piece, face);
            let here = cells[owners[face].get() as usize];
            let there = neighbours.get(face);
            let there = there.map_or(NONE, |cell| cells[cell.get() as usize]);
            let (out, other) = if is_turned {
                (there, here)
            } else {
                (here, there)
            };
            for (side, cell) in [(&mut owner[number], out), (&mut neighbour[number], other)] {
                if cell == NONE {
                    continue;
                }
                if ![NONE, cell].contains(side) {
                    return Err(piece.refuse(format!(
                        "face {number} of the whole has cells {side} and {cell} on one side"
                    )));
                }
                *side = cell;
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

fn points(pieces: &[Piece]) -> Result<Vec<[f64; 3]>> {
    let n_all = pieces.iter().map(|piece| piece.lists.points.len()).sum();
    let mut points: Vec<Option<[f64; 3]>> = Vec::new();
    for piece in pieces {
        for (number, point) in numbers(piece).points.iter().zip(&piece.lists.points) {
            let number = *number as usize;
            check_number(piece, "point", number, n_all)?;
            if number >= points.len() {
                points.resize(number + 1, None);
            }
            points[number].get_or_insert(*point);
        }
    }
    let missing = |i| pieces[0].refuse(format!("point {i} of the whole is in no piece"));
    let all = points.into_iter().enumerate();
    all.map(|(i, point)| point.ok_or_else(|| missing(i)))
        .collect()
}

/// The patches of the whole by their names; the faces of each must be in a row.
fn patches(pieces: &[Piece], n_faces: usize) -> Result<Vec<Patch>> {
    let mut patches: Vec<Patch> = Vec::new();
    let mut places = Places::default();
    let all = pieces.iter().flat_map(|piece| &piece.lists.patches);
    for patch in all.filter(|patch| !is_shared(patch)) {
        places.entry(&patch.name, &mut patches, || patch.clone());
    }
    // First and last face and number of faces of each name.
    let mut found: BTreeMap<&str, (usize, usize, usize)> = BTreeMap::new();
    for piece in pieces {
        for patch in piece.lists.patches.iter().filter(|patch| patch.n_faces > 0) {
            let Some(name) = whole_patch(patch) else {
                continue;
            };
            let span = found.entry(name).or_insert((n_faces, 0, 0));
            for face in patch.start_face..patch.start_face + patch.n_faces {
                let (number, _) = number_of(piece, face);
                *span = (span.0.min(number), span.1.max(number), span.2 + 1);
            }
        }
    }
    let mut end = 0;
    for patch in &mut patches {
        (patch.start_face, patch.n_faces) = match found.get(patch.name.as_str()) {
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

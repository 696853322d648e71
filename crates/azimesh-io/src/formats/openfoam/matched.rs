//! Pieces joined by the faces that they share, for cases without the numbers of the whole: two patches between two
//! pieces have their faces in one order, each face turned round and with the same first node.
//!
//! Cells, points and faces come piece by piece.

use super::decomposed::{Piece, is_shared, whole_patch, zones_of};
use super::read::Lists;
use super::topology::Patch;
use crate::formats::by_faces::Label;
use azimesh_core::error::Result;
use std::collections::BTreeMap;

/// Nodes of one face in two pieces are as near as this, times the largest coordinate.
const SAME_PLACE: f64 = 1e-6;

/// Where the points and cells of each piece begin among those of all.
struct Starts {
    points: Vec<usize>,
    cells: Vec<usize>,
}

/// The whole mesh, and the node of it that each point of each piece is.
pub(super) fn join(pieces: &[Piece]) -> Result<(Lists, Vec<Vec<u32>>)> {
    let starts = Starts::of(pieces);
    let (n_points, n_cells) = starts.ends();
    if n_points.max(n_cells) >= u32::MAX as usize {
        return Err(pieces[0].refuse(crate::mesh::too_many("nodes or cells")));
    }
    let mut same = Same::new(n_points);
    let mut between = Vec::new();
    for piece in pieces {
        for patch in piece.shared().filter(|patch| whole_patch(patch).is_none()) {
            let (other, theirs) = partner(pieces, piece, patch)?;
            for i in 0..patch.n_faces {
                let faces = [patch.start_face + i, theirs.start_face + i];
                same.join(&starts, [piece, other], faces)?;
                if piece.number < other.number {
                    between.push((piece.number, other.number, faces));
                }
            }
        }
    }
    let (points, new_index) = same.points(pieces);
    let mut lists = Lists {
        points,
        ..Lists::default()
    };
    let whole = Whole {
        pieces,
        starts: &starts,
        new_index: &new_index,
    };
    for piece in pieces {
        for (face, cell) in piece.lists.neighbour.view().iter().enumerate() {
            whole.push(&mut lists, piece, face);
            let cell = starts.cells[piece.number] + cell.get() as usize;
            lists.neighbour.decoded().push(cell as u32);
        }
    }
    for (one, other, [face, their_face]) in between {
        whole.push(&mut lists, &pieces[one], face);
        let cell = pieces[other].lists.owner.view()[their_face];
        let cell = starts.cells[other] + cell.get() as usize;
        lists.neighbour.decoded().push(cell as u32);
    }
    whole.push_patches(&mut lists);
    lists.zones = zones_of(pieces, |piece, cell| {
        let first = starts.cells[piece.number] as u32;
        first.saturating_add(cell)
    });
    let bounds = starts.points.windows(2);
    let nodes = bounds.map(|two| new_index[two[0]..two[1]].to_vec());
    Ok((lists, nodes.collect()))
}

impl Starts {
    fn of(pieces: &[Piece]) -> Self {
        let mut starts = Self {
            points: vec![0],
            cells: vec![0],
        };
        let (mut point, mut cell) = (0, 0);
        for piece in pieces {
            point += piece.lists.points.len();
            cell += piece.lists.n_cells();
            starts.points.push(point);
            starts.cells.push(cell);
        }
        starts
    }

    fn ends(&self) -> (usize, usize) {
        let last = |starts: &[usize]| starts.last().copied().unwrap_or(0);
        (last(&self.points), last(&self.cells))
    }
}

/// The patch on the other side of one between two pieces, and its piece.
fn partner<'p>(
    pieces: &'p [Piece],
    piece: &Piece,
    patch: &Patch,
) -> Result<(&'p Piece, &'p Patch)> {
    let name = &patch.name;
    let number = patch
        .entry("neighbProcNo")
        .and_then(|number| number.parse().ok());
    let refuse = |message: String| piece.refuse(message);
    let number: usize = number.ok_or_else(|| {
        refuse(format!(
            "patch \"{name}\" does not name the piece on its other side (neighbProcNo)"
        ))
    })?;
    let other = pieces
        .get(number)
        .filter(|_| number != piece.number)
        .ok_or_else(|| {
            refuse(format!(
                "patch \"{name}\" is shared with piece {number}, which is not there"
            ))
        })?;
    let back = piece.number.to_string();
    let mut theirs = other.shared();
    let theirs = theirs.find(|theirs| {
        theirs.entry("neighbProcNo") == Some(&back) && whole_patch(theirs).is_none()
    });
    let theirs = theirs.filter(|theirs| theirs.n_faces == patch.n_faces);
    let theirs = theirs.ok_or_else(|| {
        refuse(format!(
            "patch \"{name}\" has {} faces, but piece {number} has no patch of as many on the other side",
            patch.n_faces
        ))
    })?;
    Ok((other, theirs))
}

/// Which points are one.
struct Same(Vec<u32>);

impl Same {
    fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    fn root(&mut self, mut point: u32) -> u32 {
        while self.0[point as usize] != point {
            let above = self.0[self.0[point as usize] as usize];
            self.0[point as usize] = above;
            point = above;
        }
        point
    }

    /// Joins the nodes of a face in two pieces.
    fn join(&mut self, starts: &Starts, pieces: [&Piece; 2], faces: [usize; 2]) -> Result<()> {
        let [one, other] = [0, 1].map(|i| pieces[i].lists.faces.view().get(faces[i]));
        let turned = other[..1].iter().chain(other[1..].iter().rev());
        let [a, b] = pieces.map(|piece| &piece.lists.points);
        let is_near = |(one, other): (&Label, &Label)| {
            let [p, q] = [a[one.get() as usize], b[other.get() as usize]];
            let size = p.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            (0..3).all(|i| (p[i] - q[i]).abs() <= SAME_PLACE * size.max(f64::MIN_POSITIVE))
        };
        if one.len() != other.len() || !one.iter().zip(turned.clone()).all(is_near) {
            return Err(pieces[0].refuse(format!(
                "face {} is not face {} of piece {}, which should be the same",
                faces[0], faces[1], pieces[1].number
            )));
        }
        for (one, other) in one.iter().zip(turned) {
            let [one, other] = [(one, 0), (other, 1)]
                .map(|(node, i)| (starts.points[pieces[i].number] + node.get() as usize) as u32);
            let [one, other] = [self.root(one), self.root(other)];
            self.0[one.max(other) as usize] = one.min(other);
        }
        Ok(())
    }

    /// The points of the whole, and the index in it of those of all pieces.
    fn points(mut self, pieces: &[Piece]) -> (Vec<[f64; 3]>, Vec<u32>) {
        let mut points = Vec::new();
        let mut new_index = vec![0; self.0.len()];
        let all = pieces.iter().flat_map(|piece| &piece.lists.points);
        for (i, point) in all.enumerate() {
            let root = self.root(i as u32) as usize;
            if root == i {
                new_index[i] = points.len() as u32;
                points.push(*point);
            } else {
                new_index[i] = new_index[root];
            }
        }
        (points, new_index)
    }
}

/// The pieces with the numbers of their points in the whole.
struct Whole<'p> {
    pieces: &'p [Piece],
    starts: &'p Starts,
    new_index: &'p [u32],
}

impl Whole<'_> {
    /// Appends a face of a piece and its owner.
    fn push(&self, lists: &mut Lists, piece: &Piece, face: usize) {
        let first = self.starts.points[piece.number];
        let nodes = piece.lists.faces.view().get(face).iter();
        let whole = |node: &Label| self.new_index[first + node.get() as usize];
        lists.faces.push(nodes.map(whole));
        let owner = piece.lists.owner.view()[face].get();
        let cell = self.starts.cells[piece.number] + owner as usize;
        lists.owner.decoded().push(cell as u32);
    }

    /// Appends the faces of the patches, by name in the order in which the pieces have them.
    fn push_patches(&self, lists: &mut Lists) {
        let mut parts: BTreeMap<&str, Vec<(&Piece, &Patch)>> = BTreeMap::new();
        for piece in self.pieces {
            for part in &piece.lists.patches {
                if let Some(name) = whole_patch(part) {
                    parts.entry(name).or_default().push((piece, part));
                }
            }
        }
        let all = self.pieces.iter().flat_map(|piece| &piece.lists.patches);
        for patch in all.filter(|patch| !is_shared(patch)) {
            let Some(parts) = parts.remove(&*patch.name) else {
                continue;
            };
            let start_face = lists.faces.len();
            for (piece, part) in parts {
                for face in part.start_face..part.start_face + part.n_faces {
                    self.push(lists, piece, face);
                }
            }
            lists.patches.push(Patch {
                start_face,
                n_faces: lists.faces.len() - start_face,
                ..patch.clone()
            });
        }
    }
}

//! Pieces as one mesh: nodes that they share become one.
//!
//! Shared are nodes of the same global number at nearly the same place, or without numbers nodes of
//! different pieces at the very same place, where each piece has but one node. Cells and nodes with global numbers are put
//! in the order of these, others stay piece by piece.

use super::subset::push;
use crate::formats::Notes;
use crate::mesh::too_many;
use crate::mesh::{Cells, DataArray, Mesh, Values, for_each_shared_place};
use azimesh_core::diagnostic::formats::{ArrayRead, Pieces};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::{any, collect, largest, sort};
use std::collections::{BTreeMap, BTreeSet};

/// One piece, with the names of the arrays that hold its global numbers.
pub struct Piece {
    /// The mesh of the piece, without groups.
    pub mesh: Mesh,
    /// Point array.
    pub node_ids: Option<String>,
    /// Cell array.
    pub cell_ids: Option<String>,
}

/// Nodes of one global number are as near as this, times the largest coordinate: 32-bit numbers are
/// rounded to 6e-8 of themselves.
const SAME_PLACE: f64 = 1e-6;

/// Where the nodes of the pieces are in the whole mesh.
struct Joined {
    /// For each node of the whole, the node it is taken from, counted through all pieces.
    origin: Vec<usize>,
    /// For each node of all pieces, its index in the whole.
    new_index: Vec<u32>,
}

/// One mesh of all pieces.
pub fn merge(mut pieces: Vec<Piece>, notes: &mut Notes) -> Result<Mesh> {
    let is_empty = |piece: &Piece| piece.mesh.points.is_empty() && piece.mesh.cells.is_empty();
    let mut fields = field_arrays(&pieces, notes);
    pieces.retain(|piece| !is_empty(piece));
    let n_nodes: usize = pieces.iter().map(|piece| piece.mesh.points.len()).sum();
    if n_nodes >= u32::MAX as usize {
        return Err(mismatch(too_many("nodes")));
    }
    let points: Vec<[f64; 3]> = pieces
        .iter()
        .flat_map(|piece| piece.mesh.points.iter().copied())
        .collect();
    let node_ids = all_numbers(&pieces, |p| {
        Piece::numbers(&p.mesh.point_arrays, &p.node_ids)
    });
    let by_ids = node_ids
        .as_ref()
        .and_then(|ids| joined_by_ids(ids, &points, notes));
    let counted = by_ids.is_some();
    let joined = by_ids.unwrap_or_else(|| joined_by_place(&pieces, &points, notes));
    note_joined(&pieces, &points, &joined, counted, notes);

    let cell_ids = all_numbers(&pieces, |p| {
        Piece::numbers(&p.mesh.cell_arrays, &p.cell_ids)
    });
    let order = cell_order(&pieces, cell_ids.as_deref());
    let mut mesh = Mesh {
        points: joined.origin.iter().map(|&node| points[node]).collect(),
        cells: cells(&pieces, &order, &joined.new_index),
        point_arrays: arrays(&pieces, "point", |m| &m.point_arrays, &joined.origin, notes),
        cell_arrays: arrays(&pieces, "cell", |m| &m.cell_arrays, &order, notes),
        ..Mesh::default()
    };
    mesh.field_arrays.append(&mut fields);
    // Numbers that count through say no more than the order.
    if let Some(first) = pieces.first() {
        drop_counted(
            &mut mesh.point_arrays,
            first.node_ids.as_ref().filter(|_| counted),
        );
        drop_counted(
            &mut mesh.cell_arrays,
            first.cell_ids.as_ref().filter(|_| cell_ids.is_some()),
        );
    }
    Ok(mesh)
}

/// Global numbers of all pieces one after another, if every piece has them under one name.
fn all_numbers(pieces: &[Piece], numbers: impl Fn(&Piece) -> Option<Vec<i64>>) -> Option<Vec<i64>> {
    let all: Option<Vec<Vec<i64>>> = pieces.iter().map(numbers).collect();
    Some(all?.concat())
}

/// Nodes of one number as one; `None` when the numbers are not good for that.
fn joined_by_ids(ids: &[i64], points: &[[f64; 3]], notes: &mut Notes) -> Option<Joined> {
    let sorted = sorted(ids);
    let magnitude = |point: [f64; 3]| point.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let largest = largest(points.len(), |node| magnitude(points[node]));
    let elsewhere = |pair: &[(u64, u32)]| {
        let [a, b] = [pair[0].1, pair[1].1].map(|node| points[node as usize]);
        let near = |i: usize| (a[i] - b[i]).abs() <= SAME_PLACE * largest;
        pair[0].0 == pair[1].0 && !(0..3).all(near)
    };
    if any(sorted.len().saturating_sub(1), |i| {
        elsewhere(&sorted[i..i + 2])
    }) {
        notes.push(Pieces::NumbersUnused);
        return None;
    }
    let mut joined = Joined {
        origin: Vec::with_capacity(ids.len()),
        new_index: vec![0; ids.len()],
    };
    for group in sorted.chunk_by(|a, b| a.0 == b.0) {
        for (_, node) in group {
            joined.new_index[*node as usize] = joined.origin.len() as u32;
        }
        joined.origin.push(group[0].1 as usize);
    }
    Some(joined)
}

/// Keys that are in the order of the global numbers, and what has these numbers.
fn sorted(ids: &[i64]) -> Vec<(u64, u32)> {
    let key = |id: i64| id as u64 ^ (1 << 63);
    let mut sorted = collect(ids.len(), |i| (key(ids[i]), i as u32));
    sort(&mut sorted);
    sorted
}

/// Nodes at one place as one, where no piece has several there.
fn joined_by_place(pieces: &[Piece], points: &[[f64; 3]], notes: &mut Notes) -> Joined {
    let piece_of: Vec<u32> = pieces
        .iter()
        .zip(0..)
        .flat_map(|(piece, i)| std::iter::repeat_n(i, piece.mesh.points.len()))
        .collect();
    // The first node at each place stands for those of the other pieces.
    let mut first: Vec<usize> = (0..points.len()).collect();
    let (mut n_apart, mut n_joined) = (0, 0);
    let mut visit = |group: &[u32]| {
        let of_pieces = || group.iter().map(|node| piece_of[*node as usize]);
        if of_pieces().zip(of_pieces().skip(1)).any(|(a, b)| a == b) {
            let several = of_pieces().any(|piece| piece != piece_of[group[0] as usize]);
            n_apart += usize::from(several);
            return;
        }
        n_joined += 1;
        for node in group {
            first[*node as usize] = group[0] as usize;
        }
    };
    if pieces.len() > 1 {
        for_each_shared_place(points, &mut visit);
    }
    if n_apart > n_joined {
        // Cells that share no nodes within a piece share none with other pieces.
        notes.push(Pieces::NotJoined);
        first = (0..points.len()).collect();
    } else if n_apart > 0 {
        notes.push(Pieces::KeptApart { n: n_apart });
    }
    let mut joined = Joined {
        origin: Vec::new(),
        new_index: vec![0; points.len()],
    };
    for (node, &first) in first.iter().enumerate() {
        if first == node {
            joined.new_index[node] = joined.origin.len() as u32;
            joined.origin.push(node);
        } else {
            joined.new_index[node] = joined.new_index[first];
        }
    }
    joined
}

fn note_joined(
    pieces: &[Piece],
    points: &[[f64; 3]],
    joined: &Joined,
    counted: bool,
    notes: &mut Notes,
) {
    let n_shared = points.len() - joined.origin.len();
    if n_shared > 0 {
        notes.push(Pieces::Joined {
            n: pieces.len(),
            n_nodes: n_shared,
            by: if counted { "number" } else { "place" },
        });
    }
}

/// Cells of the whole, counted through all pieces.
fn cell_order(pieces: &[Piece], ids: Option<&[i64]>) -> Vec<usize> {
    let n: usize = pieces.iter().map(|piece| piece.mesh.cells.len()).sum();
    match ids {
        Some(ids) => sorted(ids).iter().map(|(_, cell)| *cell as usize).collect(),
        None => (0..n).collect(),
    }
}

fn cells(pieces: &[Piece], order: &[usize], new_index: &[u32]) -> Cells {
    let mut starts = vec![(0, 0)];
    let (mut cell, mut node) = (0, 0);
    for piece in pieces {
        cell += piece.mesh.cells.len();
        node += piece.mesh.points.len();
        starts.push((cell, node));
    }
    let mut cells = Cells::new();
    cells.reserve(
        pieces
            .iter()
            .map(|p| p.mesh.cells.connectivity().len())
            .sum(),
    );
    for &cell in order {
        let piece = starts.partition_point(|(start, _)| *start <= cell) - 1;
        let (first_cell, first_node) = starts[piece];
        push(
            &mut cells,
            &pieces[piece].mesh.cells,
            cell - first_cell,
            |node| new_index[first_node + node as usize],
        );
    }
    cells
}

/// Arrays that all pieces have alike, with the tuples `origin` of those of all pieces.
fn arrays(
    pieces: &[Piece],
    what: &'static str,
    of: impl Fn(&Mesh) -> &Vec<DataArray>,
    origin: &[usize],
    notes: &mut Notes,
) -> Vec<DataArray> {
    // A piece without nodes or cells needs no arrays for them.
    let parts: Vec<&Vec<DataArray>> = pieces
        .iter()
        .filter(|piece| what == "point" || !piece.mesh.cells.is_empty())
        .map(|piece| of(&piece.mesh))
        .collect();
    let Some((first, rest)) = parts.split_first() else {
        return Vec::new();
    };
    let mut arrays: Vec<DataArray> = Vec::new();
    let mut kept: BTreeSet<&str> = BTreeSet::new();
    let rest: Vec<BTreeMap<_, _>> = rest
        .iter()
        .map(|part| part.iter().map(|array| (key(array), array)).collect())
        .collect();
    for array in first.iter() {
        let others: Option<Vec<&Values>> = rest
            .iter()
            .map(|part| part.get(&key(array)).map(|array| &array.values))
            .collect();
        let mut all = array.values.clone();
        if others.is_some_and(|others| others.into_iter().all(|values| all.append(values))) {
            kept.insert(&array.name);
            arrays.push(DataArray {
                values: all.select(array.n_components, origin),
                ..array.clone()
            });
        }
    }
    for array in parts.iter().flat_map(|part| part.iter()) {
        if !kept.contains(&*array.name) {
            notes.push(ArrayRead::NotAlike {
                what,
                name: array.name.clone(),
            });
        }
    }
    arrays
}

/// What arrays of several pieces have in common.
fn key(array: &DataArray) -> (&str, usize) {
    (&array.name, array.n_components)
}

/// Field arrays of the first piece; a note where another piece has another.
fn field_arrays(pieces: &[Piece], notes: &mut Notes) -> Vec<DataArray> {
    let mut arrays: Vec<DataArray> = Vec::new();
    let mut known: BTreeMap<&str, &DataArray> = BTreeMap::new();
    for array in pieces.iter().flat_map(|piece| &piece.mesh.field_arrays) {
        let first = *known.entry(&array.name).or_insert(array);
        if std::ptr::eq(first, array) {
            arrays.push(array.clone());
        } else if first != array {
            notes.push(ArrayRead::OfFirstPiece {
                name: array.name.clone(),
            });
        }
    }
    arrays
}

/// Removes an array of numbers that count through from 0, each once or more.
fn drop_counted(arrays: &mut Vec<DataArray>, name: Option<&String>) {
    let Some(name) = name else {
        return;
    };
    let counts = |array: &DataArray| {
        let numbers = array.values.to_integers().unwrap_or_default();
        let steps = numbers
            .windows(2)
            .all(|two| (0..=1).contains(&(two[1] - two[0])));
        numbers.first().is_none_or(|first| *first == 0) && steps
    };
    arrays.retain(|array| array.name != *name || !counts(array));
}

impl Piece {
    /// The numbers in one of its arrays.
    fn numbers(arrays: &[DataArray], name: &Option<String>) -> Option<Vec<i64>> {
        let name = name.as_ref()?;
        let array = arrays.iter().find(|array| array.name == *name);
        array?.values.to_integers()
    }
}

/// An error of the pieces together.
fn mismatch(message: String) -> Error {
    Error::input(message).dataset("Piece")
}

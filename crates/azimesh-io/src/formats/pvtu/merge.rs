//! Pieces as one mesh: nodes that they share become one.
//!
//! Shared are nodes of the same global number at nearly the same place, or without numbers nodes of
//! different pieces at the very same place, where each piece has but one node. Cells and nodes with global numbers are put
//! in the order of these, others stay piece by piece.

use crate::formats::Notes;
use crate::formats::names::alike;
use crate::formats::vtk::number::Element;
use crate::mesh::too_many;
use crate::mesh::{Cells, DataArray, Mesh, for_each_shared_place};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::note;
use azimesh_core::numbers::with_verb;
use azimesh_core::parallel::{any, collect, largest, sort};
use std::collections::BTreeMap;

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

/// Nodes of the pieces in the whole mesh.
struct Joined {
    /// For each node of the whole, the node it is taken from, counted through all pieces.
    origin: Vec<usize>,
    /// For each node of all pieces, its index in the whole.
    new_index: Vec<u32>,
}

/// One mesh of all pieces.
pub fn merge(mut pieces: Vec<Piece>, notes: &mut Notes) -> Result<Mesh> {
    let field_arrays = field_arrays(&pieces, notes);
    pieces.retain(|piece| !piece.mesh.points.is_empty() || !piece.mesh.cells.is_empty());
    let n_nodes: usize = pieces.iter().map(|piece| piece.mesh.points.len()).sum();
    if n_nodes >= u32::MAX as usize {
        return Err(Error::input(too_many("nodes")).dataset("Piece"));
    }
    let points = pieces.iter().flat_map(|piece| &piece.mesh.points);
    let points: Vec<[f64; 3]> = points.copied().collect();
    let node_ids = numbers(&pieces, |p| (&p.mesh.point_arrays, &p.node_ids));
    let by_ids = node_ids.and_then(|ids| joined_by_ids(&ids, &points, notes));
    let is_by_number = by_ids.is_some();
    let joined = by_ids.unwrap_or_else(|| joined_by_place(&pieces, &points, notes));
    let n_shared = points.len() - joined.origin.len();
    notes.count(n_shared, |n| {
        note!(
            "pieces_joined",
            "{} joined at {} with the same {}",
            with_verb(pieces.len(), "piece", "is"),
            counted(n, "node"),
            if is_by_number { "number" } else { "place" }
        )
    });
    let cell_ids = numbers(&pieces, |p| (&p.mesh.cell_arrays, &p.cell_ids));
    let has_cell_ids = cell_ids.is_some();
    let n_cells = pieces.iter().map(|piece| piece.mesh.cells.len()).sum();
    let in_file = || (0..n_cells).collect();
    let by_number = |ids: Vec<i64>| {
        sorted(&ids)
            .iter()
            .map(|(_, cell)| *cell as usize)
            .collect()
    };
    let order: Vec<usize> = cell_ids.map_or_else(in_file, by_number);
    let mut mesh = Mesh {
        points: joined.origin.iter().map(|&node| points[node]).collect(),
        point_arrays: arrays(&pieces, "point", |m| &m.point_arrays, &joined.origin, notes),
        cell_arrays: arrays(&pieces, "cell", |m| &m.cell_arrays, &order, notes),
        field_arrays,
        ..Mesh::default()
    };
    mesh.cells = cells(&mut pieces, &joined.new_index);
    if has_cell_ids {
        mesh.cells = mesh.cells.select(order);
    }
    // Numbers that count through say no more than the order.
    if let Some(first) = pieces.first() {
        let node_ids = first.node_ids.as_ref().filter(|_| is_by_number);
        drop_counted(&mut mesh.point_arrays, node_ids);
        let cell_ids = first.cell_ids.as_ref().filter(|_| has_cell_ids);
        drop_counted(&mut mesh.cell_arrays, cell_ids);
    }
    Ok(mesh)
}

/// Global numbers of all pieces one after another, if every piece has them.
fn numbers<'p>(
    pieces: &'p [Piece],
    of: impl Fn(&'p Piece) -> (&'p Vec<DataArray>, &'p Option<String>),
) -> Option<Vec<i64>> {
    let mut all = Vec::new();
    for (arrays, name) in pieces.iter().map(of) {
        let name = name.as_ref()?;
        let array = arrays.iter().find(|array| array.name == *name)?;
        all.extend(array.values.to_integers()?);
    }
    Some(all)
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
    let n_pairs = sorted.len().saturating_sub(1);
    if any(n_pairs, |i| elsewhere(&sorted[i..i + 2])) {
        notes.push(note!(
            "numbers_unused",
            "global node numbers are not used: nodes with the same number are at different places"
        ));
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
    let numbered = pieces.iter().zip(0..);
    let of_nodes = numbered.flat_map(|(piece, i)| std::iter::repeat_n(i, piece.mesh.points.len()));
    let piece_of: Vec<u32> = of_nodes.collect();
    // The first node at each position represents the nodes of the other pieces.
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
        notes.push(note!(
            "pieces_not_joined",
            "the pieces are not joined: their cells share no nodes even within a piece"
        ));
        first = (0..points.len()).collect();
    } else if n_apart > 0 {
        let places = counted(n_apart, "place");
        notes.push(note!(
            "kept_apart",
            "nodes at {places} are not joined: a piece has several nodes there"
        ));
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

/// The cells of all pieces with the nodes of the whole, one piece after another.
fn cells(pieces: &mut [Piece], new_index: &[u32]) -> Cells {
    let each = pieces.iter();
    let n_entries = each.map(|piece| piece.mesh.cells.connectivity().len());
    let mut cells = Cells::new();
    cells.reserve(n_entries.sum());
    let mut rest = new_index;
    for piece in pieces {
        let mut own = std::mem::take(&mut piece.mesh.cells);
        own.renumber_nodes(rest);
        cells.append(&own);
        rest = &rest[piece.mesh.points.len()..];
    }
    cells
}

/// Arrays that all pieces have alike, with the tuples `origin` of all pieces.
fn arrays<'p>(
    pieces: &'p [Piece],
    what: &'static str,
    of: impl Fn(&'p Mesh) -> &'p Vec<DataArray>,
    origin: &[usize],
    notes: &mut Notes,
) -> Vec<DataArray> {
    // A piece without nodes or cells needs no arrays for them.
    let parts = pieces.iter();
    let parts = parts.filter(|piece| what == "point" || !piece.mesh.cells.is_empty());
    let parts: Vec<&Vec<DataArray>> = parts.map(|piece| of(&piece.mesh)).collect();
    let kind = |array: &'p DataArray| {
        let element = Element::of(&array.values).name();
        (&*array.name, array.n_components, element)
    };
    let all = alike(&parts, what, (|array| &*array.name, kind), notes);
    let whole = all.into_iter().map(|of_pieces| {
        let mut values = of_pieces[0].values.clone();
        for array in &of_pieces[1..] {
            values.append(&array.values);
        }
        DataArray {
            values: values.select(of_pieces[0].n_components, origin),
            ..of_pieces[0].clone()
        }
    });
    whole.collect()
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
            let name = &array.name;
            notes.push(note!(
                "of_first_piece",
                "the field array \"{name}\" differs between pieces; the array of the first piece is kept"
            ));
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
        let mut steps = numbers.windows(2).map(|two| two[1] - two[0]);
        numbers.first().is_none_or(|first| *first == 0) && steps.all(|step| (0..=1).contains(&step))
    };
    arrays.retain(|array| array.name != *name || !counts(array));
}

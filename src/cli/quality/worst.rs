//! The worst cells of a mesh or of a sequence, and their positions.

use super::Step;
use azimesh_core::geometry::vector::{Vector, add, scale};
use azimesh_io::mesh::{CellKind, CellRef, Mesh};
use azimesh_quality::{Candidate, Reference, TaggedSurface, worst};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// The worst cells of the evaluated meshes, the worst first.
pub(super) struct WorstCells {
    n: usize,
    pub cells: Vec<WorstCell>,
}

/// A cell of the list.
pub(super) struct WorstCell {
    pub step: Option<Step>,
    pub found: Candidate,
    pub kind: &'static str,
    /// Mean of its nodes.
    pub position: Vector,
    /// Tags that hold a face with one of its nodes.
    pub tags: Vec<String>,
    /// The tag nearest to its position, and its distance; `None` in a mesh without tags.
    pub nearest: Option<(String, f64)>,
}

impl WorstCells {
    /// Creates an empty list that keeps `n` cells.
    pub fn new(n: usize) -> Self {
        Self {
            n,
            cells: Vec::new(),
        }
    }

    /// Adds the cells of a mesh that are worse than earlier ones.
    pub fn consider(&mut self, step: Option<Step>, mesh: &Mesh, reference: &Reference) {
        let mut candidates = worst(mesh, &mesh.points, reference, self.n);
        if self.cells.len() == self.n {
            let last = self.cells.last().map(|cell| cell.found);
            candidates.retain(|found| last.is_some_and(|last| found.rank(&last).is_lt()));
        }
        self.cells.extend(described(step, mesh, &candidates));
        // The sort is stable: of equal cells, cells of earlier steps come first.
        self.cells.sort_by(|a, b| a.found.rank(&b.found));
        self.cells.truncate(self.n);
    }
}

/// A cell as seen by its rank.
#[derive(Serialize, Deserialize)]
struct Seen {
    kind: CellKind,
    position: Vector,
    tags: Vec<String>,
}

fn described(step: Option<Step>, mesh: &Mesh, candidates: &[Candidate]) -> Vec<WorstCell> {
    if candidates.is_empty() {
        return Vec::new();
    }
    let mut of_ranks = mesh.ranks().allgather(seen_here(mesh, candidates));
    let of_any = |i: usize| of_ranks.iter_mut().find_map(|of_rank| of_rank[i].take());
    let seen: Vec<Seen> = (0..candidates.len()).filter_map(of_any).collect();
    let tagged = TaggedSurface::new(mesh);
    let positions: Vec<Vector> = seen.iter().map(|seen| seen.position).collect();
    let nearest_here = tagged.nearest(&mesh.points, &positions);
    let is_nearer =
        |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).is_lt();
    let nearest = mesh.ranks().allgather(nearest_here);
    let nearest = |i: usize| {
        let of_ranks = nearest.iter().filter_map(|of_rank| of_rank[i]);
        of_ranks.reduce(|a, b| if is_nearer(&b, &a) { b } else { a })
    };
    let describe = |(i, (found, seen)): (usize, (&Candidate, Seen))| WorstCell {
        step,
        found: *found,
        kind: seen.kind.name(),
        position: seen.position,
        tags: seen.tags,
        nearest: nearest(i).map(|(squared, tag)| (tagged.name(tag).to_owned(), squared.sqrt())),
    };
    candidates
        .iter()
        .zip(seen)
        .enumerate()
        .map(describe)
        .collect()
}

/// Returns the candidates that are cells of this rank, each at its index among all.
fn seen_here(mesh: &Mesh, candidates: &[Candidate]) -> Vec<Option<Seen>> {
    let (own, offset) = (mesh.own_cells(), mesh.own_offset());
    let here = |found: &Candidate| {
        let cell = found.cell.checked_sub(offset)?;
        own.contains(&cell).then(|| mesh.cells.get(cell))
    };
    let cells: Vec<_> = candidates.iter().map(here).collect();
    let touching = touching_tags(mesh, &cells);
    let see = |(cell, tags): (Option<CellRef<'_>>, Vec<String>)| {
        let cell = cell?;
        let places = cell.nodes.iter().map(|&node| mesh.points[node as usize]);
        Some(Seen {
            kind: cell.kind,
            position: scale(places.fold([0.0; 3], add), 1.0 / cell.nodes.len() as f64),
            tags,
        })
    };
    cells.into_iter().zip(touching).map(see).collect()
}

/// Returns, for each cell of this rank, the tags that hold a face with one of its nodes.
fn touching_tags(mesh: &Mesh, cells: &[Option<CellRef<'_>>]) -> Vec<Vec<String>> {
    let nodes = cells.iter().flatten().flat_map(|cell| cell.nodes);
    let mut tags_of: BTreeMap<u32, Vec<usize>> = nodes.map(|&node| (node, Vec::new())).collect();
    for (place, tag) in mesh.boundary_tags().enumerate() {
        for node in tag.cells.iter().flat_map(|face| mesh.cells.get(face).nodes) {
            if let Some(tags) = tags_of
                .get_mut(node)
                .filter(|tags| tags.last() != Some(&place))
            {
                tags.push(place);
            }
        }
    }
    let names: Vec<&String> = mesh.boundary_tags().map(|tag| &tag.name).collect();
    let touching = |cell: &Option<CellRef<'_>>| {
        let nodes = cell.map_or(&[][..], |cell| cell.nodes);
        let tags: BTreeSet<usize> = nodes
            .iter()
            .flat_map(|node| &tags_of[node])
            .copied()
            .collect();
        tags.into_iter().map(|place| names[place].clone()).collect()
    };
    cells.iter().map(touching).collect()
}

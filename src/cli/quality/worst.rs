//! The worst cells of a mesh or of a sequence, and where they are.

use super::Step;
use crate::geometry::closest::ClosestSurface;
use crate::geometry::vector::{Vector, add, scale};
use crate::mesh::{Mesh, facets::facets};
use crate::quality::{Candidate, Reference, worst};

/// The worst cells of the meshes that were considered, the worst first.
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
    /// Of which `n` are kept.
    pub fn new(n: usize) -> Self {
        Self {
            n,
            cells: Vec::new(),
        }
    }

    /// Takes in the cells of a mesh that are worse than those found before.
    pub fn consider(&mut self, step: Option<Step>, mesh: &Mesh, reference: &Reference) {
        let mut candidates = worst(mesh, &mesh.points, reference, self.n);
        if self.cells.len() == self.n {
            let last = self.cells.last().map(|cell| cell.found);
            candidates.retain(|found| last.is_some_and(|last| found.rank(&last).is_lt()));
        }
        self.cells.extend(described(step, mesh, &candidates));
        // The sort is stable: of equal cells those of earlier steps come first.
        self.cells.sort_by(|a, b| a.found.rank(&b.found));
        self.cells.truncate(self.n);
    }
}

fn described(step: Option<Step>, mesh: &Mesh, candidates: &[Candidate]) -> Vec<WorstCell> {
    if candidates.is_empty() {
        return Vec::new();
    }
    let touching = touching_tags(mesh, candidates);
    let tagged = TaggedSurface::new(mesh);
    let surface = ClosestSurface::new(&mesh.points[..], &tagged.facets);
    let describe = |(found, tags): (&Candidate, Vec<String>)| {
        let cell = mesh.cells.get(found.cell);
        let sum = cell
            .nodes
            .iter()
            .fold([0.0; 3], |sum, &node| add(sum, mesh.points[node as usize]));
        let position = scale(sum, 1.0 / cell.nodes.len() as f64);
        let foot = surface.nearest(&position, f64::INFINITY);
        WorstCell {
            step,
            found: *found,
            kind: cell.kind.name(),
            position,
            tags,
            nearest: foot.map(|foot| (tagged.name(foot.facet), foot.distance_squared.sqrt())),
        }
    };
    candidates.iter().zip(touching).map(describe).collect()
}

/// The tagged boundary faces as triangles, or as edges in 2D.
struct TaggedSurface<'a> {
    facets: Vec<[u32; 3]>,
    /// Each tag with the end of its facets.
    tags: Vec<(&'a str, usize)>,
}

impl<'a> TaggedSurface<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let (mut all, mut tags) = (Vec::new(), Vec::new());
        for tag in mesh.boundary_tags() {
            let ranges = tag.cells.ranges();
            for run in ranges.flat_map(|range| mesh.cells.runs_in(range)) {
                let pieces = facets(run.kind, run.n_nodes);
                let corners = run
                    .cells()
                    .flat_map(|nodes| pieces.iter().map(|piece| piece.map(|i| nodes[i])));
                all.extend(corners);
            }
            tags.push((&tag.name[..], all.len()));
        }
        Self { facets: all, tags }
    }

    fn name(&self, facet: usize) -> String {
        let after = self.tags.partition_point(|(_, end)| *end <= facet);
        self.tags[after].0.to_owned()
    }
}

fn touching_tags(mesh: &Mesh, candidates: &[Candidate]) -> Vec<Vec<String>> {
    let mut found = vec![Vec::new(); candidates.len()];
    for tag in mesh.boundary_tags() {
        let mut on_tag = vec![false; mesh.points.len()];
        for node in tag.cells.iter().flat_map(|face| mesh.cells.get(face).nodes) {
            on_tag[*node as usize] = true;
        }
        for (candidate, tags) in candidates.iter().zip(&mut found) {
            let nodes = mesh.cells.get(candidate.cell).nodes;
            if nodes.iter().any(|&node| on_tag[node as usize]) {
                tags.push(tag.name.clone());
            }
        }
    }
    found
}

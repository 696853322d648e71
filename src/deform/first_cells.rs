//! First cells at moving walls: each wall node with its nearest neighbour off the wall.

use super::sharing::Holder;
use crate::error::Result;
use crate::geometry::vector::{Vector, distance};
use crate::mesh::{CellRun, Cells, Mesh, NodeBits, Numbering, Slots, in_32_bits};
use crate::motion::{Motion, Role};
use crate::parallel::{self, BLOCK};
use std::ops::Range;
use std::sync::Arc;

/// Cells of one task.
const CELLS: usize = 1 << 14;

/// An edge that leaves a wall: the place of its node among those of the wall or its number, the node off it, its length.
pub(super) type Edge = (u32, u32, f64);

/// Edges that leave a moving wall, the shortest at each wall node.
#[derive(Debug, Clone, Default)]
pub struct FirstCells {
    /// Wall node and its neighbour.
    edges: Vec<(u32, u32)>,
    /// Length of the shortest edge in the reference mesh.
    smallest: Option<f64>,
}

impl FirstCells {
    /// Finds the edges in the reference mesh. Polyhedra and polygons have none. Of an outline its `holder` finds them, and it learns
    /// where they end.
    ///
    /// # Errors
    /// Of the holder.
    pub(crate) fn find(
        mesh: &mut Arc<Mesh>,
        motion: &Motion,
        holder: Option<&dyn Holder>,
    ) -> Result<Self> {
        let surface = &motion.surface.nodes;
        let moving = surface.nodes.iter().zip(&surface.roles);
        let moving = moving.filter(|(_, role)| matches!(role, Role::Moving(_)));
        let nodes: Vec<u32> = moving.map(|(node, _)| *node).collect();
        let found = match holder.filter(|_| mesh.outline.is_some()) {
            None => {
                let found = shortest(mesh, 0..mesh.cells.len(), &nodes);
                let on = |(at, off, length): Edge| (nodes[at as usize], off, length);
                found.into_iter().map(on).collect()
            }
            Some(holder) => {
                let (found, ends) = holder.edges_off_walls(&nodes)?;
                let off: Vec<u32> = found.iter().map(|edge| edge.1).collect();
                Arc::make_mut(mesh).take_places(&off, &ends);
                found
            }
        };
        Ok(Self {
            edges: found.iter().map(|&(on, off, _)| (on, off)).collect(),
            smallest: found.iter().map(|edge| edge.2).min_by(f64::total_cmp),
        })
    }

    /// The edges from the wall, each with its node there and the one off it.
    #[cfg(test)]
    pub fn edges(&self) -> &[(u32, u32)] {
        &self.edges
    }

    /// The nodes of the edges.
    pub fn nodes(&self) -> impl Iterator<Item = u32> {
        self.edges.iter().flat_map(|&(on, off)| [on, off])
    }

    /// The smallest first-cell height, in mesh units.
    pub fn smallest(&self) -> Option<f64> {
        self.smallest
    }

    /// The smallest ratio of first-cell height to that in the reference mesh, of nodes that have `slots` in `points`.
    pub(crate) fn smallest_ratio(
        &self,
        (slots, points): (Slots<'_>, &[Vector]),
        reference: &Mesh,
    ) -> Option<f64> {
        let at_rest = |node: u32| reference.place(node);
        let ratio = |&(on, off): &(u32, u32)| {
            distance(points[slots.of(on)], points[slots.of(off)])
                / distance(at_rest(on), at_rest(off))
        };
        let least = parallel::map_blocks(self.edges.len(), BLOCK, &|range| {
            self.edges[range].iter().map(ratio).min_by(f64::total_cmp)
        });
        least.into_iter().flatten().min_by(f64::total_cmp)
    }

    /// The largest relative change of a first-cell height when coordinates are rounded to 32 bits.
    pub fn change_in_f32(&self, mesh: &Mesh) -> f64 {
        parallel::largest(self.edges.len(), |at| {
            let [on, off] = <[u32; 2]>::from(self.edges[at]).map(|node| mesh.place(node));
            let [rounded_on, rounded_off] = [on, off].map(in_32_bits);
            (distance(rounded_on, rounded_off) / distance(on, off) - 1.0).abs()
        })
    }
}

/// The shortest edge of some cells of a mesh that leaves the wall at each of its `nodes`, which are ascending: the lower node off
/// it of two of one length. Each has the place of its node there.
pub(super) fn shortest(mesh: &Mesh, cells: Range<usize>, nodes: &[u32]) -> Vec<Edge> {
    let mut wall = vec![u32::MAX; mesh.points.len()];
    for (at, &node) in nodes.iter().enumerate() {
        wall[node as usize] = at as u32;
    }
    let mut shortest = vec![(u32::MAX, f64::INFINITY); nodes.len()];
    let mut shorten = |edges: Vec<Edge>| {
        for (at, off, length) in edges {
            let entry: &mut (u32, f64) = &mut shortest[at as usize];
            if (length, off) < (entry.1, entry.0) {
                *entry = (off, length);
            }
        }
    };
    for run in mesh.volume_runs_in(cells) {
        let edges = |cells: &[u32]| edges_off(&run, cells, &wall, &mesh.points);
        if run.n_cells() <= CELLS {
            shorten(edges(run.connectivity));
            continue;
        }
        let (nodes, size) = (run.connectivity, CELLS * run.n_nodes);
        let found = parallel::map_blocks(nodes.len(), size, &|range| edges(&nodes[range]));
        found.into_iter().for_each(&mut shorten);
    }
    let found = (0..).zip(shortest);
    let found = found.filter(|(_, (off, _))| *off != u32::MAX);
    found.map(|(at, (off, length))| (at, off, length)).collect()
}

/// Of edges by their nodes, each with its end, the shortest at each node on the wall, by these nodes.
pub(super) fn shortest_of(edges: impl Iterator<Item = (Edge, Vector)>) -> (Vec<Edge>, Vec<Vector>) {
    let mut edges: Vec<(Edge, Vector)> = edges.collect();
    edges.sort_unstable_by(|((on, off, length), _), ((on_b, off_b, length_b), _)| {
        let by_length = length.total_cmp(length_b);
        on.cmp(on_b).then(by_length).then(off.cmp(off_b))
    });
    edges.dedup_by_key(|(edge, _)| edge.0);
    edges.into_iter().unzip()
}

/// Of edges that leave walls, ascending, each from a node there to one off it, the shortest at each wall node, and where it
/// ends; nodes are ascending, each list with its places.
pub(super) fn shortest_at(
    edges: &[[u32; 2]],
    (on, on_places): (&[u32], &[Vector]),
    (off, off_places): (&[u32], &[Vector]),
) -> (Vec<Edge>, Vec<Vector>) {
    let (numbers_on, numbers_off) = (Numbering::new(on), Numbering::new(off));
    let at_nodes: Vec<&[[u32; 2]]> = edges.chunk_by(|a, b| a[0] == b[0]).collect();
    let shortest = |edges: &[[u32; 2]]| {
        let from = on_places[numbers_on.of(edges[0][0]) as usize];
        let edge = |&[on, off]: &[u32; 2]| {
            let end = off_places[numbers_off.of(off) as usize];
            ((on, off, distance(from, end)), end)
        };
        // The first of several of one length is the one with the lowest end.
        let edges = edges.iter().map(edge);
        edges.min_by(|(a, _), (b, _)| a.2.total_cmp(&b.2))
    };
    let found = at_nodes.into_iter().filter_map(shortest);
    found.unzip()
}

/// The edges of the solid cells among some that leave walls, each once, from its node there to the one off it; ascending.
pub(super) fn off_walls(cells: &Cells, walls: &NodeBits) -> Vec<[u32; 2]> {
    let mut edges = parallel::concat_blocks(cells.len(), CELLS, &|range| {
        let mut found = Vec::new();
        for run in cells.runs_in(range).filter(|run| run.kind.dimension() == 3) {
            for cell in run.cells() {
                if !cell.iter().any(|&node| walls.has(node)) {
                    continue;
                }
                for &[a, b] in run.kind.edges() {
                    let (a, b) = (cell[a as usize], cell[b as usize]);
                    match [walls.has(a), walls.has(b)] {
                        [true, false] => found.push([a, b]),
                        [false, true] => found.push([b, a]),
                        _ => {}
                    }
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    });
    parallel::sort(&mut edges);
    edges.dedup();
    edges
}

/// The edges of some cells of a run that leave the wall, which `wall` numbers: place on the wall,
/// node off it, length.
fn edges_off(run: &CellRun<'_>, cells: &[u32], wall: &[u32], points: &[Vector]) -> Vec<Edge> {
    let place = |node: u32| wall[node as usize];
    let mut found = Vec::new();
    for cell in cells.chunks_exact(run.n_nodes) {
        if cell.iter().all(|&node| place(node) == u32::MAX) {
            continue;
        }
        for &[a, b] in run.kind.edges() {
            let (a, b) = (cell[a as usize], cell[b as usize]);
            for (on, off) in [(a, b), (b, a)] {
                if place(on) != u32::MAX && place(off) == u32::MAX {
                    let length = distance(points[on as usize], points[off as usize]);
                    found.push((place(on), off, length));
                }
            }
        }
    }
    found
}

//! First cells at moving walls: each wall node with its nearest neighbour off the wall.

use crate::motion::{Motion, Role};
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::parallel::{self, BLOCK};
use azimesh_io::mesh::{CellRun, Mesh, in_32_bits};

/// Number of cells per task.
const CELLS: usize = 1 << 14;

/// An edge that leaves a wall: its node on the wall, its other node, its length.
type Edge = (u32, u32, f64);

/// Edges that leave a moving wall, the shortest at each wall node of the whole mesh. One rank has each edge.
#[derive(Debug, Clone, Default)]
pub struct FirstCells {
    /// Wall node and its neighbour, by their local indices.
    edges: Vec<(u32, u32)>,
    /// Length of the shortest edge of all ranks in the reference mesh.
    smallest: Option<f64>,
    /// The largest relative change of a length when coordinates are rounded to 32 bits, of all ranks.
    change_in_f32: f64,
}

impl FirstCells {
    /// Finds the edges in the reference mesh. Polyhedra and polygons have none. All ranks that share the mesh call it.
    pub(crate) fn find(mesh: &Mesh, motion: &Motion) -> Self {
        let surface = &motion.surface.nodes;
        let moving = surface.nodes.iter().zip(&surface.roles);
        let moving = moving.filter(|(_, role)| matches!(role, Role::Moving(_)));
        let walls: Vec<u32> = moving
            .filter_map(|(node, _)| mesh.node_here(*node))
            .collect();
        let found = shortest_of_all(mesh, shortest(mesh, &walls));
        let smallest = found.iter().map(|edge| edge.2).min_by(f64::total_cmp);
        let change = |at: usize| {
            let (on, off, length) = found[at];
            let [on, off] = [on, off].map(|node| in_32_bits(mesh.points[node as usize]));
            (distance(on, off) / length - 1.0).abs()
        };
        let change_in_f32 = parallel::largest(found.len(), change);
        Self {
            edges: found.iter().map(|&(on, off, _)| (on, off)).collect(),
            smallest: least_of_all(mesh, smallest),
            change_in_f32: (mesh.ranks().allgather(change_in_f32).into_iter()).fold(0.0, f64::max),
        }
    }

    /// Returns the edges from the wall, each with its node on the wall and its other node.
    #[cfg(test)]
    pub fn edges(&self) -> &[(u32, u32)] {
        &self.edges
    }

    /// Returns the smallest first-cell height, in mesh units.
    pub fn smallest(&self) -> Option<f64> {
        self.smallest
    }

    /// Returns the smallest ratio of first-cell heights to the reference mesh, of all ranks. `points` are the positions of
    /// the nodes of this rank. All ranks call it.
    pub(crate) fn smallest_ratio(&self, mesh: &Mesh, points: &[Vector]) -> Option<f64> {
        let ratio = |&(on, off): &(u32, u32)| {
            let length = |points: &[Vector]| distance(points[on as usize], points[off as usize]);
            length(points) / length(&mesh.points)
        };
        let least = parallel::map_blocks(self.edges.len(), BLOCK, &|range| {
            self.edges[range].iter().map(ratio).min_by(f64::total_cmp)
        });
        least_of_all(mesh, least.into_iter().flatten().min_by(f64::total_cmp))
    }

    /// Returns the largest relative change of a first-cell height when coordinates are rounded to 32 bits.
    pub fn change_in_f32(&self) -> f64 {
        self.change_in_f32
    }
}

/// Returns the smallest value of all ranks.
fn least_of_all(mesh: &Mesh, own: Option<f64>) -> Option<f64> {
    let of_ranks = mesh.ranks().allgather(own).into_iter().flatten();
    of_ranks.min_by(f64::total_cmp)
}

/// Keeps the edges that are the shortest of all ranks at their wall nodes, each on one rank.
fn shortest_of_all(mesh: &Mesh, own: Vec<Edge>) -> Vec<Edge> {
    let Some(part) = &mesh.part else { return own };
    let number = |&(on, off, length): &Edge| {
        let [on, off] = [on, off].map(|node| mesh.number_of_node(node));
        (on, length, off)
    };
    let of_ranks = part
        .ranks
        .allgather(own.iter().map(number).collect::<Vec<_>>());
    let of_ranks = (0..).zip(of_ranks);
    let mut all: Vec<(u32, f64, u32, usize)> = of_ranks
        .flat_map(|(rank, edges)| {
            let edges = edges.into_iter();
            edges.map(move |(on, length, off)| (on, length, off, rank))
        })
        .collect();
    all.sort_unstable_by(|a, b| {
        let by_length = a.1.total_cmp(&b.1);
        a.0.cmp(&b.0)
            .then(by_length)
            .then((a.2, a.3).cmp(&(b.2, b.3)))
    });
    all.dedup_by_key(|edge| edge.0);
    all.retain(|edge| edge.3 == part.ranks.rank());
    let kept = |edge: &Edge| {
        let (on, _, off) = number(edge);
        let at = all.binary_search_by_key(&on, |kept| kept.0);
        at.is_ok_and(|at| all[at].2 == off)
    };
    own.into_iter().filter(kept).collect()
}

/// Finds the shortest edge of the own cells that leaves the wall at each of the local wall nodes, which are ascending.
/// Of two equally long edges it takes the one with the lower other node.
fn shortest(mesh: &Mesh, nodes: &[u32]) -> Vec<Edge> {
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
    for run in mesh.volume_runs_in(mesh.own_cells()) {
        let edges = |cells: &[u32]| edges_off(&run, cells, &wall, &mesh.points);
        if run.n_cells() <= CELLS {
            shorten(edges(run.connectivity));
            continue;
        }
        let (nodes, size) = (run.connectivity, CELLS * run.n_nodes);
        let found = parallel::map_blocks(nodes.len(), size, &|range| edges(&nodes[range]));
        found.into_iter().for_each(&mut shorten);
    }
    let found = nodes.iter().zip(shortest);
    let found = found.filter(|(_, (off, _))| *off != u32::MAX);
    found
        .map(|(&on, (off, length))| (on, off, length))
        .collect()
}

/// Returns the edges of some cells of a run that leave the wall: index on the wall (by `wall`), other node, length.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Schedule;
    use azimesh_core::ranks::on_threads;
    use azimesh_io::mesh::cubes::{cubes, shuffled};
    use azimesh_io::mesh::{Boundary, CellSet, ZoneSides};
    use std::path::Path;

    const SCHEDULE: &str = "azimuth.values = [0, 90]
        boundaries.others = \"fixed\"
        rbf.support_radius = 10.0
        body = [ { name = \"a\", tags = [\"left\", \"low\"], cyclic = { pitch = [ { sin = 5.0 } ] } } ]";

    #[test]
    fn ranks_have_the_first_cells_of_the_whole_mesh_each_once() {
        let mesh = cubes(40);
        for mesh in [shuffled(&mesh), mesh] {
            let schedule = Schedule::parse(SCHEDULE, Path::new("s.toml")).expect("it is good");
            let sides_of = |cells: &CellSet| Ok(ZoneSides::of(&mesh, cells));
            let motion = schedule.resolve(&Boundary::of(&mesh), &sides_of);
            let motion = motion.expect("they fit");
            let wanted = FirstCells::find(&mesh, &motion);
            let moved = |[x, y, z]: Vector| [x + 0.1 * (y * z).sin(), y, z * 1.01 + 1e5];
            let points: Vec<Vector> = mesh.points.iter().map(|&point| moved(point)).collect();
            let ratio = wanted.smallest_ratio(&mesh, &points);
            assert!(wanted.edges().len() > 3000 && wanted.change_in_f32() > 0.0);
            for n in [1, 2, 3, 5] {
                let found = on_threads(n, |ranks| {
                    let part = Mesh::shared_of(ranks.is_first().then_some(&mesh), &ranks);
                    let found = FirstCells::find(&part, &motion);
                    assert_eq!(found.smallest(), wanted.smallest());
                    assert_eq!(found.change_in_f32(), wanted.change_in_f32());
                    let points: Vec<Vector> = part.points.iter().map(|&at| moved(at)).collect();
                    assert_eq!(found.smallest_ratio(&part, &points), ratio);
                    let number = |node: u32| part.number_of_node(node);
                    let edges = found.edges().iter();
                    let edges = edges.map(|&(on, off)| (number(on), number(off)));
                    edges.collect::<Vec<_>>()
                });
                let mut edges = found.concat();
                edges.sort_unstable();
                assert!(edges == wanted.edges());
            }
        }
    }
}

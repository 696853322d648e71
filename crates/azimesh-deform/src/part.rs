//! The nodes and cells of a rank, as needed for the steps of a run: on one rank, the whole mesh.

use super::plan::Plan;
use super::plan::first_cells::FirstCells;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_core::ranks::Ranks;
use azimesh_core::ranks::hash::{PartHasher, TreeHasher};
use azimesh_io::mesh::{Doubled, Mesh};
use bytemuck::Pod;
use std::sync::Arc;

/// The part of a mesh that a rank moves.
#[derive(Debug, Clone)]
pub struct Part {
    /// The mesh at rest; where a zone turns, its interface nodes are duplicated.
    pub mesh: Arc<Mesh>,
    /// The first cells at moving walls.
    pub first_cells: FirstCells,
    /// The copies of interface nodes, in the order of duplication.
    pub(super) doubled: Vec<Doubled>,
    /// The surface nodes of this rank, ascending, each with its index among all surface nodes.
    pub(super) surface: Vec<[u32; 2]>,
    /// The nodes that deform, ascending; `None` for all. In one layer of cells only the lower nodes: the upper ones follow.
    pub(super) deforming: Option<Vec<u32>>,
}

impl Part {
    pub(super) fn new(
        plan: &Plan,
        mesh: Arc<Mesh>,
        first_cells: FirstCells,
        doubled: Vec<Doubled>,
    ) -> Self {
        let surface = &plan.motion.surface.nodes.nodes;
        let here = |at: usize| Some([mesh.node_here(surface[at])?, at as u32]);
        Self {
            surface: parallel::filter_map(surface.len(), here),
            deforming: deforming_nodes(plan, &mesh),
            mesh,
            first_cells,
            doubled,
        }
    }

    /// Returns the ranks that share the mesh.
    pub fn ranks(&self) -> Ranks {
        self.mesh.ranks()
    }

    /// Gathers values at all surface nodes, in their order, on every rank. `of` receives a node of this rank and its index among
    /// the surface nodes.
    pub(super) fn surface_values<T: Pod + Send>(
        &self,
        of: impl Fn(usize, usize) -> T + Sync,
    ) -> Vec<T> {
        let own = self.mesh.own_nodes();
        let before = |end: usize| self.surface.partition_point(|of| (of[0] as usize) < end);
        let owned = &self.surface[before(own.start)..before(own.end)];
        let values = parallel::filter_map(owned.len(), |i| {
            let [node, at] = owned[i];
            Some(of(node as usize, at as usize))
        });
        let ranks = self.ranks();
        if ranks.n() == 1 {
            values
        } else {
            ranks.all_numbers(&values)
        }
    }

    /// Returns the BLAKE3 hash of the coordinates of all nodes.
    pub(super) fn points_hash(mesh: &Mesh) -> String {
        let own = &mesh.points[mesh.own_nodes()];
        let bytes: &[u8] = bytemuck::cast_slice(own);
        let ranks = mesh.ranks();
        if ranks.n() == 1 {
            let mut hasher = blake3::Hasher::new();
            hasher.update_rayon(bytes);
            return hasher.finalize().to_string();
        }
        let first = mesh.first_own_node() * size_of::<Vector>();
        let mut hasher = PartHasher::new(first as u64, bytes.len() as u64);
        hasher.update(bytes);
        let mut all = TreeHasher::default();
        ranks
            .allgather(hasher.finish())
            .iter()
            .for_each(|part| all.take(part));
        all.finalize().to_string()
    }
}

/// Returns the deforming nodes of a rank.
fn deforming_nodes(plan: &Plan, mesh: &Mesh) -> Option<Vec<u32>> {
    if let Some(layer) = &plan.one_layer {
        let low = layer.pairs.iter().map(|[low, _]| *low);
        return Some(low.filter(|node| plan.is_in_zone(*node)).collect());
    }
    plan.motion.zone.as_ref()?;
    Some(parallel::filter_map(mesh.points.len(), |at| {
        plan.is_in_zone(mesh.number_of_node(at as u32))
            .then_some(at as u32)
    }))
}

//! Sliding nodes on their boundary. On planes and straight edges the interpolant keeps them there, and only round-off is
//! removed. On curved boundaries they are projected, and the change fades into the mesh like the correction of the surface.

use super::MeshState;
use super::rank_correction::add_faded;
use crate::motion::{Motion, Role};
use crate::part::Part;
use crate::plan::Plan;
use crate::plan::surface::SurfacePoints;
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{Vector, distance, norm, sub};
use azimesh_core::parallel::{self, SMALL_BLOCK, collect_in_blocks};
use azimesh_rbf::slide::Sliding;

/// Returns the sliding nodes of a rank, each with its surface point.
fn sliding_nodes(plan: &Plan, part: &Part) -> Vec<(usize, usize)> {
    parallel::filter_map(part.surface.len(), |i| {
        let [node, at] = part.surface[i].map(|index| index as usize);
        let is_sliding = plan.motion.surface.nodes.roles[at] == Role::Sliding;
        is_sliding.then(|| (node, plan.surface.point_of[at] as usize))
    })
}

/// Puts the sliding nodes on their boundary. `state` is the mesh before the deformation.
pub(crate) fn place(plan: &Plan, part: &Part, state: MeshState<'_>, out: &mut [Vector]) {
    let Some(sliding) = &plan.surface.sliding else {
        return;
    };
    let nodes = sliding_nodes(plan, part);
    let placed = collect_in_blocks(nodes.len(), SMALL_BLOCK, |i| {
        let (node, point) = nodes[i];
        sliding.place(point, out[node])
    });
    if sliding.has_curved() {
        let change = |node: usize| {
            let i = nodes.partition_point(|of| of.0 < node);
            sub(placed[i], out[node])
        };
        let changes = changes(plan, part, change);
        fade_inward(part, state, &changes, out);
    }
    for ((node, _), x) in nodes.iter().zip(placed) {
        out[*node] = x;
    }
}

/// Returns the changes (N_s, 3) at all surface points, gathered from the sliding nodes of all ranks. Of several nodes at a
/// point the last one counts.
fn changes(plan: &Plan, part: &Part, change: impl Fn(usize) -> Vector + Sync) -> Vec<f64> {
    let roles = &plan.motion.surface.nodes.roles;
    let of_nodes = part.surface_values(|node, at| match roles[at] {
        Role::Sliding => change(node),
        Role::Moving(_) | Role::Fixed => [0.0; 3],
    });
    let mut changes = vec![0.0; 3 * plan.surface.nodes.len()];
    let nodes = roles.iter().zip(&plan.surface.point_of).zip(&of_nodes);
    for ((_, &point), change) in nodes.filter(|((role, _), _)| **role == Role::Sliding) {
        changes[3 * point as usize..][..3].copy_from_slice(change);
    }
    changes
}

/// Adds the changes (N_s, 3) of the surface to the nodes of this rank, fading out.
fn fade_inward(part: &Part, state: MeshState<'_>, changes: &[f64], out: &mut [Vector]) {
    let (sizes, _) = changes.as_chunks::<3>();
    let largest = sizes.iter().map(|change| norm(*change)).fold(0.0, f64::max);
    let (correction, _) = state.correction(changes, 3, largest);
    add_faded(
        &correction,
        state.nodes,
        state.deforming,
        out,
        &part.ranks(),
    );
}

/// Returns the distance of a sliding node at `x` from its boundary; `back` undoes the rotation of the zone.
pub(crate) fn off_boundary(
    sliding: &Sliding,
    point: usize,
    back: Option<&Transform>,
    x: Vector,
) -> f64 {
    let x = back.map_or(x, |back| back.apply(x));
    distance(x, sliding.place(point, x))
}

/// Returns the sliding points of a deformed mesh, if their normals may have turned.
pub(crate) fn on_moved_surface(
    motion: &Motion,
    surface: &SurfacePoints,
    points: &[Vector],
) -> Option<Sliding> {
    let sliding = surface.sliding.as_ref()?;
    if sliding.has_curved() {
        surface.find_sliding(&motion.surface.nodes, points)
    } else {
        None
    }
}

//! Sliding nodes on their boundary. On planes and straight edges the interpolant keeps them there and
//! only round-off is taken off; on curved boundaries they are projected, and the change fades into the
//! mesh as the correction of the surface does.

use super::fields::MeshState;
use super::surface::SurfacePoints;
use crate::geometry::Transform;
use crate::geometry::vector::{Vector, add, distance, norm, sub};
use crate::mesh::Slots;
use crate::motion::{Motion, Role};
use crate::parallel::{self, SMALL_BLOCK, collect_in_blocks};
use crate::rbf::correct::{Correction, FADE_RADIUS_PER_ERROR, Fading};
use crate::rbf::field::Field;
use crate::rbf::slide::Sliding;

/// The slots of mesh nodes that slide, with the surface point of each.
fn sliding_nodes(
    motion: &Motion,
    surface: &SurfacePoints,
    slots: Slots<'_>,
) -> Vec<(usize, usize)> {
    let nodes = &motion.surface.nodes;
    parallel::filter_map(nodes.nodes.len(), |at| {
        let is_sliding = nodes.roles[at] == Role::Sliding;
        is_sliding.then(|| (slots.of(nodes.nodes[at]), surface.point_of[at] as usize))
    })
}

/// Fades changes (N_s, 3) of the surface into nodes that are elsewhere.
pub(super) type FadeElsewhere<'a> = &'a dyn Fn(&Fading<'_>, &[f64]);

/// Puts the sliding nodes, which have `slots` in `out`, on their boundary. `state` is the mesh that has been deformed, of which the
/// nodes that deform are told by their slots.
pub(super) fn place(
    motion: &Motion,
    surface: &SurfacePoints,
    state: MeshState<'_>,
    elsewhere: FadeElsewhere<'_>,
    (slots, out): (Slots<'_>, &mut [Vector]),
) {
    let Some(sliding) = &surface.sliding else {
        return;
    };
    let nodes = sliding_nodes(motion, surface, slots);
    let placed = collect_in_blocks(nodes.len(), SMALL_BLOCK, |i| {
        let (node, point) = nodes[i];
        (node, point, sliding.place(point, out[node]))
    });
    if sliding.has_curved() {
        let mut changes = vec![0.0; 3 * surface.nodes.len()];
        let mut largest: f64 = 0.0;
        for (node, point, x) in &placed {
            let change = sub(*x, out[*node]);
            largest = largest.max(norm(change));
            changes[3 * point..3 * point + 3].copy_from_slice(&change);
        }
        let fade_radius = vec![FADE_RADIUS_PER_ERROR * largest; state.surface.len()];
        let fading = Fading::new(state.surface, state.facets, fade_radius);
        elsewhere(&fading, &changes);
        fade_inward(state, fading, &changes, out);
    }
    for (node, _, x) in placed {
        out[node] = x;
    }
}

/// Adds to the nodes in `out` the changes (N_s, 3) of the surface, fading out.
fn fade_inward(state: MeshState<'_>, fading: Fading<'_>, changes: &[f64], out: &mut [Vector]) {
    let deforming = state.deforming.map(<[u32]>::to_vec);
    let n_nodes = deforming.as_ref().map_or(state.nodes.len(), Vec::len);
    let mut field = Field {
        nodes: deforming,
        n_modes: 3,
        values: vec![0.0; 3 * n_nodes],
    };
    let correction = Correction::fading(fading, changes, 3);
    correction.add_to(&mut field, state.nodes);
    let (rows, _) = field.values.as_chunks::<3>();
    match &field.nodes {
        None => parallel::update(out, |node, x| *x = add(*x, rows[node])),
        Some(nodes) => {
            for (&node, row) in nodes.iter().zip(rows) {
                out[node as usize] = add(out[node as usize], *row);
            }
        }
    }
}

/// Largest distance of the sliding nodes, which have `slots` in `points`, from their boundary, which `to_inertial` has turned
/// with the zone, and the sum of its squares.
pub(super) fn off_boundary(
    motion: &Motion,
    surface: &SurfacePoints,
    to_inertial: Option<&Transform>,
    (slots, points): (Slots<'_>, &[Vector]),
) -> (f64, f64) {
    let Some(sliding) = &surface.sliding else {
        return (0.0, 0.0);
    };
    let back = to_inertial.map(Transform::inverse);
    let nodes = sliding_nodes(motion, surface, slots);
    let errors = collect_in_blocks(nodes.len(), SMALL_BLOCK, |i| {
        let (node, point) = nodes[i];
        let x = back.map_or(points[node], |back| back.apply(points[node]));
        distance(x, sliding.place(point, x))
    });
    errors
        .into_iter()
        .fold((0.0, 0.0), |(largest, squares): (f64, f64), error| {
            (largest.max(error), squares + error * error)
        })
}

/// The sliding points of a deformed mesh, where their normals have turned on the way.
pub(super) fn on_moved_surface(
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

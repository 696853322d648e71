//! Checks of a schedule against its mesh and of its options against each other, before a run.

use super::layer;
use super::periodic::PeriodicNodes;
use super::surface::SurfacePoints;
use crate::motion::{
    Interpolate, Motion, OnInverted, Polynomial, Role, Schedule, SelectionMethod, SelectionOptions,
    Step,
};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{distance, norm, sub};
use azimesh_core::numbers::{in_digits, short};
use azimesh_core::{Note, note};
use azimesh_io::mesh::{Boundary, Mesh, OneLayer};
use azimesh_rbf::modes::RigidSurface;

/// Support radii below this part of the diagonal of the mesh are refused.
const LEAST_RADIUS: f64 = 1e-9;

/// Refuses a mesh whose lengths cannot be squared.
pub(crate) fn check_size(boundary: &Boundary) -> Result<()> {
    let bounds = boundary.extent;
    if bounds.diagonal().is_finite() {
        Ok(())
    } else {
        Err(Error::input(format!(
            "the coordinates of the mesh go from {:.1e} to {:.1e}, and squares of such lengths overflow; scale \
             the mesh",
            bounds.low.into_iter().fold(f64::INFINITY, f64::min),
            bounds.high.into_iter().fold(f64::NEG_INFINITY, f64::max)
        )))
    }
}

/// Refuses a number of values that differs from the number of nodes; `what` is one of the values.
pub(crate) fn check_length(what: &str, found: usize, n: usize) -> Result<()> {
    if found == n {
        return Ok(());
    }
    Err(Error::input(format!(
        "found {} for {}; there must be one for each node",
        counted(found, what),
        counted(n, "node")
    )))
}

/// Refuses a rigid motion whose displacements are not finite or cannot be squared; the modes find that out for other
/// motions.
pub(crate) fn check_finite(motion: &Motion, surface: RigidSurface<'_>) -> Result<()> {
    for body in (0..motion.bodies.len()).filter(|&body| motion.is_rigid(body)) {
        let part = motion.parts.iter().find(|part| part.body == body);
        let bounds = part.map_or_else(
            || layer::bounds_of_body(surface, body),
            |part| part.sides.bounds,
        );
        if bounds.low[0] > bounds.high[0] {
            continue;
        }
        let corners = [bounds.low, bounds.high, bounds.nearest(&[0.0; 3])];
        for step in &motion.steps {
            let pose = motion.pose_part(body, step, 1.0);
            let off = corners.map(|x| distance(pose.apply(x), x));
            if !off.iter().all(|off| off.is_finite()) {
                return Err(Error::input(format!(
                    "body \"{}\" has displacements at step {} that are not finite or far too large",
                    motion.bodies[body].name, step.index
                ))
                .at(motion.bodies[body].place.clone()));
            }
        }
    }
    Ok(())
}

/// Refuses a motion out of the plane of a mesh of one layer, or one that separates its sides.
pub(crate) fn check_one_layer(
    layer: Option<&OneLayer>,
    mesh: &Mesh,
    motion: &Motion,
) -> Result<()> {
    let Some(layer) = layer else {
        return Ok(());
    };
    let least = LEAST_RADIUS * Bounds::around(&mesh.points).diagonal();
    let surface = &motion.surface.nodes;
    let body_of = |node: u32| {
        if let Some(body) = motion.body_of_node(node) {
            return Some(body);
        }
        let at = surface.nodes.binary_search(&node).ok()?;
        match surface.roles[at] {
            Role::Moving(body) => Some(usize::from(body)),
            Role::Fixed | Role::Sliding => None,
        }
    };
    let moving = layer.pairs.iter().map(|pair| (pair, pair.map(body_of)));
    let moving: Vec<_> = moving
        .filter(|(_, bodies)| bodies.iter().any(Option::is_some))
        .collect();
    for step in &motion.steps {
        let poses = motion.poses_in_place(step);
        for (pair, bodies) in &moving {
            let moved = [0, 1].map(|side| {
                let (node, x) = (pair[side], mesh.points[pair[side] as usize]);
                sub(bodies[side].map_or(x, |body| poses[body].place(node, x)), x)
            });
            let body = bodies[0].or(bodies[1]).unwrap_or(0);
            let what = match moved {
                [a, b] if a[layer.axis].abs().max(b[layer.axis].abs()) > least => {
                    "out of the plane of"
                }
                [a, b] if distance(a, b) > least => "apart the sides of",
                _ => continue,
            };
            return Err(Error::input(format!(
                "body \"{}\" moves node {} {what} this mesh of one layer at {step}; a mesh between sides called empty moves in \
                 its plane, normal to {}, and both sides alike",
                motion.bodies[body].name,
                pair[0],
                ["x", "y", "z"][layer.axis]
            ))
            .at(motion.bodies[body].place.clone()));
        }
    }
    Ok(())
}

/// Refuses support radii that vanish in round-off against the mesh.
pub(crate) fn check_radii(schedule: &Schedule, boundary: &Boundary) -> Result<()> {
    let least = LEAST_RADIUS * boundary.extent.diagonal();
    let radii = [
        ("support_radius", schedule.rbf.support_radius),
        ("rotation_radius", schedule.rbf.rotation_radius),
    ];
    let given = radii
        .iter()
        .filter_map(|(key, radius)| Some((key, (*radius)?)));
    match given.clone().find(|(_, radius)| *radius < least) {
        None => Ok(()),
        Some((key, radius)) => Err(Error::input(format!(
            "rbf.{key} = {} is smaller than the distance between any two nodes; lengths are in mesh \
             units, and the mesh is {} across",
            short(radius),
            in_digits(least / LEAST_RADIUS, 3)
        ))),
    }
}

/// Refuses a displacement of Algorithm 2 so small that no base points are needed for the tolerance.
pub(crate) fn check_constant(schedule: &Schedule, tolerance: f64) -> Result<()> {
    match schedule.selection.constant.map(norm) {
        Some(size) if size <= tolerance => Err(Error::input(format!(
            "selection.constant has the length {}, which is not larger than the tolerance {}, \
             so no base points would be chosen; give a displacement as large as those of the motion, or leave \
             the key out",
            short(size),
            short(tolerance)
        ))),
        _ => Ok(()),
    }
}

/// Returns notes on keys that have no effect with the method of the schedule.
pub(crate) fn unused(schedule: &Schedule) -> Vec<Note> {
    let (given, default) = (&schedule.selection, SelectionOptions::default());
    let unused = [
        ("max_points", given.max_points != default.max_points),
        ("criterion", given.criterion != default.criterion),
    ];
    let is_all = given.method == SelectionMethod::All;
    let unused = unused.iter().filter(|(_, is_given)| is_all && *is_given);
    unused
        .map(|&(key, _)| {
            note!(
                "unused_key",
                "selection.{key} is not used: method = \"all\" takes every surface node"
            )
            .with("key", key)
        })
        .collect()
}

/// Finds the first two steps with the same time.
pub(crate) fn repeated_time(steps: &[Step]) -> Option<Note> {
    let mut steps: Vec<_> = steps.iter().collect();
    steps.sort_by(|a, b| a.time().total_cmp(&b.time()));
    let twice = steps
        .windows(2)
        .find(|two| two[0].time() == two[1].time())?;
    Some(note!(
        "one_time",
        "steps {} and {} have the same time, {}; ParaView cannot distinguish them",
        twice[0].index,
        twice[1].index,
        short(twice[0].time())
    ))
}

/// Refuses options that cannot be combined.
pub(crate) fn check_combination(
    schedule: &Schedule,
    motion: &Motion,
    surface: &SurfacePoints,
    periodic: &PeriodicNodes,
) -> Result<()> {
    let mut bodies = 0..motion.bodies.len();
    let twist = schedule.rbf.interpolate == Interpolate::Twist;
    if let Some(body) = bodies
        .clone()
        .find(|&body| twist && !motion.has_rotations(body))
    {
        return Err(Error::input(format!(
            "interpolate = \"twist\" needs rotations, but body \"{}\" has only displacements of its nodes; use \
             \"displacement\", with substeps if cells fold",
            motion.bodies[body].name
        )));
    }
    let substeps = schedule.rbf.substeps > 1 || schedule.output.on_inverted == OnInverted::Substeps;
    if twist && substeps && !bodies.all(|body| motion.is_rigid(body)) {
        return Err(Error::input(
            "interpolate = \"twist\" with substeps is for rigid bodies only, and a beam bends; leave out \
             `substeps` and `on_inverted` = \"substeps\"",
        ));
    }
    let coupled = surface.sliding.is_some() || !periodic.images.is_empty();
    if coupled && schedule.rbf.polynomial == Polynomial::Linear {
        return Err(Error::input(
            "polynomial = \"linear\" cannot be used with sliding or periodic boundaries, because their nodes \
             would leave them; use \"none\"",
        ));
    }
    if !periodic.images.is_empty() && schedule.rbf.interpolate == Interpolate::Twist {
        return Err(Error::input(
            "interpolate = \"twist\" cannot be used with periodic boundaries, because the images turn about \
             other centres; use \"displacement\", with substeps if cells fold",
        ));
    }
    Ok(())
}

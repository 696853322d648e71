//! `on_inverted = "repair"`: cells of a step that substeps leave folded are made valid by moving nodes near them.
//!
//! The result follows from the positions of the step alone. Knows which nodes of a step may go where; the rest is
//! `repair`'s.

use super::measures::Measures;
use super::plan::Plan;
use crate::error::Result;
use crate::geometry::Transform;
use crate::geometry::vector::Vector;
use crate::motion::{Role, Step};
use crate::parallel;
use crate::progress::Stop;
use crate::rbf::constraint::Constraint;
use crate::repair::{Freedom, Limits, Partner, Repaired, Task, untangle};

/// Makes the cells of a step valid that are not.
///
/// # Errors
/// Where `stop` was asked for.
pub(super) fn untangle_step(
    plan: &Plan,
    measures: &Measures,
    step: &Step,
    points: &mut [Vector],
    stop: &Stop,
) -> Result<Repaired> {
    let to_inertial = plan.motion.to_inertial(step);
    let freedom = freedom(plan, measures, to_inertial.as_ref());
    let task = Task {
        mesh: &plan.mesh,
        reference: measures.orientation(),
        freedom: &freedom,
    };
    let repaired = untangle(task, points, Limits::default(), stop)?;
    let reference = &plan.mesh.points;
    plan.periodic
        .follow(&plan.motion, reference, to_inertial.as_ref(), points);
    if plan.motion.rotor.in_plane {
        parallel::update(points, |node, x| x[2] = reference[node][2]);
    }
    Ok(repaired)
}

/// Nodes of moving and fixed boundaries stay, those of planes that slide keep to them, periodic partners go together;
/// outside a deforming zone nothing moves.
fn freedom(plan: &Plan, measures: &Measures, to_inertial: Option<&Transform>) -> Freedom {
    let mut freedom = Freedom::inner(&plan.mesh, measures.adjacency());
    let turned = |constraint: Constraint| match to_inertial {
        None => constraint,
        Some(to_inertial) => {
            let normals = constraint.columns().iter();
            let normals: Vec<Vector> = normals.map(|normal| to_inertial.turn(*normal)).collect();
            Constraint::of_normals(&normals)
        }
    };
    let partners = plan.periodic.partners(to_inertial);
    for partner in &partners {
        freedom.free(partner.node);
        freedom.free(partner.leader);
    }
    freedom.pair(partners);
    let surface = &plan.motion.surface.nodes;
    for ((&node, role), &point) in surface
        .nodes
        .iter()
        .zip(&surface.roles)
        .zip(&plan.surface.point_of)
    {
        let sliding = plan.surface.sliding.as_ref();
        match (
            role,
            sliding.filter(|sliding| sliding.is_linear(point as usize)),
        ) {
            (Role::Sliding, Some(sliding)) => {
                freedom.hold(node, turned(sliding.constraint(point as usize)));
            }
            _ => freedom.fix(node),
        }
    }
    if let Some(zone) = &plan.motion.zone {
        for (node, inside) in (0..).zip(&zone.nodes) {
            if !inside {
                freedom.fix(node);
            }
        }
    }
    freedom
}

impl super::periodic::PeriodicNodes {
    /// The nodes that follow others, with the maps between them in the frame that `to_inertial` leads to.
    fn partners(&self, to_inertial: Option<&Transform>) -> Vec<Partner> {
        let map = |map: Transform| match to_inertial {
            None => map,
            Some(to_inertial) => to_inertial.inverse().then(&map).then(to_inertial),
        };
        let followers = self.followers().iter();
        followers
            .map(|follower| Partner {
                node: follower.node,
                leader: follower.leader,
                map: map(follower.map),
            })
            .collect()
    }
}

//! `on_inverted = "repair"`: makes folded cells of a step valid by moving nodes near them.
//!
//! The result depends only on the positions of the step. Knows the freedom of every node at a step; `repair` does the rest.

use crate::motion::periodic::Follower;
use crate::motion::{Role, Step, ToInertial};
use crate::plan::Plan;
use azimesh_core::error::Result;
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_core::progress::Stop;
use azimesh_io::mesh::{Coincident, Mesh, OneLayer};
use azimesh_quality::QualityEvaluator;
use azimesh_quality::repair::{
    Area, FoldedCells, Freedom, Limits, Partner, PatchLog, Task, untangle,
};
use azimesh_rbf::constraint::Constraint;

/// The directions in which the nodes of the whole mesh may move at a step.
pub(crate) struct StepFreedom<'a> {
    plan: &'a Plan,
    mesh: &'a Mesh,
    evaluator: &'a QualityEvaluator,
    to_inertial: Option<ToInertial<'a>>,
    freedom: Freedom,
}

impl<'a> StepFreedom<'a> {
    /// Creates the freedom at a step of a plan on a whole mesh.
    pub fn of(
        plan: &'a Plan,
        mesh: &'a Mesh,
        evaluator: &'a QualityEvaluator,
        copies: &Coincident,
        step: &Step,
    ) -> Self {
        let to_inertial = plan.motion.to_inertial(step);
        Self {
            freedom: freedom(plan, mesh, evaluator, copies, to_inertial.as_ref()),
            plan,
            mesh,
            evaluator,
            to_inertial,
        }
    }

    /// Returns the repair task.
    pub fn task(&self) -> Task<'_> {
        Task {
            mesh: self.mesh,
            reference: &self.evaluator.reference,
            freedom: &self.freedom,
        }
    }

    /// Makes invalid cells valid, moving as few nodes as possible.
    ///
    /// # Errors
    /// If `stop` was requested.
    pub fn untangle(
        &self,
        points: &mut [Vector],
        limits: Limits,
        stop: &Stop,
    ) -> Result<Vec<PatchLog>> {
        let repaired = untangle(self.task(), points, limits, stop)?;
        self.keep_alike(points);
        Ok(repaired.patches)
    }

    /// Adds the cells at `points` that need a repair to `all`, those below the scaled Jacobian `improve` too; gives how many
    /// these are.
    pub fn add(&self, all: &mut FoldedCells, points: &[Vector], improve: Option<f64>) -> usize {
        let n_folded = all.add(self.task(), points).all();
        let Some(wanted) = improve else {
            return n_folded;
        };
        n_folded + all.add_low(self.task(), points, wanted)
    }

    /// The area around these cells, with `rings` rings or, where cells at `points` are to be improved, as many as that takes.
    ///
    /// # Errors
    /// If `stop` was asked for.
    pub fn area(
        &self,
        cells: &FoldedCells,
        rings: usize,
        points: &mut [Vector],
        improve: Option<f64>,
        stop: &Stop,
    ) -> Result<Area> {
        match improve {
            Some(wanted) => Area::lifting(self.task(), cells, rings, points, wanted, stop),
            None => Ok(Area::around(self.task(), cells, rings)),
        }
    }

    /// Moves the nodes of an area to the minimum of its functional.
    ///
    /// # Errors
    /// If `stop` was requested.
    pub fn relax(&self, area: &Area, points: &mut [Vector], stop: &Stop) -> Result<Vec<PatchLog>> {
        let repaired = area.relax(self.task(), points, stop)?;
        self.keep_alike(points);
        Ok(repaired.patches)
    }

    /// Puts nodes back onto the curved boundary on which they slide, and followers onto the images of their leaders.
    pub fn keep_to_surface(&self, points: &mut [Vector]) {
        if let Some(sliding) = &self.plan.surface.sliding
            && sliding.has_curved()
        {
            let surface = &self.plan.motion.surface.nodes;
            let nodes = surface.nodes.iter().zip(&surface.roles);
            for ((&node, role), &point) in nodes.zip(&self.plan.surface.point_of) {
                let (node, point) = (node as usize, point as usize);
                if *role == Role::Sliding && !sliding.is_linear(point) {
                    let turn = self
                        .to_inertial
                        .as_ref()
                        .and_then(|to| to.of_node(node as u32));
                    let x = turn.map_or(points[node], |turn| turn.inverse().apply(points[node]));
                    let x = sliding.place(point, x);
                    points[node] = turn.map_or(x, |turn| turn.apply(x));
                }
            }
        }
        self.keep_alike(points);
    }

    /// Sets periodic followers, keeps a plane mesh in its plane, and makes both sides of one layer equal.
    fn keep_alike(&self, points: &mut [Vector]) {
        let plan = self.plan;
        let reference = &self.mesh.points;
        let to_inertial = self.to_inertial.as_ref();
        plan.periodic.follow(plan, self.mesh, to_inertial, points);
        if plan.motion.in_plane() {
            parallel::update(points, |node, x| x[2] = reference[node][2]);
        }
        if let Some(layer) = &plan.one_layer {
            layer.level(reference, points);
        }
    }
}

/// Returns the freedom of the nodes. Nodes of moving and fixed boundaries are fixed, nodes of sliding planes stay on
/// them, and periodic partners and copies of a node move together; outside a deforming zone nothing moves.
fn freedom(
    plan: &Plan,
    mesh: &Mesh,
    evaluator: &QualityEvaluator,
    copies: &Coincident,
    to_inertial: Option<&ToInertial<'_>>,
) -> Freedom {
    let is_alike = plan.periodic.followers().is_empty();
    let layer = plan.one_layer.as_ref().filter(|_| is_alike);
    let mut freedom = match layer {
        None => Freedom::inner(mesh, &evaluator.adjacency, copies),
        Some(layer) => {
            // In the plane, sides called `empty` are not a boundary.
            let high = layer.high_nodes(mesh.points.len());
            let is_upright = |nodes: &[u32]| {
                let n_high = nodes.iter().filter(|&&node| high[node as usize]).count();
                n_high > 0 && n_high < nodes.len()
            };
            Freedom::inside(mesh, &evaluator.adjacency, copies, &is_upright)
        }
    };
    let turned = |node: u32, constraint: Constraint| {
        let Some(turn) = to_inertial.and_then(|to| to.of_node(node)) else {
            return constraint;
        };
        let normals = constraint.columns().iter();
        let normals: Vec<Vector> = normals.map(|normal| turn.turn(*normal)).collect();
        Constraint::of_normals(&normals)
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
                freedom.hold(node, turned(node, sliding.constraint(point as usize)));
            }
            _ => freedom.fix(node),
        }
    }
    if let Some(layer) = layer {
        pair_sides(layer, &mut freedom);
    }
    if let Some(zone) = &plan.motion.zone {
        let outside = (0..mesh.points.len() as u32).filter(|node| !zone.sides.nodes.has(*node));
        outside.for_each(|node| freedom.fix(node));
    }
    freedom.unite(copies);
    freedom
}

/// Returns the copies of nodes that are one node. Copies in different frames and outside the deforming zones are not.
pub(crate) fn copies(plan: &Plan, mesh: &Mesh) -> Coincident {
    let class = |node: u32| match &plan.motion.zone {
        None => 0,
        Some(zone) if !zone.sides.nodes.has(node) => u32::MAX,
        Some(zone) => {
            let rotor = zone.part_of(node).and_then(|part| part.rotor);
            rotor.map_or(0, |rotor| rotor as u32 + 1)
        }
    };
    Coincident::of(&mesh.points, class)
}

/// Restricts nodes of the low side to the plane, and pairs them with the nodes over them.
fn pair_sides(layer: &OneLayer, freedom: &mut Freedom) {
    let mut normal = [0.0; 3];
    normal[layer.axis] = 1.0;
    let partners = layer.pairs.iter().map(|&[low, high]| {
        let is_fixed = freedom.is_fixed(low) || freedom.is_fixed(high);
        for node in [low, high] {
            if is_fixed {
                freedom.fix(node)
            } else {
                freedom.hold_too(node, normal)
            }
        }
        Partner {
            node: high,
            leader: low,
            map: Transform::IDENTITY,
        }
    });
    let partners = partners.collect();
    freedom.pair(partners);
}

impl crate::plan::periodic::PeriodicNodes {
    /// Returns the followers, with the maps from their leaders in the frame reached by `to_inertial`.
    fn partners(&self, to_inertial: Option<&ToInertial<'_>>) -> Vec<Partner> {
        let turn = |node: u32| to_inertial.and_then(|to| to.of_node(node));
        let map = |follower: &Follower| {
            let back = turn(follower.leader).map(Transform::inverse);
            let map = back.map_or(follower.map, |back| back.then(&follower.map));
            turn(follower.node).map_or(map, |turn| map.then(turn))
        };
        let followers = self.followers().iter();
        followers
            .map(|follower| Partner {
                node: follower.node,
                leader: follower.leader,
                map: map(follower),
            })
            .collect()
    }
}

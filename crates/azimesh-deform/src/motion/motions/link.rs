//! A link: the map that one motion applies at a step, and the rotations in it. A body has a chain of links.

use super::beam::sections::Sections;
use super::nodes::BodyNodes;
use azimesh_core::geometry::vector::{Vector, add, cross, dot, norm, scale, sub, unit};
use azimesh_core::geometry::{Moving, Transform};
use std::borrow::Cow;
use std::sync::Arc;

/// A rotation vector (radians) shorter than this has no axis.
const NO_AXIS: f64 = 1e-150;

/// Effect of a motion at a part of a step. `R` is rigid for every point, a map for each section of a beam, or a
/// displacement for each node.
#[derive(Debug, Clone)]
pub(in crate::motion) enum Link<'a, R = RigidLink> {
    Rigid(R),
    Sections(Box<Sections<'a>>),
    Nodes(NodeLink<'a>),
}

impl<'a> Link<'a> {
    /// Returns whether it moves nothing.
    pub fn is_rest(&self) -> bool {
        matches!(self, Self::Rigid(link) if link.rotations.is_empty() && link.translation.is_none())
    }

    /// Returns the rotations at `x` of the reference mesh, in their order.
    pub fn rotations(self, x: Vector) -> Vec<Rotation> {
        match self {
            Self::Rigid(link) => link.rotations,
            Self::Sections(sections) => sections.rotations(x),
            Self::Nodes(_) => Vec::new(),
        }
    }

    /// Returns the link at the start of a motion: the part `reached` of it, which grows by `growth` per second.
    pub fn ramped(self, [reached, growth]: [f64; 2]) -> Self {
        let rotation = |rotation: Rotation| Rotation {
            angle: reached * rotation.angle,
            rate: reached * rotation.rate + growth * rotation.angle,
            ..rotation
        };
        match self {
            Self::Rigid(RigidLink {
                rotations,
                translation,
            }) => Self::Rigid(RigidLink {
                rotations: rotations.into_iter().map(rotation).collect(),
                translation: translation.map(|[by, rate]| {
                    [
                        scale(by, reached),
                        add(scale(rate, reached), scale(by, growth)),
                    ]
                }),
            }),
            Self::Sections(sections) => {
                Self::Sections(Box::new(sections.ramped([reached, growth], rotation)))
            }
            Self::Nodes(nodes) => Self::Nodes(NodeLink {
                part: reached * nodes.part,
                growth,
                ..nodes
            }),
        }
    }

    /// Returns this link with its rigid part converted by `form`.
    pub fn with_rigid<R>(self, form: impl FnOnce(&RigidLink) -> R) -> Link<'a, R> {
        match self {
            Self::Rigid(link) => Link::Rigid(form(&link)),
            Self::Sections(sections) => Link::Sections(sections),
            Self::Nodes(nodes) => Link::Nodes(nodes),
        }
    }
}

/// Rotations, then a translation. It is at rest if it has neither.
#[derive(Debug, Clone, Default)]
pub(in crate::motion) struct RigidLink {
    /// The rotations, in their order.
    pub rotations: Vec<Rotation>,
    /// In mesh units, and in mesh units per second; the rate is 0 if the schedule has no time.
    pub translation: Option<[Vector; 2]>,
}

impl RigidLink {
    /// Returns the rigid map.
    pub fn map(&self) -> Transform {
        let maps = self.rotations.iter().map(Rotation::map);
        let turned = maps.reduce(|first, next| first.then(&next));
        let turned = turned.unwrap_or(Transform::IDENTITY);
        match self.translation {
            Some([by, _]) => turned.then(&Transform::translation(by)),
            None => turned,
        }
    }

    /// Returns the map with its velocity.
    pub fn moving(&self) -> Moving {
        let still = Moving::still(Transform::IDENTITY);
        let turned = (self.rotations.iter()).fold(still, |all, next| all.then(&next.moving()));
        match self.translation {
            Some([by, rate]) => turned.then(&Moving::translation(by, rate)),
            None => turned,
        }
    }
}

/// A right-handed rotation about an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation {
    /// Unit axis.
    pub axis: Vector,
    /// A point of the axis, in mesh units.
    pub origin: Vector,
    /// In radians.
    pub angle: f64,
    /// In radians per second; 0 if the schedule has no time.
    pub rate: f64,
    /// Rate of change of the axis per second.
    pub axis_rate: Vector,
}

impl Rotation {
    /// Returns the rotation about a fixed axis by an angle, which has a rate.
    pub(in crate::motion) fn about(axis: Vector, origin: Vector, [angle, rate]: [f64; 2]) -> Self {
        Self {
            axis,
            origin,
            angle,
            rate,
            axis_rate: [0.0; 3],
        }
    }

    /// Returns the rotation by a rotation vector, which has a rate.
    pub(in crate::motion) fn by([theta, rate]: [Vector; 2], origin: Vector) -> Self {
        let angle = norm(theta);
        let direction = unit(theta).filter(|_| angle > NO_AXIS);
        let axis = direction.or_else(|| unit(rate)).unwrap_or([1.0, 0.0, 0.0]);
        let along = dot(axis, rate);
        let across = sub(rate, scale(axis, along));
        Self {
            axis_rate: direction.map_or([0.0; 3], |_| scale(across, 1.0 / angle)),
            ..Self::about(axis, origin, [angle, along])
        }
    }

    /// Returns the rotation by a part, from 0 to 1, of the angle.
    pub(in crate::motion) fn part(self, part: f64) -> Self {
        Self {
            angle: part * self.angle,
            ..self
        }
    }

    /// Returns the map.
    pub fn map(&self) -> Transform {
        Transform::rotation(self.axis, self.origin, self.angle)
    }

    /// Returns the rotation with its velocity. The angular velocity of an angle `t` about an axis `a`, both of some rate, is
    ///
    /// ```text
    /// omega = t' a + sin(t) a' + (1 - cos(t)) a x a'
    /// ```
    pub fn moving(&self) -> Moving {
        let (sin, cos) = self.angle.sin_cos();
        let across = scale(cross(self.axis, self.axis_rate), 1.0 - cos);
        let across = add(scale(self.axis_rate, sin), across);
        let omega = add(scale(self.axis, self.rate), across);
        Moving::turning(self.map(), self.origin, omega)
    }
}

/// Displacements of individual nodes: the sum of some fields, times a part.
#[derive(Debug, Clone)]
pub(in crate::motion) struct NodeLink<'a> {
    pub nodes: Arc<BodyNodes>,
    /// Displacements, and their rates where they are requested.
    pub fields: Vec<(NodeField<'a>, Option<NodeField<'a>>)>,
    /// From 0 to 1.
    pub part: f64,
    /// Rate of the part, per second.
    pub growth: f64,
}

/// A vector for each node of a body.
#[derive(Debug, Clone)]
pub(in crate::motion) enum NodeField<'a> {
    /// The vectors themselves.
    Values(Cow<'a, [Vector]>),
    /// Shapes times factors.
    Shapes(Vec<(&'a [Vector], f64)>),
}

impl<'a> NodeField<'a> {
    /// Shapes times factors; many factors may be zero.
    pub fn shapes(shapes: &'a [Vec<Vector>], factors: Vec<f64>) -> Self {
        let pairs = shapes.iter().map(Vec::as_slice).zip(factors);
        Self::Shapes(pairs.filter(|(_, factor)| *factor != 0.0).collect())
    }

    fn at(&self, node: usize) -> Vector {
        match self {
            Self::Values(values) => values[node],
            Self::Shapes(shapes) => {
                (shapes.iter()).fold([0.0; 3], |sum, (shape, q)| add(sum, scale(shape[node], *q)))
            }
        }
    }
}

impl<'a> NodeLink<'a> {
    /// Combines both: displacements are added before they act.
    pub fn join(&mut self, other: Self) {
        self.fields.extend(other.fields);
    }

    /// Returns the displacement of a node; zero for nodes of another body.
    pub fn displacement(&self, node: u32) -> Vector {
        scale(self.sum(node, |(field, _)| Some(field)), self.part)
    }

    /// Returns its rate, in mesh units per second.
    pub fn rate(&self, node: u32) -> Vector {
        let rate = scale(self.sum(node, |(_, rate)| rate.as_ref()), self.part);
        match self.growth {
            0.0 => rate,
            growth => add(
                rate,
                scale(self.sum(node, |(field, _)| Some(field)), growth),
            ),
        }
    }

    fn sum<'s>(
        &'s self,
        node: u32,
        of: impl Fn(&'s (NodeField<'a>, Option<NodeField<'a>>)) -> Option<&'s NodeField<'a>>,
    ) -> Vector {
        let Some(at) = self.nodes.find(node) else {
            return [0.0; 3];
        };
        let fields = self.fields.iter().filter_map(of);
        fields.fold([0.0; 3], |sum, field| add(sum, field.at(at)))
    }
}

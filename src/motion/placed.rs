//! Where the points of a body are: an exact map, the same for all of a rigid body and one for each
//! section of a beam.

use super::driven::{BodyNodes, ModeShapes, Sections};
use crate::geometry::Transform;
use crate::geometry::vector::{Vector, add, scale};
use std::borrow::Cow;

/// The exact map `x -> x'` of the points of a body from the reference mesh: maps one after another.
/// A point keeps the section of a beam that it is in in the reference mesh.
#[derive(Debug, Clone)]
pub struct Pose<'a> {
    shift: Option<Shift<'a>>,
    links: Vec<Link<'a>>,
}

/// Displacements that nodes have of their own, before the maps.
#[derive(Debug, Clone)]
pub(super) struct Shift<'a> {
    pub nodes: &'a BodyNodes,
    /// Those of a surface file.
    pub surface: Option<Cow<'a, [Vector]>>,
    /// Mode shapes with their coordinates.
    pub modes: Option<(&'a ModeShapes, Vec<f64>)>,
    /// The part of them, from 0 to 1.
    pub part: f64,
}

impl Shift<'_> {
    /// The displacement of a node; zero where it is another body's.
    pub fn of(&self, node: u32) -> Vector {
        let Some(at) = self.nodes.find(node) else {
            return [0.0; 3];
        };
        let surface = self
            .surface
            .as_ref()
            .map_or([0.0; 3], |surface| surface[at]);
        let modes = self.modes.as_ref();
        let modes = modes.map_or([0.0; 3], |(shapes, factors)| shapes.sum(factors, at));
        scale(add(surface, modes), self.part)
    }
}

/// One of the maps.
#[derive(Debug, Clone)]
enum Link<'a> {
    /// The same for every point.
    Rigid(Transform),
    /// One for each section of a beam.
    Sections(Box<Sections<'a>>),
}

impl<'a> Pose<'a> {
    /// One map for every point.
    pub(super) fn of_rigid(map: Transform) -> Self {
        Self {
            shift: None,
            links: vec![Link::Rigid(map)],
        }
    }

    /// Nodes first move by displacements of their own.
    pub(super) fn after_shift(self, shift: Option<Shift<'a>>) -> Self {
        Self { shift, ..self }
    }

    /// The map of the whole body, where it moves as one.
    pub fn rigid(&self) -> Option<&Transform> {
        match self.links.as_slice() {
            [Link::Rigid(map)] if self.shift.is_none() => Some(map),
            _ => None,
        }
    }

    /// First `self`, then `next`.
    #[must_use]
    pub fn then(mut self, next: &Transform) -> Self {
        match self.links.last_mut() {
            Some(Link::Rigid(map)) => *map = map.then(next),
            _ => self.links.push(Link::Rigid(*next)),
        }
        self
    }

    /// First `self`, then the bending of a beam.
    pub(super) fn then_sections(mut self, sections: Sections<'a>) -> Self {
        self.links.push(Link::Sections(Box::new(sections)));
        self
    }

    /// First `self`, then the motion of a parent.
    pub(super) fn then_pose(self, parent: Self) -> Self {
        parent
            .links
            .into_iter()
            .fold(self, |pose, link| match link {
                Link::Rigid(map) => pose.then(&map),
                Link::Sections(sections) => pose.then_sections(*sections),
            })
    }

    /// The rigid map of what is around the point `x` of the reference mesh.
    pub fn map(&self, x: Vector) -> Transform {
        let maps = self.links.iter().map(|link| match link {
            Link::Rigid(map) => *map,
            Link::Sections(sections) => sections.map(x),
        });
        maps.reduce(|first, next| first.then(&next))
            .unwrap_or(Transform::IDENTITY)
    }

    /// The place of what is at the point `x` of the reference mesh and has no displacement of its own.
    #[inline]
    pub fn apply(&self, x: Vector) -> Vector {
        self.moved(x, x)
    }

    /// The place of a node whose place in the reference mesh is `x`.
    #[inline]
    pub fn place(&self, node: u32, x: Vector) -> Vector {
        match &self.shift {
            None => self.apply(x),
            Some(shift) => self.moved(x, add(x, shift.of(node))),
        }
    }

    /// The place of `start`, which moves with what is at `x` of the reference mesh.
    #[inline]
    fn moved(&self, x: Vector, start: Vector) -> Vector {
        self.links.iter().fold(start, |at, link| match link {
            Link::Rigid(map) => map.apply(at),
            Link::Sections(sections) => sections.place(x, at),
        })
    }
}

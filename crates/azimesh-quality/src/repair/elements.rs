//! The cells of a patch as simplices with target shapes, and the functional of one cell.
//!
//! Leaves to `patch` which nodes move, and to `newton` what is done with the derivatives.

use super::density::Space;
use super::derivatives::{
    Derivatives, Sum, columns, derivatives, sample_derivatives, sample_values, values,
};
use super::shape::regular;
use super::simplices::{Edges, Simplices};
use super::singular::Columns;
use crate::validity::Samples;
use azimesh_core::geometry::vector::{Vector, add, cross, dot, scale, sub};
use azimesh_io::mesh::CellKind;
use std::sync::Arc;

/// A simplex and its target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Simplex {
    pub edges: Edges,
    /// Rows of the inverse of the target's edges.
    pub inverse: Columns,
    pub weight: f64,
    /// Weight of the size against the shape.
    pub theta: f64,
}

/// A point of a curved cell and its target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub point: u32,
    /// Rows of the inverse of the target's derivatives.
    pub inverse: Columns,
    pub weight: f64,
    pub theta: f64,
}

/// Indices of the parts of a cell in the lists.
#[derive(Debug, Clone, Copy)]
struct Element {
    first_node: u32,
    n_nodes: u16,
    n_means: u16,
    first_mean: u32,
    /// Of a curved cell its samples, whose derivatives are in this table.
    first_simplex: u32,
    n_simplices: u32,
    table: Option<u32>,
}

/// Cells as simplices. Nodes are numbered in the patch.
#[derive(Debug, Clone)]
pub(super) struct Elements {
    space: Space,
    list: Vec<Element>,
    nodes: Vec<u32>,
    means: Vec<Vec<u16>>,
    simplices: Vec<Simplex>,
    samples: Vec<Sample>,
    tables: Vec<Arc<Samples>>,
}

/// Target shape of a cell.
pub(super) struct Target<'a> {
    /// Nodes in the reference mesh.
    pub reference: &'a [Vector],
    /// The orientation of the cell, 1 or -1.
    pub sign: f64,
    /// True if all of its simplices must become positive. Otherwise only those that are so, and were, are kept so.
    pub whole: bool,
    /// The length of an edge for a cell without one of its own.
    pub size: f64,
    /// True if the cell is to become regular, whatever its reference.
    pub regular: bool,
    /// Weight of each simplex.
    pub weight: f64,
    /// Weight of the size against the shape.
    pub theta: f64,
}

/// A simplex of the reference flatter than this counts as flat: its determinant over the product of its edges.
const FLAT: f64 = 1e-12;

/// The straight cell of a folded one that is flatter is no target.
const NEARLY_FLAT: f64 = 0.1;

/// A cell that is added.
pub(super) struct NewCell<'a> {
    /// Its kind.
    pub kind: CellKind,
    /// Its nodes, as nodes of the patch.
    pub nodes: &'a [u32],
    /// Current positions.
    pub at: &'a [Vector],
    /// True if they can move.
    pub can_move: &'a [bool],
    /// Target shape.
    pub target: Target<'a>,
}

impl NewCell<'_> {
    /// Returns whether a point of the cell, a corner or a mean of corners, can move.
    fn moves(&self, simplices: &Simplices, point: u16) -> bool {
        match usize::from(point).checked_sub(self.at.len()) {
            Some(mean) => simplices.means[mean]
                .iter()
                .any(|&node| self.can_move[usize::from(node)]),
            None => self.can_move[usize::from(point)],
        }
    }
}

/// Result of adding a simplex of a cell.
enum Found {
    Simplex(Simplex),
    /// Folded, and none of its points can move.
    Stuck,
    None,
}

/// The points of a cell that is added, means included.
struct Shapes {
    reference: Vec<Vector>,
    now: Vec<Vector>,
    /// Of the regular cell, where that is the target.
    regular: Option<Vec<Vector>>,
}

impl Shapes {
    fn of(space: Space, cell: &NewCell<'_>, simplices: &Simplices) -> Self {
        let with_means = |corners: &[Vector]| {
            let means = simplices.means.iter().map(|mean| middle(mean, corners));
            let means: Vec<Vector> = means.collect();
            [corners, &means].concat()
        };
        let target = &cell.target;
        let mut shapes = Self {
            reference: with_means(target.reference),
            now: with_means(cell.at),
            regular: None,
        };
        let keeps_shape = !target.regular
            && simplices
                .edges
                .iter()
                .all(|edges| is_double(edges, cell.nodes) || shapes.is_good(space, edges, target));
        if !keeps_shape {
            let corners = regular(cell.kind, target.reference, target.sign, target.size);
            shapes.regular = corners.map(|corners| with_means(&corners));
        }
        shapes
    }

    /// Returns whether a simplex is neither folded nor flat in the reference.
    fn is_good(&self, space: Space, edges: &Edges, target: &Target<'_>) -> bool {
        determinant(space, edges, &self.reference, target.sign) > FLAT
    }
}

impl Elements {
    pub(super) fn new(space: Space) -> Self {
        Self {
            space,
            list: Vec::new(),
            nodes: Vec::new(),
            means: Vec::new(),
            simplices: Vec::new(),
            samples: Vec::new(),
            tables: Vec::new(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// Returns whether cells are curved.
    pub(super) fn are_curved(&self) -> bool {
        !self.tables.is_empty()
    }

    /// Adds a cell as far as it can be given a target. Gives the number of its simplices that are folded and cannot
    /// move, which are left out.
    pub(super) fn push(&mut self, cell: &NewCell<'_>, simplices: Simplices) -> usize {
        let shapes = Shapes::of(self.space, cell, &simplices);
        let first_simplex = self.simplices.len();
        let mut n_stuck = 0;
        for edges in &simplices.edges {
            match self.simplex(cell, &simplices, &shapes, edges) {
                Found::Simplex(simplex) => self.simplices.push(simplex),
                Found::Stuck => n_stuck += 1,
                Found::None => {}
            }
        }
        let n_simplices = self.simplices.len() - first_simplex;
        if n_simplices > 0 {
            self.list.push(Element {
                first_node: self.nodes.len() as u32,
                n_nodes: cell.nodes.len() as u16,
                n_means: simplices.means.len() as u16,
                first_mean: self.means.len() as u32,
                first_simplex: first_simplex as u32,
                n_simplices: n_simplices as u32,
                table: None,
            });
            self.nodes.extend_from_slice(cell.nodes);
            self.means.extend(simplices.means);
        }
        n_stuck
    }

    /// One simplex of a cell that is added.
    fn simplex(
        &self,
        cell: &NewCell<'_>,
        simplices: &Simplices,
        shapes: &Shapes,
        edges: &Edges,
    ) -> Found {
        let target = &cell.target;
        if is_double(edges, cell.nodes) && shapes.regular.is_none() {
            return Found::None;
        }
        let positive = determinant(self.space, edges, &shapes.now, target.sign) > 0.0;
        if !(target.whole || (positive && shapes.is_good(self.space, edges, target))) {
            return Found::None;
        }
        if !edges
            .as_flattened()
            .iter()
            .any(|&point| cell.moves(simplices, point))
        {
            return if positive { Found::None } else { Found::Stuck };
        }
        let corners = shapes.regular.as_ref().unwrap_or(&shapes.reference);
        let inverse = self.inverse(vectors(self.space, edges, corners), target);
        inverse.map_or(Found::None, |inverse| {
            Found::Simplex(Simplex {
                edges: *edges,
                inverse,
                weight: target.weight,
                theta: target.theta,
            })
        })
    }

    /// Adds a curved cell, like [`Self::push`], with the points `samples`.
    pub(super) fn push_curved(&mut self, cell: &NewCell<'_>, samples: &Arc<Samples>) -> usize {
        let (space, target) = (self.space, &cell.target);
        let shape = curved_target(space, cell, samples);
        let first = self.samples.len();
        let mut n_stuck = 0;
        for (point, shape) in shape.into_iter().enumerate() {
            let slopes = samples.of_nodes(point);
            let positive = relative(&columns(space, slopes, cell.at), target.sign) > 0.0;
            if !(target.whole || (positive && relative(&shape, target.sign) > FLAT)) {
                continue;
            }
            let counts = |slope: &Vector| slope.iter().any(|x| x.abs() > 1e-12);
            let mut pairs = slopes.iter().zip(cell.can_move);
            if !pairs.any(|(slope, can_move)| *can_move && counts(slope)) {
                n_stuck += usize::from(!positive);
            } else if let Some(inverse) = self.inverse(shape, target) {
                self.samples.push(Sample {
                    point: point as u32,
                    inverse,
                    weight: target.weight,
                    theta: target.theta,
                });
            }
        }
        let n_samples = self.samples.len() - first;
        if n_samples > 0 {
            let known = self.tables.iter().position(|of| Arc::ptr_eq(of, samples));
            let table = known.unwrap_or_else(|| {
                self.tables.push(samples.clone());
                self.tables.len() - 1
            });
            self.list.push(Element {
                first_node: self.nodes.len() as u32,
                n_nodes: cell.nodes.len() as u16,
                n_means: 0,
                first_mean: self.means.len() as u32,
                first_simplex: first as u32,
                n_simplices: n_samples as u32,
                table: Some(table as u32),
            });
            self.nodes.extend_from_slice(cell.nodes);
        }
        n_stuck
    }

    /// Rows of the inverse of the target's edges. A simplex that is folded in a reference that has no regular shape
    /// is given equal upright edges.
    fn inverse(&self, mut e: Columns, target: &Target<'_>) -> Option<Columns> {
        let n = self.space.n_edges();
        if relative(&e, target.sign) <= FLAT {
            let lengths = e[..n].iter().map(|edge| dot(*edge, *edge).sqrt());
            let length = lengths.fold(0.0, f64::max);
            let length = if length > 0.0 { length } else { target.size };
            e = [
                [length, 0.0, 0.0],
                [0.0, target.sign * length, 0.0],
                [0.0, 0.0, 1.0],
            ];
            if n == 3 {
                e[2][2] = length;
            }
        }
        let normals = [cross(e[1], e[2]), cross(e[2], e[0]), cross(e[0], e[1])];
        let determinant = dot(e[0], normals[0]);
        let inverse = normals.map(|normal| scale(normal, 1.0 / determinant));
        let finite = inverse.as_flattened().iter().all(|x| x.is_finite());
        finite.then_some(inverse)
    }

    /// The nodes of a cell.
    #[inline]
    pub(super) fn nodes(&self, cell: usize) -> &[u32] {
        let element = &self.list[cell];
        let first = element.first_node as usize;
        &self.nodes[first..first + usize::from(element.n_nodes)]
    }

    fn means_of(&self, element: &Element) -> &[Vec<u16>] {
        let first = element.first_mean as usize;
        &self.means[first..first + usize::from(element.n_means)]
    }

    fn simplices_of(&self, element: &Element) -> &[Simplex] {
        let first = element.first_simplex as usize;
        &self.simplices[first..first + element.n_simplices as usize]
    }

    fn samples_of(&self, element: &Element) -> Option<(&[Sample], &Samples)> {
        let table = &self.tables[element.table? as usize];
        let first = element.first_simplex as usize;
        Some((
            &self.samples[first..first + element.n_simplices as usize],
            table,
        ))
    }

    /// The places of the points of a cell.
    #[inline(always)]
    fn gather(&self, cell: usize, at: &[Vector], places: &mut Vec<Vector>) {
        places.clear();
        places.extend(self.nodes(cell).iter().map(|&node| at[node as usize]));
        for mean in self.means_of(&self.list[cell]) {
            places.push(middle(mean, places));
        }
    }

    /// The value of the functional of a cell, its least determinant, and how many are not positive.
    pub(super) fn value(
        &self,
        cell: usize,
        eps: f64,
        at: &[Vector],
        places: &mut Vec<Vector>,
    ) -> (f64, f64, usize) {
        self.gather(cell, at, places);
        let element = &self.list[cell];
        match self.samples_of(element) {
            Some((samples, table)) => sample_values(self.space, eps, samples, table, places),
            None => values(self.space, eps, self.simplices_of(element), places),
        }
    }

    /// Value and derivatives of the functional of a cell.
    pub(super) fn derive(&self, cell: usize, sum: Sum, at: &[Vector], found: &mut Derivatives) {
        let mut places = std::mem::take(&mut found.places);
        self.gather(cell, at, &mut places);
        let element = &self.list[cell];
        let n = places.len();
        found.slope.clear();
        found.slope.resize(n, [0.0; 3]);
        found.blocks.clear();
        found.blocks.resize(n * (n + 1) / 2, [0.0; 9]);
        match self.samples_of(element) {
            Some((samples, table)) => {
                sample_derivatives(self.space, sum, samples, table, &places, found);
            }
            None => derivatives(self.space, sum, self.simplices_of(element), &places, found),
        }
        found.places = places;
        if element.n_means > 0 {
            found.condense(usize::from(element.n_nodes), self.means_of(element));
        }
    }
}

/// Returns whether an edge of a simplex is between nodes that are one and the same.
fn is_double(edges: &Edges, nodes: &[u32]) -> bool {
    let same = |[a, b]: [u16; 2]| {
        let node = |point: u16| nodes.get(usize::from(point));
        a != b && node(a).is_some() && node(a) == node(b)
    };
    let (n, own) = (edges.len(), |i: usize| edges[i]);
    let tips_meet = (0..n).any(|i| (0..i).any(|k| same([own(i)[1], own(k)[1]])));
    edges.iter().any(|edge| same(*edge)) || tips_meet
}

fn middle(of: &[u16], points: &[Vector]) -> Vector {
    let sum = of
        .iter()
        .fold([0.0; 3], |sum, &i| add(sum, points[usize::from(i)]));
    scale(sum, 1.0 / of.len().max(1) as f64)
}

#[inline(always)]
pub(super) fn edge([from, to]: [u16; 2], points: &[Vector]) -> Vector {
    sub(points[usize::from(to)], points[usize::from(from)])
}

/// Returns the derivatives of the target of a curved cell at each point. The target is the cell in the reference; if it is
/// folded there, the straight cell on its corners; if that is nearly flat too, a regular cell.
fn curved_target(space: Space, cell: &NewCell<'_>, samples: &Samples) -> Vec<Columns> {
    let target = &cell.target;
    let points = 0..samples.n_points();
    let of_corners = |corners: &[Vector]| -> Vec<Columns> {
        let of = |point| columns(space, samples.of_corners(point), corners);
        points.clone().map(of).collect()
    };
    let are_above =
        |least: f64| move |all: &Vec<Columns>| all.iter().all(|e| relative(e, target.sign) > least);
    let curved = || {
        let of = |point| columns(space, samples.of_nodes(point), target.reference);
        points.clone().map(of).collect()
    };
    let corners = &target.reference[..cell.kind.n_corners(cell.nodes.len())];
    let shape = (!target.regular).then(curved).filter(are_above(FLAT));
    shape
        .or_else(|| {
            let straight = (!target.regular).then(|| of_corners(corners));
            straight.filter(are_above(NEARLY_FLAT))
        })
        .or_else(|| regular(cell.kind, corners, target.sign, target.size).map(|of| of_corners(&of)))
        .unwrap_or_else(curved)
}

/// The edges of a simplex; in a plane the third is upright.
fn vectors(space: Space, edges: &Edges, points: &[Vector]) -> Columns {
    let mut e = [[0.0, 0.0, 1.0]; 3];
    for k in 0..space.n_edges() {
        e[k] = edge(edges[k], points);
    }
    e
}

/// The determinant of the edges over the product of their lengths, positive for the orientation `sign`.
fn determinant(space: Space, edges: &Edges, points: &[Vector], sign: f64) -> f64 {
    relative(&vectors(space, edges, points), sign)
}

/// The same of edges as vectors.
fn relative(e: &Columns, sign: f64) -> f64 {
    let lengths = e.map(|edge| dot(edge, edge).sqrt());
    let product = lengths[0] * lengths[1] * lengths[2];
    sign * dot(e[0], cross(e[1], e[2])) / product.max(f64::MIN_POSITIVE)
}

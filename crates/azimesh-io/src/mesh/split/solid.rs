//! The parts of one polyhedron: tetrahedra and pyramids between its faces and a point inside.

use super::super::outward::{turn_alike, turn_away};
use super::super::sides::for_each_side;
use super::super::{CellRef, Cells};
use super::flat::{fan, mean};
use super::inside::{Plane, inner_point};
use super::nodes::{FaceNodes, corners};
use super::{MIDDLE, Parts};
use azimesh_core::geometry::vector::{Vector, add, cross, dot, norm, scale, sub, unit};

/// Places of old and new nodes.
type Places<'a> = (&'a [Vector], &'a [Vector]);

fn place((old, new): Places<'_>, node: u32) -> Vector {
    let node = node as usize;
    match node.checked_sub(old.len()) {
        None => old[node],
        Some(i) => new[i],
    }
}

/// A base of a part: three or four nodes, turning so that the normal points out of the cell.
type Base = Vec<u32>;

/// Splits a cell of any kind that has faces.
pub(super) fn split(
    cells: &Cells,
    cell: &CellRef<'_>,
    points: Places<'_>,
    faces: &FaceNodes,
) -> Parts {
    let mut sides: Vec<Vec<u32>> = Vec::new();
    for_each_side(cells, cell, |_, nodes| {
        let corners = corners(nodes);
        if corners.len() >= 3 {
            sides.push(corners);
        }
    });
    let at: Vec<Vector> = cell.nodes.iter().map(|&n| place(points, n)).collect();
    let middle = mean(&at);
    let is_closed = turn_alike(&mut sides);
    if !is_closed {
        turn_away(&mut sides, &|node| place(points, node), middle);
    }
    let mut bases: Vec<Base> = Vec::new();
    for side in &sides {
        match faces.get(side) {
            Some(node) => bases.extend(fan(side, node).iter().map(|part| part.to_vec())),
            None => bases.push(side.clone()),
        }
    }
    let (volume, centroid) = volume_and_centroid(&bases, points, middle);
    if is_closed && volume < 0.0 {
        bases.iter_mut().for_each(|base| base.reverse());
    }
    let size = at.iter().map(|&x| norm(sub(x, middle))).fold(0.0, f64::max);
    let (planes, is_full) = planes(&bases, points);
    let (place, is_inside) = inner_point(&planes, &[middle, centroid], size);
    let mut parts = Parts {
        middle: Some(place),
        is_positive: is_closed && is_full && is_inside && !bases.is_empty(),
        ..Parts::default()
    };
    for base in &bases {
        let list = match base.len() {
            3 => &mut parts.simplices,
            _ => &mut parts.others,
        };
        list.extend(base.iter().rev());
        list.push(MIDDLE);
    }
    parts
}

/// Corners of a base, each between the one before and the one after: all four of a quadrilateral, one of a
/// triangle.
fn base_corners(base: &[u32], points: Places<'_>) -> impl Iterator<Item = [Vector; 3]> {
    let n = base.len();
    let corner = move |i: usize| [i, (i + 1) % n, (i + n - 1) % n].map(|k| place(points, base[k]));
    (0..if n == 3 { 1 } else { n }).map(corner)
}

/// Volume between the bases, and its centroid; `middle` where there is none. A quadrilateral counts with the
/// mean of its two ways to be two triangles, as everywhere.
fn volume_and_centroid(bases: &[Base], points: Places<'_>, middle: Vector) -> (f64, Vector) {
    let (mut volume, mut moment) = (0.0, [0.0; 3]);
    for base in bases {
        let share = if base.len() == 3 { 1.0 } else { 0.5 };
        for corner in base_corners(base, points) {
            let [a, b, c] = corner.map(|x| sub(x, middle));
            let part = share * dot(a, cross(b, c)) / 6.0;
            volume += part;
            moment = add(moment, scale(add(add(a, b), c), 0.25 * part));
        }
    }
    let centroid = match volume {
        0.0 => middle,
        _ => add(middle, scale(moment, 1.0 / volume)),
    };
    let is_finite = centroid.iter().all(|x| x.is_finite());
    (volume, if is_finite { centroid } else { middle })
}

/// The planes of all corners of the bases, and whether each has one.
fn planes(bases: &[Base], points: Places<'_>) -> (Vec<Plane>, bool) {
    let corners = bases.iter().flat_map(|base| base_corners(base, points));
    let plane = |[at, next, before]: [Vector; 3]| {
        let inward = unit(cross(sub(before, at), sub(next, at)));
        inward.map(|inward| Plane { at, inward })
    };
    let planes: Vec<Option<Plane>> = corners.map(plane).collect();
    let is_full = planes.iter().all(Option::is_some);
    (planes.into_iter().flatten().collect(), is_full)
}

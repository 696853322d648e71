//! Faces that belong to one cell only, for boundaries that a file gives by their nodes alone.

use crate::mesh::{CellKind, Cells};
use std::ops::Range;

/// No corner: a triangle among quadrilaterals, a line among both.
const NONE: u32 = u32::MAX;

/// A face by its corners in ascending order, and where it is.
type Keyed = ([u32; 4], u32, u8);

/// Faces with one cell only and with no corner but those that `is_in`, of the cells in a range that
/// have this dimension: kind and nodes, in the order of the cells. Cells of third order and above,
/// and polyhedra, give none.
pub(super) fn exterior_faces(
    cells: &Cells,
    range: Range<usize>,
    dimension: u8,
    is_in: impl Fn(u32) -> bool,
) -> Vec<(CellKind, Vec<u32>)> {
    let mut faces: Vec<Keyed> = Vec::new();
    for run in cells.runs_in(range) {
        if run.kind.dimension() != dimension || run.kind.faces().len() > usize::from(u8::MAX) {
            continue;
        }
        let n_corners = run.kind.n_corners(run.n_nodes);
        for (i, nodes) in run.cells().enumerate() {
            for face in 0..n_faces(run.kind, n_corners) {
                let mut key = [NONE; 4];
                let corners = corners(run.kind, n_corners, face);
                if corners.len() > 4 || !corners.iter().all(|&c| is_in(nodes[c])) {
                    continue;
                }
                for (key, &corner) in key.iter_mut().zip(&corners) {
                    *key = nodes[corner];
                }
                key.sort_unstable();
                faces.push((key, (run.first_cell + i) as u32, face as u8));
            }
        }
    }
    faces.sort_unstable();
    let same = |a: &Keyed, b: &Keyed| a.0 == b.0;
    let mut alone: Vec<Keyed> = faces
        .chunk_by(same)
        .filter(|faces| faces.len() == 1)
        .map(|faces| faces[0])
        .collect();
    alone.sort_unstable_by_key(|(_, cell, face)| (*cell, *face));
    let face = |(_, cell, face): Keyed| {
        let cell = cells.get(cell as usize);
        let (kind, places) = whole_face(cell.kind, cell.nodes.len(), face.into())?;
        Some((kind, places.into_iter().map(|i| cell.nodes[i]).collect()))
    };
    alone.into_iter().filter_map(face).collect()
}

fn n_faces(kind: CellKind, n_corners: usize) -> usize {
    match kind.linear() {
        CellKind::Polygon => n_corners.min(255),
        linear => linear.faces().len(),
    }
}

fn corners(kind: CellKind, n_corners: usize, face: usize) -> Vec<usize> {
    match kind.linear() {
        CellKind::Polygon => vec![face, (face + 1) % n_corners],
        linear => linear.faces()[face].iter().map(|&i| i.into()).collect(),
    }
}

/// Kind of a face and where its nodes are among those of its cell; `None` for a face of third order
/// or above.
fn whole_face(kind: CellKind, n_nodes: usize, face: usize) -> Option<(CellKind, Vec<usize>)> {
    use CellKind::*;
    let n_corners = kind.n_corners(n_nodes);
    let mut nodes = corners(kind, n_corners, face);
    let linear = match nodes.len() {
        1 => Vertex,
        2 => Line,
        3 => Triangle,
        4 => Quadrilateral,
        _ => return None,
    };
    if !kind.is_curved() {
        return Some((linear, nodes));
    }
    let centre = match (kind, face) {
        (Hexahedron27, face) => Some(20 + face),
        (Wedge18, 2..) => Some(13 + face),
        (LagrangePyramid, 0) if n_nodes == 14 => Some(13),
        (Triangle6 | Quadrilateral8 | Quadrilateral9 | Tetrahedron10, _) => None,
        (Hexahedron20 | Wedge15 | Wedge18 | Pyramid13, _) => None,
        (LagrangePyramid, _) if n_nodes == 14 => None,
        _ => return None,
    };
    let edge_between = |a: usize, b: usize| {
        let edges = kind.edges().iter().map(|edge| edge.map(usize::from));
        let mut edges = edges.enumerate();
        edges.find_map(|(i, edge)| (edge == [a, b] || edge == [b, a]).then_some(n_corners + i))
    };
    let n_edges = if nodes.len() == 2 { 1 } else { nodes.len() };
    for i in 0..n_edges {
        let middle = edge_between(nodes[i], nodes[(i + 1) % nodes_of(linear)])?;
        nodes.push(middle);
    }
    nodes.extend(centre);
    let curved = match (linear, centre) {
        (Line, _) => Line3,
        (Triangle, _) => Triangle6,
        (_, None) => Quadrilateral8,
        (_, Some(_)) => Quadrilateral9,
    };
    Some((curved, nodes))
}

fn nodes_of(linear: CellKind) -> usize {
    linear.n_nodes().unwrap_or(1)
}

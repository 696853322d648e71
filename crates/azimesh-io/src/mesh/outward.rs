//! Orientation of the faces of a polyhedron: their normals point out of it.

use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, add, cross, dot, scale, sub};

/// Refuses polyhedra that list `n_listed` nodes of their `n_uses` faces, which have `n_nodes` altogether. Some files have a face in
/// more than its two cells; a large face in each of many cells would take any amount of memory.
pub(crate) fn check_listed(n_listed: usize, n_uses: usize, n_nodes: usize) -> Result<()> {
    if n_listed <= n_nodes.saturating_add(n_uses).saturating_mul(8) {
        return Ok(());
    }
    Err(Error::input(format!(
        "its polyhedra list {n_listed} nodes of faces, and all faces together have {n_nodes}; a face belongs to at most two polyhedra"
    )))
}

/// Turns faces so that their normals point out of the cell between them, in a mesh with these points.
pub(crate) fn turn_outward(sides: &mut [Vec<u32>], points: &[Vector]) {
    let at = |node: u32| points[node as usize];
    let corners = sides.iter().flatten().map(|&node| at(node));
    let n = sides.iter().map(Vec::len).sum::<usize>();
    let middle = scale(corners.fold([0.0; 3], add), 1.0 / n as f64);
    if !turn_alike(sides) {
        turn_away(sides, &at, middle);
        return;
    }
    let volume: f64 = sides
        .iter()
        .map(|side| {
            let (area, centre) = area_and_centre(side, &at);
            dot(area, sub(centre, middle))
        })
        .sum();
    if volume < 0.0 {
        sides.iter_mut().for_each(|side| side.reverse());
    }
}

/// Turns faces so that two of them pass their common edge in opposite directions, as the first face does;
/// `false` where an edge is not of two faces, or they cannot all be turned so.
pub(super) fn turn_alike(sides: &mut [Vec<u32>]) -> bool {
    // Edges by their nodes, with the face and the direction in which it passes them.
    let mut edges: Vec<(u32, u32, usize, bool)> = Vec::new();
    for (face, side) in sides.iter().enumerate() {
        for (&a, &b) in side.iter().zip(side.iter().cycle().skip(1)) {
            edges.push((a.min(b), a.max(b), face, a < b));
        }
    }
    edges.sort_unstable();
    let pairs = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    if pairs.clone().any(|same| same.len() != 2) {
        return false;
    }
    if pairs.clone().all(|pair| pair[0].3 != pair[1].3) {
        return true;
    }
    let mut beside: Vec<Vec<(usize, bool)>> = vec![Vec::new(); sides.len()];
    for pair in pairs {
        let (a, b, is_same) = (pair[0].2, pair[1].2, pair[0].3 == pair[1].3);
        beside[a].push((b, is_same));
        beside[b].push((a, is_same));
    }
    let Some(turned) = turned(&beside) else {
        return false;
    };
    for (side, _) in sides.iter_mut().zip(turned).filter(|(_, turned)| *turned) {
        side.reverse();
    }
    true
}

/// Marks the faces to reverse, from the neighbours of each and whether both run along the shared edge in one direction.
pub(crate) fn turned(beside: &[Vec<(usize, bool)>]) -> Option<Vec<bool>> {
    let mut turned: Vec<Option<bool>> = vec![None; beside.len()];
    for start in 0..beside.len() {
        if turned[start].is_some() {
            continue;
        }
        turned[start] = Some(false);
        let mut reached = vec![start];
        while let Some(face) = reached.pop() {
            for &(other, is_same) in &beside[face] {
                let wanted = turned[face].map(|turned| turned != is_same);
                match turned[other] {
                    None => {
                        turned[other] = wanted;
                        reached.push(other);
                    }
                    known if known != wanted => return None,
                    _ => {}
                }
            }
        }
    }
    turned.into_iter().collect()
}

/// Turns each face away from `middle`.
pub(super) fn turn_away(sides: &mut [Vec<u32>], at: &dyn Fn(u32) -> Vector, middle: Vector) {
    for side in sides {
        let (area, centre) = area_and_centre(side, at);
        if dot(area, sub(centre, middle)) < 0.0 {
            side.reverse();
        }
    }
}

/// Twice the area of a face, along its normal, and the mean of its nodes.
fn area_and_centre(side: &[u32], at: &dyn Fn(u32) -> Vector) -> (Vector, Vector) {
    let at: Vec<Vector> = side.iter().map(|&node| at(node)).collect();
    let sum = at.iter().fold([0.0; 3], |sum, &x| add(sum, x));
    let centre = scale(sum, 1.0 / at.len().max(1) as f64);
    let edges = at.iter().zip(at.iter().cycle().skip(1));
    let area = edges.fold([0.0; 3], |sum, (&a, &b)| {
        add(sum, cross(sub(a, centre), sub(b, centre)))
    });
    (area, centre)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_face_of_many_polyhedra_is_refused() {
        check_listed(2_000, 500, 1_000).expect("each face is in two");
        let error = check_listed(1_000_000, 1_000, 1_000).expect_err("each is in a thousand");
        assert!(error.message.contains("at most two polyhedra"));
    }
}

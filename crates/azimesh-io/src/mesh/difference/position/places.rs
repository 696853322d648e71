//! Nodes at the very same place.

use super::Pairing;
use super::keys::{Keys, join, mixed};
use crate::mesh::difference::partners::NONE;
use azimesh_core::parallel::{collect, sort};

/// The result for the nodes of one place, or of a few whose keys are alike.
#[derive(Default)]
struct Found {
    pairs: Vec<(u32, u32)>,
    /// Nodes of each mesh at one place, where one has several.
    shared: Vec<[Vec<u32>; 2]>,
}

/// Pairs nodes that are alone at their place in both meshes, and lists places with several.
pub fn pair(a: &[[f64; 3]], b: &[[f64; 3]]) -> Pairing {
    let (ours, theirs) = (sorted(a), sorted(b));
    let at = |points: &[[f64; 3]], node: u32| bits(points[node as usize]);
    let found = join(&ours, &theirs, |found: &mut Found, x, y| match (x, y) {
        ([], _) | (_, []) => {}
        ([(_, i)], [(_, j)]) if at(a, *i) == at(b, *j) => found.pairs.push((*i, *j)),
        (x, y) => by_place(found, x, y, |i| at(a, i), |j| at(b, j)),
    });
    let mut pairing = Pairing {
        partners: [vec![NONE; a.len()], vec![NONE; b.len()]],
        shared: [Vec::new(), Vec::new()],
        candidates: Vec::new(),
    };
    drop((ours, theirs));
    let mut place = 0;
    for found in found {
        for (i, j) in found.pairs {
            pairing.pair(i, j);
        }
        for nodes in found.shared {
            for (shared, nodes) in pairing.shared.iter_mut().zip(nodes) {
                shared.extend(nodes.into_iter().map(|node| (place, node)));
            }
            place += 1;
        }
    }
    pairing
}

/// The bits of the coordinates; -0 counts as 0.
fn bits(point: [f64; 3]) -> [u64; 3] {
    point.map(|x| (x + 0.0).to_bits())
}

fn sorted(points: &[[f64; 3]]) -> Keys {
    let mut keys: Keys = collect(points.len(), |node| {
        let key = bits(points[node])
            .into_iter()
            .fold(0, |key, x| mixed(key ^ x));
        (key, node as u32)
    });
    sort(&mut keys);
    keys
}

/// Nodes whose keys are alike, by their places.
fn by_place(
    found: &mut Found,
    x: &[(u64, u32)],
    y: &[(u64, u32)],
    first: impl Fn(u32) -> [u64; 3],
    second: impl Fn(u32) -> [u64; 3],
) {
    let mut nodes: Vec<([u64; 3], bool, u32)> =
        x.iter().map(|(_, i)| (first(*i), false, *i)).collect();
    nodes.extend(y.iter().map(|(_, j)| (second(*j), true, *j)));
    nodes.sort_unstable();
    for place in nodes.chunk_by(|p, q| p.0 == q.0) {
        let (ours, theirs) = place.split_at(place.partition_point(|node| !node.1));
        match (ours, theirs) {
            ([], _) | (_, []) => {}
            ([(.., i)], [(.., j)]) => found.pairs.push((*i, *j)),
            _ => found
                .shared
                .push([ours, theirs].map(|nodes| nodes.iter().map(|(.., node)| *node).collect())),
        }
    }
}

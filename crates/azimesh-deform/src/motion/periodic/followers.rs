//! The leader of each paired node, through chains of pairs.

use super::images::{Distinct, distinct};
use super::{Periodic, Symmetry};
use azimesh_core::error::Result;
use azimesh_core::geometry::{Bounds, Transform};
use std::collections::{BTreeMap, VecDeque};

/// A node with the turned displacement of another node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Follower {
    /// The node.
    pub node: u32,
    /// The lowest node that pairs connect it to.
    pub leader: u32,
    /// Maps the leader to the node. Its rotation applied to the leader's displacement gives the node's displacement.
    /// Exactly the identity's rotation for a translation.
    pub map: Transform,
}

/// Returns every paired node except the lowest of its connected nodes, ascending, with its leader. A node on the
/// edge between two periodic sides is connected through both. `bounds` is the box of the mesh.
///
/// # Errors
/// Pairs whose maps do not commute.
pub fn followers(pairs: &[Periodic], bounds: &Bounds) -> Result<Vec<Follower>> {
    let Distinct {
        symmetries,
        of_pairs,
    } = distinct(pairs, bounds)?;
    let mut steps: Vec<(u32, u32, usize, i32)> = Vec::new();
    for (pair, (symmetry, sense)) in pairs.iter().zip(of_pairs) {
        for &(a, b) in pair.pairs.iter().filter(|(a, b)| a != b) {
            steps.push((a, b, symmetry, sense));
            steps.push((b, a, symmetry, -sense));
        }
    }
    steps.sort_unstable();
    let mut powers: BTreeMap<u32, (u32, Vec<i32>)> = BTreeMap::new();
    for &(leader, ..) in &steps {
        if powers.contains_key(&leader) {
            continue;
        }
        powers.insert(leader, (leader, vec![0; symmetries.len()]));
        let mut queue = VecDeque::from([leader]);
        while let Some(node) = queue.pop_front() {
            let first = steps.partition_point(|step| step.0 < node);
            let of_node = steps[first..].iter().take_while(|step| step.0 == node);
            for &(_, next, symmetry, sense) in of_node {
                if !powers.contains_key(&next) {
                    let mut power = powers[&node].1.clone();
                    power[symmetry] += sense;
                    powers.insert(next, (leader, power));
                    queue.push_back(next);
                }
            }
        }
    }
    let followers = powers
        .into_iter()
        .filter(|(node, (leader, _))| node != leader);
    Ok(followers
        .map(|(node, (leader, powers))| Follower {
            node,
            leader,
            map: product(&symmetries, &powers),
        })
        .collect())
}

fn product(symmetries: &[Symmetry], powers: &[i32]) -> Transform {
    let applied = symmetries
        .iter()
        .zip(powers)
        .filter(|(_, power)| **power != 0);
    let maps: Vec<Transform> = applied.map(|(s, power)| s.power(*power)).collect();
    match &maps[..] {
        [one] => *one,
        maps => maps
            .iter()
            .fold(Transform::IDENTITY, |all, map| all.then(map)),
    }
}

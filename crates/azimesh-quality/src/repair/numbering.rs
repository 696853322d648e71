//! The order of a patch's unknowns, and which of them meet in a cell.

use super::elements::Elements;

/// No unknown.
pub(super) const NONE: u32 = u32::MAX;

/// The (row, column) of the blocks below the diagonal.
pub(super) fn pairs(elements: &Elements, unknown: &[u32]) -> Vec<(u32, u32)> {
    let mut pairs = Vec::new();
    for cell in 0..elements.len() {
        let nodes = elements.nodes(cell);
        for (a, &node) in nodes.iter().enumerate() {
            let i = unknown[node as usize];
            for &other in &nodes[a + 1..] {
                let j = unknown[other as usize];
                if i != NONE && j != NONE && i != j {
                    pairs.push((i.max(j), i.min(j)));
                }
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// The order of Cuthill and McKee: the new number of each unknown, with few between neighbours.
pub(super) fn order(n: usize, pairs: &[(u32, u32)]) -> Vec<u32> {
    let mut starts = vec![0usize; n + 1];
    for &(i, j) in pairs {
        starts[i as usize + 1] += 1;
        starts[j as usize + 1] += 1;
    }
    for i in 0..n {
        starts[i + 1] += starts[i];
    }
    let (mut next, mut neighbours) = (starts.clone(), vec![0u32; 2 * pairs.len()]);
    for &(i, j) in pairs {
        for (a, b) in [(i, j), (j, i)] {
            neighbours[next[a as usize]] = b;
            next[a as usize] += 1;
        }
    }
    let degree = |i: u32| starts[i as usize + 1] - starts[i as usize];
    let mut number = vec![NONE; n];
    let mut queue = Vec::with_capacity(n);
    let mut by_degree: Vec<u32> = (0..n as u32).collect();
    by_degree.sort_by_key(|&i| (degree(i), i));
    let mut found = Vec::new();
    for first in by_degree {
        if number[first as usize] != NONE {
            continue;
        }
        let mut at = queue.len();
        number[first as usize] = at as u32;
        queue.push(first);
        while at < queue.len() {
            let own = queue[at] as usize;
            found.clear();
            let around = neighbours[starts[own]..starts[own + 1]].iter();
            found.extend(around.copied().filter(|&i| number[i as usize] == NONE));
            found.sort_by_key(|&i| (degree(i), i));
            for &i in &found {
                number[i as usize] = queue.len() as u32;
                queue.push(i);
            }
            at += 1;
        }
    }
    number
}

//! Items with 64-bit keys: sorted by key, and matched between two meshes.

pub use crate::mesh::near::{Keys, mixed};
use azimesh_core::parallel::map;

/// Keys of one mesh that are looked at in one go.
const CHUNK: usize = 1 << 15;

/// Calls `meet` with the entries of both that have one key, for each key, on all threads; gives what
/// comes of each chunk, in order. Both are sorted.
pub fn join<T: Send + Default>(
    a: &[(u64, u32)],
    b: &[(u64, u32)],
    meet: impl Fn(&mut T, &[(u64, u32)], &[(u64, u32)]) + Sync,
) -> Vec<T> {
    let starts: Vec<u64> = a
        .iter()
        .step_by(CHUNK)
        .skip(1)
        .map(|(key, _)| *key)
        .collect();
    let cut = |keys: &[(u64, u32)], i: usize| {
        let start = i.checked_sub(1).and_then(|i| starts.get(i));
        start.map_or(if i == 0 { 0 } else { keys.len() }, |start| {
            keys.partition_point(|(key, _)| key < start)
        })
    };
    map(starts.len() + 1, &|i| {
        let mut found = T::default();
        let [a, b] = [a, b].map(|keys| &keys[cut(keys, i)..cut(keys, i + 1)]);
        merge(a, b, |x, y| meet(&mut found, x, y));
        found
    })
}

fn merge(a: &[(u64, u32)], b: &[(u64, u32)], mut meet: impl FnMut(&[(u64, u32)], &[(u64, u32)])) {
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        let key = match (a.get(i), b.get(j)) {
            (Some(x), Some(y)) => x.0.min(y.0),
            (x, y) => x.or(y).expect("one is left").0,
        };
        let (i_end, j_end) = (end(a, i, key), end(b, j, key));
        meet(&a[i..i_end], &b[j..j_end]);
        (i, j) = (i_end, j_end);
    }
}

/// Index of the first entry from `start` on whose key is not `key`.
fn end(keys: &[(u64, u32)], start: usize, key: u64) -> usize {
    let same = keys[start..].iter().take_while(|(other, _)| *other == key);
    start + same.count()
}

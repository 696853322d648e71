//! Face streams of polyhedra, `n_faces, (n_nodes, node...)...`: their faces and their nodes.

use azimesh_core::error::{Error, Result};
use std::borrow::Cow;

/// A list of so many nodes is searched from its start; a longer one is sorted first.
const MOST_SEARCHED: usize = 64;

/// The faces of one polyhedron's stream; an error where the counts do not fit its length.
pub fn face_stream(stream: &[u32]) -> impl Iterator<Item = Result<&[u32]>> {
    let n_faces = stream.first().copied().unwrap_or(0);
    let mut rest = stream.get(1..).unwrap_or(&[]);
    let mut left = n_faces;
    std::iter::from_fn(move || {
        if left == 0 {
            if rest.is_empty() {
                return None;
            }
            let extra = std::mem::take(&mut rest).len();
            return Some(Err(Error::input(format!(
                "a polyhedron's face stream has {extra} entries after its last face"
            ))));
        }
        left -= 1;
        let n = rest.first().copied().unwrap_or(0) as usize;
        if n == 0 || rest.len() <= n {
            left = 0;
            rest = &[];
            return Some(Err(Error::input(
                "a polyhedron's face stream ends inside a face",
            )));
        }
        let (face, tail) = rest[1..].split_at(n);
        rest = tail;
        Some(Ok(face))
    })
}

/// The nodes of a stream, each once, in order of first appearance.
pub(super) fn distinct_nodes(stream: &[u32]) -> Result<Vec<u32>> {
    let mut nodes: Vec<u32> = Vec::new();
    for face in face_stream(stream) {
        let face = face?;
        if nodes.len() > MOST_SEARCHED {
            nodes.extend_from_slice(face);
            continue;
        }
        for node in face {
            if !nodes.contains(node) {
                nodes.push(*node);
            }
        }
    }
    if nodes.len() > MOST_SEARCHED {
        let mut places: Vec<(u32, usize)> = nodes.iter().copied().zip(0..).collect();
        places.sort_unstable();
        places.dedup_by_key(|(node, _)| *node);
        places.sort_unstable_by_key(|(_, place)| *place);
        nodes = places.into_iter().map(|(node, _)| node).collect();
    }
    Ok(nodes)
}

/// Nodes among which others are looked up.
pub(super) struct Listed<'a>(Cow<'a, [u32]>);

impl<'a> Listed<'a> {
    pub fn new(nodes: &'a [u32]) -> Self {
        if nodes.len() <= MOST_SEARCHED {
            return Self(Cow::Borrowed(nodes));
        }
        let mut sorted = nodes.to_vec();
        sorted.sort_unstable();
        Self(Cow::Owned(sorted))
    }

    pub fn has(&self, node: u32) -> bool {
        match &self.0 {
            Cow::Borrowed(nodes) => nodes.contains(&node),
            Cow::Owned(sorted) => sorted.binary_search(&node).is_ok(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_of_a_large_polyhedron_are_those_of_a_search_through_all() {
        // A strip of triangles whose nodes come in no order.
        let node = |i: u32| (i * 37) % 211;
        let mut stream = vec![200];
        for i in 0..200 {
            stream.extend([3, node(i), node(i + 1), node(i + 2)]);
        }
        let mut expected: Vec<u32> = Vec::new();
        for face in face_stream(&stream) {
            for node in face.expect("a good stream") {
                if !expected.contains(node) {
                    expected.push(*node);
                }
            }
        }
        assert_eq!(expected.len(), 202);
        let nodes = distinct_nodes(&stream).expect("a good stream");
        assert_eq!(nodes, expected);
        let listed = Listed::new(&nodes);
        assert!((0..211).all(|node| listed.has(node) == expected.contains(&node)));
    }
}

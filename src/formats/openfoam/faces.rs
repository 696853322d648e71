//! Faces as lists of nodes: a `faceList` or a `faceCompactList`, binary or as text.

use super::ascii;
use super::file::FoamFile;
use super::lists::{Layout, Open, cut_off, ends, head, labels_at, needed, number, wrong_label};
use super::text::Text;
use crate::error::Result;

/// Faces as lists of nodes, one after another.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Faces {
    /// Where each face starts in `nodes`, and the end of the last; empty where all faces have one size.
    starts: Vec<u32>,
    /// The size of all faces; 0 where `starts` tells it.
    size: usize,
    /// Nodes of all faces.
    pub nodes: Vec<u32>,
}

impl Faces {
    /// Of nodes one after another, with the places where faces start and where the last ends.
    pub fn new(starts: Vec<u32>, nodes: Vec<u32>) -> Self {
        let size = match &starts[..] {
            [first, second, ..] => second.saturating_sub(*first),
            _ => 0,
        };
        let differs = |two: &[u32]| two[1].wrapping_sub(two[0]) != size;
        let is_regular = size > 0 && starts[0] == 0 && !starts.windows(2).any(differs);
        Self {
            starts: if is_regular { Vec::new() } else { starts },
            size: if is_regular { size as usize } else { 0 },
            nodes,
        }
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        match self.size {
            0 => self.starts.len().saturating_sub(1),
            size => self.nodes.len() / size,
        }
    }

    /// Nodes of a face.
    #[inline]
    pub fn get(&self, face: usize) -> &[u32] {
        &self.nodes[self.start(face)..self.start(face + 1)]
    }

    /// Where the nodes of a face start.
    #[inline]
    fn start(&self, face: usize) -> usize {
        match self.size {
            0 => self.starts[face] as usize,
            size => face * size,
        }
    }

    /// The face that the node at this place is of.
    pub fn face_at(&self, place: usize) -> usize {
        match self.size {
            0 => {
                let after = self
                    .starts
                    .partition_point(|start| *start as usize <= place);
                after.saturating_sub(1)
            }
            size => place / size,
        }
    }

    /// All of them in order.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|face| self.get(face))
    }

    /// Appends a face.
    pub fn push(&mut self, nodes: impl IntoIterator<Item = u32>) {
        if self.starts.is_empty() {
            let ends = 0..=self.len();
            let starts = ends.map(|face| (face * self.size) as u32);
            self.starts = starts.collect();
            self.size = 0;
        }
        self.nodes.extend(nodes);
        self.starts.push(self.nodes.len() as u32);
    }
}

/// The faces in a file: a `faceList`, or a `faceCompactList` (where each starts, then the nodes of all).
pub(super) fn faces(file: &FoamFile) -> Result<Faces> {
    let mut text = file.text();
    let layout = Layout::of(file);
    let faces = match file.header.class.as_str() {
        "faceCompactList" => compact_faces(&mut text, layout),
        _ if text.is_binary => binary_faces(&mut text, layout),
        _ => ascii_faces(&mut text),
    };
    file.checked(faces)
}

fn ascii_faces(text: &mut Text) -> Result<Faces> {
    let (n, open) = head(text)?;
    match open {
        Open::Nothing => Ok(Faces::default()),
        Open::Uniform => Err(text.error("all faces are the same; there must be a list of them")),
        Open::Values => ascii::faces(text, n),
    }
}

fn compact_faces(text: &mut Text, layout: Layout) -> Result<Faces> {
    let place = text.at;
    // The second list settles the width of both.
    let mut whole = None;
    for width in layout.labels {
        let mut after = text.clone();
        let layout = Layout {
            labels: [width; 2],
            ..layout
        };
        let parsed = compact_lists(&mut after, layout);
        if parsed.is_ok() || whole.is_none() {
            let is_good = parsed.is_ok();
            whole = Some(parsed);
            if is_good {
                break;
            }
        }
        if !text.is_binary {
            break;
        }
    }
    let (starts, nodes) = whole.expect("there are two widths")?;
    let is_ascending = starts.windows(2).all(|two| two[0] <= two[1]);
    let ends = (starts.first().copied(), starts.last().copied());
    let fits = match ends {
        (Some(0), Some(last)) => last as usize == nodes.len(),
        (None, _) => nodes.is_empty(),
        _ => false,
    };
    if !is_ascending || !fits {
        return Err(text.error_at(
            place,
            format!(
                "the faces start at {} places, which do not ascend from 0 to {}, the number of nodes in the list",
                starts.len(),
                nodes.len()
            ),
        ));
    }
    Ok(Faces::new(starts, nodes))
}

fn compact_lists(text: &mut Text, layout: Layout) -> Result<(Vec<u32>, Vec<u32>)> {
    let index = |label: i64| u32::try_from(label).ok();
    let starts = labels_at(text, layout, 0, &index)?;
    if starts.is_empty() && text.peek().is_none() {
        return Ok((starts, Vec::new()));
    }
    let nodes = labels_at(text, layout, 0, &index)?;
    Ok((starts, nodes))
}

/// A binary `faceList`: each face is its number of nodes and a binary list.
fn binary_faces(text: &mut Text, layout: Layout) -> Result<Faces> {
    let (n, open) = head(text)?;
    match open {
        Open::Nothing => return Ok(Faces::default()),
        Open::Uniform => {
            return Err(text.error("all faces are the same; there must be a list of them"));
        }
        Open::Values => {}
    }
    let n = needed(text, n)?;
    let mut first_error = None;
    for width in layout.labels {
        let mut after = text.clone();
        let layout = Layout {
            labels: [width; 2],
            ..layout
        };
        match binary_faces_of(&mut after, n, layout) {
            Ok(faces) => return Ok(faces),
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    Err(first_error.expect("there are two widths"))
}

fn binary_faces_of(text: &mut Text, n: usize, layout: Layout) -> Result<Faces> {
    let index = |label: i64| u32::try_from(label).ok();
    let mut faces = Faces::default();
    let mut nodes = Vec::new();
    for _ in 0..n {
        let (count, open) = head(text)?;
        let count = needed(text, count)?;
        nodes.clear();
        if open == Open::Values {
            let width = layout.labels[0];
            if !ends(text, count, width) {
                return Err(cut_off(text, count, "label", layout.labels));
            }
            let values = text.at..text.at + count * width;
            text.at = values.end + 1;
            let one = |i: usize| {
                let at = values.start + i * width;
                let bytes = &text.bytes[at..at + width];
                let value = number(bytes, layout.is_big_endian);
                index(value).ok_or_else(|| wrong_label(text, values.start, i, value))
            };
            for i in 0..count {
                nodes.push(one(i)?);
            }
        }
        if faces.nodes.len() + nodes.len() > u32::MAX as usize {
            return Err(text.error(too_many_nodes()));
        }
        faces.push(nodes.iter().copied());
    }
    text.expect(b')', "after the last face")?;
    Ok(faces)
}

/// Refuses more nodes of faces than 32 bits tell apart.
pub(super) fn too_many_nodes() -> String {
    "the faces have more than 4294967295 nodes together, the most that are read".to_owned()
}

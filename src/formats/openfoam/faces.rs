//! Faces as lists of nodes: a `faceList` or a `faceCompactList`, binary or as text.

use super::ascii;
use super::file::FoamFile;
use super::labels::{Label, Labels};
use super::lists::{Layout, Open, cut_off, ends, head, indices_at, needed, number, wrong_label};
use super::text::Text;
use crate::error::Result;
use crate::parallel::{any, map_blocks};
use std::ops::Range;

/// Faces that one task looks through.
const BLOCK: usize = 1 << 16;

/// Faces as lists of nodes, one after another.
#[derive(Clone, Default)]
pub(super) struct Faces {
    /// Where each face starts in `nodes`, and the end of the last; empty where all faces have one size.
    starts: Labels,
    /// The size of all faces; 0 where `starts` tells it.
    size: usize,
    /// Nodes of all faces.
    pub nodes: Labels,
}

/// The lists of [`Faces`], for loops.
#[derive(Clone, Copy)]
pub(super) struct FacesView<'a> {
    starts: &'a [Label],
    /// The size of all faces; 0 where they may have several.
    pub size: usize,
    /// Nodes of all faces.
    pub nodes: &'a [Label],
}

impl Faces {
    /// Of nodes one after another, with the places where faces start and where the last ends.
    pub fn new(starts: impl Into<Labels>, nodes: impl Into<Labels>) -> Self {
        let starts = starts.into();
        Self::of_size(regular_size(starts.view()), starts, nodes.into())
    }

    fn of_size(size: Option<usize>, starts: Labels, nodes: Labels) -> Self {
        if size.is_some() {
            starts.release();
        }
        Self {
            starts: if size.is_some() {
                Labels::default()
            } else {
                starts
            },
            size: size.unwrap_or(0),
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

    /// The lists. Loops ask for them once.
    pub fn view(&self) -> FacesView<'_> {
        FacesView {
            starts: self.starts.view(),
            size: self.size,
            nodes: self.nodes.view(),
        }
    }

    /// Appends a face.
    pub fn push(&mut self, nodes: impl IntoIterator<Item = u32>) {
        if self.starts.is_empty() {
            let ends = 0..=self.len();
            let starts = ends.map(|face| (face * self.size) as u32);
            self.starts = starts.collect::<Vec<_>>().into();
            self.size = 0;
        }
        let own = self.nodes.decoded();
        own.extend(nodes);
        let end = own.len() as u32;
        self.starts.decoded().push(end);
    }
}

impl<'a> FacesView<'a> {
    /// Number of faces.
    pub fn len(&self) -> usize {
        match self.size {
            0 => self.starts.len().saturating_sub(1),
            size => self.nodes.len() / size,
        }
    }

    /// Nodes of a face.
    #[inline]
    pub fn get(&self, face: usize) -> &'a [Label] {
        &self.nodes[self.start(face)..self.start(face + 1)]
    }

    /// Where the nodes of a face start.
    #[inline]
    fn start(&self, face: usize) -> usize {
        match self.size {
            0 => self.starts[face].get() as usize,
            size => face * size,
        }
    }

    /// The first face of fewer nodes than this.
    pub fn first_below(&self, n: usize) -> Option<usize> {
        match self.size {
            0 => (0..self.len()).find(|face| self.get(*face).len() < n),
            size => (size < n && self.len() > 0).then_some(0),
        }
    }

    /// The face that the node at this place is of.
    pub fn face_at(&self, place: usize) -> usize {
        match self.size {
            0 => {
                let is_before = |start: &Label| start.get() as usize <= place;
                self.starts.partition_point(is_before).saturating_sub(1)
            }
            size => place / size,
        }
    }
}

/// The size of all faces that start at these places; `None` where they have several.
fn regular_size(starts: &[Label]) -> Option<usize> {
    let &[first, second, ..] = starts else {
        return None;
    };
    let size = second.get().checked_sub(first.get())?;
    let is_sound = first.get() == 0
        && size > 0
        && (starts.len() - 1) as u64 * u64::from(size) <= u64::from(u32::MAX);
    let differs = |range: Range<usize>| {
        let mut expected = range.start as u32 * size;
        let mut differs = false;
        for start in &starts[range] {
            differs |= start.get() != expected;
            expected = expected.wrapping_add(size);
        }
        differs
    };
    let is_regular = is_sound && !map_blocks(starts.len(), BLOCK, &differs).contains(&true);
    is_regular.then_some(size as usize)
}

/// The faces in a file: a `faceList`, or a `faceCompactList` (where each starts, then the nodes of all).
pub(super) fn faces(file: &FoamFile) -> Result<Faces> {
    let mut text = file.text();
    let layout = Layout::of(file);
    let faces = match file.header.class.as_str() {
        "faceCompactList" => compact_faces(&mut text, file, layout),
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

fn compact_faces(text: &mut Text, file: &FoamFile, layout: Layout) -> Result<Faces> {
    let place = text.at;
    // The second list settles the width of both.
    let mut whole = None;
    for width in layout.labels {
        let mut after = text.clone();
        let layout = Layout {
            labels: [width; 2],
            ..layout
        };
        let parsed = compact_lists(&mut after, file, layout);
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
    let list = starts.view();
    let value = |label: Option<&Label>| label.map(|label| label.get());
    let fits = match (value(list.first()), value(list.last())) {
        (Some(0), Some(last)) => last as usize == nodes.len(),
        (None, _) => nodes.is_empty(),
        _ => false,
    };
    let size = regular_size(list);
    let falls = |i: usize| list[i].get() > list[i + 1].get();
    let is_ascending = size.is_some() || !any(list.len().saturating_sub(1), falls);
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
    Ok(Faces::of_size(size, starts, nodes))
}

fn compact_lists(text: &mut Text, file: &FoamFile, layout: Layout) -> Result<(Labels, Labels)> {
    let index = |label: i64| u32::try_from(label).ok();
    let starts = indices_at(text, file, layout, 0, &index)?;
    if starts.is_empty() && text.peek().is_none() {
        return Ok((starts, Labels::default()));
    }
    let nodes = indices_at(text, file, layout, 0, &index)?;
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

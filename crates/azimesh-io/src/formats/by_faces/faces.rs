//! Faces as lists of nodes, one after another. The labels of a list are in the file, as far as it has them as the machine
//! does, or decoded.

use crate::formats::Source;
use azimesh_core::parallel::map_blocks;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// Labels or faces that one task looks through.
const BLOCK: usize = 1 << 16;

/// A label at any byte of a file, in the machine's own order of bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub(in crate::formats) struct Label([u8; 4]);

impl Label {
    /// Its value.
    #[inline]
    pub fn get(self) -> u32 {
        u32::from_ne_bytes(self.0)
    }
}

/// The labels of a list, from 0 on.
#[derive(Clone, Default)]
pub(in crate::formats) struct Labels {
    decoded: Vec<u32>,
    /// A file and the bytes in it that the labels are read from, instead.
    stored: Option<(Source, Range<usize>)>,
}

impl From<Vec<u32>> for Labels {
    fn from(decoded: Vec<u32>) -> Self {
        Self {
            decoded,
            stored: None,
        }
    }
}

impl Labels {
    /// These bytes of a file: labels of 32 bits in the machine's own order of bytes.
    pub fn stored(content: Source, bytes: Range<usize>) -> Self {
        Self {
            decoded: Vec::new(),
            stored: Some((content, bytes)),
        }
    }

    /// The labels. Loops ask for them once.
    pub fn view(&self) -> &[Label] {
        match &self.stored {
            Some((content, bytes)) => bytemuck::cast_slice(&content.bytes()[bytes.clone()]),
            None => bytemuck::cast_slice(&self.decoded),
        }
    }

    /// Number of labels.
    pub fn len(&self) -> usize {
        self.view().len()
    }

    /// Checks if there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The largest label.
    pub fn largest(&self) -> Option<u32> {
        let labels = self.view();
        // Numbers rather than options: so the loop over a block takes many labels at a time.
        let of_block = |range: Range<usize>| {
            let values = labels[range].iter().map(|label| label.get());
            values.fold(0, u32::max)
        };
        map_blocks(labels.len(), BLOCK, &of_block).into_iter().max()
    }

    /// Checks if they are read from the file when they are needed.
    pub fn is_stored(&self) -> bool {
        self.stored.is_some()
    }

    /// Frees the memory that holds their part of a mapped file, which is read again where it is needed again.
    pub fn release(&self) {
        if let Some((content, bytes)) = &self.stored {
            content.release_part(bytes.clone());
        }
    }

    /// Takes away the last ones that are `label`.
    pub fn trim_end(&mut self, label: u32) {
        if self.view().last().is_some_and(|last| last.get() == label) {
            let labels = self.decoded();
            let n = labels.iter().rposition(|own| *own != label);
            labels.truncate(n.map_or(0, |last| last + 1));
        }
    }

    /// The labels as a list that can grow.
    pub fn decoded(&mut self) -> &mut Vec<u32> {
        if self.is_stored() {
            self.decoded = self.view().iter().map(|label| label.get()).collect();
            self.stored = None;
        }
        &mut self.decoded
    }
}

/// Faces as lists of nodes, one after another.
#[derive(Clone, Default)]
pub(in crate::formats) struct Faces {
    /// Start of each face in `nodes`, and the end of the last; empty if all faces have one size.
    starts: Labels,
    /// The size of all faces; 0 if `starts` gives it.
    size: usize,
    /// Nodes of all faces.
    pub nodes: Labels,
}

/// The lists of [`Faces`], for loops.
#[derive(Clone, Copy)]
pub(in crate::formats) struct FacesView<'a> {
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

    pub fn of_size(size: Option<usize>, starts: Labels, nodes: Labels) -> Self {
        let mut faces = Self {
            starts: Labels::default(),
            size: size.unwrap_or(0),
            nodes,
        };
        match size {
            Some(_) => starts.release(),
            None => faces.starts = starts,
        }
        faces
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.view().len()
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

    /// Place of the first node of a face.
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
pub(in crate::formats) fn regular_size(starts: &[Label]) -> Option<usize> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn labels_in_a_file_are_those_that_are_decoded_at_any_byte() {
        let values = [7, 0, 41, 3, 3];
        for before in 0..5 {
            let mut bytes = vec![b'('; before];
            bytes.extend(values.iter().flat_map(|value: &u32| value.to_ne_bytes()));
            let end = bytes.len();
            bytes.push(b')');
            let content = Source::from_bytes(Path::new("owner"), bytes);
            let mut stored = Labels::stored(content, before..end);
            let decoded = Labels::from(values.to_vec());
            assert_eq!(stored.view(), decoded.view());
            assert_eq!((stored.len(), stored.largest()), (5, Some(41)));
            stored.release();
            stored.trim_end(7);
            assert!(stored.is_stored());
            stored.trim_end(3);
            assert!(!stored.is_stored());
            assert_eq!(stored.decoded(), &[7, 0, 41]);
        }
        assert_eq!(Labels::default().largest(), None);
        let mut same = Labels::from(vec![3, 3]);
        same.trim_end(3);
        assert!(same.is_empty());
    }
}

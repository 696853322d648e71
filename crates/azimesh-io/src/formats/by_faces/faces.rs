//! Faces as lists of nodes, one after another.

use super::labels::{Label, Labels};
use azimesh_core::parallel::map_blocks;
use std::ops::Range;

/// Faces that one task looks through.
const BLOCK: usize = 1 << 16;

/// Faces as lists of nodes, one after another.
#[derive(Clone, Default)]
pub(in crate::formats) struct Faces {
    /// Where each face starts in `nodes`, and the end of the last; empty where all faces have one size.
    starts: Labels,
    /// The size of all faces; 0 where `starts` tells it.
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

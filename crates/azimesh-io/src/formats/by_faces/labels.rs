//! The labels of a list where they lie: in the file, as far as it has them as the machine does, or decoded.

use crate::formats::Source;
use azimesh_core::parallel::map_blocks;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// Labels that one task looks through.
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
#[derive(Clone)]
pub(in crate::formats) struct Labels(Held);

#[derive(Clone)]
enum Held {
    Decoded(Vec<u32>),
    Stored {
        content: Source,
        bytes: Range<usize>,
    },
}

impl Default for Labels {
    fn default() -> Self {
        Self(Held::Decoded(Vec::new()))
    }
}

impl From<Vec<u32>> for Labels {
    fn from(labels: Vec<u32>) -> Self {
        Self(Held::Decoded(labels))
    }
}

impl Labels {
    /// These bytes of a file: labels of 32 bits in the machine's own order of bytes.
    pub fn stored(content: Source, bytes: Range<usize>) -> Self {
        Self(Held::Stored { content, bytes })
    }

    /// The labels. Loops ask for them once.
    pub fn view(&self) -> &[Label] {
        match &self.0 {
            Held::Decoded(labels) => bytemuck::cast_slice(labels),
            Held::Stored { content, bytes } => {
                bytemuck::cast_slice(&content.bytes()[bytes.clone()])
            }
        }
    }

    /// Number of labels.
    pub fn len(&self) -> usize {
        match &self.0 {
            Held::Decoded(labels) => labels.len(),
            Held::Stored { bytes, .. } => bytes.len() / size_of::<Label>(),
        }
    }

    /// Whether there is none.
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

    /// Whether they are read from the file wherever they are needed.
    pub fn is_stored(&self) -> bool {
        matches!(self.0, Held::Stored { .. })
    }

    /// Lets go of the memory that holds their part of a mapped file, which is read again where it is needed again.
    pub fn release(&self) {
        if let Held::Stored { content, bytes } = &self.0 {
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
            let labels = self.view().iter().map(|label| label.get());
            self.0 = Held::Decoded(labels.collect());
        }
        match &mut self.0 {
            Held::Decoded(labels) => labels,
            Held::Stored { .. } => unreachable!("they were just decoded"),
        }
    }
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

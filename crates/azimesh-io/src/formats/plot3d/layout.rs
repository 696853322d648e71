//! The variants of Plot3D, which a file does not state, and the search for those that fit.

use super::Plot3d;
use azimesh_core::error::{Error, Result, option};
use std::fmt;

/// Most blocks that a file may have.
const MOST_BLOCKS: usize = 1 << 20;

/// Encoding of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    /// `None` for text.
    pub binary: Option<Binary>,
    /// True if the number of blocks is at the start.
    pub is_multi: bool,
    pub n_axes: usize,
    pub has_blanking: bool,
}

/// Encoding of numbers as bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Binary {
    pub is_big_endian: bool,
    /// Between record marks, as Fortran writes.
    pub has_records: bool,
    /// Bytes of a coordinate.
    pub real: usize,
}

/// A way in which a file can be read: its layout, the nodes of its blocks along the indices, where the first
/// block starts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fit {
    pub layout: Layout,
    pub blocks: Vec<[usize; 3]>,
    pub start: usize,
}

impl Layout {
    /// Bytes of a coordinate in a binary file.
    pub fn real(&self) -> Option<usize> {
        self.binary.map(|binary| binary.real)
    }
}

/// The blocks of a file in messages.
pub(super) fn blocks_of(is_multi: bool) -> &'static str {
    if is_multi {
        "multi-block"
    } else {
        "single block"
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let blocks = blocks_of(self.is_multi);
        let blanking = if self.has_blanking { "with" } else { "without" };
        write!(f, "{blocks}, {}D, {blanking} iblank", self.n_axes)?;
        let Some(binary) = self.binary else {
            return write!(f, ", text");
        };
        let order = ["little", "big"][usize::from(binary.is_big_endian)];
        let records = ["C binary", "Fortran records"][usize::from(binary.has_records)];
        write!(f, ", {records}, {order}-endian, {} bits", 8 * binary.real)
    }
}

/// Nodes of blocks with these numbers along the indices; `None` where one is not at least 1, none has 2, or
/// they are more than `most`.
pub(super) fn n_nodes(blocks: &[[usize; 3]], most: usize) -> Option<usize> {
    let mut total = 0usize;
    for block in blocks {
        let n = block
            .iter()
            .try_fold(1usize, |n, along| n.checked_mul(*along))?;
        if n < 2 {
            return None;
        }
        total = total.checked_add(n).filter(|total| *total <= most)?;
    }
    (total > 0).then_some(total)
}

/// With and without the number of blocks, and the coordinates of a node.
pub(super) const HEADERS: [(bool, usize); 4] = [(true, 3), (true, 2), (false, 3), (false, 2)];

/// The blocks that the counts at the start announce, and where the first one starts. `counts` gives so many counts from a
/// place on, and what follows them.
pub(super) fn header(
    (is_multi, n_axes): (bool, usize),
    counts: impl Fn(usize, usize) -> Option<(Vec<i64>, usize)>,
) -> Option<(Vec<[usize; 3]>, usize)> {
    let (mut n, mut at) = (1, 0);
    if is_multi {
        let (first, end) = counts(0, 1)?;
        (n, at) = (usize::try_from(first[0]).ok()?, end);
    }
    if n == 0 || n > MOST_BLOCKS {
        return None;
    }
    let (sizes, start) = counts(at, n * n_axes)?;
    let block = |sizes: &[i64]| {
        let mut block = [1; 3];
        for (along, size) in block.iter_mut().zip(sizes) {
            *along = usize::try_from(*size).ok().filter(|n| *n >= 1)?;
        }
        Some(block)
    };
    let blocks = sizes.chunks_exact(n_axes).map(block);
    Some((blocks.collect::<Option<_>>()?, start))
}

/// The one way in which a file can be read.
pub(super) fn one(mut fits: Vec<Fit>, stated: &Plot3d, why_none: String) -> Result<Fit> {
    fits.retain(|fit| (stated.allows)(&fit.layout));
    match &fits[..] {
        [] => Err(Error::input(why_none).byte(0)),
        [_] => Ok(fits.remove(0)),
        [first, second, ..] => {
            let all: Vec<String> = fits.iter().map(|fit| fit.layout.to_string()).collect();
            let flavours = Plot3d::that_tell(&first.layout, &second.layout);
            let state = flavours.map_or(String::new(), |[one, other]| {
                format!("; give {} {one} or {other}", option("input-format"))
            });
            Err(Error::input(format!(
                "the file can be read in {} ways: {}{state}",
                all.len(),
                all.join("; ")
            ))
            .byte(0))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_that_no_block_has_are_refused() {
        let blocks = |counts: &[i64], head| {
            header(head, |at, n| {
                Some((counts.get(at..at + n)?.to_vec(), at + n))
            })
        };
        let two = vec![[3, 4, 1], [5, 6, 1]];
        assert_eq!(blocks(&[2, 3, 4, 5, 6], (true, 2)), Some((two, 5)));
        assert_eq!(blocks(&[3, 0], (false, 2)), None);
        assert_eq!(blocks(&[3, -2, 4], (false, 3)), None);
        assert_eq!(n_nodes(&[[3, 4, 1], [2, 2, 2]], 100), Some(20));
        assert_eq!(n_nodes(&[[3, 4, 1]], 11), None);
        assert_eq!(n_nodes(&[[1, 1, 1]], 11), None);
        assert_eq!(n_nodes(&[[usize::MAX, 2, 1]], usize::MAX), None);
    }
}

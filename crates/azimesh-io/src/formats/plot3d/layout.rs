//! What a Plot3D file does not say of itself, and which of it fits the file.

use super::Plot3d;
use azimesh_core::error::{Error, Result, option};
use std::fmt;

/// Most blocks that a file may have.
pub(super) const MOST_BLOCKS: usize = 1 << 20;

/// How a file is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    /// `None` for text.
    pub binary: Option<Binary>,
    /// Whether the number of blocks stands at the start.
    pub is_multi: bool,
    /// 2 or 3.
    pub n_axes: usize,
    pub has_blanking: bool,
}

/// How numbers are stored as bytes.
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

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let blocks = if self.is_multi {
            "multi-block"
        } else {
            "single block"
        };
        let blanking = if self.has_blanking { "with" } else { "without" };
        write!(f, "{blocks}, {}D, {blanking} iblank", self.n_axes)?;
        match self.binary {
            None => write!(f, ", text"),
            Some(binary) => {
                let order = if binary.is_big_endian {
                    "big"
                } else {
                    "little"
                };
                let records = if binary.has_records {
                    "Fortran records"
                } else {
                    "C binary"
                };
                write!(f, ", {records}, {order}-endian, {} bits", 8 * binary.real)
            }
        }
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

/// The numbers of nodes along the indices from a list of all of them.
pub(super) fn blocks(sizes: &[i64], n_axes: usize) -> Option<Vec<[usize; 3]>> {
    let block = |sizes: &[i64]| {
        let mut block = [1; 3];
        for (along, size) in block.iter_mut().zip(sizes) {
            *along = usize::try_from(*size).ok().filter(|n| *n >= 1)?;
        }
        Some(block)
    };
    sizes.chunks_exact(n_axes).map(block).collect()
}

/// The one way in which a file can be read.
pub(super) fn one(mut fits: Vec<Fit>, stated: &Plot3d, why_none: String) -> Result<Fit> {
    fits.retain(|fit| (stated.allows)(&fit.layout));
    match &fits[..] {
        [] => Err(Error::input(why_none).byte(0)),
        [_] => Ok(fits.remove(0)),
        [first, second, ..] => {
            let all: Vec<String> = fits.iter().map(|fit| fit.layout.to_string()).collect();
            let state = match Plot3d::that_tell(&first.layout, &second.layout) {
                Some([one, other]) => {
                    format!("; give {} {one} or {other}", option("format"))
                }
                None => String::new(),
            };
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
        assert_eq!(blocks(&[3, 4, 5, 6], 2), Some(vec![[3, 4, 1], [5, 6, 1]]));
        assert_eq!(blocks(&[3, 0], 2), None);
        assert_eq!(blocks(&[3, -2, 4], 3), None);
        assert_eq!(n_nodes(&[[3, 4, 1], [2, 2, 2]], 100), Some(20));
        assert_eq!(n_nodes(&[[3, 4, 1]], 11), None);
        assert_eq!(n_nodes(&[[1, 1, 1]], 11), None);
        assert_eq!(n_nodes(&[[usize::MAX, 2, 1]], usize::MAX), None);
    }
}

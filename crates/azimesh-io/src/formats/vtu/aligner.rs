//! Passes decoded bytes on in whole tuples.

use super::super::vtk::chunk::Chunk;
use super::super::vtk::number::Element;
use azimesh_core::error::Result;

/// Bytes decoded before they are passed on.
pub(super) const CHUNK: usize = 8 << 20;

/// Passes bytes on in whole tuples.
pub(super) struct Aligner<'s> {
    /// Bytes of a tuple.
    pub tuple: usize,
    pub element: Element,
    pub swap: bool,
    pub pending: Vec<u8>,
    pub sink: &'s mut dyn FnMut(Chunk) -> Result<()>,
}

impl Aligner<'_> {
    /// Passes on what `fill` appends, but for an incomplete tuple at the end.
    pub fn push(&mut self, fill: impl FnOnce(&mut Vec<u8>) -> Result<()>) -> Result<()> {
        fill(&mut self.pending)?;
        let whole = self.pending.len() / self.tuple * self.tuple;
        if whole > 0 {
            let chunk = Chunk {
                bytes: &self.pending[..whole],
                element: self.element,
                swap: self.swap,
            };
            (self.sink)(chunk)?;
            self.pending.drain(..whole);
        }
        Ok(())
    }
}

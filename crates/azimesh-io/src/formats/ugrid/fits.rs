//! Recognizes UGRID files, which have no magic number: the counts at the start must fit the length of the file.

use super::layout::{Binary, Layout};
use super::{fortran, text};

impl Layout {
    /// Whether the counts at the start fit the length of the file.
    pub fn fits(&self, bytes: &[u8]) -> bool {
        match self {
            Self::Text => text::fits(bytes),
            Self::Binary(binary) => binary.fits(bytes),
        }
    }
}

impl Binary {
    /// Marks of records are not looked at: some writers get them wrong.
    fn fits(&self, bytes: &[u8]) -> bool {
        let before = if self.has_records { fortran::MARK } else { 0 };
        let Some(Ok(counts)) = bytes.get(before..).and_then(|from| self.counts(from)) else {
            return false;
        };
        let body = self.body(&counts);
        let marks = match self.has_records {
            true => 2 * fortran::MARK as u128 + fortran::marks(body),
            false => 0,
        };
        counts.is_mesh() && bytes.len() as u128 == self.header() as u128 + body + marks
    }
}

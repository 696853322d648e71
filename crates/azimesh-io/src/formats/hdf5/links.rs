//! The children of a group that gets more of them with each step: those that are in the file
//! already, in blocks of 8, 64, 512 ... that are written once.

use super::address::Stored;
use super::checksum::with_checksum;
use super::messages::{self, LINK, Messages};
use azimesh_core::error::Result;

/// Blocks of one size that are joined to one.
const RADIX: usize = 8;

/// Names and objects, in the order in which they are added.
#[derive(Default)]
pub(in crate::formats) struct Links {
    /// Messages of all, one after another, and where each ends.
    messages: Messages,
    ends: Vec<usize>,
    blocks: Vec<Block>,
}

/// Some of the messages in the file.
pub(super) struct Block {
    n_links: usize,
    address: u64,
    n_bytes: u64,
}

impl Links {
    /// Adds a child.
    pub fn add(&mut self, name: &str, object: Stored) -> Result<()> {
        let message = messages::link(self.len(), name, object.address)?;
        self.messages.push(LINK, 0, &message)?;
        self.ends.push(self.messages.0.len());
        Ok(())
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Puts blocks into the file that are not there yet: `put` gives an address to bytes.
    pub(super) fn store(&mut self, mut put: impl FnMut(&[u8]) -> Result<u64>) -> Result<()> {
        let sizes = sizes(self.len());
        let pairs = self.blocks.iter().zip(&sizes);
        let n_kept = pairs.take_while(|(block, n)| block.n_links == **n).count();
        self.blocks.truncate(n_kept);
        let mut first = sizes[..n_kept].iter().sum();
        for &n_links in &sizes[n_kept..] {
            let messages = &self.messages.0[self.start(first)..self.start(first + n_links)];
            let block = with_checksum([&b"OCHK"[..], messages].concat());
            self.blocks.push(Block {
                n_links,
                address: put(&block)?,
                n_bytes: block.len() as u64,
            });
            first += n_links;
        }
        Ok(())
    }

    /// Adds to a header where the blocks are, and the links that are in none.
    pub(super) fn add_to(&self, messages: &mut Messages) -> Result<()> {
        const CONTINUATION: u8 = 16;
        for block in &self.blocks {
            let place = [block.address.to_le_bytes(), block.n_bytes.to_le_bytes()];
            messages.push(CONTINUATION, 0, place.as_flattened())?;
        }
        let n_in_blocks = self.blocks.iter().map(|block| block.n_links).sum();
        let rest = &self.messages.0[self.start(n_in_blocks)..];
        messages.0.extend(rest);
        Ok(())
    }

    /// Where the message of a link starts.
    fn start(&self, link: usize) -> usize {
        link.checked_sub(1).map_or(0, |before| self.ends[before])
    }
}

/// Links of each block, of `n` in all: powers of [`RADIX`], the largest first, and less than that
/// many in none. So there are few blocks, and a step rewrites few of them.
fn sizes(n: usize) -> Vec<usize> {
    let mut sizes = Vec::new();
    let mut size = RADIX;
    while size <= n {
        let n_blocks = n / size % RADIX;
        sizes.splice(0..0, std::iter::repeat_n(size, n_blocks));
        size *= RADIX;
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_hold_all_links_but_the_last_few() {
        assert_eq!(sizes(7), [0; 0]);
        assert_eq!(sizes(8), [8]);
        assert_eq!(sizes(150), [64, 64, 8, 8]);
        assert_eq!(sizes(513), [512]);
    }
}

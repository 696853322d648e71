//! Messages of object headers, and the children of a group that gets more of them with each step: those that are in the file
//! already, in blocks of 8, 64, 512 ... that are written once.

use super::tree::Stored;
use azimesh_core::error::{Error, Result};
use hdf5_reader::checksum::jenkins_lookup3;

/// Messages of a header, one after another.
#[derive(Default)]
pub(super) struct Messages(pub Vec<u8>);

impl Messages {
    pub fn push(&mut self, kind: u8, flags: u8, body: &[u8]) -> Result<()> {
        let size = u16::try_from(body.len()).map_err(|_| {
            Error::input(format!(
                "the header of an HDF5 object has {} bytes; it can have 65535",
                body.len()
            ))
        })?;
        self.0.push(kind);
        self.0.extend(size.to_le_bytes());
        self.0.push(flags);
        self.0.extend(body);
        Ok(())
    }

    /// Adds a link to the object at `address`.
    pub fn push_link(&mut self, order: usize, name: &str, address: u64) -> Result<()> {
        const LINK: u8 = 6;
        const WITH_ORDER_AND_CHARSET: u8 = 0x14;
        const LENGTH_OF_2_BYTES: u8 = 0x01;
        const UTF8: u8 = 1;
        let length = u16::try_from(name.len()).map_err(|_| {
            Error::input(format!(
                "a name has {} bytes; HDF5 allows 65535",
                name.len()
            ))
        })?;
        let mut message = vec![1, WITH_ORDER_AND_CHARSET | LENGTH_OF_2_BYTES];
        message.extend((order as u64).to_le_bytes());
        message.push(UTF8);
        message.extend(length.to_le_bytes());
        message.extend(name.as_bytes());
        message.extend(address.to_le_bytes());
        self.push(LINK, 0, &message)
    }
}

/// Bytes, and their checksum after them.
pub(super) fn with_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
    let sum = jenkins_lookup3(&bytes);
    bytes.extend(sum.to_le_bytes());
    bytes
}

/// Blocks of one size that are joined to one.
const RADIX: usize = 8;

/// Children of a group, in the order in which they are added.
#[derive(Default)]
pub(in crate::formats) struct Links {
    messages: Vec<Vec<u8>>,
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
        let mut message = Messages::default();
        message.push_link(self.len(), name, object.address)?;
        self.messages.push(message.0);
        Ok(())
    }

    /// Number of children.
    pub fn len(&self) -> usize {
        self.messages.len()
    }

    /// Puts blocks into the file that are not there yet: `put` gives an address to bytes.
    pub(super) fn store(&mut self, mut put: impl FnMut(&[u8]) -> Result<u64>) -> Result<()> {
        let sizes = sizes(self.len());
        let pairs = self.blocks.iter().zip(&sizes);
        let n_kept = pairs.take_while(|(block, n)| block.n_links == **n).count();
        self.blocks.truncate(n_kept);
        let mut first = sizes[..n_kept].iter().sum();
        for &n_links in &sizes[n_kept..] {
            let messages = self.messages[first..first + n_links].concat();
            let block = with_checksum([&b"OCHK"[..], &messages].concat());
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
        let n_in_blocks: usize = self.blocks.iter().map(|block| block.n_links).sum();
        messages.0.extend(self.messages[n_in_blocks..].concat());
        Ok(())
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

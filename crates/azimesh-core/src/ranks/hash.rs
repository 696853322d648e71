//! BLAKE3 hashes of bytes that several ranks have: BLAKE3 is a tree, so that each rank hashes whole blocks of its own bytes,
//! and the hash of all equals the hash of one process.

use blake3::hazmat::{
    ChainingValue, HasherExt, Mode, merge_subtrees_non_root, merge_subtrees_root,
};
use blake3::{Hash, Hasher};
use serde::{Deserialize, Serialize};

/// Bytes of a block: a power of two of BLAKE3's chunks.
const BLOCK: u64 = 64 << 10;

/// Hashes bytes from front to back; some are hashed elsewhere ([`HashedBytes`]).
#[derive(Default, Clone)]
pub struct TreeHasher {
    /// The block under work; one that is full stays open until more bytes come, since the last one is hashed otherwise.
    block: Hasher,
    n_in_block: u64,
    /// Whole blocks before it.
    n_blocks: u64,
    /// Merged blocks: a tree for each bit of their number that is set, the largest first.
    trees: Vec<ChainingValue>,
}

/// Hashes that a rank sends of its bytes: the hashes of complete blocks, and the bytes before and after them.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HashedBytes {
    #[serde(with = "super::raw")]
    before: Vec<u8>,
    #[serde(with = "super::raw")]
    blocks: Vec<ChainingValue>,
    #[serde(with = "super::raw")]
    after: Vec<u8>,
}

/// Hashes some of many bytes: those from a place on.
pub struct PartHasher {
    at: u64,
    /// First and last complete block.
    whole: [u64; 2],
    block: Hasher,
    made: HashedBytes,
}

impl TreeHasher {
    /// Number of bytes so far.
    pub fn n_bytes(&self) -> u64 {
        self.n_blocks * BLOCK + self.n_in_block
    }

    /// Takes the next bytes.
    pub fn update(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            self.close_full();
            let room = (BLOCK - self.n_in_block) as usize;
            let (now, later) = bytes.split_at(room.min(bytes.len()));
            self.block.update(now);
            self.n_in_block += now.len() as u64;
            bytes = later;
        }
    }

    /// Adds the next bytes, hashed by a rank from [`n_bytes`](Self::n_bytes) on.
    pub fn take(&mut self, part: &HashedBytes) {
        self.update(&part.before);
        if !part.blocks.is_empty() {
            self.close_full();
            assert_eq!(self.n_in_block, 0, "ranks hash bytes in place");
            part.blocks.iter().for_each(|block| self.push(*block));
            self.begin();
        }
        self.update(&part.after);
    }

    /// The hash of all bytes.
    pub fn finalize(&self) -> Hash {
        let mut trees = self.trees.clone();
        merge(&mut trees, self.n_blocks);
        let Some(first) = trees.first().copied() else {
            return self.block.finalize();
        };
        let last = self.block.finalize_non_root();
        let right = trees[1..].iter().rev().fold(last, |right, left| {
            merge_subtrees_non_root(left, &right, Mode::Hash)
        });
        merge_subtrees_root(&first, &right, Mode::Hash)
    }

    fn close_full(&mut self) {
        if self.n_in_block == BLOCK {
            let block = self.block.finalize_non_root();
            self.push(block);
            self.begin();
        }
    }

    fn push(&mut self, block: ChainingValue) {
        merge(&mut self.trees, self.n_blocks);
        self.trees.push(block);
        self.n_blocks += 1;
    }

    fn begin(&mut self) {
        self.block = Hasher::new();
        self.block.set_input_offset(self.n_blocks * BLOCK);
        self.n_in_block = 0;
    }
}

/// Merges trees of so many blocks, once it is known that more follow.
fn merge(trees: &mut Vec<ChainingValue>, n_blocks: u64) {
    while trees.len() > n_blocks.count_ones() as usize {
        let right = trees.pop().expect("there are two");
        let left = trees.pop().expect("there are two");
        trees.push(merge_subtrees_non_root(&left, &right, Mode::Hash));
    }
}

impl PartHasher {
    /// Hasher of `n` bytes, the first of them at position `at` of all.
    pub fn new(at: u64, n: u64) -> Self {
        let end = at + n;
        let first = at.next_multiple_of(BLOCK).min(end);
        // One rank keeps the last of all blocks unmerged.
        let last = (end.saturating_sub(1) / BLOCK * BLOCK).max(first);
        Self {
            at,
            whole: [first, last],
            block: Hasher::new(),
            made: HashedBytes::default(),
        }
    }

    /// Takes the next bytes.
    pub fn update(&mut self, mut bytes: &[u8]) {
        let [first, last] = self.whole;
        while !bytes.is_empty() {
            let in_block = self.at % BLOCK;
            let room = match self.at {
                at if at < first => first - at,
                at if at < last => BLOCK - in_block,
                _ => bytes.len() as u64,
            };
            let (now, later) = bytes.split_at((room as usize).min(bytes.len()));
            if self.at < first {
                self.made.before.extend(now);
            } else if self.at >= last {
                self.made.after.extend(now);
            } else {
                if in_block == 0 {
                    self.block = Hasher::new();
                    self.block.set_input_offset(self.at);
                }
                self.block.update(now);
                if in_block + now.len() as u64 == BLOCK {
                    self.made.blocks.push(self.block.finalize_non_root());
                }
            }
            self.at += now.len() as u64;
            bytes = later;
        }
    }

    /// Hashes to be sent.
    pub fn finish(self) -> HashedBytes {
        self.made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(n: usize) -> Vec<u8> {
        (0..n).map(|i| (i * 7 + i / 251) as u8).collect()
    }

    #[test]
    fn it_is_the_hash_of_blake3_wherever_bytes_are_hashed() {
        let block = BLOCK as usize;
        for n in [0, 1, block, block + 1, 2 * block, 7 * block, 9 * block + 5] {
            let all = bytes(n);
            let wanted = blake3::hash(&all);
            for cuts in [
                vec![],
                vec![100],
                vec![block],
                vec![70, 2 * block, 2 * block + 9],
                vec![3 * block - 1, 8 * block],
            ] {
                let mut ends: Vec<usize> = cuts.into_iter().filter(|cut| *cut < n).collect();
                ends.push(n);
                let (mut here, mut mixed) = (TreeHasher::default(), TreeHasher::default());
                let mut start = 0;
                for (i, end) in ends.into_iter().enumerate() {
                    let part = &all[start..end];
                    part.chunks(1000).for_each(|some| here.update(some));
                    if i % 2 == 0 {
                        let mut hasher = PartHasher::new(start as u64, part.len() as u64);
                        part.chunks(77_777).for_each(|some| hasher.update(some));
                        mixed.take(&hasher.finish());
                    } else {
                        mixed.update(part);
                    }
                    start = end;
                }
                assert_eq!(here.n_bytes(), n as u64);
                assert_eq!(here.finalize(), wanted, "{n} bytes");
                assert_eq!(mixed.finalize(), wanted, "{n} bytes");
            }
        }
    }

    #[test]
    fn many_bytes_become_few() {
        let all = bytes(20 * BLOCK as usize);
        let mut hasher = PartHasher::new(5, all.len() as u64);
        hasher.update(&all);
        let told = hasher.finish();
        assert_eq!(told.blocks.len(), 19);
        assert_eq!(told.before.len(), BLOCK as usize - 5);
        assert_eq!(told.after.len(), 5);
    }
}

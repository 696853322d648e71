//! A set of nodes: one bit per node, set by several threads.

use super::Cells;
use super::part::SLAB;
use azimesh_core::parallel;
use azimesh_core::ranks::Ranks;
use azimesh_core::ranks::raw::List;
use std::ops::Range;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

/// Bits of a word.
const WORD: usize = u64::BITS as usize;
/// Words that one task looks at.
const BLOCK: usize = 1 << 10;

/// A bit for each node of a range.
#[derive(Debug)]
pub struct NodeBits {
    /// The node of the first bit.
    first: usize,
    words: Vec<AtomicU64>,
}

impl Clone for NodeBits {
    fn clone(&self) -> Self {
        let words = self
            .words
            .iter()
            .map(|word| AtomicU64::new(word.load(Relaxed)));
        Self {
            first: self.first,
            words: words.collect(),
        }
    }
}

impl PartialEq for NodeBits {
    fn eq(&self, other: &Self) -> bool {
        let words =
            |of: &Self| -> Vec<u64> { of.words.iter().map(|word| word.load(Relaxed)).collect() };
        self.first == other.first && words(self) == words(other)
    }
}

impl NodeBits {
    /// None of the nodes of a range.
    pub fn new(nodes: &Range<usize>) -> Self {
        let first = nodes.start / WORD * WORD;
        let n_words = nodes.end.saturating_sub(first).div_ceil(WORD);
        Self {
            first,
            words: (0..n_words).map(|_| AtomicU64::new(0)).collect(),
        }
    }

    /// Takes in all nodes of some cells.
    pub fn add_nodes_of(&self, cells: &Cells, ranges: &[Range<usize>]) {
        let blocks = ranges.iter().flat_map(|range| {
            let starts = range.clone().step_by(SLAB);
            starts.map(|start| start..range.end.min(start + SLAB))
        });
        parallel::for_items(blocks, &|_, block| {
            for run in cells.runs_in(block) {
                for &node in run.connectivity {
                    let at = node as usize - self.first;
                    let (word, bit) = (&self.words[at / WORD], 1 << (at % WORD));
                    // Most are there already, and looking is cheaper than setting.
                    if word.load(Relaxed) & bit == 0 {
                        word.fetch_or(bit, Relaxed);
                    }
                }
            }
        });
    }

    /// Takes in all nodes of a range.
    pub fn add_all(&self, nodes: &Range<usize>) {
        let mut start = nodes.start;
        while start < nodes.end {
            let at = start - self.first;
            let n = (WORD - at % WORD).min(nodes.end - start);
            let bits = (u64::MAX >> (WORD - n)) << (at % WORD);
            self.words[at / WORD].fetch_or(bits, Relaxed);
            start += n;
        }
    }

    /// Takes in some nodes.
    pub fn add(&self, nodes: &[u32]) {
        for &node in nodes {
            let at = node as usize - self.first;
            self.words[at / WORD].fetch_or(1 << (at % WORD), Relaxed);
        }
    }

    /// Extends the range at its end and adds the new nodes.
    pub fn extend(&mut self, nodes: Range<usize>) {
        let n_words = nodes.end.saturating_sub(self.first).div_ceil(WORD);
        self.words.resize_with(n_words, AtomicU64::default);
        self.add_all(&nodes);
    }

    /// Takes in the nodes of all ranks, on all ranks. Each rank has bits of the same range.
    pub fn unite(&mut self, ranks: &Ranks) {
        let n = ranks.n();
        if n == 1 {
            return;
        }
        // Each rank unites the same share of the words of all.
        let share = self.words.len().div_ceil(n).max(1);
        let mut to_each: Vec<Vec<[u64; 2]>> = vec![Vec::new(); n];
        for (words, to) in self.words.chunks_mut(share).zip(&mut to_each) {
            let words = (0..).zip(words).map(|(at, word)| [at, *word.get_mut()]);
            to.extend(words.filter(|[_, word]| *word != 0));
        }
        let first = (ranks.rank() * share).min(self.words.len());
        let mut own = vec![0; share.min(self.words.len() - first)];
        for [at, word] in ranks.alltoallv(to_each).into_iter().flatten() {
            own[at as usize] |= word;
        }
        let all = ranks
            .allgather(List(own))
            .into_iter()
            .flat_map(|List(own)| own);
        self.words = all.map(AtomicU64::new).collect();
    }

    /// Takes a node out.
    pub fn remove(&mut self, node: u32) {
        let at = node as usize - self.first;
        self.words[at / WORD].fetch_and(!(1 << (at % WORD)), Relaxed);
    }

    /// Number of nodes in the set.
    pub fn count(&self) -> usize {
        let ones = |word: &AtomicU64| word.load(Relaxed).count_ones() as usize;
        self.words.iter().map(ones).sum()
    }

    /// Returns whether a node is in the set.
    #[inline]
    pub fn has(&self, node: u32) -> bool {
        let at = (node as usize).wrapping_sub(self.first);
        let word = self.words.get(at / WORD);
        word.is_some_and(|word| word.load(Relaxed) & (1 << (at % WORD)) != 0)
    }

    /// Returns the nodes, ascending, and empties the set.
    pub fn take(&self) -> Vec<u32> {
        parallel::concat_blocks(self.words.len(), BLOCK, &|words| {
            let mut nodes = Vec::new();
            for at in words {
                let mut bits = self.words[at].swap(0, Relaxed);
                while bits != 0 {
                    nodes.push((self.first + at * WORD) as u32 + bits.trailing_zeros());
                    bits &= bits - 1;
                }
            }
            nodes
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::CellKind;
    use super::*;

    #[test]
    fn every_node_is_listed_once_in_order() {
        let mut cells = Cells::new();
        cells.push(CellKind::Triangle, &[200, 130, 131]);
        cells.push(CellKind::Triangle, &[131, 200, 192]);
        let bits = NodeBits::new(&(130..201));
        bits.add_nodes_of(&cells, &[0..1, 1..2]);
        assert_eq!(bits.take(), [130, 131, 192, 200]);
        bits.add_all(&(190..194));
        bits.add(&[192, 130]);
        assert_eq!(
            [129, 130, 189, 190, 193, 194].map(|node| bits.has(node)),
            [false, true, false, true, true, false]
        );
        assert_eq!(bits.take(), [130, 190, 191, 192, 193]);
        bits.add_all(&(190..194));
        bits.add_nodes_of(&cells, std::slice::from_ref(&(1..2)));
        assert_eq!(bits.take(), [131, 190, 191, 192, 193, 200]);
        for range in [130..201, 150..151, 191..192, 192..201, 140..140] {
            bits.add_all(&range);
            let wanted: Vec<u32> = range.map(|node| node as u32).collect();
            assert_eq!(bits.take(), wanted);
        }
        assert!(bits.take().is_empty());
        assert!(NodeBits::new(&(5..5)).take().is_empty());
    }
}

//! Maps tags of nodes or elements to indices; decides which tags are kept as an array.

use crate::mesh::too_many;
use azimesh_core::error::{Error, Result};

/// Finds the index of a node or an element by its tag.
#[derive(Debug)]
pub(in crate::formats) enum Index {
    /// Tags count up by one from `first`.
    Consecutive { first: i64, n: u64 },
    /// Tags with few gaps: the index of each from `first` on, `NONE` in a gap.
    Dense { first: i64, index: Vec<u32> },
    /// Tags with large gaps, ascending.
    Sparse(Vec<(i64, u32)>),
}

const NONE: u32 = u32::MAX;

impl Index {
    /// From the tags in order of index, of nodes or elements as `what` says. Refuses a tag that is
    /// there twice. O(n), or O(n log n) with large gaps.
    pub fn new(tags: &[i64], what: &str) -> Result<Self> {
        let (Some(&first), Some(&lowest), Some(&highest)) =
            (tags.first(), tags.iter().min(), tags.iter().max())
        else {
            return Ok(Self::Consecutive { first: 0, n: 0 });
        };
        if tags.len() >= NONE as usize {
            return Err(Error::input(too_many(&format!("{what}s"))));
        }
        let n = tags.len() as u64;
        let counts_up = |pair: &[i64]| pair[0].checked_add(1) == Some(pair[1]);
        if tags.windows(2).all(counts_up) {
            return Ok(Self::Consecutive { first, n });
        }
        let twice = |tag: i64| Error::input(format!("{what} {tag} is given twice"));
        let span = highest.wrapping_sub(lowest) as u64;
        if span <= 4 * n + 1024 {
            let mut index = vec![NONE; span as usize + 1];
            for (i, &tag) in tags.iter().enumerate() {
                let slot = &mut index[(tag - lowest) as usize];
                if *slot != NONE {
                    return Err(twice(tag));
                }
                *slot = i as u32;
            }
            let first = lowest;
            return Ok(Self::Dense { first, index });
        }
        let mut index: Vec<(i64, u32)> = tags.iter().copied().zip(0..).collect();
        index.sort_unstable();
        match index.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => Err(twice(pair[0].0)),
            None => Ok(Self::Sparse(index)),
        }
    }

    /// The index of what has this tag.
    #[inline]
    pub fn get(&self, tag: i64) -> Option<u32> {
        match self {
            Self::Consecutive { first, n } => {
                let i = tag.wrapping_sub(*first) as u64;
                (i < *n).then_some(i as u32)
            }
            Self::Dense { first, index } => {
                let i = tag.wrapping_sub(*first) as u64;
                let found = index.get(usize::try_from(i).ok()?).copied();
                found.filter(|i| *i != NONE)
            }
            Self::Sparse(index) => {
                let at = index.binary_search_by_key(&tag, |(tag, _)| *tag).ok()?;
                Some(index[at].1)
            }
        }
    }
}

/// Tags in order, kept as stretches that count up by one.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    stretches: Vec<(i64, usize)>,
    n: usize,
}

impl Numbers {
    #[inline]
    pub fn push(&mut self, tag: i64) {
        self.append(tag, 1);
    }

    fn append(&mut self, first: i64, n: usize) {
        self.n += n;
        match self.stretches.last_mut() {
            Some((start, length)) if start.checked_add(*length as i64) == Some(first) => {
                *length += n;
            }
            _ => self.stretches.push((first, n)),
        }
    }

    /// Adds the tags of another, after these.
    pub fn extend(&mut self, other: &Self) {
        for &(first, n) in &other.stretches {
            self.append(first, n);
        }
    }

    /// The tags; `None` where they are 1, 2, 3 and so on.
    pub fn values(&self) -> Option<Vec<i64>> {
        if matches!(self.stretches[..], [] | [(1, _)]) {
            return None;
        }
        let mut all = Vec::with_capacity(self.n);
        for &(first, n) in &self.stretches {
            all.extend((0..n as i64).map(|i| first + i));
        }
        Some(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_numbers_that_do_not_count_from_one_are_kept() {
        let numbers = |tags: &[i64]| {
            let mut numbers = Numbers::default();
            let (front, back) = tags.split_at(tags.len() / 2);
            let mut tail = Numbers::default();
            front.iter().for_each(|tag| numbers.push(*tag));
            back.iter().for_each(|tag| tail.push(*tag));
            numbers.extend(&tail);
            numbers.values()
        };
        assert_eq!(numbers(&[]), None);
        assert_eq!(numbers(&[1, 2, 3, 4]), None);
        for tags in [vec![2, 3], vec![1, 2, 4, 3], vec![i64::MAX, i64::MIN, 5]] {
            assert_eq!(numbers(&tags), Some(tags));
        }
    }

    #[test]
    fn tags_are_found_whatever_their_order_and_gaps() {
        for tags in [vec![5, 6, 7], vec![9, 2, 4], vec![1, 1 << 40, -7], vec![]] {
            let index = Index::new(&tags, "node").expect("no tag is there twice");
            for (i, tag) in tags.iter().enumerate() {
                assert_eq!(index.get(*tag), Some(i as u32));
            }
            for missing in [0, 3, 8, i64::MAX, i64::MIN] {
                assert_eq!(index.get(missing), None, "{missing} in {tags:?}");
            }
        }
    }

    #[test]
    fn a_tag_given_twice_is_refused() {
        assert!(Index::new(&[3, 1, 3], "node").is_err());
        assert!(Index::new(&[1 << 50, 1, 1 << 50], "node").is_err());
        assert!(Index::new(&[i64::MAX, i64::MIN], "node").is_ok());
    }
}

//! Places of numbers in an ascending list.

use std::borrow::Cow;
use std::ops::Range;

/// The part of ascending numbers that is in a range.
pub(crate) fn among<'a>(numbers: &'a [u32], range: &Range<usize>) -> &'a [u32] {
    among_by(numbers, |&number| number, range)
}

/// The part of items with ascending numbers whose numbers are in a range.
pub(crate) fn among_by<'a, T>(
    items: &'a [T],
    number: impl Fn(&T) -> u32,
    range: &Range<usize>,
) -> &'a [T] {
    let before = |end: usize| items.partition_point(|item| (number(item) as usize) < end);
    &items[before(range.start)..before(range.end)]
}

/// Finds numbers in an ascending list, in a time that hardly grows with its length where they are spread evenly.
#[derive(Debug, Clone, Default)]
pub struct Numbering<'a> {
    sorted: Cow<'a, [u32]>,
    /// Index of the first number with each value of the leading bits.
    starts: Vec<u32>,
    /// Number of the remaining bits.
    shift: u32,
}

impl<'a> Numbering<'a> {
    /// The numbering of these indices, which ascend.
    pub fn new(sorted: impl Into<Cow<'a, [u32]>>) -> Self {
        let sorted = sorted.into();
        let largest = sorted.last().copied().unwrap_or(0);
        let mut shift = 0;
        while (largest >> shift) as usize > sorted.len() {
            shift += 1;
        }
        let mut starts = Vec::with_capacity((largest >> shift) as usize + 2);
        for (at, number) in (0..).zip(&*sorted) {
            while starts.len() <= (number >> shift) as usize {
                starts.push(at);
            }
        }
        starts.push(sorted.len() as u32);
        Self {
            sorted,
            starts,
            shift,
        }
    }

    /// The list.
    pub fn sorted(&self) -> &[u32] {
        &self.sorted
    }

    /// The places of a number in the list.
    pub fn places(&self, number: u32) -> Range<usize> {
        let bits = (number >> self.shift) as usize;
        let Some(&end) = self.starts.get(bits + 1) else {
            return 0..0;
        };
        let start = self.starts[bits] as usize;
        if start == end as usize {
            return 0..0;
        }
        let few = &self.sorted[start..end as usize];
        let first = few.partition_point(|&other| other < number);
        let n = few[first..].partition_point(|&other| other == number);
        start + first..start + first + n
    }

    /// The place of a number in the list, where it is there.
    pub fn place(&self, number: u32) -> Option<usize> {
        let places = self.places(number);
        (!places.is_empty()).then_some(places.start)
    }

    /// The place of a number that is in the list.
    pub fn of(&self, number: u32) -> u32 {
        self.places(number).start as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_wherever_they_lie() {
        for sorted in [
            vec![],
            vec![0],
            vec![7, 7, 7, 4_000_000_000],
            (0..1000).map(|i| i * i).collect::<Vec<u32>>(),
            vec![u32::MAX - 1],
        ] {
            let numbering = Numbering::new(&sorted);
            assert!(numbering.starts.len() <= sorted.len() + 2);
            for number in (0..2000).chain(sorted.iter().copied()).chain([u32::MAX]) {
                let found = numbering.places(number);
                assert_eq!(found.len(), sorted.iter().filter(|x| **x == number).count());
                assert!(sorted[found].iter().all(|x| *x == number));
            }
        }
    }
}

//! Parallel loops that give the same bytes on any number of threads.
//!
//! Work is cut into blocks whose sizes the caller chooses. Threads take blocks in any order; what the blocks give is put
//! together in their own order. So a sum over blocks is added up in one order, whatever the number of threads.
//!
//! The loops take `&dyn Fn`: the call costs nothing beside the work of a block, and the code that spreads work over
//! threads is compiled once instead of once for each loop.

use crate::error::Result;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Elements of a block where each costs a few nanoseconds.
pub const BLOCK: usize = 4096;

/// Calls `act(i)` for each `i` below `n`.
pub fn for_each(n: usize, act: &(dyn Fn(usize) + Sync)) {
    (0..n).into_par_iter().for_each(act);
}

/// `of(i)` for each `i` below `n`, in order. For work of a microsecond or more; see [`collect`] for less.
pub fn map<T: Send>(n: usize, of: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
    map_items(0..n, &|i, _| of(i))
}

/// `of(range)` for each block of `size` of the numbers below `n`, in order.
pub fn map_blocks<T: Send>(
    n: usize,
    size: usize,
    of: &(dyn Fn(Range<usize>) -> T + Sync),
) -> Vec<T> {
    map(n.div_ceil(size), &|i| of(block(n, size, i)))
}

/// Calls `act(first, values)` for each block of `size` values; `first` is the index of the block's first value.
pub fn for_blocks<T: Send>(values: &mut [T], size: usize, act: &(dyn Fn(usize, &mut [T]) + Sync)) {
    for_items(values.chunks_mut(size), &|i, values| act(i * size, values));
}

/// Calls `act(i, item)` for each item.
pub fn for_items<T: Send>(items: impl IntoIterator<Item = T>, act: &(dyn Fn(usize, T) + Sync)) {
    map_items(items, act);
}

/// `of(i, item)` for each item, in order.
pub fn map_items<T: Send, U: Send>(
    items: impl IntoIterator<Item = T>,
    of: &(dyn Fn(usize, T) -> U + Sync),
) -> Vec<U> {
    let slots: Vec<_> = items
        .into_iter()
        .map(|item| Mutex::new((Some(item), None)))
        .collect();
    for_each(slots.len(), &|i| {
        let mut slot = slots[i].lock().unwrap_or_else(PoisonError::into_inner);
        let item = slot.0.take().expect("each item is taken once");
        slot.1 = Some(of(i, item));
    });
    slots
        .into_iter()
        .map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner).1)
        .map(|result| result.expect("each item has been worked on"))
        .collect()
}

/// Results in order, or the first error.
///
/// # Errors
/// That of the lowest index, whichever thread was first.
pub fn try_map<T: Send>(n: usize, of: &(dyn Fn(usize) -> Result<T> + Sync)) -> Result<Vec<T>> {
    map(n, of).into_iter().collect()
}

/// `of(i)` for each `i` below `n`, in order, where each costs little: `of` is compiled into the loop over a block.
pub fn collect<T: Copy + Default + Send>(n: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut values = vec![T::default(); n];
    update(&mut values, |i, value| *value = of(i));
    values
}

/// Calls `act(i, value)` for each value, where each costs little: `act` is compiled into the loop over a block.
pub fn update<T: Send>(values: &mut [T], act: impl Fn(usize, &mut T) + Sync) {
    for_blocks(values, BLOCK, &|first, values| {
        for (i, value) in values.iter_mut().enumerate() {
            act(first + i, value);
        }
    });
}

/// The largest of `of(i)` for each `i` below `n`, 0 where there is none larger. NaN is passed over.
pub fn largest(n: usize, of: impl Fn(usize) -> f64 + Sync) -> f64 {
    map_blocks(n, BLOCK, &|range| range.map(&of).fold(0.0, f64::max))
        .into_iter()
        .fold(0.0, f64::max)
}

/// Whether `of(i)` holds for any `i` below `n`.
pub fn any(n: usize, of: impl Fn(usize) -> bool + Sync) -> bool {
    map_blocks(n, BLOCK, &|mut range| range.any(&of)).contains(&true)
}

/// Sorts values, of which equal ones are alike: which of them comes first does not matter.
pub fn sort<T: Ord + Send>(values: &mut [T]) {
    values.par_sort_unstable();
}

/// Sorts values by a key, which no two of them share.
pub fn sort_by_key<T: Send, K: Ord>(values: &mut [T], key: impl Fn(&T) -> K + Sync) {
    values.par_sort_unstable_by_key(key);
}

/// Calls `act` on this thread and `beside` on others at the same time.
pub fn with(act: &mut dyn FnMut(), beside: &mut (dyn FnMut() + Send)) {
    rayon::in_place_scope(|scope| {
        scope.spawn(|_| beside());
        act();
    });
}

/// Block `i` of `size` of the numbers below `n`.
pub fn block(n: usize, size: usize, i: usize) -> Range<usize> {
    i * size..n.min((i + 1) * size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    #[test]
    fn results_stand_in_the_order_of_the_items() {
        let squares: Vec<usize> = (0..1000).map(|i| i * i).collect();
        assert_eq!(map(1000, &|i| i * i), squares);
        assert_eq!(map_items(squares.clone(), &|_, item| item), squares);
        assert_eq!(collect(10_000, |i| i), (0..10_000).collect::<Vec<_>>());
        let ranges = map_blocks(10, 4, &|range| range);
        assert_eq!(ranges, [0..4, 4..8, 8..10]);
    }

    #[test]
    fn each_value_is_worked_on_once_with_its_index() {
        let mut values = vec![1; 10_001];
        for_blocks(&mut values, 64, &|first, values| {
            for (i, value) in values.iter_mut().enumerate() {
                *value += first + i;
            }
        });
        assert!(values.iter().enumerate().all(|(i, value)| *value == i + 1));
        assert_eq!(largest(values.len(), |i| values[i] as f64), 10_001.0);
        assert_eq!(largest(0, |_| 1.0), 0.0);
        assert!(any(10_000, |i| i == 9_999) && !any(9_999, |i| i == 9_999));
    }

    #[test]
    fn values_are_sorted_and_two_things_done_at_once() {
        let mut keys: Vec<(u64, u32)> = (0..10_000).map(|i| (u64::from(i) % 7, i)).collect();
        let by_node = keys.clone();
        let (mut sorted, mut is_sorted) = (keys.clone(), false);
        with(&mut || sort(&mut keys), &mut || {
            sorted.sort();
            is_sorted = true;
        });
        assert!(is_sorted);
        assert_eq!(keys, sorted);
        sort_by_key(&mut keys, |key| key.1);
        assert_eq!(keys, by_node);
    }

    #[test]
    fn the_first_error_in_order_is_given() {
        let fails = |i: usize| match i {
            0..300 => Ok(i),
            _ => Err(Error::input(i.to_string())),
        };
        assert_eq!(try_map(300, &fails).expect("none fails").len(), 300);
        let error = try_map(1000, &fails).expect_err("most fail");
        assert_eq!(error.message, "300");
    }
}

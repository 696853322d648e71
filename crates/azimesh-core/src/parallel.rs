//! Parallel loops that give the same bytes on any number of threads.
//!
//! Work is cut into blocks whose sizes the caller chooses. Threads take blocks in any order; the results of the blocks are
//! combined in the order of the blocks. So a sum over blocks has one order, for any number of threads.
//!
//! The loops take `&dyn Fn`: the code that spreads work over threads is compiled once instead of once for each loop. The
//! time of a call is negligible against the work of a block.

use crate::error::{Error, Result};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Elements of a block where each costs a few nanoseconds.
pub const BLOCK: usize = 4096;
/// Elements of a block where each costs a microsecond.
pub const SMALL_BLOCK: usize = 64;

/// Calls `act(i)` for each `i` below `n`.
pub fn for_each(n: usize, act: &(dyn Fn(usize) + Sync)) {
    (0..n).into_par_iter().for_each(act);
}

/// Starts `n_threads` threads for all loops.
///
/// # Errors
/// If the system does not start them.
pub fn start(n_threads: usize) -> Result<()> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(n_threads)
        .build_global()
        .map_err(|error| cannot_start(n_threads, &error))
}

fn cannot_start(n_threads: usize, error: &rayon::ThreadPoolBuildError) -> Error {
    Error::system(format!("cannot start {n_threads} threads: {error}"))
}

/// Threads that loops run on.
pub fn n_threads() -> usize {
    rayon::current_num_threads()
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
    map_blocks_in(0..n, size, of)
}

/// `of(range)` for each block of `size` of the numbers in `all`, counted from its start, in order.
pub fn map_blocks_in<T: Send>(
    all: Range<usize>,
    size: usize,
    of: &(dyn Fn(Range<usize>) -> T + Sync),
) -> Vec<T> {
    let Range { start, end } = all;
    map((end - start).div_ceil(size), &|i| {
        let block = block(end - start, size, i);
        of(start + block.start..start + block.end)
    })
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
/// The error of the lowest index, whichever thread was first.
pub fn try_map<T: Send>(n: usize, of: &(dyn Fn(usize) -> Result<T> + Sync)) -> Result<Vec<T>> {
    map(n, of).into_iter().collect()
}

/// `of(i)` for each `i` below `n`, in order, where each costs little: `of` is compiled into the loop over a block.
pub fn collect<T: Copy + Default + Send>(n: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    collect_in_blocks(n, BLOCK, of)
}

/// [`collect`] with blocks of `size`: [`SMALL_BLOCK`] where each value costs a microsecond.
pub fn collect_in_blocks<T: Copy + Default + Send>(
    n: usize,
    size: usize,
    of: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let mut values = vec![T::default(); n];
    for_blocks(&mut values, size, &|first, values| {
        for (i, value) in values.iter_mut().enumerate() {
            *value = of(first + i);
        }
    });
    values
}

/// Joins the results of `of(range)` for each block of `size` of the numbers below `n`, in order.
pub fn concat_blocks<T: Send>(
    n: usize,
    size: usize,
    of: &(dyn Fn(Range<usize>) -> Vec<T> + Sync),
) -> Vec<T> {
    let blocks = map_blocks(n, size, of);
    let mut all = Vec::with_capacity(blocks.iter().map(Vec::len).sum());
    for block in blocks {
        all.extend(block);
    }
    all
}

/// Collects the results of `of(i)` for the numbers below `n`, in order. For calls that cost little.
pub fn filter_map<T: Send>(n: usize, of: impl Fn(usize) -> Option<T> + Sync) -> Vec<T> {
    concat_blocks(n, BLOCK, &|range| range.filter_map(&of).collect())
}

/// Calls `act(i, value)` for each value, where each costs little: `act` is compiled into the loop over a block.
pub fn update<T: Send>(values: &mut [T], act: impl Fn(usize, &mut T) + Sync) {
    for_blocks(values, BLOCK, &|first, values| {
        for (i, value) in values.iter_mut().enumerate() {
            act(first + i, value);
        }
    });
}

/// Returns the largest of `of(i)` for each `i` below `n`, or 0 if none is larger. NaN is ignored.
pub fn largest(n: usize, of: impl Fn(usize) -> f64 + Sync) -> f64 {
    map_blocks(n, BLOCK, &|range| range.map(&of).fold(0.0, f64::max))
        .into_iter()
        .fold(0.0, f64::max)
}

/// Checks if `of(i)` holds for any `i` below `n`.
pub fn any(n: usize, of: impl Fn(usize) -> bool + Sync) -> bool {
    map_blocks(n, BLOCK, &|mut range| range.any(&of)).contains(&true)
}

/// Sorts values whose order among equals does not matter.
pub fn sort<T: Ord + Send>(values: &mut [T]) {
    values.par_sort_unstable();
}

/// Sorts values by a key, which no two of them share.
pub fn sort_by_key<T: Send, K: Ord>(values: &mut [T], key: impl Fn(&T) -> K + Sync) {
    values.par_sort_unstable_by_key(key);
}

/// Calls `act` on this thread and `beside` on other threads, concurrently.
pub fn with(act: &mut dyn FnMut(), beside: &mut (dyn FnMut() + Send)) {
    rayon::in_place_scope(|scope| {
        scope.spawn(|_| beside());
        act();
    });
}

/// Calls `act` on this thread and `beside` on a thread of its own, which does not wait for other work of the loops' threads.
/// If there is one thread, or the system starts no other, `beside` is called after `act`.
pub fn with_own_thread(act: &mut dyn FnMut(), beside: &mut (dyn FnMut() + Send)) {
    if n_threads() == 1 {
        act();
        return beside();
    }
    let is_started = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().spawn_scoped(scope, &mut *beside);
        act();
        thread.is_ok()
    });
    if !is_started {
        beside();
    }
}

/// Block `i` of `size` of the numbers below `n`.
pub fn block(n: usize, size: usize, i: usize) -> Range<usize> {
    i * size..n.min((i + 1) * size)
}

/// Scratch memory of a loop: as many `T` as threads work at once, used again for one block after the other.
pub struct Scratch<T> {
    new: fn() -> T,
    free: Mutex<Vec<T>>,
}

impl<T> Scratch<T> {
    /// None yet; `new` makes them.
    pub fn new(new: fn() -> T) -> Self {
        let free = Mutex::new(Vec::new());
        Self { new, free }
    }

    /// Calls `act` with one of them, as the last call left it.
    pub fn with<R>(&self, act: impl FnOnce(&mut T) -> R) -> R {
        let free = || self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let found = free().pop();
        let mut scratch = found.unwrap_or_else(self.new);
        let result = act(&mut scratch);
        free().push(scratch);
        result
    }

    /// All of them, in any order.
    pub fn into_all(self) -> Vec<T> {
        self.free
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn results_of_blocks_follow_one_another() {
        let even: Vec<usize> = (0..10_000).step_by(2).collect();
        let found = filter_map(10_000, |i| i.is_multiple_of(2).then_some(i));
        assert_eq!(found, even);
        let all = concat_blocks(10_000, 7, &|range| range.collect());
        assert_eq!(all, (0..10_000).collect::<Vec<_>>());
        assert_eq!(collect_in_blocks(100, 7, |i| 2 * i), even[..100]);
    }

    #[test]
    fn scratch_is_used_again_and_holds_all_that_was_counted() {
        let counts = Scratch::new(|| 0);
        for_each(1000, &|i| counts.with(|count| *count += i));
        let counts = counts.into_all();
        assert!(counts.len() <= rayon::current_num_threads());
        assert_eq!(counts.iter().sum::<usize>(), 499_500);
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
        let mut n_done = 0;
        with_own_thread(&mut || sort_by_key(&mut keys, |key| key.1), &mut || {
            n_done += 1;
        });
        assert_eq!((keys, n_done), (by_node, 1));
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

    #[test]
    fn blocks_of_a_range_are_counted_from_its_start() {
        assert_eq!(map_blocks_in(5..12, 4, &|range| range), [5..9, 9..12]);
        assert_eq!(map_blocks_in(5..5, 4, &|range| range), [0..0; 0]);
    }
}

//! Processes that work on one mesh together, each on a part of it: ranks, as MPI calls them.
//!
//! All ranks run the same code and call the functions here in the same order, each with what it has. What comes out is
//! the same on every rank, whatever their number: values are put together in the order of the ranks, and nothing is added
//! up by the network. A program that runs alone is rank 0 of 1, and sends nothing.

#[cfg(feature = "mpi")]
mod mpi;
pub mod raw;
#[cfg(any(test, feature = "internals"))]
mod threads;

#[cfg(feature = "mpi")]
pub use mpi::start;
#[cfg(any(test, feature = "internals"))]
pub use threads::on_threads;

use crate::error::Result;
use bytemuck::Pod;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What carries bytes from rank to rank, in the order in which they were sent.
pub trait Network: Send + Sync {
    /// The number of this rank.
    fn rank(&self) -> usize;
    /// How many there are.
    fn n_ranks(&self) -> usize;
    /// Sends bytes to another rank. It may wait until they are received.
    fn send(&self, to: usize, bytes: &[u8]);
    /// Waits for the next bytes of another rank.
    fn receive(&self, from: usize) -> Vec<u8>;
    /// Waits for the next bytes of another rank, of which there are as many as `bytes` takes.
    fn receive_into(&self, from: usize, bytes: &mut [u8]);
    /// Sends to one rank and receives from one, without waiting for either first.
    fn send_and_receive(&self, to: usize, bytes: &[u8], from: usize) -> Vec<u8>;
}

/// This rank, and the way to the others. Copies share it.
#[derive(Clone)]
pub struct Ranks {
    network: Option<Arc<dyn Network>>,
    sent: Arc<[AtomicU64; 2]>,
}

impl Default for Ranks {
    fn default() -> Self {
        Self::alone()
    }
}

impl fmt::Debug for Ranks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rank {} of {}", self.rank(), self.n())
    }
}

impl Ranks {
    /// The only one.
    pub fn alone() -> Self {
        Self {
            network: None,
            sent: Arc::default(),
        }
    }

    /// One of several, which `network` connects.
    pub fn new(network: impl Network + 'static) -> Self {
        Self {
            network: Some(Arc::new(network)),
            ..Self::alone()
        }
    }

    /// The number of this rank.
    pub fn rank(&self) -> usize {
        self.network.as_ref().map_or(0, |network| network.rank())
    }

    /// How many there are.
    pub fn n(&self) -> usize {
        self.network.as_ref().map_or(1, |network| network.n_ranks())
    }

    /// Whether this is the rank that speaks for all.
    pub fn is_first(&self) -> bool {
        self.rank() == 0
    }

    /// Messages that this rank has sent so far, and bytes in them.
    pub fn sent(&self) -> [u64; 2] {
        [0, 1].map(|i| self.sent[i].load(Ordering::Relaxed))
    }

    fn network(&self) -> &dyn Network {
        let network = self.network.as_ref();
        &**network.expect("a rank that is alone sends nothing")
    }

    fn count(&self, bytes: usize) {
        self.sent[0].fetch_add(1, Ordering::Relaxed);
        self.sent[1].fetch_add(bytes as u64, Ordering::Relaxed);
    }

    fn send(&self, to: usize, bytes: &[u8]) {
        self.count(bytes.len());
        self.network().send(to, bytes);
    }

    fn receive(&self, from: usize) -> Vec<u8> {
        self.network().receive(from)
    }

    /// What rank 0 has, on all ranks: down a tree, so that no rank sends more than `log2 n` times.
    pub fn broadcast<T: Serialize + DeserializeOwned>(&self, of_first: Option<T>) -> T {
        if self.n() == 1 {
            return of_first.expect("rank 0 has it");
        }
        let (rank, n) = (self.rank(), self.n());
        let bytes = match of_first {
            Some(value) if rank == 0 => pack(&value),
            _ => self.receive(rank - (1 << rank.ilog2())),
        };
        let mut step = match rank {
            0 => 1,
            _ => 2 << rank.ilog2(),
        };
        while rank + step < n {
            self.send(rank + step, &bytes);
            step *= 2;
        }
        unpack(&bytes)
    }

    /// What each rank has, in their order, on rank 0 alone: up the tree of [`broadcast`](Self::broadcast).
    fn gather<T: Serialize + DeserializeOwned>(&self, own: T) -> Option<Vec<T>> {
        let (rank, n) = (self.rank(), self.n());
        let mut all = vec![(rank, own)];
        let first = match rank {
            0 => 1,
            _ => 2 << rank.ilog2(),
        };
        let mut steps = Vec::new();
        let mut step = first;
        while rank + step < n {
            steps.push(step);
            step *= 2;
        }
        for step in steps.into_iter().rev() {
            all.extend(unpack::<Vec<(usize, T)>>(&self.receive(rank + step)));
        }
        if rank > 0 {
            self.send(rank - (1 << rank.ilog2()), &pack(&all));
            return None;
        }
        all.sort_by_key(|(rank, _)| *rank);
        Some(all.into_iter().map(|(_, value)| value).collect())
    }

    /// What each rank has, in their order, on all ranks. For what is small: it grows with the number of ranks.
    pub fn all<T: Serialize + DeserializeOwned>(&self, own: T) -> Vec<T> {
        match self.n() {
            1 => vec![own],
            _ => {
                let gathered = self.gather(own);
                self.broadcast(gathered)
            }
        }
    }

    /// Adds up over all ranks in their order: `append` adds what this rank has to what those before it have, and to `start`
    /// on rank 0. The sum goes from rank to rank, so it is added up as one process would do it.
    pub fn fold<T: Serialize + DeserializeOwned>(
        &self,
        start: T,
        append: impl FnOnce(&mut T),
    ) -> T {
        let (rank, n) = (self.rank(), self.n());
        let mut sum = match rank {
            0 => start,
            _ => unpack(&self.receive(rank - 1)),
        };
        append(&mut sum);
        if n == 1 {
            return sum;
        }
        // The last rank has the sum of all; rank 0 passes it on.
        match rank + 1 < n {
            true => self.send(rank + 1, &pack(&sum)),
            false => self.send(0, &pack(&sum)),
        }
        let whole = (rank == 0).then(|| unpack(&self.receive(n - 1)));
        self.broadcast(whole)
    }

    /// Gives each rank what rank 0 has for it, one rank after the other; `for_rank` is asked there alone.
    ///
    /// # Panics
    /// When rank 0 has nothing for a rank.
    pub fn scatter<T: Serialize + DeserializeOwned>(
        &self,
        for_rank: &dyn Fn(usize) -> Option<T>,
    ) -> T {
        const ALL: &str = "rank 0 has something for every rank";
        if !self.is_first() {
            return unpack(&self.receive(0));
        }
        for rank in 1..self.n() {
            self.send(rank, &pack(&for_rank(rank).expect(ALL)));
        }
        for_rank(0).expect(ALL)
    }

    /// Gives each rank the numbers that rank 0 has for it; `for_rank` is asked there alone. `own` takes them.
    pub fn scatter_into<T: Pod>(
        &self,
        for_rank: &dyn Fn(usize, &mut [T]),
        own: &mut [T],
        lengths: &[usize],
    ) {
        if !self.is_first() {
            return self
                .network()
                .receive_into(0, bytemuck::cast_slice_mut(own));
        }
        let mut values = Vec::new();
        for (rank, &length) in lengths.iter().enumerate().skip(1) {
            values.resize(length, T::zeroed());
            for_rank(rank, &mut values);
            self.send(rank, bytemuck::cast_slice(&values));
        }
        for_rank(0, own);
    }

    /// Gives rank 0 the numbers of this one, which it takes by [`receive_parts`](Self::receive_parts).
    pub fn send_part<T: Pod>(&self, own: &[T]) {
        self.send(0, bytemuck::cast_slice(own));
    }

    /// Takes the numbers of each other rank on rank 0; `parts` has as much room as each has numbers.
    pub fn receive_parts<T: Pod>(&self, parts: &mut [&mut [T]]) {
        for (rank, part) in parts.iter_mut().enumerate().skip(1) {
            let bytes = bytemuck::cast_slice_mut(part);
            self.network().receive_into(rank, bytes);
        }
    }

    /// Gives each rank what the others have for it: `for_each[i]` goes to rank `i`. What comes is in the order of the ranks.
    ///
    /// # Panics
    /// When there is not one for each rank.
    pub fn exchange(&self, mut for_each: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        let (rank, n) = (self.rank(), self.n());
        assert_eq!(for_each.len(), n, "one for each rank");
        let own = std::mem::take(&mut for_each[rank]);
        let mut received = vec![Vec::new(); n];
        received[rank] = own;
        for step in 1..n {
            let (to, from) = ((rank + step) % n, (rank + n - step) % n);
            self.count(for_each[to].len());
            let bytes = std::mem::take(&mut for_each[to]);
            received[from] = self.network().send_and_receive(to, &bytes, from);
        }
        received
    }

    /// What each rank made, where all of them succeeded; else the error of the first that failed, on all of them.
    ///
    /// # Errors
    /// Where it failed on any rank.
    pub fn agree<T>(&self, made: Result<T>) -> Result<T> {
        if self.n() == 1 {
            return made;
        }
        let (made, error) = match made {
            Ok(made) => (Some(made), None),
            Err(error) => (None, Some(error)),
        };
        match self.all(error).into_iter().flatten().next() {
            Some(error) => Err(error),
            None => Ok(made.expect("no rank failed")),
        }
    }
}

fn pack<T: Serialize>(value: &T) -> Vec<u8> {
    postcard::to_allocvec(value).expect("what ranks send each other can be packed")
}

fn unpack<T: DeserializeOwned>(bytes: &[u8]) -> T {
    postcard::from_bytes(bytes).expect("ranks of one program understand each other")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    #[test]
    fn every_rank_gets_what_all_have_in_their_order() {
        for n in 1..10 {
            let found = on_threads(n, |ranks| {
                let all = ranks.all(10 * ranks.rank());
                let first = ranks.broadcast(ranks.is_first().then(|| "from the first".to_owned()));
                (all, first, ranks.n())
            });
            let wanted: Vec<usize> = (0..n).map(|rank| 10 * rank).collect();
            for (all, first, size) in found {
                assert_eq!(
                    (all, &first[..], size),
                    (wanted.clone(), "from the first", n)
                );
            }
        }
    }

    #[test]
    fn a_sum_over_ranks_is_that_of_one_process_to_the_last_bit() {
        let parts: Vec<f64> = (0..64).map(|i| f64::from(i).sin() * 1e3).collect();
        let sum = parts.iter().sum::<f64>();
        for n in [1, 2, 3, 7] {
            let sums = on_threads(n, |ranks| {
                let own = &parts[64 * ranks.rank() / n..64 * (ranks.rank() + 1) / n];
                ranks.fold(0.0, |sum| own.iter().for_each(|part| *sum += part))
            });
            assert!(sums.iter().all(|found| found.to_bits() == sum.to_bits()));
        }
    }

    #[test]
    fn what_is_for_another_rank_arrives_there_and_is_counted() {
        let received = on_threads(4, |ranks| {
            let rank = ranks.rank() as u8;
            let for_each = (0..4).map(|to| vec![rank; to]).collect();
            (ranks.exchange(for_each), ranks.sent())
        });
        for (rank, (received, sent)) in received.into_iter().enumerate() {
            let wanted: Vec<Vec<u8>> = (0..4).map(|from| vec![from; rank]).collect();
            assert_eq!(received, wanted);
            assert_eq!(sent, [3, (6 - rank) as u64]);
        }
    }

    #[test]
    fn the_first_rank_that_fails_gives_the_error_of_all() {
        let found = on_threads(4, |ranks| {
            ranks.agree(match ranks.rank() {
                0 => Ok("good"),
                rank => Err(Error::input(format!("of rank {rank}")).line(7)),
            })
        });
        for found in found {
            assert_eq!(
                found.expect_err("three failed").to_string(),
                "line 7: of rank 1"
            );
        }
        let fine = on_threads(3, |ranks| ranks.agree(Ok(ranks.rank())));
        let fine: Vec<usize> = fine
            .into_iter()
            .map(|of| of.expect("none failed"))
            .collect();
        assert_eq!(fine, [0, 1, 2]);
    }
}

//! Processes that work on one mesh together, each on a part of it: ranks, as MPI calls them.
//!
//! All ranks run the same code and call the functions here in the same order, each with its own data. The results are the
//! same on every rank, for any number of ranks: values are combined in the order of the ranks, and the network adds nothing
//! up. A program that runs alone is rank 0 of 1, and sends nothing.

mod exchange;
pub mod hash;
pub mod processor;
pub mod raw;
mod threads;

pub use threads::on_threads;

use crate::error::Result;
use bytemuck::Pod;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A network that carries bytes from rank to rank, in the order in which they were sent.
pub trait Network: Send + Sync {
    /// The number of this rank.
    fn rank(&self) -> usize;
    /// The number of ranks.
    fn n_ranks(&self) -> usize;
    /// Sends bytes to another rank. It may wait until they are received.
    fn send(&self, to: usize, bytes: &[u8]);
    /// Waits for the next bytes of another rank.
    fn receive(&self, from: usize) -> Vec<u8>;
    /// Waits for the next bytes of another rank, as many as `bytes` takes.
    fn receive_into(&self, from: usize, bytes: &mut [u8]);
    /// Checks if this rank is on the machine of the first.
    fn is_on_first_machine(&self) -> bool {
        true
    }
}

/// This rank, and its connection to the others. Copies share it.
#[derive(Clone)]
pub struct Ranks {
    network: Option<Arc<dyn Network>>,
    sent: Arc<Mutex<Log>>,
}

/// Record of the messages of a rank.
struct Log {
    /// Purpose of its present messages.
    what: String,
    /// Messages, and bytes in them.
    sent: BTreeMap<String, [u64; 2]>,
}

impl Default for Log {
    fn default() -> Self {
        Self {
            what: "start".to_owned(),
            sent: BTreeMap::new(),
        }
    }
}

/// Messages of all ranks for one purpose.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Sent {
    /// The purpose.
    pub what: String,
    /// Messages of all ranks.
    pub messages: u64,
    /// Bytes in them.
    pub bytes: u64,
    /// Bytes of the rank that sent most.
    pub most: u64,
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
    /// Makes the only rank.
    pub fn alone() -> Self {
        Self {
            network: None,
            sent: Arc::default(),
        }
    }

    /// Makes one rank of several, which `network` connects.
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

    /// The number of ranks.
    pub fn n(&self) -> usize {
        self.network.as_ref().map_or(1, |network| network.n_ranks())
    }

    /// Checks if this is rank 0, which reports for all.
    pub fn is_first(&self) -> bool {
        self.rank() == 0
    }

    /// Checks if this rank is on the machine of the first.
    pub fn is_on_first_machine(&self) -> bool {
        let network = self.network.as_ref();
        network.is_none_or(|network| network.is_on_first_machine())
    }

    /// Names the purpose of all later messages.
    pub fn set_label(&self, what: &str) {
        self.log().what = what.to_owned();
    }

    /// Counts the messages of all ranks, by purpose.
    pub fn sent_by_all(&self) -> Vec<Sent> {
        let own = self.log().sent.clone();
        let mut all: BTreeMap<String, Sent> = BTreeMap::new();
        for (what, [messages, bytes]) in self.allgather(own).into_iter().flatten() {
            let sent = all.entry(what.clone()).or_default();
            sent.what = what;
            sent.messages += messages;
            sent.bytes += bytes;
            sent.most = sent.most.max(bytes);
        }
        all.into_values().collect()
    }

    fn log(&self) -> MutexGuard<'_, Log> {
        self.sent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn network(&self) -> &dyn Network {
        let network = self.network.as_ref();
        &**network.expect("a rank that is alone sends nothing")
    }

    fn send(&self, to: usize, bytes: &[u8]) {
        let mut log = self.log();
        let what = log.what.clone();
        let [messages, n_bytes] = log.sent.entry(what).or_default();
        *messages += 1;
        *n_bytes += bytes.len() as u64;
        drop(log);
        self.network().send(to, bytes);
    }

    fn receive(&self, from: usize) -> Vec<u8> {
        self.network().receive(from)
    }

    /// Sends the value of rank 0 to all ranks: down a tree, so that no rank sends more than `log2 n` times.
    pub fn broadcast<T: Serialize + DeserializeOwned>(&self, of_first: Option<T>) -> T {
        if self.n() == 1 {
            return of_first.expect("rank 0 has it");
        }
        let (rank, n) = (self.rank(), self.n());
        let bytes = match &of_first {
            Some(value) if rank == 0 => pack(value),
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
        of_first.unwrap_or_else(|| unpack(&bytes))
    }

    /// Collects the values of all ranks, in their order, on rank 0 only: up the tree of [`broadcast`](Self::broadcast).
    pub fn gather<T: Serialize + DeserializeOwned>(&self, own: T) -> Option<Vec<T>> {
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

    /// Collects the values of all ranks, in their order, on all ranks. For small values: the result grows with the
    /// number of ranks.
    pub fn allgather<T: Serialize + DeserializeOwned>(&self, own: T) -> Vec<T> {
        match self.n() {
            1 => vec![own],
            _ => {
                let gathered = self.gather(own);
                self.broadcast(gathered)
            }
        }
    }

    /// Adds up over all ranks in their order: rank 0 begins with `start`, and `append` adds a rank's value to the sum of the
    /// previous ranks. The sum passes from rank to rank, so it has the same order as in one process.
    pub fn ordered_fold<T, P>(&self, start: T, own: P, append: impl Fn(&mut T, P)) -> T
    where
        T: Serialize + DeserializeOwned,
        P: Serialize + DeserializeOwned,
    {
        let (rank, n) = (self.rank(), self.n());
        let mut sum = match rank {
            0 => start,
            _ => unpack(&self.receive(rank - 1)),
        };
        append(&mut sum, own);
        if n == 1 {
            return sum;
        }
        // The last rank has the sum of all; rank 0 passes it on.
        if rank + 1 < n {
            self.send(rank + 1, &pack(&sum))
        } else {
            self.send(0, &pack(&sum))
        }
        let whole = (rank == 0).then(|| unpack(&self.receive(n - 1)));
        self.broadcast(whole)
    }

    /// Sends each rank its value from rank 0, one rank after the other; `for_rank` is called there only.
    ///
    /// # Panics
    /// If rank 0 has no value for a rank.
    pub fn scatter<T: Serialize + DeserializeOwned>(
        &self,
        for_rank: &mut dyn FnMut(usize) -> Option<T>,
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

    /// Sends each rank its numbers from rank 0; `for_rank` is called there only. `own` receives them.
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

    /// Sends the numbers of this rank to rank 0, which receives them by [`receive_parts`](Self::receive_parts).
    pub fn send_part<T: Pod>(&self, own: &[T]) {
        self.send(0, bytemuck::cast_slice(own));
    }

    /// Receives the numbers of each other rank on rank 0; `parts` has the length of the numbers of each rank.
    pub fn receive_parts<T: Pod>(&self, parts: &mut [&mut [T]]) {
        for (rank, part) in parts.iter_mut().enumerate().skip(1) {
            let bytes = bytemuck::cast_slice_mut(part);
            self.network().receive_into(rank, bytes);
        }
    }

    /// Returns each rank's own value if all succeeded; else the error of the first that failed, on all ranks.
    ///
    /// # Errors
    /// If any rank failed.
    pub fn all_ok<T>(&self, made: Result<T>) -> Result<T> {
        if self.n() == 1 {
            return made;
        }
        let (made, error) = match made {
            Ok(made) => (Some(made), None),
            Err(error) => (None, Some(error)),
        };
        match self.allgather(error).into_iter().flatten().next() {
            Some(error) => Err(error),
            None => Ok(made.expect("no rank failed")),
        }
    }
}

/// The bytes of a value. They are counted first: a list that grows clears, fills and copies much more memory.
fn pack<T: Serialize>(value: &T) -> Vec<u8> {
    const PACKED: &str = "what ranks send each other can be packed";
    let n_bytes = postcard::experimental::serialized_size(value).expect(PACKED);
    postcard::to_extend(value, Vec::with_capacity(n_bytes)).expect(PACKED)
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
                let all = ranks.allgather(10 * ranks.rank());
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
                let add = |sum: &mut f64, own: Vec<f64>| own.iter().for_each(|part| *sum += part);
                ranks.ordered_fold(0.0, own.to_vec(), add)
            });
            assert!(sums.iter().all(|found| found.to_bits() == sum.to_bits()));
        }
    }

    #[test]
    fn numbers_go_from_the_first_rank_and_back_and_are_counted() {
        let found = on_threads(4, |ranks| {
            let lengths = [1, 2, 3, 4];
            let own = lengths[ranks.rank()];
            let mut numbers = vec![0u32; own];
            ranks.set_label("there");
            let fill = |rank: usize, numbers: &mut [u32]| numbers.fill(rank as u32);
            ranks.scatter_into(&fill, &mut numbers, &lengths);
            assert_eq!(numbers, vec![ranks.rank() as u32; own]);
            ranks.set_label("back");
            let mut all = [0u32; 10];
            if ranks.is_first() {
                let (first, rest) = all.split_at_mut(1);
                let (second, rest) = rest.split_at_mut(2);
                let (third, fourth) = rest.split_at_mut(3);
                ranks.receive_parts(&mut [first, second, third, fourth]);
            } else {
                ranks.send_part(&numbers);
            }
            (all, ranks.sent_by_all())
        });
        assert_eq!(found[0].0, [0, 1, 1, 2, 2, 2, 3, 3, 3, 3]);
        let sent = |what: &str, most: u64| Sent {
            what: what.to_owned(),
            messages: 3,
            bytes: 36,
            most,
        };
        for (_, found) in found {
            assert_eq!(found, [sent("back", 16), sent("there", 36)]);
        }
    }

    #[test]
    fn the_first_rank_that_fails_gives_the_error_of_all() {
        let found = on_threads(4, |ranks| {
            ranks.all_ok(match ranks.rank() {
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
        let fine = on_threads(3, |ranks| ranks.all_ok(Ok(ranks.rank())));
        let fine: Vec<usize> = fine
            .into_iter()
            .map(|of| of.expect("none failed"))
            .collect();
        assert_eq!(fine, [0, 1, 2]);
    }
}

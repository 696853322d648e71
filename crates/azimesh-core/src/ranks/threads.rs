//! Ranks as threads of one process, for tests. A message waits until it is received, as MPI may do.

use super::{Network, Ranks};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Mutex, PoisonError};

struct Channels {
    rank: usize,
    to: Vec<Mutex<SyncSender<Vec<u8>>>>,
    from: Vec<Mutex<Receiver<Vec<u8>>>>,
}

impl Network for Channels {
    fn rank(&self) -> usize {
        self.rank
    }

    fn n_ranks(&self) -> usize {
        self.to.len()
    }

    fn send(&self, to: usize, bytes: &[u8]) {
        let sender = self.to[to].lock().unwrap_or_else(PoisonError::into_inner);
        // A rank that has panicked receives nothing more.
        let _ = sender.send(bytes.to_vec());
    }

    fn receive(&self, from: usize) -> Vec<u8> {
        let receiver = self.from[from].lock();
        let receiver = receiver.unwrap_or_else(PoisonError::into_inner);
        receiver.recv().expect("the other rank is there")
    }

    fn receive_into(&self, from: usize, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.receive(from));
    }
}

/// Runs `work` on each of `n` ranks, each a thread, and returns the results in their order.
///
/// # Panics
/// If one of them does.
pub fn on_threads<T: Send>(n: usize, work: impl Fn(Ranks) -> T + Sync) -> Vec<T> {
    let mut senders: Vec<Vec<_>> = (0..n).map(|_| Vec::new()).collect();
    let mut receivers: Vec<Vec<_>> = (0..n).map(|_| Vec::new()).collect();
    for from in 0..n {
        for to in &mut receivers {
            let (sender, receiver) = sync_channel(0);
            senders[from].push(Mutex::new(sender));
            to.push(Mutex::new(receiver));
        }
    }
    let ends = senders.into_iter().zip(receivers).enumerate();
    std::thread::scope(|scope| {
        let work = &work;
        let started = ends.map(|(rank, (to, from))| {
            scope.spawn(move || work(Ranks::new(Channels { rank, to, from })))
        });
        let started: Vec<_> = started.collect();
        let ended = started.into_iter().map(|thread| thread.join());
        ended.map(|end| end.expect("no rank panics")).collect()
    })
}

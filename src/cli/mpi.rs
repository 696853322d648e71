//! Ranks as MPI starts them, by the MPI of the system.

use azimesh_core::ranks::{Network, Ranks};
use azimesh_core::{Error, Result};
use mpi::Threading;
use mpi::collective::Root;
use mpi::environment::Universe;
use mpi::point_to_point::{Destination, Source};
use mpi::topology::{Communicator, Process, SimpleCommunicator};
use std::time::{Duration, Instant};

/// Variables that launchers set for the processes that they start: Open MPI, PMIx, MPICH and others with PMI.
const LAUNCHED: [&str; 4] = ["OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_SIZE", "PMI_RANK"];
/// Exit code of a Rust program that panics.
const PANICKED: i32 = 101;
/// Largest message in bytes: MPI counts to 2^31. Longer messages are sent in pieces; only the last piece is shorter.
const PIECE: usize = 1 << 30;
/// Time during which a rank polls for a message without pause: an answer to its own message arrives within that.
const SOON: Duration = Duration::from_micros(200);
/// Pause between polls after that. Longer waits have longer pauses, about a sixteenth of the waiting time. Waiting leaves the
/// processor to other ranks of the machine.
const NAP: Duration = Duration::from_micros(100);
const LONGEST_NAP: Duration = Duration::from_millis(5);

/// MPI while it is in use. Dropping it waits for all ranks, except if this rank panics: then it ends all ranks.
pub struct Session {
    _universe: Universe,
    ranks: Ranks,
    n_on_node: usize,
}

impl Drop for Session {
    fn drop(&mut self) {
        if std::thread::panicking() {
            SimpleCommunicator::world().abort(PANICKED);
        }
    }
}

impl Session {
    /// This rank.
    pub fn ranks(&self) -> &Ranks {
        &self.ranks
    }

    /// Ranks that share this machine.
    pub fn n_on_node(&self) -> usize {
        self.n_on_node
    }
}

/// Joins the other ranks if a launcher of MPI has started this process.
///
/// # Errors
/// If MPI cannot be started, or accepts calls from one thread only.
pub fn start() -> Result<Option<Session>> {
    if LAUNCHED.iter().all(|name| std::env::var_os(name).is_none()) {
        return Ok(None);
    }
    // Only one thread calls at a time, any of them.
    let started = mpi::initialize_with_threading(Threading::Serialized);
    let (universe, threading) =
        started.ok_or_else(|| Error::system("MPI is under way already, or cannot be started"))?;
    if threading < Threading::Serialized {
        return Err(Error::system(
            "this MPI takes calls from one thread only; build azimesh with one that allows MPI_THREAD_SERIALIZED",
        ));
    }
    let world = universe.world();
    let node = world.split_shared(world.rank());
    let mut first_on_node = world.rank();
    node.process_at_rank(0).broadcast_into(&mut first_on_node);
    Ok(Some(Session {
        n_on_node: node.size() as usize,
        ranks: match world.size() {
            1 => Ranks::alone(),
            n => Ranks::new(World {
                rank: world.rank() as usize,
                n_ranks: n as usize,
                is_on_first_machine: first_on_node == 0,
            }),
        },
        _universe: universe,
    }))
}

/// All ranks. The communicator is not stored: it may not be passed to another thread.
struct World {
    rank: usize,
    n_ranks: usize,
    is_on_first_machine: bool,
}

/// The pieces of a message: all but the last have `PIECE` bytes, the last has fewer.
fn pieces(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let n = bytes.len() / PIECE;
    (0..=n).map(move |i| &bytes[i * PIECE..bytes.len().min((i + 1) * PIECE)])
}

/// Waits for a message.
fn wait_for(from: &Process<'_>) {
    let start = Instant::now();
    while from.immediate_probe().is_none() {
        let waited = start.elapsed();
        if waited > SOON {
            std::thread::sleep((waited / 16).clamp(NAP, LONGEST_NAP));
        }
    }
}

impl Network for World {
    fn rank(&self) -> usize {
        self.rank
    }

    fn n_ranks(&self) -> usize {
        self.n_ranks
    }

    fn is_on_first_machine(&self) -> bool {
        self.is_on_first_machine
    }

    fn send(&self, to: usize, bytes: &[u8]) {
        let world = SimpleCommunicator::world();
        let to = world.process_at_rank(to as i32);
        pieces(bytes).for_each(|piece| to.send(piece));
    }

    fn receive(&self, from: usize) -> Vec<u8> {
        let world = SimpleCommunicator::world();
        let from = world.process_at_rank(from as i32);
        wait_for(&from);
        let (mut all, _) = from.receive_vec::<u8>();
        let mut last = all.len();
        while last == PIECE {
            let (piece, _) = from.receive_vec::<u8>();
            last = piece.len();
            all.extend(piece);
        }
        all
    }

    fn receive_into(&self, from: usize, bytes: &mut [u8]) {
        let world = SimpleCommunicator::world();
        let from = world.process_at_rank(from as i32);
        wait_for(&from);
        let n = bytes.len() / PIECE;
        let (whole, last) = bytes.split_at_mut(n * PIECE);
        for piece in whole.chunks_exact_mut(PIECE) {
            from.receive_into(piece);
        }
        from.receive_into(last);
    }
}

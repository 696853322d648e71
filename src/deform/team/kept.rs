//! Positions that stay with the ranks, which write them: the first rank knows those of few nodes.
//!
//! A rank has its own nodes. At a step by fields it tells the first rank where some of them are, and is told where those are that it does not place itself. Once the step is kept, the next may begin while it is written.

use super::order::Order;
use super::work::{Work, among};
use super::{SharedFields, State, Team};
use crate::error::{Error, Result};
use crate::geometry::vector::Vector;
use crate::mesh::{Numbers, PointsApart, check_in_32_bits, node_slab};
use crate::ranks::Ranks;
use crate::ranks::hash::{HashedBytes, PartHasher};
use crate::ranks::raw::List;
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// Nodes whose numbers are made and written at a time.
const NODES: usize = 1 << 14;

/// Numbers that ranks are to write.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct WriteTask {
    /// The file, and where in it the numbers of all ranks begin; none where they are only hashed.
    to: Option<(PathBuf, u64)>,
    numbers: Numbers,
    /// The same place among the bytes that are hashed.
    hash_from: u64,
    /// Whether they are synced to the disk.
    sync: bool,
}

/// Positions of a step that a rank writes, and what it has written.
#[derive(Default)]
pub(super) struct Kept {
    points: Vec<Vector>,
    /// Files that are being synced to the disk.
    syncing: Vec<JoinHandle<io::Result<()>>>,
}

/// The positions of a step, with the ranks.
#[derive(Clone)]
pub(crate) struct KeptPoints {
    team: Arc<Team>,
    sync: bool,
}

impl Team {
    /// Has each rank keep its own nodes, of `n_nodes` that all deform. The first rank is told of some at every step, which are
    /// ascending.
    pub fn divide(&self, n_nodes: usize, told: Vec<u32>) {
        let mut state = self.state();
        self.order(Order::Divide);
        state.work.wanted = share_wanted(Some((n_nodes, &told)), &self.ranks);
        state.told = told;
    }

    /// Gives all positions of the step that the ranks have moved to last, which are known in part.
    pub fn collect(&self, points: &mut [Vector]) {
        let mut state = self.state();
        self.place_own(&mut state, points);
        self.order(Order::Collect);
        let mut parts = split(points, self.ranks.n());
        parts[0].copy_from_slice(state.work.own_places());
        self.ranks.receive_parts(&mut parts);
    }

    /// Has the ranks keep the positions of the step that they have moved to last, until they are written; with `sync` to the
    /// disk.
    pub fn keep(self: &Arc<Self>, points: &[Vector], sync: bool) -> KeptPoints {
        let mut state = self.state();
        self.place_own(&mut state, points);
        self.order(Order::Keep);
        state.work.keep();
        KeptPoints {
            team: Arc::clone(self),
            sync,
        }
    }

    /// Tells ranks where nodes are that they do not place, if they were not told of this step.
    fn place_own(&self, state: &mut State, points: &[Vector]) {
        if !state.is_told {
            self.tell_places(state, points);
        }
    }
}

/// Which of its own nodes each rank is to tell of: of `n_nodes` some, ascending, which the first rank knows.
pub(super) fn share_wanted(of_first: Option<(usize, &[u32])>, ranks: &Ranks) -> Vec<u32> {
    let n_ranks = ranks.n();
    let List(wanted) = ranks.scatter(&mut |rank| {
        let (n_nodes, wanted) = of_first?;
        let slab = node_slab(n_nodes, rank, n_ranks);
        let wanted = among(wanted, &slab).iter();
        Some(List(
            wanted
                .map(|node| node - slab.start as u32)
                .collect::<Vec<_>>(),
        ))
    });
    wanted
}

impl SharedFields {
    /// Moves all nodes to a step, and writes to `out` where those are of which this rank is told.
    pub fn move_apart(&self, step: usize, out: &mut [Vector]) {
        let (team, mut state) = (&self.team, self.team.state());
        team.order(Order::Move {
            id: self.id,
            step,
            from_zero: false,
            stays: true,
        });
        state.moves();
        let n_ranks = team.ranks.n();
        let slab = |rank| node_slab(out.len(), rank, n_ranks);
        let State { work, told, .. } = &mut *state;
        let mut places = vec![[0.0; 3]; told.len()];
        let mut rest = &mut places[..];
        let mut parts = Vec::new();
        for rank in 0..n_ranks {
            let (part, others) = rest.split_at_mut(among(told, &slab(rank)).len());
            parts.push(part);
            rest = others;
        }
        let own = &mut parts[0];
        let take = |told: &[Vector]| own.copy_from_slice(told);
        team.ranks
            .together(|| work.move_to((self.id, step, false), true, take));
        team.ranks.receive_parts(&mut parts);
        for (&node, place) in told.iter().zip(places) {
            out[node as usize] = place;
        }
    }
}

impl KeptPoints {
    /// Waits until all that ranks have written is on the disk.
    pub fn settle(&self) -> Result<()> {
        if !self.sync {
            return Ok(());
        }
        let mut state = self.team.state();
        self.team.order(Order::Settle);
        let settled = state.work.settle(&self.team.ranks);
        self.team.ranks.agree(settled)
    }
}

impl std::fmt::Debug for KeptPoints {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "positions with {} ranks", self.team.ranks.n())
    }
}

impl PointsApart for KeptPoints {
    fn write(
        &self,
        to: Option<(&Path, u64)>,
        numbers: Numbers,
        hash_from: u64,
    ) -> Result<Vec<HashedBytes>> {
        let absolute = |(path, at): (&Path, u64)| {
            let path = std::path::absolute(path).map_err(|error| Error::io(path, &error))?;
            Ok::<_, Error>((path, at))
        };
        let task = WriteTask {
            to: to.map(absolute).transpose()?,
            numbers,
            hash_from,
            sync: self.sync,
        };
        // No other thread may be needed here: it may wait for the team.
        let mut state = self.team.state();
        let Order::Write(task) = self.team.order(Order::Write(task)) else {
            unreachable!("a broadcast gives what it got")
        };
        let told = state.work.write(&task, &self.team.ranks);
        let all = self.team.ranks.gather(told);
        all.unwrap_or_default().into_iter().collect()
    }
}

impl Work {
    /// Where the own nodes are.
    pub fn own_places(&self) -> &[Vector] {
        &self.nodes.places[self.own()]
    }

    /// Keeps positions until they are written.
    pub fn keep(&mut self) {
        let mut kept = std::mem::take(&mut self.kept.points);
        kept.clear();
        kept.extend_from_slice(self.own_places());
        self.kept.points = kept;
    }

    /// Writes numbers of the own nodes.
    pub fn write(&mut self, task: &WriteTask, ranks: &Ranks) -> Result<HashedBytes> {
        let size = task.numbers.size();
        let (start, n) = (self.first_own() * size, self.kept.points.len() * size);
        let mut hasher = PartHasher::new(task.hash_from + start as u64, n as u64);
        let failed = |error: io::Error| of_rank(ranks, &error);
        let mut file = match &task.to {
            Some((path, at)) => Some(file_at(path, at + start as u64).map_err(failed)?),
            None => None,
        };
        let mut bytes = Vec::new();
        for (i, nodes) in self.kept.points.chunks(NODES).enumerate() {
            if task.numbers.is_single {
                check_in_32_bits(nodes, self.first_own() + i * NODES)?;
            }
            bytes.clear();
            task.numbers.append(nodes, &mut bytes);
            hasher.update(&bytes);
            if let Some(file) = &mut file {
                file.write_all(&bytes).map_err(failed)?;
            }
        }
        // The first rank syncs the file once it is whole.
        if let Some(file) = file.filter(|_| task.sync && !ranks.is_first()) {
            let thread = thread::Builder::new().name("disk".to_owned());
            let sync = thread.spawn(move || file.sync_data());
            self.kept.syncing.push(sync.map_err(failed)?);
        }
        Ok(hasher.finish())
    }

    /// Waits until what was written is on the disk.
    pub fn settle(&mut self, ranks: &Ranks) -> Result<()> {
        for thread in self.kept.syncing.drain(..) {
            let synced = thread
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            synced.map_err(|error| of_rank(ranks, &error))?;
        }
        Ok(())
    }
}

fn file_at(path: &Path, at: u64) -> io::Result<File> {
    let mut file = OpenOptions::new().write(true).open(path)?;
    file.seek(SeekFrom::Start(at))?;
    Ok(file)
}

/// A failure of a rank; the first rank knows the name of the file.
fn of_rank(ranks: &Ranks, error: &io::Error) -> Error {
    let why = match error.kind() {
        io::ErrorKind::NotFound => "it does not see the folder; all ranks write their nodes, so it has to be on a disk that all machines share".to_owned(),
        _ => error.to_string(),
    };
    Error::system(format!("rank {}: {why}", ranks.rank()))
}

/// Positions of all nodes, by the ranks that they belong to.
pub(super) fn split(points: &mut [Vector], n_ranks: usize) -> Vec<&mut [Vector]> {
    let n = points.len();
    let mut rest = points;
    let mut parts = Vec::new();
    for rank in 0..n_ranks {
        let (part, others) = rest.split_at_mut(node_slab(n, rank, n_ranks).len());
        parts.push(part);
        rest = others;
    }
    parts
}

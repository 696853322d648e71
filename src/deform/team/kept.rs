//! Positions, and velocities, that stay with the ranks, which write them: the first rank knows those of few nodes.
//!
//! A rank has its own nodes. At a step by fields it tells the first rank where some of them are, and is told where those are that it does not place itself. Once the step is kept, the next may begin while it is written.

use super::order::Order;
use super::work::Work;
use super::{SharedFields, State, Team};
use crate::deform::numbers_file::NumbersFile;
use crate::error::{Error, Result};
use crate::formats::list_nodes;
use crate::geometry::vector::{Vector, sub};
use crate::mesh::{
    Apart, CellSet, Mesh, NodesOfCells, Numbers, Slots, ZoneSides, among, node_slab,
};
use crate::parallel;
use crate::ranks::Ranks;
use crate::ranks::hash::HashedBytes;
use crate::ranks::raw::List;
use serde::{Deserialize, Serialize};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// Numbers that ranks are to write.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct WriteTask {
    /// The file, and where in it the numbers of all ranks begin; none where they are only hashed.
    to: Option<(PathBuf, u64)>,
    numbers: Numbers,
    /// Whether coordinates are those of the reference mesh; else those that are kept.
    at_rest: bool,
    /// The same place among the bytes that are hashed.
    hash_from: u64,
    /// Whether they are synced to the disk.
    sync: bool,
}

/// Positions of a step that a rank writes, and what it has written.
#[derive(Default)]
pub(super) struct Kept {
    points: Vec<Vector>,
    /// Velocities of the nodes, where they are asked for.
    velocities: Vec<Vector>,
    /// Files that are being synced to the disk.
    syncing: Vec<JoinHandle<io::Result<()>>>,
}

/// The positions of a step, with the ranks.
#[derive(Clone)]
pub(crate) struct KeptPoints {
    team: Arc<Team>,
}

impl Team {
    /// Has each rank keep its own nodes of a mesh. The first rank is told of some at every step, which are ascending.
    pub(crate) fn divide(&self, mesh: &Mesh, told: Vec<u32>) {
        let n_nodes = mesh.points.len();
        let mut state = self.state();
        state.known = match mesh.slots() {
            Slots::All => None,
            Slots::Known(known) => Some(Arc::clone(known)),
        };
        self.order(Order::Divide);
        state.work.wanted = share_wanted(Some((n_nodes, &told)), &self.ranks);
        state.told = told;
    }

    /// Gives all positions of the step that the ranks have moved to last, which are known in part.
    pub(crate) fn collect(&self, points: &mut [Vector]) {
        let mut state = self.state();
        self.place_own(&mut state, points);
        self.order(Order::Collect);
        let mut parts = split(points, self.ranks.n());
        parts[0].copy_from_slice(state.work.own_places());
        self.ranks.receive_parts(&mut parts);
        state.are_apart = false;
    }

    /// Has the ranks keep the positions of the step that they have moved to last, until they are written.
    pub(crate) fn keep(self: &Arc<Self>, points: &[Vector]) -> KeptPoints {
        let mut state = self.state();
        self.place_own(&mut state, points);
        self.order(Order::Keep);
        state.work.keep();
        KeptPoints {
            team: Arc::clone(self),
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
    /// Moves all nodes to a step, and writes to `out`, in the slots of the mesh, where those are of which this rank is told; with
    /// `from_zero` nothing moves, and what is written are velocities.
    pub fn move_apart(&self, step: usize, from_zero: bool, out: &mut [Vector]) {
        let (team, mut state) = (&self.team, self.team.state());
        team.order(Order::Move {
            id: self.id,
            step,
            from_zero,
            stays: true,
        });
        if !from_zero {
            state.moves();
            state.are_apart = true;
        }
        let n_ranks = team.ranks.n();
        let State { work, told, .. } = &mut *state;
        let mut places = vec![[0.0; 3]; told.len()];
        let mut parts = split_at(&mut places, told, (out.len(), n_ranks));
        let own = &mut parts[0];
        let take = |told: &[Vector]| own.copy_from_slice(told);
        team.ranks
            .together(|| work.move_to((self.id, step, from_zero), true, take));
        team.ranks.receive_parts(&mut parts);
        for (&node, place) in state.told.iter().zip(places) {
            out[state.slots().of(node)] = place;
        }
    }
}

impl std::fmt::Debug for KeptPoints {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "positions with {} ranks", self.team.ranks.n())
    }
}

impl Apart for KeptPoints {
    fn write(
        &self,
        to: Option<(&Path, u64)>,
        numbers: &Numbers,
        hash_from: u64,
    ) -> Result<Vec<HashedBytes>> {
        self.team.write(to, numbers, hash_from, false)
    }
}

/// The reference mesh.
impl Apart for Team {
    fn write(
        &self,
        to: Option<(&Path, u64)>,
        numbers: &Numbers,
        hash_from: u64,
    ) -> Result<Vec<HashedBytes>> {
        self.write(to, numbers, hash_from, true)
    }

    fn zone_sides(&self, marked: &CellSet) -> Result<ZoneSides> {
        // The first rank reads the file for that piece by piece, alone.
        let file = self.file.as_ref().expect("ranks have read it by parts");
        file.by_pieces(|slabs, _| slabs.zone_sides(marked))
    }
}

impl std::fmt::Debug for Team {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "a mesh with {} ranks", self.ranks.n())
    }
}

impl Team {
    /// Whether all that ranks write has to be on the disk once the team has [settled](Self::settle).
    pub(crate) fn set_sync(&self, syncs: bool) {
        self.state().syncs = syncs;
    }

    /// Waits until all that ranks have written is on the disk.
    pub(crate) fn settle(&self) -> Result<()> {
        let mut state = self.state();
        if !state.syncs {
            return Ok(());
        }
        self.order(Order::Settle);
        let settled = state.work.settle(&self.ranks);
        self.ranks.agree(settled)
    }

    fn write(
        &self,
        to: Option<(&Path, u64)>,
        numbers: &Numbers,
        hash_from: u64,
        at_rest: bool,
    ) -> Result<Vec<HashedBytes>> {
        let absolute = |(path, at): (&Path, u64)| {
            let path = std::path::absolute(path).map_err(|error| Error::io(path, &error))?;
            Ok::<_, Error>((path, at))
        };
        let to = to.map(absolute).transpose()?;
        // No other thread may be needed here: it may wait for the team.
        let mut state = self.state();
        let task = WriteTask {
            to,
            numbers: numbers.clone(),
            at_rest,
            hash_from,
            sync: state.syncs,
        };
        self.order(Order::Write(task.clone()));
        let told = state.work.write(&task, &self.ranks);
        let all = self.ranks.gather(told);
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
        self.kept.velocities = self.take_own_velocities();
    }

    /// Writes numbers of the own nodes or of the own cells.
    pub fn write(&mut self, task: &WriteTask, ranks: &Ranks) -> Result<HashedBytes> {
        let failed = |error: io::Error| of_rank(ranks, &error);
        let (start, n_bytes) = self.place_in_file(&task.numbers, task.at_rest, ranks);
        let to = task.to.as_ref().map(|(path, at)| (&**path, at + start));
        let mut out = NumbersFile::new(to, task.hash_from + start, &failed)?;
        let (places, first) = (self.written_points(task.at_rest), self.first_own());
        match &task.numbers {
            Numbers::Coordinates(numbers) => out.points(places, first, *numbers)?,
            Numbers::Displacements(numbers) => {
                let rest = self.own_rest();
                let moved = parallel::collect(places.len(), |i| sub(places[i], rest[i]));
                out.points(&moved, first, *numbers)?;
            }
            Numbers::Velocities(numbers) => out.points(&self.kept.velocities, first, *numbers)?,
            Numbers::Nodes(wanted) => out.piece(n_bytes as usize, |take| {
                write_nodes(self.cells_to_write(), wanted, take)
            })?,
        }
        let (told, file) = out.finish();
        // The first rank syncs the file once it is whole.
        if let Some(file) = file.filter(|_| task.sync && !ranks.is_first()) {
            let thread = thread::Builder::new().name("disk".to_owned());
            let sync = thread.spawn(move || file.sync_data());
            self.kept.syncing.push(sync.map_err(failed)?);
        }
        Ok(told.into_iter().next().expect("it is one piece"))
    }

    /// Where the numbers of this rank begin among those of all, in bytes, and how many bytes they are.
    fn place_in_file(&self, numbers: &Numbers, at_rest: bool, ranks: &Ranks) -> (u64, u64) {
        match numbers {
            Numbers::Coordinates(numbers)
            | Numbers::Displacements(numbers)
            | Numbers::Velocities(numbers) => {
                let n = self.written_points(at_rest).len();
                let bytes = |n: usize| (n * numbers.size()) as u64;
                (bytes(self.first_own()), bytes(n))
            }
            Numbers::Nodes(wanted) => {
                let mesh = self.cells_to_write();
                let here = cells_here(mesh, wanted);
                let n = (wanted.n_numbers(&mesh.cells, here) * wanted.size()) as u64;
                let of_ranks = ranks.all(n);
                (of_ranks[..ranks.rank()].iter().sum(), n)
            }
        }
    }

    /// Where the own nodes are that are written.
    fn written_points(&self, at_rest: bool) -> &[Vector] {
        match at_rest {
            true => self.own_rest(),
            false => &self.kept.points,
        }
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

/// Which of the cells of a part are own ones among those that are written.
fn cells_here(mesh: &Mesh, wanted: &NodesOfCells) -> Range<usize> {
    let (own, before) = (mesh.own_cells(), mesh.own_offset());
    let place = |cell: usize| cell.saturating_sub(before).clamp(own.start, own.end);
    place(wanted.cells.start)..place(wanted.cells.end)
}

fn write_nodes(
    mesh: &Mesh,
    wanted: &NodesOfCells,
    take: &mut dyn FnMut(&[u8]) -> Result<()>,
) -> Result<()> {
    let part = mesh
        .part
        .as_ref()
        .expect("a rank writes the cells of its part");
    let number = |node: u32| part.nodes[node as usize];
    list_nodes(&mesh.cells, cells_here(mesh, wanted), wanted, &number, take)
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
    cut(
        points,
        (0..n_ranks).map(|rank| node_slab(n, rank, n_ranks).len()),
    )
}

/// Positions at some nodes of `n_nodes`, ascending, by the ranks that these belong to.
pub(super) fn split_at<'a>(
    points: &'a mut [Vector],
    nodes: &[u32],
    (n_nodes, n_ranks): (usize, usize),
) -> Vec<&'a mut [Vector]> {
    let of_rank = |rank| among(nodes, &node_slab(n_nodes, rank, n_ranks)).len();
    cut(points, (0..n_ranks).map(of_rank))
}

pub(super) fn cut(
    points: &mut [Vector],
    lengths: impl Iterator<Item = usize>,
) -> Vec<&mut [Vector]> {
    let mut rest = points;
    let mut parts = Vec::new();
    for n in lengths {
        let (part, others) = rest.split_at_mut(n);
        parts.push(part);
        rest = others;
    }
    parts
}

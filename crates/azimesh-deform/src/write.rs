//! Values of nodes and cells that every rank writes into one file. The first rank writes the rest of the file, and
//! announces where the values begin.

use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, sub};
use azimesh_core::parallel;
use azimesh_core::ranks::Ranks;
use azimesh_core::ranks::hash::{HashedBytes, PartHasher};
use azimesh_io::formats::list_nodes;
use azimesh_io::mesh::{Apart, Coordinates, Mesh, NodesOfCells, Numbers, check_in_32_bits};
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Number of nodes whose values are computed and written together.
const NODES: usize = 1 << 14;

/// The part of a mesh that a rank writes, and the values at its nodes.
#[derive(Debug, Clone, Copy)]
pub struct OwnValues<'a> {
    /// The part.
    pub mesh: &'a Mesh,
    /// Positions of the nodes.
    pub points: &'a [Vector],
    /// Velocities of the nodes; empty if they are not written.
    pub velocities: &'a [Vector],
}

/// Ranks that write nothing: for a file that is not written.
#[derive(Debug)]
pub(crate) struct Nowhere;

impl Apart for Nowhere {
    fn write(&self, _: Option<(&Path, u64)>, _: &Numbers, _: u64) -> Result<Vec<HashedBytes>> {
        Ok(Vec::new())
    }
}

/// The values that every rank writes.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct WriteTask {
    /// The file, and the byte where the values of all ranks begin; `None` if they are only hashed.
    to: Option<(PathBuf, u64)>,
    numbers: Numbers,
    /// The same byte in the hashed stream.
    hash_from: u64,
}

/// The values of all ranks, as the first rank passes them to a format.
#[derive(Debug)]
struct RankWriter<'a> {
    own: OwnValues<'a>,
    ranks: Ranks,
    /// True if this rank syncs its values to the disk. The first rank syncs all of the file that its machine has written.
    sync: bool,
}

/// A function that writes a file, given the ranks that write their values into it.
type WriteFile<'a, T> = dyn FnMut(&dyn Apart) -> Result<T> + 'a;

/// Writes a file by all ranks. `write` does so on the first rank and receives the values of all ranks; it is `None` on the
/// others. With `sync` the values of the other ranks are on the disk before `write` continues. All ranks call it; the result
/// is on the first.
///
/// # Errors
/// On the first rank the error of `write`.
pub fn write_together<T>(
    own: OwnValues<'_>,
    sync: bool,
    write: Option<&mut WriteFile<'_, T>>,
) -> Result<Option<T>> {
    let ranks = own.mesh.ranks();
    let by = RankWriter {
        own,
        ranks: ranks.clone(),
        sync: sync && !ranks.is_on_first_machine(),
    };
    if let Some(write) = write {
        let written = write(&by);
        ranks.broadcast(Some(None::<WriteTask>));
        return written.map(Some);
    }
    while let Some(task) = ranks.broadcast::<Option<WriteTask>>(None) {
        ranks.gather(by.write_own(&task));
    }
    Ok(None)
}

impl Apart for RankWriter<'_> {
    fn write(
        &self,
        to: Option<(&Path, u64)>,
        numbers: &Numbers,
        hash_from: u64,
    ) -> Result<Vec<HashedBytes>> {
        let absolute = |(path, at): (&Path, u64)| {
            let path = std::path::absolute(path).map_err(|error| Error::io(path, &error))?;
            Ok::<_, Error>((path, at))
        };
        let task = WriteTask {
            to: to.map(absolute).transpose()?,
            numbers: numbers.clone(),
            hash_from,
        };
        let task = self
            .ranks
            .broadcast(Some(Some(task)))
            .expect("it was given");
        let all = self.ranks.gather(self.write_own(&task));
        all.unwrap_or_default().into_iter().collect()
    }
}

impl RankWriter<'_> {
    /// Writes the values of this rank.
    fn write_own(&self, task: &WriteTask) -> Result<HashedBytes> {
        let (own, ranks) = (&self.own, &self.ranks);
        let nodes = own.mesh.own_nodes();
        let first = own.mesh.first_own_node();
        let bytes = |n: usize, numbers: &Coordinates| (n * numbers.size()) as u64;
        let (start, n_bytes) = match &task.numbers {
            Numbers::Coordinates(of) | Numbers::Displacements(of) | Numbers::Velocities(of) => {
                (bytes(first, of), bytes(nodes.len(), of))
            }
            Numbers::Nodes(wanted) => {
                let n = wanted.n_numbers(&own.mesh.cells, cells_here(own.mesh, wanted));
                let n = (n * wanted.size()) as u64;
                (ranks.allgather(n)[..ranks.rank()].iter().sum(), n)
            }
        };
        let failed = |error: io::Error| of_rank(ranks, &error);
        let open = |(path, at): &(PathBuf, u64)| file_at(path, at + start).map_err(failed);
        let mut file = task.to.as_ref().map(open).transpose()?;
        let mut hasher = PartHasher::new(task.hash_from + start, n_bytes);
        let mut take = |bytes: &[u8]| {
            hasher.update(bytes);
            match &mut file {
                Some(file) => file.write_all(bytes).map_err(failed),
                None => Ok(()),
            }
        };
        match &task.numbers {
            Numbers::Coordinates(of) => {
                write_vectors(&own.points[nodes], first, *of, &mut take)?;
            }
            Numbers::Displacements(of) => {
                let (points, rest) = (&own.points[nodes.clone()], &own.mesh.points[nodes]);
                let moved = parallel::collect(points.len(), |i| sub(points[i], rest[i]));
                write_vectors(&moved, first, *of, &mut take)?;
            }
            Numbers::Velocities(of) => {
                write_vectors(&own.velocities[nodes], first, *of, &mut take)?;
            }
            Numbers::Nodes(wanted) => {
                let mesh = own.mesh;
                let number = |node: u32| mesh.number_of_node(node);
                let here = cells_here(mesh, wanted);
                list_nodes(&mesh.cells, here, wanted, &number, &mut take)?;
            }
        }
        if let Some(file) = file.filter(|_| self.sync) {
            file.sync_data().map_err(failed)?;
        }
        Ok(hasher.finish())
    }
}

/// Returns the own cells of a rank among the written ones.
fn cells_here(mesh: &Mesh, wanted: &NodesOfCells) -> Range<usize> {
    let (own, before) = (mesh.own_cells(), mesh.own_offset());
    let place = |cell: usize| cell.saturating_sub(before).clamp(own.start, own.end);
    place(wanted.cells.start)..place(wanted.cells.end)
}

/// Passes on the bytes of vectors at nodes, starting at node `first`.
fn write_vectors(
    vectors: &[Vector],
    first: usize,
    numbers: Coordinates,
    take: &mut dyn FnMut(&[u8]) -> Result<()>,
) -> Result<()> {
    let mut bytes = Vec::new();
    for (i, nodes) in vectors.chunks(NODES).enumerate() {
        if numbers.is_single {
            check_in_32_bits(nodes, first + i * NODES)?;
        }
        bytes.clear();
        numbers.append(nodes, &mut bytes);
        take(&bytes)?;
    }
    Ok(())
}

/// Opens an existing file for writing from a byte on.
fn file_at(path: &Path, at: u64) -> io::Result<File> {
    let mut file = OpenOptions::new().write(true).open(path)?;
    file.seek(SeekFrom::Start(at))?;
    Ok(file)
}

/// Returns the failure of a rank; the first rank adds the name of the file.
fn of_rank(ranks: &Ranks, error: &io::Error) -> Error {
    let why = match error.kind() {
        io::ErrorKind::NotFound => "it does not see the folder; all ranks write their nodes, so it has to be on a disk that all machines share".to_owned(),
        _ => error.to_string(),
    };
    Error::system(format!("rank {}: {why}", ranks.rank()))
}

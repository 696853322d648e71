//! Numbers of nodes and cells on their way into a file that somebody else writes the rest of.

use crate::error::{Error, Result};
use crate::geometry::vector::Vector;
use crate::mesh::{Coordinates, check_in_32_bits};
use crate::ranks::hash::{HashedBytes, PartHasher};
use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

/// Nodes whose numbers are made and written at a time.
const NODES: usize = 1 << 14;

/// Takes numbers piece by piece: they are hashed, and written where they go to a file.
pub(super) struct NumbersFile<'a> {
    file: Option<File>,
    /// Tells what went wrong with it.
    failed: &'a dyn Fn(io::Error) -> Error,
    /// The number of the next byte among those that are hashed.
    at: u64,
    told: Vec<HashedBytes>,
}

impl<'a> NumbersFile<'a> {
    /// From a byte of a file on, or to none. `failed` tells what went wrong with the file, whose name the writer of the rest knows.
    pub fn new(
        to: Option<(&Path, u64)>,
        hash_from: u64,
        failed: &'a dyn Fn(io::Error) -> Error,
    ) -> Result<Self> {
        let file = to.map(|(path, at)| file_at(path, at)).transpose();
        Ok(Self {
            file: file.map_err(failed)?,
            failed,
            at: hash_from,
            told: Vec::new(),
        })
    }

    /// Takes a piece of so many bytes, which `make` passes on.
    pub fn piece(
        &mut self,
        n_bytes: usize,
        make: impl FnOnce(&mut dyn FnMut(&[u8]) -> Result<()>) -> Result<()>,
    ) -> Result<()> {
        let mut hasher = PartHasher::new(self.at, n_bytes as u64);
        let (file, failed) = (&mut self.file, self.failed);
        make(&mut |bytes| {
            hasher.update(bytes);
            match file {
                Some(file) => file.write_all(bytes).map_err(failed),
                None => Ok(()),
            }
        })?;
        self.told.push(hasher.finish());
        self.at += n_bytes as u64;
        Ok(())
    }

    /// Takes the coordinates of consecutive nodes, the first of which has this number.
    pub fn points(&mut self, points: &[Vector], first: usize, wanted: Coordinates) -> Result<()> {
        self.piece(points.len() * wanted.size(), |take| {
            write_points(points, first, wanted, take)
        })
    }

    /// What is told of all of it, and the file, which may not be on the disk yet.
    pub fn finish(self) -> (Vec<HashedBytes>, Option<File>) {
        (self.told, self.file)
    }
}

/// That the system refused something of the file.
pub(super) fn failed(error: io::Error) -> Error {
    Error::system(error.to_string())
}

/// Writes numbers of nodes, the first of which has this number.
fn write_points(
    points: &[Vector],
    first: usize,
    numbers: Coordinates,
    take: &mut dyn FnMut(&[u8]) -> Result<()>,
) -> Result<()> {
    let mut bytes = Vec::new();
    for (i, nodes) in points.chunks(NODES).enumerate() {
        if numbers.is_single {
            check_in_32_bits(nodes, first + i * NODES)?;
        }
        bytes.clear();
        numbers.append(nodes, &mut bytes);
        take(&bytes)?;
    }
    Ok(())
}

/// A file that is there, to be written from a byte on.
fn file_at(path: &Path, at: u64) -> io::Result<File> {
    let mut file = OpenOptions::new().write(true).open(path)?;
    file.seek(SeekFrom::Start(at))?;
    Ok(file)
}

//! Slabs of a mesh that are worked on one after another, or beside each other without a word, each by a process of its own; and the
//! run that joins them.
//!
//! ```text
//! one slab   has the outline of the mesh, moves the nodes of its slab and judges its cells at every step, and leaves where
//!            the nodes are and what its cells are like in a file
//! joining    has the outline too, reads where the nodes are, puts together what the slabs tell of their cells, and writes;
//!            it needs the whole mesh where steps have folded cells
//! ```
//!
//! Where an outline is not enough (other formats, plane meshes, arrays that are made), each has the whole mesh: its work is less then, its
//! memory is not.
//!
//! A slab does what a rank does ([`super::team`]), but finds out by itself what other ranks would tell it.

mod joined;
mod one;
mod stored;

use super::mesh_file::Outlined;
use super::sharing::Sharing;
pub use joined::Joined;
pub use one::OneSlab;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
pub(crate) use stored::{Left, StoredStep};

/// One of several slabs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SlabOf {
    /// Its number, from 0.
    pub number: usize,
    /// How many there are.
    pub n: usize,
}

impl fmt::Display for SlabOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number + 1, self.n)
    }
}

impl FromStr for SlabOf {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, n)| {
            Some((number.parse::<usize>().ok()?, n.parse::<usize>().ok()?))
        });
        match numbers {
            Some((number, n)) if (1..=n).contains(&number) => Ok(Self {
                number: number - 1,
                n,
            }),
            _ => Err(format!(
                "\"{text}\" is not a slab; write I/N, such as 1/9 for the first of nine"
            )),
        }
    }
}

impl SlabOf {
    /// All of as many.
    pub(crate) fn all(n: usize) -> impl Iterator<Item = Self> {
        (0..n).map(move |number| Self { number, n })
    }

    /// Its folder in that of the sequence.
    pub(crate) fn folder(&self, sequence: &Path) -> PathBuf {
        let name = format!("slab_{}", self.number + 1);
        sequence.join(format!("slabs_{}", self.n)).join(name)
    }

    /// How many slabs there are of the sequence in a folder, for each number of them of which there are some, ascending.
    pub(crate) fn numbers_in(sequence: &Path) -> Vec<usize> {
        let entries = std::fs::read_dir(sequence).into_iter().flatten().flatten();
        let number = |entry: std::fs::DirEntry| {
            let name = entry.file_name().into_string().ok()?;
            name.strip_prefix("slabs_")?.parse().ok()
        };
        let mut found: Vec<usize> = entries.filter_map(number).collect();
        found.sort_unstable();
        found
    }
}

impl Outlined {
    /// The work on one slab, which is read once there is a plan, where this is the outline. Values of arrays are of no use for it.
    pub fn one(&mut self, slab: SlabOf) -> Sharing {
        self.loaded.mesh.forget_arrays();
        Sharing::Slab(Arc::new(OneSlab::new(self.file.clone(), slab)))
    }

    /// The joining of so many slabs of the sequence in a folder.
    pub fn joined(&self, sequence: &Path, n: usize) -> Sharing {
        let joined = Joined::new(self.file.clone(), sequence, n);
        Sharing::Joined(Arc::new(joined))
    }
}

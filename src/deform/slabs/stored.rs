//! Files in which slabs leave steps.
//!
//! ```text
//! "azimesh slab 3\n", a zero byte
//! length of the head (8 bytes), the head (by postcard), its hash (32 bytes)
//! coordinates of the own nodes: three numbers of 64 bits each
//! velocities of the own nodes in the frame of the rotor, where they are asked for, likewise
//! ```
//!
//! Numbers are little-endian; hashes are BLAKE3. The head has the hashes of the coordinates and of the velocities.

use crate::error::{Error, Result};
use crate::formats::{Commit, OutputSet};
use crate::geometry::vector::Vector;
use crate::ranks::{Told, processor};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 16] = b"azimesh slab 3\n\0";
/// Bytes of a node.
const NODE: u64 = 24;
/// Bytes of a hash.
const HASH: u64 = 32;
/// Nodes that are read at once.
const NODES: usize = 1 << 20;

/// What a slab tells of its cells at a step.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct ToldOfStep {
    /// Of the mesh at rest.
    pub at_rest: Told,
    /// Of the quality of cells.
    pub cells: Told,
    /// Of the quality of faces.
    pub faces: Told,
    /// Of moving walls.
    pub walls: Told,
}

/// How a step was moved.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Moved {
    pub step: usize,
    /// The hash of the base points.
    pub base: [u8; 32],
    /// The largest displacement error before the correction, of the whole surface.
    pub selection_error: f64,
}

#[derive(Debug, Serialize, Deserialize)]
struct Head {
    run: [u8; 32],
    moved: Moved,
    nodes: Range<usize>,
    coordinates: [u8; 32],
    velocities: Option<[u8; 32]>,
    /// The kind of processor that has computed it.
    processor: String,
    told: ToldOfStep,
}

/// Where a slab leaves a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Left<'a> {
    pub path: &'a Path,
    pub commit: Commit,
    /// What tells its run from others.
    pub run: [u8; 32],
}

/// What is done with places of some nodes and with their velocities, from the number of the first on.
pub(super) type Act<'a> = dyn FnMut(usize, &[Vector], &[Vector]) -> Result<()> + 'a;

/// A file that holds a step of a slab.
#[derive(Debug)]
pub(crate) struct StoredStep {
    path: PathBuf,
    file: File,
    head: Head,
    /// Where the coordinates begin.
    at: u64,
}

impl StoredStep {
    /// Its name in the folder of a slab.
    pub fn file_name(step: usize) -> String {
        format!("step_{step:04}.slab")
    }

    /// Writes a step of a slab with its own nodes, completely or not at all.
    pub(super) fn save(
        &Left { path, commit, run }: &Left<'_>,
        moved: Moved,
        nodes: Range<usize>,
        (points, velocities): (&[Vector], Option<&[Vector]>),
        told: ToldOfStep,
    ) -> Result<()> {
        let hash = |vectors: &[Vector]| {
            let mut hasher = blake3::Hasher::new();
            let hasher = hasher.update_rayon(bytemuck::cast_slice(vectors));
            *hasher.finalize().as_bytes()
        };
        let head = Head {
            run,
            moved,
            nodes,
            coordinates: hash(points),
            velocities: velocities.map(hash),
            processor: processor::kind().to_owned(),
            told,
        };
        let head = postcard::to_stdvec(&head).expect("a head can be packed");
        let mut out = OutputSet::new(path, commit);
        out.main(|out| {
            let length = (head.len() as u64).to_le_bytes();
            let hash = blake3::hash(&head);
            let [points, velocities] =
                [points, velocities.unwrap_or_default()].map(bytemuck::cast_slice);
            let parts: [&[u8]; 6] = [MAGIC, &length, &head, hash.as_bytes(), points, velocities];
            let mut parts = parts.into_iter();
            let written = parts.try_for_each(|part| out.write_all(part));
            written.map_err(|error| Error::io(path, &error))
        })?;
        out.finish().files.keep()
    }

    /// Opens a file, and checks all of it but the coordinates and the velocities.
    ///
    /// # Errors
    /// Where it is not there, or not as it was written.
    pub fn open(path: &Path) -> Result<Self> {
        let failed = |error: std::io::Error| Error::io(path, &error);
        let mut file = File::open(path).map_err(failed)?;
        let n_bytes = file.metadata().map_err(failed)?.len();
        let mut first = [0; 24];
        let wrong = || damaged(path);
        file.read_exact(&mut first).map_err(|_| wrong())?;
        let (magic, length) = first.split_at(MAGIC.len());
        let length = u64::from_le_bytes(length.try_into().expect("these are 8 bytes"));
        let at = (first.len() as u64 + HASH).saturating_add(length);
        if magic != MAGIC || at > n_bytes {
            return Err(wrong());
        }
        let mut head = vec![0; length as usize];
        let mut hash = [0; HASH as usize];
        file.read_exact(&mut head).map_err(failed)?;
        file.read_exact(&mut hash).map_err(failed)?;
        if *blake3::hash(&head).as_bytes() != hash {
            return Err(wrong());
        }
        let head: Head = postcard::from_bytes(&head).map_err(|_| wrong())?;
        let n_vectors = head.nodes.len() as u64 * if head.velocities.is_some() { 2 } else { 1 };
        match n_vectors.checked_mul(NODE) == Some(n_bytes - at) {
            true => Ok(Self {
                path: path.to_path_buf(),
                file,
                head,
                at,
            }),
            false => Err(wrong()),
        }
    }

    /// What tells its run from others.
    pub fn run(&self) -> [u8; 32] {
        self.head.run
    }

    /// The step.
    pub fn step(&self) -> usize {
        self.head.moved.step
    }

    /// The own nodes of the slab.
    pub fn nodes(&self) -> Range<usize> {
        self.head.nodes.clone()
    }

    /// How it was moved.
    pub(super) fn moved(&self) -> Moved {
        self.head.moved
    }

    /// An error about this file.
    pub(super) fn wrong(&self, message: &str) -> Error {
        Error::input(message).file(&self.path)
    }

    /// The kind of processor that has computed it.
    pub(super) fn processor(&self) -> &str {
        &self.head.processor
    }

    /// What the slab tells of its cells.
    pub(super) fn into_told(self) -> ToldOfStep {
        self.head.told
    }

    /// Reads where consecutive nodes are, by their numbers in the whole mesh.
    pub(super) fn read(&mut self, nodes: Range<usize>, points: &mut [Vector]) -> Result<()> {
        self.read_at(self.at, nodes, points)
    }

    /// Reads vectors of consecutive nodes; those of all own ones begin at a byte of the file.
    fn read_at(&mut self, at: u64, nodes: Range<usize>, out: &mut [Vector]) -> Result<()> {
        let at = at + (nodes.start - self.head.nodes.start) as u64 * NODE;
        let bytes = bytemuck::cast_slice_mut(&mut out[..nodes.len()]);
        let read = (self.file.seek(SeekFrom::Start(at))).and_then(|_| self.file.read_exact(bytes));
        read.map_err(|error| Error::io(&self.path, &error))
    }

    /// Passes all coordinates, some nodes at a time with the number of the first.
    ///
    /// # Errors
    /// Of `act`, and at the end where they are not what was written.
    pub(super) fn pass(
        &mut self,
        act: &mut dyn FnMut(usize, &[Vector]) -> Result<()>,
    ) -> Result<()> {
        self.pass_both(false, &mut |first, points, _| act(first, points))
    }

    /// The same with the velocities, where they are `wanted`.
    pub(super) fn pass_both(&mut self, wanted: bool, act: &mut Act<'_>) -> Result<()> {
        if wanted && self.head.velocities.is_none() {
            return Err(self.wrong("this step of a slab has no velocities"));
        }
        let nodes = self.nodes();
        let room = || vec![[0.0; 3]; NODES.min(nodes.len())];
        let hash_of_velocities = self.head.velocities.filter(|_| wanted);
        let (mut points, mut velocities) = (room(), hash_of_velocities.map(|_| room()));
        let (mut hasher, mut second) = (blake3::Hasher::new(), blake3::Hasher::new());
        let after = self.at + nodes.len() as u64 * NODE;
        for start in nodes.clone().step_by(NODES) {
            let some = start..nodes.end.min(start + NODES);
            let points = &mut points[..some.len()];
            self.read(some.clone(), points)?;
            hasher.update_rayon(bytemuck::cast_slice(points));
            let velocities = match &mut velocities {
                None => &mut [],
                Some(velocities) => &mut velocities[..some.len()],
            };
            if !velocities.is_empty() {
                self.read_at(after, some, velocities)?;
                second.update_rayon(bytemuck::cast_slice(velocities));
            }
            act(start, points, velocities)?;
        }
        let is = |hasher: blake3::Hasher, wanted| *hasher.finalize().as_bytes() == wanted;
        let are_same = hash_of_velocities.is_none_or(|wanted| is(second, wanted));
        match is(hasher, self.head.coordinates) && are_same {
            true => Ok(()),
            false => Err(damaged(&self.path)),
        }
    }

    /// Checks the coordinates and the velocities.
    ///
    /// # Errors
    /// Where they are not what was written.
    pub fn check(&mut self) -> Result<()> {
        self.pass_both(self.head.velocities.is_some(), &mut |_, _, _| Ok(()))
    }
}

fn damaged(path: &Path) -> Error {
    Error::input("this is not a step of a slab as it was written; the run of that slab writes it again with --resume")
        .file(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn saved(folder: &Path) -> (PathBuf, Vec<Vector>, ToldOfStep) {
        let path = folder.join(StoredStep::file_name(3));
        let points: Vec<Vector> = (0..300).map(|i| [f64::from(i), 0.5, -1e-300]).collect();
        let told = ToldOfStep {
            cells: vec![vec![1, 2], vec![]],
            walls: vec![vec![7; 90]],
            ..ToldOfStep::default()
        };
        let left = Left {
            path: &path,
            commit: Commit::REPLACE,
            run: [9; 32],
        };
        let moved = Moved {
            step: 3,
            base: [5; 32],
            selection_error: 0.5,
        };
        let velocities: Vec<Vector> = points.iter().map(|x| x.map(|x| 2.0 - x)).collect();
        let vectors = (&points[..], Some(&velocities[..]));
        StoredStep::save(&left, moved, 256..556, vectors, told.clone()).expect("it is new");
        (path, points, told)
    }

    #[test]
    fn a_step_is_read_as_it_was_left() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, points, told) = saved(folder.path());
        let mut found = StoredStep::open(&path).expect("it is whole");
        assert_eq!(
            (found.run(), found.step(), found.nodes()),
            ([9; 32], 3, 256..556)
        );
        let moved = found.moved();
        assert_eq!((moved.base, moved.selection_error), ([5; 32], 0.5));
        let mut some = vec![[0.0; 3]; 9];
        found.read(300..309, &mut some).expect("they are there");
        assert_eq!(some, points[44..53]);
        let mut all = Vec::new();
        found
            .pass_both(true, &mut |first, points, velocities| {
                assert_eq!(first, 256 + all.len());
                all.extend_from_slice(points);
                let wanted = points.iter().map(|x| x.map(|x| 2.0 - x));
                assert!(wanted.eq(velocities.iter().copied()));
                Ok(())
            })
            .expect("it is whole");
        assert_eq!(all, points);
        assert_eq!(found.into_told(), told);
    }

    #[test]
    fn every_byte_of_a_file_is_checked() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, ..) = saved(folder.path());
        let bytes = std::fs::read(&path).expect("it is there");
        let check = |bytes: &[u8]| {
            std::fs::write(&path, bytes).expect("it can be written");
            StoredStep::open(&path).and_then(|mut found| found.check())
        };
        for at in (0..bytes.len()).step_by(13).chain([bytes.len() - 1]) {
            let mut other = bytes.clone();
            other[at] ^= 1;
            let refused = check(&other).expect_err("a bit is another");
            assert_eq!(refused.kind, crate::error::ErrorKind::Input, "{at}");
            assert!(check(&bytes[..at]).is_err(), "{at}");
        }
        check(&[&bytes[..], b"x"].concat()).expect_err("a byte too many");
        check(&bytes).expect("it is whole");
    }
}

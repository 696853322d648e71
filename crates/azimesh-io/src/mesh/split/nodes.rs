//! New nodes of a mesh that is split, each in the middle of other nodes.

use super::super::sides::for_each_side;
use super::super::{CellKind, CellRef, Mesh, Values, too_many};
use super::flat;
use azimesh_core::error::{Error, Result};
use std::collections::{HashMap, hash_map::Entry};

/// New nodes, numbered after the nodes of the mesh.
pub(super) struct NewNodes {
    first: usize,
    places: Vec<[f64; 3]>,
    /// End of the nodes of each in `around`.
    ends: Vec<usize>,
    /// Nodes around each new node.
    around: Vec<u32>,
}

impl NewNodes {
    /// None yet, after `n` nodes.
    pub fn after(n: usize) -> Self {
        Self {
            first: n,
            places: Vec::new(),
            ends: Vec::new(),
            around: Vec::new(),
        }
    }

    pub fn len(&self) -> usize {
        self.places.len()
    }

    pub fn places(&self) -> &[[f64; 3]] {
        &self.places
    }

    /// Iterates over the nodes around each new node.
    pub fn nodes(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts
            .zip(&self.ends)
            .map(|(&from, &to)| &self.around[from..to])
    }

    /// Adds the middle of `nodes`; gives its number.
    pub fn add(&mut self, place: [f64; 3], nodes: &[u32]) -> Result<u32> {
        let number = self.first + self.places.len();
        if number >= u32::MAX as usize - 1 {
            return Err(Error::input(too_many("nodes")));
        }
        self.places.push(place);
        self.around.extend_from_slice(nodes);
        self.ends.push(self.around.len());
        Ok(number as u32)
    }
}

/// The nodes in the middle of faces of more than four corners.
#[derive(Default)]
pub(super) struct FaceNodes {
    /// By the corners in ascending order.
    numbers: HashMap<Box<[u32]>, u32>,
}

impl FaceNodes {
    /// Adds a node for each such face of the cells that are split, and for each polygon.
    pub fn of(mesh: &Mesh, new_nodes: &mut NewNodes) -> Result<Self> {
        let mut faces = Self::default();
        let split = mesh.cells.runs().filter(|run| super::is_split(run.kind));
        for cell in split.flat_map(|run| run.cell_refs()) {
            faces.add_those_of(mesh, &cell, new_nodes)?;
        }
        Ok(faces)
    }

    fn add_those_of(
        &mut self,
        mesh: &Mesh,
        cell: &CellRef<'_>,
        new_nodes: &mut NewNodes,
    ) -> Result<()> {
        if cell.kind == CellKind::Polygon {
            return self.add(&corners(cell.nodes), &mesh.points, new_nodes);
        }
        let mut done = Ok(());
        for_each_side(&mesh.cells, cell, |_, nodes| {
            if done.is_ok() {
                done = self.add(&corners(nodes), &mesh.points, new_nodes);
            }
        });
        done
    }

    fn add(
        &mut self,
        corners: &[u32],
        points: &[[f64; 3]],
        new_nodes: &mut NewNodes,
    ) -> Result<()> {
        if corners.len() <= 4 {
            return Ok(());
        }
        if let Entry::Vacant(place) = self.numbers.entry(key(corners)) {
            let middle = flat::middle(corners, points).0;
            let number = new_nodes.add(middle, place.key())?;
            place.insert(number);
        }
        Ok(())
    }

    /// The node in the middle of a face with these corners; `None` where it has four or fewer.
    pub fn get(&self, corners: &[u32]) -> Option<u32> {
        match corners.len() {
            0..=4 => None,
            _ => self.numbers.get(&key(corners)).copied(),
        }
    }
}

fn key(corners: &[u32]) -> Box<[u32]> {
    let mut key: Box<[u32]> = corners.into();
    key.sort_unstable();
    key
}

/// The nodes of a face without those that repeat the one before.
pub(super) fn corners(nodes: &[u32]) -> Vec<u32> {
    let mut corners = nodes.to_vec();
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    corners
}

impl Values {
    /// Adds the mean of the tuples of each list: of integers the nearest one, of text none.
    pub(super) fn append_means<'a>(
        &mut self,
        n_components: usize,
        lists: impl Iterator<Item = &'a [u32]>,
    ) {
        /// The `i`-th values of the tuples of a list.
        fn column<'v, T: Copy>(
            values: &'v [T],
            list: &'v [u32],
            (i, n): (usize, usize),
        ) -> impl Iterator<Item = T> + 'v {
            list.iter().map(move |&node| values[node as usize * n + i])
        }
        macro_rules! means {
            ($v:expr, $wide:ty, $mean:expr) => {
                for list in lists {
                    for i in 0..n_components {
                        let column = column($v, list, (i, n_components));
                        let sum: $wide = column.map(<$wide>::from).sum();
                        let mean = $mean(sum, list.len());
                        $v.push(mean);
                    }
                }
            };
        }
        let real = |sum: f64, n: usize| sum / n as f64;
        match self {
            Values::I8(v) => means!(v, i128, |sum, n| nearest(sum, n) as i8),
            Values::U8(v) => means!(v, i128, |sum, n| nearest(sum, n) as u8),
            Values::I16(v) => means!(v, i128, |sum, n| nearest(sum, n) as i16),
            Values::U16(v) => means!(v, i128, |sum, n| nearest(sum, n) as u16),
            Values::I32(v) => means!(v, i128, |sum, n| nearest(sum, n) as i32),
            Values::U32(v) => means!(v, i128, |sum, n| nearest(sum, n) as u32),
            Values::I64(v) => means!(v, i128, |sum, n| nearest(sum, n) as i64),
            Values::U64(v) => means!(v, i128, |sum, n| nearest(sum, n) as u64),
            Values::F32(v) => means!(v, f64, |sum, n| real(sum, n) as f32),
            Values::F64(v) => means!(v, f64, real),
            Values::Text(v) => {
                let n = lists.count() * n_components;
                v.resize(v.len() + n, String::new());
            }
        }
    }
}

/// The integer nearest to `sum / n`; halves go up.
fn nearest(sum: i128, n: usize) -> i128 {
    let n = n.max(1) as i128;
    (2 * sum + n).div_euclid(2 * n)
}

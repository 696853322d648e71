//! Faces of the polyhedra of a mesh as VTKHDF lists them: every polyhedron has its own.

use super::super::hdf5::Sink;
use crate::mesh::{CellKind, Cells};
use azimesh_core::error::Result;

/// Values made at a time.
const CHUNK: usize = 1 << 19;

/// How many there are.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct FaceCounts {
    pub faces: u64,
    pub entries: u64,
}

impl FaceCounts {
    pub fn of(cells: &Cells) -> Self {
        let mut counts = Self::default();
        for stream in streams(cells) {
            let n = u64::from(stream.first().copied().unwrap_or(0));
            counts.faces += n;
            counts.entries += (stream.len() as u64).saturating_sub(1 + n);
        }
        counts
    }
}

/// An integer of 32 or 64 bits.
pub(super) trait Index: bytemuck::NoUninit {
    fn from_u64(value: u64) -> Self;
}

impl Index for i32 {
    fn from_u64(value: u64) -> Self {
        value as i32
    }
}

impl Index for i64 {
    fn from_u64(value: u64) -> Self {
        value as i64
    }
}

/// Nodes of all faces.
pub(super) fn nodes<T: Index>(cells: &Cells, sink: Sink) -> Result<()> {
    let mut out = Buffer::<T>::new(sink);
    for face in faces(cells) {
        for &node in face {
            out.push(node.into())?;
        }
    }
    out.finish()
}

/// Where the nodes of each face start, and where those of the last end.
pub(super) fn starts<T: Index>(cells: &Cells, sink: Sink) -> Result<()> {
    let mut out = Buffer::<T>::new(sink);
    let mut end = 0;
    out.push(0)?;
    for face in faces(cells) {
        end += face.len() as u64;
        out.push(end)?;
    }
    out.finish()
}

/// Where the faces of each cell start, and where those of the last end; `n_more` cells without
/// faces follow.
pub(super) fn cell_starts<T: Index>(cells: &Cells, n_more: usize, sink: Sink) -> Result<()> {
    let mut out = Buffer::<T>::new(sink);
    let mut end = 0;
    out.push(0)?;
    for run in cells.runs() {
        for cell in run.first_cell..run.first_cell + run.n_cells() {
            if run.kind == CellKind::Polyhedron {
                let stream = cells.face_stream(cell).unwrap_or(&[]);
                end += u64::from(stream.first().copied().unwrap_or(0));
            }
            out.push(end)?;
        }
    }
    for _ in 0..n_more {
        out.push(end)?;
    }
    out.finish()
}

/// 0, 1, 2, ...: the faces in the order of the cells.
pub(super) fn numbers<T: Index>(n: u64, sink: Sink) -> Result<()> {
    let mut out = Buffer::<T>::new(sink);
    for face in 0..n {
        out.push(face)?;
    }
    out.finish()
}

fn streams(cells: &Cells) -> impl Iterator<Item = &[u32]> {
    polyhedra(cells).filter_map(|cell| cells.face_stream(cell))
}

fn faces(cells: &Cells) -> impl Iterator<Item = &[u32]> {
    polyhedra(cells).flat_map(|cell| cells.polyhedron_faces(cell))
}

fn polyhedra(cells: &Cells) -> impl Iterator<Item = usize> {
    let runs = cells.runs().filter(|run| run.kind == CellKind::Polyhedron);
    runs.flat_map(|run| run.first_cell..run.first_cell + run.n_cells())
}

/// Gathers values and hands them on.
struct Buffer<'s, T> {
    values: Vec<T>,
    sink: Sink<'s>,
}

impl<'s, T: Index> Buffer<'s, T> {
    fn new(sink: Sink<'s>) -> Self {
        Self {
            values: Vec::new(),
            sink,
        }
    }

    fn push(&mut self, value: u64) -> Result<()> {
        self.values.push(T::from_u64(value));
        if self.values.len() < CHUNK {
            return Ok(());
        }
        (self.sink)(bytemuck::cast_slice(&self.values))?;
        self.values.clear();
        Ok(())
    }

    fn finish(self) -> Result<()> {
        (self.sink)(bytemuck::cast_slice(&self.values))
    }
}

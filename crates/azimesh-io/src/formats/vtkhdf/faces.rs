//! Faces of the polyhedra of a mesh as VTKHDF lists them: every polyhedron has its own.

use crate::mesh::{CellKind, Cells};

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
            let n = u64::from(n_faces(stream));
            counts.faces += n;
            counts.entries += (stream.len() as u64).saturating_sub(1 + n);
        }
        counts
    }
}

/// Nodes of all faces.
pub(super) fn nodes(cells: &Cells) -> impl Iterator<Item = i64> {
    faces(cells).flatten().map(|node| i64::from(*node))
}

/// Start of the nodes of each face, and the end of the last.
pub(super) fn starts(cells: &Cells) -> impl Iterator<Item = i64> {
    let mut end = 0;
    let ends = faces(cells).map(move |face| {
        end += face.len() as i64;
        end
    });
    std::iter::once(0).chain(ends)
}

/// Start of the faces of each cell, and the end of the last; `n_more` cells without faces follow.
pub(super) fn cell_starts(cells: &Cells, n_more: usize) -> impl Iterator<Item = i64> {
    let of_mesh = cells.runs().flat_map(move |run| {
        let own = run.first_cell..run.first_cell + run.n_cells();
        own.map(move |cell| match run.kind {
            CellKind::Polyhedron => n_faces(cells.face_stream(cell).unwrap_or(&[])),
            _ => 0,
        })
    });
    let mut end = 0;
    let ends = of_mesh.chain(std::iter::repeat_n(0, n_more));
    std::iter::once(0).chain(ends.map(move |n| {
        end += i64::from(n);
        end
    }))
}

fn n_faces(stream: &[u32]) -> u32 {
    stream.first().copied().unwrap_or(0)
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

//! Makes a mesh of the numbers of a file, whichever way they are stored.

use super::super::Notes;
use super::Ugrid;
use super::conditions::Patch;
use super::faces;
use super::layout::{Content, KINDS, Layout, N_FACE_KINDS, PYRAMID, n_nodes};
use super::{binary, text};
use crate::mesh::{CellKind, Cells, Mesh};
use azimesh_core::error::Result;
use azimesh_core::parallel::{BLOCK, for_blocks};

/// The mesh in these bytes, with the names and conditions of `patches`.
pub(super) fn read(
    bytes: &[u8],
    flavour: &Ugrid,
    patches: &[Patch],
    notes: &mut Notes,
) -> Result<Mesh> {
    let mut content = match &flavour.layout {
        Layout::Text => text::read(bytes, flavour)?,
        Layout::Binary(layout) => binary::read(bytes, layout, flavour)?,
    };
    notes.extend(std::mem::take(&mut content.notes));
    turn_pyramids(&mut content);
    let runs = KINDS.into_iter().zip(content.counts.n_cells);
    let runs = runs.map(|(kind, n)| (kind, n_nodes(kind), n));
    let mut mesh = Mesh {
        points: content.points,
        cells: Cells::from_connectivity(content.connectivity, runs),
        ..Mesh::default()
    };
    faces::add_groups(&mut mesh, &content.face_numbers, patches);
    Ok(mesh)
}

/// Puts the nodes of the pyramids among those of all cells into VTK's order.
fn turn_pyramids(content: &mut Content) {
    let is_before = |kind: &CellKind| *kind != CellKind::Pyramid;
    let n_before = KINDS.into_iter().take_while(is_before).count();
    let entries = |i: usize| n_nodes(KINDS[i]) * content.counts.n_cells[i];
    let start: usize = (0..n_before).map(entries).sum();
    debug_assert!(n_before > N_FACE_KINDS);
    turn(&mut content.connectivity[start..start + entries(n_before)]);
}

/// Puts the nodes of pyramids into VTK's order.
pub(super) fn turn(pyramids: &mut [u32]) {
    for_blocks(pyramids, PYRAMID.len() * BLOCK, &|_, pyramids| {
        for nodes in pyramids.chunks_exact_mut(PYRAMID.len()) {
            let old: [u32; 5] = std::array::from_fn(|i| nodes[i]);
            for (node, from) in nodes.iter_mut().zip(PYRAMID) {
                *node = old[from];
            }
        }
    });
}

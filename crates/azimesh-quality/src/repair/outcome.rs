//! The report of a repair: its patches, and the remaining cells with the reason.

use super::MOST_NODES_OF_CURVED;
use super::boundary::CrossedFace;
use azimesh_core::error::option;
use serde::{Deserialize, Serialize};

/// Reason why a cell is not repaired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reason {
    /// All of its nodes, or the nodes of a folded corner, are fixed.
    Fixed,
    /// The fixed nodes of the boundary leave no valid mesh: [`Repaired::overtaken`] proves it.
    Boundary,
    /// No valid positions were found.
    NotFound,
    /// A surface in space is not repaired.
    Surface,
    /// Curved cells of a kind without a proof of validity, or of very many nodes, are not repaired.
    Curved,
    /// Valid before its coordinates were rounded to 32 bits.
    Rounded,
}

impl Reason {
    /// In JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Boundary => "boundary",
            Self::NotFound => "not_found",
            Self::Surface => "surface",
            Self::Curved => "curved",
            Self::Rounded => "rounded",
        }
    }

    /// The reason in words.
    pub fn sentence(self) -> String {
        let sentence = match self {
            Self::Fixed => "all nodes of the cell, or of a folded corner of it, are fixed",
            Self::Boundary => {
                "there is no valid mesh: fixed nodes of the boundary have been passed by others, or bodies intersect"
            }
            Self::NotFound => "no valid positions were found for the nodes around them",
            Self::Surface => {
                "cells of a surface in space are not repaired; repair the volume mesh that it bounds"
            }
            Self::Curved => {
                return format!(
                    "a mesh with curved cells of 19, 24 or more than {MOST_NODES_OF_CURVED} nodes, curved polygons or Bezier pyramids is not repaired; make its cells linear first (convert {})",
                    option("linearize")
                );
            }
            Self::Rounded => {
                "coordinates of 32 bits do not keep their nodes apart; write coordinates of 64 bits, or shift the mesh to the origin"
            }
        };
        sentence.to_owned()
    }
}

/// A cell that is not valid after the repair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unrepaired {
    /// The cell.
    pub cell: usize,
    /// Why.
    pub reason: Reason,
}

/// Log of one patch.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PatchLog {
    /// Cells that were not valid before.
    pub invalid_before: usize,
    /// Cells that are not valid after it.
    pub invalid: usize,
    /// The first cell that was not valid.
    pub first_cell: usize,
    /// Cells of the patch.
    pub n_cells: usize,
    /// Nodes that could move.
    pub n_nodes: usize,
    /// Rings of neighbours.
    pub rings: usize,
    /// Newton steps.
    pub steps: usize,
    /// Iterations of the linear systems.
    pub iterations: usize,
    /// The least Jacobian of a simplex relative to its reference before.
    pub least_before: f64,
    /// And after it.
    pub least: f64,
    /// The largest displacement of a node, in mesh units.
    pub largest_move: f64,
}

/// Result of a repair.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Repaired {
    /// The patches, in the order of their lowest nodes, patches of fewer rings first.
    pub patches: Vec<PatchLog>,
    /// Cells that are still not valid, ascending.
    pub unrepaired: Vec<Unrepaired>,
    /// Faces of the boundary that prove that there is no valid mesh, those near cells that are left.
    pub overtaken: Vec<CrossedFace>,
}

impl Repaired {
    pub(super) fn give_up(&mut self, cells: Vec<u32>, reason: Reason) {
        let cells = cells.into_iter().map(|cell| cell as usize);
        self.unrepaired
            .extend(cells.map(|cell| Unrepaired { cell, reason }));
    }
}

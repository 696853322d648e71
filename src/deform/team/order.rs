//! What the first rank tells the others.

use super::kept::WriteTask;
use super::placing::{Maps, Rates};
use super::sweeps::SweepOrder;
use crate::deform::fields::Chosen;
use crate::deform::layer::{Layer, LayerKind};
use crate::deform::step_memory::Rounding;
use crate::formats::SharedFile;
use crate::geometry::Bounds;
use crate::geometry::vector::Vector;
use crate::ranks::Ranks;
use crate::ranks::raw::{self, List};
use crate::rbf::interpolant::Interpolant;
use serde::{Deserialize, Serialize};

/// What the first rank orders. What an order is about follows it.
#[derive(Serialize, Deserialize)]
pub(super) enum Order {
    /// Choose base points: sweep over a slab of the surface.
    Select(SweepOrder),
    /// Evaluate fields at all nodes.
    Evaluate { id: usize, task: Box<Task> },
    /// Move the nodes to a step, and tell where the own ones are that deform; with `from_zero` by how much they move, or their
    /// velocities.
    Move {
        id: usize,
        step: usize,
        from_zero: bool,
        /// Whether what is found of the own nodes stays with the rank, which tells of some.
        stays: bool,
    },
    /// Add what fades in from the surface to where nodes are; the boxes are around all nodes to which something is added.
    Fade { boxes: Vec<Bounds> },
    /// Fields are not needed any more.
    Forget { id: usize },
    /// Read a part of the mesh from its file, and tell of the surface in it or not.
    Read { file: SharedFile, tells: bool },
    /// Hash a share of the file.
    Hash(SharedFile),
    /// Tell of the shortest edges that leave moving walls.
    Edges,
    /// Tell which of these boundary faces lie on no cell.
    LooseFaces(Vec<u32>),
    /// Take a part of the mesh, the one that was read before, from its file or else from the first rank, and to judge cells the moving
    /// faces there.
    Share {
        is_read: bool,
        file: Option<SharedFile>,
        n_nodes: usize,
        moving_faces: Option<Vec<u32>>,
    },
    /// Take the own nodes, without a part of the mesh.
    TakeNodes { n_nodes: usize },
    /// Tell the numbers of all nodes in the whole mesh.
    Numbers,
    /// End the move to a step, with places rounded.
    EndMove { maps: Maps, rounding: Rounding },
    /// Set the velocities that fields do not give; the first rank tells some.
    EndVelocities(Rates),
    /// Take the places of nodes of which the first rank tells.
    PlaceApart,
    /// Take the places that other nodes of the part have on the first rank, where they are others.
    PlaceRest,
    /// Take which of the own nodes the first rank wants to know, where they may stay with the rank.
    Divide,
    /// Tell where all own nodes are.
    Collect,
    /// Keep where the own nodes are, to write them.
    Keep,
    /// Write numbers of the nodes that are kept.
    Write(WriteTask),
    /// Wait until what was written is on the disk.
    Settle,
    /// Judge the cells of the part.
    Cells,
    /// Judge the faces of the part.
    Faces,
    /// Judge how walls lean.
    Walls,
    /// There is no more to do.
    End,
}

/// Fields that are to be evaluated.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Task {
    pub layers: Vec<LayerTask>,
    /// Around all nodes that are corrected.
    pub boxes: Vec<Bounds>,
}

/// Where the nodes of a rank are before fields move them.
#[derive(Default, Serialize, Deserialize)]
pub(super) enum RowsFrom {
    /// At rest.
    #[default]
    Rest,
    /// Where the rank has moved them to.
    Moved,
    /// Here.
    Told(List<Vector>),
}

/// What a rank has to know of a layer.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct LayerTask {
    pub kind: LayerKind,
    pub n_modes: usize,
    #[serde(with = "raw")]
    pub coefficients: Vec<f64>,
    pub interpolant: Interpolant,
}

/// Blocks of nodes with other places than a rank has.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Changed {
    pub blocks: Vec<u32>,
    #[serde(with = "raw")]
    pub places: Vec<Vector>,
}

impl Order {
    /// What messages after it are for.
    fn what(&self) -> &'static str {
        match self {
            Self::Select(_) => "selection",
            Self::Evaluate { .. } | Self::Forget { .. } | Self::End => "fields",
            Self::Fade { .. } => "correction",
            Self::Move { .. } | Self::Collect => "positions",
            Self::Read { .. }
            | Self::Hash(_)
            | Self::Edges
            | Self::LooseFaces(_)
            | Self::Share { .. }
            | Self::TakeNodes { .. }
            | Self::Numbers => "parts",
            Self::EndMove { .. } | Self::EndVelocities(_) | Self::PlaceApart | Self::PlaceRest => {
                "places"
            }
            Self::Divide | Self::Keep | Self::Write(_) | Self::Settle => "writing",
            Self::Cells | Self::Faces | Self::Walls => "quality",
        }
    }

    /// Gives an order to all ranks, and gives it back; on other ranks than the first it comes from there.
    pub fn give(of_first: Option<Self>, ranks: &Ranks) -> Self {
        if let Some(order) = &of_first {
            ranks.is_for(order.what());
        }
        let order = ranks.broadcast(of_first);
        ranks.is_for(order.what());
        order
    }
}

impl LayerTask {
    pub fn of((layer, chosen): (&Layer, &Chosen<'_>)) -> Self {
        Self {
            kind: layer.kind.clone(),
            n_modes: layer.modes.n_modes,
            coefficients: layer.modes.coefficients.clone(),
            interpolant: chosen.selection.interpolant.clone(),
        }
    }
}

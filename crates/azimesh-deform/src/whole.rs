//! The whole mesh on the first rank, when other ranks have parts of it: for the repair of folded cells, and for formats
//! that are written from a whole mesh.

use super::part::Part;
use super::plan::prepare::{has_boxes, leave_out_boxes};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::{Coincident, Mesh};
use azimesh_quality::QualityEvaluator;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::{Arc, OnceLock};

/// A function that reads the mesh without duplicated interface nodes.
pub type ReadWhole = Box<dyn Fn() -> Result<Arc<Mesh>> + Send + Sync>;

/// The whole mesh, which the first rank reads when it is needed.
#[derive(Default)]
pub(crate) struct Whole {
    /// `None` on the other ranks, and if one process has the mesh.
    read: Option<ReadWhole>,
    mesh: OnceLock<Arc<Mesh>>,
    evaluator: OnceLock<QualityEvaluator>,
    copies: OnceLock<Coincident>,
}

impl Whole {
    pub fn new(read: Option<ReadWhole>) -> Self {
        Self {
            read,
            ..Self::default()
        }
    }

    /// Returns the whole mesh; on all ranks but the first their parts.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn mesh<'a>(&'a self, part: &'a Part) -> Result<&'a Arc<Mesh>> {
        let Some(read) = self.read.as_ref() else {
            return Ok(&part.mesh);
        };
        if let Some(mesh) = self.mesh.get() {
            return Ok(mesh);
        }
        let mut mesh = read()?;
        if has_boxes(&mesh) {
            leave_out_boxes(Arc::make_mut(&mut mesh));
        }
        for doubled in &part.doubled {
            doubled.apply(Arc::make_mut(&mut mesh));
        }
        Ok(self.mesh.get_or_init(|| mesh))
    }

    /// Returns whether the first rank has read it.
    pub fn is_read(&self) -> bool {
        self.mesh.get().is_some()
    }

    /// Returns its quality evaluator in the reference state; `own` is the evaluator of one process.
    ///
    /// # Errors
    /// Like [`mesh`](Self::mesh).
    pub fn evaluator<'a>(
        &'a self,
        part: &'a Part,
        own: &'a QualityEvaluator,
    ) -> Result<&'a QualityEvaluator> {
        if self.read.is_none() {
            return Ok(own);
        }
        let mesh = self.mesh(part)?;
        Ok(self.evaluator.get_or_init(|| QualityEvaluator::new(mesh)))
    }

    /// Returns the nodes that `find` says are one in the reference state of the mesh.
    pub fn copies(&self, find: impl FnOnce() -> Coincident) -> &Coincident {
        self.copies.get_or_init(find)
    }
}

/// Calls `act` on the first rank with the positions of all nodes, and distributes the positions that it leaves. Returns
/// its result on all ranks. All ranks call it.
///
/// # Errors
/// The error of `act`, on all ranks.
pub(super) fn on_first<T: Serialize + DeserializeOwned>(
    part: &Part,
    points: &mut [Vector],
    act: impl FnOnce(&mut [Vector]) -> Result<T>,
) -> Result<T> {
    let ranks = part.ranks();
    if ranks.n() == 1 {
        return act(points);
    }
    let mut whole = part.mesh.gather_nodes(&points[part.mesh.own_nodes()]);
    let done = whole.as_mut().map(|whole| act(whole)).transpose();
    let done = ranks.all_ok(done)?;
    part.mesh.scatter_nodes(whole.as_deref(), points);
    Ok(ranks.broadcast(done))
}

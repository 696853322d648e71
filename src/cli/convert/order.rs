//! `azimesh convert --reorder`.

use super::Run;
use azimesh_core::error::counted;
use azimesh_io::mesh::{Mesh, Reordering};

impl Run<'_> {
    /// Puts nodes and cells along a curve; those of later steps of a sequence in the order of the first, by which a step
    /// differs from the next as it did before. A step with another number of nodes or cells has an order of its own.
    pub(super) fn reorder(&self, mesh: &mut Mesh) {
        let mut order = self.order.borrow_mut();
        let known = order.take().filter(|order| order.fits(mesh));
        let order = order.insert(known.unwrap_or_else(|| Reordering::along_curve(mesh)));
        mesh.reorder(order);
        self.tell(format!(
            "--reorder: {} and {} along a space-filling curve",
            counted(mesh.points.len(), "node"),
            counted(mesh.cells.len(), "cell")
        ));
    }
}

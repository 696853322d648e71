//! Notes of `quality`: what the metrics of a mesh do not cover.

use super::notes::notes;
use super::short;
use crate::error::counted;

notes! {
/// A remark on a mesh that its metrics do not cover.
QualityNote as Quality {
    /// Cells of higher order.
    CornersAlone {
        /// Their number.
        cells: usize,
    } => (
        "{} of higher order: validity and quality are checked at the corners only, with straight edges",
        counted(*cells, "cell")
    )

    /// Products of lengths exceed the range of double precision.
    OutOfRange {
        /// The largest extent of the mesh along an axis.
        extent: f64,
    } => (
        "the mesh has an extent of {}: products of lengths leave the range of double precision, and metrics are wrong; use \
         another unit (convert --scale)",
        short(*extent)
    )
}
}

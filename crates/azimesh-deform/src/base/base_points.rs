//! Base points by mesh node, as users pass and receive them.

use serde::{Deserialize, Serialize};

/// Base points by mesh node, in the order of selection.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::BasePoints;
///
/// let base = BasePoints::from(vec![3, 17, 42]);
/// assert_eq!(base.nodes, [3, 17, 42]);
/// assert_eq!(base.rotation_nodes, None);
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BasePoints {
    /// Base points of the displacements; with `interpolate = "twist"` of the translations.
    pub nodes: Vec<u32>,
    /// Base points of the rotations, with `interpolate = "twist"`.
    pub rotation_nodes: Option<Vec<u32>>,
}

impl From<Vec<u32>> for BasePoints {
    fn from(nodes: Vec<u32>) -> Self {
        Self {
            nodes,
            rotation_nodes: None,
        }
    }
}

//! Base points by their mesh nodes, as users give and get them.

use serde::{Deserialize, Serialize};

/// Base points by their mesh nodes, in the order in which they were chosen.
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
    /// Those of the displacements; with `interpolate = "twist"` of the translations.
    pub nodes: Vec<u32>,
    /// With `interpolate = "twist"`, those of the rotations.
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

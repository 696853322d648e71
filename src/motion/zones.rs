//! The zones that deform, and their interface to the rest of the mesh.

use super::names::Pattern;
use crate::error::Result;
use crate::mesh::{Mesh, ZoneSides};

/// The part of the mesh that deforms when the schedule names zones.
#[derive(Debug, Clone)]
pub struct DeformingZone {
    /// For each cell of the mesh, whether it is a volume cell of these zones.
    pub cells: Vec<bool>,
    /// Its nodes, and those shared with volume cells outside these zones, which stay fixed.
    pub sides: ZoneSides,
}

impl DeformingZone {
    /// Whether a node is shared with volume cells outside these zones.
    pub fn is_interface(&self, node: u32) -> bool {
        self.sides.interface_nodes.binary_search(&node).is_ok()
    }

    /// The zones that `patterns` name; `None` when there are no patterns.
    pub(super) fn find(patterns: &[Pattern], mesh: &Mesh) -> Result<Option<Self>> {
        if patterns.is_empty() {
            return Ok(None);
        }
        let zones: Vec<_> = mesh.zones().collect();
        let names: Vec<&str> = zones.iter().map(|zone| zone.name.as_str()).collect();
        let mut cells = vec![false; mesh.cells.len()];
        for pattern in patterns {
            for zone in pattern.find("zone", &names)? {
                for range in zones[zone].cells.ranges() {
                    cells[range].fill(true);
                }
            }
        }
        let sides = match &mesh.outline {
            None => ZoneSides::of(mesh, &cells),
            Some(outline) => outline.by.zone_sides(&cells)?,
        };
        Ok(Some(Self { cells, sides }))
    }
}

//! The zones that deform, and their interface to the rest of the mesh.

use super::names::Pattern;
use azimesh_core::error::Result;
use azimesh_io::mesh::{Boundary, CellSet, ZoneSides};

/// Finds the sides of some volume cells of the mesh.
pub type SidesOf<'a> = dyn Fn(&CellSet) -> Result<ZoneSides> + 'a;

/// The part of the mesh that deforms when the schedule names zones.
#[derive(Debug, Clone)]
pub struct DeformingZone {
    /// The volume cells of these zones.
    pub cells: CellSet,
    /// Its nodes, and those shared with volume cells outside these zones, which stay fixed.
    pub sides: ZoneSides,
}

impl DeformingZone {
    /// Returns whether a node is shared with volume cells outside these zones.
    pub fn is_interface(&self, node: u32) -> bool {
        self.sides.interface_nodes.binary_search(&node).is_ok()
    }

    /// The zones that `patterns` name; `None` when there are no patterns.
    pub(super) fn find(
        patterns: &[Pattern],
        boundary: &Boundary,
        sides_of: &SidesOf<'_>,
    ) -> Result<Option<Self>> {
        if patterns.is_empty() {
            return Ok(None);
        }
        let zones: Vec<_> = boundary.zones().collect();
        let names: Vec<&str> = zones.iter().map(|zone| zone.name.as_str()).collect();
        let mut ranges = Vec::new();
        for pattern in patterns {
            for zone in pattern.find("zone", &names)? {
                ranges.extend(zones[zone].cells.ranges());
            }
        }
        ranges.sort_unstable_by_key(|range| range.start);
        let (mut cells, mut end) = (CellSet::new(), 0);
        for range in ranges {
            // A cell may be in several zones.
            cells.push_range(range.start.max(end)..range.end.max(end));
            end = end.max(range.end);
        }
        let sides = sides_of(&cells)?;
        Ok(Some(Self { cells, sides }))
    }
}

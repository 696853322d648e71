//! The parts of a mesh that move differently: zones that deform, zones that move rigidly with a body, and the rest, which stays.

use super::names::Pattern;
use super::schedule::Schedule;
use azimesh_core::error::Result;
use azimesh_io::mesh::{Boundary, CellSet, ZoneSides};

/// A function that finds the sides of some volume cells of the mesh.
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

    /// Returns the zones of the schedule that deform. Without a name these are all zones that no body of `parts` moves, and
    /// `None` if that is the whole mesh.
    pub(super) fn find(
        schedule: &Schedule,
        parts: &[RigidPart],
        boundary: &Boundary,
        sides_of: &SidesOf<'_>,
    ) -> Result<Option<Self>> {
        let patterns = &schedule.boundaries.zones;
        let cells = match (patterns.is_empty(), parts.is_empty()) {
            (true, true) => return Ok(None),
            (true, false) => rest_of(parts, boundary.n_cells),
            (false, _) => cells_of(patterns, boundary)?,
        };
        if let Some(part) = parts.iter().find(|part| overlap(&part.cells, &cells)) {
            let message = format!(
                "`zones` has cells that move rigidly with body \"{}\"; leave its zones out, a cell cannot deform as well",
                schedule.bodies[part.body].name
            );
            return Err(schedule.places.error("boundaries.zones", message));
        }
        let sides = sides_of(&cells)?;
        Ok(Some(Self { cells, sides }))
    }
}

/// Zones that move rigidly with a body.
#[derive(Debug, Clone)]
pub struct RigidPart {
    /// The body.
    pub body: usize,
    /// The volume cells of the zones.
    pub cells: CellSet,
    /// Its nodes; after duplication it shares none with other volume cells.
    pub sides: ZoneSides,
}

impl RigidPart {
    /// Returns the zones of every body that has some.
    pub(super) fn find_all(
        schedule: &Schedule,
        boundary: &Boundary,
        sides_of: &SidesOf<'_>,
    ) -> Result<Vec<Self>> {
        let mut parts: Vec<Self> = Vec::new();
        for (index, body) in schedule.bodies.iter().enumerate() {
            if body.zones.is_empty() {
                continue;
            }
            let cells = cells_of(&body.zones, boundary)?;
            if cells.is_empty() {
                let message = format!(
                    "the zones of body \"{}\" have no cells; name zones that have some",
                    body.name
                );
                return Err(body.places.error("zones", message));
            }
            if let Some(other) = parts.iter().find(|part| overlap(&part.cells, &cells)) {
                let message = format!(
                    "the zones of body \"{}\" have cells that move with body \"{}\" already; a cell moves with one body",
                    body.name, schedule.bodies[other.body].name
                );
                return Err(body.places.error("zones", message));
            }
            parts.push(Self {
                body: index,
                sides: sides_of(&cells)?,
                cells,
            });
        }
        Ok(parts)
    }
}

/// Returns the cells of the zones that patterns name.
fn cells_of(patterns: &[Pattern], boundary: &Boundary) -> Result<CellSet> {
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
    Ok(cells)
}

/// Returns all cells of a mesh that are in none of the parts.
fn rest_of(parts: &[RigidPart], n_cells: usize) -> CellSet {
    let mut ranges: Vec<_> = parts.iter().flat_map(|part| part.cells.ranges()).collect();
    ranges.sort_unstable_by_key(|range| range.start);
    let (mut rest, mut end) = (CellSet::new(), 0);
    for range in ranges {
        rest.push_range(end..range.start);
        end = range.end;
    }
    rest.push_range(end..n_cells);
    rest
}

fn overlap(a: &CellSet, b: &CellSet) -> bool {
    let mut ranges = a.ranges();
    ranges.any(|range| b.ranges_in(range).next().is_some())
}

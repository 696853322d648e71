//! The parts of a mesh that move differently: zones that deform, zones that move rigidly with a body, and the rest, which stays.

use super::names::Pattern;
use super::rotor::{Frame, Rotor};
use super::schedule::Schedule;
use azimesh_core::error::{Error, Result};
use azimesh_io::mesh::{Boundary, CellSet, Cells, ZoneSides};
use std::collections::BTreeMap;
use std::ops::Range;

/// A function that finds the sides of some volume cells of the mesh.
pub type SidesOf<'a> = dyn Fn(&CellSet) -> Result<ZoneSides> + 'a;

/// The part of the mesh that deforms when the schedule names zones.
#[derive(Debug, Clone)]
pub struct DeformingZone {
    /// The volume cells of these zones.
    pub cells: CellSet,
    /// Its nodes, and the nodes that its parts share with other volume cells, which stay fixed.
    pub sides: ZoneSides,
    /// The zones that turn with each rotor, and those that do not turn.
    pub parts: Vec<ZonePart>,
}

/// A deforming part of the mesh that turns with one rotor, or does not turn.
#[derive(Debug, Clone)]
pub struct ZonePart {
    /// Its rotor; `None` if it does not turn.
    pub rotor: Option<usize>,
    /// Its volume cells.
    pub cells: CellSet,
    /// Its nodes, and the nodes that it shares with other volume cells.
    pub sides: ZoneSides,
}

impl DeformingZone {
    /// Returns whether a node is shared with volume cells outside these zones.
    pub fn is_interface(&self, node: u32) -> bool {
        self.sides.interface_nodes.binary_search(&node).is_ok()
    }

    /// Returns the part that contains a node.
    pub fn part_of(&self, node: u32) -> Option<&ZonePart> {
        let mut parts = self.parts.iter();
        parts.find(|part| part.sides.nodes.has(node))
    }

    /// Returns the zones of the schedule that deform. Without a name these are all zones that no body of `parts` moves, and
    /// `None` if that is the whole mesh.
    pub(super) fn find(
        schedule: &Schedule,
        rigid: &[RigidPart],
        boundary: &Boundary,
        sides_of: &SidesOf<'_>,
    ) -> Result<Option<Self>> {
        let mut found: Vec<(Option<usize>, CellSet)> = Vec::new();
        for (at, rotor) in schedule.rotors.iter().enumerate() {
            if rotor.zones.is_empty() {
                continue;
            }
            let (cells, places) = (cells_of(&rotor.zones, boundary)?, schedule.rotor_places(at));
            check_apart(schedule, rigid, &found, &cells)
                .map_err(|error| error.at(places.of("zones")))?;
            found.push((Some(at), cells));
        }
        let turns = |rotor: &Rotor| rotor.frame == Frame::Inertial;
        let is_only = found.is_empty() && schedule.rotors.len() == 1;
        let patterns = &schedule.boundaries.zones;
        let others = match (patterns.is_empty(), found.is_empty(), rigid.is_empty()) {
            (false, _, _) => Some(cells_of(patterns, boundary)?),
            (true, false, _) => None,
            (true, true, true) if is_only || !schedule.rotors.iter().any(turns) => return Ok(None),
            (true, true, _) => Some(rest_of(rigid, boundary.n_cells)),
        };
        if let Some(cells) = others {
            check_apart(schedule, rigid, &found, &cells)
                .map_err(|error| error.at(schedule.places.of("boundaries.zones")))?;
            let rotor = (is_only && turns(&schedule.rotors[0])).then_some(0);
            found.push((rotor, cells));
        }
        let parts = found.into_iter().map(|(rotor, cells)| {
            Ok(ZonePart {
                rotor,
                sides: sides_of(&cells)?,
                cells,
            })
        });
        let parts: Vec<ZonePart> = parts.collect::<Result<_>>()?;
        let (cells, sides) = match &parts[..] {
            [one] => (one.cells.clone(), one.sides.clone()),
            _ => {
                let cells = united(parts.iter().flat_map(|part| part.cells.ranges()));
                let sides = sides_of(&cells)?;
                (cells, sides)
            }
        };
        let mut zone = Self {
            cells,
            sides,
            parts,
        };
        zone.unite_interfaces();
        Ok(Some(zone))
    }

    /// Sets the interface of the zone to the interfaces of its parts.
    pub fn unite_interfaces(&mut self) {
        let nodes = self.parts.iter().flat_map(|part| {
            let sides = &part.sides;
            let places = sides.interface_places.iter().copied();
            sides.interface_nodes.iter().copied().zip(places)
        });
        let nodes: BTreeMap<u32, _> = nodes.collect();
        let sides = &mut self.sides;
        (sides.interface_nodes, sides.interface_places) = nodes.into_iter().unzip();
        sides.interface_faces = Cells::new();
        for part in &self.parts {
            sides.interface_faces.append(&part.sides.interface_faces);
        }
    }
}

/// Refuses cells that deform and move rigidly, or turn with two rotors.
fn check_apart(
    schedule: &Schedule,
    rigid: &[RigidPart],
    found: &[(Option<usize>, CellSet)],
    cells: &CellSet,
) -> Result<()> {
    if let Some(part) = rigid.iter().find(|part| overlap(&part.cells, cells)) {
        return Err(Error::input(format!(
            "`zones` has cells that move rigidly with body \"{}\"; leave its zones out, a cell cannot deform as well",
            schedule.bodies[part.body].name
        )));
    }
    match found.iter().find(|(_, other)| overlap(other, cells)) {
        Some((Some(rotor), _)) => Err(Error::input(format!(
            "`zones` has cells that turn with rotor \"{}\" already; a cell turns with one rotor",
            schedule.rotors[*rotor].name.as_deref().unwrap_or_default()
        ))),
        _ => Ok(()),
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
    Ok(united(ranges.into_iter()))
}

/// Returns the cells of ranges, which may overlap.
fn united(ranges: impl Iterator<Item = Range<usize>>) -> CellSet {
    let mut ranges: Vec<_> = ranges.collect();
    ranges.sort_unstable_by_key(|range| range.start);
    let (mut cells, mut end) = (CellSet::new(), 0);
    for range in ranges {
        cells.push_range(range.start.max(end)..range.end.max(end));
        end = end.max(range.end);
    }
    cells
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

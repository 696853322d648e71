//! The zones that a mesh is written in, and the markers of each.

use super::super::names::{Places, Rule, UniqueNames};
use super::EXCHANGE;
use crate::mesh::{Group, MeshView};
use std::collections::BTreeMap;
use std::ops::Range;

/// The mesh, cut into zones.
pub(super) struct WrittenZones {
    /// The zones, in the order in which they are written: the mesh's groups, or one zone, the whole mesh.
    pub zones: Vec<WrittenZone>,
    /// True if nodes are written in an order other than the mesh's.
    pub is_reordered: bool,
    /// Index of each node within its zone; `None` where that is its own.
    local: Option<Vec<u32>>,
}

pub(super) struct WrittenZone {
    /// The zone's cells, of the mesh's dimension.
    pub cells: Vec<Range<usize>>,
    /// The zone's nodes; `None` for all.
    pub nodes: Option<Vec<u32>>,
    /// The zone's markers.
    pub markers: Vec<Marker>,
}

/// The faces (and single nodes) of one name.
#[derive(Clone)]
pub(super) struct Marker {
    pub name: String,
    pub written: String,
    pub cells: Vec<Range<usize>>,
}

impl WrittenZones {
    /// The mesh as its zones, where these share no nodes, or as one.
    pub fn of(mesh: &MeshView) -> Self {
        let markers = markers(mesh);
        let zones: Vec<&Group> = mesh.zones().collect();
        if let Some(owner) = owners(mesh, &zones, &markers) {
            return Self::split(mesh, &zones, markers, &owner);
        }
        let (nodes, cells) = (None, mesh.volume_runs().map(|run| run.range()).collect());
        let whole = WrittenZone {
            cells,
            nodes,
            markers,
        };
        Self {
            zones: vec![whole],
            is_reordered: false,
            local: None,
        }
    }

    fn split(mesh: &MeshView, zones: &[&Group], markers: Vec<Marker>, owner: &[u32]) -> Self {
        let mut nodes: Vec<Vec<u32>> = vec![Vec::new(); zones.len()];
        let mut local = Vec::with_capacity(owner.len());
        for (node, &zone) in owner.iter().enumerate() {
            let nodes = &mut nodes[zone as usize];
            local.push(nodes.len() as u32);
            nodes.push(node as u32);
        }
        let mut own: Vec<Vec<Marker>> = vec![Vec::new(); zones.len()];
        for marker in markers {
            if marker.cells.is_empty() {
                own[0].push(marker);
                continue;
            }
            let mut of_zones: BTreeMap<u32, Vec<Range<usize>>> = BTreeMap::new();
            for cell in marker.cells.iter().cloned().flatten() {
                let zone = owner[mesh.cells.get(cell).nodes[0] as usize];
                let ranges = of_zones.entry(zone).or_default();
                match ranges.last_mut() {
                    Some(last) if last.end == cell => last.end += 1,
                    _ => ranges.push(cell..cell + 1),
                }
            }
            for (zone, cells) in of_zones {
                own[zone as usize].push(Marker {
                    cells,
                    ..marker.clone()
                });
            }
        }
        let parts = zones.iter().zip(nodes).zip(own);
        let zones = parts.map(|((group, nodes), markers)| WrittenZone {
            cells: group.cells.ranges().collect(),
            nodes: Some(nodes),
            markers,
        });
        Self {
            zones: zones.collect(),
            is_reordered: !owner.is_sorted(),
            local: Some(local),
        }
    }

    /// Index of a node within its zone.
    pub fn local(&self, node: u32) -> u32 {
        (self.local.as_ref()).map_or(node, |local| local[node as usize])
    }
}

/// Boundary tags and groups of single nodes; groups of one name together.
fn markers(mesh: &MeshView) -> Vec<Marker> {
    let mut names = UniqueNames::with([EXCHANGE]);
    let mut markers: Vec<Marker> = Vec::new();
    let mut places = Places::default();
    for group in of_markers(mesh) {
        let new = || Marker {
            name: group.name.clone(),
            written: String::new(),
            cells: Vec::new(),
        };
        let marker = places.entry(&*group.name, &mut markers, new);
        marker.cells.extend(group.cells.ranges());
    }
    let before: Vec<&str> = markers.iter().map(|marker| marker.name.as_str()).collect();
    let written = names.give_all(&before, &RULE);
    for (marker, written) in markers.iter_mut().zip(written) {
        marker.written = written;
    }
    markers
}

pub(super) fn of_markers<'a>(mesh: &MeshView<'a>) -> impl Iterator<Item = &'a Group> {
    let dimension = mesh.dimension();
    let is_marker = move |group: &&Group| group.dimension + 1 == dimension || group.dimension == 0;
    mesh.groups.iter().filter(is_marker)
}

/// Names as SU2 can read them: it ends one at white space.
pub(super) const RULE: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| {
        let is_odd = |c: char| c.is_whitespace() || c.is_control() || c == '%' || c == '=';
        match name {
            "" => "_".to_owned(),
            name => name.replace(is_odd, "_"),
        }
    },
    why: "names in SU2 have no spaces, % or =",
};

/// The zone of each node, where every cell of the mesh's dimension is in a zone and no node, by
/// cells or markers, in two. A node of no cell goes with the one before it.
fn owners(mesh: &MeshView, zones: &[&Group], markers: &[Marker]) -> Option<Vec<u32>> {
    const NOBODY: u32 = u32::MAX;
    let n_cells: usize = mesh.volume_runs().map(|run| run.n_cells()).sum();
    let n_in_zones: usize = zones.iter().map(|zone| zone.cells.len()).sum();
    if zones.len() < 2 || n_in_zones != n_cells {
        return None;
    }
    let mut owner = vec![NOBODY; mesh.points.len()];
    for (zone, group) in (0..).zip(zones) {
        let runs = group.cells.ranges().flat_map(|r| mesh.cells.runs_in(r));
        for &node in runs.flat_map(|run| run.connectivity) {
            let owner = &mut owner[node as usize];
            if *owner != NOBODY && *owner != zone {
                return None;
            }
            *owner = zone;
        }
    }
    let mut last = 0;
    for owner in &mut owner {
        last = if *owner == NOBODY { last } else { *owner };
        *owner = last;
    }
    let ranges = markers.iter().flat_map(|marker| &marker.cells).cloned();
    let mut runs = ranges.flat_map(|range| mesh.cells.runs_in(range));
    let is_whole = |nodes: &[u32]| {
        let first = owner[nodes[0] as usize];
        nodes.iter().all(|&node| owner[node as usize] == first)
    };
    runs.all(|run| run.cells().all(is_whole)).then_some(owner)
}

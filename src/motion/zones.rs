//! The zones that deform, and their interface to the rest of the mesh.

use super::names::Pattern;
use crate::error::Result;
use crate::mesh::{CellKind, CellRef, Cells, Mesh};

/// The part of the mesh that deforms when the schedule names zones.
#[derive(Debug, Clone)]
pub struct DeformingZone {
    /// For each node of the mesh, whether a cell of these zones has it.
    pub nodes: Vec<bool>,
    /// For each cell of the mesh, whether it is a volume cell of these zones.
    pub cells: Vec<bool>,
    /// Nodes shared with volume cells outside these zones, ascending. They stay fixed.
    pub interface_nodes: Vec<u32>,
    /// Linear faces whose nodes are all on the interface and that only one cell of the zones has.
    pub interface_faces: Cells,
}

impl DeformingZone {
    /// Whether a node is shared with volume cells outside these zones.
    pub fn is_interface(&self, node: u32) -> bool {
        self.interface_nodes.binary_search(&node).is_ok()
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
        let (nodes, interface) = nodes_in_and_between(mesh, &cells);
        let interface_faces = faces_between(mesh, &cells, &interface);
        let interface_nodes = (0..interface.len() as u32)
            .filter(|&node| interface[node as usize])
            .collect();
        Ok(Some(Self {
            nodes,
            cells,
            interface_nodes,
            interface_faces,
        }))
    }
}

/// Nodes of the cells marked, and those of them that other volume cells have as well.
fn nodes_in_and_between(mesh: &Mesh, marked: &[bool]) -> (Vec<bool>, Vec<bool>) {
    let mut inside = vec![false; mesh.points.len()];
    let mut outside = vec![false; mesh.points.len()];
    for run in mesh.volume_runs() {
        for (nodes, &marked) in run.cells().zip(&marked[run.first_cell..]) {
            let side = if marked { &mut inside } else { &mut outside };
            for &node in nodes {
                side[node as usize] = true;
            }
        }
    }
    for (outside, &inside) in outside.iter_mut().zip(&inside) {
        *outside &= inside;
    }
    (inside, outside)
}

fn faces_between(mesh: &Mesh, marked: &[bool], interface: &[bool]) -> Cells {
    let on = |nodes: &[u32]| nodes.iter().all(|&node| interface[node as usize]);
    let mut faces: Vec<(Vec<u32>, Vec<u32>)> = Vec::new();
    for run in mesh.volume_runs() {
        for (i, nodes) in run.cells().enumerate() {
            let index = run.first_cell + i;
            if !marked[index] || !nodes.iter().any(|&node| interface[node as usize]) {
                continue;
            }
            let cell = CellRef {
                index,
                kind: run.kind,
                nodes,
            };
            let on_interface = faces_of(mesh, &cell).into_iter().filter(|face| on(face));
            faces.extend(on_interface.map(|face| {
                let mut key = face.clone();
                key.sort_unstable();
                (key, face)
            }));
        }
    }
    faces.sort_unstable();
    let mut single = Cells::new();
    for same in faces.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, face)] = same {
            let kind = match face.len() {
                1 => CellKind::Vertex,
                2 => CellKind::Line,
                3 => CellKind::Triangle,
                4 => CellKind::Quadrilateral,
                _ => CellKind::Polygon,
            };
            single.push(kind, face);
        }
    }
    single
}

/// Corner nodes of each face of a volume cell (of each edge in 2D).
fn faces_of(mesh: &Mesh, cell: &CellRef<'_>) -> Vec<Vec<u32>> {
    match cell.kind {
        CellKind::Polyhedron => mesh
            .cells
            .polyhedron_faces(cell.index)
            .map(<[u32]>::to_vec)
            .collect(),
        CellKind::Polygon | CellKind::QuadraticPolygon => {
            let n = cell.kind.n_corners(cell.nodes.len());
            let side = |i| vec![cell.nodes[i], cell.nodes[(i + 1) % n]];
            (0..n).map(side).collect()
        }
        kind => {
            let corners = |face: &&[u8]| face.iter().map(|&i| cell.nodes[i as usize]).collect();
            kind.faces().iter().map(corners).collect()
        }
    }
}

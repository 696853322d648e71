//! The zones that deform, and their interface to the rest of the mesh.

use super::names::Pattern;
use crate::error::Result;
use crate::mesh::sides::for_each_side;
use crate::mesh::{CellKind, Cells, Faces, Mesh};

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

/// Faces of one of the marked cells only, all on the interface, in the order of their nodes.
fn faces_between(mesh: &Mesh, marked: &[bool], interface: &[bool]) -> Cells {
    let is_on = |node: &u32| interface[*node as usize];
    let faces = Faces::of_cells(mesh, |cell| {
        marked[cell.index] && cell.nodes.iter().any(is_on)
    });
    let mut found: Vec<(Vec<u32>, Vec<u32>)> = Vec::new();
    for outer in &faces.outer {
        let cell = mesh.cells.get(outer.cell as usize);
        for_each_side(&mesh.cells, &cell, |face, corners| {
            if face == outer.face as usize && corners.iter().all(is_on) {
                let mut key = corners.to_vec();
                key.sort_unstable();
                found.push((key, corners.to_vec()));
            }
        });
    }
    found.sort_unstable();
    let mut single = Cells::new();
    for (_, face) in found {
        let kind = match face.len() {
            1 => CellKind::Vertex,
            2 => CellKind::Line,
            3 => CellKind::Triangle,
            4 => CellKind::Quadrilateral,
            _ => CellKind::Polygon,
        };
        single.push(kind, &face);
    }
    single
}

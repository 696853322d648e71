//! The faces of all polyhedra, each once, with the element numbers that CGNS gives them.

use super::plan::{Numbering, is_polygon};
use crate::mesh::{CellKind, MeshView};
use azimesh_core::parallel::{collect, sort};

/// Faces of polyhedra.
#[derive(Default)]
pub(super) struct FaceTable {
    /// Element number of the first face that is no cell.
    pub first_element: usize,
    /// For each face that is no cell the start of its nodes, and the end of the last.
    pub starts: Vec<usize>,
    pub nodes: Vec<u32>,
    /// Cell index of each polyhedron, ascending, and where its faces start in `used`.
    polyhedra: Vec<(u32, usize)>,
    /// Element numbers of the faces of each polyhedron, below zero where the face is turned round.
    used: Vec<i64>,
}

/// A face in its first use: of a polygon cell, or of a polyhedron.
struct Met<'a> {
    nodes: &'a [u32],
    /// Element number of a polygon cell.
    cell: Option<usize>,
}

impl FaceTable {
    /// Numbers the faces of a mesh.
    pub fn of(mesh: &MeshView, numbering: &Numbering) -> Self {
        let mut table = Self {
            first_element: mesh.cells.len() + 1,
            starts: vec![0],
            ..Self::default()
        };
        if !mesh.cells.has_polyhedra() {
            return table;
        }
        let met = table.meet(mesh, numbering);
        let first_of = first_alike(&met);
        let mut numbers = vec![0_i64; met.len()];
        let n_cells = met.iter().filter(|face| face.cell.is_some()).count();
        for (i, face) in met.iter().enumerate() {
            let first = first_of[i];
            if first == i {
                numbers[i] = match face.cell {
                    Some(element) => element as i64,
                    None => table.add(face.nodes),
                };
            } else {
                let sign = if is_turned(met[first].nodes, face.nodes) {
                    -1
                } else {
                    1
                };
                numbers[i] = sign * numbers[first];
            }
        }
        table.used = numbers.split_off(n_cells);
        table
    }

    /// All polygon cells, then the faces of all polyhedra.
    fn meet<'a>(&mut self, mesh: &'a MeshView<'a>, numbering: &'a Numbering) -> Vec<Met<'a>> {
        let mut met: Vec<Met> = Vec::new();
        for run in mesh.cells.runs().filter(|run| is_polygon(mesh, run.kind)) {
            met.extend(run.cell_refs().map(|cell| Met {
                nodes: cell.nodes,
                cell: Some(numbering.element(cell.index)),
            }));
        }
        let n_polygons = met.len();
        let runs = mesh.cells.runs();
        let polyhedra = runs.filter(|run| run.kind == CellKind::Polyhedron);
        for cell in polyhedra.flat_map(|run| run.range()) {
            self.polyhedra.push((cell as u32, met.len() - n_polygons));
            let faces = mesh.cells.polyhedron_faces(cell);
            met.extend(faces.map(|nodes| Met { nodes, cell: None }));
        }
        met
    }

    fn add(&mut self, nodes: &[u32]) -> i64 {
        let element = self.first_element + self.len();
        self.nodes.extend(nodes);
        self.starts.push(self.nodes.len());
        element as i64
    }

    /// Number of faces that are no cells.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Numbers of the faces of a polyhedron.
    pub fn of_polyhedron(&self, mesh: &MeshView, cell: usize) -> &[i64] {
        let at = (self.polyhedra).binary_search_by_key(&(cell as u32), |(cell, _)| *cell);
        let start = self.polyhedra[at.expect("it is a polyhedron")].1;
        &self.used[start..start + mesh.cells.n_faces(cell)]
    }
}

/// For each face the first one with the same nodes.
fn first_alike(met: &[Met]) -> Vec<usize> {
    let mut keyed = collect(met.len(), |i| (key(met[i].nodes), i as u32));
    sort(&mut keyed);
    let mut first_of: Vec<usize> = (0..met.len()).collect();
    for alike in keyed.chunk_by(|a, b| a.0 == b.0) {
        for (k, &(_, i)) in alike.iter().enumerate() {
            let mut before = alike[..k].iter().map(|(_, first)| *first as usize);
            let same = before.find(|first| has_same(met[*first].nodes, met[i as usize].nodes));
            if let Some(first) = same {
                first_of[i as usize] = first;
            }
        }
    }
    first_of
}

/// A number that does not depend on the order of the nodes.
fn key(nodes: &[u32]) -> u64 {
    nodes.iter().fold(0_u64, |sum, &node| {
        let mixed = (u64::from(node) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        sum.wrapping_add((mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9))
    })
}

fn has_same(a: &[u32], b: &[u32]) -> bool {
    a.len() == b.len() && b.iter().all(|node| a.contains(node))
}

/// Tests if a face with the same nodes goes round the other way.
fn is_turned(face: &[u32], other: &[u32]) -> bool {
    let after = |nodes: &[u32], node: u32| {
        let at = nodes.iter().position(|&n| n == node)?;
        Some(nodes[(at + 1) % nodes.len()])
    };
    after(other, face[0]) != after(face, face[0])
}

//! The faces of all polyhedra, each once, with the element numbers that CGNS gives them.

use super::plan::{Numbering, is_polygon};
use crate::mesh::{CellKind, MeshView, turn_outward};
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
    /// True if it goes round inward in its polyhedron.
    is_inward: bool,
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
            let number = match (first == i, face.cell) {
                (true, Some(element)) => element as i64,
                (true, None) => table.add(face.nodes),
                _ => numbers[first].abs(),
            };
            let is_turned = first != i && is_turned(met[first].nodes, face.nodes);
            numbers[i] = if is_turned != face.is_inward {
                -number
            } else {
                number
            };
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
                is_inward: false,
            }));
        }
        let n_polygons = met.len();
        let runs = mesh.cells.runs();
        let polyhedra = runs.filter(|run| run.kind == CellKind::Polyhedron);
        for cell in polyhedra.flat_map(|run| run.range()) {
            self.polyhedra.push((cell as u32, met.len() - n_polygons));
            let faces: Vec<&[u32]> = mesh.cells.polyhedron_faces(cell).collect();
            let mut outward: Vec<Vec<u32>> = faces.iter().map(|face| face.to_vec()).collect();
            if faces
                .iter()
                .copied()
                .flatten()
                .all(|&node| (node as usize) < mesh.points.len())
            {
                turn_outward(&mut outward, mesh.points);
            }
            met.extend(faces.iter().zip(&outward).map(|(nodes, outward)| Met {
                nodes,
                cell: None,
                is_inward: is_turned(nodes, outward),
            }));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn faces_that_go_round_inward_are_negative() {
        let corner = |i: u32| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)];
        let outward = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        for (is_reversed, sign) in [(false, 1), (true, -1)] {
            let mut mesh = Mesh::of_points((0..8).map(corner).collect());
            let mut stream = vec![6];
            for mut face in outward {
                if is_reversed {
                    face.reverse();
                }
                stream.push(4);
                stream.extend(face);
            }
            mesh.cells.push_polyhedron(&stream).expect("it is a cube");
            let view = mesh.view();
            let table = FaceTable::of(&view, &Numbering::of(&view));
            let expected: Vec<i64> = (2..8).map(|face| sign * face).collect();
            assert_eq!(table.of_polyhedron(&view, 0), expected);
        }
    }
}

//! Kinds of cells from their faces: tetrahedra, hexahedra, wedges and pyramids in VTK's order of nodes, else polyhedra.
//!
//! A kind is taken only where every face is one of its faces and turns outward, as OpenFOAM's own shapes are found. Its
//! shapes with a collapsed edge (`wedge`, `tetWedge`) are polyhedra.

use super::cells::INWARD;
use super::faces::{FacesView, Label};
use super::uniform::{hexahedron, tetrahedron};
use crate::mesh::{CellKind, Cells};
use azimesh_core::error::Result;

/// The few faces of a cell that may be a simple one, turned outward.
struct Outward {
    faces: [[u32; 4]; 6],
    sizes: [u8; 6],
    n: usize,
}

/// Appends the cell that has these faces, with [`INWARD`] where they point into it. `stream` is memory that is used again.
pub(in crate::formats) fn push(
    cells: &mut Cells,
    faces: FacesView,
    of_cell: &[u32],
    stream: &mut Vec<u32>,
) -> Result<()> {
    if let Some(outward) = Outward::new(faces, of_cell)
        && let Some((kind, nodes)) = outward.shape()
    {
        cells.push(kind, &nodes[..kind.n_nodes().unwrap_or(0)]);
        return Ok(());
    }
    stream.clear();
    let value = |node: &Label| node.get();
    stream.push(of_cell.len() as u32);
    for face in of_cell {
        let nodes = faces.get((face & !INWARD) as usize);
        stream.push(nodes.len() as u32);
        if face & INWARD == 0 {
            stream.extend(nodes.iter().map(value));
        } else {
            stream.push(nodes[0].get());
            stream.extend(nodes[1..].iter().rev().map(value));
        }
    }
    cells.push_polyhedron(stream)
}

impl Outward {
    /// `None` where there are more faces, or larger ones, than any simple cell has.
    fn new(faces: FacesView, of_cell: &[u32]) -> Option<Self> {
        if of_cell.len() > 6 {
            return None;
        }
        let mut outward = Self {
            faces: [[0; 4]; 6],
            sizes: [0; 6],
            n: of_cell.len(),
        };
        for (i, face) in of_cell.iter().enumerate() {
            let nodes = faces.get((face & !INWARD) as usize);
            let n = nodes.len();
            let turned = outward.faces[i].get_mut(..n)?;
            for (own, node) in turned.iter_mut().zip(nodes) {
                *own = node.get();
            }
            if face & INWARD != 0 {
                turned[1..].reverse();
            }
            outward.sizes[i] = n as u8;
        }
        Some(outward)
    }

    fn get(&self, face: usize) -> &[u32] {
        &self.faces[face][..usize::from(self.sizes[face])]
    }

    /// The kind of cell and its nodes.
    fn shape(&self) -> Option<(CellKind, [u32; 8])> {
        let mut nodes = [u32::MAX; 8];
        let of_size = |n: u8| self.sizes.iter().filter(|size| **size == n).count();
        let kind = match (self.n, of_size(3), of_size(4)) {
            (4, 4, 0) => {
                let triangles = [0, 1, 2, 3].map(|i| self.faces[i].as_chunks::<3>().0[0]);
                nodes[..4].copy_from_slice(&tetrahedron(triangles)?);
                return Some((CellKind::Tetrahedron, nodes));
            }
            (6, 0, 6) => return Some((CellKind::Hexahedron, hexahedron(self.faces)?)),
            (5, 4, 1) => CellKind::Pyramid,
            (5, 2, 3) => CellKind::Wedge,
            _ => return None,
        };
        let n = if kind == CellKind::Pyramid { 4 } else { 3 };
        let base = self.sizes.iter().position(|size| usize::from(*size) == n)?;
        // Seen from inside, the base turns the other way.
        for (own, node) in nodes.iter_mut().zip(self.get(base).iter().rev()) {
            *own = *node;
        }
        if kind == CellKind::Pyramid {
            let is_apex = |node: &&u32| !nodes[..n].contains(*node);
            let other = self.get(usize::from(base == 0));
            nodes[n] = *other.iter().find(is_apex)?;
        } else {
            self.raise(&mut nodes)?;
        }
        self.is_of(kind, &nodes[..kind.n_nodes()?])
            .then_some((kind, nodes))
    }

    /// The upper nodes of a wedge, by the quadrilaterals on its sides.
    fn raise(&self, nodes: &mut [u32; 8]) -> Option<()> {
        let mut n_sides = 0;
        for (face, _) in self.faces.iter().zip(self.sizes).filter(|side| side.1 == 4) {
            for corner in 0..4 {
                let edge = [face[corner], face[(corner + 1) % 4]];
                if let Some(i) = (0..3).find(|i| [nodes[*i], nodes[(i + 1) % 3]] == edge) {
                    nodes[3 + (i + 1) % 3] = face[(corner + 2) % 4];
                    n_sides += 1;
                }
            }
        }
        (n_sides == 3).then_some(())
    }

    /// Checks if the faces are the faces of a kind with these nodes, each once.
    fn is_of(&self, kind: CellKind, nodes: &[u32]) -> bool {
        let mut found = 0u32;
        for face in (0..self.n).map(|face| self.get(face)) {
            let mut table = kind.faces().iter();
            match table.position(|expected| is_turned(face, expected, nodes)) {
                Some(place) => found |= 1 << place,
                None => return false,
            }
        }
        let is_distinct = (1..nodes.len()).all(|i| !nodes[..i].contains(&nodes[i]));
        found == (1 << kind.faces().len()) - 1 && is_distinct
    }
}

/// Checks if the corners of a face are these corners of a cell in this order, starting at any of them.
fn is_turned(face: &[u32], expected: &[u8], nodes: &[u32]) -> bool {
    let n = expected.len();
    let at = |i: usize| nodes[usize::from(expected[i % n])];
    let start = (0..n).find(|start| at(*start) == face[0]);
    face.len() == n && start.is_some_and(|start| (1..n).all(|i| face[i] == at(start + i)))
}

#[cfg(test)]
mod tests {
    use super::super::faces::Faces;
    use super::*;

    fn built(faces: &[&[u32]], owner: &[u32], cell: u32) -> Cells {
        let mut list = Faces::default();
        for face in faces {
            list.push(face.iter().copied());
        }
        let number = |face: usize| {
            if owner[face] == cell {
                face as u32
            } else {
                face as u32 | INWARD
            }
        };
        let of_cell: Vec<u32> = (0..faces.len()).map(number).collect();
        let mut cells = Cells::new();
        push(&mut cells, list.view(), &of_cell, &mut Vec::new()).expect("a cell");
        cells
    }

    /// The faces of a kind, with its nodes called by these numbers, some of them turned round and given to another owner.
    fn pulled_apart(table: &[&[u8]], names: &[u32], reversed: u32) -> (Vec<Vec<u32>>, Vec<u32>) {
        let mut owner = Vec::new();
        let faces = table.iter().enumerate().map(|(i, face)| {
            let mut nodes: Vec<u32> = face
                .iter()
                .map(|corner| names[usize::from(*corner)])
                .collect();
            nodes.rotate_left(i % 3);
            let is_reversed = reversed >> i & 1 == 1;
            owner.push(if is_reversed { 3 } else { 7 });
            if is_reversed {
                nodes.reverse();
            }
            nodes
        });
        (faces.collect(), owner)
    }

    #[test]
    fn a_cell_is_found_from_its_faces_whichever_way_they_turn() {
        let names = [40, 11, 27, 3, 9, 55, 8, 21];
        for kind in [
            CellKind::Tetrahedron,
            CellKind::Pyramid,
            CellKind::Wedge,
            CellKind::Hexahedron,
        ] {
            let table = kind.faces();
            for reversed in 0..1 << table.len() {
                let (faces, owner) = pulled_apart(table, &names, reversed);
                let faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
                let cells = built(&faces, &owner, 7);
                let cell = cells.get(0);
                assert_eq!(cell.kind, kind);
                // It has the faces that it was made from, outward: as its own table says.
                for expected in table {
                    let nodes: Vec<u32> = expected
                        .iter()
                        .map(|i| cell.nodes[usize::from(*i)])
                        .collect();
                    let is_same = |(face, owner): (&&[u32], &u32)| {
                        let mut turned = face.to_vec();
                        if *owner != 7 {
                            turned.reverse();
                        }
                        let start = turned.iter().position(|node| *node == nodes[0]);
                        start.is_some_and(|start| {
                            turned.rotate_left(start);
                            turned == nodes
                        })
                    };
                    assert!(
                        faces.iter().zip(&owner).any(is_same),
                        "{kind:?} {reversed} {nodes:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn faces_that_make_no_simple_cell_make_a_polyhedron() {
        // A face turned inward; a cube with one divided face; a hexahedron with an edge of no length.
        let inward: &[&[u32]] = &[&[0, 1, 2], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];
        let divided: &[&[u32]] = &[
            &[0, 3, 2, 1],
            &[4, 5, 6],
            &[4, 6, 7],
            &[0, 1, 5, 4],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[3, 0, 4, 7],
        ];
        let collapsed: &[&[u32]] = &[
            &[0, 2, 1],
            &[3, 4, 5, 6],
            &[0, 3, 6],
            &[1, 2, 5, 4],
            &[0, 1, 4, 3],
            &[0, 6, 5, 2],
        ];
        for faces in [inward, divided, collapsed] {
            let cells = built(faces, &[0; 7], 0);
            assert_eq!(cells.get(0).kind, CellKind::Polyhedron);
            let found: Vec<&[u32]> = cells.polyhedron_faces(0).collect();
            assert_eq!(found, faces);
        }
        // The neighbour of all of its faces sees them from the other side.
        let cells = built(divided, &[0; 7], 1);
        let found: Vec<&[u32]> = cells.polyhedron_faces(0).collect();
        assert_eq!(found[1], [4, 6, 5]);
    }
}

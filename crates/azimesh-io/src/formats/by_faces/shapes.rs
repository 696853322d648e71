//! What kind of cell faces make: tetrahedra, hexahedra, wedges and pyramids in VTK's order of nodes, else polyhedra.
//!
//! A kind is taken only where every face is one of its faces and turns outward, as OpenFOAM's own shapes are found. Its
//! shapes with a collapsed edge (`wedge`, `tetWedge`) are polyhedra.

use super::cells::INWARD;
use super::faces::FacesView;
use super::labels::Label;
use crate::mesh::{CellKind, Cells};
use azimesh_core::error::Result;

/// Faces by the corners of the cell, outward.
type Table = &'static [&'static [u8]];

const TETRAHEDRON: Table = &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];
const PYRAMID: Table = &[
    &[0, 3, 2, 1],
    &[0, 1, 4],
    &[1, 2, 4],
    &[2, 3, 4],
    &[3, 0, 4],
];
const WEDGE: Table = &[
    &[0, 2, 1],
    &[3, 4, 5],
    &[0, 1, 4, 3],
    &[1, 2, 5, 4],
    &[2, 0, 3, 5],
];
const HEXAHEDRON: Table = &[
    &[0, 3, 2, 1],
    &[4, 5, 6, 7],
    &[0, 1, 5, 4],
    &[1, 2, 6, 5],
    &[2, 3, 7, 6],
    &[3, 0, 4, 7],
];

/// Memory that is used again from cell to cell.
#[derive(Default)]
pub(in crate::formats) struct Scratch {
    stream: Vec<u32>,
}

/// The few faces of a cell that may be a simple one, turned outward.
struct Outward {
    faces: [[u32; 4]; 6],
    sizes: [u8; 6],
    n: usize,
}

/// Appends the cell that has these faces, with [`INWARD`] where they point into it.
pub(in crate::formats) fn push(
    cells: &mut Cells,
    faces: FacesView,
    of_cell: &[u32],
    scratch: &mut Scratch,
) -> Result<()> {
    if let Some(nodes) = tetrahedron(faces, of_cell) {
        cells.push(CellKind::Tetrahedron, &nodes);
        return Ok(());
    }
    if let Some(outward) = Outward::new(faces, of_cell)
        && let Some((kind, nodes)) = outward.shape()
    {
        cells.push(kind, &nodes[..kind.n_nodes().unwrap_or(0)]);
        return Ok(());
    }
    let stream = &mut scratch.stream;
    stream.clear();
    let value = |node: &Label| node.get();
    stream.push(of_cell.len() as u32);
    for face in of_cell {
        let nodes = faces.get((face & !INWARD) as usize);
        stream.push(nodes.len() as u32);
        match face & INWARD == 0 {
            true => stream.extend(nodes.iter().map(value)),
            false => {
                stream.push(nodes[0].get());
                stream.extend(nodes[1..].iter().rev().map(value));
            }
        }
    }
    cells.push_polyhedron(stream)
}

/// The nodes of a tetrahedron: the base seen from inside, then the apex.
#[inline]
fn tetrahedron(faces: FacesView, of_cell: &[u32]) -> Option<[u32; 4]> {
    let &[base, ref sides @ ..] = of_cell else {
        return None;
    };
    let triangle = |face: u32| match (faces.get((face & !INWARD) as usize), face & INWARD) {
        (&[a, b, c], 0) => Some([a.get(), b.get(), c.get()]),
        (&[a, b, c], _) => Some([a.get(), c.get(), b.get()]),
        _ => None,
    };
    let &[first, second, third] = sides else {
        return None;
    };
    let [c, b, a] = triangle(base)?;
    let sides = [triangle(first)?, triangle(second)?, triangle(third)?];
    let apex = sides[0]
        .into_iter()
        .find(|node| ![a, b, c].contains(node))?;
    let mut found = 0;
    for [x, y, z] in sides {
        // The edge that a side has on the base.
        let edge = match apex {
            _ if apex == z => (x, y),
            _ if apex == x => (y, z),
            _ if apex == y => (z, x),
            _ => return None,
        };
        let edges = [(a, b), (b, c), (c, a)];
        found |= 1 << edges.iter().position(|known| *known == edge)?;
    }
    let is_whole = found == 0b111 && a != b && b != c && c != a;
    is_whole.then_some([a, b, c, apex])
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
        let sizes = self.sizes[..self.n].iter();
        let n_triangles = sizes.filter(|size| **size == 3).count();
        let (kind, base, table) = match (self.n, n_triangles) {
            (4, 4) => (CellKind::Tetrahedron, 3, TETRAHEDRON),
            (5, 4) => (CellKind::Pyramid, 4, PYRAMID),
            (5, 2) => (CellKind::Wedge, 3, WEDGE),
            (6, 0) => (CellKind::Hexahedron, 4, HEXAHEDRON),
            _ => return None,
        };
        let first = self.sizes[..self.n].iter().position(|size| *size == base)?;
        let mut nodes = [u32::MAX; 8];
        // Seen from inside, the base turns the other way.
        let n = usize::from(base);
        for (i, node) in self.get(first).iter().rev().enumerate() {
            nodes[i] = *node;
        }
        match kind {
            CellKind::Tetrahedron | CellKind::Pyramid => {
                let is_apex = |node: &&u32| !nodes[..n].contains(*node);
                let other = self.get(usize::from(first == 0));
                nodes[n] = *other.iter().find(is_apex)?;
            }
            _ => self.raise(first, n, &mut nodes)?,
        }
        self.is_of(&nodes[..kind.n_nodes()?], table)
            .then_some((kind, nodes))
    }

    /// The nodes above those of the base, by the quadrilaterals on its sides.
    fn raise(&self, base: usize, n: usize, nodes: &mut [u32; 8]) -> Option<()> {
        let mut n_sides = 0;
        for side in (0..self.n).filter(|side| *side != base && self.sizes[*side] == 4) {
            let face = self.faces[side];
            for corner in 0..4 {
                let [from, to] = [face[corner], face[(corner + 1) % 4]];
                let place = (0..n).find(|i| nodes[*i] == from && nodes[(*i + 1) % n] == to);
                if let Some(place) = place {
                    nodes[n + (place + 1) % n] = face[(corner + 2) % 4];
                    n_sides += 1;
                }
            }
        }
        (n_sides == n).then_some(())
    }

    /// Whether the faces are those of a kind with these nodes, each once.
    fn is_of(&self, nodes: &[u32], table: Table) -> bool {
        let mut found = 0u32;
        for face in 0..self.n {
            let mut local = [0u8; 4];
            let face = self.get(face);
            for (local, node) in local.iter_mut().zip(face) {
                let mut place = u8::MAX;
                for (i, own) in nodes.iter().enumerate() {
                    if own == node {
                        place = i as u8;
                    }
                }
                *local = place;
            }
            let local = &local[..face.len()];
            match table.iter().position(|expected| is_turned(local, expected)) {
                Some(place) => found |= 1 << place,
                None => return false,
            }
        }
        found == (1 << table.len()) - 1
    }
}

/// Whether two faces are the same from some corner on.
fn is_turned(face: &[u8], expected: &[u8]) -> bool {
    let n = expected.len();
    if face.len() != n {
        return false;
    }
    let Some(start) = expected.iter().position(|corner| *corner == face[0]) else {
        return false;
    };
    (1..n).all(|i| face[i] == expected[(start + i) % n])
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
        let number = |face: usize| match owner[face] == cell {
            true => face as u32,
            false => face as u32 | INWARD,
        };
        let of_cell: Vec<u32> = (0..faces.len()).map(number).collect();
        let mut cells = Cells::new();
        push(&mut cells, list.view(), &of_cell, &mut Scratch::default()).expect("a cell");
        cells
    }

    /// The faces of a kind, with its nodes called by these numbers, some of them turned round and given to another owner.
    fn pulled_apart(table: Table, names: &[u32], reversed: u32) -> (Vec<Vec<u32>>, Vec<u32>) {
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
        for (kind, table) in [
            (CellKind::Tetrahedron, TETRAHEDRON),
            (CellKind::Pyramid, PYRAMID),
            (CellKind::Wedge, WEDGE),
            (CellKind::Hexahedron, HEXAHEDRON),
        ] {
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
        // A face turned inward; a cube of which one face is divided; a hexahedron with an edge of no length.
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

//! Collapsed cells, which list a node twice: a hexahedron with a collapsed edge is a wedge, and so on.

use super::CellKind::{self, *};
use super::sides::flat;
use super::{CellRef, CellSet, Cells, Mesh, Origin};

impl CellRef<'_> {
    /// Returns the cell that the remaining faces of a collapsed cell bound: a tetrahedron, pyramid, wedge or polyhedron; a triangle
    /// for a quadrilateral. `None` for other cells, and if the faces bound nothing.
    pub fn uncollapsed(&self) -> Option<Cells> {
        if !self.is_collapsed() {
            return None;
        }
        let mut one = Cells::new();
        if self.kind.dimension() == 2 {
            let corners = ring(self.nodes.iter().copied());
            return (corners.len() == 3 && is_simple(&corners)).then(|| {
                one.push(Triangle, &corners);
                one
            });
        }
        let faces = self.kind.faces().iter();
        let faces = faces.map(|face| ring(face.iter().map(|&i| self.nodes[usize::from(i)])));
        let faces = without_folds(faces.filter(|face| face.len() > 2).collect());
        if faces.len() < 4 || !faces.iter().all(|face| is_simple(face)) {
            return None;
        }
        match known(&faces) {
            Some((kind, nodes)) if has_faces(kind, &nodes, &faces) => one.push(kind, &nodes),
            _ => {
                let mut stream = vec![faces.len() as u32];
                for face in &faces {
                    stream.push(face.len() as u32);
                    stream.extend(face);
                }
                one.push_polyhedron(&stream).ok()?;
            }
        }
        Some(one)
    }

    /// Returns whether a straight cell has an edge between a node and itself.
    fn is_collapsed(&self) -> bool {
        !self.kind.is_curved() && self.has_collapsed_edge()
    }

    fn has_collapsed_edge(&self) -> bool {
        let is_point =
            |edge: &[u8; 2]| self.nodes[usize::from(edge[0])] == self.nodes[usize::from(edge[1])];
        self.kind.edges().iter().any(is_point)
    }
}

/// Counts of [`Mesh::uncollapse`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Uncollapsed {
    /// Replaced cells and boundary faces.
    pub n_cells: usize,
    /// Removed boundary faces, which had collapsed to lines.
    pub n_gone: usize,
    /// Collapsed cells whose faces bound nothing; they are kept.
    pub n_left: usize,
    /// Curved cells with a collapsed edge; they are kept.
    pub n_curved: usize,
}

impl Mesh {
    /// Replaces collapsed cells and boundary faces by the cells that they are. Cells are renumbered only if boundary faces are removed.
    pub fn uncollapse(&mut self) -> Uncollapsed {
        let mut counts = Uncollapsed::default();
        let dimension = self.dimension();
        let mut cells = Cells::new();
        cells.reserve(self.cells.connectivity().len());
        let mut gone = CellSet::new();
        for run in self.cells.runs() {
            if run.kind.is_curved() {
                let collapsed = run.cell_refs().filter(CellRef::has_collapsed_edge);
                counts.n_curved += collapsed.count();
            }
            if !run.cell_refs().any(|cell| cell.is_collapsed()) {
                cells.append(&self.cells.select_runs(&[run.range()]));
                continue;
            }
            for cell in run.cell_refs() {
                let own = || self.cells.select([cell.index]);
                match (cell.is_collapsed(), cell.uncollapsed()) {
                    (true, Some(one)) => {
                        cells.append(&one);
                        counts.n_cells += 1;
                    }
                    (true, None) if cell.kind.dimension() < dimension => {
                        cells.append(&own());
                        gone.push(cell.index);
                    }
                    (is_left, _) => {
                        cells.append(&own());
                        counts.n_left += usize::from(is_left);
                    }
                }
            }
        }
        if counts.n_cells + gone.len() > 0 {
            self.cells = cells;
            self.origin = Origin::default();
            counts.n_gone = gone.len();
            let keep: Vec<usize> = (0..self.cells.len())
                .filter(|cell| !gone.contains(*cell))
                .collect();
            self.keep_cells(&keep);
        }
        counts
    }
}

/// Returns the nodes around a face, without repeated neighbours.
fn ring(nodes: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut ring: Vec<u32> = nodes.collect();
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    ring
}

/// Returns whether each node is listed once.
fn is_simple(face: &[u32]) -> bool {
    (1..face.len()).all(|i| !face[..i].contains(&face[i]))
}

fn sorted(face: &[u32]) -> Vec<u32> {
    let mut nodes = face.to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Removes coincident pairs of faces, and faces that have collapsed to a line.
fn without_folds(faces: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    let keys: Vec<Vec<u32>> = faces.iter().map(|face| sorted(face)).collect();
    let is_alone = |at: usize| {
        let same = keys.iter().filter(|key| **key == keys[at]);
        keys[at].len() > 2 && same.count() == 1
    };
    let kept = (0..faces.len()).filter(|&at| is_alone(at));
    kept.map(|at| faces[at].clone()).collect()
}

/// Returns the tetrahedron, pyramid, wedge or hexahedron of these faces, if they have its orientation.
fn known(faces: &[Vec<u32>]) -> Option<(CellKind, Vec<u32>)> {
    let n_nodes = sorted(&faces.concat()).len();
    let mut triangles = faces.iter().filter(|face| flat(face.len()) == Triangle);
    let quads = || faces.iter().filter(|face| face.len() == 4);
    let apart = |face: &[u32]| {
        let all = faces.iter().flatten().copied();
        all.into_iter().find(|node| !face.contains(node))
    };
    match (faces.len(), quads().count(), n_nodes) {
        (4, 0, 4) => {
            let [a, b, c] = *triangles.next()?.first_chunk()?;
            Some((Tetrahedron, vec![a, c, b, apart(&[a, b, c])?]))
        }
        (5, 1, 5) => {
            let [a, b, c, d] = *quads().next()?.first_chunk()?;
            Some((Pyramid, vec![a, d, c, b, apart(&[a, b, c, d])?]))
        }
        (5, 3, 6) => {
            let (low, high) = (triangles.next()?, triangles.next()?);
            let over = |node: u32| {
                let edges = quads().flat_map(|quad| (0..4).map(|i| [quad[i], quad[(i + 1) % 4]]));
                let mut beside = edges.filter_map(|[a, b]| match node {
                    node if node == a => Some(b),
                    node if node == b => Some(a),
                    _ => None,
                });
                beside.find(|other| high.contains(other))
            };
            let base = [low[0], low[2], low[1]];
            let top = base.map(over).into_iter().collect::<Option<Vec<u32>>>()?;
            is_simple(&top).then(|| (Wedge, [&base[..], &top].concat()))
        }
        _ => None,
    }
}

/// Returns whether these are the faces of such a cell; a quadrilateral may also fold onto a neighbouring triangle.
fn has_faces(kind: CellKind, nodes: &[u32], faces: &[Vec<u32>]) -> bool {
    let keys: Vec<Vec<u32>> = faces.iter().map(|face| sorted(face)).collect();
    let of_kind = kind.faces().iter();
    let mut of_kind = of_kind.map(|face| face.iter().map(|&i| nodes[usize::from(i)]));
    of_kind.all(|face| keys.contains(&sorted(&face.collect::<Vec<_>>())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uncollapsed(kind: CellKind, nodes: &[u32]) -> Option<(CellKind, Vec<u32>)> {
        let cell = CellRef {
            index: 0,
            kind,
            nodes,
        };
        let one = cell.uncollapsed()?;
        Some((one.get(0).kind, one.get(0).nodes.to_vec()))
    }

    #[test]
    fn cells_with_nodes_twice_are_what_is_left_of_their_faces() {
        use CellKind::{Hexahedron as Hex, Quadrilateral as Quad};
        assert_eq!(uncollapsed(Hex, &[0, 1, 2, 3, 4, 5, 6, 7]), None);
        // An upright edge, an edge of the base, a face in a node, a face in a line, and a tetrahedron.
        let found = uncollapsed(Hex, &[0, 1, 2, 0, 3, 4, 5, 3]);
        assert_eq!(found, Some((Wedge, vec![0, 1, 2, 3, 4, 5])));
        let found = uncollapsed(Hex, &[0, 1, 2, 3, 4, 5, 5, 4]);
        assert_eq!(found, Some((Wedge, vec![0, 3, 4, 1, 2, 5])));
        let found = uncollapsed(Hex, &[0, 1, 2, 3, 4, 4, 4, 4]);
        assert_eq!(found, Some((Pyramid, vec![0, 1, 2, 3, 4])));
        let found = uncollapsed(Hex, &[0, 1, 2, 2, 3, 3, 3, 3]);
        assert_eq!(found, Some((Tetrahedron, vec![0, 2, 3, 1])));
        let found = uncollapsed(Wedge, &[0, 1, 2, 3, 3, 2]);
        assert_eq!(found.expect("it has a volume").0, Tetrahedron);
        let found = uncollapsed(Wedge, &[0, 1, 2, 3, 4, 2]);
        assert_eq!(found.expect("it has a volume").0, Pyramid);
        // A corner of the top and the corner of the base below it are one node: a polyhedron of three triangles and three quadrilaterals.
        let found = uncollapsed(Hex, &[0, 1, 2, 3, 4, 5, 6, 3]);
        assert_eq!(found.expect("it has a volume").0, Polyhedron);
        // A quadrilateral on a neighbouring triangle: no pyramid.
        let found = uncollapsed(Hex, &[0, 1, 1, 2, 3, 4, 1, 3]);
        assert_eq!(found.expect("it has a volume").0, Polyhedron);
        assert_eq!(uncollapsed(Hex, &[0, 1, 1, 0, 2, 3, 3, 2]), None);
        assert_eq!(uncollapsed(Hex, &[0; 8]), None);
        let found = uncollapsed(Quad, &[0, 1, 1, 2]);
        assert_eq!(found, Some((Triangle, vec![0, 1, 2])));
        assert_eq!(uncollapsed(Quad, &[0, 1, 1, 0]), None);
    }

    #[test]
    fn a_mesh_lists_its_cells_as_what_they_are_and_loses_faces_that_are_lines() {
        let mut mesh = Mesh {
            points: vec![[0.0; 3]; 8],
            ..Mesh::default()
        };
        mesh.cells.push(Hexahedron, &[0, 1, 2, 0, 3, 4, 5, 3]);
        mesh.cells.push(Quadrilateral, &[0, 3, 3, 0]);
        mesh.cells.push(Quadrilateral, &[0, 1, 2, 0]);
        mesh.cells.push(Hexahedron, &[0, 0, 0, 0, 0, 0, 0, 1]);
        mesh.add_tag("axis", [1]).expect("a face");
        mesh.add_tag("low", [2]).expect("a face");
        let counts = mesh.uncollapse();
        let expected = Uncollapsed {
            n_cells: 2,
            n_gone: 1,
            n_left: 1,
            n_curved: 0,
        };
        assert_eq!(counts, expected);
        let kinds: Vec<_> = mesh.cells.iter().map(|cell| cell.kind).collect();
        assert_eq!(kinds, [Wedge, Triangle, Hexahedron]);
        assert_eq!(mesh.groups[1].cells.iter().collect::<Vec<_>>(), [1]);
        mesh.validate().expect("it is a mesh");
    }
}

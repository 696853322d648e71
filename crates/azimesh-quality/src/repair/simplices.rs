//! The simplices of a cell.
//!
//! A simplex is three edges (two in a plane) between points of the cell: its nodes first, then means of some of them.
//! Corners of triangles, quadrilaterals, tetrahedra, hexahedra and wedges, the four base corners of pyramids;
//! triangles of edge and mean of polygons; tetrahedra of edge, face mean and cell mean of polyhedra. Where corners do
//! not prove a hexahedron or a wedge, the middles of its edges and faces and its own middle are added.

use azimesh_io::mesh::{CellKind, CellRef, Cells, corners};

/// Cells of more nodes are left as they are: work grows with the square.
const MOST_NODES: usize = 500;

/// Three edges, each from one point of the cell to another.
pub(super) type Edges = [[u16; 2]; 3];

/// The simplices of a cell, and its points that are no nodes: means of these nodes.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Simplices {
    /// The edges of each.
    pub edges: Vec<Edges>,
    /// Nodes, by their places in the cell, of each further point.
    pub means: Vec<Vec<u16>>,
}

impl Simplices {
    /// Simplices of a cell; with `between` also those between corners. None for a cell of very many nodes.
    pub(super) fn of(cells: &Cells, cell: &CellRef<'_>, between: bool) -> Self {
        let mut all = Self::default();
        if cell.nodes.len() > MOST_NODES {
            return all;
        }
        let kind = cell.kind.linear();
        for [from, to @ ..] in corners::of(kind) {
            all.edges
                .push(to.map(|to| [u16::from(*from), u16::from(to)]));
        }
        match kind {
            CellKind::Polygon => all.add_polygon(cell.kind.n_corners(cell.nodes.len())),
            CellKind::Polyhedron | CellKind::PentagonalPrism | CellKind::HexagonalPrism => {
                all.add_polyhedron(cells, cell);
            }
            CellKind::Wedge if between => all.add_within_wedge(),
            CellKind::Hexahedron if between => all.add_within_hexahedron(),
            _ => {}
        }
        all
    }

    fn add_polygon(&mut self, n: usize) {
        let n = n as u16;
        self.means.push((0..n).collect());
        for i in 0..n {
            self.edges.push([[n, i], [n, (i + 1) % n], [n, n]]);
        }
    }

    fn add_polyhedron(&mut self, cells: &Cells, cell: &CellRef<'_>) {
        let n = cell.nodes.len();
        let mut places: Vec<(u32, u16)> = cell.nodes.iter().copied().zip(0..).collect();
        places.sort_unstable();
        let place = |node: u32| {
            let at = places.binary_search_by_key(&node, |entry| entry.0);
            at.map_or(0, |at| places[at].1)
        };
        let mut faces: Vec<Vec<u16>> = Vec::new();
        for face in cells.polyhedron_faces(cell.index) {
            faces.push(face.iter().map(|&node| place(node)).collect());
        }
        for face in cell.kind.faces() {
            faces.push(face.iter().map(|&corner| u16::from(corner)).collect());
        }
        let centre = n as u16;
        self.means.push((0..n as u16).collect());
        for face in faces {
            let k = face.len();
            if k == 3 {
                self.edges.push([0, 1, 2].map(|i| [centre, face[i]]));
                continue;
            }
            let middle = (n + self.means.len()) as u16;
            for i in 0..k {
                self.edges.push([
                    [centre, face[i]],
                    [centre, face[(i + 1) % k]],
                    [centre, middle],
                ]);
            }
            self.means.push(face);
        }
    }

    /// At the middles of the upright edges.
    fn add_within_wedge(&mut self) {
        self.means
            .extend([[0, 3], [1, 4], [2, 5]].map(|pair| pair.to_vec()));
        for k in 0..3u16 {
            let (next, last) = ((k + 1) % 3, (k + 2) % 3);
            self.edges
                .push([[6 + k, 6 + next], [6 + k, 6 + last], [k, k + 3]]);
        }
    }

    /// At the middles of the edges, of the faces and of the cell.
    fn add_within_hexahedron(&mut self) {
        // Points by their halves along the axes: 0, 1 or 2.
        let corner = |at: [u16; 3]| {
            [[0, 3], [1, 2]][usize::from(at[0] / 2)][usize::from(at[1] / 2)] + 2 * at[2]
        };
        let mut middles: Vec<[u16; 3]> = Vec::new();
        for at in (0..27).map(|n| [n % 3, n / 3 % 3, n / 9]) {
            let n_middle = at.iter().filter(|half| **half == 1).count();
            if (1..3).contains(&n_middle) {
                middles.push(at);
                let ends = |half: u16| if half == 1 { vec![0, 2] } else { vec![half] };
                let mut nodes = Vec::new();
                for z in ends(at[2]) {
                    for y in ends(at[1]) {
                        nodes.extend(ends(at[0]).into_iter().map(|x| corner([x, y, z])));
                    }
                }
                self.means.push(nodes);
            }
        }
        let place = |at: [u16; 3]| match middles.iter().position(|middle| *middle == at) {
            Some(position) => 8 + position as u16,
            None => corner(at),
        };
        for at in (0..27).map(|n| [n % 3, n / 3 % 3, n / 9]) {
            if at.contains(&1) {
                self.edges.push([0, 1, 2].map(|axis| {
                    let (mut from, mut to) = (at, at);
                    (from[axis], to[axis]) = (0, 2);
                    [place(from), place(to)]
                }));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repair::shape::regular;
    use azimesh_core::geometry::vector::{Vector, add, cross, dot, scale, sub};
    use azimesh_io::mesh::Mesh;

    fn determinants(mesh: &Mesh, all: &Simplices) -> Vec<f64> {
        let cell = mesh.cells.get(0);
        let mut points: Vec<Vector> = cell
            .nodes
            .iter()
            .map(|&n| mesh.points[n as usize])
            .collect();
        for mean in &all.means {
            let sum = mean
                .iter()
                .fold([0.0; 3], |sum, &i| add(sum, points[usize::from(i)]));
            points.push(scale(sum, 1.0 / mean.len() as f64));
        }
        let edge = |[a, b]: [u16; 2]| sub(points[usize::from(b)], points[usize::from(a)]);
        let solid = mesh.dimension() == 3;
        let of = |edges: &Edges| {
            let third = if solid {
                edge(edges[2])
            } else {
                [0.0, 0.0, 1.0]
            };
            dot(edge(edges[0]), cross(edge(edges[1]), third))
        };
        all.edges.iter().map(of).collect()
    }

    #[test]
    fn every_simplex_of_a_regular_cell_is_positive() {
        let kinds = [
            (CellKind::Triangle, 3, 1),
            (CellKind::Quadrilateral, 4, 4),
            (CellKind::Tetrahedron, 4, 1),
            (CellKind::Pyramid, 5, 4),
            (CellKind::Wedge, 6, 9),
            (CellKind::Hexahedron, 8, 27),
        ];
        for (kind, n, n_simplices) in kinds {
            let zeros = vec![[0.0; 3]; n];
            let points = regular(kind, &zeros, 1.0, 1.0).expect("it has a regular shape");
            let mut mesh = Mesh {
                points,
                ..Mesh::default()
            };
            mesh.cells.push(kind, &(0..n as u32).collect::<Vec<_>>());
            let all = Simplices::of(&mesh.cells, &mesh.cells.get(0), true);
            assert_eq!(all.edges.len(), n_simplices, "{kind:?}");
            let found = determinants(&mesh, &all);
            assert!(found.iter().all(|d| *d > 0.4), "{kind:?} {found:?}");
        }
    }

    #[test]
    fn polygons_and_polyhedra_are_cut_around_their_means() {
        let mut mesh = Mesh {
            points: (0..5)
                .map(|i| (f64::from(i) * 1.2566).sin_cos())
                .map(|(s, c)| [c, s, 0.0])
                .collect(),
            ..Mesh::default()
        };
        mesh.cells.push(CellKind::Polygon, &[0, 1, 2, 3, 4]);
        let found = determinants(
            &mesh,
            &Simplices::of(&mesh.cells, &mesh.cells.get(0), false),
        );
        assert!(found.len() == 5 && found.iter().all(|d| *d > 0.9));
        let cube = regular(CellKind::Hexahedron, &[[0.0; 3]; 8], 1.0, 1.0).expect("a cube");
        let mut mesh = Mesh {
            points: cube,
            ..Mesh::default()
        };
        let faces = CellKind::Hexahedron.faces();
        let mut stream = vec![faces.len() as u32];
        for face in faces {
            stream.push(face.len() as u32);
            stream.extend(face.iter().map(|&corner| u32::from(corner)));
        }
        mesh.cells.push_polyhedron(&stream).expect("a good stream");
        let found = determinants(
            &mesh,
            &Simplices::of(&mesh.cells, &mesh.cells.get(0), false),
        );
        assert!(
            found.len() == 24 && found.iter().all(|d| (d - 0.25).abs() < 1e-12),
            "{found:?}"
        );
    }
}

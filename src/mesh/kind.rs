//! Cell kinds: VTK's numbers, names, dimensions, faces and edges, in VTK's node order.

/// A kind of cell. The discriminant is VTK's cell type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
#[allow(missing_docs)] // the names say it
pub enum CellKind {
    Vertex = 1,
    Line = 3,
    Triangle = 5,
    Polygon = 7,
    Quadrilateral = 9,
    Tetrahedron = 10,
    Hexahedron = 12,
    Wedge = 13,
    Pyramid = 14,
    Line3 = 21,
    Triangle6 = 22,
    Quadrilateral8 = 23,
    Tetrahedron10 = 24,
    Hexahedron20 = 25,
    Wedge15 = 26,
    Pyramid13 = 27,
    Quadrilateral9 = 28,
    Hexahedron27 = 29,
    Wedge18 = 32,
    Polyhedron = 42,
}

use CellKind::*;

impl CellKind {
    /// Every kind, in the order of VTK's numbers.
    pub const ALL: [CellKind; 20] = [
        Vertex,
        Line,
        Triangle,
        Polygon,
        Quadrilateral,
        Tetrahedron,
        Hexahedron,
        Wedge,
        Pyramid,
        Line3,
        Triangle6,
        Quadrilateral8,
        Tetrahedron10,
        Hexahedron20,
        Wedge15,
        Pyramid13,
        Quadrilateral9,
        Hexahedron27,
        Wedge18,
        Polyhedron,
    ];

    /// The kind with this VTK cell type.
    pub fn from_vtk(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == number)
    }

    /// VTK's cell type.
    pub fn vtk(self) -> u8 {
        self as u8
    }

    /// The name in messages and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Vertex => "vertex",
            Line => "line",
            Triangle => "triangle",
            Polygon => "polygon",
            Quadrilateral => "quadrilateral",
            Tetrahedron => "tetrahedron",
            Hexahedron => "hexahedron",
            Wedge => "wedge",
            Pyramid => "pyramid",
            Line3 => "line3",
            Triangle6 => "triangle6",
            Quadrilateral8 => "quadrilateral8",
            Tetrahedron10 => "tetrahedron10",
            Hexahedron20 => "hexahedron20",
            Wedge15 => "wedge15",
            Pyramid13 => "pyramid13",
            Quadrilateral9 => "quadrilateral9",
            Hexahedron27 => "hexahedron27",
            Wedge18 => "wedge18",
            Polyhedron => "polyhedron",
        }
    }

    /// Topological dimension, 0 to 3.
    pub fn dimension(self) -> u8 {
        match self.linear() {
            Vertex => 0,
            Line => 1,
            Triangle | Polygon | Quadrilateral => 2,
            _ => 3,
        }
    }

    /// Nodes of one cell; `None` for polygons and polyhedra, which have any number.
    pub fn n_nodes(self) -> Option<usize> {
        Some(match self {
            Vertex => 1,
            Line => 2,
            Triangle | Line3 => 3,
            Quadrilateral | Tetrahedron => 4,
            Pyramid => 5,
            Wedge | Triangle6 => 6,
            Hexahedron | Quadrilateral8 => 8,
            Quadrilateral9 => 9,
            Tetrahedron10 => 10,
            Pyramid13 => 13,
            Wedge15 => 15,
            Wedge18 => 18,
            Hexahedron20 => 20,
            Hexahedron27 => 27,
            Polygon | Polyhedron => return None,
        })
    }

    /// The kind of the corner nodes alone; a cell's first nodes are its corners.
    pub fn linear(self) -> Self {
        match self {
            Line3 => Line,
            Triangle6 => Triangle,
            Quadrilateral8 | Quadrilateral9 => Quadrilateral,
            Tetrahedron10 => Tetrahedron,
            Hexahedron20 | Hexahedron27 => Hexahedron,
            Wedge15 | Wedge18 => Wedge,
            Pyramid13 => Pyramid,
            linear => linear,
        }
    }

    /// Faces of the linear kind as corner indices, outward by VTK's convention (a wedge's as VTK
    /// lists them). In 2D the "faces" are the edges in order. Empty for kinds without fixed faces.
    pub fn faces(self) -> &'static [&'static [u8]] {
        match self.linear() {
            Line => &[&[0], &[1]],
            Triangle => &[&[0, 1], &[1, 2], &[2, 0]],
            Quadrilateral => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
            Tetrahedron => &[&[0, 1, 3], &[1, 2, 3], &[2, 0, 3], &[0, 2, 1]],
            Hexahedron => &[
                &[0, 4, 7, 3],
                &[1, 2, 6, 5],
                &[0, 1, 5, 4],
                &[3, 7, 6, 2],
                &[0, 3, 2, 1],
                &[4, 5, 6, 7],
            ],
            Wedge => &[
                &[0, 1, 2],
                &[3, 5, 4],
                &[0, 3, 4, 1],
                &[1, 4, 5, 2],
                &[2, 5, 3, 0],
            ],
            Pyramid => &[
                &[0, 3, 2, 1],
                &[0, 1, 4],
                &[1, 2, 4],
                &[2, 3, 4],
                &[3, 0, 4],
            ],
            _ => &[],
        }
    }

    /// Edges of the linear kind as pairs of corner indices. Empty for polygons and polyhedra.
    pub fn edges(self) -> &'static [[u8; 2]] {
        match self.linear() {
            Line => &[[0, 1]],
            Triangle => &[[0, 1], [1, 2], [2, 0]],
            Quadrilateral => &[[0, 1], [1, 2], [2, 3], [3, 0]],
            Tetrahedron => &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
            Hexahedron => &[
                [0, 1],
                [1, 2],
                [2, 3],
                [3, 0],
                [4, 5],
                [5, 6],
                [6, 7],
                [7, 4],
                [0, 4],
                [1, 5],
                [2, 6],
                [3, 7],
            ],
            Wedge => &[
                [0, 1],
                [1, 2],
                [2, 0],
                [3, 4],
                [4, 5],
                [5, 3],
                [0, 3],
                [1, 4],
                [2, 5],
            ],
            Pyramid => &[
                [0, 1],
                [1, 2],
                [2, 3],
                [3, 0],
                [0, 4],
                [1, 4],
                [2, 4],
                [3, 4],
            ],
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vtk_numbers_come_back() {
        for kind in CellKind::ALL {
            assert_eq!(CellKind::from_vtk(kind.vtk()), Some(kind));
        }
        assert_eq!(CellKind::from_vtk(0), None);
    }

    #[test]
    fn every_edge_of_a_solid_is_shared_by_two_of_its_faces() {
        for kind in [Tetrahedron, Hexahedron, Wedge, Pyramid] {
            for edge in kind.edges() {
                let holds = |face: &&&[u8]| edge.iter().all(|node| face.contains(node));
                assert_eq!(kind.faces().iter().filter(holds).count(), 2, "{kind:?}");
            }
        }
    }
}

//! Cell kinds: VTK's numbers, names, dimensions, faces and edges, in VTK's node order.

use serde::{Deserialize, Serialize};

/// Makes the kinds from a table: of each VTK's cell type, its name in messages, the kind of its corners alone, and the
/// nodes of one cell.
macro_rules! kinds {
    ($(#[$attribute:meta])* $n:literal: $($kind:ident = $vtk:literal $name:literal $linear:ident $n_nodes:expr,)*) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[repr(u8)]
        #[allow(missing_docs)] // the names say it
        pub enum CellKind {
            $($kind = $vtk,)*
        }

        impl CellKind {
            /// Every kind, in the order of VTK's numbers.
            pub const ALL: [CellKind; $n] = [$($kind,)*];

            /// The name in messages and JSON.
            pub fn name(self) -> &'static str {
                match self {
                    $($kind => $name,)*
                }
            }

            /// The kind of the corner nodes alone; a cell's first nodes are its corners.
            pub fn linear(self) -> Self {
                match self {
                    $($kind => $linear,)*
                }
            }

            /// Nodes of one cell; `None` for kinds that have any number: polygons, polyhedra, and the
            /// Lagrange and Bezier cells of any order.
            pub fn n_nodes(self) -> Option<usize> {
                match self {
                    $($kind => $n_nodes,)*
                }
            }
        }
    };
}

kinds! {
    /// A kind of cell. The discriminant is VTK's cell type.
    ///
    /// ```
    /// use azimesh_io::CellKind;
    ///
    /// assert_eq!(CellKind::Wedge as u8, 13);
    /// assert_eq!(CellKind::Wedge.dimension(), 3);
    /// ```
    43:
    Vertex = 1 "vertex" Vertex Some(1),
    Line = 3 "line" Line Some(2),
    Triangle = 5 "triangle" Triangle Some(3),
    Polygon = 7 "polygon" Polygon None,
    Quadrilateral = 9 "quadrilateral" Quadrilateral Some(4),
    Tetrahedron = 10 "tetrahedron" Tetrahedron Some(4),
    Hexahedron = 12 "hexahedron" Hexahedron Some(8),
    Wedge = 13 "wedge" Wedge Some(6),
    Pyramid = 14 "pyramid" Pyramid Some(5),
    PentagonalPrism = 15 "pentagonal_prism" PentagonalPrism Some(10),
    HexagonalPrism = 16 "hexagonal_prism" HexagonalPrism Some(12),
    Line3 = 21 "line3" Line Some(3),
    Triangle6 = 22 "triangle6" Triangle Some(6),
    Quadrilateral8 = 23 "quadrilateral8" Quadrilateral Some(8),
    Tetrahedron10 = 24 "tetrahedron10" Tetrahedron Some(10),
    Hexahedron20 = 25 "hexahedron20" Hexahedron Some(20),
    Wedge15 = 26 "wedge15" Wedge Some(15),
    Pyramid13 = 27 "pyramid13" Pyramid Some(13),
    Quadrilateral9 = 28 "quadrilateral9" Quadrilateral Some(9),
    Hexahedron27 = 29 "hexahedron27" Hexahedron Some(27),
    QuadraticLinearQuadrilateral = 30 "quadratic_linear_quadrilateral" Quadrilateral Some(6),
    QuadraticLinearWedge = 31 "quadratic_linear_wedge" Wedge Some(12),
    Wedge18 = 32 "wedge18" Wedge Some(18),
    Hexahedron24 = 33 "hexahedron24" Hexahedron Some(24),
    Triangle7 = 34 "triangle7" Triangle Some(7),
    CubicLine = 35 "cubic_line" Line Some(4),
    QuadraticPolygon = 36 "quadratic_polygon" Polygon None,
    Pyramid19 = 37 "pyramid19" Pyramid Some(19),
    Polyhedron = 42 "polyhedron" Polyhedron None,
    LagrangeCurve = 68 "lagrange_curve" Line None,
    LagrangeTriangle = 69 "lagrange_triangle" Triangle None,
    LagrangeQuadrilateral = 70 "lagrange_quadrilateral" Quadrilateral None,
    LagrangeTetrahedron = 71 "lagrange_tetrahedron" Tetrahedron None,
    LagrangeHexahedron = 72 "lagrange_hexahedron" Hexahedron None,
    LagrangeWedge = 73 "lagrange_wedge" Wedge None,
    LagrangePyramid = 74 "lagrange_pyramid" Pyramid None,
    BezierCurve = 75 "bezier_curve" Line None,
    BezierTriangle = 76 "bezier_triangle" Triangle None,
    BezierQuadrilateral = 77 "bezier_quadrilateral" Quadrilateral None,
    BezierTetrahedron = 78 "bezier_tetrahedron" Tetrahedron None,
    BezierHexahedron = 79 "bezier_hexahedron" Hexahedron None,
    BezierWedge = 80 "bezier_wedge" Wedge None,
    BezierPyramid = 81 "bezier_pyramid" Pyramid None,
}

use CellKind::*;

impl CellKind {
    /// The kind with this VTK cell type.
    pub fn from_vtk(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == number)
    }

    /// VTK's cell type.
    pub fn vtk(self) -> u8 {
        self as u8
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

    /// Returns whether one cell can have `n` nodes.
    pub fn can_have(self, n: usize) -> bool {
        match self {
            Polygon => n >= 3,
            QuadraticPolygon => n >= 6 && n.is_multiple_of(2),
            Polyhedron => n >= 1,
            kind => match kind.n_nodes() {
                Some(expected) => n == expected,
                None => n >= kind.n_corners(n),
            },
        }
    }

    /// Corners of a cell with `n_nodes` nodes: its first nodes.
    pub fn n_corners(self, n_nodes: usize) -> usize {
        match self {
            QuadraticPolygon => n_nodes / 2,
            kind => kind.linear().n_nodes().unwrap_or(n_nodes),
        }
    }

    /// Returns whether it has more nodes than its corners.
    pub fn is_curved(self) -> bool {
        self.linear() != self
    }

    /// Faces of the linear kind as corner indices, outward in a cell of positive volume. In 2D the
    /// "faces" are the edges in order. Empty for kinds without fixed faces.
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
                &[0, 2, 1],
                &[3, 4, 5],
                &[0, 1, 4, 3],
                &[1, 2, 5, 4],
                &[2, 0, 3, 5],
            ],
            Pyramid => &[
                &[0, 3, 2, 1],
                &[0, 1, 4],
                &[1, 2, 4],
                &[2, 3, 4],
                &[3, 0, 4],
            ],
            PentagonalPrism => &[
                &[0, 4, 3, 2, 1],
                &[5, 6, 7, 8, 9],
                &[0, 1, 6, 5],
                &[1, 2, 7, 6],
                &[2, 3, 8, 7],
                &[3, 4, 9, 8],
                &[4, 0, 5, 9],
            ],
            HexagonalPrism => &[
                &[0, 5, 4, 3, 2, 1],
                &[6, 7, 8, 9, 10, 11],
                &[0, 1, 7, 6],
                &[1, 2, 8, 7],
                &[2, 3, 9, 8],
                &[3, 4, 10, 9],
                &[4, 5, 11, 10],
                &[5, 0, 6, 11],
            ],
            _ => &[],
        }
    }

    /// Edges of the linear kind as pairs of corner indices. Empty for polygons and polyhedra.
    #[rustfmt::skip] // a table
    pub fn edges(self) -> &'static [[u8; 2]] {
        match self.linear() {
            Line => &[[0, 1]],
            Triangle => &[[0, 1], [1, 2], [2, 0]],
            Quadrilateral => &[[0, 1], [1, 2], [2, 3], [3, 0]],
            Tetrahedron => &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
            Pyramid => &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]],
            Wedge => &[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]],
            Hexahedron => &[
                [0, 1], [1, 2], [2, 3], [3, 0],
                [4, 5], [5, 6], [6, 7], [7, 4],
                [0, 4], [1, 5], [2, 6], [3, 7],
            ],
            PentagonalPrism => &[
                [0, 1], [1, 2], [2, 3], [3, 4], [4, 0],
                [5, 6], [6, 7], [7, 8], [8, 9], [9, 5],
                [0, 5], [1, 6], [2, 7], [3, 8], [4, 9],
            ],
            HexagonalPrism => &[
                [0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0],
                [6, 7], [7, 8], [8, 9], [9, 10], [10, 11], [11, 6],
                [0, 6], [1, 7], [2, 8], [3, 9], [4, 10], [5, 11],
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
    fn a_kind_is_named_as_before() {
        assert_eq!(Hexahedron27.name(), "hexahedron27");
        assert_eq!(LagrangeWedge.name(), "lagrange_wedge");
    }

    /// Corners of regular cells of positive volume: prisms on a polygon around the axis of z, pyramids over one.
    fn corners(kind: CellKind, n_base: usize) -> Vec<[f64; 3]> {
        let angle = |i: usize| std::f64::consts::TAU * i as f64 / n_base as f64;
        let at = |i: usize, z: f64| [angle(i).cos(), angle(i).sin(), z];
        let base = (0..n_base).map(|i| at(i, 0.0));
        if matches!(kind, Tetrahedron | Pyramid) {
            base.chain([[0.0, 0.0, 1.0]]).collect()
        } else {
            base.chain((0..n_base).map(|i| at(i, 1.0))).collect()
        }
    }

    #[test]
    fn faces_point_out_of_a_cell_of_positive_volume() {
        use azimesh_core::geometry::vector::{cross, dot, sub};
        for (kind, n_base) in [
            (Tetrahedron, 3),
            (Pyramid, 4),
            (Wedge, 3),
            (Hexahedron, 4),
            (PentagonalPrism, 5),
            (HexagonalPrism, 6),
        ] {
            let at = corners(kind, n_base);
            for face in kind.faces() {
                let [a, b, c] = [0, 1, 2].map(|i| at[usize::from(face[i])]);
                let out = dot(cross(sub(b, a), sub(c, a)), sub(a, [0.0, 0.0, 0.5]));
                assert!(out > 0.0, "{kind:?} {face:?}");
            }
        }
    }

    #[test]
    fn every_edge_of_a_solid_is_shared_by_two_of_its_faces() {
        for kind in [
            Tetrahedron,
            Hexahedron,
            Wedge,
            Pyramid,
            PentagonalPrism,
            HexagonalPrism,
        ] {
            for edge in kind.edges() {
                let holds = |face: &&&[u8]| edge.iter().all(|node| face.contains(node));
                assert_eq!(kind.faces().iter().filter(holds).count(), 2, "{kind:?}");
            }
        }
    }
}

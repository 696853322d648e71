//! Cell kinds: VTK's numbers, names, dimensions, faces and edges, in VTK's node order.

use serde::{Deserialize, Serialize};

/// A kind of cell. The discriminant is VTK's cell type.
///
/// ```
/// use azimesh_io::CellKind;
///
/// assert_eq!(CellKind::Wedge as u8, 13);
/// assert_eq!(CellKind::Wedge.dimension(), 3);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
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
    PentagonalPrism = 15,
    HexagonalPrism = 16,
    Line3 = 21,
    Triangle6 = 22,
    Quadrilateral8 = 23,
    Tetrahedron10 = 24,
    Hexahedron20 = 25,
    Wedge15 = 26,
    Pyramid13 = 27,
    Quadrilateral9 = 28,
    Hexahedron27 = 29,
    QuadraticLinearQuadrilateral = 30,
    QuadraticLinearWedge = 31,
    Wedge18 = 32,
    Hexahedron24 = 33,
    Triangle7 = 34,
    CubicLine = 35,
    QuadraticPolygon = 36,
    Pyramid19 = 37,
    Polyhedron = 42,
    LagrangeCurve = 68,
    LagrangeTriangle = 69,
    LagrangeQuadrilateral = 70,
    LagrangeTetrahedron = 71,
    LagrangeHexahedron = 72,
    LagrangeWedge = 73,
    LagrangePyramid = 74,
    BezierCurve = 75,
    BezierTriangle = 76,
    BezierQuadrilateral = 77,
    BezierTetrahedron = 78,
    BezierHexahedron = 79,
    BezierWedge = 80,
    BezierPyramid = 81,
}

use CellKind::*;

impl CellKind {
    /// Every kind, in the order of VTK's numbers.
    pub const ALL: [CellKind; 43] = [
        Vertex,
        Line,
        Triangle,
        Polygon,
        Quadrilateral,
        Tetrahedron,
        Hexahedron,
        Wedge,
        Pyramid,
        PentagonalPrism,
        HexagonalPrism,
        Line3,
        Triangle6,
        Quadrilateral8,
        Tetrahedron10,
        Hexahedron20,
        Wedge15,
        Pyramid13,
        Quadrilateral9,
        Hexahedron27,
        QuadraticLinearQuadrilateral,
        QuadraticLinearWedge,
        Wedge18,
        Hexahedron24,
        Triangle7,
        CubicLine,
        QuadraticPolygon,
        Pyramid19,
        Polyhedron,
        LagrangeCurve,
        LagrangeTriangle,
        LagrangeQuadrilateral,
        LagrangeTetrahedron,
        LagrangeHexahedron,
        LagrangeWedge,
        LagrangePyramid,
        BezierCurve,
        BezierTriangle,
        BezierQuadrilateral,
        BezierTetrahedron,
        BezierHexahedron,
        BezierWedge,
        BezierPyramid,
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
            PentagonalPrism => "pentagonal_prism",
            HexagonalPrism => "hexagonal_prism",
            Line3 => "line3",
            Triangle6 => "triangle6",
            Quadrilateral8 => "quadrilateral8",
            Tetrahedron10 => "tetrahedron10",
            Hexahedron20 => "hexahedron20",
            Wedge15 => "wedge15",
            Pyramid13 => "pyramid13",
            Quadrilateral9 => "quadrilateral9",
            Hexahedron27 => "hexahedron27",
            QuadraticLinearQuadrilateral => "quadratic_linear_quadrilateral",
            QuadraticLinearWedge => "quadratic_linear_wedge",
            Wedge18 => "wedge18",
            Hexahedron24 => "hexahedron24",
            Triangle7 => "triangle7",
            CubicLine => "cubic_line",
            QuadraticPolygon => "quadratic_polygon",
            Pyramid19 => "pyramid19",
            Polyhedron => "polyhedron",
            LagrangeCurve => "lagrange_curve",
            LagrangeTriangle => "lagrange_triangle",
            LagrangeQuadrilateral => "lagrange_quadrilateral",
            LagrangeTetrahedron => "lagrange_tetrahedron",
            LagrangeHexahedron => "lagrange_hexahedron",
            LagrangeWedge => "lagrange_wedge",
            LagrangePyramid => "lagrange_pyramid",
            BezierCurve => "bezier_curve",
            BezierTriangle => "bezier_triangle",
            BezierQuadrilateral => "bezier_quadrilateral",
            BezierTetrahedron => "bezier_tetrahedron",
            BezierHexahedron => "bezier_hexahedron",
            BezierWedge => "bezier_wedge",
            BezierPyramid => "bezier_pyramid",
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

    /// Nodes of one cell; `None` for kinds that have any number: polygons, polyhedra, and the
    /// Lagrange and Bezier cells of any order.
    pub fn n_nodes(self) -> Option<usize> {
        Some(match self {
            Vertex => 1,
            Line => 2,
            Triangle | Line3 => 3,
            Quadrilateral | Tetrahedron | CubicLine => 4,
            Pyramid => 5,
            Wedge | Triangle6 | QuadraticLinearQuadrilateral => 6,
            Triangle7 => 7,
            Hexahedron | Quadrilateral8 => 8,
            Quadrilateral9 => 9,
            Tetrahedron10 | PentagonalPrism => 10,
            HexagonalPrism | QuadraticLinearWedge => 12,
            Pyramid13 => 13,
            Wedge15 => 15,
            Wedge18 => 18,
            Pyramid19 => 19,
            Hexahedron20 => 20,
            Hexahedron24 => 24,
            Hexahedron27 => 27,
            _ => return None,
        })
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

    /// The kind of the corner nodes alone; a cell's first nodes are its corners.
    pub fn linear(self) -> Self {
        match self {
            Line3 | CubicLine | LagrangeCurve | BezierCurve => Line,
            Triangle6 | Triangle7 | LagrangeTriangle | BezierTriangle => Triangle,
            Quadrilateral8
            | Quadrilateral9
            | QuadraticLinearQuadrilateral
            | LagrangeQuadrilateral
            | BezierQuadrilateral => Quadrilateral,
            QuadraticPolygon => Polygon,
            Tetrahedron10 | LagrangeTetrahedron | BezierTetrahedron => Tetrahedron,
            Hexahedron20 | Hexahedron24 | Hexahedron27 | LagrangeHexahedron | BezierHexahedron => {
                Hexahedron
            }
            Wedge15 | Wedge18 | QuadraticLinearWedge | LagrangeWedge | BezierWedge => Wedge,
            Pyramid13 | Pyramid19 | LagrangePyramid | BezierPyramid => Pyramid,
            linear => linear,
        }
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

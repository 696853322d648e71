//! Types of elements: their names, the cells that they become, the order of their nodes, the numbers of their sides.

use crate::mesh::CellKind::{self, *};

/// The shape that the name of a type stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Point,
    /// Bars, beams, trusses, edges.
    Bar,
    Triangle,
    Quadrilateral,
    /// Triangles and quadrilaterals with two faces and, after these, edges.
    Shell,
    Tetrahedron,
    Pyramid,
    Wedge,
    Hexahedron,
    /// Polygons.
    NSided,
    /// Polyhedra.
    NFaced,
}

/// Beginnings of names, in capitals, and their shapes. Names may go on: `HEX8`, `SHELL4`, `TRISHELL3`.
const NAMES: &[(&str, Shape)] = &[
    ("CIRCLE SPHERE NODE POINT", Shape::Point),
    ("BAR BEAM TRUSS ROD EDGE LINE", Shape::Bar),
    ("TRISHELL QUADSHELL SHELL", Shape::Shell),
    ("TRI", Shape::Triangle),
    ("QUAD", Shape::Quadrilateral),
    ("TET", Shape::Tetrahedron),
    ("PYR", Shape::Pyramid),
    ("WEDGE PRISM", Shape::Wedge),
    ("HEX", Shape::Hexahedron),
    ("NSIDED", Shape::NSided),
    ("NFACED", Shape::NFaced),
];

impl Shape {
    /// The shape of a type of elements of so many nodes, in a mesh of this many coordinates.
    pub fn of(name: &str, n_nodes: usize, n_coordinates: usize) -> Option<Self> {
        let name = name.trim().to_ascii_uppercase();
        let is_name = |(starts, _): &&(&str, Shape)| starts.split(' ').any(|s| name.starts_with(s));
        let (_, shape) = *NAMES.iter().find(is_name)?;
        Some(match shape {
            // In space they have two faces, as shells do; in the plane shells of two or three nodes are lines.
            Self::Triangle if n_coordinates == 3 => Self::Shell,
            Self::Shell if n_coordinates < 3 && n_nodes < 4 && name.starts_with("SHELL") => {
                Self::Bar
            }
            shape => shape,
        })
    }
}

/// The nodes of an element as nodes of a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element {
    pub kind: CellKind,
    /// Position in the element of each node of the cell; `None` where they are the same.
    pub order: Option<&'static [usize]>,
    /// Nodes of the cell: fewer than an element has, if no cell has all of them.
    pub n_kept: usize,
}

const HEX20: [usize; 20] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15,
];
/// The middle comes first, then the faces below, above, and across the first and the second axis.
const HEX27: [usize; 27] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15, 23, 24, 25, 26, 21, 22,
    20,
];
const WEDGE15: [usize; 15] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11];
const WEDGE18: [usize; 18] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11, 15, 16, 17];
/// The middles of the triangles precede the middles of the quadrilaterals, which begin with the second.
const WEDGE20: [usize; 18] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11, 19, 17, 18];
/// The middle comes first, then the middles as before.
const WEDGE21: [usize; 18] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11, 20, 18, 19];

impl Element {
    /// An element of this shape with so many nodes; `None` where there is none.
    pub fn of(shape: Shape, n_nodes: usize) -> Option<Self> {
        let same = |kind: CellKind, n_kept: usize| Self {
            kind,
            order: None,
            n_kept,
        };
        let ordered = |kind: CellKind, order: &'static [usize]| Self {
            kind,
            order: Some(order),
            n_kept: order.len(),
        };
        Some(match (shape, n_nodes) {
            (Shape::Point, 1) => same(Vertex, 1),
            (Shape::Bar, 2) => same(Line, 2),
            (Shape::Bar, 3) => same(Line3, 3),
            (Shape::Bar, 4) => same(CubicLine, 4),
            (Shape::Triangle | Shape::Shell, 3) => same(Triangle, 3),
            (Shape::Triangle | Shape::Shell, 6) => same(Triangle6, 6),
            (Shape::Triangle | Shape::Shell, 7) => same(Triangle7, 7),
            (Shape::Triangle, 4..) => same(Triangle, 3),
            (Shape::Quadrilateral | Shape::Shell, 4) => same(Quadrilateral, 4),
            (Shape::Quadrilateral | Shape::Shell, 8) => same(Quadrilateral8, 8),
            (Shape::Quadrilateral | Shape::Shell, 9) => same(Quadrilateral9, 9),
            (Shape::Quadrilateral | Shape::Shell, 5..) => same(Quadrilateral, 4),
            (Shape::Tetrahedron, 10..=15) => same(Tetrahedron10, 10),
            (Shape::Tetrahedron, 4..) => same(Tetrahedron, 4),
            (Shape::Pyramid, 13) => same(Pyramid13, 13),
            (Shape::Pyramid, 14 | 18) => same(LagrangePyramid, 14),
            (Shape::Pyramid, 19) => same(Pyramid19, 19),
            (Shape::Pyramid, 5..) => same(Pyramid, 5),
            (Shape::Wedge, 12) => same(QuadraticLinearWedge, 12),
            (Shape::Wedge, 15 | 16) => ordered(Wedge15, &WEDGE15),
            (Shape::Wedge, 18) => ordered(Wedge18, &WEDGE18),
            (Shape::Wedge, 20) => ordered(Wedge18, &WEDGE20),
            (Shape::Wedge, 21) => ordered(Wedge18, &WEDGE21),
            (Shape::Wedge, 6..) => same(Wedge, 6),
            (Shape::Hexahedron, 20 | 21) => ordered(Hexahedron20, &HEX20),
            (Shape::Hexahedron, 27) => ordered(Hexahedron27, &HEX27),
            (Shape::Hexahedron, 8..) => same(Hexahedron, 8),
            _ => return None,
        })
    }
}

/// A side of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    /// A face of its cell, an edge of a plane one, an end of a line, counted as the cell counts them.
    Face(usize),
    /// The element itself: a shell is a face.
    Whole,
}

/// Faces of cells in the order of the sides of elements, which count from 1.
const TETRAHEDRON: [usize; 4] = [0, 1, 2, 3];
const PYRAMID: [usize; 5] = [1, 2, 3, 4, 0];
const WEDGE: [usize; 5] = [2, 3, 4, 0, 1];
const HEXAHEDRON: [usize; 6] = [2, 1, 3, 0, 4, 5];

impl Side {
    /// The side of this number of an element, whose cell has `n_faces` faces, in a mesh whose largest cells are of
    /// this dimension; `None` where there is none.
    pub fn of(shape: Shape, number: i64, n_faces: usize, dimension: u8) -> Option<Self> {
        let at = usize::try_from(number.checked_sub(1)?).ok()?;
        let face = match shape {
            Shape::Point => return None,
            Shape::Bar if dimension > 1 => return Some(Self::Whole),
            Shape::Shell if at < 2 => return Some(Self::Whole),
            Shape::Shell => at - 2,
            Shape::Tetrahedron => *TETRAHEDRON.get(at)?,
            Shape::Pyramid => *PYRAMID.get(at)?,
            Shape::Wedge => *WEDGE.get(at)?,
            Shape::Hexahedron => *HEXAHEDRON.get(at)?,
            Shape::Bar | Shape::Triangle | Shape::Quadrilateral | Shape::NSided | Shape::NFaced => {
                at
            }
        };
        (face < n_faces).then_some(Self::Face(face))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_type_is_known_by_the_start_of_its_name() {
        for (name, n_nodes, n, shape) in [
            ("hex8", 8, 3, Some(Shape::Hexahedron)),
            ("HEX", 20, 3, Some(Shape::Hexahedron)),
            ("TETRA10", 10, 3, Some(Shape::Tetrahedron)),
            ("tri3", 3, 2, Some(Shape::Triangle)),
            ("TRI", 3, 3, Some(Shape::Shell)),
            ("TRISHELL3", 3, 3, Some(Shape::Shell)),
            ("QUAD4", 4, 3, Some(Shape::Quadrilateral)),
            ("SHELL2", 2, 2, Some(Shape::Bar)),
            ("SHELL", 4, 2, Some(Shape::Shell)),
            ("nfaced", 9, 3, Some(Shape::NFaced)),
            ("SUPER", 8, 3, None),
        ] {
            assert_eq!(Shape::of(name, n_nodes, n), shape, "{name}");
        }
    }

    /// Corners of each side as the manual of Exodus lists them, from 1, and corners of the face of the cell.
    #[test]
    fn sides_have_the_corners_that_the_manual_gives_them() {
        let sides: [(Shape, CellKind, &[&[u8]]); 6] = [
            (
                Shape::Hexahedron,
                Hexahedron,
                &[
                    &[1, 2, 6, 5],
                    &[2, 3, 7, 6],
                    &[3, 4, 8, 7],
                    &[1, 5, 8, 4],
                    &[1, 4, 3, 2],
                    &[5, 6, 7, 8],
                ],
            ),
            (
                Shape::Tetrahedron,
                Tetrahedron,
                &[&[1, 2, 4], &[2, 3, 4], &[1, 4, 3], &[1, 3, 2]],
            ),
            (
                Shape::Wedge,
                Wedge,
                &[
                    &[1, 2, 5, 4],
                    &[2, 3, 6, 5],
                    &[1, 4, 6, 3],
                    &[1, 3, 2],
                    &[4, 5, 6],
                ],
            ),
            (
                Shape::Pyramid,
                Pyramid,
                &[
                    &[1, 2, 5],
                    &[2, 3, 5],
                    &[3, 4, 5],
                    &[1, 5, 4],
                    &[1, 4, 3, 2],
                ],
            ),
            (Shape::Triangle, Triangle, &[&[1, 2], &[2, 3], &[3, 1]]),
            (
                Shape::Quadrilateral,
                Quadrilateral,
                &[&[1, 2], &[2, 3], &[3, 4], &[4, 1]],
            ),
        ];
        for (shape, kind, sides) in sides {
            for (i, corners) in sides.iter().enumerate() {
                let number = i as i64 + 1;
                let side = Side::of(shape, number, kind.faces().len(), 3);
                let Some(Side::Face(face)) = side else {
                    panic!("{shape:?} has no side {number}");
                };
                let mut expected: Vec<u8> = corners.iter().map(|corner| corner - 1).collect();
                let mut found = kind.faces()[face].to_vec();
                expected.sort_unstable();
                found.sort_unstable();
                assert_eq!(found, expected, "{shape:?} {number}");
            }
            let beyond = sides.len() as i64 + 1;
            assert_eq!(Side::of(shape, beyond, kind.faces().len(), 3), None);
            assert_eq!(Side::of(shape, 0, kind.faces().len(), 3), None);
        }
    }

    #[test]
    fn a_shell_has_two_faces_and_then_edges() {
        let side = |number| Side::of(Shape::Shell, number, 4, 2);
        assert_eq!([side(1), side(2)], [Some(Side::Whole); 2]);
        assert_eq!(side(3), Some(Side::Face(0)));
        assert_eq!(side(6), Some(Side::Face(3)));
        assert_eq!(side(7), None);
        assert_eq!(Side::of(Shape::Bar, 2, 2, 1), Some(Side::Face(1)));
        assert_eq!(Side::of(Shape::Bar, 2, 2, 3), Some(Side::Whole));
    }

    /// The middles of the quadrilaterals 1 2 5 4, 2 3 6 5 and 3 1 4 6, which is how VTK and wedges of 18 nodes have them.
    #[test]
    fn wedges_of_20_and_21_nodes_have_the_middles_of_their_sides_in_the_order_of_seacas() {
        for (n, middles) in [(18, [15, 16, 17]), (20, [19, 17, 18]), (21, [20, 18, 19])] {
            let element = Element::of(Shape::Wedge, n).expect("it is known");
            assert_eq!(element.order.expect("it differs")[15..], middles, "{n}");
        }
    }

    #[test]
    fn every_order_names_each_node_once() {
        for (shape, n) in [
            (Shape::Hexahedron, 20),
            (Shape::Hexahedron, 27),
            (Shape::Wedge, 15),
            (Shape::Wedge, 18),
            (Shape::Wedge, 20),
            (Shape::Wedge, 21),
        ] {
            let element = Element::of(shape, n).expect("it is known");
            let mut order = element.order.expect("it differs").to_vec();
            assert_eq!(order.len(), element.n_kept);
            assert!(element.kind.can_have(element.n_kept));
            order.sort_unstable();
            order.dedup();
            assert_eq!(order.len(), element.n_kept, "{shape:?} {n}");
        }
    }
}

//! Gmsh's element types and their node order against VTK's.

use crate::mesh::CellKind::{self, *};
use crate::mesh::lagrange::{self, LatticePoint, inside_triangle, shell, shifted};
use std::sync::OnceLock;

/// Gmsh's number and the kind of elements with a fixed number of nodes.
const TYPES: [(i32, CellKind); 18] = [
    (1, Line),
    (2, Triangle),
    (3, Quadrilateral),
    (4, Tetrahedron),
    (5, Hexahedron),
    (6, Wedge),
    (7, Pyramid),
    (8, Line3),
    (9, Triangle6),
    (10, Quadrilateral9),
    (11, Tetrahedron10),
    (12, Hexahedron27),
    (13, Wedge18),
    (15, Vertex),
    (16, Quadrilateral8),
    (17, Hexahedron20),
    (18, Wedge15),
    (19, Pyramid13),
];

/// Gmsh's numbers of complete elements, from first order on.
const ORDERS: [(CellKind, &[i32]); 7] = [
    (LagrangeCurve, &[1, 8, 26, 27, 28, 62, 63, 64, 65, 66]),
    (LagrangeTriangle, &[2, 9, 21, 23, 25, 42, 43, 44, 45, 46]),
    (
        LagrangeQuadrilateral,
        &[3, 10, 36, 37, 38, 47, 48, 49, 50, 51],
    ),
    (
        LagrangeTetrahedron,
        &[4, 11, 29, 30, 31, 71, 72, 73, 74, 75],
    ),
    (LagrangeHexahedron, &[5, 12, 92, 93, 94, 95, 96, 97, 98]),
    (LagrangeWedge, &[6, 13, 90, 91, 106, 107, 108, 109, 110]),
    (LagrangePyramid, &[7, 14, 118, 119, 120, 121, 122, 123, 124]),
];

#[derive(Debug)]
pub(super) struct Type {
    pub kind: CellKind,
    pub n_nodes: usize,
    /// For each of Gmsh's nodes its place among VTK's; empty where both count alike.
    to_vtk: Vec<u16>,
}

impl Type {
    fn new(kind: CellKind, n_nodes: usize) -> Self {
        let mut to_vtk = Vec::new();
        let complete = ORDERS.iter().map(|(complete, _)| *complete);
        if let Some(of) = { complete }.find(|complete| complete.linear() == kind.linear()) {
            // Incomplete elements of second order have the first nodes of complete ones.
            let order = lagrange::order(of, n_nodes).unwrap_or(2);
            let order = (lattice(of, order as u16), lagrange::lattice(of, order));
            let places = lagrange::permutation(&order.0, &order.1);
            let places = places.expect("both have the same places").into_iter();
            to_vtk = places.take(n_nodes).map(|vtk| vtk as u16).collect();
        }
        if to_vtk.iter().zip(0..).all(|(to, i)| *to == i) {
            to_vtk.clear();
        }
        Self {
            kind,
            n_nodes,
            to_vtk,
        }
    }

    /// The place among VTK's nodes of Gmsh's node `i`.
    #[inline]
    pub fn vtk(&self, i: usize) -> usize {
        match &self.to_vtk[..] {
            [] => i,
            to => to[i].into(),
        }
    }
}

/// The element type with this number, or a sentence that refuses it.
pub(super) fn element_type(number: i64) -> Result<&'static Type, String> {
    static KNOWN: [OnceLock<Option<Type>>; 128] = [const { OnceLock::new() }; 128];
    let known = usize::try_from(number).ok().and_then(|i| KNOWN.get(i));
    let found = known.and_then(|cell| cell.get_or_init(|| make(number)).as_ref());
    found.ok_or_else(|| refused(number))
}

fn make(number: i64) -> Option<Type> {
    let is = |of: &i32| i64::from(*of) == number;
    if let Some((_, kind)) = TYPES.iter().find(|(of, _)| is(of)) {
        return Some(Type::new(*kind, kind.n_nodes()?));
    }
    ORDERS.iter().find_map(|(kind, numbers)| {
        let order = numbers.iter().position(is)? + 1;
        Some(Type::new(*kind, lagrange::n_nodes(*kind, order)?))
    })
}

fn refused(number: i64) -> String {
    let what = match number {
        20 | 22 | 24 | 32 | 33 | 39..=41 | 52..=61 | 79..=83 | 99..=105 | 111..=117 | 125..=131 => {
            "an incomplete (serendipity) element of third or higher order, which lacks nodes inside; mesh with \
             Mesh.SecondOrderIncomplete = 0 for complete ones"
        }
        34 | 35 => "a polygon or polyhedron that Gmsh makes by cutting elements with a level set",
        67..=70 => "the border between cut elements",
        84..=89 | 132 => "an element of order zero, which has no corners",
        133..=136 => "a part of another element, cut by a level set",
        137..=140 => "an element with bubble or enriched nodes",
        _ => "unknown",
    };
    format!(
        "element type {number} is {what}; points, complete elements of any order, and incomplete ones \
         of second order are read"
    )
}

/// Gmsh's number for elements of this kind with `n_nodes`; `None` where it has none.
pub(super) fn number(kind: CellKind, n_nodes: usize) -> Option<i32> {
    if let Some((number, _)) = TYPES.iter().find(|(_, of)| *of == kind) {
        return Some(*number);
    }
    let kind = if kind == CubicLine {
        LagrangeCurve
    } else {
        kind
    };
    let (_, numbers) = ORDERS.iter().find(|(of, _)| *of == kind)?;
    let order = lagrange::order(kind, n_nodes)?;
    numbers.get(order - 1).copied()
}

/// The type that cells of this kind with `n_nodes` are written as.
pub(super) fn written_type(kind: CellKind, n_nodes: usize) -> Option<(i32, Type)> {
    Some((number(kind, n_nodes)?, Type::new(kind, n_nodes)))
}

/// Each node's place in a Lagrange kind's element of this order, in Gmsh's order: corners, edges, faces,
/// inside, where faces and the inside are ordered as elements of lower order are.
fn lattice(kind: CellKind, p: u16) -> Vec<LatticePoint> {
    if p == 0 {
        return vec![[0; 3]];
    }
    // Ends of the edges, corners of the axes of the faces, number of triangles, which are the first faces, and
    // the difference to the order of the element inside.
    let (edges, faces, n_triangles, lower): (&[u8], &[usize], usize, Option<u16>) = match kind {
        LagrangeTetrahedron => (
            &[0, 1, 1, 2, 2, 0, 3, 0, 3, 2, 3, 1],
            &[0, 2, 1, 0, 1, 3, 0, 3, 2, 3, 1, 2],
            4,
            Some(4),
        ),
        LagrangeHexahedron => (
            &[
                0, 1, 0, 3, 0, 4, 1, 2, 1, 5, 2, 3, 2, 6, 3, 7, 4, 5, 4, 7, 5, 6, 6, 7,
            ],
            &[0, 3, 1, 0, 1, 4, 0, 4, 3, 1, 2, 5, 2, 3, 6, 4, 5, 7],
            0,
            Some(2),
        ),
        LagrangeWedge => (
            &[0, 1, 0, 2, 0, 3, 1, 2, 1, 4, 2, 5, 3, 4, 3, 5, 4, 5],
            &[0, 2, 1, 3, 4, 5, 0, 1, 3, 0, 3, 2, 1, 2, 4],
            2,
            None,
        ),
        LagrangePyramid => (
            &[0, 1, 0, 3, 0, 4, 1, 2, 1, 4, 2, 3, 2, 4, 3, 4],
            &[0, 1, 4, 3, 0, 4, 1, 2, 4, 2, 3, 4, 0, 3, 1],
            4,
            Some(3),
        ),
        LagrangeQuadrilateral => {
            let places = quadrilateral(p).into_iter();
            return places.map(|[i, j]| [i, j, 0]).collect();
        }
        // VTK's order is the same.
        _ => return lagrange::lattice(kind, p.into()),
    };
    let (triangle, square) = (&inside_triangle(p)[..], &inside_quadrilateral(p)[..]);
    let mut corners = lagrange::lattice(kind, 1);
    corners.iter_mut().flatten().for_each(|i| *i *= p);
    let faces = faces.as_chunks().0.iter().enumerate();
    let inside = |i| if i < n_triangles { triangle } else { square };
    let faces: Vec<_> = faces.map(|(i, axes)| (*axes, inside(i))).collect();
    let mut places = shell(p, &corners, edges.as_chunks().0, &faces);
    if kind == LagrangeWedge {
        // Each place of a triangle has a line upwards, its ends first.
        let upwards: Vec<u16> = match p {
            ..3 => (1..p).collect(),
            _ => [1, p - 1].into_iter().chain(2..p - 1).collect(),
        };
        for [i, j] in triangle {
            places.extend(upwards.iter().map(|k| [*i, *j, *k]));
        }
    }
    if let Some(inner) = lower.and_then(|lower| p.checked_sub(lower)) {
        places.extend(shifted(lattice(kind, inner)));
    }
    places
}

/// Corners, edges all the way round, then a quadrilateral two orders lower.
fn quadrilateral(p: u16) -> Vec<[u16; 2]> {
    if p == 0 {
        return vec![[0, 0]];
    }
    let mut places = vec![[0, 0], [p, 0], [p, p], [0, p]];
    places.extend((1..p).map(|i| [i, 0]));
    places.extend((1..p).map(|i| [p, i]));
    places.extend((1..p).map(|i| [p - i, p]));
    places.extend((1..p).map(|i| [0, p - i]));
    places.extend(inside_quadrilateral(p));
    places
}

fn inside_quadrilateral(p: u16) -> Vec<[u16; 2]> {
    let inner = p.checked_sub(2);
    inner.map_or(Vec::new(), |inner| shifted(quadrilateral(inner)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_lie_where_gmsh_puts_them() {
        let dump = include_str!("../../../testdata/gmsh_orders.txt");
        assert_eq!(dump.lines().count(), 67);
        for line in dump.lines() {
            let words: Vec<&str> = line.split(' ').collect();
            let number = words[0].parse::<i64>().expect("an element type");
            let order: u16 = words[2].parse().expect("an order");
            let place = |word: &&str| -> LatticePoint {
                let steps: Vec<u16> = word
                    .split(',')
                    .map(|i| i.parse().expect("a step"))
                    .collect();
                steps.try_into().expect("three steps")
            };
            let expected: Vec<LatticePoint> = words[3..].iter().map(place).collect();
            let kind = match words[1] {
                "Line" => LagrangeCurve,
                "Triangle" => LagrangeTriangle,
                "Quadrangle" => LagrangeQuadrilateral,
                "Tetrahedron" => LagrangeTetrahedron,
                "Hexahedron" => LagrangeHexahedron,
                "Prism" => LagrangeWedge,
                _ => LagrangePyramid,
            };
            assert_eq!(lattice(kind, order), expected, "{kind:?} {order}");
            let found = super::number(kind, expected.len());
            assert_eq!(found.map(i64::from), Some(number), "{kind:?} {order}");
        }
    }

    #[test]
    fn middle_nodes_of_second_order_are_in_the_order_of_lagrange_cells() {
        for (of, _) in ORDERS {
            let places = lagrange::lattice(of, 2);
            for kind in CellKind::ALL {
                let Some(n) = kind.n_nodes().filter(|_| kind.linear() == of.linear()) else {
                    continue;
                };
                let n_corners = of.linear().n_nodes().expect("no polygon");
                if n == n_corners || number(kind, n).is_none() || kind == CubicLine {
                    continue;
                }
                for (edge, middle) in kind.edges().iter().zip(&places[n_corners..]) {
                    let [a, b] = edge.map(|corner| places[usize::from(corner)]);
                    let expected: Vec<u16> = a.iter().zip(b).map(|(a, b)| (a + b) / 2).collect();
                    assert_eq!(middle[..], expected, "{kind:?}");
                }
            }
        }
    }

    #[test]
    fn every_element_goes_to_its_kind_and_back() {
        for number in (-1..200).chain([1000, i64::MAX]) {
            let Ok(of) = element_type(number) else {
                continue;
            };
            let back = super::number(of.kind, of.n_nodes);
            assert_eq!(back.map(i64::from), Some(number));
            let mut places: Vec<usize> = (0..of.n_nodes).map(|i| of.vtk(i)).collect();
            places.sort_unstable();
            assert!(places.into_iter().eq(0..of.n_nodes), "{number}");
        }
        assert_eq!(number(CubicLine, 4), Some(26));
        assert_eq!(number(LagrangePyramid, 14), Some(14));
        assert_eq!(number(LagrangeHexahedron, 27), Some(12));
        assert_eq!(number(LagrangeTriangle, 7), None);
        assert_eq!(number(LagrangeCurve, 12), None);
    }
}

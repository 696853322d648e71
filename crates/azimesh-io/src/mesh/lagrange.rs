//! Lagrange cells of any order: number and positions of their nodes, in VTK's order.
//!
//! The nodes form a lattice with steps of 1/order along the axes of the reference cell. Comparing the
//! lattices of two programs gives the permutation between their node orders.
//! Bezier cells have their control points at the same places. VTK has a number but no code for
//! pyramids of any order; theirs are ordered here as VTK orders the others, and its 19-node pyramid:
//! corners, edges, base, sides, inside.

use super::CellKind::{self, *};
use std::collections::BTreeMap;

/// A node of a cell's lattice: steps along the reference cell's axes. In a simplex their sum is at
/// most the order; in a wedge the sum of the first two is. In a pyramid the first and the second are
/// each at most the order less the third.
pub type LatticePoint = [u16; 3];

/// Nodes of a Lagrange or Bezier cell of an order from 1 on; `None` for other kinds, and where there
/// are more than 2^32.
pub fn n_nodes(kind: CellKind, order: usize) -> Option<usize> {
    let p = u64::try_from(order)
        .ok()
        .filter(|p| (1..1 << 20).contains(p))?;
    let n = match kind {
        LagrangeCurve | BezierCurve => p + 1,
        LagrangeTriangle | BezierTriangle => (p + 1) * (p + 2) / 2,
        LagrangeQuadrilateral | BezierQuadrilateral => (p + 1) * (p + 1),
        LagrangeTetrahedron | BezierTetrahedron => (p + 1) * (p + 2) * (p + 3) / 6,
        LagrangeHexahedron | BezierHexahedron => (p + 1) * (p + 1) * (p + 1),
        LagrangeWedge | BezierWedge => (p + 1) * (p + 1) * (p + 2) / 2,
        LagrangePyramid | BezierPyramid => (p + 1) * (p + 2) * (2 * p + 3) / 6,
        _ => return None,
    };
    usize::try_from(n)
        .ok()
        .filter(|n| u32::try_from(*n).is_ok())
}

/// Order of a Lagrange or Bezier cell with `n` nodes; `None` where no order has as many: other
/// kinds, orders that differ along the axes, and the cells of second order that VTK knows with a
/// node inside each triangle (7, 15 and 21 nodes of a triangle, a tetrahedron and a wedge).
pub fn order(kind: CellKind, n: usize) -> Option<usize> {
    let enough = |order: &usize| n_nodes(kind, *order).is_none_or(|count| count >= n);
    let found = (1..)
        .find(enough)
        .expect("counts grow until there are none");
    (n_nodes(kind, found) == Some(n)).then_some(found)
}

/// Lattice points of the nodes of a Lagrange or Bezier cell, in VTK's order; empty where [`n_nodes`] is
/// `None`, and for orders above 65534.
pub fn lattice(kind: CellKind, order: usize) -> Vec<LatticePoint> {
    let (Ok(p @ ..=65534), Some(_)) = (u16::try_from(order), n_nodes(kind, order)) else {
        return Vec::new();
    };
    match kind {
        LagrangeCurve | BezierCurve => curve(p),
        LagrangeTriangle | BezierTriangle => flat(triangle(p)),
        LagrangeQuadrilateral | BezierQuadrilateral => flat(quadrilateral(p)),
        LagrangeTetrahedron | BezierTetrahedron => tetrahedron(p),
        LagrangeHexahedron | BezierHexahedron => hexahedron(p),
        LagrangeWedge | BezierWedge => wedge(p),
        LagrangePyramid | BezierPyramid => pyramid(p),
        _ => Vec::new(),
    }
}

/// For each place of `wanted` its position in `given`; `None` unless both have the same places.
pub fn permutation(wanted: &[LatticePoint], given: &[LatticePoint]) -> Option<Vec<usize>> {
    let at: BTreeMap<LatticePoint, usize> = given.iter().copied().zip(0..).collect();
    let found: Vec<usize> = wanted
        .iter()
        .map_while(|place| at.get(place).copied())
        .collect();
    (at.len() == given.len() && found.len() == given.len() && wanted.len() == given.len())
        .then_some(found)
}

/// `from`, moved by steps towards corners that are 0 or `order` steps away along each axis.
fn moved<const N: usize>(
    from: LatticePoint,
    towards: [(LatticePoint, u16); N],
    order: u16,
) -> LatticePoint {
    std::array::from_fn(|axis| {
        let step = |(to, n): &(LatticePoint, u16)| {
            let way = i32::from(to[axis]) - i32::from(from[axis]);
            way.signum() * i32::from(*n)
        };
        let steps: i32 = towards.iter().map(step).sum();
        let place = i32::from(from[axis]) + steps;
        debug_assert!((0..=i32::from(order)).contains(&place));
        place as u16
    })
}

/// Places shifted by one step along each axis: inside a cell of higher order.
pub fn shifted<const N: usize>(places: Vec<[u16; N]>) -> Vec<[u16; N]> {
    places
        .into_iter()
        .map(|place| place.map(|i| i + 1))
        .collect()
}

fn flat(places: Vec<[u16; 2]>) -> Vec<LatticePoint> {
    places.into_iter().map(|[i, j]| [i, j, 0]).collect()
}

fn curve(p: u16) -> Vec<LatticePoint> {
    let ends = [[0, 0, 0], [p, 0, 0]];
    shell(p, &ends, Line.edges(), &[])
}

/// Corners, edges, then a triangle three orders lower.
pub fn triangle(p: u16) -> Vec<[u16; 2]> {
    if p == 0 {
        return vec![[0, 0]];
    }
    let mut places = vec![[0, 0], [p, 0], [0, p]];
    places.extend((1..p).map(|i| [i, 0]));
    places.extend((1..p).map(|i| [p - i, i]));
    places.extend((1..p).map(|i| [0, p - i]));
    places.extend(inside_triangle(p));
    places
}

/// The places inside a triangle.
pub fn inside_triangle(p: u16) -> Vec<[u16; 2]> {
    match p.checked_sub(3) {
        Some(inner) => shifted(triangle(inner)),
        None => Vec::new(),
    }
}

fn quadrilateral(p: u16) -> Vec<[u16; 2]> {
    let mut places = vec![[0, 0], [p, 0], [p, p], [0, p]];
    places.extend((1..p).map(|i| [i, 0]));
    places.extend((1..p).map(|i| [p, i]));
    places.extend((1..p).map(|i| [i, p]));
    places.extend((1..p).map(|i| [0, i]));
    places.extend(rows(p));
    places
}

/// The places inside a quadrilateral, row by row.
fn rows(p: u16) -> Vec<[u16; 2]> {
    let row = |j| (1..p).map(move |i| [i, j]);
    (1..p).flat_map(row).collect()
}

/// Corners, the places inside the edges between pairs of them, and those inside the faces. A face is given by the corner
/// that its axes lead from, the two corners that they lead to, and the steps along them to each place.
pub fn shell(
    p: u16,
    corners: &[LatticePoint],
    edges: &[[u8; 2]],
    faces: &[([usize; 3], &[[u16; 2]])],
) -> Vec<LatticePoint> {
    let mut places = corners.to_vec();
    for [from, to] in edges
        .iter()
        .map(|edge| edge.map(|end| corners[usize::from(end)]))
    {
        places.extend((1..p).map(|step| moved(from, [(to, step)], p)));
    }
    for (axes, inside) in faces {
        let [corner, first, second] = axes.map(|corner| corners[corner]);
        let place = |&[i, j]: &[u16; 2]| moved(corner, [(first, i), (second, j)], p);
        places.extend(inside.iter().map(place));
    }
    places
}

fn tetrahedron(p: u16) -> Vec<LatticePoint> {
    if p == 0 {
        return vec![[0; 3]];
    }
    let corners = [[0, 0, 0], [p, 0, 0], [0, p, 0], [0, 0, p]];
    let inside = &inside_triangle(p)[..];
    let faces = [[0, 1, 3], [2, 3, 1], [0, 3, 2], [0, 2, 1]].map(|axes| (axes, inside));
    let mut places = shell(p, &corners, Tetrahedron.edges(), &faces);
    if let Some(inner) = p.checked_sub(4) {
        places.extend(shifted(tetrahedron(inner)));
    }
    places
}

fn hexahedron(p: u16) -> Vec<LatticePoint> {
    let base = [[0, 0, 0], [p, 0, 0], [p, p, 0], [0, p, 0]];
    let corners = [base, base.map(|[i, j, _]| [i, j, p])].concat();
    let edges = [
        [[0, 1], [1, 2], [3, 2], [0, 3]],
        [[4, 5], [5, 6], [7, 6], [4, 7]],
        [[0, 4], [1, 5], [2, 6], [3, 7]],
    ]
    .concat();
    let inside = &rows(p)[..];
    let axes = [
        [0, 3, 4],
        [1, 2, 5],
        [0, 1, 4],
        [3, 2, 7],
        [0, 1, 3],
        [4, 5, 7],
    ];
    let mut places = shell(p, &corners, &edges, &axes.map(|axes| (axes, inside)));
    for k in 1..p {
        places.extend(inside.iter().map(|[i, j]| [*i, *j, k]));
    }
    places
}

/// Triangles inside a wedge are filled row by row, unlike all others.
fn wedge(p: u16) -> Vec<LatticePoint> {
    let base = [[0, 0, 0], [p, 0, 0], [0, p, 0]];
    let corners = [base, base.map(|[i, j, _]| [i, j, p])].concat();
    let mut triangle = rows(p);
    triangle.retain(|[i, j]| i + j < p);
    let (triangle, square) = (&triangle[..], &rows(p)[..]);
    let faces = [
        ([0, 1, 2], triangle),
        ([3, 4, 5], triangle),
        ([0, 1, 3], square),
        ([1, 2, 4], square),
        ([2, 0, 5], square),
    ];
    let mut places = shell(p, &corners, Wedge.edges(), &faces);
    for k in 1..p {
        places.extend(triangle.iter().map(|[i, j]| [*i, *j, k]));
    }
    places
}

fn pyramid(p: u16) -> Vec<LatticePoint> {
    if p == 0 {
        return vec![[0; 3]];
    }
    let corners = [[0, 0, 0], [p, 0, 0], [p, p, 0], [0, p, 0], [0, 0, p]];
    let edges = [
        [[0, 1], [1, 2], [3, 2], [0, 3]],
        [[0, 4], [1, 4], [2, 4], [3, 4]],
    ]
    .concat();
    let (square, side) = (&rows(p)[..], &inside_triangle(p)[..]);
    let faces = [
        ([0, 1, 3], square),
        ([0, 1, 4], side),
        ([1, 2, 4], side),
        ([2, 3, 4], side),
        ([3, 0, 4], side),
    ];
    let mut places = shell(p, &corners, &edges, &faces);
    if let Some(inner) = p.checked_sub(3) {
        places.extend(shifted(pyramid(inner)));
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: [CellKind; 7] = [
        LagrangeCurve,
        LagrangeTriangle,
        LagrangeQuadrilateral,
        LagrangeTetrahedron,
        LagrangeHexahedron,
        LagrangeWedge,
        LagrangePyramid,
    ];

    #[test]
    fn nodes_lie_where_vtk_puts_them() {
        let dump = include_str!("../../testdata/lagrange_orders.txt");
        assert_eq!(dump.lines().count(), 36);
        for line in dump.lines() {
            let mut words = line.split(' ');
            let mut number = || words.next().and_then(|word| word.parse::<u16>().ok());
            let (kind, order) = (number().expect("a type"), number().expect("an order"));
            let kind = CellKind::from_vtk(kind as u8).expect("VTK's number");
            let place = |word: &str| {
                let steps: Vec<u16> = word
                    .split(',')
                    .map(|i| i.parse().expect("a step"))
                    .collect();
                LatticePoint::try_from(steps).expect("three steps")
            };
            let expected: Vec<LatticePoint> = words.map(place).collect();
            assert_eq!(lattice(kind, order.into()), expected, "{kind:?} {order}");
        }
    }

    #[test]
    fn a_lattice_has_each_place_once_and_as_many_as_its_order_says() {
        for kind in KINDS {
            for p in 1..12 {
                let mut places = lattice(kind, p);
                assert_eq!(Some(places.len()), n_nodes(kind, p), "{kind:?} {p}");
                assert_eq!(order(kind, places.len()), Some(p), "{kind:?} {p}");
                places.sort_unstable();
                places.dedup();
                assert_eq!(Some(places.len()), n_nodes(kind, p), "{kind:?} {p}");
            }
        }
        assert_eq!(order(LagrangeTriangle, 7), None);
        assert_eq!(order(LagrangeQuadrilateral, 12), None);
        assert_eq!(order(Triangle6, 6), None);
        assert_eq!(order(LagrangeCurve, usize::MAX), None);
        assert!(lattice(LagrangeCurve, 0).is_empty());
    }

    #[test]
    fn a_pyramid_of_second_order_is_the_13_node_one_with_the_centre_of_its_base() {
        let places = lattice(LagrangePyramid, 2);
        let middle = |[a, b]: [u8; 2]| -> LatticePoint {
            std::array::from_fn(|i| (places[usize::from(a)][i] + places[usize::from(b)][i]) / 2)
        };
        for (place, edge) in places[5..].iter().zip(Pyramid13.edges()) {
            assert_eq!(*place, middle(*edge));
        }
        assert_eq!(places[13], [1, 1, 0]);
    }

    #[test]
    fn an_order_of_the_same_places_is_a_permutation() {
        let vtk = lattice(LagrangeTriangle, 2);
        let other = [vtk[2], vtk[0], vtk[5], vtk[1], vtk[4], vtk[3]];
        assert_eq!(permutation(&vtk, &other), Some(vec![1, 3, 0, 5, 4, 2]));
        assert_eq!(permutation(&vtk, &other[..5]), None);
        assert_eq!(permutation(&vtk, &[vtk[0]; 6]), None);
    }
}

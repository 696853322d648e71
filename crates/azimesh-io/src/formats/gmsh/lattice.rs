//! Gmsh's order of the nodes of complete elements: corners, edges, faces, inside, where faces and the
//! inside are ordered as elements of lower order are.

use crate::mesh::CellKind::{self, *};
use crate::mesh::lagrange::{self, LatticePoint, inside_triangle, shell, shifted};

/// Where each node of a Lagrange kind's element of this order lies, in Gmsh's order; empty for other
/// kinds.
pub(super) fn lattice(kind: CellKind, p: u16) -> Vec<LatticePoint> {
    match kind {
        // These are ordered as VTK orders them.
        LagrangeCurve | LagrangeTriangle => lagrange::lattice(kind, p.into()),
        LagrangeQuadrilateral => {
            let places = quadrilateral(p).into_iter();
            places.map(|[i, j]| [i, j, 0]).collect()
        }
        LagrangeTetrahedron => tetrahedron(p),
        LagrangeHexahedron => hexahedron(p),
        LagrangeWedge => wedge(p),
        LagrangePyramid => pyramid(p),
        _ => Vec::new(),
    }
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
    match p.checked_sub(2) {
        Some(inner) => shifted(quadrilateral(inner)),
        None => Vec::new(),
    }
}

fn tetrahedron(p: u16) -> Vec<LatticePoint> {
    if p == 0 {
        return vec![[0; 3]];
    }
    let corners = [[0, 0, 0], [p, 0, 0], [0, p, 0], [0, 0, p]];
    let edges = [[0, 1], [1, 2], [2, 0], [3, 0], [3, 2], [3, 1]];
    let inside = &inside_triangle(p)[..];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [3, 1, 2]].map(|axes| (axes, inside));
    let mut places = shell(p, &corners, &edges, &faces);
    if let Some(inner) = p.checked_sub(4) {
        places.extend(shifted(tetrahedron(inner)));
    }
    places
}

fn hexahedron(p: u16) -> Vec<LatticePoint> {
    if p == 0 {
        return vec![[0; 3]];
    }
    let base = [[0, 0, 0], [p, 0, 0], [p, p, 0], [0, p, 0]];
    let corners = [base, base.map(|[i, j, _]| [i, j, p])].concat();
    let edges = [
        [[0, 1], [0, 3], [0, 4], [1, 2], [1, 5], [2, 3]],
        [[2, 6], [3, 7], [4, 5], [4, 7], [5, 6], [6, 7]],
    ]
    .concat();
    let inside = &inside_quadrilateral(p)[..];
    let axes = [
        [0, 3, 1],
        [0, 1, 4],
        [0, 4, 3],
        [1, 2, 5],
        [2, 3, 6],
        [4, 5, 7],
    ];
    let mut places = shell(p, &corners, &edges, &axes.map(|axes| (axes, inside)));
    if let Some(inner) = p.checked_sub(2) {
        places.extend(shifted(hexahedron(inner)));
    }
    places
}

/// Inside, each place of a triangle has a line upwards, its ends first.
fn wedge(p: u16) -> Vec<LatticePoint> {
    let base = [[0, 0, 0], [p, 0, 0], [0, p, 0]];
    let corners = [base, base.map(|[i, j, _]| [i, j, p])].concat();
    let edges = [
        [[0, 1], [0, 2], [0, 3]],
        [[1, 2], [1, 4], [2, 5]],
        [[3, 4], [3, 5], [4, 5]],
    ]
    .concat();
    let (triangle, square) = (&inside_triangle(p)[..], &inside_quadrilateral(p)[..]);
    let faces = [
        ([0, 2, 1], triangle),
        ([3, 4, 5], triangle),
        ([0, 1, 3], square),
        ([0, 3, 2], square),
        ([1, 2, 4], square),
    ];
    let mut places = shell(p, &corners, &edges, &faces);
    let upwards: Vec<u16> = match p {
        ..3 => (1..p).collect(),
        _ => [1, p - 1].into_iter().chain(2..p - 1).collect(),
    };
    for [i, j] in triangle {
        places.extend(upwards.iter().map(|k| [*i, *j, *k]));
    }
    places
}

fn pyramid(p: u16) -> Vec<LatticePoint> {
    if p == 0 {
        return vec![[0; 3]];
    }
    let corners = [[0, 0, 0], [p, 0, 0], [p, p, 0], [0, p, 0], [0, 0, p]];
    let edges = [
        [[0, 1], [0, 3], [0, 4], [1, 2]],
        [[1, 4], [2, 3], [2, 4], [3, 4]],
    ]
    .concat();
    let (square, side) = (&inside_quadrilateral(p)[..], &inside_triangle(p)[..]);
    let faces = [
        ([0, 1, 4], side),
        ([3, 0, 4], side),
        ([1, 2, 4], side),
        ([2, 3, 4], side),
        ([0, 3, 1], square),
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
            let found = super::super::kinds::number(kind, expected.len());
            assert_eq!(found.map(i64::from), Some(number), "{kind:?} {order}");
        }
    }
}

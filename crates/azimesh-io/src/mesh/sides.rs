//! The faces of single cells, which are edges in 2D: their corners, and all of their nodes.

use super::lagrange::{self, LatticePoint};
use super::{CellKind, CellRef, Cells};
use CellKind::*;

/// Calls `visit(face, corners)` for each face of a cell: an edge of a cell in the plane, an end of
/// a line. The corners turn as the cell's kind has them.
#[inline]
pub fn for_each_side(cells: &Cells, cell: &CellRef<'_>, mut visit: impl FnMut(usize, &[u32])) {
    match cell.kind {
        Polyhedron => {
            for (face, nodes) in cells.polyhedron_faces(cell.index).enumerate() {
                visit(face, nodes);
            }
        }
        Polygon | QuadraticPolygon => {
            let corners = &cell.nodes[..cell.kind.n_corners(cell.nodes.len())];
            for (i, &from) in corners.iter().enumerate() {
                visit(i, &[from, corners[(i + 1) % corners.len()]]);
            }
        }
        kind => {
            let mut nodes = [0; 8];
            for (face, corners) in kind.faces().iter().enumerate() {
                for (i, &corner) in corners.iter().enumerate() {
                    nodes[i] = cell.nodes[usize::from(corner)];
                }
                visit(face, &nodes[..corners.len()]);
            }
        }
    }
}

/// Calls `read` with the corners of one face of a cell; with no corners if there is no such face.
pub(crate) fn side_corners<T>(
    cells: &Cells,
    cell: &CellRef<'_>,
    face: usize,
    read: impl FnOnce(&[u32]) -> T,
) -> T {
    match cell.kind {
        Polyhedron => read(cells.polyhedron_faces(cell.index).nth(face).unwrap_or(&[])),
        Polygon | QuadraticPolygon => {
            let corners = &cell.nodes[..cell.kind.n_corners(cell.nodes.len())];
            match corners.get(face) {
                Some(&from) => read(&[from, corners[(face + 1) % corners.len()]]),
                None => read(&[]),
            }
        }
        kind => {
            let corners = kind.faces().get(face).copied().unwrap_or(&[]);
            let mut nodes = [0; 8];
            for (i, &corner) in corners.iter().enumerate() {
                nodes[i] = cell.nodes[usize::from(corner)];
            }
            read(&nodes[..corners.len()])
        }
    }
}

/// A face of a cell as a cell, with all nodes on it. `None` where it is not
/// known which do: cells whose orders along their axes differ, and some kinds of VTK's own.
pub fn side(cells: &Cells, cell: &CellRef<'_>, face: usize) -> Option<(CellKind, Vec<u32>)> {
    if cell.kind == Polyhedron {
        let nodes = cells.polyhedron_faces(cell.index).nth(face)?;
        return Some((flat(nodes.len()), nodes.to_vec()));
    }
    let (kind, places) = places(cell.kind, cell.nodes.len(), face)?;
    Some((kind, places.into_iter().map(|i| cell.nodes[i]).collect()))
}

/// Kind of a face of `kind` with `n_nodes` nodes, and where its nodes are among the cell's.
fn places(kind: CellKind, n_nodes: usize, face: usize) -> Option<(CellKind, Vec<usize>)> {
    let n_corners = kind.n_corners(n_nodes);
    if matches!(kind, Polygon | QuadraticPolygon) {
        let ends = vec![face, (face + 1) % n_corners];
        return Some(match kind {
            Polygon => (Line, ends),
            _ => (Line3, [&ends[..], &[n_corners + face]].concat()),
        });
    }
    let corners = kind.faces().get(face)?.iter().map(|&i| usize::from(i));
    let corners: Vec<usize> = corners.collect();
    if !kind.is_curved() || corners.len() == 1 {
        return Some((flat(corners.len()), corners));
    }
    match lagrange::order(kind, n_nodes) {
        Some(order) => of_any_order(kind, order, &corners),
        None => of_second_order(kind, n_corners, face, corners),
    }
}

/// The kind of a face with straight edges.
pub(crate) fn flat(n_corners: usize) -> CellKind {
    match n_corners {
        1 => Vertex,
        2 => Line,
        3 => Triangle,
        4 => Quadrilateral,
        _ => Polygon,
    }
}

/// Corners, then the middles of the edges, which a cell lists in the order of its edges, then the
/// middle of the face.
fn of_second_order(
    kind: CellKind,
    n_corners: usize,
    face: usize,
    mut nodes: Vec<usize>,
) -> Option<(CellKind, Vec<usize>)> {
    let n = nodes.len();
    let centre = match kind {
        Triangle6 | Triangle7 | Quadrilateral8 | Quadrilateral9 | Tetrahedron10 | Hexahedron20
        | Wedge15 | Pyramid13 => None,
        Hexahedron27 => Some(20 + face),
        Wedge18 if n == 4 => Some(13 + face),
        Wedge18 => None,
        _ => return None,
    };
    let middle = |a: usize, b: usize| {
        let joins = |edge: &[u8; 2]| {
            let edge = edge.map(usize::from);
            edge == [a, b] || edge == [b, a]
        };
        let edges = kind.edges().iter().position(joins);
        edges.map(|edge| n_corners + edge)
    };
    for i in 0..if n == 2 { 1 } else { n } {
        nodes.push(middle(nodes[i], nodes[(i + 1) % n])?);
    }
    nodes.extend(centre);
    let kind = match (n, centre) {
        (2, _) => Line3,
        (3, _) => Triangle6,
        (_, None) => Quadrilateral8,
        (_, Some(_)) => Quadrilateral9,
    };
    Some((kind, nodes))
}

/// The nodes on the lattice between a face's corners, in the order of the face's own lattice.
fn of_any_order(kind: CellKind, order: usize, corners: &[usize]) -> Option<(CellKind, Vec<usize>)> {
    let is_bezier = kind as u8 >= BezierCurve as u8;
    let face = match (corners.len(), is_bezier) {
        (2, false) => LagrangeCurve,
        (3, false) => LagrangeTriangle,
        (4, false) => LagrangeQuadrilateral,
        (2, true) => BezierCurve,
        (3, true) => BezierTriangle,
        (4, true) => BezierQuadrilateral,
        _ => return None,
    };
    let lattice = lagrange::lattice(kind, order);
    let order = i32::try_from(order).ok()?;
    let at = |node: usize| lattice[node].map(i32::from);
    let origin = at(corners[0]);
    let along = |to: usize| {
        let to = at(to);
        [0, 1, 2].map(|axis| (to[axis] - origin[axis]) / order)
    };
    let first = along(corners[1]);
    let second = corners
        .get(2)
        .map_or([0; 3], |_| along(corners[corners.len() - 1]));
    let place = |[i, j, _]: LatticePoint| {
        [0, 1, 2]
            .map(|axis| origin[axis] + i32::from(i) * first[axis] + i32::from(j) * second[axis])
    };
    let nodes = lagrange::lattice(face, order as usize)
        .into_iter()
        .map(|on_face| {
            let wanted = place(on_face);
            (0..lattice.len()).find(|&node| at(node) == wanted)
        })
        .collect::<Option<Vec<_>>>()?;
    // The quadratic pyramid with every middle has quadratic faces, since there is no kind of cell for it.
    let face = match (kind, nodes.len()) {
        (LagrangePyramid, 6) => Triangle6,
        (LagrangePyramid, 9) => Quadrilateral9,
        _ => face,
    };
    Some((face, nodes))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes of cells with this kind, second order and above.
    fn sizes(kind: CellKind) -> Vec<usize> {
        match kind.n_nodes() {
            Some(n) => vec![n],
            None => (1..=5).filter_map(|p| lagrange::n_nodes(kind, p)).collect(),
        }
    }

    #[test]
    fn a_face_has_its_corners_first_and_every_node_once() {
        for kind in CellKind::ALL {
            for n in sizes(kind) {
                for (face, corners) in kind.faces().iter().enumerate() {
                    let Some((of, nodes)) = places(kind, n, face) else {
                        continue;
                    };
                    assert!(of.can_have(nodes.len()), "{kind:?} {n}");
                    assert_eq!(of.dimension() + 1, kind.dimension());
                    let first: Vec<usize> = corners.iter().map(|&i| i.into()).collect();
                    assert_eq!(nodes[..first.len()], first, "{kind:?} {n}");
                    let mut once = nodes.clone();
                    once.sort_unstable();
                    once.dedup();
                    assert_eq!(once.len(), nodes.len(), "{kind:?} {n}");
                }
            }
        }
    }

    #[test]
    fn a_face_of_a_lagrange_cell_of_second_order_is_that_of_the_quadratic_cell() {
        let faces = |kind: CellKind, n| {
            let faces = 0..kind.faces().len();
            faces.map(move |face| places(kind, n, face).expect("it is known").1)
        };
        assert!(faces(LagrangeTetrahedron, 10).eq(faces(Tetrahedron10, 10)));
        assert!(faces(LagrangeTriangle, 6).eq(faces(Triangle6, 6)));
    }
}

//! Node orders of mirrored cells.

use super::CellKind::{self, *};
use super::lagrange;
use super::{CellRun, Cells};
use azimesh_core::error::{Error, Result, option};

impl Cells {
    /// Returns the cells with the node order of their mirror images, which keeps volumes positive when the points are mirrored.
    ///
    /// # Errors
    /// For Lagrange cells whose orders along their axes differ: the positions of their nodes are not known.
    pub fn mirrored(&self) -> Result<Self> {
        let mut cells = Self::new();
        cells.reserve(self.connectivity().len());
        for run in self.runs() {
            if run.kind == Polyhedron {
                self.push_mirrored_polyhedra(&run, &mut cells)?;
                continue;
            }
            let order = order(run.kind, run.n_nodes).ok_or_else(|| {
                Error::input(format!(
                    "cell {} is a {} with {} nodes, of which no mirror image is known; {} makes it linear",
                    run.first_cell,
                    run.kind.name(),
                    run.n_nodes,
                    option("linearize")
                ))
            })?;
            let nodes = run
                .cells()
                .flat_map(|nodes| order.iter().map(|&i| nodes[i]));
            cells.push_run(run.kind, run.n_nodes, &nodes.collect::<Vec<_>>());
        }
        Ok(cells)
    }

    fn push_mirrored_polyhedra(&self, run: &CellRun<'_>, to: &mut Self) -> Result<()> {
        for cell in run.cell_refs() {
            let mut stream = vec![self.n_faces(cell.index) as u32];
            for face in self.polyhedron_faces(cell.index) {
                stream.push(face.len() as u32);
                stream.extend(face.iter().rev());
            }
            to.push_polyhedron_with_nodes(cell.nodes, &stream)?;
        }
        Ok(())
    }
}

/// Returns the permutation from the nodes of a cell to the nodes of its mirror image.
fn order(kind: CellKind, n_nodes: usize) -> Option<Vec<usize>> {
    let n_corners = kind.n_corners(n_nodes);
    if kind >= LagrangeCurve {
        return of_lattice(kind, lagrange::order(kind, n_nodes)?);
    }
    let corners = corners(kind, n_corners);
    let mut all = corners.clone();
    match kind {
        CubicLine => all.extend([3, 2]),
        QuadraticPolygon => all.extend((0..n_corners).map(|i| 2 * n_corners - 1 - i)),
        _ => {
            let between = between(kind, n_nodes)?;
            for nodes in &between {
                let mut image: Vec<usize> = nodes.iter().map(|&i| corners[i]).collect();
                image.sort_unstable();
                let at = between.iter().position(|other| *other == image)?;
                all.push(n_corners + at);
            }
        }
    }
    (all.len() == n_nodes).then_some(all)
}

/// Returns the corners of the mirror image: the first two axes of the reference cell are exchanged. In the quadrilateral with two
/// curved edges the first axis is reversed instead, which keeps these edges.
fn corners(kind: CellKind, n: usize) -> Vec<usize> {
    let ring = |n: usize, from: usize| (0..n).map(move |i| from + (n - i) % n);
    match kind.linear() {
        Vertex => vec![0],
        Line => vec![1, 0],
        Quadrilateral if kind == QuadraticLinearQuadrilateral => vec![1, 0, 3, 2],
        Tetrahedron => vec![0, 2, 1, 3],
        Pyramid => vec![0, 3, 2, 1, 4],
        Wedge | Hexahedron | PentagonalPrism | HexagonalPrism => {
            ring(n / 2, 0).chain(ring(n / 2, n / 2)).collect()
        }
        _ => ring(n, 0).collect(),
    }
}

/// Returns the corners, ascending, between which each further node of a cell is; `None` if they are not known.
fn between(kind: CellKind, n_nodes: usize) -> Option<Vec<Vec<usize>>> {
    let sorted = |corners: &[u8]| {
        let mut corners: Vec<usize> = corners.iter().map(|&i| i.into()).collect();
        corners.sort_unstable();
        corners
    };
    let n_corners = kind.n_corners(n_nodes);
    if n_nodes == n_corners {
        return Some(Vec::new());
    }
    let edges: &[usize] = match kind {
        QuadraticLinearQuadrilateral => &[0, 2],
        QuadraticLinearWedge => &[0, 1, 2, 3, 4, 5],
        _ => &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11],
    };
    let edges = edges.iter().filter_map(|&i| kind.edges().get(i));
    let mut nodes: Vec<Vec<usize>> = edges.map(|edge| sorted(edge)).collect();
    match kind {
        Hexahedron27 | Pyramid19 => nodes.extend(kind.faces().iter().map(|face| sorted(face))),
        Wedge18 => nodes.extend(kind.faces()[2..].iter().map(|face| sorted(face))),
        Hexahedron24 => nodes.extend([2, 1, 3, 0].map(|face| sorted(kind.faces()[face]))),
        _ => {}
    }
    if matches!(kind, Triangle7 | Quadrilateral9 | Hexahedron27 | Pyramid19) {
        nodes.push((0..n_corners).collect());
    }
    Some(nodes)
}

/// Returns the order of a cell whose nodes are on a lattice.
fn of_lattice(kind: CellKind, order: usize) -> Option<Vec<usize>> {
    let given = lagrange::lattice(kind, order);
    let p = u16::try_from(order).ok()?;
    let image = given.iter().map(|&[i, j, k]| match kind.dimension() {
        1 => [p - i, 0, 0],
        _ => [j, i, k],
    });
    lagrange::permutation(&image.collect::<Vec<_>>(), &given)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells of this kind: numbers of nodes.
    fn sizes(kind: CellKind) -> Vec<usize> {
        match kind.n_nodes() {
            Some(n) => vec![n],
            None if kind == Polyhedron => Vec::new(),
            None if matches!(kind, Polygon | QuadraticPolygon) => vec![6, 8, 12],
            None => (1..=4).filter_map(|p| lagrange::n_nodes(kind, p)).collect(),
        }
    }

    #[test]
    fn the_mirror_image_of_a_mirror_image_is_the_cell() {
        for kind in CellKind::ALL {
            for n in sizes(kind) {
                let order = order(kind, n).expect("it is known");
                let twice: Vec<usize> = order.iter().map(|&i| order[i]).collect();
                assert_eq!(twice, (0..n).collect::<Vec<_>>(), "{kind:?} {n}");
                assert_eq!(order == twice, kind == Vertex, "{kind:?} {n}");
            }
        }
        assert_eq!(order(LagrangeQuadrilateral, 6), None);
    }

    #[test]
    fn edges_and_faces_of_a_mirror_image_have_their_own_nodes_between_their_corners() {
        for kind in [Tetrahedron10, Hexahedron20, Wedge15, Pyramid13, Triangle6] {
            let n = kind.n_nodes().expect("it is fixed");
            let order = order(kind, n).expect("it is known");
            let n_corners = kind.n_corners(n);
            for (i, edge) in kind.edges().iter().enumerate() {
                let ends = edge.map(|end| order[usize::from(end)]);
                let middle = kind.edges()[order[n_corners + i] - n_corners].map(usize::from);
                assert!(ends == middle || ends == [middle[1], middle[0]], "{kind:?}");
            }
        }
        assert_eq!(corners(Hexahedron, 8), [0, 3, 2, 1, 4, 7, 6, 5]);
        assert_eq!(corners(Wedge, 6), [0, 2, 1, 3, 5, 4]);
    }
}

//! A mesh with its cells, or its nodes and cells, in another order.

use super::arrays::select_tuples;
use super::{CellKind, Cells, Group, Mesh, MeshView, Origin};
use azimesh_core::geometry::curve;
use azimesh_core::parallel::{collect, sort};
use std::collections::BTreeMap;
use std::ops::Range;

/// Another order of the nodes and cells of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Reordering {
    /// The old node at each new place.
    nodes: Vec<usize>,
    /// The old cell at each new place.
    cells: Vec<usize>,
}

impl Reordering {
    /// Nodes along a Morton curve over their bounding box; cells by the first of their nodes on it. Cells of one kind in
    /// the same groups are put together, in the order in which such cells first come in the file, so that a group is
    /// not scattered and cells of one kind follow one another. Equal keys keep their order: a mesh in this order
    /// does not change.
    pub fn along_curve(mesh: &Mesh) -> Self {
        let nodes: Vec<usize> = curve::order(&mesh.points)
            .into_iter()
            .map(|node| node as usize)
            .collect();
        let place = inverse(&nodes);
        let class = classes(mesh);
        let first = |cell: usize| {
            let nodes = mesh.cells.get(cell).nodes.iter();
            nodes.map(|node| place[*node as usize]).min().unwrap_or(0)
        };
        let mut keyed = collect(mesh.cells.len(), |cell| {
            (class[cell], first(cell), cell as u32)
        });
        sort(&mut keyed);
        let cells = keyed.into_iter().map(|(_, _, cell)| cell as usize);
        Self {
            cells: cells.collect(),
            nodes,
        }
    }

    /// Returns whether a mesh has as many nodes and cells.
    pub fn fits(&self, mesh: &Mesh) -> bool {
        [self.nodes.len(), self.cells.len()] == [mesh.points.len(), mesh.cells.len()]
    }
}

/// The new place of each old index.
fn inverse(order: &[usize]) -> Vec<u32> {
    let mut place = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old] = new as u32;
    }
    place
}

/// For each cell the number of its class: its kind and the groups that it is in. Classes are numbered in the order of
/// their first cells.
fn classes(mesh: &Mesh) -> Vec<u32> {
    let mut kinds: Vec<CellKind> = Vec::new();
    let mut class = vec![0u32; mesh.cells.len()];
    for run in mesh.cells.runs() {
        let known = kinds.iter().position(|kind| *kind == run.kind);
        let number = known.unwrap_or(kinds.len());
        if known.is_none() {
            kinds.push(run.kind);
        }
        class[run.first_cell..run.first_cell + run.n_cells()].fill(number as u32);
    }
    let mut n_classes = kinds.len() as u32;
    for group in &mesh.groups {
        let mut split: BTreeMap<u32, u32> = BTreeMap::new();
        for cell in group.cells.iter() {
            class[cell] = *split.entry(class[cell]).or_insert_with(|| {
                n_classes += 1;
                n_classes - 1
            });
        }
    }
    let mut rank: Vec<Option<u32>> = vec![None; n_classes as usize];
    let mut n_ranks = 0;
    for class in &mut class {
        *class = *rank[*class as usize].get_or_insert_with(|| {
            n_ranks += 1;
            n_ranks - 1
        });
    }
    class
}

impl Mesh {
    /// Puts nodes and cells in another order; groups and arrays follow.
    ///
    /// # Panics
    /// When the order is of another number of nodes or cells.
    pub fn reorder(&mut self, order: &Reordering) {
        assert!(order.fits(self), "it has other nodes or cells");
        let points = std::mem::take(&mut self.points);
        self.points = collect(points.len(), |new| points[order.nodes[new]]);
        drop(points);
        select_tuples(&mut self.point_arrays, &order.nodes);
        select_tuples(&mut self.cell_arrays, &order.cells);
        let place = inverse(&order.cells);
        for group in &mut self.groups {
            let cells = group.cells.iter().map(|cell| place[cell] as usize);
            group.cells = cells.collect();
        }
        drop(place);
        self.cells = self.cells.select(order.cells.iter().copied());
        self.cells.renumber_nodes(&inverse(&order.nodes));
        self.origin = Origin::default();
    }
}

impl Cells {
    /// The cells of these ranges, in this order.
    pub(super) fn select_runs(&self, ranges: &[Range<usize>]) -> Self {
        let mut cells = Self::new();
        for range in ranges {
            for run in self.runs_in(range.clone()) {
                match run.kind {
                    CellKind::Polyhedron => {
                        let polyhedra = run.first_cell..run.first_cell + run.n_cells();
                        cells.append(&self.select(polyhedra));
                    }
                    kind => cells.push_run(kind, run.n_nodes, run.connectivity),
                }
            }
        }
        cells
    }

    /// These cells, in this order.
    ///
    /// # Panics
    /// When there is no such cell.
    pub fn select(&self, order: impl IntoIterator<Item = usize>) -> Self {
        let order = order.into_iter();
        let mut cells = Self::new();
        let n = order
            .size_hint()
            .1
            .map_or(self.len(), |n| n.min(self.len()));
        cells.reserve(self.connectivity().len() * n / self.len().max(1));
        for cell in order {
            let cell = self.get(cell);
            match self.face_stream(cell.index) {
                Some(stream) => cells
                    .push_polyhedron_with_nodes(cell.nodes, stream)
                    .expect("it was checked when it was added"),
                None => cells.push(cell.kind, cell.nodes),
            }
        }
        cells
    }
}

impl MeshView<'_> {
    /// The mesh with its cells in this order, which has every cell once; groups and arrays follow.
    pub fn with_cells_in_order(&self, order: &[usize]) -> Mesh {
        let mut new_index = vec![0; order.len()];
        for (new, &old) in order.iter().enumerate() {
            new_index[old] = new;
        }
        let group = |group: &Group| Group {
            cells: group.cells.iter().map(|cell| new_index[cell]).collect(),
            ..group.clone()
        };
        Mesh {
            points: self.points.to_vec(),
            cells: self.cells.select(order.iter().copied()),
            groups: self.groups.iter().map(group).collect(),
            point_arrays: self.point_arrays.iter().copied().cloned().collect(),
            cell_arrays: (self.cell_arrays.iter())
                .map(|of| of.select(order))
                .collect(),
            field_arrays: self.field_arrays.iter().copied().cloned().collect(),
            space: self.space,
            part: None,
            origin: Origin::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{DataArray, DiffOptions, Values, diff};
    use super::*;

    /// Cells of two kinds, boundary faces of two tags, and a zone, all shuffled.
    fn shuffled() -> Mesh {
        let n = 9u32;
        let mut cells: Vec<(CellKind, Vec<u32>)> = Vec::new();
        let node = |i: u32, j: u32| j * n + i;
        for (i, j) in (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))) {
            let quad = [
                node(i, j),
                node(i + 1, j),
                node(i + 1, j + 1),
                node(i, j + 1),
            ];
            match (i + j) % 3 {
                0 => cells.extend([
                    (CellKind::Triangle, vec![quad[0], quad[1], quad[2]]),
                    (CellKind::Triangle, vec![quad[0], quad[2], quad[3]]),
                ]),
                _ => cells.push((CellKind::Quadrilateral, quad.to_vec())),
            }
        }
        let line = |i: u32, j: u32, k: u32, l: u32| (CellKind::Line, vec![node(i, j), node(k, l)]);
        for i in 0..n - 1 {
            cells.extend([line(i, 0, i + 1, 0), line(i, n - 1, i + 1, n - 1)]);
        }
        let n_nodes = n * n;
        let mut mesh = Mesh::of_points(
            (0..n_nodes)
                .map(|new| new * 37 % n_nodes)
                .map(|old| [f64::from(old % n), f64::from(old / n), 0.0])
                .collect(),
        );
        let mut new_node = vec![0; n_nodes as usize];
        (0..n_nodes).for_each(|new| new_node[(new * 37 % n_nodes) as usize] = new);
        let n_cells = cells.len();
        for i in 0..n_cells {
            let (kind, nodes) = &cells[i * 29 % n_cells];
            mesh.cells.push(*kind, nodes);
        }
        mesh.cells.renumber_nodes(&new_node);
        let height = |cell: usize| {
            let nodes = mesh.cells.get(cell).nodes.iter();
            nodes
                .map(|node| mesh.points[*node as usize][1])
                .sum::<f64>()
        };
        let group = |name: &str, dimension: u8, is_in: &dyn Fn(usize) -> bool| {
            Group::new(
                dimension,
                name,
                None,
                (0..n_cells)
                    .filter(|cell| mesh.cells.get(*cell).kind.dimension() == dimension)
                    .filter(|cell| is_in(*cell))
                    .collect(),
            )
        };
        let groups = vec![
            group("low", 1, &|cell| height(cell) == 0.0),
            group("high", 1, &|cell| height(cell) > 0.0),
            group("upper", 2, &|cell| height(cell) > 16.0),
        ];
        mesh.groups = groups;
        let id = Values::I32((0..n_nodes as i32).collect());
        mesh.point_arrays.push(DataArray::scalar("node", id));
        let id = Values::I32((0..n_cells as i32).collect());
        mesh.cell_arrays.push(DataArray::scalar("cell", id));
        mesh.validate().expect("a good mesh");
        mesh
    }

    #[test]
    fn a_mesh_along_the_curve_is_the_same_by_position_and_stays_in_that_order() {
        let mesh = shuffled();
        assert!(!mesh.cells.len().is_multiple_of(29), "each cell once");
        let order = Reordering::along_curve(&mesh);
        let mut other = mesh.clone();
        other.reorder(&order);
        other.validate().expect("a good mesh");
        let options = DiffOptions {
            by_position: true,
            ..DiffOptions::default()
        };
        let found = diff(&mesh, &other, &options).expect("they can be compared");
        assert!(found.is_same(), "{found:?}");
        assert_ne!(mesh.points, other.points);
        assert_eq!(
            Reordering::along_curve(&other).nodes,
            (0..81).collect::<Vec<_>>()
        );
        let mut again = other.clone();
        again.reorder(&Reordering::along_curve(&other));
        assert_eq!(again, other);
    }

    #[test]
    fn kinds_and_groups_are_not_scattered() {
        let mesh = shuffled();
        assert!(mesh.cells.runs().len() > 20);
        let mut other = mesh.clone();
        other.reorder(&Reordering::along_curve(&mesh));
        // Triangles and quadrilaterals within and without the zone, lines of two tags.
        assert!(other.cells.runs().len() <= 6);
        let n_ranges = |mesh: &Mesh| {
            let groups = mesh.groups.iter().map(|group| group.cells.ranges().len());
            groups.collect::<Vec<_>>()
        };
        assert!(n_ranges(&mesh).iter().all(|n| *n > 4));
        assert!(
            n_ranges(&other).iter().all(|n| *n <= 2),
            "{:?}",
            n_ranges(&other)
        );
        let far = |mesh: &Mesh| {
            let spans = mesh.cells.iter().map(|cell| {
                let [low, high] = [cell.nodes.iter().min(), cell.nodes.iter().max()];
                high.zip(low).map_or(0, |(high, low)| high - low)
            });
            spans.sum::<u32>()
        };
        assert!(far(&other) * 2 < far(&mesh));
    }

    #[test]
    fn groups_and_arrays_follow_their_cells() {
        let mut mesh = Mesh::default();
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        let tetrahedron = [4, 3, 0, 1, 2, 3, 0, 1, 3, 3, 1, 2, 3, 3, 0, 2, 3];
        mesh.cells
            .push_polyhedron(&tetrahedron)
            .expect("a good stream");
        mesh.cells.push(CellKind::Triangle, &[1, 2, 3]);
        mesh.groups
            .push(Group::new(2, "wall", None, [2].into_iter().collect()));
        let id = Values::I32(vec![10, 11, 12]);
        mesh.cell_arrays.push(DataArray::scalar("id", id));
        let other = mesh.view().with_cells_in_order(&[1, 2, 0]);
        assert_eq!(other.cells.face_stream(0), Some(&tetrahedron[..]));
        assert_eq!(other.cells.get(1).nodes, [1, 2, 3]);
        assert_eq!(other.groups[0].cells.iter().collect::<Vec<_>>(), [1]);
        assert_eq!(other.cell_arrays[0].values, Values::I32(vec![11, 12, 10]));
    }
}

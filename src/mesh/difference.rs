//! How two meshes differ: node by node, cell by cell, tag by tag, array by array.
//!
//! Nodes are compared in order. Cells are compared in order within each dimension, because formats
//! may put boundary faces before or after the volume cells. Groups are compared by dimension and
//! name as sets of cells, each known by its kind and nodes.

use super::{CellKind, CellRef, Cells, DataArray, Group, Mesh, Values};
use std::collections::BTreeMap;
use std::fmt;

/// How much two coordinates may differ; by default not at all.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tolerance {
    /// Largest distance of two nodes, and of two values of an array, that count as the same.
    pub value: f64,
    /// Whether `value` is a fraction: of the diagonal of the first mesh's box for nodes, of the
    /// largest magnitude in the first mesh's array for arrays.
    pub relative: bool,
}

impl Tolerance {
    fn absolute(self, scale: f64) -> f64 {
        if self.relative {
            self.value * scale
        } else {
            self.value
        }
    }
}

/// A pair of nodes with the same index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodePair {
    /// Their index.
    pub node: usize,
    /// Position in the first mesh.
    pub a: [f64; 3],
    /// Position in the second mesh.
    pub b: [f64; 3],
    /// Distance between them, in mesh units.
    pub distance: f64,
}

/// What differs between two meshes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Difference {
    /// Number of nodes in each.
    pub n_nodes: [usize; 2],
    /// Nodes, of those that both have, further apart than the tolerance.
    pub moved_nodes: usize,
    /// The first of them.
    pub first_moved: Option<NodePair>,
    /// The pair that is furthest apart, moved or not.
    pub furthest: Option<NodePair>,
    /// Number of cells in each.
    pub n_cells: [usize; 2],
    /// Cells whose kind or nodes differ, with those that only one mesh has.
    pub changed_cells: usize,
    /// Differences of the cells, a sentence for each dimension.
    pub cells: Vec<String>,
    /// Differences of groups, a sentence each.
    pub groups: Vec<String>,
    /// Differences of arrays, a sentence each.
    pub arrays: Vec<String>,
}

impl Difference {
    /// Compares `a` with `b`. Memory: a few bytes a boundary face.
    pub fn between(a: &Mesh, b: &Mesh, tolerance: Tolerance) -> Self {
        let mut found = Self {
            n_nodes: [a.points.len(), b.points.len()],
            n_cells: [a.cells.len(), b.cells.len()],
            ..Self::default()
        };
        found.compare_nodes(a, b, tolerance);
        found.compare_cells(a, b);
        found.compare_groups(a, b);
        found.compare_arrays(a, b, tolerance);
        found
    }

    /// Whether nothing differs by more than the tolerance.
    pub fn is_same(&self) -> bool {
        self.n_nodes[0] == self.n_nodes[1]
            && self.moved_nodes == 0
            && self.cells.is_empty()
            && self.groups.is_empty()
            && self.arrays.is_empty()
    }

    /// Largest distance between two nodes with the same index; 0 without nodes.
    pub fn max_distance(&self) -> f64 {
        self.furthest.map_or(0.0, |pair| pair.distance)
    }

    fn compare_nodes(&mut self, a: &Mesh, b: &Mesh, tolerance: Tolerance) {
        let diagonal = a.bounds().map_or(0.0, |[low, high]| distance(low, high));
        let allowed = tolerance.absolute(diagonal);
        for (node, (&a, &b)) in a.points.iter().zip(&b.points).enumerate() {
            let pair = NodePair {
                node,
                a,
                b,
                distance: distance(a, b),
            };
            if self.furthest.is_none_or(|f| pair.distance > f.distance) {
                self.furthest = Some(pair);
            }
            if pair.distance > allowed {
                self.moved_nodes += 1;
                self.first_moved.get_or_insert(pair);
            }
        }
    }

    fn compare_cells(&mut self, a: &Mesh, b: &Mesh) {
        for dimension in 0..=3 {
            let [ours, theirs] = [a, b].map(|mesh| of_dimension(&mesh.cells, dimension).count());
            let pairs = of_dimension(&a.cells, dimension).zip(of_dimension(&b.cells, dimension));
            let mut changed = pairs.filter(|(x, y)| !same_cell(a, x, b, y));
            let first = changed.next();
            let n_changed = usize::from(first.is_some()) + changed.count();
            self.changed_cells += n_changed + ours.abs_diff(theirs);
            if ours != theirs {
                self.cells.push(format!(
                    "{ours} and {theirs} cells of dimension {dimension}"
                ));
            }
            if let Some((x, y)) = first {
                self.cells.push(format!(
                    "{n_changed} cells of dimension {dimension} differ; first {} and {}",
                    describe(&x),
                    describe(&y)
                ));
            }
        }
    }

    fn compare_groups(&mut self, a: &Mesh, b: &Mesh) {
        let [ours, theirs] = [a, b].map(groups_by_name);
        for ((dimension, name), group) in &ours {
            let Some(other) = theirs.get(&(*dimension, *name)) else {
                self.groups.push(format!(
                    "{} \"{name}\" is only in the first",
                    role(a, group)
                ));
                continue;
            };
            if group.cells.len() != other.cells.len() {
                self.groups.push(format!(
                    "{} \"{name}\" has {} and {} cells",
                    role(a, group),
                    group.cells.len(),
                    other.cells.len()
                ));
            } else {
                let missing = cells_not_in(a, group, b, other);
                if missing > 0 {
                    self.groups.push(format!(
                        "{} \"{name}\": {missing} of {} cells are not the same",
                        role(a, group),
                        group.cells.len()
                    ));
                }
            }
        }
        for ((_, name), group) in theirs.iter().filter(|(key, _)| !ours.contains_key(key)) {
            self.groups.push(format!(
                "{} \"{name}\" is only in the second",
                role(b, group)
            ));
        }
    }

    fn compare_arrays(&mut self, a: &Mesh, b: &Mesh, tolerance: Tolerance) {
        // Cell arrays follow the order of cells, which may differ between dimensions.
        let orders = [a, b].map(|mesh| {
            let by_dimension = |d| of_dimension(&mesh.cells, d).map(|cell| cell.index);
            let order: Vec<usize> = (0..=3).flat_map(by_dimension).collect();
            (!order.is_sorted()).then_some(order)
        });
        let places = [
            ("point", &a.point_arrays, &b.point_arrays),
            ("cell", &a.cell_arrays, &b.cell_arrays),
            ("field", &a.field_arrays, &b.field_arrays),
        ];
        for (place, ours, theirs) in places {
            for array in ours {
                let Some(other) = theirs.iter().find(|other| other.name == array.name) else {
                    let name = &array.name;
                    self.arrays
                        .push(format!("{place} array \"{name}\" is only in the first"));
                    continue;
                };
                let reordered = place == "cell" && orders.iter().any(Option::is_some);
                let differs = if reordered {
                    let [x, y] = [(array, &orders[0]), (other, &orders[1])]
                        .map(|(array, order)| in_order(array, order.as_deref()));
                    array_difference(&x, &y, tolerance)
                } else {
                    array_difference(array, other, tolerance)
                };
                if let Some(what) = differs {
                    let name = &array.name;
                    self.arrays.push(format!("{place} array \"{name}\" {what}"));
                }
            }
            for array in theirs {
                if !ours.iter().any(|other| other.name == array.name) {
                    let name = &array.name;
                    self.arrays
                        .push(format!("{place} array \"{name}\" is only in the second"));
                }
            }
        }
    }
}

/// One line: what differs, or that nothing does.
impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_same() {
            let [n_nodes, n_cells] = [self.n_nodes[0], self.n_cells[0]];
            write!(f, "same: {n_nodes} nodes, {n_cells} cells")?;
            return match self.max_distance() {
                0.0 => Ok(()),
                furthest => write!(f, ", nodes at most {furthest:e} apart"),
            };
        }
        let mut parts = Vec::new();
        let [ours, theirs] = self.n_nodes;
        if ours != theirs {
            parts.push(format!("{ours} and {theirs} nodes"));
        }
        if let (true, Some(worst)) = (self.moved_nodes > 0, self.furthest) {
            parts.push(format!(
                "{} nodes differ, node {} most, by {:e}",
                self.moved_nodes, worst.node, worst.distance
            ));
        }
        if !self.cells.is_empty() {
            parts.push(format!("{} cells differ", self.changed_cells));
        }
        for (what, sentences) in [("groups", &self.groups), ("arrays", &self.arrays)] {
            match &sentences[..] {
                [] => {}
                [one] => parts.push(one.clone()),
                many => parts.push(format!("{} {what} differ", many.len())),
            }
        }
        write!(f, "different: {}", parts.join("; "))
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn of_dimension(cells: &Cells, dimension: u8) -> impl Iterator<Item = CellRef<'_>> {
    let runs = cells
        .runs()
        .filter(move |run| run.kind.dimension() == dimension);
    runs.flat_map(|run| {
        run.cells().enumerate().map(move |(i, nodes)| CellRef {
            index: run.first_cell + i,
            kind: run.kind,
            nodes,
        })
    })
}

/// Polyhedra are the same when their faces are, in order and going round the same way: formats that
/// keep a face shared by two cells once do not keep at which node each cell starts it.
fn same_cell(a: &Mesh, x: &CellRef, b: &Mesh, y: &CellRef) -> bool {
    if x.kind != CellKind::Polyhedron || y.kind != CellKind::Polyhedron {
        return x.kind == y.kind && x.nodes == y.nodes;
    }
    let ours = a.cells.polyhedron_faces(x.index);
    let theirs = b.cells.polyhedron_faces(y.index);
    ours.map(Some)
        .chain([None])
        .zip(theirs.map(Some).chain([None]))
        .all(|pair| match pair {
            (Some(one), Some(other)) => same_round(one, other),
            (one, other) => one.is_none() && other.is_none(),
        })
}

fn same_round(one: &[u32], other: &[u32]) -> bool {
    let start = one
        .first()
        .and_then(|first| other.iter().position(|n| n == first));
    one.len() == other.len()
        && start.is_some_and(|start| {
            let (end, begin) = other.split_at(start);
            begin.iter().chain(end).eq(one)
        })
}

fn describe(cell: &CellRef) -> String {
    let nodes: Vec<String> = cell.nodes.iter().take(8).map(u32::to_string).collect();
    let more = if cell.nodes.len() > 8 { " ..." } else { "" };
    let kind = cell.kind.name();
    format!("{kind} {} ({}{more})", cell.index, nodes.join(" "))
}

fn role(mesh: &Mesh, group: &Group) -> String {
    match mesh.dimension().checked_sub(group.dimension) {
        Some(0) => "zone".to_owned(),
        Some(1) => "boundary tag".to_owned(),
        _ => format!("group of dimension {}", group.dimension),
    }
}

fn groups_by_name(mesh: &Mesh) -> BTreeMap<(u8, &str), &Group> {
    mesh.groups
        .iter()
        .map(|group| ((group.dimension, group.name.as_str()), group))
        .collect()
}

/// Cells of `x` in `a` that `y` in `b` does not have, each known by kind and set of nodes.
fn cells_not_in(a: &Mesh, x: &Group, b: &Mesh, y: &Group) -> usize {
    let in_order = x.cells.iter().zip(y.cells.iter());
    let differ = in_order.filter(|&(i, j)| {
        let (cell, other) = (a.cells.get(i), b.cells.get(j));
        cell.kind != other.kind || cell.nodes != other.nodes
    });
    if differ.count() == 0 {
        return 0;
    }
    let mut counts: BTreeMap<(u8, Vec<u32>), i64> = BTreeMap::new();
    for (mesh, group, step) in [(a, x, 1), (b, y, -1)] {
        for cell in group.cells.iter().map(|cell| mesh.cells.get(cell)) {
            let mut nodes = cell.nodes.to_vec();
            nodes.sort_unstable();
            *counts.entry((cell.kind.vtk(), nodes)).or_default() += step;
        }
    }
    counts.into_values().map(|n| n.max(0) as usize).sum()
}

fn in_order(array: &DataArray, order: Option<&[usize]>) -> DataArray {
    let Some(order) = order else {
        return array.clone();
    };
    DataArray {
        values: array.values.select(array.n_components, order),
        ..array.clone()
    }
}

/// What differs between two arrays of one name. The type of number may differ, its value not.
fn array_difference(a: &DataArray, b: &DataArray, tolerance: Tolerance) -> Option<String> {
    if (a.n_components, a.values.len()) != (b.n_components, b.values.len()) {
        let shape = |x: &DataArray| format!("{} tuples of {}", x.n_tuples(), x.n_components);
        return Some(format!("has {} and {}", shape(a), shape(b)));
    }
    if let (Values::Text(x), Values::Text(y)) = (&a.values, &b.values) {
        let first = x.iter().zip(y).position(|(x, y)| x != y)?;
        return Some(format!(
            "has \"{}\" and \"{}\" at {first}",
            x[first], y[first]
        ));
    }
    let integers = a.values.to_integers().zip(b.values.to_integers());
    if integers.is_some_and(|(x, y)| x == y) {
        return None;
    }
    let (Some(x), Some(y)) = (to_reals(&a.values), to_reals(&b.values)) else {
        return Some("is text in one and numbers in the other".to_owned());
    };
    let largest = x.iter().map(|x| x.abs()).filter(|x| x.is_finite());
    let allowed = tolerance.absolute(largest.fold(0.0, f64::max));
    let differs = |(x, y): (&f64, &f64)| {
        let distance = (x - y).abs();
        x != y && !(x.is_nan() && y.is_nan()) && (distance.is_nan() || distance > allowed)
    };
    let n_differ = x.iter().zip(&y).filter(|&pair| differs(pair)).count();
    let first = x.iter().zip(&y).position(differs)?;
    Some(format!(
        "differs in {n_differ} of {} values, first at {}: {} and {}",
        x.len(),
        first / a.n_components.max(1),
        x[first],
        y[first]
    ))
}

fn to_reals(values: &Values) -> Option<Vec<f64>> {
    match values {
        Values::F64(v) => Some(v.clone()),
        Values::F32(v) => Some(v.iter().map(|&x| x.into()).collect()),
        Values::U64(v) => Some(v.iter().map(|&x| x as f64).collect()),
        other => Some(other.to_integers()?.iter().map(|&x| x as f64).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::CellKind;
    use super::*;

    fn square(faces_first: bool) -> Mesh {
        let mut mesh = Mesh {
            points: vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
            ..Mesh::default()
        };
        let volume = |mesh: &mut Mesh| {
            mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
            mesh.cells.push(CellKind::Triangle, &[0, 2, 3]);
        };
        if !faces_first {
            volume(&mut mesh);
        }
        let first = mesh.cells.len();
        mesh.cells.push(CellKind::Line, &[0, 1]);
        mesh.cells.push(CellKind::Line, &[1, 2]);
        if faces_first {
            volume(&mut mesh);
        }
        mesh.groups.push(Group {
            dimension: 1,
            name: "wall".into(),
            number: None,
            condition: None,
            cells: [first, first + 1].into_iter().collect(),
        });
        let ids = if faces_first {
            vec![3, 4, 1, 2]
        } else {
            vec![1, 2, 3, 4]
        };
        mesh.cell_arrays
            .push(DataArray::scalar("id", Values::I32(ids)));
        mesh
    }

    fn between(a: &Mesh, b: &Mesh) -> Difference {
        Difference::between(a, b, Tolerance::default())
    }

    #[test]
    fn faces_before_or_after_volumes_are_the_same_mesh() {
        let found = between(&square(true), &square(false));
        assert!(found.is_same(), "{found:?}");
        assert_eq!(found.to_string(), "same: 4 nodes, 4 cells");
    }

    #[test]
    fn a_moved_node_is_named_and_a_tolerance_lets_it_pass() {
        let (a, mut b) = (square(true), square(true));
        b.points[2][0] += 1e-3;
        let found = between(&a, &b);
        assert_eq!(found.moved_nodes, 1);
        assert_eq!(found.furthest.map(|pair| pair.node), Some(2));
        assert!(!found.is_same() && found.to_string().contains("node 2 most"));
        let relative = true;
        for (value, relative, same) in [
            (1.1e-3, false, true),
            (9e-4, false, false),
            (8e-4, relative, true),
        ] {
            let found = Difference::between(&a, &b, Tolerance { value, relative });
            assert_eq!(found.is_same(), same, "{value} {relative}");
        }
    }

    #[test]
    fn cells_groups_and_arrays_that_differ_are_each_told() {
        let a = square(true);
        let mut b = square(true);
        b.groups[0].name = "inlet".into();
        b.cell_arrays[0].values = Values::F64(vec![3.0, 4.0, 1.0, 2.5]);
        b.cells.push(CellKind::Line, &[2, 3]);
        b.cell_arrays.clear();
        let found = between(&a, &b);
        assert_eq!(
            (found.changed_cells, found.groups.len(), found.arrays.len()),
            (1, 2, 1)
        );
        let mut c = square(true);
        c.groups[0].cells = [1].into_iter().collect();
        c.cell_arrays[0].values = Values::F64(vec![3.0, 4.0, 1.0, 2.5]);
        let found = between(&a, &c);
        assert_eq!((found.groups.len(), found.arrays.len()), (1, 1));
        assert!(
            found.arrays[0].contains("first at 3: 2 and 2.5"),
            "{}",
            found.arrays[0]
        );
        let mut d = square(true);
        let turned = [0u32, 3, 2];
        d.cells = Cells::new();
        for cell in a.cells.iter() {
            let last = cell.index == 3;
            d.cells
                .push(cell.kind, if last { &turned } else { cell.nodes });
        }
        assert_eq!(between(&a, &d).changed_cells, 1);
    }
}

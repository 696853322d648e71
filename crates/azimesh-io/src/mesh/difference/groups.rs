//! Boundary tags, zones and other groups, compared by dimension and name as sets of cells.

use super::super::{Group, Mesh};
use super::partners::Partners;
use std::collections::BTreeMap;

/// A sentence for each group that differs. Where it is known which cells belong together, groups are
/// compared by that; otherwise a cell is known by its kind and nodes.
pub fn compare(a: &Mesh, b: &Mesh, partners: Option<&Partners>) -> Vec<String> {
    let [ours, theirs] = [a, b].map(Named::of);
    let mut found = Vec::new();
    for (key, group) in ours.iter() {
        let (role, name) = (role(a, group), &group.name);
        let Some(other) = theirs.get(key) else {
            found.push(format!("{role} \"{name}\" is only in the first mesh"));
            continue;
        };
        let n = group.cells.len();
        if n != other.cells.len() {
            let m = other.cells.len();
            found.push(format!("{role} \"{name}\" has {n} and {m} cells"));
            continue;
        }
        let missing = match partners {
            Some(partners) => n_without_partner(group, other, partners, b.cells.len()),
            None => n_not_in(a, group, b, other),
        };
        if missing > 0 {
            found.push(format!("{role} \"{name}\": {missing} of {n} cells differ"));
        }
    }
    for (_, group) in theirs.iter().filter(|(key, _)| ours.get(key).is_none()) {
        let (role, name) = (role(b, group), &group.name);
        found.push(format!("{role} \"{name}\" is only in the second mesh"));
    }
    found
}

fn role(mesh: &Mesh, group: &Group) -> String {
    match mesh.dimension().checked_sub(group.dimension) {
        Some(0) => "zone".to_owned(),
        Some(1) => "boundary tag".to_owned(),
        _ => format!("group of dimension {}", group.dimension),
    }
}

/// The key of a group: its dimension, its name, and how many of both came before it.
type Key<'a> = (u8, &'a str, usize);

/// The groups of a mesh, in their order and by what they are known by.
struct Named<'a> {
    in_order: Vec<(Key<'a>, &'a Group)>,
    by_key: BTreeMap<Key<'a>, &'a Group>,
}

impl<'a> Named<'a> {
    fn of(mesh: &'a Mesh) -> Self {
        let mut counts: BTreeMap<(u8, &str), usize> = BTreeMap::new();
        let keyed = mesh.groups.iter().map(|group| {
            let count = counts.entry((group.dimension, &group.name)).or_default();
            *count += 1;
            ((group.dimension, group.name.as_str(), *count), group)
        });
        let in_order: Vec<_> = keyed.collect();
        Self {
            by_key: in_order.iter().copied().collect(),
            in_order,
        }
    }

    fn iter(&self) -> impl Iterator<Item = &(Key<'a>, &'a Group)> {
        self.in_order.iter()
    }

    fn get(&self, key: &Key<'_>) -> Option<&'a Group> {
        self.by_key.get(key).copied()
    }
}

/// Cells of `x` whose partners are not in `y`.
fn n_without_partner(x: &Group, y: &Group, partners: &Partners, n_cells: usize) -> usize {
    if partners.is_in_order() && x.cells == y.cells {
        return 0;
    }
    let mut in_y = vec![false; n_cells];
    for range in y.cells.ranges() {
        in_y[range].fill(true);
    }
    let is_there = |cell: usize| partners.of(cell).is_some_and(|partner| in_y[partner]);
    x.cells.iter().filter(|&cell| !is_there(cell)).count()
}

/// Cells of `x` in `a` that `y` in `b` does not have, each known by kind and set of nodes.
fn n_not_in(a: &Mesh, x: &Group, b: &Mesh, y: &Group) -> usize {
    let mut in_order = x.cells.iter().zip(y.cells.iter());
    let same = |(i, j): (usize, usize)| {
        let (cell, other) = (a.cells.get(i), b.cells.get(j));
        cell.kind == other.kind && cell.nodes == other.nodes
    };
    if in_order.all(same) {
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

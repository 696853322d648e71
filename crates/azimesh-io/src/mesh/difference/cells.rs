//! Cells compared in order within each dimension.

use super::super::{CellKind, CellRef, CellRun, Cells};
use super::partners::{NONE, Partners, in_chunks};

/// The result of a comparison of cells.
#[derive(Debug)]
pub struct Compared {
    /// Cells that differ, with those that only one mesh has.
    pub n_changed: usize,
    /// The differences.
    pub sentences: Vec<String>,
    /// Pairs of cells.
    pub partners: Partners,
}

/// As many cells of both meshes, of one kind in each.
struct Stretch<'a> {
    a: CellRun<'a>,
    b: CellRun<'a>,
}

/// Compares cells in order, each dimension separately.
pub fn compare(a: &Cells, b: &Cells) -> Compared {
    let mut n_changed = 0;
    let mut sentences = Vec::new();
    let mut all = Vec::new();
    for dimension in 0..=3 {
        let [ours, theirs] = [a, b].map(|cells| n_of(cells, dimension));
        let stretches = stretches(a, b, dimension);
        let mut n_here = 0;
        let mut first = None;
        for stretch in &stretches {
            let (n, at) = stretch.changed(a, b);
            n_here += n;
            first = first.or(at.map(|at| [cell_of(&stretch.a, at), cell_of(&stretch.b, at)]));
        }
        n_changed += n_here + ours.abs_diff(theirs);
        if ours != theirs {
            sentences.push(format!(
                "{ours} and {theirs} cells of dimension {dimension}"
            ));
        }
        if let Some([x, y]) = first {
            sentences.push(format!(
                "{n_here} cells of dimension {dimension} differ; first {} and {}",
                describe(&x),
                describe(&y)
            ));
        }
        all.extend(stretches);
    }
    Compared {
        n_changed,
        sentences,
        partners: partners(a, b, &all),
    }
}

fn n_of(cells: &Cells, dimension: u8) -> usize {
    let runs = cells.runs().filter(|run| run.kind.dimension() == dimension);
    runs.map(|run| run.n_cells()).sum()
}

/// The cells of one dimension that both have, cut where the kind changes in either.
fn stretches<'a>(a: &'a Cells, b: &'a Cells, dimension: u8) -> Vec<Stretch<'a>> {
    let [mut ours, mut theirs] = [a, b].map(|cells| {
        cells
            .runs()
            .filter(move |run| run.kind.dimension() == dimension)
    });
    let (mut x, mut y) = (ours.next(), theirs.next());
    let mut found = Vec::new();
    while let (Some(p), Some(q)) = (x, y) {
        let n = p.n_cells().min(q.n_cells());
        let ((p, p_rest), (q, q_rest)) = (split(p, n), split(q, n));
        found.push(Stretch { a: p, b: q });
        x = p_rest.or_else(|| ours.next());
        y = q_rest.or_else(|| theirs.next());
    }
    found
}

/// The first `n` cells of a run, and the others.
fn split(run: CellRun<'_>, n: usize) -> (CellRun<'_>, Option<CellRun<'_>>) {
    let (head, tail) = run.connectivity.split_at(n * run.n_nodes);
    let rest = CellRun {
        first_cell: run.first_cell + n,
        connectivity: tail,
        ..run
    };
    let first = CellRun {
        connectivity: head,
        ..run
    };
    (first, (!tail.is_empty()).then_some(rest))
}

impl Stretch<'_> {
    /// Counts the cells that differ, and gives the position of the first in the stretch.
    fn changed(&self, a: &Cells, b: &Cells) -> (usize, Option<usize>) {
        let n = self.a.n_cells();
        if (self.a.kind, self.a.n_nodes) != (self.b.kind, self.b.n_nodes) {
            return (n, Some(0));
        }
        let is_same = |i: usize| match self.a.kind {
            CellKind::Polyhedron => {
                same_polyhedron(a, self.a.first_cell + i, b, self.b.first_cell + i)
            }
            _ => nodes_of(&self.a, i) == nodes_of(&self.b, i),
        };
        let look = |range: std::ops::Range<usize>| {
            let mut changed = range.filter(|&i| !is_same(i));
            let first = changed.next();
            (usize::from(first.is_some()) + changed.count(), first)
        };
        in_chunks(n, &look, |x, y| (x.0 + y.0, x.1.or(y.1)))
    }
}

fn nodes_of<'a>(run: &CellRun<'a>, i: usize) -> &'a [u32] {
    &run.connectivity[i * run.n_nodes..(i + 1) * run.n_nodes]
}

fn cell_of<'a>(run: &CellRun<'a>, i: usize) -> CellRef<'a> {
    CellRef {
        index: run.first_cell + i,
        kind: run.kind,
        nodes: nodes_of(run, i),
    }
}

fn partners(a: &Cells, b: &Cells, stretches: &[Stretch<'_>]) -> Partners {
    if stretches.iter().all(|s| s.a.first_cell == s.b.first_cell) {
        return Partners::in_order(a.len(), b.len());
    }
    let mut list = vec![NONE; a.len()];
    for stretch in stretches {
        let places = stretch.a.first_cell..stretch.a.first_cell + stretch.a.n_cells();
        for (partner, cell) in list[places].iter_mut().zip(stretch.b.first_cell as u32..) {
            *partner = cell;
        }
    }
    Partners::Listed(list)
}

/// Polyhedra are the same when their faces are, in order and going round the same way: formats that
/// keep a face shared by two cells once do not keep at which node each cell starts it.
fn same_polyhedron(a: &Cells, x: usize, b: &Cells, y: usize) -> bool {
    let mut ours = a.polyhedron_faces(x);
    let mut theirs = b.polyhedron_faces(y);
    loop {
        match (ours.next(), theirs.next()) {
            (None, None) => return true,
            (Some(one), Some(other)) if same_round(one, other) => {}
            _ => return false,
        }
    }
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

/// A cell by its kind, its index and its first nodes.
pub fn describe(cell: &CellRef) -> String {
    let nodes: Vec<String> = cell.nodes.iter().take(8).map(u32::to_string).collect();
    let more = if cell.nodes.len() > 8 { " ..." } else { "" };
    let kind = cell.kind.name();
    format!("{kind} {} ({}{more})", cell.index, nodes.join(" "))
}

//! Cells that belong together: of one kind, with the same nodes.

use super::super::cells::{Compared, describe};
use super::super::partners::{NONE, Partners};
use super::keys::{Keys, join, mixed};
use crate::mesh::sides::for_each_side;
use crate::mesh::{CellKind, CellRef, Cells};
use azimesh_core::parallel::{for_blocks, sort};

/// Cells that are looked at in one go.
const CHUNK: usize = 1 << 14;
/// Nodes of the second mesh without a partner are called by their index and this.
const ALONE: u64 = 1 << 32;

/// The result for cells with equal keys.
#[derive(Default)]
struct Found {
    pairs: Vec<(u32, u32)>,
    /// Of the pairs, those whose nodes make another cell.
    rewired: Vec<(u32, u32)>,
}

/// Pairs the cells of two meshes whose nodes belong together: `back` has the partner of each node of
/// the second. A pair is the same cell if its faces are; cells of the meshes' own dimension must
/// also go round them the same way.
pub fn cells(a: &Cells, b: &Cells, back: &[u32]) -> Compared {
    let both = Both {
        a,
        b,
        back,
        dimension: a.runs().map(|run| run.kind.dimension()).max(),
    };
    let called = |node| both.called(node);
    let (ours, theirs) = (sorted(a, u64::from), sorted(b, called));
    let found = join(&ours, &theirs, |found: &mut Found, x, y| match (x, y) {
        ([], _) | (_, []) => {}
        ([(_, i)], [(_, j)]) => {
            found.meet(&both, *i, *j);
        }
        (x, y) => {
            let mut free: Vec<u32> = y.iter().map(|(_, j)| *j).collect();
            for (_, i) in x {
                if let Some(at) = free.iter().position(|j| found.meet(&both, *i, *j)) {
                    free.remove(at);
                }
            }
        }
    });
    drop((ours, theirs));
    compared(a, b, &found)
}

impl Found {
    /// Pairs two cells if they have the same nodes; gives whether they do.
    fn meet(&mut self, both: &Both, i: u32, j: u32) -> bool {
        let (x, y) = (both.a.get(i as usize), both.b.get(j as usize));
        let same = both.have_same_nodes(&x, &y);
        if same {
            self.pairs.push((i, j));
            if !both.have_same_faces(&x, &y) {
                self.rewired.push((i, j));
            }
        }
        same
    }
}

fn sorted(cells: &Cells, called: impl Fn(u32) -> u64 + Sync) -> Keys {
    let mut keys: Keys = vec![(0, 0); cells.len()];
    for_blocks(&mut keys, CHUNK, &|start, keys| {
        let runs = cells.runs_in(start..start + keys.len());
        let nodes = runs.flat_map(|run| run.cells().map(move |nodes| (run.kind, nodes)));
        for (((kind, nodes), index), key) in nodes.zip(start as u32..).zip(keys) {
            let names = nodes.iter().map(|&node| mixed(called(node)));
            let sum = names.fold(kind.vtk().into(), u64::wrapping_add);
            *key = (mixed(sum), index);
        }
    });
    sort(&mut keys);
    keys
}

/// The cells of two meshes whose nodes are paired.
struct Both<'a> {
    a: &'a Cells,
    b: &'a Cells,
    /// The partner of each node of the second.
    back: &'a [u32],
    /// Dimension of the meshes.
    dimension: Option<u8>,
}

impl Both<'_> {
    /// The label of a node of the second mesh: its partner, if it has one.
    fn called(&self, node: u32) -> u64 {
        match self.back[node as usize] {
            NONE => ALONE + u64::from(node),
            partner => partner.into(),
        }
    }

    fn have_same_nodes(&self, x: &CellRef, y: &CellRef) -> bool {
        let has = |name: u64| x.nodes.iter().any(|&node| u64::from(node) == name);
        x.kind == y.kind
            && x.nodes.len() == y.nodes.len()
            && y.nodes.iter().all(|&node| has(self.called(node)))
    }

    /// For cells with the same nodes.
    fn have_same_faces(&self, x: &CellRef, y: &CellRef) -> bool {
        let mut pairs = x.nodes.iter().zip(y.nodes);
        let in_order = pairs.all(|(&i, &j)| u64::from(i) == self.called(j));
        if in_order && x.kind != CellKind::Polyhedron {
            return true;
        }
        let directed = Some(x.kind.dimension()) == self.dimension;
        let ours = faces(self.a, x, u64::from, directed);
        ours == faces(self.b, y, |node| self.called(node), directed)
    }
}

/// A number for the faces of a cell, in whatever order and from whichever node they begin.
fn faces(cells: &Cells, cell: &CellRef, called: impl Fn(u32) -> u64, directed: bool) -> u64 {
    let mut sum = 0u64;
    for_each_side(cells, cell, |_, corners| {
        let n = corners.len();
        let name = |i: usize| called(corners[i % n]);
        let lowest = (0..n).min_by_key(|&i| name(i)).unwrap_or(0);
        // An edge has its sense by which end comes first.
        let start = if directed && n == 2 { 0 } else { lowest };
        let backwards = !directed && name(start + n - 1) < name(start + 1);
        let ring = (0..n).map(|i| {
            if backwards {
                name(start + n - i)
            } else {
                name(start + i)
            }
        });
        sum = sum.wrapping_add(ring.fold(n as u64, |key, name| mixed(key ^ name)));
    });
    sum
}

fn compared(a: &Cells, b: &Cells, found: &[Found]) -> Compared {
    let mut partners = vec![NONE; a.len()];
    let mut has_partner = vec![false; b.len()];
    for &(i, j) in found.iter().flat_map(|found| &found.pairs) {
        partners[i as usize] = j;
        has_partner[j as usize] = true;
    }
    let mut rewired: Vec<(u32, u32)> = found.iter().flat_map(|f| f.rewired.clone()).collect();
    rewired.sort_unstable();
    let ours = (0..a.len()).filter(|&cell| partners[cell] == NONE);
    let theirs = (0..b.len()).filter(|&cell| !has_partner[cell]);
    let alone = [
        Alone::count(a, ours, "first"),
        Alone::count(b, theirs, "second"),
    ];
    let mut sentences = Vec::new();
    let mut n_changed = rewired.len();
    for dimension in 0..=3 {
        let here = alone.each_ref().map(|alone| alone.n[dimension]);
        n_changed += here[0].max(here[1]);
        sentences.extend(alone.iter().filter_map(|alone| alone.sentence(dimension)));
    }
    if let Some(&(i, j)) = rewired.first() {
        let [x, y] = [a.get(i as usize), b.get(j as usize)];
        sentences.push(format!(
            "{} cells have the same nodes and other faces, or go round them the other way; first {} and {}",
            rewired.len(),
            describe(&x),
            describe(&y)
        ));
    }
    Compared {
        n_changed,
        sentences,
        partners: Partners::Listed(partners),
    }
}

/// Cells without a partner, by dimension.
struct Alone<'a> {
    n: [usize; 4],
    first: [Option<CellRef<'a>>; 4],
    mesh: &'static str,
}

impl<'a> Alone<'a> {
    fn count(cells: &'a Cells, alone: impl Iterator<Item = usize>, mesh: &'static str) -> Self {
        let mut found = Self {
            n: [0; 4],
            first: [None; 4],
            mesh,
        };
        for cell in alone.map(|cell| cells.get(cell)) {
            let dimension = usize::from(cell.kind.dimension());
            found.n[dimension] += 1;
            found.first[dimension].get_or_insert(cell);
        }
        found
    }

    fn sentence(&self, dimension: usize) -> Option<String> {
        let first = self.first[dimension].as_ref()?;
        let (n, mesh) = (self.n[dimension], self.mesh);
        let first = describe(first);
        Some(format!(
            "{n} cells of dimension {dimension} are only in the {mesh}; first {first}"
        ))
    }
}

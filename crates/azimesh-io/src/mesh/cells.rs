//! The cells of a mesh, in file order, stored as runs of equal kind and node count.
//!
//! A run needs no offsets, and a metric can be computed over a whole run without looking at types.
//! Node indices are zero-based.

use super::kind::CellKind;
pub use super::streams::face_stream;
use super::streams::{Listed, distinct_nodes};
use azimesh_core::error::{Error, Result};
use azimesh_core::ranks::raw;
use azimesh_core::{parallel, sparse};
use serde::{Deserialize, Serialize};

/// Cells in order, run-length encoded by kind and node count. Nodes are in VTK's order.
///
/// ```
/// use azimesh_io::{CellKind, Cells};
///
/// let mut cells = Cells::default();
/// cells.push(CellKind::Triangle, &[0, 1, 2]);
/// cells.push(CellKind::Quadrilateral, &[1, 3, 4, 2]);
/// assert_eq!(cells.len(), 2);
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Cells {
    runs: Vec<Run>,
    #[serde(with = "raw")]
    connectivity: Vec<u32>,
    polyhedra: Polyhedra,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Run {
    kind: CellKind,
    n_nodes: u32,
    first_cell: u32,
    n_cells: u32,
    first_entry: usize,
}

/// Faces of the polyhedra, in the order of the polyhedra among the cells.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct Polyhedra {
    /// Cell index of each polyhedron, ascending.
    #[serde(with = "raw")]
    cells: Vec<u32>,
    /// Start of each polyhedron in `stream`.
    #[serde(with = "raw")]
    starts: Vec<usize>,
    /// `n_faces, (n_nodes, node...)...` for each.
    #[serde(with = "raw")]
    stream: Vec<u32>,
}

/// Consecutive cells of one kind and one node count.
#[derive(Debug, Clone, Copy)]
pub struct CellRun<'a> {
    /// Kind of every cell of the run.
    pub kind: CellKind,
    /// Nodes of each cell.
    pub n_nodes: usize,
    /// Index of the run's first cell.
    pub first_cell: usize,
    /// Node indices, `n_nodes` for each cell.
    pub connectivity: &'a [u32],
}

impl<'a> CellRun<'a> {
    /// Number of cells in the run.
    pub fn n_cells(&self) -> usize {
        self.connectivity.len() / self.n_nodes
    }

    /// Its cells.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first_cell..self.first_cell + self.n_cells()
    }

    /// Nodes of each cell, in order.
    pub fn cells(&self) -> std::slice::ChunksExact<'a, u32> {
        self.connectivity.chunks_exact(self.n_nodes)
    }

    /// Each cell, in order.
    pub fn cell_refs(&self) -> impl Iterator<Item = CellRef<'a>> + use<'a> {
        let (kind, first) = (self.kind, self.first_cell);
        self.cells().enumerate().map(move |(i, nodes)| CellRef {
            index: first + i,
            kind,
            nodes,
        })
    }
}

/// One cell.
#[derive(Debug, Clone, Copy)]
pub struct CellRef<'a> {
    /// Index among all cells.
    pub index: usize,
    /// Kind of cell.
    pub kind: CellKind,
    /// Nodes in VTK's order; for a polyhedron each node once.
    pub nodes: &'a [u32],
}

impl Cells {
    /// No cells yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Reserves memory for `n_entries` node indices.
    pub fn reserve(&mut self, n_entries: usize) {
        self.connectivity.reserve(n_entries);
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.runs
            .last()
            .map_or(0, |run| run.first_cell as usize + run.n_cells as usize)
    }

    /// Refuses so many further cells where they could not be indexed.
    pub(crate) fn check_space(&self, n: usize) -> Result<()> {
        match self.len().checked_add(n) {
            Some(total) if total < u32::MAX as usize => Ok(()),
            _ => Err(Error::input(super::too_many("cells"))),
        }
    }

    /// Returns whether there is no cell.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Largest dimension of a cell; 0 without cells.
    pub fn dimension(&self) -> u8 {
        let dimensions = self.runs().map(|run| run.kind.dimension());
        dimensions.max().unwrap_or(0)
    }

    /// Marks those of `n` nodes that a cell has.
    pub fn used_nodes(&self, n: usize) -> Vec<bool> {
        let mut used = vec![false; n];
        for &node in self.connectivity() {
            used[node as usize] = true;
        }
        used
    }

    /// Node indices of all cells, one after another.
    pub fn connectivity(&self) -> &[u32] {
        &self.connectivity
    }

    /// Appends one cell. A polyhedron is appended with [`Cells::push_polyhedron`].
    ///
    /// # Panics
    /// When the number of nodes is not the kind's; the caller has checked its input.
    pub fn push(&mut self, kind: CellKind, nodes: &[u32]) {
        assert!(kind != CellKind::Polyhedron);
        assert!(kind.can_have(nodes.len()));
        self.extend_run(kind, nodes.len(), 1);
        self.connectivity.extend_from_slice(nodes);
    }

    /// Appends many cells of one kind with `n_nodes` nodes each.
    ///
    /// # Panics
    /// When the length of `connectivity` is no multiple of `n_nodes`.
    pub fn push_run(&mut self, kind: CellKind, n_nodes: usize, connectivity: &[u32]) {
        assert!(kind != CellKind::Polyhedron && n_nodes > 0);
        assert!(kind.can_have(n_nodes));
        assert!(connectivity.len().is_multiple_of(n_nodes));
        if !connectivity.is_empty() {
            self.extend_run(kind, n_nodes, connectivity.len() / n_nodes);
            self.connectivity.extend_from_slice(connectivity);
        }
    }

    /// Takes over `connectivity` whole: `kinds` gives (kind, nodes per cell, number of cells) in
    /// order. For readers that hold the finished array and must not copy it.
    pub fn from_connectivity(
        connectivity: Vec<u32>,
        kinds: impl IntoIterator<Item = (CellKind, usize, usize)>,
    ) -> Self {
        let mut cells = Self::new();
        let mut n_entries = 0;
        for (kind, n_nodes, n_cells) in kinds {
            assert!(kind != CellKind::Polyhedron && kind.can_have(n_nodes));
            if n_cells > 0 {
                cells.extend_run_at(kind, n_nodes, n_cells, n_entries);
                n_entries += n_nodes * n_cells;
            }
        }
        assert_eq!(n_entries, connectivity.len());
        cells.connectivity = connectivity;
        cells
    }

    /// Cells of the given kinds, as for [`from_connectivity`](Self::from_connectivity), whose nodes are all `node`.
    pub(super) fn of_kinds(
        kinds: impl IntoIterator<Item = (CellKind, usize, usize)>,
        node: u32,
    ) -> Self {
        let mut cells = Self::new();
        let mut n_entries = 0;
        for (kind, n_nodes, n_cells) in kinds {
            cells.extend_run_at(kind, n_nodes, n_cells, n_entries);
            n_entries += n_nodes * n_cells;
        }
        cells.connectivity = sparse::zeros(n_entries, node);
        cells
    }

    /// Appends a polyhedron given as its face stream `n_faces, (n_nodes, node...)...`.
    ///
    /// Its nodes are listed once each, in order of first appearance.
    pub fn push_polyhedron(&mut self, stream: &[u32]) -> Result<()> {
        self.push_polyhedron_with_nodes(&distinct_nodes(stream)?, stream)
    }

    /// Appends a polyhedron whose file gives the order of its nodes.
    pub fn push_polyhedron_with_nodes(&mut self, nodes: &[u32], stream: &[u32]) -> Result<()> {
        let listed = Listed::new(nodes);
        for face in face_stream(stream) {
            if let Some(node) = face?.iter().find(|node| !listed.has(**node)) {
                return Err(Error::input(format!(
                    "a face of polyhedron {} has node {node}, which is not a node of the polyhedron",
                    self.len()
                )));
            }
        }
        if nodes.is_empty() {
            return Err(Error::input("a polyhedron without nodes"));
        }
        self.polyhedra.cells.push(self.len() as u32);
        self.polyhedra.starts.push(self.polyhedra.stream.len());
        self.polyhedra.stream.extend_from_slice(stream);
        self.extend_run(CellKind::Polyhedron, nodes.len(), 1);
        self.connectivity.extend_from_slice(nodes);
        Ok(())
    }

    /// Appends all cells of another list.
    pub fn append(&mut self, other: &Self) {
        self.append_kinds(other);
        self.connectivity.extend_from_slice(&other.connectivity);
    }

    /// Appends all of another list but its connectivity.
    fn append_kinds(&mut self, other: &Self) {
        let (cell, entry) = (self.len(), self.connectivity.len());
        for run in &other.runs {
            let n_cells = run.n_cells as usize;
            self.extend_run_at(
                run.kind,
                run.n_nodes as usize,
                n_cells,
                entry + run.first_entry,
            );
        }
        let (own, new) = (&mut self.polyhedra, &other.polyhedra);
        let stream = own.stream.len();
        own.cells
            .extend(new.cells.iter().map(|index| cell as u32 + index));
        own.starts
            .extend(new.starts.iter().map(|start| stream + start));
        own.stream.extend_from_slice(&new.stream);
    }

    /// Puts all cells of another list, which is small, before these.
    pub(super) fn prepend(&mut self, other: &Self) {
        let mut own = std::mem::replace(self, other.clone());
        let mut connectivity = std::mem::take(&mut own.connectivity);
        self.append_kinds(&own);
        connectivity.reserve_exact(other.connectivity.len());
        connectivity.splice(0..0, other.connectivity.iter().copied());
        self.connectivity = connectivity;
    }

    /// Replaces each node by `new_index[node]`.
    ///
    /// # Panics
    /// When a node is beyond `new_index`.
    pub fn renumber_nodes(&mut self, new_index: &[u32]) {
        self.renumber_nodes_by(|node| new_index[node as usize]);
    }

    /// Replaces each node by `new_index(node)`.
    pub fn renumber_nodes_by(&mut self, new_index: impl Fn(u32) -> u32 + Sync) {
        self.renumber_nodes_of(0..self.len(), new_index);
    }

    /// The same for some of the cells.
    pub(super) fn renumber_nodes_of(
        &mut self,
        cells: std::ops::Range<usize>,
        new_index: impl Fn(u32) -> u32 + Sync,
    ) {
        let entries = self.first_entry(cells.start)..self.first_entry(cells.end);
        parallel::update(&mut self.connectivity[entries], |_, node| {
            *node = new_index(*node);
        });
        let Polyhedra {
            cells: polyhedra,
            starts,
            stream,
        } = &mut self.polyhedra;
        let start = |cell: usize| {
            let before = polyhedra.partition_point(|&other| (other as usize) < cell);
            starts.get(before).copied().unwrap_or(stream.len())
        };
        let (start, end) = (start(cells.start), start(cells.end));
        let stream = &mut stream[start..end];
        let mut at = 0;
        while at < stream.len() {
            let n_faces = stream[at];
            at += 1;
            for _ in 0..n_faces {
                let n = stream[at] as usize;
                for node in &mut stream[at + 1..=at + n] {
                    *node = new_index(*node);
                }
                at += n + 1;
            }
        }
    }

    /// Lists linear wedges in the other orientation: the second and third node of each triangle change places.
    pub fn mirror_wedges(&mut self) {
        for run in self.runs.iter().filter(|run| run.kind == CellKind::Wedge) {
            let end = run.first_entry + 6 * run.n_cells as usize;
            mirror_wedges(&mut self.connectivity[run.first_entry..end]);
        }
    }

    /// Lists the wedges in the other order if these are then the cells of a reference; true if they are its cells.
    ///
    /// A file may not name the order of its wedges, and volumes do not show it if most wedges are inverted.
    pub fn follow(&mut self, reference: &Cells) -> bool {
        if self == reference {
            return true;
        }
        let mut mirrored = self.clone();
        mirrored.mirror_wedges();
        let is_same = mirrored == *reference;
        if is_same {
            *self = mirrored;
        }
        is_same
    }

    /// Start of the nodes of a cell; for the index after the last cell, the end of all nodes.
    fn first_entry(&self, cell: usize) -> usize {
        if cell == self.len() {
            return self.connectivity.len();
        }
        let run = &self.runs[self.run_of(cell)];
        run.first_entry + (cell - run.first_cell as usize) * run.n_nodes as usize
    }

    fn extend_run(&mut self, kind: CellKind, n_nodes: usize, n_cells: usize) {
        self.extend_run_at(kind, n_nodes, n_cells, self.connectivity.len());
    }

    fn extend_run_at(&mut self, kind: CellKind, n_nodes: usize, n_cells: usize, entry: usize) {
        let first_cell = self.len();
        assert!(
            first_cell + n_cells < u32::MAX as usize,
            "at most 4294967294 cells"
        );
        match self.runs.last_mut() {
            Some(run) if run.kind == kind && run.n_nodes as usize == n_nodes => {
                run.n_cells += n_cells as u32;
            }
            _ => self.runs.push(Run {
                kind,
                n_nodes: n_nodes as u32,
                first_cell: first_cell as u32,
                n_cells: n_cells as u32,
                first_entry: entry,
            }),
        }
    }

    /// The runs, in order.
    pub fn runs(&self) -> impl ExactSizeIterator<Item = CellRun<'_>> + DoubleEndedIterator + Clone {
        self.runs.iter().map(|run| self.view(run))
    }

    fn view(&self, run: &Run) -> CellRun<'_> {
        let n_nodes = run.n_nodes as usize;
        let end = run.first_entry + n_nodes * run.n_cells as usize;
        CellRun {
            kind: run.kind,
            n_nodes,
            first_cell: run.first_cell as usize,
            connectivity: &self.connectivity[run.first_entry..end],
        }
    }

    /// Index of the run that holds a cell.
    ///
    /// # Panics
    /// When there is no such cell.
    pub fn run_of(&self, cell: usize) -> usize {
        assert!(cell < self.len(), "there is no cell {cell}");
        self.runs
            .partition_point(|run| run.first_cell as usize <= cell)
            - 1
    }

    /// The run of this index.
    ///
    /// # Panics
    /// When there is no such run.
    pub fn run(&self, index: usize) -> CellRun<'_> {
        self.view(&self.runs[index])
    }

    /// The runs, cut to the cells of `range`.
    pub fn runs_in(&self, range: std::ops::Range<usize>) -> impl Iterator<Item = CellRun<'_>> {
        let first = self
            .runs
            .partition_point(|run| (run.first_cell + run.n_cells) as usize <= range.start);
        self.runs[first..]
            .iter()
            .take_while({
                let end = range.end;
                move |run| (run.first_cell as usize) < end
            })
            .map(move |run| {
                let whole = self.view(run);
                let skip = range.start.saturating_sub(whole.first_cell);
                let end = whole.n_cells().min(range.end - whole.first_cell);
                CellRun {
                    first_cell: whole.first_cell + skip,
                    connectivity: &whole.connectivity[skip * whole.n_nodes..end * whole.n_nodes],
                    ..whole
                }
            })
    }

    /// Every cell, in order.
    pub fn iter(&self) -> impl Iterator<Item = CellRef<'_>> {
        self.runs().flat_map(|run| run.cell_refs())
    }

    /// The cell with this index.
    ///
    /// # Panics
    /// When there is no such cell.
    pub fn get(&self, index: usize) -> CellRef<'_> {
        let after = self
            .runs
            .partition_point(|run| run.first_cell as usize <= index);
        let run = self.view(&self.runs[after - 1]);
        let start = (index - run.first_cell) * run.n_nodes;
        CellRef {
            index,
            kind: run.kind,
            nodes: &run.connectivity[start..start + run.n_nodes],
        }
    }

    /// Face stream `n_faces, (n_nodes, node...)...` of a polyhedron; `None` for any other cell.
    pub fn face_stream(&self, cell: usize) -> Option<&[u32]> {
        let ordinal = self.polyhedra.cells.binary_search(&(cell as u32)).ok()?;
        let starts = &self.polyhedra.starts;
        let end = starts
            .get(ordinal + 1)
            .copied()
            .unwrap_or(self.polyhedra.stream.len());
        Some(&self.polyhedra.stream[starts[ordinal]..end])
    }

    /// Number of faces of a polyhedron; 0 for any other cell.
    pub(crate) fn n_faces(&self, cell: usize) -> usize {
        self.face_stream(cell)
            .map_or(0, |stream| stream[0] as usize)
    }

    /// Face streams of all polyhedra, one after another.
    pub fn face_streams(&self) -> &[u32] {
        &self.polyhedra.stream
    }

    /// Faces of a polyhedron as node lists; empty for any other cell.
    pub fn polyhedron_faces(&self, cell: usize) -> impl Iterator<Item = &[u32]> {
        face_stream(self.face_stream(cell).unwrap_or(&[0]))
            .map(|face| face.expect("streams are checked when a polyhedron is added"))
    }

    /// Returns whether any cell is a polyhedron.
    pub fn has_polyhedra(&self) -> bool {
        !self.polyhedra.cells.is_empty()
    }

    /// Bytes held in memory.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.runs[..])
            + size_of_val(&self.connectivity[..])
            + size_of_val(&self.polyhedra.stream[..])
            + self.polyhedra.cells.len() * 12
    }
}

/// Lists wedges of six nodes in the other orientation.
pub(crate) fn mirror_wedges(nodes: &mut [u32]) {
    for nodes in nodes.chunks_exact_mut(6) {
        nodes.swap(1, 2);
        nodes.swap(4, 5);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_come_back_in_order_whatever_the_runs() {
        let mut cells = Cells::new();
        cells.push(CellKind::Triangle, &[0, 1, 2]);
        cells.push(CellKind::Triangle, &[1, 2, 3]);
        cells.push(CellKind::Polygon, &[0, 1, 2, 3, 4]);
        cells.push(CellKind::Polygon, &[0, 1, 2]);
        assert_eq!(cells.runs().len(), 3);
        assert_eq!(cells.get(1).nodes, [1, 2, 3]);
        assert_eq!(cells.get(3).nodes, [0, 1, 2]);
        assert_eq!(cells.iter().count(), 4);
        let cut: Vec<_> = cells
            .runs_in(1..3)
            .map(|r| (r.first_cell, r.n_cells()))
            .collect();
        assert_eq!(cut, [(1, 1), (2, 1)]);
    }

    #[test]
    fn a_polyhedron_keeps_its_faces() {
        let tetrahedron = [4, 3, 0, 1, 2, 3, 0, 1, 3, 3, 1, 2, 3, 3, 0, 2, 3];
        let mut cells = Cells::new();
        cells.push(CellKind::Vertex, &[0]);
        cells.push_polyhedron(&tetrahedron).expect("a good stream");
        assert_eq!(cells.get(1).nodes, [0, 1, 2, 3]);
        assert_eq!(cells.face_stream(1), Some(&tetrahedron[..]));
        assert_eq!(cells.polyhedron_faces(1).count(), 4);
        assert!(cells.push_polyhedron(&[1, 3, 0, 1]).is_err());
        assert!(cells.push_polyhedron(&[1, 3, 0, 1, 2, 7]).is_err());
    }

    #[test]
    fn cells_put_before_others_are_as_if_those_had_been_appended() {
        let tetrahedron = [4, 3, 0, 1, 2, 3, 0, 1, 3, 3, 1, 2, 3, 3, 0, 2, 3];
        let mut few = Cells::new();
        few.push_polyhedron(&tetrahedron).expect("a good stream");
        few.push(CellKind::Triangle, &[7, 8, 9]);
        let mut others = Cells::new();
        others.push(CellKind::Triangle, &[0, 1, 2]);
        others.push_polyhedron(&tetrahedron).expect("a good stream");
        for (before, after) in [
            (&few, &others),
            (&few, &Cells::new()),
            (&Cells::new(), &few),
        ] {
            let (mut wanted, mut found) = (before.clone(), after.clone());
            wanted.append(after);
            found.prepend(before);
            assert_eq!(found, wanted);
        }
    }

    #[test]
    fn cells_that_are_appended_are_as_if_they_had_been_pushed() {
        let stream = |n: u32| {
            let faces = [4, 3, 0, 1, 2, 3, 0, 1, 3, 3, 1, 2, 3, 3, 0, 2, 3];
            let at = |(i, value): (usize, &u32)| {
                if i % 4 > 1 || i % 4 == 0 && i > 0 {
                    n + value
                } else {
                    *value
                }
            };
            faces.iter().enumerate().map(at).collect::<Vec<u32>>()
        };
        let push = |cells: &mut Cells, n: u32| {
            cells.push(CellKind::Triangle, &[n, n + 1, n + 2]);
            cells.push_polyhedron(&stream(n)).expect("a good stream");
            cells.push(CellKind::Triangle, &[n, n + 1, n + 3]);
        };
        let (mut all, mut parts) = (Cells::new(), Cells::new());
        for n in [0, 10, 20] {
            push(&mut all, n);
            let mut part = Cells::new();
            push(&mut part, n);
            parts.append(&part);
        }
        parts.append(&Cells::new());
        assert_eq!(parts, all);
        assert_eq!(parts.runs().len(), 7);
        assert_eq!(parts.polyhedron_faces(4).next(), Some(&[10, 11, 12][..]));
    }
}

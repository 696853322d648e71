//! The boundary of a mesh: motions and checks before a run need nothing else of the mesh.

use super::{CellKind, CellRef, CellRun, Cells, Group, Mesh, Numbering, Origin, groups, is_flat};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_core::ranks::raw;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// The boundary of a mesh: its faces, their nodes with coordinates, and the groups of the mesh.
///
/// Faces are all cells of lower dimension than the mesh; the faces of a cloud of points are its vertices. Nodes and
/// cells have the numbers of the whole mesh.
#[derive(Debug, Clone)]
pub struct Boundary {
    /// Number of nodes of the mesh.
    pub n_nodes: usize,
    /// Number of cells of the mesh.
    pub n_cells: usize,
    /// Box around all nodes of the mesh.
    pub extent: Bounds,
    /// Boundary tags, zones and groups of lower dimension, in file order.
    pub groups: Vec<Group>,
    /// Data that the reader of the mesh left for a writer of the same format.
    pub origin: Origin,
    dimension: u8,
    /// Ascending numbers of the nodes with known coordinates.
    nodes: Numbering<'static>,
    points: Vec<Vector>,
    faces: Cells,
    blocks: Vec<Block>,
}

/// Consecutive faces of one kind, with the numbers of the whole mesh.
#[derive(Serialize, Deserialize)]
struct FaceRun {
    kind: CellKind,
    n_nodes: usize,
    first_cell: usize,
    #[serde(with = "raw")]
    nodes: Vec<u32>,
}

/// Consecutive cells of the mesh that are faces.
#[derive(Debug, Clone)]
struct Block {
    /// Their numbers in the mesh.
    cells: Range<usize>,
    /// Number of other cells before them.
    n_others: usize,
}

impl Boundary {
    /// Copies the boundary of a mesh. All ranks that have parts of it call it, and get the boundary of the whole mesh.
    pub fn of(mesh: &Mesh) -> Self {
        let (ranks, dimension) = (mesh.ranks(), mesh.dimension());
        let is_face = |run: &CellRun<'_>| dimension == 0 || run.kind.dimension() < dimension;
        let runs = mesh.cells.runs_in(mesh.own_cells());
        let own = runs.filter(is_face).map(|run| FaceRun {
            kind: run.kind,
            n_nodes: run.n_nodes,
            first_cell: run.first_cell + mesh.own_offset(),
            nodes: run
                .connectivity
                .iter()
                .map(|&node| mesh.number_of_node(node))
                .collect(),
        });
        let (mut faces, mut blocks) = (Cells::new(), Vec::<Block>::new());
        for run in ranks
            .allgather(own.collect::<Vec<_>>())
            .into_iter()
            .flatten()
        {
            let n_cells = run.nodes.len() / run.n_nodes;
            let cells = run.first_cell..run.first_cell + n_cells;
            let n_others = cells.start - faces.len();
            match blocks.last_mut() {
                Some(last) if last.n_others == n_others => last.cells.end = cells.end,
                _ => blocks.push(Block { cells, n_others }),
            }
            faces.push_run(run.kind, run.n_nodes, &run.nodes);
        }
        let mut nodes = faces.connectivity().to_vec();
        parallel::sort(&mut nodes);
        nodes.dedup();
        Self {
            n_nodes: mesh.n_nodes_of_all(),
            n_cells: mesh.n_cells_of_all(),
            extent: mesh.extent_of_all(),
            groups: mesh.groups_of_all().to_vec(),
            origin: mesh.origin.clone(),
            dimension,
            points: mesh.values_of_nodes(&nodes, |node| mesh.points[node]),
            nodes: Numbering::new(nodes),
            faces,
            blocks,
        }
    }

    /// Returns the dimension of the mesh, as [`Mesh::dimension`].
    pub fn dimension(&self) -> u8 {
        self.dimension
    }

    /// Returns the dimension of the space of the mesh, as [`Mesh::space_dimension`].
    pub fn space_dimension(&self) -> u8 {
        if self.dimension < 3 && is_flat(&self.extent) {
            2
        } else {
            3
        }
    }

    /// Counts the cells of the mesh's own dimension.
    pub fn n_volume_cells(&self) -> usize {
        match self.dimension {
            0 => self.n_cells,
            _ => self.n_cells - self.faces.len(),
        }
    }

    /// Lists the boundary tags, in file order, as [`Mesh::boundary_tags`].
    pub fn boundary_tags(&self) -> impl Iterator<Item = &Group> + Clone {
        groups::boundary_tags(&self.groups, self.dimension)
    }

    /// Lists the zones, in file order, as [`Mesh::zones`].
    pub fn zones(&self) -> impl Iterator<Item = &Group> + Clone {
        groups::zones(&self.groups, self.dimension)
    }

    /// Returns the coordinates of a node.
    ///
    /// # Panics
    /// If the node is neither on a face nor among the nodes that were [added](Self::add_nodes).
    #[inline]
    pub fn position(&self, node: u32) -> Vector {
        let at = self.nodes.place(node);
        self.points[at.expect("the node is on the boundary")]
    }

    /// Returns the face with this cell number.
    ///
    /// # Panics
    /// If the cell is not a face.
    pub fn face(&self, cell: usize) -> CellRef<'_> {
        let block = self.block_of(cell).filter(|of| of.cells.contains(&cell));
        let block = block.expect("the cell is a face");
        CellRef {
            index: cell,
            ..self.faces.get(cell - block.n_others)
        }
    }

    /// Finds the first block that ends after a cell.
    fn block_of(&self, cell: usize) -> Option<&Block> {
        let before = |block: &Block| block.cells.end <= cell;
        self.blocks.get(self.blocks.partition_point(before))
    }

    /// Lists the faces, in order.
    pub fn faces(&self) -> impl Iterator<Item = CellRun<'_>> {
        self.faces_in(0..self.n_cells)
    }

    /// Lists the faces among some cells, in order.
    pub fn faces_in(&self, cells: Range<usize>) -> impl Iterator<Item = CellRun<'_>> {
        let first = self
            .blocks
            .partition_point(|block| block.cells.end <= cells.start);
        let end = cells.end;
        let blocks = self.blocks[first..].iter();
        let blocks = blocks.take_while(move |block| block.cells.start < end);
        blocks.flat_map(move |block| {
            let n_others = block.n_others;
            let (start, end) = (
                cells.start.max(block.cells.start) - n_others,
                cells.end.min(block.cells.end) - n_others,
            );
            let runs = self.faces.runs_in(start..end);
            runs.map(move |run| CellRun {
                first_cell: run.first_cell + n_others,
                ..run
            })
        })
    }

    /// Lists the nodes of the faces of a boundary tag, a node once per face.
    pub fn nodes_of<'a>(&'a self, tag: &'a Group) -> impl Iterator<Item = u32> + 'a {
        let runs = tag.cells.ranges().flat_map(|cells| self.faces_in(cells));
        runs.flat_map(|run| run.connectivity.iter().copied())
    }

    /// Adds nodes inside the mesh with their coordinates, such as nodes on the interface of a zone. Known nodes stay as
    /// they are.
    pub fn add_nodes(&mut self, nodes: &[u32], points: &[Vector]) {
        let known = self.nodes.sorted().iter().zip(&self.points);
        let mut all: Vec<(u32, Vector)> = known
            .chain(nodes.iter().zip(points))
            .map(|(node, point)| (*node, *point))
            .collect();
        all.sort_by_key(|of| of.0);
        all.dedup_by_key(|of| of.0);
        let (nodes, points): (Vec<u32>, Vec<Vector>) = all.into_iter().unzip();
        (self.nodes, self.points) = (Numbering::new(nodes), points);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;

    /// Checks that the boundary has the faces, positions and groups of the mesh.
    fn assert_boundary_of(mesh: &Mesh) {
        let boundary = Boundary::of(mesh);
        assert_eq!(boundary.dimension(), mesh.dimension());
        assert_eq!(boundary.space_dimension(), mesh.space_dimension());
        assert_eq!(boundary.extent, mesh.extent_of_all());
        assert!(boundary.boundary_tags().eq(mesh.boundary_tags()));
        assert!(boundary.zones().eq(mesh.zones()));
        let n_volume: usize = mesh.volume_runs().map(|run| run.n_cells()).sum();
        assert_eq!(boundary.n_volume_cells(), n_volume);
        let is_face = |cell: &CellRef<'_>| cell.kind.dimension() < mesh.dimension().max(1);
        let of_mesh: Vec<CellRef<'_>> = mesh.cells.iter().filter(is_face).collect();
        let key = |cell: &CellRef<'_>| (cell.index, cell.kind, cell.nodes.to_vec());
        let all = boundary.faces().flat_map(|run| run.cell_refs());
        assert!(all.map(|face| key(&face)).eq(of_mesh.iter().map(key)));
        for face in &of_mesh {
            assert_eq!(key(&boundary.face(face.index)), key(face));
            for &node in face.nodes {
                assert_eq!(boundary.position(node), mesh.points[node as usize]);
            }
        }
        let n = mesh.cells.len();
        for range in [0..n / 3, n / 3..2 * n / 3, n / 2..n / 2, 2 * n / 3..n] {
            let found = boundary.faces_in(range.clone());
            let found = found.flat_map(|run| run.cell_refs());
            let expected = of_mesh.iter().filter(|face| range.contains(&face.index));
            assert!(found.map(|face| key(&face)).eq(expected.map(key)));
        }
        for tag in mesh.boundary_tags() {
            let nodes = tag.cells.iter().flat_map(|cell| mesh.cells.get(cell).nodes);
            assert!(boundary.nodes_of(tag).eq(nodes.copied()));
        }
    }

    #[test]
    fn a_boundary_has_the_faces_positions_and_tags_of_its_mesh() {
        for file in ["wing_on_plane.vtu", "naca0012.vtu"] {
            let mesh = Mesh::read(format!("testdata/{file}")).expect("it is good");
            assert_boundary_of(&mesh);
        }
    }

    #[test]
    fn faces_may_be_anywhere_among_the_cells() {
        let mut mesh = Mesh::of_points((0..6).map(|i| [f64::from(i), 0.5, 0.0]).collect());
        for at in 0..3 {
            mesh.cells.push(CellKind::Triangle, &[at, at + 1, at + 2]);
            mesh.cells.push(CellKind::Vertex, &[at]);
            mesh.cells
                .push(CellKind::Tetrahedron, &[at, at + 1, at + 2, at + 3]);
        }
        assert_boundary_of(&mesh);
        mesh.cells.push(CellKind::Line, &[4, 5]);
        assert_boundary_of(&mesh);
        mesh.cells = Cells::new();
        (0..6).for_each(|node| mesh.cells.push(CellKind::Vertex, &[node]));
        assert_boundary_of(&mesh);
        mesh.space = Some(3);
        assert_boundary_of(&mesh);
        assert_boundary_of(&Mesh::default());
    }

    #[test]
    fn nodes_inside_are_added() {
        let mut mesh = Mesh::of_points((0..6).map(|i| [f64::from(i), 0.0, 0.0]).collect());
        mesh.cells.push(CellKind::Triangle, &[0, 2, 4]);
        mesh.cells.push(CellKind::Line, &[2, 4]);
        let mut boundary = Boundary::of(&mesh);
        boundary.add_nodes(&[5, 2, 0], &[[5.0; 3], [7.0; 3], [9.0; 3]]);
        let expected = [
            (0, [9.0; 3]),
            (2, mesh.points[2]),
            (4, mesh.points[4]),
            (5, [5.0; 3]),
        ];
        for (node, position) in expected {
            assert_eq!(boundary.position(node), position);
        }
    }
}

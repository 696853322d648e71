//! From cells to faces: inner faces in upper-triangular order, then the patches one after another, each face turned
//! out of its owner. Knows nothing of the types of patches or of files.
//!
//! Cells keep their order. The owner of a face is its cell of lower index; faces are sorted by owner, then by
//! neighbour. The faces of a patch have the order that its boundary cells have in the mesh, so that pairs of periodic
//! patches stay pairs.
//!
//! A cell that a motion has turned inside out keeps the orientation of its kind: faces of neighbouring cells have to
//! agree, and a checker of meshes is to find the negative volume.

use crate::mesh::sides::for_each_side;
use crate::mesh::{Across, Adjacency, CellKind, CellRef, CellRun, MeshView, turned};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, cross, dot, sub};
use azimesh_core::parallel::{BLOCK, map, map_blocks};
use std::collections::{BTreeMap, BTreeSet};
use std::mem;

/// The faces of a mesh as polyMesh has them.
#[derive(Debug, Default, PartialEq)]
pub(super) struct OrderedFaces {
    pub faces: FaceList,
    /// Cell of each face that it is turned out of.
    pub owner: Vec<u32>,
    /// The other cell of each inner face.
    pub neighbour: Vec<u32>,
    /// Number of faces of each patch, in order; the last one has the outer faces of no tag.
    pub patch_sizes: Vec<usize>,
    pub n_cells: usize,
    /// Number of cells that the mesh lists in the other orientation.
    pub n_reversed: usize,
}

/// Lists of nodes, one after another.
#[derive(Debug, PartialEq)]
pub(super) struct FaceList {
    /// Start of each face in `nodes`, and the end.
    pub starts: Vec<u32>,
    pub nodes: Vec<u32>,
}

impl Default for FaceList {
    fn default() -> Self {
        Self {
            starts: vec![0],
            nodes: Vec::new(),
        }
    }
}

impl FaceList {
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    pub fn get(&self, face: usize) -> &[u32] {
        &self.nodes[self.starts[face] as usize..self.starts[face + 1] as usize]
    }

    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|face| self.get(face))
    }

    pub fn push(&mut self, nodes: &[u32]) {
        self.nodes.extend_from_slice(nodes);
        self.starts.push(self.nodes.len() as u32);
    }

    /// Takes over the faces of another list.
    fn append(&mut self, other: &FaceList) -> Result<()> {
        let before = self.nodes.len();
        if before + other.nodes.len() > i32::MAX as usize {
            return Err(too_many("the faces have", "nodes together"));
        }
        self.nodes.extend_from_slice(&other.nodes);
        let starts = other.starts[1..].iter().map(|start| start + before as u32);
        self.starts.extend(starts);
        Ok(())
    }
}

fn too_many(there: &str, what: &str) -> Error {
    Error::input(format!(
        "{there} more than 2147483647 {what}, the most that labels of 32 bits count"
    ))
}

/// The number of each volume cell among them.
pub(super) struct CellNumbers {
    /// First cell and first number of each run of volume cells.
    runs: Vec<(u32, u32)>,
    n: usize,
}

impl CellNumbers {
    /// Numbers the cells of the mesh's dimension.
    pub fn of(mesh: &MeshView) -> Self {
        let (mut runs, mut n) = (Vec::new(), 0);
        let mut end = None;
        for run in mesh.volume_runs() {
            if end != Some(run.first_cell) {
                runs.push((run.first_cell as u32, n as u32));
            }
            n += run.n_cells();
            end = Some(run.first_cell + run.n_cells());
        }
        Self { runs, n }
    }

    pub fn len(&self) -> usize {
        self.n
    }

    #[inline]
    pub fn get(&self, cell: u32) -> u32 {
        let after = self.runs.partition_point(|(first, _)| *first <= cell);
        let (first, number) = self.runs[after.saturating_sub(1)];
        number + (cell - first)
    }
}

/// The faces of some consecutive cells.
#[derive(Default)]
struct Part {
    inner: FaceList,
    owner: Vec<u32>,
    neighbour: Vec<u32>,
    outer: FaceList,
    /// Of each outer face its patch, its boundary cell ([`NONE`] without a tag), and its owner.
    on_patch: Vec<[u32; 3]>,
}

const NONE: u32 = u32::MAX;

impl OrderedFaces {
    /// Finds the faces of a solid mesh. `patch_of` has for each cell the patch of a boundary cell; `n_patches` is
    /// the patch of the others, the largest.
    ///
    /// Time and memory grow with the number of sides of the cells.
    pub fn of(mesh: &MeshView, patch_of: &[u32], n_patches: usize) -> Result<Self> {
        let walk = Walk {
            mesh,
            numbers: CellNumbers::of(mesh),
            orientation: Orientation::of(mesh),
            patch_of,
            rest: n_patches as u32,
        };
        let adjacency = Adjacency::of_cells(mesh.cells, mesh.dimension());
        let mut parts = map(adjacency.n_chunks(), &|chunk| walk.part(&adjacency, chunk));
        drop(adjacency);
        let mut topology = Self {
            n_cells: walk.numbers.len(),
            n_reversed: walk.orientation.n_reversed(mesh),
            patch_sizes: vec![0; n_patches + 1],
            ..Self::default()
        };
        let entries = parts
            .iter()
            .map(|part| part.inner.nodes.len() + part.outer.nodes.len());
        topology.faces.nodes.reserve_exact(entries.sum());
        for part in &mut parts {
            topology.faces.append(&mem::take(&mut part.inner))?;
            topology.owner.append(&mut mem::take(&mut part.owner));
            topology
                .neighbour
                .append(&mut mem::take(&mut part.neighbour));
        }
        topology.add_patches(&parts)?;
        Ok(topology)
    }

    /// Adds the faces of the patches, after the inner ones.
    fn add_patches(&mut self, parts: &[Part]) -> Result<()> {
        let mut order: Vec<([u32; 2], u32, u32)> = Vec::new();
        for (at, part) in parts.iter().enumerate() {
            let faces = part.on_patch.iter().zip(0..);
            order.extend(faces.map(|(&[patch, cell, _], i)| ([patch, cell], at as u32, i)));
        }
        order.sort_unstable();
        if order.len() + self.owner.len() > i32::MAX as usize {
            return Err(too_many("there are", "faces"));
        }
        for ([patch, _], part, i) in order {
            let part = &parts[part as usize];
            self.faces.push(part.outer.get(i as usize));
            self.owner.push(part.on_patch[i as usize][2]);
            self.patch_sizes[patch as usize] += 1;
        }
        Ok(())
    }
}

struct Walk<'a> {
    mesh: &'a MeshView<'a>,
    numbers: CellNumbers,
    orientation: Orientation,
    patch_of: &'a [u32],
    rest: u32,
}

impl Walk<'_> {
    fn part(&self, adjacency: &Adjacency, chunk: usize) -> Part {
        let (range, mut sides) = adjacency.chunk(chunk);
        let mut part = Part::default();
        let (mut own, mut inner) = (FaceList::default(), Vec::new());
        let dimension = self.mesh.dimension();
        let runs = self.mesh.cells.runs_in(range);
        for run in runs.filter(|run| run.kind.dimension() == dimension) {
            for cell in run.cell_refs() {
                own.starts.truncate(1);
                own.nodes.clear();
                inner.clear();
                for_each_side(self.mesh.cells, &cell, |side, corners| {
                    let reverse = self.orientation.is_inward(&cell, side);
                    match sides.across() {
                        Across::Elsewhere => {}
                        Across::Cell(other) => {
                            inner.push((self.numbers.get(other), own.len()));
                            push_face(&mut own, corners, reverse);
                        }
                        Across::Outside(boundary) => {
                            self.outer(&mut part, &cell, (corners, reverse), boundary)
                        }
                    }
                });
                inner.sort_unstable();
                let owner = self.numbers.get(cell.index as u32);
                for &(neighbour, at) in &inner {
                    part.inner.push(own.get(at));
                    part.owner.push(owner);
                    part.neighbour.push(neighbour);
                }
            }
        }
        part
    }

    fn outer(
        &self,
        part: &mut Part,
        cell: &CellRef<'_>,
        (corners, reverse): (&[u32], bool),
        boundary: Option<u32>,
    ) {
        let patch = boundary.map_or(self.rest, |cell| self.patch_of[cell as usize]);
        let owner = self.numbers.get(cell.index as u32);
        let first = boundary.map(|cell| self.mesh.cells.get(cell as usize).nodes[0]);
        let from = part.outer.nodes.len();
        push_face(&mut part.outer, corners, reverse);
        let face = &mut part.outer.nodes[from..];
        // A face starts where the boundary cell does: solvers pair the faces of cyclic patches by their first nodes.
        if let Some(at) = first.and_then(|first| face.iter().position(|node| *node == first)) {
            face.rotate_left(at);
        }
        let of_tag = boundary.filter(|_| patch != self.rest);
        part.on_patch.push([patch, of_tag.unwrap_or(NONE), owner]);
    }
}

/// Adds a face without repeated corners, which collapsed cells have. The first node stays first.
fn push_face(list: &mut FaceList, corners: &[u32], reverse: bool) {
    let (first, n) = (list.nodes.len(), corners.len());
    for i in 0..n {
        let node = corners[if reverse && i > 0 { n - i } else { i }];
        if list.nodes[first..].last() != Some(&node) {
            list.nodes.push(node);
        }
    }
    if list.nodes.len() > first + 1 && list.nodes[first..].last() == Some(&list.nodes[first]) {
        list.nodes.pop();
    }
    list.starts.push(list.nodes.len() as u32);
}

/// The orientation of the sides of the cells of a mesh.
struct Orientation {
    /// Kinds whose sides turn inward as the kind has them.
    inward: BTreeSet<CellKind>,
    /// Polyhedra whose sides do not agree among themselves, and for each side whether it turns inward.
    mixed: BTreeMap<u32, Vec<bool>>,
}

impl Orientation {
    /// Follows from the signs of the volumes: most cells of a kind decide for all cells of the kind.
    pub fn of(mesh: &MeshView) -> Self {
        let mut balance: BTreeMap<CellKind, i64> = BTreeMap::new();
        let mut mixed = BTreeMap::new();
        for run in mesh.volume_runs() {
            let blocks = map_blocks(run.n_cells(), BLOCK, &|cells| {
                let mut found = (0_i64, Vec::new());
                for i in cells {
                    let nodes = &run.connectivity[i * run.n_nodes..(i + 1) * run.n_nodes];
                    let (kind, index) = (run.kind, run.first_cell + i);
                    add_cell(mesh, &CellRef { index, kind, nodes }, &mut found);
                }
                found
            });
            for (sum, own) in blocks {
                *balance.entry(run.kind.linear()).or_default() += sum;
                mixed.extend(own);
            }
        }
        let inward = balance.into_iter().filter(|(_, sum)| *sum < 0);
        Self {
            inward: inward.map(|(kind, _)| kind).collect(),
            mixed,
        }
    }

    /// Number of cells whose sides all turn inward as their kind has them.
    pub fn n_reversed(&self, mesh: &MeshView) -> usize {
        let runs = mesh.volume_runs();
        let inward = runs.filter(|run| self.inward.contains(&run.kind.linear()));
        let of_run = |run: CellRun| {
            let cells = run.first_cell as u32..(run.first_cell + run.n_cells()) as u32;
            run.n_cells() - self.mixed.range(cells).count()
        };
        inward.map(of_run).sum()
    }

    /// Checks if a side of a cell, with its corners as the cell has them, turns inward.
    pub fn is_inward(&self, cell: &CellRef<'_>, side: usize) -> bool {
        let own = || self.mixed.get(&(cell.index as u32));
        match cell.kind {
            CellKind::Polyhedron if !self.mixed.is_empty() => {
                let common = self.inward.contains(&CellKind::Polyhedron);
                own().map_or(common, |sides| sides.get(side).copied().unwrap_or(false))
            }
            kind => self.inward.contains(&kind.linear()),
        }
    }
}

/// Adds the sign of the volume of a cell, or the sides of a polyhedron that do not agree.
fn add_cell(mesh: &MeshView, cell: &CellRef<'_>, found: &mut (i64, Vec<(u32, Vec<bool>)>)) {
    if cell.kind == CellKind::Polyhedron {
        let faces: Vec<&[u32]> = mesh.cells.polyhedron_faces(cell.index).collect();
        if let Some(mut turned) = disagreeing(&faces) {
            if volume(mesh, cell, |side| turned[side]) < 0.0 {
                turned.iter_mut().for_each(|turned| *turned = !*turned);
            }
            found.1.push((cell.index as u32, turned));
            return;
        }
    }
    let volume = volume(mesh, cell, |_| false);
    found.0 += i64::from(volume > 0.0) - i64::from(volume < 0.0);
}

/// Six times the volume inside the sides of a cell, those that are `turned` taken the other way round.
fn volume(mesh: &MeshView, cell: &CellRef<'_>, turned: impl Fn(usize) -> bool) -> f64 {
    let Some(&first) = cell.nodes.first() else {
        return 0.0;
    };
    let origin = mesh.points[first as usize];
    let at = |node: u32| -> Vector { sub(mesh.points[node as usize], origin) };
    let mut sum = 0.0;
    for_each_side(mesh.cells, cell, |side, corners| {
        let mut own = 0.0;
        for i in 2..corners.len() {
            let [a, b, c] = [corners[0], corners[i - 1], corners[i]].map(at);
            own += dot(a, cross(b, c));
        }
        sum += if turned(side) { -own } else { own };
    });
    sum
}

/// For each face of a polyhedron whether it turns against the first; `None` where no face does. Faces that share
/// an edge pass over it in opposite directions where they agree.
fn disagreeing(faces: &[&[u32]]) -> Option<Vec<bool>> {
    let mut edges: Vec<([u32; 2], usize, bool)> = Vec::new();
    for (face, nodes) in faces.iter().enumerate() {
        for (i, &from) in nodes.iter().enumerate() {
            let to = nodes[(i + 1) % nodes.len()];
            if from != to {
                edges.push(([from.min(to), from.max(to)], face, from < to));
            }
        }
    }
    edges.sort_unstable();
    let pairs = || {
        edges
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|pair| pair.len() == 2)
    };
    if pairs().all(|pair| pair[0].2 != pair[1].2) {
        return None;
    }
    let mut beside: Vec<Vec<(usize, bool)>> = vec![Vec::new(); faces.len()];
    for pair in pairs() {
        let (a, b, is_same) = (pair[0].1, pair[1].1, pair[0].2 == pair[1].2);
        beside[a].push((b, is_same));
        beside[b].push((a, is_same));
    }
    turned(&beside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellKind, Mesh};

    /// Two tetrahedra that share a face, the second before the first in the file.
    fn two() -> Mesh {
        let mut mesh = Mesh::of_points(vec![
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 1.0, 1.0],
        ]);
        mesh.cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
        mesh.cells.push(CellKind::Triangle, &[1, 0, 3]);
        mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        mesh
    }

    #[test]
    fn inner_faces_come_first_and_turn_out_of_the_cell_of_lower_number() {
        let mesh = two();
        let topology = OrderedFaces::of(&mesh.view(), &[1, 0, 1], 1).expect("it is small");
        assert_eq!((topology.n_cells, topology.neighbour.len()), (2, 1));
        assert_eq!((topology.owner[0], topology.neighbour[0]), (0, 1));
        // Seen from cell 0, whose node 4 is beyond, the shared face turns towards node 0.
        let nodes = topology.faces.get(0);
        let at = |i: usize| mesh.points[nodes[i] as usize];
        use azimesh_core::geometry::vector::{cross, dot, sub};
        let normal = cross(sub(at(1), at(0)), sub(at(2), at(0)));
        assert!(dot(normal, sub(mesh.points[0], at(0))) > 0.0);
        assert_eq!(topology.patch_sizes, [1, 5]);
        // The tagged face keeps its first node and turns out of its cell.
        assert_eq!(topology.faces.get(1), [1, 3, 0]);
    }

    #[test]
    fn faces_of_a_block_are_in_upper_triangular_order() {
        let mesh = Mesh::read("testdata/sphere_in_box_raw.vtu").expect("it is there");
        let none = vec![0; mesh.cells.len()];
        let topology = OrderedFaces::of(&mesh.view(), &none, 0).expect("it is small");
        let inner: Vec<_> = topology.owner.iter().zip(&topology.neighbour).collect();
        assert!(inner.len() > 1000 && inner.is_sorted() && inner.iter().all(|(a, b)| a < b));
        assert_eq!(topology.owner.len(), topology.faces.len());
        assert_eq!(topology.patch_sizes[0], topology.faces.len() - inner.len());
    }

    #[test]
    fn a_collapsed_side_loses_its_repeated_corners() {
        let mut list = FaceList::default();
        push_face(&mut list, &[1, 2, 2, 3], false);
        push_face(&mut list, &[1, 2, 3, 1], true);
        push_face(&mut list, &[4, 5, 6, 7], true);
        let faces: Vec<&[u32]> = (0..3).map(|i| list.get(i)).collect();
        assert_eq!(faces, [&[1, 2, 3][..], &[1, 3, 2], &[4, 7, 6, 5]]);
    }

    fn cube(stream_turned: &[usize]) -> Mesh {
        let corner = |i: usize| [1, 2, 4].map(|bit| f64::from(u8::from(i & bit != 0)));
        let mut faces = CellKind::Hexahedron.faces().to_vec();
        faces.sort();
        // Nodes of a hexahedron, numbered by the bits of their places.
        let bits = [0, 1, 3, 2, 4, 5, 7, 6];
        let mut stream = vec![6];
        for (i, face) in faces.iter().enumerate() {
            let mut nodes: Vec<u32> = face.iter().map(|&node| bits[usize::from(node)]).collect();
            if stream_turned.contains(&i) {
                nodes.reverse();
            }
            stream.push(4);
            stream.extend(nodes);
        }
        let mut mesh = Mesh::of_points((0..8).map(corner).collect());
        mesh.cells.push_polyhedron(&stream).expect("a good stream");
        mesh
    }

    fn inward(mesh: &Mesh) -> Vec<usize> {
        let view = mesh.view();
        let orientation = Orientation::of(&view);
        let cell = mesh.cells.get(0);
        (0..6)
            .filter(|&side| orientation.is_inward(&cell, side))
            .collect()
    }

    #[test]
    fn faces_of_a_polyhedron_that_turn_inward_are_found() {
        assert_eq!(inward(&cube(&[])), [0; 0]);
        assert_eq!(inward(&cube(&[0, 1, 2, 3, 4, 5])), [0, 1, 2, 3, 4, 5]);
        assert_eq!(inward(&cube(&[0, 3])), [0, 3]);
        assert_eq!(inward(&cube(&[0, 1, 2, 4])), [0, 1, 2, 4]);
    }

    #[test]
    fn a_folded_cell_turns_as_the_others_of_its_kind() {
        let mut mesh = Mesh::default();
        for i in 0..3 {
            let x = 3.0 * f64::from(i);
            let height = if i == 1 { -1.0 } else { 1.0 };
            mesh.points.extend([
                [x, 0.0, 0.0],
                [x + 1.0, 0.0, 0.0],
                [x, 1.0, 0.0],
                [x, 0.0, height],
            ]);
            let first = 4 * i as u32;
            let nodes: Vec<u32> = (first..first + 4).collect();
            mesh.cells.push(CellKind::Tetrahedron, &nodes);
        }
        let view = mesh.view();
        let orientation = Orientation::of(&view);
        assert!((0..3).all(|cell| !orientation.is_inward(&mesh.cells.get(cell), 0)));
    }
}

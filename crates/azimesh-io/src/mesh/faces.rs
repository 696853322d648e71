//! Finds the outer faces of a mesh and the boundary cells on them.
//!
//! A face of only one cell is an outer face. Cells of one dimension less, the boundary cells, are on outer faces, between
//! two cells, or on no face at all. Faces are identified by their corners.

use super::sides::{for_each_side, side, side_corners};
use super::walls::{face_on_side, wall};
use super::{CellKind, CellRef, Cells, Mesh, MeshView};
use azimesh_core::parallel::{map_blocks, sort_by_key};
use std::ops::Range;

/// Cells whose faces are compared among themselves first. Most neighbours of a cell are near it in
/// the file, so that few faces are left for the comparison of all.
const CHUNK: usize = 1 << 15;

/// A face of one cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct OuterFace {
    /// The cell.
    pub cell: u32,
    /// Index of its face.
    pub face: u32,
    /// Its first boundary cell; of a wall of no thickness the one on this side.
    pub boundary: Option<u32>,
}

/// The faces of a mesh by how many cells have them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Faces {
    /// Faces that one cell has, and both sides of walls of no thickness, in the order of the cells and their faces.
    pub outer: Vec<OuterFace>,
    /// Boundary cells between two cells, ascending.
    pub inside: Vec<u32>,
    /// Boundary cells of walls of no thickness, ascending.
    pub of_walls: Vec<u32>,
    /// Boundary cells on no face of a cell, ascending.
    pub dangling: Vec<u32>,
    /// Number of non-manifold faces: faces of more than two cells.
    pub n_non_manifold: usize,
}

/// A face of a cell, or a boundary cell, for comparison.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    /// The four smallest corners, ascending; `NONE` where there are fewer.
    corners: [u32; 4],
    pub cell: u32,
    /// Face of the cell (24 bits; all set for a boundary cell) and number of corners (8 bits, 255
    /// for more).
    face_and_size: u32,
}

const NONE: u32 = u32::MAX;
/// In place of the face of a boundary cell.
pub(super) const BOUNDARY: u32 = (1 << 24) - 1;

impl Entry {
    /// In place of a side that is no face.
    pub const COLLAPSED: Self = Self {
        corners: [NONE; 4],
        cell: NONE,
        face_and_size: 0,
    };

    /// `None` for a face that has collapsed to fewer corners than `least`.
    #[inline]
    pub fn new(corners: &[u32], least: usize, cell: usize, face: u32) -> Option<Self> {
        let mut smallest = match *corners {
            [a, b, c, d] => [a, b, c, d],
            [a, b, c] => [a, b, c, NONE],
            [a, b] => [a, b, NONE, NONE],
            _ => [NONE; 4],
        };
        let size = match corners.len() {
            n @ 2..=4 => {
                sort(&mut smallest);
                distinct(&mut smallest, n)
            }
            _ => {
                let all = sorted(corners);
                let n = all.len().min(4);
                smallest[..n].copy_from_slice(&all[..n]);
                all.len()
            }
        };
        (size >= least).then_some(Self {
            corners: smallest,
            cell: cell as u32,
            face_and_size: face.min(BOUNDARY) << 8 | size.min(255) as u32,
        })
    }

    #[inline]
    pub fn key(&self) -> (u128, u32) {
        let pair = |high: u32, low: u32| u128::from(high) << 32 | u128::from(low);
        let [a, b, c, d] = self.corners;
        (pair(a, b) << 64 | pair(c, d), self.size())
    }

    #[inline]
    pub fn smallest(&self) -> u32 {
        self.corners[0]
    }

    #[inline]
    pub fn size(&self) -> u32 {
        self.face_and_size & 255
    }

    #[inline]
    pub fn face(&self) -> u32 {
        self.face_and_size >> 8
    }

    #[inline]
    pub fn is_boundary(&self) -> bool {
        self.face() == BOUNDARY
    }

    #[inline]
    fn order(&self) -> ((u128, u32), u32, u32) {
        (self.key(), self.cell, self.face_and_size)
    }
}

/// Sorts four numbers, without branches and calls.
#[inline]
fn sort(numbers: &mut [u32; 4]) {
    for (i, j) in [(0, 1), (2, 3), (0, 2), (1, 3), (1, 2)] {
        let (a, b) = (numbers[i], numbers[j]);
        (numbers[i], numbers[j]) = (a.min(b), a.max(b));
    }
}

/// Removes repeated corners of an ascending list; gives how many are left.
#[inline]
fn distinct(corners: &mut [u32; 4], n: usize) -> usize {
    if (1..n).all(|i| corners[i] != corners[i - 1]) {
        return n;
    }
    let mut kept = 0;
    for i in 0..n {
        if i == 0 || corners[i] != corners[kept - 1] {
            corners[kept] = corners[i];
            kept += 1;
        }
    }
    corners[kept..].fill(NONE);
    kept
}

fn sorted(corners: &[u32]) -> Vec<u32> {
    let mut all = corners.to_vec();
    all.sort_unstable();
    all.dedup();
    all
}

impl Faces {
    /// The faces of all cells of the mesh's dimension.
    pub fn of(mesh: &Mesh) -> Self {
        Self::of_cells(mesh, |_| true)
    }

    /// The faces of those cells of the mesh's dimension that are `wanted`, as if there were no
    /// others. Of a face that three cells have, the third may be called an outer one.
    ///
    /// Time and memory grow with the number of cells; a mesh whose cells are unordered takes 24 bytes per face.
    pub fn of_cells(mesh: &Mesh, wanted: impl Fn(&CellRef<'_>) -> bool + Sync) -> Self {
        Self::of_view(&mesh.view(), wanted)
    }

    /// [`Faces::of_cells`] of a mesh that is written.
    pub fn of_view(mesh: &MeshView<'_>, wanted: impl Fn(&CellRef<'_>) -> bool + Sync) -> Self {
        let dimension = mesh.dimension();
        if dimension == 0 {
            return Self::default();
        }
        let mut entries = entries(mesh.cells, mesh.points.len(), dimension, wanted);
        let mut faces = Self::default();
        for_each_face(mesh.cells, &mut entries, |same| faces.add(mesh.cells, same));
        faces.outer.sort_unstable();
        faces.inside.sort_unstable();
        faces.of_walls.sort_unstable();
        faces.dangling.sort_unstable();
        faces
    }

    fn add(&mut self, cells: &Cells, same: &[Entry]) {
        let boundary = same.iter().filter(|entry| entry.is_boundary());
        let boundary = boundary.map(|entry| entry.cell);
        let sides: Vec<&Entry> = same.iter().filter(|entry| !entry.is_boundary()).collect();
        let wall = wall(cells, boundary.clone());
        let outer = |side: &Entry, boundary| OuterFace {
            cell: side.cell,
            face: side.face(),
            boundary,
        };
        match (&sides[..], wall) {
            ([], _) => self.dangling.extend(boundary),
            ([side], None) => self.outer.push(outer(side, boundary.min())),
            ([one, others @ ..], Some(wall)) if others.len() < 2 => {
                let cell = cells.get(one.cell as usize);
                let own = |corners: &[u32]| face_on_side(cells, wall, corners);
                let own = side_corners(cells, &cell, one.face() as usize, own);
                let across = wall.into_iter().find(|face| *face != own);
                self.outer.push(outer(one, Some(own)));
                for other in others {
                    self.outer.push(outer(other, across));
                    self.of_walls.extend(boundary.clone());
                }
            }
            (sides, _) => {
                self.n_non_manifold += usize::from(sides.len() > 2);
                self.inside.extend(boundary);
            }
        }
    }

    /// Boundary cells between two cells, walls among them, ascending.
    pub fn between(&self) -> Vec<u32> {
        let mut all = [&self.inside[..], &self.of_walls].concat();
        all.sort_unstable();
        all
    }

    /// Outer faces without a boundary cell.
    pub fn bare(&self) -> impl Iterator<Item = &OuterFace> {
        self.outer.iter().filter(|face| face.boundary.is_none())
    }
}

/// Boundary cells and faces of the `wanted` cells, sorted so that entries with the same smallest corners are
/// adjacent. Faces that two cells share may be left out if they cannot have a boundary cell.
pub(super) fn entries(
    cells: &Cells,
    n_points: usize,
    dimension: u8,
    wanted: impl Fn(&CellRef<'_>) -> bool + Sync,
) -> Vec<Entry> {
    let mut entries = boundary_cells(cells, dimension);
    let mut near_boundary = vec![false; n_points];
    for entry in &entries {
        near_boundary[entry.corners[0] as usize] = true;
    }
    let left = map_blocks(cells.len(), CHUNK, &|range| {
        unpaired(cells, range, dimension, &wanted, &near_boundary)
    });
    entries.reserve_exact(left.iter().map(Vec::len).sum());
    for part in left {
        entries.extend(part);
    }
    sort_by_key(&mut entries, Entry::order);
    entries
}

/// Cells of one dimension less than the mesh's.
pub(super) fn boundary_cells(cells: &Cells, dimension: u8) -> Vec<Entry> {
    let runs = cells.runs();
    let runs = runs.filter(|run| run.kind.dimension() + 1 == dimension);
    let entries = runs.flat_map(|run| {
        let n_corners = run.kind.n_corners(run.n_nodes);
        let of_cell =
            move |cell: CellRef| Entry::new(&cell.nodes[..n_corners], 1, cell.index, BOUNDARY);
        run.cell_refs().filter_map(of_cell)
    });
    entries.collect()
}

/// Faces with one cell only and with no corner but those that `is_in`, of the cells in a range that
/// have this dimension: kind and nodes, in the order of the cells. Faces whose nodes are not all
/// known are left out.
pub(crate) fn exterior_faces(
    cells: &Cells,
    range: Range<usize>,
    dimension: u8,
    is_in: impl Fn(u32) -> bool,
) -> Vec<(CellKind, Vec<u32>)> {
    let is_wanted = |corners: &[u32]| corners.iter().all(|&corner| is_in(corner));
    let mut entries = sides_of(cells, range, dimension, |_| true, is_wanted);
    let mut alone = Vec::new();
    for_each_face(cells, &mut entries, |same| {
        if let [face] = same {
            alone.push((face.cell, face.face()));
        }
    });
    alone.sort_unstable();
    let whole = |(cell, face)| side(cells, &cells.get(cell as usize), face as usize);
    alone.into_iter().filter_map(whole).collect()
}

/// Faces of a range of cells, without those that two of them share and no boundary cell can have.
fn unpaired(
    cells: &Cells,
    range: Range<usize>,
    dimension: u8,
    wanted: impl Fn(&CellRef<'_>) -> bool,
    near_boundary: &[bool],
) -> Vec<Entry> {
    let mut entries = sides_of(cells, range, dimension, wanted, |_| true);
    let mut left = Vec::new();
    for_each_face(cells, &mut entries, |same| {
        if same.len() != 2 || near_boundary[same[0].corners[0] as usize] {
            left.extend_from_slice(same);
        }
    });
    left
}

/// The faces of the `wanted` cells of a range that have this dimension, where `takes` takes their corners; sorted.
fn sides_of(
    cells: &Cells,
    range: Range<usize>,
    dimension: u8,
    wanted: impl Fn(&CellRef<'_>) -> bool,
    takes: impl Fn(&[u32]) -> bool,
) -> Vec<Entry> {
    let mut entries = Vec::new();
    let least = usize::from(dimension);
    let runs = cells.runs_in(range);
    for run in runs.filter(|run| run.kind.dimension() == dimension) {
        for cell in run.cell_refs().filter(&wanted) {
            for_each_side(cells, &cell, |face, corners| {
                if takes(corners) {
                    entries.extend(Entry::new(corners, least, cell.index, face as u32));
                }
            });
        }
    }
    entries.sort_unstable_by_key(Entry::order);
    entries
}

/// Visits the entries of each face. `entries` are sorted.
pub(super) fn for_each_face(cells: &Cells, entries: &mut [Entry], mut visit: impl FnMut(&[Entry])) {
    for alike in entries.chunk_by_mut(|a, b| a.key() == b.key()) {
        if alike.len() == 1 || alike[0].size() <= 4 {
            visit(alike);
            continue;
        }
        // Faces of many corners may differ in those beyond the smallest four.
        let mut whole: Vec<(Vec<u32>, Entry)> = alike
            .iter()
            .map(|entry| (all_corners(cells, entry), *entry))
            .collect();
        whole.sort_by(|a, b| a.0.cmp(&b.0));
        for same in whole.chunk_by(|a, b| a.0 == b.0) {
            visit(&same.iter().map(|(_, entry)| *entry).collect::<Vec<_>>());
        }
    }
}

pub(super) fn all_corners(cells: &Cells, entry: &Entry) -> Vec<u32> {
    let cell = cells.get(entry.cell as usize);
    if entry.is_boundary() {
        return sorted(&cell.nodes[..cell.kind.n_corners(cell.nodes.len())]);
    }
    side_corners(cells, &cell, entry.face() as usize, sorted)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(n_points: usize, cells: &[(CellKind, &[u32])]) -> Mesh {
        let mut mesh = Mesh::of_points(vec![[0.0; 3]; n_points]);
        for (kind, nodes) in cells {
            mesh.cells.push(*kind, nodes);
        }
        mesh
    }

    #[test]
    fn faces_of_one_cell_are_outer_and_know_what_lies_on_them() {
        let mesh = mesh(
            6,
            &[
                (CellKind::Tetrahedron, &[0, 1, 2, 3]),
                (CellKind::Tetrahedron, &[1, 2, 3, 4]),
                (CellKind::Triangle, &[2, 1, 0]),
                (CellKind::Triangle, &[3, 2, 1]),
                (CellKind::Triangle, &[0, 1, 5]),
            ],
        );
        let faces = Faces::of(&mesh);
        assert_eq!(faces.outer.len(), 6);
        assert_eq!(faces.bare().count(), 5);
        assert_eq!(faces.outer.iter().find_map(|face| face.boundary), Some(2));
        assert_eq!(
            (&faces.inside[..], &faces.dangling[..]),
            (&[3][..], &[4][..])
        );
        let alone = Faces::of_cells(&mesh, |cell| cell.index == 1);
        assert_eq!(alone.outer.len(), 4);
    }

    #[test]
    fn polygons_with_the_same_smallest_corners_are_told_apart() {
        let hexagon: &[u32] = &[0, 1, 2, 3, 4, 5];
        let other: &[u32] = &[0, 1, 2, 3, 4, 6];
        let mut mesh = mesh(
            7,
            &[(CellKind::Polygon, hexagon), (CellKind::Polygon, other)],
        );
        let face = |nodes: &[u32]| [&[1, 6], nodes].concat();
        for nodes in [hexagon, other, hexagon] {
            mesh.cells
                .push_polyhedron(&face(nodes))
                .expect("a good stream");
        }
        let faces = Faces::of(&mesh);
        assert_eq!((&faces.inside[..], faces.outer.len()), (&[0][..], 1));
        assert_eq!(faces.outer[0].boundary, Some(1));
    }

    #[test]
    fn a_collapsed_hexahedron_meets_the_wedge_beside_it() {
        let mesh = mesh(
            8,
            &[
                (CellKind::Hexahedron, &[0, 1, 2, 2, 3, 4, 5, 5]),
                (CellKind::Tetrahedron, &[0, 1, 2, 6]),
            ],
        );
        assert_eq!(Faces::of(&mesh).outer.len(), 4 + 3);
    }

    #[test]
    fn edges_of_plane_cells_are_their_faces() {
        let mesh = mesh(
            4,
            &[
                (CellKind::Triangle, &[0, 1, 2]),
                (CellKind::Polygon, &[0, 2, 3]),
                (CellKind::Line, &[2, 0]),
            ],
        );
        let faces = Faces::of(&mesh);
        assert_eq!((faces.outer.len(), &faces.inside[..]), (4, &[2][..]));
    }

    #[test]
    fn cells_of_third_order_and_polyhedra_have_faces_too() {
        let nodes: Vec<u32> = (0..20).collect();
        let mut cells = Cells::new();
        cells.push(CellKind::LagrangeTetrahedron, &nodes);
        let found = exterior_faces(&cells, 0..1, 3, |node| node < 3);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].0, CellKind::LagrangeTriangle);
        assert_eq!(found[0].1.len(), 10);

        // Two pyramids on a pentagon, which is between them.
        let mut cells = Cells::new();
        for apex in [5, 6] {
            let mut stream = vec![6, 5, 0, 1, 2, 3, 4];
            (0..5).for_each(|i| stream.extend([3, i, (i + 1) % 5, apex]));
            cells.push_polyhedron(&stream).expect("a good stream");
        }
        assert!(exterior_faces(&cells, 0..2, 3, |node| node < 5).is_empty());
        let found = exterior_faces(&cells, 0..1, 3, |node| node < 5);
        assert_eq!(found, [(CellKind::Polygon, vec![0, 1, 2, 3, 4])]);
    }
}

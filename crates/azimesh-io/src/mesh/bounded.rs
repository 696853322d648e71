//! The cell behind each boundary face, whose values in cell arrays the face can take.

use super::arrays::with_numbers;
use super::faces::{Entry, entries, for_each_face};
use super::sides::side_corners;
use super::walls::{face_on_side, wall};
use super::{CellRef, DataArray, Faces, Mesh, MeshView, NodeBits, Values};

/// Boundary faces between two or more cells of the mesh, ascending.
pub fn inner_faces(mesh: &MeshView<'_>) -> Vec<u32> {
    let dimension = mesh.dimension();
    let is_face = |run: &super::CellRun<'_>| run.kind.dimension() + 1 == dimension;
    let mut touched = vec![false; mesh.points.len()];
    for run in mesh.cells.runs().filter(is_face) {
        run.connectivity
            .iter()
            .for_each(|&node| touched[node as usize] = true);
    }
    let touches = |cell: &CellRef<'_>| cell.nodes.iter().any(|&node| touched[node as usize]);
    Faces::of_view(mesh, touches).inside
}

/// Finds the boundary faces, among some with ascending numbers, that are a side of no cell of the mesh. In a part all
/// numbers refer to the whole mesh. All ranks call it, with the same faces.
pub fn faces_on_no_cell(mesh: &Mesh, faces: &[u32]) -> Vec<u32> {
    let on_cells = faces_on_cells(mesh, faces, |_| true);
    let all = (0..).zip(faces);
    let loose = all.filter(|(at, _)| !on_cells.has(*at));
    loose.map(|(_, face)| *face).collect()
}

/// Finds the boundary faces, by their places among some, that are a side of a cell that is `wanted`; as
/// [`faces_on_no_cell`]. Cells that touch none of their nodes are passed over.
pub(super) fn faces_on_cells(
    mesh: &Mesh,
    faces: &[u32],
    wanted: impl Fn(u32) -> bool + Sync,
) -> NodeBits {
    let mut found = NodeBits::new(&(0..faces.len()));
    if faces.is_empty() {
        return found;
    }
    // Each rank holds all boundary faces of its own cells.
    let here = faces.iter().filter_map(|&face| mesh.cell_here(face));
    let here: Vec<u32> = here.collect();
    let mut touched = vec![false; mesh.points.len()];
    for &face in &here {
        let nodes = mesh.cells.get(face as usize).nodes;
        nodes.iter().for_each(|&node| touched[node as usize] = true);
    }
    let own = mesh.own_cells();
    let is_wanted = |cell: &CellRef<'_>| {
        own.contains(&cell.index)
            && cell.nodes.iter().any(|&node| touched[node as usize])
            && wanted(mesh.number_of_cell(cell.index as u32))
    };
    let dimension = mesh.dimension();
    let mut entries = entries(&mesh.cells, mesh.points.len(), dimension, is_wanted);
    for_each_face(&mesh.cells, &mut entries, |same| {
        if !same.iter().all(Entry::is_boundary) {
            let on_cell = same.iter().filter(|entry| entry.is_boundary());
            let numbers = on_cell.map(|entry| mesh.number_of_cell(entry.cell));
            let places = numbers.filter_map(|face| faces.binary_search(&face).ok());
            places.for_each(|at| found.add(&[at as u32]));
        }
    });
    found.unite(&mesh.ranks());
    found
}

/// The cell that each boundary face bounds: of a face between two cells the one that comes first in the mesh, of a wall of no
/// thickness the one on its side.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BoundedCells {
    /// Boundary face and cell, ascending; without faces on no cell.
    pairs: Vec<(u32, u32)>,
}

impl BoundedCells {
    /// Finds them for a mesh, in the time and memory of [`Faces::of`](super::Faces::of).
    pub fn of(mesh: &Mesh) -> Self {
        Self::of_view(&mesh.view())
    }

    /// Of a mesh that is to be written.
    pub fn of_view(mesh: &MeshView<'_>) -> Self {
        let dimension = mesh.dimension();
        let has_boundary = |run: super::CellRun<'_>| run.kind.dimension() + 1 == dimension;
        if !mesh.cells.runs().any(has_boundary) {
            return Self::default();
        }
        let mut entries = entries(mesh.cells, mesh.points.len(), dimension, |_| true);
        let mut pairs = Vec::new();
        for_each_face(mesh.cells, &mut entries, |same| {
            let mut sides = same.iter().filter(|entry| !entry.is_boundary());
            let Some(first) = sides.next() else {
                return;
            };
            let faces = same.iter().filter(|entry| entry.is_boundary());
            let faces = faces.map(|face| face.cell);
            pairs.extend(faces.clone().map(|face| (face, first.cell)));
            if let (Some(other), Some(wall)) = (sides.next(), wall(mesh.cells, faces.clone())) {
                let cell = mesh.cells.get(first.cell as usize);
                let own = |corners: &[u32]| face_on_side(mesh.cells, wall, corners);
                let own = side_corners(mesh.cells, &cell, first.face() as usize, own);
                let across = pairs.iter_mut().rev().take(faces.count());
                across
                    .filter(|(face, _)| *face != own && wall.contains(face))
                    .for_each(|pair| pair.1 = other.cell);
            }
        });
        pairs.sort_unstable();
        Self { pairs }
    }

    /// The cell that a boundary face bounds.
    pub fn cell_of(&self, face: usize) -> Option<usize> {
        let at = self
            .pairs
            .binary_search_by_key(&face, |(face, _)| *face as usize);
        at.ok().map(|at| self.pairs[at].1 as usize)
    }

    /// Gives every boundary face the values of the cell that it bounds.
    ///
    /// # Panics
    /// When the array has fewer tuples than the mesh cells.
    pub fn give_values(&self, array: &mut DataArray) {
        let n = array.n_components;
        with_numbers!(&mut array.values, v => self.copy(n, v), text => self.copy(n, text));
    }

    fn copy<T: Clone>(&self, n: usize, values: &mut [T]) {
        for &(face, cell) in &self.pairs {
            for i in 0..n {
                values[face as usize * n + i] = values[cell as usize * n + i].clone();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::CellKind;
    use super::*;

    /// Two tetrahedra; faces 2 outside, 3 between them, 4 on no cell, 5 the first again.
    fn mesh() -> Mesh {
        let mut mesh = Mesh::of_points(vec![[0.0; 3]; 6]);
        mesh.cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
        mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        for face in [[2, 1, 0], [3, 2, 1], [0, 1, 5], [0, 1, 2]] {
            mesh.cells.push(CellKind::Triangle, &face);
        }
        mesh.cells.push(CellKind::Line, &[0, 1]);
        mesh
    }

    #[test]
    fn every_face_knows_the_first_cell_that_it_bounds() {
        let bounded = BoundedCells::of(&mesh());
        let cells: Vec<_> = (0..7).map(|face| bounded.cell_of(face)).collect();
        assert_eq!(
            cells,
            [None, None, Some(1), Some(0), None, Some(1), None],
            "{bounded:?}"
        );
    }

    #[test]
    fn faces_between_cells_are_inner_ones() {
        assert_eq!(inner_faces(&mesh().view()), [3]);
    }

    #[test]
    fn faces_on_no_cell_are_found_among_those_that_are_asked_for() {
        assert_eq!(faces_on_no_cell(&mesh(), &[2, 3, 4, 5]), [4]);
        assert_eq!(faces_on_no_cell(&mesh(), &[2, 3]), [] as [u32; 0]);
    }

    #[test]
    fn values_of_any_type_go_from_a_cell_to_its_faces_and_nowhere_else() {
        let bounded = BoundedCells::of(&mesh());
        let numbers = Values::F32(vec![
            1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12., 13., 14.,
        ]);
        let mut vectors = DataArray::tuples("v", 2, numbers);
        bounded.give_values(&mut vectors);
        let wanted = vec![1., 2., 3., 4., 3., 4., 1., 2., 9., 10., 3., 4., 13., 14.];
        assert_eq!(vectors.values, Values::F32(wanted));
        let mut flags = DataArray::scalar("flag", Values::U8(vec![7, 9, 0, 0, 0, 0, 1]));
        bounded.give_values(&mut flags);
        assert_eq!(flags.values, Values::U8(vec![7, 9, 9, 7, 0, 9, 1]));
        let words = ["a", "b", "", "", "c", "", "d"].map(str::to_owned).to_vec();
        let mut words = DataArray::scalar("word", Values::Text(words));
        bounded.give_values(&mut words);
        let wanted = ["a", "b", "b", "a", "c", "b", "d"].map(str::to_owned);
        assert_eq!(words.values, Values::Text(wanted.to_vec()));
    }

    #[test]
    fn edges_bound_plane_cells_and_polygons_polyhedra() {
        let mut plane = Mesh::of_points(vec![[0.0; 3]; 4]);
        plane.cells.push(CellKind::Line, &[3, 2]);
        plane.cells.push(CellKind::Triangle, &[0, 1, 2]);
        plane.cells.push(CellKind::Polygon, &[0, 2, 3]);
        assert_eq!(BoundedCells::of(&plane).cell_of(0), Some(2));
        let mut solid = Mesh::of_points(vec![[0.0; 3]; 10]);
        let sides = (0..5).flat_map(|i| [4, i, (i + 1) % 5, 5 + (i + 1) % 5, 5 + i]);
        let stream = [7, 5, 0, 1, 2, 3, 4, 5, 9, 8, 7, 6, 5]
            .into_iter()
            .chain(sides);
        let stream: Vec<u32> = stream.collect();
        solid.cells.push_polyhedron(&stream).expect("a good stream");
        solid.cells.push(CellKind::Polygon, &[4, 3, 2, 1, 0]);
        assert_eq!(BoundedCells::of(&solid).cell_of(1), Some(0));
    }
}

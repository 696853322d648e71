//! Walls of no thickness: two boundary faces with the same nodes that turn against each other, one for each side. The cells
//! on both sides share these nodes, and the wall is between them: the face is an outer face of each. A boundary face without
//! such a partner does not separate cells.

use super::faces::{Entry, all_corners, boundary_cells};
use super::{Cells, MeshView};
use std::collections::BTreeMap;

/// The two faces of a wall: the first of some boundary faces with the same corners, and the first that turns against it.
pub(super) fn wall(cells: &Cells, faces: impl IntoIterator<Item = u32>) -> Option<[u32; 2]> {
    let mut faces = faces.into_iter();
    let one = faces.next()?;
    let turned = faces.find(|face| !is_same_way(corners(cells, *face), corners(cells, one)));
    turned.map(|other| [one, other])
}

/// The face of a wall on the side of a cell, whose own corners of the face are these: a boundary face turns like the side of
/// the cell that it bounds.
pub(super) fn face_on_side(cells: &Cells, wall: [u32; 2], own: &[u32]) -> u32 {
    let is_first = is_same_way(corners(cells, wall[0]), own);
    wall[usize::from(!is_first)]
}

fn corners(cells: &Cells, face: u32) -> &[u32] {
    let face = cells.get(face as usize);
    &face.nodes[..face.kind.n_corners(face.nodes.len())]
}

/// Returns whether the second list of the same corners goes round as the first, from whatever corner.
pub(super) fn is_same_way(corners: &[u32], others: &[u32]) -> bool {
    if let [from, _] = corners {
        return others.first() == Some(from);
    }
    let from = others.iter().position(|corner| *corner == corners[0]);
    let after = from.map(|at| others[(at + 1) % others.len()]);
    after.is_none_or(|after| after == corners[1])
}

/// Number of faces of walls of no thickness, each with its two sides.
pub fn n_walls(mesh: &MeshView<'_>) -> usize {
    Walls::of(mesh.cells, &boundary_cells(mesh.cells, mesh.dimension())).n()
}

/// The walls of a mesh, by the keys of their faces.
#[derive(Default)]
pub(super) struct Walls(BTreeMap<(u128, u32), Vec<[u32; 2]>>);

impl Walls {
    /// Finds them among the boundary cells of a mesh.
    pub fn of(cells: &Cells, boundary: &[Entry]) -> Self {
        let mut entries = boundary.to_vec();
        entries.sort_unstable_by_key(|entry| (entry.key(), entry.cell));
        let mut walls = Self::default();
        super::faces::for_each_face(cells, &mut entries, |same| {
            if same.len() > 1
                && let Some(wall) = wall(cells, same.iter().map(|entry| entry.cell))
            {
                walls.0.entry(same[0].key()).or_default().push(wall);
            }
        });
        walls
    }

    /// Number of walls.
    pub fn n(&self) -> usize {
        self.0.values().map(Vec::len).sum()
    }

    /// The wall that a side of a cell is on.
    #[inline]
    pub fn at(&self, cells: &Cells, side: &Entry) -> Option<[u32; 2]> {
        if self.0.is_empty() {
            return None;
        }
        let known = self.0.get(&side.key())?.iter();
        let is_it = |wall: &&[u32; 2]| {
            let mut own = corners(cells, wall[0]).to_vec();
            own.sort_unstable();
            own.dedup();
            side.size() <= 4 || own == all_corners(cells, side)
        };
        known.copied().find(|wall| is_it(&wall))
    }
}

#[cfg(test)]
mod tests {
    use crate::WriteOptions;
    use crate::mesh::{Adjacency, BoundedCells, CellKind, Faces, Group, Mesh, Plane, Reordering};
    use std::num::NonZeroUsize;

    /// Two cubes from x = 0 to 2, as polyhedra or not, with a plate of two faces between them, its sides `left` and `right`,
    /// and a tag `outlet`.
    fn plate(are_polyhedra: bool) -> Mesh {
        let point = |i: u32| [f64::from(i % 3), f64::from(i / 3 % 2), f64::from(i / 6)];
        let mut mesh = Mesh::of_points((0..12).map(point).collect());
        for x in 0..2 {
            let cube = [0, 1, 4, 3, 6, 7, 10, 9].map(|node| node + x);
            let sides = [
                [0, 4, 7, 3],
                [1, 2, 6, 5],
                [0, 1, 5, 4],
                [3, 7, 6, 2],
                [0, 3, 2, 1],
                [4, 5, 6, 7],
            ];
            let sides = sides
                .iter()
                .flat_map(|side| [4].into_iter().chain(side.map(|i| cube[i])));
            let stream: Vec<u32> = [6].into_iter().chain(sides).collect();
            match are_polyhedra {
                true => mesh.cells.push_polyhedron(&stream).expect("a good stream"),
                false => mesh.cells.push(CellKind::Hexahedron, &cube),
            }
        }
        // The first turns out of the left cube, the second out of the right one.
        let faces = [
            ("left", [1, 4, 10, 7]),
            ("right", [1, 7, 10, 4]),
            ("outlet", [2, 5, 11, 8]),
        ];
        for (at, (name, face)) in faces.into_iter().enumerate() {
            mesh.cells.push(CellKind::Quadrilateral, &face);
            mesh.groups
                .push(Group::new(2, name, None, [at + 2].into_iter().collect()));
        }
        mesh
    }

    /// The x of the middle of each cell at the plate, and the tag of its side; checks that all ways to find it agree.
    fn sides(mesh: &Mesh) -> Vec<(f64, String)> {
        mesh.validate().expect("a good mesh");
        assert_eq!(Adjacency::of(mesh).n_inner(), 0);
        let bounded = BoundedCells::of(mesh);
        let mut found = Vec::new();
        for face in Faces::of(mesh).outer {
            let Some(boundary) = face.boundary else {
                continue;
            };
            assert_eq!(bounded.cell_of(boundary as usize), Some(face.cell as usize));
            let nodes = mesh.cells.get(face.cell as usize).nodes;
            let x = nodes.iter().map(|node| mesh.points[*node as usize][0]);
            let mut tags = mesh.boundary_tags();
            let tag = tags.find(|tag| tag.cells.contains(boundary as usize));
            found.push((
                x.sum::<f64>() / nodes.len() as f64,
                tag.expect("it is in one").name.clone(),
            ));
        }
        found.retain(|(_, tag)| ["left", "right", "plate"].contains(&&**tag));
        found.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        found
    }

    fn expected() -> Vec<(f64, String)> {
        vec![(0.5, "left".to_owned()), (1.5, "right".to_owned())]
    }

    #[test]
    fn every_format_keeps_walls_without_thickness() {
        let folder = tempfile::tempdir().expect("a folder");
        let all = [
            "m.vtu",
            "m.pvtu",
            "m.vtk",
            "m.vtkhdf",
            "m.cgns",
            "m.msh",
            "m.su2",
            "m.b8.ugrid",
            "m.foam",
        ];
        for (are_polyhedra, names) in [(false, &all[..]), (true, &all[..5]), (true, &all[8..])] {
            let mesh = plate(are_polyhedra);
            assert_eq!(sides(&mesh), expected());
            for name in names {
                let path = folder.path().join(format!("{are_polyhedra}")).join(name);
                let options = WriteOptions {
                    pieces: NonZeroUsize::new(2).filter(|_| *name == "m.pvtu"),
                    ..WriteOptions::default()
                };
                std::fs::create_dir_all(path.parent().expect("it has one")).expect("a folder");
                mesh.view()
                    .write_with(&path, &options)
                    .expect("it is written");
                let read = Mesh::read(&path).expect("it is read");
                assert_eq!(sides(&read), expected(), "{name}");
            }
        }
    }

    #[test]
    fn every_change_of_a_mesh_keeps_walls_without_thickness() {
        let mut merged = plate(false);
        merged
            .merge_tags("plate", &["left", "right"])
            .expect("tags");
        let both = [0.5, 1.5].map(|x| (x, "plate".to_owned()));
        assert_eq!(sides(&merged), both);
        let mut reordered = plate(false);
        let order = Reordering::along_curve(&reordered);
        reordered.reorder(&order);
        assert_eq!(sides(&reordered), expected());
        let mut dropped = plate(false);
        dropped.drop_tags(&["outlet"]).expect("a tag");
        assert_eq!(sides(&dropped), expected());
        let mut mirrored = plate(true);
        let distance = mirrored.join_distance();
        mirrored
            .mirror(Plane { axis: 2, at: 0.0 }, None, distance)
            .expect("a half");
        assert_eq!(Adjacency::of(&mirrored).n_inner(), 2);
        assert_eq!(Faces::of(&mirrored).of_walls.len(), 4);
        let mut split = plate(true);
        split.split_polyhedra().expect("good polyhedra");
        let faces = Faces::of(&split);
        assert!(faces.of_walls.len() >= 2 && faces.inside.is_empty());
    }
}

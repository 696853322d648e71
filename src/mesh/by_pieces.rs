//! A mesh that one process reads piece by piece and never holds as a whole: what is asked for of its cells and nodes.

use super::from_slabs::{MeshByRanges, mesh_of, nodes_of, own_cells, own_points};
use super::node_bits::NodeBits;
use super::numbering::{Numbering, among};
use super::part::{self, SLAB};
use super::zone_sides::{ZoneSides, faces_between, faces_of_nodes, runs_of};
use super::{CellSet, Cells, faces_on_no_cell};
use crate::error::Result;
use crate::geometry::Bounds;
use crate::geometry::vector::Vector;
use crate::parallel;

/// Cells that are read at once.
const CELLS: usize = if cfg!(test) { 1 } else { 32 } * SLAB;
/// Nodes that are read at once.
const NODES: usize = if cfg!(test) { 1 << 12 } else { 1 << 20 };

impl MeshByRanges<'_> {
    /// Passes the cells, some at a time, with the number of the first of them.
    pub fn each_cells(&self, act: &mut dyn FnMut(usize, &Cells) -> Result<()>) -> Result<()> {
        for start in (0..self.n_cells).step_by(CELLS) {
            let cells = own_cells(self, start..self.n_cells.min(start + CELLS))?;
            act(start, &cells)?;
        }
        Ok(())
    }

    /// Passes the coordinates of the nodes, some at a time, with the number of the first of them.
    pub fn each_points(&self, act: &mut dyn FnMut(usize, &[Vector]) -> Result<()>) -> Result<()> {
        for start in (0..self.n_nodes).step_by(NODES) {
            let points = own_points(self, start..self.n_nodes.min(start + NODES))?;
            act(start, &points)?;
        }
        Ok(())
    }

    /// The sides of the volume cells of a solid mesh that are marked, as [`ZoneSides::of`] has them.
    pub fn zone_sides(&self, marked: &CellSet) -> Result<ZoneSides> {
        let [inside, outside] = [(); 2].map(|()| NodeBits::new(&(0..self.n_nodes)));
        self.each_cells(&mut |first, cells| {
            for (bits, side) in [(&inside, true), (&outside, false)] {
                let solid = cells.runs().filter(|run| run.kind.dimension() == 3);
                bits.add_nodes_of(cells, &runs_of(solid, first, marked, side));
            }
            Ok(())
        })?;
        let is_on = |node: &u32| inside.has(*node) && outside.has(*node);
        let (mut near, mut rim, mut rim_faces) = (Cells::new(), Cells::new(), Vec::new());
        let mut near_cells: Vec<u32> = Vec::new();
        self.each_cells(&mut |first, cells| {
            let of_rim = faces_of_nodes(cells, 3, is_on);
            rim.append(&cells.select(of_rim.iter().map(|&face| face as usize)));
            rim_faces.extend(of_rim.iter().map(|face| face + first as u32));
            let touching: Vec<usize> = parallel::concat_blocks(cells.len(), SLAB, &|range| {
                let touches = |cell: &usize| cells.get(*cell).nodes.iter().any(is_on);
                let touching = range.filter(touches);
                touching
                    .filter(|cell| marked.contains(first + cell))
                    .collect()
            });
            near_cells.extend(touching.iter().map(|cell| (first + cell) as u32));
            near.append(&cells.select(touching));
            Ok(())
        })?;
        let of_near = nodes_of(&near, 0..0);
        let numbering = Numbering::new(&of_near);
        near.renumber_nodes_by(|node| numbering.of(node));
        let origin = vec![[0.0; 3]; of_near.len()];
        let near = mesh_of(origin, near, 3, part::Part::default());
        let on_interface = |node: &u32| is_on(&of_near[*node as usize]);
        let (mut interface_faces, cells) = faces_between(&near, |_| true, on_interface);
        let interface_cells = cells.iter().map(|&cell| near_cells[cell as usize]);
        interface_faces.renumber_nodes_by(|node| of_near[node as usize]);
        let interface_nodes: Vec<u32> = of_near.iter().copied().filter(is_on).collect();
        let (mut bounds, mut interface_places) = (Bounds::EMPTY, Vec::new());
        self.each_points(&mut |first, points| {
            let here = (first as u32..).zip(points).filter(|of| inside.has(of.0));
            bounds = bounds.union(&Bounds::around(here.map(|of| of.1)));
            let on = among(&interface_nodes, &(first..first + points.len())).iter();
            interface_places.extend(on.map(|&node| points[node as usize - first]));
            Ok(())
        })?;
        let no_face_of =
            |side: bool| self.faces_on_no_cell(&rim, &|cell| marked.contains(cell) == side);
        if !rim_faces.is_empty() {
            let (off_marked, off_others) = (no_face_of(true)?, no_face_of(false)?);
            let is_rim = |at: usize| {
                off_marked.binary_search(&at).is_err() && off_others.binary_search(&at).is_ok()
            };
            rim_faces = (0..rim_faces.len())
                .filter(|&at| is_rim(at))
                .map(|at| rim_faces[at])
                .collect();
        }
        Ok(ZoneSides {
            nodes: inside,
            bounds,
            interface_places,
            interface_nodes,
            interface_faces,
            interface_cells: interface_cells.collect(),
            rim_faces,
        })
    }

    /// Those of some boundary faces, by their places among them, ascending, that are a side of none of the cells that are taken.
    pub fn faces_on_no_cell(
        &self,
        faces: &Cells,
        takes: &(dyn Fn(usize) -> bool + Sync),
    ) -> Result<Vec<usize>> {
        let at_faces = NodeBits::new(&(0..self.n_nodes));
        at_faces.add(&nodes_of(faces, 0..0));
        let mut loose: Vec<usize> = (0..faces.len()).collect();
        self.each_cells(&mut |first, cells| {
            let near = parallel::concat_blocks(cells.len(), SLAB, &|range| {
                let mut near = Vec::new();
                for run in cells.runs_in(range).filter(|run| run.kind.dimension() == 3) {
                    let touches = |nodes: &[u32]| nodes.iter().any(|&node| at_faces.has(node));
                    let cells = (run.first_cell..).zip(run.cells());
                    let touching = cells.filter(|of| touches(of.1)).map(|of| of.0);
                    near.extend(touching.filter(|cell| takes(first + cell)));
                }
                near
            });
            if near.is_empty() || loose.is_empty() {
                return Ok(());
            }
            let mut together = faces.select(loose.iter().copied());
            together.append(&cells.select(near));
            let nodes = nodes_of(&together, 0..0);
            let numbering = Numbering::new(&nodes);
            together.renumber_nodes_by(|node| numbering.of(node));
            let mesh = mesh_of(
                vec![[0.0; 3]; nodes.len()],
                together,
                3,
                part::Part::default(),
            );
            let left = faces_on_no_cell(&mesh, &(0..loose.len() as u32).collect::<Vec<_>>());
            loose = left.into_iter().map(|at| loose[at as usize]).collect();
            Ok(())
        })?;
        Ok(loose)
    }

    /// Where some nodes are, which ascend.
    pub fn places(&self, nodes: &[u32]) -> Result<Vec<Vector>> {
        let mut places = Vec::with_capacity(nodes.len());
        let mut rest = nodes;
        while let (Some(&first), Some(&last)) = (rest.first(), rest.last()) {
            let first = first as usize;
            let piece = first..(last as usize + 1).min(first + NODES);
            let here = among(rest, &piece);
            let end = here[here.len() - 1] as usize + 1;
            let points = own_points(self, first..end)?;
            places.extend(here.iter().map(|&node| points[node as usize - first]));
            rest = &rest[here.len()..];
        }
        Ok(places)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Apart, CellKind, Mesh, Numbers};
    use super::*;
    use crate::ranks::hash::HashedBytes;
    use std::path::Path;
    use std::sync::Arc;

    /// A cube of several pieces: tetrahedra, six to a small cube, or two wedges, and the triangles of its lower side.
    fn cube_of(kind: CellKind) -> Mesh {
        let n: u32 = if kind == CellKind::Wedge { 34 } else { 25 };
        let at = |i: u32, j: u32, k: u32| i + (n + 1) * (j + (n + 1) * k);
        let side = || 0..n;
        let mut mesh = Mesh::default();
        for k in 0..=n {
            for j in 0..=n {
                let x = |i: u32| [i, j, k].map(f64::from);
                mesh.points.extend((0..=n).map(x));
            }
        }
        let mut faces = Cells::new();
        for (k, j, i) in
            side().flat_map(|k| side().flat_map(move |j| side().map(move |i| (k, j, i))))
        {
            let [a, b, c, d] = [
                at(i, j, k),
                at(i + 1, j, k),
                at(i + 1, j + 1, k),
                at(i, j + 1, k),
            ];
            let up = (n + 1) * (n + 1);
            for [a, b, c] in [[a, b, c], [a, c, d]] {
                match kind {
                    CellKind::Wedge => mesh.cells.push(kind, &[a, b, c, a + up, b + up, c + up]),
                    _ => {
                        mesh.cells.push(kind, &[a, b, c, c + up]);
                        mesh.cells.push(kind, &[a, b, c + up, b + up]);
                        mesh.cells.push(kind, &[a, b + up, c + up, a + up]);
                    }
                }
                if k == 0 {
                    faces.push(CellKind::Triangle, &[a, c, b]);
                }
            }
        }
        mesh.cells.append(&faces);
        mesh
    }

    fn by_pieces<T>(mesh: &Mesh, act: impl FnOnce(&MeshByRanges) -> T) -> T {
        act(&MeshByRanges {
            n_nodes: mesh.points.len(),
            n_cells: mesh.cells.len(),
            space: mesh.space,
            points: &|nodes| Ok(mesh.points[nodes].to_vec()),
            cells: &|cells| Ok(mesh.cells.select(cells)),
        })
    }

    /// Nobody who writes.
    #[derive(Debug)]
    struct Nobody;

    impl Apart for Nobody {
        fn write(&self, _: Option<(&Path, u64)>, _: &Numbers, _: u64) -> Result<Vec<HashedBytes>> {
            unreachable!("nothing is written")
        }
    }

    #[test]
    fn an_outline_knows_the_boundary_and_where_all_ends() {
        let mesh = cube_of(CellKind::Wedge);
        let found = by_pieces(&mesh, |slabs| {
            Mesh::outline_by_pieces(slabs, false, Arc::new(Nobody))
        });
        let found = found.expect("an outline");
        assert_eq!(found.extent(), mesh.extent());
        assert_eq!(found.points.len(), mesh.points.len());
        let mut at_faces = vec![false; mesh.points.len()];
        for (own, whole) in found.cells.runs().zip(mesh.cells.runs()) {
            assert_eq!((own.kind, own.n_cells()), (whole.kind, whole.n_cells()));
            let is_face = own.kind.dimension() < 3;
            assert_eq!(own.connectivity == whole.connectivity, is_face);
            let faces = whole.connectivity.iter().filter(|_| is_face);
            faces.for_each(|&node| at_faces[node as usize] = true);
        }
        assert_eq!(found.cells.len(), mesh.cells.len());
        let known: Vec<u32> = (0..)
            .zip(&at_faces)
            .filter(|of| *of.1)
            .map(|of| of.0)
            .collect();
        for (slot, node) in known.iter().enumerate() {
            assert_eq!(found.slots().of(*node), slot);
            assert_eq!(found.place(*node), mesh.points[*node as usize]);
        }
        assert!(known.len() < mesh.points.len());
        // Others in any order, twice, and among those that are known.
        let mut found = found;
        let mut others: Vec<u32> = (0..mesh.points.len() as u32).rev().step_by(2).collect();
        others.push(others[0]);
        let places: Vec<Vector> = others
            .iter()
            .map(|&node| mesh.points[node as usize])
            .collect();
        found.take_places(&others, &places);
        for node in known.iter().chain(&others) {
            assert_eq!(found.place(*node), mesh.points[*node as usize]);
        }
        let plane = Mesh::read("testdata/naca0012.vtu").expect("a mesh");
        let refused = by_pieces(&plane, |slabs| {
            Mesh::outline_by_pieces(slabs, false, Arc::new(Nobody))
        });
        assert!(refused.is_err());
    }

    #[test]
    fn faces_that_the_whole_mesh_has_twice_are_refused_where_they_are_one() {
        let mut mesh = cube_of(CellKind::Tetrahedron);
        let face = mesh.cells.runs().find(|run| run.kind == CellKind::Triangle);
        let nodes = face.expect("it has faces").connectivity[..3].to_vec();
        let read = |mesh: &Mesh, once| {
            by_pieces(mesh, |slabs| {
                Mesh::outline_by_pieces(slabs, once, Arc::new(Nobody)).is_ok()
            })
        };
        assert!(read(&mesh, true));
        mesh.cells
            .push(CellKind::Triangle, &[nodes[1], nodes[2], nodes[0]]);
        assert!(read(&mesh, false) && !read(&mesh, true));
    }

    #[test]
    fn faces_on_no_cell_are_found_piece_by_piece() {
        let mut mesh = cube_of(CellKind::Tetrahedron);
        let n = mesh.points.len() as u32;
        let first = mesh.cells.len() as u32;
        mesh.cells.push(CellKind::Triangle, &[0, n / 2, n - 1]);
        mesh.cells.push(CellKind::Triangle, &[5, n / 3, n - 7]);
        let is_face = |cell: &u32| mesh.cells.get(*cell as usize).kind == CellKind::Triangle;
        let faces: Vec<u32> = (0..mesh.cells.len() as u32).filter(is_face).collect();
        let loose = |faces: &[u32], takes: &(dyn Fn(usize) -> bool + Sync)| {
            let alone = mesh.cells.select(faces.iter().map(|&face| face as usize));
            let found = by_pieces(&mesh, |slabs| slabs.faces_on_no_cell(&alone, takes));
            let found = found.expect("it is read").into_iter();
            found.map(|at| faces[at]).collect::<Vec<_>>()
        };
        assert_eq!(loose(&faces, &|_| true), [first, first + 1]);
        assert!(loose(&faces[..9], &|_| true).is_empty());
        assert_eq!(
            loose(&faces[..9], &|cell| cell > first as usize / 2),
            faces[..9]
        );
    }

    #[test]
    fn a_zone_has_the_sides_that_it_has_in_the_whole_mesh() {
        let at_random = |cell: usize| cell * 7 % 11 < 4;
        for kind in [CellKind::Tetrahedron, CellKind::Wedge] {
            let mesh = cube_of(kind);
            // Cells at random, then those of a few layers.
            for (zone, has_rim) in [
                (at_random as fn(usize) -> bool, true),
                (|cell| cell / 9000 == 1, false),
            ] {
                let is_solid = |cell: usize| mesh.cells.get(cell).kind == kind;
                let cells = 0..mesh.cells.len();
                let marked = cells.filter(|&cell| is_solid(cell) && zone(cell)).collect();
                let found = by_pieces(&mesh, |slabs| slabs.zone_sides(&marked));
                let wanted = ZoneSides::of(&mesh, &marked);
                assert!(wanted.interface_faces.len() > 100, "{kind:?}");
                assert_eq!(!wanted.rim_faces.is_empty(), has_rim, "{kind:?}");
                assert!(found.expect("they are read") == wanted, "{kind:?}");
            }
        }
    }

    #[test]
    fn places_of_nodes_are_those_of_the_mesh() {
        let mesh = cube_of(CellKind::Tetrahedron);
        let n = mesh.points.len() as u32;
        for nodes in [
            vec![],
            vec![n - 1],
            vec![0, 1, 7, n / 2, n - 2, n - 1],
            (0..n).collect(),
        ] {
            let found = by_pieces(&mesh, |slabs| slabs.places(&nodes)).expect("they are read");
            let wanted: Vec<Vector> = nodes
                .iter()
                .map(|&node| mesh.points[node as usize])
                .collect();
            assert_eq!(found, wanted);
        }
        let broken = MeshByRanges {
            points: &|nodes| Ok(vec![[f64::NAN; 3]; nodes.len()]),
            cells: &|cells| Ok(mesh.cells.select(cells)),
            n_nodes: mesh.points.len(),
            n_cells: mesh.cells.len(),
            space: None,
        };
        assert!(broken.places(&[3]).is_err());
    }
}

//! Values of nodes of the whole mesh, for the ranks that have its parts. All ranks call each function; a mesh that is no part is
//! the whole, and nothing is sent.

use super::{Mesh, NodeBits, among};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::ranks::raw::List;
use bytemuck::Pod;

impl Mesh {
    /// Gives the values of some nodes of the whole mesh, ascending, the same nodes on all ranks. `of` gives the value of an own node,
    /// by its place here.
    pub fn values_of_nodes<T: Pod>(&self, nodes: &[u32], of: impl Fn(usize) -> T) -> Vec<T> {
        let Some(part) = &self.part else {
            return nodes.iter().map(|&node| of(node as usize)).collect();
        };
        let own = &part.owners[part.ranks.rank()];
        let place = |node: u32| part.own_nodes.start + (node as usize - own.start);
        let values = among(nodes, own).iter().map(|&node| of(place(node)));
        let of_ranks = part.ranks.allgather(List(values.collect()));
        of_ranks
            .into_iter()
            .flat_map(|List(values)| values)
            .collect()
    }

    /// Gives the first rank the positions of all nodes, in their order. `own` has the positions of the own nodes.
    pub fn gather_nodes(&self, own: &[Vector]) -> Option<Vec<Vector>> {
        let Some(part) = &self.part else {
            return Some(own.to_vec());
        };
        if !part.ranks.is_first() {
            part.ranks.send_part(own);
            return None;
        }
        let mut whole = vec![[0.0; 3]; part.n_nodes];
        let mut parts = Vec::new();
        let mut rest = &mut whole[..];
        for owned in &part.owners {
            let (of_rank, others) = rest.split_at_mut(owned.len());
            parts.push(of_rank);
            rest = others;
        }
        parts[0].copy_from_slice(own);
        part.ranks.receive_parts(&mut parts);
        Some(whole)
    }

    /// Gives each rank the positions of all nodes that it has, own ones or not. The first rank has all, in their order.
    pub fn scatter_nodes(&self, whole: Option<&[Vector]>, out: &mut [Vector]) {
        let whole = whole.unwrap_or(&[]);
        let Some(part) = &self.part else {
            return out.copy_from_slice(whole);
        };
        let lengths = part.ranks.allgather(part.nodes.len());
        let mut others: Vec<Vec<u32>> = Vec::new();
        if part.ranks.is_first() {
            others.extend(lengths.iter().map(|&n| vec![0; n]));
            others[0].clone_from(&part.nodes);
            let mut lists: Vec<&mut [u32]> = others.iter_mut().map(|list| &mut list[..]).collect();
            part.ranks.receive_parts(&mut lists);
        } else {
            part.ranks.send_part(&part.nodes);
        }
        let of_rank = |rank: usize, out: &mut [Vector]| {
            for (out, &node) in out.iter_mut().zip(&others[rank]) {
                *out = whole[node as usize];
            }
        };
        part.ranks.scatter_into(&of_rank, out, &lengths);
    }

    /// The box around all nodes of the whole mesh.
    pub fn extent_of_all(&self) -> Bounds {
        self.united(Bounds::around(&self.points[self.own_nodes()]))
    }

    /// The box around the boxes of all ranks.
    pub(super) fn united(&self, own: Bounds) -> Bounds {
        let of_ranks = self.ranks().allgather(own).into_iter();
        of_ranks.fold(Bounds::EMPTY, |all, own| all.union(&own))
    }

    /// The nodes of all ranks, by their numbers in the whole mesh, from nodes here.
    pub(super) fn bits_of_all(&self, here: NodeBits) -> NodeBits {
        let Some(part) = &self.part else { return here };
        let mut all = NodeBits::new(&(0..part.n_nodes));
        let nodes = here.take().into_iter();
        let numbers: Vec<u32> = nodes.map(|node| part.nodes[node as usize]).collect();
        all.add(&numbers);
        all.unite(&part.ranks);
        all
    }
}

#[cfg(test)]
mod tests {
    use super::super::cubes::{cubes, shuffled};
    use super::super::{BoundedCells, CellSet, Doubled, Faces, Mesh, ZoneSides, faces_on_no_cell};
    use super::*;
    use azimesh_core::ranks::on_threads;
    use std::ops::Range;

    /// Runs `find` on each of `n` ranks with its part of the mesh.
    fn on_parts<T: Send>(mesh: &Mesh, n: usize, find: impl Fn(Mesh) -> T + Sync) -> Vec<T> {
        on_threads(n, |ranks| {
            find(Mesh::shared_of(ranks.is_first().then_some(mesh), &ranks))
        })
    }

    /// A mesh of three slabs with its nodes and cells in order and in none, each with numbers of ranks.
    fn meshes() -> [(Mesh, &'static [usize]); 2] {
        let mesh = cubes(40);
        assert!(mesh.cells.len() > 2 << 15, "there are three slabs");
        [(shuffled(&mesh), &[3]), (mesh, &[1, 2, 3, 5])]
    }

    fn boundary_faces(mesh: &Mesh) -> Vec<u32> {
        let tags = mesh.groups_of_all().iter();
        let tags = tags.filter(|group| group.dimension == 2);
        let mut faces: Vec<u32> = tags
            .flat_map(|tag| tag.cells.iter().map(|cell| cell as u32))
            .collect();
        faces.sort_unstable();
        faces
    }

    /// The bits of all numbers.
    fn bits(values: &[Vector]) -> Vec<u64> {
        values.iter().flatten().map(|x| x.to_bits()).collect()
    }

    /// Checks that a part has the nodes, cells and groups of the whole mesh that it should have; gives its own nodes and cells.
    fn own_of(part: &Mesh, whole: &Mesh) -> [Range<usize>; 2] {
        part.validate().expect("it is good");
        let known = part.part.as_ref().expect("it is a part");
        assert_eq!(part.n_nodes_of_all(), whole.points.len());
        assert_eq!(part.n_cells_of_all(), whole.cells.len());
        assert!(part.groups_of_all() == whole.groups);
        for node in 0..part.points.len() as u32 {
            let number = part.number_of_node(node);
            assert_eq!(part.node_here(number), Some(node));
            assert_eq!(part.points[node as usize], whole.points[number as usize]);
        }
        for cell in 0..part.cells.len() as u32 {
            let number = part.number_of_cell(cell);
            assert_eq!(part.cell_here(number), Some(cell));
            let [here, there] =
                [(part, cell), (whole, number)].map(|of| of.0.cells.get(of.1 as usize));
            let nodes = here.nodes.iter().map(|&node| part.number_of_node(node));
            assert!(here.kind == there.kind && nodes.eq(there.nodes.iter().copied()));
        }
        for (here, all) in part.groups.iter().zip(&whole.groups) {
            let numbers = here
                .cells
                .iter()
                .map(|cell| part.number_of_cell(cell as u32));
            assert!(
                numbers.eq((all.cells.iter().map(|cell| cell as u32))
                    .filter(|cell| part.cell_here(*cell).is_some()))
            );
        }
        let range = |own: Range<usize>, numbers: &[u32]| {
            let first = numbers.get(own.start).map_or(0, |first| *first as usize);
            let mut own_numbers = numbers[own].iter().map(|number| *number as usize);
            let end = own_numbers.next_back().map_or(first, |last| last + 1);
            first..end
        };
        let own_nodes = range(part.own_nodes(), &known.nodes);
        if !own_nodes.is_empty() {
            assert_eq!(own_nodes, known.owners[known.ranks.rank()]);
            assert!(part.owns_node(part.own_nodes().start as u32));
        }
        [own_nodes, range(part.own_cells(), &known.cells)]
    }

    /// Checks that each node and cell has one owner, and that ranks have what is around their own cells.
    fn are_parts_of(parts: &[Mesh], whole: &Mesh) {
        let owned: Vec<_> = parts.iter().map(|part| own_of(part, whole)).collect();
        for (kind, n) in [whole.points.len(), whole.cells.len()]
            .into_iter()
            .enumerate()
        {
            let own = owned.iter().map(|own| own[kind].clone());
            assert!(own.flatten().eq(0..n));
        }
        let faces = |mesh: &Mesh| {
            let own = mesh.own_cells();
            let outer = Faces::of(mesh).outer.into_iter();
            let outer = outer.filter(|face| own.contains(&(face.cell as usize)));
            let number = |cell: u32| mesh.number_of_cell(cell);
            let outer = outer.map(|of| (number(of.cell), of.face, of.boundary.map(number)));
            let bounded = BoundedCells::of(mesh);
            let bounded = own.clone().map(|face| {
                let cell = bounded.cell_of(face);
                (number(face as u32), cell.map(|cell| number(cell as u32)))
            });
            (outer.collect::<Vec<_>>(), bounded.collect::<Vec<_>>())
        };
        let of_parts = parts.iter().map(faces);
        let (outer, bounded): (Vec<_>, Vec<_>) = of_parts.unzip();
        assert!((outer.concat(), bounded.concat()) == faces(whole));
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "takes long without optimization")]
    fn parts_know_the_groups_of_the_whole_mesh_and_what_is_around_their_cells() {
        for (mesh, ranks) in meshes() {
            for &n in ranks {
                are_parts_of(&on_parts(&mesh, n, |part| part), &mesh);
            }
        }
    }

    #[test]
    fn values_of_nodes_come_from_their_owners_and_positions_go_to_all_who_have_the_node() {
        for (mesh, ranks) in meshes() {
            let n_nodes = mesh.points.len() as u32;
            let nodes: Vec<u32> = (0..n_nodes).filter(|node| node % 7 == 3).collect();
            let wanted = mesh.values_of_nodes(&nodes, |node| mesh.points[node]);
            let turned = |[x, y, z]: Vector| [y, z, x];
            let moved: Vec<Vector> = mesh.points.iter().map(|&point| turned(point)).collect();
            for &n in ranks {
                on_parts(&mesh, n, |part| {
                    let found = part.values_of_nodes(&nodes, |node| part.points[node]);
                    assert!(bits(&found) == bits(&wanted));
                    let extent = part.extent_of_all();
                    assert_eq!(extent, Bounds::around(&mesh.points));
                    let gathered = part.gather_nodes(&part.points[part.own_nodes()]);
                    let is_first = part.ranks().is_first();
                    assert_eq!(gathered.is_some(), is_first);
                    assert!(gathered.is_none_or(|all| bits(&all) == bits(&mesh.points)));
                    let mut out = vec![[0.0; 3]; part.points.len()];
                    part.scatter_nodes(is_first.then_some(&moved[..]), &mut out);
                    let here: Vec<Vector> = part.points.iter().map(|&at| turned(at)).collect();
                    assert!(bits(&out) == bits(&here));
                });
            }
        }
    }

    #[test]
    fn faces_on_no_cell_are_those_of_the_whole_mesh() {
        for (mesh, ranks) in meshes() {
            let faces = boundary_faces(&mesh);
            let wanted = faces_on_no_cell(&mesh, &faces);
            assert_eq!(wanted.len(), 2);
            for &n in ranks {
                for found in on_parts(&mesh, n, |part| faces_on_no_cell(&part, &faces)) {
                    assert_eq!(found, wanted);
                }
            }
        }
    }

    /// Cells of a zone, and cells spread over the mesh.
    fn marked(mesh: &Mesh) -> [CellSet; 2] {
        let solid =
            (0..mesh.cells.len()).filter(|&cell| mesh.cells.get(cell).kind.dimension() == 3);
        let spread = solid.filter(|cell| cell * 7 % 11 < 4).collect();
        [mesh.groups_of_all()[0].cells.clone(), spread]
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "takes long without optimization")]
    fn sides_of_zones_are_those_of_the_whole_mesh() {
        for (mesh, ranks) in meshes() {
            for (cells, has_rim) in marked(&mesh).into_iter().zip([false, true]) {
                let wanted = ZoneSides::of(&mesh, &cells);
                assert!(wanted.interface_faces.len() > 1000);
                assert_eq!(!wanted.rim_faces.is_empty(), has_rim);
                for &n in ranks {
                    let found = on_parts(&mesh, n, |part| ZoneSides::of(&part, &cells));
                    for found in found {
                        assert!(bits(&found.interface_places) == bits(&wanted.interface_places));
                        assert!(found == wanted);
                    }
                }
            }
        }
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "takes long without optimization")]
    fn parts_of_a_mesh_with_copies_of_nodes_are_parts_of_the_whole_mesh_with_them() {
        for (mesh, ranks) in meshes() {
            for (cells, ranks) in marked(&mesh).into_iter().zip([ranks, &[3]]) {
                let sides = ZoneSides::of(&mesh, &cells);
                let wanted = Doubled::between(&mesh, &cells, &sides, &[]).expect("there is room");
                let mut whole = mesh.clone();
                wanted.apply(&mut whole);
                for &n in ranks {
                    let parts = on_parts(&mesh, n, |mut part| {
                        let doubled = Doubled::between(&part, &cells, &sides, &[]);
                        let doubled = doubled.expect("there is room");
                        assert!(doubled == wanted);
                        doubled.apply(&mut part);
                        let faces = boundary_faces(&part);
                        assert_eq!(
                            faces_on_no_cell(&part, &faces),
                            faces_on_no_cell(&whole, &faces)
                        );
                        let all: Vec<u32> = (0..part.n_nodes_of_all() as u32).collect();
                        let found = part.values_of_nodes(&all, |node| part.points[node]);
                        assert!(bits(&found) == bits(&whole.points));
                        part
                    });
                    are_parts_of(&parts, &whole);
                }
            }
        }
    }
}

//! Copies of interface nodes for the cells of a zone, which then shares no node with the other cells and can turn against
//! them. Both sides of the interface get boundary faces with tags of their own.

use super::arrays::append_tuples;
use super::from_slabs::Owners;
use super::interface::{Interface, Neighbour, NewFaces};
use super::numbering::Numbering;
use super::zone_sides::ZoneSides;
use super::{CellRef, CellSet, Cells, Group, Mesh, RankPart};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::ranks::raw;
use azimesh_core::sparse;
use serde::{Deserialize, Serialize};

/// Nodes with copies, which follow all other nodes in the order of their originals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Doubled {
    /// Number of nodes of the mesh without copies.
    n_nodes: usize,
    /// The originals, ascending, and their positions.
    #[serde(with = "raw")]
    nodes: Vec<u32>,
    #[serde(with = "raw")]
    places: Vec<Vector>,
    /// The cells that have the copies.
    cells: CellSet,
    /// Number of cells of the mesh without added faces.
    n_cells: usize,
    /// Faces of both sides of the interface, which follow all other cells.
    faces: NewFaces,
    /// Groups that change, by their places, and those that are added.
    groups: Vec<(Option<usize>, Group)>,
}

impl Doubled {
    /// Doubles the nodes between the marked volume cells of a mesh and the others. Copies go to marked cells and to boundary
    /// faces that have a node inside or belong to marked cells alone. All numbers refer to the whole mesh. All ranks that have
    /// parts of it call this and get the same result.
    ///
    /// # Errors
    /// If there would be too many nodes.
    pub fn between(
        mesh: &Mesh,
        marked: &CellSet,
        sides: &ZoneSides,
        neighbours: &[Neighbour<'_>],
    ) -> Result<Self> {
        let n_nodes = mesh.n_nodes_of_all();
        if n_nodes + sides.interface_nodes.len() > u32::MAX as usize {
            return Err(Error::input(
                "the mesh would have more than 4294967295 nodes",
            ));
        }
        let interface = Numbering::new(&sides.interface_nodes);
        let number = |node: &u32| mesh.number_of_node(*node);
        let is_inside = |nodes: &[u32]| {
            let mut numbers = nodes.iter().map(number);
            numbers.clone().all(|node| sides.nodes.has(node))
                && numbers.any(|node| interface.place(node).is_none())
        };
        let dimension = mesh.dimension();
        let first = mesh.own_offset();
        let mut own = CellSet::new();
        let goes = |cell: &CellRef<'_>| {
            let face = (first + cell.index) as u32;
            is_inside(cell.nodes) || sides.rim_faces.binary_search(&face).is_ok()
        };
        for run in mesh.cells.runs_in(mesh.own_cells()) {
            if run.kind.dimension() < dimension {
                let faces = run.cell_refs().filter(goes);
                faces.for_each(|face| own.push(first + face.index));
                continue;
            }
            let start = first + run.first_cell;
            let marked = marked.ranges_in(start..start + run.n_cells());
            marked.for_each(|range| own.push_range(range));
        }
        let mut cells = CellSet::new();
        for of_rank in mesh.ranks().allgather(own) {
            of_rank.ranges().for_each(|range| cells.push_range(range));
        }
        let mut doubled = Self {
            n_nodes,
            nodes: sides.interface_nodes.clone(),
            places: sides.interface_places.clone(),
            cells,
            n_cells: mesh.n_cells_of_all(),
            faces: NewFaces::default(),
            groups: Vec::new(),
        };
        let interface = Interface::of(mesh, marked, sides, neighbours);
        (doubled.faces, doubled.groups) = interface.tagged(doubled.copies());
        Ok(doubled)
    }

    /// Number of cells with the added faces.
    pub fn n_cells(&self) -> usize {
        self.n_cells + self.faces.cells.len()
    }

    /// Number of nodes with the copies.
    pub fn n_nodes(&self) -> usize {
        self.n_nodes + self.nodes.len()
    }

    /// Maps a node to its copy, or to itself if it has none.
    pub fn copies(&self) -> impl Fn(u32) -> u32 + Sync {
        let numbering = Numbering::new(&self.nodes);
        move |node| match numbering.place(node) {
            Some(at) => (self.n_nodes + at) as u32,
            None => node,
        }
    }

    /// Replaces nodes by their copies in consecutive cells of the mesh, which start at the number `first`.
    pub fn give(&self, cells: &mut Cells, first: usize) {
        let copy = self.copies();
        for range in self.cells.ranges_in(first..first + cells.len()) {
            cells.renumber_nodes_of(range.start - first..range.end - first, &copy);
        }
    }

    /// Gives a mesh the copies. The last rank owns the copies and the new faces; all ranks that
    /// have parts of the mesh call it.
    pub fn apply(&self, mesh: &mut Mesh) {
        if let Some(part) = mesh.part.take() {
            self.apply_to_part(mesh, &part);
            return;
        }
        self.add_copies_to_arrays(mesh);
        self.give(&mut mesh.cells, 0);
        mesh.points.extend_from_slice(&self.places);
        self.add_faces(mesh);
    }

    /// Extends the layout of a mesh by the copies and the new faces.
    pub fn apply_to_layout(&self, layout: &mut Mesh) {
        layout.points = sparse::zeros(self.n_nodes(), [0.0; 3]);
        self.add_copies_to_arrays(layout);
        self.add_faces(layout);
    }

    fn add_copies_to_arrays(&self, mesh: &mut Mesh) {
        let nodes: Vec<usize> = self.nodes.iter().map(|node| *node as usize).collect();
        append_tuples(&mut mesh.point_arrays, &nodes);
    }

    /// Makes a part again from its own cells, which have other neighbours now. It has no arrays.
    fn apply_to_part(&self, mesh: &mut Mesh, part: &RankPart) {
        let (ranks, dimension) = (&part.ranks, mesh.dimension());
        let all = std::mem::take(&mut mesh.cells);
        let mut cells = all.select(part.own_cells.clone());
        drop(all);
        cells.renumber_nodes_by(|node| part.nodes[node as usize]);
        let numbers = &part.cells[part.own_cells.clone()];
        let first = numbers.first().map_or(0, |first| *first as usize);
        self.give(&mut cells, first);
        let mut points = mesh.points[part.own_nodes.clone()].to_vec();
        let mut owners = part.owners.clone();
        if let Some(last) = owners.last_mut() {
            last.end = self.n_nodes();
        }
        if ranks.rank() + 1 == ranks.n() {
            points.extend_from_slice(&self.places);
            cells.append(&self.faces.cells);
        }
        let own = first..first + cells.len();
        let owners = Owners::new(owners, ranks);
        *mesh = owners.mesh(points, cells, own, dimension, self.n_cells());
        let mut groups = part.groups.clone();
        self.change(&mut groups);
        mesh.set_whole_groups(groups);
    }

    /// Changes the groups of the whole mesh and adds new ones.
    fn change(&self, groups: &mut Vec<Group>) {
        for (at, group) in &self.groups {
            match at {
                Some(at) => groups[*at] = group.clone(),
                None => groups.push(group.clone()),
            }
        }
    }

    /// Adds the faces of the interface, with the values of the marked cells that they bound, and their tags.
    fn add_faces(&self, mesh: &mut Mesh) {
        mesh.cells.append(&self.faces.cells);
        let bounded: Vec<usize> = self
            .faces
            .bounded
            .iter()
            .map(|cell| *cell as usize)
            .collect();
        append_tuples(&mut mesh.cell_arrays, &bounded);
        self.change(&mut mesh.groups);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellKind, DataArray, Values};

    /// Two cubes on one another, `rotor` below `stator`, with two faces of `wall` below and, where `tagged`, one of `itf` between them.
    fn cubes(tagged: bool) -> Mesh {
        let mut mesh = Mesh::default();
        for z in [0.0, 1.0, 2.0] {
            let corners = [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
            mesh.points.extend(corners);
        }
        for first in [0, 4] {
            let nodes: Vec<u32> = (first..first + 8).collect();
            mesh.cells.push(CellKind::Hexahedron, &nodes);
        }
        for face in [[0, 1, 2, 3], [0, 3, 7, 4]] {
            mesh.cells.push(CellKind::Quadrilateral, &face);
        }
        let between = [5, 4, 7, 6];
        let mut group = |dimension: u8, name: &str, cells: &[usize]| {
            mesh.groups.push(Group::new(
                dimension,
                name,
                Some(7),
                cells.iter().copied().collect(),
            ));
        };
        group(3, "rotor", &[0]);
        group(3, "stator", &[1]);
        group(2, "wall", &[2, 3]);
        if tagged {
            group(2, "itf", &[4]);
            mesh.cells.push(CellKind::Quadrilateral, &between);
        }
        let numbers = (0..mesh.cells.len() as i32).collect();
        mesh.cell_arrays = vec![DataArray::scalar("number", Values::I32(numbers))];
        mesh.validate().expect("it is good");
        mesh
    }

    fn doubled(mut mesh: Mesh) -> Mesh {
        let marked = [0].into_iter().collect();
        let sides = ZoneSides::of(&mesh, &marked);
        let doubled = Doubled::between(&mesh, &marked, &sides, &[]).expect("there is room");
        doubled.apply(&mut mesh);
        assert_eq!(mesh.cells.len(), doubled.n_cells());
        assert_eq!(mesh.points.len(), doubled.n_nodes());
        mesh.validate().expect("it is good");
        mesh
    }

    /// Nodes of the faces of a tag, each face ascending.
    fn faces(mesh: &Mesh, tag: &str) -> Vec<Vec<u32>> {
        let group = mesh.groups.iter().find(|group| group.name == tag);
        let cells = group.expect("it is there").cells.iter();
        let nodes = |cell: usize| {
            let mut nodes = mesh.cells.get(cell).nodes.to_vec();
            nodes.sort_unstable();
            nodes
        };
        cells.map(nodes).collect()
    }

    #[test]
    fn each_side_of_an_interface_has_a_tag_of_its_own() {
        let mesh = doubled(cubes(true));
        let names: Vec<&str> = mesh
            .groups
            .iter()
            .map(|group| group.name.as_str())
            .collect();
        assert_eq!(
            names,
            ["rotor", "stator", "wall", "itf_stator", "itf_rotor"]
        );
        assert_eq!(faces(&mesh, "itf_rotor"), [[12, 13, 14, 15]]);
        assert_eq!(faces(&mesh, "itf_stator"), [[4, 5, 6, 7]]);
        assert_eq!(
            mesh.cell_arrays[0].values,
            Values::I32(vec![0, 1, 2, 3, 4, 0])
        );
    }

    #[test]
    fn an_interface_without_a_tag_gets_two() {
        let mesh = doubled(cubes(false));
        assert_eq!(faces(&mesh, "inner_interface"), [[12, 13, 14, 15]]);
        assert_eq!(faces(&mesh, "outer_interface"), [[4, 5, 6, 7]]);
        assert_eq!(mesh.cells.len(), 6);
    }

    #[test]
    fn a_tag_that_is_partly_on_the_interface_keeps_the_rest() {
        let mut mesh = cubes(true);
        mesh.groups[3].cells = [3, 4].into_iter().collect();
        mesh.groups[2].cells = [2].into_iter().collect();
        mesh.groups[2].name = "itf_rotor".into();
        let mesh = doubled(mesh);
        assert_eq!(mesh.groups[3].cells.iter().collect::<Vec<_>>(), [3]);
        assert_eq!(faces(&mesh, "itf_rotor_2"), [[12, 13, 14, 15]]);
        assert_eq!(faces(&mesh, "itf_stator"), [[4, 5, 6, 7]]);
    }
}

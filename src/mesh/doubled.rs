//! Nodes of a mesh of which some cells get copies, so that these cells share no node with the others: what a zone needs to turn
//! against the rest. Both sides of the interface get boundary faces with tags of their own.

use super::interface::{Interface, NewFaces};
use super::numbering::Numbering;
use super::zone_sides::ZoneSides;
use super::{CellRef, CellSet, Cells, Group, Mesh};
use crate::error::{Error, Result};
use crate::geometry::vector::Vector;
use crate::ranks::raw;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Nodes with copies, which follow all other nodes in the order of their originals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Doubled {
    /// How many nodes the mesh has without copies.
    n_nodes: usize,
    /// The originals, ascending, and where they are.
    #[serde(with = "raw")]
    nodes: Vec<u32>,
    #[serde(with = "raw")]
    places: Vec<Vector>,
    /// The cells that have the copies.
    cells: CellSet,
    /// How many cells the mesh has without the faces that are added.
    n_cells: usize,
    /// Faces of both sides of the interface, which follow all other cells.
    faces: NewFaces,
    /// Groups that change, by their places, and those that are added.
    groups: Vec<(Option<usize>, Group)>,
}

impl Doubled {
    /// The nodes between the volume cells of a mesh that are marked and the others. Marked cells get the copies, and so do boundary
    /// faces that have a node inside or lie on marked cells alone.
    ///
    /// # Errors
    /// Where there would be too many nodes.
    pub fn between(mesh: &Mesh, marked: &CellSet, sides: &ZoneSides) -> Result<Self> {
        let n_nodes = mesh.points.len();
        if n_nodes + sides.interface_nodes.len() > u32::MAX as usize {
            return Err(Error::input(
                "the mesh would have more than 4294967295 nodes",
            ));
        }
        let interface = Numbering::new(&sides.interface_nodes);
        let is_inside = |nodes: &[u32]| {
            nodes.iter().all(|&node| sides.nodes.has(node))
                && nodes.iter().any(|&node| interface.place(node).is_none())
        };
        let dimension = mesh.dimension();
        let mut cells = CellSet::new();
        let goes = |cell: &CellRef<'_>| {
            let is_on_rim = || sides.rim_faces.binary_search(&(cell.index as u32)).is_ok();
            is_inside(cell.nodes) || is_on_rim()
        };
        for run in mesh.cells.runs() {
            // An outline does not know the nodes of volume cells.
            if run.kind.dimension() < dimension {
                let faces = run.cell_refs().filter(goes);
                faces.for_each(|face| cells.push(face.index));
                continue;
            }
            let own = run.first_cell..run.first_cell + run.n_cells();
            marked
                .ranges_in(own)
                .for_each(|range| cells.push_range(range));
        }
        let mut doubled = Self {
            n_nodes,
            nodes: sides.interface_nodes.clone(),
            places: sides.interface_places.clone(),
            cells,
            n_cells: mesh.cells.len(),
            faces: NewFaces::default(),
            groups: Vec::new(),
        };
        let interface = Interface::of(mesh, marked, sides);
        (doubled.faces, doubled.groups) = interface.tagged(doubled.copies());
        Ok(doubled)
    }

    /// How many cells there are with the faces that are added.
    pub fn n_cells(&self) -> usize {
        self.n_cells + self.faces.cells.len()
    }

    /// The faces of some cells that are added.
    pub fn faces_among(&self, cells: &Range<usize>) -> Cells {
        let place = |cell: usize| cell.saturating_sub(self.n_cells);
        self.faces
            .cells
            .select(place(cells.start)..place(cells.end))
    }

    /// How many nodes there are with the copies.
    pub fn n_nodes(&self) -> usize {
        self.n_nodes + self.nodes.len()
    }

    /// Gives the number of the copy of a node, or that of the node where it has none.
    pub fn copies(&self) -> impl Fn(u32) -> u32 + Sync {
        let numbering = Numbering::new(&self.nodes);
        move |node| match numbering.place(node) {
            Some(at) => (self.n_nodes + at) as u32,
            None => node,
        }
    }

    /// Where the copies are that are among some nodes.
    pub fn places(&self, nodes: &Range<usize>) -> &[Vector] {
        let place = |node: usize| node.saturating_sub(self.n_nodes).min(self.places.len());
        &self.places[place(nodes.start)..place(nodes.end)]
    }

    /// Gives consecutive cells of the mesh, of which the first has the number `first`, their copies.
    pub fn give(&self, cells: &mut Cells, first: usize) {
        let copy = self.copies();
        for range in self.cells.ranges_in(first..first + cells.len()) {
            cells.renumber_nodes_of(range.start - first..range.end - first, &copy);
        }
    }

    /// Gives a whole mesh the copies, or an outline those that it knows of.
    pub fn apply(&self, mesh: &mut Mesh) {
        let nodes: Vec<usize> = self.nodes.iter().map(|node| *node as usize).collect();
        for array in &mut mesh.point_arrays {
            let copies = array.values.select(array.n_components, &nodes);
            array.values.append(&copies);
        }
        if mesh.outline.is_none() {
            self.give(&mut mesh.cells, 0);
            mesh.points.extend_from_slice(&self.places);
            self.add_faces(mesh);
            return;
        }
        mesh.add_unknown_nodes(self.nodes.len());
        mesh.take_places(&self.nodes, &self.places);
        let copies: Vec<u32> = (self.n_nodes as u32..self.n_nodes() as u32).collect();
        mesh.take_places(&copies, &self.places);
        let dimension = mesh.dimension();
        let runs = mesh.cells.runs();
        let faces = runs.filter(|run| run.kind.dimension() < dimension);
        let faces: Vec<Range<usize>> = faces
            .map(|run| run.first_cell..run.first_cell + run.n_cells())
            .collect();
        let copy = self.copies();
        for range in faces.into_iter().flat_map(|run| self.cells.ranges_in(run)) {
            mesh.cells.renumber_nodes_of(range, &copy);
        }
        self.add_faces(mesh);
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
        for array in &mut mesh.cell_arrays {
            let values = array.values.select(array.n_components, &bounded);
            array.values.append(&values);
        }
        for (at, group) in &self.groups {
            match at {
                Some(at) => mesh.groups[*at] = group.clone(),
                None => mesh.groups.push(group.clone()),
            }
        }
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
            mesh.groups.push(Group {
                dimension,
                name: name.into(),
                number: Some(7),
                condition: None,
                cells: cells.iter().copied().collect(),
            });
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
        let doubled = Doubled::between(&mesh, &marked, &sides).expect("there is room");
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

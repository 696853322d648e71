//! Boundary faces and tags for both sides of the interface of a zone that is cut from the rest of a mesh.

use super::groups::zones;
use super::numbering::Numbering;
use super::zone_sides::{ZoneSides, own_faces_of_nodes};
use super::{CellSet, Cells, Group, Mesh};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Names of both sides of an interface: for faces without a tag, and for sides of several zones.
const SIDES: [&str; 2] = ["inner", "outer"];

/// Boundary faces that are added to a mesh.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct NewFaces {
    pub cells: Cells,
    /// The marked cell at each of them.
    pub bounded: Vec<u32>,
}

/// The faces between the marked cells of a mesh and the others, with the boundary faces that are there already.
pub(super) struct Interface<'a> {
    mesh: &'a Mesh,
    sides: &'a ZoneSides,
    /// Places among the interface faces of those that both sides have.
    faces: Vec<usize>,
    /// The boundary face of the mesh at each of them.
    there: Vec<Option<u32>>,
    /// Names of the marked cells and of the others.
    names: [String; 2],
}

impl<'a> Interface<'a> {
    /// Of the marked volume cells, which have these sides. Curved cells have no faces here: a face of corners would not be a side of
    /// them.
    pub fn of(mesh: &'a Mesh, marked: &CellSet, sides: &'a ZoneSides) -> Self {
        let ranks = mesh.ranks();
        let is_curved = mesh.volume_runs().any(|run| run.kind.is_curved());
        let is_curved = ranks.allgather(is_curved).contains(&true);
        let key = |mut key: Vec<u32>| {
            key.sort_unstable();
            key
        };
        let on_interface = Numbering::new(&sides.interface_nodes);
        let number = |node: &u32| mesh.number_of_node(*node);
        let is_on = |node: &u32| on_interface.place(number(node)).is_some();
        let keyed = |face: u32| {
            let nodes = mesh.cells.get(face as usize).nodes.iter();
            (key(nodes.map(number).collect()), mesh.number_of_cell(face))
        };
        let own: Vec<(Vec<u32>, u32)> = own_faces_of_nodes(mesh, is_on)
            .into_iter()
            .map(keyed)
            .collect();
        let mut there: BTreeMap<Vec<u32>, u32> = BTreeMap::new();
        for (key, face) in ranks.allgather(own).into_iter().flatten() {
            there.entry(key).or_insert(face);
        }
        // Sides of the mesh whose nodes are all on the interface are not between two cells.
        let is_inner = |face: &Option<u32>| {
            face.is_none_or(|face| sides.rim_faces.binary_search(&face).is_err())
        };
        let all = (0..sides.interface_faces.len()).filter(|_| !is_curved);
        let found = all.map(|at| {
            (
                at,
                there
                    .get(&key(sides.interface_faces.get(at).nodes.to_vec()))
                    .copied(),
            )
        });
        let (faces, there) = found.filter(|(_, face)| is_inner(face)).unzip();
        Self {
            names: names(mesh, marked),
            mesh,
            sides,
            faces,
            there,
        }
    }

    /// The faces to add, with `copy` of the nodes on the side of the marked cells, and the groups that change or are added: a tag on the
    /// interface becomes two, and faces without a tag get two.
    pub fn tagged(&self, copy: impl Fn(u32) -> u32) -> (NewFaces, Vec<(Option<usize>, Group)>) {
        let mut new = NewFaces::default();
        let first = self.mesh.n_cells_of_all();
        let mut add = |nodes: &[u32], at: usize| {
            let kind = self.sides.interface_faces.get(self.faces[at]).kind;
            new.cells.push(kind, nodes);
            new.bounded.push(self.sides.interface_cells[self.faces[at]]);
            first + new.cells.len() - 1
        };
        let nodes = |at: usize| self.sides.interface_faces.get(self.faces[at]).nodes;
        let all = 0..self.faces.len();
        let inner: Vec<usize> = all
            .clone()
            .map(|at| {
                add(
                    &nodes(at)
                        .iter()
                        .map(|&node| copy(node))
                        .collect::<Vec<u32>>(),
                    at,
                )
            })
            .collect();
        let outer = all.map(|at| match self.there[at] {
            Some(face) => face as usize,
            None => add(&nodes(at).iter().rev().copied().collect::<Vec<u32>>(), at),
        });
        let outer: Vec<usize> = outer.collect();
        let groups = self.groups(&inner, &outer);
        (new, groups)
    }

    fn groups(&self, inner: &[usize], outer: &[usize]) -> Vec<(Option<usize>, Group)> {
        let dimension = self.mesh.dimension().saturating_sub(1);
        let mut taken: BTreeSet<String> = self
            .mesh
            .groups_of_all()
            .iter()
            .map(|group| group.name.clone())
            .collect();
        let mut is_tagged = vec![false; outer.len()];
        let (mut changed, mut added) = (Vec::new(), Vec::new());
        let groups = self.mesh.groups_of_all().iter().enumerate();
        for (at, group) in groups.filter(|(_, group)| group.dimension == dimension) {
            let own = (0..outer.len())
                .filter(|&face| self.there[face].is_some() && group.cells.contains(outer[face]));
            let own: Vec<usize> = own.collect();
            if own.is_empty() {
                continue;
            }
            own.iter().for_each(|&face| is_tagged[face] = true);
            let of = |name: &str, cells: &[usize], taken: &mut BTreeSet<String>| Group {
                name: free_name(&format!("{}_{name}", group.name), taken),
                number: None,
                cells: own.iter().map(|&face| cells[face]).collect(),
                ..group.clone()
            };
            let sides = [
                of(&self.names[0], inner, &mut taken),
                of(&self.names[1], outer, &mut taken),
            ];
            let [inside, outside] = sides;
            added.push((None, inside));
            if outside.cells.len() == group.cells.len() {
                changed.push((
                    Some(at),
                    Group {
                        number: group.number,
                        ..outside
                    },
                ));
            } else {
                let rest = group
                    .cells
                    .iter()
                    .filter(|cell| !outside.cells.contains(*cell))
                    .collect();
                changed.push((
                    Some(at),
                    Group {
                        cells: rest,
                        ..group.clone()
                    },
                ));
                added.push((None, outside));
            }
        }
        for (side, cells) in SIDES.iter().zip([inner, outer]) {
            let untagged = (0..outer.len()).filter(|&face| !is_tagged[face]);
            let cells: CellSet = untagged.map(|face| cells[face]).collect();
            if !cells.is_empty() {
                let name = free_name(&format!("{side}_interface"), &mut taken);
                added.push((
                    None,
                    Group {
                        dimension,
                        name,
                        number: None,
                        condition: None,
                        cells,
                    },
                ));
            }
        }
        changed.into_iter().chain(added).collect()
    }
}

/// The names of the only zone with marked cells and of the only zone without.
fn names(mesh: &Mesh, marked: &CellSet) -> [String; 2] {
    let is_marked = |group: &&Group| {
        group
            .cells
            .iter()
            .next()
            .is_some_and(|cell| marked.contains(cell))
    };
    [true, false].map(|side| {
        let mut zones = zones(mesh.groups_of_all(), mesh.dimension())
            .filter(|group| !group.cells.is_empty() && is_marked(group) == side);
        match (zones.next(), zones.next()) {
            (Some(one), None) => one.name.clone(),
            _ => SIDES[usize::from(!side)].to_owned(),
        }
    })
}

/// A name that no group has, which is taken from then on.
fn free_name(wanted: &str, taken: &mut BTreeSet<String>) -> String {
    let numbered = (2..).map(|i| format!("{wanted}_{i}"));
    let mut names = std::iter::once(wanted.to_owned()).chain(numbered);
    let name = names.find(|name| !taken.contains(name)).unwrap_or_default();
    taken.insert(name.clone());
    name
}

//! Boundary faces and tags for both sides of the interface of a zone that is cut from the rest of a mesh.

use super::groups::zones;
use super::numbering::Numbering;
use super::zone_sides::{ZoneSides, own_faces_of_nodes};
use super::{CellSet, Cells, Group, Mesh};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Names of both sides of an interface: for faces without a tag, and for sides of several zones.
const SIDES: [&str; 2] = ["inner", "outer"];

/// Cells next to the marked cells that move differently from the rest of the mesh.
#[derive(Clone, Copy)]
pub struct Neighbour<'a> {
    /// The cells.
    pub cells: &'a CellSet,
    /// Their interface faces, also those away from the marked cells.
    pub faces: &'a Cells,
}

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
    /// The side across each of them: 0 is the rest of the mesh, 1, 2, ... are the neighbours.
    across: Vec<usize>,
    /// For each of these sides the names of the marked cells and of the cells across.
    names: Vec<[String; 2]>,
}

impl<'a> Interface<'a> {
    /// Of the marked volume cells, which have these sides. Curved cells have no faces here: a face of corners would not be a side of
    /// them.
    pub fn of(
        mesh: &'a Mesh,
        marked: &CellSet,
        sides: &'a ZoneSides,
        neighbours: &[Neighbour<'_>],
    ) -> Self {
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
        let keys = |faces: &Cells| -> Vec<Vec<u32>> {
            let faces = faces.iter();
            faces.map(|face| key(face.nodes.to_vec())).collect()
        };
        let mut side_of: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
        for (neighbour, side) in neighbours.iter().zip(1..) {
            let keys = keys(neighbour.faces).into_iter();
            side_of.extend(keys.map(|key| (key, side)));
        }
        let (mut faces, mut at_faces, mut across) = (Vec::new(), Vec::new(), Vec::new());
        let all = keys(&sides.interface_faces).into_iter().enumerate();
        for (at, key) in all.filter(|_| !is_curved) {
            let face = there.get(&key).copied();
            if is_inner(&face) {
                faces.push(at);
                at_faces.push(face);
                across.push(side_of.get(&key).copied().unwrap_or(0));
            }
        }
        Self {
            names: names(mesh, marked, neighbours),
            mesh,
            sides,
            faces,
            there: at_faces,
            across,
        }
    }

    /// The faces to add, with `copy` of the nodes on the side of the marked cells, and the groups that change or are added: a tag on the
    /// interface becomes two, and faces without a tag get two; two for each neighbour.
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
            let mut outsides: Vec<Group> = Vec::new();
            for (side, names) in self.names.iter().enumerate() {
                let own = (0..outer.len()).filter(|&face| {
                    self.across[face] == side
                        && self.there[face].is_some()
                        && group.cells.contains(outer[face])
                });
                let own: Vec<usize> = own.collect();
                if own.is_empty() {
                    continue;
                }
                own.iter().for_each(|&face| is_tagged[face] = true);
                let [inside, outside] =
                    [(&names[0], inner), (&names[1], outer)].map(|(name, cells)| Group {
                        name: free_name(&format!("{}_{name}", group.name), &mut taken),
                        number: None,
                        cells: own.iter().map(|&face| cells[face]).collect(),
                        ..group.clone()
                    });
                added.push((None, inside));
                outsides.push(outside);
            }
            if outsides.is_empty() {
                continue;
            }
            let is_outside = |cell: usize| outsides.iter().any(|group| group.cells.contains(cell));
            let rest: CellSet = group
                .cells
                .iter()
                .filter(|cell| !is_outside(*cell))
                .collect();
            let (number, kept) = match rest.is_empty() {
                true => (group.number, outsides.remove(0)),
                false => (
                    group.number,
                    Group {
                        cells: rest,
                        ..group.clone()
                    },
                ),
            };
            changed.push((Some(at), Group { number, ..kept }));
            added.extend(outsides.into_iter().map(|group| (None, group)));
        }
        for side in 0..self.names.len() {
            for (name, cells) in SIDES.iter().zip([inner, outer]) {
                let untagged =
                    (0..outer.len()).filter(|&face| self.across[face] == side && !is_tagged[face]);
                let cells: CellSet = untagged.map(|face| cells[face]).collect();
                if !cells.is_empty() {
                    let name = free_name(&format!("{name}_interface"), &mut taken);
                    added.push((None, Group::new(dimension, name, None, cells)));
                }
            }
        }
        changed.into_iter().chain(added).collect()
    }
}

/// Returns the names of the only zone with marked cells and of the only zone across: in the rest of the mesh, then in each neighbour.
fn names(mesh: &Mesh, marked: &CellSet, neighbours: &[Neighbour<'_>]) -> Vec<[String; 2]> {
    let name = |side: usize, is_in: &dyn Fn(usize) -> bool| {
        let is_in = |group: &&Group| group.cells.iter().next().is_some_and(is_in);
        let mut zones = zones(mesh.groups_of_all(), mesh.dimension()).filter(is_in);
        match (zones.next(), zones.next()) {
            (Some(one), None) => one.name.clone(),
            _ => SIDES[side].to_owned(),
        }
    };
    let inner = name(0, &|cell| marked.contains(cell));
    let is_rest = |cell: usize| {
        !marked.contains(cell) && !neighbours.iter().any(|other| other.cells.contains(cell))
    };
    let rest = name(1, &is_rest);
    let across = neighbours
        .iter()
        .map(|other| name(1, &|cell| other.cells.contains(cell)));
    let across = std::iter::once(rest).chain(across);
    across.map(|across| [inner.clone(), across]).collect()
}

/// A name that no group has, which is taken from then on.
fn free_name(wanted: &str, taken: &mut BTreeSet<String>) -> String {
    let numbered = (2..).map(|i| format!("{wanted}_{i}"));
    let mut names = std::iter::once(wanted.to_owned()).chain(numbered);
    let name = names.find(|name| !taken.contains(name)).unwrap_or_default();
    taken.insert(name.clone());
    name
}

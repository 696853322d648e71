//! Cuts moving parts of the mesh from the rest: the nodes between them are duplicated, and the cells of the moving part use
//! the copies.

use crate::motion::{Motion, Role, TagRole};
use azimesh_core::error::{Result, counted};
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::facets::facets;
use azimesh_io::mesh::{Boundary, CellSet, Doubled, Mesh, Neighbour, ZoneSides};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A body or rotor that moves a part of the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mover {
    /// The body of rigid zones, by its index.
    Body(usize),
    /// The rotor with which zones turn, by its index.
    Rotor(usize),
}

/// An interface of a part that moves to another one or to the rest, in the reference mesh.
#[derive(Debug, Clone)]
pub struct Seam {
    /// Mover of the part.
    pub part: Mover,
    /// Mover of the cells across; `None` if they stay.
    pub across: Option<Mover>,
    /// The nodes of all interfaces of the part.
    pub points: Vec<Vector>,
    /// The facets of this interface, by the indices of the points.
    pub facets: Vec<[u32; 3]>,
}

impl Seam {
    /// Returns the interfaces of a part with these sides to the rest and to others, which have such interface faces.
    fn all(part: Mover, sides: &ZoneSides, others: &[(Mover, Neighbour<'_>)]) -> Vec<Self> {
        let key = |nodes: &[u32]| {
            let mut key = nodes.to_vec();
            key.sort_unstable();
            key
        };
        let mut movers: BTreeMap<Vec<u32>, Mover> = BTreeMap::new();
        for (mover, other) in others {
            movers.extend(other.faces.iter().map(|face| (key(face.nodes), *mover)));
        }
        let mut seams: BTreeMap<Option<Mover>, Self> = BTreeMap::new();
        for face in sides.interface_faces.iter() {
            let across = movers.get(&key(face.nodes)).copied();
            let seam = seams.entry(across).or_insert_with(|| Self {
                part,
                across,
                points: sides.interface_places.clone(),
                facets: Vec::new(),
            });
            for corners in facets(face.kind, face.nodes.len()) {
                let at = corners.map(|i| sides.interface_nodes.binary_search(&face.nodes[i]));
                if let [Ok(a), Ok(b), Ok(c)] = at {
                    seam.facets.push([a as u32, b as u32, c as u32]);
                }
            }
        }
        seams.into_values().collect()
    }
}

/// The copies and tags that the cuts add.
#[derive(Default)]
pub struct Cuts {
    /// The copies, in the order of duplication.
    pub doubled: Vec<Doubled>,
    /// The tags of interfaces, each with the number of its faces.
    pub tags: Vec<String>,
    /// True if parts were connected before.
    pub is_joined: bool,
    /// The interfaces, in the order of the cuts.
    pub seams: Vec<Seam>,
}

impl Cuts {
    /// Duplicates the nodes around every rigid part of the motion, and around the deforming zone if it turns, in the mesh of
    /// this rank. Adds faces and tags on both sides, and makes the motion use the copies.
    pub fn make(
        mesh: &mut Arc<Mesh>,
        boundary: &mut Boundary,
        motion: &mut Motion,
    ) -> Result<Self> {
        let mut cuts = Self::default();
        let names: Vec<String> = motion
            .surface
            .tags
            .iter()
            .map(|tag| tag.tag.clone())
            .collect();
        // Children come after their parents and are often inside them: if they are cut first, each interface has two parts.
        for part in (0..motion.parts.len()).rev() {
            let cells = motion.parts[part].cells.clone();
            let sides = ZoneSides::of(mesh, &cells);
            let mover = Mover::Body(motion.parts[part].body);
            cuts.cut(mesh, boundary, motion, (mover, &cells, &sides), [part, 0])?;
        }
        let mut of_parts: Vec<Option<usize>> = Vec::new();
        for part in 0..motion.zone.as_ref().map_or(0, |zone| zone.parts.len()) {
            of_parts.push(cuts.cut_turning(mesh, boundary, motion, part)?);
        }
        if cuts.doubled.is_empty() {
            return Ok(cuts);
        }
        // The nodes of each part now have their final numbers.
        for part in &mut motion.parts {
            part.sides = ZoneSides::of(mesh, &part.cells);
        }
        cuts.rename(mesh, motion, &of_parts);
        cuts.name_tags(boundary, motion, &names);
        Ok(cuts)
    }

    /// Cuts a part of the deforming zone from the rest if it turns; returns the index of its copies.
    fn cut_turning(
        &mut self,
        mesh: &mut Arc<Mesh>,
        boundary: &mut Boundary,
        motion: &mut Motion,
        part: usize,
    ) -> Result<Option<usize>> {
        let turning = motion.zone.as_ref().map(|zone| &zone.parts[part]);
        let Some((turning, rotor)) = turning.and_then(|part| Some((part, part.rotor?))) else {
            return Ok(None);
        };
        let cells = turning.cells.clone();
        let sides = match self.doubled.is_empty() {
            true => turning.sides.clone(),
            false => ZoneSides::of(mesh, &cells),
        };
        let zone = (Mover::Rotor(rotor), &cells, &sides);
        self.cut(mesh, boundary, motion, zone, [0, part + 1])?;
        Ok(Some(self.doubled.len() - 1))
    }

    /// Cuts these cells from the rest. Not cut yet are the rigid parts before the first index, and the parts of the deforming
    /// zone from the second index on.
    fn cut(
        &mut self,
        mesh: &mut Arc<Mesh>,
        boundary: &mut Boundary,
        motion: &mut Motion,
        (mover, cells, sides): (Mover, &CellSet, &ZoneSides),
        [n_rigid, first]: [usize; 2],
    ) -> Result<()> {
        let neighbour = |mover, cells, faces| (mover, Neighbour { cells, faces });
        let rigid = motion.parts[..n_rigid].iter();
        let rigid = rigid.map(|part| {
            let faces = &part.sides.interface_faces;
            neighbour(Mover::Body(part.body), &part.cells, faces)
        });
        let deforming = motion.zone.iter().flat_map(|zone| &zone.parts[first..]);
        let turning = deforming.filter_map(|part| {
            let faces = &part.sides.interface_faces;
            Some(neighbour(Mover::Rotor(part.rotor?), &part.cells, faces))
        });
        let others: Vec<_> = rigid.chain(turning).collect();
        self.seams.extend(Seam::all(mover, sides, &others));
        let neighbours: Vec<_> = others.into_iter().map(|(_, other)| other).collect();
        let doubled = Doubled::between(mesh, cells, sides, &neighbours)?;
        doubled.apply(Arc::make_mut(mesh));
        *boundary = Boundary::of(mesh);
        self.is_joined |= !sides.interface_faces.is_empty();
        self.doubled.push(doubled);
        // Tags of the interface have other names, and new ones come last.
        let tags = &mut motion.surface.tags;
        for (at, group) in boundary.boundary_tags().enumerate() {
            match tags.get_mut(at) {
                Some(tag) => tag.tag.clone_from(&group.name),
                None => tags.push(TagRole {
                    tag: group.name.clone(),
                    role: Some(Role::Fixed),
                    periodic: false,
                }),
            }
        }
        Ok(())
    }

    /// Makes the parts of the deforming zone use their copies.
    fn rename(&self, mesh: &Mesh, motion: &mut Motion, of_parts: &[Option<usize>]) {
        let Some(zone) = &mut motion.zone else {
            return;
        };
        let surface = &mut motion.surface.nodes;
        let before: Vec<_> = surface.nodes.iter().zip(&surface.roles).collect();
        let mut after = Vec::new();
        for (part, doubled) in zone.parts.iter_mut().zip(of_parts) {
            let copies = doubled.map(|at| self.doubled[at].copies());
            let copy = |node: u32| copies.as_ref().map_or(node, |copy| copy(node));
            let nodes = ZoneSides::of(mesh, &part.cells).nodes;
            let sides = &mut part.sides;
            sides.nodes = nodes;
            sides.interface_faces.renumber_nodes_by(copy);
            let interface = sides.interface_nodes.iter().map(|&node| copy(node));
            let places: BTreeMap<u32, _> = interface.zip(sides.interface_places.clone()).collect();
            (sides.interface_nodes, sides.interface_places) = places.into_iter().unzip();
            let own = before.iter().map(|&(&node, &role)| (copy(node), role));
            after.extend(own.filter(|(node, _)| sides.nodes.has(*node)));
        }
        after.sort_unstable_by_key(|entry| entry.0);
        after.dedup();
        (surface.nodes, surface.roles) = after.into_iter().unzip();
        zone.sides.nodes = match &zone.parts[..] {
            [one] => one.sides.nodes.clone(),
            _ => ZoneSides::of(mesh, &zone.cells).nodes,
        };
        zone.unite_interfaces();
    }

    /// Records the tags that the cuts renamed or added; `names` are the old names. Tags in a rigid part move with its body.
    fn name_tags(&mut self, boundary: &Boundary, motion: &mut Motion, names: &[String]) {
        let mut tags = std::mem::take(&mut motion.surface.tags);
        let groups = boundary.boundary_tags().zip(&mut tags);
        for (at, (group, tag)) in groups.enumerate() {
            let is_new = at >= names.len();
            if names.get(at) != Some(&group.name) {
                let n_faces = counted(group.cells.len(), "face");
                self.tags.push(format!("{} ({n_faces})", group.name));
            }
            if (is_new || tag.role.is_none()) && !tag.periodic {
                let mut bodies = boundary
                    .nodes_of(group)
                    .map(|node| motion.body_of_node(node));
                let first = bodies.next().flatten();
                if names.get(at) != Some(&group.name) {
                    tag.role = Some(Role::Fixed);
                }
                if let Some(body) = first.filter(|_| bodies.all(|body| body == first)) {
                    tag.role = Some(Role::Moving(body as u16));
                }
            }
        }
        motion.surface.tags = tags;
    }
}

//! Cuts moving parts of the mesh from the rest: the nodes between them are duplicated, and the cells of the moving part use
//! the copies.

use crate::motion::{Motion, Role, TagRole};
use azimesh_core::error::{Result, counted};
use azimesh_io::mesh::{Boundary, CellSet, Doubled, Mesh, Neighbour, ZoneSides};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The copies and tags that the cuts add.
#[derive(Default)]
pub struct Cuts {
    /// The copies, in the order of duplication.
    pub doubled: Vec<Doubled>,
    /// The tags of interfaces, each with the number of its faces.
    pub tags: Vec<String>,
    /// True if parts were connected before.
    pub is_joined: bool,
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
            cuts.cut(mesh, boundary, motion, (&cells, &sides), [part, 0])?;
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
        let Some(turning) = turning.filter(|part| part.rotor.is_some()) else {
            return Ok(None);
        };
        let cells = turning.cells.clone();
        let sides = match self.doubled.is_empty() {
            true => turning.sides.clone(),
            false => ZoneSides::of(mesh, &cells),
        };
        self.cut(mesh, boundary, motion, (&cells, &sides), [0, part + 1])?;
        Ok(Some(self.doubled.len() - 1))
    }

    /// Cuts these cells from the rest. Not cut yet are the rigid parts before the first index, and the parts of the deforming
    /// zone from the second index on.
    fn cut(
        &mut self,
        mesh: &mut Arc<Mesh>,
        boundary: &mut Boundary,
        motion: &mut Motion,
        (cells, sides): (&CellSet, &ZoneSides),
        [n_rigid, first]: [usize; 2],
    ) -> Result<()> {
        let rigid = motion.parts[..n_rigid].iter();
        let rigid = rigid.map(|part| (&part.cells, &part.sides));
        let deforming = motion.zone.iter().flat_map(|zone| &zone.parts[first..]);
        let turning = deforming.filter(|part| part.rotor.is_some());
        let others = rigid.chain(turning.map(|part| (&part.cells, &part.sides)));
        let neighbours = others.map(|(cells, sides)| Neighbour {
            cells,
            faces: &sides.interface_faces,
        });
        let neighbours: Vec<_> = neighbours.collect();
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

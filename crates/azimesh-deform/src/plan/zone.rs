//! Cuts moving parts of the mesh from the rest: the nodes between them are duplicated, and the cells of the moving part use
//! the copies.

use crate::motion::{Motion, Role, TagRole};
use azimesh_core::error::{Result, counted};
use azimesh_io::mesh::{Boundary, CellSet, Doubled, Mesh, ZoneSides};
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
            cuts.cut(mesh, boundary, motion, &cells, &sides)?;
        }
        let turns = motion.to_inertial(&motion.steps[0]).is_some();
        if let Some(zone) = motion.zone.as_ref().filter(|_| turns) {
            let cells = zone.cells.clone();
            let sides = match motion.parts.is_empty() {
                true => zone.sides.clone(),
                false => ZoneSides::of(mesh, &cells),
            };
            cuts.cut(mesh, boundary, motion, &cells, &sides)?;
            cuts.rename(motion);
        }
        if cuts.doubled.is_empty() {
            return Ok(cuts);
        }
        // The nodes of each part now have their final numbers.
        for part in &mut motion.parts {
            part.sides = ZoneSides::of(mesh, &part.cells);
        }
        if let Some(zone) = &mut motion.zone {
            zone.sides.nodes = ZoneSides::of(mesh, &zone.cells).nodes;
        }
        cuts.name_tags(boundary, motion, &names);
        Ok(cuts)
    }

    fn cut(
        &mut self,
        mesh: &mut Arc<Mesh>,
        boundary: &mut Boundary,
        motion: &mut Motion,
        cells: &CellSet,
        sides: &ZoneSides,
    ) -> Result<()> {
        let doubled = Doubled::between(mesh, cells, sides)?;
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

    /// Makes the deforming zone use the copies of the last cut.
    fn rename(&self, motion: &mut Motion) {
        let (Some(zone), Some(doubled)) = (&mut motion.zone, self.doubled.last()) else {
            return;
        };
        let copy = doubled.copies();
        let sides = &mut zone.sides;
        sides.interface_faces.renumber_nodes_by(&copy);
        let nodes = sides.interface_nodes.iter().map(|&node| copy(node));
        let places: BTreeMap<u32, _> = nodes.zip(sides.interface_places.clone()).collect();
        (sides.interface_nodes, sides.interface_places) = places.into_iter().unzip();
        let surface = &mut motion.surface.nodes;
        let mut roles: Vec<_> = surface
            .nodes
            .iter()
            .map(|&node| copy(node))
            .zip(surface.roles.clone())
            .collect();
        roles.sort_unstable_by_key(|entry| entry.0);
        (surface.nodes, surface.roles) = roles.into_iter().unzip();
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

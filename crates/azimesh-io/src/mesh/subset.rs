//! A part of a mesh: without some of its boundary tags or zones, its boundary alone, its volume alone.

use super::arrays::select_tuples;
use super::{CellSet, Group, Mesh, Origin, faces_on_no_cell};
use azimesh_core::error::{Error, Result, nearest_name, option};
use std::collections::BTreeSet;

impl Mesh {
    /// Removes boundary tags, or zones if no tag has the name. Their cells go unless another group of the kind has them; so do
    /// faces that are then on no cell. Returns the number of removed faces and of removed cells.
    ///
    /// # Errors
    /// When there is no such tag or zone, or no cell would be left.
    pub fn drop_tags(&mut self, names: &[&str]) -> Result<[usize; 2]> {
        self.check_tags(names)?;
        let gone: Vec<bool> = self.named(names);
        self.drop_groups(&gone)
    }

    /// Removes all boundary tags but these, as [`drop_tags`](Self::drop_tags) does; all zones but these where they are zones.
    ///
    /// # Errors
    /// When there is no such tag or zone.
    pub fn keep_tags(&mut self, names: &[&str]) -> Result<[usize; 2]> {
        self.check_tags(names)?;
        let kept = self.named(names);
        let kinds: BTreeSet<u8> = self
            .groups
            .iter()
            .zip(&kept)
            .filter(|(_, kept)| **kept)
            .map(|(group, _)| group.dimension)
            .collect();
        let gone = self.groups.iter().zip(&kept);
        let gone: Vec<bool> = gone
            .map(|(group, kept)| !kept && kinds.contains(&group.dimension))
            .collect();
        self.drop_groups(&gone)
    }

    /// For each group whether it is meant by one of these names: a boundary tag, or a zone where no tag has the name.
    fn named(&self, names: &[&str]) -> Vec<bool> {
        let dimension = self.dimension();
        let names: BTreeSet<&str> = names.iter().copied().collect();
        let tags: BTreeSet<&str> = self.boundary_tags().map(|tag| &*tag.name).collect();
        let is_meant = |group: &Group| {
            let is_tag = group.dimension + 1 == dimension;
            let is_zone = group.dimension == dimension && !tags.contains(&*group.name);
            (is_tag || is_zone) && names.contains(&*group.name)
        };
        self.groups.iter().map(is_meant).collect()
    }

    fn drop_groups(&mut self, is_gone: &[bool]) -> Result<[usize; 2]> {
        let mut gone = vec![false; self.cells.len()];
        for kept in [false, true] {
            let groups = self.groups.iter().zip(is_gone);
            for (group, _) in groups.filter(|(_, is_gone)| **is_gone != kept) {
                for cells in group.cells.ranges() {
                    gone[cells].fill(!kept);
                }
            }
        }
        let dimension = self.dimension();
        let n_solid = |mesh: &Self| mesh.cells_of(|of| of == dimension).len();
        let (n_cells, n_solid_before) = (self.cells.len(), n_solid(self));
        let keep: Vec<usize> = (0..gone.len()).filter(|cell| !gone[*cell]).collect();
        let n_solid_kept = keep
            .iter()
            .filter(|cell| self.cells.get(**cell).kind.dimension() == dimension)
            .count();
        if n_solid_before > 0 && n_solid_kept == 0 {
            return Err(Error::input("no cell of the mesh would be left"));
        }
        let mut place = 0..;
        self.groups
            .retain(|_| !is_gone[place.next().expect("it has no end")]);
        self.keep_cells(&keep);
        if n_solid_kept < n_solid_before {
            let faces = self.cells_of(|of| of + 1 == dimension);
            let faces: Vec<u32> = faces.into_iter().map(|face| face as u32).collect();
            let loose = faces_on_no_cell(self, &faces);
            let is_kept = |cell: &usize| loose.binary_search(&(*cell as u32)).is_err();
            let keep: Vec<usize> = (0..self.cells.len()).filter(is_kept).collect();
            self.keep_cells(&keep);
            self.groups.retain(|group| !group.cells.is_empty());
        }
        let n_solid_gone = n_solid_before - n_solid_kept;
        Ok([n_cells - self.cells.len() - n_solid_gone, n_solid_gone])
    }

    /// Makes one boundary tag, or zone, of several, at the place of the first; it has their type where all have the same.
    ///
    /// # Errors
    /// When there is no such tag or zone, some are tags and others zones, or another has the new name.
    pub fn merge_tags(&mut self, new: &str, names: &[&str]) -> Result<()> {
        self.check_tags(names)?;
        let is_merged = self.named(names);
        let merged = || {
            self.groups
                .iter()
                .zip(&is_merged)
                .filter(|(_, merged)| **merged)
        };
        let Some(dimension) = merged().next().map(|(group, _)| group.dimension) else {
            return Ok(());
        };
        if let Some((other, _)) = merged().find(|(group, _)| group.dimension != dimension) {
            return Err(Error::input(format!(
                "\"{}\" is a zone and others are boundary tags, or the other way round; merge tags and zones separately",
                other.name
            )));
        }
        let clashes = |(group, merged): (&Group, &bool)| {
            group.dimension == dimension && group.name == new && !merged
        };
        if self.groups.iter().zip(&is_merged).any(clashes) {
            return Err(Error::input(format!(
                "there is a tag \"{new}\" already; name it among those that are merged"
            )));
        }
        let mut cells: Vec<usize> = merged().flat_map(|(group, _)| group.cells.iter()).collect();
        cells.sort_unstable();
        cells.dedup();
        let mut conditions = merged().map(|(group, _)| group.condition.clone());
        let first = conditions.next().flatten();
        let condition = conditions
            .all(|other| other == first)
            .then_some(first)
            .flatten();
        let mut is_first = true;
        let mut is_merged = is_merged.into_iter();
        self.groups.retain_mut(|group| {
            if !is_merged.next().expect("each group has one") {
                return true;
            }
            group.cells = cells.iter().copied().collect::<CellSet>();
            group.name = new.to_owned();
            group.condition.clone_from(&condition);
            std::mem::replace(&mut is_first, false)
        });
        self.origin = Origin::default();
        Ok(())
    }

    /// Keeps the boundary faces and their tags only: a surface in the space of the mesh. Returns how many nodes went.
    ///
    /// # Errors
    /// When there are no boundary faces.
    pub fn keep_boundary(&mut self) -> Result<usize> {
        let dimension = self.dimension();
        let keep = self.cells_of(|of| of + 1 == dimension);
        if keep.is_empty() {
            return Err(Error::input(format!(
                "the mesh has no boundary faces to keep; {} connected makes them",
                option("tag-boundary")
            )));
        }
        let before = self.points.len();
        self.groups.retain(|group| group.dimension + 1 == dimension);
        self.keep_cells(&keep);
        self.space = Some(dimension);
        Ok(before - self.points.len())
    }

    /// Keeps the volume cells and their zones only.
    pub fn keep_volume(&mut self) {
        let dimension = self.dimension();
        let keep = self.cells_of(|of| of == dimension);
        self.groups.retain(|group| group.dimension == dimension);
        self.keep_cells(&keep);
    }

    /// The volume cells and their zones, with all nodes, and the numbers of these cells here.
    pub fn volume_alone(&self) -> (Self, Vec<usize>) {
        let dimension = self.dimension();
        let keep = self.cells_of(|of| of == dimension);
        let mut volume = self.clone();
        volume.groups.retain(|group| group.dimension == dimension);
        volume.select_cells(&keep);
        (volume, keep)
    }

    fn cells_of(&self, is_kept: impl Fn(u8) -> bool) -> Vec<usize> {
        let runs = self
            .cells
            .runs()
            .filter(|run| is_kept(run.kind.dimension()));
        runs.flat_map(|run| run.first_cell..run.first_cell + run.n_cells())
            .collect()
    }

    /// Keeps these cells only, which are ascending; nodes that only others had go. Groups and arrays follow.
    pub(crate) fn keep_cells(&mut self, keep: &[usize]) {
        if keep.len() == self.cells.len() {
            return;
        }
        let used_before = self.nodes_of_cells();
        self.select_cells(keep);
        let used = self.nodes_of_cells();
        let nodes = (0..self.points.len()).filter(|&node| used[node] || !used_before[node]);
        let nodes: Vec<usize> = nodes.collect();
        if nodes.len() < self.points.len() {
            self.keep_nodes(&nodes);
        }
    }

    /// Keeps these cells only, which are ascending, and all nodes.
    fn select_cells(&mut self, keep: &[usize]) {
        let mut new_index = vec![usize::MAX; self.cells.len()];
        for (new, &old) in keep.iter().enumerate() {
            new_index[old] = new;
        }
        for group in &mut self.groups {
            let cells = group.cells.iter().map(|cell| new_index[cell]);
            group.cells = cells.filter(|cell| *cell != usize::MAX).collect();
        }
        select_tuples(&mut self.cell_arrays, keep);
        self.cells = self.cells.select(keep.iter().copied());
        self.origin = Origin::default();
    }

    fn check_tags(&self, names: &[&str]) -> Result<()> {
        let known: Vec<&str> = (self.boundary_tags().chain(self.zones()))
            .map(|group| &*group.name)
            .collect();
        let set: BTreeSet<&str> = known.iter().copied().collect();
        let Some(wrong) = names.iter().find(|name| !set.contains(*name)) else {
            return Ok(());
        };
        let hint = nearest_name(wrong, known.iter().copied());
        let hint = hint.map_or(String::new(), |name| format!(" (did you mean \"{name}\"?)"));
        Err(Error::input(format!(
            "there is no tag \"{wrong}\"{hint}; there are: {}",
            known.join(", ")
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;

    /// Two tetrahedra, a zone each, with a tagged face of each and one between them.
    fn two_zones() -> Mesh {
        let point = |i| [f64::from(i % 2), f64::from(i / 2), f64::from(i % 3)];
        let mut mesh = Mesh::of_points((0..5).map(point).collect());
        mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        mesh.cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
        for face in [[0, 1, 2], [1, 2, 3], [2, 3, 4]] {
            mesh.cells.push(CellKind::Triangle, &face);
        }
        for (at, name) in ["a", "b", "low", "between", "high"].into_iter().enumerate() {
            mesh.groups.push(Group::new(
                if at < 2 { 3 } else { 2 },
                name,
                None,
                std::iter::once(at).collect(),
            ));
        }
        mesh
    }

    fn names(mesh: &Mesh) -> Vec<&str> {
        mesh.groups.iter().map(|group| &*group.name).collect()
    }

    #[test]
    fn a_zone_is_dropped_with_its_cells_and_the_faces_that_were_on_them_alone() {
        let mut mesh = two_zones();
        assert_eq!(mesh.drop_tags(&["b"]).expect("a zone"), [1, 1]);
        assert_eq!(names(&mesh), ["a", "low", "between"]);
        assert_eq!((mesh.points.len(), mesh.cells.len()), (4, 3));
        mesh.validate().expect("it is good");
        let mut mesh = two_zones();
        assert_eq!(mesh.keep_tags(&["b"]).expect("a zone"), [1, 1]);
        assert_eq!(names(&mesh), ["b", "between", "high"]);
        assert!(two_zones().drop_tags(&["a", "b"]).is_err());
        assert!(two_zones().drop_tags(&["c"]).is_err());
        let mut mesh = two_zones();
        assert_eq!(mesh.keep_tags(&["low"]).expect("a tag"), [2, 0]);
        assert_eq!(names(&mesh), ["a", "b", "low"]);
    }

    #[test]
    fn zones_merge_as_tags_do_but_not_with_them() {
        let mut mesh = two_zones();
        mesh.merge_tags("fluid", &["a", "b"]).expect("zones");
        assert_eq!(names(&mesh), ["fluid", "low", "between", "high"]);
        assert_eq!(mesh.groups[0].cells.len(), 2);
        mesh.merge_tags("wall", &["low", "high"]).expect("tags");
        assert_eq!(names(&mesh), ["fluid", "wall", "between"]);
        let mixed = two_zones().merge_tags("all", &["a", "low"]);
        assert!(
            mixed
                .expect_err("it is mixed")
                .message
                .contains("separately")
        );
        assert!(two_zones().merge_tags("b", &["a"]).is_err());
    }
}

//! A part of a mesh: without some of its boundary tags, its boundary alone, its volume alone.

use super::{CellSet, Mesh, Origin};
use crate::error::{Error, Result, nearest_name};

impl Mesh {
    /// Removes boundary tags, with those of their faces that no other group has. Returns how many faces went.
    ///
    /// # Errors
    /// When there is no such tag.
    pub fn drop_tags(&mut self, names: &[&str]) -> Result<usize> {
        self.check_tags(names)?;
        let dimension = self.dimension();
        let is_gone = |group: &super::Group| {
            group.dimension + 1 == dimension && names.contains(&group.name.as_str())
        };
        let mut gone = vec![false; self.cells.len()];
        for kept in [false, true] {
            for group in self.groups.iter().filter(|group| is_gone(group) != kept) {
                for cells in group.cells.ranges() {
                    gone[cells].fill(!kept);
                }
            }
        }
        self.groups.retain(|group| !is_gone(group));
        let keep: Vec<usize> = (0..gone.len()).filter(|cell| !gone[*cell]).collect();
        let n_gone = self.cells.len() - keep.len();
        self.keep_cells(&keep);
        Ok(n_gone)
    }

    /// Removes all boundary tags but these, as [`drop_tags`](Self::drop_tags) does.
    ///
    /// # Errors
    /// When there is no such tag.
    pub fn keep_tags(&mut self, names: &[&str]) -> Result<usize> {
        self.check_tags(names)?;
        let others = self.boundary_tags().map(|tag| tag.name.clone());
        let others: Vec<String> = others
            .filter(|name| !names.contains(&name.as_str()))
            .collect();
        let others: Vec<&str> = others.iter().map(String::as_str).collect();
        self.drop_tags(&others)
    }

    /// Makes one boundary tag of several, at the place of the first; it has their type where all have the same.
    ///
    /// # Errors
    /// When there is no such tag, or another has the new name.
    pub fn merge_tags(&mut self, new: &str, names: &[&str]) -> Result<()> {
        self.check_tags(names)?;
        let dimension = self.dimension();
        let is_tag = |group: &super::Group| group.dimension + 1 == dimension;
        let is_merged =
            |group: &super::Group| is_tag(group) && names.contains(&group.name.as_str());
        let clashes =
            |group: &&super::Group| is_tag(group) && group.name == new && !names.contains(&new);
        if self.groups.iter().any(|group| clashes(&group)) {
            return Err(Error::input(format!(
                "there is a tag \"{new}\" already; name it among those that are merged"
            )));
        }
        let merged = self.groups.iter().filter(|group| is_merged(group));
        let mut cells: Vec<usize> = merged
            .clone()
            .flat_map(|group| group.cells.iter())
            .collect();
        cells.sort_unstable();
        cells.dedup();
        let mut conditions = merged.map(|group| group.condition.clone());
        let first = conditions.next().flatten();
        let condition = conditions
            .all(|other| other == first)
            .then_some(first)
            .flatten();
        let mut is_first = true;
        self.groups.retain_mut(|group| {
            if !is_merged(group) {
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
            return Err(Error::input(
                "the mesh has no boundary faces to keep; --tag-boundary connected makes them",
            ));
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
        let mut new_index = vec![usize::MAX; self.cells.len()];
        for (new, &old) in keep.iter().enumerate() {
            new_index[old] = new;
        }
        for group in &mut self.groups {
            let cells = group.cells.iter().map(|cell| new_index[cell]);
            group.cells = cells.filter(|cell| *cell != usize::MAX).collect();
        }
        for array in &mut self.cell_arrays {
            array.values = array.values.select(array.n_components, keep);
        }
        let used_before = self.nodes_of_cells();
        self.cells = self.cells.select(keep.iter().copied());
        let used = self.nodes_of_cells();
        let nodes = (0..self.points.len()).filter(|&node| used[node] || !used_before[node]);
        let nodes: Vec<usize> = nodes.collect();
        if nodes.len() < self.points.len() {
            self.keep_nodes(&nodes);
        }
        self.origin = Origin::default();
    }

    fn check_tags(&self, names: &[&str]) -> Result<()> {
        let known: Vec<&str> = self.boundary_tags().map(|tag| tag.name.as_str()).collect();
        let Some(wrong) = names.iter().find(|name| !known.contains(name)) else {
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

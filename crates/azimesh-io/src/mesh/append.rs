//! Merges several meshes into one.

use super::{CellSet, DataArray, Group, Mesh, Origin, too_many};
use azimesh_core::error::{Error, Result, option};

/// Differences between merged meshes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Merged {
    /// Names of tags and zones of more than one mesh.
    pub shared: Vec<String>,
    /// Names of arrays that are missing in some mesh or differ in type; they are left out.
    pub arrays: Vec<String>,
}

impl Mesh {
    /// Appends the nodes and cells of another mesh of the same dimension. Groups of one name and dimension are merged; arrays
    /// of one mesh only are removed.
    ///
    /// # Errors
    /// If the dimensions differ, or nodes or cells become too many.
    pub fn append(&mut self, other: &Self) -> Result<Merged> {
        let [own, its] = [self.dimension(), other.dimension()];
        if own != its {
            return Err(Error::input(format!(
                "this mesh has cells of dimension {its}, and those before it of dimension {own}; {} H and {} change the dimension",
                option("extrude"),
                option("flatten")
            )));
        }
        let (n_nodes, n_cells) = (self.points.len(), self.cells.len());
        if n_nodes + other.points.len() > u32::MAX as usize - 1 {
            return Err(Error::input(too_many("nodes")));
        }
        self.cells.check_space(other.cells.len())?;
        let mut cells = other.cells.clone();
        cells.renumber_nodes_by(|node| node + n_nodes as u32);
        self.cells.append(&cells);
        self.points.extend_from_slice(&other.points);
        let mut merged = Merged::default();
        for group in &other.groups {
            self.add_group(group, n_cells, &mut merged.shared);
        }
        let lost = &mut merged.arrays;
        append_arrays(&mut self.point_arrays, &other.point_arrays, lost);
        append_arrays(&mut self.cell_arrays, &other.cell_arrays, lost);
        for array in &other.field_arrays {
            match self.field_arrays.iter().find(|own| own.name == array.name) {
                None => self.field_arrays.push(array.clone()),
                Some(own) if own == array => {}
                Some(_) => lost.push(array.name.clone()),
            }
        }
        self.space = self.space.max(other.space);
        self.origin = Origin::default();
        Ok(merged)
    }

    /// Adds a group, whose cells begin after `n_cells` others, to the group of the same name if there is one.
    fn add_group(&mut self, group: &Group, n_cells: usize, shared: &mut Vec<String>) {
        let mut cells = CellSet::new();
        let ranges = group.cells.ranges();
        ranges.for_each(|range| cells.push_range(range.start + n_cells..range.end + n_cells));
        let is_same = |own: &&mut Group| own.dimension == group.dimension && own.name == group.name;
        if let Some(own) = self.groups.iter_mut().find(is_same) {
            cells.ranges().for_each(|range| own.cells.push_range(range));
            if own.condition != group.condition {
                own.condition = None;
            }
            if !shared.contains(&group.name) {
                shared.push(group.name.clone());
            }
            return;
        }
        let has_number = |own: &Group| {
            own.dimension == group.dimension && own.number.is_some() && own.number == group.number
        };
        let is_taken = self.groups.iter().any(has_number);
        self.groups.push(Group {
            number: group.number.filter(|_| !is_taken),
            cells,
            ..group.clone()
        });
    }

    /// Renames all tags and zones.
    pub fn rename_groups(&mut self, name: impl Fn(&Group) -> String) {
        for group in &mut self.groups {
            group.name = name(group);
        }
        self.origin = Origin::default();
    }

    /// Makes a zone of the volume cells without a zone.
    pub fn add_zone_of_rest(&mut self, name: &str) {
        let mut has_zone = vec![false; self.cells.len()];
        for range in self.zones().flat_map(|zone| zone.cells.ranges()) {
            has_zone[range].fill(true);
        }
        let volume = self.volume_runs().flat_map(|run| run.range());
        let rest: CellSet = volume.filter(|cell| !has_zone[*cell]).collect();
        if !rest.is_empty() {
            self.groups
                .push(Group::new(self.dimension(), name, None, rest));
        }
    }
}

/// Appends the values of arrays of the same form; removes the others and lists their names.
fn append_arrays(own: &mut Vec<DataArray>, other: &[DataArray], lost: &mut Vec<String>) {
    let is_one_form = |a: &DataArray, b: &DataArray| {
        (&a.name, a.n_components, a.values.type_name())
            == (&b.name, b.n_components, b.values.type_name())
    };
    let mut lose = |name: &String| {
        if !lost.contains(name) {
            lost.push(name.clone());
        }
    };
    own.retain_mut(|array| {
        let same = other.iter().find(|other| is_one_form(array, other));
        match same {
            Some(same) => array.values.append(&same.values),
            None => {
                lose(&array.name);
                false
            }
        }
    });
    let is_lost = |array: &&DataArray| !own.iter().any(|own| is_one_form(own, array));
    let left = other.iter().filter(is_lost);
    left.for_each(|array| lose(&array.name));
}

#[cfg(test)]
mod tests {
    use super::super::{CellKind, Values};
    use super::*;

    fn triangle(x: f64, tag: &str, array: &str) -> Mesh {
        let mut mesh = Mesh {
            points: vec![[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]],
            ..Mesh::default()
        };
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        mesh.cells.push(CellKind::Line, &[0, 1]);
        mesh.add_tag(tag, [1]).expect("an edge");
        mesh.groups[0].number = Some(4);
        let values = Values::F64(vec![x; 3]);
        mesh.point_arrays = vec![
            DataArray::scalar("p", values.clone()),
            DataArray::scalar(array, values),
        ];
        mesh
    }

    #[test]
    fn tags_of_one_name_become_one_and_arrays_that_not_both_have_go() {
        let mut mesh = triangle(0.0, "wall", "own");
        let merged = mesh
            .append(&triangle(5.0, "wall", "other"))
            .expect("it is as flat");
        assert_eq!(merged.shared, ["wall"]);
        assert_eq!(merged.arrays, ["own", "other"]);
        mesh.append(&triangle(9.0, "inlet", "p"))
            .expect("it is as flat");
        mesh.validate().expect("it is a mesh");
        assert_eq!(mesh.groups[0].cells.iter().collect::<Vec<_>>(), [1, 3]);
        let inlet = &mesh.groups[1];
        assert_eq!((&*inlet.name, inlet.number), ("inlet", None));
        assert_eq!(mesh.cells.get(4).nodes, [6, 7, 8]);
        assert_eq!(mesh.point_arrays[0].values.len(), 9);
        mesh.add_zone_of_rest("all");
        assert_eq!(mesh.groups[2].cells.len(), 3);
        let mut solid = Mesh::default();
        solid.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        assert!(mesh.append(&solid).is_err());
    }
}

//! Boundary tags and zones: integer cell arrays with names in field data.
//!
//! `BoundaryTag` numbers cells one dimension below the mesh's, `Zone` cells of its own dimension, `Group` any
//! of lower dimension; 0 is none, and name i of `BoundaryTagNames`, `ZoneNames` or `GroupNames`
//! belongs to number i + 1. Arrays of other programs number the cells of every dimension at once;
//! ours do where cells were extracted, as a surface from its volume: a number makes a group of its
//! own in each dimension that has it.

use crate::formats::names::Rule;
use crate::mesh::{CellSet, DataArray, Group, Mesh, MeshView, Values};
use azimesh_core::Note;
use azimesh_core::error::{Error, Result, nearest_name};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Names of a pair of arrays that store groups: numbers at cells, and names.
pub struct Labels<'n> {
    /// Name of the integer cell array.
    pub array: &'n str,
    /// Name of the string array.
    pub names: &'n str,
}

/// Tags of boundary faces.
pub const BOUNDARY: Labels<'static> = Labels {
    array: "BoundaryTag",
    names: "BoundaryTagNames",
};
/// Zones.
pub const ZONE: Labels<'static> = Labels {
    array: "Zone",
    names: "ZoneNames",
};
/// Groups of cells of lower dimension than boundary faces. Read only with its names.
pub const LOWER: Labels<'static> = Labels {
    array: "Group",
    names: "GroupNames",
};

/// Arrays in which other programs keep groups, the first that there is being used.
const FOREIGN: [&str; 3] = ["gmsh:physical", OF_GMSH, "medit:ref"];

/// The array in Gmsh's legacy files, where cells in no group have -1.
const OF_GMSH: &str = "CellEntityIds";

/// Turns arrays that number groups into groups. `chosen` is the user's array of boundary tags.
pub fn extract(mesh: &mut Mesh, chosen: Option<&str>) -> Result<()> {
    let dimension = mesh.dimension();
    if let Some(name) = chosen {
        take_chosen(mesh, name)?;
    } else if is_integer(mesh, BOUNDARY.array) {
        take(mesh, &BOUNDARY, dimension.saturating_sub(1));
        if is_surface_of_solid(mesh) {
            mesh.space = Some(3);
        }
    } else if let Some(name) = FOREIGN.into_iter().find(|name| is_integer(mesh, name)) {
        let (array, names) = (name, "");
        take(mesh, &Labels { array, names }, dimension);
    }
    if is_integer(mesh, ZONE.array) && mesh.zones().next().is_none() {
        take(mesh, &ZONE, dimension);
    }
    if is_integer(mesh, LOWER.array) && names_at(mesh, LOWER.names).is_some() {
        take(mesh, &LOWER, dimension.saturating_sub(2));
    }
    Ok(())
}

/// Returns whether boundary tags are on surface cells in space, and on no edges: on the boundary of a volume that
/// is not there.
fn is_surface_of_solid(mesh: &Mesh) -> bool {
    let has = |dimension: u8| {
        let mut groups = mesh.groups.iter();
        groups.any(|group| group.dimension == dimension && !group.cells.is_empty())
    };
    mesh.dimension() == 2 && mesh.space_dimension() == 3 && has(2) && !has(1)
}

fn take_chosen(mesh: &mut Mesh, name: &str) -> Result<()> {
    if is_integer(mesh, name) {
        let mut own = [&BOUNDARY, &ZONE].into_iter();
        let own = own.find(|labels| labels.array == name);
        let names = own.map_or("", |labels| labels.names);
        let below = u8::from(name == BOUNDARY.array);
        let dimension = mesh.dimension().saturating_sub(below);
        take(mesh, &Labels { array: name, names }, dimension);
        return Ok(());
    }
    let known = mesh.cell_arrays.iter().map(|array| array.name.as_str());
    let known: Vec<_> = known.collect();
    if known.contains(&name) {
        let message = "boundary tags must be a scalar array of integers";
        return Err(Error::input(message).dataset(name));
    }
    let nearest = nearest_name(name, known.iter().copied());
    let hint = nearest.map_or(String::new(), |near| format!(" (did you mean {near}?)"));
    let known = if known.is_empty() {
        "none"
    } else {
        &known.join(", ")
    };
    Err(Error::input(format!(
        "there is no cell array \"{name}\"{hint}; cell arrays: {known}"
    )))
}

/// Makes a group of each number on cells of each dimension, and one of the `usual` dimension of each
/// name that no cell has; removes the arrays.
fn take(mesh: &mut Mesh, labels: &Labels, usual: u8) {
    let at = array_at(mesh, labels.array).expect("the caller has found it");
    let numbers = mesh.cell_arrays.remove(at).values;
    let names = names_at(mesh, labels.names).map(|at| mesh.field_arrays.remove(at).values);
    let names = match names {
        Some(Values::Text(names)) => names,
        _ => Vec::new(),
    };
    let mut sets: BTreeMap<(i64, u8), CellSet> = BTreeMap::new();
    for run in mesh.cells.runs() {
        let dimension = run.kind.dimension();
        let mut start = run.first_cell;
        numbers.for_each_stretch(run.range(), |number, n| {
            let is_none = number == 0 || (number == -1 && labels.array == OF_GMSH);
            if !is_none {
                let set = sets.entry((number, dimension)).or_default();
                set.push_range(start..start + n);
            }
            start += n;
        });
    }
    // A named tag without cells is kept.
    for number in 1..=names.len() as i64 {
        if sets.range((number, 0)..=(number, 3)).next().is_none() {
            sets.insert((number, usual), CellSet::new());
        }
    }
    let group = |((number, dimension), cells): ((i64, u8), CellSet)| {
        let index = number.checked_sub(1).and_then(|i| usize::try_from(i).ok());
        let name = index
            .and_then(|i| names.get(i))
            .filter(|name| !name.is_empty());
        let name = name.cloned().unwrap_or_else(|| number.to_string());
        Group::new(dimension, name, i32::try_from(number).ok(), cells)
    };
    mesh.groups.extend(sets.into_iter().map(group));
}

fn array_at(mesh: &Mesh, name: &str) -> Option<usize> {
    mesh.cell_arrays.iter().position(|array| array.name == name)
}

fn names_at(mesh: &Mesh, name: &str) -> Option<usize> {
    let is_names =
        |array: &DataArray| array.name == name && matches!(array.values, Values::Text(_));
    mesh.field_arrays.iter().position(is_names)
}

/// Returns whether there is a scalar cell array of this name that holds integers.
fn is_integer(mesh: &Mesh, name: &str) -> bool {
    array_at(mesh, name).is_some_and(|at| {
        let array = &mesh.cell_arrays[at];
        array.n_components == 1 && array.values.is_integer()
    })
}

/// The numbers of one pair of arrays for all cells, and the groups that one number a cell cannot give.
pub struct Numbers {
    /// One number a cell, 0 for none, in 8 bits where all fit, otherwise in 32.
    pub of_cells: Values,
    /// Further (cell, number) of cells in several groups, ascending.
    pub further: Vec<(usize, i32)>,
    /// Names, number by number.
    pub names: Vec<String>,
}

impl Numbers {
    /// Changes names to fit the rule; gives a note for each change.
    pub fn fit_names(&mut self, rule: &Rule) -> Vec<Note> {
        let before = std::mem::take(&mut self.names);
        let written = rule.by_name(before.iter().map(String::as_str));
        let new_name = |name: &String| written[name.as_str()].clone();
        self.names = before.iter().map(new_name).collect();
        let notes = written.iter();
        let notes = notes.filter_map(|(name, written)| rule.note("group", name, written));
        notes.collect()
    }

    /// The numbers that cells written again have, which are these `cells`: the further ones of boundary tags.
    pub fn repeated(&self, cells: &[usize], are_tags: bool) -> Values {
        if !are_tags {
            return self.of_cells.select(1, cells);
        }
        let numbers = self.further.iter().map(|(_, number)| *number);
        match self.of_cells {
            Values::U8(_) => Values::U8(numbers.map(|n| n as u8).collect()),
            _ => Values::I32(numbers.collect()),
        }
    }
}

/// Returns whether a boundary face is in several tags, so that it is written for each.
pub fn has_repeated(mesh: &MeshView) -> bool {
    let tags = mesh.boundary_tags();
    let mut ranges: Vec<Range<usize>> = tags.flat_map(|tag| tag.cells.ranges()).collect();
    ranges.sort_unstable_by_key(|range| range.start);
    ranges.windows(2).any(|two| two[1].start < two[0].end)
}

/// Numbers groups from 1. With `keep_numbers` they keep their own where those are all different
/// and above 0, and no names are given.
pub fn number(groups: &[&Group], n_cells: usize, keep_numbers: bool) -> Numbers {
    let own = groups.iter().filter_map(|group| group.number);
    let own: BTreeSet<i32> = own.filter(|n| *n > 0).collect();
    let keep = keep_numbers && own.len() == groups.len();
    let numbered = groups.iter().zip(1..);
    let numbered = numbered.map(|(group, i)| (group.number.filter(|_| keep).unwrap_or(i), *group));
    let numbered: Vec<(i32, &Group)> = numbered.collect();
    let mut further = Vec::new();
    let of_cells = if numbered.iter().all(|(n, _)| u8::try_from(*n).is_ok()) {
        Values::U8(fill(&numbered, n_cells, |n| n as u8, &mut further))
    } else {
        Values::I32(fill(&numbered, n_cells, |n| n, &mut further))
    };
    further.sort_unstable();
    Numbers {
        of_cells,
        further,
        names: groups.iter().map(|group| group.name.clone()).collect(),
    }
}

fn fill<T: Copy + Default + PartialEq>(
    groups: &[(i32, &Group)],
    n_cells: usize,
    narrowed: impl Fn(i32) -> T,
    further: &mut Vec<(usize, i32)>,
) -> Vec<T> {
    let mut of_cells = vec![T::default(); n_cells];
    for (number, group) in groups {
        for cell in group.cells.ranges().flatten() {
            match &mut of_cells[cell] {
                free if *free == T::default() => *free = narrowed(*number),
                _ => further.push((cell, *number)),
            }
        }
    }
    of_cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;

    /// A tetrahedron, or else nothing, and two of its faces, with these arrays.
    fn mesh(has_volume: bool, arrays: &[(&Labels, Vec<i32>)], names: &[&str]) -> Mesh {
        let mut mesh = Mesh::of_points(vec![[0.0; 3]; 4]);
        if has_volume {
            mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        }
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        mesh.cells.push(CellKind::Triangle, &[0, 1, 3]);
        for (labels, numbers) in arrays {
            let numbers = Values::I32(numbers.clone());
            mesh.cell_arrays
                .push(DataArray::scalar(labels.array, numbers));
            let names = names.iter().map(|name| (*name).to_owned()).collect();
            mesh.field_arrays
                .push(DataArray::scalar(labels.names, Values::Text(names)));
        }
        mesh
    }

    #[test]
    fn cells_of_gmsh_in_no_group_have_no_tag() {
        let labels = Labels {
            array: OF_GMSH,
            names: "",
        };
        let mut volume = mesh(true, &[(&labels, vec![-1, 7, -1])], &[]);
        extract(&mut volume, None).expect("a good array");
        assert_eq!(groups(&volume), [(2, "7", vec![1])]);
    }

    fn groups(mesh: &Mesh) -> Vec<(u8, &str, Vec<usize>)> {
        let group = |g: &Group| (g.dimension, g.cells.iter().collect());
        let named = |g| {
            let (dimension, cells) = group(g);
            (dimension, g.name.as_str(), cells)
        };
        mesh.groups.iter().map(named).collect()
    }

    #[test]
    fn tags_of_an_extracted_surface_become_its_zones() {
        let mut surface = mesh(false, &[(&BOUNDARY, vec![2, 1])], &["hub", "blade", "far"]);
        extract(&mut surface, None).expect("good arrays");
        let expected = [
            (2, "hub", vec![1]),
            (2, "blade", vec![0]),
            (1, "far", vec![]),
        ];
        assert_eq!(groups(&surface), expected);
        assert!(surface.cell_arrays.is_empty());
    }

    #[test]
    fn numbers_on_cells_of_another_dimension_are_kept() {
        let mut volume = mesh(true, &[(&BOUNDARY, vec![2, 1, 0])], &["wall", "inner"]);
        extract(&mut volume, None).expect("good arrays");
        let expected = [(2, "wall", vec![1]), (3, "inner", vec![0])];
        assert_eq!(groups(&volume), expected);

        let mut zones = mesh(true, &[(&ZONE, vec![1, 0, 1])], &["air"]);
        extract(&mut zones, None).expect("good arrays");
        assert_eq!(groups(&zones), [(2, "air", vec![2]), (3, "air", vec![0])]);
    }
}

//! Boundary tags and zones: integer cell arrays with names in field data.
//!
//! `BoundaryTag` numbers cells one dimension below the mesh's, `Zone` those of its own, `Group` any
//! of lower dimension; 0 is none, and name i of `BoundaryTagNames`, `ZoneNames` or `GroupNames`
//! belongs to number i + 1. Arrays of other programs number the cells of every dimension at once;
//! ours do where cells were extracted, as a surface from its volume: a number makes a group of its
//! own in each dimension that has it.

use crate::formats::names::Rule;
use crate::mesh::{CellSet, DataArray, Group, Mesh, MeshView, Values};
use azimesh_core::diagnostic::formats::GroupWritten;
use azimesh_core::error::{Error, Result, nearest_name};
use std::collections::BTreeMap;
use std::ops::Range;

/// Names of a pair of arrays that store groups: numbers at cells, and names.
pub struct Labels {
    /// Name of the integer cell array.
    pub array: &'static str,
    /// Name of the string array.
    pub names: &'static str,
}

/// Tags of boundary faces.
pub const BOUNDARY: Labels = Labels {
    array: "BoundaryTag",
    names: "BoundaryTagNames",
};
/// Zones.
pub const ZONE: Labels = Labels {
    array: "Zone",
    names: "ZoneNames",
};
/// Groups of cells of lower dimension than boundary faces. Read only with its names.
pub const LOWER: Labels = Labels {
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
        let labels = Labels {
            array: name,
            names: "",
        };
        take(mesh, &labels, dimension);
    }
    if is_integer(mesh, ZONE.array) {
        let has_zones = mesh.zones().next().is_some();
        if !has_zones {
            take(mesh, &ZONE, dimension);
        }
    }
    if is_integer(mesh, LOWER.array) && names_at(mesh, LOWER.names).is_some() {
        take(mesh, &LOWER, dimension.saturating_sub(2));
    }
    Ok(())
}

/// Whether boundary tags are on surface cells in space, and on no edges: on the boundary of a volume that
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
        let own = [&BOUNDARY, &ZONE]
            .into_iter()
            .find(|labels| labels.array == name);
        let names = own.map_or("", |labels| labels.names);
        let below = u8::from(name == BOUNDARY.array);
        let dimension = mesh.dimension().saturating_sub(below);
        take_from(mesh, name, names, dimension);
        return Ok(());
    }
    let known: Vec<_> = mesh
        .cell_arrays
        .iter()
        .map(|array| array.name.as_str())
        .collect();
    if known.contains(&name) {
        let message = "boundary tags must be a scalar array of integers";
        return Err(Error::input(message).dataset(name));
    }
    let nearest = nearest_name(name, known.iter().copied());
    let hint = nearest.map_or(String::new(), |near| format!(" (did you mean {near}?)"));
    let known = if known.is_empty() {
        "none".to_owned()
    } else {
        known.join(", ")
    };
    Err(Error::input(format!(
        "there is no cell array \"{name}\"{hint}; cell arrays: {known}"
    )))
}

fn take(mesh: &mut Mesh, labels: &Labels, usual: u8) {
    take_from(mesh, labels.array, labels.names, usual);
}

/// Makes a group of each number on cells of each dimension, and one of the `usual` dimension of each
/// name that no cell has; removes the arrays.
fn take_from(mesh: &mut Mesh, array: &str, names: &str, usual: u8) {
    let at = array_at(mesh, array).expect("the caller has found it");
    let numbers = mesh.cell_arrays.remove(at).values;
    let names = names_at(mesh, names).map(|at| mesh.field_arrays.remove(at).values);
    let names = match names {
        Some(Values::Text(names)) => names,
        _ => Vec::new(),
    };
    let mut sets: BTreeMap<(i64, u8), CellSet> = BTreeMap::new();
    for run in mesh.cells.runs() {
        let dimension = run.kind.dimension();
        let cells = run.first_cell..run.first_cell + run.n_cells();
        let mut start = cells.start;
        numbers.for_each_stretch(cells, |number, n| {
            let is_none = number == 0 || (number == -1 && array == OF_GMSH);
            if !is_none {
                let set = sets.entry((number, dimension)).or_default();
                set.push_range(start..start + n);
            }
            start += n;
        });
    }
    add_named_but_unused(&mut sets, &names, usual);
    mesh.groups
        .extend(sets.into_iter().map(|((number, dimension), cells)| {
            let index = number.checked_sub(1).and_then(|i| usize::try_from(i).ok());
            let name = index.and_then(|i| names.get(i));
            Group {
                dimension,
                name: name
                    .filter(|n| !n.is_empty())
                    .cloned()
                    .unwrap_or_else(|| number.to_string()),
                number: i32::try_from(number).ok(),
                condition: None,
                cells,
            }
        }));
}

/// A named tag without cells is kept, so that nothing is lost on the way through.
fn add_named_but_unused(sets: &mut BTreeMap<(i64, u8), CellSet>, names: &[String], dimension: u8) {
    for number in 1..=names.len() as i64 {
        if sets.range((number, 0)..=(number, 3)).next().is_none() {
            sets.insert((number, dimension), CellSet::new());
        }
    }
}

fn array_at(mesh: &Mesh, name: &str) -> Option<usize> {
    mesh.cell_arrays.iter().position(|array| array.name == name)
}

fn names_at(mesh: &Mesh, name: &str) -> Option<usize> {
    let is_names =
        |array: &DataArray| array.name == name && matches!(array.values, Values::Text(_));
    mesh.field_arrays.iter().position(is_names)
}

/// Whether there is a scalar cell array of this name that holds integers.
fn is_integer(mesh: &Mesh, name: &str) -> bool {
    array_at(mesh, name).is_some_and(|at| {
        let array = &mesh.cell_arrays[at];
        array.n_components == 1 && array.values.is_integer()
    })
}

/// The numbers of one pair of arrays for all cells, and what one number a cell cannot say.
pub struct Numbers {
    /// One number a cell; 0 for none.
    pub of_cells: CellNumbers,
    /// Further (cell, number) of cells in several groups, ascending.
    pub further: Vec<(usize, i32)>,
    /// Names, number by number.
    pub names: Vec<String>,
}

/// One number a cell, in the smallest type that holds them all.
pub enum CellNumbers {
    /// Up to 255.
    Narrow(Vec<u8>),
    /// Any.
    Wide(Vec<i32>),
}

impl CellNumbers {
    /// The number of a cell.
    pub fn get(&self, cell: usize) -> i32 {
        match self {
            CellNumbers::Narrow(numbers) => numbers[cell].into(),
            CellNumbers::Wide(numbers) => numbers[cell],
        }
    }
}

impl Numbers {
    /// Changes names to fit the rule; gives a note for each change.
    pub fn fit_names(&mut self, rule: &Rule) -> Vec<GroupWritten> {
        let written = rule.by_name(self.names.iter().map(String::as_str));
        let notes = written.iter();
        let notes = notes.filter_map(|(name, written)| rule.note("group", name, written));
        let notes = notes.collect();
        self.names = self
            .names
            .iter()
            .map(|name| written[name.as_str()].clone())
            .collect();
        notes
    }
}

/// Whether a boundary face is in several tags, so that it is written for each.
pub fn has_repeated(mesh: &MeshView) -> bool {
    let tags = mesh.boundary_tags();
    let mut ranges: Vec<Range<usize>> = tags.flat_map(|tag| tag.cells.ranges()).collect();
    ranges.sort_unstable_by_key(|range| range.start);
    ranges.windows(2).any(|two| two[1].start < two[0].end)
}

/// Numbers groups from 1. With `keep_numbers` they keep their own where those are all different
/// and above 0, and no names are given.
pub fn number(groups: &[&Group], n_cells: usize, keep_numbers: bool) -> Numbers {
    let mut own: Vec<i32> = groups
        .iter()
        .filter_map(|g| g.number)
        .filter(|n| *n > 0)
        .collect();
    own.sort_unstable();
    own.dedup();
    let keep = keep_numbers && own.len() == groups.len();
    let numbered: Vec<(i32, &Group)> = groups
        .iter()
        .zip(1..)
        .map(|(group, i)| (group.number.filter(|_| keep).unwrap_or(i), *group))
        .collect();
    let mut further = Vec::new();
    let narrow = numbered.iter().all(|(n, _)| u8::try_from(*n).is_ok());
    let of_cells = match narrow {
        true => CellNumbers::Narrow(fill(&numbered, n_cells, |n| n as u8, &mut further)),
        false => CellNumbers::Wide(fill(&numbered, n_cells, |n| n, &mut further)),
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
        let mut mesh = Mesh {
            points: vec![[0.0; 3]; 4],
            ..Mesh::default()
        };
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

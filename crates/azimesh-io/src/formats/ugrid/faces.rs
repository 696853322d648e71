//! Converts between numbers of boundary faces and tags of a mesh.

use super::mapbc::{self, Patch};
use crate::mesh::{CellRun, CellSet, DataArray, Group, Mesh, MeshView, Values};
use azimesh_core::geometry::bounds::Bounds;
use std::collections::{BTreeMap, BTreeSet};

/// Field array of FUN3D's numbers that would be written otherwise: face number, condition.
const CONDITIONS: &str = "ugrid:bc";

/// Name of the tag for boundary faces that are in none.
pub(super) const UNTAGGED: &str = "untagged";

/// Adds a group for each number of the first cells of the mesh and for each patch.
pub(super) fn add_groups(mesh: &mut Mesh, numbers: &[i32], patches: &[Patch]) {
    let mut sets: BTreeMap<i32, CellSet> = BTreeMap::new();
    let mut first = 0;
    for same in numbers.chunk_by(|a, b| a == b) {
        let end = first + same.len();
        sets.entry(same[0]).or_default().push_range(first..end);
        first = end;
    }
    let mut by_number: BTreeMap<i32, &Patch> = BTreeMap::new();
    for patch in patches {
        sets.entry(patch.number).or_default();
        by_number.insert(patch.number, patch);
    }
    let mut kept = Vec::new();
    for (number, cells) in sets {
        let patch = by_number.get(&number).copied();
        let name = patch.and_then(|patch| patch.name.clone());
        let name = name.unwrap_or_else(|| number.to_string());
        let group = Group {
            condition: patch.and_then(|patch| mapbc::condition(patch.condition)),
            ..Group::new(2, name, Some(number), cells)
        };
        if let Some(patch) = patch.filter(|_| group.condition.is_some())
            && condition_number(&mesh.view(), &group) != Some(patch.condition)
        {
            kept.extend([i64::from(number), patch.condition.into()]);
        }
        mesh.groups.push(group);
    }
    if !kept.is_empty() {
        let array = DataArray::tuples(CONDITIONS, 2, Values::I64(kept));
        mesh.field_arrays.push(array);
    }
}

/// Field arrays that are written in the `.mapbc`.
pub(super) const KEPT: &[&str] = &[CONDITIONS];

/// A boundary tag and the number of its faces.
pub(super) struct Tag<'a> {
    pub group: &'a Group,
    pub number: i32,
}

/// The boundary tags with their numbers: their own where these are positive and free, otherwise
/// the lowest that are.
pub(super) fn tags<'a>(mesh: &MeshView<'a>) -> Vec<Tag<'a>> {
    let mut taken = BTreeSet::new();
    let own = |group: &Group| group.number.filter(|number| *number > 0);
    let tags = mesh.boundary_tags();
    let own = tags.map(|group| own(group).filter(|number| taken.insert(*number)));
    let own: Vec<Option<i32>> = own.collect();
    let mut free = (1..).filter(|number| !taken.contains(number));
    let tags = mesh.boundary_tags().zip(own);
    tags.map(|(group, own)| Tag {
        group,
        number: own.or_else(|| free.next()).expect("a mesh has fewer tags"),
    })
    .collect()
}

/// FUN3D's number of the tag's condition; `None` where it has none.
pub(super) fn condition_number(mesh: &MeshView, group: &Group) -> Option<i32> {
    let condition = group.condition.as_deref()?;
    let kept = kept_number(mesh, group.number);
    let kept = kept.filter(|kept| mapbc::condition(*kept).as_deref() == Some(condition));
    kept.or_else(|| mapbc::number(condition, normal(mesh, group)))
}

/// Checks if FUN3D's number of a tag's condition depends on the positions of its nodes.
pub(super) fn has_number_by_positions(mesh: &MeshView, group: &Group) -> bool {
    let number = |axis: usize| mapbc::number(group.condition.as_deref()?, axis);
    number(0) != number(1) && kept_number(mesh, group.number).is_none()
}

/// The condition that the file had for this face number, where it has been kept.
fn kept_number(mesh: &MeshView, number: Option<i32>) -> Option<i32> {
    let number = i64::from(number?);
    let kept = mesh.field_array(CONDITIONS)?;
    let kept = Some(kept).filter(|array| array.n_components == 2)?;
    let kept = kept.values.to_integers()?;
    let mut pairs = kept.chunks_exact(2);
    let pair = pairs.find(|pair| pair[0] == number)?;
    i32::try_from(pair[1]).ok()
}

/// The axis along which the tag's faces extend least, at rest: of all steps it is the same.
fn normal(mesh: &MeshView, group: &Group) -> usize {
    let runs = group.cells.ranges().flat_map(|r| mesh.cells.runs_in(r));
    let nodes = runs.flat_map(|run| run.connectivity);
    let points = nodes.map(|node| &mesh.rest.points[*node as usize]);
    let Bounds { low, high } = Bounds::around(points);
    let extent = |axis: &usize| high[*axis] - low[*axis];
    let least = (0..3).min_by(|a, b| extent(a).total_cmp(&extent(b)));
    least.expect("there are three axes")
}

/// The number of every boundary face.
pub(super) struct FaceNumbers {
    /// First cell of each run of faces, and how many faces come before it.
    starts: Vec<(usize, usize)>,
    numbers: Vec<i32>,
    /// Faces that are in no tag, and their number.
    pub n_untagged: usize,
    /// The number of faces that are in no tag.
    pub untagged: i32,
    /// Faces that are in several tags, which have the number of the first.
    pub n_shared: usize,
}

impl FaceNumbers {
    /// Numbers of the faces of a solid mesh.
    pub fn of(mesh: &MeshView, tags: &[Tag]) -> Self {
        const NONE: i32 = i32::MIN;
        let mut starts = Vec::new();
        let mut n_faces = 0;
        for run in mesh.cells.runs().filter(|run| run.kind.dimension() == 2) {
            starts.push((run.first_cell, n_faces));
            n_faces += run.n_cells();
        }
        let highest = tags.iter().map(|tag| tag.number).max().unwrap_or(0);
        let mut faces = Self {
            starts,
            numbers: vec![NONE; n_faces],
            n_untagged: 0,
            untagged: highest.saturating_add(1),
            n_shared: 0,
        };
        for tag in tags {
            for run in tag.group.cells.ranges().flat_map(|r| mesh.cells.runs_in(r)) {
                let first = faces.first(&run);
                for number in &mut faces.numbers[first..first + run.n_cells()] {
                    match *number {
                        NONE => *number = tag.number,
                        _ => faces.n_shared += 1,
                    }
                }
            }
        }
        for number in faces.numbers.iter_mut().filter(|number| **number == NONE) {
            *number = faces.untagged;
            faces.n_untagged += 1;
        }
        faces
    }

    fn first(&self, run: &CellRun) -> usize {
        let is_before = |(cell, _): &(usize, usize)| *cell <= run.first_cell;
        let after = self.starts.partition_point(is_before);
        let (cell, face) = self.starts[after - 1];
        face + run.first_cell - cell
    }

    /// Numbers of the faces of a run.
    pub fn of_run(&self, run: &CellRun) -> &[i32] {
        let first = self.first(run);
        &self.numbers[first..first + run.n_cells()]
    }
}

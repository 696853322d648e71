//! A mesh of what a file says: cells of their faces, tags of the zones on the boundary, zones of cells.

use super::content::{Content, FaceZone, NONE};
use super::join::{Joined, join};
use super::kinds::{OVERLAP, PARENT};
use super::plane;
use crate::formats::Notes;
use crate::formats::by_faces::{self, Faces, Labels};
use crate::mesh::{CellKind, CellSet, Cells, Group, Mesh};
use azimesh_core::diagnostic::formats::{Fluent, NotKept};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::update;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Makes the mesh of a file of these bytes.
pub(super) fn mesh(mut content: Content, bytes: &[u8], notes: &mut Notes) -> Result<Mesh> {
    if content.n_cells == 0 {
        return Err(Error::input(match content.faces.is_empty() {
            true => "the file has no faces and no cells, so there is no mesh",
            false => {
                "the file has faces, but no cells: it is a surface mesh, and a mesh with cells is needed"
            }
        }));
    }
    note_left_out(&content, notes);
    let mut joined = join(&mut content, bytes)?;
    notes.count(joined.n_loose, |n| NotKept::Of {
        what: "faces on no cell",
        n,
        item: "face",
    });
    let n_faces = joined.faces.len();
    if joined.n_cells > 2 * n_faces || n_faces >= 1 << 31 {
        return Err(too_many_cells(joined.n_cells, n_faces));
    }
    let tags = tags(&content, &joined);
    let both = twice(&joined, &tags);
    let mut cells = match content.dimension {
        2 => plane::assemble(&joined)?,
        _ => solid(&mut joined)?,
    };
    for nodes in both {
        cells.push(kind_of(nodes.len(), content.dimension), &nodes);
    }
    let mut groups = groups(tags, &joined, n_faces, content.dimension);
    groups.extend(zones(&content, &joined));
    Ok(Mesh {
        points: content.points,
        cells,
        groups,
        ..Mesh::default()
    })
}

/// The groups of the tags: faces on the boundary follow the cells, and tagged faces between cells follow those.
fn groups(tags: Vec<Tag>, joined: &Joined, n_faces: usize, dimension: u8) -> Vec<Group> {
    let (n_cells, n_inside) = (joined.n_cells, joined.n_inside);
    let mut first_twice = n_cells + n_faces - n_inside;
    let group = |tag: Tag| {
        let mut set = CellSet::new();
        for range in &tag.outside {
            let shift = |face: usize| n_cells + face - n_inside;
            set.push_range(shift(range.start)..shift(range.end));
        }
        for range in &tag.inside {
            set.push_range(first_twice..first_twice + range.len());
            first_twice += range.len();
        }
        Group {
            dimension: dimension - 1,
            cells: set,
            ..tag.group
        }
    };
    tags.into_iter().map(group).collect()
}

/// Refuses more cells than faces can bound.
pub(super) fn too_many_cells(n_cells: usize, n_faces: usize) -> Error {
    Error::input(format!(
        "the file says that it has {n_cells} cells, too many for its {n_faces} faces"
    ))
}

/// Cells of a solid mesh, then the faces on its boundary.
fn solid(joined: &mut Joined) -> Result<Cells> {
    let mut list = std::mem::take(&mut joined.faces);
    let n_inside = joined.n_inside;
    // On the boundary a face points into its cell, and is turned to point out of it.
    for face in n_inside..list.len() {
        let range = list.range(face);
        list.nodes[range][1..].reverse();
    }
    let mut owner = vec![0; list.len()];
    update(&mut owner, |face, owner| {
        *owner = list.cells[face][usize::from(face < n_inside)]
    });
    let mut neighbour = vec![0; n_inside];
    update(&mut neighbour, |face, cell| *cell = list.cells[face][0]);
    let starts: Vec<u32> = match list.size {
        0 => std::iter::once(0)
            .chain(std::mem::take(&mut list.ends))
            .collect(),
        _ => Vec::new(),
    };
    list.cells = Vec::new();
    let size = (list.size > 0).then_some(list.size);
    let faces = Faces::of_size(size, Labels::from(starts), Labels::from(list.nodes));
    by_faces::assemble(&faces, &owner.into(), &neighbour.into(), joined.n_cells, 1)
}

/// A tag with its faces.
struct Tag {
    group: Group,
    /// Faces on the boundary.
    outside: Vec<Range<usize>>,
    /// Faces between two cells.
    inside: Vec<Range<usize>>,
}

/// The tags, in the order of the file: zones with faces on the boundary, and zones between cells that are not interior.
fn tags(content: &Content, joined: &Joined) -> Vec<Tag> {
    let mut tags: Vec<Tag> = Vec::new();
    let mut places = BTreeMap::new();
    for (zone, [outside, inside]) in content.faces.iter().zip(&joined.zones) {
        let is_tagged = !inside.is_empty() && !content.is_interior(zone);
        if outside.is_empty() && !is_tagged {
            continue;
        }
        let at = *places.entry(zone.zone).or_insert_with(|| {
            tags.push(new_tag(content, zone));
            tags.len() - 1
        });
        tags[at]
            .outside
            .extend((!outside.is_empty()).then(|| outside.clone()));
        tags[at].inside.extend(is_tagged.then(|| inside.clone()));
    }
    tags
}

fn new_tag(content: &Content, zone: &FaceZone) -> Tag {
    let kind = content.kind(zone);
    Tag {
        group: Group {
            dimension: 2,
            name: content.name(zone.zone, &kind),
            number: Some(zone.zone as i32),
            condition: Some(kind),
            cells: CellSet::new(),
        },
        outside: Vec::new(),
        inside: Vec::new(),
    }
}

/// The nodes of tagged faces between two cells, in the order of the tags.
fn twice(joined: &Joined, tags: &[Tag]) -> Vec<Vec<u32>> {
    let ranges = tags.iter().flat_map(|tag| &tag.inside);
    let faces = ranges.cloned().flatten();
    faces
        .map(|face| joined.faces.nodes(face).to_vec())
        .collect()
}

fn kind_of(n_nodes: usize, dimension: u8) -> CellKind {
    match (dimension, n_nodes) {
        (2, _) => CellKind::Line,
        (_, 3) => CellKind::Triangle,
        (_, 4) => CellKind::Quadrilateral,
        _ => CellKind::Polygon,
    }
}

/// The zones of cells, in the order of the file.
fn zones(content: &Content, joined: &Joined) -> Vec<Group> {
    let mut ranges: BTreeMap<u32, Vec<Range<usize>>> = BTreeMap::new();
    let mut order = Vec::new();
    for zone in content.cells.iter().filter(|zone| zone.is_active) {
        let own = ranges.entry(zone.zone).or_insert_with(|| {
            order.push(zone.zone);
            Vec::new()
        });
        own.push(zone.cells.clone());
    }
    let group = |number: u32| {
        let mut own = ranges.remove(&number).unwrap_or_default();
        own.sort_by_key(|range| range.start);
        let kind = content.names.get(&number);
        let kind = kind.map_or("fluid", |named| &named.kind);
        Group {
            dimension: content.dimension,
            name: content.name(number, "fluid"),
            number: Some(number as i32),
            condition: (kind != "fluid").then(|| kind.to_owned()),
            cells: cells_of(own, joined),
        }
    };
    order.into_iter().map(group).collect()
}

/// The cells of a zone, by their new numbers.
fn cells_of(ranges: Vec<Range<usize>>, joined: &Joined) -> CellSet {
    let mut set = CellSet::new();
    let Some(numbers) = &joined.numbers else {
        ranges.into_iter().for_each(|range| set.push_range(range));
        return set;
    };
    let kept = ranges.into_iter().flatten().map(|cell| numbers[cell]);
    kept.filter(|cell| *cell != NONE)
        .for_each(|cell| set.push(cell as usize));
    set
}

/// Whether somebody has named a zone between cells so: Fluent itself calls them "interior", also within longer names, and
/// writers of its files "internal-3", by their numbers.
fn is_given(name: &str) -> bool {
    let number = name.strip_prefix("internal-").unwrap_or(name);
    !name.contains("interior") && !number.bytes().all(|byte| byte.is_ascii_digit())
}

/// Tells what of the file the mesh does not hold.
fn note_left_out(content: &Content, notes: &mut Notes) {
    let mut names = BTreeSet::new();
    let mut n_overlaps = 0;
    for zone in &content.faces {
        if zone.kind >= OVERLAP {
            n_overlaps += zone.list.len();
        } else if zone.kind != PARENT && content.is_interior(zone) {
            names.insert(content.name(zone.zone, "interior"));
        }
    }
    let named: Vec<String> = names.into_iter().filter(|name| is_given(name)).collect();
    notes.list(named, |names| Fluent::Interior { names });
    if n_overlaps > 0 {
        notes.push(Fluent::Overlaps { n: n_overlaps });
    }
    let refined = content.refined_cells.iter().map(Range::len);
    let inactive = content.cells.iter().filter(|zone| !zone.is_active);
    let n = usize::max(refined.sum(), inactive.map(|zone| zone.cells.len()).sum());
    if n > 0 || !content.refined_faces.is_empty() {
        notes.push(Fluent::Refined { n });
    }
    let of_mesh = content.faces.iter().filter(|zone| zone.kind < OVERLAP);
    let of_mesh: BTreeSet<u32> = of_mesh.map(|zone| zone.zone).collect();
    let pairs = content.shadows.iter();
    let pairs = pairs.filter(|pair| pair.iter().all(|zone| of_mesh.contains(zone)));
    let pairs: Vec<[String; 2]> = pairs
        .map(|[zone, shadow]| {
            let kinds = [(zone, "periodic"), (shadow, "periodic-shadow")];
            kinds.map(|(zone, kind)| content.name(*zone, kind))
        })
        .collect();
    notes.list(pairs, |pairs| Fluent::Periodic { pairs });
}

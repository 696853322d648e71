//! A mesh of what a file says: cells of their faces, tags of the zones on the boundary, zones of cells.

use super::content::{Content, FaceZone};
use super::join::{Joined, join};
use super::kinds::{OVERLAP, PARENT};
use super::plane;
use crate::diagnostic::formats::{Fluent, NotKept};
use crate::error::{Error, Result};
use crate::formats::Notes;
use crate::formats::by_faces::{self, Faces, Labels};
use crate::mesh::{CellKind, CellSet, Cells, Group, Mesh};
use crate::parallel::update;
use std::collections::BTreeSet;
use std::ops::Range;

/// Makes the mesh.
pub(super) fn mesh(mut content: Content, notes: &mut Notes) -> Result<Mesh> {
    if content.n_cells == 0 {
        return Err(Error::input(match content.faces.is_empty() {
            true => "the file has no faces and no cells, so there is no mesh",
            false => {
                "the file has faces, but no cells: it is a surface mesh, and a mesh with cells is needed"
            }
        }));
    }
    note_left_out(&content, notes);
    let mut joined = join(&mut content)?;
    if joined.n_loose > 0 {
        notes.push(NotKept::Of {
            what: "faces on no cell",
            n: joined.n_loose,
            item: "face",
        });
    }
    let n_faces = joined.faces.len();
    if joined.n_cells > 2 * n_faces || n_faces >= 1 << 31 {
        return Err(too_many_cells(joined.n_cells, n_faces));
    }
    let n_inside = joined.n_inside;
    let tags = tags(&content, &joined);
    let mut both = Vec::new();
    let mut cells = match content.dimension {
        2 => {
            let cells = plane::assemble(&joined)?;
            twice(&joined, &tags, &mut both);
            cells
        }
        _ => {
            twice(&joined, &tags, &mut both);
            solid(&mut joined)?
        }
    };
    for nodes in both {
        cells.push(kind_of(nodes.len(), content.dimension), &nodes);
    }
    let mut groups = Vec::new();
    let mut first_twice = joined.n_cells + n_faces - n_inside;
    for tag in tags {
        let mut set = CellSet::new();
        for range in &tag.outside {
            let shift = |face: usize| joined.n_cells + face - n_inside;
            set.push_range(shift(range.start)..shift(range.end));
        }
        for range in &tag.inside {
            set.push_range(first_twice..first_twice + range.len());
            first_twice += range.len();
        }
        groups.push(Group {
            dimension: content.dimension - 1,
            cells: set,
            ..tag.group
        });
    }
    groups.extend(zones(&content, &joined));
    Ok(Mesh {
        points: content.points,
        cells,
        groups,
        ..Mesh::default()
    })
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
    for (zone, [outside, inside]) in content.faces.iter().zip(&joined.zones) {
        let is_tagged = !inside.is_empty() && !content.is_interior(zone);
        if outside.is_empty() && !is_tagged {
            continue;
        }
        let known = tags
            .iter()
            .position(|tag| tag.group.number == Some(zone.zone as i32));
        let at = known.unwrap_or_else(|| {
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
fn twice(joined: &Joined, tags: &[Tag], nodes: &mut Vec<Vec<u32>>) {
    let ranges = tags.iter().flat_map(|tag| &tag.inside);
    nodes.extend(
        ranges
            .cloned()
            .flatten()
            .map(|face| joined.faces.nodes(face).to_vec()),
    );
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
    let mut order: Vec<u32> = Vec::new();
    for zone in content.cells.iter().filter(|zone| zone.is_active) {
        if !order.contains(&zone.zone) {
            order.push(zone.zone);
        }
    }
    let group = |number: u32| {
        let own = content.cells.iter();
        let own = own.filter(|zone| zone.zone == number && zone.is_active);
        let mut ranges: Vec<Range<usize>> = own.map(|zone| zone.cells.clone()).collect();
        ranges.sort_by_key(|range| range.start);
        let cells = match &joined.numbers {
            None => {
                let mut set = CellSet::new();
                ranges.into_iter().for_each(|range| set.push_range(range));
                set
            }
            Some(numbers) => {
                let kept = ranges.into_iter().flatten().map(|cell| numbers[cell]);
                kept.filter(|cell| *cell != super::content::NONE)
                    .map(|cell| cell as usize)
                    .collect()
            }
        };
        let kind = content
            .names
            .get(&number)
            .map_or("fluid", |named| &named.kind);
        Group {
            dimension: content.dimension,
            name: content.name(number, "fluid"),
            number: Some(number as i32),
            condition: (kind != "fluid").then(|| kind.to_owned()),
            cells,
        }
    };
    order.into_iter().map(group).collect()
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
    // Fluent calls those so that nobody has named.
    let named = names.into_iter().filter(|name| !name.contains("interior"));
    let named: Vec<String> = named.collect();
    if !named.is_empty() {
        notes.push(Fluent::Interior { names: named });
    }
    if n_overlaps > 0 {
        notes.push(Fluent::Overlaps { n: n_overlaps });
    }
    let refined = content.refined_cells.iter().map(Range::len);
    let inactive = content.cells.iter().filter(|zone| !zone.is_active);
    let n = usize::max(refined.sum(), inactive.map(|zone| zone.cells.len()).sum());
    if n > 0 || !content.refined_faces.is_empty() {
        notes.push(Fluent::Refined { n });
    }
    let pairs: Vec<[String; 2]> = content
        .shadows
        .iter()
        .filter(|pair| {
            let is_there = |zone: &u32| {
                let mut own = content.faces.iter();
                own.any(|face| face.zone == *zone && face.kind < OVERLAP)
            };
            pair.iter().all(is_there)
        })
        .map(|[zone, shadow]| {
            [
                content.name(*zone, "periodic"),
                content.name(*shadow, "periodic-shadow"),
            ]
        })
        .collect();
    if !pairs.is_empty() {
        notes.push(Fluent::Periodic { pairs });
    }
}
